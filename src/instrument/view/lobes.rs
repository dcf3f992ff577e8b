//! The view of lobes in space.

use crate::instrument::direction::{direction, pair};
use crate::instrument::view::curves::incoming_name;
use crate::instrument::view::settings::{Component, NamedModel, ViewSettings};
use crate::plot::{Chart, ChartAxis, Lobe, LobeChart};

/// The most lobes of a chart.
pub const MOST_LOBES: usize = 12;

/// Angles from `low` to `high`, closer to each other around `middles`, where lobes are narrow. A draft has half of
/// them.
fn nodes([low, high]: [f64; 2], step: f64, middles: &[f64], is_draft: bool) -> Vec<f64> {
    let every = if is_draft { 2 } else { 1 };
    let step = f64::from(every) * step;
    let count = ((high - low) / step).round() as u32;
    let mut angles: Vec<f64> = (0..=count).map(|index| low + step * f64::from(index)).collect();
    for middle in middles {
        for index in (0..28).step_by(every as usize) {
            let away = 0.02 * 1.25_f64.powi(index);
            angles.extend([middle - away, middle + away]);
        }
        angles.push(*middle);
    }
    angles.retain(|angle| (low..=high).contains(angle));
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|one, other| (*one - *other).abs() < 1e-9);
    angles
}

/// The surface of one model for light from one direction.
fn lobe_of(model: &NamedModel, polar: f64, settings: &ViewSettings) -> Lobe {
    let azimuth = settings.light_azimuth;
    let light = direction(polar, azimuth);
    // The surface is closed at the normal and ends just above the horizon.
    let rows = nodes([0.0, 89.9], 1.45, &[polar], settings.is_draft);
    let columns = nodes([azimuth, azimuth + 360.0], 3.0, &[azimuth + 180.0], settings.is_draft);
    let component = settings.component.unwrap_or(Component::Luminance);
    let pairs = rows.iter().flat_map(|row| columns.iter().map(|column| pair(light, direction(*row, *column))));
    let colours = settings.shown.of(model.model.as_ref(), &pairs.collect::<Vec<_>>());
    let values = colours.into_iter().map(|colour| component.of(colour)).collect();
    Lobe { name: String::new(), colour: 0, light: [polar, azimuth], polar: rows, azimuths: columns, values }
}

/// The BRDF of all outgoing directions.
pub(super) fn lobe(models: &[NamedModel], settings: &ViewSettings) -> Chart {
    let polar = settings.polar_or(&[45.0]);
    let mut lobes = Vec::new();
    for (number, model) in models.iter().enumerate() {
        for (index, angle) in polar.iter().enumerate() {
            let name = ViewSettings::name_among(models, number);
            let words = [name, incoming_name(*angle)].into_iter().filter(|word| !word.is_empty());
            let name = words.collect::<Vec<_>>().join(", ");
            let colour = if models.len() > 1 { number } else { index };
            lobes.push(Lobe { name, colour, ..lobe_of(model, *angle, settings) });
        }
    }
    lobes.truncate(MOST_LOBES);
    let [title, unit] = settings.shown.title();
    let [azimuth, elevation] = settings.seen_from;
    Chart::Lobe(LobeChart {
        heading: settings.heading_at_azimuth("Reflection into all directions", models),
        radius: ChartAxis::numbers(title, unit, settings.is_log),
        seen_from: [settings.light_azimuth + azimuth, elevation],
        is_draft: settings.is_draft,
        lobes,
    })
}
