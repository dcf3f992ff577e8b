//! The sizes of the panels of the window, as the user left them.

use serde::ser::{Serialize, SerializeMap, Serializer};

/// A side of a panel that the user can move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PanelSide {
    /// The width of the texts.
    Texts,
    /// The width of the parameters.
    Parameters,
    /// The height of the list of bodies and lights.
    Owners,
    /// The height of the pixel inspector.
    Inspector,
    /// The height of the instruments below the picture.
    Instruments,
    /// The width of the instruments at the right of the picture.
    InstrumentsAtRight,
    /// The width of the instruments over the picture.
    InstrumentsOverWidth,
    /// The height of the instruments over the picture.
    InstrumentsOverHeight,
    /// The height of the panel for fits.
    Fitting,
}

impl PanelSide {
    /// Every side.
    pub const ALL: [PanelSide; 9] = [
        PanelSide::Texts,
        PanelSide::Parameters,
        PanelSide::Owners,
        PanelSide::Inspector,
        PanelSide::Instruments,
        PanelSide::InstrumentsAtRight,
        PanelSide::InstrumentsOverWidth,
        PanelSide::InstrumentsOverHeight,
        PanelSide::Fitting,
    ];

    /// Its key in the file.
    pub fn key(self) -> &'static str {
        match self {
            PanelSide::Texts => "texts_width",
            PanelSide::Parameters => "parameters_width",
            PanelSide::Owners => "owners_height",
            PanelSide::Inspector => "inspector_height",
            PanelSide::Instruments => "instruments_height",
            PanelSide::InstrumentsAtRight => "instruments_width",
            PanelSide::InstrumentsOverWidth => "instruments_over_width",
            PanelSide::InstrumentsOverHeight => "instruments_over_height",
            PanelSide::Fitting => "fitting_height",
        }
    }

    /// The side with this key.
    pub fn named(key: &str) -> Option<PanelSide> {
        PanelSide::ALL.into_iter().find(|side| side.key() == key)
    }

    /// The size at the first start, in points.
    fn usual(self) -> f32 {
        match self {
            PanelSide::Texts => 390.0,
            PanelSide::Parameters => 310.0,
            PanelSide::Owners => 240.0,
            PanelSide::Inspector => 240.0,
            PanelSide::Instruments => 380.0,
            PanelSide::InstrumentsAtRight => 420.0,
            PanelSide::InstrumentsOverWidth => 380.0,
            PanelSide::InstrumentsOverHeight => 400.0,
            PanelSide::Fitting => 320.0,
        }
    }
}

/// The allowed sizes of panels, in points. The window also keeps room for the others.
pub const PANEL_SIZES: [f32; 2] = [60.0, 4000.0];

/// A size for each side, in points, within [`PANEL_SIZES`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PanelSizes {
    /// In the order of [`PanelSide::ALL`].
    sizes: [f32; PanelSide::ALL.len()],
}

impl Default for PanelSizes {
    fn default() -> Self {
        Self { sizes: PanelSide::ALL.map(PanelSide::usual) }
    }
}

impl PanelSizes {
    /// The size of a side, in points.
    pub fn get(&self, side: PanelSide) -> f32 {
        self.sizes[side as usize]
    }

    /// Sets a size to the nearest within range, in whole points. NaN changes nothing.
    pub fn set(&mut self, side: PanelSide, size: f32) {
        if !size.is_nan() {
            self.sizes[side as usize] = size.clamp(PANEL_SIZES[0], PANEL_SIZES[1]).round();
        }
    }

    /// The sizes of two programs: ours where they were changed here.
    pub(super) fn merged(&self, last_seen: &Self, theirs: &Self) -> Self {
        let of = |side: PanelSide| if self.get(side) == last_seen.get(side) { theirs.get(side) } else { self.get(side) };
        Self { sizes: PanelSide::ALL.map(of) }
    }
}

impl Serialize for PanelSizes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(PanelSide::ALL.len()))?;
        for side in PanelSide::ALL {
            map.serialize_entry(side.key(), &self.get(side))?;
        }
        map.end()
    }
}
