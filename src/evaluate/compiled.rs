//! Frames by compiled code.

use crate::evaluate::columns::Columns;
use crate::evaluate::frame::Frame;
use crate::evaluate::framebuffer::{Channels, Framebuffer, Part};
use crate::evaluate::pass::{Onto, Pass, Source, Workroom};
use crate::evaluate::planes::Weight;
use crate::evaluate::program::TileProgram;
use crate::formula::binding::Bindings;
use crate::formula::graph::{Node, NodeId};
use crate::formula::layout::Layout;
use crate::formula::{Formula, Parameter, ParameterId};
use crate::jit::compile::Contributor;
use crate::jit::{AHEAD, CompiledFormula, Kernel, Line, Splat};
use crate::lang::scalars::flush;
use crate::lang::variables::{Owner, Predefined};
use crate::scene::Scene;
use crate::trace::{Edge, Hits, Mismatch, Optics, Path, TILE_PIXELS, Tile};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// A compiled formula with the static values of all records of a traced scene.
pub struct Compiled {
    pub(super) compiled: Arc<CompiledFormula>,
    pub(super) hits: Arc<Hits>,
    pub(super) columns: Vec<Columns>,
    pub(super) layout: Layout,
    pub(super) parameters: Vec<Parameter>,
    /// Where each parameter number that the uniform kernel reads lies.
    uniform_leaves: Vec<Place>,
    pub(super) places: Places,
    /// What is done for each tile in a whole picture.
    programs: Vec<Mutex<TileProgram>>,
    /// Where tiles were worked on; kept for the next frame.
    workrooms: Mutex<Vec<Workroom>>,
}

/// A number of the parameters of an owner of some kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) owner: Owner,
    pub(super) slot: usize,
}

/// Where the parameters of equation (2) itself lie in the row of their owner.
pub(super) struct Places {
    pub(super) kr: usize,
    pub(super) kt: usize,
    pub(super) ki: usize,
    pub(super) ka: usize,
    pub(super) body_colour: usize,
    pub(super) ambient_colour: usize,
    pub(super) background: usize,
}

impl Compiled {
    /// Works out the static values of all records, on all threads of the current pool.
    ///
    /// # Errors
    /// `hits` are not those of `scene`.
    pub fn new(compiled: Arc<CompiledFormula>, formula: &Formula, scene: &Scene, hits: &Arc<Hits>) -> Result<Self, Mismatch> {
        let optics = Optics::new(scene, &hits.view);
        let columns = Columns::of_tiles(&compiled, &optics, hits)?;
        let slot = |id: ParameterId| formula.parameter(id).slot as usize;
        let uniform_leaves = places_of(&compiled.bindings, &formula.parameters, &compiled.contributor.uniform_leaves);
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
        let parameters = formula.parameters.clone();
        let programs = hits.tiles.iter().map(|_| Mutex::default()).collect();
        Ok(Self {
            compiled,
            hits: Arc::clone(hits),
            columns,
            layout,
            parameters,
            uniform_leaves,
            places,
            programs,
            workrooms: Mutex::default(),
        })
    }

    /// The memory at rest, in bytes: the hit store, the static columns, what is done for each tile, and where tiles were worked on. The last two
    /// are there after a frame.
    pub fn bytes(&self) -> usize {
        let workrooms = self.workrooms.lock().unwrap_or_else(PoisonError::into_inner).len();
        let programs = self.programs.iter().map(|program| program.lock().unwrap_or_else(PoisonError::into_inner).bytes());
        let columns = self.columns.iter().map(Columns::bytes);
        self.hits.bytes() as usize + columns.chain(programs).sum::<usize>() + workrooms * Workroom::BYTES
    }

    /// The picture that these parameter numbers give, unclamped and linear; see [`Evaluator::frame`](super::Evaluator::frame).
    pub fn frame(&self, memory: &[f32]) -> Frame {
        let view = self.hits.view;
        let mut frame = Frame::black(view.width(), view.height());
        let pass = self.whole(memory);
        self.each_tile(frame.linear.par_chunks_mut(TILE_PIXELS as usize), |pixels, place, workroom| {
            self.tile(&pass, memory, place, workroom);
            for (index, pixel) in pixels.iter_mut().enumerate() {
                *pixel = workroom.planes.colour(index);
            }
        });
        frame
    }

    /// The same picture as a window shows it; the numbers lie within the ranges of their parameters here too.
    ///
    /// # Panics
    /// Where the framebuffer has another size than the view, or there are too few parameter numbers.
    pub fn draw(&self, memory: &[f32], framebuffer: &mut Framebuffer) {
        self.check_size(framebuffer);
        let pass = self.whole(memory);
        self.each_tile(framebuffer.parts(), |part, place, workroom| self.draw_tile(&pass, memory, place, workroom, part));
    }

