//! The file of the settings: several running programs may change it, and it may be damaged.

use crate::files::{Readable, reason, replace_text};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::lang::variables::Predefined;
use crate::user_data::folders::Folders;
use crate::user_data::settings::read::{ParsedSettings, read};
use crate::user_data::settings::{Defaults, Settings, WindowSettings, save};
use crate::user_data::store::{cannot_save, create_folder};
use crate::workspace::read_source;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Settings that were read, with the problems of their file.
#[derive(Debug, Clone)]
pub struct LoadedSettings {
    /// What could be read, with defaults for the rest. All are defaults if there is no file.
    pub settings: Settings,
    /// The text that the diagnostics refer to.
    pub source: Source,
    /// The problems of the file. If there are errors, the file is renamed and kept when settings are saved.
    pub diagnostics: Diagnostics,
    /// Whether the file has a scale of widgets. Otherwise the screen may suggest one.
    pub scale_is_given: bool,
}

/// The file of the settings.
#[derive(Debug, Clone)]
pub struct SettingsFile {
    path: PathBuf,
    /// The settings that were read or saved last. Whatever differs from them was changed here.
    last_seen: Settings,
}

impl SettingsFile {
    /// The file in these folders. Nothing is read or created yet.
    pub fn new(folders: &Folders) -> Self {
        Self { path: folders.configuration.join("settings.toml"), last_seen: Settings::default() }
    }

    /// The path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads the file. Without a file, and for values with errors, the settings are defaults.
    pub fn read(&mut self) -> LoadedSettings {
        let (source, ParsedSettings { settings, mut diagnostics, scale_is_given, .. }) = self.load();
        if diagnostics.has_errors() {
            let name = self.unused_name().display().to_string();
            let message = "settings that cannot be read have their default values";
            diagnostics
                .push(Diagnostic::warning(message).help(format!("when settings are saved, this file is kept as `{name}`")));
        }
        self.last_seen.clone_from(&settings);
        LoadedSettings { settings, source, diagnostics, scale_is_given }
    }

    /// Saves settings, whole or not at all. What another program changed in the file stays, unless it was changed here
    /// too; so do unknown keys. A damaged file is renamed and kept; its new path is returned.
    ///
    /// # Errors
    /// The file cannot be written. The old file is then unchanged.
    pub fn save(&mut self, settings: &Settings) -> Result<Option<PathBuf>, Diagnostic> {
        let failed = |error| cannot_save("the settings", &self.path, &error);
        let is_there = fs::symlink_metadata(&self.path).is_ok();
        let (source, found) = self.load();
        let damaged = found.diagnostics.has_errors();
        let merged =
            if is_there && !damaged { merge_settings(settings, &self.last_seen, &found.settings) } else { settings.clone() };
        let text = save::to_toml(&merged, &found.unknown)?;
        let mut renamed = None;
        if !is_there || damaged || text != source.text() {
            if let Some(folder) = self.path.parent() {
                create_folder(folder).map_err(failed)?;
            }
            if is_there && damaged {
                renamed = Some(self.rename_damaged()?);
            }
            if let Err(error) = replace_text(&self.path, &text) {
                if let Some(renamed) = renamed {
                    // A damaged file is better than none. If this fails too, the file is still there under its new
                    // name.
                    let _ = fs::rename(renamed, &self.path);
                }
                return Err(failed(error));
            }
        }
        self.last_seen.clone_from(settings);
        Ok(renamed)
    }

    /// Reads and parses the file.
    fn load(&self) -> (Source, ParsedSettings) {
        let name = self.path.display().to_string();
        let missing = fs::metadata(&self.path).is_err_and(|error| error.kind() == ErrorKind::NotFound);
        if missing {
            return (Source::new(name, ""), ParsedSettings::default());
        }
        match read_source(&self.path, None, Readable::Regular) {
            Ok(source) => {
                let mut found = read(&source);
                let folder = self.path.parent().unwrap_or(Path::new(""));
                found.settings.startup = found.settings.startup.from_folder(folder);
                (source, found)
            }
            Err(error) => (Source::new(name, ""), ParsedSettings { diagnostics: error.into(), ..ParsedSettings::default() }),
        }
    }

    /// A new name for the damaged file that no file has: an earlier damaged file may still be needed.
    fn unused_name(&self) -> PathBuf {
        let first = self.path.with_added_extension("damaged");
        let unknown = (2..).map(|number: u32| self.path.with_added_extension(format!("damaged-{number}")));
        let mut names = std::iter::once(first.clone()).chain(unknown);
        names.find(|name| fs::symlink_metadata(name).is_err()).unwrap_or(first)
    }

    fn rename_damaged(&self) -> Result<PathBuf, Diagnostic> {
        let renamed = self.unused_name();
        fs::rename(&self.path, &renamed).map_err(|error| {
            let (name, renamed) = (self.path.display(), renamed.display());
            let message = format!("cannot rename the damaged settings `{name}` to `{renamed}`: {}", reason(&error));
            Diagnostic::error(message).help("nothing was changed; repair the file, or remove it")
        })?;
        Ok(renamed)
    }
}

/// The merged value: ours if it was changed here, otherwise the file's.
fn merge_value<T: PartialEq + Clone>(ours: &T, last_seen: &T, theirs: &T) -> T {
    if ours == last_seen { theirs.clone() } else { ours.clone() }
}

fn merge_settings(ours: &Settings, last_seen: &Settings, theirs: &Settings) -> Settings {
    let mut defaults = Defaults::default();
    for &parameter in Predefined::ALL {
        let index = parameter as usize;
        defaults.values[index] =
            merge_value(&ours.defaults.values[index], &last_seen.defaults.values[index], &theirs.defaults.values[index]);
    }
    Settings {
        shadows: merge_value(&ours.shadows, &last_seen.shadows, &theirs.shadows),
        depth: merge_value(&ours.depth, &last_seen.depth, &theirs.depth),
        size: merge_value(&ours.size, &last_seen.size, &theirs.size),
        default_index: merge_value(&ours.default_index, &last_seen.default_index, &theirs.default_index),
        transfer: merge_value(&ours.transfer, &last_seen.transfer, &theirs.transfer),
        samples: merge_value(&ours.samples, &last_seen.samples, &theirs.samples),
        backend: merge_value(&ours.backend, &last_seen.backend, &theirs.backend),
        memory: merge_value(&ours.memory, &last_seen.memory, &theirs.memory),
        startup: merge_value(&ours.startup, &last_seen.startup, &theirs.startup),
        defaults,
        window: WindowSettings {
            theme: merge_value(&ours.window.theme, &last_seen.window.theme, &theirs.window.theme),
            scale: merge_value(&ours.window.scale, &last_seen.window.scale, &theirs.window.scale),
            apply_as_you_type: merge_value(
                &ours.window.apply_as_you_type,
                &last_seen.window.apply_as_you_type,
                &theirs.window.apply_as_you_type,
            ),
            gallery: merge_value(&ours.window.gallery, &last_seen.window.gallery, &theirs.window.gallery),
            log: merge_value(&ours.window.log, &last_seen.window.log, &theirs.window.log),
            instruments: merge_value(&ours.window.instruments, &last_seen.window.instruments, &theirs.window.instruments),
            instruments_at: merge_value(
                &ours.window.instruments_at,
                &last_seen.window.instruments_at,
                &theirs.window.instruments_at,
            ),
            size: merge_value(&ours.window.size, &last_seen.window.size, &theirs.window.size),
            panels: ours.window.panels.merged(&last_seen.window.panels, &theirs.window.panels),
        },
    }
}
