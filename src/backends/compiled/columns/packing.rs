//! The columns of the variants that are in use: each has its own, with the static values that it reads alone.

use super::{Arrangement, Chunk, Columns};
use crate::backends::compiled::memory::StreamMemory;
use crate::jit::{CompiledVariant, Line};
use crate::scene::BodyId;
use crate::trace::{Hits, Tile};
use crate::world::EmitterId;
use rayon::prelude::*;
use std::sync::Arc;

/// What reads a part of the columns of a formula, or all of them.
pub(in crate::backends::compiled) struct Reader<'r> {
    /// The variant. `None` for a kernel of all branches, which reads all columns.
    pub(in crate::backends::compiled) variant: Option<&'r CompiledVariant>,
    /// Whether it computes each pair of a body and a light.
    pub(in crate::backends::compiled) pairs: &'r [bool],
}

/// Readers, and what is needed to know their pairs.
pub(in crate::backends::compiled) struct Packing<'r> {
    pub(in crate::backends::compiled) readers: &'r [Reader<'r>],
    /// The index of the pair of a body and the light of an emitter.
    pub(in crate::backends::compiled) pair: &'r (dyn Fn(BodyId, EmitterId) -> usize + Sync),
}

impl Packing<'_> {
    /// The columns of each reader, tile by tile. They are computed from the columns of the formula. The columns of a
    /// tile lie one reader after the other. `old` is memory that is not needed any more. It is used again if it has
    /// about the right size: the system takes longer to give memory than it takes to fill it.
    pub(in crate::backends::compiled) fn pack(
        &self,
        given: &[Columns],
        hits: &Hits,
        old: Option<StreamMemory>,
    ) -> Vec<Vec<Columns>> {
        let arrangements: Vec<Vec<Arrangement>> =
            hits.tiles.iter().zip(given).map(|(tile, given)| self.arrangements(tile, given)).collect();
        let end = |tile: &Vec<Arrangement>| tile.last().map_or(0, |arrangement| arrangement.end);
        let spare = |arrangement: &Arrangement| Arrangement::spare(arrangement.hit_columns, arrangement.record_columns);
        let spare = arrangements.iter().flatten().map(spare).max().unwrap_or(0);
        let needed = arrangements.iter().map(end).sum::<usize>() + spare;
        let old = old.filter(|old| (needed..=2 * needed).contains(&old.lines().len()));
        let mut memory = old.unwrap_or_else(|| StreamMemory::zeroed(needed));
        let mut parts = Vec::with_capacity(arrangements.len());
        let mut rest = memory.lines_mut();
        for tile in &arrangements {
            let (own, behind) = rest.split_at_mut(end(tile));
            parts.push(own);
            rest = behind;
        }
        hits.tiles.par_iter().zip(given).zip(&arrangements).zip(parts).for_each(|(((tile, given), arrangements), lines)| {
            for (reader, arrangement) in self.readers.iter().zip(arrangements) {
                self.fill(reader, tile, given, arrangement, lines);
            }
        });
        let memory = Arc::new(memory);
        let mut start = 0;
        let columns = |tile: Vec<Arrangement>| {
            let lines = start..start + end(&tile);
            start = lines.end;
            let own = |arrangement| Columns { memory: Arc::clone(&memory), lines: lines.clone(), arrangement };
            tile.into_iter().map(own).collect()
        };
        arrangements.into_iter().map(columns).collect()
    }

    /// The arrangement of the columns of each reader in a tile.
    fn arrangements(&self, tile: &Tile, given: &Columns) -> Vec<Arrangement> {
        let mut start = 0;
        let of_reader = |reader: &Reader| {
            let (hit_columns, record_columns) = match reader.variant {
                Some(variant) => (variant.hits.outputs(), variant.records.outputs()),
                None => (given.arrangement.hit_columns, given.arrangement.record_columns),
            };
            let arrangement = Arrangement::new(tile, start, hit_columns, record_columns, |group| {
                group.emitters.iter().any(|emitter| reader.pairs[(self.pair)(group.body, *emitter)])
            });
            start = arrangement.end;
            arrangement
        };
        self.readers.iter().map(of_reader).collect()
    }

    /// Computes the columns of a reader in the memory of a tile.
    fn fill(&self, reader: &Reader, tile: &Tile, given: &Columns, arrangement: &Arrangement, memory: &mut [Line]) {
        for (index, (group, own)) in tile.groups.iter().zip(&arrangement.groups).enumerate() {
            for chunk in Chunk::all(own) {
                let start = arrangement.chunk(own, &chunk);
                let (hit_lines, record_lines) = (chunk.lines * arrangement.hit_columns, chunk.lines * arrangement.record_columns);
                let part = given.part(index, chunk.first..chunk.first + chunk.lines);
                let hits = &given.lines()[part.hits()];
                let target = &mut memory[start..start + hit_lines];
                match reader.variant {
                    Some(variant) => variant.hits.run([hits, &[], &[]], &[], &mut [target], chunk.lines),
                    None => target.copy_from_slice(hits),
                }
                for (light, emitter) in group.emitters.iter().enumerate() {
                    if !reader.pairs[(self.pair)(group.body, *emitter)] {
                        continue;
                    }
                    let records = &given.lines()[part.records(light)];
                    let start = start + hit_lines + light * record_lines;
                    let target = &mut memory[start..start + record_lines];
                    match reader.variant {
                        Some(variant) => variant.records.run([hits, records, &[]], &[], &mut [target], chunk.lines),
                        None => target.copy_from_slice(records),
                    }
                }
            }
        }
    }
}
