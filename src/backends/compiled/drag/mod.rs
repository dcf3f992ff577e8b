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
//! [`prepare`](Drag::prepare) does about as much work as a full evaluation. A tile whose images would be inaccurate,
//! would exceed the budget or would not be faster is drawn by the general method. [`estimate`] decides what is faster.

mod cells;
mod estimate;
mod images;
mod reach;
mod summations;
mod whole;
mod work;

use crate::backends::compiled::Compiled;
use crate::backends::compiled::columns::Columns;
use crate::backends::compiled::program::TileProgram;
use crate::backends::compiled::summation::Summation;
use crate::backends::compiled::tile::{Accumulate, TileScratch};
use crate::evaluate::weights::PathMonomials;
use crate::evaluate::{Drag, Framebuffer, Part};
use crate::jit::CompileError;
use crate::picture::encoder::with_bytes;
use crate::plan::{Channels, Method};
use crate::trace::Tile;
use cells::Factor;
use estimate::FrameEstimate;
use images::{Image, Key, LARGEST_SUM, TileImages, factor_of};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};
use summations::{DragKernels, Summations};
use whole::WholeSummations;
use work::{Work, WorkItem, full_cost, work_items};

/// A slider that is held: frames in which only some numbers of one owner move.
pub(super) struct CompiledDrag {
    compiled: Arc<Compiled>,
    kernels: DragKernels,
    estimate: FrameEstimate,
    /// The parameter numbers that all stored data was made with, apart from those that move.
    parameters: Vec<f32>,
    tiles: Vec<TileState>,
    /// Whether a whole picture has been drawn.
    drawn: bool,
    /// What the formula chooses, if it chose otherwise for the picture before.
    new_choices: Option<Vec<u32>>,
    /// The most bytes that may be stored, and the bytes that are stored.
    budget: usize,
    bytes: usize,
}

/// The stored data of a tile.
enum TileState {
    /// Nothing that moves is visible in it.
    Untouched,
    /// The first `done` of the items are made, with these images.
    Waiting {
        items: Vec<WorkItem>,
        done: usize,
        images: Vec<Image>,
        columns: Option<Columns>,
    },
    Images {
        images: TileImages,
        /// Whether the pixels that the images do not write are right. They are not after a picture for which the
        /// images were not accurate: something may have been infinite where the images are 0.
        right: bool,
    },
    Live(LiveTile),
    /// It is drawn by the general method.
    General,
}

/// The stored data of a tile with a live part: the cells, and the fixed part in them.
struct LiveTile {
    cells: Vec<u16>,
    base: Vec<f32>,
    columns: Option<Columns>,
    program: TileProgram,
}

impl CompiledDrag {
    /// Begins a drag of numbers of one owner. `moved` are their indices in `parameters`, which holds the values before
    /// the drag. At most `budget` bytes are stored.
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
    ) -> Result<Self, CompileError> {
        compiled.check_parameters(parameters);
        let kernels = DragKernels::new(compiled, moved)?;
        let mut drag = Self {
            compiled: Arc::clone(compiled),
            kernels,
            estimate: FrameEstimate::default(),
            parameters: Vec::new(),
            tiles: Vec::new(),
            drawn: false,
            new_choices: None,
            budget,
            bytes: 0,
        };
        drag.restart(parameters);
        Ok(drag)
    }

    /// Counts the stored bytes. Drops the data of tiles that exceed the budget, from the last tile on.
    fn settle(&mut self) {
        self.bytes = 0;
        for state in &mut self.tiles {
            let bytes = state.bytes();
            if self.bytes + bytes > self.budget {
                *state = TileState::General;
            } else {
                self.bytes += bytes;
            }
        }
    }

    fn restart(&mut self, parameters: &[f32]) {
        self.parameters = parameters.to_vec();
        self.drawn = false;
        self.estimate = FrameEstimate::new(&self.compiled, &self.kernels, parameters);
        let plan = &self.kernels.plan;
        let state = |tile: &Tile| {
            if plan.method == Method::General {
                return TileState::General;
            }
            let monomials = self.compiled.monomials(plan, tile, parameters);
            let items = work_items(plan, &self.compiled.hits.world, tile, &monomials);
            if items.is_empty() {
                TileState::Untouched
            } else if plan.method == Method::Specialised && !self.specialising_pays(tile, &monomials) {
                TileState::General
            } else {
                TileState::Waiting { items, done: 0, images: Vec::new(), columns: None }
            }
        };
        self.tiles = self.compiled.hits.tiles.par_iter().map(state).collect();
        self.settle();
    }

    /// Whether a live part is faster in a tile than a full evaluation, by the estimate.
    fn specialising_pays(&self, tile: &Tile, monomials: &PathMonomials) -> bool {
        let reach = self.kernels.reach(&self.compiled);
        self.estimate.live_pays(reach.live_cells(tile, monomials).len(), &reach, tile, monomials)
    }

    /// The number of work items of each tile that are done next: together they cost about one full evaluation.
    fn next_counts(&self) -> Vec<usize> {
        let mut left = full_cost(&self.compiled);
        let mut counts: Vec<usize> = vec![0; self.tiles.len()];
        for (state, count) in self.tiles.iter().zip(&mut counts) {
            let TileState::Waiting { items, done, .. } = state else { continue };
            for item in &items[*done..] {
                if item.cost > left {
                    left = 0;
                    break;
                }
                left -= item.cost;
                *count += 1;
            }
            if left == 0 {
                break;
            }
        }
        // An item that costs more than a full evaluation is done alone.
        if counts.iter().all(|count| *count == 0)
            && let Some(index) = self.tiles.iter().position(|tile| matches!(tile, TileState::Waiting { .. }))
        {
            counts[index] = 1;
        }
        counts
    }
}

