//! The static values of all records, computed once after tracing and stored in columns (structure of arrays).
//!
//! A group of hits has one column for each node of the hit frontier. For each of its emitters, it has one
//! column for each node of the record frontier. Columns have whole lines and are cut into chunks of [`CHUNK_LINES`].
//! A chunk begins with a stream of the hit columns. A stream of the record columns of each emitter follows. A stream
//! holds its columns line by line. This is the order in which frames read them, from front to back.

mod packing;

pub(super) use packing::{Packing, Reader};

use crate::backends::compiled::leaves::{StaticLeaf, StaticTextures};
use crate::backends::compiled::memory::StreamMemory;
use crate::backends::compiled::source::ContributionSource;
use crate::formula::Formula;
use crate::jit::{CompiledFormula, Line, PREFETCH_DISTANCE, Splat, Streams};
use crate::lang::scalars::flush;
use crate::plan::KernelPlan;
use crate::trace::{
    CHUNK_LINES, CoordinatesUse, Group, HitVariables, LINE_HITS, LightVariables, Mismatch, ROUND_LINES, Tile, Tracer, replay,
    variable,
};
use crate::world::EmitterId;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

// The hits of a line of a column are those of a line of sums that are added to pixels.
const _: () = assert!(LINE_HITS == Line::RECORDS && CHUNK_LINES.is_multiple_of(ROUND_LINES));

/// The columns of a tile's groups.
pub(in crate::backends) struct Columns {
    memory: Arc<StreamMemory>,
    /// The tile's part of the memory.
    lines: Range<usize>,
    arrangement: Arrangement,
}

/// Where the columns of a tile lie.
struct Arrangement {
    groups: Vec<GroupColumns>,
    hit_columns: usize,
    record_columns: usize,
    /// The first line after them.
    end: usize,
}

/// Where the columns of a group lie.
#[derive(Clone, Copy)]
struct GroupColumns {
    /// The first line of the first.
    start: usize,
    /// The length of each column, in lines.
    lines: usize,
    emitters: usize,
}

impl Arrangement {
    /// The arrangement of a tile from line `start` on, with columns for the groups that `has` chooses.
    fn new(tile: &Tile, start: usize, hit_columns: usize, record_columns: usize, has: impl Fn(&Group) -> bool) -> Self {
        let groups = Vec::with_capacity(tile.groups.len());
        let mut arrangement = Self { groups, hit_columns, record_columns, end: start };
        for group in &tile.groups {
            let lines = if has(group) { group.hits.len().div_ceil(LINE_HITS) } else { 0 };
            let own = GroupColumns { start: arrangement.end, lines, emitters: group.emitters.len() };
            arrangement.groups.push(own);
            arrangement.end += lines * arrangement.columns_of(&own);
        }
        arrangement
    }

    /// The number of columns of a group.
    fn columns_of(&self, group: &GroupColumns) -> usize {
        self.hit_columns + self.record_columns * group.emitters
    }

    /// The first line of the columns that belong to a chunk of a group.
    fn chunk(&self, group: &GroupColumns, chunk: &Chunk) -> usize {
        group.start + chunk.first * self.columns_of(group)
    }

    /// Kernels read whole rounds. This is the most lines that they read after the end of a stream. The results are
    /// not used.
    fn spare(hit_columns: usize, record_columns: usize) -> usize {
        ROUND_LINES * hit_columns.max(record_columns)
    }
}

/// A part of a group whose columns lie together.
struct Chunk {
    /// Its first line in the group.
    first: usize,
    lines: usize,
}

impl Chunk {
    /// The chunk that holds a line of a group.
    fn of(line: usize, group: &GroupColumns) -> Self {
        let first = line - line % CHUNK_LINES;
        Self { first, lines: (group.lines - first).min(CHUNK_LINES) }
    }

    /// All chunks of a group.
    fn all(group: &GroupColumns) -> impl Iterator<Item = Chunk> {
        let group = *group;
        (0..group.lines).step_by(CHUNK_LINES).map(move |first| Chunk::of(first, &group))
    }
}

impl Columns {
    /// Computes the static values of some tiles, with these textures.
    pub(in crate::backends) fn of_tiles(
        compiled: &CompiledFormula,
        formula: &Formula,
        textures: &StaticTextures,
        tracer: &Tracer,
        tiles: &[Tile],
    ) -> Result<Vec<Self>, Mismatch> {
        let frontier = &compiled.plan.bindings.frontier;
        // Groups that no light reaches are not evaluated.
        let lit = |group: &Group| !group.emitters.is_empty();
        let (hit_columns, record_columns) = (frontier.hits.len(), frontier.records.len());
        let spare = Arrangement::spare(hit_columns, record_columns);
        let arrangement = |tile: &Tile| Arrangement::new(tile, 0, hit_columns, record_columns, lit);
        let arrangements: Vec<Arrangement> = tiles.iter().map(arrangement).collect();
        let mut memory = StreamMemory::zeroed(arrangements.iter().map(|arrangement| arrangement.end).sum::<usize>() + spare);
        let mut parts = Vec::with_capacity(arrangements.len());
        let mut rest = memory.lines_mut();
        for arrangement in &arrangements {
            let (own, behind) = rest.split_at_mut(arrangement.end);
            parts.push(own);
            rest = behind;
        }
        tiles.par_iter().zip(&arrangements).zip(parts).try_for_each(|((tile, arrangement), lines)| {
            let mut leaves = LeafColumns::new(compiled, formula, textures);
            (0..tile.groups.len()).try_for_each(|index| fill(compiled, tracer, tile, arrangement, index, lines, &mut leaves))
        })?;
        let memory = Arc::new(memory);
        let mut end = 0;
        let tile = |arrangement: Arrangement| {
            let start = end;
            end += arrangement.end;
            Self { memory: Arc::clone(&memory), lines: start..end, arrangement }
        };
        Ok(arrangements.into_iter().map(tile).collect())
    }

