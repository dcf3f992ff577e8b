//! What `measure` prints: the verdict first, then the numbers.

use crate::cli::measure::report::{
    AlbedoReport, COMPONENTS, ExpressionReport, GreatestReport, MeasurementReport, PairReport, RangeReport,
};
use illuminator::instrument::albedo::ACCURACY;
use std::fmt::Write;

/// The width of the names at the left.
const NAME_WIDTH: usize = 14;
/// A share that may be more wrong than this, or this part of it, is told with its error.
const LARGE_ERROR: f64 = 2e-3;
/// What the smallest value is of.
const VALUE: &str = "(the formula's value, π · BRDF · cos θ)";
/// The most characters of the name of an expression.
const LONGEST_NAME: usize = 24;

/// The table.
pub(super) fn table(report: &MeasurementReport) -> String {
    let mut text = format!("{}\n\n", report.model);
    let mut fact = |name: &str, said: String| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{name:<NAME_WIDTH$}{said}");
    };
    fact("energy", verdict(report));
    if has_furnace(report) && report.smallest.is_some() {
        fact("furnace", furnace(report));
    }
    fact("reciprocity", reciprocity(report));
    let azimuth = match report.depends_on_azimuth {
        Some(true) => "matters (anisotropic)",
        Some(false) => "does not matter (isotropic)",
        None => "CANNOT BE TOLD",
    };
    fact("azimuth", azimuth.to_owned());
    fact(
        "smallest",
        match &report.smallest {
            Some(smallest) if smallest.value < 0.0 => {
                format!("NEGATIVE: {} {VALUE} at {}", number(smallest.value), place(&smallest.at))
            }
            Some(smallest) => format!("{} {VALUE}, no negative value found", number(smallest.value)),
            None => "no finite value".to_owned(),
        },
    );
    if let Some(error) = report.large_error() {
        fact("ACCURACY", format!("low: shares may be wrong by {}", number(error)));
    }
    if let Some(pair) = &report.not_finite {
        fact("NOT FINITE", format!("at {}; there it counts as 0", place(pair)));
    }
    if let Some(ranges) = &report.ranges {
        text.push_str(&over_ranges(ranges));
    }
    text.push('\n');
    text.push_str(&shares(report));
    if !report.expressions.is_empty() {
        text.push('\n');
        text.push_str(&expressions(report));
    }
    text
}

/// An angle in degrees, with more digits near the horizon.
fn degrees(angle: f64) -> String {
    if angle > 89.0 { format!("{angle:.2}°") } else { format!("{angle:.1}°") }
}

/// A share of the light with this many digits behind the point; a very large one as a power of ten.
fn portion(share: f64, digits: usize) -> String {
    if share.abs() < 1e5 { format!("{share:.digits$}") } else { format!("{share:.3e}") }
}

fn percent(share: f64) -> String {
    if share < 5e-5 {
        return "less than 0.01 %".to_owned();
    }
    let digits = if share < 0.0995 { 2 } else { 1 };
    format!("{:.digits$} %", 100.0 * share)
}

/// Whether what is seen in a white furnace is told beside what is reflected of a beam.
fn has_furnace(report: &MeasurementReport) -> bool {
    report.is_reciprocal != Some(true)
}

/// The answer to whether energy is conserved.
fn verdict(report: &MeasurementReport) -> String {
    let greatest = &report.greatest_albedo;
    let (share, at) = (share_of(greatest), of_greatest(greatest, has_azimuth(report), report.is_grey()));
    let said = match (report.smallest.is_some(), above_one(greatest)) {
        (false, _) => return "unknown: there is no finite value".to_owned(),
        (true, None) if !report.is_mostly_finite => {
            return format!(
                "CANNOT BE TOLD: {} of all pairs of directions have no finite value",
                percent(report.part_not_finite)
            );
        }
        (true, None) if report.conserves_energy.is_none() => {
            let share = format!("{} ± {}", portion(greatest.share, 3), portion(greatest.error, 3));
            format!("CANNOT BE TOLD: about {share} of a beam of light is reflected ({at})")
        }
        (true, None) => {
            // Shares that are this near to 1 count as 1.
            let within = if greatest.share > 1.0 { " within 0.1 %" } else { "" };
            format!("conserved{within}: {} {share} of a beam of light is reflected ({at})", at_most(greatest))
        }
        (true, Some(above)) => format!("NOT conserved: {share} of the light at {at}; {above}"),
    };
    if report.not_finite.is_some() { format!("where values are finite, {said}") } else { said }
}

