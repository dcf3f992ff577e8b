//! Pictures of several passes under every kind of light: both backends agree pass by pass, and drags over sums of
//! passes give the mean of all passes.

use crate::agreement::drags::{VIEWS, together, wrong};
use crate::agreement::formulas::{Case, SIZE, check, ingredients, number, runner};
use crate::agreement::{backends, compiled, only_draws_in_full};
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::{Backend, DragBeginning, Evaluator, Framebuffer};
use illuminator::lang::variables::Predefined;
use illuminator::picture::{Frame, Transfer};
use illuminator::plan::Method;
use illuminator::trace::View;
use illuminator::workspace::Values;
use proptest::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Every kind of light on a floor, a mirror and glass.
const SCENE: &str = "
    bodies;
    floor: rectangle, <-5,0,-6>, <5,0,-6>, <5,0,4>, opaque;
    ball: sphere, center <-0.8,1,0>, radius 1;
    box: box, <0.6,0,-0.5>, <1.6,1,0.5>;
    lights;
    sun: directional, <-1,-2,-1>;
    beam: spot, <3,4,2>, target <0.5,0,0>, angle 20, soft 12;
    globe: sphere, center <-3,3,1>, radius 0.7;
    panel: rectangle, <-1,4,-1>, <1,4,-1>, <1,4,1>;
    lamp: point, <0,2,4>;
    sky: environment, rotate 30;
    camera; position <0,1.6,6>; gaze <0,-0.15,-1>; up <0,1,0>; fov 40;";

/// The same formula and scene with another pass added to every evaluator.
fn with_passes(case: &mut Case, backends: &[Arc<dyn Backend>], passes: u32) {
    for pass in 1..passes {
        for (evaluator, backend) in case.evaluators.iter_mut().zip(backends) {
            let view = case.subject.view.with_pass(pass);
            let subject = Subject { view, ..case.subject.clone() };
            let hits = Engine::new(Arc::clone(backend)).trace(&subject, &Task::UNWATCHED).expect("small enough");
            *evaluator = evaluator.with_pass(&hits).expect("hits of another pass");
        }
    }
}

/// Formulas that use lights in every way.
const FORMULAS: [&str; 6] = [
    "= IL*Cd*max(0, N.L) + q*IL*max(0, R.V)^20;",
    "= IL*IL*Cd*max(0, N.L) + sqrt(IL)*max(0, N.H)^(10*q);",
    "= Cd*q*smoothstep(0.2, 0.4, N.L);",
    "= IL*visible*Cd*max(0, (N.L + q)/(1 + q)) + 0.1*(1 - visible)*Cd;",
    "= IL*Cd*max(0, N.L)/(1 + 0.01*min(dist, 100)) + l*IL*alpha*beta;",
    "= if(p > 0.5, IL*Cd*max(0, N.L), max(IL, Cd)*gety(L)*gety(L));",
];

#[test]
pub(super) fn both_backends_agree_in_every_pass() {
    let numbers = [0.3, 0.7, 0.5, 0.9, 0.2, 0.6, 0.8];
    for formula in FORMULAS {
        for pass in 0..3 {
            let declared = "body_specific; p: scalar; q: scalar, constraint 0..1; light_specific; l: scalar;";
            let case = Case::in_pass(format!("{declared} formula; {formula}"), &numbers, &backends(), SCENE, pass);
            check(&case.expect("a formula")).unwrap_or_else(|error| panic!("{formula}, pass {pass}: {error}"));
        }
    }
}

#[test]
pub(super) fn random_formulas_agree_in_every_pass() {
    let outcome = runner(150).run(&(ingredients(), 0..4_u32), |((scalar, vector, result, numbers), pass)| {
        let text = Case::text([&scalar, &vector, &result]);
        check(&Case::in_pass(text, &numbers, &backends(), SCENE, pass)?)
    });
    if let Err(error) = outcome {
        panic!("{error}");
    }
}

#[test]
pub(super) fn weights_of_rays_weigh_what_rays_see_of_the_environment() {
    let fresnel = "F0 = ((1-eta)/(1+eta))^2; F = if(total, 1, F0 + (1-F0)*(1-max(0,N.V))^5);";
    let formulas = [
        format!("{fresnel} reflected = kr*F; refracted = kt*(1-F); = IL*Cd*max(0, N.L);"),
        format!("{fresnel} reflected = Cd*kr*F; refracted = <0.2, 0, 1>; emission = 0.1*Cd; = IL*IL*Cd*max(0, N.L);"),
        // Weights that are not bounded, and weights that vanish by components.
        "reflected = <kr/0, 1, 0>; refracted = <0, kt, 1>; = IL*Cd*max(0, N.L);".to_owned(),
    ];
    for (formula, pass) in formulas.iter().zip(0..) {
        // Rays of the floor have the weight 0, but not those that go on from there.
        for numbers in [[0.0, 0.7, 0.9, 0.4, 0.6], [1.0, 0.7, 0.0, 0.0, 0.6]] {
            let case = Case::in_pass(format!("formula; {formula}"), &numbers, &compiled(), SCENE, pass).expect("a formula");
            check(&case).unwrap_or_else(|error| panic!("{formula}: {error}"));
        }
    }
}

