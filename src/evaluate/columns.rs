//! Static values of all records, worked out once after tracing and kept in columns (structure of arrays).
//!
//! A group of hits has one column for each node of the hit frontier and, for each light that reaches it, one for each node of the
//! record frontier. They are cut in chunks of [`CHUNK`] blocks, the chunks of all columns one behind the other before the next ones: just
//! as frames read them, so that memory is read from front to back.

use crate::evaluate::pass::Source;
use crate::formula::graph::{Node, NodeId};
use crate::jit::{CompiledFormula, Lanes};
use crate::lang::scalars::flush;
use crate::lang::variables::Variable;
use crate::scene::LightId;
use crate::trace::{Group, HitVariables, LightVariables, Mismatch, Optics, Tile, replay, variable};
use std::ops::Range;

/// How many blocks are worked out at a time: what belongs to them stays in the first cache meanwhile.
pub(super) const CHUNK: u32 = 256;

/// Kernels that compute two blocks at a time read a block beyond the last.
const SPARE: usize = 1;

/// The static columns of a tile's groups.
pub(super) struct Columns {
    lanes: Vec<Lanes>,
    /// For each group where its columns begin, of how many blocks each is, and the number of its lights.
    groups: Vec<(usize, usize, usize)>,
    hit_columns: usize,
    record_columns: usize,
}

impl Columns {
    /// Works out the static values of a tile.
    pub(super) fn new(compiled: &CompiledFormula, optics: &Optics, tile: &Tile) -> Result<Self, Mismatch> {
        let hit_columns = compiled.bindings.frontier.hits.len();
        let record_columns = compiled.bindings.frontier.records.len();
        let mut groups = Vec::with_capacity(tile.groups.len());
        let mut end = 0;
        for group in &tile.groups {
            // Where no light reaches, nothing is evaluated.
            let blocks = if group.lights.is_empty() { 0 } else { group.blocks.len() };
            groups.push((end, blocks, group.lights.len()));
            end += blocks * (hit_columns + record_columns * group.lights.len());
        }
        let mut columns = Self { lanes: vec![Lanes::default(); end + SPARE], groups, hit_columns, record_columns };
        let mut workroom = Workroom::new(compiled);
        for index in 0..tile.groups.len() {
            columns.fill(compiled, optics, tile, index, &mut workroom)?;
        }
        Ok(columns)
    }

    /// Columns of what a source yields for each record of a tile, where it is active.
    pub(super) fn kept(tile: &Tile, place: usize, source: &Source, lights: usize) -> Self {
        let record_columns = source.kernel.outputs();
        let is_active = |group: &Group, light: &LightId| source.active[group.body.index() * lights + light.index()];
        let mut groups = Vec::with_capacity(tile.groups.len());
        let mut end = 0;
        for group in &tile.groups {
            let blocks = if group.lights.iter().any(|light| is_active(group, light)) { group.blocks.len() } else { 0 };
            groups.push((end, blocks, group.lights.len()));
            end += blocks * record_columns * group.lights.len();
        }
        let mut kept = Self { lanes: vec![Lanes::default(); end + SPARE], groups, hit_columns: 0, record_columns };
        let mut inputs = Vec::new();
        for (index, group) in tile.groups.iter().enumerate() {
            let (start, length, lights_here) = kept.groups[index];
            for first in (0..length).step_by(CHUNK as usize) {
                let chunk = Chunk::of(first, length);
                for (light_place, light) in group.lights.iter().enumerate().filter(|(_, light)| is_active(group, light)) {
                    let pair = group.body.index() * lights + light.index();
                    let uniforms = &source.uniforms[pair * source.uniform_count..(pair + 1) * source.uniform_count];
                    inputs.clear();
                    source.columns[place].of(index, light_place, first, chunk.blocks, &mut inputs);
                    let begin = start + first * record_columns * lights_here + light_place * record_columns * chunk.blocks;
                    let own = &mut kept.lanes[begin..begin + record_columns * chunk.blocks];
                    source.kernel.run(&inputs, uniforms, &mut pieces(own, chunk.blocks), chunk.blocks);
                }
            }
        }
        kept
    }

