//! The hits of a picture, kept compactly: not the surfaces (see [`super::replay`] for those) but which pixels' rays came by
//! which path to which body, and which lights reach them.
//!
//! The colour of a pixel is linear in its rays' colours, so the tree of rays flattens into a sum over its paths:
//!
//! ```text
//! E(pixel) = Σ_hits weight(path) · [ Σ_lit lights ki·local + ka·Cd·Ia ]  +  Σ_misses weight(path) · background
//! ```
//!
//! where weight(path) is the product of kr or kt of the bodies along it: equation (2) of thesis 4.2.3, multiplied out.
//! Within a [`Group`] the body and the lights are the same, within a [`Span`] the weight too. Rays of neighbouring pixels mostly go
//! the same way, so a span is stored as [`Block`]s of up to four hits in consecutive pixels: what is computed for a block's
//! four lanes is added to four neighbouring pixels at once.

use crate::scene::{BodyId, LightId};
use crate::trace::View;
use crate::trace::walk::Edge;
use std::ops::{Add, Range};

/// How many consecutive pixels make a tile. It is fixed, so that sums are taken in the same order on any machine.
pub const TILE_PIXELS: u32 = 16_384;

/// How many hits a block holds at most.
pub const BLOCK_LANES: usize = 4;

// A block keeps its first pixel's place in the tile in fourteen bits, and the number of its hits in two.
// A region counts them in sixteen bits, and a tile has no more sets of paths than pixels.
const _: () = assert!(TILE_PIXELS <= 1 << Block::PIXEL_BITS && BLOCK_LANES <= 1 << (16 - Block::PIXEL_BITS));

/// One to four hits, or misses, in consecutive pixels; the lanes beyond are dead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block(u16);

impl Block {
    const PIXEL_BITS: u32 = 14;

    /// The first hit of a block.
    pub(super) fn new(pixel: u16) -> Self {
        debug_assert!(u32::from(pixel) < TILE_PIXELS);
        Self(pixel)
    }

    /// A block of so many hits, 1..=4, from this pixel of a tile on.
    #[cfg(test)]
    pub(crate) fn of(pixel: usize, lanes: usize) -> Self {
        Self(pixel as u16 | ((lanes - 1) as u16) << Self::PIXEL_BITS)
    }

    /// Takes one more hit in, if it is the next pixel's and there is room.
    pub(super) fn extend(&mut self, pixel: u16) -> bool {
        let fits = self.lanes() < BLOCK_LANES && usize::from(pixel) == self.pixel() + self.lanes();
        if fits {
            self.0 += 1 << Self::PIXEL_BITS;
        }
        fits
    }

    /// The pixel of the first lane, counted from the tile's first.
    #[inline]
    pub fn pixel(self) -> usize {
        usize::from(self.0) & ((1 << Self::PIXEL_BITS) - 1)
    }

    /// Whether these blocks of one span, in their order, hold sixteen neighbouring pixels.
    #[inline]
    pub fn are_neighbours(blocks: &[Block; 4]) -> bool {
        // Pixels grow by at least as much as a block has lanes: where all are full and the last is where it would be, nothing is between.
        let full = (BLOCK_LANES as u16 - 1) << Self::PIXEL_BITS;
        let [first, .., last] = blocks;
        let all_full = blocks.iter().fold(full, |bits, block| bits & block.0) == full;
        all_full && last.pixel() == first.pixel() + 3 * BLOCK_LANES
    }

    /// How many hits it holds, 1..=4.
    #[inline]
    pub fn lanes(self) -> usize {
        1 + usize::from(self.0 >> Self::PIXEL_BITS)
    }
}

/// A path by its place in its tile's list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PathId(pub u32);

impl PathId {
    /// The id as an index into [`Tile::paths`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The way of a ray from the camera: its last step, and where that began.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Path {
    /// The path to the hit from which the last ray comes; `None`: from the camera. Its id is the lower one.
    pub parent: Option<PathId>,
    /// How the last ray came to be.
    pub edge: Edge,
    /// The body that it hit; `None`: it left the scene.
    pub body: Option<BodyId>,
}

/// Consecutive hits, or misses, of one path, in the order of their pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Span {
    /// The path.
    pub path: PathId,
    /// Indices into [`Tile::blocks`], of misses into [`Tile::miss_blocks`].
    pub blocks: Range<u32>,
}

/// The hits of a tile on one body that exactly these lights reach.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// The body.
    pub body: BodyId,
    /// The lights, in the order of declaration; none where only the ambient light reaches.
    pub lights: Box<[LightId]>,
    /// Indices into [`Tile::blocks`].
    pub blocks: Range<u32>,
    /// The same hits path by path, in the order of path ids. A path occurs once, and in it a pixel at most once.
    pub spans: Box<[Span]>,
}

/// Consecutive pixels whose rays went the same ways.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// How many pixels.
    pub pixels: u16,
    /// Index into [`Tile::path_sets`].
    pub set: u16,
}

