//! The built-in models against numbers that were worked out independently of this program: closed forms, limits,
//! published tables, integrals, and formulas of papers computed again in double precision.

mod cloth;
mod fibres;
mod headers;
mod leaves;
mod microfacets;
mod painterly;
mod surfaces;

use illuminator::formula::graph::{Graph, Node, NodeId};
use illuminator::formula::{Formula, ParameterId};
use illuminator::lang::source::Source;
use illuminator::lang::variables::Variable;
use illuminator::workspace::{FileKind, presets};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI};

/// A direction, a point or a colour.
type Triple = [f64; 3];

/// The dot product.
fn dot(a: Triple, b: Triple) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The cross product.
fn cross(a: Triple, b: Triple) -> Triple {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A vector divided by its length.
fn normalize(a: Triple) -> Triple {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// The direction at an angle to the normal +z, at an azimuth from +x, both in degrees.
fn direction(polar: f64, azimuth: f64) -> Triple {
    let (polar, azimuth) = (polar.to_radians(), azimuth.to_radians());
    [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()]
}

/// A hit and a light: what the variables of a formula follow from. The normal is +z and the tangent +x.
#[derive(Debug, Clone, Copy)]
struct Hit {
    /// To the light.
    light: Triple,
    /// To the viewer.
    viewer: Triple,
    /// The hit in world coordinates.
    point: Triple,
    /// 1 if nothing is between the hit and the light.
    visible: f64,
    /// n1/n2 at the surface.
    eta: f64,
    /// From the hit to the light.
    distance: f64,
}

impl Hit {
    /// A hit at the origin, with light and viewer in these directions of unit length.
    fn new(light: Triple, viewer: Triple) -> Self {
        Hit { light, viewer, point: [0.0; 3], visible: 1.0, eta: 1.0, distance: 1.0 }
    }

    /// With light and viewer exchanged.
    fn swapped(self) -> Self {
        Hit { light: self.viewer, viewer: self.light, ..self }
    }

    /// The value of a component of a variable.
    fn variable(&self, variable: Variable, component: u8) -> f64 {
        let normal = [0.0, 0.0, 1.0];
        let tangent = [1.0, 0.0, 0.0];
        let mirrored = || [0, 1, 2].map(|axis| 2.0 * dot(normal, self.light) * normal[axis] - self.light[axis]);
        let angle = |a, b| [dot(a, b).clamp(-1.0, 1.0).acos(); 3];
        let vector = match variable {
            Variable::Normal => normal,
            Variable::ToLight => self.light,
            Variable::ToViewer => self.viewer,
            Variable::Mirrored => mirrored(),
            Variable::Halfway => normalize([0, 1, 2].map(|axis| self.light[axis] + self.viewer[axis])),
            Variable::Tangent => tangent,
            Variable::Bitangent => cross(normal, tangent),
            // The surface is flat, and no model reads its coordinates.
            Variable::GeometricNormal => normal,
            Variable::SurfaceU | Variable::SurfaceV => [0.0; 3],
            Variable::Point => self.point,
            Variable::Alpha => angle(normal, self.light),
            Variable::Beta => angle(mirrored(), self.viewer),
            Variable::Gamma => angle(normal, self.viewer),
            Variable::RelativeIndex => [self.eta; 3],
            Variable::TotalReflection => {
                let sine = self.eta * (1.0 - dot(normal, self.viewer).powi(2)).max(0.0).sqrt();
                [f64::from(sine > 1.0); 3]
            }
            Variable::Distance => [self.distance; 3],
            Variable::Visible => [self.visible; 3],
            Variable::Radiance | Variable::SampleWeight | Variable::WeightedRadiance => [1.0; 3],
        };
        vector[usize::from(component)]
    }
}

/// A built-in formula with values of its parameters: their defaults until others are given.
struct Model {
    formula: Formula,
    graph: Graph,
    macros: HashMap<String, Graph>,
    /// By the index of the parameter.
    values: Vec<[f32; 3]>,
}

impl Model {
    /// The built-in formula of this name.
    fn built_in(name: &str) -> Self {
        let text = presets::text(FileKind::Formula, name).expect("a built-in formula");
        let source = Source::new(name, text);
        let (formula, warnings) = Formula::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        assert!(warnings.is_empty(), "{}", warnings.located(&source));
        let graph = Graph::new(&formula);
        let values = formula.parameter_ids().map(|id| formula.parameter(id).default).collect();
        Model { formula, graph, macros: HashMap::new(), values }
    }

    /// With a value of a parameter: all three components of a vector.
    fn set(mut self, name: &str, value: f64) -> Self {
        self.assign(name, [value; 3]);
        self
    }

    /// With a value of a vector parameter.
    fn colour(mut self, name: &str, value: Triple) -> Self {
        self.assign(name, value);
        self
    }

    /// Gives a parameter a value, which must be in its range.
    fn assign(&mut self, name: &str, value: Triple) {
        let id = self.formula.parameter_named(name).unwrap_or_else(|| panic!("no parameter {name}"));
        let value = value.map(|x| x as f32);
        for x in value {
            assert!(!self.formula.parameter(id).clamp(x).1, "{name} = {x} is out of range");
        }
        self.values[id.0 as usize] = value;
    }

    /// The formula.
    fn formula(&self) -> &Formula {
        &self.formula
    }

    /// The colour that a hit gets from a light of intensity 1: π times the BRDF, times N.L.
    fn shade(&self, hit: &Hit) -> Triple {
        self.evaluate(&self.graph, hit)
    }

    /// The value of a macro, three times if it is a scalar.
    fn value(&mut self, name: &str, hit: &Hit) -> Triple {
        if !self.macros.contains_key(name) {
            let (_, id) = self.formula.macros.iter().find(|(known, _)| known == name).expect("a macro");
            let formula = Formula { result: *id, ..self.formula.clone() };
            self.macros.insert(name.to_owned(), Graph::new(&formula));
        }
        self.evaluate(&self.macros[name], hit)
    }

    fn evaluate(&self, graph: &Graph, hit: &Hit) -> Triple {
        let leaf = |id: NodeId| match graph.node(id) {
            Node::Variable(variable, component) => hit.variable(variable, component) as f32,
            Node::Parameter(parameter, component) => self.values[parameter.0 as usize][usize::from(component)],
            Node::Constant(_) | Node::Apply(..) => unreachable!("only variables and parameters are asked for"),
        };
        let values = graph.evaluate(&graph.result(), leaf);
        [0, 1, 2].map(|channel| f64::from(values[channel]))
    }

    /// What part of the light from all directions goes to a viewer at this angle in degrees, under a white sky:
    /// the integral of the colour over the hemisphere of lights, divided by π. The midpoint rule, in steps of the
    /// polar angle and of the azimuth.
    fn albedo(&self, polar: f64, steps: usize) -> Triple {
        let viewer = direction(polar, 0.0);
        hemisphere(steps, |light| self.shade(&Hit::new(light, viewer))).map(|sum| sum / PI)
    }
}

/// The integral of a function of a direction over the hemisphere above the normal. The midpoint rule, in this number
/// of steps of the polar angle and twice as many of the azimuth.
fn hemisphere(steps: usize, mut integrand: impl FnMut(Triple) -> Triple) -> Triple {
    let (polar_step, azimuth_step) = (FRAC_PI_2 / steps as f64, PI / steps as f64);
    let mut sum = [0.0; 3];
    for row in 0..steps {
        let polar = (row as f64 + 0.5) * polar_step;
        for column in 0..2 * steps {
            let azimuth = (column as f64 + 0.5) * azimuth_step;
            let light = [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()];
            let value = integrand(light);
            let weight = polar.sin() * polar_step * azimuth_step;
            sum = [0, 1, 2].map(|channel| sum[channel] + weight * value[channel]);
        }
    }
    sum
}

/// Directions to light and viewer all over the hemisphere, also near its edge and with N.L ≤ 0, and equal to each
/// other, to the normal and to the mirror direction.
fn hits() -> Vec<Hit> {
    let mut found = Vec::new();
    for viewer in [0.0, 45.0, 89.9, 90.0] {
        for polar in [0.0, 45.0, 89.9, 90.0, 135.0, 180.0] {
            for azimuth in [0.0, 90.0, 180.0] {
                found.push(Hit::new(direction(polar, azimuth), direction(viewer, 0.0)));
            }
        }
    }
    found
}

/// Asserts that a value is near another one: within `tolerance`, relative to the wanted one where that is above 1.
#[track_caller]
fn near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance * wanted.abs().max(1.0), "{found} is not {wanted}");
}

