//! Pictures of bodies made of triangles, seen from afar: a buffer of depths, and light from beside the viewer.

use crate::picture::Bitmap;
use crate::plot::colours::mixed;
use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

/// Pixels of the buffer for each pixel of the picture, along each side, if it is not too large then.
const FINENESS: u32 = 2;
/// The most pixels of the buffer, if one for each pixel of the picture is not more.
const MOST_PIXELS: u64 = 40_000_000;
/// Bytes for each pixel of the buffer: a depth and a colour.
const PIXEL_BYTES: u64 = 7;

/// Pixels of the buffer for each pixel of a picture of this size, along each side. A draft has one.
fn fineness([width, height]: [u32; 2], is_draft: bool) -> u32 {
    if is_draft {
        return 1;
    }
    let fits = |fineness: &u32| u64::from(width) * u64::from(height) * u64::from(fineness * fineness) <= MOST_PIXELS;
    (2..=FINENESS).rev().find(fits).unwrap_or(1)
}

/// The most memory that the buffer of a picture of at most this many pixels takes, in bytes.
pub(super) fn buffer_memory(pixels: u64) -> u64 {
    (pixels * u64::from(FINENESS * FINENESS)).min(MOST_PIXELS.max(pixels)) * PIXEL_BYTES
}

/// A corner of a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct SolidCorner {
    pub(super) at: DVec3,
    /// The normal there, of unit length.
    pub(super) normal: DVec3,
    /// Two numbers for lines on the surface: they are drawn where one of them is whole.
    pub(super) ruling: DVec2,
}

/// A picture in work.
pub(super) struct SolidPicture {
    fineness: u32,
    size: [u32; 2],
    /// To the coordinates of the viewer: right, up, and towards the viewer.
    turn: DMat3,
    /// The middle of the picture in coordinates of the viewer, and pixels of the buffer for each unit.
    middle: DVec2,
    scale: f64,
    depths: Vec<f32>,
    colours: Vec<[u8; 3]>,
    /// Triangles that are not drawn yet.
    waiting: Vec<SeenTriangle>,
}

/// A triangle in coordinates of the buffer: column, row, depth.
struct SeenTriangle {
    at: [DVec3; 3],
    corners: [SolidCorner; 3],
    colour: [u8; 3],
    /// Twice its area, with a sign.
    area: f64,
    /// How fast the ruling numbers change from pixel to pixel.
    speed: DVec2,
}

/// The rows of the buffer that are drawn together.
const BAND: usize = 32;

/// The turn to the coordinates of a viewer who stands at an azimuth, in degrees from +x to +y, and an elevation above
/// the plane z = 0.
pub(super) fn turned(azimuth: f64, elevation: f64) -> DMat3 {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    let towards = DVec3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin());
    let right = DVec3::new(-azimuth.sin(), azimuth.cos(), 0.0);
    DMat3::from_cols(right, towards.cross(right), towards).transpose()
}

/// The whole numbers within the range of three coordinates, cut at both ends.
fn span([one, two, three]: [f64; 3], [low, high]: [usize; 2]) -> std::ops::Range<usize> {
    let [least, most] = [low as f64, high as f64];
    let start = one.min(two).min(three).floor().clamp(least, most);
    start as usize..one.max(two).max(three).ceil().clamp(least, most) as usize
}

impl SeenTriangle {
    /// Draws the part that is in some rows of the buffer, of which the first one is given.
    fn draw(&self, turn: DMat3, [first, columns]: [usize; 2], depths: &mut [f32], colours: &mut [[u8; 3]]) {
        let [a, b, c] = self.at;
        for row in span([a.y, b.y, c.y], [first, first + depths.len() / columns]) {
            for column in span([a.x, b.x, c.x], [0, columns]) {
                let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                let weight = |from: DVec3, to: DVec3| (to - from).truncate().perp_dot(at - from.truncate()) / self.area;
                let (of_a, of_b, of_c) = (weight(b, c), weight(c, a), weight(a, b));
                if of_a < 0.0 || of_b < 0.0 || of_c < 0.0 {
                    continue;
                }
                let depth = (of_a * a.z + of_b * b.z + of_c * c.z) as f32;
                // Much of a lobe is behind other parts of it, and need not be shaded.
                let index = (row - first) * columns + column;
                if depth > depths[index] {
                    let [one, two, three] = &self.corners;
                    let normal = of_a * one.normal + of_b * two.normal + of_c * three.normal;
                    let ruling = of_a * one.ruling + of_b * two.ruling + of_c * three.ruling;
                    let shade = shaded(turn * normal.try_normalize().unwrap_or(DVec3::Z), self.colour);
                    (depths[index], colours[index]) = (depth, ruled(shade, ruling, self.speed));
                }
            }
        }
    }
}

