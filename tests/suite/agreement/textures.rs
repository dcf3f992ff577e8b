//! Textures by every backend, against bilinear interpolation in double precision that is written here.

use crate::agreement::compiled;
use crate::agreement::drags::{VIEWS, wrong};
use crate::agreement::formulas::{Case, SIZE, check};
use illuminator::backends::interpreter::Interpreted;
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::{Evaluator, Framebuffer};
use illuminator::lang::types::Type;
use illuminator::texture::{TextureImage, keep};
use illuminator::trace::View;
use illuminator::workspace::{Assignment, Values};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

const WIDTH: u32 = 5;
const HEIGHT: u32 = 3;

/// The texel at a column and a row from the bottom.
fn texel(x: u32, y: u32) -> [f32; 3] {
    let n = (x + WIDTH * y) as f32;
    [n / 15.0, (n * 7.0 % 15.0) / 15.0, if x == y { 4.0 } else { 0.25 }]
}

/// The number of a texture of 5×3 texels.
pub(super) fn number() -> f32 {
    static NUMBER: OnceLock<f32> = OnceLock::new();
    *NUMBER.get_or_init(|| {
        let texels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| texel(x, y))).collect();
        let texture = TextureImage::new(WIDTH, HEIGHT, texels).expect("texels");
        keep(PathBuf::from("five-by-three.png"), texture).expect("room")
    })
}

/// The colour at (u, v): the middle of texel i of n is at (i + 0.5)/n, and the image repeats.
fn expected(u: f64, v: f64) -> [f64; 3] {
    let around = |coordinate: f64, count: u32| {
        let place = coordinate * f64::from(count) - 0.5;
        let wrapped = |index: f64| index.rem_euclid(f64::from(count)) as u32;
        (wrapped(place.floor()), wrapped(place.floor() + 1.0), place - place.floor())
    };
    let ((left, right, s), (low, high, t)) = (around(u, WIDTH), around(v, HEIGHT));
    std::array::from_fn(|component| {
        let at = |x: u32, y: u32| f64::from(texel(x, y)[component]);
        (1.0 - t) * ((1.0 - s) * at(left, low) + s * at(right, low)) + t * ((1.0 - s) * at(left, high) + s * at(right, high))
    })
}

/// The one pixel of a picture by every backend. It shows the point (0.75, 0.25) of a rectangle, under white light from
/// straight above. `wood` is the texture, and `grey` is white.
fn pixel(formula: &str) -> Vec<[f32; 3]> {
    let scene = "bodies; r: rectangle, <-1,-3,0>, <-1,1,0>, <3,1,0>; lights; l: point, <0,0,9>;
        camera; position <0,0,4>; gaze <0,0,-1>; up <0,1,0>; fov 1;";
    let text = format!(
        "global; sky: texture; body_specific; wood: texture; grey: texture; s: scalar, default 3;
         light_specific; slide: texture; formula; {formula}"
    );
    let view = View::new(1, 1).and_then(|view| view.with_depth(2)).expect("within range");
    let subject = Subject::parse(&text, scene, view).unwrap_or_else(|errors| panic!("{formula}: {errors}"));
    let mut values = Values::defaults(&subject.formula, subject.world.scene());
    let textures: Vec<Assignment> = values
        .iter()
        .filter(|(_, id, _)| {
            let parameter = values.table().parameter(*id);
            parameter.ty == Type::Texture && parameter.name != "grey"
        })
        .map(|(owner, parameter, _)| Assignment { owner, parameter, value: [number(), 0.0, 0.0] })
        .collect();
    assert_eq!(textures.len(), 3);
    let given = [("ka", 0.0), ("kr", 1.0)].map(|(name, value)| {
        let id = values.table().parameter_named(name).expect("a parameter");
        let owner = values.iter().find(|(_, known, _)| *known == id).expect("a value").0;
        Assignment { owner, parameter: id, value: [value, 0.0, 0.0] }
    });
    values.assign(&[textures.as_slice(), &given].concat());
    let background = values.table().parameter_named("background").expect("a parameter");
    values.assign(&[Assignment { owner: illuminator::workspace::OwnerId::Global, parameter: background, value: [1.0; 3] }]);
    let interpreted = Interpreted::new(&subject.formula, &subject.world, view).expect("small enough");
    let frame = |backend| {
        let evaluator = Engine::new(backend).evaluator(&subject, &[], &Task::UNWATCHED).expect("a picture");
        evaluator.frame(values.numbers()).linear[0]
    };
    compiled().into_iter().map(frame).chain([interpreted.frame(values.numbers()).linear[0]]).collect()
}

fn near(formula: &str, expected: [f64; 3]) {
    let found = pixel(formula);
    assert!(found.len() > 1, "several backends");
    for found in found {
        let close = |(found, expected): (&f32, f64)| (f64::from(*found) - expected).abs() <= 1e-4 * expected.abs().max(1.0);
        assert!(found.iter().zip(expected).all(close), "{formula}: {found:?} is not {expected:?}");
    }
}

