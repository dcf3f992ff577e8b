//! The tables of a tile that the kernel reads beside columns: which rays a pixel has, and where their hits are among
//! the lines of the columns.
//!
//! The kernel evaluates the recursive equation for each pixel. So a ray of a pixel is listed after the rays that go on
//! from it: the value of a hit is computed when their values are known. Pixels whose
//! rays took the same paths share a list.

use crate::backends::compiled::columns::Columns;
use crate::backends::compiled::surface::SurfaceTile;
use crate::trace::{Edge, LINE_HITS, Mismatch, Path, PathId, Tile, Tracer, replay_misses};
use crate::world::World;
use std::collections::BTreeMap;

/// No place, or no body.
pub(super) const NONE: u32 = u32::MAX;
/// Marks the place of a hit that is in several groups: the rest is where the list of its places is.
pub(super) const SEVERAL: u32 = 1 << 31;

/// A ray in the list of a set of paths.
#[derive(Debug, Clone, Copy)]
pub(super) struct SetRay {
    /// The body that it hit, or [`NONE`].
    body: u32,
    /// The body that it comes from, or [`NONE`].
    from: u32,
    /// How many rays come before it on its path.
    level: u32,
    edge: Edge,
    /// Its number among the hits, or the misses, of a pixel.
    number: u32,
    /// How many rays of the list go on from it: those just before it.
    behind: usize,
}

impl SetRay {
    /// The index of its weight, if it has one: that of the reflected ray of body 0, that of the refracted one, those of
    /// body 1.
    fn weight(&self) -> Option<usize> {
        let edge = edge_number(self.edge);
        edge.checked_sub(1).map(|edge| 2 * self.from as usize + edge as usize)
    }
}

fn edge_number(edge: Edge) -> u32 {
    match edge {
        Edge::Primary => 0,
        Edge::Reflected => 1,
        Edge::Refracted => 2,
    }
}

/// The rays of a set that have a weight, as the kernel reads them. `lives` says which weights are not 0.
pub(super) fn live_rays(rays: &[SetRay], lives: &[bool]) -> Vec<[u32; 2]> {
    let mut live: Vec<[u32; 2]> = Vec::with_capacity(rays.len());
    // Where the last ray of each level is.
    let mut last: Vec<usize> = Vec::new();
    let mut rest = rays;
    while let Some((ray, before)) = rest.split_last() {
        if ray.weight().is_some_and(|weight| !lives[weight]) {
            rest = &before[..before.len() - ray.behind];
            continue;
        }
        rest = before;
        let level = ray.level as usize;
        let edge = edge_number(ray.edge);
        if let Some(parent) = level.checked_sub(1).and_then(|level| live.get_mut(last[level])) {
            parent[1] |= edge << 6;
        }
        last.truncate(level);
        last.push(live.len());
        live.push([ray.body, ray.number << 8 | edge << 4 | ray.level]);
    }
    live.reverse();
    live
}

/// The rays of a set of paths, and the number of each path.
struct RaySet {
    rays: Vec<SetRay>,
    /// Each path with its number among hits or misses, sorted.
    numbers: Vec<(PathId, u32)>,
    hits: u32,
    misses: u32,
}

impl RaySet {
    fn new(paths: &[PathId], all: &[Path]) -> Self {
        let mut set = Self { rays: Vec::with_capacity(paths.len()), numbers: Vec::new(), hits: 0, misses: 0 };
        enum Step {
            Enter(PathId, u32),
            Leave(PathId, u32, usize),
        }
        let mut next: Vec<(Option<PathId>, PathId)> = paths.iter().map(|path| (all[path.index()].parent, *path)).collect();
        next.sort_unstable();
        let after = |path: Option<PathId>| {
            let first = next.partition_point(|(parent, _)| *parent < path);
            next[first..].iter().take_while(move |(parent, _)| *parent == path).map(|(_, path)| *path)
        };
        let mut steps: Vec<Step> = after(None).map(|path| Step::Enter(path, 0)).collect();
        while let Some(step) = steps.pop() {
            match step {
                Step::Enter(path, level) => {
                    steps.push(Step::Leave(path, level, set.rays.len()));
                    steps.extend(after(Some(path)).map(|next| Step::Enter(next, level + 1)));
                }
                Step::Leave(id, level, before) => {
                    let path = all[id.index()];
                    let counter = if path.body.is_some() { &mut set.hits } else { &mut set.misses };
                    let number = *counter;
                    *counter += 1;
                    set.numbers.push((id, number));
                    let from = path.parent.and_then(|parent| all[parent.index()].body);
                    set.rays.push(SetRay {
                        body: path.body.map_or(NONE, |body| body.0),
                        from: from.map_or(NONE, |body| body.0),
                        level,
                        edge: path.edge,
                        number,
                        behind: set.rays.len() - before,
                    });
                }
            }
        }
        set.numbers.sort_unstable();
        set
    }

