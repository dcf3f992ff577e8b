//! Tiles, lines, chunks and segments: the layout of hits, which the hit store and compiled code share.

use std::mem::offset_of;
use std::ops::Range;

/// The most consecutive pixels that make a tile, see [`tile_pixels`].
pub const TILE_PIXELS: u32 = 16_384;

/// A small picture has about this many tiles, so that all threads have work.
const MIN_TILES: u32 = 16;
/// A tile has at least this many pixels, if the picture does: each tile has tables of its own.
const MIN_TILE_PIXELS: u32 = 256;

/// How many consecutive pixels make a tile of a picture with this many pixels: at most [`TILE_PIXELS`], and a multiple
/// of 256. It depends on nothing else, so sums are taken in the same order on any machine.
#[must_use]
pub fn tile_pixels(picture_pixels: u32) -> u32 {
    let share = picture_pixels.div_ceil(MIN_TILES).next_multiple_of(MIN_TILE_PIXELS);
    share.clamp(MIN_TILE_PIXELS, TILE_PIXELS)
}

/// How many hits make a line: as many as the widest vectors have lanes. The hits of a group are cut in lines in their
/// order.
pub const LINE_HITS: usize = 16;

/// How many lines compiled code computes side by side.
pub const ROUND_LINES: usize = 4;

/// How many lines are worked on at a time, see [`Segment::line`].
pub const CHUNK_LINES: usize = 64;

/// How many hits a chunk has.
pub const CHUNK_HITS: usize = CHUNK_LINES * LINE_HITS;

/// Up to sixteen hits, or misses, that are neighbours in one line and in the picture.
///
/// A segment gives the pixel of the line's first lane, as if all lanes were neighbours, and a mask of its own lanes. So
/// compiled code adds a vector of contributions to a vector of pixels at once. It relies on what the methods promise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Segment {
    plane_index: u16,
    lanes: u16,
    /// The line and, in the upper bits, the span.
    line_and_span: u16,
}

// Plane indices are within sixteen bits, and so are a line with a span: a chunk has no more spans than hits.
const _: () = assert!(TILE_PIXELS as usize + Segment::MARGIN <= u16::MAX as usize && LINE_HITS == u16::BITS as usize);
const _: () = assert!(CHUNK_LINES == 1 << Segment::LINE_BITS && CHUNK_LINES * CHUNK_HITS <= 1 << u16::BITS);

impl Segment {
    /// What [`plane_index`](Self::plane_index) adds to the number of a pixel, so that it is never negative.
    pub const MARGIN: usize = LINE_HITS;

    /// The offsets of plane index, lanes, and line with span, in bytes. Each has sixteen bits.
    pub(crate) const OFFSETS: [usize; 3] =
        [offset_of!(Self, plane_index), offset_of!(Self, lanes), offset_of!(Self, line_and_span)];

    /// How many low bits are the line. The bits above them are the span.
    pub(crate) const LINE_BITS: u32 = CHUNK_LINES.trailing_zeros();

    /// A segment of one hit: its pixel in the tile, its number in the group, and the number of its span in the chunk.
    ///
    /// # Panics
    /// A tile has no such pixel, or a chunk has no such span.
    pub(crate) fn new(pixel: u16, hit: u32, span: usize) -> Self {
        assert!(u32::from(pixel) < TILE_PIXELS && span < CHUNK_HITS, "a pixel of a tile, and a span of a chunk");
        let lane = hit % LINE_HITS as u32;
        let line = hit / LINE_HITS as u32 % CHUNK_LINES as u32;
        let line_and_span = line as u16 | (span << Self::LINE_BITS) as u16;
        Self { plane_index: pixel + Self::MARGIN as u16 - lane as u16, lanes: 1 << lane, line_and_span }
    }

    /// Adds the next hit, if it is in the same line and its pixel is the next. Whether it was added.
    pub(crate) fn extend(&mut self, pixel: u16) -> bool {
        let lane = u16::BITS - self.lanes.leading_zeros();
        // The pixel of a lane is the plane index plus the lane, less the margin.
        let next = usize::from(self.plane_index) + lane as usize;
        let fits = lane < LINE_HITS as u32 && usize::from(pixel) + Self::MARGIN == next;
        if fits {
            self.lanes |= 1 << lane;
        }
        fits
    }

    /// The index of the line's first lane in a plane: the pixel that its hit would be in, counted from the tile's
    /// first, plus [`MARGIN`](Self::MARGIN). It is less than [`TILE_PIXELS`] and the margin.
    #[inline]
    pub fn plane_index(self) -> usize {
        usize::from(self.plane_index)
    }

    /// A mask of the lanes of the line; the lowest bit is the first lane. At least one bit is set, and the bits that
    /// are set are neighbours.
    #[inline]
    pub fn lanes(self) -> u16 {
        self.lanes
    }

    /// The number of the line in its chunk, less than [`CHUNK_LINES`].
    #[inline]
    pub fn line(self) -> usize {
        usize::from(self.line_and_span) % CHUNK_LINES
    }

    /// The number of the span in its chunk, less than [`CHUNK_HITS`].
    #[inline]
    pub fn span(self) -> usize {
        usize::from(self.line_and_span >> Self::LINE_BITS)
    }

    /// How many hits it has.
    #[inline]
    pub fn hits(self) -> usize {
        self.lanes.count_ones() as usize
    }

    /// Its pixels, counted from the tile's first.
    #[inline]
    pub fn pixels(self) -> Range<usize> {
        let first = usize::from(self.plane_index) + self.lanes.trailing_zeros() as usize - Self::MARGIN;
        first..first + self.hits()
    }
}
