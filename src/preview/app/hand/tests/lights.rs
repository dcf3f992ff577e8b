//! Lights of every kind are shown, moved, aimed, turned and scaled by hand.

use super::*;
use crate::preview::app::hand::gesture::SceneAxis;
use crate::preview::app::hand::handles::FactorHandles;
use crate::preview::app::hand::view::Grip;
use crate::preview::app::{HandleTool, tab::TextTab};
use crate::scene::{LightId, LightKind};

/// The window with a scene of a ball and these lights, seen from the front, with the first light selected.
fn with_lights(lights: &str, tool: HandleTool) -> Harness<'static, App> {
    let mut harness = harness();
    let text = format!(
        "bodies; ball: sphere, center <0, 0, 0>, radius 0.5;\nlights;\n{lights}\ncamera; position <0, 0, 9>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;\n"
    );
    harness.state_mut().documents.scene.replace_text(&text);
    harness.state_mut().apply(TextTab::Scene);
    assert_eq!(harness.state().documents.scene.counts()[0], 0, "{text}");
    harness.state_mut().parameters.select(OwnerId::Light(LightId(0)));
    harness.state_mut().perform(Action::Scene(SceneAction::Handles(tool)));
    settle(&mut harness);
    harness.run_steps(3);
    harness
}

const LIGHT: SceneObject = SceneObject::Light(LightId(0));

/// The line of the text that declares the first light.
fn line(harness: &Harness<'_, App>) -> String {
    text(harness).lines().nth(2).expect("a line").to_owned()
}

fn kind(harness: &Harness<'_, App>) -> LightKind {
    scene(harness).lights[0].kind.clone()
}

/// Ends a drag with Ctrl held.
fn release_snapped(harness: &mut Harness<'_, App>, at: Pos2) {
    harness.event(Event::ModifiersChanged(Modifiers::CTRL));
    harness.event(Event::PointerMoved(at));
    harness.step();
    release(harness, PointerButton::Primary, Modifiers::CTRL, at);
}

fn undo(harness: &mut Harness<'_, App>) {
    harness.state_mut().perform(Action::Undo);
    harness.run_steps(2);
}

#[test]
fn a_light_of_every_kind_is_dragged_copied_and_removed() {
    for row in LightKind::SYNTAX {
        // With the example in view.
        let written = format!(" l: {}; // here", row.example);
        let mut harness = with_lights(&written, HandleTool::Move);
        let before = kind(&harness);
        let markers = harness.state().scene_view().light_markers();
        if before.anchor().is_none() && before.direction().is_none() {
            assert!(markers.is_empty(), "it is all around: {written}");
            continue;
        }
        let [marker] = markers[..] else { panic!("{} markers", markers.len()) };
        assert_eq!(marker.light, LightId(0), "{written}");
        let grip = harness.state().scene_view().grip_at(marker.at, true);
        assert_eq!(grip, Some(Grip::Object(LIGHT)), "{written}");
        drag(&mut harness, PointerButton::Primary, NONE, marker.at, vec2(-30.0, 20.0));
        let after = kind(&harness);
        assert!(after != before && line(&harness).ends_with("; // here"), "{}", line(&harness));
        if let Some((old, new)) = before.anchor().zip(after.anchor()) {
            let by = new - old;
            assert!(by.x < -0.05 && by.y < -0.05 && by.z == 0.0 && after.size() == before.size(), "{written} {by}");
        }
        assert_eq!(after.target().is_some(), before.target().is_some());
        undo(&mut harness);
        assert_eq!(line(&harness), written, "one step");
        // With Ctrl meanwhile, to tenths or to 15 degrees.
        press_and_move(&mut harness, PointerButton::Primary, NONE, marker.at, vec2(-70.0, 90.0));
        release_snapped(&mut harness, marker.at + vec2(-71.0, 90.0));
        let snapped = kind(&harness);
        assert_ne!(snapped, before, "{written}");
        let is_whole = |number: f64| (number - number.round()).abs() < 1e-3;
        match before.anchor().zip(snapped.anchor()) {
            Some((old, new)) => assert!((10.0 * (new - old)).to_array().into_iter().all(is_whole), "{}", line(&harness)),
            None => {
                let direction = snapped.direction().expect("a direction");
                let angles = [direction.y.asin(), direction.x.atan2(direction.z)].map(|angle| angle.to_degrees() / 15.0);
                assert!(angles.into_iter().all(|angle| (angle - angle.round()).abs() < 2e-3), "{}", line(&harness));
            }
        }
        undo(&mut harness);
        for action in [SceneAction::Frame, SceneAction::View(ViewSide::Left), SceneAction::FrameAll] {
            harness.state_mut().perform(Action::Scene(action));
        }
        harness.state_mut().perform(Action::Scene(SceneAction::Duplicate));
        harness.run_steps(2);
        assert_eq!(harness.state().selected_object(), Some(SceneObject::Light(LightId(1))), "{}", text(&harness));
        let copy = scene(&harness).lights[1].clone();
        assert_eq!((copy.name.as_str(), copy.kind.size()), ("l2", before.size()));
        harness.state_mut().perform(Action::Scene(SceneAction::Remove));
        harness.run_steps(2);
        assert_eq!(scene(&harness).lights.len(), 1);
        assert_eq!(line(&harness), written);
    }
}

