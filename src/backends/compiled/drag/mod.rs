//! Frames while a slider is held. Only what the slider can change is computed, by the cheapest correct method.
//!
//! Pixels that no moved number affects are not written again. For the others there are three methods:
//!
//! - **Images**, where the graph proves the picture to be a weighted sum of images that do not move: `Σ kr^i · kt^j ·
//!   factor · image`. kr and kt of a body are polynomials along paths; ki, colours and most weights enter the formula
//!   linearly.
//! - **Specialised**, elsewhere: everything that does not move is one image, and a kernel computes the live part from
//!   columns that keep every expensive value that does not move.
//! - **General**, where neither is possible or ready yet, or faster: the whole picture again.
//!
//! Images, bases and columns are made tile by tile, between frames, so that no frame waits for them. Each
//! [`prepare`](Drag::prepare) does about as much work as a full evaluation of one pass. A tile whose images would be
//! inaccurate, would exceed the budget or would not be faster is drawn by the general method. [`estimate`] decides what
//! is faster.
//!
//! A picture of several passes is linear in the pictures of the passes, so images are sums over the passes, and a frame
//! takes as long as with one. Until they are made, and for all other methods, a frame takes the picture before the drag
//! and changes it by what the numbers change in few passes: the noise of the few passes is only in the change.

mod cells;
mod estimate;
mod images;
mod preparation;
mod reach;
mod summations;
#[cfg(test)]
mod tests;
mod tile_state;
mod whole;
mod work;

use crate::backends::compiled::Compiled;
use crate::backends::compiled::chosen::DragVariants;
use crate::backends::compiled::tile::TileScratch;
use crate::evaluate::{Drag, DragBeginning, Framebuffer, Part};
use crate::jit::CompileError;
use crate::picture::{Frame, rest_of};
use crate::plan::Method;
use estimate::FrameEstimate;
use images::{Key, factor_of};
use preparation::Preparation;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};
use summations::{DragKernels, DragPasses};
use tile_state::{LivePart, TileDrag, TileState, TileWork};
use whole::WholeSummations;
use work::{WorkItem, WorkList, full_cost};

/// A slider that is held: frames in which only some numbers of one owner move.
pub(super) struct CompiledDrag {
    compiled: Arc<Compiled>,
    kernels: DragKernels,
    estimate: FrameEstimate,
    /// The parameter numbers that all stored data was made with, apart from those that move.
    parameters: Vec<f32>,
    tiles: Vec<TileDrag>,
    /// The picture that the drag begins with, if it does.
    picture: Option<Arc<Frame>>,
    /// How many passes a frame evaluates, where it evaluates any.
    passes: usize,
    /// Whether a whole picture has been drawn.
    drawn: bool,
    /// What the formula chooses, if it chose otherwise for the picture before.
    new_choices: Option<Vec<u32>>,
    /// The most bytes that may be stored, and the bytes that are stored.
    budget: usize,
    bytes: usize,
}

impl CompiledDrag {
    /// Begins a drag of numbers of one owner. `moved` are their indices in `parameters`, which holds the values before
    /// the drag. At most `budget` bytes are stored. It may begin with a picture of these values.
    ///
    /// # Errors
    /// The kernels are too large for the code generator.
    ///
    /// # Panics
    /// If there are fewer parameter numbers than the layout has.
    pub(super) fn new(
        compiled: &Arc<Compiled>,
        moved: &[usize],
        parameters: &[f32],
        budget: usize,
        beginning: Option<&DragBeginning>,
    ) -> Result<Self, CompileError> {
        compiled.check_parameters(parameters);
        let kernels = DragKernels::new(compiled, moved)?;
        let all = compiled.passes.len();
        let mut drag = Self {
            compiled: Arc::clone(compiled),
            kernels,
            estimate: FrameEstimate::default(),
            parameters: Vec::new(),
            tiles: Vec::new(),
            picture: beginning.map(|beginning| Arc::clone(&beginning.picture)),
            passes: beginning.map_or(all, |beginning| beginning.passes.clamp(1, all)),
            drawn: false,
            new_choices: None,
            budget,
            bytes: 0,
        };
        drag.restart(parameters);
        Ok(drag)
    }

