//! Estimates of what a frame of a tile costs by each method. Stored numbers are traffic of memory: where they spare
//! little computation, a full evaluation is faster.
//!
//! The unit is the time of a simple instruction for sixteen records with 16 lanes. The constants were fitted to
//! `benches/drags` with 16, 8 and 4 lanes. No time is measured while the program runs, so the choice is the same in
//! every run.

use crate::backends::compiled::Compiled;
use crate::backends::compiled::drag::cells::CELL_PIXELS;
use crate::backends::compiled::drag::reach::Reach;
use crate::backends::compiled::drag::summations::DragKernels;
use crate::backends::compiled::drag::work::weighted_blocks;
use crate::evaluate::weights::{PathMonomials, Powers, Weight};
use crate::formula::graph::Graph;
use crate::jit::Width;
use crate::lang::variables::Owner;
use crate::plan::{Channels, ContributionPlan, KernelWork};
use crate::trace::{Group, Tile};
use crate::world::EmitterId;

/// To read a column, for sixteen records.
const COLUMN: f64 = 5.0;
/// To pass over a column that is not read, for sixteen records: memory delivers it with those beside it.
const UNREAD_COLUMN: f64 = 4.0;
/// To read columns of a drag beside the static ones, for sixteen records.
const DRAG_COLUMNS: f64 = 15.0;
/// To add sixteen hits to the pixels, with 16 lanes.
const ADD: f64 = 14.0;
/// To fill a cell with the terms without lights, and to write it.
const FILL_AND_WRITE: f64 = 13.0;
/// To restore the base of a cell, and to write it.
const RESTORE_AND_WRITE: f64 = 46.0;
/// To write a cell whose images were added.
const WRITE_SUM: f64 = 3.0;
/// To read three components, or one component, of the base or of an image in a cell.
const IMAGE: f64 = 30.0;
const IMAGE_COMPONENT: f64 = 10.0;

/// The most that a frame with stored data may cost, as a share of a full evaluation. The estimate of a live part is
/// wrong by up to a third, most where memory is slow. That of images is wrong by less.
const MOST_LIVE: f64 = 0.7;
const MOST_IMAGES: f64 = 0.9;

/// The costs of the kernels of a drag, for sixteen hits.
#[derive(Debug, Clone, Default)]
pub(super) struct FrameEstimate {
    /// The whole contribution of each pair of a body and a light, body by body. 0 if the light adds nothing during the
    /// drag.
    full: Vec<f64>,
    /// The live part of a pair.
    live: f64,
    /// To add the sum of all lights to the pixels.
    add: f64,
    lights: usize,
}

impl FrameEstimate {
    /// The estimate for the numbers before the drag.
    pub(super) fn new(compiled: &Compiled, kernels: &DragKernels, parameters: &[f32]) -> Self {
        let of = |plan: &ContributionPlan, graph: &Graph| {
            let KernelWork { instructions, columns } = plan.records.work(graph);
            f64::from(instructions) * instruction(compiled.width()) + f64::from(columns) * COLUMN
        };
        let formula = &compiled.compiled;
        let whole = of(&formula.plan.contribution, &formula.plan.bindings.graph);
        // Where the formula chooses, the kernels of a pair have the branches that it takes.
        let chosen = compiled.chosen(parameters);
        let of_variant = |pair: usize| {
            let variant = chosen.as_ref()?.variants.iter().find(|variant| variant.pairs[pair])?;
            let plan = &variant.compiled.as_ref()?.plan;
            Some(of(&plan.contribution, &plan.bindings.graph))
        };
        let [bodies, lights] = [Owner::Body, Owner::Light].map(|owner| compiled.equation.layout.owners(owner));
        let of_pair = |pair: usize| match kernels.plan.may_be_on(parameters, pair % lights) {
            true => of_variant(pair).unwrap_or(whole),
            false => 0.0,
        };
        let full = (0..bodies * lights).map(of_pair).collect();
        let slider = &kernels.plan.slider;
        let moving = slider.moving.iter().map(|plan| of(plan, &slider.separation.bindings.graph));
        let columns = if slider.columns.is_some() { DRAG_COLUMNS } else { 0.0 };
        // A live part reads a part of the columns of the formula, as do variants. But those have columns of their own.
        let frontier = &formula.plan.bindings.frontier;
        let read = |plan: &ContributionPlan| {
            let all = plan.records.work(&slider.separation.bindings.graph).columns as usize;
            all.saturating_sub(plan.records.streams[2].len())
        };
        let read = slider.moving.iter().map(read).max().unwrap_or(0);
        let unread = (frontier.hits.len() + frontier.records.len()).saturating_sub(read) as f64 * UNREAD_COLUMN;
        Self { full, live: moving.sum::<f64>() + columns + unread, add: ADD * adding(compiled.width()), lights }
    }

