//! The workshop: a formula on a scene with its values, and what can be done with them.
//!
//! There are no widgets here. Pictures come from the [renderer](super::renderer). Whatever fails leaves the workshop
//! unchanged.

mod departed;
mod dependence;
mod export;
mod first_look;
mod history;
mod measured_picture;
mod moving;
mod opening;
mod reflection;
mod snapshots;
mod stand_ins;
mod thumbnail;
mod view_change;

use crate::backends::{BackendChoice, DEFAULT};
use crate::engine::{Engine, Subject, Task};
use crate::formula::{Formula, ParameterId};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::preview::renderer::{Picture, RenderRequest, Renderer};
use crate::scene::Scene;
use crate::trace::{View, ViewError, usable_memory};
use crate::workspace::AssetStore;
use crate::workspace::Location;
use crate::workspace::project::{Project, parse_scene_with_assets, view};
use crate::workspace::session::PictureSettings;
use crate::workspace::textures::parse_formula;
use crate::workspace::{Assignment, OwnerId, ParameterTable, Session, Values};
use crate::world::World;
use departed::DepartedValues;
pub use dependence::{MovingParameter, is_movable};
use export::ExportContent;
pub use export::PictureExport;
use history::{CurrentState, HistoryEntry, PastValues, ValueHistory, changed, changed_in_view};
use measured_picture::MeasuredPicture;
pub use measured_picture::MeasuredTwin;
use moving::MovingScene;
pub use opening::{OpenedSession, OpeningErrors};
pub use snapshots::Snapshot;
use stand_ins::StandIns;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
pub use thumbnail::Thumbnail;

/// What is open.
pub struct Workshop {
    renderer: Renderer,
    formula: Arc<Formula>,
    world: Arc<World>,
    values: Values,
    history: ValueHistory,
    picture: PictureSettings,
    /// The size of the picture in view, if that is not the size of the session.
    other_size: Option<[u32; 2]>,
    backend: BackendChoice,
    /// How many passes a picture is the mean of if the session does not say, at least 1.
    default_samples: u32,
    /// The memory that a picture may take, in bytes; `None` for half of what is free.
    memory: Option<u64>,
    /// The engines in use, each with its compiled code.
    engines: Vec<Engine>,
    /// The slider that is held.
    held: Option<(OwnerId, ParameterId)>,
    /// Whether a slider of the view transform is held.
    view_is_held: bool,
    shown: Picture,
    /// The stamp of the values that were requested last.
    requested: u64,
    snapshots: [Option<Snapshot>; 2],
    /// The picture with a measured material.
    measured: Option<MeasuredPicture>,
    /// The scene that is moved by hand, as it was before.
    moving: Option<MovingScene>,
    departed: DepartedValues,
    stand_ins: StandIns,
    /// What was read of the files that scenes name.
    assets: Arc<AssetStore>,
}

impl Workshop {
    /// Shows an open session, the files of which were read by way of this store. `wake` is called, from any thread,
    /// when there is something new to show.
    ///
    /// # Errors
    /// No thread can be started.
    pub fn new(project: &Project, assets: Arc<AssetStore>, wake: impl Fn() + Send + Sync + 'static) -> io::Result<Self> {
        let mut workshop = Self {
            renderer: Renderer::new(wake)?,
            formula: Arc::clone(&project.subject.formula),
            world: Arc::clone(&project.subject.world),
            values: project.values.clone(),
            history: ValueHistory::default(),
            picture: project.picture,
            other_size: None,
            backend: DEFAULT,
            default_samples: 1,
            memory: None,
            engines: Vec::new(),
            held: None,
            view_is_held: false,
            shown: Picture::default(),
            requested: 0,
            snapshots: [None, None],
            measured: None,
            moving: None,
            departed: DepartedValues::default(),
            stand_ins: StandIns::default(),
            assets,
        };
        workshop.request_picture();
        Ok(workshop)
    }

    /// Shows another session.
    pub fn open(&mut self, project: &Project) {
        self.formula = Arc::clone(&project.subject.formula);
        self.world = Arc::clone(&project.subject.world);
        self.values = project.values.clone();
        self.picture = project.picture;
        self.history = ValueHistory::default();
        self.snapshots = [None, None];
        self.measured = None;
        self.departed = DepartedValues::default();
        self.stand_ins = StandIns::default();
        self.request_picture();
    }