    /// Counts the stored bytes, from the first tile on. Drops the data of each tile that does not fit into the rest of
    /// the budget; later tiles that need less may fit.
    fn settle(&mut self) {
        self.bytes = 0;
        for tile in &mut self.tiles {
            let bytes = tile.bytes();
            if self.bytes + bytes > self.budget {
                *tile = TileDrag::whole();
            } else {
                self.bytes += bytes;
            }
        }
    }

    fn restart(&mut self, parameters: &[f32]) {
        self.parameters = parameters.to_vec();
        self.drawn = false;
        self.estimate = FrameEstimate::new(&self.compiled, &self.kernels, parameters);
        let compiled = &*self.compiled;
        let plan = &self.kernels.plan;
        let list = WorkList {
            drag: DragPasses { compiled, plan, parameters: &self.parameters },
            reach: self.kernels.reach(compiled),
            from_picture: self.picture.as_ref().map(|_| self.passes),
            picture: self.picture.as_deref(),
        };
        let of_tile = |tile: usize| match list.of_tile(tile) {
            _ if plan.method == Method::General => TileDrag::whole(),
            None => TileDrag::whole(),
            Some(items) if items.is_empty() => TileDrag { state: TileState::Untouched, work: None },
            Some(_) if plan.method == Method::Specialised && !self.specialising_pays(tile) => TileDrag::whole(),
            Some(items) => {
                let work = TileWork { items, done: 0, images: Vec::new(), columns: Vec::new() };
                TileDrag { state: TileState::Whole(None), work: Some(work) }
            }
        };
        self.tiles = (0..compiled.first_tiles().len()).into_par_iter().map(of_tile).collect();
        self.settle();
    }

    /// Whether a live part is faster in a tile than a full evaluation, by the estimate.
    fn specialising_pays(&self, tile: usize) -> bool {
        let reach = self.kernels.reach(&self.compiled);
        let tile = &self.compiled.first_tiles()[tile];
        let monomials = self.compiled.monomials(&self.kernels.plan, tile, &self.parameters);
        let mut cells = cells::CellSet::none(tile.pixels.len());
        reach.add_live_cells(tile, &monomials, &mut cells);
        self.estimate.live_pays(cells.cells().len(), &reach, tile, &monomials)
    }

    /// The number of work items of each tile that are done next: together they cost about one full evaluation of a
    /// pass.
    fn next_counts(&self) -> Vec<usize> {
        let mut rest = full_cost(&self.compiled);
        let mut counts: Vec<usize> = vec![0; self.tiles.len()];
        let left: Vec<&[WorkItem]> = self.tiles.iter().map(|tile| tile.work.as_ref().map_or(&[][..], TileWork::left)).collect();
        let stages: BTreeSet<u32> = left.iter().copied().flatten().map(|item| item.stage).collect();
        'stages: for stage in stages {
            for (items, count) in left.iter().zip(&mut counts) {
                for item in items[*count..].iter().take_while(|item| item.stage == stage) {
                    if item.cost > rest {
                        break 'stages;
                    }
                    rest -= item.cost;
                    *count += 1;
                }
            }
        }
        // An item that costs more than a full evaluation is done alone.
        let first = left.iter().enumerate().filter_map(|(tile, items)| Some((items.first()?.stage, tile))).min();
        if let Some((_, tile)) = first
            && counts.iter().all(|count| *count == 0)
        {
            counts[tile] = 1;
        }
        counts
    }
}

impl Drag for CompiledDrag {
    /// If no tile has stored data at the end of the preparation, every frame is drawn by the general method.
    fn method(&self) -> Method {
        let general = self.tiles.iter().any(|tile| matches!(tile.state, TileState::Whole(_)) && tile.work.is_none());
        if general && !self.tiles.iter().any(TileDrag::is_stored) { Method::General } else { self.kernels.plan.method }
    }

