//! The compact store of a picture's hits: which pixels have a hit at the end of which path, and which emitters of
//! lights reach it.
//!
//! Surfaces are not stored, see [`super::replay`].
//!
//! The colour of a pixel is linear in the colours of its rays, so the tree of rays flattens into a sum over its paths:
//!
//! ```text
//! E(pixel) = Σ_hits weight(path) · [ Σ_emitters ki·local + ka·Cd·Ia ]  +  Σ_misses weight(path) · background
//! ```
//!
//! where weight(path) is the product of kr or kt of the bodies along it: equation (2) of thesis 4.2.3, multiplied out.
//!
//! All hits of a [`Group`] share the body and the emitters; all of a [`Span`] share the weight, too. Rays of
//! neighbouring pixels mostly go the same way, so the pixels of a span are stored as [`Segment`]s: what is computed for
//! the hits of a segment, side by side, is added to neighbouring pixels at once.

use crate::lang::variables::EvaluatedLights;
use crate::scene::BodyId;
use crate::trace::View;
use crate::trace::primitives::PrimitiveTable;
use crate::trace::segment::{Segment, TILE_PIXELS};
use crate::trace::visibility::VisibilityTable;
use crate::trace::walk::Edge;
use crate::world::{EmitterId, World};
use smallvec::SmallVec;
use std::ops::{Add, Range};
use std::sync::{Arc, OnceLock};

/// A path, by its index in the list of its tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PathId(pub u32);

impl PathId {
    /// The id as an index into [`Tile::paths`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The way of a ray from the camera: its last step, and the path before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Path {
    /// The path to the hit from which the last ray comes, with a lower id; `None`: it comes from the camera.
    pub parent: Option<PathId>,
    /// How the last ray came to be.
    pub edge: Edge,
    /// The body that it hit; `None`: it left the scene.
    pub body: Option<BodyId>,
}

/// Consecutive hits, or misses, of one path, in the order of their pixels. The hits lie in one chunk of their group,
/// which is [`CHUNK_HITS`](crate::trace::segment::CHUNK_HITS) hits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Span {
    /// The path.
    pub path: PathId,
    /// Their numbers. The hits of a tile are counted in the order of groups, spans and pixels; misses are counted
    /// separately.
    pub hits: Range<u32>,
    /// Their pixels: indices into [`Tile::segments`], for misses into [`Tile::miss_segments`].
    pub segments: Range<u32>,
}

/// The hits of a tile on one body that exactly these emitters reach. Where many lights cast many shadows, few hits
/// share their emitters. Such hits are *scattered*: they are in one group for each of their emitters.
///
/// In the hits for all lights, a group is all hits on a body, and has all emitters, whether they reach the hits or not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// The body.
    pub body: BodyId,
    /// The emitters, in the order of their lights; empty where only the ambient light reaches.
    pub emitters: SmallVec<[EmitterId; 6]>,
    /// Whether its hits are scattered: the one emitter of the group is not the only one that reaches them.
    pub scattered: bool,
    /// The numbers of its hits in the tile. Each hit makes a lit record with each of the emitters.
    pub hits: Range<u32>,
    /// The same hits path by path, in the order of path ids: indices into [`Tile::spans`]. A pixel occurs at most once
    /// in a path.
    pub spans: Range<u32>,
}

// A region counts pixels in sixteen bits, and a tile the sets of their paths.
const _: () = assert!(TILE_PIXELS < 1 << 16);

/// Consecutive pixels whose rays took the same paths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// How many pixels, at least 1.
    pub pixels: u16,
    /// Index into [`Tile::path_sets`].
    pub set: u16,
}

/// Lists of paths, one after the other.
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

    /// The list of this number, which exists.
    pub(super) fn get(&self, set: u16) -> &[PathId] {
        let set = usize::from(set);
        let start = set.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.paths[start as usize..self.ends[set] as usize]
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
    /// The pixels, counted row by row from the top left of the picture.
    pub pixels: Range<u32>,
    /// Every path that a ray of these pixels took, parents before children, in the order of their first rays.
    pub paths: Vec<Path>,
    /// The triangles of hits on meshes. Both stores of a tile share them.
    pub primitives: Arc<PrimitiveTable>,
    /// The groups, ordered by body, by emitters, and by whether they are scattered.
    pub groups: Vec<Group>,
    /// How many copies of hits there are: a hit that is scattered over n groups has n − 1.
    pub copies: u32,
    /// The spans of all groups. A frame reads this data mostly from memory, so it is kept in few long lists.
    pub spans: Vec<Span>,
    /// The pixels of all hits, span by span.
    pub segments: Vec<Segment>,
    /// The rays that left the scene, path by path, in the order of path ids.
    pub misses: Vec<Span>,
    /// The pixels of all such rays, span by span.
    pub miss_segments: Vec<Segment>,
    /// All pixels of the tile in order, by the paths of their rays. What a ray adds regardless of its end point, such
    /// as the ambient light, is the same for all pixels of a region.
    pub regions: Vec<Region>,
    /// The sets of paths that regions refer to.
    pub path_sets: PathSets,
    /// Which emitters are visible from which hits; only where groups have emitters that do not reach their hits.
    pub visibility: Option<VisibilityTable>,
}