    /// The drag columns that a source computes for each record of a tile where it is active, from static columns and
    /// uniform values.
    pub(super) fn for_drag(tile: &Tile, given: &Columns, source: &ContributionSource, uniforms: &[Splat]) -> Self {
        let is_active = |group: &Group, emitter: &EmitterId| source.active[source.pair(group.body, *emitter)];
        let outputs = source.overwrite.outputs();
        let arrangement =
            Arrangement::new(tile, 0, 0, outputs, |group| group.emitters.iter().any(|emitter| is_active(group, emitter)));
        let mut memory = StreamMemory::zeroed(arrangement.end + Arrangement::spare(0, outputs));
        let lines = memory.lines_mut();
        for (index, (group, own)) in tile.groups.iter().zip(&arrangement.groups).enumerate() {
            for chunk in Chunk::all(own) {
                let start = arrangement.chunk(own, &chunk);
                let part = given.part(index, chunk.first..chunk.first + chunk.lines);
                for (light, emitter) in group.emitters.iter().enumerate().filter(|(_, emitter)| is_active(group, emitter)) {
                    let length = outputs * chunk.lines;
                    let begin = start + light * length;
                    let uniforms = &uniforms[source.uniforms_of(source.pair(group.body, *emitter))];
                    let streams: Streams = [&given.lines()[part.hits()], &given.lines()[part.records(light)], &[]];
                    source.overwrite.run(streams, uniforms, &mut [&mut lines[begin..begin + length]], chunk.lines);
                }
            }
        }
        Self { memory: Arc::new(memory), lines: 0..arrangement.end, arrangement }
    }

    /// The lines of the columns, and the lines after them that whole rounds may read.
    pub(super) fn lines(&self) -> &[Line] {
        &self.memory.lines()[self.lines.start..]
    }

    /// The lines of the columns alone.
    #[cfg(feature = "gpu")]
    pub(in crate::backends) fn own_lines(&self) -> &[Line] {
        &self.memory.lines()[self.lines.clone()]
    }

    /// The memory that they lie in, possibly with others.
    pub(super) fn into_memory(self) -> Arc<StreamMemory> {
        self.memory
    }

    /// Their memory, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.lines.len() * size_of::<Line>() + size_of_val(self.arrangement.groups.as_slice())
    }

    /// Where some lines of the columns of a group are. The lines belong to one chunk. They may end up to a round
    /// after it, where there is other data.
    pub(in crate::backends) fn part(&self, group: usize, lines: Range<usize>) -> ColumnPart {
        let arrangement = &self.arrangement;
        let own = &arrangement.groups[group];
        let chunk = Chunk::of(lines.start, own);
        ColumnPart {
            start: arrangement.chunk(own, &chunk),
            hit_columns: arrangement.hit_columns,
            record_columns: arrangement.record_columns,
            chunk: chunk.lines,
            whole: chunk.lines * arrangement.columns_of(own),
            lines: lines.start - chunk.first..lines.end - chunk.first,
        }
    }
}

/// Where some lines of the columns of a group are among the lines of the tile, as kernels read them.
pub(in crate::backends) struct ColumnPart {
    /// The first line of the chunk.
    start: usize,
    hit_columns: usize,
    record_columns: usize,
    /// The number of lines of one column of the chunk, and of all its columns.
    chunk: usize,
    whole: usize,
    /// The lines within the chunk.
    lines: Range<usize>,
}

impl ColumnPart {
    /// The hit frontier.
    pub(in crate::backends) fn hits(&self) -> Range<usize> {
        self.stream(0, self.hit_columns)
    }

    /// The record frontier, for the light with this index in the group.
    pub(in crate::backends) fn records(&self, light: usize) -> Range<usize> {
        self.stream(self.chunk * (self.hit_columns + light * self.record_columns), self.record_columns)
    }

    /// The index of the first line after the chunk that kernels have not prefetched.
    pub(super) fn next_lines(&self) -> usize {
        self.start + self.whole + PREFETCH_DISTANCE / size_of::<Line>()
    }

    /// The lines of a stream of this many columns that begins at line `start` of the chunk.
    fn stream(&self, start: usize, columns: usize) -> Range<usize> {
        let start = self.start + start;
        start + columns * self.lines.start..start + columns * self.lines.end
    }
}

