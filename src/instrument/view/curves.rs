//! Views as curves: over the outgoing angle, and over the incoming angle.

use crate::instrument::albedo::{EQUAL, albedos};
use crate::instrument::direction::{STEEPEST, angle_text};
use crate::instrument::draft;
use crate::instrument::hemisphere::Integration;
use crate::instrument::view::settings::{Component, ComponentPart, NamedModel, ViewSettings};
use crate::plot::{CURVE_COLOURS, CartesianChart, Chart, ChartAxis, Curve, Dashes, PolarChart, ReferenceLine, subscript};

/// The polar angles of the light if none are given.
const USUAL_POLAR: [f64; 3] = [0.0, 30.0, 60.0];
/// The last outgoing angle, in degrees: along the surface there is no direction to look from.
const LAST: f64 = 89.9;

/// The outgoing angles for light at a polar angle: all around, and closer to each other at the mirror direction and at
/// the direction of the light, where lobes are narrow.
fn outgoing(polar: f64) -> Vec<f64> {
    let mut angles: Vec<f64> = (-178..=178).map(|half| 0.5 * f64::from(half)).collect();
    angles.extend([-LAST, -89.5, 89.5, LAST]);
    for middle in [polar, -polar] {
        for step in 0..120 {
            let away = 0.002 * 1.066_f64.powi(step);
            angles.extend([middle - away, middle + away]);
        }
        angles.push(middle);
    }
    angles.retain(|angle| angle.abs() <= LAST);
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    angles
}

/// The points of a curve over the outgoing angle: positive at the side of the mirror direction.
fn over_outgoing(model: &NamedModel, polar: f64, settings: &ViewSettings) -> (Vec<f64>, Vec<[f64; 3]>) {
    let angles = outgoing(polar);
    let pairs: Vec<_> = angles.iter().map(|angle| settings.pair(polar, *angle)).collect();
    let colours = settings.shown.of(model.model.as_ref(), &pairs);
    (angles, colours)
}

/// The curves of all models and incoming angles. What differs more gets a colour, and what differs less gets dashes.
fn reflection_curves(models: &[NamedModel], polar: &[f64], settings: &ViewSettings) -> Vec<Curve> {
    let parts = settings.component.unwrap_or(Component::Luminance).parts();
    let mut curves = Vec::new();
    for (number, model) in models.iter().enumerate() {
        for (index, angle) in polar.iter().enumerate() {
            let (angles, colours) = over_outgoing(model, *angle, settings);
            for ComponentPart { name: part, colour: own_colour, of: component } in &parts {
                let model_name = ViewSettings::name_among(models, number);
                let is_alone = model_name.is_empty() && parts.len() == 1;
                let incoming = if polar.len() > 1 || is_alone { incoming_name(*angle) } else { String::new() };
                let words = [model_name.as_str(), &incoming, *part].into_iter().filter(|word| !word.is_empty());
                // Among components, colours tell them apart; else among models; else among angles.
                let is_colour_free = parts.len() == 1;
                let (colour, dashes) = match own_colour.filter(|_| !is_colour_free) {
                    Some(colour) => (colour, index * models.len() + number),
                    // More curves than colours differ by their dashes.
                    None if models.len() > 1 => (number % CURVE_COLOURS, index + polar.len() * (number / CURVE_COLOURS)),
                    None => (index % CURVE_COLOURS, index / CURVE_COLOURS),
                };
                curves.push(Curve {
                    name: words.collect::<Vec<_>>().join(", "),
                    points: angles.iter().zip(&colours).map(|(angle, value)| [*angle, component(*value)]).collect(),
                    colour,
                    dashes: Dashes::ALL[dashes % Dashes::ALL.len()],
                });
            }
        }
    }
    curves
}

/// The name of an incoming angle.
pub(super) fn incoming_name(polar: f64) -> String {
    format!("{} = {}", subscript("θ", 'i'), angle_text(polar))
}