#[test]
pub(super) fn drags_of_passes_with_weights_of_rays_give_their_mean() {
    let backends = [compiled().pop().expect("a width")];
    for formula in [
        "reflected = kr*Cd; refracted = kt; = IL*Cd*max(0, N.L);",
        // Weights that are not bounded: such a picture is no sum of images.
        "reflected = kr/(gety(N) - gety(N)); refracted = kt*1e20; = IL*Cd*max(0, N.L);",
    ] {
        let numbers = [0.5, 0.7, 0.9, 0.4, 0.6];
        let mut case = Case::in_pass(format!("formula; {formula}"), &numbers, &backends, SCENE, 0).expect("a formula");
        with_passes(&mut case, &backends, 3);
        for index in 0..case.layout.len() {
            let dragged = drag(&case, &case.evaluators[0], &[index], &[0.2, 0.8, 0.0]);
            dragged.unwrap_or_else(|error| panic!("{formula}: {error}"));
        }
    }
}

#[test]
fn pictures_of_large_numbers_are_dragged_by_images_without_visible_errors() {
    let backends = [compiled().pop().expect("a width")];
    let text = "body_specific; q: scalar, constraint 0..1; formula; emission = <3e7*q*(N.V), 300*q, 0.1>; = IL*Cd*max(0, N.L);";
    let numbers = [0.7, 0.3, 0.9, 0.6];
    let mut case = Case::in_pass(text.to_owned(), &numbers, &backends, SCENE, 0).expect("a formula");
    with_passes(&mut case, &backends, 3);
    let evaluator = &case.evaluators[0];
    let q = case.formula.parameter(case.formula.parameter_named("q").expect("a parameter"));
    for body in 0..case.layout.owners(q.owner) {
        let index = case.layout.index(q, body);
        let beginning = DragBeginning { picture: Arc::new(evaluator.frame(&case.memory)), passes: 1 };
        let mut drag = Arc::clone(evaluator).drag(&[index], &case.memory, usize::MAX, Some(&beginning)).expect("kernels");
        while !drag.prepare() {}
        let mut drawn = Framebuffer::black(SIZE.0, SIZE.1, VIEWS[1]);
        drag.frame(&case.memory, &mut drawn);
        for value in [0.0, 1e-7, 0.5] {
            let mut memory = case.memory.clone();
            memory[index] = value;
            drag.frame(&memory, &mut drawn);
            assert_eq!(wrong(&drawn, &evaluator.frame(&memory)), 0, "{value} on body {body}");
            assert!(drag.is_of_all_passes() && drag.method() == Method::Images, "{value} on body {body}");
        }
    }
}

static METHODS: [AtomicUsize; 3] = [const { AtomicUsize::new(0) }; 3];

/// Drags numbers through values, from scratch and from the picture of all passes.
fn drag(case: &Case, evaluator: &Arc<dyn Evaluator>, moved: &[usize], values: &[f32]) -> Result<Method, TestCaseError> {
    let picture = Arc::new(evaluator.frame(&case.memory));
    let failed = |error: &dyn std::fmt::Display| TestCaseError::fail(error.to_string());
    let mut method = Method::General;
    for begins in [false, true] {
        let mut cleaned = Frame::clone(&picture);
        let is_finite = picture.linear.as_flattened().iter().all(|number| number.abs() < 1e3);
        cleaned.clean();
        let beginning = begins.then(|| DragBeginning { picture: Arc::new(cleaned), passes: 1 });
        let drag = Arc::clone(evaluator).drag(moved, &case.memory, usize::MAX, beginning.as_ref());
        let mut drag = drag.map_err(|error| failed(&error))?;
        let mut drawn = Framebuffer::black(SIZE.0, SIZE.1, VIEWS[1]);
        if begins {
            drag.frame(&case.memory, &mut drawn);
            if is_finite {
                prop_assert_eq!(wrong(&drawn, &picture), 0, "the numbers have not moved: {}", &case.text);
            }
        }
        while !drag.prepare() {}
        let mut memory = case.memory.clone();
        for value in values {
            moved.iter().for_each(|index| memory[*index] = case.clamped(*index, *value));
            drag.frame(&memory, &mut drawn);
            method = drag.method();
            if begins && (method != Method::Images || !is_finite) {
                continue;
            }
            let frame = evaluator.frame(&memory);
            prop_assert_eq!(
                wrong(&drawn, &frame),
                0,
                "{} by {:?}, {}, {:?} to {} ALL {}",
                &case.text,
                method,
                begins,
                moved,
                value,
                drag.is_of_all_passes()
            );
            if let Some(linear) = drag.linear(&memory) {
                let far = |(one, other): (&f32, &f32)| (one - other).abs() > 1e-4 * other.abs().max(1.0);
                let far = linear.linear.as_flattened().iter().zip(frame.linear.as_flattened()).filter(|pair| far(*pair)).count();
                prop_assert_eq!(far, 0, "{}", &case.text);
            }
        }
    }
    Ok(method)
}

