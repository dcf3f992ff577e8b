//! Settings: what a new session begins with, and how the workshop window looks (thesis 8.4).
//!
//! They serve the window and new sessions alone; what a session says wins, and commands that make pictures or measure do not
//! read them. How their file is kept is in `file`.

mod file;
mod nearest;
mod read;
mod save;

pub use file::{Reading, SettingsFile};

use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::lang::variables::Predefined;
use crate::trace::{MAX_DEPTH, MAX_SIDE};
use crate::workspace::Location;
use crate::workspace::assignment::Assignment;
use crate::workspace::presets::DEFAULT_SESSION;
use crate::workspace::roster::Roster;
use crate::workspace::session::PictureSettings;

/// How large widgets may be drawn, 1 being a pixel a point.
pub const SCALES: [f32; 2] = [0.5, 3.0];

/// How wide and how high a window may be asked for, in pixels.
pub const WINDOW_SIDES: [u32; 2] = [320, 16_384];

/// What every value of a predefined parameter lies within.
const PREDEFINED_RANGE: [f32; 2] = [0.0, 1.0];

/// What the user chose once for all sessions to come.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Whether shadow rays are sent.
    pub shadows: bool,
    /// The maximum depth of rays, 1..=[`MAX_DEPTH`].
    pub depth: u32,
    /// Width and height of pictures in pixels, each 1..=[`MAX_SIDE`].
    pub size: [u32; 2],
    /// The refractive index of bodies that give none, greater than 0.
    pub default_index: f64,
    /// The session that the window opens where none is named.
    pub startup: Location,
    /// The defaults of predefined parameters, the background among them.
    pub defaults: Defaults,
    /// How the window looks and behaves.
    pub window: WindowSettings,
}

/// How the window looks and behaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowSettings {
    /// Its colours.
    pub theme: Theme,
    /// How large widgets are drawn, within [`SCALES`].
    pub scale: f32,
    /// Whether a formula or scene is applied while it is typed, as soon as it is sound.
    pub apply_as_you_type: bool,
    /// Whether the log is shown.
    pub log: bool,
    /// Width and height of the window in pixels when it was last closed, each within [`WINDOW_SIDES`].
    pub size: [u32; 2],
}

/// Whether a window is light or dark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Theme {
    /// As the system has it; dark where it does not say.
    System,
    /// Light on dark.
    Dark,
    /// Dark on light.
    Light,
}

impl Theme {
    /// Every theme.
    pub const ALL: [Theme; 3] = [Theme::System, Theme::Dark, Theme::Light];

    /// As the file and menus call it.
    pub fn name(self) -> &'static str {
        match self {
            Theme::System => "system",
            Theme::Dark => "dark",
            Theme::Light => "light",
        }
    }

    /// Whether to draw dark, given whether the system is, if it says.
    pub fn is_dark(self, system: Option<bool>) -> bool {
        match self {
            Theme::System => system.unwrap_or(true),
            Theme::Dark => true,
            Theme::Light => false,
        }
    }
}

/// The defaults of predefined parameters, each within its range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defaults {
    /// In the order of the table of predefined parameters; a scalar is the first component.
    values: [[f32; 3]; Predefined::ALL.len()],
}

impl Defaults {
    /// One number, or three.
    pub fn of(&self, parameter: Predefined) -> &[f32] {
        &self.values[parameter as usize][..parameter.default().len()]
    }

    /// Sets a default to the nearest value within range; a scalar is the first component. What is no number leaves it.
    pub fn set(&mut self, parameter: Predefined, value: [f32; 3]) {
        let [low, high] = PREDEFINED_RANGE;
        let kept = &mut self.values[parameter as usize];
        for (kept, number) in kept.iter_mut().zip(value).take(parameter.default().len()) {
            if !number.is_nan() {
                *kept = number.clamp(low, high);
            }
        }
    }
}

impl Default for Defaults {
    fn default() -> Self {
        let mut defaults = Self { values: [[0.0; 3]; Predefined::ALL.len()] };
        for parameter in Predefined::ALL {
            let value = &mut defaults.values[*parameter as usize];
            parameter.default().iter().zip(value).for_each(|(from, to)| *to = *from);
        }
        defaults
    }
}

impl Default for WindowSettings {
    fn default() -> Self {
        Self { theme: Theme::System, scale: 1.0, apply_as_you_type: false, log: false, size: [1280, 800] }
    }
}

impl Default for Settings {
    fn default() -> Self {
        // A session that says nothing and settings that say nothing mean the same picture.
        let PictureSettings { size, depth, shadows, default_index, srgb: _ } = PictureSettings::default();
        Self {
            shadows,
            depth,
            size,
            default_index,
            startup: Location::Preset(DEFAULT_SESSION.to_owned()),
            defaults: Defaults::default(),
            window: WindowSettings::default(),
        }
    }
}

impl Settings {
    /// Reads settings as far as they are sound: what is wrong is told, and as by default or the nearest that is right. A file of
    /// another version says nothing. A path is as written: see [`Location::from_folder`].
    pub fn parse(source: &Source) -> (Settings, Diagnostics) {
        let found = read::read(source);
        (found.settings, found.diagnostics)
    }

    /// The settings as a file has them. What is out of range is written as the nearest that is within.
    ///
    /// # Errors
    /// The path of the startup session is no UTF-8 text.
    pub fn to_toml(&self) -> Result<String, Diagnostic> {
        save::to_toml(self, &read::Others::default())
    }

    /// How the picture of a new session is made.
    pub fn picture(&self) -> PictureSettings {
        let Settings { shadows, depth, size, default_index, .. } = self.within_ranges();
        PictureSettings { size, depth, shadows, default_index, srgb: false }
    }

    /// The values of a new session that are other than the language's own defaults, for every owner that has them. Left out are
    /// those that owners cannot have: what follows from others, and weights of rays that a body never sends.
    pub fn initial_values(&self, roster: &Roster) -> Vec<Assignment> {
        let mut assignments = Vec::new();
        for &predefined in Predefined::ALL {
            let Some(parameter) = roster.parameter_named(predefined.name()) else { continue };
            let kind = predefined.owner();
            if self.defaults.of(predefined) == predefined.default() || roster.system(kind).is_locked(parameter) {
                continue;
            }
            let value = self.defaults.values[predefined as usize];
            let owners = roster.owners().of_kind(kind).filter(|owner| roster.fixed(*owner, parameter).is_none());
            assignments.extend(owners.map(|owner| Assignment { owner, parameter, value }));
        }
        assignments
    }

    /// The same with everything within its range.
    #[must_use]
    pub fn within_ranges(&self) -> Settings {
        let usual = Settings::default();
        let sides = |size: [u32; 2], [low, high]: [u32; 2]| size.map(|side| side.clamp(low, high));
        let scale = if self.window.scale.is_nan() { usual.window.scale } else { self.window.scale };
        Settings {
            depth: self.depth.clamp(1, MAX_DEPTH),
            size: sides(self.size, [1, MAX_SIDE]),
            default_index: if is_index(self.default_index) { self.default_index } else { usual.default_index },
            window: WindowSettings {
                scale: scale.clamp(SCALES[0], SCALES[1]),
                size: sides(self.window.size, WINDOW_SIDES),
                ..self.window
            },
            ..self.clone()
        }
    }
}

/// Whether this may be a refractive index, in files too.
fn is_index(number: f64) -> bool {
    number > 0.0 && (number as f32).is_finite()
}

#[cfg(test)]
mod tests;
