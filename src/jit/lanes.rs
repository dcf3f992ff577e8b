//! What compiled code reads and writes: columns, uniform values, and pixels.

use crate::segment::{CHUNK_LINES, LINE_HITS, Segment, TILE_PIXELS};

/// Four records' values of one column, side by side in memory as kernels load them.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C, align(16))]
pub struct Lanes(pub [f32; 4]);

impl Lanes {
    /// How many records a block holds.
    pub const COUNT: usize = 4;

    /// The same value for all four records.
    pub fn splat(value: f32) -> Self {
        Self([value; 4])
    }

    /// The numbers of some blocks, one behind the other.
    pub fn numbers(blocks: &[Lanes]) -> &[f32] {
        bytemuck::cast_slice(blocks)
    }

    /// How many blocks so many records take.
    pub fn blocks(records: usize) -> usize {
        records.div_ceil(Self::COUNT)
    }
}

/// Four blocks: as many records as the widest kernels compute at a time, and a line of the cache.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C, align(64))]
pub struct Line(pub [Lanes; 4]);

impl Line {
    /// How many blocks a line holds.
    pub const BLOCKS: usize = 4;
    /// How many records a line holds.
    pub const RECORDS: usize = Self::BLOCKS * Lanes::COUNT;

    /// The blocks of some lines, one behind the other.
    pub fn blocks(lines: &[Line]) -> &[Lanes] {
        bytemuck::cast_slice(lines)
    }

    /// The same, to be written.
    pub fn blocks_mut(lines: &mut [Line]) -> &mut [Lanes] {
        bytemuck::cast_slice_mut(lines)
    }
}

/// A uniform value, in as many lanes as the widest kernels have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C, align(64))]
pub struct Splat([f32; Line::RECORDS]);

impl Splat {
    /// The value in all lanes.
    pub fn new(value: f32) -> Self {
        Self([value; Line::RECORDS])
    }
}

/// Sixteen pixels of a framebuffer: a line of the cache.
#[derive(Debug, Clone, Copy, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C, align(64))]
pub struct PixelLine(pub [u32; Line::RECORDS]);

/// What is added to the pixels of hits: red, green and blue of each line of a chunk.
pub type Sums = [[Line; CHUNK_LINES]; 3];

/// Pixels of a plane: those of a tile, behind a [margin](Segment::MARGIN), and room for a line beyond.
pub const PLANE_PIXELS: usize = Segment::MARGIN + TILE_PIXELS as usize + LINE_HITS;

/// Red, green and blue of the pixels of a tile, each behind its margin.
#[derive(Debug, Clone, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct PixelPlanes(pub [[f32; PLANE_PIXELS]; 3]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_what_kernels_load() {
        assert_eq!((size_of::<Lanes>(), align_of::<Lanes>()), (16, 16));
        assert_eq!((size_of::<Splat>(), align_of::<Splat>()), (64, 64));
        assert_eq!((size_of::<Line>(), align_of::<Line>()), (64, 64));
        assert_eq!(Lanes::blocks(0), 0);
        assert_eq!(Lanes::blocks(5), 2);
    }
}