    /// The memory they take, in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.lanes.as_slice()) + size_of_val(self.groups.as_slice())
    }

    /// The columns of a group for its light of this place, hit frontier first, each from block `first` of the group on, for `blocks`
    /// blocks of the same chunk at least; behind those that are there.
    pub(super) fn of<'c>(&'c self, group: usize, light: usize, first: usize, blocks: usize, into: &mut Vec<&'c [Lanes]>) {
        let (start, length, lights) = self.groups[group];
        let chunk = Chunk::of(first, length);
        let own = start + chunk.first * self.columns_of(lights);
        let records = self.hit_columns + light * self.record_columns;
        for column in (0..self.hit_columns).chain(records..records + self.record_columns) {
            let begin = own + column * chunk.blocks + first - chunk.first;
            into.push(&self.lanes[begin..begin + blocks + SPARE]);
        }
    }

    /// How many columns a group with so many lights has.
    fn columns_of(&self, lights: usize) -> usize {
        self.hit_columns + self.record_columns * lights
    }

    /// Fills the columns of a group.
    fn fill(
        &mut self,
        compiled: &CompiledFormula,
        optics: &Optics,
        tile: &Tile,
        index: usize,
        workroom: &mut Workroom,
    ) -> Result<(), Mismatch> {
        let group = &tile.groups[index];
        if self.hit_columns + self.record_columns == 0 || group.lights.is_empty() {
            return Ok(());
        }
        let (start, length, lights) = self.groups[index];
        let columns = self.columns_of(lights);
        for first in (0..length).step_by(CHUNK as usize) {
            let Chunk { blocks, .. } = Chunk::of(first, length);
            // A tile has fewer than 2³² blocks.
            let from = group.blocks.start + first as u32;
            workroom.gather(optics, tile, group, from..from + blocks as u32)?;
            let begin = start + first * columns;
            let own = &mut self.lanes[begin..begin + blocks * columns];
            let (hit_part, record_part) = own.split_at_mut(blocks * self.hit_columns);
            compiled.hit_kernel.run(&workroom.hit_inputs(), &[], &mut pieces(hit_part, blocks), blocks);
            for place in 0..lights {
                let light = blocks * self.record_columns;
                let part = &mut record_part[place * light..(place + 1) * light];
                compiled.record_kernel.run(&workroom.record_inputs(place), &[], &mut pieces(part, blocks), blocks);
            }
        }
        Ok(())
    }
}

/// A part of a group whose columns lie together.
struct Chunk {
    first: usize,
    blocks: usize,
}

impl Chunk {
    /// That of a block, in a group of so many.
    fn of(block: usize, length: usize) -> Self {
        let first = block - block % CHUNK as usize;
        Self { first, blocks: (length - first).min(CHUNK as usize) }
    }
}

/// Columns of `length` blocks each that lie one behind the other.
fn pieces(columns: &mut [Lanes], length: usize) -> Vec<&mut [Lanes]> {
    columns.chunks_exact_mut(length).collect()
}

/// A column for as many blocks as are worked out at a time.
fn column() -> Vec<Lanes> {
    vec![Lanes::default(); CHUNK as usize]
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

    /// Works out the variables of the hits of these blocks for all lights of the group. Dead lanes keep what was there: it is read,
    /// but nothing comes of it.
    fn gather(&mut self, optics: &Optics, tile: &Tile, group: &Group, blocks: Range<u32>) -> Result<(), Mismatch> {
        let scene = optics.scene();
        while self.records.len() < group.lights.len() {
            self.records.push(self.record_leaves.iter().map(|_| column()).collect());
        }
        let first = blocks.start as usize * Lanes::COUNT;
        replay(optics, tile, group, blocks, |lane, _, surface| {
            let place = lane - first;
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