impl Drag for CompiledDrag {
    /// If no tile has stored data at the end of the preparation, every frame is drawn by the general method.
    fn method(&self) -> Method {
        let stored = |state: &TileState| !matches!(state, TileState::Untouched | TileState::General);
        let general = self.tiles.iter().any(|state| matches!(state, TileState::General));
        if general && !self.tiles.iter().any(stored) { Method::General } else { self.kernels.plan.method }
    }

    fn bytes(&self) -> usize {
        self.bytes
    }

    fn pixels(&self) -> usize {
        let of_tile = |(state, tile): (&TileState, &Tile)| match state {
            TileState::Untouched => 0,
            TileState::Waiting { .. } | TileState::General => tile.pixels.len(),
            TileState::Images { images, .. } => images.pixels(tile.pixels.len()),
            TileState::Live(live) => cells::pixel_count(&live.cells, tile.pixels.len()),
        };
        self.tiles.iter().zip(&self.compiled.hits.tiles).map(of_tile).sum()
    }

    fn is_ready(&self) -> bool {
        !self.tiles.iter().any(|tile| matches!(tile, TileState::Waiting { .. }))
    }

    fn frame(&mut self, parameters: &[f32], framebuffer: &mut Framebuffer) {
        self.compiled.check_size(framebuffer);
        self.compiled.check_parameters(parameters);
        if !self.kernels.plan.same_fixed(&self.parameters, parameters) {
            self.restart(parameters);
        }
        let compiled = &*self.compiled;
        let plan = &self.kernels.plan;
        let factors = plan.factors(parameters);
        let factor = |key: Key| factor_of(key, &factors);
        // Once everything is made, few tiles are drawn by the general method. If there is none, the variants that a
        // moved number chooses are not needed.
        let any_whole = self.tiles.iter().any(|tile| tile.is_drawn_whole(self.drawn, &factor));
        let variants = if any_whole { compiled.chosen_in_drag(parameters, &mut self.new_choices) } else { None };
        let whole = OnceLock::new();
        let draw_all = |index: usize, scratch: &mut TileScratch, part: Part| {
            let summations = whole.get_or_init(|| WholeSummations::new(compiled, parameters, variants.as_ref()));
            summations.draw_tile(compiled, parameters, index, scratch, part);
        };
        let live = self.kernels.live_summation(compiled, parameters);
        let (channels, drawn) = (plan.channels, self.drawn);
        let tiles = framebuffer.parts().zip(&mut self.tiles);
        compiled.each_tile(tiles, |(part, state), index, scratch| match state {
            TileState::Untouched if drawn => {}
            TileState::Images { images, right } => {
                let accurate = images.is_accurate(&factor);
                if drawn && accurate && *right {
                    images.draw(compiled.width(), &factor, part);
                } else {
                    draw_all(index, scratch, part);
                }
                *right = accurate;
            }
            TileState::Live(tile) if drawn => {
                if let Some(live) = &live {
                    compiled.path_weights(&compiled.hits.tiles[index], parameters, &mut scratch.weights);
                    tile.draw(&compiled.hits.tiles[index], index, live, channels, scratch, part);
                }
            }
            TileState::Untouched | TileState::Live(_) | TileState::Waiting { .. } | TileState::General => {
                draw_all(index, scratch, part);
            }
        });
        self.drawn = true;
    }

    fn prepare(&mut self) -> bool {
        if self.is_ready() {
            return true;
        }
        let counts = self.next_counts();
        if counts.iter().any(|count| *count > 0) {
            let chosen = self.compiled.chosen(&self.parameters);
            let preparation = Preparation {
                compiled: &self.compiled,
                kernels: &self.kernels,
                estimate: &self.estimate,
                summations: self.kernels.summations(&self.compiled, &self.parameters, chosen.as_deref()),
                parameters: &self.parameters,
            };
            self.compiled.each_tile(self.tiles.par_iter_mut().zip(counts), |(state, count), index, scratch| {
                for _ in 0..count {
                    preparation.advance(state, index, scratch);
                }
            });
            self.settle();
        }
        self.is_ready()
    }
}

impl TileState {
    /// Whether the next frame draws the tile by the general method.
    fn is_drawn_whole(&self, drawn: bool, factor: &impl Fn(Key) -> Factor) -> bool {
        match self {
            TileState::Untouched | TileState::Live(_) => !drawn,
            TileState::Images { images, right } => !(drawn && *right && images.is_accurate(factor)),
            TileState::Waiting { .. } | TileState::General => true,
        }
    }

