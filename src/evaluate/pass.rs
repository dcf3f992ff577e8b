//! Adding up a tile: which kernels run over which records, and how their contributions come into the pixels.
//!
//! A [`Pass`] is one way to weigh the hits of a picture. A whole frame is one pass: every path with its weight, one source of
//! light for all pairs of a body and a light. A part of the picture that a drag keeps (see [`drag`](super::drag)) is another.

use crate::evaluate::columns::{CHUNK, Columns};
use crate::evaluate::framebuffer::Channels;
use crate::evaluate::planes::{Planes, Weight};
use crate::jit::{Kernel, Lanes, Splat};
use crate::scene::LightId;
use crate::trace::{Group, Span, Tile};
use std::ops::Range;

/// What lit records contribute: a kernel with what it reads beside the columns, for some pairs of a body and a light.
pub(super) struct Source<'p> {
    /// Static columns → contributions, added up.
    pub(super) kernel: &'p Kernel,
    /// What the kernel yields.
    pub(super) channels: Channels,
    /// The columns of each tile that the kernel reads.
    pub(super) columns: &'p [Columns],
    /// For each pair of a body and a light the uniform values.
    pub(super) uniforms: Vec<Splat>,
    /// How many uniform values a pair has.
    pub(super) uniform_count: usize,
    /// For each pair whether anything comes of it.
    pub(super) active: Vec<bool>,
}

/// What is added up, and with what weights.
pub(super) struct Pass<'p> {
    pub(super) sources: Vec<Source<'p>>,
    /// How many lights a body is paired with.
    pub(super) lights: usize,
    /// For each body what its hits contribute wherever they are.
    pub(super) ambient: Vec<[f32; 3]>,
    /// What rays contribute that left the scene.
    pub(super) background: [f32; 3],
    /// What is computed; the others stay as they are.
    pub(super) channels: Channels,
}

/// Room for the work on a tile, used again for the next.
pub(super) struct Workroom {
    pub(super) planes: Planes,
    /// The weight of each path of the tile.
    pub(super) weights: Vec<Weight>,
    /// Red, green and blue of some blocks, before the weight of their paths.
    sums: [Vec<Lanes>; 3],
}

impl Workroom {
    pub(super) fn new() -> Self {
        Self { planes: Planes::new(), weights: Vec::new(), sums: [(); 3].map(|()| vec![Lanes::default(); CHUNK as usize + 1]) }
    }
}

impl Pass<'_> {
    /// Adds the pass to the planes of the workroom, whose weights are those of the tile's paths. `place` is the tile's; `kept` are
    /// columns beside the static ones, if kernels read such.
    pub(super) fn add(&self, tile: &Tile, place: usize, kept: Option<&Columns>, workroom: &mut Workroom) {
        for (index, group) in tile.groups.iter().enumerate() {
            self.group(tile, place, kept, group, index, workroom);
        }
        if self.background != [0.0; 3] {
            for span in &tile.misses {
                let weight = workroom.weights[span.path.index()];
                if !weight.is_zero() {
                    workroom.planes.add_constant(tile.misses_of(span), self.background, weight);
                }
            }
        }
    }

    fn group(&self, tile: &Tile, place: usize, kept: Option<&Columns>, group: &Group, index: usize, workroom: &mut Workroom) {
        let ambient = self.ambient[group.body.index()];
        let lit = group.lights.iter().any(|light| self.sources.iter().any(|source| source.active[self.pair(group, *light)]));
        if !lit && ambient == [0.0; 3] {
            return;
        }
        // Runs of spans whose weight is not 0 are computed together, and nothing of the others.
        let dead = |weights: &[Weight], span: &Span| weights[span.path.index()].is_zero();
        let mut rest = &*group.spans;
        while let Some(start) = rest.iter().position(|span| !dead(&workroom.weights, span)) {
            let alive = &rest[start..];
            let length = alive.iter().position(|span| dead(&workroom.weights, span)).unwrap_or(alive.len());
            let (mut run, behind) = alive.split_at(length);
            rest = behind;
            if !lit {
                for span in run {
                    let weight = workroom.weights[span.path.index()];
                    workroom.planes.add_constant(tile.blocks_of(&span.blocks), ambient, weight);
                }
                continue;
            }
            let (Some(first), Some(last)) = (run.first(), run.last()) else { continue };
            let blocks = first.blocks.start..last.blocks.end;
            // Chunks as the columns are cut in.
            let skipped = (blocks.start - group.blocks.start) / CHUNK * CHUNK;
            for start in (group.blocks.start + skipped..blocks.end).step_by(CHUNK as usize) {
                let chunk = start.max(blocks.start)..(start + CHUNK).min(blocks.end);
                self.light(place, kept, group, index, ambient, &chunk, &mut workroom.sums);
                while let Some((span, later)) = run.split_first() {
                    let part = span.blocks.start.max(chunk.start)..span.blocks.end.min(chunk.end);
                    if part.start >= part.end {
                        break;
                    }
                    let sums = (part.start - chunk.start) as usize..(part.end - chunk.start) as usize;
                    let sums = workroom.sums.each_ref().map(|plane| &plane[sums.clone()]);
                    let weight = workroom.weights[span.path.index()];
                    workroom.planes.add(tile.blocks_of(&part), sums, weight, self.channels);
                    if span.blocks.end > chunk.end {
                        break;
                    }
                    run = later;
                }
            }
        }
    }

    /// The sums of these blocks of a group: what its body contributes anyway, and the contributions of all its lights.
    fn light(
        &self,
        place: usize,
        kept: Option<&Columns>,
        group: &Group,
        index: usize,
        ambient: [f32; 3],
        blocks: &Range<u32>,
        sums: &mut [Vec<Lanes>; 3],
    ) {
        let length = blocks.len();
        for (plane, component) in sums.iter_mut().zip(ambient) {
            plane[..length + 1].fill(Lanes::splat(component));
        }
        let first = (blocks.start - group.blocks.start) as usize;
        let mut inputs = Vec::with_capacity(16);
        for source in &self.sources {
            for (light_place, light) in group.lights.iter().enumerate() {
                let pair = self.pair(group, *light);
                if !source.active[pair] {
                    continue;
                }
                let uniforms = &source.uniforms[pair * source.uniform_count..(pair + 1) * source.uniform_count];
                inputs.clear();
                source.columns[place].of(index, light_place, first, length, &mut inputs);
                if let Some(kept) = kept {
                    kept.of(index, light_place, first, length, &mut inputs);
                }
                let [red, green, blue] = &mut *sums;
                match source.channels {
                    Channels::All => source.kernel.run(&inputs, uniforms, &mut [red, green, blue], length),
                    Channels::One(component) => {
                        let plane = [red, green, blue].into_iter().nth(component);
                        if let Some(plane) = plane {
                            source.kernel.run(&inputs, uniforms, &mut [plane], length);
                        }
                    }
                }
            }
        }
    }

    fn pair(&self, group: &Group, light: LightId) -> usize {
        group.body.index() * self.lights + light.index()
    }
}
