//! Maps of radiance over the sphere of directions: looking radiance up, and drawing directions.

use crate::environment::cells::CellWeights;
use crate::environment::latitude_longitude::{MapPlace, direction, zone};
use crate::environment::texels::{MapRepairs, Texels};
use glam::DVec3;
use std::f64::consts::PI;
use std::ops::Range;

/// The largest width and height of a map, in texels.
pub const MAX_MAP_SIDE: u32 = 16_384;

/// The most cells that directions are drawn by. Larger maps have cells of several texels.
const MOST_CELLS: u64 = 1 << 23;

/// How much of the luminance of linear RGB each component is (Recommendation ITU-R BT.709-6, item 3.2).
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// The weight that a texel gives to its own cell and to each neighbour, along each axis.
///
/// The light of a texel reaches half way into the neighbouring cells, because radiance is interpolated. An even density
/// in each cell has the least variance if it is in proportion to the root of the mean square of the light in the cell.
/// For one bright texel, the mean square is ∫(1 − |x|)² dx: 7/12 in its own cell, and 1/24 in each neighbour. So the
/// weights are as √(7/12) to √(1/24), with the sum 1. (By the mean, 3/4 and 1/8, a corner beside a bright texel would
/// be twice as bright in relation to its density.)
const OWN: f64 = 0.652;
const NEIGHBOUR: f64 = 0.174;

/// Where light comes from, and how much: a map of linear RGB radiance in latitude-longitude form, or white.
///
/// Row 0 is at the zenith, +y; the middle of the map is +z, and +x is a quarter of its width left of the middle. This
/// is the convention of OpenEXR (`ENVMAP_LATLONG`) and of Mitsuba's `envmap`.
#[derive(Debug, PartialEq)]
pub struct RadianceMap {
    /// `None`: white.
    texels: Option<TexelMap>,
}

/// The texels of a map, and the cells that directions are drawn by.
#[derive(Debug, PartialEq)]
struct TexelMap {
    texels: Texels,
    /// The side of a cell, in texels. Cells at the right and lower edges may be smaller.
    side: usize,
    cells: CellWeights,
}

/// A direction that was drawn, with the light that comes from there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadianceSample {
    /// The direction, of unit length.
    pub direction: DVec3,
    /// The radiance, linear RGB.
    pub radiance: [f32; 3],
    /// How densely directions are drawn there, per steradian; greater than 0.
    pub density: f64,
}

impl RadianceMap {
    /// Radiance 1 from all directions.
    pub const WHITE: RadianceMap = RadianceMap { texels: None };

    /// A map of this many texels. `row` writes a row, counted from the top, from the left; rows are asked for on
    /// several threads. `None` if a side is 0 or greater than [`MAX_MAP_SIDE`].
    pub fn of_rows(width: u32, height: u32, row: impl Fn(u32, &mut [[f32; 3]]) + Sync) -> Option<(Self, MapRepairs)> {
        let sides = 1..=MAX_MAP_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            return None;
        }
        let (texels, repairs) = Texels::of_rows(width as usize, height as usize, row);
        Some((Self { texels: Some(TexelMap::new(texels)) }, repairs))
    }

    /// The bytes that a map of this many texels takes.
    pub fn memory_of(width: u32, height: u32) -> u64 {
        let (width, height) = (width as usize, height as usize);
        let side = cell_side(width, height);
        Texels::memory_of(width, height) + CellWeights::memory_of(width.div_ceil(side), height.div_ceil(side))
    }

    /// The bytes that it takes.
    pub fn memory(&self) -> u64 {
        self.texels.as_ref().map_or(0, |map| map.texels.memory() + map.cells.memory())
    }

    /// Width and height in texels; `None` for white.
    pub fn size(&self) -> Option<[u32; 2]> {
        self.texels.as_ref().map(|map| [map.texels.width, map.texels.height].map(|side| side as u32))
    }

    /// The radiance from a direction of any length greater than 0, linear RGB. Between the middles of texels it is
    /// interpolated, also across the left and the right edge. Above the middles of the first row and below those of the
    /// last it is that of the row.
    pub fn radiance(&self, direction: DVec3) -> [f32; 3] {
        self.texels.as_ref().map_or([1.0; 3], |map| map.texels.at(MapPlace::of(direction)).to_array())
    }

    /// Draws a direction by a point of the unit square: the more light comes from a direction, the more densely.
    /// Directions that light comes from are never left out. `None` if no light comes from anywhere.
    ///
    /// A cell of the map, which is a texel unless the map has more than 8 million, is drawn by its luminance and that
    /// of its neighbours, times its solid angle, and a direction in it evenly. Points that are spread evenly lead to
    /// directions that are.
    pub fn sample(&self, point: [f64; 2]) -> Option<RadianceSample> {
        match &self.texels {
            Some(map) => map.sample(point),
            None => {
                let cosine = 1.0 - 2.0 * point[1];
                let direction = direction(point[0], [sine_of(cosine), cosine]);
                Some(RadianceSample { direction, radiance: [1.0; 3], density: 0.25 / PI })
            }
        }
    }
}

