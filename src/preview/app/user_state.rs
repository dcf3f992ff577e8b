//! What outlives a window: settings, recent files, and drafts.

use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::preview::app::autosave::{Autosave, DraftSlot, PerDraft, Unsaved};
use crate::preview::app::notices::{Notice, Topic};
use crate::user_data::drafts::{Draft, Drafts, LeftoverDraft};
use crate::user_data::folders::Folders;
use crate::user_data::recent::Recent;
use crate::user_data::settings::{Settings, SettingsFile};
use crate::workspace::FileKind;
use crate::workspace::Location;
use std::cmp::Reverse;
use std::path::{Path, PathBuf};

/// The user data. Empty if there is no folder for it.
#[derive(Default)]
pub(super) struct UserState {
    pub(super) settings: Settings,
    file: Option<SettingsFile>,
    recent: Option<Recent>,
    autosave: Option<Autosave>,
    /// The states of the drafts that were noted last.
    noted: PerDraft<Option<u64>>,
    left: Vec<LeftoverDraft>,
    data: Option<PathBuf>,
    /// Whether the scale of widgets is that of an earlier run.
    pub(super) scale_is_given: bool,
}

impl UserState {
    /// Reads the user data. Returns notices about what could not be read.
    pub(super) fn open(folders: Option<&Folders>) -> (Self, Vec<Notice>) {
        let Some(folders) = folders else { return (Self::default(), Vec::new()) };
        let mut file = SettingsFile::new(folders);
        let reading = file.read();
        let (recent, recent_warning) = Recent::open(folders);
        let drafts = Drafts::new(folders);
        let (left, left_warnings) = drafts.leftover_drafts();
        let left = sort_drafts(left, &drafts);
        let mut notices = Vec::new();
        if !reading.diagnostics.is_empty() {
            let details = reading.diagnostics.iter().map(|diagnostic| match diagnostic.span() {
                Some(span) => format!("line {}: {}", reading.source.position(span.start).0, line(diagnostic)),
                None => line(diagnostic),
            });
            let details = details.collect::<Vec<_>>().join("\n");
            notices.push(Notice::warning(Topic::Settings, "The settings file has errors", details));
        }
        if let Some(warning) = recent_warning {
            notices.push(Notice::warning(Topic::Recent, "The list of recent files starts empty", line(&warning)));
        }
        if !left_warnings.is_empty() {
            let title = "Unsaved work of earlier runs may be missing";
            notices.push(Notice::warning(Topic::LeftDrafts, title, lines(&left_warnings)));
        }
        let user_state = Self {
            settings: reading.settings,
            file: Some(file),
            recent: Some(recent),
            autosave: Some(Autosave::new(drafts)),
            noted: PerDraft::default(),
            left,
            data: Some(folders.data.clone()),
            scale_is_given: reading.scale_is_given,
        };
        (user_state, notices)
    }

    /// The folder for materials of built-in formulas.
    pub(super) fn data(&self) -> Option<&Path> {
        self.data.as_deref()
    }

    /// Saves the settings, if there is a file for them.
    pub(super) fn save_settings(&mut self) -> Result<(), Diagnostic> {
        match &mut self.file {
            Some(file) => file.save(&self.settings).map(|_| ()),
            None => Ok(()),
        }
    }

    /// The recent files of a kind, newest first.
    pub(super) fn recent(&self, kind: FileKind) -> Vec<PathBuf> {
        self.recent.as_ref().map_or_else(Vec::new, |recent| recent.list(kind))
    }

    /// Adds a recent file.
    pub(super) fn add_recent(&mut self, kind: FileKind, path: &Path) -> Result<(), Diagnostic> {
        self.recent.as_mut().map_or(Ok(()), |recent| recent.add(kind, path))
    }