    /// Draws a tile into its part of a framebuffer.
    pub(super) fn draw_tile(&self, pass: &Pass, memory: &[f32], place: usize, workroom: &mut Workroom, part: Part) {
        self.tile(pass, memory, place, workroom);
        // Kernels have fetched what is just behind the tile's own.
        let behind = self.columns.get(place + 1).and_then(|next| next.lines().get(AHEAD / size_of::<Line>()..));
        workroom.planes.quantise(part, behind.unwrap_or_default());
    }

    pub(super) fn check_size(&self, framebuffer: &Framebuffer) {
        let view = self.hits.view;
        assert_eq!((framebuffer.width, framebuffer.height), (view.width(), view.height()), "a framebuffer of the view's size");
    }

    pub(super) fn check_numbers(&self, memory: &[f32]) {
        assert!(memory.len() >= self.layout.len(), "as many parameter numbers as the formula and the scene have");
    }

    /// Does some work for each tile, in parallel: on what belongs to it, with its place among the tiles, in some workroom.
    pub(super) fn each_tile<T: Send>(
        &self,
        work: impl IndexedParallelIterator<Item = T>,
        each: impl Fn(T, usize, &mut Workroom) + Sync + Send,
    ) {
        work.enumerate().for_each(|(place, own)| {
            let pool = || self.workrooms.lock().unwrap_or_else(PoisonError::into_inner);
            let free = pool().pop();
            let mut workroom = free.unwrap_or_else(Workroom::new);
            each(own, place, &mut workroom);
            pool().push(workroom);
        });
    }

