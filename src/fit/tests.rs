//! Known parameters are found again: from reflectance, and from pictures.

mod certainty;

use crate::engine::{Engine, Subject, Task};
use crate::fit::directions::{LARGEST_ANGLE, pairs};
use crate::fit::metric::{METRICS, Metric};
use crate::fit::picture::{PictureMisfit, TargetPicture};
use crate::fit::samples::{FitSample, SampleMisfit, samples_of, samples_of_material};
use crate::fit::solve::{FitOptions, Solution, solve};
use crate::fit::unknowns::{FitNumber, FreeParameter, Unknowns};
use crate::formula::{Formula, ParameterId};
use crate::instrument::model::{FormulaModel, ModelProgram, ParameterNumbers, Place, default_numbers};
use crate::lang::source::Source;
use crate::measured::Measurement;
use crate::sensitivity::Sensitivity;
use crate::trace::View;
use crate::workspace::{FileKind, NamedAssignment, Values, presets};
use glam::DVec3;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn built_in(name: &str) -> Formula {
    Formula::parse(&Source::new(name, presets::text(FileKind::Formula, name).unwrap())).unwrap().0
}

/// The numbers of a formula where some parameters have other values.
fn numbers(formula: &Formula, changed: &[(&str, &[f32])]) -> ParameterNumbers {
    let mut numbers = default_numbers(formula);
    for (name, value) in changed {
        let id = formula.parameter_named(name).unwrap();
        numbers[id.0 as usize] = if value.len() == 3 { [value[0], value[1], value[2]] } else { [value[0]; 3] };
    }
    numbers
}

/// Fits these parameters of a formula to itself at other values, from its defaults.
fn refit(formula: &Formula, wanted: &[(&str, &[f32])], metric: Metric) -> (Unknowns, Solution, Vec<f64>) {
    let truth = numbers(formula, wanted);
    let model = FormulaModel::new(Arc::new(ModelProgram::new(formula)), truth.clone(), Place::default());
    let samples = samples_of(&model, 4000, LARGEST_ANGLE);
    let start = default_numbers(formula);
    let free: Vec<FreeParameter> = wanted
        .iter()
        .map(|(name, _)| FreeParameter { parameter: formula.parameter_named(name).unwrap(), owner: 0, range: None })
        .collect();
    let value = |id: ParameterId, _: usize| start[id.0 as usize];
    let unknowns = Unknowns::new(formula, &free, &value).unwrap();
    let place = Place::default();
    let misfit = SampleMisfit::new(formula, start.clone(), &place, unknowns.numbers(), &samples, metric);
    let solution = solve(&misfit, &unknowns, FitOptions::default(), &|_| (), &AtomicBool::new(false));
    let number = |number: FitNumber| f64::from(truth[number.parameter.0 as usize][usize::from(number.component)]);
    let wanted = unknowns.numbers().into_iter().map(number).collect();
    (unknowns, solution, wanted)
}

#[test]
fn parameters_of_built_in_formulas_are_found_again() {
    type Case = (&'static str, &'static [(&'static str, &'static [f32])]);
    let cases: &[Case] = &[
        ("phong", &[("ks", &[0.6]), ("kd", &[0.2]), ("h", &[23.0])]),
        ("blinn-phong", &[("kd", &[0.3]), ("h", &[700.0]), ("Cs", &[0.9, 0.5, 0.1])]),
        ("ggx", &[("ag", &[0.11]), ("n", &[1.9]), ("kd", &[0.3])]),
        ("cook-torrance", &[("d", &[0.2]), ("m", &[0.4]), ("n", &[1.8, 2.5, 3.0])]),
        ("ward", &[("rs", &[0.1]), ("rd", &[0.3]), ("ax", &[0.11]), ("ay", &[0.25])]),
        ("oren-nayar", &[("sigma", &[12.0]), ("Cd", &[0.3, 0.6, 0.9])]),
        ("ashikhmin-shirley", &[("nu", &[150.0]), ("nv", &[30.0]), ("Rs", &[0.3, 0.2, 0.1])]),
        ("disney", &[("metallic", &[0.4]), ("roughness", &[0.25]), ("clearcoat", &[0.5]), ("sheen", &[0.3])]),
    ];
    for (name, wanted) in cases {
        let formula = built_in(name);
        for metric in METRICS {
            let (unknowns, solution, wanted) = refit(&formula, wanted, metric);
            for ((found, wanted), number) in solution.values.iter().zip(&wanted).zip(unknowns.numbers()) {
                let near = (found - wanted).abs() <= 1e-3 * wanted.abs().max(1e-2);
                let parameter = &formula.parameter(number.parameter).name;
                assert!(near, "{name}, {}: {parameter} {found}, {wanted}: {solution:?}", metric.name);
            }
        }
    }
}

