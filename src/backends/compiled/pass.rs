//! Adding up a tile: what its hits contribute, and with which weights.
//!
//! A [`Pass`] is one way to weight the hits of a picture. A whole frame is one pass: every path with its weight, and one source for all
//! pairs of a body and a light. An image that a drag keeps (see [`drag`](super::drag)) is another.

use crate::backends::compiled::columns::Columns;
use crate::backends::compiled::planes::Planes;
use crate::backends::compiled::program::{TileInputs, TileProgram};
use crate::evaluate::weights::Weight;
use crate::jit::{Kernel, PixelCode, Splat, Sums, Width, fetch};
use crate::plan::Channels;
use crate::scene::BodyId;
use crate::trace::{CHUNK_HITS, Tile};
use crate::world::{EmitterId, World};
use std::ops::Range;

/// What lit records contribute: a kernel with what it reads beside the columns, for some pairs of a body and a light.
pub(super) struct Source<'p> {
    /// Static columns → contributions, stored.
    pub(super) overwrite: &'p Kernel,
    /// The same, added to what is there.
    pub(super) add: &'p Kernel,
    /// What the kernels yield.
    pub(super) channels: Channels,
    /// Where the uniform values of its pairs of a body and a light begin, and how many a pair has.
    pub(super) first_uniform: usize,
    pub(super) uniform_count: usize,
    /// For each pair whether anything comes of it.
    pub(super) active: Vec<bool>,
    /// How many lights a body is paired with.
    pub(super) lights: usize,
    /// The world, which knows the light of each emitter.
    pub(super) world: &'p World,
}

impl Source<'_> {
    /// The place of the pair of a body and the light of an emitter.
    pub(super) fn pair(&self, body: BodyId, emitter: EmitterId) -> usize {
        body.index() * self.lights + self.world.light_of(emitter).index()
    }

    /// Where the uniform values of a pair are.
    pub(super) fn uniforms_of(&self, pair: usize) -> Range<usize> {
        let first = self.first_uniform + pair * self.uniform_count;
        first..first + self.uniform_count
    }
}

/// What is added up, and with what weights.
pub(super) struct Pass<'p> {
    pub(super) sources: Vec<Source<'p>>,
    /// The uniform values of all of them.
    pub(super) uniforms: Vec<Splat>,
    /// The static columns of each tile.
    pub(super) columns: &'p [Columns],
    /// What each hit of a body adds, whatever the lights: body by body.
    pub(super) at_hits: Vec<[f32; 3]>,
    /// What each ray adds that left the scene.
    pub(super) at_misses: [f32; 3],
    /// The components that are computed; the others stay as they are.
    pub(super) channels: Channels,
    /// The code that adds to pixels, where there is some for the processor.
    pub(super) code: Option<&'static PixelCode>,
}

/// What happens to the pixels that are in the planes when a pass runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Accumulate {
    /// The pass overwrites them.
    Overwrite,
    /// The pass adds to them.
    Add,
}

/// Scratch memory for the work on a tile, used again for the next.
pub(super) struct TileScratch {
    pub(super) planes: Planes,
    /// The weight of each path of the tile.
    pub(super) weights: Vec<Weight>,
    /// Red, green and blue of the hits of a chunk, before the weight of their paths.
    sums: Box<Sums>,
    /// The weight of each span, and what is behind them.
    span_weights: Vec<f32>,
    /// The program of a pass that runs once.
    once: TileProgram,
    /// What each path, and each set of paths, adds to its pixels whatever the lights; the fourth number is 0.
    path_colours: Vec<[f32; 4]>,
    set_colours: Vec<[f32; 4]>,
}

impl TileScratch {
    /// About how large one is.
    pub(super) const BYTES: usize = Planes::BYTES + size_of::<Sums>();

    /// Scratch where pixels are worked on with vectors of this width.
    pub(super) fn new(width: Width) -> Self {
        Self {
            planes: Planes::new(width),
            weights: Vec::new(),
            sums: bytemuck::zeroed_box(),
            span_weights: Vec::new(),
            once: TileProgram::default(),
            path_colours: Vec::new(),
            set_colours: Vec::new(),
        }
    }
}

impl<'p> Pass<'p> {
    /// Adds a source with its uniform values.
    pub(super) fn push(&mut self, mut source: Source<'p>, mut uniforms: Vec<Splat>) {
        source.first_uniform = self.uniforms.len();
        self.uniforms.append(&mut uniforms);
        self.sources.push(source);
    }

    /// Runs the pass over a tile, into the planes of the scratch, whose weights are those of the tile's paths. `place` is the place of the
    /// tile; `kept` are columns of a drag, if kernels read any. `program` keeps the order of work of this tile in passes like this one.
    pub(super) fn run(
        &self,
        tile: &Tile,
        place: usize,
        kept: Option<&Columns>,
        accumulate: Accumulate,
        scratch: &mut TileScratch,
        program: &mut TileProgram,
    ) {
        // All at once: one after the other, each list would be waited for.
        fetch(&tile.regions);
        fetch(&tile.spans);
        program.fetch();
        self.fill_regions(tile, accumulate, scratch);
        let TileScratch { planes, weights, sums, span_weights, .. } = scratch;
        let inputs = TileInputs { tile, place, kept, weights };
        program.prepare(self, &inputs);
        span_weights.clear();
        span_weights.extend(tile.spans.iter().map(|span| weights[span.path.index()].0 as f32));
        span_weights.resize(tile.spans.len() + CHUNK_HITS, 0.0);
        program.run(self, &inputs, span_weights, sums, planes);
    }

    /// The same for a pass that runs once over the tile: overwrites the planes.
    pub(super) fn run_once(&self, tile: &Tile, place: usize, scratch: &mut TileScratch) {
        let mut program = std::mem::take(&mut scratch.once);
        program.forget();
        self.run(tile, place, None, Accumulate::Overwrite, scratch, &mut program);
        scratch.once = program;
    }

    /// Adds what rays add whatever the lights: the same for all pixels of a region.
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