    /// Everything that a picture is added up from.
    pub(super) fn whole(&self, memory: &[f32]) -> Pass<'_> {
        self.check_numbers(memory);
        let (source, uniforms) = self.source_of(memory, &self.compiled.contributor, &self.uniform_leaves, Channels::All);
        let background = self.colour(memory, Owner::Global, 0, self.places.background);
        let ambient = (0..self.layout.owners(Owner::Body)).map(|body| self.ambient(body, memory)).collect();
        let mut pass = self.nothing(ambient, background, Channels::All);
        pass.push(source, uniforms);
        pass
    }

    /// A pass without sources.
    pub(super) fn nothing(&self, ambient: Vec<[f32; 3]>, background: [f32; 3], channels: Channels) -> Pass<'_> {
        Pass { sources: Vec::new(), uniforms: Vec::new(), columns: &self.columns, ambient, background, channels }
    }

    /// What a contributor yields, of all pairs of a body and a light that contribute, and its uniform values, whose leaves lie at these places.
    pub(super) fn source_of<'c>(
        &'c self,
        memory: &[f32],
        contributor: &'c Contributor,
        leaves: &[Place],
        channels: Channels,
    ) -> (Source<'c>, Vec<Splat>) {
        let source = Source {
            storing: &contributor.storing,
            adding: &contributor.adding,
            channels,
            first_uniform: 0,
            uniform_count: contributor.uniform_kernel.outputs(),
            active: self.active(memory, |_, _| true),
            lights: self.layout.owners(Owner::Light),
        };
        (source, self.uniforms(memory, &contributor.uniform_kernel, leaves))
    }

    /// The parameter, and its component, whose number lies in this slot of the row of such an owner.
    pub(super) fn number_at(&self, owner: Owner, slot: usize) -> Option<(ParameterId, u8)> {
        let holds = |parameter: &&Parameter| {
            let first = parameter.slot as usize;
            parameter.owner == owner && (first..first + parameter.ty.slots()).contains(&slot)
        };
        let index = self.parameters.iter().position(|parameter| holds(&parameter))?;
        // A vector has three components.
        Some((ParameterId(index as u32), (slot - self.parameters[index].slot as usize) as u8))
    }

    /// Which pairs contribute. A light of intensity 0 adds exactly nothing, whatever the formula yields.
    pub(super) fn active(&self, memory: &[f32], wanted: impl Fn(usize, usize) -> bool) -> Vec<bool> {
        let [bodies, lights] = [Owner::Body, Owner::Light].map(|owner| self.layout.owners(owner));
        let bright = |light| self.number(memory, Owner::Light, light, self.places.ki) != 0.0;
        let pairs = (0..bodies).flat_map(|body| (0..lights).map(move |light| (body, light)));
        pairs.map(|(body, light)| bright(light) && wanted(body, light)).collect()
    }

    /// Adds a tile up from black.
    fn tile(&self, pass: &Pass, memory: &[f32], place: usize, workroom: &mut Workroom) {
        let tile = &self.hits.tiles[place];
        self.path_weights(tile, memory, &mut workroom.weights);
        let mut program = self.programs[place].lock().unwrap_or_else(PoisonError::into_inner);
        pass.add(tile, place, None, Onto::Black, workroom, &mut program);
    }

    /// A number of the row of the owner of this index.
    fn number(&self, memory: &[f32], owner: Owner, index: usize, slot: usize) -> f32 {
        flush(memory[self.layout.row(owner, index) + slot])
    }

    fn colour(&self, memory: &[f32], owner: Owner, index: usize, slot: usize) -> [f32; 3] {
        [0, 1, 2].map(|component| self.number(memory, owner, index, slot + component))
    }

    /// The uniform values of all pairs of a body and a light, one pair behind the other, by a kernel that reads these parameters.
    fn uniforms(&self, memory: &[f32], kernel: &Kernel, leaves: &[Place]) -> Vec<Splat> {
        let [bodies, lights] = [Owner::Body, Owner::Light].map(|owner| self.layout.owners(owner));
        let pairs = bodies * lights;
        let lines = pairs.div_ceil(Line::RECORDS);
        let mut inputs = vec![Line::default(); lines * leaves.len()];
        for (column, place) in leaves.iter().enumerate() {
            for pair in 0..pairs {
                let index = match place.owner {
                    Owner::Global => 0,
                    Owner::Body => pair / lights,
                    Owner::Light => pair % lights,
                };
                let number = self.number(memory, place.owner, index, place.slot);
                inputs[pair / Line::RECORDS * leaves.len() + column].0[pair % Line::RECORDS] = number;
            }
        }
        let columns = kernel.outputs();
        let mut outputs = vec![Line::default(); lines * columns];
        kernel.run([&inputs, &[], &[]], &[], &mut [&mut outputs], lines);
        let values = |pair: usize| {
            let first = pair / Line::RECORDS * columns;
            outputs[first..first + columns].iter().map(move |line| line.0[pair % Line::RECORDS])
        };
        (0..pairs).flat_map(values).map(Splat::new).collect()
    }

    /// The weight of each path of a tile: the product of kr and kt of the bodies along it.
    pub(super) fn path_weights(&self, tile: &Tile, memory: &[f32], weights: &mut Vec<Weight>) {
        weights.clear();
        for path in &tile.paths {
            let weight = match self.last_factor(tile, path) {
                Some((parent, place)) => Weight(weights[parent].0 * f64::from(flush(memory[place]))),
                None => Weight(1.0),
            };
            weights.push(weight);
        }
    }

    /// The path that a path goes on from, and where the number that it is weighed with beyond that lies; `None` for a primary ray.
    pub(super) fn last_factor(&self, tile: &Tile, path: &Path) -> Option<(usize, usize)> {
        let slot = match path.edge {
            Edge::Primary => return None,
            Edge::Reflected => self.places.kr,
            Edge::Refracted => self.places.kt,
        };
        let parent = path.parent?.index();
        Some((parent, self.layout.row(Owner::Body, tile.paths[parent].body?.index()) + slot))
    }

    /// ka · Cd · Ia of a body, exactly 0 where ka is.
    pub(super) fn ambient(&self, body: usize, memory: &[f32]) -> [f32; 3] {
        let [weight, colour, light] = self.ambient_factors(body, memory);
        if weight == [0.0; 3] { [0.0; 3] } else { [0, 1, 2].map(|c| weight[c] * (colour[c] * light[c])) }
    }

    /// ka, Cd and Ia of a body.
    pub(super) fn ambient_factors(&self, body: usize, memory: &[f32]) -> [[f32; 3]; 3] {
        let weight = self.number(memory, Owner::Global, 0, self.places.ka);
        let colour = self.colour(memory, Owner::Body, body, self.places.body_colour);
        let light = self.colour(memory, Owner::Global, 0, self.places.ambient_colour);
        [[weight; 3], colour, light]
    }
}

/// Where the parameters that these nodes are lie.
pub(super) fn places_of(bindings: &Bindings, parameters: &[Parameter], leaves: &[NodeId]) -> Vec<Place> {
    let place = |leaf: &NodeId| match bindings.graph.node(*leaf) {
        Node::Parameter(id, component) => {
            let parameter = &parameters[id.0 as usize];
            Some(Place { owner: parameter.owner, slot: parameter.slot as usize + usize::from(component) })
        }
        Node::Constant(_) | Node::Variable(..) | Node::Apply(..) => None,
    };
    // What is uniform is made of parameters alone.
    leaves.iter().filter_map(place).collect()
}
