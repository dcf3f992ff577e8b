//! Evaluation by machine code.
//!
//! The static values of every record lie in columns (`columns`). A frame runs the contribution kernels over the
//! spans whose path weight is not 0, and adds their results to the pixels (`summation`, `tile`, `planes`). The order of
//! that work is kept from frame to frame (`program`). `drag` makes the pictures while a slider is held.

mod chosen;
pub(in crate::backends) mod columns;
mod drag;
pub(in crate::backends) mod leaves;
mod memory;
mod miss_radiance;
mod place;
mod planes;
mod program;
mod source;
mod stored_pass;
mod summation;
pub(in crate::backends) mod surface;
mod textured;
mod tile;
pub(in crate::backends) mod uniforms;
mod variant_columns;

use crate::evaluate::weights::{PathMonomials, Weight, path_weights};
use crate::evaluate::{
    Backend, DragBeginning, Drawn, EvaluateError, Evaluator, Footprint, Framebuffer, Part, equation_in, evaluated_formula,
};
use crate::formula::Formula;
use crate::formula::equation::{Equation, Site};
use crate::jit::compile::{CompiledSurface, Contribution};
use crate::jit::{self, CompiledFormula, Kernel, KernelCache, Line, PREFETCH_DISTANCE, PixelCode, Splat, Width};
use crate::lang::variables::Owner;
use crate::picture::Frame;
use crate::plan::{Channels, DragPlan, ParameterSlot, SurfacePlan, parameter_slots};
use crate::trace::{Hits, Mismatch, Tile, View, tile_pixels};
use crate::world::World;
use chosen::{Chosen, ChosenVariant};
use columns::LeafColumns;
use drag::CompiledDrag;
use leaves::StaticTextures;
use miss_radiance::MissRadiance;
use place::TilePlace;
use rayon::prelude::*;
use source::ContributionSource;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use stored_pass::StoredPass;
use summation::{Summation, SummationColumns};
use surface::{OwnPart, SurfaceSummation, SurfaceTile, parameter_weights};
use textured::Textured;
use tile::{Accumulate, TileScratch};
use uniforms::pair_values;

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
        let seen = if world.environment().is_some() { MissRadiance::BYTES_PER_MISS } else { 0 };
        // Variants have columns of their own, at most as many.
        let copies = if compiled.conditions.is_some() { 2 } else { 1 };
        Ok(Footprint {
            per_hit: copies * numbers(frontier.hits.len()) + surface,
            per_record: copies * per_record,
            per_miss: seen + if compiled.surface.is_some() { SurfaceTile::BYTES_PER_MISS as u64 } else { 0 },
            per_pair,
            per_call,
            per_pixel: 0,
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
        let compiled = Compiled::new(kernels, formula, std::slice::from_ref(hits), parameters)?;
        match compiled.textures.is_empty() {
            true => Ok(Arc::new(compiled)),
            false => Ok(Arc::new(Textured::new(vec![Arc::clone(hits)], compiled))),
        }
    }
}

/// A compiled formula with the static values of all records of a traced scene, for one or more passes. Its pictures are
/// the mean of the passes.
pub struct Compiled {
    compiled: Arc<CompiledFormula>,
    formula: Arc<Formula>,
    /// At least one.
    passes: Vec<Arc<StoredPass>>,
    /// The parameter numbers that the uniform kernel of the surface reads.
    surface_leaves: Vec<ParameterSlot>,
    /// The textures that static values were looked up in. Pictures have the same.
    textures: StaticTextures,
    equation: Equation,
    /// The parameter numbers that the uniform kernel reads.
    leaves: Vec<ParameterSlot>,
    /// The variants that were in use last, if the formula chooses.
    chosen: Mutex<Option<Arc<Chosen>>>,
    /// Scratch of the threads, kept for the next frame.
    scratch: Mutex<Vec<TileScratch>>,
}

impl Compiled {
    /// Computes the static values of all records of these passes, on all threads of the current pool, with the textures
    /// among these parameter numbers. There is at least one pass.
    ///
    /// # Errors
    /// The tiles of `hits` are not those of their world and view.
    fn new(
        compiled: Arc<CompiledFormula>,
        formula: &Arc<Formula>,
        hits: &[Arc<Hits>],
        parameters: &[f32],
    ) -> Result<Self, Mismatch> {
        let equation = equation_in(formula, &hits.first().ok_or(Mismatch)?.world);
        let textures = StaticTextures::new(&compiled.plan, formula, equation.layout, parameters);
        let pass = |hits: &Arc<Hits>| Ok(Arc::new(StoredPass::new(&compiled, formula, &textures, hits)?));
        let passes = hits.iter().map(pass).collect::<Result<_, _>>()?;
        let leaves = compiled.plan.contribution.leaves(&compiled.plan.bindings.graph, &formula.parameters);
        let of_surface = |plan: &SurfacePlan| plan.outputs.leaves(&plan.bindings.graph, &formula.parameters);
        let surface_leaves = compiled.plan.surface.as_ref().map(of_surface).unwrap_or_default();
        Ok(Self {
            surface_leaves,
            passes,
            textures,
            equation,
            formula: Arc::clone(formula),
            leaves,
            chosen: Mutex::default(),
            compiled,
            scratch: Mutex::default(),
        })
    }