/// Fills the columns of a group in the memory of its tile.
fn fill(
    compiled: &CompiledFormula,
    tracer: &Tracer,
    tile: &Tile,
    arrangement: &Arrangement,
    index: usize,
    memory: &mut [Line],
    leaves: &mut LeafColumns<'_>,
) -> Result<(), Mismatch> {
    let (group, own) = (&tile.groups[index], &arrangement.groups[index]);
    let columns = arrangement.columns_of(own);
    if columns == 0 {
        return Ok(());
    }
    for chunk in Chunk::all(own) {
        // A tile has fewer than 2³² hits.
        let first = group.hits.start + (chunk.first * LINE_HITS) as u32;
        let end = (first + (chunk.lines * LINE_HITS) as u32).min(group.hits.end);
        leaves.gather(tracer, tile, group, first..end)?;
        let start = arrangement.chunk(own, &chunk);
        let part = &mut memory[start..start + columns * chunk.lines];
        let (hit_part, record_part) = part.split_at_mut(chunk.lines * arrangement.hit_columns);
        compiled.hits.run([&leaves.hits, &[], &[]], &[], &mut [hit_part], chunk.lines);
        for (light, records) in leaves.records.iter().enumerate().take(group.emitters.len()) {
            let length = chunk.lines * arrangement.record_columns;
            let part = &mut record_part[light * length..(light + 1) * length];
            compiled.records.run([records, &[], &[]], &[], &mut [part], chunk.lines);
        }
    }
    Ok(())
}

/// What static kernels read, for up to one chunk of hits.
pub(in crate::backends) struct LeafColumns<'t> {
    hit_leaves: Vec<StaticLeaf>,
    record_leaves: Vec<StaticLeaf>,
    textures: &'t StaticTextures,
    coordinates: CoordinatesUse,
    /// A stream with a column for each hit leaf, for one chunk of hits. It stays in the L1 cache.
    hits: Vec<Line>,
    /// For each emitter, a stream with a column for each record leaf.
    records: Vec<Vec<Line>>,
}

impl<'t> LeafColumns<'t> {
    /// The memory that they take for a group with this many emitters, in bytes.
    pub(in crate::backends) fn bytes(compiled: &CompiledFormula, emitters: usize) -> usize {
        let leaves = |plan: &KernelPlan| plan.streams[0].len();
        let columns = leaves(&compiled.plan.hits) + emitters * leaves(&compiled.plan.records);
        columns * CHUNK_LINES * size_of::<Line>()
    }

    fn new(compiled: &CompiledFormula, formula: &Formula, textures: &'t StaticTextures) -> Self {
        let leaves = |plan: &KernelPlan| StaticLeaf::of(plan, &compiled.plan.bindings.graph, &formula.parameters);
        let (hit_leaves, record_leaves) = (leaves(&compiled.plan.hits), leaves(&compiled.plan.records));
        let coordinates = CoordinatesUse::by(hit_leaves.iter().chain(&record_leaves).filter_map(StaticLeaf::variable));
        let hits = vec![Line::default(); CHUNK_LINES * hit_leaves.len()];
        Self { hit_leaves, record_leaves, textures, coordinates, hits, records: Vec::new() }
    }

    /// Computes the leaves of these hits for all lights of the group. Lanes after the last hit keep their old
    /// values. Kernels read them, but the results are not used.
    fn gather(&mut self, tracer: &Tracer, tile: &Tile, group: &Group, hits: Range<u32>) -> Result<(), Mismatch> {
        let world = tracer.world();
        while self.records.len() < group.emitters.len() {
            self.records.push(vec![Line::default(); CHUNK_LINES * self.record_leaves.len()]);
        }
        let (first, coordinates) = (hits.start, self.coordinates);
        replay(tracer, tile, group, hits, |hit, key, surface| {
            let index = (hit - first) as usize;
            let own = HitVariables::new(world, surface, tracer.relative_index(surface), coordinates);
            let put = |stream: &mut [Line], columns: usize, column: usize, value: f32| {
                stream[index / Line::RECORDS * columns + column].0[index % Line::RECORDS] = flush(value);
            };
            for (emitter, stream) in group.emitters.iter().zip(&mut self.records) {
                let sample = tracer.sample(*emitter, surface, key);
                let record = LightVariables::new(surface, &sample, tile.is_visible(hit, *emitter));
                let light = world.light_of(*emitter);
                for (column, leaf) in self.record_leaves.iter().enumerate() {
                    let value = match *leaf {
                        StaticLeaf::Variable(symbol, component) => variable(symbol, &own, &record)[component],
                        StaticLeaf::Texture(slot) => self.textures.number(slot, group.body, Some(light)),
                    };
                    put(stream, self.record_leaves.len(), column, value);
                }
            }
            for (column, leaf) in self.hit_leaves.iter().enumerate() {
                let value = self.textures.at_hit(*leaf, &own, group.body);
                put(&mut self.hits, self.hit_leaves.len(), column, value);
            }
        })
    }
}
