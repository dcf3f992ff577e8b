//! Formulas that choose by uniform conditions: each pair of a body and a light runs the kernels of its branches.

use crate::agreement::drags::{VIEWS, wrong};
use crate::agreement::{backends, compiled};
use illuminator::backends::interpreter::Interpreted;
use illuminator::backends::verify::verify;
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::{Evaluator, Framebuffer};
use illuminator::trace::View;
use illuminator::workspace::Values;
use std::sync::Arc;

/// Branches by a choice of the body, a choice of the light and a global threshold.
const MODELS: &str = "
    global; level: scalar, constraint 0..1, default 0.5;
    body_specific;
    model: scalar, choices \"Lambert\", \"Phong\", \"Blinn\";
    h: scalar, constraint 1..200, default 20;
    shine: scalar, constraint 0..1, default 0.4;
    light_specific; kind: scalar, choices \"hard\", \"soft\", \"odd\";
    formula;
    NL = max(0, N.L);
    WRAPPED = max(0, (N.L + 0.5)/1.5);
    HIGHLIGHT = if(model == 0, 0, if(model == 1, max(0, R.V)^h, max(0, N.H)^h));
    ODD = sin(level*alpha)*cos(level*beta);
    = IL*(if(kind == 0, NL, if(kind == 1, WRAPPED, ODD))*Cd + if(shine > level, shine, 0.1)*HIGHLIGHT*<1>);";

/// Sixty-four small balls over a floor, under two lights.
fn scene() -> String {
    let balls: String =
        (0..64).map(|ball| format!("b{ball}: sphere, center <{}, 0.3, {}>, radius 0.3;", ball % 8 - 4, ball / 8 - 4)).collect();
    format!(
        "bodies; floor: rectangle, <-6, 0, -6>, <6, 0, -6>, <6, 0, 6>, opaque; {balls}
         lights; key: point, <4, 6, 5>; fill: point, <-5, 3, 2>;
         camera; position <0, 5, 9>; gaze <0, -0.5, -1>; up <0, 1, 0>; fov 40;"
    )
}

/// The formula on the balls. `of` gives the numbers of each scalar parameter for each of its owners.
fn subject(formula: &str, of: impl Fn(&str, usize) -> Option<f32>) -> (Subject, Vec<f32>) {
    let view = View::new(96, 64).and_then(|view| view.with_depth(2)).expect("within range");
    let subject = Subject::parse(formula, &scene(), view).expect("sound texts");
    let values = Values::defaults(&subject.formula, subject.world.scene());
    let mut numbers = values.numbers().to_vec();
    let layout = values.table().layout();
    for parameter in &subject.formula.parameters {
        for owner in 0..layout.owners(parameter.owner) {
            if let Some(number) = of(&parameter.name, owner) {
                numbers[layout.index(parameter, owner)] = number;
            }
        }
    }
    (subject, numbers)
}

/// The number of a parameter of an owner.
fn index(subject: &Subject, name: &str, owner: usize) -> usize {
    let values = Values::defaults(&subject.formula, subject.world.scene());
    let parameter = subject.formula.parameters.iter().find(|parameter| parameter.name == name).expect("a parameter");
    values.table().layout().index(parameter, owner)
}

#[test]
pub(super) fn every_pair_takes_its_own_branches() {
    let (subject, mut numbers) = subject(MODELS, |name, owner| match name {
        "model" => Some((owner % 3) as f32),
        "shine" => Some(owner as f32 / 64.0),
        "kind" => Some((owner % 2) as f32),
        _ => None,
    });
    let interpreted = Interpreted::new(&subject.formula, &subject.world, subject.view).expect("small enough");
    let changes: [(&str, usize, f32); 5] =
        [("model", 9, 2.0), ("level", 0, 0.9), ("kind", 1, 0.0), ("model", 9, 0.0), ("level", 0, 0.1)];
    for backend in backends() {
        let evaluator = Engine::new(backend).evaluator(&subject, &[], &Task::UNWATCHED).expect("small enough");
        let mut numbers = numbers.clone();
        for (name, owner, value) in changes {
            let found = verify(&*evaluator, &interpreted, &numbers);
            assert!(found.passes() && found.excused == 0, "before {name}: {found:?}");
            numbers[index(&subject, name, owner)] = value;
        }
        assert!(verify(&*evaluator, &interpreted, &numbers).passes());
    }
    // A light that is off adds nothing, and what it would choose does not matter.
    numbers[index(&subject, "ki", 0)] = 0.0;
    for backend in compiled() {
        let evaluator = Engine::new(backend).evaluator(&subject, &[], &Task::UNWATCHED).expect("small enough");
        for kind in [1.0, 2.0, 0.0] {
            numbers[index(&subject, "kind", 0)] = kind;
            assert!(verify(&*evaluator, &interpreted, &numbers).passes());
        }
    }
}