/// The light on a surface, whose normal is in coordinates of the viewer: from the left above the viewer, and a little
/// from everywhere.
fn shaded(normal: DVec3, colour: [u8; 3]) -> [u8; 3] {
    let normal = if normal.z < 0.0 { -normal } else { normal };
    let light = DVec3::new(-0.45, 0.65, 0.62).normalize();
    let lit = normal.dot(light).max(0.0);
    let dark = mixed(colour, [0; 3], 0.55 * (1.0 - lit));
    let shine = (2.0 * normal.dot(light) * normal.z - light.z).max(0.0).powi(24);
    mixed(dark, [255; 3], 0.35 * shine + 0.1 * lit)
}

impl SolidPicture {
    /// An empty picture of `size` pixels, in which these points have room. A draft has no smooth edges.
    pub(super) fn new((size, is_draft): ([u32; 2], bool), turn: DMat3, points: &[DVec3], paper: [u8; 3]) -> Self {
        let fineness = fineness(size, is_draft);
        let size = size.map(|side| side * fineness);
        let count = size[0] as usize * size[1] as usize;
        let seen = points.iter().map(|point| (turn * *point).truncate());
        let bounds = |(low, high): (DVec2, DVec2), at: DVec2| (low.min(at), high.max(at));
        let (low, high) = seen.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), bounds);
        let room = (high - low).max(DVec2::splat(1e-3));
        let room = if room.is_finite() { room * 1.04 } else { DVec2::ONE };
        let scale = (f64::from(size[0]) / room.x).min(f64::from(size[1]) / room.y);
        let middle = if low.is_finite() { 0.5 * (low + high) } else { DVec2::ZERO };
        Self {
            fineness,
            size,
            turn,
            middle,
            scale,
            depths: vec![f32::NEG_INFINITY; count],
            colours: vec![paper; count],
            waiting: Vec::new(),
        }
    }

    /// A point of the world as column, row and depth in the buffer.
    fn seen(&self, at: DVec3) -> DVec3 {
        let seen = self.turn * at;
        let [width, height] = self.size.map(|side| 0.5 * f64::from(side));
        DVec3::new(width + (seen.x - self.middle.x) * self.scale, height - (seen.y - self.middle.y) * self.scale, seen.z)
    }

    /// Where a point of the world is on the picture, as parts of its width and height.
    pub(super) fn share(&self, at: DVec3) -> [f64; 2] {
        let seen = self.seen(at);
        [seen.x / f64::from(self.size[0]), seen.y / f64::from(self.size[1])]
    }

    /// Draws a triangle. Where a ruling number is whole, its line is darker.
    pub(super) fn triangle(&mut self, corners: [SolidCorner; 3], colour: [u8; 3]) {
        let at = corners.map(|corner| self.seen(corner.at));
        let [a, b, c] = at;
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        if area == 0.0 || !area.is_finite() {
            return;
        }
        // How fast the ruling numbers change from pixel to pixel, so that all lines are as wide.
        let (r, s, t) = (corners[0].ruling, corners[1].ruling, corners[2].ruling);
        let (along, down) = ((b - a).truncate(), (c - a).truncate());
        let slope_x = ((s - r) * down.y - (t - r) * along.y) / area;
        let slope_y = ((t - r) * along.x - (s - r) * down.x) / area;
        let speed = (slope_x * slope_x + slope_y * slope_y).map(f64::sqrt);
        self.waiting.push(SeenTriangle { at, corners, colour, area, speed });
    }

    /// Draws the triangles that wait, in their order, some rows on each thread.
    fn draw_waiting(&mut self) {
        let triangles = std::mem::take(&mut self.waiting);
        let columns = (self.size[0] as usize).max(1);
        let turn = self.turn;
        let bands = self.depths.par_chunks_mut(BAND * columns).zip(self.colours.par_chunks_mut(BAND * columns));
        bands.enumerate().for_each(|(band, (depths, colours))| {
            for triangle in &triangles {
                triangle.draw(turn, [BAND * band, columns], depths, colours);
            }
        });
    }

    /// Draws the plane z = 0 within a circle of a radius. `colour` is given the place on it, and how far apart places
    /// of neighbouring pixels are.
    pub(super) fn plane(&mut self, radius: f64, colour: impl Fn(DVec2, f64) -> [u8; 3] + Sync) {
        self.draw_waiting();
        let back = self.turn.transpose();
        let towards = back * DVec3::Z;
        if towards.z.abs() < 1e-3 {
            return;
        }
        let [width, height] = self.size.map(|side| 0.5 * f64::from(side));
        let (scale, middle, columns) = (self.scale, self.middle, (self.size[0] as usize).max(1));
        let rows = self.depths.par_chunks_mut(columns).zip(self.colours.par_chunks_mut(columns)).enumerate();
        rows.for_each(|(row, (depths, colours))| {
            let y = (height - row as f64 - 0.5) / scale + middle.y;
            for (column, (nearest, target)) in depths.iter_mut().zip(colours).enumerate() {
                let x = (column as f64 + 0.5 - width) / scale + middle.x;
                let from = back * DVec3::new(x, y, 0.0);
                let depth = -from.z / towards.z;
                let place = (from + depth * towards).truncate();
                if depth as f32 > *nearest && place.length_squared() <= radius * radius {
                    (*nearest, *target) = (depth as f32, colour(place, 1.0 / scale));
                }
            }
        });
    }

    /// Draws a round rod from one point to another, which may become thinner.
    pub(super) fn rod(&mut self, [from, to]: [DVec3; 2], [first, last]: [f64; 2], colour: [u8; 3]) {
        const SIDES: u32 = 16;
        let Some(along) = (to - from).try_normalize() else { return };
        let (one, other) = along.any_orthonormal_pair();
        let corner = |side: u32, end: DVec3, radius: f64| {
            let (sine, cosine) = (f64::from(side) / f64::from(SIDES) * std::f64::consts::TAU).sin_cos();
            let normal = one * cosine + other * sine;
            SolidCorner { at: end + radius * normal, normal, ruling: DVec2::splat(0.5) }
        };
        for side in 0..SIDES {
            let [a, b] = [side, side + 1].map(|side| corner(side, from, first));
            let [c, d] = [side, side + 1].map(|side| corner(side, to, last));
            self.triangle([a, b, d], colour);
            self.triangle([a, d, c], colour);
            let flat = |corner: SolidCorner| SolidCorner { normal: -along, ..corner };
            self.triangle([flat(a), flat(b), SolidCorner { at: from, ..flat(a) }], colour);
        }
    }

    /// The picture.
    pub(super) fn bitmap(&mut self) -> Bitmap {
        self.draw_waiting();
        let fineness = self.fineness;
        let size = self.size.map(|side| side / fineness);
        let mut bytes = Vec::with_capacity(3 * size[0] as usize * size[1] as usize);
        for row in 0..size[1] {
            for column in 0..size[0] {
                let mut sums = [0_u32; 3];
                for within in 0..fineness * fineness {
                    let (x, y) = (column * fineness + within % fineness, row * fineness + within / fineness);
                    let colour = self.colours[y as usize * self.size[0] as usize + x as usize];
                    sums.iter_mut().zip(colour).for_each(|(sum, component)| *sum += u32::from(component));
                }
                let count = fineness * fineness;
                // A mean of bytes is one.
                bytes.extend(sums.map(|sum| ((sum + count / 2) / count) as u8));
            }
        }
        Bitmap::of_bytes(size, bytes)
    }
}

