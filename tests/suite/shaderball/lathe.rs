//! Surfaces turned on a lathe: a profile goes around an axis. Corners of the profile are rounded.

use glam::{DVec2, DVec3, dvec2, dvec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The distance of an additional loop of vertices from the end of a rounded corner. Such loops keep normals on flat
/// parts perpendicular to them.
const SUPPORT: f64 = 0.012;
/// Corners rounded by less have larger facets.
const SMALL: f64 = 0.015;

/// A corner of a profile: the distance from the axis, the height, and the radius with which it is rounded. A radius
/// of 0 keeps the point as it is.
pub(super) struct Corner {
    pub(super) at: DVec2,
    pub(super) radius: f64,
}

pub(super) fn corner(distance: f64, height: f64, radius: f64) -> Corner {
    Corner { at: dvec2(distance, height), radius }
}

/// Points on an arc of which `radius` gives the distance from the origin at each angle. The angle is measured from the
/// axis, in degrees, and `angles` has no two equal neighbours.
pub(super) fn arc(angles: &[f64], radius: impl Fn(f64) -> f64) -> Vec<Corner> {
    let point = |angle: &f64| {
        let (sine, cosine) = angle.to_radians().sin_cos();
        // Exactly on the axis, so that the surface is closed there.
        let sine = if *angle == 0.0 || *angle == 180.0 { 0.0 } else { sine };
        Corner { at: radius(*angle) * dvec2(sine, cosine), radius: 0.0 }
    };
    angles.iter().map(point).collect()
}

/// The points of a profile, with rounded corners. The outside is on its right. A `ring` ends where it begins.
pub(super) fn profile(corners: &[Corner], ring: bool) -> Vec<DVec2> {
    let count = corners.len();
    let mut points: Vec<DVec2> = Vec::new();
    for (index, Corner { at, radius }) in corners.iter().enumerate() {
        let at_end = !ring && (index == 0 || index == count - 1);
        if at_end || *radius == 0.0 {
            points.push(*at);
            continue;
        }
        let last = (corners[(index + count - 1) % count].at - *at).normalize();
        let next = (corners[(index + 1) % count].at - *at).normalize();
        let half = last.angle_to(next).abs() / 2.0;
        let reach = radius / half.tan();
        let centre = *at + (last + next).normalize() * (radius / half.sin());
        let (start, end) = (*at + last * reach, *at + next * reach);
        let turn = if *radius < SMALL { FRAC_PI_2 / 2.0 } else { FRAC_PI_2 / 4.0 };
        let steps = ((PI - 2.0 * half) / turn).ceil().max(1.0) as usize;
        let angle = (start - centre).angle_to(end - centre);
        points.push(start + last * SUPPORT);
        for step in 0..=steps {
            let turn = DVec2::from_angle(angle * step as f64 / steps as f64);
            points.push(centre + turn.rotate(start - centre));
        }
        points.push(end + next * SUPPORT);
    }
    if ring {
        points.push(points[0]);
    }
    points
}

/// A mesh of strips of triangles, whose first triangles are counter-clockwise seen from the front.
#[derive(Default)]
pub(super) struct Model {
    pub(super) vertices: Vec<(DVec3, [f64; 2])>,
    pub(super) strips: Vec<Vec<u16>>,
}

/// Turns a profile around the y axis. `shape` multiplies the distance from the axis by the row and the angle, which
/// goes from +z to +x. The coordinate u goes around, and v along the profile by its length.
pub(super) fn lathe(points: &[DVec2], columns: usize, shape: impl Fn(usize, f64) -> f64) -> Model {
    let mut model = Model::default();
    let lengths = points.windows(2).map(|pair| pair[0].distance(pair[1]));
    let whole: f64 = lengths.clone().sum();
    let mut length = 0.0;
    let steps = lengths.chain([0.0]);
    for ((row, point), step) in points.iter().enumerate().zip(steps) {
        for column in 0..=columns {
            // The last column lies exactly on the first, and so does the last row of a ring.
            let angle = TAU * (column % columns) as f64 / columns as f64;
            let row = if row == points.len() - 1 && points[0] == *point { 0 } else { row };
            let distance = point.x * shape(row, angle);
            // The coordinate of a pole is in the middle of its triangle.
            let shift = if point.x == 0.0 { 0.5 } else { 0.0 };
            let u = ((column as f64 + shift) / columns as f64).min(1.0);
            let position = dvec3(distance * angle.sin(), point.y, distance * angle.cos());
            model.vertices.push((position, [u, (length / whole).min(1.0)]));
        }
        length += step;
    }
    let at = |row: usize, column: usize| (row * (columns + 1) + column) as u16;
    for (row, pair) in points.windows(2).enumerate() {
        if pair[0].x == 0.0 {
            model.strips.extend((0..columns).map(|column| vec![at(row, column), at(row + 1, column + 1), at(row + 1, column)]));
        } else if pair[1].x == 0.0 {
            model.strips.extend((0..columns).map(|column| vec![at(row, column), at(row, column + 1), at(row + 1, column)]));
        } else {
            model.strips.push((0..=columns).flat_map(|column| [at(row + 1, column), at(row, column)]).collect());
        }
    }
    model
}

impl Model {
    /// Maps all positions.
    pub(super) fn mapped(mut self, map: impl Fn(DVec3) -> DVec3) -> Self {
        self.vertices.iter_mut().for_each(|(position, _)| *position = map(*position));
        self
    }

    /// A binary PLY file. Strips take half as much as faces.
    pub(super) fn ply(&self) -> Vec<u8> {
        // -1 parts strips.
        let indices: Vec<i16> = self.strips.join(&u16::MAX).into_iter().map(|index| index as i16).collect();
        let mut bytes = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             property float u\nproperty float v\nelement tristrips 1\nproperty list int short vertex_indices\nend_header\n",
            self.vertices.len(),
        )
        .into_bytes();
        for (position, uv) in &self.vertices {
            let numbers = position.to_array().into_iter().chain(*uv);
            bytes.extend(numbers.flat_map(|number| (number as f32).to_le_bytes()));
        }
        bytes.extend((indices.len() as i32).to_le_bytes());
        bytes.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
        bytes
    }
}