/// The tolerance of computations in single precision.
const SINGLE: f64 = 1e-4;

/// Asserts that the colour is a number, not negative and nowhere extreme, for all [`hits`] with many settings of the
/// body's parameters: each at one end of its range or at its default, in combinations drawn by a fixed sequence.
#[track_caller]
fn sound_in_all_corners(name: &str) {
    sound_in_corners(name, 60);
}

/// The same as [`sound_in_all_corners`], in this number of combinations: for long formulas.
#[track_caller]
fn sound_in_corners(name: &str, combinations: usize) {
    let mut model = Model::built_in(name);
    let hits = hits();
    let mut state = 1_u32;
    let mut draw = |count: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as usize % count
    };
    for _ in 0..combinations {
        let ids: Vec<ParameterId> = model.formula.parameter_ids().collect();
        for id in ids {
            let parameter = model.formula.parameter(id);
            let [low, high] = parameter.range.expect("a range");
            let value = if parameter.is_whole() {
                [low + draw((high - low) as usize + 1) as f32; 3]
            } else {
                [[low; 3], [high; 3], parameter.default][draw(3)]
            };
            model.values[id.0 as usize] = value;
        }
        for hit in &hits {
            let colour = model.shade(hit);
            let sound = colour.iter().all(|x| x.is_finite() && *x >= 0.0 && *x < 1e9);
            let given = || Vec::from_iter(model.formula.parameters.iter().map(|one| &one.name).zip(&model.values));
            assert!(sound, "{name}: {colour:?} at {hit:?} with {:?}", given());
        }
    }
}
