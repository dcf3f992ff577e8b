//! The text of the scene follows what is moved, added and removed in the picture and in menus; one step of undo each.

use crate::lang::variables::Owner;
use crate::preview::app::hand::owner_of;
use crate::preview::app::hand::sight::{distance, framing, from_side, pivot, place_to_stand};
use crate::preview::app::notices::{Notice, Topic};
use crate::preview::app::steps::OtherStep;
use crate::preview::app::tab::TextTab;
use crate::preview::app::{App, SceneAction};
use crate::scene::edit::{EditRefusal, Precision, SceneChange, SceneObject, edit, unused_name};
use crate::scene::{BodyForm, BodyId, Camera, LightKind, Scene, Shape, Syntax, Transform};
use crate::world::{Assets, Bounds, World};
use glam::DVec3;

/// The size of lights that are added, as a part of the distance of the scene.
const LIGHT_SIZE: f64 = 0.2;

impl App {
    /// Makes a change of the scene in its text, and applies it. If the text has errors, nothing changes.
    pub(super) fn change_scene(&mut self, change: &SceneChange, precision: Precision) {
        match edit(&self.documents.scene.source(), change, precision) {
            Ok(done) => {
                self.notices.clear(Topic::SceneText);
                if self.documents.scene.take_text_by_hand(&done.text) {
                    self.steps.note(OtherStep::SceneText, self.workshop.history_position());
                    self.follow_scene_text();
                } else {
                    self.workshop.put_back();
                }
            }
            Err(refusal) => {
                self.workshop.put_back();
                self.refuse_change(&refusal.to_string());
            }
        }
    }

    fn refuse_change(&mut self, reason: &str) {
        let title = "The scene was not changed: its text cannot follow";
        self.notify(Notice::warning(Topic::SceneText, title, reason));
    }

    /// Whether the text of the scene has no errors, so it can follow a gesture. If it is another one than that of the
    /// picture, it is applied.
    pub(super) fn scene_text_can_follow(&mut self) -> bool {
        let source = self.documents.scene.source();
        match Scene::parse(&source) {
            Ok((scene, _)) => {
                if scene != **self.workshop.scene() {
                    self.follow_scene_text();
                    self.log.add(format!("{}: applied, because the scene is moved", self.documents.scene.name()));
                }
                true
            }
            Err(errors) => {
                let first = errors.iter().next().map(|error| error.message().to_owned());
                self.refuse_change(&EditRefusal::Errors(first.unwrap_or_default()).to_string());
                false
            }
        }
    }

    /// Applies the text of the scene, if it has no errors. The selected body or light stays selected.
    pub(super) fn follow_scene_text(&mut self) {
        let owners = |app: &Self| app.workshop.values().table().owners().clone();
        let selected = owners(self).name(self.parameters.selected()).map(str::to_owned);
        let is_saved = !self.session_is_unsaved();
        let document = &mut self.documents.scene;
        document.check();
        let warnings = self.workshop.apply_scene(&document.source(), &document.place());
        let applied = warnings.is_ok();
        document.set_diagnostics(warnings.unwrap_or_else(|errors| errors));
        if applied {
            document.note_applied(true);
            self.note_mended(is_saved);
        }
        if applied && let Some(name) = selected {
            let owner = owners(self).named(&name).unwrap_or(crate::workspace::OwnerId::Global);
            if owner != self.parameters.selected() {
                self.parameters.select(owner);
            }
        }
    }

    /// Undoes or redoes the last step: of the scene, of a material or of a value, whichever is next.
    pub(super) fn move_in_history(&mut self, forwards: bool) {
        self.cancel_gesture();
        let position = self.workshop.history_position();
        match self.steps.next(forwards, position).cloned() {
            Some(OtherStep::SceneText) => {
                if self.documents.scene.move_by_hand(forwards) {
                    self.steps.pass(forwards, position);
                    self.documents.scene.take_by_hand_moved();
                    self.follow_scene_text();
                } else {
                    // The text was edited since: its own history knows what to undo.
                    self.steps.forget(&OtherStep::SceneText);
                    self.move_in_history(forwards);
                }
                return;
            }
            Some(OtherStep::Material(change)) => {
                self.steps.pass(forwards, position);
                self.move_material(&change, forwards);
                return;
            }
            None => {}
        }
        let _ = if forwards { self.workshop.redo() } else { self.workshop.undo() };
    }