#[test]
fn a_light_of_every_kind_is_added_and_shines_on_what_is_seen() {
    for row in LightKind::SYNTAX {
        let mut harness = with_lights(" l: point, <9, 9, 9>;", HandleTool::Move);
        harness.state_mut().perform(Action::Scene(SceneAction::AddLight(row.keyword.word)));
        harness.run_steps(2);
        assert_eq!(harness.state().selected_object(), Some(SceneObject::Light(LightId(1))), "{}", text(&harness));
        let added = scene(&harness).lights[1].clone();
        assert!(added.name == "light" && added.kind.to_string().starts_with(row.keyword.word));
        // Above the left shoulder, 8.5 from the ball.
        if let Some(anchor) = added.kind.anchor() {
            assert!(anchor.x < -1.0 && anchor.y > 1.0 && anchor.z > 1.0 && anchor.length() < 9.0, "{anchor}");
        }
        if let Some(direction) = added.kind.direction() {
            let expected = DVec3::new(0.3, -0.5, -0.3).normalize();
            assert!(direction.abs_diff_eq(expected, 2e-3), "{direction}");
        }
        if let Some(size) = added.kind.size() {
            assert!((size - 1.7).abs() < 1e-3, "a fifth of the distance: {size}");
        }
        undo(&mut harness);
        assert_eq!(scene(&harness).lights.len(), 1);
    }
}

#[test]
fn the_target_of_a_spot_has_a_handle() {
    let mut harness = with_lights(" l: spot, <-1, 2, 0>, target <1, 0, 0>, angle 20, soft 5;", HandleTool::Move);
    let (id, at) = harness.state().scene_view().target_handle().expect("a handle");
    assert_eq!(harness.state().scene_view().grip_at(at, true), Some(Grip::Target(id)));
    drag(&mut harness, PointerButton::Primary, NONE, at, vec2(40.0, 0.0));
    let (position, target) = (kind(&harness).anchor().expect("a place"), kind(&harness).target().expect("a target"));
    assert!(position == DVec3::new(-1.0, 2.0, 0.0) && target.x > 1.1 && target.with_x(0.0) == DVec3::ZERO, "{target}");
    undo(&mut harness);
    harness.key_down(Key::Y);
    drag(&mut harness, PointerButton::Primary, NONE, at, vec2(40.0, 40.0));
    harness.key_up(Key::Y);
    let target = kind(&harness).target().expect("a target");
    assert!(target.y < -0.1 && target.with_y(0.0) == DVec3::X, "{target}");
    undo(&mut harness);
    // The marker takes the target along.
    let marker = harness.state().scene_view().light_markers()[0].at;
    drag(&mut harness, PointerButton::Primary, NONE, marker, vec2(40.0, 0.0));
    let moved = kind(&harness);
    let way = moved.target().expect("a target") - moved.anchor().expect("a place");
    assert!(way.abs_diff_eq(DVec3::new(2.0, -2.0, 0.0), 1e-9), "{way}");
    undo(&mut harness);
    // Rings turn the target about the light.
    harness.state_mut().perform(Action::Scene(SceneAction::Handles(HandleTool::Rotate)));
    assert!(harness.state().scene_view().rings().is_some());
    harness.state_mut().perform(Action::Scene(SceneAction::Handles(HandleTool::Scale)));
    let view = harness.state().scene_view();
    assert!(view.factor_handles().is_none() && view.arrows().is_some(), "it has no size");
}

