//! The scene under the mouse: gestures in the picture lead the camera, and move bodies and lights.
//!
//! A `gesture` says which scene follows from where the pointer is. `view` says where things are on the screen, and
//! what can be taken hold of. `markers` and `outline` draw. Here, the mouse and the keys begin, move and end gestures.
//! When a gesture ends, the text of the scene follows (`scene_text`).

pub(super) mod gesture;
mod handles;
mod keys;
mod light_shapes;
mod markers;
mod object;
mod outline;
pub(super) mod sight;
#[cfg(test)]
mod tests;
mod tool_row;
pub(super) mod view;

use crate::preview::app::{Action, App, HandleTool, scene_menu};
use crate::scene::edit::SceneObject;
use crate::workspace::OwnerId;
use crate::world::World;
use egui::{CursorIcon, Key, Modifiers, PointerButton, Pos2, Response, Ui};
use gesture::{Gesture, Motion, SceneAxis, Travel};
use outline::Outline;
use sight::{pivot, seen_at};
use std::sync::Arc;
use view::{Grip, SceneView};

/// A drag over the whole pane turns the camera by this angle, in radians.
const TURN: f32 = std::f32::consts::PI;
/// A drag of this many points makes a distance or the field of view e times as large.
const FACTOR_POINTS: f32 = 180.0;
/// One notch of the wheel makes the distance this many times as large.
const NOTCH: f64 = 0.9;
/// Turns of the wheel and keys that follow within this time are one gesture, in seconds.
const PAUSE: f64 = 0.5;
/// After a selection, its outline is shown for this time, even if the pointer is elsewhere. In seconds.
const SHOWN_AFTER_SELECTION: f64 = 1.2;

/// What ends a gesture.
#[derive(Debug, Clone, Copy, PartialEq)]
enum GestureEnd {
    /// The button is released.
    Release(PointerButton),
    /// Nothing follows until this time, in seconds of egui's clock.
    Pause(f64),
}

/// The hand that leads the camera and moves things.
pub(super) struct Hand {
    gesture: Option<(Gesture, GestureEnd)>,
    /// Whether markers are shown.
    pub(super) markers: bool,
    /// What handles do.
    tool: HandleTool,
    /// What is selected, and when it was.
    selected: (Option<SceneObject>, f64),
    /// What was just added: it is marked until the pointer comes over the picture, or a value is moved.
    pub(super) added: Option<SceneObject>,
    outline: CachedOutline,
}

/// The outline of the selected body, with what it was made from.
#[derive(Default)]
struct CachedOutline {
    made_from: Option<(Arc<World>, SceneObject, f64)>,
    outline: Outline,
}

impl Default for Hand {
    fn default() -> Self {
        Self {
            gesture: None,
            markers: true,
            tool: HandleTool::default(),
            selected: (None, f64::NEG_INFINITY),
            added: None,
            outline: CachedOutline::default(),
        }
    }
}

impl Hand {
    /// What handles do.
    pub(super) fn tool(&self) -> HandleTool {
        self.tool
    }

    /// Uses other handles, which are shown.
    pub(super) fn use_tool(&mut self, tool: HandleTool) {
        (self.tool, self.markers) = (tool, true);
    }
}

impl CachedOutline {
    fn update(&mut self, world: &Arc<World>, selected: Option<SceneObject>, aspect: f64) {
        let Some(object @ SceneObject::Body(id)) = selected.filter(|_| aspect.is_finite() && aspect > 0.0) else {
            *self = Self::default();
            return;
        };
        let same =
            |(of, body, with): &(Arc<World>, SceneObject, f64)| Arc::ptr_eq(of, world) && *body == object && *with == aspect;
        if !self.made_from.as_ref().is_some_and(same) {
            self.outline = Outline::of(world, id, aspect);
            self.made_from = Some((Arc::clone(world), object, aspect));
        }
    }
}

/// The body or light that owns parameters.
pub(super) fn object_of(owner: OwnerId) -> Option<SceneObject> {
    match owner {
        OwnerId::Global => None,
        OwnerId::Body(id) => Some(SceneObject::Body(id)),
        OwnerId::Light(id) => Some(SceneObject::Light(id)),
    }
}

/// The owner of the parameters of a body or light.
pub(super) fn owner_of(object: SceneObject) -> OwnerId {
    match object {
        SceneObject::Body(id) => OwnerId::Body(id),
        SceneObject::Light(id) => OwnerId::Light(id),
    }
}

