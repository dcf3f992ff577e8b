//! Bodies are turned and scaled by handles.

use super::*;
use crate::preview::app::hand::gesture::SceneAxis;
use crate::preview::app::hand::handles::FactorHandles;
use crate::preview::app::hand::view::Grip;
use crate::preview::app::{HandleTool, tab::TextTab};
use crate::scene::{BodyId, Shape};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

/// The window with a scene of these bodies, seen from above, with the first of them selected.
fn seen_from_above(bodies: &str, tool: HandleTool) -> Harness<'static, App> {
    let mut harness = harness();
    let text = format!(
        "bodies;\n{bodies}\nlights; key: point, <3,9,4>;\ncamera; position <0, 9, 0>; gaze <0, -1, 0>; up <0, 0, -1>; fov 45;\n"
    );
    harness.state_mut().documents.scene.replace_text(&text);
    harness.state_mut().apply(TextTab::Scene);
    assert_eq!(harness.state().documents.scene.counts()[0], 0, "{text}");
    harness.state_mut().parameters.select(OwnerId::Body(BodyId(0)));
    harness.state_mut().perform(Action::Scene(SceneAction::Handles(tool)));
    settle(&mut harness);
    harness.run_steps(3);
    harness
}

/// The line of the text that declares the first body.
fn line(harness: &Harness<'_, App>) -> String {
    text(harness).lines().nth(1).expect("a line").to_owned()
}

/// A point of the ring about an axis, and the one a quarter turn onwards.
fn quarter(harness: &Harness<'_, App>, axis: DVec3) -> [Pos2; 2] {
    let view = harness.state().scene_view();
    let anchor = scene(harness).bodies[0].form.anchor().expect("a place");
    let radius = super::super::handles::RING * view.reach_at(anchor);
    let (one, other) = axis.any_orthonormal_pair();
    // In between, where no other ring is.
    let at = |degrees: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        anchor + radius * (cosine * one + sine * other)
    };
    [at(37.0), at(127.0)].map(|point| view.project(point).expect("a point in view"))
}

#[test]
fn a_ring_turns_a_body_by_the_angle_of_the_pointer_about_its_middle() {
    let written = "b: box, <0.5, 0, -0.5>, <1.5, 1, 0.5>, matte; // a box";
    let mut harness = seen_from_above(written, HandleTool::Rotate);
    let [from, to] = quarter(&harness, DVec3::Y);
    assert_eq!(harness.state().scene_view().grip_at(from, true), Some(Grip::Ring(SceneObject::Body(BodyId(0)), SceneAxis::Y)));
    assert_eq!(harness.state().scene_view().grip_at(from, false), None, "hidden handles are none");
    press_and_move(&mut harness, PointerButton::Primary, NONE, from, to - from);
    let words = harness.state().hand.gesture.as_ref().and_then(|(gesture, _)| gesture.words()).expect("words");
    assert!(harness.state().workshop.moving().is_some() && line(&harness) == written && words == "90°", "{words}");
    release(&mut harness, PointerButton::Primary, NONE, to);
    let once = "b: box, <-0.5, -0.5, -0.5>, <0.5, 0.5, 0.5>, rotate <0, 1, 0> 90, translate <1, 0.5, 0>, matte; // a box";
    assert_eq!(line(&harness), once);
    // Backwards from there, with Ctrl in steps of 15 degrees: 50 of the 90 are 45.
    let part = from + 0.5 * (to - from) + vec2(0.0, 3.0);
    drag(&mut harness, PointerButton::Primary, Modifiers::CTRL, to, part - to);
    assert_eq!(line(&harness), once.replace("90", "45"));
    for expected in [once, written] {
        harness.state_mut().perform(Action::Undo);
        assert_eq!(line(&harness), expected, "one step a drag");
    }
    // Escape gives up.
    press_and_move(&mut harness, PointerButton::Primary, NONE, from, to - from);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    release(&mut harness, PointerButton::Primary, NONE, to);
    assert!(line(&harness) == written && scene(&harness).bodies[0].form.transforms.is_empty());
}

#[test]
fn a_ring_that_is_seen_from_its_edge_is_turned_along_it() {
    let mut harness = seen_from_above("b: sphere, center <0, 0, 0>, radius 1;", HandleTool::Rotate);
    let view = harness.state().scene_view();
    let (centre, radius) = (at(&harness, DVec3::ZERO), super::super::handles::RING as f32 * super::super::view::ARROW);
    // Beside the middle, on the line of the ring about x, which leads up.
    let from = centre + vec2(0.0, -0.4 * radius);
    assert_eq!(view.grip_at(from, true), Some(Grip::Ring(SceneObject::Body(BodyId(0)), SceneAxis::X)));
    // Up in the picture is -z: what is on top goes there, so the turn about x is against the clock.
    drag(&mut harness, PointerButton::Primary, NONE, from, vec2(0.0, -0.5 * radius));
    let Some(crate::scene::Transform::Rotate { axis, degrees }) = scene(&harness).bodies[0].form.transforms.first().copied()
    else {
        panic!("{}", line(&harness))
    };
    assert!(axis == DVec3::X && (degrees + 0.5_f64.to_degrees()).abs() < 0.3, "{degrees}");
}

