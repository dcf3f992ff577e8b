//! Builds a tile of the store: sorts the hits of its pixels into groups and spans while they are traced.
//!
//! Pixels come in order, and a path ends at most once in a pixel. So the list of pixels of each (path, emitter set) is
//! sorted as it grows, and only the lists themselves are sorted at the end.

use crate::scene::BodyId;
use crate::trace::primitives::PrimitiveTable;
use crate::trace::segment::{CHUNK_HITS, Segment};
use crate::trace::store::{Group, Path, PathId, PathSets, Region, Span, Tile};
use crate::trace::walk::Edge;
use crate::world::{EmitterId, PrimitiveId};
use foldhash::{HashMap, HashSet};
use smallvec::SmallVec;
use std::ops::Range;
use std::sync::Arc;

/// About what a path, an emitter set or a list of pixels takes in the tables of the builder, hits aside, in bytes. An
/// eighth of it remains in the store.
pub(super) const BYTES_PER_ENTRY: u64 = 128;

/// The hits of a tile so far.
#[derive(Default)]
pub(super) struct TileBuilder {
    paths: Vec<Path>,
    path_ids: HashMap<Path, PathId>,
    /// What came last after the camera.
    first: LatestPaths,
    /// What came last after and by each path.
    latest: Vec<Latest>,
    emitter_sets: Vec<Vec<EmitterId>>,
    emitter_set_ids: HashMap<Vec<EmitterId>, u32>,
    /// The pixels of the hits that came by a path and are reached by an emitter set.
    hits: Vec<((PathId, u32), Vec<u16>)>,
    hit_indices: HashMap<(PathId, u32), usize>,
    misses: Vec<(PathId, Vec<u16>)>,
    /// The hits on meshes in the order of their pixels: the index of the path, the pixel and the triangle.
    primitives: Vec<(usize, u16, PrimitiveId)>,
    /// The paths of the current pixel.
    pixel: Vec<PathId>,
    regions: Vec<Region>,
    path_sets: PathSets,
    path_set_ids: HashMap<Vec<PathId>, u16>,
}

/// For each edge, where a ray went last: the body that it hit, if any, and the path.
type LatestPaths = [Option<(Option<BodyId>, PathId)>; 3];

/// What was last on a path. Rays of neighbouring pixels mostly go the same way, so tables are seldom looked up.
#[derive(Clone, Copy, Default)]
struct Latest {
    next: LatestPaths,
    /// The emitter set, and the index of the list in `hits`.
    hit: Option<(u32, usize)>,
    /// The index of the list in `misses`.
    miss: Option<usize>,
}

impl TileBuilder {
    /// Ends a pixel, after all its rays.
    pub(super) fn finish_pixel(&mut self) {
        if let Some(last) = self.regions.last_mut()
            && self.path_sets.get(last.set) == self.pixel
        {
            last.pixels += 1;
            self.pixel.clear();
            return;
        }
        let set = match self.path_set_ids.get(&self.pixel) {
            Some(set) => *set,
            None => {
                // There are no more of them than pixels.
                let set = self.path_sets.len() as u16;
                self.path_sets.paths.extend_from_slice(&self.pixel);
                self.path_sets.ends.push(self.path_sets.paths.len() as u32);
                self.path_set_ids.insert(self.pixel.clone(), set);
                set
            }
        };
        self.pixel.clear();
        self.regions.push(Region { pixels: 1, set });
    }

    /// The path that continues `parent` along `edge` to `body`, or out of the scene.
    pub(super) fn path(&mut self, parent: Option<PathId>, edge: Edge, body: Option<BodyId>) -> PathId {
        let latest = parent.map_or(self.first, |parent| self.latest[parent.index()].next)[edge as usize];
        if let Some((last, id)) = latest
            && last == body
        {
            return id;
        }
        let path = Path { parent, edge, body };
        let id = *self.path_ids.entry(path).or_insert_with(|| {
            // A tile has at most 2¹⁴ pixels with 2⁹ hits and as many misses each.
            let id = PathId(self.paths.len() as u32);
            self.paths.push(path);
            self.latest.push(Latest::default());
            id
        });
        let latest = parent.map_or(&mut self.first, |parent| &mut self.latest[parent.index()].next);
        latest[edge as usize] = Some((body, id));
        id
    }

    /// Adds a hit by `path` in the tile's pixel `pixel`; `emitters` reach it.
    pub(super) fn hit(&mut self, path: PathId, emitters: &[EmitterId], pixel: u16) {
        self.pixel.push(path);
        let latest = self.latest[path.index()].hit.filter(|(set, _)| self.emitter_sets[*set as usize] == emitters);
        let (set, list) = latest.unwrap_or_else(|| {
            let set = self.emitter_set(emitters);
            let list = *self.hit_indices.entry((path, set)).or_insert_with(|| {
                self.hits.push(((path, set), Vec::new()));
                self.hits.len() - 1
            });
            (set, list)
        });
        self.latest[path.index()].hit = Some((set, list));
        self.hits[list].1.push(pixel);
    }

