//! Performing actions: opening, saving, applying, and the others.

use crate::files::Readable;
use crate::lang::source::Source;
use crate::preview::app::action::{PanelId, PictureOverlay};
use crate::preview::app::asset_loading::AfterReading;
use crate::preview::app::notices::{Notice, Topic};
use crate::preview::app::saving::SaveStep;
use crate::preview::app::session_mistakes::documents;
use crate::preview::app::steps::OtherSteps;
use crate::preview::app::tab::TextTab;
use crate::preview::app::theme::Theme;
use crate::preview::app::{Action, App, SavedSession, theme, user_state};
use crate::preview::editor::Document;
use crate::preview::workshop::OpenedSession;
use crate::user_data::drafts::Draft;
use crate::user_data::settings::{Settings, WindowSettings};
use crate::workspace::FileKind;
use crate::workspace::Location;
use crate::workspace::carried::CarriedValues;
use crate::workspace::project::SessionMistakes;
use std::path::Path;
use std::sync::Arc;

/// The texts of a new formula and a new scene, which work as they are.
const NEW_FORMULA: &str = "formula;\n= IL*Cd*max(0, N.L);\n";
const NEW_SCENE: &str = "bodies;
ball: sphere, center <0, 1, 0>, radius 1;
floor: rectangle, <-8, 0, -8>, <8, 0, -8>, <8, 0, 8>;

lights;
key: point, <4, 6, 5>;

camera;
position <0, 2.2, 7>;
gaze <0, -0.15, -1>;
up <0, 1, 0>;
fov 40;
";

impl App {
    /// The unsaved work that an action would replace: what it is, and its name.
    fn work_lost_by(&self, action: &Action) -> Vec<(FileKind, String)> {
        let (Action::New(kind) | Action::Open(kind, _)) = action else { return Vec::new() };
        let replaced = |tab: &TextTab| TextTab::of(*kind).is_none_or(|only| only == *tab);
        let documents = TextTab::ALL.into_iter().filter(replaced).map(|tab| &self.documents[tab]);
        let unsaved = documents.filter(|document| document.unsaved());
        let mut lost: Vec<_> = unsaved.map(|document| (document.kind(), document.name())).collect();
        // Unsaved values alone are no reason to ask: users move sliders while they look through sessions.
        if !lost.is_empty() && *kind == FileKind::Session && self.session_is_unsaved() {
            lost.push((FileKind::Session, "the values".to_owned()));
        }
        lost
    }

    /// Performs an action. If unsaved texts would be lost, the user is asked first.
    pub fn perform(&mut self, action: Action) {
        self.end_gesture();
        let lost = self.work_lost_by(&action);
        if lost.is_empty() {
            self.perform_confirmed(action);
        } else {
            let (kinds, names): (Vec<FileKind>, Vec<String>) = lost.into_iter().unzip();
            self.ask_to_save(&format!("Your changes in {} would be lost.", names.join(" and ")), &kinds, action);
        }
    }

