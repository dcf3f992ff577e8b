//! Settings: how the program works and looks, and what new sessions start with (thesis 8.4).
//!
//! Only the window uses them. A session overrides them, and the commands that make pictures or measure ignore them.
//! `file` has the file that holds them.

mod file;
mod nearest;
mod panel_sizes;
mod read;
mod save;

pub use file::{LoadedSettings, SettingsFile};
pub use panel_sizes::{PANEL_SIZES, PanelSide, PanelSizes};

use crate::backends::{BackendChoice, DEFAULT};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::lang::variables::Predefined;
use crate::picture::Transfer;
use crate::trace::{MAX_DEPTH, MAX_PASSES, MAX_SIDE};
use crate::workspace::Location;
use crate::workspace::assignment::Assignment;
use crate::workspace::parameter_table::ParameterTable;
use crate::workspace::presets::DEFAULT_SESSION;
use crate::workspace::session::PictureSettings;

/// The scales of widgets, in pixels per point.
pub const SCALES: [f32; 2] = [0.5, 3.0];

/// The memory that a picture may be allowed, in MiB.
pub const MEMORY: [u32; 2] = [64, 1 << 24];

/// The allowed widths and heights of the window, in pixels.
pub const WINDOW_SIDES: [u32; 2] = [320, 16_384];

/// The range of every predefined parameter.
const PREDEFINED_RANGE: [f32; 2] = [0.0, 1.0];

/// What the user chose for all future sessions.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Whether shadow rays are sent.
    pub shadows: bool,
    /// The maximum depth of rays, 1..=[`MAX_DEPTH`].
    pub depth: u32,
    /// Width and height of pictures in pixels, each 1..=[`MAX_SIDE`].
    pub size: [u32; 2],
    /// The refractive index of bodies that have none of their own, greater than 0.
    pub default_index: f64,
    /// How the linear colours of new sessions are stored.
    pub transfer: Transfer,
    /// How many passes the window makes of a picture whose session does not say, 1..=[`MAX_PASSES`].
    pub samples: u32,
    /// What evaluates formulas.
    pub backend: BackendChoice,
    /// The memory that a picture may take, in MiB; `None` for half of what is free.
    pub memory: Option<u32>,
    /// The session that the window opens if none is named.
    pub startup: Location,
    /// The defaults of predefined parameters, the background among them.
    pub defaults: Defaults,
    /// How the window looks and behaves.
    pub window: WindowSettings,
}

/// How the window looks and behaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowSettings {
    /// The colours.
    pub theme: ThemeSetting,
    /// The scale of widgets, within [`SCALES`].
    pub scale: f32,
    /// Whether a formula or scene is applied while the user types, whenever it has no errors.
    pub apply_as_you_type: bool,
    /// Whether the gallery is shown when the program starts without a session.
    pub gallery: bool,
    /// Whether the log is shown.
    pub log: bool,
    /// Whether the instruments are shown.
    pub instruments: bool,
    /// Where they are.
    pub instruments_at: InstrumentDock,
    /// Width and height of the window in pixels when it was last closed, each within [`WINDOW_SIDES`].
    pub size: [u32; 2],
    /// The sizes of its panels.
    pub panels: PanelSizes,
}

/// Where the instruments are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstrumentDock {
    /// Below the picture.
    Below,
    /// At the right of the picture.
    Right,
    /// Over the picture, in a window that can be moved.
    Over,
}

impl InstrumentDock {
    /// Every place.
    pub const ALL: [InstrumentDock; 3] = [InstrumentDock::Below, InstrumentDock::Right, InstrumentDock::Over];

    /// The name in the file.
    pub fn name(self) -> &'static str {
        match self {
            InstrumentDock::Below => "below",
            InstrumentDock::Right => "right",
            InstrumentDock::Over => "over",
        }
    }
}

/// Whether a window is light or dark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ThemeSetting {
    /// As in the system; dark if the system does not say.
    System,
    /// Light on dark.
    Dark,
    /// Dark on light.
    Light,
}

impl ThemeSetting {
    /// Every theme.
    pub const ALL: [ThemeSetting; 3] = [ThemeSetting::System, ThemeSetting::Dark, ThemeSetting::Light];

    /// The name in the file and in menus.
    pub fn name(self) -> &'static str {
        match self {
            ThemeSetting::System => "system",
            ThemeSetting::Dark => "dark",
            ThemeSetting::Light => "light",
        }
    }

    /// Whether to draw dark. `system` is whether the system is dark, if it says so.
    pub fn is_dark(self, system: Option<bool>) -> bool {
        match self {
            ThemeSetting::System => system.unwrap_or(true),
            ThemeSetting::Dark => true,
            ThemeSetting::Light => false,
        }
    }
}

