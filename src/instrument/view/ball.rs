//! Views of a ball: in a white furnace, and under a light.

use crate::instrument::albedo::albedos;
use crate::instrument::direction::{angle_text, direction, pair};
use crate::instrument::draft;
use crate::instrument::hemisphere::Integration;
use crate::instrument::survey::{ModelSurvey, seems_to_depend_on_azimuth};
use crate::instrument::view::settings::{NamedModel, ViewSettings};
use crate::instrument::{DirectionPair, Reflectance};
use crate::plot::{Chart, ChartAxis, MapChart, MapPanel, MapValues};
use glam::{DMat3, DVec3};

/// The pixels of a picture of a ball.
#[derive(Clone, Copy)]
struct BallGrid {
    /// Pixels along each side.
    side: u32,
    /// Points of a pixel along each side.
    fineness: u32,
}

/// That of a chart, and that of a draft.
const FINE: BallGrid = BallGrid { side: 360, fineness: 2 };
const DRAFT: BallGrid = BallGrid { side: 240, fineness: 1 };

/// The radius of the ball, where half a side is 1.
const RADIUS: f64 = 0.88;
/// The colour of a ball without any finite value.
const UNKNOWN: [f32; 3] = [f32::NAN; 3];
/// How bright the furnace is shown, so that more than it has can be seen.
const FURNACE: f32 = 0.5;

impl BallGrid {
    fn of(settings: &ViewSettings) -> Self {
        if settings.is_draft { DRAFT } else { FINE }
    }

    /// Points along each side.
    fn points(self) -> u32 {
        self.side * self.fineness
    }

    /// The place of a point of a pixel on the ball: its normal, to the right, up, and towards the viewer. None beside
    /// it.
    fn normal_at(self, index: u32) -> Option<DVec3> {
        let side = self.points();
        let place = |index: u32| (2.0 * (f64::from(index) + 0.5) / f64::from(side) - 1.0) / RADIUS;
        let (x, y) = (place(index % side), -place(index / side));
        let height = 1.0 - x * x - y * y;
        (height > 0.0).then(|| DVec3::new(x, y, height.sqrt()))
    }

    /// The means of the points of each pixel.
    fn pixels(self, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let (side, fineness) = (self.points(), self.fineness);
        let pixel = |index: u32| {
            let (column, row) = (index % self.side * fineness, index / self.side * fineness);
            let mut sum = [0.0; 3];
            for within in 0..fineness * fineness {
                let at = (row + within / fineness) * side + column + within % fineness;
                let point = points.get(at as usize).copied().unwrap_or_default();
                // What is brighter than white does not shine over an edge. NaN stays.
                let kept = |component: f32| if component > 1.0 { 1.0 } else { component };
                sum.iter_mut().zip(point).for_each(|(sum, component): (&mut f32, f32)| *sum += kept(component));
            }
            sum.map(|component| component / (fineness * fineness) as f32)
        };
        (0..self.side * self.side).map(pixel).collect()
    }

    /// The colours of a ball by `colours`, which is given the normals of its points, before a background.
    fn ball(self, background: [f32; 3], colours: impl FnOnce(&[DVec3]) -> Vec<[f32; 3]>) -> MapPanel {
        let normals: Vec<Option<DVec3>> = (0..self.points().pow(2)).map(|index| self.normal_at(index)).collect();
        let seen: Vec<DVec3> = normals.iter().copied().flatten().collect();
        let mut colours = colours(&seen).into_iter();
        let of_point = |normal: &Option<DVec3>| normal.and_then(|_| colours.next()).unwrap_or(background);
        let points: Vec<[f32; 3]> = normals.iter().map(of_point).collect();
        MapPanel { name: String::new(), size: [self.side; 2], values: MapValues::Colours(self.pixels(&points)) }
    }
}

/// Tangent, bitangent and normal of a ball as columns; the tangent runs around the vertical axis.
fn frame(normal: DVec3) -> DMat3 {
    let tangent = DVec3::Y.cross(normal).try_normalize().unwrap_or(DVec3::X);
    DMat3::from_cols(tangent, normal.cross(tangent), normal)
}

/// What is seen of a model in a white furnace, by polar angle and azimuth of the viewer.
struct FurnaceTable {
    /// Steps of the polar angle, and of the azimuth.
    steps: [usize; 2],
    shares: Vec<[f64; 3]>,
    /// Whether there is any finite value, and whether there are values that are not.
    is_known: bool,
    has_odd: bool,
}

impl FurnaceTable {
    const LAST: f64 = 89.5;

    fn new(model: &dyn Reflectance, is_draft: bool) -> Self {
        if is_draft {
            let steps = if seems_to_depend_on_azimuth(model) { [12, 8] } else { [12, 1] };
            let shares = draft::shares(model, Integration::OverLights, &Self::angles(steps));
            return Self { steps, shares, is_known: true, has_odd: false };
        }
        let survey = ModelSurvey::of(model);
        let steps = if survey.depends_on_azimuth { [18, 24] } else { [45, 1] };
        let angles = Self::angles(steps);
        let shares = albedos(model, Integration::OverLights, &angles).into_iter().map(|integral| integral.value).collect();
        Self { steps, shares, is_known: survey.least.is_some(), has_odd: survey.not_finite.is_some() }
    }

