//! The nodes of a tile: all its hits, and the rays that left the scene, with the static values of what a formula gives
//! at them.

use crate::backends::compiled::leaves::{StaticLeaf, StaticTextures};
use crate::backends::compiled::memory::StreamMemory;
use crate::formula::Formula;
use crate::jit::compile::CompiledSurface;
use crate::jit::{CompiledFormula, Line};
use crate::lang::scalars::flush;
use crate::scene::BodyId;
use crate::trace::{CoordinatesUse, HitVariables, LINE_HITS, Mismatch, PathId, ROUND_LINES, Tile, Tracer, replay};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

/// No node.
const NONE: u32 = u32::MAX;

/// The nodes of a tile.
pub(in crate::backends) struct SurfaceTile {
    /// The nodes of each path, in the order of their pixels. Those of a path that left the scene have no values.
    pub(super) paths: Vec<Range<u32>>,
    /// The nodes on each body that has one.
    pub(super) bodies: Vec<NodesOnBody>,
    /// The pixel of each node in the tile.
    pub(super) pixels: Vec<u16>,
    /// The node from which the ray of each node comes.
    pub(super) parents: Vec<u32>,
    /// The node of each hit of the tile, in the order of groups.
    pub(super) of_hit: Vec<u32>,
    /// The static values of the nodes on bodies, line by line.
    pub(super) columns: StreamMemory,
    pub(super) lines: usize,
}

/// The nodes of a tile on one body.
pub(super) struct NodesOnBody {
    pub(super) body: BodyId,
    pub(super) lines: Range<usize>,
    /// Whether any ray goes on from them.
    pub(super) go_on: bool,
}

impl SurfaceTile {
    /// The memory that a hit takes beside its static values, in bytes, scratch memory of a frame included.
    pub(in crate::backends::compiled) const BYTES_PER_HIT: usize = Self::BYTES_PER_MISS + size_of::<u32>() + 3 * size_of::<f32>();

    /// The memory that a ray takes which left the scene, in bytes: its pixel and the node that it comes from, and in a
    /// frame its weights, exact or in single precision with those of the next rays.
    pub(in crate::backends::compiled) const BYTES_PER_MISS: usize =
        size_of::<u16>() + size_of::<u32>() + size_of::<[f64; 3]>() + 9 * size_of::<f32>();

    /// The nodes of all tiles, with their static values, and these textures.
    pub(in crate::backends) fn of_tiles(
        compiled: &CompiledFormula,
        formula: &Formula,
        textures: &StaticTextures,
        tracer: &Tracer,
        tiles: &[Tile],
    ) -> Result<Vec<Self>, Mismatch> {
        let (Some(plan), Some(compiled)) = (&compiled.plan.surface, &compiled.surface) else { return Ok(Vec::new()) };
        let leaves = StaticLeaf::of(&plan.hits, &plan.bindings.graph, &formula.parameters);
        let of_tile = |tile: &Tile| {
            let mut made = Self::new(tile);
            made.fill(compiled, &leaves, textures, tracer, tile)?;
            Ok(made)
        };
        tiles.par_iter().map(of_tile).collect()
    }

    /// The nodes of a tile, without values.
    fn new(tile: &Tile) -> Self {
        let pixels = pixels_of_paths(tile);
        // Nodes on one body are neighbours, from whole lines on.
        let mut order: Vec<PathId> = (0..tile.paths.len() as u32).map(PathId).collect();
        order.sort_by_key(|path| (tile.paths[path.index()].body.is_none(), tile.paths[path.index()].body, *path));
        let mut made = Self {
            paths: vec![0..0; tile.paths.len()],
            bodies: Vec::new(),
            pixels: Vec::new(),
            parents: Vec::new(),
            of_hit: Vec::new(),
            columns: StreamMemory::zeroed(0),
            lines: 0,
        };
        for path in order {
            let body = tile.paths[path.index()].body;
            if made.bodies.last().map(|nodes| Some(nodes.body)) != Some(body) {
                made.pixels.resize(made.pixels.len().next_multiple_of(LINE_HITS), 0);
                if let Some(body) = body {
                    made.bodies.push(NodesOnBody { body, lines: made.pixels.len() / LINE_HITS..0, go_on: false });
                }
            }
            // A tile has fewer than 2³² hits and misses.
            let start = made.pixels.len() as u32;
            made.pixels.extend_from_slice(&pixels[path.index()]);
            made.paths[path.index()] = start..made.pixels.len() as u32;
            if let (Some(_), Some(nodes)) = (body, made.bodies.last_mut()) {
                nodes.lines.end = made.pixels.len().div_ceil(LINE_HITS);
                made.lines = nodes.lines.end;
            }
        }
        let parents = tile.paths.iter().filter_map(|path| path.parent);
        let going_on: BTreeSet<BodyId> = parents.filter_map(|parent| tile.paths[parent.index()].body).collect();
        made.bodies.iter_mut().for_each(|nodes| nodes.go_on = going_on.contains(&nodes.body));
        made.parents = vec![NONE; made.pixels.len()];
        for (path, own) in tile.paths.iter().zip(&made.paths) {
            let Some(parent) = path.parent else { continue };
            for node in own.clone() {
                made.parents[node as usize] = made.node(parent, made.pixels[node as usize]);
            }
        }
        made.of_hit = vec![NONE; tile.groups.last().map_or(0, |group| group.hits.end as usize)];
        for span in &tile.spans {
            let of_span = tile.segments_of(span).iter().flat_map(|segment| segment.pixels());
            for (hit, pixel) in span.hits.clone().zip(of_span) {
                made.of_hit[hit as usize] = made.node(span.path, pixel as u16);
            }
        }
        made
    }