/// The microfacet model of Walter and others (2007) with the distribution GGX over a matte surface, as the paper gives
/// it, in double precision.
fn ggx(width: f64, index: f64, matte: DVec3, light: DVec3, view: DVec3) -> DVec3 {
    let half = (light + view).normalize();
    let cosine = half.z;
    let square = width * width;
    let distribution = square / (PI * (cosine * cosine * (square - 1.0) + 1.0).powi(2));
    let masked = |direction: DVec3| {
        let tangent = (1.0 - direction.z * direction.z).max(0.0) / (direction.z * direction.z);
        2.0 / (1.0 + (1.0 + square * tangent).sqrt())
    };
    let c = light.dot(half).abs();
    let g = (index * index - 1.0 + c * c).sqrt();
    let fresnel = 0.5 * ((g - c) / (g + c)).powi(2) * (1.0 + ((c * (g + c) - 1.0) / (c * (g - c) + 1.0)).powi(2));
    let specular = distribution * masked(light) * masked(view) * fresnel / (4.0 * light.z * view.z);
    DVec3::splat(specular) + matte / PI
}

#[test]
fn parameters_of_a_file_of_measurements_are_found_again() {
    let text = "body_specific; a: scalar, constraint 0.02..1, default 0.5; n: scalar, constraint 1.05..3, default 1.4; formula;
        c = max(0, L.H); g = sqrt(n^2 - 1 + c^2);
        F = 0.5*((g - c)/(g + c))^2*(1 + ((c*(g + c) - 1)/(c*(g - c) + 1))^2);
        D = a^2/(pi*((N.H)^2*(a^2 - 1) + 1)^2);
        G(x) = 2/(1 + sqrt(1 + a^2*(1 - x^2)/x^2));
        = IL*max(0, N.L)*(Cd + <pi*D*F*G(N.L)*G(N.V)/(4*(N.L)*(N.V))>);";
    let (formula, _) = Formula::parse(&Source::new("ggx", text)).unwrap();
    let truth = [0.13, 1.7, 0.4, 0.25, 0.1];
    let matte = DVec3::new(truth[2], truth[3], truth[4]);
    let file = crate::measured::merl::bytes(|light, view| ggx(truth[0], truth[1], matte, light, view));
    let material = Measurement::of_bytes("ggx.binary", &file).unwrap().material(Path::new("ggx.binary")).unwrap();
    let samples = samples_of_material(&material, 5000, LARGEST_ANGLE);
    assert!(samples.len() > 4000, "{}", samples.len());
    let free =
        ["a", "n", "Cd"].map(|name| FreeParameter { parameter: formula.parameter_named(name).unwrap(), owner: 0, range: None });
    let start = default_numbers(&formula);
    let unknowns = Unknowns::new(&formula, &free, &|id, _| start[id.0 as usize]).unwrap();
    for metric in METRICS {
        let place = Place::default();
        let misfit = SampleMisfit::new(&formula, start.clone(), &place, unknowns.numbers(), &samples, metric);
        let solution = solve(&misfit, &unknowns, FitOptions { starts: 4 }, &|_| (), &AtomicBool::new(false));
        for (found, wanted) in solution.values.iter().zip(truth) {
            assert!((found - wanted).abs() < 1e-3 * wanted, "{}: {found}, {wanted}: {solution:?}", metric.name);
        }
    }
}

