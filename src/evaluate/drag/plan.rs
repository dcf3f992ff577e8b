//! What a drag has to do: what moves, what it reaches, and what each frame adds up or multiplies.

mod passes;
mod steps;

use crate::evaluate::compiled::{Compiled, Place, places_of};
use crate::evaluate::drag::Method;
use crate::evaluate::drag::cells::{CellSet, Factor};
use crate::evaluate::drag::images::Key;
use crate::evaluate::framebuffer::Channels;
use crate::evaluate::pass::Pass;
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

pub(super) use passes::Passes;
pub(super) use steps::{Step, Work};

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

impl Plan {
    /// Finds out what moves with the numbers at these places.
    ///
    /// # Errors
    /// Kernels for it are beyond what the code generator takes.
    pub(super) fn new(compiled: &Compiled, moved: &[usize]) -> Result<Self, CompileError> {
        let layout = &compiled.layout;
        let found: Vec<(usize, (Owner, usize, usize))> =
            moved.iter().filter_map(|place| Some((*place, layout.owner_of(*place)?))).collect();
        let owners: BTreeSet<(Owner, usize)> = found.iter().map(|(_, (owner, index, _))| (*owner, *index)).collect();
        let single = owners.len() == 1;
        let (owner, index) = owners.into_iter().next().unwrap_or((Owner::Global, 0));
        let numbers: Vec<(usize, ParameterId, u8)> = found
            .iter()
            .filter_map(|(place, (owner, _, slot))| {
                let (id, component) = compiled.number_at(*owner, *slot)?;
                Some((*place, id, component))
            })
            .collect();
        let kernels = compiled.compiled.drag(&numbers.iter().map(|(_, id, component)| (*id, *component)).collect::<Vec<_>>())?;
        let mut bindings = kernels.separation.bindings.clone();
        let leaves: Vec<(NodeId, usize)> =
            numbers.iter().map(|(place, id, component)| (bindings.parameter(*id, *component), *place)).collect();

        let places = &compiled.places;
        let slot_moves = |of: Owner, slot: usize| of == owner && found.iter().any(|(_, (_, _, moved))| *moved == slot);
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

    /// Whether anything that moves may be seen in a group of hits.
    fn moves_group(&self, group: &Group) -> bool {
        let body = group.body.index();
        self.moves_ambient(body) || group.lights.iter().any(|light| self.moves_pair(body, light.index()))
    }

    /// What the kernels for what moves yield.
    fn moving_channels(&self) -> Channels {
        match *self.kernels.channels {
            [channel] => Channels::One(channel),
            _ => Channels::All,
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

    /// What the paths of a tile weigh, whatever the moved kr and kt are.
    fn path_weights(&self, compiled: &Compiled, tile: &Tile, memory: &[f32]) -> PathWeights {
        let mut resting = memory.to_vec();
        [self.kr, self.kt].into_iter().flatten().for_each(|place| resting[place] = 1.0);
        let mut weights = Vec::new();
        compiled.path_weights(tile, &resting, &mut weights);
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
        PathWeights { resting: weights, counts }
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

    /// What is live, for the numbers of a frame.
    pub(super) fn live_pass<'p>(&'p self, compiled: &'p Compiled, memory: &[f32]) -> Option<Pass<'p>> {
        let (contributor, leaves) = match self.method {
            Method::Specialised => (self.kernels.moving.first()?, self.moving_leaves.first()?),
            Method::Images | Method::General => return None,
        };
        let (mut source, uniforms) = compiled.source_of(memory, contributor, leaves, self.moving_channels());
        source.active = compiled.active(memory, |body, light| self.moves_pair(body, light));
        let ambient = |body: usize| match self.moves_ambient(body) {
            true => only(compiled.ambient(body, memory), self.ambient_moves),
            false => [0.0; 3],
        };
        let mut pass = compiled.nothing((0..compiled.layout.owners(Owner::Body)).map(ambient).collect(), [0.0; 3], self.channels);
        pass.push(source, uniforms);
        Some(pass)
    }

    /// The cells of a tile in which something is live.
    pub(super) fn live_cells(&self, compiled: &Compiled, tile: &Tile, memory: &[f32]) -> Vec<u16> {
        let mut weights = Vec::new();
        self.path_weights(compiled, tile, memory).of(Key::default(), &mut weights);
        let mut cells = CellSet::none(tile.pixels.len());
        for group in tile.groups.iter().filter(|group| self.moves_group(group)) {
            add_live(tile, tile.spans_of(group), &weights, &mut cells);
        }
        cells.cells()
    }
}

/// The weights of the paths of a tile as polynomials in the moved kr and kt.
struct PathWeights {
    /// Without the moved kr and kt.
    resting: Vec<Weight>,
    /// How often each path has them in its weight.
    counts: Vec<(u8, u8)>,
}

impl PathWeights {
    /// The weights for an image with this key: 0 for paths that have the moved kr and kt more often in them, or less.
    fn of(&self, key: Key, weights: &mut Vec<Weight>) {
        let wanted = (key.reflections, key.refractions);
        let paths = self.resting.iter().zip(&self.counts);
        weights.clear();
        weights.extend(paths.map(|(weight, counts)| if *counts == wanted { *weight } else { Weight(0.0) }));
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

/// Adds the cells of spans of hits whose weight is not 0.
fn add_live(tile: &Tile, spans: &[Span], weights: &[Weight], cells: &mut CellSet) {
    for span in spans.iter().filter(|span| !weights[span.path.index()].is_zero()) {
        cells.add(tile.segments_of(span));
    }
}
