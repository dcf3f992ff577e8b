//! The scene under the mouse, without a window.

mod handles;
mod lights;

use crate::files::Readable;
use crate::preview::app::tests::settle;
use crate::preview::app::{Action, App, SceneAction};
use crate::preview::workshop::OpenedSession;
use crate::scene::edit::SceneObject;
use crate::scene::{Scene, ViewSide};
use crate::workspace::{Location, OwnerId};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use glam::DVec3;

fn harness() -> Harness<'static, App> {
    let app = App::new(Some(&Location::Preset("studio".to_owned())), None).expect("a built-in session");
    let builder = Harness::builder().with_size(vec2(1100.0, 700.0)).with_step_dt(0.02);
    let mut harness = builder.build_ui_state(|ui, app: &mut App| app.draw(ui), app);
    let workshop = &mut harness.state_mut().workshop;
    let small = crate::workspace::session::PictureSettings { size: [96, 64], depth: 2, samples: Some(1), ..workshop.settings() };
    workshop.set_picture(small).expect("a size in range");
    settle(&mut harness);
    // The controls under the picture may need another line, once its zoom is known.
    harness.run_steps(3);
    harness
}

fn scene(harness: &Harness<'_, App>) -> Scene {
    Scene::clone(harness.state().workshop.scene())
}

fn text(harness: &Harness<'_, App>) -> String {
    harness.state().documents.scene.text().to_owned()
}

/// Where a point of the scene is on the screen.
fn at(harness: &Harness<'_, App>, point: DVec3) -> Pos2 {
    harness.state().scene_view().project(point).expect("a point before the camera")
}

fn button(pos: Pos2, button: PointerButton, pressed: bool, modifiers: Modifiers) -> Event {
    Event::PointerButton { pos, button, pressed, modifiers }
}

/// Presses a button, and moves in steps; the button stays down.
fn press_and_move(harness: &mut Harness<'_, App>, with: PointerButton, modifiers: Modifiers, from: Pos2, by: Vec2) {
    harness.event(Event::PointerMoved(from));
    harness.step();
    harness.event(Event::ModifiersChanged(modifiers));
    harness.event(button(from, with, true, modifiers));
    harness.step();
    for step in 1..=5 {
        harness.event(Event::PointerMoved(from + by * (step as f32 / 5.0)));
        harness.step();
    }
}

fn release(harness: &mut Harness<'_, App>, with: PointerButton, modifiers: Modifiers, at: Pos2) {
    harness.event(button(at, with, false, modifiers));
    harness.step();
    harness.event(Event::ModifiersChanged(Modifiers::NONE));
    harness.run_steps(2);
}

fn drag(harness: &mut Harness<'_, App>, with: PointerButton, modifiers: Modifiers, from: Pos2, by: Vec2) {
    press_and_move(harness, with, modifiers, from, by);
    release(harness, with, modifiers, from + by);
}

const NONE: Modifiers = Modifiers::NONE;

#[test]
fn a_drag_orbits_and_one_undo_brings_text_and_picture_back() {
    let mut harness = harness();
    let (first, written, before) = (settle(&mut harness), text(&harness), scene(&harness));
    let ball = before.bodies[1].form.anchor().expect("a centre");
    let from = at(&harness, ball);
    let view = harness.state().scene_view();
    let (body, seen) = super::sight::seen_at(view.world, view.image_point(from)).expect("a point of the ball");
    assert_eq!(body.0, 1);
    press_and_move(&mut harness, PointerButton::Primary, NONE, from, vec2(120.0, 30.0));
    assert!(harness.state().workshop.moving().is_some() && text(&harness) == written, "the text follows at the end");
    release(&mut harness, PointerButton::Primary, NONE, from + vec2(120.0, 30.0));
    let after = scene(&harness);
    assert!(harness.state().workshop.moving().is_none());
    assert!(after.camera != before.camera && after.bodies == before.bodies);
    // About the point that was seen: it stays there. Dragged to the right, the camera goes to the left, and up.
    assert!(at(&harness, seen).distance(from) < 1.0, "{:?} {from:?}", at(&harness, seen));
    assert!(after.camera.position().x < before.camera.position().x && after.camera.position().y > before.camera.position().y);
    // Only numbers of two lines of the camera are others.
    let changed: Vec<_> = written
        .lines()
        .zip(text(&harness).lines().map(str::to_owned))
        .filter(|(a, b)| a != b)
        .map(|(a, _)| a.trim().split(' ').next().map(str::to_owned))
        .collect();
    assert_eq!(changed, [Some("position".to_owned()), Some("gaze".to_owned())]);
    let moved = settle(&mut harness);
    assert!(moved != first && harness.state().is_unsaved());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(2);
    assert!(text(&harness) == written && settle(&mut harness) == first && scene(&harness).camera == before.camera);
    harness.state_mut().perform(Action::Redo);
    assert!(settle(&mut harness) == moved && harness.state().undo_and_redo_names()[1].is_none());
}

