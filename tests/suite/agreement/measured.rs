//! Measured materials by every backend, against the files and the geometry of one hit.

use crate::agreement::compiled;
use glam::DVec3;
use illuminator::backends::interpreter::Interpreted;
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::Evaluator;
use illuminator::formula::binding::Bindings;
use illuminator::formula::binding_time::BindingTime;
use illuminator::formula::graph::Node;
use illuminator::lang::scalars::Primitive;
use illuminator::measured::{MeasuredMaterial, kept};
use illuminator::trace::View;
use illuminator::workspace::Values;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// The names of files in `tests/reference/measured`.
const FILES: [&str; 2] = ["anisotropic_rgb.bsdf", "isotropic_spectral.bsdf"];

/// The materials of the files, with their numbers.
fn materials() -> &'static [(Arc<MeasuredMaterial>, f32)] {
    static READ: OnceLock<Vec<(Arc<MeasuredMaterial>, f32)>> = OnceLock::new();
    READ.get_or_init(|| {
        let read = |name: &&str| {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/measured").join(name);
            let material = MeasuredMaterial::read(&path).unwrap_or_else(|error| panic!("{error:#}"));
            (Arc::clone(&material), kept::keep(path, material).expect("room"))
        };
        FILES.iter().map(read).collect()
    })
}

/// A formula on a rectangle under a light, seen from the side, with its materials.
fn subject(formula: &str) -> (Subject, View) {
    let scene = "bodies; r: rectangle, <-1,0,1>, <-1,0,-1>, <1,0,-1>; lights; l: point, <1.5,2,0.5>;
        camera; position <-1,1,2>; gaze <1,-1,-2>; up <0,1,0>; fov 0.1;";
    let view = View::new(1, 1).and_then(|view| view.with_depth(1)).expect("within range");
    let text = format!("body_specific; one: scalar, default 1; formula; reflected = 0; refracted = 0; ambient = <0>; {formula}");
    let mut subject = Subject::parse(&text, scene, view).unwrap_or_else(|errors| panic!("{formula}: {errors}"));
    for material in &mut Arc::make_mut(&mut subject.formula).materials {
        let index = FILES.iter().position(|name| *name == material.path).expect("a known file");
        material.number = materials()[index].1;
    }
    (subject, view)
}

/// The one pixel of a picture by every backend.
fn pixels(formula: &str) -> Vec<[f32; 3]> {
    let (subject, view) = subject(formula);
    let values = Values::defaults(&subject.formula, subject.world.scene());
    let interpreted = Interpreted::new(&subject.formula, &subject.world, view).expect("small enough");
    let frame = |backend| {
        let evaluator = Engine::new(backend).evaluator(&subject, &[], &Task::UNWATCHED).expect("a picture");
        evaluator.frame(values.numbers()).linear[0]
    };
    compiled().into_iter().map(frame).chain([interpreted.frame(values.numbers()).linear[0]]).collect()
}

/// The directions to the light and to the view in the frame of the hit, which is the middle of the rectangle.
fn directions() -> [DVec3; 2] {
    // The first edge goes to -z: that is the tangent. The normal is +y.
    let (tangent, normal) = (DVec3::NEG_Z, DVec3::Y);
    let bitangent = normal.cross(tangent);
    [DVec3::new(1.5, 2.0, 0.5), DVec3::new(-1.0, 1.0, 2.0)].map(|towards| {
        let towards = towards.normalize();
        DVec3::new(towards.dot(tangent), towards.dot(bitangent), towards.dot(normal))
    })
}

fn near(formula: &str, expected: DVec3) {
    let found = pixels(formula);
    assert!(expected.min_element() > 1e-3, "{formula}: something is seen: {expected}");
    for found in found {
        let close = |(found, expected): (&f32, f64)| (f64::from(*found) - expected).abs() <= 1e-4 * expected;
        assert!(found.iter().zip(expected.to_array()).all(close), "{formula}: {found:?} is not {expected:?}");
    }
}

#[test]
pub(super) fn pixels_have_the_reflectance_of_the_file() {
    let [light, view] = directions();
    for (name, (material, _)) in FILES.iter().zip(materials()) {
        let value = PI * material.value(light, view);
        near(&format!("= measured(\"{name}\");"), value);
        near(&format!("= IL*measured(\"{name}\")*max(0, N.L);"), value * light.z);
        near(&format!("M = measured(\"{name}\"); = M*M;"), value * value);
        near(&format!("= measured(\"{name}\", V, L);"), PI * material.value(view, light));
        near(&format!("F(a, b) = measured(\"{name}\", 7*b, a); = F(V, L);"), value);
        near(&format!("= sum(i, 1, 3, i*measured(\"{name}\"));"), value * 6.0);
        // Half way to the normal.
        let half = (light + DVec3::Z).normalize();
        near(&format!("= measured(\"{name}\", normalize(L + N), V);"), PI * material.value(half, view));
    }
    let [one, other] = [0, 1].map(|index| PI * materials()[index].0.value(light, view));
    near(&format!("= measured(\"{}\") + 2*measured(\"{}\");", FILES[0], FILES[1]), one + 2.0 * other);
}

/// Not on graphics devices: their kernels have no measured materials.
#[test]
fn directions_may_depend_on_parameters() {
    let [light, view] = directions();
    let value = PI * materials()[0].0.value((light + DVec3::Z).normalize(), view);
    near(&format!("= measured(\"{}\", L + one*N, V);", FILES[0]), value);
}

#[test]
fn below_the_horizon_and_without_a_file_nothing_is_reflected() {
    for formula in ["= measured(\"anisotropic_rgb.bsdf\", -L, V);", "= measured(\"anisotropic_rgb.bsdf\", L, one*<0>);"] {
        assert!(pixels(formula).iter().all(|pixel| *pixel == [0.0; 3]), "{formula}");
    }
}

/// Nothing is looked up in a frame: the values are stored once after tracing.
#[test]
fn measured_materials_of_variables_are_static() {
    let looked_up = |formula: &str| {
        let (subject, _) = subject(formula);
        let Bindings { graph, frontier, .. } = Bindings::new(&subject.formula);
        let bindings = Bindings::new(&subject.formula);
        let ids = (0..graph.len() as u32).map(illuminator::formula::graph::NodeId);
        let lookups = ids.filter(|id| matches!(graph.node(*id), Node::Apply(Primitive::Measured, _)));
        let times: Vec<BindingTime> = lookups.map(|id| bindings.time(id)).collect();
        (frontier.records.len(), times)
    };
    let (records, times) = looked_up("= IL*Cd*measured(\"anisotropic_rgb.bsdf\")*max(0, N.L);");
    assert_eq!(records, 3, "red, green and blue with the cosine");
    assert!(times.len() == 3 && times.iter().all(|time| matches!(time, BindingTime::Static(_))), "{times:?}");
    let (_, times) = looked_up("= IL*measured(\"anisotropic_rgb.bsdf\", L + one*N, V);");
    assert!(times.len() == 3 && times.iter().all(|time| *time == BindingTime::Dynamic), "{times:?}");
}
