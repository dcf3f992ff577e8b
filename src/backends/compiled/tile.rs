//! A summation over one tile, into the planes of the tile: first the terms without lights, then the contributions of
//! all groups.

use crate::backends::compiled::columns::Columns;
use crate::backends::compiled::place::TilePlace;
use crate::backends::compiled::planes::Planes;
use crate::backends::compiled::program::{TileInputs, TileProgram};
use crate::backends::compiled::summation::Summation;
use crate::backends::compiled::surface::{SurfaceScratch, SurfaceSummation};
use crate::evaluate::weights::Weight;
use crate::jit::{Sums, Width, fetch};
use crate::trace::{CHUNK_HITS, Tile};

/// How a summation treats the pixels that are in the planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Accumulate {
    /// The summation overwrites them.
    Overwrite,
    /// The summation adds to them.
    Add,
}

/// Scratch memory for the work on a tile. It is used again for the next tile.
pub(super) struct TileScratch {
    pub(super) planes: Planes,
    /// The sum of the passes so far, where a picture has several.
    total: Option<Planes>,
    /// The weight of each path of the tile.
    pub(super) weights: Vec<Weight>,
    /// Red, green and blue of the hits of a chunk, not yet multiplied by path weights.
    sums: Box<Sums>,
    /// The weight of each span, followed by more numbers, see [`Operands`](crate::jit::Operands).
    span_weights: Vec<f32>,
    /// The program of a summation that runs once.
    once: TileProgram,
    /// The colours of each path and of each set of paths by the terms without lights. The fourth number is 0.
    path_colours: Vec<[f32; 4]>,
    set_colours: Vec<[f32; 4]>,
    surface: SurfaceScratch,
}

impl TileScratch {
    /// The approximate size in bytes.
    pub(super) const BYTES: usize = Planes::BYTES + size_of::<Sums>();

    /// Scratch memory for code with vectors of this width.
    pub(super) fn new(width: Width) -> Self {
        Self {
            planes: Planes::new(width),
            total: None,
            weights: Vec::new(),
            sums: bytemuck::zeroed_box(),
            span_weights: Vec::new(),
            once: TileProgram::default(),
            path_colours: Vec::new(),
            set_colours: Vec::new(),
            surface: SurfaceScratch::default(),
        }
    }

    /// Adds the first pixels of the planes to the total, or makes them the total.
    pub(super) fn add_to_total(&mut self, is_first: bool, pixels: usize) {
        let width = self.planes.width();
        let total = self.total.get_or_insert_with(|| Planes::new(width));
        if is_first {
            std::mem::swap(total, &mut self.planes);
        } else {
            total.add_planes(&self.planes, pixels);
        }
    }

    /// Makes the total the planes.
    pub(super) fn take_total(&mut self) {
        if let Some(total) = &mut self.total {
            std::mem::swap(total, &mut self.planes);
        }
    }

    /// Whether a weight of a path was not bounded in the last summation. Then its picture is not a sum of images.
    pub(super) fn is_unbounded(&self) -> bool {
        self.surface.is_unbounded()
    }
}

impl Summation<'_> {
    /// Runs the summation over a tile, into the planes of the scratch memory, which holds the weights of the tile's
    /// paths.
    /// `place` is the tile among those of all passes. `drag_columns` are given if kernels read any. `program` keeps the
    /// order of work of this tile in summations like this one.
    pub(super) fn run(
        &self,
        tile: &Tile,
        place: TilePlace,
        drag_columns: Option<&Columns>,
        accumulate: Accumulate,
        scratch: &mut TileScratch,
        program: &mut TileProgram,
    ) {
        // All at once, so that the lists come from memory at the same time.
        fetch(&tile.regions);
        fetch(&tile.spans);
        program.fetch();
        match &self.surface {
            None => self.fill_regions(tile, accumulate, scratch),
            Some(surface) => self.fill_nodes(surface, tile, place, accumulate, scratch),
        }
        let TileScratch { planes, weights, sums, span_weights, surface, .. } = scratch;
        let width = planes.width();
        if let Some(radiance) = self.radiance(place) {
            match &self.surface {
                None => radiance.add(self.environment, weights, planes),
                Some(summation) if surface.is_plain() => {
                    radiance.add_weighed(self.environment, weights, summation.plain_weights(tile, place, surface), planes);
                }
                Some(summation) => {
                    let add = |pixel: usize, colour: [f32; 3]| planes.add_colour(pixel, colour);
                    let seen = |miss: usize| {
                        let seen = radiance.of(miss);
                        std::array::from_fn(|component| self.environment[component] * seen[component])
                    };
                    summation.add_environment(tile, place, weights, surface, seen, add);
                }
            }
        }
        let hit_weights = self.surface.as_ref().map(|summation| summation.hit_weights(place, surface, width));
        let inputs = TileInputs { tile, place, drag_columns, weights, hit_weights };
        program.prepare(self, &inputs);
        span_weights.clear();
        span_weights.extend(tile.spans.iter().map(|span| inputs.span_weight(span.path)));
        span_weights.resize(tile.spans.len() + CHUNK_HITS, 0.0);
        program.run(self, &inputs, span_weights, sums, planes);
        if let Some(summation) = &self.surface {
            summation.add_collected(tile, place, surface, |pixel, colour| planes.add_colour(pixel, colour));
        }
    }

    /// Runs a summation that runs only once over the tile.
    pub(super) fn run_once(&self, tile: &Tile, place: TilePlace, accumulate: Accumulate, scratch: &mut TileScratch) {
        let mut program = std::mem::take(&mut scratch.once);
        program.forget();
        self.run(tile, place, None, accumulate, scratch, &mut program);
        scratch.once = program;
    }

    /// Computes the weights of all hits, and adds the terms without lights.
    fn fill_nodes(
        &self,
        surface: &SurfaceSummation,
        tile: &Tile,
        place: TilePlace,
        accumulate: Accumulate,
        scratch: &mut TileScratch,
    ) {
        let width = scratch.planes.width();
        surface.weigh(tile, place, &mut scratch.weights, &mut scratch.surface, width);
        let TileScratch { planes, weights, surface: nodes, .. } = scratch;
        if accumulate == Accumulate::Overwrite {
            planes.clear();
        }
        surface.add_own(tile, place, weights, nodes, (&self.at_hits, self.at_misses), |pixel, colour| {
            planes.add_colour(pixel, colour);
        });
    }

    /// Adds the terms without lights. They are the same for all pixels of a region.
    fn fill_regions(&self, tile: &Tile, accumulate: Accumulate, scratch: &mut TileScratch) {
        let black = || self.at_hits.iter().all(|colour| *colour == [0.0; 3]) && self.at_misses == [0.0; 3];
        let add = match accumulate {
            Accumulate::Overwrite => false,
            Accumulate::Add if black() => return,
            Accumulate::Add => true,
        };
        let TileScratch { planes, weights, path_colours, set_colours, .. } = scratch;
        path_colours.clear();
        path_colours.extend(tile.paths.iter().zip(weights.iter()).map(|(path, weight)| {
            let colour = path.body.map_or(self.at_misses, |body| self.at_hits[body.index()]);
            let [red, green, blue] = if weight.is_zero() { [0.0; 3] } else { weight.of(colour) };
            [red, green, blue, 0.0]
        }));
        set_colours.clear();
        set_colours.extend(tile.path_sets.iter().map(|paths| {
            let mut sum = [0.0; 4];
            for path in paths {
                let colour = path_colours[path.index()];
                sum = std::array::from_fn(|component| sum[component] + colour[component]);
            }
            sum
        }));
        planes.fill(tile, set_colours, add);
    }
}
