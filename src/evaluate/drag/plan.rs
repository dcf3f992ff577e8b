//! What a drag has to do: what moves, what it reaches, and by which passes over the hits what is kept comes about.

use crate::evaluate::columns::Columns;
use crate::evaluate::compiled::{Compiled, Place, places_of};
use crate::evaluate::drag::Method;
use crate::evaluate::drag::cells::{CellSet, Factor};
use crate::evaluate::drag::images::Key;
use crate::evaluate::framebuffer::Channels;
use crate::evaluate::pass::{Onto, Pass, Source, Workroom};
use crate::evaluate::planes::Weight;
use crate::formula::ParameterId;
use crate::formula::binding::Bindings;
use crate::formula::graph::NodeId;
use crate::formula::separation::Dependence;
use crate::jit::CompileError;
use crate::jit::compile::{Contributor, DragKernels};
use crate::lang::scalars::flush;
use crate::lang::variables::Owner;
use crate::trace::{Edge, Group, Span, Tile};
use std::collections::BTreeSet;
use std::sync::Arc;

/// More images of a tile than this are not kept.
const MOST_IMAGES: usize = 40;

/// What a drag has to do.
pub(super) struct Plan {
    method: Method,
    channels: Channels,
    owner: Owner,
    index: usize,
    /// The places of the numbers that move.
    moved: Vec<usize>,
    /// The graph in which the factors of terms are.
    bindings: Bindings,
    /// The numbers that nodes of moved parameters stand for.
    leaves: Vec<(NodeId, usize)>,
    terms: Vec<PlanTerm>,
    /// The places of kr and kt, where they move.
    kr: Option<usize>,
    kt: Option<usize>,
    ambient: Ambient,
    /// Which components of the ambient light and of the background move.
    ambient_moves: [bool; 3],
    background_moves: [bool; 3],
    kernels: Arc<DragKernels>,
    /// Where the uniform leaves of the contributors lie.
    moving_leaves: Vec<Vec<Place>>,
    resting_leaves: Vec<Place>,
    kept_leaves: Vec<Place>,
}

/// What the images of a term are multiplied with, and what is in them.
struct PlanTerm {
    factors: [Option<NodeId>; 3],
    /// Which of the moving contributors.
    contributor: Option<usize>,
    ambient: bool,
    background: bool,
}

/// How the ambient light ka · Cd · Ia moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ambient {
    Rests,
    /// Components of the colour of one body.
    BodyColour,
    Weight,
    /// Components of the colour of the ambient light.
    LightColour,
}

/// Something that is made for a tile before the drag is quick there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Work {
    /// Columns of what is kept for each record.
    Kept,
    /// An image.
    Image(Key),
    /// What rests. It is the last.
    Base,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Step {
    pub(super) work: Work,
    /// About how long it takes, in units of adding a block to the pixels, which is about half of evaluating it
    /// for a light.
    pub(super) cost: u64,
}

/// The passes that make what is kept, for the numbers at hand.
pub(super) struct Passes<'p> {
    base: Pass<'p>,
    terms: Vec<Pass<'p>>,
    kept: Option<Source<'p>>,
}