    fn perform_confirmed(&mut self, action: Action) {
        match action {
            Action::Confirmed(action) if *action == Action::Quit => self.closing = true,
            Action::Confirmed(action) => self.perform_confirmed(*action),
            Action::New(kind) => self.begin(kind),
            Action::ShowOpenDialog(kind) => {
                let near = self.session.as_ref().and_then(Location::file).and_then(Path::parent);
                self.dialogs.files.open(kind, near);
            }
            Action::ShowImageDialog(owner, parameter) => {
                let of_formula = self.documents.formula.location().and_then(Location::file);
                let near = of_formula.or_else(|| self.session.as_ref().and_then(Location::file)).and_then(Path::parent);
                self.dialogs.files.choose_image(owner, parameter, near);
            }
            Action::SetImage(owner, parameter, path) => self.read_image(owner, parameter, &path),
            Action::Open(kind, location) => self.open(kind, location),
            Action::ShowMeshDialog => self.show_mesh_dialog(),
            Action::AddMesh(path, place) => self.add_mesh(&path, place),
            Action::Save => self.save(),
            Action::ShowSaveDialog(kind) => self.show_save_dialog(Some(kind), &format!("Save {}", kind.noun())),
            Action::SaveTo(Some(kind), path) => self.save_to(kind, path),
            Action::SaveTo(None, path) => self.save_picture(path),
            Action::SaveAll { kinds, then } => {
                let steps = kinds.into_iter().map(|kind| SaveStep { kind, path: None }).collect();
                self.save_in_turn(steps, then.map(|then| *then));
            }
            Action::StopSaving => self.stop_saving(),
            Action::ShowSavePictureDialog => self.show_save_dialog(None, "Save picture"),
            Action::CopyPicture => self.copy_picture(),
            Action::Instruments(action) => self.perform_on_instruments(action),
            Action::FitTo(path) => self.fitting.read(&path),
            Action::SaveSession => match self.session.clone() {
                // What could not be read of a session would be lost in its own file.
                Some(Location::File(path)) if self.mistakes.session_errors.is_none() => {
                    self.save_to(FileKind::Session, path);
                }
                Some(_) | None => self.show_save_dialog(Some(FileKind::Session), "Save session"),
            },
            Action::EditText(command) => self.editor.order(command),
            Action::SaveMaterial { name, body } => self.save_material(&name, body, false),
            Action::ReplaceMaterial { name, body } => self.save_material(&name, body, true),
            Action::DeleteMaterial(name) => self.delete_material(&name),
            Action::RestoreMaterial(change) => self.restore_material(*change),
            Action::Apply => self.apply(self.tab),
            Action::ApplyAsYouType(wanted) => self.change_settings(|settings| settings.window.apply_as_you_type = wanted),
            Action::Undo => self.move_in_history(false),
            Action::Redo => self.move_in_history(true),
            Action::Scene(action) => self.perform_on_scene(&action),
            Action::TakeSnapshot(slot) => self.workshop.take_snapshot(slot),
            Action::RestoreSnapshot(slot) => self.restore_snapshot(slot),
            Action::Zoom(zoom) => self.pane.zoom_about_middle(zoom, &self.workshop),
            Action::ZoomBy(steps) => self.pane.zoom_by_keys(steps, &self.workshop),
            Action::ToggleOverlay(PictureOverlay::Clipping) => self.pane.clipping = !self.pane.clipping,
            Action::ToggleOverlay(PictureOverlay::Histogram) => self.pane.histogram = !self.pane.histogram,
            Action::SetBackend(backend) => self.change_settings(|settings| settings.backend = backend),
            Action::SetTheme(theme) => self.change_settings(|settings| settings.window.theme = theme),
            Action::SetScale(scale) => self.change_settings(|settings| settings.window.scale = scale),
            Action::OfferDrafts => self.dialogs.offer_drafts(self.user_state.draft_names()),
            Action::RestoreDrafts => self.restore_drafts(),
            Action::DiscardDrafts => {
                if let Err(error) = self.user_state.discard_drafts() {
                    self.dialogs.show_message("Not discarded", error.message());
                }
            }
            Action::UseAsStartupSession => self.start_with_this(),
            Action::TogglePanel(panel) => self.toggle(panel),
            Action::NewSession => self.begin_session(),
            Action::ShowSettings => self.settings_dialog.open(&self.user_state.settings, self.session.as_ref()),
            Action::SaveSettings(settings) => {
                // What the window has noted meanwhile, such as its size, is not in the dialog.
                let WindowSettings { log, instruments, size, panels, .. } = self.user_state.settings.window;
                let window = WindowSettings { log, instruments, size, panels, ..settings.window };
                self.change_settings(|kept| *kept = Settings { window, ..*settings });
            }
            Action::ShowGallery => self.gallery.open(|kind| self.user_state.recent(kind)),
            Action::InspectPixel(pixel) => {
                self.inspector.open = true;
                self.inspector.inspect(&self.workshop, pixel);
            }
            Action::ShowShortcuts => self.dialogs.show_shortcuts(),
            Action::Quit => self.quit(),
        }
    }

