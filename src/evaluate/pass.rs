//! Adding up a tile: what its hits contribute, with which values, and where that comes into the pixels.
//!
//! A [`Pass`] is one way to weigh the hits of a picture. A whole frame is one pass: every path with its weight, one source of
//! light for all pairs of a body and a light. A part of the picture that a drag keeps (see [`drag`](super::drag)) is another.

use crate::evaluate::columns::Columns;
use crate::evaluate::framebuffer::Channels;
use crate::evaluate::planes::{Planes, Weight};
use crate::evaluate::program::{Ground, TileProgram};
use crate::jit::{Kernel, Splat, Sums, fetch};
use crate::scene::{BodyId, LightId};
use crate::trace::{CHUNK_HITS, Tile};
use std::ops::Range;

/// What lit records contribute: a kernel with what it reads beside the columns, for some pairs of a body and a light.
pub(super) struct Source<'p> {
    /// Static columns → contributions, stored.
    pub(super) storing: &'p Kernel,
    /// The same, added to what is there.
    pub(super) adding: &'p Kernel,
    /// What the kernels yield.
    pub(super) channels: Channels,
    /// Where the uniform values of its pairs of a body and a light begin, and how many a pair has.
    pub(super) first_uniform: usize,
    pub(super) uniform_count: usize,
    /// For each pair whether anything comes of it.
    pub(super) active: Vec<bool>,
    /// How many lights a body is paired with.
    pub(super) lights: usize,
}

impl Source<'_> {
    /// The place of a pair of a body and a light.
    pub(super) fn pair(&self, body: BodyId, light: LightId) -> usize {
        body.index() * self.lights + light.index()
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
    /// For each body what its hits contribute wherever they are.
    pub(super) ambient: Vec<[f32; 3]>,
    /// What rays contribute that left the scene.
    pub(super) background: [f32; 3],
    /// What is computed; the others stay as they are.
    pub(super) channels: Channels,
}

/// What a pass is added to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Onto {
    /// Nothing, whatever is in the planes.
    Black,
    /// What is in the planes.
    WhatIsThere,
}

/// Room for the work on a tile, used again for the next.
pub(super) struct Workroom {
    pub(super) planes: Planes,
    /// The weight of each path of the tile.
    pub(super) weights: Vec<Weight>,
    /// Red, green and blue of the hits of a chunk, before the weight of their paths.
    sums: Box<Sums>,
    /// The weight of each span, and what is behind them.
    span_weights: Vec<f32>,
    /// Room for what is done once.
    once: TileProgram,
    /// What each path, and each set of them, adds to its pixels beside the contributions of lights; the fourth number is 0.
    path_colours: Vec<[f32; 4]>,
    set_colours: Vec<[f32; 4]>,
}

impl Workroom {
    /// About how large one is.
    pub(super) const BYTES: usize = Planes::BYTES + size_of::<Sums>();

    pub(super) fn new() -> Self {
        Self {
            planes: Planes::new(),
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
    /// Takes a source in, with its uniform values.
    pub(super) fn push(&mut self, mut source: Source<'p>, mut uniforms: Vec<Splat>) {
        source.first_uniform = self.uniforms.len();
        self.uniforms.append(&mut uniforms);
        self.sources.push(source);
    }

    /// Adds the pass to the planes of the workroom, whose weights are those of the tile's paths. `place` is the tile's; `kept` are
    /// columns beside the static ones, if kernels read such. What is done is kept in `program`, that of the same tile in such passes.
    pub(super) fn add(
        &self,
        tile: &Tile,
        place: usize,
        kept: Option<&Columns>,
        onto: Onto,
        workroom: &mut Workroom,
        program: &mut TileProgram,
    ) {
        // All at once: one after the other, each would be waited for.
        fetch(&tile.regions);
        fetch(&tile.spans);
        program.fetch();
        self.everywhere(tile, onto, workroom);
        let Workroom { planes, weights, sums, span_weights, .. } = workroom;
        let ground = Ground { tile, place, kept, weights };
        program.prepare(self, &ground);
        span_weights.clear();
        span_weights.extend(tile.spans.iter().map(|span| weights[span.path.index()].0 as f32));
        span_weights.resize(tile.spans.len() + CHUNK_HITS, 0.0);
        program.run(self, &ground, span_weights, sums, planes);
    }

    /// The same where it is done only once.
    pub(super) fn add_once(&self, tile: &Tile, place: usize, onto: Onto, workroom: &mut Workroom) {
        let mut program = std::mem::take(&mut workroom.once);
        program.forget();
        self.add(tile, place, None, onto, workroom, &mut program);
        workroom.once = program;
    }

    /// What rays add whatever their hits are like, ambient light and background: the same in each region.
    fn everywhere(&self, tile: &Tile, onto: Onto, workroom: &mut Workroom) {
        let add = match onto {
            Onto::Black => false,
            Onto::WhatIsThere if self.ambient.iter().all(|colour| *colour == [0.0; 3]) && self.background == [0.0; 3] => return,
            Onto::WhatIsThere => true,
        };
        let Workroom { planes, weights, path_colours, set_colours, .. } = workroom;
        path_colours.clear();
        path_colours.extend(tile.paths.iter().zip(weights.iter()).map(|(path, weight)| {
            let colour = path.body.map_or(self.background, |body| self.ambient[body.index()]);
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
