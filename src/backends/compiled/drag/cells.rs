//! Parts of a tile's planes, stored by cells of sixteen pixels: only where a drag can change anything.

use crate::backends::compiled::planes::Planes;
use crate::evaluate::{write, write_component};
use crate::picture::encoder::Bytes;
use crate::plan::Channels;
use crate::trace::Segment;
use pulp::Simd;

/// Pixels of a cell. A cell of a framebuffer is a cache line.
pub(super) const CELL_PIXELS: usize = 16;

/// The number of numbers in one cell of an image: red, then green, then blue of all its pixels, or one of them.
pub(super) fn stride(channels: Channels) -> usize {
    match channels {
        Channels::All => 3 * CELL_PIXELS,
        Channels::One(_) => CELL_PIXELS,
    }
}

/// Copies a cell of the planes to the end of some numbers.
pub(super) fn copy(planes: &Planes, cell: usize, channels: Channels, into: &mut Vec<f32>) {
    let pixels = cell * CELL_PIXELS..(cell + 1) * CELL_PIXELS;
    let components = planes.components();
    match channels {
        Channels::All => components.iter().for_each(|plane| into.extend_from_slice(&plane[pixels.clone()])),
        Channels::One(component) => into.extend_from_slice(&components[component][pixels]),
    }
}

/// Copies a cell back to the planes.
#[inline(always)]
pub(super) fn restore(planes: &mut Planes, cell: usize, channels: Channels, cells: &[f32]) {
    let pixels = cell * CELL_PIXELS..(cell + 1) * CELL_PIXELS;
    match channels {
        Channels::All => {
            for (component, plane) in cells.chunks_exact(CELL_PIXELS).enumerate() {
                planes.part_mut(component, pixels.clone()).copy_from_slice(plane);
            }
        }
        Channels::One(component) => planes.part_mut(component, pixels).copy_from_slice(cells),
    }
}

/// Makes a cell of the planes black.
pub(super) fn clear(planes: &mut Planes, cell: usize, channels: Channels) {
    let pixels = cell * CELL_PIXELS..(cell + 1) * CELL_PIXELS;
    channels.components().for_each(|component| planes.part_mut(component, pixels.clone()).fill(0.0));
}

/// Multiplies a cell of the planes by a number, and adds other numbers to it.
pub(super) fn scale_and_add(planes: &mut Planes, cell: usize, channels: Channels, factor: f32, cells: &[f32]) {
    let pixels = cell * CELL_PIXELS..(cell + 1) * CELL_PIXELS;
    for (component, numbers) in channels.components().zip(cells.chunks_exact(CELL_PIXELS)) {
        let plane = planes.part_mut(component, pixels.clone());
        plane.iter_mut().zip(numbers).for_each(|(sum, number)| *sum = factor * *sum + number);
    }
}

/// The largest magnitude of some numbers. It is infinite if any number is infinite or NaN.
pub(super) fn largest(numbers: &[f32]) -> f32 {
    // The bits of magnitudes, read as integers, have the order of the magnitudes. Those of NaN are the largest.
    let bits = numbers.iter().map(|number| number.abs().to_bits()).max().unwrap_or(0);
    let largest = f32::from_bits(bits);
    if largest.is_finite() { largest } else { f32::INFINITY }
}

/// A set of cells of a tile.
pub(super) struct CellSet(Vec<bool>);

impl CellSet {
    /// An empty set, for a tile of this many pixels.
    pub(super) fn none(pixels: usize) -> Self {
        Self(vec![false; pixels.div_ceil(CELL_PIXELS)])
    }

    /// Adds the cells of all hits of some segments.
    pub(super) fn add(&mut self, segments: &[Segment]) {
        for segment in segments {
            // A segment is not longer than a cell, so it touches at most two.
            self.0[segment.first_pixel() / CELL_PIXELS] = true;
            self.0[segment.last_pixel() / CELL_PIXELS] = true;
        }
    }

    /// The cells, in order.
    pub(super) fn cells(&self) -> Vec<u16> {
        // A tile has at most 2¹⁴ pixels.
        self.0.iter().enumerate().filter(|(_, held)| **held).map(|(cell, _)| cell as u16).collect()
    }
}

/// The factors of the components of an image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Factor(pub(super) [f32; 3]);

