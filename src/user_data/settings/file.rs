//! The file of the settings: where it is, what several running programs make of it, and what becomes of a damaged one.

use crate::files::{Readable, reason, replace_text};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::lang::variables::Predefined;
use crate::user_data::folders::Folders;
use crate::user_data::settings::read::{Found, read};
use crate::user_data::settings::{Defaults, Settings, WindowSettings, save};
use crate::user_data::store::{cannot_keep, make_folder};
use crate::workspace::read_source;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Settings as they were read, with what is wrong with their file.
#[derive(Debug, Clone)]
pub struct Reading {
    /// What is sound of the file, with defaults for the rest; all defaults where there is none.
    pub settings: Settings,
    /// The text that the diagnostics mean.
    pub source: Source,
    /// What is wrong with it. Errors among them: the file is damaged, and will be kept aside when settings are saved.
    pub diagnostics: Diagnostics,
}

/// The file of the settings.
#[derive(Debug, Clone)]
pub struct SettingsFile {
    path: PathBuf,
    /// What whoever saves has last seen or saved: what is other than this, he has changed.
    seen: Settings,
}

impl SettingsFile {
    /// The file in these folders. Nothing is read or made yet.
    pub fn new(folders: &Folders) -> Self {
        Self { path: folders.configuration.join("settings.toml"), seen: Settings::default() }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads it. There is always an answer: no file means defaults, and so does what is wrong.
    pub fn read(&mut self) -> Reading {
        let (source, Found { settings, mut diagnostics, .. }) = self.look();
        if diagnostics.has_errors() {
            let name = self.free_name().display().to_string();
            let message = "settings that cannot be read have their default values";
            diagnostics
                .push(Diagnostic::warning(message).help(format!("when settings are saved, this file is kept as `{name}`")));
        }
        self.seen.clone_from(&settings);
        Reading { settings, source, diagnostics }
    }

    /// Saves settings, whole or not at all. What another program has changed in the file meanwhile stays, but for what was
    /// changed here too; so do keys that mean nothing. A damaged file is kept aside: the answer is where, if so.
    ///
    /// # Errors
    /// The file cannot be written; what was there before is still there.
    pub fn save(&mut self, settings: &Settings) -> Result<Option<PathBuf>, Diagnostic> {
        let failed = |error| cannot_keep("the settings", &self.path, &error);
        let is_there = fs::symlink_metadata(&self.path).is_ok();
        let (source, found) = self.look();
        let damaged = found.diagnostics.has_errors();
        let merged = if is_there && !damaged { merge(settings, &self.seen, &found.settings) } else { settings.clone() };
        let text = save::to_toml(&merged, &found.others)?;
        let mut aside = None;
        if !is_there || damaged || text != source.text() {
            if let Some(folder) = self.path.parent() {
                make_folder(folder).map_err(failed)?;
            }
            if is_there && damaged {
                aside = Some(self.set_aside()?);
            }
            if let Err(error) = replace_text(&self.path, &text) {
                if let Some(aside) = aside {
                    // Better a damaged file in its place than none. Where that fails too, it is still there under its new name.
                    let _ = fs::rename(aside, &self.path);
                }
                return Err(failed(error));
            }
        }
        self.seen.clone_from(settings);
        Ok(aside)
    }

    /// What the file says now.
    fn look(&self) -> (Source, Found) {
        let name = self.path.display().to_string();
        let missing = fs::metadata(&self.path).is_err_and(|error| error.kind() == ErrorKind::NotFound);
        if missing {
            return (Source::new(name, ""), Found::default());
        }
        match read_source(&self.path, None, Readable::Regular) {
            Ok(source) => {
                let mut found = read(&source);
                let folder = self.path.parent().unwrap_or(Path::new(""));
                found.settings.startup = found.settings.startup.from_folder(folder);
                (source, found)
            }
            Err(error) => (Source::new(name, ""), Found { diagnostics: error.into(), ..Found::default() }),
        }
    }

    /// A name for the damaged file that nothing has yet: what was kept aside before may be missed as well.
    fn free_name(&self) -> PathBuf {
        let first = self.path.with_added_extension("damaged");
        let others = (2..).map(|number: u32| self.path.with_added_extension(format!("damaged-{number}")));
        let mut names = std::iter::once(first.clone()).chain(others);
        names.find(|name| fs::symlink_metadata(name).is_err()).unwrap_or(first)
    }

    fn set_aside(&self) -> Result<PathBuf, Diagnostic> {
        let aside = self.free_name();
        fs::rename(&self.path, &aside).map_err(|error| {
            let (name, aside) = (self.path.display(), aside.display());
            let message = format!("cannot keep the damaged settings `{name}` as `{aside}`: {}", reason(&error));
            Diagnostic::error(message).help("nothing was changed; mend the file, or take it away")
        })?;
        Ok(aside)
    }
}

/// The one of three that is to be: what was changed here, else what the file has.
fn newer<T: PartialEq + Clone>(ours: &T, seen: &T, theirs: &T) -> T {
    if ours == seen { theirs.clone() } else { ours.clone() }
}

fn merge(ours: &Settings, seen: &Settings, theirs: &Settings) -> Settings {
    let mut defaults = Defaults::default();
    for &parameter in Predefined::ALL {
        let place = parameter as usize;
        defaults.values[place] =
            newer(&ours.defaults.values[place], &seen.defaults.values[place], &theirs.defaults.values[place]);
    }
    Settings {
        shadows: newer(&ours.shadows, &seen.shadows, &theirs.shadows),
        depth: newer(&ours.depth, &seen.depth, &theirs.depth),
        size: newer(&ours.size, &seen.size, &theirs.size),
        default_index: newer(&ours.default_index, &seen.default_index, &theirs.default_index),
        startup: newer(&ours.startup, &seen.startup, &theirs.startup),
        defaults,
        window: WindowSettings {
            theme: newer(&ours.window.theme, &seen.window.theme, &theirs.window.theme),
            scale: newer(&ours.window.scale, &seen.window.scale, &theirs.window.scale),
            apply_as_you_type: newer(
                &ours.window.apply_as_you_type,
                &seen.window.apply_as_you_type,
                &theirs.window.apply_as_you_type,
            ),
            log: newer(&ours.window.log, &seen.window.log, &theirs.window.log),
            size: newer(&ours.window.size, &seen.window.size, &theirs.window.size),
        },
    }
}
