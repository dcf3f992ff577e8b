//! Parsing the text of settings, as far as it has no errors.

use crate::backends::{self, BackendChoice};
use crate::lang::ast::Constant;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::source::Source;
use crate::lang::types::Type;
use crate::lang::variables::Predefined;
use crate::picture::Transfer;
use crate::trace::{MAX_DEPTH, MAX_PASSES, MAX_SIDE};
use crate::user_data::settings::nearest::{nearest_number, nearest_whole};
use crate::user_data::settings::{
    InstrumentDock, MEMORY, PANEL_SIZES, PREDEFINED_RANGE, PanelSide, SCALES, Settings, ThemeSetting, WINDOW_SIDES, is_index,
};
use crate::workspace::Location;
use crate::workspace::spanned_toml::{TomlEntry, Value, check_version, entries, parse as parse_toml, parse_integer, unknown_key};

const KEYS: [&str; 12] =
    ["version", "shadows", "depth", "size", "ior", "srgb", "samples", "backend", "memory", "startup", "defaults", "window"];
const WINDOW_KEYS: [&str; 8] = ["theme", "scale", "apply_as_you_type", "gallery", "log", "instruments", "instruments_at", "size"];

/// A parsed text.
#[derive(Default)]
pub(super) struct ParsedSettings {
    /// The settings without errors, with defaults for the rest.
    pub(super) settings: Settings,
    /// The unknown keys.
    pub(super) unknown: UnknownKeys,
    /// The problems.
    pub(super) diagnostics: Diagnostics,
    /// Whether there is a scale of widgets.
    pub(super) scale_is_given: bool,
}

/// Unknown keys, perhaps of another version of the program. They stay in the file.
#[derive(Default)]
pub(super) struct UnknownKeys {
    /// The unknown keys of the file itself.
    pub(super) file: toml::Table,
    /// The unknown keys among the defaults of parameters.
    pub(super) defaults: toml::Table,
    /// The unknown keys of the window.
    pub(super) window: toml::Table,
}

pub(super) fn read(source: &Source) -> ParsedSettings {
    let mut found = ParsedSettings::default();
    let table = match parse_toml(source) {
        Ok(table) => table,
        Err(diagnostics) => return ParsedSettings { diagnostics, ..found },
    };
    let entries = entries(&table);
    let version = entries.iter().find(|entry| entry.key == "version").map(|entry| entry.value);
    check_version(version, &mut found.diagnostics);
    if version.is_some() && found.diagnostics.has_errors() {
        // In another version the keys may have another meaning.
        return found;
    }
    for entry in entries {
        found.entry(&entry);
    }
    found.unknown = unknown(source);
    found.diagnostics.sort();
    found
}

/// The unknown keys of a text.
fn unknown(source: &Source) -> UnknownKeys {
    let mut file: toml::Table = source.text().trim_start_matches('\u{feff}').parse().unwrap_or_default();
    let mut rest_of = |key: &str, known: &dyn Fn(&str) -> bool| match file.remove(key) {
        Some(toml::Value::Table(mut table)) => {
            table.retain(|key, _| !known(key));
            table
        }
        _ => toml::Table::new(),
    };
    let defaults = rest_of("defaults", &|key| Predefined::named(key).is_some());
    let window = rest_of("window", &|key| WINDOW_KEYS.contains(&key) || PanelSide::named(key).is_some());
    file.retain(|key, _| !KEYS.contains(&key));
    UnknownKeys { file, defaults, window }
}

impl ParsedSettings {
    /// The value of an outcome; `None` after reporting an error.
    fn report_error<T>(&mut self, outcome: Result<T, Diagnostic>) -> Option<T> {
        outcome.map_err(|diagnostic| self.diagnostics.push(diagnostic)).ok()
    }

    /// The same, for an outcome that may have a warning.
    fn report_warning<T>(&mut self, outcome: Result<(T, Option<Diagnostic>), Diagnostic>) -> Option<T> {
        let (taken, warning) = self.report_error(outcome)?;
        warning.into_iter().for_each(|warning| self.diagnostics.push(warning));
        Some(taken)
    }

