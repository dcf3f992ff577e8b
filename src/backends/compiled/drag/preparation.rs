//! Making the stored data of a tile, one work item after the other.

use crate::backends::compiled::drag::cells::{self, CellSet};
use crate::backends::compiled::drag::estimate::FrameEstimate;
use crate::backends::compiled::drag::images::{Image, TileImages, factor_of};
use crate::backends::compiled::drag::summations::{DragKernels, DragPasses, Summations};
use crate::backends::compiled::drag::tile_state::{LivePart, LiveTile, TileDrag, TileState, TileWork};
use crate::backends::compiled::drag::work::Work;
use crate::backends::compiled::place::TilePlace;
use crate::backends::compiled::program::TileProgram;
use crate::backends::compiled::summation::Summation;
use crate::backends::compiled::tile::TileScratch;
use crate::picture::Frame;
use crate::plan::{Factors, Method};

/// Makes the stored data.
pub(super) struct Preparation<'p> {
    pub(super) drag: DragPasses<'p>,
    pub(super) kernels: &'p DragKernels,
    pub(super) estimate: &'p FrameEstimate,
    pub(super) summations: Summations<'p>,
    /// The live part with the numbers before the drag, if there is one.
    pub(super) live: Option<Summation<'p>>,
    /// The factors of the images with the numbers before the drag.
    pub(super) factors: Factors,
    /// The picture that the drag begins with.
    pub(super) picture: Option<&'p Frame>,
}

impl Preparation<'_> {
    /// Does the next work item of a tile.
    pub(super) fn advance(&self, tile: &mut TileDrag, index: usize, scratch: &mut TileScratch) {
        let Some(work) = &mut tile.work else { return };
        let Some(item) = work.left().first().cloned() else { return };
        work.done += 1;
        let (plan, compiled) = (self.drag.plan, self.drag.compiled);
        let mut may_give_up = matches!(item.work, Work::Base | Work::BaseOfPicture(_));
        match item.work {
            Work::Columns(passes) => {
                work.columns =
                    passes.filter_map(|pass| self.summations.columns(compiled, TilePlace { pass, tile: index })).collect();
            }
            Work::Image(key, passes) => match self.summations.make_image(&self.drag, key, passes, index, scratch) {
                Some(touched) => work.add(Image::new(key, &scratch.planes, &touched, plan.channels), plan.channels),
                None => {
                    tile.state = TileState::Whole(None);
                    may_give_up = true;
                }
            },
            Work::Base => {
                let passes = compiled.passes.len();
                let is_unbounded = self.summations.make_base(&self.drag, index, scratch);
                tile.state = match plan.method {
                    _ if is_unbounded => TileState::Whole(None),
                    Method::Images => self.images(work, passes, false, index, scratch),
                    Method::Specialised => self.live(work, passes, index, scratch),
                    Method::General => TileState::Whole(None),
                };
            }
            Work::BaseOfPicture(passes) => {
                tile.state = match plan.method {
                    Method::Images => {
                        self.set_base(work, passes, index, scratch);
                        self.images(work, passes, true, index, scratch)
                    }
                    Method::Specialised => self.live_of_picture(work, passes, index, scratch),
                    Method::General => TileState::Whole(None),
                };
            }
        }
        // Where images of few passes do not help, those of more passes do not either.
        if work.left().is_empty() || may_give_up && matches!(tile.state, TileState::Whole(_)) {
            tile.work = None;
        }
    }

    /// Sets the planes to the picture that the drag begins with, without the images of this many passes.
    fn set_base(&self, work: &TileWork, passes: usize, index: usize, scratch: &mut TileScratch) {
        self.set_picture(index, scratch);
        let channels = self.drag.plan.channels;
        for image in &work.images {
            let cells::Factor(factor) = factor_of(image.key(), &self.factors);
            let share = cells::Factor(factor.map(|component| component / passes as f32));
            image.subtract(share, channels, &mut scratch.planes);
        }
    }

    /// Sets the planes to the picture that the drag begins with.
    fn set_picture(&self, index: usize, scratch: &mut TileScratch) {
        let pixels = &self.drag.compiled.first_tiles()[index].pixels;
        let colours = self.picture.map_or(&[][..], |picture| picture.part(pixels));
        for component in 0..3 {
            let plane = scratch.planes.part_mut(component, 0..pixels.len());
            plane.iter_mut().zip(colours).for_each(|(number, colour)| *number = colour[component]);
        }
    }

    /// The images of a tile over this many passes. The base is in the planes.
    fn images(&self, work: &TileWork, passes: usize, is_right: bool, index: usize, scratch: &TileScratch) -> TileState {
        let (plan, compiled) = (self.drag.plan, self.drag.compiled);
        if work.images.is_empty() {
            return TileState::Whole(None);
        }
        let images = TileImages::new(&work.images, 1.0 / passes as f32, &scratch.planes, plan.channels);
        let tile = &compiled.first_tiles()[index];
        let (reach, monomials) = (self.kernels.reach(compiled), compiled.monomials(plan, tile, self.drag.parameters));
        match self.estimate.images_pay(images.traffic(), compiled.passes.len(), &reach, tile, &monomials) {
            true => TileState::Images { images, right: is_right },
            false => TileState::Whole(None),
        }
    }

    /// The live part of a tile, for frames that evaluate this many passes. The base is in the planes.
    fn live(&self, work: &mut TileWork, passes: usize, index: usize, scratch: &TileScratch) -> TileState {
        let columns = std::mem::take(&mut work.columns);
        let cells = self.live_cells(passes, index);
        LiveTile::new(cells, columns, passes, self.drag.plan.channels, scratch).map_or(TileState::Whole(None), TileState::Live)
    }

    /// The same, with the base that remains of the picture without the live part of these passes.
    fn live_of_picture(&self, work: &mut TileWork, passes: usize, index: usize, scratch: &mut TileScratch) -> TileState {
        let DragPasses { compiled, plan, parameters } = self.drag;
        let Some(summation) = &self.live else { return TileState::Whole(None) };
        scratch.planes.clear();
        let live = LivePart { compiled, summation, parameters };
        for pass in 0..passes {
            let mut program = TileProgram::default();
            live.add(TilePlace { pass, tile: index }, work.columns.get(pass), scratch, &mut program);
            if scratch.is_unbounded() {
                return TileState::Whole(None);
            }
        }
        // What was added to the planes, subtracted from the picture.
        let cells = self.live_cells(passes, index);
        let mut added = Vec::new();
        cells.iter().for_each(|cell| cells::copy(&scratch.planes, usize::from(*cell), plan.channels, &mut added));
        self.set_picture(index, scratch);
        let share = -1.0 / passes as f32;
        added.iter_mut().for_each(|number| *number *= share);
        for (cell, added) in cells.iter().zip(added.chunks_exact(cells::stride(plan.channels))) {
            cells::scale_and_add(&mut scratch.planes, usize::from(*cell), plan.channels, 1.0, added);
        }
        self.live(work, passes, index, scratch)
    }

    /// The cells of a tile that the live part of the first passes can change.
    fn live_cells(&self, passes: usize, index: usize) -> Vec<u16> {
        let DragPasses { compiled, plan, parameters } = self.drag;
        let reach = self.kernels.reach(compiled);
        let mut cells = CellSet::none(compiled.first_tiles()[index].pixels.len());
        for pass in 0..passes {
            let tile = compiled.tile_at(TilePlace { pass, tile: index });
            reach.add_live_cells(tile, &compiled.monomials(plan, tile, parameters), &mut cells);
        }
        cells.cells()
    }
}
