//! Evaluation by machine code.
//!
//! The static values of every record lie in columns (`columns`). A frame runs the contribution kernels over the
//! spans whose path weight is not 0, and adds their results to the pixels (`summation`, `tile`, `planes`). The order of
//! that work is kept from frame to frame (`program`). `drag` makes the pictures while a slider is held.

mod chosen;
mod columns;
mod drag;
mod leaves;
mod memory;
mod planes;
mod program;
mod source;
mod summation;
mod surface;
mod textured;
mod tile;

use crate::evaluate::weights::{PathMonomials, Weight, path_weights};
use crate::evaluate::{Backend, Drawn, EvaluateError, Evaluator, Footprint, Framebuffer, Part, evaluated_formula};
use crate::formula::equation::{Equation, Site};
use crate::formula::{Formula, Parameter};
use crate::jit::compile::Contribution;
use crate::jit::{self, CompiledFormula, Kernel, KernelCache, Line, PREFETCH_DISTANCE, PixelCode, Splat, Width};
use crate::lang::scalars::flush;
use crate::lang::variables::Owner;
use crate::picture::Frame;
use crate::plan::{Channels, DragPlan, ParameterSlot, SurfacePlan, parameter_slots};
use crate::trace::{Hits, Mismatch, Tile, View, tile_pixels};
use crate::world::World;
use chosen::{Chosen, ChosenVariant};
use columns::{Columns, LeafColumns};
use drag::CompiledDrag;
use leaves::StaticTextures;
use program::TileProgram;
use rayon::prelude::*;
use source::ContributionSource;
use std::sync::{Arc, Mutex, PoisonError};
use summation::{Summation, SummationColumns};
use surface::{SurfaceSummation, SurfaceTile, parameter_weights};
use textured::Textured;
use tile::{Accumulate, TileScratch};

/// The name of the backend.
pub const NAME: &str = "jit";

/// The backend. It keeps the kernels of the last formulas.
#[derive(Default)]
pub struct Jit {
    kernels: KernelCache,
}

impl Jit {
    /// The backend with vectors of this width rather than the widest.
    pub fn with_width(width: Width) -> Self {
        Self { kernels: KernelCache::with_width(width) }
    }
}

impl Backend for Jit {
    fn name(&self) -> &'static str {
        NAME
    }

    fn compile(&self, formula: &Arc<Formula>, world: &World) -> Result<Footprint, EvaluateError> {
        let compiled = self.kernels.compiled(&evaluated_formula(formula, world))?;
        let frontier = &compiled.plan.bindings.frontier;
        let numbers = |count: usize| (size_of::<f32>() * count) as u64;
        // Parameter numbers, uniform values as the kernel writes them and as others read them, and whether the pair
        // is active.
        let (leaves, uniforms) = (compiled.plan.contribution.uniforms.streams[0].len(), compiled.contribution.uniforms.outputs());
        let per_pair = numbers(leaves + uniforms) + (size_of::<Splat>() * uniforms) as u64 + 2;
        let per_call = jit::CallList::BYTES_PER_CALL as u64;
        let surface = compiled.surface.as_ref();
        let surface = surface.map_or(0, |surface| numbers(surface.hits.outputs()) + SurfaceTile::BYTES_PER_HIT as u64);
        let per_record = numbers(frontier.records.len());
        // Variants have columns of their own, at most as many.
        let copies = if compiled.conditions.is_some() { 2 } else { 1 };
        Ok(Footprint {
            per_hit: copies * numbers(frontier.hits.len()) + surface,
            per_record: copies * per_record,
            per_pair,
            per_call,
        })
    }

    fn thread_bytes(&self, formula: &Arc<Formula>, world: &World, _: &View) -> Result<u64, EvaluateError> {
        let compiled = self.kernels.compiled(&evaluated_formula(formula, world))?;
        let leaves = LeafColumns::bytes(&compiled, world.emitter_ids().count());
        Ok((TileScratch::BYTES + leaves) as u64)
    }

    fn prepare(&self, formula: &Arc<Formula>, hits: &Arc<Hits>, parameters: &[f32]) -> Result<Arc<dyn Evaluator>, EvaluateError> {
        let formula = &evaluated_formula(formula, &hits.world);
        let kernels = self.kernels.compiled(formula)?;
        let compiled = Compiled::new(Arc::clone(&kernels), formula, hits, parameters)?;
        match compiled.textures.is_empty() {
            true => Ok(Arc::new(compiled)),
            false => Ok(Arc::new(Textured::new(kernels, formula, hits, compiled))),
        }
    }
}