    fn entry(&mut self, entry: &TomlEntry) {
        match entry.key {
            "version" => {}
            "shadows" => {
                if let Some(shadows) = self.report_error(entry.value.truth()) {
                    self.settings.shadows = shadows;
                }
            }
            "depth" => {
                if let Some(depth) = self.report_warning(nearest_whole(entry.value, 1..=i64::from(MAX_DEPTH))) {
                    self.settings.depth = depth as u32;
                }
            }
            "size" => self.settings.size = self.sides(entry.value, [1, MAX_SIDE], self.settings.size),
            "ior" => {
                if let Some(index) = self.report_error(entry.value.number()) {
                    self.index(entry.value, index);
                }
            }
            "srgb" => {
                if let Some(srgb) = self.report_error(entry.value.truth()) {
                    self.settings.transfer = if srgb { Transfer::Srgb } else { Transfer::Linear };
                }
            }
            "samples" => {
                if let Some(samples) = self.report_warning(nearest_whole(entry.value, 1..=i64::from(MAX_PASSES))) {
                    self.settings.samples = samples as u32;
                }
            }
            "backend" => {
                if let Some(backend) = self.report_error(backend(entry.value)) {
                    self.settings.backend = backend;
                }
            }
            "memory" => self.memory(entry.value),
            "startup" => {
                if let Some(startup) = self.report_error(startup(entry.value)) {
                    self.settings.startup = startup;
                }
            }
            "defaults" => {
                for entry in self.table(entry.value) {
                    self.predefined(&entry);
                }
            }
            "window" => {
                for entry in self.table(entry.value) {
                    self.window(&entry);
                }
            }
            _ => self.unknown(entry, &KEYS),
        }
    }

    fn table<'t>(&mut self, value: Value<'t>) -> Vec<TomlEntry<'t>> {
        self.report_error(value.table()).map(entries).unwrap_or_default()
    }

    fn unknown(&mut self, entry: &TomlEntry, known: &[&str]) {
        self.diagnostics.push(unknown_key(entry, known).help("it stays in the file"));
    }

    fn sides(&mut self, value: Value, [low, high]: [u32; 2], before: [u32; 2]) -> [u32; 2] {
        let mut sides = before;
        let Some(values) = self.report_error(value.list::<2>("width and height, `[640, 480]`")) else { return sides };
        for (value, side) in values.into_iter().zip(&mut sides) {
            if let Some(taken) = self.report_warning(nearest_whole(value, i64::from(low)..=i64::from(high))) {
                *side = taken as u32;
            }
        }
        sides
    }

    fn memory(&mut self, value: Value) {
        let any = self.report_error(value.integer("an amount of memory in MiB; 0 for half of what is free"));
        let is_half = any.map(|number| parse_integer(number) == Some(0));
        let [low, high] = MEMORY.map(i64::from);
        match is_half {
            Some(true) => self.settings.memory = None,
            Some(false) => {
                let memory = self.report_warning(nearest_whole(value, low..=high));
                self.settings.memory = memory.map(|memory| memory as u32);
            }
            None => {}
        }
    }

    fn index(&mut self, value: Value, index: f64) {
        if is_index(index) {
            self.settings.default_index = index;
        } else {
            // No number above 0 is the nearest.
            let usual = self.settings.default_index;
            let message = format!("the refractive index {index} is not positive; {usual} is used");
            self.diagnostics.push(Diagnostic::warning(message).at(value.span, "expected more than 0"));
        }
    }

    fn predefined(&mut self, entry: &TomlEntry) {
        let Some(parameter) = Predefined::named(entry.key) else {
            let names: Vec<&str> = Predefined::ALL.iter().map(|parameter| parameter.name()).collect();
            return self.unknown(entry, &names);
        };
        let Some(constant) = self.report_error(entry.value.constant()) else { return };
        if constant.ty() != parameter.ty() {
            let expected = if parameter.ty() == Type::Vector { "three numbers `[x, y, z]`" } else { "a number" };
            let message = format!("`{}` is {}", entry.key, parameter.ty().with_article());
            return self.diagnostics.push(Diagnostic::error(message).at(entry.value.span, format!("expected {expected}")));
        }
        let values = match constant {
            Constant::Scalar(_) => vec![entry.value],
            Constant::Vector(_) => self.report_error(entry.value.list::<3>("three numbers")).map(Vec::from).unwrap_or_default(),
        };
        let mut taken = [0.0; 3];
        for (value, taken) in values.into_iter().zip(&mut taken) {
            if let Some(number) = self.report_warning(nearest_number(value, PREDEFINED_RANGE)) {
                *taken = number;
            }
        }
        self.settings.defaults.set(parameter, taken);
    }

    fn window(&mut self, entry: &TomlEntry) {
        match entry.key {
            "theme" => {
                if let Some(theme) = self.report_error(theme(entry.value)) {
                    self.settings.window.theme = theme;
                }
            }
            "scale" => {
                if let Some(scale) = self.report_warning(nearest_number(entry.value, SCALES)) {
                    self.settings.window.scale = scale;
                    self.scale_is_given = true;
                }
            }
            "apply_as_you_type" => {
                if let Some(apply) = self.report_error(entry.value.truth()) {
                    self.settings.window.apply_as_you_type = apply;
                }
            }
            "gallery" => {
                if let Some(gallery) = self.report_error(entry.value.truth()) {
                    self.settings.window.gallery = gallery;
                }
            }
            "log" => {
                if let Some(log) = self.report_error(entry.value.truth()) {
                    self.settings.window.log = log;
                }
            }
            "instruments" => {
                if let Some(instruments) = self.report_error(entry.value.truth()) {
                    self.settings.window.instruments = instruments;
                }
            }
            "instruments_at" => {
                if let Some(dock) = self.report_error(dock(entry.value)) {
                    self.settings.window.instruments_at = dock;
                }
            }
            "size" => self.settings.window.size = self.sides(entry.value, WINDOW_SIDES, self.settings.window.size),
            key => match PanelSide::named(key) {
                Some(side) => {
                    if let Some(size) = self.report_warning(nearest_number(entry.value, PANEL_SIZES)) {
                        self.settings.window.panels.set(side, size);
                    }
                }
                None => {
                    let sides = PanelSide::ALL.map(PanelSide::key);
                    self.unknown(entry, &[WINDOW_KEYS.as_slice(), sides.as_slice()].concat());
                }
            },
        }
    }
}

