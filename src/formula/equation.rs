//! Equation (2) of the thesis (4.2.3) as data: the terms that a lit record, a hit, or a ray that leaves the scene adds
//! to a pixel, and the weights of child rays.
//!
//! ```text
//! E(hit)  = Σ_lit lights ki · local  +  ka · Cd · Ia  +  kr · E(reflected)  +  kt · E(refracted)
//! E(miss) = background  +  ki · IL · radiance of the environment
//! ```
//!
//! The lit lights are those that reach the hit, or all if the formula reads `visible`. The interpreter, the compiled
//! code, drags and the inspector all read this table. Which lights reach a hit is not decided here.

use crate::formula::layout::Layout;
use crate::formula::{Formula, SurfaceTerms};
use crate::lang::scalars::{Floats, Scalars, flush};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::variables::{Owner, Predefined};

/// Where a term is added.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Site {
    /// For each light for which the formula is evaluated at a hit.
    LitRecord,
    /// At each hit, whatever the lights.
    Hit,
    /// Where a ray leaves the scene.
    Miss,
    /// The same, if the scene has an environment: the term is multiplied by the radiance from there.
    Environment,
}

/// The colour of a term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Colour {
    /// The value of the user's formula for a lit record.
    Formula,
    /// A product of vector parameters, one number for red, green and blue each.
    Parameters(&'static [Predefined]),
}

/// A term: a product of a scalar weight and a colour. If the weight is 0, the term is exactly 0, even if the colour is
/// infinite or NaN.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct EquationTerm {
    /// Its name in reports.
    pub name: &'static str,
    /// Where it is added.
    pub site: Site,
    /// The scalar parameter that is its weight. `None`: 1.
    pub weight: Option<Predefined>,
    /// The colour.
    pub colour: Colour,
    /// The term that a formula may give in its place.
    pub replaced_by: Option<SurfaceTerm>,
}

/// The terms, in the order in which they are added up.
pub const TERMS: [EquationTerm; 4] = [
    EquationTerm {
        name: "local",
        site: Site::LitRecord,
        weight: Some(Predefined::Intensity),
        colour: Colour::Formula,
        replaced_by: None,
    },
    EquationTerm {
        name: "ambient",
        site: Site::Hit,
        weight: Some(Predefined::Ambient),
        colour: Colour::Parameters(&[Predefined::BodyColour, Predefined::AmbientColour]),
        replaced_by: Some(SurfaceTerm::Ambient),
    },
    EquationTerm {
        name: "background",
        site: Site::Miss,
        weight: None,
        colour: Colour::Parameters(&[Predefined::Background]),
        replaced_by: None,
    },
    EquationTerm {
        name: "environment",
        site: Site::Environment,
        weight: Some(Predefined::Intensity),
        colour: Colour::Parameters(&[Predefined::LightColour]),
        replaced_by: None,
    },
];

/// The weight of the reflected ray of a hit, a parameter of the body.
pub const REFLECTED: Predefined = Predefined::Reflection;
/// The weight of the refracted ray of a hit, a parameter of the body.
pub const REFRACTED: Predefined = Predefined::Refraction;

/// The parameter that is the weight of a ray where the formula does not give one.
pub fn weight_parameter(weight: SurfaceTerm) -> Option<Predefined> {
    match weight {
        SurfaceTerm::Reflected => Some(REFLECTED),
        SurfaceTerm::Refracted => Some(REFRACTED),
        SurfaceTerm::Ambient | SurfaceTerm::Emission => None,
    }
}

impl EquationTerm {
    /// The terms of a site, in their order.
    pub fn at(site: Site) -> impl Iterator<Item = &'static EquationTerm> {
        TERMS.iter().filter(move |term| term.site == site)
    }

    /// The parameters whose product the term is: first the weight, then the colours. The formula is not included.
    pub fn factors(&self) -> impl Iterator<Item = Predefined> + use<> {
        let colours = match self.colour {
            Colour::Formula => &[],
            Colour::Parameters(colours) => colours,
        };
        self.weight.into_iter().chain(colours.iter().copied())
    }

    /// The product of the weight and the colours. `value` gives their values, a scalar three times. The term of the
    /// formula gives its weight only.
    pub fn product(&self, value: impl Fn(Predefined) -> [f32; 3]) -> [f32; 3] {
        let multiply = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|component| Floats.mul(a[component], b[component]));
        let colour = match self.colour {
            Colour::Formula => [1.0; 3],
            Colour::Parameters(colours) => colours.iter().map(|colour| value(*colour)).reduce(multiply).unwrap_or([1.0; 3]),
        };
        self.weight.map_or(colour, |weight| weighed(value(weight)[0], colour))
    }
}

impl EquationTerm {
    /// The product of the weight, the colours and a radiance.
    pub fn product_with(&self, value: impl Fn(Predefined) -> [f32; 3], radiance: [f32; 3]) -> [f32; 3] {
        let colour = EquationTerm { weight: None, ..*self }.product(&value);
        let colour = std::array::from_fn(|component| Floats.mul(colour[component], radiance[component]));
        self.weight.map_or(colour, |weight| weighed(value(weight)[0], colour))
    }
}

/// A weighted colour. It is exactly 0 if the weight is 0.
pub fn weighed(weight: f32, colour: [f32; 3]) -> [f32; 3] {
    colour.map(|component| if weight == 0.0 { 0.0 } else { Floats.mul(weight, component) })
}

/// A colour weighted by components. It is exactly 0 if the weight is 0 in all components.
pub fn weighed_by(weight: [f32; 3], colour: [f32; 3]) -> [f32; 3] {
    if weight == [0.0; 3] {
        return [0.0; 3];
    }
    std::array::from_fn(|component| Floats.mul(weight[component], colour[component]))
}

