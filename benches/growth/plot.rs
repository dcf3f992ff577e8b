//! Draws the measurements: a panel for each thing that grows, with logarithmic axes.

use crate::{SERIES, Sweep};
use std::fmt::Write;

const WIDTH: f64 = 900.0;
const COLUMNS: usize = 3;
/// The lengths of the axes of a panel.
const AXES: [f64; 2] = [234.0, 212.0];
const FIRST: [f64; 2] = [52.0, 36.0];
const STEP: [f64; 2] = [294.0, 292.0];
/// The height of the legend, below the panels, and the length of an entry.
const LEGEND_HEIGHT: f64 = 72.0;
const ENTRY: f64 = 178.0;
/// The margin at each end of a horizontal axis, as a part of its length.
const AIR: f64 = 0.06;
const COLOURS: [&str; SERIES.len()] = ["#0b5fa5", "#c2410c", "#5b7a00", "#8b2fa0"];

/// A logarithmic scale from numbers to positions.
struct Scale {
    from: f64,
    to: f64,
    length: f64,
}

impl Scale {
    fn at(&self, value: f64) -> f64 {
        (value.log10() - self.from) / (self.to - self.from) * self.length
    }
}

/// Draws a panel for each sweep.
pub(crate) fn svg(sweeps: &[Sweep]) -> String {
    let costs =
        || sweeps.iter().flat_map(|sweep| sweep.points.iter()).flat_map(|(_, cost)| SERIES.iter().map(|own| (own.of)(cost)));
    let lowest = costs().fold(f64::INFINITY, f64::min).log10().floor();
    let highest = costs().fold(0.0, f64::max).log10() + 0.2;
    let rows = sweeps.len().div_ceil(COLUMNS) as f64;
    let height = FIRST[1] + STEP[1] * rows + LEGEND_HEIGHT;
    let up = Scale { from: lowest, to: highest, length: AXES[1] };
    let mut text = format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}" font-family="Helvetica, Arial, sans-serif" font-size="12" fill="#222">
<title>How the cost of each stage grows</title>
<rect width="{WIDTH}" height="{height}" fill="white"/>
"##
    );
    for (index, sweep) in sweeps.iter().enumerate() {
        panel(&mut text, index, sweep, &up);
    }
    legend(&mut text, FIRST[1] + STEP[1] * rows);
    text + "</svg>\n"
}

/// The upper left corner of the axes of a panel.
fn corner(index: usize) -> [f64; 2] {
    [FIRST[0] + STEP[0] * (index % COLUMNS) as f64, FIRST[1] + STEP[1] * (index / COLUMNS) as f64]
}

fn line(text: &mut String, line: std::fmt::Arguments) {
    writeln!(text, "{line}").expect("writing to a string does not fail");
}

fn panel(text: &mut String, index: usize, sweep: &Sweep, up: &Scale) {
    let [x, y] = corner(index);
    let [width, height] = AXES;
    let amounts = || sweep.points.iter().map(|(amount, _)| amount.log10());
    let (least, most) = (amounts().fold(f64::INFINITY, f64::min), amounts().fold(f64::NEG_INFINITY, f64::max));
    let air = AIR * (most - least);
    let along = Scale { from: least - air, to: most + air, length: width };
    line(text, format_args!(r#"<g transform="translate({x} {y})">"#));
    let clip = format!("axes{index}");
    line(text, format_args!(r#"<clipPath id="{clip}"><rect width="{width}" height="{height}"/></clipPath>"#));
    line(text, format_args!(r#"<text x="0" y="-12" font-size="14" font-weight="bold">{}</text>"#, sweep.label));

    for decade in up.from as i32..=up.to.floor() as i32 {
        let value = 10f64.powi(decade);
        let down = height - up.at(value);
        line(text, format_args!(r##"<path d="M0 {down:.1}H{width}" stroke="#e4e4e4"/>"##));
        line(text, format_args!(r#"<text x="-7" y="{:.1}" text-anchor="end">{value}</text>"#, down + 4.0));
    }
    line(text, format_args!(r#"<text x="-7" y="-12" text-anchor="end" font-style="italic">ms</text>"#));
    for (value, label) in sweep.ticks.iter().filter(|(value, _)| (along.from..=along.to).contains(&value.log10())) {
        let right = along.at(*value);
        line(text, format_args!(r##"<path d="M{right:.1} {height}v5" stroke="#666"/>"##));
        line(text, format_args!(r#"<text x="{right:.1}" y="{}" text-anchor="middle">{label}</text>"#, height + 19.0));
    }
    // Linear growth is parallel to these lines.
    line(text, format_args!(r##"<g clip-path="url(#{clip})" stroke="#aaa" stroke-dasharray="4 4">"##));
    let decades = along.to - along.from;
    for decade in (up.from - decades).floor() as i32..up.to.ceil() as i32 {
        let [left, right] = [0.0, decades].map(|more| height - up.at(10f64.powf(f64::from(decade) + more)));
        line(text, format_args!(r#"<path d="M0 {left:.1}L{width} {right:.1}"/>"#));
    }
    line(text, format_args!("</g>"));
    line(text, format_args!(r##"<rect width="{width}" height="{height}" fill="none" stroke="#666"/>"##));
    for (series, colour) in SERIES.iter().zip(COLOURS) {
        let points: Vec<[f64; 2]> =
            sweep.points.iter().map(|(amount, cost)| [along.at(*amount), height - up.at((series.of)(cost))]).collect();
        let path: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        line(text, format_args!(r#"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="2"/>"#, path.join(" ")));
        for [x, y] in points {
            line(text, format_args!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="3" fill="{colour}"/>"#));
        }
    }
    line(text, format_args!("</g>"));
}

fn legend(text: &mut String, top: f64) {
    line(text, format_args!(r#"<g transform="translate({} {top})">"#, FIRST[0]));
    for (index, (series, colour)) in SERIES.iter().zip(COLOURS).enumerate() {
        let left = ENTRY * index as f64;
        line(text, format_args!(r#"<path d="M{left} 0h34" stroke="{colour}" stroke-width="2"/>"#));
        line(text, format_args!(r#"<circle cx="{}" cy="0" r="3" fill="{colour}"/>"#, left + 17.0));
        line(text, format_args!(r#"<text x="{}" y="4">{}</text>"#, left + 42.0, series.name));
    }
    let left = ENTRY * SERIES.len() as f64;
    line(text, format_args!(r##"<path d="M{left} 0h34" stroke="#aaa" stroke-dasharray="4 4"/>"##));
    line(text, format_args!(r#"<text x="{}" y="4">linear growth</text>"#, left + 42.0));
    let typical = crate::Workload::TYPICAL;
    let [[width, height], [small_width, small_height]] = [typical.size, crate::SMALL];
    let caption = [
        "Milliseconds on one thread, the best of several rounds. What does not grow in a panel:".to_owned(),
        format!(
            "{width}×{height} pixels ({small_width}×{small_height} for sines), {} lights, {} spheres over a floor, depth {}, a formula of \
             {} highlight.",
            typical.lights,
            typical.spheres_a_side * typical.spheres_a_side,
            typical.depth,
            typical.terms
        ),
    ];
    for (words, row) in caption.iter().zip([32.0, 50.0]) {
        line(text, format_args!(r##"<text x="0" y="{row}" fill="#555">{words}</text>"##));
    }
    line(text, format_args!("</g>"));
}