/// A compiled formula with the static values of all records of a traced scene.
pub struct Compiled {
    compiled: Arc<CompiledFormula>,
    hits: Arc<Hits>,
    columns: Vec<Columns>,
    /// The nodes of each tile, if the formula gives something at every hit.
    surface: Vec<SurfaceTile>,
    /// The parameter numbers that the uniform kernel of the surface reads.
    surface_leaves: Vec<ParameterSlot>,
    /// The textures that static values were looked up in. Pictures have the same.
    textures: StaticTextures,
    equation: Equation,
    parameters: Vec<Parameter>,
    /// The parameter numbers that the uniform kernel reads.
    leaves: Vec<ParameterSlot>,
    /// The order of work of each tile in a whole picture.
    programs: Vec<Mutex<TileProgram>>,
    /// The variants that were in use last, if the formula chooses.
    chosen: Mutex<Option<Arc<Chosen>>>,
    /// Scratch of the threads, kept for the next frame.
    scratch: Mutex<Vec<TileScratch>>,
}

impl Compiled {
    /// Computes the static values of all records, on all threads of the current pool, with the textures among these
    /// parameter numbers.
    ///
    /// # Errors
    /// The tiles of `hits` are not those of its world and view.
    fn new(compiled: Arc<CompiledFormula>, formula: &Formula, hits: &Arc<Hits>, parameters: &[f32]) -> Result<Self, Mismatch> {
        let hits = hits.for_lights(formula.evaluated_lights())?;
        let scene = hits.world.scene();
        let equation = Equation::new(formula, scene.bodies.len(), scene.lights.len());
        let textures = StaticTextures::new(&compiled.plan, formula, equation.layout, parameters);
        let columns = Columns::of_tiles(&compiled, formula, &textures, &hits)?;
        let leaves = compiled.plan.contribution.leaves(&compiled.plan.bindings.graph, &formula.parameters);
        let surface = SurfaceTile::of_tiles(&compiled, formula, &textures, &hits)?;
        let of_surface = |plan: &SurfacePlan| plan.outputs.leaves(&plan.bindings.graph, &formula.parameters);
        let surface_leaves = compiled.plan.surface.as_ref().map(of_surface).unwrap_or_default();
        Ok(Self {
            surface,
            surface_leaves,
            columns,
            textures,
            equation,
            parameters: formula.parameters.clone(),
            leaves,
            programs: hits.tiles.iter().map(|_| Mutex::default()).collect(),
            chosen: Mutex::default(),
            compiled,
            hits,
            scratch: Mutex::default(),
        })
    }

    /// The width of the vectors that pictures are made with.
    pub fn width(&self) -> Width {
        self.compiled.width
    }

    /// Draws a tile into its part of a framebuffer.
    fn draw_tile(&self, summation: &Summation, parameters: &[f32], index: usize, scratch: &mut TileScratch, part: Part) {
        self.tile(summation, parameters, index, scratch);
        // Kernels have prefetched the first lines after those of the tile.
        let next = summation.columns.lines(index + 1).and_then(|next| next.get(PREFETCH_DISTANCE / size_of::<Line>()..));
        scratch.planes.quantise(0, part, next.unwrap_or_default());
    }

    fn check_size(&self, framebuffer: &Framebuffer) {
        let view = self.hits.view;
        assert_eq!((framebuffer.width, framebuffer.height), (view.width(), view.height()), "a framebuffer of the view's size");
    }

    fn check_parameters(&self, parameters: &[f32]) {
        assert!(parameters.len() >= self.equation.layout.len(), "as many parameter numbers as the formula and the scene have");
    }

    /// Does some work for each tile, in parallel. `each` gets an item of `work`, the index of the tile, and scratch
    /// memory.
    fn each_tile<T: Send>(
        &self,
        work: impl IndexedParallelIterator<Item = T>,
        each: impl Fn(T, usize, &mut TileScratch) + Sync + Send,
    ) {
        work.enumerate().for_each(|(index, own)| {
            let pool = || self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
            let free = pool().pop();
            let mut scratch = free.unwrap_or_else(|| TileScratch::new(self.width()));
            each(own, index, &mut scratch);
            pool().push(scratch);
        });
    }

    /// The summation of a whole picture, with the [variants](Self::chosen) for these numbers.
    fn whole<'p>(&'p self, parameters: &[f32], chosen: Option<&'p Chosen>) -> Summation<'p> {
        self.check_parameters(parameters);
        let bodies = 0..self.equation.layout.owners(Owner::Body);
        let at_hits = bodies.map(|body| self.equation.sum(Site::Hit, parameters, body)).collect();
        let mut summation = self.empty_summation(at_hits, self.equation.sum(Site::Miss, parameters, 0), Channels::All);
        summation.surface = self.surface_summation(parameters, true);
        self.push_contributions(parameters, chosen, &mut summation);
        summation
    }

