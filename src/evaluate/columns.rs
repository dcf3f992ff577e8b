//! Static values of all records, worked out once after tracing and kept in columns (structure of arrays).
//!
//! A group of hits has one column for each node of the hit frontier and, for each light that reaches it, one for each node of the
//! record frontier, in whole lines. They are cut in chunks of [`CHUNK`] blocks, the chunks of all columns one behind the other before the
//! next ones: just as frames read them, so that memory is read from front to back.

use crate::evaluate::memory::StreamMemory;
use crate::evaluate::pass::Source;
use crate::formula::graph::{Node, NodeId};
use crate::jit::{CompiledFormula, Lanes, Line};
use crate::lang::scalars::flush;
use crate::lang::variables::Variable;
use crate::scene::LightId;
use crate::trace::{
    CHUNK_LINES, Group, HitVariables, Hits, LINE_HITS, LightVariables, Mismatch, Optics, ROUND_LINES, Tile, replay, variable,
};
use rayon::prelude::*;
use smallvec::SmallVec;
use std::ops::Range;
use std::sync::Arc;

// What stands side by side in a column is what is added to the pixels side by side.
const _: () = assert!(LINE_HITS == Line::RECORDS && CHUNK_LINES.is_multiple_of(ROUND_LINES));

/// Kernels read whole rounds: where a column ends before, what lies behind it, of which nothing comes.
const SPARE: usize = ROUND_LINES;

/// How many blocks are worked out at a time: what belongs to them stays in the first cache meanwhile.
pub(super) const CHUNK: usize = CHUNK_LINES * Line::BLOCKS;

/// Parts of columns that kernels read; few, mostly.
pub(super) type Inputs<'c> = SmallVec<[&'c [Lanes]; 16]>;

/// The columns of a tile's groups.
pub(super) struct Columns {
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
    lines: usize,
}

/// Where the columns of a group lie.
#[derive(Clone, Copy)]
struct GroupColumns {
    /// The first line of the first.
    start: usize,
    /// How long each is, in whole lines.
    lines: usize,
    lights: usize,
}

impl Arrangement {
    /// That of a tile, with columns for those groups that `has` chooses.
    fn new(tile: &Tile, hit_columns: usize, record_columns: usize, has: impl Fn(&Group) -> bool) -> Self {
        let mut arrangement = Self { groups: Vec::with_capacity(tile.groups.len()), hit_columns, record_columns, lines: 0 };
        for group in &tile.groups {
            let lines = if has(group) { group.hits.len().div_ceil(LINE_HITS) } else { 0 };
            let own = GroupColumns { start: arrangement.lines, lines, lights: group.lights.len() };
            arrangement.groups.push(own);
            arrangement.lines += lines * arrangement.columns_of(&own);
        }
        arrangement
    }

    /// How many columns a group has.
    fn columns_of(&self, group: &GroupColumns) -> usize {
        self.hit_columns + self.record_columns * group.lights
    }

    /// The first line of the columns that belong to a chunk of a group.
    fn chunk(&self, group: &GroupColumns, chunk: &Chunk) -> usize {
        group.start + chunk.first * self.columns_of(group)
    }
}

/// A part of a group whose columns lie together.
struct Chunk {
    /// Its first line in the group.
    first: usize,
    lines: usize,
}

impl Chunk {
    /// That of a line of a group.
    fn of(line: usize, group: &GroupColumns) -> Self {
        let first = line - line % CHUNK_LINES;
        Self { first, lines: (group.lines - first).min(CHUNK_LINES) }
    }

    /// All of a group.
    fn all(group: &GroupColumns) -> impl Iterator<Item = Chunk> {
        let group = *group;
        (0..group.lines).step_by(CHUNK_LINES).map(move |first| Chunk::of(first, &group))
    }
}

