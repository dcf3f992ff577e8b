//! The summations over the hits that make the stored data of a drag, and the summation for the live part.

use crate::backends::compiled::Compiled;
use crate::backends::compiled::chosen::Chosen;
use crate::backends::compiled::columns::Columns;
use crate::backends::compiled::drag::cells::CellSet;
use crate::backends::compiled::drag::images::Key;
use crate::backends::compiled::drag::reach::{Reach, add_cells};
use crate::backends::compiled::place::TilePlace;
use crate::backends::compiled::source::ContributionSource;
use crate::backends::compiled::summation::Summation;
use crate::backends::compiled::surface::{OwnPart, SurfaceSummation};
use crate::backends::compiled::tile::{Accumulate, TileScratch};
use crate::evaluate::weights::Powers;
use crate::formula::equation::Site;
use crate::jit::compile::{CompiledSlider, Contribution};
use crate::jit::{CompileError, Splat};
use crate::lang::variables::Owner;
use crate::plan::{Channels, ContributionPlan, DragPlan, ImageTerm, Method, ParameterSlot, moved_parameters};
use crate::trace::Tile;
use std::ops::Range;
use std::sync::Arc;

/// The plan of a drag, with the kernels for it.
pub(super) struct DragKernels {
    pub(super) plan: DragPlan,
    pub(super) kernels: Arc<CompiledSlider>,
    /// The parameter numbers that the uniform kernels of the contributions read.
    moving_leaves: Vec<Vec<ParameterSlot>>,
    fixed_leaves: Vec<ParameterSlot>,
    column_leaves: Vec<ParameterSlot>,
}

/// The summations that make the stored data, for some parameter numbers.
pub(super) struct Summations<'p> {
    fixed: Summation<'p>,
    /// What is added to it, where the formula chooses: the part that does not move of the pairs that move.
    fixed_part: Option<Summation<'p>>,
    terms: Vec<Summation<'p>>,
    /// With its uniform values.
    columns: Option<(ContributionSource<'p>, Vec<Splat>)>,
}

impl DragKernels {
    /// Plans and compiles a drag of the numbers with these indices.
    ///
    /// # Errors
    /// The kernels are too large for the code generator.
    pub(super) fn new(compiled: &Compiled, moved: &[usize]) -> Result<Self, CompileError> {
        let layout = &compiled.equation.layout;
        let numbers = moved_parameters(layout, &compiled.formula.parameters, moved);
        let numbers: Vec<_> = numbers.into_iter().map(|(_, id, component)| (id, component)).collect();
        let kernels = compiled.compiled.slider(&numbers)?;
        let surface = compiled.compiled.plan.surface.as_ref();
        let plan = DragPlan::new(&kernels.plan, surface, &compiled.equation, &compiled.formula.parameters, moved);
        let graph = &kernels.plan.separation.bindings.graph;
        let leaves = |plan: &ContributionPlan| plan.leaves(graph, &compiled.formula.parameters);
        let moving_leaves = kernels.plan.moving.iter().map(leaves).collect();
        let [fixed_leaves, column_leaves] =
            [&kernels.plan.fixed, &kernels.plan.columns].map(|plan| plan.as_ref().map(leaves).unwrap_or_default());
        Ok(Self { plan, moving_leaves, fixed_leaves, column_leaves, kernels })
    }

    /// What moves where.
    pub(super) fn reach<'p>(&'p self, compiled: &'p Compiled) -> Reach<'p> {
        Reach { plan: &self.plan, world: compiled.world(), has_fixed: self.plan.slider.fixed.is_some() }
    }