    /// Notes the unsaved work of some drafts. `states` identifies the state of each; `None` is saved. Drafts whose
    /// state did not change are left alone. Nothing is written yet.
    pub(super) fn note_unsaved(
        &mut self,
        slots: &[DraftSlot],
        states: PerDraft<Option<u64>>,
        unsaved: impl Fn(DraftSlot) -> Unsaved,
    ) {
        let Some(autosave) = &self.autosave else { return };
        for &slot in slots {
            let (noted, state) = (&mut self.noted[slot as usize], states[slot as usize]);
            if *noted != state {
                *noted = state;
                autosave.note(slot, state.map(|_| unsaved(slot)));
            }
        }
    }

    /// The drafts; `None` if nothing is kept.
    pub(super) fn autosave(&self) -> Option<&Autosave> {
        self.autosave.as_ref()
    }

    /// Whether there are changes that are not on disk yet.
    pub(super) fn is_behind(&self, states: PerDraft<Option<u64>>) -> bool {
        self.autosave.as_ref().is_some_and(|autosave| autosave.is_waiting() || states != self.noted)
    }

    /// The drafts of earlier runs, for the user.
    pub(super) fn draft_names(&self) -> Vec<String> {
        let name = |left: &LeftoverDraft| {
            let Ok(draft) = &left.draft else { return "what cannot be read".to_owned() };
            let what = if draft.kind == FileKind::Session { "values of the session" } else { draft.kind.noun() };
            match &draft.location {
                Some(location) => format!("{what} {location}"),
                None => format!("{what} without a file"),
            }
        };
        self.left.iter().map(name).collect()
    }

    /// Whether there are drafts other than values of built-in sessions. Users try those and leave; they do not want to
    /// be asked about them.
    pub(super) fn has_important_drafts(&self) -> bool {
        !self.left.iter().all(is_preset_session)
    }

    /// Takes over the drafts of earlier runs that can be read.
    pub(super) fn restore_drafts(&mut self) -> Vec<Draft> {
        let Some(autosave) = &self.autosave else { return Vec::new() };
        let mut drafts = autosave.drafts();
        let mut found = Vec::new();
        for left in self.left.drain(..) {
            let Ok(draft) = &left.draft else { continue };
            let slot = DraftSlot::of(draft.kind);
            // An older draft of the same kind stays for the next start.
            if let Ok(draft) = drafts.take_over(&left, slot.editor()) {
                // The draft exists from now on. Its text is noted again when it is open.
                self.noted[slot as usize] = Some(u64::MAX);
                found.push(draft);
            }
        }
        found
    }

    /// Discards the drafts of earlier runs.
    pub(super) fn discard_drafts(&mut self) -> Result<(), Diagnostic> {
        let Some(autosave) = &self.autosave else { return Ok(()) };
        let drafts = autosave.drafts();
        self.left.drain(..).try_for_each(|left| drafts.discard(&left))
    }
}

/// The message and the hints of a diagnostic, without its place.
pub(super) fn line(diagnostic: &Diagnostic) -> String {
    let hints = diagnostic.hints().iter().map(|hint| format!(" ({hint})"));
    std::iter::once(diagnostic.message().to_owned()).chain(hints).collect()
}

fn lines(diagnostics: &Diagnostics) -> String {
    diagnostics.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Whether a draft only has values of a built-in session.
fn is_preset_session(left: &LeftoverDraft) -> bool {
    let built_in = |draft: &Draft| draft.kind == FileKind::Session && matches!(draft.location, Some(Location::Preset(_)));
    left.draft.as_ref().is_ok_and(built_in)
}

/// Sorts drafts: formulas, scenes, sessions, the newest first. Of the values of built-in sessions, only the newest
/// draft stays, so they do not pile up.
fn sort_drafts(mut left: Vec<LeftoverDraft>, drafts: &Drafts) -> Vec<LeftoverDraft> {
    left.sort_by_key(|left| left.draft.as_ref().ok().map(|draft| (DraftSlot::of(draft.kind).editor(), Reverse(draft.time))));
    let mut seen = false;
    // A draft that cannot be removed stays.
    left.retain(|left| !is_preset_session(left) || !std::mem::replace(&mut seen, true) || drafts.discard(left).is_err());
    left
}