/// A share with how wrong it may be, if that is much.
fn share_of(greatest: &GreatestReport) -> String {
    let share = portion(greatest.share, 3);
    if is_certain(greatest) { share } else { format!("{share} ± {}", portion(greatest.error, 3)) }
}

fn is_certain(greatest: &GreatestReport) -> bool {
    greatest.error <= LARGE_ERROR * greatest.share.abs().max(1.0)
}

fn at_most(greatest: &GreatestReport) -> &'static str {
    if is_certain(greatest) { "at most" } else { "about" }
}

/// Where a share is above 1.
fn above_one(greatest: &GreatestReport) -> Option<String> {
    let (from, to) = (greatest.above_one_from?, greatest.above_one_to?);
    let only = if from > 89.0 { "only along the surface, " } else { "" };
    let until = if to < 89.0 { format!(" to {}", degrees(to)) } else { String::new() };
    Some(format!("{only}above 1 from {}{until}", degrees(from)))
}

/// What a viewer sees of a model that is not reciprocal.
fn furnace(report: &MeasurementReport) -> String {
    let greatest = &report.greatest_in_furnace;
    let (share, at) = (share_of(greatest), of_greatest(greatest, has_azimuth(report), report.is_grey()));
    match above_one(greatest) {
        None => format!("{} {share} is seen in a white furnace (at {at})", at_most(greatest)),
        Some(above) => format!("up to {share} is seen in a white furnace, at {at}; {above}"),
    }
}

/// Whether an azimuth is told beside an angle.
fn has_azimuth(report: &MeasurementReport) -> bool {
    report.depends_on_azimuth == Some(true)
}

/// Where the greatest share is.
fn of_greatest(greatest: &GreatestReport, has_azimuth: bool, is_grey: bool) -> String {
    let mut text = degrees(greatest.theta);
    if greatest.at_last_angle {
        text.push_str(", the last angle looked at");
    }
    // At the normal, there is no azimuth.
    if has_azimuth && greatest.theta > 0.05 {
        let _ = write!(text, ", azimuth {:.0}°", greatest.phi.round() % 360.0);
    }
    if !is_grey {
        let _ = write!(text, ", {}", greatest.component);
    }
    text
}

fn reciprocity(report: &MeasurementReport) -> String {
    match &report.reciprocity {
        None => "no finite value".to_owned(),
        Some(worst) if report.is_reciprocal == Some(true) => format!("reciprocal, to {}", percent(worst.error)),
        Some(_) if report.is_reciprocal.is_none() && !report.is_mostly_finite => "CANNOT BE TOLD".to_owned(),
        Some(_) if report.is_reciprocal.is_none() => {
            "CANNOT BE TOLD: pairs have the same values, and a beam and a furnace have other shares".to_owned()
        }
        Some(worst) => format!("NOT reciprocal: values differ by {} at {}", percent(worst.error), place(&worst.at)),
    }
}

fn place(pair: &PairReport) -> String {
    let of = |[polar, azimuth]: [f64; 2]| {
        let azimuth = if polar < 1e-3 { String::new() } else { format!("/{azimuth:.0}°") };
        format!("{}{azimuth}", degrees(polar))
    };
    format!("light {}, viewer {}", of(pair.light), of(pair.view))
}

/// What was found over the ranges of parameters.
fn over_ranges(ranges: &RangeReport) -> String {
    let RangeReport { parameters, settings, above_one, .. } = ranges;
    if parameters.is_empty() {
        return "\nno parameter has a range\n".to_owned();
    }
    let mut text = format!("\nover the ranges of {} ({settings} settings)\n", parameters.join(", "));
    let with = |values: &Option<String>| values.as_ref().map_or_else(String::new, |values| format!(", with {values}"));
    let mut fact = |name: &str, said: String| {
        let _ = writeln!(text, "  {name:<NAME_WIDTH$}{said}");
    };
    if let Some(greatest) = &ranges.greatest_albedo {
        let share = share_of(greatest);
        let most = format!("{share} of a beam at {}{}", degrees(greatest.theta), with(&ranges.greatest_with));
        fact(
            "energy",
            match above_one {
                0 if greatest.is_uncertain => format!("CANNOT BE TOLD; most: {most}"),
                0 if greatest.above_one_from.is_none() => format!("conserved by all; {} {most}", at_most(greatest)),
                count => format!("NOT conserved by {}; most: {most}", (*count).max(1)),
            },
        );
    }
    match ranges.smallest {
        Some(smallest) if smallest < 0.0 => {
            fact("smallest", format!("NEGATIVE: {}{}", number(smallest), with(&ranges.smallest_with)))
        }
        Some(smallest) => fact("smallest", format!("{}, no negative value found", number(smallest))),
        None => fact("smallest", "no finite value".to_owned()),
    }
    if ranges.not_finite_with.is_some() {
        fact("NOT FINITE", with(&ranges.not_finite_with).trim_start_matches([',', ' ']).to_owned());
    }
    text
}