    /// Performs an action on the scene.
    pub(super) fn perform_on_scene(&mut self, action: &SceneAction) {
        self.end_gesture();
        match action {
            SceneAction::ToggleMarkers => {
                self.hand.markers = !self.hand.markers;
                return;
            }
            SceneAction::Handles(tool) => {
                self.hand.use_tool(*tool);
                return;
            }
            SceneAction::Frame
            | SceneAction::FrameAll
            | SceneAction::View(_)
            | SceneAction::ResetCamera
            | SceneAction::AddBody(_)
            | SceneAction::AddLight(_)
            | SceneAction::Duplicate
            | SceneAction::Remove => {}
        }
        if !self.scene_text_can_follow() {
            return;
        }
        let selected = self.selected_object();
        let [width, height] = self.workshop.size().map(f64::from);
        let (world, aspect) = (self.workshop.world().clone(), width / height);
        match action {
            SceneAction::Frame => self.lead_camera(framing(&world, selected, aspect)),
            SceneAction::FrameAll => self.lead_camera(framing(&world, None, aspect)),
            SceneAction::View(side) => self.lead_camera(from_side(&world, *side, selected)),
            SceneAction::ResetCamera => match Scene::parse(&self.documents.scene.saved_source()) {
                Ok((saved, _)) => self.lead_camera(Some(saved.camera)),
                Err(_) => self.refuse_change("the saved text has errors, so it has no camera"),
            },
            SceneAction::AddBody(keyword) => self.add_body(keyword),
            SceneAction::AddLight(keyword) => self.add_light(keyword),
            SceneAction::Duplicate => selected.into_iter().for_each(|object| self.duplicate(object)),
            SceneAction::Remove => {
                selected.into_iter().for_each(|object| self.change_scene(&SceneChange::Remove(object), Precision::Exact));
            }
            SceneAction::ToggleMarkers | SceneAction::Handles(_) => {}
        }
    }

    fn lead_camera(&mut self, camera: Option<Camera>) {
        let Some(camera) = camera else { return };
        if camera != self.workshop.scene().camera {
            self.change_scene(&SceneChange::Camera(camera), Precision::for_size(self.view_distance()));
        }
    }

    /// How far away the scene is, in world units.
    fn view_distance(&self) -> f64 {
        distance(self.workshop.world())
    }

    /// Adds a body where the camera looks, as high as a fifth of the picture. It stands on what is seen there.
    fn add_body(&mut self, keyword: &str) {
        let Some(shape) =
            example(Shape::SYNTAX, keyword, |text| Some(scene_with(text, "")?.bodies.into_iter().next()?.form.shape))
        else {
            return;
        };
        let (camera, distance) = (&self.workshop.scene().camera, self.view_distance());
        let size = 0.2 * distance * (camera.fov().to_radians() / 2.0).tan();
        let (place, upright) = (place_to_stand(self.workshop.world(), [0.0, 0.0], size), camera.upright());
        let precision = Precision::for_size(distance);
        let name = unused_name(self.workshop.scene(), keyword);
        if shape.mesh().is_some() {
            let transforms = vec![Transform::Fit { center: precision.round(place + size * upright), size: 2.0 * size }];
            self.add(SceneChange::AddBody(name.clone(), BodyForm { shape, transforms }), precision, &name, Owner::Body);
            return;
        }
        let Some(bounds) = bounds_of(&shape) else { return };
        let scale = 2.0 * size / (bounds.high - bounds.low).max_element();
        let Some((shape, anchor)) = shape.scaled(scale).and_then(|shape| shape.anchor().map(|anchor| (shape, anchor))) else {
            return;
        };
        let half = 0.5 * scale * (bounds.high - bounds.low).dot(upright.abs());
        // What lies flat is raised, or it would lie in the floor.
        let height = if half < 0.2 * size { size } else { half };
        let middle = anchor + scale * (bounds.low.midpoint(bounds.high) - anchor);
        let Some(shape) = shape.moved(precision.round(place + height * upright - middle)) else { return };
        self.add(SceneChange::AddBody(name.clone(), shape.into()), precision, &name, Owner::Body);
    }

    /// Adds a light above the camera's left shoulder.
    fn add_light(&mut self, keyword: &str) {
        let Some(kind) = example(LightKind::SYNTAX, keyword, |text| Some(scene_with("", text)?.lights.into_iter().next()?.kind))
        else {
            return;
        };
        let (camera, distance) = (&self.workshop.scene().camera, self.view_distance());
        let [right, _, forward] = camera.axes();
        let middle = pivot(self.workshop.world(), [0.0, 0.0], None);
        let at = middle + distance * (0.5 * camera.upright() - 0.3 * right - 0.3 * forward);
        let precision = Precision::for_size(distance);
        let [at, middle, size] = [at, middle, DVec3::splat(LIGHT_SIZE * distance)].map(|vector| precision.round(vector));
        let name = unused_name(self.workshop.scene(), "light");
        self.add(SceneChange::AddLight(name.clone(), placed_light(kind, at, middle, size.x)), precision, &name, Owner::Light);
    }

