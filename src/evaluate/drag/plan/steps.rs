//! What has to be made for each tile before a drag is quick there, in steps of known cost.

use crate::evaluate::compiled::Compiled;
use crate::evaluate::drag::Method;
use crate::evaluate::drag::images::Key;
use crate::evaluate::drag::plan::{PathWeights, Plan};
use crate::evaluate::planes::Weight;
use crate::trace::{Group, Span, Tile};
use std::collections::BTreeSet;
use std::ops::Range;

/// More images of a tile than this are not kept.
const MOST_IMAGES: usize = 40;

/// Something that is made for a tile before the drag is quick there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::evaluate::drag) enum Work {
    /// Columns of what is kept for each record.
    Kept,
    /// An image.
    Image(Key),
    /// What rests. It is the last.
    Base,
}

/// A part of what is made for a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::evaluate::drag) struct Step {
    pub(in crate::evaluate::drag) work: Work,
    /// About how long it takes, in units of adding a block to the pixels, which is about half of evaluating it
    /// for a light.
    pub(in crate::evaluate::drag) cost: u64,
}

impl Plan {
    /// About what a full evaluation costs, in the units of [`Step::cost`].
    pub(in crate::evaluate::drag) fn full_cost(&self, compiled: &Compiled) -> u64 {
        compiled.hits.tiles.iter().map(tile_cost).sum()
    }

    /// What has to be made for a tile; nothing where nothing that moves is seen in it.
    pub(in crate::evaluate::drag) fn steps(&self, compiled: &Compiled, place: usize, memory: &[f32]) -> Vec<Step> {
        let tile = &compiled.hits.tiles[place];
        let weights = self.path_weights(compiled, tile, memory);
        let base = Step { work: Work::Base, cost: tile_cost(tile) };
        match self.method {
            Method::Images => {
                let mut steps = self.image_steps(tile, &weights);
                if steps.len() > MOST_IMAGES {
                    // Too many to be worth it; the base alone means the general way.
                    return vec![Step { cost: 0, ..base }];
                }
                if !steps.is_empty() {
                    steps.push(base);
                }
                steps
            }
            Method::Specialised => {
                let mut own = Vec::new();
                weights.of(Key::default(), &mut own);
                let moving = || tile.groups.iter().filter(|group| self.moves_group(group));
                if moving().all(|group| live_blocks(tile.spans_of(group), &own) == 0) {
                    return Vec::new();
                }
                let cost = moving().map(|group| group_cost(group.lights.len(), blocks(&group.hits))).sum();
                let kept = self.kernels.kept.as_ref().map(|_| Step { work: Work::Kept, cost });
                kept.into_iter().chain([base]).collect()
            }
            Method::General => Vec::new(),
        }
    }

    /// The images of a tile that are not black, apart from the base.
    fn image_steps(&self, tile: &Tile, weights: &PathWeights) -> Vec<Step> {
        let powers: BTreeSet<(u8, u8)> = weights.counts.iter().copied().collect();
        let (mut own, mut steps) = (Vec::new(), Vec::new());
        for (reflections, refractions) in powers {
            weights.of(Key { reflections, refractions, term: 0 }, &mut own);
            let live: Vec<(&Group, usize)> = tile
                .groups
                .iter()
                .map(|group| (group, live_blocks(tile.spans_of(group), &own)))
                .filter(|(_, blocks)| *blocks > 0)
                .collect();
            let misses = live_blocks(&tile.misses, &own) as u64;
            for term in 0..=self.terms.len() {
                // Terms are far fewer than 256.
                let key = Key { reflections, refractions, term: term as u8 };
                let of_group = |(group, blocks): &(&Group, usize)| Some(group_cost(self.reached(group, term)?, *blocks));
                let cost: u64 =
                    live.iter().filter_map(of_group).sum::<u64>() + if self.has_background(term) { misses } else { 0 };
                if cost > 0 && !key.is_base() {
                    steps.push(Step { work: Work::Image(key), cost: cost + pixels_cost(tile) });
                }
            }
        }
        steps
    }
}

/// About what a full evaluation of a tile costs.
fn tile_cost(tile: &Tile) -> u64 {
    let groups: u64 = tile.groups.iter().map(|group| group_cost(group.lights.len(), blocks(&group.hits))).sum();
    groups + tile.miss_segments.len() as u64 + pixels_cost(tile)
}

/// About how many blocks of four so many hits take.
fn blocks(hits: &Range<u32>) -> usize {
    hits.len().div_ceil(4)
}

/// The blocks of spans whose weight is not 0.
fn live_blocks(spans: &[Span], weights: &[Weight]) -> usize {
    spans.iter().filter(|span| !weights[span.path.index()].is_zero()).map(|span| blocks(&span.hits)).sum()
}

/// What so many blocks of a group cost for so many lights: their evaluation, and adding them to pixels.
fn group_cost(lights: usize, blocks: usize) -> u64 {
    (blocks * (2 * lights + 1)) as u64
}

/// What clearing and reading the pixels of a tile costs.
fn pixels_cost(tile: &Tile) -> u64 {
    tile.pixels.len() as u64 / 4
}