/// The defaults of predefined parameters, each within its range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defaults {
    /// In the order of the table of predefined parameters. A scalar uses the first component.
    values: [[f32; 3]; Predefined::ALL.len()],
}

impl Defaults {
    /// The default of a parameter: one number or three.
    pub fn of(&self, parameter: Predefined) -> &[f32] {
        &self.values[parameter as usize][..parameter.default().len()]
    }

    /// Sets a default to the nearest value within range. A scalar uses the first component. A component that is NaN
    /// stays unchanged.
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
        Self {
            theme: ThemeSetting::System,
            scale: 1.0,
            apply_as_you_type: false,
            gallery: true,
            log: false,
            instruments: false,
            instruments_at: InstrumentDock::Below,
            size: [1280, 800],
            panels: PanelSizes::default(),
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        // But for the transfer and the passes, a session without settings and the default settings give the same
        // picture. Sessions without a transfer are those of the thesis, and the window has time for several passes.
        let PictureSettings { size, depth, shadows, default_index, samples: _, view: _ } = PictureSettings::default();
        Self {
            shadows,
            depth,
            size,
            default_index,
            transfer: Transfer::Srgb,
            samples: 16,
            backend: DEFAULT,
            memory: None,
            startup: Location::Preset(DEFAULT_SESSION.to_owned()),
            defaults: Defaults::default(),
            window: WindowSettings::default(),
        }
    }
}

impl Settings {
    /// Parses settings as far as they have no errors. A value with an error becomes its default; one out of range
    /// becomes the nearest within it. Of a file of another version everything is default. Paths stay as written: see
    /// [`Location::from_folder`].
    pub fn parse(source: &Source) -> (Settings, Diagnostics) {
        let found = read::read(source);
        (found.settings, found.diagnostics)
    }

    /// The settings as the text of a file. Values out of range become the nearest within it.
    ///
    /// # Errors
    /// The path of the startup session is not UTF-8.
    pub fn to_toml(&self) -> Result<String, Diagnostic> {
        save::to_toml(self, &read::UnknownKeys::default())
    }

    /// How a new session makes its picture.
    pub fn picture(&self) -> PictureSettings {
        let Settings { shadows, depth, size, default_index, transfer, .. } = self.within_ranges();
        PictureSettings { size, depth, shadows, default_index, samples: None, view: transfer.into() }
    }

    /// The values of a new session that differ from the defaults of the language, for every owner. Left out are values
    /// that follow from others, and the weights of rays that a body never sends.
    pub fn initial_values(&self, table: &ParameterTable) -> Vec<Assignment> {
        let mut assignments = Vec::new();
        for &predefined in Predefined::ALL {
            let Some(parameter) = table.parameter_named(predefined.name()) else { continue };
            let kind = predefined.owner();
            if self.defaults.of(predefined) == predefined.default() || table.system(kind).is_locked(parameter) {
                continue;
            }
            let value = self.defaults.values[predefined as usize];
            let owners = table.owners().of_kind(kind).filter(|owner| table.fixed(*owner, parameter).is_none());
            assignments.extend(owners.map(|owner| Assignment { owner, parameter, value }));
        }
        assignments
    }

    /// The same settings, with everything within its range.
    #[must_use]
    pub fn within_ranges(&self) -> Settings {
        let usual = Settings::default();
        let sides = |size: [u32; 2], [low, high]: [u32; 2]| size.map(|side| side.clamp(low, high));
        let scale = if self.window.scale.is_nan() { usual.window.scale } else { self.window.scale };
        Settings {
            depth: self.depth.clamp(1, MAX_DEPTH),
            size: sides(self.size, [1, MAX_SIDE]),
            default_index: if is_index(self.default_index) { self.default_index } else { usual.default_index },
            samples: self.samples.clamp(1, MAX_PASSES),
            memory: self.memory.map(|memory| memory.clamp(MEMORY[0], MEMORY[1])),
            window: WindowSettings {
                scale: scale.clamp(SCALES[0], SCALES[1]),
                size: sides(self.window.size, WINDOW_SIDES),
                ..self.window
            },
            ..self.clone()
        }
    }
}

/// Whether a number can be a refractive index.
fn is_index(number: f64) -> bool {
    number > 0.0 && (number as f32).is_finite()
}

#[cfg(test)]
mod tests;