/// A colour, darker on the lines of a ruling. Lines that are too close to each other fade.
fn ruled(colour: [u8; 3], ruling: DVec2, speed: DVec2) -> [u8; 3] {
    let line = |number: f64, speed: f64| {
        let distance = (number - number.round()).abs() / speed.max(1e-12);
        let close = (1.0 - 8.0 * speed).clamp(0.0, 1.0);
        (1.0 - (distance - 0.9).clamp(0.0, 1.0)) * close
    };
    mixed(colour, [0; 3], 0.3 * line(ruling.x, speed.x).max(line(ruling.y, speed.y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_in_front_is_seen() {
        // From above: x is to the right if the viewer stands at azimuth −90.
        let turn = turned(-90.0, 90.0);
        assert!((turn * DVec3::X).abs_diff_eq(DVec3::X, 1e-12) && (turn * DVec3::Z).abs_diff_eq(DVec3::Z, 1e-12));
        let mut picture =
            SolidPicture::new(([10, 10], false), turn, &[DVec3::splat(1.0 / 1.04), DVec3::splat(-1.0 / 1.04)], [255; 3]);
        let corner =
            |x: f64, y: f64, z: f64| SolidCorner { at: DVec3::new(x, y, z), normal: DVec3::Z, ruling: DVec2::splat(0.5) };
        picture.triangle([corner(-1.0, -1.0, 0.5), corner(1.0, -1.0, 0.5), corner(-1.0, 1.0, 0.5)], [200, 0, 0]);
        picture.plane(10.0, |_, _| [0, 0, 200]);
        let bitmap = picture.bitmap();
        let at = |column: usize, row: usize| &bitmap.bytes()[3 * (10 * row + column)..][..3];
        assert_eq!(at(9, 0), [0, 0, 200]);
        assert!(at(0, 9)[0] > 100 && at(0, 9)[2] < 100, "{:?}", at(0, 9));
        assert!(picture.share(DVec3::new(1.0, 1.0, 0.0)).iter().zip([1.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
