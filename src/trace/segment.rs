//! Tiles, lines, chunks and segments: the layout of hits, which the hit store and compiled code share.

use std::mem::offset_of;

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

/// How many lines are worked on at a time, see [`Segment::first_hit`].
pub const CHUNK_LINES: usize = 64;

/// How many hits a chunk has.
pub const CHUNK_HITS: usize = CHUNK_LINES * LINE_HITS;

/// Up to sixteen hits, or misses, that follow each other in a span, and whose pixels are within sixteen neighbours.
///
/// A segment gives its first pixel, and a mask of the pixels from there on that have a hit. So compiled code adds a
/// vector of contributions to a vector of pixels at once. It relies on what the methods promise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Segment {
    pixel: u16,
    lanes: u16,
    hit: u16,
    span: u16,
}

// All numbers fit sixteen bits: a chunk has no more spans than hits.
const _: () = assert!(TILE_PIXELS <= 1 << u16::BITS && LINE_HITS == u16::BITS as usize && CHUNK_HITS <= 1 << u16::BITS);

impl Segment {
    /// The offsets of pixel, lanes, hit and span, in bytes. Each has sixteen bits.
    pub(crate) const OFFSETS: [usize; 4] =
        [offset_of!(Self, pixel), offset_of!(Self, lanes), offset_of!(Self, hit), offset_of!(Self, span)];

    /// A segment of one hit: its pixel in the tile, its number in the group, and the number of its span in the chunk.
    ///
    /// # Panics
    /// A tile has no such pixel, or a chunk has no such span.
    pub(crate) fn new(pixel: u16, hit: u32, span: usize) -> Self {
        assert!(u32::from(pixel) < TILE_PIXELS && span < CHUNK_HITS, "a pixel of a tile, and a span of a chunk");
        Self { pixel, lanes: 1, hit: (hit % CHUNK_HITS as u32) as u16, span: span as u16 }
    }

    /// Adds the next hit of the chunk, if its pixel is after those of the segment and near enough. Whether it was
    /// added.
    pub(crate) fn extend(&mut self, pixel: u16) -> bool {
        let fits = usize::from(self.hit) + self.hits() < CHUNK_HITS;
        let lane = pixel.checked_sub(self.pixel).filter(|lane| fits && self.lanes.checked_shr((*lane).into()) == Some(0));
        self.lanes |= lane.map_or(0, |lane| 1 << lane);
        lane.is_some()
    }

    /// Adds the next hit of the chunk, if its pixel is the one after the last of the segment, and the segment has no
    /// gaps. Whether it was added.
    pub(crate) fn extend_run(&mut self, pixel: u16) -> bool {
        self.is_run() && usize::from(pixel) == usize::from(self.pixel) + self.hits() && self.extend(pixel)
    }

    /// The first pixel, counted from the tile's first. It is less than [`TILE_PIXELS`].
    #[inline]
    pub fn first_pixel(self) -> usize {
        self.pixel.into()
    }

    /// The last pixel, counted from the tile's first.
    #[inline]
    pub fn last_pixel(self) -> usize {
        self.first_pixel() + self.lanes.ilog2() as usize
    }

    /// A mask of the pixels that have a hit, from the first pixel on. The lowest bit is the first pixel, and is set.
    #[inline]
    pub fn lanes(self) -> u16 {
        self.lanes
    }

    /// The number of its first hit in the chunk, less than [`CHUNK_HITS`]. The others follow it in the same chunk.
    #[inline]
    pub fn first_hit(self) -> usize {
        self.hit.into()
    }

    /// The number of the span in its chunk, less than [`CHUNK_HITS`].
    #[inline]
    pub fn span(self) -> usize {
        self.span.into()
    }

    /// How many hits it has.
    #[inline]
    pub fn hits(self) -> usize {
        self.lanes.count_ones() as usize
    }

    /// Whether its pixels are neighbours.
    #[inline]
    pub fn is_run(self) -> bool {
        self.lanes & self.lanes.wrapping_add(1) == 0
    }

    /// Its pixels, counted from the tile's first, in the order of its hits.
    #[inline]
    pub fn pixels(self) -> impl Iterator<Item = usize> {
        let mut lanes = self.lanes;
        let next = move || {
            let lane = (lanes != 0).then(|| lanes.trailing_zeros() as usize);
            lanes &= lanes.wrapping_sub(1);
            lane
        };
        std::iter::from_fn(next).map(move |lane| self.first_pixel() + lane)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_take_pixels_that_are_near_enough_and_in_order() {
        let mut segment = Segment::new(7, 5, 2);
        assert!(segment.is_run() && segment.extend_run(8) && segment.is_run());
        assert!(!segment.extend_run(10) && !segment.extend(8) && !segment.extend(3));
        assert!(segment.extend(10) && !segment.is_run() && !segment.extend_run(11));
        assert!(segment.extend(22) && !segment.extend(23) && !segment.extend(22));
        assert_eq!(segment.pixels().collect::<Vec<_>>(), [7, 8, 10, 22]);
        assert_eq!((segment.first_pixel(), segment.last_pixel(), segment.hits()), (7, 22, 4));
        assert_eq!((segment.first_hit(), segment.span()), (5, 2));
    }

    #[test]
    fn a_segment_ends_with_its_chunk() {
        let mut segment = Segment::new(0, 2 * CHUNK_HITS as u32 - 2, 0);
        assert_eq!(segment.first_hit(), CHUNK_HITS - 2);
        assert!(segment.extend_run(1) && !segment.extend_run(2) && !segment.extend(5));
    }

    #[test]
    fn a_full_segment_has_sixteen_neighbours() {
        let mut segment = Segment::new(100, 0, 0);
        assert_eq!((101..200).filter(|pixel| segment.extend_run(*pixel)).count(), 15);
        assert!(segment.is_run() && segment.pixels().eq(100..116));
    }
}