    /// Adds the contributions of all pairs of a body and a light: by the kernels of the branches that a pair takes, or
    /// by one kernel where the formula does not choose.
    fn push_contributions<'p>(&'p self, parameters: &[f32], chosen: Option<&'p Chosen>, summation: &mut Summation<'p>) {
        let Some(chosen) = chosen else {
            let (source, uniforms) = self.source(parameters, &self.compiled.contribution, &self.leaves, Channels::All);
            return summation.push(source, uniforms);
        };
        summation.columns = SummationColumns::Variants(chosen);
        for (index, ChosenVariant { compiled, leaves, pairs }) in chosen.variants.iter().enumerate() {
            let contribution = compiled.as_ref().map_or(&self.compiled.contribution, |variant| &variant.contribution);
            let (mut source, uniforms) = self.source(parameters, contribution, leaves, Channels::All);
            source.variant = index;
            source.active.iter_mut().zip(pairs).for_each(|(active, own)| *active &= own);
            summation.push(source, uniforms);
        }
    }

    /// Which uniform conditions hold for each pair of a body and a light, a bit for each. Empty if the formula does not
    /// choose by uniform conditions.
    fn choices(&self, parameters: &[f32]) -> Vec<u32> {
        let (Some(plan), Some(kernel)) = (&self.compiled.plan.conditions, &self.compiled.conditions) else { return Vec::new() };
        let leaves = parameter_slots(&plan.numbers, &plan.bindings.graph, &self.parameters);
        let numbers = self.uniforms(parameters, kernel, &leaves, self.equation.layout.owners(Owner::Light));
        let bits = |of_pair: &[Splat]| {
            of_pair.iter().enumerate().fold(0, |bits, (index, number)| bits | u32::from(number.value() != 0.0) << index)
        };
        numbers.chunks_exact(plan.conditions.len()).map(bits).collect()
    }

    /// What the formula gives at every hit, for a summation with these parameter numbers.
    fn surface_summation(&self, parameters: &[f32], adds_own: bool) -> Option<SurfaceSummation<'_>> {
        let (plan, compiled) = (self.compiled.plan.surface.as_ref()?, self.compiled.surface.as_ref()?);
        let bodies = self.equation.layout.owners(Owner::Body);
        Some(SurfaceSummation {
            compiled,
            plan,
            tiles: &self.surface,
            uniforms: self.uniforms(parameters, &compiled.outputs.uniforms, &self.surface_leaves, 1),
            weights: parameter_weights(&self.equation, parameters, bodies),
            adds_own,
        })
    }

    /// The weights of the paths of a tile as monomials of the moved kr and kt. Where the formula gives weights of rays,
    /// they have their powers only.
    fn monomials(&self, plan: &DragPlan, tile: &Tile, parameters: &[f32]) -> PathMonomials {
        let mut monomials = PathMonomials::new(tile, &plan.equation, parameters, plan.weights);
        if !self.surface.is_empty() {
            monomials.fixed.fill(Weight(1.0));
        }
        monomials
    }

    /// Sets `weights` to the weights of all paths of a tile. Where the formula gives weights of rays, they are 1, and
    /// the summation multiplies by the weights of hits.
    fn path_weights(&self, tile: &Tile, parameters: &[f32], weights: &mut Vec<Weight>) {
        if self.surface.is_empty() {
            path_weights(tile, &self.equation, parameters, weights);
        } else {
            weights.clear();
            weights.resize(tile.paths.len(), Weight(1.0));
        }
    }

    /// A summation without sources.
    fn empty_summation(&self, at_hits: Vec<[f32; 3]>, at_misses: [f32; 3], channels: Channels) -> Summation<'_> {
        let code = PixelCode::get(self.width());
        let (sources, uniforms) = (Vec::new(), Vec::new());
        let columns = SummationColumns::Formula(&self.columns);
        Summation { sources, uniforms, columns, at_hits, at_misses, channels, code, surface: None }
    }

    /// A contribution of all pairs of a body and a light whose light is on, and its uniform values, computed from
    /// these leaves.
    fn source<'c>(
        &'c self,
        parameters: &[f32],
        contribution: &'c Contribution,
        leaves: &[ParameterSlot],
        channels: Channels,
    ) -> (ContributionSource<'c>, Vec<Splat>) {
        let source = ContributionSource {
            overwrite: &contribution.overwrite,
            add: &contribution.add,
            channels,
            variant: 0,
            first_uniform: 0,
            uniform_count: contribution.uniforms.outputs(),
            active: self.active(parameters, |_, _| true),
            lights: self.equation.layout.owners(Owner::Light),
            world: &self.hits.world,
        };
        let lights = self.equation.layout.owners(Owner::Light);
        (source, self.uniforms(parameters, &contribution.uniforms, leaves, lights))
    }

    /// Which of the wanted pairs contribute. A light of weight 0 adds nothing, even where the formula is infinite or
    /// NaN.
    fn active(&self, parameters: &[f32], wanted: impl Fn(usize, usize) -> bool) -> Vec<bool> {
        let [bodies, lights] = [Owner::Body, Owner::Light].map(|owner| self.equation.layout.owners(owner));
        let is_on: Vec<bool> = (0..lights).map(|light| self.equation.light_weight(parameters, light) != 0.0).collect();
        let pairs = (0..bodies).flat_map(|body| (0..lights).map(move |light| (body, light)));
        pairs.map(|(body, light)| is_on[light] && wanted(body, light)).collect()
    }

    /// Computes the pixels of a tile, in the planes of the scratch memory.
    fn tile(&self, summation: &Summation, parameters: &[f32], index: usize, scratch: &mut TileScratch) {
        let tile = &self.hits.tiles[index];
        self.path_weights(tile, parameters, &mut scratch.weights);
        let mut program = self.programs[index].lock().unwrap_or_else(PoisonError::into_inner);
        summation.run(tile, index, None, Accumulate::Overwrite, scratch, &mut program);
    }

    /// The uniform values of all pairs of a body and a light, pair by pair, by a kernel that reads these parameter
    /// numbers. `lights` is the number of lights, or 1 for values that do not depend on a light.
    fn uniforms(&self, parameters: &[f32], kernel: &Kernel, leaves: &[ParameterSlot], lights: usize) -> Vec<Splat> {
        let layout = &self.equation.layout;
        let pairs = layout.owners(Owner::Body) * lights;
        let lines = pairs.div_ceil(Line::RECORDS);
        let mut inputs = vec![Line::default(); lines * leaves.len()];
        for (column, leaf) in leaves.iter().enumerate() {
            for pair in 0..pairs {
                let index = match leaf.owner {
                    Owner::Global => 0,
                    Owner::Body => pair / lights,
                    Owner::Light => pair % lights,
                };
                let number = flush(parameters[layout.row(leaf.owner, index) + leaf.slot]);
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
}

impl Evaluator for Compiled {
    fn frame(&self, parameters: &[f32]) -> Frame {
        let view = self.hits.view;
        let mut frame = Frame::black(view.width(), view.height());
        let chosen = self.chosen(parameters);
        let summation = self.whole(parameters, chosen.as_deref());
        self.each_tile(frame.linear.par_chunks_mut(tile_pixels(view.pixels()) as usize), |pixels, index, scratch| {
            self.tile(&summation, parameters, index, scratch);
            for (index, pixel) in pixels.iter_mut().enumerate() {
                *pixel = scratch.planes.colour(index);
            }
        });
        frame
    }

    fn draw(&self, parameters: &[f32], framebuffer: &mut Framebuffer) -> Drawn {
        self.check_size(framebuffer);
        Drawn::timed(|| {
            let chosen = self.chosen(parameters);
            let summation = self.whole(parameters, chosen.as_deref());
            self.each_tile(framebuffer.parts(), |part, index, scratch| {
                self.draw_tile(&summation, parameters, index, scratch, part);
            });
        })
    }

    fn drag(
        self: Arc<Self>,
        moved: &[usize],
        parameters: &[f32],
        budget: usize,
    ) -> Result<Box<dyn crate::evaluate::Drag>, EvaluateError> {
        Ok(Box::new(CompiledDrag::new(&self, moved, parameters, budget)?))
    }

    /// The hit store, the static columns, those of the variants in use, the order of work of each tile, and scratch
    /// memory. The last three exist after the first frame.
    fn bytes(&self) -> usize {
        let scratch = self.scratch.lock().unwrap_or_else(PoisonError::into_inner).len();
        let programs = self.programs.iter().map(|program| program.lock().unwrap_or_else(PoisonError::into_inner).bytes());
        let columns = self.columns.iter().map(Columns::bytes).chain(self.surface.iter().map(SurfaceTile::bytes));
        let chosen = self.chosen.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map_or(0, |chosen| chosen.bytes());
        self.hits.bytes() as usize + columns.chain(programs).sum::<usize>() + chosen + scratch * TileScratch::BYTES
    }
}
