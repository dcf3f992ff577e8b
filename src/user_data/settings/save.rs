//! Writing settings as text.

use crate::lang::diagnostic::Diagnostic;
use crate::lang::variables::Predefined;
use crate::picture::Transfer;
use crate::user_data::settings::read::UnknownKeys;
use crate::user_data::settings::{Defaults, PanelSizes, Settings};
use crate::workspace::Location;
use crate::workspace::spanned_toml::VERSION;
use serde::{Serialize, Serializer};

/// The file, key by key.
#[derive(Serialize)]
struct SettingsText<'s> {
    version: i64,
    shadows: bool,
    depth: u32,
    size: [u32; 2],
    ior: f64,
    srgb: bool,
    samples: u32,
    backend: &'static str,
    /// In MiB; 0 for half of what is free.
    memory: u32,
    startup: String,
    #[serde(flatten)]
    unknown: &'s toml::Table,
    defaults: DefaultsTable<'s>,
    window: WindowText<'s>,
}

#[derive(Serialize)]
struct WindowText<'s> {
    theme: &'static str,
    scale: f32,
    apply_as_you_type: bool,
    gallery: bool,
    log: bool,
    instruments: bool,
    instruments_at: &'static str,
    size: [u32; 2],
    #[serde(flatten)]
    panels: PanelSizes,
    #[serde(flatten)]
    unknown: &'s toml::Table,
}

/// The defaults of parameters, in the order of their table, and the unknown keys beside them.
struct DefaultsTable<'s> {
    defaults: &'s Defaults,
    unknown: &'s toml::Table,
}

impl Serialize for DefaultsTable<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let known = Predefined::ALL.iter().map(|parameter| {
            let number = match self.defaults.of(*parameter) {
                [number] => SettingNumber::Scalar(*number),
                numbers => SettingNumber::Vector(numbers),
            };
            (parameter.name(), number)
        });
        let unknown = self.unknown.iter().map(|(key, value)| (key.as_str(), SettingNumber::Other(value)));
        serializer.collect_map(known.chain(unknown))
    }
}

#[derive(Serialize)]
#[serde(untagged)]
enum SettingNumber<'s> {
    Scalar(f32),
    Vector(&'s [f32]),
    Other(&'s toml::Value),
}

pub(super) fn to_toml(settings: &Settings, unknown: &UnknownKeys) -> Result<String, Diagnostic> {
    let startup = startup(&settings.startup)?;
    let Settings { shadows, depth, size, default_index, transfer, samples, backend, memory, startup: _, defaults, window } =
        settings.within_ranges();
    let text = SettingsText {
        version: VERSION,
        shadows,
        depth,
        size,
        ior: default_index,
        srgb: transfer == Transfer::Srgb,
        samples,
        backend: backend.name,
        memory: memory.unwrap_or(0),
        startup,
        unknown: &unknown.file,
        defaults: DefaultsTable { defaults: &defaults, unknown: &unknown.defaults },
        window: WindowText {
            theme: window.theme.name(),
            scale: window.scale,
            apply_as_you_type: window.apply_as_you_type,
            gallery: window.gallery,
            log: window.log,
            instruments: window.instruments,
            instruments_at: window.instruments_at.name(),
            size: window.size,
            panels: window.panels,
            unknown: &unknown.window,
        },
    };
    toml::to_string(&text).map_err(|error| Diagnostic::error(format!("cannot write the settings as TOML: {error}")))
}

/// The location of the startup session, such that it is found from any folder.
fn startup(location: &Location) -> Result<String, Diagnostic> {
    let Location::File(path) = location else { return Ok(location.to_string()) };
    let path = std::path::absolute(path).unwrap_or_else(|_| path.clone());
    path.to_str().map(str::to_owned).ok_or_else(|| {
        Diagnostic::error(format!("cannot save the path of the startup session: `{}` is not UTF-8 text", path.display()))
            .help("choose another startup session, or give this one another name")
    })
}
