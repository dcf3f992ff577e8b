//! Views of models: what they are at a glance, as charts.
//!
//! [`VIEWS`] is the table of them. The command line, the manual and the window derive from it.

mod ball;
mod curves;
mod lobes;
mod maps;
mod reading;
mod settings;

use crate::plot::Chart;
pub use lobes::MOST_LOBES;
pub use reading::{DirectionReading, readings};
pub use settings::{Component, NamedModel, Shown, ViewSettings};

/// What can be chosen for some views.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViewChoice {
    /// Polar angles of the light.
    LightPolar,
    /// The azimuth of the light.
    LightAzimuth,
    /// The plane in which outgoing directions are.
    Plane,
    /// Logarithmic scales.
    Log,
    /// False colours.
    FalseColours,
    /// The component of colours.
    Component,
    /// The BRDF, or the value of the formula.
    Shown,
    /// From where it is seen.
    SeenFrom,
}

use ViewChoice::{Component as OfComponent, FalseColours, LightAzimuth, LightPolar, Log, Plane, SeenFrom, Shown as OfShown};

/// From where light comes in a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightUse {
    /// From each of [`ViewSettings::light_polar`], together in one chart.
    Several,
    /// The same, but each angle takes a picture of its own.
    One,
    /// From every angle.
    All,
    /// From every angle, and its values are integrals over the hemisphere. They take longer.
    Integrated,
}

/// A view.
#[derive(Debug)]
pub struct InstrumentView {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows.
    pub doc: &'static str,
    /// What its axes are.
    pub axes: &'static str,
    /// What can be chosen beside the models.
    pub choices: &'static [ViewChoice],
    /// From where light comes in it.
    pub lights: LightUse,
    /// Makes the chart of one or more models.
    chart: fn(&[NamedModel], &ViewSettings) -> Chart,
}

/// All views.
pub const VIEWS: [InstrumentView; 8] = [
    InstrumentView {
        name: "polar",
        doc: "the BRDF in a plane through the normal, as distances from the middle",
        axes: "outgoing angle; BRDF as the distance",
        choices: &[LightPolar, LightAzimuth, Plane, Log, OfComponent, OfShown],
        lights: LightUse::Several,
        chart: curves::polar,
    },
    InstrumentView {
        name: "cartesian",
        doc: "the same, over two axes",
        axes: "outgoing angle from −90° to 90°; BRDF",
        choices: &[LightPolar, LightAzimuth, Plane, Log, OfComponent, OfShown],
        lights: LightUse::Several,
        chart: curves::cartesian,
    },
    InstrumentView {
        name: "lobe",
        doc: "the BRDF of all outgoing directions, as a surface in space",
        axes: "the directions themselves; BRDF as the distance",
        choices: &[LightPolar, LightAzimuth, Log, OfComponent, OfShown, SeenFrom],
        lights: LightUse::One,
        chart: lobes::lobe,
    },
    InstrumentView {
        name: "slice",
        doc: "the picture of a material by Burley (2012): half angle by difference angle, at an azimuth of 90°",
        axes: "half angle θh, difference angle θd; π · BRDF as the colour",
        choices: &[Log, FalseColours, OfComponent],
        lights: LightUse::All,
        chart: maps::slice,
    },
    InstrumentView {
        name: "albedo",
        doc: "the share of a beam of light that is reflected, with a line at 1",
        axes: "incoming angle; share of the light",
        choices: &[LightAzimuth, Log, OfComponent],
        lights: LightUse::Integrated,
        chart: curves::albedo,
    },
    InstrumentView {
        name: "furnace",
        doc: "a ball in a white furnace, light from everywhere: it vanishes if it loses and makes no light",
        axes: "the ball, seen from the front",
        choices: &[],
        lights: LightUse::Integrated,
        chart: ball::furnace,
    },
    InstrumentView {
        name: "reciprocity",
        doc: "the relative difference of the BRDF if light and viewer change places",
        axes: "incoming angle, outgoing angle; difference as the colour",
        choices: &[LightAzimuth, Plane],
        lights: LightUse::All,
        chart: maps::reciprocity,
    },
    InstrumentView {
        name: "sphere",
        doc: "a ball that a distant light shines on",
        axes: "the ball, seen from the front",
        choices: &[LightPolar, LightAzimuth],
        lights: LightUse::One,
        chart: ball::sphere,
    },
];

impl InstrumentView {
    /// The view of a name.
    pub fn named(name: &str) -> Option<&'static InstrumentView> {
        VIEWS.iter().find(|view| view.name == name)
    }

    /// The chart of models. There is at least one model for anything to be seen.
    pub fn chart(&self, models: &[NamedModel], settings: &ViewSettings) -> Chart {
        (self.chart)(models, settings)
    }
}

#[cfg(test)]
mod tests;