    /// The memory that is kept, in bytes.
    fn bytes(&self) -> usize {
        match self {
            TileState::Untouched | TileState::General => 0,
            TileState::Waiting { images, columns, .. } => {
                images.iter().map(Image::bytes).sum::<usize>() + columns.as_ref().map_or(0, Columns::bytes)
            }
            TileState::Images { images, .. } => images.bytes(),
            TileState::Live(live) => {
                let columns = live.columns.as_ref().map_or(0, Columns::bytes);
                size_of_val(&*live.base) + size_of_val(&*live.cells) + columns + live.program.bytes()
            }
        }
    }
}

/// Makes the stored data.
struct Preparation<'p> {
    compiled: &'p Compiled,
    kernels: &'p DragKernels,
    estimate: &'p FrameEstimate,
    summations: Summations<'p>,
    parameters: &'p [f32],
}

impl Preparation<'_> {
    /// Does the next work item of a tile.
    fn advance(&self, state: &mut TileState, index: usize, scratch: &mut TileScratch) {
        let TileState::Waiting { items, done, images, columns } = state else { return };
        let Some(item) = items.get(*done) else { return };
        *done += 1;
        let (compiled, plan) = (self.compiled, &self.kernels.plan);
        let tile = &compiled.hits.tiles[index];
        let monomials = || compiled.monomials(plan, tile, self.parameters);
        match item.work {
            Work::Columns => *columns = self.summations.columns(compiled, index),
            Work::Image(key) => {
                let touched = self.summations.make_image(plan, compiled, &monomials(), key, index, scratch);
                images.push(Image::new(key, &scratch.planes, &touched, plan.channels));
            }
            Work::Base => {
                let monomials = monomials();
                self.summations.make_base(compiled, &monomials, index, scratch);
                *state = match plan.method {
                    _ if scratch.is_unbounded() => TileState::General,
                    Method::Images if images.is_empty() => TileState::General,
                    Method::Images => {
                        let images = TileImages::new(std::mem::take(images), &scratch.planes, plan.channels);
                        let reach = self.kernels.reach(compiled);
                        let (read, written) = images.traffic();
                        if self.estimate.images_pay(read, written, &reach, tile, &monomials) {
                            TileState::Images { images, right: false }
                        } else {
                            TileState::General
                        }
                    }
                    Method::Specialised => {
                        let reach = self.kernels.reach(compiled);
                        LiveTile::new(reach.live_cells(tile, &monomials), columns.take(), plan.channels, scratch)
                            .map_or(TileState::General, TileState::Live)
                    }
                    Method::General => TileState::General,
                };
            }
        }
    }
}

impl LiveTile {
    /// Stores these cells of the planes. `None` if their numbers are so large that they may cancel against the live
    /// part.
    fn new(cells: Vec<u16>, columns: Option<Columns>, channels: Channels, scratch: &TileScratch) -> Option<Self> {
        let mut base = Vec::with_capacity(cells.len() * cells::stride(channels));
        for cell in &cells {
            cells::copy(&scratch.planes, usize::from(*cell), channels, &mut base);
        }
        (cells::largest(&base) <= LARGEST_SUM).then(|| Self { cells, base, columns, program: TileProgram::default() })
    }

    /// Adds the live part to the fixed part, and writes the cells. The scratch memory holds the weights of the tile's
    /// paths.
    fn draw(&mut self, tile: &Tile, index: usize, live: &Summation, channels: Channels, scratch: &mut TileScratch, part: Part) {
        let stride = cells::stride(channels);
        for (cell, lanes) in self.cells.iter().zip(self.base.chunks_exact(stride)) {
            cells::restore(&mut scratch.planes, usize::from(*cell), channels, lanes);
        }
        live.run(tile, index, self.columns.as_ref(), Accumulate::Add, scratch, &mut self.program);
        match channels {
            Channels::All => {
                let Part { pixels, encoder } = part;
                for run in self.cells.chunk_by(|one, next| one + 1 == *next) {
                    let start = usize::from(run[0]) * cells::CELL_PIXELS;
                    let end = (start + run.len() * cells::CELL_PIXELS).min(pixels.len());
                    scratch.planes.quantise(start, Part { pixels: &mut pixels[start..end], encoder }, &[]);
                }
            }
            Channels::One(component) => {
                let (planes, width) = (scratch.planes.components(), scratch.planes.width());
                width.dispatch(CellWriter { cells: &self.cells, plane: planes[component], component, part });
            }
        }
    }
}

/// Writes one component of cells of the planes. The code that is inlined here is compiled for a width.
struct CellWriter<'a> {
    cells: &'a [u16],
    plane: &'a [f32],
    component: usize,
    part: Part<'a>,
}

impl WithSimd for CellWriter<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let CellWriter { cells, plane, component, part: Part { pixels, encoder } } = self;
        let plane = plane.as_chunks::<{ cells::CELL_PIXELS }>().0;
        with_bytes!(encoder, bytes => for cell in cells {
            cells::write_cell(cells::pixels_of(pixels, *cell), [&plane[usize::from(*cell)]], component, bytes);
        });
    }
}

#[cfg(test)]
mod tests;