impl Columns {
    /// Works out the static values of all tiles.
    pub(super) fn of_tiles(compiled: &CompiledFormula, optics: &Optics, hits: &Hits) -> Result<Vec<Self>, Mismatch> {
        let frontier = &compiled.bindings.frontier;
        // Where no light reaches, nothing is evaluated.
        let lit = |group: &Group| !group.lights.is_empty();
        let arrangement = |tile: &Tile| Arrangement::new(tile, frontier.hits.len(), frontier.records.len(), lit);
        let arrangements: Vec<Arrangement> = hits.tiles.iter().map(arrangement).collect();
        let mut memory = StreamMemory::zeroed(arrangements.iter().map(|arrangement| arrangement.lines).sum::<usize>() + SPARE);
        let mut parts = Vec::with_capacity(arrangements.len());
        let mut rest = memory.lines_mut();
        for arrangement in &arrangements {
            let (own, behind) = rest.split_at_mut(arrangement.lines);
            parts.push(own);
            rest = behind;
        }
        hits.tiles.par_iter().zip(&arrangements).zip(parts).try_for_each(|((tile, arrangement), lines)| {
            let mut workroom = Workroom::new(compiled);
            (0..tile.groups.len()).try_for_each(|index| fill(compiled, optics, tile, arrangement, index, lines, &mut workroom))
        })?;
        let memory = Arc::new(memory);
        let mut end = 0;
        let tile = |arrangement: Arrangement| {
            let start = end;
            end += arrangement.lines;
            Self { memory: Arc::clone(&memory), lines: start..end, arrangement }
        };
        Ok(arrangements.into_iter().map(tile).collect())
    }

    /// Columns of what a source yields for each record of a tile, where it is active.
    pub(super) fn kept(tile: &Tile, place: usize, source: &Source) -> Self {
        let is_active = |group: &Group, light: &LightId| source.active[source.pair(group.body, *light)];
        let outputs = source.storing.outputs();
        let arrangement = Arrangement::new(tile, 0, outputs, |group| group.lights.iter().any(|light| is_active(group, light)));
        let mut memory = StreamMemory::zeroed(arrangement.lines + SPARE);
        let lines = memory.lines_mut();
        let mut inputs = Inputs::new();
        for (index, (group, own)) in tile.groups.iter().zip(&arrangement.groups).enumerate() {
            for chunk in Chunk::all(own) {
                let start = arrangement.chunk(own, &chunk);
                for (light_place, light) in group.lights.iter().enumerate().filter(|(_, light)| is_active(group, light)) {
                    inputs.clear();
                    source.columns[place].of(index, light_place, chunk.first..chunk.first + chunk.lines, &mut inputs);
                    let length = outputs * chunk.lines;
                    let begin = start + light_place * length;
                    let mut outputs = pieces(&mut lines[begin..begin + length], chunk.lines);
                    let uniforms = source.uniforms_of(source.pair(group.body, *light));
                    source.storing.run(&inputs, uniforms, &mut outputs, chunk.lines * Line::BLOCKS);
                }
            }
        }
        Self { memory: Arc::new(memory), lines: 0..arrangement.lines, arrangement }
    }

    /// The memory they take, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.lines.len() * size_of::<Line>() + size_of_val(self.arrangement.groups.as_slice())
    }

    /// Some lines of the columns of a group for its light of this place, hit frontier first, behind those that are there. The lines are
    /// of one chunk, or up to a round beyond, where there is something else.
    #[inline]
    pub(super) fn of<'c>(&'c self, group: usize, light: usize, lines: Range<usize>, into: &mut Inputs<'c>) {
        let arrangement = &self.arrangement;
        let own = &arrangement.groups[group];
        let chunk = Chunk::of(lines.start, own);
        let start = self.lines.start + arrangement.chunk(own, &chunk) + lines.start - chunk.first;
        let records = arrangement.hit_columns + light * arrangement.record_columns;
        for column in (0..arrangement.hit_columns).chain(records..records + arrangement.record_columns) {
            let begin = start + column * chunk.lines;
            into.push(Line::blocks(&self.memory.lines()[begin..begin + lines.len()]));
        }
    }
}

