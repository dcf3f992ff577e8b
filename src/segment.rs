//! Hits side by side: what tracing stores of their pixels, and compiled code adds to them by.
//!
//! This is where the store of hits and compiled code must agree, and all that they share.

use std::mem::offset_of;
use std::ops::Range;

/// How many consecutive pixels make a tile. It is fixed, so that sums are taken in the same order on any machine.
pub const TILE_PIXELS: u32 = 16_384;

/// How many hits make a line: as many as the widest vectors have lanes. The hits of a group are cut in lines in their order.
pub const LINE_HITS: usize = 16;

/// Compiled code computes so many lines side by side.
pub const ROUND_LINES: usize = 4;

/// How many lines are worked on at a time, see [`Segment::line`].
pub const CHUNK_LINES: usize = 64;

/// How many hits these are.
pub const CHUNK_HITS: usize = CHUNK_LINES * LINE_HITS;

/// Up to sixteen hits, or misses, that stand side by side in one line and whose pixels are neighbours too.
///
/// It says where the line would lie in the picture if all its hits were neighbours like these, and which of its lanes they are: so a
/// vector of what the hits of a line add is added to a vector of pixels at once. Compiled code relies on what the methods promise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Segment {
    place: u16,
    lanes: u16,
    /// The line and, in the upper bits, the span.
    line_and_span: u16,
}

// Places are within sixteen bits, and so are a line with a span: there are no more spans in a chunk than hits.
const _: () = assert!(TILE_PIXELS as usize + Segment::MARGIN <= u16::MAX as usize && LINE_HITS == u16::BITS as usize);
const _: () = assert!(CHUNK_LINES == 1 << Segment::LINE_BITS && CHUNK_LINES * CHUNK_HITS <= 1 << u16::BITS);

impl Segment {
    /// What is added to pixels in a [`place`](Self::place), so that it is never negative.
    pub const MARGIN: usize = LINE_HITS;

    /// Where place, lanes, and line with span lie, in bytes; each has sixteen bits.
    pub(crate) const OFFSETS: [usize; 3] = [offset_of!(Self, place), offset_of!(Self, lanes), offset_of!(Self, line_and_span)];

    /// So many bits are the line, those above them the span.
    pub(crate) const LINE_BITS: u32 = CHUNK_LINES.trailing_zeros();

    /// That of one hit, by its pixel, counted from the tile's first, its number in the group, and that of its span in the chunk.
    ///
    /// # Panics
    /// Where there is no such pixel in a tile, or no such span in a chunk.
    pub(crate) fn new(pixel: u16, hit: u32, span: usize) -> Self {
        assert!(u32::from(pixel) < TILE_PIXELS && span < CHUNK_HITS, "a pixel of a tile, and a span of a chunk");
        let lane = hit % LINE_HITS as u32;
        let line = hit / LINE_HITS as u32 % CHUNK_LINES as u32;
        let line_and_span = line as u16 | (span << Self::LINE_BITS) as u16;
        Self { place: pixel + Self::MARGIN as u16 - lane as u16, lanes: 1 << lane, line_and_span }
    }

    /// Takes the next hit in, if it is in the same line and its pixel is the next.
    pub(crate) fn extend(&mut self, pixel: u16) -> bool {
        let lane = u16::BITS - self.lanes.leading_zeros();
        let fits = lane < LINE_HITS as u32 && usize::from(pixel) == self.pixels().end;
        if fits {
            self.lanes |= 1 << lane;
        }
        fits
    }

    /// The place of the line's first lane: the pixel that its hit would be in, counted from the tile's first, and [`MARGIN`](Self::MARGIN).
    /// It is less than [`TILE_PIXELS`] and the margin.
    #[inline]
    pub fn place(self) -> usize {
        usize::from(self.place)
    }

    /// Which lanes of the line the hits are: the lowest bit is the first; their bits are neighbours, and there is one at least.
    #[inline]
    pub fn lanes(self) -> u16 {
        self.lanes
    }

    /// The place of the line among those that are worked on together, less than [`CHUNK_LINES`].
    #[inline]
    pub fn line(self) -> usize {
        usize::from(self.line_and_span) % CHUNK_LINES
    }

    /// The number of the span among those of the chunk, less than [`CHUNK_HITS`].
    #[inline]
    pub fn span(self) -> usize {
        usize::from(self.line_and_span >> Self::LINE_BITS)
    }

    /// How many hits.
    #[inline]
    pub fn hits(self) -> usize {
        self.lanes.count_ones() as usize
    }

    /// The pixels, counted from the tile's first.
    #[inline]
    pub fn pixels(self) -> Range<usize> {
        let first = usize::from(self.place) + self.lanes.trailing_zeros() as usize - Self::MARGIN;
        first..first + self.hits()
    }
}
