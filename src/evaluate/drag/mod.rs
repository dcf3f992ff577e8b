//! Frames while a slider is dragged: only what it can change is computed, in the cheapest right way.
//!
//! The pixels that no moved number reaches are not written again. For the others there are three ways:
//!
//! - **Images**, where the graph proves the picture to be a weighed sum of images that rest: `Σ kr^i · kt^j · factor · image`. kr and kt
//!   of a body are polynomials along paths; ki, colours and most weights enter the formula linearly.
//! - **Specialised**, elsewhere: what rests is one image, and a kernel computes what is live, from columns in which every expensive part
//!   that rests is kept.
//! - **General**, where neither is possible, or is ready yet: the whole picture anew.
//!
//! What is kept is made tile by tile ([`Drag::prepare`]), never more at a time than about a full evaluation: between frames, so that none waits for it. A tile of
//! which images would be inaccurate, or that would exceed the budget, stays with the general way.

mod cells;
mod images;
mod plan;

use crate::evaluate::columns::Columns;
use crate::evaluate::compiled::Compiled;
use crate::evaluate::framebuffer::{self, Channels, Framebuffer, Part};
use crate::evaluate::pass::{Onto, Pass, Workroom};
use crate::evaluate::program::TileProgram;
use crate::jit::CompileError;
use crate::trace::Tile;
use crate::transfer::with_bytes;
use images::{Image, Key, LARGEST_SUM, TileImages};
use plan::{Passes, Plan, Step, Work};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// How frames of a drag are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// As weighed sums of images.
    Images,
    /// By a kernel for what is live.
    Specialised,
    /// As any picture.
    General,
}

impl Method {
    /// Its name, as in reports.
    pub fn name(self) -> &'static str {
        match self {
            Method::Images => "images",
            Method::Specialised => "specialised",
            Method::General => "general",
        }
    }
}

/// A slider that is held: frames in which nothing but some numbers of one owner moves.
pub struct Drag {
    compiled: Arc<Compiled>,
    plan: Plan,
    /// The parameter numbers that what is kept was made with; what moves aside.
    memory: Vec<f32>,
    tiles: Vec<TileState>,
    /// Whether a whole picture has been drawn.
    drawn: bool,
    /// How many bytes may be kept, and are.
    budget: usize,
    bytes: usize,
}

/// What is kept of a tile.
enum TileState {
    /// Nothing that moves is seen in it.
    Untouched,
    /// Not all is made yet: so many steps are, with these images.
    Waiting {
        steps: Vec<Step>,
        done: usize,
        images: Vec<Image>,
        kept: Option<Columns>,
    },
    Images {
        images: TileImages,
        /// Whether what they leave alone is right in the picture: it is not after a picture that they could not make, with something
        /// infinite that is 0 in them.
        right: bool,
    },
    Live(LiveTile),
    /// It is drawn the general way.
    General,
}

/// What rests in a tile of which something is live.
struct LiveTile {
    cells: Vec<u16>,
    base: Vec<f32>,
    kept: Option<Columns>,
    program: TileProgram,
}

impl Drag {
    /// Takes hold of numbers of one owner (places in `memory`, whose values are those before the drag), and keeps at most so many bytes.
    /// All numbers lie within the ranges of their parameters, as for any [frame](crate::evaluate::Evaluator::frame).
    ///
    /// # Errors
    /// Kernels for it are beyond what the code generator takes.
    ///
    /// # Panics
    /// Where there are fewer parameter numbers than the layout has.
    pub fn new(compiled: &Arc<Compiled>, moved: &[usize], memory: &[f32], budget: usize) -> Result<Self, CompileError> {
        compiled.check_numbers(memory);
        let plan = Plan::new(compiled, moved)?;
        let mut drag = Self {
            compiled: Arc::clone(compiled),
            plan,
            memory: memory.to_vec(),
            tiles: Vec::new(),
            drawn: false,
            budget,
            bytes: 0,
        };
        drag.restart(memory);
        Ok(drag)
    }

    /// How frames are made, once everything is prepared.
    pub fn method(&self) -> Method {
        self.plan.method()
    }

    /// The memory that is kept for it, in bytes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// How many pixels a frame writes, once everything is prepared.
    pub fn pixels(&self) -> usize {
        let of_tile = |(state, tile): (&TileState, &Tile)| match state {
            TileState::Untouched => 0,
            TileState::Waiting { .. } | TileState::General => tile.pixels.len(),
            TileState::Images { images, .. } => images.pixels(),
            TileState::Live(live) => live.cells.len() * cells::CELL_PIXELS,
        };
        self.tiles.iter().zip(&self.compiled.hits.tiles).map(of_tile).sum()
    }

