//! The texels of a map: how they are stored, and the radiance between them.

use crate::environment::compact::CompactNumber;
use crate::environment::latitude_longitude::MapPlace;
use glam::Vec3;
use rayon::prelude::*;

/// Texels in rows, at least one.
#[derive(Debug, PartialEq)]
pub(super) struct Texels {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Row by row from the top, each from the left.
    numbers: Vec<[CompactNumber; 3]>,
}

/// What could not be kept as it was.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MapRepairs {
    /// Texels with a component that is not a number. It became 0.
    pub not_numbers: u64,
    /// Texels with a component that is infinite or too large. It became the largest number of a map, about 8.6·10⁹.
    pub too_bright: u64,
    /// Texels with a component below 0. It became 0.
    pub negative: u64,
    /// What these components sum up to, as a part of the sum of all others; infinite if one of them is beyond the
    /// numbers of a map, or if there are no others. Many images have small ones, by compression with loss and by
    /// filters that sharpen.
    pub negative_part: f64,
}

/// What is found in a row, or in several.
#[derive(Debug, Clone, Copy, Default)]
struct RowFindings {
    not_numbers: u64,
    too_bright: u64,
    negative: u64,
    below: f64,
    above: f64,
}

impl RowFindings {
    fn add(&mut self, texel: [f32; 3]) {
        let has = |is_wrong: fn(f32) -> bool| u64::from(texel.into_iter().any(is_wrong));
        self.not_numbers += has(f32::is_nan);
        self.too_bright += has(|component| component > CompactNumber::MAX);
        self.negative += has(|component| component < 0.0);
        for component in texel {
            // What is too large would hide all others, and NaN is neither above nor below.
            if (0.0..=CompactNumber::MAX).contains(&component) {
                self.above += f64::from(component);
            } else if component < -CompactNumber::MAX {
                self.below = f64::INFINITY;
            } else if component < 0.0 {
                self.below -= f64::from(component);
            }
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            not_numbers: self.not_numbers + other.not_numbers,
            too_bright: self.too_bright + other.too_bright,
            negative: self.negative + other.negative,
            below: self.below + other.below,
            above: self.above + other.above,
        }
    }

    fn repairs(self) -> MapRepairs {
        let Self { not_numbers, too_bright, negative, below, above } = self;
        let negative_part = if below > 0.0 { below / above } else { 0.0 };
        MapRepairs { not_numbers, too_bright, negative, negative_part }
    }
}

/// The radiance of a texel, linear RGB.
#[inline]
fn radiance_of(&[red, green, blue]: &[CompactNumber; 3]) -> Vec3 {
    Vec3::new(red.get(), green.get(), blue.get())
}

impl Texels {
    /// The bytes that this many texels take.
    pub(super) fn memory_of(width: usize, height: usize) -> u64 {
        width as u64 * height as u64 * size_of::<[CompactNumber; 3]>() as u64
    }

    /// Texels whose rows `row` writes, see [`RadianceMap::of_rows`](super::RadianceMap::of_rows).
    pub(super) fn of_rows(width: usize, height: usize, row: impl Fn(u32, &mut [[f32; 3]]) + Sync) -> (Self, MapRepairs) {
        let mut numbers = vec![[CompactNumber::default(); 3]; width * height];
        let write = |given: &mut Vec<[f32; 3]>, (index, texels): (usize, &mut [[CompactNumber; 3]])| {
            row(index as u32, given);
            let mut findings = RowFindings::default();
            for (texel, given) in texels.iter_mut().zip(given) {
                findings.add(*given);
                *texel = given.map(CompactNumber::nearest);
            }
            findings
        };
        let rows = numbers.par_chunks_mut(width).enumerate().map_init(|| vec![[0.0; 3]; width], write);
        // In the order of the rows, whatever the number of threads.
        let rows: Vec<RowFindings> = rows.collect();
        let findings = rows.into_iter().fold(RowFindings::default(), RowFindings::plus);
        (Self { width, height, numbers }, findings.repairs())
    }

    /// The bytes that they take.
    pub(super) fn memory(&self) -> u64 {
        size_of_val(self.numbers.as_slice()) as u64
    }

    /// A row, from the left.
    pub(super) fn row(&self, row: usize) -> impl Iterator<Item = Vec3> {
        self.numbers[row * self.width..][..self.width].iter().map(radiance_of)
    }

    #[inline]
    fn texel(&self, column: usize, row: usize) -> Vec3 {
        radiance_of(&self.numbers[row * self.width + column])
    }

    /// The radiance at a place: interpolated between the middles of texels, across the left and the right edge too.
    #[inline]
    pub(super) fn at(&self, place: MapPlace) -> Vec3 {
        let (x, y) = (place.u * self.width as f64 - 0.5, (place.v * self.height as f64 - 0.5).max(0.0));
        // The casts saturate, and NaN becomes 0.
        let left = if x < 0.0 { self.width - 1 } else { (x as usize).min(self.width - 1) };
        let right = if left + 1 == self.width { 0 } else { left + 1 };
        let above = (y as usize).min(self.height - 1);
        let below = (above + 1).min(self.height - 1);
        let (across, down) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
        let in_row = |row: usize| self.texel(left, row).lerp(self.texel(right, row), across);
        in_row(above).lerp(in_row(below), down)
    }
}
