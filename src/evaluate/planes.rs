//! The pixels of a tile while colours are added up: a plane each of red, green and blue.
//!
//! Hits come in blocks of up to four neighbouring pixels (see [`Block`]), so adding is four lanes wide. Which colours are added, and with
//! what weight, is the caller's.

use crate::evaluate::framebuffer::Channels;
use crate::jit::Lanes;
use crate::trace::{BLOCK_LANES, Block, MAX_DEPTH, TILE_PIXELS};
use wide::f32x4;

// A block's lanes are those of a kernel.
const _: () = assert!(BLOCK_LANES == Lanes::COUNT);

/// A last block may reach beyond the tile, with lanes that are dead.
const LENGTH: usize = TILE_PIXELS as usize + Lanes::COUNT;

/// All ones in the lanes that a block of so many hits (less one) has.
const LIVE: [[u32; 4]; BLOCK_LANES] = [[!0, 0, 0, 0], [!0, !0, 0, 0], [!0, !0, !0, 0], [!0; 4]];

/// Red, green and blue of a tile's pixels: linear, unclamped.
pub(super) struct Planes(Box<[[f32; LENGTH]; 3]>);

impl Planes {
    /// All black.
    pub(super) fn new() -> Self {
        // Made on the heap: it is larger than what a thread's stack may spare.
        let planes: Box<[[f32; LENGTH]]> = vec![[0.0; LENGTH]; 3].into_boxed_slice();
        Self(planes.try_into().unwrap_or_else(|_| unreachable!("three planes were made")))
    }

    /// Makes the first `pixels` black.
    pub(super) fn clear(&mut self, pixels: usize) {
        for plane in self.0.iter_mut() {
            plane[..pixels].fill(0.0);
        }
    }

    /// Red, green and blue of the pixels, each a slice of the whole tile and some dead lanes.
    pub(super) fn components(&self) -> [&[f32]; 3] {
        self.0.each_ref().map(<[f32; LENGTH]>::as_slice)
    }

    /// Sets four neighbouring pixels.
    #[inline]
    pub(super) fn set(&mut self, component: usize, pixel: usize, lanes: Lanes) {
        self.0[component][pixel..pixel + Lanes::COUNT].copy_from_slice(&lanes.0);
    }

    /// The colour of a pixel.
    pub(super) fn colour(&self, pixel: usize) -> [f32; 3] {
        self.0.each_ref().map(|plane| plane[pixel])
    }

    /// Adds the weighed colours of blocks of hits; `sums` has four lanes for each block.
    pub(super) fn add(&mut self, blocks: &[Block], sums: [&[Lanes]; 3], weight: Weight, channels: Channels) {
        if weight.is_tiny() {
            return self.add_tiny(blocks, sums, weight);
        }
        let weight = f32x4::splat(weight.0 as f32);
        let [reds, greens, blues] = sums;
        match channels {
            Channels::All => {
                let [red_plane, green_plane, blue_plane] = &mut *self.0;
                for (((block, red), green), blue) in blocks.iter().zip(reds).zip(greens).zip(blues) {
                    let live = live(*block);
                    add_at(red_plane, *block, (weight * f32x4::from(red.0)) & live);
                    add_at(green_plane, *block, (weight * f32x4::from(green.0)) & live);
                    add_at(blue_plane, *block, (weight * f32x4::from(blue.0)) & live);
                }
            }
            Channels::One(component) => {
                let plane = &mut self.0[component];
                for (block, sum) in blocks.iter().zip(sums[component]) {
                    add_at(plane, *block, (weight * f32x4::from(sum.0)) & live(*block));
                }
            }
        }
    }

    /// Adds the same weighed colour to the pixels of all hits of these blocks.
    pub(super) fn add_constant(&mut self, blocks: &[Block], colour: [f32; 3], weight: Weight) {
        let [red, green, blue] = weight.of(colour).map(f32x4::splat);
        let [red_plane, green_plane, blue_plane] = &mut *self.0;
        for block in blocks {
            let live = live(*block);
            add_at(red_plane, *block, red & live);
            add_at(green_plane, *block, green & live);
            add_at(blue_plane, *block, blue & live);
        }
    }

    /// The same where the weight is too small for a number of single precision.
    #[cold]
    fn add_tiny(&mut self, blocks: &[Block], sums: [&[Lanes]; 3], weight: Weight) {
        for (index, block) in blocks.iter().enumerate() {
            for lane in 0..block.lanes() {
                let colour = weight.of(sums.map(|plane| plane[index].0[lane]));
                for (plane, component) in self.0.iter_mut().zip(colour) {
                    plane[block.pixel() + lane] += component;
                }
            }
        }
    }
}

/// The mask of a block's lanes.
#[inline]
fn live(block: Block) -> f32x4 {
    f32x4::from(LIVE[block.lanes() - 1].map(f32::from_bits))
}

#[inline]
fn add_at(plane: &mut [f32; LENGTH], block: Block, value: f32x4) {
    let pixel = block.pixel();
    let place = &mut plane[pixel..pixel + BLOCK_LANES];
    let before: [f32; 4] = std::array::from_fn(|lane| place[lane]);
    place.copy_from_slice(&(f32x4::from(before) + value).to_array());
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
    fn of(self, colour: [f32; 3]) -> [f32; 3] {
        if self.is_tiny() {
            colour.map(|component| (self.0 * f64::from(component)) as f32)
        } else {
            colour.map(|component| self.0 as f32 * component)
        }
    }
}
