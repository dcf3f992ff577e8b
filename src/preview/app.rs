//! The user interface of the workshop: texts on the left, the picture in the middle, parameters on the right, the log
//! below.
//!
//! Every panel is a module. A panel draws itself and pushes [`Action`]s, as menus and keys do; the app performs them.
//! Sliders and the pane of the picture call the [workshop](super::workshop) directly. No window is known here, so tests
//! drive all of this without one.

mod action;
mod arrangement;
mod asset_loading;
mod autosave;
mod colours;
mod comparison;
mod confirmation;
mod dialogs;
mod drops;
mod file_dialogs;
mod files;
mod fitting;
mod focus_ring;
mod gallery;
mod hand;
mod histogram;
mod image_rows;
mod inspector;
mod instrument_actions;
mod instruments;
mod jobs;
mod key_groups;
mod key_list;
mod log;
mod materials;
mod measured_comparison;
mod menu;
mod menu_entries;
mod mesh_adding;
mod modal;
mod notices;
mod number_field;
mod pane;
mod panel_sizes;
mod parameters;
mod pixel_dependence;
mod question;
mod saving;
mod scene_actions;
mod scene_menu;
mod scene_text;
mod sensitivity_view;
mod session_mistakes;
mod settings_dialog;
mod status;
mod steps;
mod tab;
mod theme;
mod thumbnail_key;
mod thumbnails;
mod unsaved;
mod user_state;
mod value_rows;
mod view_controls;

pub use action::Action;
pub use instrument_actions::InstrumentAction;
pub use scene_actions::{HandleTool, MeshSpot, SceneAction};

use crate::backends::BackendChoice;
use crate::evaluate::review::PictureFinding;
use crate::files::Readable;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::source::SourceSpan;
use crate::preview::editor::{Document, Editor, Palette, problems_ui, reference_ui};
use crate::preview::renderer::Event;
use crate::preview::workshop::{OpenedSession, OpeningErrors, Workshop};
use crate::preview::{FrameTimes, PictureView, WindowApp};
use crate::user_data::desktop_theme::desktop_is_dark;
use crate::user_data::folders::Folders;
use crate::user_data::settings::{PanelSide, WindowSettings};
use crate::workspace::AssetStore;
use crate::workspace::FileKind;
use crate::workspace::Location;
use crate::workspace::presets::DEFAULT_SESSION;
use crate::workspace::project::SessionMistakes;
use arrangement::PanelsBelow;
use asset_loading::AssetLoading;
use confirmation::Confirmation;
use dialogs::Dialogs;
use drops::DroppedFiles;
use egui::{CentralPanel, Context, Frame, Panel, Ui};
use fitting::FittingPanel;
use focus_ring::FocusRing;
use gallery::Gallery;
use hand::Hand;
use inspector::InspectorPanel;
use instruments::InstrumentPanel;
use jobs::{JobResult, Jobs};
use log::Log;
use materials::MaterialRow;
use measured_comparison::MeasuredComparison;
use notices::{Notice, Notices, Topic};
use pane::PicturePane;
use parameters::ParameterPanel;
use saving::PendingSave;
use sensitivity_view::SensitivityView;
use settings_dialog::SettingsDialog;
use std::io;
use std::sync::{Arc, OnceLock};
use std::time::Duration;
use steps::OtherSteps;
use tab::{PerTab, TextTab};
use theme::Theme;
use thumbnails::Thumbnails;
use unsaved::SavedSession;
use user_state::UserState;