#[test]
fn every_button_has_its_motion_and_escape_gives_up() {
    let mut harness = harness();
    let before = scene(&harness).camera;
    let centre = harness.state().pane.area().center();
    let ctrl_shift = Modifiers::CTRL.plus(Modifiers::SHIFT);
    for (with, modifiers, moves, turns, widens) in [
        (PointerButton::Middle, NONE, true, false, false),
        (PointerButton::Primary, Modifiers::SHIFT, true, false, false),
        (PointerButton::Secondary, NONE, true, false, false),
        (PointerButton::Primary, Modifiers::CTRL, true, false, false),
        (PointerButton::Secondary, Modifiers::SHIFT, false, false, true),
        (PointerButton::Primary, ctrl_shift, false, false, true),
        (PointerButton::Primary, Modifiers::ALT, true, true, false),
    ] {
        drag(&mut harness, with, modifiers, centre, vec2(30.0, 60.0));
        let after = scene(&harness).camera;
        let seen = [after.position() != before.position(), after.gaze() != before.gaze(), after.fov() != before.fov()];
        assert_eq!(seen, [moves, turns, widens], "{with:?} {modifiers:?}");
        harness.state_mut().perform(Action::Undo);
        assert_eq!(scene(&harness).camera, before);
        press_and_move(&mut harness, with, modifiers, centre, vec2(30.0, 60.0));
        assert!(scene(&harness).camera != before);
        harness.key_press(Key::Escape);
        harness.run_steps(2);
        release(&mut harness, with, modifiers, centre + vec2(30.0, 60.0));
        assert_eq!(scene(&harness).camera, before);
        assert!(harness.state().undo_and_redo_names()[0].is_none(), "nothing was done");
    }
}

#[test]
fn the_wheel_goes_closer_and_turns_that_follow_are_one_step() {
    let mut harness = harness();
    let (before, written) = (scene(&harness).camera, text(&harness));
    let pearl = scene(&harness).bodies[2].form.anchor().expect("a centre");
    let from = at(&harness, pearl);
    let view = harness.state().scene_view();
    let (_, pearl) = super::sight::seen_at(view.world, view.image_point(from)).expect("a point of the pearl");
    harness.event(Event::PointerMoved(from));
    harness.step();
    for _ in 0..3 {
        let (unit, delta, phase) = (egui::MouseWheelUnit::Line, vec2(0.0, 1.0), egui::TouchPhase::Move);
        harness.event(Event::MouseWheel { unit, delta, phase, modifiers: NONE });
        harness.step();
    }
    let near = scene(&harness).camera;
    assert!(near.position().distance(pearl) < 0.8 * before.position().distance(pearl), "{near:?}");
    assert!(at(&harness, pearl).distance(from) < 1.0, "what is under the pointer stays there");
    // After a pause the text follows.
    for _ in 0..100 {
        harness.step();
    }
    assert!(text(&harness) != written && harness.state().workshop.moving().is_none());
    harness.state_mut().perform(Action::Undo);
    assert!(text(&harness) == written && scene(&harness).camera == before);
    // Arrow keys are the same.
    for _ in 0..2 {
        harness.key_press(Key::ArrowRight);
        harness.step();
    }
    harness.run_steps(100);
    assert!(scene(&harness).camera.position().x > before.position().x);
    harness.state_mut().perform(Action::Undo);
    assert!(text(&harness) == written);
}