    fn emitter_set(&mut self, emitters: &[EmitterId]) -> u32 {
        if let Some(set) = self.emitter_set_ids.get(emitters) {
            return *set;
        }
        // There are no more of them than hits.
        let set = self.emitter_sets.len() as u32;
        self.emitter_sets.push(emitters.to_vec());
        self.emitter_set_ids.insert(emitters.to_vec(), set);
        set
    }

    /// Keeps the triangle of a hit on a mesh by `path` in the tile's pixel `pixel`.
    pub(super) fn primitive(&mut self, path: PathId, pixel: u16, primitive: PrimitiveId) {
        self.primitives.push((path.index(), pixel, primitive));
    }

    /// Adds a ray that left the scene by `path` in the tile's pixel `pixel`.
    pub(super) fn miss(&mut self, path: PathId, pixel: u16) {
        self.pixel.push(path);
        let list = *self.latest[path.index()].miss.get_or_insert_with(|| {
            self.misses.push((path, Vec::new()));
            self.misses.len() - 1
        });
        self.misses[list].1.push(pixel);
    }

    /// How many entries the tables have, hits aside.
    pub(super) fn entries(&self) -> u64 {
        let lists = self.paths.len() + self.emitter_sets.len() + self.hits.len() + self.misses.len() + self.path_sets.len();
        // Regions, and the paths in sets, are far smaller than an entry.
        (lists + (self.regions.len() + self.path_sets.paths.len()) / 8) as u64
    }

    /// The finished tile.
    pub(super) fn tile(self, pixels: Range<u32>) -> Tile {
        let (lists, copies) = hit_lists(self.hits, &self.emitter_sets, &self.paths);
        let (groups, spans, segments) = grouped(&lists);
        let mut missed = self.misses;
        missed.sort_unstable_by_key(|(path, _)| *path);
        let mut all_missed = Pixels::default();
        let misses = missed.iter().map(|(path, pixels)| all_missed.span(*path, pixels, 0)).collect();
        let mut miss_segments = all_missed.segments;
        let (mut paths, mut regions, mut path_sets) = (self.paths, self.regions, self.path_sets);
        let primitives = Arc::new(PrimitiveTable::new(&self.primitives, paths.len()));
        paths.shrink_to_fit();
        miss_segments.shrink_to_fit();
        regions.shrink_to_fit();
        path_sets.paths.shrink_to_fit();
        path_sets.ends.shrink_to_fit();
        Tile {
            pixels,
            paths,
            primitives,
            groups,
            copies,
            spans,
            segments,
            misses,
            miss_segments,
            regions,
            path_sets,
            visibility: None,
        }
    }
}

/// The groups of these lists, which are in the order of what groups and spans share, with their spans and segments.
pub(super) fn grouped(lists: &[HitList]) -> (Vec<Group>, Vec<Span>, Vec<Segment>) {
    let (mut all, mut spans) = (Pixels::default(), Vec::new());
    let groups = lists.chunk_by(|a, b| a.group() == b.group()).map(|lists| group(lists, &mut all, &mut spans)).collect();
    let mut segments = all.segments;
    spans.shrink_to_fit();
    segments.shrink_to_fit();
    (groups, spans, segments)
}

/// The group of these lists, which share body and emitters, behind the hits and spans so far. There is at least one
/// list.
fn group(lists: &[HitList], all: &mut Pixels, spans: &mut Vec<Span>) -> Group {
    let start = all.begin_group();
    let first = spans.len() as u32;
    let mut in_chunk = 0;
    for list in lists {
        let mut rest = &*list.pixels;
        while !rest.is_empty() {
            let (here, later) = rest.split_at(rest.len().min(all.left_in_chunk()));
            if all.left_in_chunk() == CHUNK_HITS {
                in_chunk = 0;
            }
            spans.push(all.span(list.path, here, in_chunk));
            in_chunk += 1;
            rest = later;
        }
    }
    let HitList { body, emitters, scattered, .. } = &lists[0];
    let (hits, spans) = (start..all.hits, first..spans.len() as u32);
    Group { body: *body, emitters: emitters.clone(), scattered: *scattered, hits, spans }
}

/// The hits of one path on a body that one emitter set reaches; or scattered ones that one emitter reaches, among
/// others.
pub(super) struct HitList {
    pub(super) body: BodyId,
    pub(super) emitters: SmallVec<[EmitterId; 6]>,
    pub(super) scattered: bool,
    pub(super) path: PathId,
    /// In order.
    pub(super) pixels: Vec<u16>,
}

impl HitList {
    /// What the hits of a group share.
    fn group(&self) -> (BodyId, &[EmitterId], bool) {
        (self.body, &self.emitters, self.scattered)
    }
}

/// Groups of fewer hits may be scattered. Starting with an emitter of a group costs as much as about thirty hits.
/// Adding to pixels for each emitter separately costs less, the longer the groups are that result.
const SMALL_GROUP: usize = 24;
/// They are scattered if that leaves at most one in this many pairs of a group and an emitter.
const MIN_REDUCTION: usize = 4;

