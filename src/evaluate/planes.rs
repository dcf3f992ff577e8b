//! The pixels of a tile while colours are added up: a plane each of red, green and blue.
//!
//! Hits come in blocks of up to four neighbouring pixels (see [`Block`]), and blocks mostly in runs of neighbours: what is added to a run is
//! added in vectors as wide as the processor has. Which colours are added, and with what weight, is the caller's.

use crate::evaluate::framebuffer::{self, Channels};
use crate::jit::Lanes;
use crate::trace::{BLOCK_LANES, Block, MAX_DEPTH, Region, TILE_PIXELS, Tile};
use pulp::{Arch, Simd, WithSimd};

// A block's lanes are those of a kernel.
const _: () = assert!(BLOCK_LANES == Lanes::COUNT);

/// Pixels that are written at a time.
const WIDE: usize = 16;

/// Pixels in a plane: those of a tile, and room for what is written beyond the last in one go with it.
const LENGTH: usize = TILE_PIXELS as usize + WIDE;

/// All ones in the lanes that a block of so many hits (less one) has.
const LIVE: [[u32; BLOCK_LANES]; BLOCK_LANES] = [[!0, 0, 0, 0], [!0, !0, 0, 0], [!0, !0, !0, 0], [!0; 4]];

/// Red, green and blue of a tile's pixels: linear, unclamped.
pub(super) struct Planes {
    planes: Box<[[f32; LENGTH]; 3]>,
    arch: Arch,
}

impl Planes {
    /// How large they are.
    pub(super) const BYTES: usize = size_of::<[[f32; LENGTH]; 3]>();

    /// All black.
    pub(super) fn new() -> Self {
        // Made on the heap: it is larger than what a thread's stack may spare.
        let planes: Box<[[f32; LENGTH]]> = vec![[0.0; LENGTH]; 3].into_boxed_slice();
        let planes = planes.try_into().unwrap_or_else(|_| unreachable!("three planes were made"));
        Self { planes, arch: Arch::new() }
    }

    /// Red, green and blue of the pixels, each a slice of a whole tile and more.
    pub(super) fn components(&self) -> [&[f32]; 3] {
        self.planes.each_ref().map(<[f32; LENGTH]>::as_slice)
    }

    /// Some pixels of a component.
    #[inline]
    pub(super) fn part_mut(&mut self, component: usize, pixels: std::ops::Range<usize>) -> &mut [f32] {
        &mut self.planes[component][pixels]
    }

    /// The colour of a pixel.
    pub(super) fn colour(&self, pixel: usize) -> [f32; 3] {
        self.planes.each_ref().map(|plane| plane[pixel])
    }

    /// Gives every region of a tile a colour, that of its set of paths; or adds it to what is there.
    pub(super) fn fill(&mut self, tile: &Tile, colours: &[[f32; 3]], add: bool) {
        self.arch.dispatch(Fill { planes: &mut self.planes, regions: &tile.regions, colours, add });
    }

    /// Adds the weighed colours of blocks of hits; `sums` has four lanes for each block.
    pub(super) fn add(&mut self, blocks: &[Block], sums: [&[Lanes]; 3], weight: Weight, channels: Channels) {
        if weight.is_tiny() {
            return self.add_tiny(blocks, sums, weight);
        }
        let (sums, weight) = (sums.map(Lanes::flat), weight.0 as f32);
        let planes = &mut *self.planes;
        match channels {
            Channels::All => self.arch.dispatch(Addition { planes, blocks, sums: &sums, weight }),
            Channels::One(component) => {
                let planes = std::slice::from_mut(&mut planes[component]);
                self.arch.dispatch(Addition { planes, blocks, sums: &[sums[component]], weight });
            }
        }
    }

    /// The same where the weight is too small for a number of single precision.
    #[cold]
    fn add_tiny(&mut self, blocks: &[Block], sums: [&[Lanes]; 3], weight: Weight) {
        for (index, block) in blocks.iter().enumerate() {
            for lane in 0..block.lanes() {
                let colour = weight.of(sums.map(|plane| plane[index].0[lane]));
                for (plane, component) in self.planes.iter_mut().zip(colour) {
                    plane[block.pixel() + lane] += component;
                }
            }
        }
    }

    /// Writes the tile's pixels.
    pub(super) fn quantise(&self, pixels: &mut [u32]) {
        self.arch.dispatch(Quantise { planes: self.components(), pixels });
    }
}

// What is dispatched is a structure with a method that must be inlined: only so is it compiled for the vectors of this processor.

/// Colours every region.
struct Fill<'a> {
    planes: &'a mut [[f32; LENGTH]; 3],
    regions: &'a [Region],
    colours: &'a [[f32; 3]],
    add: bool,
}