/// The indices of the predefined parameters in the parameter numbers of a formula on a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Equation {
    /// The rows of the owners.
    pub layout: Layout,
    /// The first slot of each predefined parameter in the row of its owner, in the order of the table.
    slots: [usize; Predefined::ALL.len()],
    /// The terms that the formula gives.
    pub surface: SurfaceTerms,
    /// The index of the light that is the environment, if there is one.
    pub environment: Option<usize>,
}

impl Equation {
    /// The equation of a formula on a scene with this many bodies and lights.
    pub fn new(formula: &Formula, bodies: usize, lights: usize) -> Self {
        let mut slots = [0; Predefined::ALL.len()];
        for predefined in Predefined::ALL {
            slots[*predefined as usize] = formula.parameter(formula.predefined(*predefined)).slot as usize;
        }
        Self { layout: Layout::new(formula, bodies, lights), slots, surface: formula.surface, environment: None }
    }

    /// The same on a scene whose environment is the light with this index.
    #[must_use]
    pub fn with_environment(self, environment: Option<usize>) -> Self {
        Self { environment, ..self }
    }

    /// Whether a term is part of the equation: the scene has what it needs, and the formula does not give another in
    /// its place.
    pub fn has(&self, term: &EquationTerm) -> bool {
        (term.site != Site::Environment || self.environment.is_some())
            && term.replaced_by.is_none_or(|surface| self.surface.get(surface).is_none())
    }

    /// The slot of a component of a predefined parameter in the row of its owner.
    pub fn slot(&self, predefined: Predefined, component: usize) -> usize {
        self.slots[predefined as usize] + component
    }

    /// The index of the first number of a predefined parameter, for the owner with index `owner` (0 for globals).
    pub fn index(&self, predefined: Predefined, owner: usize) -> usize {
        self.layout.row(predefined.owner(), owner) + self.slot(predefined, 0)
    }

    /// The value of a predefined parameter for the owner with index `owner`. A scalar is repeated three times.
    pub fn value(&self, parameters: &[f32], predefined: Predefined, owner: usize) -> [f32; 3] {
        let first = self.index(predefined, owner);
        let last = predefined.ty().slots() - 1;
        [0, 1, 2].map(|component: usize| flush(parameters[first + component.min(last)]))
    }

    /// The value of a term without the formula at a hit on a body. The value at a miss does not depend on the body. The
    /// radiance of the environment is left out.
    pub fn term(&self, term: &EquationTerm, parameters: &[f32], body: usize) -> [f32; 3] {
        term.product(|factor| self.value(parameters, factor, self.owner_of(factor, body)))
    }

    /// The index of the owner of a factor of a term without the formula, at a hit on a body or at a miss. The only
    /// light of such terms is the environment.
    pub fn owner_of(&self, factor: Predefined, body: usize) -> usize {
        owner_index(factor, body, self.environment.unwrap_or(0))
    }

    /// The weight of the lit records of this light. If it is 0, the light adds nothing.
    pub fn light_weight(&self, parameters: &[f32], light: usize) -> f32 {
        let weights = EquationTerm::at(Site::LitRecord).filter_map(|term| term.weight);
        weights.map(|weight| self.value(parameters, weight, owner_index(weight, 0, light))[0]).fold(1.0, |a, b| a * b)
    }

    /// The sum of the terms of a site without those that the formula gives.
    pub fn sum(&self, site: Site, parameters: &[f32], body: usize) -> [f32; 3] {
        let terms = EquationTerm::at(site).filter(|term| self.has(term)).map(|term| self.term(term, parameters, body));
        terms.reduce(|a, b| std::array::from_fn(|component| Floats.add(a[component], b[component]))).unwrap_or_default()
    }
}

/// The index of the owner of a parameter at a hit of this body, for this light.
pub fn owner_index(predefined: Predefined, body: usize, light: usize) -> usize {
    match predefined.owner() {
        Owner::Global => 0,
        Owner::Body => body,
        Owner::Light => light,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weight_of_zero_leaves_nothing() {
        let ambient = EquationTerm::at(Site::Hit).next().unwrap();
        let value = |weight: f32| {
            let known = [
                (Predefined::Ambient, [weight; 3]),
                (Predefined::BodyColour, [f32::INFINITY, 0.5, f32::NAN]),
                (Predefined::AmbientColour, [1.0, 0.25, 1.0]),
            ];
            move |factor: Predefined| known.iter().find(|(known, _)| *known == factor).unwrap().1
        };
        assert_eq!(ambient.product(value(0.0)), [0.0; 3]);
        let [red, green, blue] = ambient.product(value(2.0));
        assert_eq!((red, green, blue.is_nan()), (f32::INFINITY, 0.25, true));
    }

    #[test]
    fn every_parameter_of_the_equation_is_in_one_term_or_weighs_a_ray() {
        let terms = TERMS.iter().filter(|term| term.site != Site::Environment);
        let mut factors: Vec<Predefined> = terms.flat_map(EquationTerm::factors).chain([REFLECTED, REFRACTED]).collect();
        factors.sort_unstable();
        // The formula uses the colour of a light. The environment is a light too.
        let mut all: Vec<Predefined> = Predefined::ALL.iter().copied().filter(|one| *one != Predefined::LightColour).collect();
        all.sort_unstable();
        assert_eq!(factors, all);
        let environment: Vec<Predefined> = EquationTerm::at(Site::Environment).flat_map(EquationTerm::factors).collect();
        assert_eq!(environment, [Predefined::Intensity, Predefined::LightColour]);
    }
}