    /// The number of a path among hits or misses. Paths of another set have none, and do not occur.
    fn number(&self, path: PathId) -> Option<u32> {
        let at = self.numbers.binary_search_by_key(&path, |(known, _)| *known);
        at.ok().map(|at| self.numbers[at].1)
    }
}

/// The tables of one or more tiles. Numbers of lines, lists and sets count from the first of the tables.
#[derive(Default)]
pub(super) struct Tables {
    /// For each line of hits: see `picture.wgsl`.
    pub(super) lines: Vec<[u32; 4]>,
    pub(super) lists: Vec<u32>,
    /// For each pixel: the first hit, the first miss, and the set.
    pub(super) pixels: Vec<[u32; 3]>,
    pub(super) sets: Vec<Vec<SetRay>>,
    pub(super) places: Vec<u32>,
    /// Empty if the formula gives nothing at every hit.
    pub(super) nodes: Vec<u32>,
    /// Empty without an environment.
    pub(super) radiance: Vec<[f32; 3]>,
    /// The lines of columns before the next tile, and those of nodes.
    column_lines: u32,
    node_lines: u32,
}

/// What the tables of a tile are made from.
pub(super) struct TileSource<'t> {
    pub(super) tile: &'t Tile,
    pub(super) columns: &'t Columns,
    pub(super) surface: Option<&'t SurfaceTile>,
}

/// The pixels of a tile that is worked on.
struct TilePixels {
    sets: Vec<RaySet>,
    /// For each pixel: the first hit, the first miss, and the set.
    pixels: Vec<[u32; 3]>,
    hits: usize,
    misses: usize,
}

impl TilePixels {
    fn new(tile: &Tile) -> Self {
        let sets: Vec<RaySet> = tile.path_sets.iter().map(|paths| RaySet::new(paths, &tile.paths)).collect();
        let mut pixels = Vec::with_capacity(tile.pixels.len());
        let (mut hits, mut misses) = (0, 0);
        for region in &tile.regions {
            let set = &sets[usize::from(region.set)];
            for _ in 0..region.pixels {
                pixels.push([hits, misses, u32::from(region.set)]);
                hits += set.hits;
                misses += set.misses;
            }
        }
        Self { sets, pixels, hits: hits as usize, misses: misses as usize }
    }

    /// Where the hit or the miss of a path in a pixel is among those of the tile. `which` is 0 for hits and 1 for
    /// misses.
    fn slot(&self, pixel: usize, path: PathId, which: usize) -> Result<usize, Mismatch> {
        let own = self.pixels.get(pixel).ok_or(Mismatch)?;
        let number = self.sets[own[2] as usize].number(path).ok_or(Mismatch)?;
        Ok((own[which] + number) as usize)
    }
}

impl Tables {
    /// The tables of a tile.
    ///
    /// # Errors
    /// The tile is not one of the tracer's world and view.
    pub(super) fn of_tile(source: &TileSource, tracer: &Tracer) -> Result<Self, Mismatch> {
        let TileSource { tile, columns, surface } = *source;
        let pixels = TilePixels::new(tile);
        let mut tables = Self { places: vec![NONE; pixels.hits], ..Self::default() };
        tables.place_hits(tile, columns, &pixels, tracer.world())?;
        if let Some(surface) = surface {
            tables.nodes = vec![0; pixels.hits];
            for (path, _) in tile.paths.iter().enumerate().filter(|(_, path)| path.body.is_some()) {
                for (node, pixel) in surface.nodes_of(path) {
                    // A tile has fewer than 2³² paths.
                    tables.nodes[pixels.slot(usize::from(pixel), PathId(path as u32), 0)?] = node;
                }
            }
            tables.node_lines = surface.node_lines();
        }
        if let Some(environment) = tracer.world().environment() {
            tables.radiance = vec![[0.0; 3]; pixels.misses];
            for span in &tile.misses {
                let mut found = Ok(());
                replay_misses(tracer, tile, span, |pixel, direction| {
                    match pixels.slot((pixel - tile.pixels.start) as usize, span.path, 1) {
                        Ok(slot) => tables.radiance[slot] = environment.radiance(direction),
                        Err(mismatch) => found = Err(mismatch),
                    }
                })?;
                found?;
            }
        }
        tables.column_lines = columns.own_lines().len() as u32;
        tables.sets = pixels.sets.into_iter().map(|set| set.rays).collect();
        tables.pixels = pixels.pixels;
        Ok(tables)
    }