#[test]
fn factors_are_along_the_own_axes_of_a_body_and_the_middle_scales_it_as_a_whole() {
    let turned = "b: cylinder, <0, -1, 0>, <0, 1, 0>, radius 0.5, rotate <0, 1, 0> 30, translate <1, 0, 0>;";
    let mut harness = seen_from_above(turned, HandleTool::Scale);
    let handles = |harness: &Harness<'_, App>| harness.state().scene_view().factor_handles().expect("handles");
    let FactorHandles { origin, tips, .. } = handles(&harness);
    // The own y leads to the camera, so it has no handle.
    assert_eq!(tips.iter().map(|(axis, _)| *axis).collect::<Vec<_>>(), [SceneAxis::X, SceneAxis::Z]);
    let tip = tips[0].1;
    let direction = (tip - origin).normalized();
    // By 30 degrees against the clock, seen from above.
    assert!((direction.y.atan2(direction.x).to_degrees() + 30.0).abs() < 1.0, "{direction:?}");
    drag(&mut harness, PointerButton::Primary, NONE, tip, tip - origin);
    assert_eq!(line(&harness), turned.replace(", rotate", ", scale <2, 1, 1>, rotate"));
    drag(&mut harness, PointerButton::Primary, Modifiers::CTRL, tip, -0.48 * (tip - origin));
    assert_eq!(line(&harness), turned.replace(", rotate", ", scale <1, 1, 1>, rotate").replace(", scale <1, 1, 1>", ""));
    // To the right is larger.
    assert_eq!(harness.state().scene_view().grip_at(origin, true), Some(Grip::Middle(SceneObject::Body(BodyId(0)))));
    let points = super::super::FACTOR_POINTS * std::f32::consts::LN_2;
    drag(&mut harness, PointerButton::Primary, NONE, origin, vec2(points, 0.0));
    assert_eq!(line(&harness), turned.replace("-1, 0>", "-2, 0>").replace("1, 0>, radius 0.5", "2, 0>, radius 1"));
    harness.state_mut().perform(Action::Undo);
    harness.state_mut().perform(Action::Undo);
    harness.state_mut().perform(Action::Undo);
    assert_eq!(line(&harness), turned);
}

#[test]
fn every_shape_is_moved_turned_and_scaled_by_handles() {
    for row in Shape::SYNTAX {
        let written = format!("b: {};", row.example);
        let mut harness = seen_from_above(&written, HandleTool::Move);
        let before = scene(&harness).bodies[0].form.clone();
        let view = harness.state().scene_view();
        let (_, tip) = view.arrows().expect("arrows").tips[0];
        drag(&mut harness, PointerButton::Primary, NONE, tip, vec2(40.0, 0.0));
        let moved = scene(&harness).bodies[0].form.clone();
        let by = moved.anchor().expect("a place") - before.anchor().expect("a place");
        assert!(by.x > 0.1 && by.y == 0.0 && by.z == 0.0, "{written} {by}");
        harness.state_mut().perform(Action::Undo);
        harness.state_mut().perform(Action::Scene(SceneAction::Handles(HandleTool::Rotate)));
        let [from, to] = quarter(&harness, DVec3::Y);
        drag(&mut harness, PointerButton::Primary, NONE, from, to - from);
        assert!(line(&harness).contains("rotate <0, 1, 0> 90"), "{}", line(&harness));
        harness.state_mut().perform(Action::Undo);
        harness.state_mut().perform(Action::Scene(SceneAction::Handles(HandleTool::Scale)));
        let FactorHandles { origin, tips, .. } = harness.state().scene_view().factor_handles().expect("handles");
        let (axis, tip) = tips[0];
        assert_eq!(axis, SceneAxis::X, "{written}");
        drag(&mut harness, PointerButton::Primary, NONE, tip, tip - origin);
        let wide = scene(&harness).bodies[0].form.clone();
        assert_ne!(wide, before);
        assert!(wide.anchor().expect("a place").abs_diff_eq(before.anchor().expect("a place"), 1e-3), "{wide}");
        harness.state_mut().perform(Action::Undo);
        drag(&mut harness, PointerButton::Primary, NONE, origin, vec2(0.0, -60.0));
        assert_ne!(line(&harness), written);
        harness.state_mut().perform(Action::Undo);
        assert_eq!(line(&harness), written, "each is one step");
    }
}

