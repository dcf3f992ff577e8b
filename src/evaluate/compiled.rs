//! Frames by compiled code.

use crate::evaluate::columns::Columns;
use crate::evaluate::frame::Frame;
use crate::formula::graph::Node;
use crate::formula::layout::Layout;
use crate::formula::{Formula, ParameterId};
use crate::jit::{CompiledFormula, Lanes};
use crate::lang::scalars::flush;
use crate::lang::variables::{Owner, Predefined};
use crate::scene::Scene;
use crate::trace::{Edge, Group, Hits, MAX_DEPTH, Mismatch, Optics, Span, TILE_PIXELS, Tile};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// A compiled formula with the static values of all records of a traced scene.
pub struct Compiled {
    compiled: Arc<CompiledFormula>,
    hits: Arc<Hits>,
    columns: Vec<Columns>,
    layout: Layout,
    /// For each parameter number that the uniform kernel reads: its owner, slot and all.
    uniform_leaves: Vec<(Owner, usize)>,
    places: Places,
}

/// Where the parameters of equation (2) itself lie in the row of their owner.
struct Places {
    kr: usize,
    kt: usize,
    ki: usize,
    ka: usize,
    body_colour: usize,
    ambient_colour: usize,
    background: usize,
}

/// What one frame needs to know beyond the hits: parameter numbers and what is uniform in them.
struct Parameters<'f> {
    memory: &'f [f32],
    /// For each pair of a body and a light its uniform values, each in four lanes.
    uniforms: Vec<Lanes>,
}

impl Compiled {
    /// Works out the static values of all records, on all threads of the current pool.
    ///
    /// # Errors
    /// `hits` are not those of `scene`.
    pub fn new(compiled: Arc<CompiledFormula>, formula: &Formula, scene: &Scene, hits: &Arc<Hits>) -> Result<Self, Mismatch> {
        let optics = Optics::new(scene, &hits.view);
        let columns = hits.tiles.par_iter().map(|tile| Columns::new(&compiled, &optics, tile)).collect::<Result<Vec<_>, _>>()?;
        let slot = |id: ParameterId| formula.parameter(id).slot as usize;
        let leaf = |node: Node| match node {
            Node::Parameter(id, component) => Some((formula.parameter(id).owner, slot(id) + usize::from(component))),
            Node::Constant(_) | Node::Variable(..) | Node::Apply(..) => None,
        };
        // What is uniform is made of parameters alone.
        let uniform_leaves = compiled.uniform_leaves.iter().filter_map(|id| leaf(compiled.bindings.graph.node(*id))).collect();
        let place = |predefined| slot(formula.predefined(predefined));
        let places = Places {
            kr: place(Predefined::Reflection),
            kt: place(Predefined::Refraction),
            ki: place(Predefined::Intensity),
            ka: place(Predefined::Ambient),
            body_colour: place(Predefined::BodyColour),
            ambient_colour: place(Predefined::AmbientColour),
            background: place(Predefined::Background),
        };
        let layout = Layout::new(formula, scene.bodies.len(), scene.lights.len());
        Ok(Self { compiled, hits: Arc::clone(hits), columns, layout, uniform_leaves, places })
    }

    /// The memory at rest, in bytes: the hit store and the static columns.
    pub fn bytes(&self) -> usize {
        self.hits.bytes() as usize + self.columns.iter().map(Columns::bytes).sum::<usize>()
    }

    /// The picture that these parameter numbers give; see [`Evaluator::frame`](super::Evaluator::frame).
    pub fn frame(&self, memory: &[f32]) -> Frame {
        assert!(memory.len() >= self.layout.len(), "as many parameter numbers as the formula and the scene have");
        let view = self.hits.view;
        let mut frame = Frame::black(view.width(), view.height());
        let parameters = Parameters { memory, uniforms: self.uniforms(memory) };
        frame.linear.par_chunks_mut(TILE_PIXELS as usize).zip(self.hits.tiles.par_iter().zip(&self.columns)).for_each_init(
            Workroom::default,
            |workroom, (pixels, (tile, columns))| {
                self.tile(tile, columns, &parameters, workroom);
                for (index, pixel) in pixels.iter_mut().enumerate() {
                    *pixel = std::array::from_fn(|component| workroom.pixels[component][index]);
                }
            },
        );
        frame
    }