    /// Starts a new session with the same formula and scene, and with these settings and values.
    pub fn begin_session(&mut self, picture: PictureSettings, initial: impl FnOnce(&ParameterTable) -> Vec<Assignment>) {
        let given = initial(&ParameterTable::new(&self.formula, self.scene()));
        self.values = Values::new(&self.formula, self.scene(), &given).0;
        self.picture = if view(&picture).is_ok() { picture } else { self.picture };
        self.history = ValueHistory::default();
        self.snapshots = [None, None];
        self.measured = None;
        self.stand_ins.forget_values();
        self.request_picture();
    }

    /// The memory that a picture may take, in bytes; `None` for half of what is free.
    pub fn memory(&self) -> Option<u64> {
        self.memory
    }

    /// What was read of the files that scenes name.
    pub fn assets(&self) -> &Arc<AssetStore> {
        &self.assets
    }

    /// The renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The applied formula.
    pub fn formula(&self) -> &Arc<Formula> {
        &self.formula
    }

    /// The applied scene.
    pub fn scene(&self) -> &Arc<Scene> {
        self.world.scene()
    }

    /// The applied scene, ready for rays.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// The values of all parameters.
    pub fn values(&self) -> &Values {
        &self.values
    }

    /// The picture settings of the session.
    pub fn settings(&self) -> PictureSettings {
        self.picture
    }

    /// The backend that evaluates pictures.
    pub fn backend(&self) -> BackendChoice {
        self.backend
    }

    /// The view of the requested picture.
    ///
    /// # Errors
    /// A setting is out of range.
    pub fn view(&self) -> Result<View, ViewError> {
        view(&PictureSettings { size: self.size(), ..self.picture })
    }

