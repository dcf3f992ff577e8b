//! Parts of a tile's planes, kept by cells of sixteen pixels: only where a drag can change anything.

use crate::evaluate::framebuffer::{self, Channels};
use crate::evaluate::planes::Planes;
use crate::jit::Lanes;
use crate::trace::Block;
use wide::f32x4;

/// Pixels of a cell. A cell of a framebuffer is a cache line.
pub(super) const CELL_PIXELS: usize = 16;
/// Blocks of lanes of a cell.
const CELL_BLOCKS: usize = CELL_PIXELS / Lanes::COUNT;

/// How many lanes one cell of an image takes.
pub(super) fn stride(channels: Channels) -> usize {
    match channels {
        Channels::All => 3 * CELL_BLOCKS,
        Channels::One(_) => CELL_BLOCKS,
    }
}

/// Copies a cell of the planes to the end of some lanes: block by block, in each red, green and blue.
pub(super) fn copy(planes: &Planes, cell: usize, channels: Channels, into: &mut Vec<Lanes>) {
    let components = planes.components();
    for block in 0..CELL_BLOCKS {
        let start = cell * CELL_PIXELS + block * Lanes::COUNT;
        let lanes = |component: usize| {
            let plane: &[f32] = components[component];
            Lanes(std::array::from_fn(|lane| plane.get(start + lane).copied().unwrap_or(0.0)))
        };
        match channels {
            Channels::All => into.extend([lanes(0), lanes(1), lanes(2)]),
            Channels::One(component) => into.push(lanes(component)),
        }
    }
}

/// Copies a cell from lanes back to the planes.
pub(super) fn restore(planes: &mut Planes, cell: usize, channels: Channels, lanes: &[Lanes]) {
    let start = cell * CELL_PIXELS;
    match channels {
        Channels::All => {
            for (block, lanes) in lanes.chunks_exact(3).enumerate() {
                for (component, lanes) in lanes.iter().enumerate() {
                    planes.set(component, start + block * Lanes::COUNT, *lanes);
                }
            }
        }
        Channels::One(component) => {
            for (block, lanes) in lanes.iter().enumerate() {
                planes.set(component, start + block * Lanes::COUNT, *lanes);
            }
        }
    }
}

/// The largest magnitude in some lanes; infinite where anything is infinite or NaN.
pub(super) fn largest(lanes: &[Lanes]) -> f32 {
    let mut largest = f32x4::ZERO;
    let mut odd = f32x4::ZERO;
    for lanes in lanes {
        let value = f32x4::from(lanes.0).abs();
        largest = largest.fast_max(value);
        // 0 for every number; NaN for NaN and infinity.
        odd += value * f32x4::ZERO;
    }
    let number = odd.to_array().iter().all(|lane| *lane == 0.0);
    if number { largest.to_array().into_iter().fold(0.0, f32::max) } else { f32::INFINITY }
}

/// A set of cells of a tile.
pub(super) struct CellSet(Vec<bool>);

impl CellSet {
    /// None of a tile of so many pixels.
    pub(super) fn none(pixels: usize) -> Self {
        Self(vec![false; pixels.div_ceil(CELL_PIXELS)])
    }

    /// Adds the cells of all hits of some blocks.
    pub(super) fn add(&mut self, blocks: &[Block]) {
        for block in blocks {
            let last = block.pixel() + block.lanes() - 1;
            self.0[block.pixel() / CELL_PIXELS] = true;
            self.0[last / CELL_PIXELS] = true;
        }
    }

    /// The cells, in order.
    pub(super) fn cells(&self) -> Vec<u16> {
        // A tile has 2¹⁴ pixels.
        self.0.iter().enumerate().filter(|(_, held)| **held).map(|(cell, _)| cell as u16).collect()
    }
}

/// A term of an image: its values are multiplied by a factor for each component.
#[derive(Debug, Clone, Copy)]
pub(super) struct Factor(pub(super) [f32; 3]);

/// Writes a cell: `lanes` holds the base, and behind it a term for each factor.
#[inline]
pub(super) fn combine(lanes: &[Lanes], factors: &[Factor], channels: Channels, pixels: &mut [u32]) {
    match channels {
        Channels::All => {
            let (base, terms) = lanes.split_at(3 * CELL_BLOCKS);
            for (block, pixels) in pixels.chunks_mut(Lanes::COUNT).enumerate() {
                let at = |lanes: &[Lanes], component: usize| f32x4::from(lanes[3 * block + component].0);
                let mut sums = [at(base, 0), at(base, 1), at(base, 2)];
                for (term, Factor(factor)) in terms.chunks_exact(3 * CELL_BLOCKS).zip(factors) {
                    for (component, sum) in sums.iter_mut().enumerate() {
                        *sum += f32x4::splat(factor[component]) * at(term, component);
                    }
                }
                framebuffer::write(pixels, sums);
            }
        }
        Channels::One(component) => {
            let (base, terms) = lanes.split_at(CELL_BLOCKS);
            for (block, pixels) in pixels.chunks_mut(Lanes::COUNT).enumerate() {
                let mut sum = f32x4::from(base[block].0);
                for (term, Factor(factor)) in terms.chunks_exact(CELL_BLOCKS).zip(factors) {
                    sum += f32x4::splat(factor[component]) * f32x4::from(term[block].0);
                }
                framebuffer::write_component(pixels, component, sum);
            }
        }
    }
}

/// The pixels of a cell in a tile's part of a framebuffer.
#[inline]
pub(super) fn pixels_of(pixels: &mut [u32], cell: u16) -> &mut [u32] {
    let start = usize::from(cell) * CELL_PIXELS;
    let end = (start + CELL_PIXELS).min(pixels.len());
    &mut pixels[start..end]
}
