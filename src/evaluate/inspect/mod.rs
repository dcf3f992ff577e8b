//! The inspector explains one pixel: its tree of rays with bodies, angles and lights, what each of them adds, and the
//! formula with its numbers.
//!
//! The inspector traces the pixel itself and needs no stored hits. It adds numbers up in the same order as the
//! interpreter, so the total of a pixel is the same. The result is plain data ([`Inspection`]);
//! [`text`](Inspector::text) writes it for a terminal. Nothing is kept.
//!
//! An inspection is of one pass. `passes` has the colours of a pixel in several passes, and their mean.

mod figures;
mod instance;
mod nan;
mod passes;
mod report;
#[cfg(test)]
mod tests;
mod text;

pub use figures::{Quantity, figures, vector_figures, weight_figures};
pub use instance::{Instance, InstanceLine};
pub use nan::{NanCause, NanOrigin};
pub use passes::PassColours;
pub use report::{
    Crossing, End, InspectedEnvironment, InspectedHit, InspectedLight, InspectedMiss, InspectedRay, Inspection, Onward,
    Visibility,
};
pub use text::left_out;

use crate::evaluate::at_point::term_values;
use crate::evaluate::equation_in;
use crate::formula::equation::{Equation, EquationTerm, Site, weighed, weighed_by, weight_parameter};
use crate::formula::{Formula, ParameterId};
use crate::lang::scalars::{Floats, Scalars, flush};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::variables::{Owner, Predefined, Variable};
use crate::scene::{BodyId, LightId};
use crate::trace::{Child, CoordinatesUse, Edge, HitVariables, LightVariables, RayNode, Tracer, Tree, View, ray_tree, variable};
use crate::world::{EmitterId, Ray, Side, World};
use glam::DVec3;
use std::sync::{Arc, OnceLock};

/// A formula on a scene, with the values of its parameters.
#[derive(Debug)]
pub struct Inspector<'i> {
    formula: &'i Formula,
    world: &'i World,
    equation: Equation,
    parameters: &'i [f32],
    /// The formula that backends evaluate, if it is not that of the user.
    weighted: OnceLock<Option<Arc<Formula>>>,
}

/// The light for which a formula is evaluated, and what it sends as a factor of `IL`.
#[derive(Clone, Copy)]
struct InspectedSource {
    light: LightId,
    radiance: [f32; 3],
}

/// A ray whose end has not been visited yet.
struct PendingChild {
    child: Child,
    edge: Edge,
    parent: Option<usize>,
    depth: u32,
    ray: Ray,
    factor: [f32; 3],
    weight: [f64; 3],
}

impl<'i> Inspector<'i> {
    /// An inspector of `formula` in `world` with these parameter numbers, see
    /// [`Evaluator::frame`](crate::evaluate::Evaluator::frame).
    ///
    /// # Panics
    /// Where there are fewer numbers than the [`Layout`](crate::formula::layout::Layout) of formula and scene has.
    pub fn new(formula: &'i Formula, world: &'i World, parameters: &'i [f32]) -> Self {
        let equation = equation_in(formula, world);
        assert!(parameters.len() >= equation.layout.len(), "as many parameter numbers as the formula and the scene have");
        Self { formula, world, equation, parameters, weighted: OnceLock::new() }
    }

    /// Follows the rays of a pixel, given as column and row from the top left, in the pass of the view. `None` outside
    /// the picture.
    pub fn inspect(&self, view: &View, pixel: [u32; 2]) -> Option<Inspection> {
        let [column, row] = pixel;
        if column >= view.width() || row >= view.height() {
            return None;
        }
        let pixel_index = row * view.width() + column;
        let tracer = Tracer::new(self.world, view);
        let tree = ray_tree(&tracer, pixel_index, self.formula.evaluated_lights());
        let mut rays = self.follow(&tracer, pixel_index, &tree);
        // Children come after their parents.
        for index in (0..rays.len()).rev() {
            rays[index].total = self.brought(&rays, index);
        }
        let total = rays.first()?.total;
        Some(Inspection { pixel, pass: view.pass(), rays, total })
    }