/// The hits by what groups and spans share, in the order of these; and how many copies there are of hits that are in
/// several groups.
fn hit_lists(hits: Vec<((PathId, u32), Vec<u16>)>, sets: &[Vec<EmitterId>], paths: &[Path]) -> (Vec<HitList>, u32) {
    let body_of = |path: PathId| paths.get(path.index()).and_then(|path| path.body);
    let emitters_of = |set: u32| sets.get(set as usize).map_or(&[][..], Vec::as_slice);
    let mut sizes: HashMap<(BodyId, u32), usize> = HashMap::default();
    for ((path, set), pixels) in &hits {
        if let Some(body) = body_of(*path) {
            *sizes.entry((body, *set)).or_default() += pixels.len();
        }
    }
    let is_small = |body: BodyId, set: u32| emitters_of(set).len() > 1 && sizes[&(body, set)] < SMALL_GROUP;
    // For each body: the pairs of a small group and an emitter, and the emitters.
    let mut small: HashMap<BodyId, (usize, HashSet<EmitterId>)> = HashMap::default();
    for (body, set) in sizes.keys().filter(|(body, set)| is_small(*body, *set)) {
        let (pairs, emitters) = small.entry(*body).or_default();
        *pairs += emitters_of(*set).len();
        emitters.extend(emitters_of(*set));
    }
    let is_scattered = |body| small.get(&body).is_some_and(|(pairs, emitters)| *pairs >= MIN_REDUCTION * emitters.len());
    let mut lists = Vec::with_capacity(hits.len());
    let mut scattered: HashMap<(BodyId, EmitterId, PathId), Vec<u16>> = HashMap::default();
    let mut copies = 0;
    for ((path, set), pixels) in hits {
        let Some(body) = body_of(path) else { continue };
        let emitters = emitters_of(set);
        if is_small(body, set) && is_scattered(body) {
            // No more than records, of which there are fewer than 2³².
            copies += (pixels.len() * (emitters.len() - 1)) as u32;
            for emitter in emitters {
                scattered.entry((body, *emitter, path)).or_default().extend_from_slice(&pixels);
            }
        } else {
            lists.push(HitList { body, emitters: emitters.into(), scattered: false, path, pixels });
        }
    }
    for ((body, emitter, path), mut pixels) in scattered {
        pixels.sort_unstable();
        lists.push(HitList { body, emitters: [emitter].as_slice().into(), scattered: true, path, pixels });
    }
    lists.sort_unstable_by(|a, b| (a.group(), a.path).cmp(&(b.group(), b.path)));
    (lists, copies)
}

/// Segments have gaps if their number then is at most this fraction of that of segments without.
const GAIN_OF_GAPS: (usize, usize) = (3, 4);

/// The pixels of hits, or of misses, one after the other.
#[derive(Default)]
struct Pixels {
    segments: Vec<Segment>,
    hits: u32,
    /// The first hit of the group.
    group: u32,
}

impl Pixels {
    /// Begins a group, in lines of its own, and returns the number of its first hit.
    fn begin_group(&mut self) -> u32 {
        self.group = self.hits;
        self.hits
    }

    /// How many hits of the group still fit the current chunk.
    fn left_in_chunk(&self) -> usize {
        CHUNK_HITS - (self.hits - self.group) as usize % CHUNK_HITS
    }

    /// Adds the pixels of a path, in segments of their own, behind those so far. `in_chunk` is the number of the span
    /// in its chunk.
    fn span(&mut self, path: PathId, pixels: &[u16], in_chunk: usize) -> Span {
        let (start, first) = (self.segments.len(), self.hits);
        self.segments(pixels, in_chunk, Segment::extend_run);
        let runs = self.segments.len() - start;
        if runs > 1 {
            // Segments with gaps are added by code that costs more for each.
            let with_gaps = self.segments.len();
            self.segments(pixels, in_chunk, Segment::extend);
            if (self.segments.len() - with_gaps) * GAIN_OF_GAPS.1 <= runs * GAIN_OF_GAPS.0 {
                self.segments.drain(start..with_gaps);
            } else {
                self.segments.truncate(with_gaps);
            }
        }
        // A tile has at most 2¹⁴ pixels with 2⁹ hits and as many misses each.
        self.hits += pixels.len() as u32;
        Span { path, hits: first..self.hits, segments: start as u32..self.segments.len() as u32 }
    }

    /// Adds segments of these pixels. `extend` adds the next pixel to a segment if it can.
    fn segments(&mut self, pixels: &[u16], in_chunk: usize, extend: fn(&mut Segment, u16) -> bool) {
        let start = self.segments.len();
        for (hit, pixel) in (self.hits - self.group..).zip(pixels) {
            let extended = self.segments[start..].last_mut().is_some_and(|segment| extend(segment, *pixel));
            if !extended {
                self.segments.push(Segment::new(*pixel, hit, in_chunk));
            }
        }
    }
}