/// The workshop with its user interface.
pub struct App {
    workshop: Workshop,
    documents: PerTab<Document>,
    editor: Editor,
    /// The tab in view.
    tab: TextTab,
    /// The file of the session, if there is one.
    session: Option<Location>,
    saved: SavedSession,
    /// What is wrong with the texts of the open session.
    mistakes: SessionMistakes,
    /// What is remarkable about the picture at rest.
    finding: Option<PictureFinding>,
    parameters: ParameterPanel,
    pane: PicturePane,
    hand: Hand,
    steps: OtherSteps,
    log: Log,
    dialogs: Dialogs,
    notices: Notices,
    confirmation: Confirmation,
    pending_save: Option<PendingSave>,
    gallery: Gallery,
    focus_ring: FocusRing,
    thumbnails: Thumbnails,
    jobs: Jobs,
    asset_loading: AssetLoading,
    dropped: DroppedFiles,
    settings_dialog: SettingsDialog,
    inspector: InspectorPanel,
    instruments: InstrumentPanel,
    /// Which of the panels below the picture are in view.
    below: PanelsBelow,
    fitting: FittingPanel,
    sensitivity: SensitivityView,
    measured: MeasuredComparison,
    materials: MaterialRow,
    user_state: UserState,
    /// When drafts were written last, in seconds of egui's clock.
    drafts_written_at: f64,
    theme: Theme,
    /// Whether the desktop is dark, if it says so.
    desktop_is_dark: Option<bool>,
    scale: f32,
    panels: Panels,
    query: String,
    /// Whether the text editor had the keyboard in the last frame.
    typing: bool,
    /// Whether the next picture decides the exposure.
    exposes_first: bool,
    /// The context of the window, once there is one; it wakes the window.
    context: Arc<OnceLock<Context>>,
    closing: bool,
    /// What could not be saved when the window closed.
    closing_errors: Vec<String>,
}

/// The panels in view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Panels {
    texts: bool,
    parameters: bool,
    log: bool,
    reference: bool,
}

impl App {
    /// Opens a session; without one, the startup session of the settings. `folders` holds what is kept between runs. A
    /// session whose formula or scene has mistakes is opened as far as it can be used.
    ///
    /// # Errors
    /// The session itself cannot be read, or does not say what it is of. Or no thread can be started.
    pub fn new(session: Option<&Location>, folders: Option<&Folders>) -> Result<Self, OpeningErrors> {
        let (user_state, mut notices) = UserState::open(folders);
        let startup = &user_state.settings.startup;
        let assets = Arc::new(AssetStore::default());
        let (location, opened) = match session {
            Some(location) => (location.clone(), asset_loading::open_at_start(location, Readable::RegularOrPipe, &assets)?),
            None => match asset_loading::open_at_start(startup, Readable::Regular, &assets) {
                Ok(opened) => (startup.clone(), opened),
                // The window must open even if the startup session is gone.
                Err(errors) => {
                    let title = format!("The startup session {startup} was not opened; this is the built-in one");
                    notices.push(Notice::warning(Topic::Startup, title, errors.to_string()));
                    let built_in = Location::Preset(DEFAULT_SESSION.to_owned());
                    let opened = OpenedSession::open(&built_in, Readable::Regular, &assets)?;
                    (built_in, opened)
                }
            },
        };
        let context: Arc<OnceLock<Context>> = Arc::default();
        let workshop = Workshop::new(&opened.project, assets, waker(&context)).map_err(no_thread)?;
        let documents = session_mistakes::documents(&opened);
        let saved = SavedSession::of(&workshop, &documents);
        let mut app = Self {
            workshop,
            documents,
            editor: Editor::default(),
            tab: TextTab::Formula,
            session: Some(location),
            saved,
            mistakes: SessionMistakes::default(),
            finding: None,
            parameters: ParameterPanel::default(),
            pane: PicturePane::default(),
            hand: Hand::default(),
            steps: OtherSteps::default(),
            log: Log::default(),
            dialogs: Dialogs::default(),
            notices: Notices::default(),
            confirmation: Confirmation::default(),
            pending_save: None,
            gallery: Gallery::default(),
            focus_ring: FocusRing::default(),
            thumbnails: Thumbnails::default(),
            jobs: Jobs::new(waker(&context)),
            asset_loading: AssetLoading::default(),
            dropped: DroppedFiles::default(),
            settings_dialog: SettingsDialog::default(),
            inspector: InspectorPanel::default(),
            instruments: InstrumentPanel::new(&user_state.settings.window, waker(&context)),
            below: PanelsBelow::default(),
            fitting: FittingPanel::new(waker(&context)),
            sensitivity: SensitivityView::new(waker(&context)),
            measured: MeasuredComparison::new(waker(&context)),
            materials: MaterialRow::default(),
            drafts_written_at: 0.0,
            theme: Theme::Dark,
            desktop_is_dark: folders.and_then(|_| desktop_is_dark()),
            scale: user_state.settings.window.scale,
            panels: Panels { texts: true, parameters: true, log: user_state.settings.window.log, reference: false },
            user_state,
            query: String::new(),
            typing: false,
            exposes_first: false,
            context,
            closing: false,
            closing_errors: Vec::new(),
        };
        app.follow_settings();
        notices.into_iter().for_each(|notice| app.notify(notice));
        if let Some(location) = app.session.clone() {
            app.notify_of_session(&location, &opened.warnings);
        }
        app.note_mistakes(opened.mistakes);
        app.read_files_of_start();
        if app.user_state.has_important_drafts() {
            app.dialogs.offer_drafts(app.user_state.draft_names());
        }
        app.open_materials();
        if session.is_none() && app.user_state.settings.window.gallery && !app.user_state.has_important_drafts() {
            app.perform(Action::ShowGallery);
        }
        Ok(app)
    }