/// Lists of paths, one behind the other.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PathSets {
    pub(super) paths: Vec<PathId>,
    /// Where each list ends.
    pub(super) ends: Vec<u32>,
}

impl PathSets {
    /// Every list, in order.
    pub fn iter(&self) -> impl Iterator<Item = &[PathId]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| &self.paths[start as usize..*end as usize])
    }

    /// How many lists there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }
}

/// The hits of some consecutive pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tile {
    /// The pixels, counted row by row from the left upper corner of the picture.
    pub pixels: Range<u32>,
    /// Every path that a ray of these pixels took, parents before children, in the order in which they were met first.
    pub paths: Vec<Path>,
    /// The groups, ordered by body and then by lights.
    pub groups: Vec<Group>,
    /// The pixels of all hits, by fours.
    pub blocks: Vec<Block>,
    /// The rays that left the scene, path by path, in the order of path ids.
    pub misses: Vec<Span>,
    /// The pixels of all such rays, by fours.
    pub miss_blocks: Vec<Block>,
    /// All pixels in order, by the paths of their rays: what a ray adds wherever it ended, such as the ambient light, is the same in a region.
    pub regions: Vec<Region>,
    /// The paths of the rays of each region.
    pub path_sets: PathSets,
}

impl Tile {
    /// The steps of a path from the camera on; the last one's body is where it ends.
    pub fn steps(&self, path: PathId) -> Vec<(Edge, Option<BodyId>)> {
        let chain = std::iter::successors(self.paths.get(path.index()), |path| self.paths.get(path.parent?.index()));
        let mut steps: Vec<_> = chain.map(|path| (path.edge, path.body)).collect();
        steps.reverse();
        steps
    }

    /// The blocks of a group, or of a part of it.
    ///
    /// # Panics
    /// If the range reaches beyond the blocks of this tile.
    pub fn blocks_of(&self, blocks: &Range<u32>) -> &[Block] {
        &self.blocks[blocks.start as usize..blocks.end as usize]
    }

    /// The blocks of a span of misses.
    ///
    /// # Panics
    /// If the span is another tile's and reaches beyond the misses of this one.
    pub fn misses_of(&self, span: &Span) -> &[Block] {
        &self.miss_blocks[span.blocks.start as usize..span.blocks.end as usize]
    }

    /// What is in the tile.
    pub fn counts(&self) -> Counts {
        let lit = |group: &Group| lanes(self.blocks_of(&group.blocks)) * group.lights.len() as u64;
        Counts {
            hits: lanes(&self.blocks),
            records: self.groups.iter().map(lit).sum(),
            paths: self.paths.len() as u64,
            groups: self.groups.len() as u64,
            misses: lanes(&self.miss_blocks),
        }
    }

    /// The memory it takes, in bytes.
    pub fn bytes(&self) -> u64 {
        let groups = self.groups.iter().map(|group| size_of_val(&*group.lights) + size_of_val(&*group.spans));
        let lists = size_of_val(&*self.paths) + size_of_val(&*self.groups) + size_of_val(&*self.misses);
        let sets = size_of_val(&*self.path_sets.paths) + size_of_val(&*self.path_sets.ends);
        let pixels = size_of_val(&*self.blocks) + size_of_val(&*self.miss_blocks) + size_of_val(&*self.regions) + sets;
        (size_of::<Self>() + groups.sum::<usize>() + lists + pixels) as u64
    }
}

/// How many hits are in these blocks.
fn lanes(blocks: &[Block]) -> u64 {
    blocks.iter().map(|block| block.lanes() as u64).sum()
}

/// How much there is of everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Hits.
    pub hits: u64,
    /// Records: pairs of a hit and a light that reaches it.
    pub records: u64,
    /// Paths; one that occurs in several tiles counts in each.
    pub paths: u64,
    /// Groups, counted likewise.
    pub groups: u64,
    /// Rays that left the scene.
    pub misses: u64,
}

impl Add for Counts {
    type Output = Counts;

    fn add(self, other: Counts) -> Counts {
        Counts {
            hits: self.hits + other.hits,
            records: self.records + other.records,
            paths: self.paths + other.paths,
            groups: self.groups + other.groups,
            misses: self.misses + other.misses,
        }
    }
}

/// The hits of a whole picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Hits {
    /// The view that was traced.
    pub view: View,
    /// [`TILE_PIXELS`] pixels each, the last one what is left, in the order of pixels.
    pub tiles: Vec<Tile>,
}

impl Hits {
    /// What is in the picture.
    pub fn counts(&self) -> Counts {
        self.tiles.iter().map(Tile::counts).fold(Counts::default(), Counts::add)
    }

    /// The memory it takes, in bytes.
    pub fn bytes(&self) -> u64 {
        self.tiles.iter().map(Tile::bytes).sum()
    }
}
