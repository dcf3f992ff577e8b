//! The plan of a drag: which terms move with the slider, and how a picture is computed from images that do not move.

use crate::formula::binding::Bindings;
use crate::formula::equation::{Equation, EquationTerm, REFLECTED, REFRACTED, Site, TERMS, owner_index};
use crate::formula::graph::NodeId;
use crate::formula::separation::{Dependence, SeparableTerm};
use crate::formula::{Parameter, ParameterId};
use crate::lang::scalars::flush;
use crate::lang::variables::{Owner, Predefined};
use crate::plan::slider::{SliderPlan, moved_parameters};
use crate::plan::surface::{OwnDependence, SurfacePlan};
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

/// How pictures of a drag are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// As weighted sums of images.
    Images,
    /// By a kernel for the part that moves, and an image of everything else.
    Specialised,
    /// In full, like any picture.
    General,
}

impl Method {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Method::Images => "images",
            Method::Specialised => "specialised",
            Method::General => "general",
        }
    }
}

/// Which components of colours are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channels {
    /// Red, green and blue.
    All,
    /// One of them: 0 red, 1 green, 2 blue.
    One(usize),
}

impl Channels {
    /// The components, a range within 0..3.
    pub fn components(self) -> Range<usize> {
        match self {
            Channels::All => 0..3,
            Channels::One(component) => component..component + 1,
        }
    }
}

/// A term of equation (2) that moves without the formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MovedTerm {
    /// Its index in the table of terms.
    pub term: usize,
    /// The factor that moves.
    pub factor: Predefined,
    /// Whether red, green and blue of the term move.
    pub components: [bool; 3],
}

/// The factors of the images of a term, and the contents of the images.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageTerm {
    /// The factor of each component, a node of the graph of [`DragPlan::bindings`]; `None` where the image has no such
    /// component.
    pub factors: [Option<NodeId>; 3],
    /// The contribution that is in the image: its index in [`SliderPlan::moving`].
    pub contribution: Option<usize>,
    /// The terms without the formula that are in the image, each without its moved factor: indices in
    /// [`DragPlan::moved_terms`].
    pub moved_terms: Vec<usize>,
    /// Whether the ambient light and the emission that the formula gives are in the image, without the moved factor.
    pub own: bool,
}

/// How pictures are computed from the numbers that a slider moves, on one scene.
///
/// With [`Method::Images`] a picture is `Σ_ij kr^i · kt^j · (fixed_ij + Σ_terms factor · image_ij)`. Here kr and kt
/// are those that move, if any, and the images of (i, j) hold the paths that have these powers in their weight. With
/// [`Method::Specialised`] a picture is the fixed image, plus the only contribution of [`SliderPlan::moving`], plus
/// the moved terms.
#[derive(Debug, Clone)]
pub struct DragPlan {
    /// How pictures are made.
    pub method: Method,
    /// The components of colours that move.
    pub channels: Channels,
    /// The kernels.
    pub slider: Arc<SliderPlan>,
    /// Where the parameters of equation (2) lie.
    pub equation: Equation,
    /// The owner whose numbers move: its kind and its index.
    pub owner: (Owner, usize),
    /// The indices in the layout of the numbers that move, in ascending order.
    pub moved: Vec<usize>,
    /// The graph that the factors of terms belong to.
    pub bindings: Bindings,
    /// The numbers that the leaves of factors stand for.
    leaves: Vec<(NodeId, usize)>,
    /// The terms of a picture by images, without the fixed image.
    pub terms: Vec<ImageTerm>,
    /// The terms of equation (2) without the formula that move.
    pub moved_terms: Vec<MovedTerm>,
    /// The indices in the layout of the moved kr and kt, if they move.
    pub weights: [Option<usize>; 2],
}

/// The factors of a picture: those of each image term, and the moved kr and kt (1 if they do not move).
#[derive(Debug, Clone, PartialEq)]
pub struct Factors {
    /// Red, green and blue of each of [`DragPlan::terms`]; 0 where its image has no such component.
    pub terms: Vec<[f32; 3]>,
    /// The moved kr, usually 0 to 1.
    pub kr: f64,
    /// The moved kt, usually 0 to 1.
    pub kt: f64,
}