    /// Restores a snapshot. The texts in view may be those of another formula or scene.
    fn restore_snapshot(&mut self, slot: usize) {
        let before = (Arc::clone(self.workshop.formula()), Arc::clone(self.workshop.scene()));
        self.workshop.restore_snapshot(slot);
        if !Arc::ptr_eq(&before.0, self.workshop.formula()) {
            self.documents.formula.note_applied(false);
        }
        if !Arc::ptr_eq(&before.1, self.workshop.scene()) {
            self.documents.scene.note_applied(false);
        }
    }

    /// Makes the open session the startup session.
    fn start_with_this(&mut self) {
        if let Some(location) = self.session.clone() {
            self.user_state.settings.startup = match location {
                Location::File(path) => Location::File(std::path::absolute(&path).unwrap_or(path)),
                Location::Preset(name) => Location::Preset(name),
            };
            self.save_settings();
            self.confirm("the next start opens this session");
        }
    }

    /// Shows or hides a panel.
    fn toggle(&mut self, panel: PanelId) {
        let panels = &mut self.panels;
        let seen = match panel {
            PanelId::Texts => &mut panels.texts,
            PanelId::Parameters => &mut panels.parameters,
            PanelId::Log => &mut panels.log,
            PanelId::Reference => &mut panels.reference,
            PanelId::Inspector => &mut self.inspector.open,
            PanelId::Instruments => &mut self.instruments.open,
            PanelId::Fitting => &mut self.fitting.open,
        };
        *seen = !*seen;
        panels.texts |= panel == PanelId::Reference && panels.reference;
        if matches!(panel, PanelId::Log | PanelId::Instruments) {
            let window = &mut self.user_state.settings.window;
            (window.log, window.instruments) = (panels.log, self.instruments.open);
            self.save_settings();
        }
    }

    /// Ends the program after saving drafts. If they cannot be saved, the user is asked first.
    fn quit(&mut self) {
        let is_work = self.documents.values().any(Document::unsaved)
            || (self.session_is_unsaved() && matches!(self.session, Some(Location::File(_))));
        let reason = match (self.save_drafts_now(), self.user_state.autosave()) {
            (Err(error), _) => user_state::line(&error),
            (Ok(()), None) => "there is no folder for it".to_owned(),
            (Ok(()), Some(_)) => return self.closing = true,
        };
        if is_work {
            let text = format!("Your unsaved changes would be lost. They cannot be kept for the next start: {reason}.");
            let texts = self.documents.values().filter(|text| text.unsaved()).map(Document::kind);
            let session = self.session_is_unsaved().then_some(FileKind::Session);
            let kinds: Vec<FileKind> = texts.chain(session).collect();
            self.ask_to_save(&text, &kinds, Action::Quit);
        } else {
            self.closing = true;
        }
    }

    /// Changes settings, saves them, and does as they say.
    pub(super) fn change_settings(&mut self, change: impl FnOnce(&mut Settings)) {
        change(&mut self.user_state.settings);
        self.user_state.settings = self.user_state.settings.within_ranges();
        self.follow_settings();
        self.save_settings();
    }

    /// Does as the settings say.
    pub(super) fn follow_settings(&mut self) {
        let settings = &self.user_state.settings;
        self.scale = settings.window.scale;
        self.workshop.set_backend(settings.backend);
        self.workshop.set_default_samples(settings.samples);
        self.workshop.set_memory(settings.memory.map(|memory| u64::from(memory) << 20));
        let theme = Theme::from_setting(settings.window.theme, self.desktop_is_dark);
        if std::mem::replace(&mut self.theme, theme) != theme
            && let Some(context) = self.context.get()
        {
            theme::apply(context, theme);
        }
    }

    fn save_settings(&mut self) {
        match self.user_state.save_settings() {
            Ok(()) => {
                self.notices.clear(Topic::SavingSettings);
            }
            Err(error) => {
                let title = "Settings are not saved: they last until the program ends";
                self.notify(Notice::warning(Topic::SavingSettings, title, user_state::line(&error)));
            }
        }
    }

    pub(super) fn note_recent(&mut self, kind: FileKind, location: &Location) {
        if let Location::File(path) = location
            && let Err(error) = self.user_state.add_recent(kind, path)
        {
            let title = "The list of recent files is not saved: it lasts until the program ends";
            self.notify(Notice::warning(Topic::Recent, title, user_state::line(&error)));
        }
    }