    /// The formula at a hit for a light with its numbers, whether the light reaches the hit or not. `None` if the scene
    /// has no such light.
    pub fn instance(&self, hit: &InspectedHit, light: LightId) -> Option<Instance> {
        let light = hit.lights.iter().find(|inspected| inspected.light == light)?;
        Some(Instance::new(self.formula, &self.values_at(hit, light)))
    }

    /// The values of all terms of the formula at a hit for a light.
    fn values_at(&self, hit: &InspectedHit, light: &InspectedLight) -> Vec<[f32; 3]> {
        let value = |symbol| variable(symbol, &hit.variables, &light.variables);
        let source = InspectedSource { light: light.light, radiance: light.sample.radiance };
        self.values(self.formula, hit.body(), Some(source), &value)
    }

    /// All rays with what is found at their ends, but without the light of their children.
    fn follow(&self, tracer: &Tracer, pixel: u32, tree: &Tree) -> Vec<InspectedRay> {
        let mut rays: Vec<InspectedRay> = Vec::new();
        let (child, ray) = (tree.primary, tracer.primary(pixel));
        let mut stack =
            vec![PendingChild { child, edge: Edge::Primary, parent: None, depth: 1, ray, factor: [1.0; 3], weight: [1.0; 3] }];
        while let Some(PendingChild { child, edge, parent, depth, ray, factor, weight }) = stack.pop() {
            let node = match child {
                Child::None => continue,
                Child::Miss(_) => None,
                Child::Hit(index) => tree.nodes.get(index),
            };
            let index = rays.len();
            if let Some(End::Hit(hit)) = parent.and_then(|parent| rays.get_mut(parent)).map(|parent| &mut parent.end) {
                match edge {
                    Edge::Primary => {}
                    Edge::Reflected => hit.reflected = Onward::Ray(index),
                    Edge::Refracted => hit.refracted = Onward::Ray(index),
                }
            }
            let (end, own) = match node {
                None => {
                    let miss = self.miss(ray.direction);
                    let seen = miss.environment.map(|environment| environment.contribution);
                    (End::Miss(miss), seen.map_or(miss.background, |seen| add(miss.background, seen)))
                }
                Some(node) => {
                    let hit = self.hit(tracer, node);
                    let own = own(&hit);
                    (End::Hit(Box::new(hit)), own)
                }
            };
            if let (Some(RayNode { hit, reflected, refracted, .. }), End::Hit(inspected)) = (node, &end) {
                let children = [
                    (Edge::Refracted, *refracted, tracer.refracted(hit), inspected.weights[1]),
                    (Edge::Reflected, *reflected, tracer.reflected(hit), inspected.weights[0]),
                ];
                stack.extend(children.into_iter().filter_map(|(edge, child, ray, factor)| {
                    let (ray, weight) = (ray?, product(weight, factor));
                    Some(PendingChild { child, edge, parent: Some(index), depth: depth + 1, ray, factor, weight })
                }));
            }
            let share = |component: usize| (weight[component] * f64::from(own[component])) as f32;
            let contribution = if weight == [0.0; 3] { [0.0; 3] } else { std::array::from_fn(share) };
            rays.push(InspectedRay { edge, parent, depth, ray, factor, weight, end, own, total: own, contribution });
        }
        rays
    }

    /// What a ray that leaves the scene in this direction brings.
    fn miss(&self, direction: DVec3) -> InspectedMiss {
        let background = self.equation.sum(Site::Miss, self.parameters, 0);
        let environment = self.world.environment().map(|environment| {
            let radiance = environment.radiance(direction);
            let value = |factor: Predefined| self.equation.value(self.parameters, factor, self.equation.owner_of(factor, 0));
            let terms = EquationTerm::at(Site::Environment).map(|term| term.product_with(value, radiance));
            InspectedEnvironment {
                light: environment.light(),
                intensity: value(Predefined::Intensity)[0],
                colour: value(Predefined::LightColour),
                radiance,
                contribution: terms.reduce(add).unwrap_or_default(),
            }
        });
        InspectedMiss { background, environment }
    }