    /// The workshop.
    pub fn workshop(&self) -> &Workshop {
        &self.workshop
    }

    /// Draws everything, and performs the actions of the user.
    pub fn draw(&mut self, ui: &mut Ui) {
        self.workshop.refresh();
        self.expose_first_picture();
        let size = ui.ctx().content_rect().size() * self.scale;
        self.user_state.settings.window.size = [size.x, size.y].map(|side| side.round() as u32);
        self.take_news();
        self.follow_files(ui);
        let typing = std::mem::take(&mut self.typing) || ui.ctx().text_edit_focused();
        // While a dialog waits for an answer, shortcuts do nothing.
        let waits = self.dialogs.files.is_open() || ui.memory(|memory| memory.top_modal_layer().is_some());
        let mut actions = if waits { Vec::new() } else { action::pressed(ui, typing) };
        self.follow_drops(ui, waits, &mut actions);
        Panel::top("menu").show(ui, |ui| menu::bar(self, ui, &mut actions));
        if !self.notices.is_empty() {
            Panel::top("notices").show(ui, |ui| self.notices.ui(ui));
        }
        Panel::bottom("status").show(ui, |ui| status::bar(self, ui, &mut actions));
        if self.panels.log {
            Panel::bottom("log").resizable(true).default_size(150.0).show(ui, |ui| self.log.ui(ui));
        }
        self.panels_ui(ui, waits || typing, &mut actions);
        CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
            Panel::bottom("view controls").show(ui, |ui| view_controls::bar(self, ui, &mut actions));
            self.pane.note = self.note_on_picture();
            if let Some(owner) = self.pane.ui(ui, &mut self.workshop, self.scale) {
                self.parameters.select(owner);
            }
            self.end_typing(ui, typing);
            self.scene_by_hand(ui, !typing && !waits, &mut actions);
            if self.inspector.open
                && let Some(pixel) = self.pane.clicked()
            {
                self.inspector.inspect(&self.workshop, pixel);
                // Its panel has been drawn already.
                ui.ctx().request_repaint();
            }
            self.sensitivity.legend_ui(ui, &self.pane);
            self.inspector.mark(ui, &self.pane.placement(&self.workshop), self.pane.area());
        });
        self.instruments_over_ui(ui.ctx(), &mut actions);
        self.confirmation.ui(ui.ctx(), &mut actions);
        gallery::gallery_ui(self, ui.ctx(), &mut actions);
        self.make_thumbnails(ui.ctx().pixels_per_point());
        self.dialogs.ui(ui.ctx(), &mut actions);
        if let Some(settings) = self.settings_dialog.ui(ui.ctx()) {
            actions.push(Action::SaveSettings(Box::new(settings)));
        }
        self.show_hovered_files(ui);
        self.focus_ring.ui(ui.ctx());
        for action in actions {
            self.perform(action);
        }
        self.autosave(ui);
    }

    /// Takes what the renderer and the background jobs have told since the last frame.
    fn take_news(&mut self) {
        self.follow_measured();
        let events: Vec<_> = self.workshop.renderer().events().collect();
        for event in events {
            // Without a scene, the window says already why there is no picture.
            if !matches!(event, Event::Reviewed(_)) || !self.workshop.stands_in(FileKind::Scene) {
                self.log.record(&event, &self.workshop);
            }
            match event {
                Event::Failed(message) => self.notify(Notice::error(Topic::Picture, "There is no picture", message)),
                Event::Reviewed(finding) => self.finding = finding,
                Event::Frame { method, .. } => {
                    self.notices.clear(Topic::Picture);
                    // Pictures of a held slider are not reviewed.
                    self.finding = self.finding.take().filter(|_| method.is_none());
                }
                Event::Moved { .. } => {
                    self.notices.clear(Topic::Picture);
                    self.finding = None;
                }
                Event::Compiled(_) | Event::Traced { .. } | Event::Passes { .. } | Event::Ready { .. } | Event::Undefined(..) => {
                }
            }
        }
        for result in self.jobs.results() {
            self.handle_job_result(result);
        }
    }

    /// Takes the keyboard from a text when the picture is pressed or a slider dragged, as a click elsewhere does.
    /// Otherwise keys that are held in a drag would be typed, and Ctrl+Z would undo typing and not the drag.
    fn end_typing(&self, ui: &Ui, typing: bool) {
        let pressed = self.pane.response().is_some_and(|response| response.is_pointer_button_down_on());
        if typing && (pressed || self.workshop.held().is_some()) {
            ui.memory_mut(|memory| memory.focused().into_iter().for_each(|id| memory.surrender_focus(id)));
        }
    }

    /// What could not be saved when the window closed, for the user.
    pub fn closing_errors(&self) -> &[String] {
        &self.closing_errors
    }

    /// Shows a notice that there is no folder for user data, and why.
    pub fn notify_no_user_data(&mut self, reason: &Diagnostic) {
        let title = "Nothing is remembered: unsaved work, settings and recent files are lost when the program ends";
        self.notify(Notice::warning(Topic::Home, title, user_state::line(reason)));
    }

    /// Runs a job in the background.
    fn run_job(&mut self, job: impl FnOnce() -> Option<JobResult> + Send + 'static) {
        if let Some(result) = self.jobs.run(job) {
            self.handle_job_result(result);
        }
    }

    fn handle_job_result(&mut self, result: JobResult) {
        match result {
            JobResult::Done(text) => self.confirm(text),
            JobResult::ThumbnailMade(key, image) => self.thumbnails.keep(self.context.get(), *key, image),
            JobResult::ChartNotSaved(error) => self.tell_not_saved(&error, Action::Instruments(InstrumentAction::ShowSaveDialog)),
            JobResult::MeasuredRead(path, read) => self.take_measured(&path, read),
            JobResult::PictureNotSaved(error) => self.tell_not_saved(&error, Action::ShowSavePictureDialog),
            JobResult::ImageRead(image) => self.set_image(*image),
            JobResult::DraftsWritten(Ok(())) => {
                if self.notices.clear(Topic::Drafts) {
                    self.log.add("unsaved work is kept again");
                }
            }
            JobResult::DraftsWritten(Err(error)) => {
                let title = "Unsaved work is not kept: save it yourself, or it is lost when the program ends";
                self.notify(Notice::error(Topic::Drafts, title, user_state::line(&error)));
            }
        }
    }

    /// Passes every line of the log to a listener too.
    pub fn set_log_listener(&mut self, listener: impl FnMut(&str) + 'static) {
        self.log.set_listener(listener);
    }

    /// Draws the tabs, the text in view, and the problems of both texts.
    fn texts_ui(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        ui.horizontal_wrapped(|ui| {
            for (tab, document) in self.documents.iter() {
                let hover = document.location().map_or_else(|| "not saved yet".to_owned(), ToString::to_string);
                if ui.selectable_label(self.tab == tab, document.title()).on_hover_text(hover).clicked() {
                    self.tab = tab;
                }
            }
            let name = format!("Apply {}", self.tab.kind().noun());
            let (button, about) = if self.documents[self.tab].is_applied() {
                (egui::Button::new(egui::RichText::new(&name).weak()), "The picture is made from this text (Ctrl+Enter)")
            } else {
                (theme::main_button(ui, &name), "Make the picture from the changed text (Ctrl+Enter)")
            };
            if ui.add(button).on_hover_text(about).clicked() {
                actions.push(Action::Apply);
            }
        });
        let [errors, warnings] = self.documents.values().fold([0, 0], |[errors, warnings], document| {
            let [more, others] = document.counts();
            [errors + more, warnings + others]
        });
        let mut jump: Option<(TextTab, SourceSpan)> = None;
        if errors + warnings > 0 {
            Panel::bottom("problems").resizable(true).default_size(110.0).show(ui, |ui| {
                jump = problems_ui(ui, &self.documents.iter().collect::<Vec<_>>());
            });
        }
        if self.panels.reference {
            Panel::bottom("reference").resizable(true).default_size(260.0).show(ui, |ui| {
                if let Some(text) = reference_ui(ui, &mut self.query) {
                    self.editor.insert(text);
                }
            });
        }
        if let Some((tab, span)) = jump {
            self.tab = tab;
            self.editor.jump_to(span);
        }
        let palette = Palette::suiting(ui.visuals());
        let response = self.editor.ui(ui, &mut self.documents[self.tab], &palette);
        self.typing = response.focused;
        self.follow_editor_undo();
        let sound = self.documents[self.tab].counts()[0] == 0;
        if response.apply || response.changed && sound && self.user_state.settings.window.apply_as_you_type {
            actions.push(Action::Apply);
        }
    }

    /// Adapts the scale of widgets and the size of the window to a screen of this size in pixels, unless there was an
    /// earlier run.
    pub fn start_on_screen(&mut self, screen: [u32; 2], scale: f32) {
        if self.user_state.scale_is_given {
            return;
        }
        self.scale = scale;
        let window = &mut self.user_state.settings.window;
        window.scale = scale;
        if window.size == WindowSettings::default().size {
            let fitted = |side: u32, screen: u32| ((side as f32 * scale) as u32).min(screen);
            window.size = [fitted(window.size[0], screen[0]), fitted(window.size[1], screen[1])];
        }
        // On a small screen the panels leave room for the picture.
        let room = window.size[0] as f32 / scale;
        for (side, share) in [(PanelSide::Texts, 0.3), (PanelSide::Parameters, 0.27)] {
            window.panels.set(side, window.panels.get(side).min(share * room));
        }
        self.user_state.settings = self.user_state.settings.within_ranges();
    }

    /// The initial width and height of the window, in pixels.
    pub fn window_size(&self) -> [usize; 2] {
        self.user_state.settings.window.size.map(|side| side as usize)
    }

    fn backend(&self) -> BackendChoice {
        self.workshop.backend()
    }
}