impl DragPlan {
    /// Plans a drag of the numbers with these indices. `slider` is the plan for the [parameters](moved_parameters) that
    /// they belong to.
    pub fn new(
        slider: &Arc<SliderPlan>,
        surface: Option<&SurfacePlan>,
        equation: &Equation,
        parameters: &[Parameter],
        moved: &[usize],
    ) -> Self {
        let layout = &equation.layout;
        let owners: BTreeSet<(Owner, usize)> =
            moved.iter().filter_map(|index| layout.owner_of(*index)).map(|(owner, index, _)| (owner, index)).collect();
        let single = owners.len() == 1;
        let owner = owners.into_iter().next().unwrap_or((Owner::Global, 0));
        let mut bindings = slider.separation.bindings.clone();
        let mut leaf = |(index, id, component): (usize, ParameterId, u8)| (bindings.parameter(id, component), index);
        let moved_ids = moved_parameters(layout, parameters, moved);
        let ids: Vec<ParameterId> = moved_ids.iter().map(|(_, id, _)| *id).collect();
        let leaves: Vec<(NodeId, usize)> = moved_ids.iter().copied().map(&mut leaf).collect();
        let node_at = |index: usize| leaves.iter().find(|(_, moved)| *moved == index).map(|(node, _)| *node);
        let found = moving_terms(equation, owner, node_at);
        let weight_index = |weight: Predefined| {
            let index = (owner.0 == weight.owner()).then(|| equation.index(weight, owner.1))?;
            node_at(index).map(|_| index)
        };
        let (weights, powers_only) = match surface {
            None => ([REFLECTED, REFRACTED].map(weight_index), true),
            Some(surface) => weights_by_formula(surface, &ids, weight_index),
        };
        let numbers: Vec<(ParameterId, u8)> = moved_ids.iter().map(|(_, id, component)| (*id, *component)).collect();
        let own = surface.map_or(OwnDependence::None, |surface| surface.own_dependence(&numbers));
        let inseparable = matches!(slider.separation.dependence, Dependence::Inseparable { .. });
        let (own_factors, own_is_simple) = match own {
            OwnDependence::None => (None, true),
            OwnDependence::Linear(numbers) => {
                let mut node = |(id, component)| bindings.parameter(id, component);
                // With a weight that moves, what is given would have its powers too.
                (Some(numbers.map(|number| number.map(&mut node))), !inseparable && weights == [None; 2])
            }
            OwnDependence::Other => (None, false),
        };
        let terms = if inseparable { Vec::new() } else { image_terms(&slider.separation.dependence, &found, own_factors) };
        // Today no slider moves more than one owner, or two factors of one term. The general method handles that. An
        // inseparable part has no powers of kr and kt, and is not visible where a ray leaves the scene.
        let twice = found.windows(2).any(|pair| pair[0].0.term == pair[1].0.term);
        let weights_move = weights.iter().any(Option::is_some);
        let at_misses = found.iter().any(|(moved, _)| is_of_miss(TERMS[moved.term].site));
        let method = match inseparable {
            _ if !powers_only || !own_is_simple || !single || twice || inseparable && (weights_move || at_misses) => {
                Method::General
            }
            true => Method::Specialised,
            false => Method::Images,
        };
        let mut channels: BTreeSet<usize> = slider.channels.iter().copied().collect();
        channels.extend((0..3).filter(|channel| found.iter().any(|(moved, _)| moved.components[*channel])));
        channels.extend((0..3).filter(|channel| own_factors.is_some_and(|factors| factors[*channel].is_some())));
        let channels = match channels.first() {
            Some(channel) if channels.len() == 1 && !weights_move => Channels::One(*channel),
            _ => Channels::All,
        };
        let mut moved = moved.to_vec();
        moved.sort_unstable();
        let moved_terms = found.into_iter().map(|(moved, _)| moved).collect();
        let (slider, equation) = (Arc::clone(slider), *equation);
        Self { method, channels, slider, equation, owner, moved, bindings, leaves, terms, moved_terms, weights }
    }

    /// Whether two arrays of parameter numbers have the same length, and differ only in numbers that move. Bits are
    /// compared.
    pub fn same_fixed(&self, one: &[f32], other: &[f32]) -> bool {
        let fixed = |index: usize| self.moved.binary_search(&index).is_err();
        one.len() == other.len()
            && one.iter().zip(other).enumerate().all(|(index, (a, b))| a.to_bits() == b.to_bits() || !fixed(index))
    }

    /// Parameter numbers with this number in place of each that moves.
    pub fn with_moved(&self, parameters: &[f32], number: f32) -> Vec<f32> {
        let mut numbers = parameters.to_vec();
        self.moved.iter().for_each(|index| numbers[*index] = number);
        numbers
    }

    /// Whether the formula moves for a pair of a body and a light, given by their indices.
    pub fn moves_pair(&self, body: usize, light: usize) -> bool {
        let (owner, index) = self.owner;
        self.slider.separation.dependence != Dependence::None
            && match owner {
                Owner::Global => true,
                Owner::Body => body == index,
                Owner::Light => light == index,
            }
    }