#[test]
fn parameters_of_a_picture_are_found_again() {
    let scene = "bodies; floor: rectangle, <-4,0,-4>, <4,0,-4>, <4,0,4>; ball: sphere, center <0,1,0>, radius 1;
        lights; key: point, <4,6,5>; fill: point, <-5,3,2>; camera; position <0,1.6,6>; gaze <0,-0.1,-1>; up <0,1,0>; fov 45;";
    let text = presets::text(FileKind::Formula, "blinn-phong").unwrap();
    let subject = Subject::parse(text, scene, View::new(60, 45).unwrap()).unwrap();
    let formula = &subject.formula;
    let values = |settings: &[&str]| {
        let mut values = Values::defaults(formula, subject.world.scene());
        let given: Vec<_> =
            settings.iter().flat_map(|text| text.parse::<NamedAssignment>().unwrap().resolve(values.table()).unwrap()).collect();
        values.assign(&given);
        values.numbers().to_vec()
    };
    let truth = values(&["ball.ks=0.2", "ball.h=40", "ball.Cd=<0.2,0.5,0.7>", "floor.kr=0.4", "key.ki=0.7"]);
    let start = values(&[]);
    let engine = Engine::default();
    let target = engine.picture(&subject, &truth, 1, &Task::UNWATCHED).unwrap();
    let hits = [engine.trace(&subject, &Task::UNWATCHED).unwrap()];
    let layout = crate::formula::layout::Layout::new(formula, 2, 2);
    // The body `ball` is the second, and the light `key` the first.
    let wanted = [("ks", 1), ("h", 1), ("Cd", 1), ("kr", 0), ("ki", 0)];
    let free: Vec<FreeParameter> = wanted
        .iter()
        .map(|(name, owner)| FreeParameter { parameter: formula.parameter_named(name).unwrap(), owner: *owner, range: None })
        .collect();
    let index = |id: ParameterId, owner: usize| layout.index(formula.parameter(id), owner);
    let value = |id: ParameterId, owner: usize| {
        let last = formula.parameter(id).ty.slots() - 1;
        [0, 1, 2].map(|component: usize| start[index(id, owner) + component.min(last)])
    };
    let unknowns = Unknowns::new(formula, &free, &value).unwrap();
    let moving: Vec<ParameterId> = unknowns.numbers().iter().map(|number| number.parameter).collect();
    let sensitivity = Sensitivity::new(&engine, &subject, &hits, &moving, &start).unwrap();
    let indices: Vec<usize> =
        unknowns.numbers().iter().map(|number| index(number.parameter, number.owner) + usize::from(number.component)).collect();
    let target = TargetPicture { frame: target, end: None };
    let misfit = PictureMisfit::new(sensitivity, start.clone(), indices.clone(), target, METRICS[0]);
    let solution = solve(&misfit, &unknowns, FitOptions { starts: 3 }, &|_| (), &AtomicBool::new(false));
    for (found, index) in solution.values.iter().zip(&indices) {
        let wanted = f64::from(truth[*index]);
        assert!((found - wanted).abs() <= 1e-3 * wanted.abs().max(1e-2), "{index}: {found}, {wanted}: {solution:?}");
    }
    assert!(solution.undetermined.is_empty() && solution.residuals[1] < 1e-4 * solution.residuals[0]);
}

#[test]
fn what_data_do_not_determine_is_told() {
    // kd and Cd appear only as a product, and w has no effect.
    let text = "body_specific; kd: scalar, constraint 0..1, default 0.5; w: scalar, constraint 0..1, default 0.5;
        formula; = kd*Cd*IL*max(0, N.L) + 0*<w>;";
    let (formula, _) = Formula::parse(&Source::new("test", text)).unwrap();
    let (unknowns, solution, _) = refit(&formula, &[("kd", &[0.7]), ("Cd", &[0.3, 0.4, 0.5]), ("w", &[0.1])], METRICS[0]);
    let names = |group: &[FitNumber]| -> Vec<String> {
        group.iter().map(|number| format!("{}{}", formula.parameter(number.parameter).name, number.component)).collect()
    };
    let groups: Vec<Vec<String>> = solution.undetermined.iter().map(|group| names(group)).collect();
    assert_eq!(groups, [vec!["w0"], vec!["kd0", "Cd0", "Cd1", "Cd2"]]);
    assert!(solution.residuals[1] < 1e-6 && solution.deviations.iter().all(Option::is_none), "{solution:?}");
    let product = solution.values[0] * solution.values[1];
    assert_eq!(unknowns.free(), 5);
    assert!((product - 0.21).abs() < 1e-4, "{product}");
}

/// Fits these parameters of a formula to the samples of another one with the same parameters.
fn fit_to(formula: &str, data: &str, names: &[&str]) -> (Formula, Solution) {
    let parse = |text: &str| Formula::parse(&Source::new("test", text)).unwrap().0;
    let (formula, data) = (parse(formula), parse(data));
    let model = FormulaModel::new(Arc::new(ModelProgram::new(&data)), default_numbers(&data), Place::default());
    let samples = samples_of(&model, 2000, LARGEST_ANGLE);
    let free: Vec<FreeParameter> = names
        .iter()
        .map(|name| FreeParameter { parameter: formula.parameter_named(name).unwrap(), owner: 0, range: None })
        .collect();
    let start = default_numbers(&formula);
    let unknowns = Unknowns::new(&formula, &free, &|id, _| start[id.0 as usize]).unwrap();
    let place = Place::default();
    let misfit = SampleMisfit::new(&formula, start.clone(), &place, unknowns.numbers(), &samples, METRICS[0]);
    let solution = solve(&misfit, &unknowns, FitOptions { starts: 4 }, &|_| (), &AtomicBool::new(false));
    (formula, solution)
}

const GLOSS: &str = "body_specific; kd: scalar, constraint 0..1, default 0.3; ks: scalar, constraint 0..1, default 0.2;
    h: scalar, constraint 1..200, default 20; c: scalar, constraint 0..1, default 0.5;";