    /// Finds the lines of all hits that a light is evaluated for.
    fn place_hits(&mut self, tile: &Tile, columns: &Columns, pixels: &TilePixels, world: &World) -> Result<(), Mismatch> {
        let mut others: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        for (index, group) in tile.groups.iter().enumerate().filter(|(_, group)| !group.emitters.is_empty()) {
            // A tile has fewer than 2³² hits.
            let list = self.lists.len() as u32;
            self.lists.push(group.emitters.len() as u32);
            self.lists.extend(group.emitters.iter().map(|emitter| world.light_of(*emitter).index() as u32));
            let first_line = self.lines.len();
            for line in 0..group.hits.len().div_ceil(LINE_HITS) {
                let part = columns.part(index, line..line + 1);
                let [first, second] = [0, 1].map(|light| part.records(light).start as u32);
                self.lines.push([part.hits().start as u32, first, second - first, list]);
            }
            for span in tile.spans_of(group) {
                for (hit, pixel) in span.hits.clone().zip(tile.pixels_of(span)) {
                    let place = (first_line * LINE_HITS) as u32 + hit - group.hits.start;
                    let slot = pixels.slot(pixel, span.path, 0)?;
                    match self.places[slot] {
                        NONE => self.places[slot] = place,
                        _ => others.entry(slot).or_default().push(place),
                    }
                }
            }
        }
        for (slot, places) in others {
            let list = self.lists.len() as u32;
            self.lists.extend([places.len() as u32 + 1, self.places[slot]]);
            self.lists.extend(places);
            self.places[slot] = SEVERAL | list;
        }
        Ok(())
    }

    /// Adds the tables of the next tile.
    pub(super) fn append(&mut self, next: Tables) {
        // Buffers are limited to fewer numbers.
        let [lines, lists, sets] = [self.lines.len(), self.lists.len(), self.sets.len()].map(|count| count as u32);
        let [hits, misses] = [self.places.len(), self.radiance.len()].map(|count| count as u32);
        let (columns, nodes) = (self.column_lines, self.node_lines);
        self.lines
            .extend(next.lines.iter().map(|[hit, record, step, list]| [hit + columns, record + columns, *step, list + lists]));
        self.lists.extend(relocated_lists(&next, lines));
        let first = |[hit, miss, set]: &[u32; 3]| [hit + hits, miss + misses, set + sets];
        self.pixels.extend(next.pixels.iter().map(first));
        self.sets.extend(next.sets);
        let lines_before = lines * LINE_HITS as u32;
        self.places.extend(next.places.iter().map(|place| match *place {
            NONE => NONE,
            several if several & SEVERAL != 0 => several + lists,
            place => place + lines_before,
        }));
        self.nodes.extend(next.nodes.iter().map(|node| node + nodes * LINE_HITS as u32));
        self.radiance.extend(next.radiance);
        self.column_lines += next.column_lines;
        self.node_lines += next.node_lines;
    }

    /// The bytes of the largest of them, and of columns with them.
    pub(super) fn largest_bytes(&self) -> u64 {
        let rays: usize = self.sets.iter().map(|rays| rays.len() + 1).sum();
        let numbers =
            [4 * self.lines.len(), self.lists.len(), 3 * self.pixels.len(), 2 * rays, self.places.len(), 3 * self.radiance.len()];
        size_of::<f32>() as u64 * numbers.into_iter().max().unwrap_or(0) as u64
    }
}

/// The lists of tables whose lines come behind others.
fn relocated_lists(tables: &Tables, lines: u32) -> Vec<u32> {
    let mut lists = tables.lists.clone();
    for place in tables.places.iter().filter(|place| **place != NONE && **place & SEVERAL != 0) {
        let list = (place & !SEVERAL) as usize;
        let count = lists[list] as usize;
        lists[list + 1..=list + count].iter_mut().for_each(|place| *place += lines * LINE_HITS as u32);
    }
    lists
}
