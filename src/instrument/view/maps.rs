//! Views as pictures over two angles.

use crate::instrument::DirectionPair;
use crate::instrument::direction::{brdf, direction, pair};
use crate::instrument::reciprocity::differences;
use crate::instrument::view::settings::{Component, NamedModel, ViewSettings, scaled};
use crate::plot::{Chart, ChartAxis, MapChart, MapPanel, MapValues, subscript};
use glam::{DQuat, DVec3};

/// Pixels along each side.
const SIDE: u32 = 180;

/// The angle of a pixel, in degrees from 0 to 90.
fn angle(index: u32) -> f64 {
    90.0 * (f64::from(index) + 0.5) / f64::from(SIDE)
}

/// What there is at each pixel, row by row from the top: `at` is given the angles to the right and upwards.
fn pixels(at: impl Fn(f64, f64) -> DirectionPair) -> Vec<DirectionPair> {
    let rows = (0..SIDE).rev();
    rows.flat_map(|row| (0..SIDE).map(move |column| (column, row))).map(|(column, row)| at(angle(column), angle(row))).collect()
}

/// The pair of directions with a half angle and a difference angle, at an azimuth of 90° between them (Rusinkiewicz
/// 1998, "A New Change of Variables for Efficient BRDF Representation").
fn halfway(half: f64, difference: f64) -> DirectionPair {
    let turn = DQuat::from_axis_angle(DVec3::Y, half.to_radians());
    let light = turn * direction(difference, 90.0);
    let middle = turn * DVec3::Z;
    pair(light, 2.0 * middle.dot(light) * middle - light)
}

/// The image slice of Burley (2012), "Physically-Based Shading at Disney", section 3.
pub(super) fn slice(models: &[NamedModel], settings: &ViewSettings) -> Chart {
    let pairs = pixels(halfway);
    let shows_numbers = settings.false_colours || settings.is_log || settings.component.is_some();
    let panels = models.iter().enumerate().map(|(number, model)| {
        let brdfs = pairs.iter().zip(model.model.values(&pairs)).map(|(pair, value)| brdf(pair, value));
        let values = if shows_numbers {
            let component = settings.component.unwrap_or(Component::Luminance);
            MapValues::Numbers(brdfs.map(|brdf| component.of(brdf)).collect())
        } else {
            MapValues::Colours(brdfs.map(scaled).collect())
        };
        MapPanel { name: ViewSettings::name_among(models, number), size: [SIDE; 2], values }
    });
    let names = [("half angle ", 'h'), ("difference angle ", 'd')];
    let title = if shows_numbers { "Image slice" } else { "Image slice: π · BRDF" };
    Chart::Map(MapChart {
        heading: settings.heading(title),
        axes: Some(names.map(|(name, mark)| ChartAxis::angles(&format!("{name}{}", subscript("θ", mark)), [0.0, 90.0]))),
        bar: match shows_numbers {
            true => ChartAxis::numbers("BRDF", "1/sr", settings.is_log),
            false => ChartAxis::numbers("π · BRDF", "", false),
        },
        panels: panels.collect(),
    })
}

/// How different the BRDF is if light and viewer change places.
pub(super) fn reciprocity(models: &[NamedModel], settings: &ViewSettings) -> Chart {
    let pairs = pixels(|light, view| settings.pair(light, view));
    let panels = models.iter().enumerate().map(|(number, model)| MapPanel {
        name: ViewSettings::name_among(models, number),
        size: [SIDE; 2],
        values: MapValues::Numbers(differences(model.model.as_ref(), &pairs)),
    });
    let panels: Vec<MapPanel> = panels.collect();
    // Where there is nothing but rounding, nothing is to be seen.
    let greatest = panels.iter().flat_map(|panel| match &panel.values {
        MapValues::Numbers(numbers) => numbers.as_slice(),
        MapValues::Colours(_) => &[],
    });
    let is_reciprocal = !greatest.copied().any(|difference| difference > 1e-3);
    let range = is_reciprocal.then_some([0.0, 0.01]);
    Chart::Map(MapChart {
        heading: settings.heading_at_azimuth("Reciprocity: the difference if light and viewer change places", models),
        axes: Some(["angle of the light", "angle of the viewer"].map(|title| ChartAxis::angles(title, [0.0, 90.0]))),
        bar: ChartAxis { range, ..ChartAxis::numbers("relative difference", "", false) },
        panels,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn slices_have_the_half_angle_and_the_difference_angle() {
        for (half, difference) in [(0.0, 0.0), (30.0, 60.0), (80.0, 45.0), (10.0, 89.0)] {
            let pair = halfway(half, difference);
            let [light, view] = [pair.light, pair.view].map(|direction| Vec3::from(direction).as_dvec3());
            let middle = (light + view).normalize();
            assert!((middle.z.acos().to_degrees() - half).abs() < 1e-3, "{half} {difference}");
            assert!((middle.dot(light).clamp(-1.0, 1.0).acos().to_degrees() - difference).abs() < 1e-2, "{half} {difference}");
            // At 90° both are as high above the surface.
            assert!((light.z - view.z).abs() < 1e-6);
        }
    }
}
