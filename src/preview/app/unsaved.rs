//! What is unsaved: whether the session and the texts differ from their files, and the drafts that are kept of them.
//!
//! How drafts are written on another thread is in `autosave`.

use crate::lang::diagnostic::Diagnostic;
use crate::preview::app::App;
use crate::preview::app::autosave::{Autosave, DraftSlot, PerDraft, Unsaved};
use crate::preview::app::jobs::JobResult;
use crate::preview::app::tab::PerTab;
use crate::preview::editor::Document;
use crate::preview::workshop::Workshop;
use crate::workspace::session::PictureSettings;
use crate::workspace::{FileKind, Location, presets};
use egui::Ui;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::time::Duration;

/// The contents of the session file as saved last. Every frame compares them with the session, to know whether it is
/// unsaved.
#[derive(Default)]
pub(super) struct SavedSession {
    numbers: Vec<f32>,
    picture: PictureSettings,
    locations: PerTab<Option<Location>>,
}

impl SavedSession {
    pub(super) fn of(workshop: &Workshop, documents: &PerTab<Document>) -> Self {
        Self {
            numbers: workshop.values().numbers().to_vec(),
            picture: workshop.settings(),
            locations: documents.map(|document| document.location().cloned()),
        }
    }
}

impl App {
    /// Notes unsaved work, and writes drafts every few seconds, which is what a crash can cost. Texts are noted in
    /// every frame, so they can still be written if the window does not close normally.
    pub(super) fn autosave(&mut self, ui: &Ui) {
        const EVERY: f64 = 2.0;
        let states = self.unsaved_states();
        self.note_unsaved(&[DraftSlot::Formula, DraftSlot::Scene], states);
        let now = ui.input(|input| input.time);
        if now - self.drafts_written_at >= EVERY {
            self.drafts_written_at = now;
            self.note_unsaved(&DraftSlot::ALL, states);
            self.write_drafts();
        }
        // If nothing else changes, there would be no next frame.
        if self.user_state.is_behind(states) {
            ui.ctx().request_repaint_after(Duration::from_secs_f64(EVERY));
        }
    }

    /// Notes the unsaved state of some drafts.
    pub(super) fn note_unsaved(&mut self, slots: &[DraftSlot], states: PerDraft<Option<u64>>) {
        let Self { workshop, documents, session, user_state, .. } = self;
        let of_text = |text: &Document| {
            let (location, session) = (text.location().cloned(), session.clone());
            Unsaved { kind: text.kind(), location, session, text: text.text().to_owned() }
        };
        user_state.note_unsaved(slots, states, |slot| match slot {
            DraftSlot::Formula => of_text(&documents.formula),
            DraftSlot::Scene => of_text(&documents.scene),
            DraftSlot::Session => {
                let text = session_text(workshop, documents);
                Unsaved { kind: FileKind::Session, location: session.clone(), session: None, text }
            }
        });
    }

    /// Writes the noted drafts, in the background.
    pub(super) fn write_drafts(&mut self) {
        if let Some(autosave) = self.user_state.autosave().filter(|autosave| autosave.is_waiting()) {
            let autosave = autosave.clone();
            self.run_job(move || Some(JobResult::DraftsWritten(autosave.flush())));
        }
    }

    /// Saves drafts of all unsaved work, and waits until they are on disk.
    pub(super) fn save_drafts_now(&mut self) -> Result<(), Diagnostic> {
        self.note_unsaved(&DraftSlot::ALL, self.unsaved_states());
        self.user_state.autosave().map_or(Ok(()), Autosave::flush)
    }

    /// A function that writes the noted drafts, on any thread, if the window cannot close normally.
    pub fn last_resort(&self) -> impl Fn() + Send + Sync + use<> {
        let keep = self.user_state.autosave().map(Autosave::last_resort);
        move || keep.iter().for_each(|keep| keep())
    }

    /// Whether a text or the session is unsaved.
    pub fn is_unsaved(&self) -> bool {
        self.session_is_unsaved() || self.documents.values().any(Document::unsaved)
    }

    /// A number for each draft that identifies its unsaved state; `None` if it is saved.
    pub(super) fn unsaved_states(&self) -> PerDraft<Option<u64>> {
        let of_text = |text: &Document| text.unsaved().then(|| text.id() << 32 ^ text.revision());
        let PerTab { formula, scene } = self.documents.map(of_text);
        let session = self.session_is_unsaved().then(|| {
            let mut hasher = DefaultHasher::new();
            self.workshop.values().numbers().iter().for_each(|number| number.to_bits().hash(&mut hasher));
            let PictureSettings { size, depth, shadows, default_index, samples, view } = self.workshop.settings();
            (size, depth, shadows, default_index.to_bits(), samples, view.exposure.to_bits(), view.curve, view.transfer)
                .hash(&mut hasher);
            self.documents.values().for_each(|text| text.location().map(ToString::to_string).hash(&mut hasher));
            hasher.finish()
        });
        [formula, scene, session]
    }

    /// Whether values, settings or files differ from those in the session's file.
    pub(super) fn session_is_unsaved(&self) -> bool {
        let SavedSession { numbers, picture, locations } = &self.saved;
        let moved = self.documents.iter().any(|(tab, document)| document.location() != locations[tab].as_ref());
        let other = *numbers != self.workshop.values().numbers() || *picture != self.workshop.settings();
        moved || other
    }

    /// Notes that the session is saved as it is.
    pub(super) fn note_saved_session(&mut self) {
        self.saved = SavedSession::of(&self.workshop, &self.documents);
    }
}

/// The session as a text for a draft, with absolute paths. A text that is in no file is replaced by a built-in one
/// here; its own draft overrides that.
fn session_text(workshop: &Workshop, documents: &PerTab<Document>) -> String {
    let PerTab { formula, scene } = documents.map(|document| match document.location() {
        Some(Location::File(path)) => Location::File(std::path::absolute(path).unwrap_or_else(|_| path.clone())),
        Some(Location::Preset(name)) => Location::Preset(name.clone()),
        None => Location::Preset(presets::names(document.kind()).next().unwrap_or_default().to_owned()),
    });
    // A session made from values can always be written.
    workshop.session(formula, scene).to_toml(Path::new("/")).unwrap_or_default()
}