    /// The same with one more pass. The passes so far are shared.
    ///
    /// # Errors
    /// The tiles of `hits` are not those of their world and view, or the view differs in more than the pass.
    fn with_one_more(&self, hits: &Arc<Hits>) -> Result<Self, Mismatch> {
        let own = &self.passes[0].hits;
        if !Arc::ptr_eq(&own.world, &hits.world) || own.view != hits.view.with_pass(own.view.pass()) {
            return Err(Mismatch);
        }
        let pass = StoredPass::new(&self.compiled, &self.formula, &self.textures, hits)?;
        Ok(Self {
            compiled: Arc::clone(&self.compiled),
            formula: Arc::clone(&self.formula),
            passes: self.passes.iter().cloned().chain([Arc::new(pass)]).collect(),
            surface_leaves: self.surface_leaves.clone(),
            textures: self.textures.clone(),
            equation: self.equation,
            leaves: self.leaves.clone(),
            chosen: Mutex::default(),
            scratch: Mutex::default(),
        })
    }

    /// The world that was traced.
    fn world(&self) -> &World {
        &self.passes[0].hits.world
    }

    /// The view of the first pass. Those of the others differ in the pass alone.
    fn view(&self) -> View {
        self.passes[0].hits.view
    }

    /// The hits of the tiles of the first pass.
    fn first_tiles(&self) -> &[Tile] {
        &self.passes[0].hits.tiles
    }

    /// The hits of a tile.
    fn tile_at(&self, place: TilePlace) -> &Tile {
        self.passes[place.pass].tile(place.tile)
    }

    /// The width of the vectors that pictures are made with.
    pub fn width(&self) -> Width {
        self.compiled.width
    }

    /// Draws a tile of the mean of all passes into its part of a framebuffer.
    fn draw_tile(&self, summation: &Summation, parameters: &[f32], tile: usize, scratch: &mut TileScratch, part: Part) {
        self.mean(0..self.passes.len(), tile, scratch, |place, scratch| self.tile(summation, parameters, place, scratch));
        // Kernels have prefetched the first lines after those of the tile.
        let next = summation.columns.lines(TilePlace { pass: 0, tile: tile + 1 });
        let next = next.and_then(|next| next.get(PREFETCH_DISTANCE / size_of::<Line>()..));
        scratch.planes.quantise(0, part, next.unwrap_or_default());
    }

    /// Computes the sum of some passes for a tile, in the planes of the scratch memory. `compute` does it for one pass.
    fn sum_tile(
        &self,
        passes: Range<usize>,
        tile: usize,
        scratch: &mut TileScratch,
        compute: impl Fn(TilePlace, &mut TileScratch),
    ) {
        // Each pass is added as a whole. So the sum is the same if passes are added one by one to a finished picture.
        let pixels = self.first_tiles()[tile].pixels.len();
        let (first, last) = (passes.start, passes.end.saturating_sub(1));
        for pass in passes {
            compute(TilePlace { pass, tile }, scratch);
            if first < last {
                scratch.add_to_total(pass == first, pixels);
            }
        }
        if first < last {
            scratch.take_total();
        }
    }

    /// The same for the mean of the passes.
    fn mean(&self, passes: Range<usize>, tile: usize, scratch: &mut TileScratch, compute: impl Fn(TilePlace, &mut TileScratch)) {
        let count = passes.len();
        self.sum_tile(passes, tile, scratch, compute);
        if count > 1 {
            scratch.planes.scale(1.0 / count as f32, self.first_tiles()[tile].pixels.len());
        }
    }

    fn check_size(&self, framebuffer: &Framebuffer) {
        let view = self.view();
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
        summation.environment = self.equation.sum(Site::Environment, parameters, 0);
        summation.surface = self.surface_summation(parameters, OwnPart::All);
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
        let leaves = parameter_slots(&plan.numbers, &plan.bindings.graph, &self.formula.parameters);
        let numbers = self.uniforms(parameters, kernel, &leaves, self.equation.layout.owners(Owner::Light));
        let bits = |of_pair: &[Splat]| {
            of_pair.iter().enumerate().fold(0, |bits, (index, number)| bits | u32::from(number.value() != 0.0) << index)
        };
        numbers.chunks_exact(plan.conditions.len()).map(bits).collect()
    }