#[test]
fn parallel_light_turns_about_the_middle_of_the_picture() {
    let mut harness = with_lights(" sun: directional, <0, -2, 0>;", HandleTool::Rotate);
    let view = harness.state().scene_view();
    let marker = view.light_markers()[0];
    let centre = view.picture().center();
    // The light comes from above.
    assert!((marker.at.x - centre.x).abs() < 1.0 && marker.at.y < centre.y - 50.0 && marker.outside.is_none(), "{marker:?}");
    assert!(view.arrows().is_none() && view.rings().is_none(), "it is nowhere");
    let radius = centre.y - marker.at.y;
    drag(&mut harness, PointerButton::Primary, NONE, marker.at, vec2(radius, 0.0));
    // From above and from the right alike, with a vector of the same length.
    let direction = kind(&harness).direction().expect("a direction");
    assert!(direction.abs_diff_eq(DVec3::new(-0.5, -0.5, 0.0).normalize(), 0.01), "{direction}");
    assert!(line(&harness).contains("sun: directional, <-1.4") && line(&harness).ends_with(", 0>;"), "{}", line(&harness));
    assert_eq!(harness.state().selected_object(), Some(LIGHT));
    undo(&mut harness);
    assert_eq!(line(&harness), " sun: directional, <0, -2, 0>;");
    // Towards the camera.
    harness.key_down(Key::Z);
    drag(&mut harness, PointerButton::Primary, NONE, marker.at, vec2(0.0, 30.0));
    harness.key_up(Key::Z);
    let direction = kind(&harness).direction().expect("a direction");
    assert!(direction.x.abs() < 1e-9 && direction.z.abs() > 0.05, "{direction}");
}

#[test]
fn areas_are_scaled_and_turned_by_their_handles() {
    let mut harness = with_lights(" l: sphere, center <1, 1, 0>, radius 0.5;", HandleTool::Move);
    let view = harness.state().scene_view();
    let (object, handle) = view.radius_handle().expect("a handle");
    let centre = at(&harness, DVec3::new(1.0, 1.0, 0.0));
    assert_eq!((object, view.grip_at(handle, true)), (LIGHT, Some(Grip::Radius(LIGHT))));
    drag(&mut harness, PointerButton::Primary, NONE, handle, handle - centre);
    let ratio = kind(&harness).radius().expect("a radius") / 0.5;
    assert!((ratio - 2.0).abs() < 0.05, "{ratio}");
    undo(&mut harness);
    harness.state_mut().perform(Action::Scene(SceneAction::Handles(HandleTool::Scale)));
    let FactorHandles { origin, tips, .. } = harness.state().scene_view().factor_handles().expect("a handle");
    assert!(tips.is_empty(), "it stays a sphere");
    drag(&mut harness, PointerButton::Primary, Modifiers::CTRL, origin, vec2(super::super::FACTOR_POINTS * 1.5_f32.ln(), 0.0));
    assert_eq!(line(&harness), " l: sphere, center <1, 1, 0>, radius 0.75;");

    let written = " l: rectangle, <-1, 1, 0>, <1, 1, 0>, <1, 2, 0>;";
    let mut harness = with_lights(written, HandleTool::Scale);
    let FactorHandles { origin, tips, .. } = harness.state().scene_view().factor_handles().expect("handles");
    assert_eq!(tips.iter().map(|(axis, _)| *axis).collect::<Vec<_>>(), [SceneAxis::X, SceneAxis::Y]);
    drag(&mut harness, PointerButton::Primary, NONE, tips[0].1, tips[0].1 - origin);
    assert_eq!(line(&harness), " l: rectangle, <-2, 1, 0>, <2, 1, 0>, <2, 2, 0>;");
    undo(&mut harness);
    drag(&mut harness, PointerButton::Primary, NONE, tips[1].1, tips[1].1 - origin);
    assert_eq!(line(&harness), " l: rectangle, <-1, 0.5, 0>, <1, 0.5, 0>, <1, 2.5, 0>;");
    undo(&mut harness);
    // A quarter turn about the axis that leads to the camera.
    harness.state_mut().perform(Action::Scene(SceneAction::Handles(HandleTool::Rotate)));
    let view = harness.state().scene_view();
    let middle = DVec3::new(0.0, 1.5, 0.0);
    let radius = super::super::handles::RING * view.reach_at(middle);
    let [from, to] = [37.0_f64, 127.0].map(|degrees| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        at(&harness, middle + radius * DVec3::new(cosine, sine, 0.0))
    });
    drag(&mut harness, PointerButton::Primary, NONE, from, to - from);
    assert_eq!(line(&harness), " l: rectangle, <0.5, 0.5, 0>, <0.5, 2.5, 0>, <-0.5, 2.5, 0>;");
    undo(&mut harness);
    assert_eq!(line(&harness), written);
}