    /// Whether the weight of a light moves.
    pub fn moves_light_weight(&self, light: usize) -> bool {
        let mut weights = EquationTerm::at(Site::LitRecord).filter_map(|term| term.weight);
        weights.any(|weight| self.moved.binary_search(&self.equation.index(weight, owner_index(weight, 0, light))).is_ok())
    }

    /// Whether a light adds anything with these numbers, or may while its weight moves.
    ///
    /// # Panics
    /// Where there are fewer numbers than the layout has.
    pub fn may_be_on(&self, parameters: &[f32], light: usize) -> bool {
        self.moves_light_weight(light) || flush(self.equation.light_weight(parameters, light)) != 0.0
    }

    /// Whether a term without the formula moves at the hits of a body.
    pub fn moves_at(&self, moved: &MovedTerm, body: usize) -> bool {
        moved.factor.owner() != Owner::Body || self.owner == (Owner::Body, body)
    }

    /// Whether anything but the contributions of lights moves at the hits of a body.
    pub fn moves_hits(&self, body: usize) -> bool {
        self.moved_at(Site::Hit).any(|moved| self.moves_at(moved, body))
            || self.terms.iter().any(|term| term.own) && self.moves_own(body)
    }

    /// Whether what the formula gives at hits of a body, whatever the lights, reads moved numbers if it reads any.
    pub fn moves_own(&self, body: usize) -> bool {
        self.owner.0 == Owner::Global || self.owner == (Owner::Body, body)
    }

    /// The terms without the formula that move at a site.
    pub fn moved_at(&self, site: Site) -> impl Iterator<Item = &MovedTerm> {
        self.moved_terms.iter().filter(move |moved| TERMS[moved.term].site == site)
    }

    /// The components that the kernels of moving contributions compute.
    pub fn moving_channels(&self) -> Channels {
        match *self.slider.channels {
            [channel] => Channels::One(channel),
            _ => Channels::All,
        }
    }

    /// The factors of the picture of these parameter numbers: red, green and blue for each term, and kr and kt.
    ///
    /// # Panics
    /// Where there are fewer numbers than the layout has.
    pub fn factors(&self, parameters: &[f32]) -> Factors {
        let number = |index: usize| flush(parameters[index]);
        let leaf = |id: NodeId| self.leaves.iter().find(|(node, _)| *node == id).map_or(0.0, |(_, index)| number(*index));
        let wanted: Vec<NodeId> = self.terms.iter().flat_map(|term| term.factors).flatten().collect();
        let mut values = self.bindings.graph.evaluate(&wanted, leaf).into_iter();
        let terms = self.terms.iter().map(|term| term.factors.map(|factor| factor.map_or(0.0, |_| values.next().unwrap_or(0.0))));
        let [kr, kt] = self.weights.map(|index| index.map_or(1.0, |index| f64::from(number(index))));
        Factors { terms: terms.collect(), kr, kt }
    }

    /// The sum of the terms of a site without the formula at the hits of a body, in linear RGB, not clamped. Components
    /// that move are left out. At misses, the body has no meaning.
    ///
    /// # Panics
    /// Where there are fewer numbers than the layout has.
    pub fn fixed(&self, site: Site, parameters: &[f32], body: usize) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for (index, term) in TERMS.iter().enumerate().filter(|(_, term)| term.site == site && self.equation.has(term)) {
            let moved = self.moved_terms.iter().find(|moved| moved.term == index && self.moves_at(moved, body));
            let colour = self.equation.term(term, parameters, body);
            add(&mut sum, colour, |component| moved.is_none_or(|moved| !moved.components[component]));
        }
        sum
    }

    /// The same sum, of the components that move.
    ///
    /// # Panics
    /// Where there are fewer numbers than the layout has.
    pub fn moving(&self, site: Site, parameters: &[f32], body: usize) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for moved in self.moved_at(site).filter(|moved| self.moves_at(moved, body)) {
            let colour = self.equation.term(&TERMS[moved.term], parameters, body);
            add(&mut sum, colour, |component| moved.components[component]);
        }
        sum
    }

    /// The colour of an image term at the hits of a body, or at misses, in linear RGB, without its contribution: the
    /// moved terms without their moved factor.
    ///
    /// # Panics
    /// Where there are fewer numbers than the layout has.
    pub fn image_colour(&self, term: &ImageTerm, site: Site, parameters: &[f32], body: usize) -> [f32; 3] {
        let mut sum = [0.0; 3];
        let moved_terms = term.moved_terms.iter().map(|index| &self.moved_terms[*index]);
        for moved in moved_terms.filter(|moved| TERMS[moved.term].site == site && self.moves_at(moved, body)) {
            let value = |factor: Predefined| match factor == moved.factor {
                true => [1.0; 3],
                false => self.equation.value(parameters, factor, self.equation.owner_of(factor, body)),
            };
            add(&mut sum, TERMS[moved.term].product(value), |component| moved.components[component]);
        }
        sum
    }
}