    fn bytes(&self) -> usize {
        self.bytes
    }

    fn pixels(&self) -> usize {
        self.tiles.iter().zip(self.compiled.first_tiles()).map(|(state, tile)| state.pixels(tile.pixels.len())).sum()
    }

    fn is_ready(&self) -> bool {
        self.tiles.iter().all(|tile| tile.work.is_none())
    }

    fn linear(&self, parameters: &[f32]) -> Option<Frame> {
        if !self.is_ready() || !self.kernels.plan.same_fixed(&self.parameters, parameters) {
            return None;
        }
        let factors = self.kernels.plan.factors(parameters);
        let factor = |key: Key| factor_of(key, &factors);
        let is_known = |tile: &TileDrag| match &tile.state {
            TileState::Untouched => true,
            TileState::Images { images, .. } => images.is_accurate(&factor),
            TileState::Live(_) | TileState::Whole(_) => false,
        };
        if !self.tiles.iter().all(is_known) {
            return None;
        }
        let mut frame = Frame::clone(self.picture.as_ref()?);
        for (state, tile) in self.tiles.iter().zip(self.compiled.first_tiles()) {
            if let TileState::Images { images, .. } = &state.state {
                images.set_linear(&factor, &mut frame.linear[tile.pixels.start as usize..tile.pixels.end as usize]);
            }
        }
        Some(frame)
    }

    fn is_of_all_passes(&self) -> bool {
        let is_known = |tile: &TileDrag| match tile.state {
            TileState::Untouched => true,
            TileState::Images { right, .. } => right,
            TileState::Live(_) | TileState::Whole(_) => false,
        };
        self.passes == self.compiled.passes.len() || self.is_ready() && self.tiles.iter().all(is_known)
    }

    fn frame(&mut self, parameters: &[f32], framebuffer: &mut Framebuffer) {
        self.compiled.check_size(framebuffer);
        self.compiled.check_parameters(parameters);
        if !self.kernels.plan.same_fixed(&self.parameters, parameters) {
            self.picture = None;
            self.passes = self.compiled.passes.len();
            self.restart(parameters);
        }
        if let Some(picture) = self.picture.as_ref().filter(|_| !self.drawn) {
            framebuffer.set(picture);
            self.drawn = true;
        }
        let compiled = &*self.compiled;
        let plan = &self.kernels.plan;
        let factors = plan.factors(parameters);
        let factor = |key: Key| factor_of(key, &factors);
        // Once everything is made, few tiles are drawn by the general method. If there is none, the variants that a
        // moved number chooses are not needed.
        let any_whole = self.tiles.iter().any(|tile| tile.is_drawn_whole(self.drawn, &factor));
        let variants = if any_whole { compiled.chosen_in_drag(parameters, &mut self.new_choices) } else { None };
        let before = match &self.picture {
            Some(_) if any_whole => compiled.chosen_in_drag(&self.parameters, &mut self.new_choices.clone()),
            Some(_) | None => None,
        };
        let whole = WholeFrame {
            compiled,
            now: (parameters, variants.as_ref(), OnceLock::new()),
            before: (&self.parameters, before.as_ref(), OnceLock::new()),
            picture: self.picture.as_deref(),
            passes: self.passes,
        };
        let live = self.kernels.live_summation(compiled, parameters);
        let live = live.as_ref().map(|summation| LivePart { compiled, summation, parameters });
        let (channels, drawn) = (plan.channels, self.drawn);
        let tiles = framebuffer.parts().zip(&mut self.tiles);
        compiled.each_tile(tiles, |(part, tile), index, scratch| match &mut tile.state {
            TileState::Untouched if drawn => {}
            TileState::Images { images, right } => {
                let (accurate, was_right) = (images.is_accurate(&factor), drawn && *right);
                if !(accurate && was_right) {
                    let part = Part { pixels: &mut *part.pixels, encoder: part.encoder };
                    whole.draw(index, &mut None, scratch, part);
                }
                // The images have all passes, and what was drawn may have some of them.
                if accurate && (was_right || whole.is_of_some_passes()) {
                    images.draw(compiled.width(), &factor, part);
                }
                *right = accurate;
            }
            TileState::Live(tile) if drawn => {
                if let Some(live) = &live {
                    tile.draw(live, index, channels, scratch, part);
                }
            }
            TileState::Untouched | TileState::Live(_) => whole.draw(index, &mut None, scratch, part),
            TileState::Whole(rest) => whole.draw(index, rest, scratch, part),
        });
        self.drawn = true;
    }