#[test]
fn the_first_frame_of_a_picture_of_large_numbers_has_all_passes() {
    let backends = [compiled().pop().expect("a width")];
    // Green is large, and blue is that of the background beside dark bodies, whose edges differ from pass to pass.
    let text = "formula; emission = <0, 300, 0>; = 0.1*IL*Cd*max(0, N.L);";
    let numbers = [0.1, 0.05, 0.15, 0.02];
    let mut case = Case::in_pass(text.to_owned(), &numbers, &backends, SCENE, 0).expect("a formula");
    with_passes(&mut case, &backends, 3);
    let evaluator = &case.evaluators[0];
    let background = case.formula.parameter(case.formula.predefined(Predefined::Background));
    let index = case.layout.index(background, 0) + 2;
    let beginning = DragBeginning { picture: Arc::new(evaluator.frame(&case.memory)), passes: 1 };
    let mut drag = Arc::clone(evaluator).drag(&[index], &case.memory, usize::MAX, Some(&beginning)).expect("kernels");
    let mut drawn = Framebuffer::black(SIZE.0, SIZE.1, VIEWS[1]);
    drag.frame(&case.memory, &mut drawn);
    while !drag.prepare() {}
    let mut memory = case.memory.clone();
    memory[index] = 0.5;
    drag.frame(&memory, &mut drawn);
    assert!(drag.method() == Method::Images && drag.is_of_all_passes());
    assert_eq!(wrong(&drawn, &evaluator.frame(&memory)), 0);
}

#[test]
pub(super) fn random_drags_of_passes_give_their_mean() {
    let backends = [compiled().pop().expect("a width")];
    let strategy = (ingredients(), any::<prop::sample::Index>(), any::<bool>(), proptest::collection::vec(number(), 2));
    let outcome = runner(200).run(&strategy, |((scalar, vector, result, numbers), which, all, values)| {
        let mut case = Case::in_pass(Case::text([&scalar, &vector, &result]), &numbers, &backends, SCENE, 0)?;
        with_passes(&mut case, &backends, 3);
        let index = which.index(case.layout.len());
        let moved = if all { together(&case, index) } else { vec![index] };
        let method = drag(&case, &case.evaluators[0], &moved, &values)?;
        METHODS[method as usize].fetch_add(1, Ordering::Relaxed);
        Ok(())
    });
    let methods = METHODS.each_ref().map(|count| count.load(Ordering::Relaxed));
    println!("images, specialised, general: {methods:?}");
    if let Err(error) = outcome {
        panic!("{error}");
    }
    assert!(methods[0] > 10 || only_draws_in_full(), "images are tried: {methods:?}");
}

#[test]
pub(super) fn passes_one_by_one_and_all_at_once_give_the_same_bits() {
    let formula = "body_specific; kd: scalar, constraint 0..1, default 0.5; formula; reflected = 0.2; = kd*IL*Cd*max(0, N.L);";
    let subject = Subject::parse(formula, SCENE, View::new(60, 40).expect("a size")).expect("sound texts");
    let values = Values::defaults(&subject.formula, subject.world.scene());
    let engine = Engine::new(compiled().pop().expect("a width"));
    let mean = engine.picture(&subject, values.numbers(), 5, &Task::UNWATCHED).expect("small enough");
    let mut evaluator = engine.evaluator(&subject, values.numbers(), &Task::UNWATCHED).expect("small enough");
    let never = AtomicBool::new(false);
    let mut sum = evaluator.sum(0..1, values.numbers(), &never).expect("it is not cancelled");
    for pass in 1..5 {
        let subject = Subject { view: subject.view.with_pass(pass), ..subject.clone() };
        evaluator = evaluator.with_pass(&engine.trace(&subject, &Task::UNWATCHED).expect("small enough")).expect("its hits");
        let pass = pass as usize;
        sum.add(&evaluator.sum(pass..pass + 1, values.numbers(), &never).expect("it is not cancelled"));
    }
    sum.scale(1.0 / 5.0);
    assert!(evaluator.frame(values.numbers()) == mean && sum == mean);
    let mut drawn = Framebuffer::black(60, 40, Transfer::Linear);
    evaluator.draw(values.numbers(), &mut drawn);
    assert_eq!(wrong(&drawn, &mean), 0);
    assert_eq!(evaluator.passes(), 5);
    assert!(evaluator.sum(0..5, values.numbers(), &AtomicBool::new(true)).is_none());
}