#[test]
fn the_selected_body_is_dragged_and_resized_by_its_handles() {
    let mut harness = harness();
    let before = scene(&harness);
    let [ball, pearl] = [1, 2].map(|index| before.bodies[index].form.clone());
    let centre = at(&harness, pearl.anchor().expect("a centre"));
    harness.event(Event::PointerMoved(centre));
    harness.drag_at(centre);
    harness.step();
    harness.drop_at(centre);
    harness.run_steps(2);
    assert_eq!(harness.state().selected_object().map(|object| harness.state().name_of(object)), Some("pearl".to_owned()));
    // Beside the arrows, on the body itself.
    let grabbed = centre + vec2(-8.0, -8.0);
    drag(&mut harness, PointerButton::Primary, NONE, grabbed, vec2(-40.0, -20.0));
    let moved = scene(&harness).bodies[2].form.clone();
    assert_eq!(moved.radius(), pearl.radius());
    assert!(at(&harness, moved.anchor().expect("a centre")).distance(centre + vec2(-40.0, -20.0)) < 10.0);
    assert!(scene(&harness).bodies[1].form == ball && scene(&harness).camera == before.camera);
    harness.state_mut().perform(Action::Undo);
    assert_eq!(scene(&harness).bodies[2].form, pearl);
    // Along an axis, by the arrow and by the key.
    let arrows = harness.state().scene_view().arrows().expect("arrows");
    let (_, tip) = arrows.tips[1];
    drag(&mut harness, PointerButton::Primary, NONE, tip, vec2(25.0, -50.0));
    let along = scene(&harness).bodies[2].form.anchor().expect("a centre") - pearl.anchor().expect("a centre");
    assert!(along.x == 0.0 && along.z == 0.0 && along.y > 0.1, "{along}");
    harness.state_mut().perform(Action::Undo);
    harness.key_down(Key::Z);
    drag(&mut harness, PointerButton::Primary, NONE, grabbed, vec2(-40.0, -30.0));
    harness.key_up(Key::Z);
    let along = scene(&harness).bodies[2].form.anchor().expect("a centre") - pearl.anchor().expect("a centre");
    assert!(along.x == 0.0 && along.y == 0.0 && along.z != 0.0, "{along}");
    harness.state_mut().perform(Action::Undo);
    // The radius.
    harness.run_steps(2);
    let (_, handle) = harness.state().scene_view().radius_handle().expect("a handle");
    drag(&mut harness, PointerButton::Primary, NONE, handle, handle - centre);
    let larger = scene(&harness).bodies[2].form.clone();
    assert!(larger.anchor() == pearl.anchor());
    let ratio = larger.radius().expect("a radius") / pearl.radius().expect("a radius");
    assert!((ratio - 2.0).abs() < 0.05, "{ratio}");
    // The floor reaches beyond the picture: a drag on it orbits, though it is selected.
    harness.state_mut().perform(Action::Undo);
    harness.state_mut().parameters.select(OwnerId::Body(crate::scene::BodyId(0)));
    harness.run_steps(2);
    let below = harness.state().scene_view().picture().center_bottom() - vec2(60.0, 10.0);
    drag(&mut harness, PointerButton::Primary, NONE, below, vec2(60.0, 0.0));
    assert!(scene(&harness).bodies == before.bodies && scene(&harness).camera != before.camera);
}

#[test]
fn lights_have_markers_inside_and_outside_the_picture_and_are_dragged() {
    let mut harness = harness();
    let before = scene(&harness);
    let markers = harness.state().scene_view().light_markers();
    assert_eq!(markers.len(), 3);
    let room = harness.state().pane.area();
    assert!(markers.iter().all(|marker| room.contains(marker.at)), "{markers:?}");
    for marker in markers {
        let id = marker.light;
        drag(&mut harness, PointerButton::Primary, NONE, marker.at, vec2(-30.0, 20.0));
        let (old, new) = (&before.lights[id.index()].kind, &scene(&harness).lights[id.index()].kind);
        let by = new.anchor().expect("a place") - old.anchor().expect("a place");
        let [right, above, forward] = before.camera.axes();
        assert!(scene(&harness).camera == before.camera, "{marker:?} {:?}", harness.state().pane.area());
        assert!(by.dot(right) < -0.05 && by.dot(above) < -0.05 && by.dot(forward).abs() < 0.02, "{by}");
        assert_eq!(harness.state().selected_object(), Some(SceneObject::Light(id)));
        harness.state_mut().perform(Action::Undo);
        assert!(scene(&harness).lights == before.lights);
        harness.run_steps(2);
    }
}

