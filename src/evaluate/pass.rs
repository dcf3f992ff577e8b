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
    /// Red, green and blue of some blocks, before the weight of their paths.
    sums: [Vec<Lanes>; 3],
    /// What each path, and each set of them, adds to its pixels beside the contributions of lights.
    path_colours: Vec<[f32; 3]>,
    set_colours: Vec<[f32; 3]>,
}

impl Workroom {
    /// About how large one is.
    pub(super) const BYTES: usize = Planes::BYTES + 3 * (CHUNK as usize + 1) * size_of::<Lanes>();

    pub(super) fn new() -> Self {
        let sums = [(); 3].map(|()| vec![Lanes::default(); CHUNK as usize + 1]);
        Self { planes: Planes::new(), weights: Vec::new(), sums, path_colours: Vec::new(), set_colours: Vec::new() }
    }
}

impl Pass<'_> {
    /// Adds the pass to the planes of the workroom, whose weights are those of the tile's paths. `place` is the tile's; `kept` are
    /// columns beside the static ones, if kernels read such.
    pub(super) fn add(&self, tile: &Tile, place: usize, kept: Option<&Columns>, onto: Onto, workroom: &mut Workroom) {
        self.everywhere(tile, onto, workroom);
        for (index, group) in tile.groups.iter().enumerate() {
            self.group(tile, place, kept, group, index, workroom);
        }
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
            if weight.is_zero() { [0.0; 3] } else { weight.of(colour) }
        }));
        set_colours.clear();
        set_colours.extend(tile.path_sets.iter().map(|paths| {
            let mut sum = [0.0; 3];
            for path in paths {
                let colour = path_colours[path.index()];
                sum = std::array::from_fn(|component| sum[component] + colour[component]);
            }
            sum
        }));
        planes.fill(tile, set_colours, add);
    }

    /// What the lights of a group add.
    fn group(&self, tile: &Tile, place: usize, kept: Option<&Columns>, group: &Group, index: usize, workroom: &mut Workroom) {
        if !group.lights.iter().any(|light| self.sources.iter().any(|source| source.active[self.pair(group, *light)])) {
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
            let (Some(first), Some(last)) = (run.first(), run.last()) else { continue };
            let blocks = first.blocks.start..last.blocks.end;
            // Chunks as the columns are cut in.
            let skipped = (blocks.start - group.blocks.start) / CHUNK * CHUNK;
            for start in (group.blocks.start + skipped..blocks.end).step_by(CHUNK as usize) {
                let chunk = start.max(blocks.start)..(start + CHUNK).min(blocks.end);
                self.light(place, kept, group, index, &chunk, &mut workroom.sums);
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

    /// The contributions of all lights of a group to these blocks.
    fn light(
        &self,
        place: usize,
        kept: Option<&Columns>,
        group: &Group,
        index: usize,
        blocks: &Range<u32>,
        sums: &mut [Vec<Lanes>; 3],
    ) {
        let length = blocks.len();
        for plane in sums.iter_mut() {
            plane[..length + 1].fill(Lanes::default());
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