    /// A number of the row of the owner of this index.
    fn number(&self, memory: &[f32], owner: Owner, index: usize, slot: usize) -> f32 {
        flush(memory[self.layout.row(owner, index) + slot])
    }

    fn colour(&self, memory: &[f32], owner: Owner, index: usize, slot: usize) -> [f32; 3] {
        [0, 1, 2].map(|component| self.number(memory, owner, index, slot + component))
    }

    /// The uniform values of all pairs of a body and a light.
    fn uniforms(&self, memory: &[f32]) -> Vec<Lanes> {
        let [bodies, lights] = [Owner::Body, Owner::Light].map(|owner| self.layout.owners(owner));
        let pairs = bodies * lights;
        let count = self.compiled.bindings.uniforms.len();
        let blocks = Lanes::blocks(pairs);
        let inputs: Vec<Vec<Lanes>> = self
            .uniform_leaves
            .iter()
            .map(|(owner, slot)| {
                let mut column = vec![Lanes::default(); blocks];
                for pair in 0..pairs {
                    let index = match owner {
                        Owner::Global => 0,
                        Owner::Body => pair / lights,
                        Owner::Light => pair % lights,
                    };
                    column[pair / Lanes::COUNT].0[pair % Lanes::COUNT] = self.number(memory, *owner, index, *slot);
                }
                column
            })
            .collect();
        let mut outputs = vec![vec![Lanes::default(); blocks]; count];
        let inputs: Vec<&[Lanes]> = inputs.iter().map(Vec::as_slice).collect();
        let mut places: Vec<&mut [Lanes]> = outputs.iter_mut().map(Vec::as_mut_slice).collect();
        self.compiled.uniform_kernel.run(&inputs, &[], &mut places, blocks);
        let value = |pair: usize, index: usize| Lanes::splat(outputs[index][pair / Lanes::COUNT].0[pair % Lanes::COUNT]);
        (0..pairs).flat_map(|pair| (0..count).map(move |index| (pair, index))).map(|(pair, index)| value(pair, index)).collect()
    }

    /// The weight of each path of a tile: the product of kr and kt of the bodies along it.
    fn path_weights(&self, tile: &Tile, memory: &[f32], weights: &mut Vec<Weight>) {
        weights.clear();
        for path in &tile.paths {
            let weight = match path.parent.map(|parent| (parent.index(), tile.paths[parent.index()].body)) {
                Some((parent, Some(body))) => {
                    let slot = match path.edge {
                        Edge::Reflected => self.places.kr,
                        Edge::Refracted => self.places.kt,
                        // Only first steps are primary, and they have no parent.
                        Edge::Primary => {
                            weights.push(Weight(1.0));
                            continue;
                        }
                    };
                    Weight(weights[parent].0 * f64::from(self.number(memory, Owner::Body, body.index(), slot)))
                }
                Some((_, None)) | None => Weight(1.0),
            };
            weights.push(weight);
        }
    }

    /// Sums up the pixels of a tile in the workroom.
    fn tile(&self, tile: &Tile, columns: &Columns, parameters: &Parameters, workroom: &mut Workroom) {
        workroom.clear(tile.pixels.len());
        self.path_weights(tile, parameters.memory, &mut workroom.weights);
        for (index, group) in tile.groups.iter().enumerate() {
            self.group(tile, group, index, columns, parameters, workroom);
        }
        let background = self.colour(parameters.memory, Owner::Global, 0, self.places.background);
        for span in &tile.misses {
            let weight = workroom.weights[span.path.index()];
            if !weight.is_zero() {
                let colour = weight.of(background);
                for pixel in tile.pixels_of_misses(span) {
                    workroom.add(*pixel, colour);
                }
            }
        }
    }

