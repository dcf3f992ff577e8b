//! The preparation of each tile for a drag, in work items of known cost.

use crate::backends::compiled::Compiled;
use crate::backends::compiled::drag::images::Key;
use crate::backends::compiled::drag::reach::Reach;
use crate::evaluate::weights::{PathMonomials, Powers, Weight};
use crate::plan::{DragPlan, Method};
use crate::trace::{Group, Span, Tile};
use crate::world::World;
use std::collections::BTreeSet;
use std::ops::Range;

/// If a tile needs more images than this, none are kept.
const MOST_IMAGES: usize = 40;

/// The result of a work item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Work {
    /// Columns that the live part reads.
    Columns,
    /// An image.
    Image(Key),
    /// The image of everything that does not move. It is the last item.
    Base,
}

/// A part of the preparation of a tile, done at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct WorkItem {
    pub(super) work: Work,
    /// Its approximate cost. The unit is the time to add four hits to the pixels, about half of the time to evaluate
    /// them for a light.
    pub(super) cost: u64,
}

/// The approximate cost of a full evaluation, in the unit of [`WorkItem::cost`].
pub(super) fn full_cost(compiled: &Compiled) -> u64 {
    compiled.hits.tiles.iter().map(tile_cost).sum()
}

/// The work items for a tile, in their order. There are none if nothing that moves is visible in it.
pub(super) fn work_items(plan: &DragPlan, world: &World, tile: &Tile, monomials: &PathMonomials) -> Vec<WorkItem> {
    let reach = Reach { plan, world, has_fixed: plan.slider.fixed.is_some() };
    let base = WorkItem { work: Work::Base, cost: tile_cost(tile) };
    match plan.method {
        Method::Images => {
            let mut items = image_items(&reach, tile, monomials);
            if items.len() > MOST_IMAGES {
                // A base without images means the general method.
                return vec![WorkItem { cost: 0, ..base }];
            }
            if !items.is_empty() {
                items.push(base);
            }
            items
        }
        Method::Specialised => {
            let mut own = Vec::new();
            monomials.of(Powers::default(), &mut own);
            let moving = || tile.groups.iter().filter(|group| reach.moves_group(group));
            if moving().all(|group| weighted_blocks(tile.spans_of(group), &own) == 0) {
                return Vec::new();
            }
            let cost = moving().map(|group| group_cost(group.emitters.len(), blocks(&group.hits))).sum();
            let columns = plan.slider.columns.as_ref().map(|_| WorkItem { work: Work::Columns, cost });
            columns.into_iter().chain([base]).collect()
        }
        Method::General => Vec::new(),
    }
}

/// The images of a tile that are not black, apart from the base.
fn image_items(reach: &Reach, tile: &Tile, monomials: &PathMonomials) -> Vec<WorkItem> {
    let all: BTreeSet<Powers> = monomials.powers.iter().copied().collect();
    let (mut own, mut items) = (Vec::new(), Vec::new());
    for powers in all {
        monomials.of(powers, &mut own);
        let weighted: Vec<(&Group, usize)> = tile
            .groups
            .iter()
            .map(|group| (group, weighted_blocks(tile.spans_of(group), &own)))
            .filter(|(_, blocks)| *blocks > 0)
            .collect();
        let misses = weighted_blocks(&tile.misses, &own) as u64;
        // There are far fewer terms than 256.
        for term in 0..=reach.plan.terms.len() as u8 {
            let key = Key { powers, term };
            let of_group = |(group, blocks): &(&Group, usize)| Some(group_cost(reach.emitters_of(group, term)?, *blocks));
            let hits: u64 = weighted.iter().filter_map(of_group).sum();
            let cost = hits + if reach.has_misses(term) { misses } else { 0 };
            if cost > 0 && !key.is_base() {
                items.push(WorkItem { work: Work::Image(key), cost: cost + pixels_cost(tile) });
            }
        }
    }
    items
}

/// The approximate cost of a full evaluation of a tile.
fn tile_cost(tile: &Tile) -> u64 {
    let groups: u64 = tile.groups.iter().map(|group| group_cost(group.emitters.len(), blocks(&group.hits))).sum();
    groups + tile.miss_segments.len() as u64 + pixels_cost(tile)
}

/// The number of blocks of four for these hits.
fn blocks(hits: &Range<u32>) -> usize {
    hits.len().div_ceil(4)
}

/// The blocks of spans whose weight is not 0.
pub(super) fn weighted_blocks(spans: &[Span], weights: &[Weight]) -> usize {
    spans.iter().filter(|span| !weights[span.path.index()].is_zero()).map(|span| blocks(&span.hits)).sum()
}

/// The cost of some blocks of a group for some lights: to evaluate them, and to add them to pixels.
fn group_cost(lights: usize, blocks: usize) -> u64 {
    (blocks * (2 * lights + 1)) as u64
}

/// The cost of clearing and reading the pixels of a tile.
fn pixels_cost(tile: &Tile) -> u64 {
    tile.pixels.len() as u64 / 4
}