/// What a button does with these modifiers. `grip` is what is under the pointer. On a handle, Ctrl snaps.
fn motion_of(button: PointerButton, modifiers: Modifiers, grip: Option<Grip>) -> Option<Motion> {
    let on_handle = grip.is_some_and(Grip::is_handle) && !modifiers.shift && !modifiers.alt;
    match button {
        PointerButton::Primary if modifiers.ctrl && modifiers.shift => Some(Motion::FieldOfView),
        PointerButton::Primary if modifiers.ctrl && !on_handle => Some(Motion::Dolly),
        PointerButton::Primary if modifiers.shift => Some(Motion::Pan),
        PointerButton::Primary if modifiers.alt => Some(Motion::Orbit),
        PointerButton::Primary => Some(grip.map_or(Motion::Orbit, motion_by)),
        PointerButton::Middle => Some(Motion::Pan),
        PointerButton::Secondary if modifiers.ctrl || modifiers.shift => Some(Motion::FieldOfView),
        PointerButton::Secondary => Some(Motion::Dolly),
        PointerButton::Extra1 | PointerButton::Extra2 => None,
    }
}

/// What is moved by something that is taken hold of.
fn motion_by(grip: Grip) -> Motion {
    match grip {
        Grip::Object(object) => Motion::Move(object, None),
        Grip::Arrow(object, axis) => Motion::Move(object, Some(axis)),
        Grip::Target(id) => Motion::Aim(id, None),
        Grip::Radius(object) => Motion::Resize(object),
        Grip::Ring(object, axis) => Motion::Turn(object, axis),
        Grip::Factor(object, axis) => Motion::Stretch(object, axis),
        Grip::Middle(object) => Motion::Grow(object),
    }
}

/// What is held while a gesture lasts; `None` if it leads the camera.
fn grip_of(motion: Motion) -> Option<Grip> {
    match motion {
        Motion::Move(object, None) => Some(Grip::Object(object)),
        Motion::Move(object, Some(axis)) => Some(Grip::Arrow(object, axis)),
        Motion::Aim(id, _) => Some(Grip::Target(id)),
        Motion::Resize(object) => Some(Grip::Radius(object)),
        Motion::Turn(object, axis) => Some(Grip::Ring(object, axis)),
        Motion::Stretch(object, axis) => Some(Grip::Factor(object, axis)),
        Motion::Grow(object) => Some(Grip::Middle(object)),
        Motion::Orbit | Motion::Pan | Motion::Dolly | Motion::FieldOfView => None,
    }
}

/// The axis whose key is held.
fn axis_key(ui: &Ui) -> Option<SceneAxis> {
    let keys = [(Key::X, SceneAxis::X), (Key::Y, SceneAxis::Y), (Key::Z, SceneAxis::Z)];
    ui.input(|input| keys.into_iter().find(|(key, _)| input.key_down(*key)).map(|(_, axis)| axis))
}

impl App {
    /// The selected body or light.
    pub(super) fn selected_object(&self) -> Option<SceneObject> {
        let owner = self.parameters.selected();
        object_of(owner).filter(|_| self.workshop.values().table().owners().has(owner))
    }

    /// Handles the mouse and the keys over the picture, and draws the markers. `keys` says whether keys are for the
    /// scene.
    pub(super) fn scene_by_hand(&mut self, ui: &Ui, keys: bool, actions: &mut Vec<Action>) {
        let Some(response) = &self.pane.response() else { return };
        let now = ui.input(|input| input.time);
        let selected = self.selected_object();
        if self.hand.selected.0 != selected {
            self.hand.selected = (selected, now);
        }
        if self.hand.added != selected || response.contains_pointer() || self.workshop.held().is_some() {
            self.hand.added = None;
        }
        let leads = self.pane.leads_scene(ui) && self.workshop.shown().version > 0;
        if !leads && self.hand.gesture.is_none() {
            return;
        }
        let [width, height] = self.pane.placement(&self.workshop).full().map(f64::from);
        self.hand.outline.update(self.workshop.world(), selected, width / height);
        if self.hand.gesture.is_some() {
            self.go_on(ui);
        }
        let grip = response.hover_pos().and_then(|at| self.scene_view().grip_at(at, self.hand.markers));
        self.begin_by_mouse(ui, response);
        if keys {
            self.begin_by_keys(ui, response);
        }
        self.show_hand(ui, response, grip);
        self.tool_row(ui, actions);
        if response.clicked()
            && let Some(Grip::Object(object @ SceneObject::Light(_))) = grip
        {
            self.parameters.select(owner_of(object));
        }
        if response.secondary_clicked()
            && let Some(at) = response.interact_pointer_pos()
        {
            let body = seen_at(self.workshop.world(), self.scene_view().image_point(at)).map(|(body, _)| SceneObject::Body(body));
            let object = match grip {
                Some(Grip::Object(object)) => Some(object),
                Some(
                    Grip::Arrow(..) | Grip::Target(_) | Grip::Radius(_) | Grip::Ring(..) | Grip::Factor(..) | Grip::Middle(_),
                )
                | None => body,
            };
            self.parameters.select(object.map_or(OwnerId::Global, owner_of));
        }
        response.context_menu(|ui| scene_menu::entries(ui, self, actions));
    }