    /// A hit with its lights. Its child rays are filled in when they are followed.
    fn hit(&self, tracer: &Tracer, node: &RayNode) -> InspectedHit {
        let surface = &node.hit;
        let body = self.world.scene().body(surface.body);
        let variables = HitVariables::new(self.world, surface, node.relative_index, CoordinatesUse::Read);
        let refracted = tracer.refracted(surface);
        let crossing = (!body.opaque).then(|| Crossing {
            entering: surface.side == Side::Front,
            n12: tracer.relative_index(surface),
            angle: refracted.map(|ray| degrees(-surface.shading_normal.dot(ray.direction))),
        });
        let terms = self.surface_terms(surface.body, &variables);
        let given = |term: SurfaceTerm| terms.iter().find(|(known, _)| *known == term).map(|(_, value)| *value);
        let weight = |term: SurfaceTerm| {
            let parameter = || weight_parameter(term).map_or([0.0; 3], |weight| self.predefined(weight, surface.body.index()));
            given(term).unwrap_or_else(parameter)
        };
        let ambient = given(SurfaceTerm::Ambient);
        let ambient = ambient.unwrap_or_else(|| self.equation.sum(Site::Hit, self.parameters, surface.body.index()));
        InspectedHit {
            surface: *surface,
            weights: [weight(SurfaceTerm::Reflected), weight(SurfaceTerm::Refracted)],
            emission: given(SurfaceTerm::Emission),
            variables,
            incidence: degrees(surface.shading_normal.dot(surface.view)),
            crossing,
            ambient,
            lights: self.world.emitter_ids().map(|emitter| self.light(tracer, node, &variables, emitter)).collect(),
            reflected: if body.matte { Onward::Matte } else { Onward::Depth },
            refracted: match refracted {
                _ if body.opaque => Onward::Opaque,
                None => Onward::TotalReflection,
                Some(_) => Onward::Depth,
            },
        }
    }

    fn light(&self, tracer: &Tracer, node: &RayNode, hit: &HitVariables, emitter: EmitterId) -> InspectedLight {
        let (surface, key, light) = (&node.hit, &node.key, self.world.light_of(emitter));
        let between = || {
            let mut occluders = tracer.occluders(emitter, surface, key);
            occluders.sort_by(|one, other| one.distance.total_cmp(&other.distance));
            occluders.into_iter().map(|occluder| occluder.body).collect()
        };
        let sample = tracer.sample(emitter, surface, key);
        let visibility = match (tracer.reaches(emitter, surface, key), tracer.faces(emitter, surface, key)) {
            (true, _) => Visibility::Lit,
            (false, _) if !sample.is_lit() => Visibility::Dark,
            (false, true) => Visibility::Shadowed(between()),
            (false, false) => Visibility::Away(between()),
        };
        let evaluated = node.lights.iter().any(|light| light.emitter == emitter);
        let variables = LightVariables::new(surface, &sample, tracer.is_visible(emitter, surface, key));
        let of = |formula: &Formula, radiance: [f32; 3]| {
            let source = InspectedSource { light, radiance };
            self.values(formula, surface.body, Some(source), &|symbol| variable(symbol, hit, &variables))
                [formula.result.0 as usize]
        };
        let local = of(self.formula, sample.radiance);
        // This formula reads radiance and weight itself. It rounds as backends do.
        let added = self.weighted().map_or(local, |formula| of(formula, [1.0; 3]));
        let intensity = self.equation.light_weight(self.parameters, light.index());
        let contribution = if evaluated { weighed(intensity, added) } else { [0.0; 3] };
        let angle = degrees(surface.shading_normal.dot(sample.direction));
        InspectedLight { light, visibility, evaluated, angle, sample, variables, intensity, local, contribution }
    }