    /// Polar angles and azimuths of the table, row by row.
    fn angles(steps: [usize; 2]) -> Vec<[f64; 2]> {
        let row = |row: usize| Self::LAST * row as f64 / steps[0] as f64;
        let column = |column: usize| 360.0 * column as f64 / steps[1] as f64;
        (0..=steps[0]).flat_map(|polar| (0..steps[1]).map(move |azimuth| [row(polar), column(azimuth)])).collect()
    }

    /// The share that is seen from a direction in the frame of the surface.
    fn at(&self, view: DVec3) -> [f64; 3] {
        let polar = view.z.clamp(-1.0, 1.0).acos().to_degrees();
        let row = (polar / Self::LAST * self.steps[0] as f64).clamp(0.0, self.steps[0] as f64);
        let turn = view.y.atan2(view.x).rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU;
        let column = turn * self.steps[1] as f64;
        let (first, start) = ((row.floor() as usize).min(self.steps[0] - 1), column.floor() as usize);
        let share = |row: usize, column: usize| self.shares[row * self.steps[1] + column % self.steps[1]];
        let mixed = |one: [f64; 3], other: [f64; 3], part: f64| -> [f64; 3] {
            std::array::from_fn(|index| one[index] + part * (other[index] - one[index]))
        };
        let across = |row: usize| mixed(share(row, start), share(row, start + 1), column - column.floor());
        mixed(across(first), across(first + 1), row - first as f64)
    }
}

/// A ball in a white furnace.
pub(super) fn furnace(models: &[NamedModel], settings: &ViewSettings) -> Chart {
    let mut heading = settings.heading("White furnace: darker loses light, brighter makes light");
    let mut panels = Vec::new();
    for (number, model) in models.iter().enumerate() {
        let table = FurnaceTable::new(model.model.as_ref(), settings.is_draft);
        let ends = |[low, high]: [f64; 2], share: &f64| [low.min(*share), high.max(*share)];
        let [least, greatest] = table.shares.iter().flatten().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
        let told = match (table.is_known, table.has_odd) {
            (false, _) => "has no finite value".to_owned(),
            (true, true) => format!("sends {least:.3} to {greatest:.3} of the light where values are finite"),
            (true, false) => format!("sends {least:.3} to {greatest:.3} of the light"),
        };
        let colours = |normals: &[DVec3]| -> Vec<[f32; 3]> {
            if !table.is_known {
                return vec![UNKNOWN; normals.len()];
            }
            let seen = normals.iter().map(|normal| table.at(frame(*normal).transpose() * DVec3::Z));
            seen.map(|share| share.map(|component| FURNACE * component as f32)).collect()
        };
        let mut name = ViewSettings::name_among(models, number);
        match (name.is_empty(), table.is_known) {
            (true, _) => heading.add(&format!("the ball {told}")),
            (false, true) => name = format!("{name}: {least:.3} to {greatest:.3}"),
            (false, false) => name = format!("{name}: {told}"),
        }
        panels.push(MapPanel { name, ..BallGrid::of(settings).ball([FURNACE; 3], colours) });
    }
    if models.len() > 1 {
        heading.add("numbers: the share of the light that a ball sends");
    }
    let bar = ChartAxis::numbers("half of the share", "", false);
    Chart::Map(MapChart { heading, axes: None, bar, panels })
}

/// A ball under a distant light from the left above.
pub(super) fn sphere(models: &[NamedModel], settings: &ViewSettings) -> Chart {
    let polar = settings.polar_or(&[45.0]);
    let mut panels = Vec::new();
    for (number, model) in models.iter().enumerate() {
        for angle in &polar {
            let light = direction(*angle, 135.0 + settings.light_azimuth);
            let ball = BallGrid::of(settings).ball([0.03; 3], |normals| lit(model.model.as_ref(), light, normals));
            let name = ViewSettings::name_among(models, number);
            let angle = if polar.len() > 1 { format!("light at {}", angle_text(*angle)) } else { String::new() };
            let words = [name, angle].into_iter().filter(|word| !word.is_empty());
            panels.push(MapPanel { name: words.collect::<Vec<_>>().join(", "), ..ball });
        }
    }
    let heading = settings.heading("A ball under a distant light");
    Chart::Map(MapChart { heading, axes: None, bar: ChartAxis::default(), panels })
}

/// The colours of a ball at points with these normals.
fn lit(model: &dyn Reflectance, light: DVec3, normals: &[DVec3]) -> Vec<[f32; 3]> {
    let is_lit = |normal: &DVec3| normal.dot(light) > 0.0;
    let local = |normal: &DVec3| {
        let back = frame(*normal).transpose();
        pair(back * light, back * DVec3::Z)
    };
    let pairs: Vec<DirectionPair> = normals.iter().filter(|normal| is_lit(normal)).map(local).collect();
    let mut values = model.values(&pairs).into_iter();
    let black = [0.0; 3];
    normals.iter().map(|normal| if is_lit(normal) { values.next().unwrap_or(black) } else { black }).collect()
}