/// A function that wakes the window, once there is one, from any thread.
fn waker(context: &Arc<OnceLock<Context>>) -> impl Fn() + Send + Sync + use<> {
    let context = Arc::clone(context);
    move || {
        if let Some(context) = context.get() {
            context.request_repaint();
        }
    }
}

fn no_thread(error: io::Error) -> OpeningErrors {
    OpeningErrors::from(Diagnostic::error(format!("cannot start a thread: {}", crate::files::reason(&error))))
}

impl WindowApp for App {
    fn started(&mut self, context: &Context) {
        // There is only one window, so the first context stays.
        let _ = self.context.set(context.clone());
        theme::apply(context, self.theme);
    }

    fn ui(&mut self, ui: &mut Ui) {
        self.draw(ui);
    }

    fn picture(&mut self) -> Option<PictureView<'_>> {
        /// Pictures that take longer come in a later frame, so the widgets do not wait.
        const QUICK: Duration = Duration::from_millis(8);
        if self.log.last_frame().is_some_and(|time| time < QUICK.as_secs_f32() * 1e3) {
            self.workshop.refresh_while_held(QUICK);
        }
        self.pane.compose(&self.workshop);
        self.pane.view(&self.workshop)
    }

    fn scale(&self) -> f32 {
        self.scale
    }

    fn follows_slowly(&self) -> bool {
        self.workshop.moving().is_some()
    }

    fn title(&self) -> String {
        let name = match &self.session {
            Some(location) => location.to_string(),
            None => "new session".to_owned(),
        };
        let mark = if self.is_unsaved() { " •" } else { "" };
        format!("{name}{mark} – Illuminator")
    }

    fn wants_close(&mut self) -> bool {
        self.closing
    }

    fn closing(&mut self) {
        // First of all, because saving a picture may take long.
        let kept = self.save_drafts_now();
        self.jobs.finish();
        self.user_state.settings = self.user_state.settings.within_ranges();
        let saved = self.user_state.save_settings();
        if self.user_state.autosave().is_none() && self.documents.values().any(Document::unsaved) {
            self.closing_errors.push("unsaved work is lost: there is no folder for it".to_owned());
        }
        self.closing_errors.extend(kept.err().map(|error| format!("unsaved work is lost: {}", user_state::line(&error))));
        self.closing_errors.extend(saved.err().map(|error| user_state::line(&error)));
    }

    fn frame_shown(&mut self, times: &FrameTimes) {
        self.log.record_frame(times, &self.workshop);
    }
}

#[cfg(test)]
mod screenshots;
#[cfg(test)]
mod tests;