fn startup(value: Value) -> Result<Location, Diagnostic> {
    let text = value.text()?;
    if text.trim().is_empty() {
        return Err(Diagnostic::error("the path of the session is empty").at(value.span, "expected a path or `preset:NAME`"));
    }
    Ok(Location::new(text))
}

fn backend(value: Value) -> Result<BackendChoice, Diagnostic> {
    let text = value.text()?;
    backends::named(text).copied().ok_or_else(|| {
        if let Some(message) = backends::lacking(text) {
            return Diagnostic::error(message).at(value.span, "another backend is needed");
        }
        let names = backends::CHOICES.iter().map(|choice| choice.name);
        let hint = nearest(text, names.clone()).map(|near| format!("did you mean \"{near}\"?"));
        let expected = names.map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(" or ");
        Diagnostic::error(format!("there is no backend \"{text}\"")).at(value.span, format!("expected {expected}")).help_if(hint)
    })
}

fn dock(value: Value) -> Result<InstrumentDock, Diagnostic> {
    let text = value.text()?;
    let names = InstrumentDock::ALL.map(InstrumentDock::name);
    InstrumentDock::ALL.into_iter().find(|dock| dock.name() == text).ok_or_else(|| {
        let hint = nearest(text, names).map(|near| format!("did you mean \"{near}\"?"));
        let expected = names.map(|name| format!("\"{name}\"")).join(" or ");
        Diagnostic::error(format!("the instruments cannot be at \"{text}\""))
            .at(value.span, format!("expected {expected}"))
            .help_if(hint)
    })
}

fn theme(value: Value) -> Result<ThemeSetting, Diagnostic> {
    let text = value.text()?;
    let names = ThemeSetting::ALL.map(ThemeSetting::name);
    ThemeSetting::ALL.into_iter().find(|theme| theme.name() == text).ok_or_else(|| {
        let hint = nearest(text, names).map(|near| format!("did you mean \"{near}\"?"));
        Diagnostic::error(format!("there is no theme \"{text}\""))
            .at(value.span, "expected \"system\", \"dark\" or \"light\"")
            .help_if(hint)
    })
}