    /// Whether images are worth having in a tile: this many cells of the base and of images, to write this many. A full
    /// evaluation is that of a pass times `passes`.
    pub(super) fn images_pay(
        &self,
        (images, cells): (usize, usize),
        passes: usize,
        reach: &Reach,
        tile: &Tile,
        monomials: &PathMonomials,
    ) -> bool {
        let image = match reach.plan.channels {
            Channels::All => IMAGE,
            Channels::One(_) => IMAGE_COMPONENT,
        };
        let cost = images as f64 * image + cells as f64 * WRITE_SUM;
        cost <= MOST_IMAGES * passes as f64 * self.full(reach, tile, monomials)
    }

    /// Whether a live part in this many cells is worth having in a tile.
    pub(super) fn live_pays(&self, cells: usize, reach: &Reach, tile: &Tile, monomials: &PathMonomials) -> bool {
        self.live(cells, reach, tile, monomials) <= MOST_LIVE * self.full(reach, tile, monomials)
    }

    /// The cost of a full evaluation of a tile. All paths count that may add something during the drag.
    fn full(&self, reach: &Reach, tile: &Tile, monomials: &PathMonomials) -> f64 {
        let of_group = |group: &Group| {
            let kernels: f64 = group.emitters.iter().map(|emitter| self.full[self.pair(reach, group, *emitter)]).sum();
            lines(tile, group, &monomials.fixed) * (kernels + self.add)
        };
        let misses = weighted_blocks(&tile.misses, &monomials.fixed) as f64 / BLOCKS;
        let cells = tile.pixels.len() as f64 / CELL_PIXELS as f64;
        tile.groups.iter().map(of_group).sum::<f64>() + misses + cells * FILL_AND_WRITE
    }

    /// The cost of a frame of a tile with a live part in this many cells.
    fn live(&self, cells: usize, reach: &Reach, tile: &Tile, monomials: &PathMonomials) -> f64 {
        let mut own = Vec::new();
        monomials.of(Powers::default(), &mut own);
        let of_group = |group: &Group| {
            let moves = |emitter: &&EmitterId| {
                self.full[self.pair(reach, group, **emitter)] > 0.0 && reach.moves_pair(group.body.index(), **emitter)
            };
            lines(tile, group, &own) * (group.emitters.iter().filter(moves).count() as f64 * self.live + self.add)
        };
        let moving = tile.groups.iter().filter(|group| reach.moves_group(group));
        moving.map(of_group).sum::<f64>() + cells as f64 * RESTORE_AND_WRITE
    }

    fn pair(&self, reach: &Reach, group: &Group, emitter: EmitterId) -> usize {
        group.body.index() * self.lights + reach.world.light_of(emitter).index()
    }
}

/// The time of a simple instruction for sixteen records. Divisions, roots and loads gain less from wide vectors than
/// other instructions.
fn instruction(width: Width) -> f64 {
    match width {
        Width::Sixteen => 1.0,
        Width::Eight => 1.2,
        Width::Four => 2.4,
    }
}

/// How much longer it takes to add to pixels than with 16 lanes.
fn adding(width: Width) -> f64 {
    match width {
        Width::Sixteen => 1.0,
        Width::Eight => 1.2,
        Width::Four => 1.6,
    }
}

/// Four hits are a block, and four blocks are a line.
const BLOCKS: f64 = 4.0;

/// The lines of the hits of a group whose path weight is not 0.
fn lines(tile: &Tile, group: &Group, weights: &[Weight]) -> f64 {
    weighted_blocks(tile.spans_of(group), weights) as f64 / BLOCKS
}