impl Plan {
    /// Finds out what moves with the numbers at these places.
    ///
    /// # Errors
    /// Kernels for it are beyond what the code generator takes.
    pub(super) fn new(compiled: &Compiled, moved: &[usize]) -> Result<Self, CompileError> {
        let layout = &compiled.layout;
        let owners: BTreeSet<(Owner, usize)> =
            moved.iter().filter_map(|place| layout.owner_of(*place)).map(|(owner, index, _)| (owner, index)).collect();
        let slots: Vec<(usize, usize)> =
            moved.iter().filter_map(|place| layout.owner_of(*place).map(|(_, _, slot)| (*place, slot))).collect();
        let single = owners.len() == 1;
        let (owner, index) = owners.into_iter().next().unwrap_or((Owner::Global, 0));
        let numbers: Vec<(usize, ParameterId, u8)> = slots
            .iter()
            .filter_map(|(place, slot)| compiled.number_at(owner, *slot).map(|(id, component)| (*place, id, component)))
            .collect();
        let kernels = compiled.compiled.drag(&numbers.iter().map(|(_, id, component)| (*id, *component)).collect::<Vec<_>>())?;
        let mut bindings = kernels.separation.bindings.clone();
        let leaves: Vec<(NodeId, usize)> =
            numbers.iter().map(|(place, id, component)| (bindings.parameter(*id, *component), *place)).collect();

        let places = &compiled.places;
        let slot_moves = |of: Owner, slot: usize| of == owner && slots.iter().any(|(_, moved)| *moved == slot);
        let node_of = |of: Owner, slot: usize| {
            let place = (of == owner).then(|| layout.row(owner, index) + slot)?;
            leaves.iter().find(|(_, moved)| *moved == place).map(|(node, _)| *node)
        };
        let components = |of: Owner, slot: usize| [0, 1, 2].map(|component| node_of(of, slot + component));
        let place_of = |slot: usize| slot_moves(Owner::Body, slot).then(|| layout.row(owner, index) + slot);
        let (kr, kt) = (place_of(places.kr), place_of(places.kt));
        let body_colour = components(Owner::Body, places.body_colour);
        let ambient_colour = components(Owner::Global, places.ambient_colour);
        let background_colour = components(Owner::Global, places.background);
        let moves = |colour: [Option<NodeId>; 3]| colour.iter().any(Option::is_some);
        let mut ambient = Ambient::Rests;
        let mut ambient_ways = 0;
        for (way, moves) in [
            (Ambient::BodyColour, moves(body_colour)),
            (Ambient::Weight, slot_moves(Owner::Global, places.ka)),
            (Ambient::LightColour, moves(ambient_colour)),
        ] {
            if moves {
                ambient = way;
                ambient_ways += 1;
            }
        }
        let ambient_factors = match ambient {
            Ambient::Rests => [None; 3],
            Ambient::BodyColour => body_colour,
            Ambient::Weight => [node_of(Owner::Global, places.ka); 3],
            Ambient::LightColour => ambient_colour,
        };

        let mut terms: Vec<PlanTerm> = Vec::new();
        let mut method = Method::Images;
        match &kernels.separation.dependence {
            Dependence::None => {}
            Dependence::Separable(separable) => {
                let term = |(place, term): (usize, &crate::formula::separation::Term)| PlanTerm {
                    factors: term.factors,
                    contributor: Some(place),
                    ambient: false,
                    background: false,
                };
                terms.extend(separable.iter().enumerate().map(term));
            }
            Dependence::Live { .. } => method = Method::Specialised,
        }
        if method == Method::Images && ambient != Ambient::Rests {
            match terms.iter_mut().find(|term| term.factors == ambient_factors) {
                Some(term) => term.ambient = true,
                None => terms.push(PlanTerm { factors: ambient_factors, contributor: None, ambient: true, background: false }),
            }
        }
        let background = moves(background_colour);
        if background {
            terms.push(PlanTerm { factors: background_colour, contributor: None, ambient: false, background: true });
        }
        let weights_move = kr.is_some() || kt.is_some();
        let live = method == Method::Specialised;
        // More than one owner, two factors of the ambient light, or weights and a live part at a time: no slider moves them so.
        if !single || ambient_ways > 1 || live && (weights_move || background) {
            method = Method::General;
        }
        let mut channels: BTreeSet<usize> = kernels.channels.iter().copied().collect();
        channels.extend((0..3).filter(|channel| ambient_factors[*channel].is_some() || background_colour[*channel].is_some()));
        let channels = match channels.first() {
            Some(channel) if channels.len() == 1 && !weights_move => Channels::One(*channel),
            _ => Channels::All,
        };
        let leaves_of = |contributor: &Contributor| {
            places_of(&kernels.separation.bindings, &compiled.parameters, &contributor.uniform_leaves)
        };
        let moving_leaves = kernels.moving.iter().map(leaves_of).collect();
        let resting_leaves = kernels.resting.as_ref().map(leaves_of).unwrap_or_default();
        let kept_leaves = kernels.kept.as_ref().map(leaves_of).unwrap_or_default();
        let mut moved = moved.to_vec();
        moved.sort_unstable();
        Ok(Self {
            method,
            channels,
            owner,
            index,
            moved,
            bindings,
            leaves,
            terms,
            kr,
            kt,
            ambient,
            ambient_moves: ambient_factors.map(|factor| factor.is_some()),
            background_moves: background_colour.map(|factor| factor.is_some()),
            kernels,
            moving_leaves,
            resting_leaves,
            kept_leaves,
        })
    }

    pub(super) fn method(&self) -> Method {
        self.method
    }

    pub(super) fn channels(&self) -> Channels {
        self.channels
    }

    /// Whether two arrays of parameter numbers differ in nothing but what moves.
    pub(super) fn same_rest(&self, one: &[f32], other: &[f32]) -> bool {
        let rests = |place: usize| self.moved.binary_search(&place).is_err();
        one.len() == other.len()
            && one.iter().zip(other).enumerate().all(|(place, (a, b))| a.to_bits() == b.to_bits() || !rests(place))
    }