    fn begin_session(&mut self) {
        let settings = &self.user_state.settings;
        self.measured.end();
        self.workshop.begin_session(settings.picture(), |table| settings.initial_values(table));
        self.steps = OtherSteps::default();
        self.session = None;
        self.exposes_first = true;
        let unusable = std::mem::take(&mut self.mistakes.unusable);
        self.note_mistakes(SessionMistakes { unusable, ..SessionMistakes::default() });
        self.note_saved_session();
    }

    /// Opens the drafts of earlier runs, still unsaved.
    fn restore_drafts(&mut self) {
        let drafts = self.user_state.restore_drafts();
        if let Some(session) = drafts.iter().find(|draft| draft.kind == FileKind::Session) {
            self.take_session(session, &drafts);
        } else if let Some(session) = drafts.iter().find_map(|draft| draft.session.clone()) {
            // The session itself was saved.
            self.open_session(session);
        }
        for draft in drafts {
            let Some(tab) = TextTab::of(draft.kind) else { continue };
            let mut document = match &draft.location {
                // The file's text is opened first, so the document knows what is unsaved.
                Some(location) => match location.read(draft.kind, Readable::Regular) {
                    Ok(source) => Document::opened(draft.kind, location.clone(), source.text()),
                    Err(_) => Document::untitled(draft.kind, ""),
                },
                None => Document::untitled(draft.kind, ""),
            };
            document.replace_text(&draft.text);
            self.documents[tab] = document;
            self.tab = tab;
            self.apply(tab);
        }
    }

    /// Shows another session with its texts. Nothing that was done before can be undone.
    fn show_session(&mut self, opened: OpenedSession, location: Option<Location>) {
        // What is being read is for the session before.
        self.asset_loading.cancel();
        self.measured.end();
        self.workshop.open(&opened.project);
        self.documents = documents(&opened);
        self.steps = OtherSteps::default();
        self.session = location;
        self.note_mistakes(opened.mistakes);
    }

    /// Opens a draft of a session, with the drafts of its texts if they have no errors.
    fn take_session(&mut self, draft: &Draft, texts: &[Draft]) {
        let source = Source::new("the draft of the session", draft.text.as_str());
        let kept = |kind: FileKind| {
            let text = texts.iter().find(|text| text.kind == kind)?;
            Some(Source::new(format!("the draft of the {}", kind.noun()), text.text.as_str()))
        };
        let assets = Arc::clone(self.workshop.assets());
        let open = |texts: &dyn Fn(FileKind) -> Option<Source>| OpenedSession::from_text(&source, Path::new("/"), texts, &assets);
        // The texts in the files are used if they are better.
        let opened = open(&kept).map(|opened| match opened.mistakes.unusable.is_empty() {
            true => opened,
            false => open(&|_| None).ok().filter(|saved| saved.mistakes.is_empty()).unwrap_or(opened),
        });
        match opened {
            Ok(opened) => {
                self.show_session(opened, draft.location.clone());
                self.open_materials();
                self.saved = SavedSession::default();
            }
            Err(errors) => self.dialogs.show_message("The saved values cannot be opened", errors.to_string()),
        }
    }

    fn begin(&mut self, kind: FileKind) {
        let Some(tab) = TextTab::of(kind) else { return };
        let text = match tab {
            TextTab::Formula => NEW_FORMULA,
            TextTab::Scene => NEW_SCENE,
        };
        self.documents[tab] = Document::untitled(kind, text);
        self.tab = tab;
        self.apply_opened(tab);
    }

    /// Opens a file: a formula or a scene in the place of that of the session, or another session.
    pub fn open(&mut self, kind: FileKind, location: Location) {
        let Some(tab) = TextTab::of(kind) else { return self.open_session(location) };
        match location.read(kind, Readable::Regular) {
            Ok(source) => {
                self.note_recent(kind, &location);
                self.documents[tab] = Document::opened(kind, location, source.text());
                self.tab = tab;
                self.apply_opened(tab);
            }
            Err(error) => self.dialogs.show_message("Not opened", user_state::line(&error)),
        }
    }