    /// The summations that make the stored data, with the [variants](Compiled::chosen) for these numbers.
    pub(super) fn summations<'p>(
        &'p self,
        compiled: &'p Compiled,
        parameters: &[f32],
        chosen: Option<&'p Chosen>,
    ) -> Summations<'p> {
        let terms = self.plan.terms.iter().map(|term| self.term_summation(compiled, parameters, term)).collect();
        let columns = self.kernels.columns.as_ref();
        let columns = columns.map(|columns| self.moving_source(compiled, parameters, columns, &self.column_leaves));
        let mut fixed = self.fixed_summation(compiled, parameters, chosen);
        let fixed_part = match self.fixed_source(compiled, parameters) {
            Some((source, uniforms)) if chosen.is_none() => {
                fixed.push(source, uniforms);
                None
            }
            // It reads other columns.
            Some((source, uniforms)) => {
                let no_colours = vec![[0.0; 3]; fixed.at_hits.len()];
                let mut part = compiled.empty_summation(no_colours, [0.0; 3], self.plan.channels);
                part.surface = self.surface_summation(compiled, parameters, OwnPart::None);
                part.push(source, uniforms);
                Some(part)
            }
            None => None,
        };
        Summations { fixed, fixed_part, terms, columns }
    }

    /// Everything that does not move, apart from the [fixed part](Self::fixed_source) of the pairs that move.
    fn fixed_summation<'p>(&'p self, compiled: &'p Compiled, parameters: &[f32], chosen: Option<&'p Chosen>) -> Summation<'p> {
        let plan = &self.plan;
        let mut summation = compiled.whole(parameters, chosen);
        for (body, colour) in summation.at_hits.iter_mut().enumerate() {
            *colour = plan.fixed(Site::Hit, parameters, body);
        }
        summation.at_misses = plan.fixed(Site::Miss, parameters, 0);
        summation.environment = plan.fixed(Site::Environment, parameters, 0);
        for source in &mut summation.sources {
            let lights = source.lights;
            for (pair, active) in source.active.iter_mut().enumerate() {
                *active &= !plan.moves_pair(pair / lights, pair % lights);
            }
        }
        summation.channels = plan.channels;
        summation.surface = self.fixed_surface(compiled, parameters);
        summation
    }

    /// The part that does not move of the contributions of the pairs that move.
    fn fixed_source<'p>(&'p self, compiled: &'p Compiled, parameters: &[f32]) -> Option<(ContributionSource<'p>, Vec<Splat>)> {
        let (mut source, uniforms) = compiled.source(parameters, self.kernels.fixed.as_ref()?, &self.fixed_leaves, Channels::All);
        source.active = compiled.active(parameters, |body, light| self.plan.moves_pair(body, light));
        Some((source, uniforms))
    }

    /// What the formula gives at every hit, without the moved kr and kt.
    fn surface_summation<'p>(&self, compiled: &'p Compiled, parameters: &[f32], own: OwnPart) -> Option<SurfaceSummation<'p>> {
        let mut parameters = parameters.to_vec();
        self.plan.weights.into_iter().flatten().for_each(|index| parameters[index] = 1.0);
        compiled.surface_summation(&parameters, own)
    }

    /// The same, with what is given whatever the lights. Of what is linear in a moved number, only the part without it.
    fn fixed_surface<'p>(&self, compiled: &'p Compiled, parameters: &[f32]) -> Option<SurfaceSummation<'p>> {
        match self.plan.terms.iter().any(|term| term.own) {
            true => self.surface_summation(compiled, &self.plan.with_moved(parameters, 0.0), OwnPart::All),
            false => self.surface_summation(compiled, parameters, OwnPart::All),
        }
    }

    /// The same for an image, with what is given times a moved number if that is in it, without the number.
    fn image_surface<'p>(&self, compiled: &'p Compiled, parameters: &[f32], term: &ImageTerm) -> Option<SurfaceSummation<'p>> {
        if !term.own {
            return self.surface_summation(compiled, parameters, OwnPart::None);
        }
        let step = self.own_step(compiled, parameters);
        let others = compiled.surface_uniforms(&self.plan.with_moved(parameters, 0.0));
        let parameters = self.plan.with_moved(parameters, step);
        self.surface_summation(compiled, &parameters, OwnPart::Change(1.0 / step, others))
    }

    /// A moved number, large enough that what it multiplies is known exactly from what is given for it and for 0. It is
    /// a power of two, so that it is an exact factor.
    fn own_step(&self, compiled: &Compiled, parameters: &[f32]) -> f32 {
        let all = &compiled.formula.parameters;
        let sizes = moved_parameters(&compiled.equation.layout, all, &self.plan.moved).into_iter().map(|(index, id, _)| {
            let range = all[id.0 as usize].range.unwrap_or_default();
            range.into_iter().chain([parameters[index]]).map(f32::abs).filter(|size| size.is_finite()).fold(1.0, f32::max)
        });
        sizes.fold(1.0, f32::max).min(1e9).log2().ceil().exp2()
    }

    /// The image of a term.
    fn term_summation<'p>(&'p self, compiled: &'p Compiled, parameters: &[f32], term: &ImageTerm) -> Summation<'p> {
        let plan = &self.plan;
        let bodies = 0..compiled.equation.layout.owners(Owner::Body);
        let at_hits = bodies.map(|body| plan.image_colour(term, Site::Hit, parameters, body)).collect();
        let at_misses = plan.image_colour(term, Site::Miss, parameters, 0);
        let mut summation = compiled.empty_summation(at_hits, at_misses, plan.channels);
        summation.environment = plan.image_colour(term, Site::Environment, parameters, 0);
        summation.surface = self.image_surface(compiled, parameters, term);
        if let Some(index) = term.contribution
            && let Some(contribution) = self.kernels.moving.get(index)
        {
            let (source, uniforms) = self.moving_source(compiled, parameters, contribution, &self.moving_leaves[index]);
            summation.push(source, uniforms);
        }
        summation
    }

    /// A contribution of the pairs that move. Where the weight of a light moves, its present value does not matter.
    fn moving_source<'p>(
        &self,
        compiled: &'p Compiled,
        parameters: &[f32],
        contribution: &'p Contribution,
        leaves: &[ParameterSlot],
    ) -> (ContributionSource<'p>, Vec<Splat>) {
        let plan = &self.plan;
        let (mut source, uniforms) = compiled.source(parameters, contribution, leaves, plan.moving_channels());
        let lights = source.lights;
        for (pair, active) in source.active.iter_mut().enumerate() {
            let (body, light) = (pair / lights, pair % lights);
            *active = plan.may_be_on(parameters, light) && plan.moves_pair(body, light);
        }
        (source, uniforms)
    }

    /// The summation for the live part, for the parameter numbers of a frame.
    pub(super) fn live_summation<'p>(&'p self, compiled: &'p Compiled, parameters: &[f32]) -> Option<Summation<'p>> {
        let plan = &self.plan;
        let (contribution, leaves) = match plan.method {
            Method::Specialised => (self.kernels.moving.first()?, self.moving_leaves.first()?),
            Method::Images | Method::General => return None,
        };
        let (mut source, uniforms) = compiled.source(parameters, contribution, leaves, plan.moving_channels());
        source.active = compiled.active(parameters, |body, light| plan.moves_pair(body, light));
        let bodies = 0..compiled.equation.layout.owners(Owner::Body);
        let at_hits = bodies.clone().map(|body| plan.moving(Site::Hit, parameters, body)).collect();
        let mut summation = compiled.empty_summation(at_hits, [0.0; 3], plan.channels);
        let surface = compiled.surface_summation(parameters, OwnPart::None);
        let lights = compiled.equation.layout.owners(Owner::Light);
        let adds = |body: usize| plan.moves_hits(body) || (0..lights).any(|light| plan.moves_pair(body, light));
        let adds_on = bodies.map(adds).collect();
        summation.surface = surface.map(|surface| SurfaceSummation { adds_on: Some(adds_on), ..surface });
        summation.push(source, uniforms);
        Some(summation)
    }
}

