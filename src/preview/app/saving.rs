//! Saving texts, sessions and pictures: the dialogs before it, what is said after it, and several files in turn.

use crate::files::replace_text;
use crate::preview::app::file_dialogs::Suggestion;
use crate::preview::app::jobs::JobResult;
use crate::preview::app::question::Question;
use crate::preview::app::tab::{PerTab, TextTab};
use crate::preview::app::{Action, App};
use crate::workspace::FileKind;
use crate::workspace::Location;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// Something to save, to its own file if there is no path.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SaveStep {
    pub(super) kind: FileKind,
    pub(super) path: Option<PathBuf>,
}

/// What is still to be saved, and what is done then.
#[derive(Debug, Default)]
pub(super) struct PendingSave {
    /// What the user is asked about, or what is being written.
    current: Option<SaveStep>,
    steps: VecDeque<SaveStep>,
    then: Option<Action>,
}

/// The session that is among them.
fn pending_session(steps: &VecDeque<SaveStep>) -> Option<&SaveStep> {
    steps.iter().find(|step| step.kind == FileKind::Session)
}

impl App {
    /// Saves the text in view.
    pub(super) fn save(&mut self) {
        let document = &self.documents[self.tab];
        match document.own_file() {
            Some(path) => {
                let path = path.to_owned();
                self.save_to(document.kind(), path);
            }
            None => self.perform(Action::ShowSaveDialog(document.kind())),
        }
    }

    /// Shows the dialog that saves something of this kind, or the picture, with a name and a folder that fit.
    pub(super) fn show_save_dialog(&mut self, kind: Option<FileKind>, title: &str) {
        // A text that is saved before its session has the name of the session.
        let pending = self.pending_save.as_ref().and_then(|pending| pending_session(&pending.steps));
        let pending = pending.and_then(|step| step.path.clone()).map(Location::File);
        let session = pending.as_ref().or(self.session.as_ref());
        let own = match kind.map(TextTab::of) {
            Some(Some(tab)) => self.documents[tab].location(),
            Some(None) | None => session,
        };
        self.dialogs.files.save(kind, title, &Suggestion::new(kind, own, session));
    }

    /// Asks whether to save work of these kinds before an action that loses it.
    pub(super) fn ask_to_save(&mut self, text: &str, kinds: &[FileKind], action: Action) {
        let confirmed = Box::new(Action::Confirmed(Box::new(action)));
        let save = Action::SaveAll { kinds: kinds.to_vec(), then: Some(confirmed.clone()) };
        let question = Question::new("Not saved", text).answer("Save", save).answer("Discard", *confirmed).or("Cancel");
        self.dialogs.ask(question);
    }

    /// Saves one thing after the other, and then performs an action. What has no file yet is asked for. If the user
    /// gives none, the rest is left. If something cannot be saved, the user may choose another file for it.
    pub(super) fn save_in_turn(&mut self, steps: Vec<SaveStep>, then: Option<Action>) {
        self.pending_save = Some(PendingSave { current: None, steps: steps.into(), then });
        self.save_next();
    }

    /// Saves nothing more of what is saved in turn, and says what was not saved.
    pub(super) fn stop_saving(&mut self) {
        let Some(PendingSave { current, steps, .. }) = self.pending_save.take() else { return };
        let name = |SaveStep { kind, path }: SaveStep| match path.as_deref().and_then(Path::file_name) {
            Some(name) => format!("the {} {}", kind.noun(), name.to_string_lossy()),
            None => format!("the {}", kind.noun()),
        };
        let names: Vec<String> = current.into_iter().chain(steps).map(name).collect();
        if !names.is_empty() {
            self.confirm(format!("not saved: {}", names.join(" and ")));
        }
    }

    /// Goes on with what is saved in turn.
    fn save_next(&mut self) {
        let Some(pending) = &mut self.pending_save else { return };
        pending.current = pending.steps.pop_front();
        let Some(SaveStep { kind, path }) = pending.current.clone() else {
            let then = self.pending_save.take().and_then(|pending| pending.then);
            return then.into_iter().for_each(|action| self.perform(action));
        };
        let own = match TextTab::of(kind) {
            Some(tab) => self.documents[tab].own_file(),
            None => self.session.as_ref().and_then(Location::file).filter(|_| self.mistakes.session_errors.is_none()),
        };
        match path.or_else(|| own.map(Path::to_owned)) {
            Some(path) => self.save_to(kind, path),
            None => {
                let before_session = pending_session(&pending.steps).is_some() && kind != FileKind::Session;
                let reason = if before_session { " first: the session names its file" } else { "" };
                self.show_save_dialog(Some(kind), &format!("Save the {}{reason}", kind.noun()));
            }
        }
    }