    /// Whether the contributions of a pair of a body and a light move.
    fn moves_pair(&self, body: usize, light: usize) -> bool {
        self.kernels.separation.dependence != Dependence::None
            && match self.owner {
                Owner::Global => true,
                Owner::Body => body == self.index,
                Owner::Light => light == self.index,
            }
    }

    /// Whether the ambient light of a body moves.
    fn moves_ambient(&self, body: usize) -> bool {
        match self.ambient {
            Ambient::Rests => false,
            Ambient::BodyColour => body == self.index,
            Ambient::Weight | Ambient::LightColour => true,
        }
    }

    /// The values of kr, kt and the factors of all terms.
    pub(super) fn factors(&self, memory: &[f32]) -> Factors {
        let number = |place: usize| flush(memory[place]);
        let leaf = |id: NodeId| self.leaves.iter().find(|(node, _)| *node == id).map_or(0.0, |(_, place)| number(*place));
        let wanted: Vec<NodeId> = self.terms.iter().flat_map(|term| term.factors).flatten().collect();
        let mut values = self.bindings.graph.evaluate(&wanted, leaf).into_iter();
        let terms = self.terms.iter().map(|term| term.factors.map(|factor| factor.map_or(0.0, |_| values.next().unwrap_or(0.0))));
        let weight = |place: Option<usize>| place.map_or(1.0, |place| f64::from(number(place)));
        Factors { terms: terms.collect(), kr: weight(self.kr), kt: weight(self.kt) }
    }

    /// What an image is multiplied with.
    pub(super) fn factor(&self, key: Key, factors: &Factors) -> Factor {
        let weight = factors.kr.powi(key.reflections.into()) * factors.kt.powi(key.refractions.into());
        let term = if key.term == 0 { [1.0; 3] } else { factors.terms[usize::from(key.term) - 1] };
        Factor(term.map(|component| (weight * f64::from(component)) as f32))
    }

    /// How often the weight of each path has the moved kr and kt in it.
    fn counts(&self, compiled: &Compiled, tile: &Tile) -> Vec<(u8, u8)> {
        let mut counts: Vec<(u8, u8)> = Vec::with_capacity(tile.paths.len());
        for path in &tile.paths {
            counts.push(match compiled.last_factor(tile, path) {
                // A path has at most as many steps as the depth.
                Some((parent, place)) => {
                    let (reflections, refractions) = counts[parent];
                    let moves = |moved: Option<usize>| u8::from(moved == Some(place));
                    match path.edge {
                        Edge::Reflected => (reflections + moves(self.kr), refractions),
                        Edge::Refracted | Edge::Primary => (reflections, refractions + moves(self.kt)),
                    }
                }
                None => (0, 0),
            });
        }
        counts
    }

    /// The weights of the paths of a tile without the moved kr and kt; 0 for those in which they are not as often as in the key.
    fn weights(&self, compiled: &Compiled, tile: &Tile, memory: &[f32], key: Key, weights: &mut Vec<Weight>) {
        let mut resting = memory.to_vec();
        [self.kr, self.kt].into_iter().flatten().for_each(|place| resting[place] = 1.0);
        compiled.path_weights(tile, &resting, weights);
        for (weight, counts) in weights.iter_mut().zip(self.counts(compiled, tile)) {
            if counts != (key.reflections, key.refractions) {
                *weight = Weight(0.0);
            }
        }
    }

    /// About what a full evaluation of a tile costs.
    fn tile_cost(tile: &Tile) -> u64 {
        let groups: u64 = tile.groups.iter().map(|group| group_cost(group.lights.len(), group.blocks.len())).sum();
        groups + tile.miss_blocks.len() as u64 + pixels_cost(tile)
    }

    /// About what a full evaluation costs, in the units of [`Step::cost`].
    pub(super) fn full_cost(&self, compiled: &Compiled) -> u64 {
        compiled.hits.tiles.iter().map(Self::tile_cost).sum()
    }