/// Fills the columns of a group in the memory of its tile.
fn fill(
    compiled: &CompiledFormula,
    optics: &Optics,
    tile: &Tile,
    arrangement: &Arrangement,
    index: usize,
    memory: &mut [Line],
    workroom: &mut Workroom,
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
        workroom.gather(optics, tile, group, first..end)?;
        let start = arrangement.chunk(own, &chunk);
        let part = &mut memory[start..start + columns * chunk.lines];
        let (hit_part, record_part) = part.split_at_mut(chunk.lines * arrangement.hit_columns);
        let blocks = chunk.lines * Line::BLOCKS;
        compiled.hit_kernel.run(&workroom.hit_inputs(), &[], &mut pieces(hit_part, chunk.lines), blocks);
        for light in 0..group.lights.len() {
            let length = chunk.lines * arrangement.record_columns;
            let part = &mut record_part[light * length..(light + 1) * length];
            compiled.record_kernel.run(&workroom.record_inputs(light), &[], &mut pieces(part, chunk.lines), blocks);
        }
    }
    Ok(())
}

/// Columns of so many lines each that lie one behind the other.
fn pieces(columns: &mut [Line], lines: usize) -> Vec<&mut [Lanes]> {
    columns.chunks_exact_mut(lines).map(Line::blocks_mut).collect()
}

/// A column for as many blocks as are worked out at a time.
fn column() -> Vec<Lanes> {
    vec![Lanes::default(); CHUNK]
}

/// The variables that static kernels read, for some hits at a time.
struct Workroom {
    hit_leaves: Vec<(Variable, usize)>,
    record_leaves: Vec<(Variable, usize)>,
    /// A column for each hit leaf.
    hits: Vec<Vec<Lanes>>,
    /// For each light, a column for each record leaf.
    records: Vec<Vec<Vec<Lanes>>>,
}

impl Workroom {
    fn new(compiled: &CompiledFormula) -> Self {
        let variables = |leaves: &[NodeId]| -> Vec<(Variable, usize)> {
            let variable = |leaf: &NodeId| match compiled.bindings.graph.node(*leaf) {
                Node::Variable(variable, component) => Some((variable, usize::from(component))),
                Node::Constant(_) | Node::Parameter(..) | Node::Apply(..) => None,
            };
            // What is static is made of variables alone.
            leaves.iter().filter_map(variable).collect()
        };
        let (hit_leaves, record_leaves) = (variables(&compiled.hit_leaves), variables(&compiled.record_leaves));
        let hits = hit_leaves.iter().map(|_| column()).collect();
        Self { hit_leaves, record_leaves, hits, records: Vec::new() }
    }

    /// Works out the variables of these hits for all lights of the group. Lanes beyond keep what was there: it is read, but nothing
    /// comes of it.
    fn gather(&mut self, optics: &Optics, tile: &Tile, group: &Group, hits: Range<u32>) -> Result<(), Mismatch> {
        let scene = optics.scene();
        while self.records.len() < group.lights.len() {
            self.records.push(self.record_leaves.iter().map(|_| column()).collect());
        }
        let first = hits.start;
        replay(optics, tile, group, hits, |hit, _, surface| {
            let place = (hit - first) as usize;
            let own = HitVariables::of(scene, surface);
            let put = |column: &mut Vec<Lanes>, value: f32| column[place / Lanes::COUNT].0[place % Lanes::COUNT] = flush(value);
            for (light, columns) in group.lights.iter().zip(&mut self.records) {
                let record = LightVariables::of(surface, scene.light(*light));
                for ((symbol, component), column) in self.record_leaves.iter().zip(columns) {
                    put(column, variable(*symbol, &own, &record)[*component]);
                }
            }
            for ((symbol, component), column) in self.hit_leaves.iter().zip(&mut self.hits) {
                put(column, own.value(*symbol).map_or(0.0, |value| value[*component]));
            }
        })
    }

    fn hit_inputs(&self) -> Vec<&[Lanes]> {
        self.hits.iter().map(Vec::as_slice).collect()
    }

    fn record_inputs(&self, light: usize) -> Vec<&[Lanes]> {
        self.records[light].iter().map(Vec::as_slice).collect()
    }
}