    pub(super) fn save_to(&mut self, kind: FileKind, path: PathBuf) {
        let tab = TextTab::of(kind);
        if tab.is_none() && self.save_texts_first(&path) {
            return;
        }
        let saved = match tab {
            Some(tab) => replace_text(&path, &self.documents[tab].file_text()),
            None => self.save_session_to(&path),
        };
        match saved {
            Ok(()) => {
                self.confirm(format!("saved {}", path.display()));
                let location = Location::File(path);
                self.note_recent(kind, &location);
                match tab {
                    Some(tab) => self.documents[tab].note_saved(location),
                    None => {
                        self.session = Some(location);
                        self.mistakes.session_errors = None;
                        self.notify_of_mistakes();
                        self.note_saved_session();
                    }
                }
                self.save_next();
            }
            Err(error) => {
                let text = format!("{}: {error}\nWhat was there is unharmed.", path.display());
                self.tell_not_saved(&text, Action::ShowSaveDialog(kind));
            }
        }
    }

    /// Says that a file was not written. The action saves the same elsewhere.
    pub(super) fn tell_not_saved(&mut self, text: &str, elsewhere: Action) {
        self.log.say_lines(&format!("not saved: {text}"));
        self.dialogs
            .ask(Question::new("Not saved", text).answer("Save elsewhere…", elsewhere).or("Close").dismissed(Action::StopSaving));
    }

    /// If texts have unsaved changes or are in no file, saves them, and the session after them. What has no file of the
    /// user is asked for. Returns whether there are such texts.
    fn save_texts_first(&mut self, session: &Path) -> bool {
        let changed = self.documents.values().filter(|text| text.unsaved() || text.location().is_none());
        let mut steps: Vec<SaveStep> = changed.map(|text| SaveStep { kind: text.kind(), path: None }).collect();
        if steps.is_empty() {
            return false;
        }
        steps.push(SaveStep { kind: FileKind::Session, path: Some(session.to_owned()) });
        let PendingSave { steps: rest, then, .. } = self.pending_save.take().unwrap_or_default();
        steps.extend(rest);
        self.save_in_turn(steps, then);
        true
    }

    fn save_session_to(&self, path: &Path) -> std::io::Result<()> {
        let PerTab { formula, scene } = self.documents.map(|document| document.location().cloned());
        let (Some(formula), Some(scene)) = (formula, scene) else {
            return Err(std::io::Error::other("save the formula and the scene first: a session names their files"));
        };
        self.workshop.save_session(path, formula, scene)
    }

    /// Says for a few seconds that something was done, and adds it to the log.
    pub(super) fn confirm(&mut self, text: impl AsRef<str>) {
        self.log.add(text.as_ref());
        self.confirmation.say(text);
    }

    /// Copies the picture in view to the clipboard, without marks of clipped pixels.
    pub(super) fn copy_picture(&mut self) {
        self.workshop.show_all_pixels();
        self.pane.compose(&self.workshop);
        let image = self.pane.image(&self.workshop);
        if let Some(context) = self.context.get() {
            let [width, height] = image.size;
            context.copy_image(image);
            self.confirm(format!("copied the picture, {width} × {height}"));
        }
    }

    /// Saves the picture, in the background.
    pub(super) fn save_picture(&mut self, path: PathBuf) {
        match self.workshop.export() {
            Ok(export) => {
                self.log.add(format!("saving {}", path.display()));
                let (passes, wanted) = (export.passes(), self.workshop.samples());
                let passes = if passes < wanted { format!(", {passes} of {wanted} passes") } else { String::new() };
                self.run_job(move || {
                    let saved = format!("saved {}{passes}", path.display());
                    Some(match export.save(&path) {
                        Ok(0) => JobResult::Done(saved),
                        Ok(undefined) => JobResult::Done(format!("{saved}; {}", super::log::undefined_pixels(undefined))),
                        Err(error) => JobResult::PictureNotSaved(error),
                    })
                });
            }
            Err(error) => self.tell_not_saved(&error.to_string(), Action::ShowSavePictureDialog),
        }
    }
}
