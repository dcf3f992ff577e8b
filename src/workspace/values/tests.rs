//! Values given, settled, moved and kept.

use super::*;
use crate::lang::source::Source;
use crate::workspace::assignment::NamedAssignment;

const PHONG: &str = "body_specific; kd: scalar, constraint 0..1, default 0.2, slider; h: scalar, constraint 5..500, default 150;
    ks: scalar, constraint 0..1, default 0.5; invariants; ks+kd=1; kr+kt=1; formula; = kd*ks*h*Cd;";

fn formula(text: &str) -> Formula {
    Formula::parse(&Source::new("f", text)).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

fn scene(bodies: &str) -> Scene {
    let text = format!(
        "bodies; {bodies} lights; key: point, <9,9,9>; fill: point, <9,9,0>;
         camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;"
    );
    Scene::parse(&Source::new("s", text)).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

fn balls() -> Scene {
    let sphere = "sphere, center <0,0,0>, radius 1";
    scene(&format!("ball: {sphere}; solid: {sphere}, opaque; dull: {sphere}, matte;"))
}

fn assignments(values: &Values, texts: &[&str]) -> Vec<Assignment> {
    let resolve = |text: &&str| text.parse::<NamedAssignment>().unwrap().resolve(values.table()).unwrap();
    texts.iter().flat_map(resolve).collect()
}

fn get(values: &Values, label: &str) -> Vec<f32> {
    let found = values.iter().find(|(owner, id, _)| values.table().label(*owner, *id) == label);
    found.unwrap_or_else(|| panic!("{label}")).2.to_vec()
}

fn assign(values: &mut Values, texts: &[&str]) -> Vec<String> {
    let given = assignments(values, texts);
    values.assign(&given).iter().map(ValueWarning::to_string).collect()
}

#[test]
fn defaults_are_settled_without_a_word() {
    let (values, warnings) = Values::new(&formula(PHONG), &balls(), &[]);
    assert_eq!(warnings, []);
    assert_eq!(get(&values, "ball.kd"), [0.5]);
    assert_eq!(get(&values, "ball.kt"), [1.0]);
    assert_eq!(get(&values, "ball.Cd"), [0.8; 3]);
    assert_eq!(get(&values, "key.IL"), [1.0; 3]);
    assert_eq!(get(&values, "ka"), [0.1]);
    assert_eq!(values.numbers().len(), values.table().layout().len());
}

#[test]
fn values_outside_are_clamped_and_locked_ones_ignored() {
    let mut values = Values::defaults(&formula(PHONG), &balls());
    let warnings =
        assign(&mut values, &["ball.ks=0.9", "*.h=600", "ball.kd=0.3", "key.IL=<1,2,-1>", "solid.ks=0.1", "solid.ks=0.2"]);
    assert_eq!(
        warnings,
        [
            "`ball.h` = 600 is outside 5..500; 500 is used",
            "`solid.h` = 600 is outside 5..500; 500 is used",
            "`dull.h` = 600 is outside 5..500; 500 is used",
            "`key.IL` = <1, 2, -1> is outside 0..1; <1, 1, 0> is used",
            "`ball.kd` = 0.3 is ignored: it follows from other values (kd = 1 - ks) and is 0.1",
        ]
    );
    assert_eq!(get(&values, "solid.ks"), [0.2]);
    assert_eq!(get(&values, "dull.ks"), [0.5]);
}

#[test]
fn opaque_and_matte_bodies_have_weights_of_zero() {
    let mut values = Values::defaults(&formula(PHONG), &balls());
    let warnings = assign(&mut values, &["*.kr=0.4", "solid.kt=0.3", "dull.kt=0.6"]);
    assert_eq!(
        warnings,
        [
            "`solid.kt` = 0.3 is ignored: the body is opaque and never refracts",
            "`dull.kr` = 0.4 is ignored: the body is matte and never reflects",
            "`dull.kt` = 0.6 is ignored: it follows from other values (kt = 1 - kr) and is 1",
        ]
    );
    assert_eq!([get(&values, "solid.kr"), get(&values, "solid.kt")], [[0.4], [0.0]]);
    assert_eq!([get(&values, "dull.kr"), get(&values, "dull.kt")], [[0.0], [1.0]]);
    assert_eq!([get(&values, "ball.kr"), get(&values, "ball.kt")], [[0.4], [0.6]]);
    let kt = values.table().parameter_named("kt").unwrap();
    let solid = values.table().owners().named("solid").unwrap();
    assert_eq!(values.range_of(solid, kt), Some([0.0, 0.0]));
    assert!(values.lock_of(solid, kt).unwrap().contains("opaque"));
}

#[test]
fn given_values_make_others_give_way_in_the_order_of_naming() {
    let text = "body_specific; a: scalar, constraint 0..1, default 0.5; b: scalar, constraint 0..1, default 0.5;
        invariants; a+b<=1; formula; = a*b*Cd;";
    let mut values = Values::defaults(&formula(text), &scene("ball: sphere, center <0,0,0>, radius 1;"));
    assert_eq!(assign(&mut values, &["ball.a=0.8"]), ["`ball.b` = 0.5 breaks an invariant; 0.2 is used"]);
    assert_eq!(assign(&mut values, &["ball.b=0.6"]), ["`ball.b` = 0.6 breaks an invariant; 0.2 is used"]);
    assert_eq!(assign(&mut values, &["ball.b=0.6", "ball.a=0.4"]), [""; 0]);
    assert_eq!([get(&values, "ball.a"), get(&values, "ball.b")], [[0.4], [0.6]]);
}

#[test]
fn moved_values_take_others_along() {
    let mut values = Values::defaults(&formula(PHONG), &balls());
    let id = |name| values.table().parameter_named(name).unwrap();
    let (ks, kd, h, cd) = (id("ks"), id("kd"), id("h"), id("Cd"));
    let ball = values.table().owners().named("ball").unwrap();
    assert_eq!(values.move_to(ball, ks, [0.75, 0.0, 0.0]), [ks, kd]);
    assert_eq!(get(&values, "ball.kd"), [0.25]);
    assert_eq!(values.move_to(ball, ks, [0.75, 0.0, 0.0]), []);
    assert_eq!(values.move_to(ball, kd, [0.75, 0.0, 0.0]), []);
    assert_eq!(values.move_to(ball, h, [1000.0, 0.0, 0.0]), [h]);
    assert_eq!(get(&values, "ball.h"), [500.0]);
    assert_eq!(values.move_to(ball, cd, [0.1, 0.2, 3.0]), [cd]);
    assert_eq!(get(&values, "ball.Cd"), [0.1, 0.2, 1.0]);
    assert_eq!(values.moved_with(ball, ks), [(ks, 1.0), (kd, -1.0)]);
    assert_eq!(values.lock_of(ball, kd).as_deref(), Some("kd = 1 - ks"));
}

#[test]
fn values_are_kept_by_owner_and_name() {
    let mut values = Values::defaults(&formula(PHONG), &balls());
    assign(&mut values, &["ball.h=20", "ball.ks=0.9", "solid.h=30", "key.ki=0.5", "ka=0.7"]);
    let other = "body_specific; ks: scalar, constraint 0..0.8; h: vector; kd: scalar, constraint 0..1; formula; = ks*h*kd;";
    let (kept, warnings) = values
        .carry_over(&formula(other), &scene("ball: sphere, center <0,0,0>, radius 2; key2: sphere, center <1,1,1>, radius 1;"));
    let warnings: Vec<String> = warnings.iter().map(ValueWarning::to_string).collect();
    assert_eq!(warnings, ["`ball.ks` = 0.9 is outside 0..0.8; 0.8 is used"]);
    assert_eq!(get(&kept, "ball.h"), [0.0; 3]);
    assert_eq!(get(&kept, "ball.kd"), get(&values, "ball.kd"));
    assert_eq!(get(&kept, "key.ki"), [0.5]);
    assert_eq!(get(&kept, "ka"), [0.7]);
    assert_eq!(get(&kept, "key2.kt"), [0.0]);
    // An opaque body's own value comes back when it is opaque no more.
    let (opaque, _) = values.carry_over(&formula(PHONG), &scene("ball: sphere, center <0,0,0>, radius 2, opaque;"));
    assert_eq!(get(&opaque, "ball.kt"), [0.0]);
    let (clear, warnings) = opaque.carry_over(&formula(PHONG), &balls());
    assert_eq!((get(&clear, "ball.kt"), warnings), (vec![1.0], vec![]));
}

#[test]
fn names_that_do_not_exist_are_reported_with_the_nearest() {
    let values = Values::defaults(&formula(PHONG), &balls());
    let error = |text: &str| text.parse::<NamedAssignment>().unwrap().resolve(values.table()).unwrap_err().to_string();
    assert_eq!(error("bal.kd=1"), "there is no body or light `bal`; did you mean `ball`?");
    assert_eq!(error("x.kd=1"), "there is no body or light `x`; there are ball, solid, dull, key, fill");
    assert_eq!(error("ball.KD=1"), "`KD` is not a parameter of the formula; did you mean `kd`?");
    assert_eq!(error("key.Q=1"), "`Q` is not a parameter of the formula; there are ki, IL");
    assert_eq!(error("kd=1"), "`kd` is a body parameter; write `BODY.kd=…`, or `*.kd=…` for all");
    assert_eq!(error("ball.ka=1"), "`ka` is a global parameter; write `ka=…`");
    assert_eq!(error("*.ka=1"), "`ka` is a global parameter; write `ka=…`");
    assert_eq!(error("ball.Cd=1"), "`Cd` is a vector; give a vector `<x, y, z>` or a colour `#rrggbb`");
    assert_eq!(error("ball.kd=<1,1,1>"), "`kd` is a scalar; give a single number");
}

#[test]
fn choices_and_switches_are_set_by_name() {
    let models = "body_specific; model: scalar, choices \"Lambert\", \"Cook and Torrance\"; wet: scalar, switch; formula;
        = IL*Cd*(model + 2*wet);";
    let mut values = Values::defaults(&formula(models), &balls());
    assert_eq!(assign(&mut values, &["ball.model=Cook and Torrance", "ball.wet=on"]), Vec::<String>::new());
    assert_eq!((get(&values, "ball.model"), get(&values, "ball.wet")), (vec![1.0], vec![1.0]));
    assert_eq!(assign(&mut values, &["ball.model=0", "ball.wet=off"]), Vec::<String>::new());
    assert_eq!((get(&values, "ball.model"), get(&values, "ball.wet")), (vec![0.0], vec![0.0]));
    let error = |text: &str| text.parse::<NamedAssignment>().unwrap().resolve(values.table()).unwrap_err().to_string();
    assert_eq!(error("ball.model=Phong"), "`Phong` is not a value; write a choice of `model`: Lambert, Cook and Torrance");
    assert_eq!(error("ball.wet=yes"), "`yes` is not a value; write `on` or `off`, or a number");
    assert_eq!(error("ball.kr=x"), "`x` is not a value; write a number, a vector `<x, y, z>` or a colour `#rrggbb`");
}