impl Summations<'_> {
    /// Makes the sum of some passes of the image of this key for a tile, in the planes of the scratch memory. Returns
    /// the cells in which it may differ from 0. `None` if a weight of a path is not bounded: then the picture is not a
    /// sum of images.
    pub(super) fn make_image(
        &self,
        drag: &DragPasses,
        key: Key,
        passes: Range<usize>,
        tile: usize,
        scratch: &mut TileScratch,
    ) -> Option<CellSet> {
        let DragPasses { compiled, plan, parameters } = *drag;
        let reach = Reach { plan, world: compiled.world(), has_fixed: plan.slider.fixed.is_some() };
        let mut touched = CellSet::none(compiled.first_tiles()[tile].pixels.len());
        let mut accumulate = Accumulate::Overwrite;
        for pass in passes {
            let place = TilePlace { pass, tile };
            let own = compiled.tile_at(place);
            compiled.monomials(plan, own, parameters).of(key.powers, &mut scratch.weights);
            match usize::from(key.term).checked_sub(1) {
                Some(term) => self.terms[term].run_once(own, place, accumulate, scratch),
                None => self.add_fixed(own, place, accumulate, scratch),
            }
            if scratch.is_unbounded() {
                return None;
            }
            accumulate = Accumulate::Add;
            for group in own.groups.iter().filter(|group| reach.emitters_of(group, key.term).is_some()) {
                add_cells(own, own.spans_of(group), &scratch.weights, &mut touched);
            }
            if reach.has_misses(key.term) {
                for span in own.misses.iter().filter(|span| !scratch.weights[span.path.index()].is_zero()) {
                    touched.add(own.miss_segments_of(span));
                }
            }
        }
        Some(touched)
    }

    /// Makes the mean of all passes of the image of everything that does not move, in the planes of the scratch memory.
    /// Returns whether a weight of a path was not bounded.
    pub(super) fn make_base(&self, drag: &DragPasses, tile: usize, scratch: &mut TileScratch) -> bool {
        let DragPasses { compiled, plan, parameters } = *drag;
        let mut accumulate = Accumulate::Overwrite;
        let mut is_unbounded = false;
        for pass in 0..compiled.passes.len() {
            let place = TilePlace { pass, tile };
            let own = compiled.tile_at(place);
            compiled.monomials(plan, own, parameters).of(Powers::default(), &mut scratch.weights);
            self.add_fixed(own, place, accumulate, scratch);
            is_unbounded |= scratch.is_unbounded();
            accumulate = Accumulate::Add;
        }
        if compiled.passes.len() > 1 {
            scratch.planes.scale(1.0 / compiled.passes.len() as f32, compiled.first_tiles()[tile].pixels.len());
        }
        is_unbounded
    }

    /// Adds everything that does not move to the planes, or sets them to it.
    fn add_fixed(&self, tile: &Tile, place: TilePlace, accumulate: Accumulate, scratch: &mut TileScratch) {
        self.fixed.run_once(tile, place, accumulate, scratch);
        if let Some(part) = &self.fixed_part {
            part.run_once(tile, place, Accumulate::Add, scratch);
        }
    }

    /// The values that the live part reads from columns, for each record of a tile.
    pub(super) fn columns(&self, compiled: &Compiled, place: TilePlace) -> Option<Columns> {
        let columns = |(source, uniforms): &(ContributionSource, Vec<Splat>)| {
            Columns::for_drag(compiled.tile_at(place), &compiled.passes[place.pass].columns[place.tile], source, uniforms)
        };
        self.columns.as_ref().map(columns)
    }
}

/// What the stored data of a drag is made for.
#[derive(Clone, Copy)]
pub(super) struct DragPasses<'d> {
    pub(super) compiled: &'d Compiled,
    pub(super) plan: &'d DragPlan,
    /// The parameter numbers before the drag.
    pub(super) parameters: &'d [f32],
}