#[test]
pub(super) fn colours_are_those_of_the_reference() {
    const NO_RAYS: &str = "reflected = 0; refracted = 0;";
    for (coordinates, u, v) in [
        ("u, v", 0.75, 0.25),
        ("-u, 1 - v", -0.75, 0.75),
        ("7*u, -5*v", 5.25, -1.25),
        // The coordinates depend on a parameter.
        ("s*u, v/s", 2.25, 0.25 / 3.0),
        ("0, 0", 0.0, 0.0),
        ("1, 1", 0.0, 0.0),
        ("s, 0.3", 3.0, 0.3),
        // Not a number, and infinite.
        ("0/0, v", 0.0, 0.25),
        ("u, log(s - s)", 0.75, 0.0),
    ] {
        let colour = expected(u, v);
        near(&format!("{NO_RAYS} emission = wood({coordinates}); = <0>;"), colour);
        near(&format!("{NO_RAYS} ambient = wood({coordinates})*s; = <0>;"), colour.map(|number| 3.0 * number));
        near(&format!("{NO_RAYS} = IL*wood({coordinates})*max(0, N.L);"), colour);
        near(&format!("{NO_RAYS} = slide({coordinates})*sky({coordinates});"), colour.map(|number| number * number));
        near(&format!("{NO_RAYS} F(a, b) = wood(a, b) + grey(b, a); = F({coordinates});"), colour.map(|number| number + 1.0));
        // The reflected ray meets the background, which is white.
        near(&format!("refracted = 0; reflected = wood({coordinates}); = <0>;"), colour);
    }
}

#[test]
pub(super) fn drags_and_views_agree_with_the_interpreter() {
    let text = "global; g: scalar, constraint -1..50; body_specific; p: scalar; q: scalar, constraint 0..1; v: vector;
        wood: texture; light_specific; slide: texture;
        formula; reflected = kr*wood(u, 4*q); refracted = kt*0.5; emission = q*wood(3*u, getx(point));
        ambient = ka*Ia*Cd*wood(getx(N), gety(N)); = IL*Cd*wood(g*u, alpha)*slide(p, beta)*max(0, N.L);";
    let numbers = [0.31, 0.77, 0.55, 0.93, 0.12, 0.68, 0.41, 0.86, 0.23, 0.6, 0.97];
    let case = Case::of(text.to_owned(), &numbers, &compiled()).unwrap_or_else(|error| panic!("{error}"));
    check(&case).unwrap_or_else(|error| panic!("{error}"));
    for index in 0..case.layout.len() {
        for evaluator in &case.evaluators {
            crate::agreement::drags::drag(&case, evaluator, &[index], &[0.2, 0.9, 0.0, 1.0], VIEWS[1])
                .unwrap_or_else(|error| panic!("{index}: {error}"));
        }
    }
}

/// What lies in columns or images is looked up again, and a replaced texture can come back.
#[test]
pub(super) fn textures_are_replaced_while_a_slider_is_held() {
    let text = "body_specific; p: scalar; q: scalar, constraint 0..1; wood: texture; light_specific; slide: texture;
        formula; emission = q*wood(3*u, v); = IL*Cd*wood(u, v)*slide(u, beta)*max(0, N.L)^p + p*wood(p*u, v);";
    let numbers = [0.31, 0.77, 0.55, 0.93, 0.12, 0.68, 0.41, 0.86, 0.23, 0.6, 0.97];
    let mut case = Case::of(text.to_owned(), &numbers, &compiled()[..1]).unwrap_or_else(|error| panic!("{error}"));
    let index = |name: &str, owner: usize| {
        let id = case.formula.parameter_named(name).expect("a parameter");
        case.layout.index(case.formula.parameter(id), owner)
    };
    let (wood, slide, held) = (index("wood", 0), index("slide", 0), [index("p", 0), index("q", 0)]);
    let evaluator = &case.evaluators[0];
    for moved in held {
        let mut drag = Arc::clone(evaluator).drag(&[moved], &case.memory, usize::MAX, None).expect("a drag");
        let mut shown = Framebuffer::black(SIZE.0, SIZE.1, VIEWS[1]);
        let mut pictures = Vec::new();
        for (step, [on_body, in_light]) in [[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0]].into_iter().enumerate() {
            (case.memory[wood], case.memory[slide]) = (number() * on_body, number() * in_light);
            for value in [0.2, 0.9] {
                case.memory[moved] = value;
                drag.frame(&case.memory, &mut shown);
                while !drag.prepare() {}
                // By another evaluator, of the bytecode.
                assert_eq!(wrong(&shown, &case.interpreted.frame(&case.memory)), 0, "step {step}, {value}");
            }
            pictures.push(shown.pixels.clone());
        }
        assert!(pictures[0] == pictures[4] && (1..4).all(|step| pictures[step] != pictures[step - 1]), "textures are seen");
    }
}
