//! Parts of a tile's planes, kept by cells of sixteen pixels: only where a drag can change anything.

use crate::backends::compiled::planes::Planes;
use crate::evaluate::write_component;
use crate::plan::Channels;
use crate::trace::Segment;
use crate::transfer::Bytes;

/// Pixels of a cell. A cell of a framebuffer is a cache line.
pub(super) const CELL_PIXELS: usize = 16;

/// How many numbers one cell of an image takes: red, green and blue of all its pixels one behind the other, or one of them.
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

/// The largest magnitude in some numbers; infinite where anything is infinite or NaN.
pub(super) fn largest(numbers: &[f32]) -> f32 {
    // The bits of magnitudes are in the order of the magnitudes, and those of NaN above all.
    let bits = numbers.iter().map(|number| number.abs().to_bits()).max().unwrap_or(0);
    let largest = f32::from_bits(bits);
    if largest.is_finite() { largest } else { f32::INFINITY }
}

/// A set of cells of a tile.
pub(super) struct CellSet(Vec<bool>);

impl CellSet {
    /// None of a tile of so many pixels.
    pub(super) fn none(pixels: usize) -> Self {
        Self(vec![false; pixels.div_ceil(CELL_PIXELS)])
    }

    /// Adds the cells of all hits of some segments.
    pub(super) fn add(&mut self, segments: &[Segment]) {
        for segment in segments {
            // No longer than a cell, so in two at most.
            let pixels = segment.pixels();
            self.0[pixels.start / CELL_PIXELS] = true;
            self.0[(pixels.end - 1) / CELL_PIXELS] = true;
        }
    }

    /// The cells, in order.
    pub(super) fn cells(&self) -> Vec<u16> {
        // A tile has 2¹⁴ pixels.
        self.0.iter().enumerate().filter(|(_, held)| **held).map(|(cell, _)| cell as u16).collect()
    }
}

/// What the components of an image are multiplied with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Factor(pub(super) [f32; 3]);

/// Writes cells one behind the other: for each, `numbers` holds the base, and behind it an image for each factor.
#[inline(always)]
pub(super) fn combine(
    numbers: &[f32],
    factors: &[Factor],
    channels: Channels,
    cells: &[u16],
    pixels: &mut [u32],
    bytes: impl Bytes,
) {
    match factors {
        // Most cells have one image: then all is of known length.
        [factor] => combine_images::<1>(numbers, &[*factor], channels, cells, pixels, bytes),
        _ => combine_images::<0>(numbers, factors, channels, cells, pixels, bytes),
    }
}

/// The same with `N` factors, or with any number of them where that is 0.
#[inline(always)]
fn combine_images<const N: usize>(
    numbers: &[f32],
    factors: &[Factor],
    channels: Channels,
    cells: &[u16],
    pixels: &mut [u32],
    bytes: impl Bytes,
) {
    let factors = if N == 0 { factors } else { &factors[..N] };
    // A row for each component of the base and of every image.
    let (rows, _) = numbers.as_chunks::<CELL_PIXELS>();
    match channels {
        Channels::All => {
            for (rows, cell) in rows.chunks_exact(3 * (1 + factors.len())).zip(cells) {
                let mut words = [0; CELL_PIXELS];
                for component in 0..3 {
                    let mut sums = rows[component];
                    for (image, Factor(factor)) in factors.iter().enumerate() {
                        add(&mut sums, &rows[3 * (image + 1) + component], factor[component]);
                    }
                    for (word, sum) in words.iter_mut().zip(sums) {
                        *word = *word << 8 | bytes.byte(sum);
                    }
                }
                in_cell(pixels_of(pixels, *cell), |pixels| *pixels = words);
            }
        }
        Channels::One(component) => {
            for (rows, cell) in rows.chunks_exact(1 + factors.len()).zip(cells) {
                let mut sums = rows[0];
                for (image, Factor(factor)) in factors.iter().enumerate() {
                    add(&mut sums, &rows[image + 1], factor[component]);
                }
                in_cell(pixels_of(pixels, *cell), |pixels| write_component(pixels, component, &sums, bytes));
            }
        }
    }
}

/// Does something to the pixels of a cell, of which the last one of a picture may have fewer. A compiler makes the best of a length that it knows.
#[inline(always)]
pub(super) fn in_cell(pixels: &mut [u32], work: impl Fn(&mut [u32; CELL_PIXELS])) {
    match <&mut [u32; CELL_PIXELS]>::try_from(&mut *pixels) {
        Ok(whole) => work(whole),
        Err(_) => {
            let mut room = [0; CELL_PIXELS];
            let part = &mut room[..pixels.len()];
            part.copy_from_slice(pixels);
            work(&mut room);
            pixels.copy_from_slice(&room[..pixels.len()]);
        }
    }
}

#[inline(always)]
fn add(sums: &mut [f32; CELL_PIXELS], image: &[f32; CELL_PIXELS], factor: f32) {
    for (sum, number) in sums.iter_mut().zip(image) {
        *sum += factor * number;
    }
}

/// The pixels of a cell in a tile's part of a framebuffer.
#[inline(always)]
pub(super) fn pixels_of(pixels: &mut [u32], cell: u16) -> &mut [u32] {
    let start = usize::from(cell) * CELL_PIXELS;
    let end = (start + CELL_PIXELS).min(pixels.len());
    &mut pixels[start..end]
}