    /// Whether all is made that will be.
    pub fn is_ready(&self) -> bool {
        !self.tiles.iter().any(|tile| matches!(tile, TileState::Waiting { .. }))
    }

    /// Draws the picture of these numbers. The framebuffer is that of the last frame, with its transfer, unless this is the first: what cannot have changed
    /// is not written; [`prepare`](Self::prepare) makes what that takes. Numbers other than the moved ones may be others than before, but then all begins anew. All lie within the ranges
    /// of their parameters: how a formula is computed and taken apart is proved for these alone.
    ///
    /// # Panics
    /// Where the framebuffer has another size than the view, or there are too few parameter numbers.
    pub fn frame(&mut self, memory: &[f32], framebuffer: &mut Framebuffer) {
        self.compiled.check_size(framebuffer);
        self.compiled.check_numbers(memory);
        if !self.plan.same_rest(&self.memory, memory) {
            self.restart(memory);
        }
        let compiled = &*self.compiled;
        let factors = self.plan.factors(memory);
        let factor = |key: Key| self.plan.factor(key, &factors);
        // Once all is made, tiles that are drawn the general way are rare.
        let whole = OnceLock::new();
        let draw_anew = |place: usize, workroom: &mut Workroom, part: Part| {
            compiled.draw_tile(whole.get_or_init(|| compiled.whole(memory)), memory, place, workroom, part);
        };
        let live = self.plan.live_pass(compiled, memory);
        let (channels, drawn) = (self.plan.channels(), self.drawn);
        let tiles = framebuffer.parts().zip(&mut self.tiles);
        compiled.each_tile(tiles, |(part, state), place, workroom| match state {
            TileState::Untouched if drawn => {}
            TileState::Images { images, right } => {
                let accurate = images.is_accurate(&factor);
                if drawn && accurate && *right {
                    images.draw(&factor, part);
                } else {
                    draw_anew(place, workroom, part);
                }
                *right = accurate;
            }
            TileState::Live(tile) if drawn => {
                if let Some(live) = &live {
                    compiled.path_weights(&compiled.hits.tiles[place], memory, &mut workroom.weights);
                    tile.draw(&compiled.hits.tiles[place], place, live, channels, workroom, part);
                }
            }
            TileState::Untouched | TileState::Live(_) | TileState::Waiting { .. } | TileState::General => {
                draw_anew(place, workroom, part);
            }
        });
        self.drawn = true;
    }

    /// Makes some more of what is kept, about as much work as a full evaluation is; whether all is made now.
    pub fn prepare(&mut self) -> bool {
        if self.is_ready() {
            return true;
        }
        let mut left = self.plan.full_cost(&self.compiled);
        let mut orders: Vec<usize> = vec![0; self.tiles.len()];
        for (state, order) in self.tiles.iter().zip(&mut orders) {
            let TileState::Waiting { steps, done, .. } = state else { continue };
            for step in &steps[*done..] {
                if step.cost > left {
                    left = 0;
                    break;
                }
                left -= step.cost;
                *order += 1;
            }
            if left == 0 {
                break;
            }
        }
        // What alone costs more than all that may be done is done alone.
        if orders.iter().all(|order| *order == 0)
            && let Some(place) = self.tiles.iter().position(|tile| matches!(tile, TileState::Waiting { .. }))
        {
            orders[place] = 1;
        }
        if orders.iter().any(|order| *order > 0) {
            let making = Making {
                compiled: &self.compiled,
                plan: &self.plan,
                passes: self.plan.passes(&self.compiled, &self.memory),
                memory: &self.memory,
            };
            self.compiled.each_tile(self.tiles.par_iter_mut().zip(orders), |(state, order), place, workroom| {
                for _ in 0..order {
                    making.advance(state, place, workroom);
                }
            });
            self.settle();
        }
        self.is_ready()
    }

    /// Counts what is kept, and gives up, from the last tile on, what is beyond the budget.
    fn settle(&mut self) {
        self.bytes = 0;
        for state in &mut self.tiles {
            let bytes = match state {
                TileState::Untouched | TileState::General => 0,
                TileState::Waiting { images, kept, .. } => {
                    images.iter().map(Image::bytes).sum::<usize>() + kept.as_ref().map_or(0, Columns::bytes)
                }
                TileState::Images { images, .. } => images.bytes(),
                TileState::Live(live) => {
                    let kept = live.kept.as_ref().map_or(0, Columns::bytes);
                    size_of_val(&*live.base) + size_of_val(&*live.cells) + kept + live.program.bytes()
                }
            };
            if self.bytes + bytes > self.budget {
                *state = TileState::General;
            } else {
                self.bytes += bytes;
            }
        }
    }