/// The title, and what stands below it: also the angle, if it is only one.
fn reflection_heading(models: &[NamedModel], polar: &[f64], settings: &ViewSettings) -> crate::plot::ChartHeading {
    let title = if settings.plane == 0.0 {
        "Reflection in the plane of incidence".to_owned()
    } else {
        format!("Reflection in a plane {} from that of incidence", angle_text(settings.plane))
    };
    let mut heading = settings.heading_at_azimuth(&title, models);
    if let ([angle], true) = (polar, models.len() > 1 || polar.len() == 1) {
        heading.add(&incoming_name(*angle));
    }
    heading
}

/// The BRDF over the outgoing angle, as distances.
pub(super) fn polar(models: &[NamedModel], settings: &ViewSettings) -> Chart {
    let polar = settings.polar_or(&USUAL_POLAR);
    let [title, unit] = settings.shown.title();
    let curves = reflection_curves(models, &polar, settings);
    let by_angle = polar.len() > 1 && models.len() == 1 && settings.component != Some(Component::Each);
    let colour_of = |index: usize| if by_angle { index % CURVE_COLOURS } else { CURVE_COLOURS };
    // At which side of the plane of the curves light comes from, if it comes from within that plane.
    let (across, along) = settings.plane.to_radians().sin_cos();
    let side = |angle: f64| (across.abs() < 1e-6 || angle == 0.0).then_some(-angle.copysign(angle * along));
    let arrows = polar.iter().enumerate().filter_map(|(index, angle)| Some((side(*angle)?, colour_of(index))));
    Chart::Polar(PolarChart {
        heading: reflection_heading(models, &polar, settings),
        angle: ChartAxis::angles("outgoing angle", [-90.0, 90.0]),
        radius: ChartAxis::numbers(title, unit, settings.is_log),
        curves,
        arrows: arrows.collect(),
    })
}

/// The BRDF over the outgoing angle.
pub(super) fn cartesian(models: &[NamedModel], settings: &ViewSettings) -> Chart {
    let polar = settings.polar_or(&USUAL_POLAR);
    let [title, unit] = settings.shown.title();
    Chart::Cartesian(CartesianChart {
        heading: reflection_heading(models, &polar, settings),
        x: ChartAxis::angles("outgoing angle", [-90.0, 90.0]),
        y: ChartAxis::numbers(title, unit, settings.is_log),
        curves: reflection_curves(models, &polar, settings),
        lines: Vec::new(),
    })
}

/// The incoming angles of the curve of shares.
fn incoming(is_draft: bool) -> Vec<f64> {
    if is_draft {
        return (0..=11).map(|step| 7.5 * f64::from(step)).chain([86.0, 88.5, 89.9, STEEPEST]).collect();
    }
    let mut angles: Vec<f64> = (0..=35).map(|step| 2.5 * f64::from(step)).collect();
    angles.extend([88.5, 89.0, 89.5, 89.9, STEEPEST]);
    angles
}

/// Curves up to this angle have all of their range in the chart, in degrees.
const WHOLE_UP_TO: f64 = 85.0;

/// A spike along the surface can be so high that the rest of the chart would look flat. Then this is the number at
/// which the chart ends, and the highest point.
fn beyond(curves: &[Curve]) -> Option<(f64, [f64; 2])> {
    let points = || curves.iter().flat_map(|curve| &curve.points).filter(|[_, share]| share.is_finite());
    let before = points().filter(|[angle, _]| *angle <= WHOLE_UP_TO).map(|[_, share]| *share).fold(1.0, f64::max);
    let highest = points().copied().max_by(|one, other| one[1].total_cmp(&other[1]))?;
    let is_negative = points().any(|[_, share]| *share < 0.0);
    (highest[1] > 3.0 * before && !is_negative).then_some((1.4 * before, highest))
}

/// Shares of drafts that differ by less, relative to 1, are called equal.
const DRAFT_EQUAL: f64 = 0.02;