/// The side of cells, in texels, so that there are not too many of them.
fn cell_side(width: usize, height: usize) -> usize {
    let fits = |side: &usize| (width.div_ceil(*side) as u64 * height.div_ceil(*side) as u64) <= MOST_CELLS;
    (1..).find(fits).unwrap_or(1)
}

/// The sine of a polar angle by its cosine.
fn sine_of(cosine: f64) -> f64 {
    ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt()
}

impl TexelMap {
    fn new(texels: Texels) -> Self {
        let side = cell_side(texels.width, texels.height);
        let (columns, rows) = (texels.width.div_ceil(side), texels.height.div_ceil(side));
        let cells = CellWeights::of_rows(columns, rows, |row, weights| weigh(&texels, side, row, weights));
        Self { texels, side, cells }
    }

    /// The rows of texels of a row of cells.
    fn rows(&self, row: usize) -> Range<usize> {
        part(row, self.side, self.texels.height)
    }

    /// The columns of texels of a column of cells.
    fn columns(&self, column: usize) -> Range<usize> {
        part(column, self.side, self.texels.width)
    }

    /// The solid angle of a cell.
    fn solid_angle(&self, column: usize, row: usize) -> f64 {
        zone_of(self.rows(row), self.texels.height) * self.columns(column).len() as f64 / self.texels.width as f64
    }

    fn sample(&self, point: [f64; 2]) -> Option<RadianceSample> {
        let drawn = self.cells.draw(point)?;
        let [across, down] = drawn.within;
        let (rows, columns) = (self.rows(drawn.row), self.columns(drawn.column));
        let u = (columns.start as f64 + across * columns.len() as f64) / self.texels.width as f64;
        let [above, below] = [rows.start, rows.end].map(|edge| (PI * edge as f64 / self.texels.height as f64).cos());
        let cosine = above + (below - above) * down;
        let sine = sine_of(cosine);
        let radiance = self.texels.at(MapPlace { u, v: sine.atan2(cosine) / PI }).to_array();
        let density = drawn.probability / self.solid_angle(drawn.column, drawn.row);
        Some(RadianceSample { direction: direction(u, [sine, cosine]), radiance, density })
    }
}

/// The texels of a cell along one side of the map, which has `count` of them.
fn part(index: usize, side: usize, count: usize) -> Range<usize> {
    index * side..((index + 1) * side).min(count)
}

/// The solid angle of these rows of a map of `height` rows.
fn zone_of(rows: Range<usize>, height: usize) -> f64 {
    zone(rows.start as f64 / height as f64, rows.end as f64 / height as f64)
}

/// Writes the weights of a row of cells: the luminance of each cell, with what its neighbours send into it, times its
/// solid angle.
fn weigh(texels: &Texels, side: usize, row: usize, weights: &mut [f32]) {
    let Texels { width, height, .. } = *texels;
    let (rows, last) = (part(row, side, height), height - 1);
    // The luminance of each column, summed over the rows of the cell and their neighbours.
    let mut luminances = vec![0.0; width];
    for texel_row in rows.start.saturating_sub(1)..=rows.end.min(last) {
        // At the poles, a row is its own neighbour.
        let share_in = |row: usize| {
            let is = |other: usize| f64::from(u8::from(other == texel_row));
            OWN * is(row) + NEIGHBOUR * (is(row.saturating_sub(1)) + is((row + 1).min(last)))
        };
        let share: f64 = rows.clone().map(share_in).sum();
        for (luminance, texel) in luminances.iter_mut().zip(texels.row(texel_row)) {
            *luminance += share * LUMINANCE.dot(texel.as_dvec3());
        }
    }
    // Each texel of a cell has the same part of it.
    let each = zone_of(rows.clone(), height) / width as f64 / rows.len() as f64;
    for (column, weight) in weights.iter_mut().enumerate() {
        let luminance = |own: usize| {
            let [left, right] = [own.checked_sub(1).unwrap_or(width - 1), (own + 1) % width];
            OWN * luminances[own] + NEIGHBOUR * (luminances[left] + luminances[right])
        };
        *weight = (each * part(column, side, width).map(luminance).sum::<f64>()) as f32;
    }
}

#[cfg(test)]
mod tests;