/// The indices of the moved kr and kt where the formula gives weights of rays, and whether these depend on the moved
/// parameters through powers of kr and kt along paths alone.
fn weights_by_formula(
    surface: &SurfacePlan,
    moved: &[ParameterId],
    index: impl Fn(Predefined) -> Option<usize>,
) -> ([Option<usize>; 2], bool) {
    let parameters = [REFLECTED, REFRACTED];
    // Predefined parameters come first, in the order of their table.
    let ids = parameters.map(|parameter| ParameterId(parameter as u32));
    let others: Vec<ParameterId> = moved.iter().copied().filter(|id| !ids.contains(id)).collect();
    let mut powers_only = true;
    let mut weights = [None; 2];
    for (weight, parameter) in parameters.into_iter().enumerate() {
        powers_only &= !surface.weight_depends_on(weight, &others);
        let given = surface.nodes.weights[weight].is_some();
        for (number, id) in ids.into_iter().enumerate().filter(|(_, id)| moved.contains(id)) {
            match surface.power_in_weight(weight, id) {
                Some(0) if given => {}
                Some(1) if number == weight => weights[weight] = index(parameter),
                Some(_) if !given && number == weight => weights[weight] = index(parameter),
                Some(0) => {}
                Some(_) | None => powers_only = false,
            }
        }
    }
    (weights, powers_only)
}

/// Whether terms of this site are added where rays leave the scene.
pub fn is_of_miss(site: Site) -> bool {
    match site {
        Site::Miss | Site::Environment => true,
        Site::LitRecord | Site::Hit => false,
    }
}

/// Adds the wanted components of a colour.
fn add(sum: &mut [f32; 3], colour: [f32; 3], wanted: impl Fn(usize) -> bool) {
    for component in (0..3).filter(|component| wanted(*component)) {
        sum[component] += colour[component];
    }
}

/// The terms without the formula that move, with the nodes of their moved factors, in the order of the table.
fn moving_terms(
    equation: &Equation,
    (owner, index): (Owner, usize),
    node_at: impl Fn(usize) -> Option<NodeId>,
) -> Vec<(MovedTerm, [Option<NodeId>; 3])> {
    let mut found = Vec::new();
    let is_plain = |term: &EquationTerm| term.site != Site::LitRecord;
    for (number, term) in TERMS.iter().enumerate().filter(|(_, term)| is_plain(term) && equation.has(term)) {
        // The factors of a light are those of the environment.
        let concerns =
            |factor: &Predefined| factor.owner() == owner && (owner != Owner::Light || equation.environment == Some(index));
        for factor in term.factors().filter(concerns) {
            let last = factor.ty().slots() - 1;
            let first = equation.index(factor, index);
            let nodes = [0, 1, 2].map(|component: usize| node_at(first + component.min(last)));
            if nodes.iter().any(Option::is_some) {
                found.push((MovedTerm { term: number, factor, components: nodes.map(|node| node.is_some()) }, nodes));
            }
        }
    }
    found
}

/// The terms of a picture by images: those of the contribution, moved terms of equation (2), and what the formula gives
/// at hits, with these moved factors. Terms with the same factors share an image.
fn image_terms(
    dependence: &Dependence,
    found: &[(MovedTerm, [Option<NodeId>; 3])],
    own_factors: Option<[Option<NodeId>; 3]>,
) -> Vec<ImageTerm> {
    let separable = match dependence {
        Dependence::Separable(terms) => &terms[..],
        Dependence::None | Dependence::Inseparable { .. } => &[],
    };
    let term = |(contribution, term): (usize, &SeparableTerm)| ImageTerm {
        contribution: Some(contribution),
        ..ImageTerm::empty(term.factors)
    };
    let mut terms: Vec<ImageTerm> = separable.iter().enumerate().map(term).collect();
    for (index, (_, factors)) in found.iter().enumerate() {
        ImageTerm::with(&mut terms, *factors).moved_terms.push(index);
    }
    if let Some(factors) = own_factors {
        ImageTerm::with(&mut terms, factors).own = true;
    }
    terms
}

impl ImageTerm {
    /// One with these factors, and nothing in its image.
    fn empty(factors: [Option<NodeId>; 3]) -> Self {
        Self { factors, contribution: None, moved_terms: Vec::new(), own: false }
    }

    /// That with these factors among some, added if there is none.
    fn with(terms: &mut Vec<ImageTerm>, factors: [Option<NodeId>; 3]) -> &mut ImageTerm {
        let index = terms.iter().position(|term| term.factors == factors).unwrap_or_else(|| {
            terms.push(Self::empty(factors));
            terms.len() - 1
        });
        &mut terms[index]
    }
}