#[test]
fn keys_and_the_row_in_the_picture_choose_the_handles() {
    let mut harness = seen_from_above("b: box, <-1, 0, -1>, <1, 2, 1>;", HandleTool::Move);
    let shown = |harness: &Harness<'_, App>| {
        let view = harness.state().scene_view();
        [view.arrows().is_some(), view.rings().is_some(), view.factor_handles().is_some()]
    };
    assert_eq!(shown(&harness), [true, false, false]);
    for (key, expected) in [(Key::E, [false, true, false]), (Key::R, [false, false, true]), (Key::W, [true, false, false])] {
        harness.key_press(key);
        harness.run_steps(2);
        assert_eq!(shown(&harness), expected);
    }
    let camera = scene(&harness).camera;
    let rotate = harness.get_by_role_and_label(Role::Button, "Rotate").rect().center();
    drag(&mut harness, PointerButton::Primary, NONE, rotate, vec2(0.0, 0.0));
    assert_eq!(shown(&harness), [false, true, false]);
    drag(&mut harness, PointerButton::Primary, NONE, rotate, vec2(30.0, 60.0));
    assert!(scene(&harness).camera == camera, "a drag that begins on the row is none on the picture");
    // Nothing to turn, nothing to choose.
    harness.state_mut().parameters.select(OwnerId::Global);
    harness.run_steps(2);
    assert!(harness.query_by_role_and_label(Role::Button, "Rotate").is_none() && shown(&harness) == [false; 3]);
    // A light has arrows whatever the handles of bodies are.
    harness.state_mut().parameters.select(OwnerId::Light(crate::scene::LightId(0)));
    harness.state_mut().perform(Action::Scene(SceneAction::View(ViewSide::Front)));
    harness.state_mut().perform(Action::Scene(SceneAction::Frame));
    harness.run_steps(2);
    assert_eq!(shown(&harness), [true, false, false]);
    // Where a text is typed, the keys are letters.
    harness.state_mut().editor.focus();
    harness.run_steps(2);
    harness.key_press(Key::R);
    harness.run_steps(2);
    assert_eq!(harness.state().hand.tool(), HandleTool::Rotate);
}

#[test]
fn every_shape_that_is_added_stands_in_view_on_what_is_there() {
    for row in Shape::SYNTAX {
        let mut harness = harness();
        let floor = "floor: rectangle, <-8, 0, -8>, <8, 0, -8>, <8, 0, 8>;";
        let camera = "position <0, 3, 9>; gaze <0, -0.3, -1>; up <0, 1, 0>; fov 45;";
        let text = format!("bodies; {floor} lights; key: point, <3,9,4>; camera; {camera}");
        harness.state_mut().documents.scene.replace_text(&text);
        harness.state_mut().apply(TextTab::Scene);
        settle(&mut harness);
        harness.state_mut().perform(Action::Scene(SceneAction::AddBody(row.keyword.word)));
        harness.run_steps(2);
        let world = harness.state().workshop.world();
        let bounds = world.bounds(BodyId(1));
        let view = harness.state().scene_view();
        // A cut gem is deeper than it is high, so it hovers a little; what is flat is above the floor too.
        assert!(bounds.low.y > -0.01 && bounds.low.y < 1.2, "{}: {bounds:?}", row.keyword.word);
        let [low, high] = [bounds.low, bounds.high].map(|point| view.project(point).expect("before the camera"));
        assert!(view.picture().contains(low) && view.picture().contains(high), "{}", row.keyword.word);
        assert_eq!(harness.state().selected_object(), Some(SceneObject::Body(BodyId(1))));
    }
}

#[test]
fn what_is_added_before_a_wall_stands_in_front_of_it() {
    let mut harness = harness();
    let bodies = "floor: rectangle, <-8, 0, -8>, <8, 0, -8>, <8, 0, 8>; wall: box, <-2, 0, -1>, <2, 4, 0>;";
    let camera = "position <0, 2, 9>; gaze <0, -0.05, -1>; up <0, 1, 0>; fov 45;";
    let text = format!("bodies; {bodies} lights; key: point, <3,9,4>; camera; {camera}");
    harness.state_mut().documents.scene.replace_text(&text);
    harness.state_mut().apply(TextTab::Scene);
    settle(&mut harness);
    harness.state_mut().perform(Action::Scene(SceneAction::AddBody("box")));
    let bounds = harness.state().workshop.world().bounds(BodyId(2));
    // The wall is seen at its front, z = 0.
    assert!(bounds.low.y.abs() < 1e-3 && bounds.low.z > -1e-3 && bounds.high.z < 3.0, "{bounds:?}");
}