impl WithSimd for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let mut start = 0;
        for region in self.regions {
            let colour = self.colours[usize::from(region.set)];
            let end = start + usize::from(region.pixels);
            for (plane, component) in self.planes.iter_mut().zip(colour) {
                if self.add {
                    plane[start..end].iter_mut().for_each(|pixel| *pixel += component);
                    continue;
                }
                // Most regions are small. What is written beyond the end, the next region overwrites.
                let mut at = start;
                while at < end {
                    plane[at..at + WIDE].copy_from_slice(&[component; WIDE]);
                    at += WIDE;
                }
            }
            start = end;
        }
    }
}

struct Quantise<'a> {
    planes: [&'a [f32]; 3],
    pixels: &'a mut [u32],
}

impl WithSimd for Quantise<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        framebuffer::write(self.pixels, self.planes);
    }
}

/// `planes += weight · sums`, four blocks at a time where they are neighbours. Plain loops of constant length, of which a compiler
/// makes vector code.
struct Addition<'a> {
    planes: &'a mut [[f32; LENGTH]],
    blocks: &'a [Block],
    sums: &'a [&'a [f32]],
    weight: f32,
}

impl WithSimd for Addition<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Addition { planes, blocks, sums, weight } = self;
        let mut index = 0;
        while let Some(block) = blocks.get(index) {
            let (pixel, lane) = (block.pixel(), index * BLOCK_LANES);
            if blocks[index..].first_chunk().is_some_and(Block::are_neighbours) {
                for (plane, sums) in planes.iter_mut().zip(sums) {
                    add_lanes(&mut plane[pixel..pixel + WIDE], &sums[lane..lane + WIDE], weight, [!0; WIDE]);
                }
                index += 4;
            } else {
                let live = LIVE[block.lanes() - 1];
                for (plane, sums) in planes.iter_mut().zip(sums) {
                    add_lanes(&mut plane[pixel..pixel + BLOCK_LANES], &sums[lane..lane + BLOCK_LANES], weight, live);
                }
                index += 1;
            }
        }
    }
}

#[inline(always)]
fn add_lanes<const N: usize>(pixels: &mut [f32], sums: &[f32], weight: f32, live: [u32; N]) {
    let term = |lane: usize| f32::from_bits((weight * sums[lane]).to_bits() & live[lane]);
    let after: [f32; N] = std::array::from_fn(|lane| pixels[lane] + term(lane));
    pixels.copy_from_slice(&after);
}

/// The weight of a path. Kept in `f64`: the product of weights that are not 0 is then never 0, and a term of infinite value stays so
/// however small its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weight(pub(super) f64);

// A factor other than 0 is at least 2⁻¹²⁶, and there is one for each depth below the first.
const _: () = assert!((MAX_DEPTH - 1) * 126 <= 1022);

impl Weight {
    pub(super) fn is_zero(self) -> bool {
        self.0 == 0.0
    }

    fn is_tiny(self) -> bool {
        self.0 < f64::from(f32::MIN_POSITIVE)
    }

    /// The weighed colour.
    #[inline]
    pub(super) fn of(self, colour: [f32; 3]) -> [f32; 3] {
        if self.is_tiny() {
            colour.map(|component| (self.0 * f64::from(component)) as f32)
        } else {
            colour.map(|component| self.0 as f32 * component)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_that_are_dead_add_nothing() {
        // Full blocks with and without gaps between them, and all sorts of short ones: sums of dead lanes are NaN.
        let runs = [0..16, 20..35, 37..41, 42..44, 45..49, 50..54, 60..61, 64..80, 81..84, 85..101, 102..104, 106..110, 110..130];
        let mut blocks: Vec<Block> = Vec::new();
        for run in &runs {
            for first in run.clone().step_by(BLOCK_LANES) {
                blocks.push(Block::of(first, (run.end - first).min(BLOCK_LANES)));
            }
        }
        let lanes = |block: &Block| Lanes(std::array::from_fn(|lane| if lane < block.lanes() { 2.0 } else { f32::NAN }));
        let sums: Vec<Lanes> = blocks.iter().map(lanes).collect();
        for channels in [Channels::All, Channels::One(1)] {
            let mut planes = Planes::new();
            planes.add(&blocks, [&sums, &sums, &sums], Weight(0.5), channels);
            for pixel in 0..160 {
                let lit = runs.iter().any(|run| run.contains(&pixel));
                let expected = |component: usize| match channels {
                    Channels::One(only) if only != component => 0.0,
                    Channels::One(_) | Channels::All => f32::from(u8::from(lit)),
                };
                assert_eq!(planes.colour(pixel), [expected(0), expected(1), expected(2)], "pixel {pixel}");
            }
        }
    }
}