    fn restart(&mut self, memory: &[f32]) {
        self.memory = memory.to_vec();
        self.drawn = false;
        let (compiled, plan) = (&*self.compiled, &self.plan);
        let state = |place: usize| {
            if plan.method() == Method::General {
                return TileState::General;
            }
            let steps = plan.steps(compiled, place, memory);
            if steps.is_empty() {
                TileState::Untouched
            } else {
                TileState::Waiting { steps, done: 0, images: Vec::new(), kept: None }
            }
        };
        self.tiles = (0..compiled.hits.tiles.len()).into_par_iter().map(state).collect();
        self.settle();
    }
}

/// Makes what is kept.
struct Making<'m> {
    compiled: &'m Compiled,
    plan: &'m Plan,
    passes: Passes<'m>,
    memory: &'m [f32],
}

impl Making<'_> {
    /// Does the next step for a tile.
    fn advance(&self, state: &mut TileState, place: usize, workroom: &mut Workroom) {
        let TileState::Waiting { steps, done, images, kept } = state else { return };
        let Some(step) = steps.get(*done) else { return };
        *done += 1;
        let (compiled, plan) = (self.compiled, self.plan);
        let channels = plan.channels();
        match step.work {
            Work::Kept => *kept = self.passes.kept_columns(compiled, place),
            Work::Image(key) => {
                let touched = self.passes.add_image(plan, compiled, self.memory, key, place, workroom);
                images.push(Image::new(key, &workroom.planes, &touched, channels));
            }
            Work::Base => {
                self.passes.add_base(plan, compiled, self.memory, place, workroom);
                *state = match plan.method() {
                    Method::Images if images.is_empty() => TileState::General,
                    Method::Images => {
                        let images = TileImages::new(std::mem::take(images), &workroom.planes, channels);
                        TileState::Images { images, right: false }
                    }
                    Method::Specialised => {
                        let cells = plan.live_cells(compiled, &compiled.hits.tiles[place], self.memory);
                        let mut base = Vec::with_capacity(cells.len() * cells::stride(channels));
                        for cell in &cells {
                            cells::copy(&workroom.planes, usize::from(*cell), channels, &mut base);
                        }
                        // What is large may cancel against what is live.
                        if cells::largest(&base) <= LARGEST_SUM {
                            TileState::Live(LiveTile { cells, base, kept: kept.take(), program: TileProgram::default() })
                        } else {
                            TileState::General
                        }
                    }
                    Method::General => TileState::General,
                };
            }
        }
    }
}

impl LiveTile {
    /// Adds what is live to what rests, and writes the cells. The workroom holds the weights of the tile's paths.
    fn draw(&mut self, tile: &Tile, place: usize, live: &Pass, channels: Channels, workroom: &mut Workroom, part: Part) {
        let stride = cells::stride(channels);
        for (cell, lanes) in self.cells.iter().zip(self.base.chunks_exact(stride)) {
            cells::restore(&mut workroom.planes, usize::from(*cell), channels, lanes);
        }
        live.add(tile, place, self.kept.as_ref(), Onto::WhatIsThere, workroom, &mut self.program);
        let planes = workroom.planes.components();
        pulp::Arch::new().dispatch(Writing { cells: &self.cells, planes, channels, part });
    }
}

/// Writes cells of the planes: what is inlined here is compiled for the vectors of this processor.
struct Writing<'a> {
    cells: &'a [u16],
    planes: [&'a [f32]; 3],
    channels: Channels,
    part: Part<'a>,
}

impl WithSimd for Writing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Writing { cells, planes, channels, part: Part { pixels, transfer } } = self;
        with_bytes!(transfer, bytes => for cell in cells {
            let start = usize::from(*cell) * cells::CELL_PIXELS;
            let linear = planes.map(|plane| &plane[start..start + cells::CELL_PIXELS]);
            let pixels = cells::pixels_of(pixels, *cell);
            match channels {
                Channels::All => framebuffer::write(pixels, linear, bytes),
                Channels::One(component) => framebuffer::write_component(pixels, component, linear[component], bytes),
            }
        });
    }
}

#[cfg(test)]
mod tests;