    fn prepare(&mut self) -> bool {
        if self.is_ready() {
            return true;
        }
        let counts = self.next_counts();
        if counts.iter().any(|count| *count > 0) {
            let compiled = &*self.compiled;
            let chosen = compiled.chosen(&self.parameters);
            let preparation = Preparation {
                drag: DragPasses { compiled, plan: &self.kernels.plan, parameters: &self.parameters },
                kernels: &self.kernels,
                estimate: &self.estimate,
                summations: self.kernels.summations(compiled, &self.parameters, chosen.as_deref()),
                live: self.kernels.live_summation(compiled, &self.parameters),
                factors: self.kernels.plan.factors(&self.parameters),
                picture: self.picture.as_deref(),
            };
            compiled.each_tile(self.tiles.par_iter_mut().zip(counts), |(tile, count), index, scratch| {
                for _ in 0..count {
                    preparation.advance(tile, index, scratch);
                }
            });
            self.settle();
        }
        self.is_ready()
    }
}

/// A set of parameter numbers with what a formula chooses for them, and the summations once they are needed.
type WholeNumbers<'w> = (&'w [f32], Option<&'w DragVariants>, OnceLock<WholeSummations<'w>>);

/// Draws tiles by evaluating passes.
struct WholeFrame<'w> {
    compiled: &'w Compiled,
    /// The numbers of the frame, and those before the drag.
    now: WholeNumbers<'w>,
    before: WholeNumbers<'w>,
    /// The picture that the drag begins with.
    picture: Option<&'w Frame>,
    passes: usize,
}

impl<'w> WholeFrame<'w> {
    /// Computes the mean of the passes for a tile, in the planes of the scratch memory.
    fn mean(&self, (numbers, variants, summations): &WholeNumbers<'w>, tile: usize, scratch: &mut TileScratch) {
        let summations = summations.get_or_init(|| WholeSummations::new(self.compiled, numbers, *variants));
        summations.mean(self.compiled, numbers, self.passes, tile, scratch);
    }

    /// Whether it evaluates some of the passes only.
    fn is_of_some_passes(&self) -> bool {
        self.passes < self.compiled.passes.len()
    }

    /// Draws a tile into its part of a framebuffer. `rest` is what the picture at the beginning has beside the mean of
    /// the passes, once it is known.
    fn draw(&self, tile: usize, rest: &mut Option<Box<[[f32; 3]]>>, scratch: &mut TileScratch, part: Part) {
        if let Some(picture) = self.picture {
            let rest = rest.get_or_insert_with(|| {
                self.mean(&self.before, tile, scratch);
                let pixels = &self.compiled.first_tiles()[tile].pixels;
                let colours = picture.part(pixels);
                let rest = |(pixel, colour): (usize, &[f32; 3])| rest_of(*colour, scratch.planes.colour(pixel));
                colours.iter().enumerate().map(rest).collect()
            });
            self.mean(&self.now, tile, scratch);
            for component in 0..3 {
                let plane = scratch.planes.part_mut(component, 0..rest.len());
                plane.iter_mut().zip(&*rest).for_each(|(number, rest)| *number += rest[component]);
            }
        } else {
            self.mean(&self.now, tile, scratch);
        }
        scratch.planes.quantise(0, part, &[]);
    }
}