    /// Adds something, with default values, and selects it.
    pub(super) fn add(&mut self, change: SceneChange, precision: Precision, name: &str, kind: Owner) {
        self.workshop.forget_values(kind, name);
        self.change_scene(&change, precision);
        self.select_named(name);
        self.hand.added = self.selected_object();
    }

    /// Adds a copy of a body or light beside it, with the same values, and selects it.
    fn duplicate(&mut self, object: SceneObject) {
        let (scene, world) = (self.workshop.scene().clone(), self.workshop.world().clone());
        let [right, ..] = scene.camera.axes();
        let (name, size) = match object {
            SceneObject::Body(id) if id.index() < scene.bodies.len() => {
                let bounds = world.bounds(id);
                // As wide as it is across the picture, with a gap. What is far larger than the picture moves little.
                let wide = (bounds.high - bounds.low).dot(right.abs());
                (&scene.body(id).name, (1.1 * wide).min(0.5 * self.view_distance()))
            }
            SceneObject::Light(id) if id.index() < scene.lights.len() => (&scene.light(id).name, 0.1 * self.view_distance()),
            SceneObject::Body(_) | SceneObject::Light(_) => return,
        };
        let name_of_copy = unused_name(&scene, name);
        self.workshop.forget_values(owner_of(object).kind(), &name_of_copy);
        let precision = Precision::for_size(self.view_distance());
        self.change_scene(&SceneChange::Duplicate(object, name_of_copy.clone(), size * right), precision);
        let owners = self.workshop.values().table().owners();
        if let (Some(from), Some(to)) = (owners.named(name), owners.named(&name_of_copy)) {
            self.workshop.copy_values(from, to);
            self.parameters.select(to);
            self.hand.added = self.selected_object();
        }
    }

    fn select_named(&mut self, name: &str) {
        if let Some(owner) = self.workshop.values().table().owners().named(name) {
            self.parameters.select(owner);
        }
    }

    /// Makes the picture follow, if a step of the scene's text was undone or redone in the editor.
    pub(super) fn follow_editor_undo(&mut self) {
        if self.documents.scene.take_by_hand_moved() {
            self.follow_scene_text();
            if self.tab == TextTab::Scene {
                self.notices.clear(Topic::SceneText);
            }
        }
    }

    /// The selected body or light, for menus.
    pub(super) fn name_of(&self, object: SceneObject) -> String {
        self.workshop.values().table().owners().name(owner_of(object)).unwrap_or_default().to_owned()
    }

    /// What the change is of that would be undone, and of that which would be redone; `None` if there is none.
    pub(super) fn undo_and_redo_names(&self) -> [Option<String>; 2] {
        let position = self.workshop.history_position();
        let [value, next_value] = self.workshop.undo_and_redo_names();
        let name = |forwards: bool, of_value: Option<String>| match self.steps.next(forwards, position) {
            Some(OtherStep::SceneText) => Some("the scene".to_owned()),
            Some(OtherStep::Material(change)) => Some(format!("the material {}", change.name)),
            None => of_value,
        };
        [name(false, value), name(true, next_value)]
    }
}

/// A light of the same kind at a place, of this size if it has one. One that shines in one direction shines towards the
/// middle.
fn placed_light(kind: LightKind, at: DVec3, middle: DVec3, size: f64) -> LightKind {
    let sized = kind.size().and_then(|own| kind.scaled(size / own)).unwrap_or(kind);
    let moved = sized.anchor().and_then(|anchor| sized.moved(at - anchor)).unwrap_or(sized);
    moved.aimed(at, middle).unwrap_or(moved)
}

/// A kind's example.
fn example<T>(kinds: &'static [Syntax<T>], keyword: &str, read: impl Fn(&str) -> Option<T>) -> Option<T> {
    kinds.iter().find(|kind| kind.keyword.word == keyword).and_then(|kind| read(kind.example))
}

/// A scene with a body and a light of these texts.
fn scene_with(body: &str, light: &str) -> Option<Scene> {
    let declared = |text: &str| if text.is_empty() { String::new() } else { format!("new: {text};") };
    let camera = "camera; position <0, 0, 9>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;";
    let text = format!("bodies; {} lights; {} {camera}", declared(body), declared(light));
    Scene::parse(&crate::lang::source::Source::new("example", text)).ok().map(|(scene, _)| scene)
}

/// The box around a shape that is no mesh.
fn bounds_of(shape: &Shape) -> Option<Bounds> {
    let world = World::new(scene_with(&shape.to_string(), "")?, &Assets::NONE).ok()?;
    Some(world.bounds(BodyId(0)))
}