    /// What has to be made for a tile; nothing where nothing that moves is seen in it.
    pub(super) fn steps(&self, compiled: &Compiled, place: usize, memory: &[f32]) -> Vec<Step> {
        let tile = &compiled.hits.tiles[place];
        let mut weights = Vec::new();
        let combinations: BTreeSet<(u8, u8)> = self.counts(compiled, tile).into_iter().collect();
        let mut steps = Vec::new();
        for (reflections, refractions) in combinations {
            for term in 0..=self.terms.len() {
                // Terms are far fewer than 256.
                let key = Key { reflections, refractions, term: term as u8 };
                if key.is_base() {
                    continue;
                }
                self.weights(compiled, tile, memory, key, &mut weights);
                let mut cost = 0;
                for group in &tile.groups {
                    let lights = self.reached(group, term);
                    if let Some(lights) = lights {
                        cost += group_cost(lights, live_blocks(&group.spans, &weights));
                    }
                }
                if self.has_background(term) {
                    cost += live_blocks(&tile.misses, &weights) as u64;
                }
                if cost > 0 {
                    steps.push(Step { work: Work::Image(key), cost: cost + pixels_cost(tile) });
                }
            }
        }
        if self.method == Method::Specialised {
            self.weights(compiled, tile, memory, Key::default(), &mut weights);
            let moving = |group: &&Group| {
                let lit = group.lights.iter().any(|light| self.moves_pair(group.body.index(), light.index()));
                lit || self.moves_ambient(group.body.index())
            };
            let blocks = tile.groups.iter().filter(moving).map(|group| live_blocks(&group.spans, &weights));
            if blocks.sum::<usize>() == 0 {
                return Vec::new();
            }
            steps.clear();
            if self.kernels.kept.is_some() {
                let cost = tile.groups.iter().filter(moving).map(|group| group_cost(group.lights.len(), group.blocks.len()));
                steps.push(Step { work: Work::Kept, cost: cost.sum() });
            }
            steps.push(Step { work: Work::Base, cost: Self::tile_cost(tile) });
        } else if steps.len() > MOST_IMAGES {
            // Too many to be worth it; the base alone means the general way.
            return vec![Step { work: Work::Base, cost: 0 }];
        } else if !steps.is_empty() {
            steps.push(Step { work: Work::Base, cost: Self::tile_cost(tile) });
        }
        steps
    }

    /// How many lights of a group an image of this term (0: none) takes in; none where the group is not in it at all.
    fn reached(&self, group: &Group, term: usize) -> Option<usize> {
        let body = group.body.index();
        let moved = group.lights.iter().filter(|light| self.moves_pair(body, light.index())).count();
        let Some(term) = term.checked_sub(1).map(|term| &self.terms[term]) else {
            // What rests: of moved pairs too, as far as something rests in them.
            return Some(group.lights.len() - if self.kernels.resting.is_some() { 0 } else { moved });
        };
        let lights = if term.contributor.is_some() { moved } else { 0 };
        (lights > 0 || term.ambient && self.moves_ambient(body)).then_some(lights)
    }

    fn has_background(&self, term: usize) -> bool {
        match term.checked_sub(1) {
            Some(term) => self.terms[term].background,
            None => self.background_moves != [true; 3],
        }
    }

    /// The passes that make what is kept.
    pub(super) fn passes<'p>(&'p self, compiled: &'p Compiled, memory: &[f32]) -> Passes<'p> {
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
            let mut source = compiled.source_of(memory, resting, &self.resting_leaves, Channels::All);
            source.active = compiled.active(memory, |body, light| self.moves_pair(body, light));
            whole.sources.push(source);
        }
        whole.channels = self.channels;
        whole
    }

    /// The part that rests of a term.
    fn term_pass<'p>(&'p self, compiled: &'p Compiled, memory: &[f32], term: &PlanTerm) -> Pass<'p> {
        let mut pass = Pass {
            sources: Vec::new(),
            lights: compiled.layout.owners(Owner::Light),
            ambient: vec![[0.0; 3]; compiled.layout.owners(Owner::Body)],
            background: [0.0; 3],
            channels: self.channels,
        };
        if let Some((contributor, leaves)) =
            term.contributor.and_then(|place| Some((self.kernels.moving.get(place)?, &self.moving_leaves[place])))
        {
            pass.sources.push(self.moving_source(compiled, memory, contributor, leaves));
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
    ) -> Source<'p> {
        let channels = match *self.kernels.channels {
            [channel] => Channels::One(channel),
            _ => Channels::All,
        };
        let mut source = compiled.source_of(memory, contributor, leaves, channels);
        let bright = |light: usize| {
            let place = compiled.layout.row(Owner::Light, light) + compiled.places.ki;
            self.moved.binary_search(&place).is_ok() || flush(memory[place]) != 0.0
        };
        let lights = compiled.layout.owners(Owner::Light);
        for (pair, active) in source.active.iter_mut().enumerate() {
            let (body, light) = (pair / lights, pair % lights);
            *active = bright(light) && self.moves_pair(body, light);
        }
        source
    }

    /// What is live, for the numbers of a frame.
    pub(super) fn live_pass<'p>(&'p self, compiled: &'p Compiled, memory: &[f32]) -> Option<Pass<'p>> {
        let (contributor, leaves) = match self.method {
            Method::Specialised => (self.kernels.moving.first()?, self.moving_leaves.first()?),
            Method::Images | Method::General => return None,
        };
        let channels = match *self.kernels.channels {
            [channel] => Channels::One(channel),
            _ => Channels::All,
        };
        let mut source = compiled.source_of(memory, contributor, leaves, channels);
        source.active = compiled.active(memory, |body, light| self.moves_pair(body, light));
        let ambient = |body: usize| match self.moves_ambient(body) {
            true => only(compiled.ambient(body, memory), self.ambient_moves),
            false => [0.0; 3],
        };
        Some(Pass {
            sources: vec![source],
            lights: compiled.layout.owners(Owner::Light),
            ambient: (0..compiled.layout.owners(Owner::Body)).map(ambient).collect(),
            background: [0.0; 3],
            channels: self.channels,
        })
    }

    /// The cells of a tile in which something is live.
    pub(super) fn live_cells(&self, compiled: &Compiled, tile: &Tile, memory: &[f32]) -> Vec<u16> {
        let mut weights = Vec::new();
        self.weights(compiled, tile, memory, Key::default(), &mut weights);
        let mut cells = CellSet::none(tile.pixels.len());
        for group in &tile.groups {
            let body = group.body.index();
            if self.moves_ambient(body) || group.lights.iter().any(|light| self.moves_pair(body, light.index())) {
                add_live(tile, &group.spans, &weights, &mut cells);
            }
        }
        cells.cells()
    }
}