    fn group(
        &self,
        tile: &Tile,
        group: &Group,
        index: usize,
        columns: &Columns,
        parameters: &Parameters,
        workroom: &mut Workroom,
    ) {
        let memory = parameters.memory;
        let ambient = self.ambient(group, memory);
        // Runs of spans whose weight is not 0 are computed together, and nothing of the others.
        let dead = |weights: &[Weight], span: &Span| weights[span.path.index()].is_zero();
        let mut rest = &*group.spans;
        while let Some(start) = rest.iter().position(|span| !dead(&workroom.weights, span)) {
            let alive = &rest[start..];
            let length = alive.iter().position(|span| dead(&workroom.weights, span)).unwrap_or(alive.len());
            let (run, behind) = alive.split_at(length);
            rest = behind;
            let (Some(first), Some(last)) = (run.first(), run.last()) else { continue };
            let block = (first.hits.start - group.hits.start) as usize / Lanes::COUNT;
            let blocks = Lanes::blocks((last.hits.end - group.hits.start) as usize) - block;
            workroom.clear_sums(blocks);
            self.lights(group, index, columns, parameters, block..block + blocks, workroom);
            for span in run {
                let weight = workroom.weights[span.path.index()];
                for (hit, pixel) in span.hits.clone().zip(tile.pixels_of(span)) {
                    let place = (hit - group.hits.start) as usize - block * Lanes::COUNT;
                    let colour = std::array::from_fn(|component| workroom.sum(component, place) + ambient[component]);
                    workroom.add(*pixel, weight.of(colour));
                }
            }
        }
    }

    /// Adds up the contributions of a group's lights in these blocks.
    fn lights(
        &self,
        group: &Group,
        index: usize,
        columns: &Columns,
        parameters: &Parameters,
        blocks: Range<usize>,
        workroom: &mut Workroom,
    ) {
        let count = self.compiled.bindings.uniforms.len();
        let mut inputs = Vec::with_capacity(8);
        for (place, light) in group.lights.iter().enumerate() {
            // A light of intensity 0 adds exactly nothing, whatever the formula yields.
            if self.number(parameters.memory, Owner::Light, light.index(), self.places.ki) == 0.0 {
                continue;
            }
            let pair = group.body.index() * self.layout.owners(Owner::Light) + light.index();
            let uniforms = &parameters.uniforms[pair * count..(pair + 1) * count];
            columns.of(index, place, blocks.start, blocks.len(), &mut inputs);
            let [red, green, blue] = &mut workroom.sums;
            self.compiled.contribution_kernel.run(&inputs, uniforms, &mut [red, green, blue], blocks.len());
        }
    }

    /// ka · Cd · Ia of a group's body, exactly 0 where ka is.
    fn ambient(&self, group: &Group, memory: &[f32]) -> [f32; 3] {
        let weight = self.number(memory, Owner::Global, 0, self.places.ka);
        let colour = self.colour(memory, Owner::Body, group.body.index(), self.places.body_colour);
        let light = self.colour(memory, Owner::Global, 0, self.places.ambient_colour);
        if weight == 0.0 { [0.0; 3] } else { [0, 1, 2].map(|component| weight * (colour[component] * light[component])) }
    }
}

/// The weight of a path. Kept in `f64`: the product of weights that are not 0 is then never 0, and a term of infinite value stays so
/// however small its weight.
#[derive(Debug, Clone, Copy)]
struct Weight(f64);

// A factor other than 0 is at least 2⁻¹²⁶, and there is one for each depth below the first.
const _: () = assert!((MAX_DEPTH - 1) * 126 <= 1022);

impl Weight {
    fn is_zero(self) -> bool {
        self.0 == 0.0
    }

    /// The weighed colour.
    #[inline]
    fn of(self, colour: [f32; 3]) -> [f32; 3] {
        if self.0 >= f64::from(f32::MIN_POSITIVE) {
            colour.map(|component| self.0 as f32 * component)
        } else {
            colour.map(|component| (self.0 * f64::from(component)) as f32)
        }
    }
}

/// Room for the sums of a tile, used again for the next.
#[derive(Default)]
struct Workroom {
    /// Red, green and blue of the tile's pixels.
    pixels: [Vec<f32>; 3],
    /// Red, green and blue of some hits, before the weight of their paths.
    sums: [Vec<Lanes>; 3],
    /// The weight of each path.
    weights: Vec<Weight>,
}

impl Workroom {
    fn clear(&mut self, pixels: usize) {
        for plane in &mut self.pixels {
            plane.clear();
            plane.resize(pixels, 0.0);
        }
    }

    fn clear_sums(&mut self, blocks: usize) {
        for plane in &mut self.sums {
            plane.clear();
            plane.resize(blocks, Lanes::default());
        }
    }

    fn sum(&self, component: usize, place: usize) -> f32 {
        self.sums[component][place / Lanes::COUNT].0[place % Lanes::COUNT]
    }

    fn add(&mut self, pixel: u16, colour: [f32; 3]) {
        for (plane, component) in self.pixels.iter_mut().zip(colour) {
            plane[usize::from(pixel)] += component;
        }
    }
}