#[test]
fn invariants_hold_at_the_end() {
    let limited = format!("{GLOSS} invariants; kd + ks <= 1; formula; = IL*max(0, N.L)*<kd + 3*ks*(max(0, N.H))^h>;");
    // It would take kd = 0.8 and ks = 0.9.
    let data = format!("{GLOSS} formula; = IL*max(0, N.L)*<0.8 + 2.7*(max(0, N.H))^30>;");
    let (_, solution) = fit_to(&limited, &data, &["kd", "ks", "h"]);
    let sum = solution.values[0] + solution.values[1];
    assert!((sum - 1.0).abs() < 1e-9, "{sum}: {solution:?}");
}

#[test]
fn products_that_only_count_together_are_all_open() {
    let text = format!("{GLOSS} formula; = IL*max(0, N.L)*<c*(kd + ks*(max(0, N.H))^h)>;");
    let data = format!("{GLOSS} formula; = IL*max(0, N.L)*<0.1 + 0.2*(max(0, N.H))^40>;");
    let (_, solution) = fit_to(&text, &data, &["kd", "ks", "h", "c"]);
    let open: Vec<bool> = solution.deviations.iter().map(Option::is_none).collect();
    assert_eq!(open, [true, true, false, true], "{solution:?}");
    assert_eq!(solution.undetermined.len(), 1);
    assert_eq!(solution.undetermined[0].len(), 3);
}

#[test]
fn thresholds_are_told_apart_from_what_has_no_effect() {
    let text = format!("{GLOSS} formula; = IL*max(0, N.L)*<if(N.H > c, kd, ks)> + 0*<h>;");
    let data = format!("{GLOSS} formula; = IL*max(0, N.L)*<if(N.H > 0.9, 0.3, 0.2)>;");
    let (formula, solution) = fit_to(&text, &data, &["kd", "h", "c"]);
    let name = |number: &FitNumber| formula.parameter(number.parameter).name.clone();
    assert_eq!(solution.stepwise.iter().map(name).collect::<Vec<_>>(), ["c"]);
    assert_eq!(solution.undetermined.len(), 2);
}

#[test]
fn a_cancelled_fit_keeps_the_values_at_hand() {
    let formula = built_in("phong");
    let start = default_numbers(&formula);
    let free = [FreeParameter { parameter: formula.parameter_named("h").unwrap(), owner: 0, range: None }];
    let unknowns = Unknowns::new(&formula, &free, &|id, _| start[id.0 as usize]).unwrap();
    let samples: Vec<FitSample> = pairs(50, LARGEST_ANGLE)
        .iter()
        .map(|weighted| FitSample { pair: weighted.pair, value: [0.1; 3], weight: weighted.weight })
        .collect();
    let place = Place::default();
    let misfit = SampleMisfit::new(&formula, start.clone(), &place, unknowns.numbers(), &samples, METRICS[0]);
    let solution = solve(&misfit, &unknowns, FitOptions::default(), &|_| (), &AtomicBool::new(true));
    assert!(solution.cancelled && solution.values == unknowns.start(), "{solution:?}");
}

#[test]
fn a_cancelled_fit_has_the_best_values_that_it_told_of() {
    use std::cell::Cell;
    use std::sync::atomic::Ordering;
    // Without invariants, so that the end is where the search was.
    let text = "body_specific; kd: scalar, constraint 0..1, default 0.6; ks: scalar, constraint 0..1, default 0.35;
        h: scalar, constraint 1..500, default 60; formula; = kd*IL*max(0, N.L) + ks*IL*max(0, R.V)^h;";
    let (formula, _) = Formula::parse(&Source::new("test", text)).unwrap();
    let start = default_numbers(&formula);
    let free = ["kd", "ks", "h"];
    let free = free.map(|name| FreeParameter { parameter: formula.parameter_named(name).unwrap(), owner: 0, range: None });
    let unknowns = Unknowns::new(&formula, &free, &|id, _| start[id.0 as usize]).unwrap();
    let truth = numbers(&formula, &[("ks", &[0.6]), ("kd", &[0.2]), ("h", &[23.0])]);
    let model = FormulaModel::new(Arc::new(ModelProgram::new(&formula)), truth, Place::default());
    let samples = samples_of(&model, 300, LARGEST_ANGLE);
    let place = Place::default();
    let misfit = SampleMisfit::new(&formula, start.clone(), &place, unknowns.numbers(), &samples, METRICS[0]);
    for most in 1..40 {
        let (cancelled, count, told) = (AtomicBool::new(false), Cell::new(0), Cell::new(f64::INFINITY));
        let tell = |progress: crate::fit::solve::FitProgress| {
            // The last word comes after the end.
            if count.get() < most {
                count.set(count.get() + 1);
                told.set(progress.residual);
                cancelled.store(count.get() == most, Ordering::Relaxed);
            }
        };
        let solution = solve(&misfit, &unknowns, FitOptions::default(), &tell, &cancelled);
        if solution.cancelled {
            assert!(solution.residuals[1] <= told.get() * (1.0 + 1e-9), "{most}: {} {solution:?}", told.get());
        }
    }
}
