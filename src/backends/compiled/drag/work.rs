//! The preparation of each tile for a drag, in work items of known cost.

use crate::backends::compiled::Compiled;
use crate::backends::compiled::drag::cells::largest;
use crate::backends::compiled::drag::images::{Key, LARGEST_SUM};
use crate::backends::compiled::drag::reach::Reach;
use crate::backends::compiled::drag::summations::DragPasses;
use crate::backends::compiled::place::TilePlace;
use crate::evaluate::weights::{PathMonomials, Powers, Weight};
use crate::picture::Frame;
use crate::plan::Method;
use crate::trace::{Group, Span, Tile};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// If a tile needs more images than this, none are kept.
const MOST_IMAGES: usize = 40;

/// The result of a work item.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Work {
    /// Columns that the live part reads, of these passes.
    Columns(Range<usize>),
    /// The sum of an image over these passes.
    Image(Key, Range<usize>),
    /// The image of everything that does not move, by evaluating all passes. It is the last item.
    Base,
    /// The same, from the picture that the drag begins with and what is made of the first passes, of which there are
    /// this many.
    BaseOfPicture(usize),
}

/// A part of the preparation of a tile, done at once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct WorkItem {
    pub(super) work: Work,
    /// Items of a lower stage come first, in all tiles.
    pub(super) stage: u32,
    /// Its approximate cost. The unit is the time to add four hits to the pixels, about half of the time to evaluate
    /// them for a light.
    pub(super) cost: u64,
}

/// The approximate cost of a full evaluation of one pass, in the unit of [`WorkItem::cost`].
pub(super) fn full_cost(compiled: &Compiled) -> u64 {
    compiled.first_tiles().iter().map(tile_cost).sum()
}

/// What is to be prepared.
#[derive(Clone, Copy)]
pub(super) struct WorkList<'w> {
    pub(super) drag: DragPasses<'w>,
    pub(super) reach: Reach<'w>,
    /// How many passes a frame with a live part evaluates, if the drag begins with a picture.
    pub(super) from_picture: Option<usize>,
    /// The picture that it begins with.
    pub(super) picture: Option<&'w Frame>,
}

impl WorkList<'_> {
    /// The work items for a tile, in their order. There are none if nothing that moves is visible in it. `None` if
    /// there would be too many images.
    pub(super) fn of_tile(&self, tile: usize) -> Option<Vec<WorkItem>> {
        match self.drag.plan.method {
            Method::Images => self.images(tile),
            Method::Specialised => Some(self.live(tile)),
            Method::General => Some(Vec::new()),
        }
    }

    /// The hits of a tile in some passes, with the weights of their paths.
    fn passes(&self, passes: Range<usize>, tile: usize) -> impl Iterator<Item = (&Tile, PathMonomials)> {
        let DragPasses { compiled, plan, parameters } = self.drag;
        passes.map(move |pass| {
            let own = compiled.tile_at(TilePlace { pass, tile });
            (own, compiled.monomials(plan, own, parameters))
        })
    }

    fn images(&self, tile: usize) -> Option<Vec<WorkItem>> {
        let all = self.drag.compiled.passes.len();
        let stages = match self.from_picture {
            Some(_) => doubling(all),
            None => std::iter::once(0..all).collect(),
        };
        let mut keys = BTreeSet::new();
        let mut items = Vec::new();
        for (stage, passes) in (0..).zip(stages) {
            let mut costs: BTreeMap<Key, u64> = BTreeMap::new();
            for (own, monomials) in self.passes(passes.clone(), tile) {
                for (key, cost) in image_costs(&self.reach, own, &monomials) {
                    *costs.entry(key).or_default() += cost;
                }
            }
            keys.extend(costs.keys().copied());
            if keys.len() > MOST_IMAGES {
                return None;
            }
            let images = costs.into_iter().map(|(key, cost)| WorkItem { work: Work::Image(key, passes.clone()), stage, cost });
            items.extend(images);
            if self.from_picture.is_some() && !keys.is_empty() {
                let cost = pixels_cost(&self.drag.compiled.first_tiles()[tile]) * keys.len() as u64;
                items.push(match passes.end == all && self.is_large(tile) {
                    // The base of such a picture would have the rounding errors of its large numbers.
                    true => WorkItem { stage, ..self.base(tile) },
                    false => WorkItem { work: Work::BaseOfPicture(passes.end), stage, cost },
                });
            }
        }
        if self.from_picture.is_none() && !items.is_empty() {
            items.push(self.base(tile));
        }
        Some(items)
    }

    fn live(&self, tile: usize) -> Vec<WorkItem> {
        let passes = 0..self.from_picture.unwrap_or(self.drag.compiled.passes.len());
        let (mut own, mut cost, mut is_visible) = (Vec::new(), 0, false);
        for (hits, monomials) in self.passes(passes.clone(), tile) {
            monomials.of(Powers::default(), &mut own);
            let moving = || hits.groups.iter().filter(|group| self.reach.moves_group(group));
            is_visible |= moving().any(|group| weighted_blocks(hits.spans_of(group), &own) > 0);
            cost += moving().map(|group| group_cost(group.emitters.len(), blocks(&group.hits))).sum::<u64>();
        }
        if !is_visible {
            return Vec::new();
        }
        let base = match self.from_picture {
            Some(passes) => WorkItem { work: Work::BaseOfPicture(passes), stage: 0, cost },
            None => self.base(tile),
        };
        let columns = self.drag.plan.slider.columns.as_ref().map(|_| WorkItem { work: Work::Columns(passes), stage: 0, cost });
        columns.into_iter().chain([base]).collect()
    }

    /// Whether the picture that the drag begins with has large numbers in a tile.
    fn is_large(&self, tile: usize) -> bool {
        let pixels = &self.drag.compiled.first_tiles()[tile].pixels;
        self.picture.is_some_and(|picture| largest(picture.part(pixels).as_flattened()) > LARGEST_SUM)
    }

    fn base(&self, tile: usize) -> WorkItem {
        let passes = 0..self.drag.compiled.passes.len();
        let cost = passes.map(|pass| tile_cost(self.drag.compiled.tile_at(TilePlace { pass, tile }))).sum();
        WorkItem { work: Work::Base, stage: 0, cost }
    }
}

/// The first pass, the second, two more, four more and so on.
fn doubling(all: usize) -> Vec<Range<usize>> {
    let starts = std::iter::once(0).chain(std::iter::successors(Some(1), |start| Some(2 * start)));
    starts.take_while(|start| *start < all).map(|start| start..(2 * start).max(1).min(all)).collect()
}

/// The images of a tile in one pass that are not black, apart from the base, with their costs.
fn image_costs(reach: &Reach, tile: &Tile, monomials: &PathMonomials) -> Vec<(Key, u64)> {
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
                items.push((key, cost + pixels_cost(tile)));
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
