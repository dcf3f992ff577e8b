//! The parts of the shader ball. Its unit is the radius of the ball; it stands on y = 0, around the y axis.

use crate::shaderball::lathe::{Corner, Model, arc, corner, lathe, profile};
use glam::{DMat3, DVec2, DVec3, dvec3};
use std::f64::consts::PI;

/// The height of the ball's centre.
const CENTRE: f64 = 1.512;
/// The radius of the hollow inside the ball.
const HOLLOW: f64 = 0.88;
/// The half angle of the opening, in degrees.
const OPENING: f64 = 40.0;
/// Where the opening looks.
const LOOKS: DVec3 = dvec3(0.52, 0.42, 0.74);
/// The radius of the socket: a little more than that of the ball.
const SOCKET: f64 = 1.01;

/// A part: the name of its file and its surface.
pub(super) fn parts() -> [(&'static str, Model); 5] {
    [
        ("shaderball-ball", tilted(ball())),
        ("shaderball-core", tilted(core())),
        ("shaderball-ring", ring()),
        ("shaderball-base", base()),
        ("backdrop", backdrop()),
    ]
}

/// Angles from one to another, in equal steps of at most `step`, and finer ones within each groove.
fn angles(from: f64, to: f64, step: f64, grooves: &[(f64, f64)]) -> Vec<f64> {
    let count = ((to - from).abs() / step).ceil() as usize;
    let even = (0..=count).map(|index| from + (to - from) * index as f64 / count as f64);
    let apart = |angle: &f64| grooves.iter().all(|(middle, half)| (angle - middle).abs() > half + step / 3.0);
    let mut all: Vec<f64> = even.filter(apart).collect();
    for (middle, half) in grooves {
        all.extend((-4..=4).map(|place| middle + half * f64::from(place) / 4.0));
    }
    all.sort_by(|one, other| if from < to { one.total_cmp(other) } else { other.total_cmp(one) });
    all
}

/// A smooth bump of height 1 around 0, which is 0 from -1 on down and from 1 on up.
fn bump(x: f64) -> f64 {
    (1.0 - x * x).max(0.0).powi(2)
}

/// How deep grooves are at an angle.
fn depth(angle: f64, grooves: &[(f64, f64)], deepest: f64) -> f64 {
    grooves.iter().map(|(middle, half)| deepest * bump((angle - middle) / half)).sum()
}

/// A thick shell with a round opening, whose lip is a half circle, and two grooves behind it.
fn ball() -> Model {
    let grooves = [(OPENING + 9.0, 1.7), (OPENING + 14.0, 1.7)];
    let mut corners = arc(&angles(180.0, OPENING, 4.0, &grooves), |angle| 1.0 - depth(angle, &grooves, 0.016));
    let (sine, cosine) = OPENING.to_radians().sin_cos();
    let outwards = DVec2::new(sine, cosine);
    let along = DVec2::new(-cosine, sine);
    let thickness = (1.0 - HOLLOW) / 2.0;
    corners.extend((1..8).map(|step| {
        let (sine, cosine) = (PI * f64::from(step) / 8.0).sin_cos();
        Corner { at: outwards * (1.0 - thickness + thickness * cosine) + along * (thickness * sine), radius: 0.0 }
    }));
    corners.extend(arc(&angles(OPENING, 180.0, 9.0, &[]), |_| HOLLOW));
    lathe(&profile(&corners, false), 88, |_, _| 1.0)
}

/// A ball on a stem, with three rings around the pole that the opening shows.
fn core() -> Model {
    let radius = 0.60;
    let grooves = [(24.0, 3.0), (44.0, 3.0), (64.0, 3.0)];
    let mut corners = vec![
        corner(0.0, -0.85, 0.0),
        corner(0.19, -0.85, 0.014),
        corner(0.19, -0.79, 0.014),
        corner(0.11, -0.75, 0.014),
        corner(0.11, -radius * 10.5_f64.to_radians().cos(), 0.008),
    ];
    let mut around = angles(166.0, 90.0, 9.5, &[]);
    around.extend(angles(84.0, 0.0, 6.0, &grooves));
    corners.extend(arc(&around, |angle| radius - depth(angle, &grooves, 0.013)));
    lathe(&profile(&corners, false), 56, |_, _| 1.0)
}

/// A collar around the neck of the base, with flutes outside.
fn ring() -> Model {
    let (inner, outer, low, high) = (0.428, 0.53, 0.292, 0.392);
    let corners = [corner(inner, low, 0.012), corner(outer, low, 0.022), corner(outer, high, 0.022), corner(inner, high, 0.012)];
    let points = profile(&corners, true);
    let flutes = |row: usize, angle: f64| {
        let weight = ((points[row].x - 0.47) / (outer - 0.47)).clamp(0.0, 1.0);
        1.0 - 0.032 * weight * (0.5 - 0.5 * (22.0 * angle).cos())
    };
    lathe(&points, 22 * 4, flutes)
}

/// A square foot with round corners, a neck, and a socket for the ball.
fn base() -> Model {
    let mut corners = vec![
        corner(0.0, 0.0, 0.0),
        corner(0.90, 0.0, 0.014),
        corner(0.90, 0.15, 0.05),
        corner(0.42, 0.20, 0.08),
        corner(0.42, 0.47, 0.05),
        corner(0.66, 0.59, 0.04),
        corner(0.66, 0.695, 0.03),
        corner(0.585, 0.695, 0.02),
    ];
    let socket = angles(147.0, 180.0, 8.3, &[]);
    corners.extend(arc(&socket, |_| SOCKET).into_iter().map(|part| corner(part.at.x, part.at.y + CENTRE, 0.0)));
    let points = profile(&corners, false);
    let square = |row: usize, angle: f64| {
        let DVec2 { x, y } = points[row];
        let weight = if y > 0.25 { 0.0 } else { ((x - 0.54) / 0.28).clamp(0.0, 1.0) };
        let weight = if y == 0.0 { 1.0 } else { weight * weight * (3.0 - 2.0 * weight) };
        let (sine, cosine) = angle.sin_cos();
        let power = 5.0;
        let factor = (sine.abs().powf(power) + cosine.abs().powf(power)).powf(-1.0 / power);
        1.0 + weight * (factor - 1.0)
    };
    lathe(&points, 76, square)
}

/// Turns the axis of a part to where the opening looks, around the centre of the ball.
fn tilted(part: Model) -> Model {
    let up = LOOKS.normalize();
    let right = DVec3::Y.cross(up).normalize();
    let turn = DMat3::from_cols(right, up, right.cross(up));
    part.mapped(|position| turn * position + DVec3::Y * CENTRE)
}

/// A floor that bends up to a wall: an open sheet.
fn backdrop() -> Model {
    let (near, back, bend, top, half) = (9.0, -5.0, 3.5, 12.0, 14.0);
    let mut points = vec![DVec2::new(near, 0.0), DVec2::new(back + bend + 0.2, 0.0)];
    points.extend((0..=24).map(|step| {
        let (sine, cosine) = (PI / 2.0 * f64::from(step) / 24.0).sin_cos();
        DVec2::new(back + bend - bend * sine, bend - bend * cosine)
    }));
    points.extend([DVec2::new(back, bend + 0.2), DVec2::new(back, top)]);
    let length: f64 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    let mut model = Model::default();
    let mut along = 0.0;
    for (row, point) in points.iter().enumerate() {
        along += if row == 0 { 0.0 } else { points[row - 1].distance(*point) };
        for (x, u) in [(-half, 0.0), (half, 1.0)] {
            model.vertices.push((dvec3(x, point.y, point.x), [u, (along / length).min(1.0)]));
        }
    }
    model.strips.push((0..points.len() as u16).flat_map(|row| [2 * row, 2 * row + 1]).collect());
    model
}