impl Tile {
    /// The steps of a path from the camera on, one for each ray: the first is the primary ray. Each is the path up to
    /// there, with how its last ray came to be and the body that this hits; `None`: it leaves the scene.
    pub fn steps(&self, path: PathId) -> Vec<(PathId, Edge, Option<BodyId>)> {
        let of = |id: PathId| Some((id, self.paths.get(id.index())?));
        let chain = std::iter::successors(of(path), |(_, path)| of(path.parent?));
        let mut steps: Vec<_> = chain.map(|(id, path)| (id, path.edge, path.body)).collect();
        steps.reverse();
        steps
    }

    /// The spans of a group.
    ///
    /// # Panics
    /// If the group is another tile's.
    pub fn spans_of(&self, group: &Group) -> &[Span] {
        &self.spans[group.spans.start as usize..group.spans.end as usize]
    }

    /// The pixels of a span of hits.
    ///
    /// # Panics
    /// If the span is another tile's and reaches beyond the hits of this one.
    pub fn segments_of(&self, span: &Span) -> &[Segment] {
        &self.segments[span.segments.start as usize..span.segments.end as usize]
    }

    /// The pixels of the hits of a span, counted from the tile's first, in the order of the hits.
    ///
    /// # Panics
    /// If the span is another tile's and reaches beyond the hits of this one.
    pub fn pixels_of(&self, span: &Span) -> impl Iterator<Item = usize> {
        self.segments_of(span).iter().flat_map(|segment| segment.pixels())
    }

    /// Whether no body lies between a hit and an emitter of its group. `hit` is its number in the tile.
    ///
    /// # Panics
    /// If the tile has fewer hits.
    pub fn is_visible(&self, hit: u32, emitter: EmitterId) -> bool {
        // An emitter that reaches a hit is visible.
        self.visibility.as_ref().is_none_or(|table| table.get(hit, emitter))
    }

    /// The pixels of a span of misses.
    ///
    /// # Panics
    /// If the span is another tile's and reaches beyond the misses of this one.
    pub fn miss_segments_of(&self, span: &Span) -> &[Segment] {
        &self.miss_segments[span.segments.start as usize..span.segments.end as usize]
    }

    /// How much is in the tile.
    pub fn counts(&self) -> Counts {
        let lit = |group: &Group| group.hits.len() as u64 * group.emitters.len() as u64;
        Counts {
            hits: self.groups.last().map_or(0, |group| u64::from(group.hits.end)) - u64::from(self.copies),
            records: self.groups.iter().map(lit).sum(),
            paths: self.paths.len() as u64,
            groups: self.groups.len() as u64,
            misses: self.misses.last().map_or(0, |span| span.hits.end.into()),
        }
    }

    /// The memory that it takes, in bytes.
    pub fn bytes(&self) -> u64 {
        let spilled = self.groups.iter().filter(|group| group.emitters.spilled()).map(|group| size_of_val(&*group.emitters));
        let lists =
            size_of_val(&*self.paths) + size_of_val(&*self.groups) + size_of_val(&*self.spans) + size_of_val(&*self.misses);
        let sets = size_of_val(&*self.path_sets.paths) + size_of_val(&*self.path_sets.ends);
        let pixels = size_of_val(&*self.segments) + size_of_val(&*self.miss_segments) + size_of_val(&*self.regions) + sets;
        let visibility = self.visibility.as_ref().map_or(0, VisibilityTable::bytes);
        // The second store shares it.
        let primitives = if self.visibility.is_none() { self.primitives.bytes() } else { 0 };
        (size_of::<Self>() + spilled.sum::<usize>() + lists + pixels + visibility + primitives) as u64
    }
}

/// How many of each there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Hits.
    pub hits: u64,
    /// Records: pairs of a hit and an emitter that reaches it.
    pub records: u64,
    /// Paths; one that occurs in several tiles is counted in each.
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
#[derive(Debug, Clone)]
pub struct Hits {
    /// The world that was traced.
    pub world: Arc<World>,
    /// The view that was traced.
    pub view: View,
    /// [`tile_pixels`](crate::trace::segment::tile_pixels) pixels each, in the order of pixels; the last one has the
    /// rest.
    pub tiles: Vec<Tile>,
    /// The emitters of the groups: those that reach the hits, or all.
    pub(super) of: EvaluatedLights,
    /// The same hits for all lights, once they are needed, see [`super::all_lights`].
    pub(super) all_lights: OnceLock<Arc<Hits>>,
}

impl Hits {
    /// Hits with the emitters that reach them.
    pub(super) fn new(world: &Arc<World>, view: View, tiles: Vec<Tile>) -> Self {
        let world = Arc::clone(world);
        Self { world, view, tiles, of: EvaluatedLights::Reaching, all_lights: OnceLock::new() }
    }

    /// No hits, for evaluators that trace for themselves.
    pub fn untraced(world: &Arc<World>, view: View) -> Self {
        Self::new(world, view, Vec::new())
    }

    /// How much is in the picture.
    pub fn counts(&self) -> Counts {
        self.tiles.iter().map(Tile::counts).fold(Counts::default(), Counts::add)
    }

    /// The memory that it takes, in bytes, without the world.
    pub fn bytes(&self) -> u64 {
        let second = self.all_lights.get().map_or(0, |all| all.bytes());
        self.tiles.iter().map(Tile::bytes).sum::<u64>() + second
    }
}