/// The share of the light that is reflected, over the incoming angle.
pub(super) fn albedo(models: &[NamedModel], settings: &ViewSettings) -> Chart {
    let polar = incoming(settings.is_draft);
    let fixed: Vec<[f64; 2]> = polar.iter().map(|polar| [*polar, settings.light_azimuth]).collect();
    let shares = |model: &NamedModel, over: Integration| -> Vec<[f64; 3]> {
        match settings.is_draft {
            true => draft::shares(model.model.as_ref(), over, &fixed),
            false => albedos(model.model.as_ref(), over, &fixed).into_iter().map(|integral| integral.value).collect(),
        }
    };
    let both = models.iter().map(|model| [Integration::OverViews, Integration::OverLights].map(|over| shares(model, over)));
    let both: Vec<[Vec<[f64; 3]>; 2]> = both.collect();
    let is_grey = |[red, green, blue]: &[f64; 3]| (red - green).abs() < EQUAL && (green - blue).abs() < EQUAL;
    let all_grey = both.iter().flatten().flatten().all(is_grey);
    // Of several models, a luminance below 1 could hide a component above it.
    let usual = match (all_grey, models.len()) {
        (true, _) => Component::Luminance,
        (false, 1) => Component::Each,
        (false, _) => Component::Greatest,
    };
    let shown = settings.component.unwrap_or(usual);
    let parts = shown.parts();
    let mut heading = settings.heading_at_azimuth("Share of the light that is reflected", models);
    let mut curves = Vec::new();
    for (number, [beam, furnace]) in both.iter().enumerate() {
        let equal = if settings.is_draft { DRAFT_EQUAL } else { EQUAL };
        let differ =
            |one: &[f64; 3], other: &[f64; 3]| one.iter().zip(other).any(|(one, other)| (one - other).abs() > 2.0 * equal);
        let has_furnace = beam.iter().zip(furnace).any(|(one, other)| differ(one, other));
        let mut sides = vec![("of a beam", beam)];
        if has_furnace {
            sides.push(("in a furnace", furnace));
        }
        for (side, (what, values)) in sides.into_iter().enumerate() {
            for ComponentPart { name: part, colour: own_colour, of: component } in &parts {
                let model_name = ViewSettings::name_among(models, number);
                let what = if has_furnace { what } else { "" };
                let words = [model_name.as_str(), what, *part].into_iter().filter(|word| !word.is_empty());
                let name = words.collect::<Vec<_>>().join(", ");
                curves.push(Curve {
                    name: if name.is_empty() { "share of the light".to_owned() } else { name },
                    points: polar.iter().zip(values).map(|(polar, value)| [*polar, component(*value)]).collect(),
                    colour: own_colour.filter(|_| models.len() == 1).unwrap_or(number % CURVE_COLOURS),
                    dashes: Dashes::ALL[(side + 2 * (number / CURVE_COLOURS)) % Dashes::ALL.len()],
                });
            }
        }
    }
    let part = match shown {
        Component::Luminance if !all_grey => ", luminance",
        Component::Greatest if !all_grey => ", greatest of red, green, blue",
        Component::Luminance | Component::Greatest | Component::Red | Component::Green | Component::Blue | Component::Each => "",
    };
    let mut y = ChartAxis::numbers(&format!("share of the light{part}"), "", settings.is_log);
    if let Some((highest, [angle, share])) = beyond(&curves).filter(|_| !settings.is_log) {
        y.range = Some([0.0, highest]);
        heading.add(&format!("up to {share:.3} at {}, beyond the chart", angle_text(angle)));
    }
    Chart::Cartesian(CartesianChart {
        heading,
        x: ChartAxis::angles("angle of the beam, or of the viewer, from the normal", [0.0, 90.0]),
        y,
        curves,
        lines: vec![ReferenceLine { value: 1.0, label: "1: as much leaves as comes".to_owned() }],
    })
}