    /// What the formula gives at every hit, for a summation with these parameter numbers.
    fn surface_summation(&self, parameters: &[f32], own: OwnPart) -> Option<SurfaceSummation<'_>> {
        let (plan, compiled) = (self.compiled.plan.surface.as_ref()?, self.compiled.surface.as_ref()?);
        let bodies = self.equation.layout.owners(Owner::Body);
        Some(SurfaceSummation {
            compiled,
            plan,
            passes: self.passes.iter().map(|pass| &*pass.surface).collect(),
            uniforms: self.surface_uniforms(parameters),
            weights: parameter_weights(&self.equation, parameters, bodies),
            own,
            adds_on: None,
        })
    }

    /// The uniform values of each body that the kernel reads for what the formula gives at every hit.
    fn surface_uniforms(&self, parameters: &[f32]) -> Vec<Splat> {
        let uniforms = |surface: &CompiledSurface| self.uniforms(parameters, &surface.outputs.uniforms, &self.surface_leaves, 1);
        self.compiled.surface.as_ref().map(uniforms).unwrap_or_default()
    }

    /// The weights of the paths of a tile as monomials of the moved kr and kt. Where the formula gives weights of rays,
    /// they have their powers only.
    fn monomials(&self, plan: &DragPlan, tile: &Tile, parameters: &[f32]) -> PathMonomials {
        let mut monomials = PathMonomials::new(tile, &plan.equation, parameters, plan.weights);
        if self.compiled.surface.is_some() {
            monomials.fixed.fill(Weight(1.0));
        }
        monomials
    }

    /// Sets `weights` to the weights of all paths of a tile. Where the formula gives weights of rays, they are 1, and
    /// the summation multiplies by the weights of hits.
    fn path_weights(&self, tile: &Tile, parameters: &[f32], weights: &mut Vec<Weight>) {
        if self.compiled.surface.is_none() {
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
        let columns = SummationColumns::Formula(self.passes.iter().map(|pass| &*pass.columns).collect());
        let (environment, surface) = ([0.0; 3], None);
        let radiance = self.passes.iter().map(|pass| &*pass.radiance).collect();
        Summation { sources, uniforms, columns, at_hits, at_misses, environment, radiance, channels, code, surface }
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
            world: self.world(),
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

    /// Computes the pixels of a tile in one pass, in the planes of the scratch memory.
    fn tile(&self, summation: &Summation, parameters: &[f32], place: TilePlace, scratch: &mut TileScratch) {
        let tile = self.tile_at(place);
        self.path_weights(tile, parameters, &mut scratch.weights);
        let program = &self.passes[place.pass].programs[place.tile];
        let mut program = program.lock().unwrap_or_else(PoisonError::into_inner);
        summation.run(tile, place, None, Accumulate::Overwrite, scratch, &mut program);
    }

    /// The uniform values of all pairs of a body and a light, see [`pair_values`].
    fn uniforms(&self, parameters: &[f32], kernel: &Kernel, leaves: &[ParameterSlot], lights: usize) -> Vec<Splat> {
        pair_values(&self.equation.layout, parameters, kernel, leaves, lights).into_iter().map(Splat::new).collect()
    }
}

impl Evaluator for Compiled {
    fn passes(&self) -> usize {
        self.passes.len()
    }

    fn with_pass(&self, hits: &Arc<Hits>) -> Result<Arc<dyn Evaluator>, EvaluateError> {
        Ok(Arc::new(self.with_one_more(hits)?))
    }

    fn sum(&self, passes: Range<usize>, parameters: &[f32], cancelled: &AtomicBool) -> Option<Frame> {
        let view = self.view();
        let mut frame = Frame::black(view.width(), view.height());
        let chosen = self.chosen(parameters);
        let summation = self.whole(parameters, chosen.as_deref());
        let tile_pixels = tile_pixels(view.pixels()) as usize;
        self.each_tile(frame.linear.par_chunks_mut(tile_pixels), |pixels, tile, scratch| {
            if cancelled.load(Ordering::Relaxed) {
                return;
            }
            let compute = |place: TilePlace, scratch: &mut TileScratch| self.tile(&summation, parameters, place, scratch);
            self.sum_tile(passes.clone(), tile, scratch, compute);
            for (index, pixel) in pixels.iter_mut().enumerate() {
                *pixel = scratch.planes.colour(index);
            }
        });
        (!cancelled.load(Ordering::Relaxed)).then_some(frame)
    }

    fn draw(&self, parameters: &[f32], framebuffer: &mut Framebuffer) -> Drawn {
        self.check_size(framebuffer);
        Drawn::timed(|| {
            let chosen = self.chosen(parameters);
            let summation = self.whole(parameters, chosen.as_deref());
            self.each_tile(framebuffer.parts(), |part, tile, scratch| {
                self.draw_tile(&summation, parameters, tile, scratch, part);
            });
        })
    }

    fn drag(
        self: Arc<Self>,
        moved: &[usize],
        parameters: &[f32],
        budget: usize,
        beginning: Option<&DragBeginning>,
    ) -> Result<Box<dyn crate::evaluate::Drag>, EvaluateError> {
        Ok(Box::new(CompiledDrag::new(&self, moved, parameters, budget, beginning)?))
    }

    /// What is stored of the passes, and scratch memory.
    fn bytes(&self) -> usize {
        let scratch = self.scratch.lock().unwrap_or_else(PoisonError::into_inner).len();
        self.passes.iter().map(|pass| pass.bytes()).sum::<usize>() + scratch * TileScratch::BYTES
    }
}
