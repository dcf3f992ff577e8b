//! How a tile is drawn in a drag, and what is still to be prepared for it.

use crate::backends::compiled::Compiled;
use crate::backends::compiled::columns::Columns;
use crate::backends::compiled::drag::cells::{self, Factor};
use crate::backends::compiled::drag::images::{Image, Key, LARGEST_SUM, TileImages};
use crate::backends::compiled::drag::work::WorkItem;
use crate::backends::compiled::place::TilePlace;
use crate::backends::compiled::program::TileProgram;
use crate::backends::compiled::summation::Summation;
use crate::backends::compiled::tile::{Accumulate, TileScratch};
use crate::evaluate::Part;
use crate::picture::encoder::with_bytes;
use crate::plan::Channels;
use pulp::{Simd, WithSimd};

/// A tile in a drag.
pub(super) struct TileDrag {
    pub(super) state: TileState,
    /// What is still to be prepared.
    pub(super) work: Option<TileWork>,
}

/// How a tile is drawn.
pub(super) enum TileState {
    /// Not at all: nothing that moves is visible in it.
    Untouched,
    /// As a weighted sum of images.
    Images {
        images: TileImages,
        /// Whether the pixels that the images do not write are right. They are not after a picture for which the
        /// images were not accurate: something may have been infinite where the images are 0.
        right: bool,
    },
    /// By a kernel for the part that moves.
    Live(LiveTile),
    /// By evaluating passes. Their mean and this are added, if the drag began with a picture: red, green and blue of
    /// the rest of it, pixel by pixel. It is known after the first frame.
    Whole(Option<Box<[[f32; 3]]>>),
}

/// What is to be prepared for a tile. The first `done` of the items are made, with these images and columns.
pub(super) struct TileWork {
    pub(super) items: Vec<WorkItem>,
    pub(super) done: usize,
    /// The sums of images over the passes so far.
    pub(super) images: Vec<Image>,
    /// The columns of each pass that the live part reads.
    pub(super) columns: Vec<Columns>,
}

impl TileWork {
    /// The items that are left.
    pub(super) fn left(&self) -> &[WorkItem] {
        &self.items[self.done..]
    }

    /// Adds the image of some more passes.
    pub(super) fn add(&mut self, image: Image, channels: Channels) {
        match self.images.iter().position(|known| known.key() == image.key()) {
            Some(index) => {
                let known = self.images.swap_remove(index);
                self.images.push(known.plus(image, channels));
            }
            None => self.images.push(image),
        }
        self.images.sort_by_key(Image::key);
    }

    fn bytes(&self) -> usize {
        self.images.iter().map(Image::bytes).sum::<usize>() + self.columns.iter().map(Columns::bytes).sum::<usize>()
    }
}

impl TileDrag {
    /// A tile that is drawn by evaluating passes.
    pub(super) fn whole() -> Self {
        Self { state: TileState::Whole(None), work: None }
    }

    /// Whether the next frame evaluates passes of the tile.
    pub(super) fn is_drawn_whole(&self, drawn: bool, factor: &impl Fn(Key) -> Factor) -> bool {
        match &self.state {
            TileState::Untouched | TileState::Live(_) => !drawn,
            TileState::Images { images, right } => !(drawn && *right && images.is_accurate(factor)),
            TileState::Whole(_) => true,
        }
    }

    /// Whether it has stored data, or will have.
    pub(super) fn is_stored(&self) -> bool {
        self.work.is_some() || matches!(self.state, TileState::Images { .. } | TileState::Live(_))
    }

    /// How many pixels a frame writes once everything is prepared, of a tile of this many pixels.
    pub(super) fn pixels(&self, tile_pixels: usize) -> usize {
        match &self.state {
            TileState::Untouched => 0,
            TileState::Whole(_) => tile_pixels,
            TileState::Images { images, .. } => images.pixels(tile_pixels),
            TileState::Live(live) => cells::pixel_count(&live.cells, tile_pixels),
        }
    }

    /// The memory that is kept, in bytes.
    pub(super) fn bytes(&self) -> usize {
        let state = match &self.state {
            TileState::Untouched => 0,
            TileState::Whole(rest) => rest.as_ref().map_or(0, |rest| size_of_val(&**rest)),
            TileState::Images { images, .. } => images.bytes(),
            TileState::Live(live) => live.bytes(),
        };
        state + self.work.as_ref().map_or(0, TileWork::bytes)
    }
}

/// The stored data of a tile with a live part: the cells, and the fixed part in them.
pub(super) struct LiveTile {
    cells: Vec<u16>,
    base: Vec<f32>,
    /// The columns of each pass that is evaluated, if the live part reads any.
    columns: Vec<Columns>,
    /// The order of work in each pass that is evaluated.
    programs: Vec<TileProgram>,
}

impl LiveTile {
    /// Stores these cells of the planes, for frames that evaluate this many passes. `None` if their numbers are so
    /// large that they may cancel against the live part.
    pub(super) fn new(
        cells: Vec<u16>,
        columns: Vec<Columns>,
        passes: usize,
        channels: Channels,
        scratch: &TileScratch,
    ) -> Option<Self> {
        let mut base = Vec::with_capacity(cells.len() * cells::stride(channels));
        for cell in &cells {
            cells::copy(&scratch.planes, usize::from(*cell), channels, &mut base);
        }
        let programs = (0..passes).map(|_| TileProgram::default()).collect();
        (cells::largest(&base) <= LARGEST_SUM).then_some(Self { cells, base, columns, programs })
    }

    fn bytes(&self) -> usize {
        let columns = self.columns.iter().map(Columns::bytes).sum::<usize>();
        let programs = self.programs.iter().map(TileProgram::bytes).sum::<usize>();
        size_of_val(&*self.base) + size_of_val(&*self.cells) + columns + programs
    }

    /// Adds the live part to the fixed part, and writes the cells.
    pub(super) fn draw(&mut self, live: &LivePart, tile: usize, channels: Channels, scratch: &mut TileScratch, part: Part) {
        let stride = cells::stride(channels);
        let bases = || self.cells.iter().map(|cell| usize::from(*cell)).zip(self.base.chunks_exact(stride));
        let is_one = self.programs.len() == 1;
        for (cell, base) in bases() {
            match is_one {
                true => cells::restore(&mut scratch.planes, cell, channels, base),
                false => cells::clear(&mut scratch.planes, cell, channels),
            }
        }
        for (pass, program) in self.programs.iter_mut().enumerate() {
            live.add(TilePlace { pass, tile }, self.columns.get(pass), scratch, program);
        }
        if !is_one {
            let share = 1.0 / self.programs.len() as f32;
            bases().for_each(|(cell, base)| cells::scale_and_add(&mut scratch.planes, cell, channels, share, base));
        }
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

/// The live part of a picture.
pub(super) struct LivePart<'l> {
    pub(super) compiled: &'l Compiled,
    pub(super) summation: &'l Summation<'l>,
    pub(super) parameters: &'l [f32],
}

impl LivePart<'_> {
    /// Adds it to the planes, for one pass of a tile.
    pub(super) fn add(&self, place: TilePlace, columns: Option<&Columns>, scratch: &mut TileScratch, program: &mut TileProgram) {
        let tile = self.compiled.tile_at(place);
        self.compiled.path_weights(tile, self.parameters, &mut scratch.weights);
        self.summation.run(tile, place, columns, Accumulate::Add, scratch, program);
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