#[test]
fn bodies_and_lights_are_added_copied_and_removed_with_their_values() {
    let mut harness = harness();
    let written = text(&harness);
    let act = |harness: &mut Harness<'_, App>, action| {
        harness.state_mut().perform(Action::Scene(action));
        harness.run_steps(2);
    };
    let selected = |harness: &Harness<'_, App>| harness.state().selected_object().map(|object| harness.state().name_of(object));
    let value = |harness: &Harness<'_, App>, label: &str| {
        let values = harness.state().workshop.values();
        let found = values.iter().find(|(owner, id, _)| values.table().label(*owner, *id) == label);
        found.map(|(_, _, value)| value.to_vec())
    };
    for (action, name) in [
        (SceneAction::AddBody("sphere"), "sphere"),
        (SceneAction::AddBody("rectangle"), "rectangle"),
        (SceneAction::AddBody("sphere"), "sphere2"),
        (SceneAction::AddLight("point"), "light"),
    ] {
        act(&mut harness, action);
        assert_eq!(selected(&harness).as_deref(), Some(name), "{}", text(&harness));
    }
    assert_eq!((scene(&harness).bodies.len(), scene(&harness).lights.len()), (6, 4));
    // What is new is in view, and not lost in a line.
    for body in scene(&harness).bodies.iter().skip(3) {
        let seen = at(&harness, body.form.anchor().expect("a centre"));
        assert!(harness.state().scene_view().picture().contains(seen), "{}", body.name);
    }
    for _ in 0..4 {
        harness.state_mut().perform(Action::Undo);
    }
    assert_eq!(text(&harness), written);
    // A copy has the values of the original.
    let ball = harness.state().workshop.values().table().owners().named("ball").expect("a body");
    harness.state_mut().parameters.select(ball);
    act(&mut harness, SceneAction::Duplicate);
    assert_eq!(selected(&harness).as_deref(), Some("ball2"));
    assert!(value(&harness, "ball2.Cd").is_some() && value(&harness, "ball2.Cd") == value(&harness, "ball.Cd"));
    assert!(text(&harness).lines().any(|line| line.trim_start().starts_with("ball2:") && line.ends_with("opaque;")));
    // Removed and brought back, the original has its own.
    let colour = value(&harness, "ball.Cd");
    let ball = harness.state().workshop.values().table().owners().named("ball").expect("a body");
    harness.state_mut().parameters.select(ball);
    act(&mut harness, SceneAction::Remove);
    assert!(value(&harness, "ball.Cd").is_none() && value(&harness, "ball2.Cd") == colour && selected(&harness).is_none());
    harness.state_mut().perform(Action::Undo);
    assert_eq!(value(&harness, "ball.Cd"), colour);
    harness.state_mut().perform(Action::Undo);
    assert_eq!(text(&harness), written);
}

#[test]
fn views_from_sides_framing_and_reset_are_steps_of_their_own() {
    let mut harness = harness();
    let (before, written) = (scene(&harness).camera, text(&harness));
    let act = |harness: &mut Harness<'_, App>, key| {
        harness.key_press(key);
        harness.run_steps(2);
        scene(harness).camera
    };
    let above = act(&mut harness, Key::Num5);
    assert_eq!((above.gaze().normalize(), above.up()), (DVec3::NEG_Y, DVec3::NEG_Z));
    let right = act(&mut harness, Key::Num3);
    assert!(right.gaze().normalize().abs_diff_eq(DVec3::NEG_X, 1e-3), "{right:?}");
    let pearl = harness.state().workshop.values().table().owners().named("pearl").expect("a body");
    harness.state_mut().parameters.select(pearl);
    let framed = act(&mut harness, Key::F);
    assert_eq!(framed.gaze(), right.gaze());
    let pearl = scene(&harness).bodies[2].form.clone();
    let [x, y] = framed.project(pearl.anchor().expect("a centre")).expect("before the camera");
    assert!(x.abs() < 0.01 && y.abs() < 0.01 && framed.position().distance(before.position()) > 0.1);
    let reset = act(&mut harness, Key::Home);
    assert_eq!(reset, before);
    for _ in 0..4 {
        harness.state_mut().perform(Action::Undo);
    }
    assert_eq!(text(&harness), written);
    assert!(harness.state().undo_and_redo_names()[0].is_none());
    harness.state_mut().perform(Action::Scene(SceneAction::View(ViewSide::Left)));
    assert!(harness.state().undo_and_redo_names()[0].is_some());
}