    /// The scene as it is on the screen.
    pub(super) fn scene_view(&self) -> SceneView<'_> {
        SceneView {
            world: self.workshop.world(),
            placement: self.pane.placement(&self.workshop),
            area: self.pane.area(),
            selected: self.selected_object(),
            tool: self.hand.tool,
            outline: &self.hand.outline.outline,
        }
    }

    /// Draws the markers, and gives the pointer its shape.
    fn show_hand(&self, ui: &Ui, response: &Response, grip: Option<Grip>) {
        let held = self.hand.gesture.as_ref().map(|(gesture, _)| gesture.motion);
        let cursor = match held {
            Some(motion) => Some(if grip_of(motion).is_some() { CursorIcon::Move } else { CursorIcon::Grabbing }),
            None => grip.map(|_| CursorIcon::Move),
        };
        if let Some(cursor) = cursor.filter(|_| response.hovered() || held.is_some()) {
            ui.ctx().set_cursor_icon(cursor);
        }
        let left = self.hand.selected.1 + SHOWN_AFTER_SELECTION - ui.input(|input| input.time);
        let just_added = self.hand.added.is_some();
        if self.hand.markers && (response.contains_pointer() || held.is_some() || just_added || left > 0.0) {
            let grip = held.map_or(grip, grip_of);
            let view = self.scene_view();
            let gesture = self.hand.gesture.as_ref().map(|(gesture, _)| gesture);
            markers::draw(&ui.painter_at(view.area), &view, grip, gesture);
            if left > 0.0 {
                ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(left));
            }
        }
    }

    /// Begins a gesture with a button or with the wheel.
    fn begin_by_mouse(&mut self, ui: &Ui, response: &Response) {
        let buttons = [PointerButton::Primary, PointerButton::Middle, PointerButton::Secondary];
        let started = buttons.into_iter().find(|button| response.drag_started_by(*button));
        let (origin, modifiers) = ui.input(|input| (input.pointer.press_origin(), input.modifiers));
        if let (Some(button), Some(at)) = (started, origin.or(response.interact_pointer_pos())) {
            let grip = self.scene_view().grip_at(at, self.hand.markers);
            if let Some(motion) = motion_of(button, modifiers, grip) {
                let held = grip.filter(|_| grip_of(motion).is_some());
                self.begin_gesture(motion, at, held, GestureEnd::Release(button));
                self.go_on(ui);
            }
        }
        if let Some(at) = response.hover_pos() {
            let notches = ui.input(|input| input.events.iter().map(wheel_notches).sum::<i32>());
            if notches != 0 {
                self.pulse(ui, Motion::Dolly, at, [0.0, f64::from(notches) * NOTCH.ln()]);
            }
        }
    }

    /// Begins a gesture at a position of the screen. Nothing happens if the text of the scene cannot follow.
    fn begin_gesture(&mut self, motion: Motion, at: Pos2, grip: Option<Grip>, end: GestureEnd) {
        self.end_gesture();
        if !self.scene_text_can_follow() {
            return;
        }
        let selected = self.selected_object();
        let view = self.scene_view();
        let from = view.image_point(at);
        let pivot = match grip {
            Some(grip) => view.held_point(grip, at),
            None => pivot(view.world, from, selected),
        };
        let gesture = Gesture {
            motion,
            begun: motion,
            start: Arc::clone(view.world),
            pivot,
            travel: Travel { from, to: from, amount: [0.0; 2] },
            reach: handles::RING * view.reach_at(pivot),
            snaps: false,
        };
        if let Motion::Move(object, _) = motion {
            self.parameters.select(owner_of(object));
        }
        self.hand.gesture = Some((gesture, end));
    }

    /// A turn of the wheel or a key: goes on with its gesture, or begins it.
    fn pulse(&mut self, ui: &Ui, motion: Motion, at: Pos2, amount: [f64; 2]) {
        let now = ui.input(|input| input.time);
        let goes_on = |(gesture, end): &(Gesture, GestureEnd)| gesture.motion == motion && matches!(end, GestureEnd::Pause(_));
        if !self.hand.gesture.as_ref().is_some_and(goes_on) {
            if self.hand.gesture.as_ref().is_some_and(|(_, end)| matches!(end, GestureEnd::Release(_))) {
                // A button is held.
                return;
            }
            self.begin_gesture(motion, at, None, GestureEnd::Pause(now));
        }
        let Some((gesture, end)) = &mut self.hand.gesture else { return };
        *end = GestureEnd::Pause(now + PAUSE);
        match motion {
            Motion::Pan => gesture.travel.to = [0, 1].map(|axis| gesture.travel.to[axis] + amount[axis]),
            Motion::Orbit
            | Motion::Dolly
            | Motion::FieldOfView
            | Motion::Move(..)
            | Motion::Aim(..)
            | Motion::Resize(_)
            | Motion::Turn(..)
            | Motion::Stretch(..)
            | Motion::Grow(_) => {
                gesture.travel.amount = [0, 1].map(|axis| gesture.travel.amount[axis] + amount[axis]);
            }
        }
        self.show_gesture();
        ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(PAUSE));
    }

    /// Goes on with the gesture, ends it, or cancels it.
    fn go_on(&mut self, ui: &Ui) {
        if ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape)) {
            self.cancel_gesture();
            return;
        }
        let (pointer, now) = ui.input(|input| (input.pointer.clone(), input.time));
        let to = pointer.latest_pos().map(|at| (at, self.scene_view().image_point(at)));
        let from = pointer.press_origin();
        let area = self.pane.area();
        let (axis, snaps) = (axis_key(ui), ui.input(|input| input.modifiers.ctrl));
        let Some((gesture, end)) = &mut self.hand.gesture else { return };
        let ended = match *end {
            GestureEnd::Release(button) => !pointer.button_down(button),
            GestureEnd::Pause(until) => now >= until,
        };
        if let (GestureEnd::Release(_), Some((at, to)), Some(from)) = (*end, to, from) {
            let before = (gesture.travel, gesture.motion, gesture.snaps);
            let moved = at - from;
            let turn = moved * TURN / area.size().min_elem().max(1.0);
            gesture.travel.to = to;
            gesture.snaps = snaps && grip_of(gesture.motion).is_some();
            gesture.travel.amount = match gesture.motion {
                Motion::Dolly | Motion::FieldOfView => [0.0, f64::from(moved.y / FACTOR_POINTS)],
                // To the right or upwards.
                Motion::Grow(_) => [0.0, f64::from((moved.x - moved.y) / FACTOR_POINTS)],
                Motion::Orbit
                | Motion::Pan
                | Motion::Move(..)
                | Motion::Aim(..)
                | Motion::Resize(_)
                | Motion::Turn(..)
                | Motion::Stretch(..) => [-f64::from(turn.x), f64::from(turn.y)],
            };
            gesture.motion = match (gesture.begun, axis) {
                (Motion::Move(object, _), Some(axis)) => Motion::Move(object, Some(axis)),
                (Motion::Aim(id, _), Some(axis)) => Motion::Aim(id, Some(axis)),
                (begun, _) => begun,
            };
            if (gesture.travel, gesture.motion, gesture.snaps) != before {
                self.show_gesture();
            }
        } else if let GestureEnd::Pause(until) = *end {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64((until - now).max(0.0)));
        }
        if ended {
            self.end_gesture();
        }
    }

    /// Shows the scene as the gesture has it now.
    fn show_gesture(&mut self) {
        let Some((gesture, _)) = &self.hand.gesture else { return };
        if self.workshop.moving().is_none() && !Arc::ptr_eq(&gesture.start, self.workshop.world()) {
            // Another scene was opened meanwhile.
            self.hand.gesture = None;
            return;
        }
        // A scene that cannot be is not shown; the one before stays.
        if let Some(scene) = gesture.moved() {
            self.workshop.show_moving(&gesture.what(), scene);
        }
    }

    /// Ends the gesture. The text of the scene follows.
    pub(super) fn end_gesture(&mut self) {
        let Some((gesture, _)) = self.hand.gesture.take() else { return };
        // Whoever opened another scene meanwhile has ended the movement.
        if self.workshop.moving().is_none() {
            return;
        }
        match gesture.change() {
            Some(change) => self.change_scene(&change, gesture.precision()),
            None => self.workshop.put_back(),
        }
    }

    /// Ends the gesture. The scene is as it was before.
    pub(super) fn cancel_gesture(&mut self) {
        if self.hand.gesture.take().is_some() {
            self.workshop.put_back();
        }
    }
}

/// How far a wheel event turns, unless it zooms the picture. 1 is one notch away from the user.
fn wheel_notches(event: &egui::Event) -> i32 {
    let egui::Event::MouseWheel { delta, modifiers, .. } = event else { return 0 };
    if modifiers.ctrl { 0 } else { i32::from(delta.y > 0.0) - i32::from(delta.y < 0.0) }
}
