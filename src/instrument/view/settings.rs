//! What views are told: models with names, and what is shown of them.

use crate::instrument::direction::{angle_text, brdf, direction, luminance, pair};
use crate::instrument::survey::seems_to_depend_on_azimuth;
use crate::instrument::{DirectionPair, Reflectance};
use crate::plot::ChartHeading;
use std::f64::consts::PI;
use std::sync::Arc;

/// A model with the name that charts show.
#[derive(Clone)]
pub struct NamedModel {
    /// Its name.
    pub name: String,
    /// The model.
    pub model: Arc<dyn Reflectance>,
}

/// One number of a colour.
pub(super) struct ComponentPart {
    /// Its name; empty if it stands for all of the colour.
    pub(super) name: &'static str,
    /// The number of the colour of its curves.
    pub(super) colour: Option<usize>,
    /// The number.
    pub(super) of: fn([f64; 3]) -> f64,
}

/// What is shown of colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// The luminance.
    Luminance,
    /// One component.
    Red,
    /// One component.
    Green,
    /// One component.
    Blue,
    /// Red, green and blue, a curve each.
    Each,
    /// The greatest of red, green and blue.
    Greatest,
}

/// The greatest component of a colour; NaN if one of them is.
fn greatest(colour: [f64; 3]) -> f64 {
    colour.into_iter().reduce(|one, other| if one.is_nan() || one > other { one } else { other }).unwrap_or(f64::NAN)
}

impl Component {
    /// All of them, with the names of the command line.
    pub const ALL: [(&'static str, Component); 6] = [
        ("luminance", Component::Luminance),
        ("red", Component::Red),
        ("green", Component::Green),
        ("blue", Component::Blue),
        ("each", Component::Each),
        ("greatest", Component::Greatest),
    ];

    /// What is shown.
    pub(super) fn parts(self) -> Vec<ComponentPart> {
        let red = ComponentPart { name: "red", colour: Some(1), of: |colour| colour[0] };
        let green = ComponentPart { name: "green", colour: Some(2), of: |colour| colour[1] };
        let blue = ComponentPart { name: "blue", colour: Some(0), of: |colour| colour[2] };
        match self {
            Component::Luminance => vec![ComponentPart { name: "", colour: None, of: luminance }],
            Component::Red => vec![red],
            Component::Green => vec![green],
            Component::Blue => vec![blue],
            Component::Each => vec![red, green, blue],
            Component::Greatest => vec![ComponentPart { name: "", colour: None, of: greatest }],
        }
    }

    /// One number of a colour; the luminance stands for all three.
    pub(super) fn of(self, colour: [f64; 3]) -> f64 {
        match self {
            Component::Luminance | Component::Each => luminance(colour),
            Component::Red => colour[0],
            Component::Green => colour[1],
            Component::Blue => colour[2],
            Component::Greatest => greatest(colour),
        }
    }
}

/// Which number of a pair of directions is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// The BRDF in 1/sr.
    Brdf,
    /// The value of the formula for white light: π · BRDF · cos θ of the light.
    Value,
}

impl Shown {
    /// Both, with the names of the command line.
    pub const ALL: [(&'static str, Shown); 2] = [("brdf", Shown::Brdf), ("value", Shown::Value)];

    /// The title and the unit of its axis.
    pub(super) fn title(self) -> [&'static str; 2] {
        match self {
            Shown::Brdf => ["BRDF", "1/sr"],
            Shown::Value => ["value for white light", ""],
        }
    }

    /// The numbers for pairs of directions.
    pub(super) fn of(self, model: &dyn Reflectance, pairs: &[DirectionPair]) -> Vec<[f64; 3]> {
        let values = model.values(pairs);
        let number = |(pair, value): (&DirectionPair, [f32; 3])| match self {
            Shown::Brdf => brdf(pair, value),
            Shown::Value => value.map(f64::from),
        };
        pairs.iter().zip(values).map(number).collect()
    }
}

/// What is shown, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewSettings {
    /// Of what: stands below the title.
    pub subtitle: String,
    /// Polar angles of the light in degrees, 0 to 89.99; none for those that the view takes by itself.
    pub light_polar: Vec<f64>,
    /// The azimuth of the light from the tangent, in degrees.
    pub light_azimuth: f64,
    /// The angle between the plane of incidence and the plane in which outgoing directions are, in degrees.
    pub plane: f64,
    /// Whether equal distances are equal ratios.
    pub is_log: bool,
    /// Whether pictures show numbers in false colours.
    pub false_colours: bool,
    /// What is shown of colours; none to follow from the model.
    pub component: Option<Component>,
    /// Which number is shown.
    pub shown: Shown,
    /// From where lobes are seen: azimuth from the light's, and elevation, in degrees.
    pub seen_from: [f64; 2],
    /// Whether charts are drafts, for those that follow a slider: drawn more coarsely, and integrals are right to some
    /// percent.
    pub is_draft: bool,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            subtitle: String::new(),
            light_polar: Vec::new(),
            light_azimuth: 0.0,
            plane: 0.0,
            is_log: false,
            false_colours: false,
            component: None,
            shown: Shown::Brdf,
            seen_from: [115.0, 26.0],
            is_draft: false,
        }
    }
}

impl ViewSettings {
    /// The polar angles of the light, or these.
    pub(super) fn polar_or(&self, usual: &[f64]) -> Vec<f64> {
        if self.light_polar.is_empty() { usual.to_vec() } else { self.light_polar.clone() }
    }

    /// Light from a polar angle, and a viewer at an angle in the plane of outgoing directions, in degrees.
    pub(super) fn pair(&self, light: f64, viewer: f64) -> DirectionPair {
        let opposite = self.light_azimuth + 180.0 + self.plane;
        pair(direction(light, self.light_azimuth), direction(viewer, opposite))
    }

    /// The heading of a chart.
    pub(super) fn heading(&self, title: &str) -> ChartHeading {
        ChartHeading { title: title.to_owned(), subtitle: self.subtitle.clone() }
    }

    /// A title, and what stands below it for light from an azimuth: also that, if it matters.
    pub(super) fn heading_at_azimuth(&self, title: &str, models: &[NamedModel]) -> ChartHeading {
        let mut heading = self.heading(title);
        if self.light_azimuth != 0.0 || models.iter().any(|model| seems_to_depend_on_azimuth(model.model.as_ref())) {
            heading.add(&format!("azimuth {}", angle_text(self.light_azimuth)));
        }
        heading
    }

    /// What of several models stands for one: its name, if there are others.
    pub(super) fn name_among(models: &[NamedModel], index: usize) -> String {
        if models.len() > 1 { models[index].name.clone() } else { String::new() }
    }
}

/// π times a BRDF: 1 for a matte white surface.
pub(super) fn scaled(brdf: [f64; 3]) -> [f32; 3] {
    brdf.map(|component| (PI * component) as f32)
}