impl Passes<'_> {
    /// Adds up the image of this key in the workroom; the cells in which it may differ from 0.
    pub(super) fn add_image(
        &self,
        plan: &Plan,
        compiled: &Compiled,
        memory: &[f32],
        key: Key,
        place: usize,
        workroom: &mut Workroom,
    ) -> CellSet {
        let tile = &compiled.hits.tiles[place];
        plan.weights(compiled, tile, memory, key, &mut workroom.weights);
        let term = usize::from(key.term);
        let pass = match term.checked_sub(1) {
            Some(term) => &self.terms[term],
            None => &self.base,
        };
        pass.add(tile, place, None, Onto::Black, workroom);
        let mut touched = CellSet::none(tile.pixels.len());
        for group in tile.groups.iter().filter(|group| plan.reached(group, term).is_some()) {
            add_live(tile, &group.spans, &workroom.weights, &mut touched);
        }
        if plan.has_background(term) {
            for span in tile.misses.iter().filter(|span| !workroom.weights[span.path.index()].is_zero()) {
                touched.add(tile.misses_of(span));
            }
        }
        touched
    }

    /// Adds up what rests in the workroom.
    pub(super) fn add_base(&self, plan: &Plan, compiled: &Compiled, memory: &[f32], place: usize, workroom: &mut Workroom) {
        let tile = &compiled.hits.tiles[place];
        plan.weights(compiled, tile, memory, Key::default(), &mut workroom.weights);
        self.base.add(tile, place, None, Onto::Black, workroom);
    }

    /// What is kept for each record of a tile.
    pub(super) fn kept_columns(&self, compiled: &Compiled, place: usize) -> Option<Columns> {
        let tile = &compiled.hits.tiles[place];
        self.kept.as_ref().map(|source| Columns::kept(tile, place, source, compiled.layout.owners(Owner::Light)))
    }
}

/// What moves in a frame, worked out.
pub(super) struct Factors {
    terms: Vec<[f32; 3]>,
    kr: f64,
    kt: f64,
}

/// A colour with some of its components 0.
fn only(colour: [f32; 3], wanted: [bool; 3]) -> [f32; 3] {
    [0, 1, 2].map(|component| if wanted[component] { colour[component] } else { 0.0 })
}

/// The blocks of spans whose weight is not 0.
fn live_blocks(spans: &[Span], weights: &[Weight]) -> usize {
    spans.iter().filter(|span| !weights[span.path.index()].is_zero()).map(|span| span.blocks.len()).sum()
}

/// Adds the cells of spans of hits whose weight is not 0.
fn add_live(tile: &Tile, spans: &[Span], weights: &[Weight], cells: &mut CellSet) {
    for span in spans.iter().filter(|span| !weights[span.path.index()].is_zero()) {
        cells.add(tile.blocks_of(&span.blocks));
    }
}

/// What so many blocks of a group cost for so many lights: their evaluation, and adding them to pixels.
fn group_cost(lights: usize, blocks: usize) -> u64 {
    (blocks * (2 * lights + 1)) as u64
}

/// What clearing and reading the pixels of a tile costs.
fn pixels_cost(tile: &Tile) -> u64 {
    tile.pixels.len() as u64 / 4
}