    /// Width and height of the requested picture, in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.other_size.unwrap_or(self.picture.size)
    }

    /// Shows a picture of this size, or of the session's own size. The session keeps its size.
    pub fn show_size(&mut self, size: Option<[u32; 2]>) {
        let before = self.size();
        self.other_size = size;
        if self.size() != before {
            self.request_picture();
        }
    }

    fn request_picture(&mut self) {
        self.held = None;
        self.moving = None;
        self.request(false);
    }

    /// Requests a picture of the current formula, scene and values. `moves` says whether the scene is being moved.
    fn request(&mut self, moves: bool) {
        // The settings have been checked.
        let Ok(view) = self.view() else { return };
        let transform = self.picture.view;
        let samples = self.samples();
        let request = RenderRequest { subject: self.subject(view), engine: self.engine(), transform, moves, samples };
        self.requested = self.renderer.show(request, self.values.numbers());
    }

    fn subject(&self, view: View) -> Subject {
        Subject { formula: Arc::clone(&self.formula), world: Arc::clone(&self.world), view }
    }

    /// The engine of the chosen backend.
    pub fn engine(&mut self) -> Engine {
        let name = self.backend.name;
        if let Some(engine) = self.engines.iter().find(|engine| engine.backend().name() == name) {
            return engine.clone();
        }
        let engine = Engine::new(self.backend.make());
        let engine = self.memory.map_or(engine.clone(), |bytes| engine.with_memory(bytes));
        self.engines.push(engine.clone());
        engine
    }

    /// Takes the newest picture, if there is one. Returns whether there was.
    pub fn refresh(&mut self) -> bool {
        let is_new = self.renderer.take(&mut self.shown);
        if is_new {
            self.complete_snapshots();
        }
        is_new
    }

    /// Takes the picture of the current values. While a slider is held, this waits a little for it, so the slider and
    /// its picture are in the same frame.
    pub fn refresh_while_held(&mut self, longest: Duration) {
        if self.held.is_some() && self.shown.values < self.requested {
            self.renderer.wait_for(self.requested, longest);
            self.refresh();
        }
    }

    /// The picture in view.
    pub fn shown(&self) -> &Picture {
        &self.shown
    }

    /// Identifies what is requested. It changes with values, formula, scene and view.
    pub fn stamp(&self) -> u64 {
        self.requested
    }

    /// Whether the picture has the current values and all its pixels.
    pub fn is_up_to_date(&self) -> bool {
        self.shown.values == self.requested && self.shown.is_full()
    }

    /// Applies a formula. Values are kept by owner and name, also of parameters that an earlier formula of this session
    /// had. Images are looked for in the folder of the formula. Returns the warnings.
    ///
    /// # Errors
    /// The errors of the text. Nothing is changed then.
    pub fn apply_formula(&mut self, source: &Source, location: Option<&Location>) -> Result<Diagnostics, Diagnostics> {
        let unsaved = Location::File(PathBuf::new());
        let (formula, warnings) = parse_formula(source, location.unwrap_or(&unsaved))?;
        let (mut values, _) = self.values.carry_over(&formula, self.scene());
        self.stand_ins.note_gone(&self.values, &values);
        self.stand_ins.place(&mut values);
        // Images may have been painted meanwhile.
        let changed_images = values.changed_images();
        values.assign(&changed_images);
        self.formula = Arc::new(formula);
        self.replace_values(values);
        Ok(warnings)
    }

    /// Applies a scene. `location` says from where its files are read. Values are kept by owner and name, also of
    /// bodies and lights that an earlier scene of this session had. Returns the warnings.
    ///
    /// # Errors
    /// The errors of the text. Nothing is changed then.
    pub fn apply_scene(&mut self, source: &Source, location: &Location) -> Result<Diagnostics, Diagnostics> {
        let memory = self.memory.unwrap_or_else(usable_memory);
        let ((scene, assets), warnings) = parse_scene_with_assets(source, location, &self.assets, memory, &Task::UNWATCHED)?;
        // They are those of this scene.
        let world = World::new(scene, &assets).map_err(|error| Diagnostic::error(error.to_string()))?;
        let (mut values, _) = self.values.carry_over(&self.formula, world.scene());
        self.departed.note(&self.values, &values);
        let back = self.departed.of_new(&self.values, &values);
        values.assign(&back);
        self.stand_ins.place(&mut values);
        self.world = Arc::new(world);
        self.replace_values(values);
        Ok(warnings)
    }

    /// Gives bodies a first look, unless they have one of these names.
    pub fn give_first_look(&mut self, known: &[String]) {
        let mut values = self.values.clone();
        first_look::give_first_look(&mut values, &self.world, |name| !known.iter().any(|known| known == name));
        self.replace_values(values);
    }

    fn replace_values(&mut self, values: Values) {
        self.values = values;
        self.request_picture();
    }

    /// Moves a slider that the user holds.
    pub fn drag(&mut self, owner: OwnerId, id: ParameterId, value: [f32; 3]) {
        if self.held != Some((owner, id)) {
            self.note_values(self.current_state().values);
            self.held = Some((owner, id));
        }
        self.values.move_to(owner, id, value);
        let indices = self.values.moved_indices(owner, id);
        self.requested = self.renderer.move_to(self.values.numbers(), Some(indices));
    }

    /// Releases the slider that is held.
    pub fn release(&mut self) {
        if self.held.take().is_some() {
            self.requested = self.renderer.move_to(self.values.numbers(), None);
        }
    }

    /// The slider that is held.
    pub fn held(&self) -> Option<(OwnerId, ParameterId)> {
        self.held
    }

    /// Sets a value at once.
    pub fn set(&mut self, owner: OwnerId, id: ParameterId, value: [f32; 3]) {
        self.change(|values| {
            values.move_to(owner, id, value);
        });
    }

    /// Gives the value of one owner to all owners of the same kind.
    pub fn copy_to_all(&mut self, owner: OwnerId, id: ParameterId) {
        let mut value = [0.0; 3];
        self.values.get(owner, id).iter().zip(&mut value).for_each(|(from, to)| *to = *from);
        let others: Vec<OwnerId> = self.values.table().owners().of_kind(owner.kind()).filter(|other| *other != owner).collect();
        self.change(|values| {
            for other in others {
                values.move_to(other, id, value);
            }
        });
    }

    /// Changes values. The change can be undone.
    pub fn change(&mut self, change: impl FnOnce(&mut Values)) {
        let before = self.current_state().values;
        change(&mut self.values);
        if before.values != self.values {
            self.note_values(before);
            self.held = None;
            self.requested = self.renderer.move_to(self.values.numbers(), None);
        }
    }

    /// Undoes the last change of values or of the view transform. Returns whether there was one.
    pub fn undo(&mut self) -> bool {
        let other = self.history.undo(self.current_state());
        self.move_to(other)
    }

    /// Redoes the change that was undone last. Returns whether there was one.
    pub fn redo(&mut self) -> bool {
        let other = self.history.redo(self.current_state());
        self.move_to(other)
    }

    /// Uses other values, which may be of another formula or scene, or another view transform.
    fn move_to(&mut self, other: Option<HistoryEntry>) -> bool {
        let Some(other) = other else { return false };
        self.view_is_held = false;
        match other {
            HistoryEntry::Values(other) => {
                self.values = other.values_for(&self.formula, self.world.scene());
                self.held = None;
                self.requested = self.renderer.move_to(self.values.numbers(), None);
            }
            HistoryEntry::View(view) => self.show_through(view),
        }
        true
    }

    fn current_state(&self) -> CurrentState {
        let (formula, scene) = (Arc::clone(&self.formula), Arc::clone(self.scene()));
        let values = PastValues { values: self.values.clone(), formula, scene };
        CurrentState { values, view: self.picture.view }
    }

    /// Notes values that are about to change.
    fn note_values(&mut self, values: PastValues) {
        self.view_is_held = false;
        self.history.push(HistoryEntry::Values(values));
    }

    /// Whether there is a change to undo, and one to redo.
    pub fn can_undo_and_redo(&self) -> [bool; 2] {
        self.history.can_undo_and_redo()
    }

    /// How many changes of values and of the view transform were made and not undone, and how many were made at all.
    /// With that, other changes can be put in order with them.
    pub fn history_position(&self) -> [u64; 2] {
        self.history.position()
    }

    /// What the change is of that would be undone, and of that which would be redone; `None` if there is none.
    pub fn undo_and_redo_names(&self) -> [Option<String>; 2] {
        let name = |other: &HistoryEntry| match other {
            HistoryEntry::Values(other) => changed(&self.values, &other.clone().values_for(&self.formula, self.scene())),
            HistoryEntry::View(other) => changed_in_view(&self.picture.view, other).to_owned(),
        };
        self.history.last_and_next().map(|entry| entry.map(name))
    }

    /// Changes size, depth and other picture settings.
    ///
    /// # Errors
    /// A setting is out of range. Nothing is changed then.
    pub fn set_picture(&mut self, picture: PictureSettings) -> Result<(), ViewError> {
        view(&picture)?;
        if picture != self.picture {
            self.picture = picture;
            self.request_picture();
        }
        Ok(())
    }

    /// Evaluates with another backend.
    pub fn set_backend(&mut self, backend: BackendChoice) {
        if backend != self.backend {
            self.backend = backend;
            self.request_picture();
        }
    }

    /// How many passes the picture is the mean of, at least 1: those of the session, or the default.
    pub fn samples(&self) -> u32 {
        self.picture.samples.unwrap_or(self.default_samples)
    }

    /// Sets how many passes a picture is the mean of if the session does not say; 0 counts as 1.
    pub fn set_default_samples(&mut self, samples: u32) {
        let before = self.samples();
        self.default_samples = samples.max(1);
        if self.samples() != before {
            self.request_picture();
        }
    }

    /// Limits the memory that a picture may take, in bytes; `None` for half of what is free.
    pub fn set_memory(&mut self, memory: Option<u64>) {
        if memory != self.memory {
            self.memory = memory;
            self.assets.forget_refused();
            self.engines.clear();
            self.request_picture();
        }
    }

    /// The open session, with the locations of its texts. Values that wait for one of them are in it.
    pub fn session(&self, formula: Location, scene: Location) -> Session {
        let values = Session::name_values(&self.values).into_iter().chain(self.waiting_values().iter().cloned()).collect();
        Session { formula, scene, picture: self.picture, values }
    }

    /// Saves the session.
    ///
    /// # Errors
    /// The file cannot be written. An existing file is then unchanged.
    pub fn save_session(&self, path: &Path, formula: Location, scene: Location) -> io::Result<()> {
        self.session(formula, scene).save(path)
    }

    /// The picture in view, to be saved on another thread. If it has not yet the current values and all its pixels, or
    /// is that of a held slider, the picture of the values is made then, with as many passes.
    ///
    /// # Errors
    /// A setting is out of range.
    pub fn export(&mut self) -> Result<PictureExport, ViewError> {
        let view = self.view()?;
        let passes = self.shown.passes.shown.max(1) as u32;
        let content = match &self.shown.linear {
            Some(frame) if self.is_up_to_date() => {
                ExportContent::Shown { frame: Arc::clone(frame), undefined: self.shown.nan.pixels() }
            }
            Some(_) | None => ExportContent::Other {
                subject: Box::new(self.subject(view)),
                engine: self.engine(),
                numbers: self.values.numbers().to_vec(),
            },
        };
        Ok(PictureExport { content, transform: self.picture.view, passes })
    }
}

#[cfg(test)]
mod tests;