/// The shares by angle.
fn shares(report: &MeasurementReport) -> String {
    let has_furnace = has_furnace(report);
    let components = if report.is_grey() { 1 } else { 3 };
    let mut lines = vec![vec!["angle".to_owned()]];
    for side in ["reflected", "in a furnace"].into_iter().take(if has_furnace { 2 } else { 1 }) {
        match components {
            1 => lines[0].push(side.to_owned()),
            _ => lines[0].extend(
                COMPONENTS.map(|name| if has_furnace && side != "reflected" { format!("f. {name}") } else { name.to_owned() }),
            ),
        }
    }
    let scale = |row: &AlbedoReport| row.beam.iter().chain(&row.furnace).copied().fold(1.0, f64::max);
    let has_errors = report.albedo.iter().any(|row| row.error > 1.5 * ACCURACY * scale(row));
    if has_errors {
        lines[0].push("±".to_owned());
    }
    let what = if has_furnace {
        "share of a beam that is reflected, by its angle; and what is seen in a white furnace (f.), by the viewer's angle"
    } else {
        "share of a beam that is reflected, by its angle (and what is seen in a white furnace, by the viewer's)"
    };
    let mut text = String::new();
    for rows in report.albedo.chunk_by(|one, other| one.phi == other.phi) {
        let mut lines = lines.clone();
        for row in rows {
            let furnace = row.furnace.iter().take(if has_furnace { components } else { 0 });
            let numbers = row.beam.iter().take(components).chain(furnace).map(|share| portion(*share, 4));
            let error = has_errors.then(|| portion(row.error, 4));
            lines.push(std::iter::once(format!("{}°", row.theta)).chain(numbers).chain(error).collect());
        }
        let heading = match (has_azimuth(report), text.is_empty(), rows[0].phi) {
            (false, ..) => what.to_owned(),
            (true, true, phi) => format!("{what}; at azimuth {phi:.0}°"),
            (true, false, phi) => format!("\nthe same at azimuth {phi:.0}°, where the share is greatest"),
        };
        let _ = write!(text, "{heading}\n{}", aligned(&lines));
    }
    text
}

/// The ranges of the expressions.
fn expressions(report: &MeasurementReport) -> String {
    let mut lines = vec![["expression", "least", "greatest"].map(str::to_owned).to_vec()];
    for expression in &report.expressions {
        let name: String = expression.name.chars().take(LONGEST_NAME).collect();
        let end = |number: Option<f64>| number.map_or_else(|| "-".to_owned(), self::number);
        let mut line = vec![name, end(expression.least), end(expression.greatest)];
        line.extend(odd(expression));
        lines.push(line);
    }
    format!("expressions over {} pairs of directions\n{}", report.pairs, aligned(&lines))
}

/// Where an expression is not finite.
fn odd(expression: &ExpressionReport) -> Option<String> {
    let told = |what: &str, count: usize, at: &Option<PairReport>| {
        at.as_ref().map(|pair| format!("{what} for {count}, as at {}", place(pair)))
    };
    let not_a_number = told("NaN", expression.not_numbers, &expression.not_a_number_at);
    let infinite = told("infinite", expression.infinite, &expression.infinite_at);
    let parts: Vec<String> = [not_a_number, infinite].into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// A number with a few digits.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{value:.3e}")
    }
}

/// Columns: the first one to the left, those with a heading to the right, and what follows as it is.
fn aligned(lines: &[Vec<String>]) -> String {
    let headings = lines.first().map_or(0, Vec::len);
    let longest = |column: usize| lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..headings).map(|column| longest(column).unwrap_or(0)).collect();
    let mut text = String::new();
    for line in lines {
        let mut shown = String::from("  ");
        for (column, cell) in line.iter().enumerate() {
            let width = widths.get(column).copied().unwrap_or(0);
            shown.push_str(&match column {
                0 => format!("{cell:<width$}"),
                _ => format!("  {cell:>width$}"),
            });
        }
        let _ = writeln!(text, "{}", shown.trim_end());
    }
    text
}