    /// The formula that backends evaluate in this world, if it is not that of the user: see
    /// [`evaluated_formula`](crate::evaluate::evaluated_formula).
    fn weighted(&self) -> Option<&Formula> {
        let weighted = || (!self.world.has_whole_samples()).then(|| self.formula.for_weighted_samples());
        self.weighted.get_or_init(weighted).as_deref()
    }

    /// Equation (2) at the end of a ray whose children's totals are known.
    fn brought(&self, rays: &[InspectedRay], index: usize) -> [f32; 3] {
        let ray = &rays[index];
        let End::Hit(hit) = &ray.end else { return ray.own };
        [hit.reflected, hit.refracted].into_iter().fold(ray.own, |sum, child| match child {
            Onward::Ray(child) => add(sum, weighed_by(rays[child].factor, rays[child].total)),
            Onward::Matte | Onward::Opaque | Onward::TotalReflection | Onward::Depth => sum,
        })
    }

    /// The terms of the lighting equation that the formula gives at a hit, with their values.
    fn surface_terms(&self, body: BodyId, hit: &HitVariables) -> Vec<(SurfaceTerm, [f32; 3])> {
        if self.formula.surface.is_empty() {
            return Vec::new();
        }
        let values = self.values(self.formula, body, None, &|symbol| hit.value(symbol).unwrap_or_default());
        self.formula.surface.iter().map(|(term, id)| (term, values[id.0 as usize])).collect()
    }

    /// The values of all terms of a formula at a hit for a light, by the reference meaning. Scalars are repeated three
    /// times. Without a light, what reads one has no meaning.
    fn values(
        &self,
        formula: &Formula,
        body: BodyId,
        source: Option<InspectedSource>,
        value: &dyn Fn(Variable) -> [f32; 3],
    ) -> Vec<[f32; 3]> {
        let colour_of_light = formula.predefined(Predefined::LightColour);
        term_values(formula, value, &|id| {
            let owner = match formula.parameter(id).owner {
                Owner::Global => Some(0),
                Owner::Body => Some(body.index()),
                Owner::Light => source.map(|source| source.light.index()),
            };
            let own = owner.map_or([0.0; 3], |owner| self.parameter(id, owner));
            match source.filter(|_| id == colour_of_light) {
                Some(source) => std::array::from_fn(|at| Floats.mul(own[at], flush(source.radiance[at]))),
                None => own,
            }
        })
    }

    fn predefined(&self, predefined: Predefined, owner: usize) -> [f32; 3] {
        self.parameter(self.formula.predefined(predefined), owner)
    }

    /// The value of a parameter of the owner with this index. A scalar is repeated three times.
    fn parameter(&self, id: ParameterId, owner: usize) -> [f32; 3] {
        let parameter = self.formula.parameter(id);
        let first = self.equation.layout.index(parameter, owner);
        let last = parameter.ty.slots() - 1;
        [0, 1, 2].map(|component: usize| flush(self.parameters[first + component.min(last)]))
    }
}

/// The weight of a path that goes on with this factor.
fn product(weight: [f64; 3], factor: [f32; 3]) -> [f64; 3] {
    if factor == [0.0; 3] {
        return [0.0; 3];
    }
    std::array::from_fn(|component| weight[component] * f64::from(factor[component]))
}

/// Σ ki·local + ambient + emission, added up as the interpreter does.
fn own(hit: &InspectedHit) -> [f32; 3] {
    let evaluated = hit.lights.iter().filter(|light| light.evaluated);
    evaluated.map(|light| light.contribution).chain([hit.ambient]).chain(hit.emission).reduce(add).unwrap_or_default()
}

fn add(one: [f32; 3], other: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|component| Floats.add(one[component], other[component]))
}

/// The angle of a cosine in degrees. Rounding may have made the cosine larger than 1.
fn degrees(cosine: f64) -> f64 {
    cosine.clamp(-1.0, 1.0).acos().to_degrees()
}