/// Writes cells. `numbers` holds the base of each cell, followed by an image for each factor.
#[inline(always)]
pub(super) fn combine<S: Simd>(
    simd: S,
    numbers: &[f32],
    factors: &[Factor],
    channels: Channels,
    cells: &[u16],
    pixels: &mut [u32],
    bytes: impl Bytes,
) {
    // Most cells have one image. Loops of constant length are unrolled.
    let first = channels.components().start;
    match (channels, factors) {
        (Channels::All, [factor]) => combine_images::<S, 3, 1>(simd, numbers, &[*factor], first, cells, pixels, bytes),
        (Channels::All, _) => combine_images::<S, 3, 0>(simd, numbers, factors, first, cells, pixels, bytes),
        (Channels::One(_), [factor]) => combine_images::<S, 1, 1>(simd, numbers, &[*factor], first, cells, pixels, bytes),
        (Channels::One(_), _) => combine_images::<S, 1, 0>(simd, numbers, factors, first, cells, pixels, bytes),
    }
}

/// A row of an image for each of `C` components.
type Rows<const C: usize> = [[f32; CELL_PIXELS]; C];

/// The same for `C` components, with `N` factors, or with any number of them if that is 0. `first` is the first
/// of the components.
#[inline(always)]
fn combine_images<S: Simd, const C: usize, const N: usize>(
    simd: S,
    numbers: &[f32],
    factors: &[Factor],
    first: usize,
    cells: &[u16],
    pixels: &mut [u32],
    bytes: impl Bytes,
) {
    let factors = if N == 0 { factors } else { &factors[..N] };
    let images: &[Rows<C>] = numbers.as_chunks().0.as_chunks().0;
    for (images, cell) in images.chunks_exact(1 + factors.len()).zip(cells) {
        let mut sums = [[0.0; CELL_PIXELS]; C];
        add_images(simd, images, factors, first, &mut sums);
        write_cell(pixels_of(pixels, *cell), sums.each_ref(), first, bytes);
    }
}

/// Adds images times their factors to the base, which is the first image. The rows are those of the components from
/// `first` on.
#[inline(always)]
fn add_images<S: Simd, const C: usize>(simd: S, images: &[Rows<C>], factors: &[Factor], first: usize, sums: &mut Rows<C>) {
    let Some((base, images)) = images.split_first() else { return };
    for component in 0..C {
        // Explicit vectors: the compiler unrolls loops over few numbers, and then does not always vectorise them.
        let vector = |rows: &Rows<C>, index: usize| S::as_simd_f32s(&rows[component]).0[index];
        for (index, sum) in S::as_mut_simd_f32s(&mut sums[component]).0.iter_mut().enumerate() {
            let mut total = vector(base, index);
            for (rows, Factor(factor)) in images.iter().zip(factors) {
                let factor = simd.splat_f32s(factor[first + component]);
                total = simd.add_f32s(total, simd.mul_f32s(factor, vector(rows, index)));
            }
            *sum = total;
        }
    }
}

/// Writes the components of a cell that are computed: all three, or the one of this index. The last cell of a picture
/// may have fewer pixels than the others.
#[inline(always)]
pub(super) fn write_cell<const C: usize>(pixels: &mut [u32], linear: [&[f32; CELL_PIXELS]; C], first: usize, bytes: impl Bytes) {
    match <&mut [u32; CELL_PIXELS]>::try_from(&mut *pixels) {
        Ok(words) => write_words(words, linear, first, bytes),
        Err(_) => {
            let mut words = [0; CELL_PIXELS];
            words[..pixels.len()].copy_from_slice(pixels);
            write_words(&mut words, linear, first, bytes);
            pixels.copy_from_slice(&words[..pixels.len()]);
        }
    }
}

/// The same for sixteen pixels. Lengths and the number of components are constants, so all stays in vector registers.
#[inline(always)]
fn write_words<const C: usize>(
    words: &mut [u32; CELL_PIXELS],
    linear: [&[f32; CELL_PIXELS]; C],
    first: usize,
    bytes: impl Bytes,
) {
    match linear.as_slice() {
        [red, green, blue] => write(words, [*red, *green, *blue], bytes),
        one => one.iter().for_each(|linear| write_component(words, first, *linear, bytes)),
    }
}

/// The number of pixels in these cells of a tile of this many pixels.
pub(super) fn pixel_count(cells: &[u16], tile_pixels: usize) -> usize {
    cells.iter().map(|cell| tile_pixels.saturating_sub(usize::from(*cell) * CELL_PIXELS).min(CELL_PIXELS)).sum()
}

/// The pixels of a cell in a tile's part of a framebuffer.
#[inline(always)]
pub(super) fn pixels_of(pixels: &mut [u32], cell: u16) -> &mut [u32] {
    let start = usize::from(cell) * CELL_PIXELS;
    let end = (start + CELL_PIXELS).min(pixels.len());
    &mut pixels[start..end]
}