    /// The static values of the nodes on bodies, line by line: 16 nodes of each column, then the next 16.
    #[cfg(feature = "gpu")]
    pub(in crate::backends) fn static_lines(&self) -> &[Line] {
        &self.columns.lines()[..self.lines * self.columns.lines().len() / (self.lines + ROUND_LINES)]
    }

    /// How many lines of nodes on bodies there are.
    #[cfg(feature = "gpu")]
    pub(in crate::backends) fn node_lines(&self) -> u32 {
        // A tile has fewer than 2³² hits.
        self.lines as u32
    }

    /// The nodes of a path, with their pixels in the tile, in the order of their pixels.
    #[cfg(feature = "gpu")]
    pub(in crate::backends) fn nodes_of(&self, path: usize) -> impl Iterator<Item = (u32, u16)> {
        let own = self.paths[path].clone();
        own.clone().zip(self.pixels[own.start as usize..own.end as usize].iter().copied())
    }

    /// The node of a path in a pixel of the tile.
    fn node(&self, path: PathId, pixel: u16) -> u32 {
        let own = self.paths[path.index()].clone();
        let pixels = &self.pixels[own.start as usize..own.end as usize];
        pixels.binary_search(&pixel).map_or(NONE, |offset| own.start + offset as u32)
    }

    /// Computes the static values of the nodes on bodies.
    fn fill(
        &mut self,
        compiled: &CompiledSurface,
        leaves: &[StaticLeaf],
        textures: &StaticTextures,
        tracer: &Tracer,
        tile: &Tile,
    ) -> Result<(), Mismatch> {
        let coordinates = CoordinatesUse::by(leaves.iter().filter_map(StaticLeaf::variable));
        let lines = self.lines + ROUND_LINES;
        let mut values = vec![Line::default(); lines * leaves.len()];
        for group in &tile.groups {
            replay(tracer, tile, group, group.hits.clone(), |hit, _, surface| {
                let node = self.of_hit[hit as usize] as usize;
                let own = HitVariables::new(tracer.world(), surface, tracer.relative_index(surface), coordinates);
                for (column, leaf) in leaves.iter().enumerate() {
                    let value = textures.at_hit(*leaf, &own, group.body);
                    values[node / LINE_HITS * leaves.len() + column].0[node % LINE_HITS] = flush(value);
                }
            })?;
        }
        let outputs = compiled.hits.outputs();
        self.columns = StreamMemory::zeroed(lines * outputs);
        if outputs > 0 {
            compiled.hits.run([&values, &[], &[]], &[], &mut [self.columns.lines_mut()], self.lines);
        }
        Ok(())
    }

    /// The memory that is kept, in bytes.
    pub(in crate::backends::compiled) fn bytes(&self) -> usize {
        size_of_val(self.columns.lines())
            + size_of_val(&*self.pixels)
            + size_of_val(&*self.parents)
            + size_of_val(&*self.of_hit)
            + size_of_val(&*self.paths)
    }
}

/// The pixels of every path of a tile, in order: of hits, or of rays that left the scene.
fn pixels_of_paths(tile: &Tile) -> Vec<Vec<u16>> {
    let mut pixels: Vec<Vec<u16>> = vec![Vec::new(); tile.paths.len()];
    for span in &tile.spans {
        let of_span = tile.segments_of(span).iter().flat_map(|segment| segment.pixels());
        pixels[span.path.index()].extend(of_span.map(|pixel| pixel as u16));
    }
    for span in &tile.misses {
        let of_span = tile.miss_segments_of(span).iter().flat_map(|segment| segment.pixels());
        pixels[span.path.index()].extend(of_span.map(|pixel| pixel as u16));
    }
    for pixels in &mut pixels {
        // Scattered hits are there more than once.
        pixels.sort_unstable();
        pixels.dedup();
    }
    pixels
}