    pub(super) fn open_session(&mut self, location: Location) {
        if self.reads_files_of_session(&location) {
            return;
        }
        match OpenedSession::open(&location, Readable::Regular, self.workshop.assets()) {
            Ok(opened) => {
                self.log.add(format!("opened {location}"));
                self.note_recent(FileKind::Session, &location);
                self.notify_of_session(&location, &opened.warnings);
                self.show_session(opened, Some(location));
                self.open_materials();
                self.note_saved_session();
            }
            Err(errors) => self.dialogs.show_message(format!("{location} was not opened"), errors.to_string()),
        }
    }

    /// Opens the library that the formula names.
    pub(super) fn open_materials(&mut self) {
        let (formula, location) = (self.workshop.formula(), self.documents.formula.location());
        self.notices.clear(Topic::Materials);
        if let Some(message) = self.materials.open(formula.uses.as_deref(), location, self.user_state.data()) {
            let title = if self.materials.is_open() {
                "The material library has warnings"
            } else {
                "Materials are off: the material library cannot be read"
            };
            self.notify(Notice::warning(Topic::Materials, title, message));
        }
    }

    /// Shows a notice about values of a session that are not used as written. If the session is saved now, they are
    /// lost.
    pub(super) fn notify_of_session(&mut self, location: &Location, warnings: &[String]) {
        self.notices.clear(Topic::Session);
        if !warnings.is_empty() {
            let title = format!("Some values of the session {location} are not used as written");
            self.notify(Notice::warning(Topic::Session, title, warnings.join("\n")));
        }
    }

    /// Shows a notice, and adds it to the log.
    pub(super) fn notify(&mut self, notice: Notice) {
        let line = match notice.details.as_str() {
            "" => notice.title.clone(),
            details => format!("{}: {details}", notice.title),
        };
        if self.notices.show(notice) {
            self.log.say_lines(&line);
        }
    }

    /// Applies a text. If it has errors, they are marked, and nothing else changes.
    pub(super) fn apply(&mut self, tab: TextTab) {
        if tab == TextTab::Scene && self.reads_files_of_text(AfterReading::Apply) {
            return;
        }
        let (before, is_saved) = (self.workshop.values().table().clone(), !self.session_is_unsaved());
        let document = &mut self.documents[tab];
        document.check();
        let source = document.source();
        let start = std::time::Instant::now();
        let applied = match tab {
            TextTab::Formula => self.workshop.apply_formula(&source, document.location()),
            TextTab::Scene => self.workshop.apply_scene(&source, &document.place()),
        };
        let name = document.name();
        match applied {
            Ok(warnings) => {
                document.set_diagnostics(warnings);
                document.note_applied(true);
                self.log.add(format!("{name}: read in {}", super::log::milliseconds(start.elapsed())));
                let carried = CarriedValues::between(&before, self.workshop.values());
                if !carried.without_parameter.is_empty() || !carried.unused_defaults.is_empty() {
                    carried.sentence().into_iter().for_each(|sentence| self.log.add(format!("  {sentence}")));
                }
                self.note_mended(is_saved);
                self.open_materials();
            }
            Err(errors) => {
                let count = errors.len();
                let mistakes = if count == 1 { "mistake" } else { "mistakes" };
                self.log.add(format!("{name}: {count} {mistakes}; the picture stays as it was"));
                document.set_diagnostics(errors);
            }
        }
    }

    /// Applies a text that has just been opened. A scene without a session gets a first look: colours for bodies that
    /// the open session does not know, and an exposure by the first picture.
    pub(super) fn apply_opened(&mut self, tab: TextTab) {
        if tab == TextTab::Scene && self.reads_files_of_text(AfterReading::ApplyOpened) {
            return;
        }
        let known: Vec<String> = self.workshop.scene().bodies.iter().map(|body| body.name.clone()).collect();
        self.apply(tab);
        if tab == TextTab::Scene && self.documents[tab].counts()[0] == 0 {
            self.workshop.give_first_look(&known);
            self.exposes_first = true;
        }
    }
}