#[test]
fn changes_of_values_and_of_the_scene_are_undone_in_their_order() {
    let mut harness = harness();
    let values = |harness: &Harness<'_, App>| harness.state().workshop.values().numbers().to_vec();
    let (written, first) = (text(&harness), values(&harness));
    let set = |harness: &mut Harness<'_, App>, to: f32| {
        let ambient = harness.state().workshop.formula().predefined(crate::lang::variables::Predefined::Ambient);
        harness.state_mut().workshop.set(OwnerId::Global, ambient, [to; 3]);
    };
    set(&mut harness, 0.3);
    let second = values(&harness);
    harness.state_mut().perform(Action::Scene(SceneAction::View(ViewSide::Top)));
    let top = text(&harness);
    set(&mut harness, 0.7);
    let undo = |harness: &mut Harness<'_, App>| {
        harness.state_mut().perform(Action::Undo);
        (text(harness), values(harness))
    };
    assert_eq!(undo(&mut harness), (top.clone(), second.clone()));
    assert_eq!(undo(&mut harness), (written.clone(), second.clone()));
    assert_eq!(undo(&mut harness), (written.clone(), first));
    let redo = |harness: &mut Harness<'_, App>| {
        harness.state_mut().perform(Action::Redo);
        (text(harness), values(harness))
    };
    assert_eq!(redo(&mut harness), (written.clone(), second.clone()));
    assert_eq!(redo(&mut harness), (top, second));
    // Undone in the editor, the picture follows as well.
    assert!(harness.state_mut().documents.scene.move_by_hand(false));
    harness.run_steps(2);
    let original = Scene::parse(&crate::lang::source::Source::new("scene", written)).expect("a scene").0;
    assert_eq!(scene(&harness).camera, original.camera);
}

#[test]
fn a_text_that_cannot_follow_is_not_touched_and_one_that_can_is_applied() {
    let mut harness = harness();
    let before = scene(&harness);
    let broken = text(&harness).replace("lights;", "lihgts");
    harness.state_mut().documents.scene.replace_text(&broken);
    let centre = harness.state().pane.area().center();
    drag(&mut harness, PointerButton::Primary, NONE, centre, vec2(80.0, 0.0));
    assert!(text(&harness) == broken && scene(&harness) == before);
    assert!(harness.state().notices.shown().iter().any(|notice| notice.details.contains("the scene text has an error")));
    harness.state_mut().perform(Action::Scene(SceneAction::AddBody("sphere")));
    assert_eq!(text(&harness), broken);
    // Typed and not applied yet, but without a mistake.
    let typed = broken.replace("lihgts", "lights;").replace("fov 29", "fov 35 /* wider */");
    harness.state_mut().documents.scene.replace_text(&typed);
    drag(&mut harness, PointerButton::Primary, NONE, centre, vec2(80.0, 0.0));
    assert!(text(&harness).contains("fov 35 /* wider */") && scene(&harness).camera.fov() == 35.0);
    assert!(scene(&harness).camera.gaze() != before.camera.gaze() && harness.state().notices.is_empty());
    // Another session ends a gesture.
    press_and_move(&mut harness, PointerButton::Primary, NONE, centre, vec2(80.0, 0.0));
    let opened =
        OpenedSession::open(&Location::Preset("glass".to_owned()), Readable::Regular, &crate::workspace::AssetStore::default())
            .expect("a session");
    harness.state_mut().perform(Action::Confirmed(Box::new(Action::Open(
        crate::workspace::FileKind::Session,
        Location::Preset("glass".to_owned()),
    ))));
    let glass = text(&harness);
    release(&mut harness, PointerButton::Primary, NONE, centre + vec2(80.0, 0.0));
    assert_eq!((text(&harness), &scene(&harness)), (glass, &**opened.project.subject.world.scene()));
}

#[test]
fn what_was_added_is_marked_until_the_pointer_comes() {
    let mut harness = harness();
    harness.state_mut().perform(Action::Scene(SceneAction::AddBody("sphere")));
    harness.run_steps(100);
    let added = harness.state().hand.added;
    assert!(added.is_some() && added == harness.state().selected_object());
    let at = harness.state().pane.area().center();
    harness.hover_at(at);
    harness.run_steps(2);
    assert_eq!(harness.state().hand.added, None);
}