#[test]
pub(super) fn more_choices_than_variants_are_right_too() {
    // Six switches, and every ball has others: 64 choices.
    let switches: String = (0..6).map(|bit| format!("s{bit}: scalar, switch;")).collect();
    let sum: String = (0..6).map(|bit| format!("+ if(s{bit}, sin({}*alpha), 0.1*beta)", bit + 1)).collect();
    let formula = format!("body_specific; {switches} formula; = IL*Cd*(1 {sum});");
    let bit = |name: &str| name.strip_prefix('s').and_then(|bit| bit.parse::<usize>().ok());
    let (subject, numbers) = subject(&formula, |name, owner| bit(name).map(|bit| (owner >> bit & 1) as f32));
    let interpreted = Interpreted::new(&subject.formula, &subject.world, subject.view).expect("small enough");
    for backend in compiled() {
        let evaluator = Engine::new(backend).evaluator(&subject, &[], &Task::UNWATCHED).expect("small enough");
        let found = verify(&*evaluator, &interpreted, &numbers);
        assert!(found.passes() && found.excused == 0, "{found:?}");
        // Other choices than before, so that other variants are kept.
        let mut turned = numbers.clone();
        let switches = (0..6).map(|bit| index(&subject, &format!("s{bit}"), 1));
        switches.for_each(|index| turned[index] = 1.0 - turned[index]);
        assert!(verify(&*evaluator, &interpreted, &turned).passes());
    }
}

#[test]
pub(super) fn formulas_that_choose_are_dragged() {
    let (subject, start) = subject(MODELS, |name, owner| match name {
        "model" => Some((owner % 3) as f32),
        "kr" => Some(0.3),
        _ => None,
    });
    // A body, a body whose variant has no such parameter, a light, and numbers that change the choices.
    let moves: [(&str, usize, [f32; 4]); 8] = [
        ("h", 1, [5.0, 30.0, 90.0, 12.0]),
        ("h", 0, [5.0, 30.0, 90.0, 12.0]),
        ("shine", 2, [0.45, 0.2, 0.9, 0.3]),
        ("kr", 0, [0.1, 0.3, 0.9, 0.5]),
        ("ki", 1, [0.1, 0.3, 0.9, 0.5]),
        ("kind", 1, [0.0, 1.0, 2.0, 0.0]),
        ("model", 0, [0.0, 2.0, 1.0, 0.0]),
        ("level", 0, [0.1, 0.9, 0.5, 0.2]),
    ];
    for backend in compiled() {
        let engine = Engine::new(backend);
        // Two, because an evaluator keeps what it chose last.
        let evaluators = [(); 2].map(|()| engine.evaluator(&subject, &[], &Task::UNWATCHED).expect("small enough"));
        for (name, owner, values) in moves {
            check(&evaluators, &subject, index(&subject, name, owner), &start, values);
        }
    }
}

/// Drags a number, before and after the preparation, and compares each frame with a full evaluation by another
/// evaluator. Each value is drawn three times: when it is new, and when what it chooses has columns or is prepared.
fn check([dragged, full]: &[Arc<dyn Evaluator>; 2], subject: &Subject, moved: usize, start: &[f32], values: [f32; 4]) {
    let mut numbers = start.to_vec();
    let mut drag = Arc::clone(dragged).drag(&[moved], &numbers, usize::MAX, None).expect("a drag");
    let mut drawn = Framebuffer::black(subject.view.width(), subject.view.height(), VIEWS[1]);
    for (turn, value) in values.into_iter().enumerate() {
        numbers[moved] = value;
        if turn == 1 {
            while !drag.prepare() {}
        }
        let frame = full.frame(&numbers);
        for time in 1..=3 {
            drag.frame(&numbers, &mut drawn);
            assert_eq!(wrong(&drawn, &frame), 0, "number {moved} at {value}, time {time}, by {:?}", drag.method());
        }
    }
}
