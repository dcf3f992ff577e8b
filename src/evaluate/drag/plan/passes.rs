//! The passes over the hits by which what a drag keeps comes about.

use crate::evaluate::columns::Columns;
use crate::evaluate::compiled::{Compiled, Place};
use crate::evaluate::drag::cells::CellSet;
use crate::evaluate::drag::images::Key;
use crate::evaluate::drag::plan::{Ambient, Plan, PlanTerm, add_live, only};
use crate::evaluate::framebuffer::Channels;
use crate::evaluate::pass::{Onto, Pass, Source, Workroom};
use crate::jit::Splat;
use crate::jit::compile::Contributor;
use crate::lang::scalars::flush;
use crate::lang::variables::Owner;

/// The passes that make what is kept, for the numbers at hand.
pub(in crate::evaluate::drag) struct Passes<'p> {
    base: Pass<'p>,
    terms: Vec<Pass<'p>>,
    /// With its uniform values.
    kept: Option<(Source<'p>, Vec<Splat>)>,
}

impl Plan {
    /// The passes that make what is kept.
    pub(in crate::evaluate::drag) fn passes<'p>(&'p self, compiled: &'p Compiled, memory: &[f32]) -> Passes<'p> {
        let terms = self.terms.iter().map(|term| self.term_pass(compiled, memory, term)).collect();
        let kept = self.kernels.kept.as_ref().map(|kept| self.moving_source(compiled, memory, kept, &self.kept_leaves));
        Passes { base: self.base_pass(compiled, memory), terms, kept }
    }

    /// What rests.
    fn base_pass<'p>(&'p self, compiled: &'p Compiled, memory: &[f32]) -> Pass<'p> {
        let mut whole = compiled.whole(memory);
        for (body, ambient) in whole.ambient.iter_mut().enumerate() {
            if self.moves_ambient(body) {
                *ambient = only(*ambient, self.ambient_moves.map(|moves| !moves));
            }
        }
        whole.background = only(whole.background, self.background_moves.map(|moves| !moves));
        for source in &mut whole.sources {
            source.active = compiled.active(memory, |body, light| !self.moves_pair(body, light));
        }
        if let Some(resting) = &self.kernels.resting {
            let (mut source, uniforms) = compiled.source_of(memory, resting, &self.resting_leaves, Channels::All);
            source.active = compiled.active(memory, |body, light| self.moves_pair(body, light));
            whole.push(source, uniforms);
        }
        whole.channels = self.channels;
        whole
    }

    /// The part that rests of a term.
    fn term_pass<'p>(&'p self, compiled: &'p Compiled, memory: &[f32], term: &PlanTerm) -> Pass<'p> {
        let mut pass = compiled.nothing(vec![[0.0; 3]; compiled.layout.owners(Owner::Body)], [0.0; 3], self.channels);
        if let Some((contributor, leaves)) =
            term.contributor.and_then(|place| Some((self.kernels.moving.get(place)?, &self.moving_leaves[place])))
        {
            let (source, uniforms) = self.moving_source(compiled, memory, contributor, leaves);
            pass.push(source, uniforms);
        }
        let present = term.factors.map(|factor| factor.is_some());
        if term.ambient {
            for (body, ambient) in pass.ambient.iter_mut().enumerate().filter(|(body, _)| self.moves_ambient(*body)) {
                let [weight, colour, light] = compiled.ambient_factors(body, memory);
                let [one, other] = match self.ambient {
                    Ambient::Rests | Ambient::BodyColour => [weight, light],
                    Ambient::Weight => [colour, light],
                    Ambient::LightColour => [weight, colour],
                };
                *ambient = only([0, 1, 2].map(|component| one[component] * other[component]), present);
            }
        }
        if term.background {
            pass.background = only([1.0; 3], present);
        }
        pass
    }

    /// A source for pairs that move. Where the intensity of a light moves, it does not matter what it is at present.
    fn moving_source<'p>(
        &self,
        compiled: &'p Compiled,
        memory: &[f32],
        contributor: &'p Contributor,
        leaves: &[Place],
    ) -> (Source<'p>, Vec<Splat>) {
        let (mut source, uniforms) = compiled.source_of(memory, contributor, leaves, self.moving_channels());
        let bright = |light: usize| {
            let place = compiled.layout.row(Owner::Light, light) + compiled.places.ki;
            self.moved.binary_search(&place).is_ok() || flush(memory[place]) != 0.0
        };
        let lights = source.lights;
        for (pair, active) in source.active.iter_mut().enumerate() {
            let (body, light) = (pair / lights, pair % lights);
            *active = bright(light) && self.moves_pair(body, light);
        }
        (source, uniforms)
    }
}

impl Passes<'_> {
    /// Adds up the image of this key in the workroom; the cells in which it may differ from 0.
    pub(in crate::evaluate::drag) fn add_image(
        &self,
        plan: &Plan,
        compiled: &Compiled,
        memory: &[f32],
        key: Key,
        place: usize,
        workroom: &mut Workroom,
    ) -> CellSet {
        let tile = &compiled.hits.tiles[place];
        plan.path_weights(compiled, tile, memory).of(key, &mut workroom.weights);
        let term = usize::from(key.term);
        let pass = match term.checked_sub(1) {
            Some(term) => &self.terms[term],
            None => &self.base,
        };
        pass.add_once(tile, place, Onto::Black, workroom);
        let mut touched = CellSet::none(tile.pixels.len());
        for group in tile.groups.iter().filter(|group| plan.reached(group, term).is_some()) {
            add_live(tile, tile.spans_of(group), &workroom.weights, &mut touched);
        }
        if plan.has_background(term) {
            for span in tile.misses.iter().filter(|span| !workroom.weights[span.path.index()].is_zero()) {
                touched.add(tile.miss_segments_of(span));
            }
        }
        touched
    }

    /// Adds up what rests in the workroom.
    pub(in crate::evaluate::drag) fn add_base(
        &self,
        plan: &Plan,
        compiled: &Compiled,
        memory: &[f32],
        place: usize,
        workroom: &mut Workroom,
    ) {
        let tile = &compiled.hits.tiles[place];
        plan.path_weights(compiled, tile, memory).of(Key::default(), &mut workroom.weights);
        self.base.add_once(tile, place, Onto::Black, workroom);
    }

    /// What is kept for each record of a tile.
    pub(in crate::evaluate::drag) fn kept_columns(&self, compiled: &Compiled, place: usize) -> Option<Columns> {
        let tile = &compiled.hits.tiles[place];
        let kept = |(source, uniforms): &(Source, Vec<Splat>)| Columns::kept(tile, &compiled.columns[place], source, uniforms);
        self.kept.as_ref().map(kept)
    }
}
