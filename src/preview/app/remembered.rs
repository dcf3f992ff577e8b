//! What outlives a window: settings, recent files, and texts and values that were not saved.

use crate::lang::diagnostic::Diagnostic;
use crate::presets::Kind;
use crate::workspace::drafts::{Draft, Drafts, LeftBehind};
use crate::workspace::files::Location;
use crate::workspace::folders::Folders;
use crate::workspace::recent::Recent;
use crate::workspace::settings::{Settings, SettingsFile};
use std::cmp::Reverse;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What is remembered; nothing where there is no folder for it.
#[derive(Default)]
pub(super) struct Remembered {
    pub(super) settings: Settings,
    file: Option<SettingsFile>,
    recent: Option<Recent>,
    /// Written by whoever has the time for it.
    drafts: Option<Arc<Mutex<Drafts>>>,
    /// What is kept already, or is going to be, of the texts and of the session: the number that tells what it is.
    kept: [Option<u64>; 3],
    /// Whether they could not be kept.
    failed: Arc<AtomicBool>,
    left: Vec<LeftBehind>,
    data: Option<PathBuf>,
}

impl Remembered {
    /// Reads what was remembered; with it, what is to be said of it.
    pub(super) fn open(folders: Option<&Folders>) -> (Self, Vec<String>) {
        let Some(folders) = folders else { return (Self::default(), Vec::new()) };
        let mut told = Vec::new();
        let mut file = SettingsFile::new(folders);
        let reading = file.read();
        told.extend(reading.diagnostics.iter().map(|diagnostic| format!("settings: {}", diagnostic.message())));
        let (recent, diagnostic) = Recent::open(folders);
        told.extend(diagnostic.map(|diagnostic| diagnostic.message().to_owned()));
        let drafts = Drafts::new(folders);
        let (left, diagnostics) = drafts.left_behind();
        let left = sorted_out(left, &drafts);
        told.extend(diagnostics.iter().map(|diagnostic| diagnostic.message().to_owned()));
        let remembered = Self {
            settings: reading.settings,
            file: Some(file),
            recent: Some(recent),
            drafts: Some(Arc::new(Mutex::new(drafts))),
            kept: [None; 3],
            failed: Arc::default(),
            left,
            data: Some(folders.data.clone()),
        };
        (remembered, told)
    }

    /// The folder for materials of built-in formulas.
    pub(super) fn data(&self) -> Option<&Path> {
        self.data.as_deref()
    }

    /// Saves the settings, where that is wanted at all.
    pub(super) fn save_settings(&mut self) -> Result<(), Diagnostic> {
        match &mut self.file {
            Some(file) => file.save(&self.settings).map(|_| ()),
            None => Ok(()),
        }
    }

    /// The recent files of a kind, the newest first.
    pub(super) fn recent(&self, kind: Kind) -> Vec<PathBuf> {
        self.recent.as_ref().map_or_else(Vec::new, |recent| recent.list(kind))
    }

    /// Remembers a file.
    pub(super) fn add_recent(&mut self, kind: Kind, path: &Path) -> Result<(), Diagnostic> {
        self.recent.as_mut().map_or(Ok(()), |recent| recent.add(kind, path))
    }

    /// What is to be done to keep what is not saved, of formula, scene and session, and to forget what is; it takes its time. None where all
    /// is kept. Each has a number that tells what it is, and none where it is saved.
    pub(super) fn keeping(
        &mut self,
        wanted: [Option<u64>; 3],
        unsaved: &dyn Fn(usize) -> Unsaved,
    ) -> Option<impl FnOnce() -> Result<(), Diagnostic> + Send + use<>> {
        let drafts = Arc::clone(self.drafts.as_ref()?);
        if self.failed.swap(false, Ordering::Relaxed) {
            // All are tried again.
            self.kept = [Some(u64::MAX); 3];
        }
        let failed = Arc::clone(&self.failed);
        let mut changed = Vec::new();
        for (editor, (wanted, kept)) in wanted.into_iter().zip(&mut self.kept).enumerate() {
            if wanted != *kept {
                *kept = wanted;
                // There are three.
                changed.push((editor as u32, wanted.map(|_| unsaved(editor))));
            }
        }
        (!changed.is_empty()).then_some(move || {
            let mut drafts = lock(&drafts);
            let kept = changed.into_iter().try_for_each(|(editor, text)| match text {
                Some(Unsaved { kind, location, text }) => drafts.keep(editor, kind, location.as_ref(), &text),
                None => drafts.remove(editor),
            });
            failed.store(kept.is_err(), Ordering::Relaxed);
            kept
        })
    }

    /// Whether anything was changed since it was kept.
    pub(super) fn is_behind(&self, wanted: [Option<u64>; 3]) -> bool {
        self.drafts.is_some() && (self.failed.load(Ordering::Relaxed) || wanted != self.kept)
    }

    /// What programs that are gone left unsaved, for people.
    pub(super) fn left(&self) -> Vec<String> {
        let name = |left: &LeftBehind| {
            let Ok(draft) = &left.draft else { return "what cannot be read".to_owned() };
            let what = if draft.kind == Kind::Session { "values of the session" } else { draft.kind.noun() };
            match &draft.location {
                Some(location) => format!("{what} {location}"),
                None => format!("{what} without a file"),
            }
        };
        self.left.iter().map(name).collect()
    }

    /// Whether there is more among it than values of a built-in session: those are tried and left, and nobody wants to be asked for them.
    pub(super) fn left_is_work(&self) -> bool {
        !self.left.iter().all(is_play)
    }

    /// Takes those texts over that can be read, and forgets the rest of them where they may go.
    pub(super) fn take_left(&mut self) -> Vec<Draft> {
        let Some(drafts) = &self.drafts else { return Vec::new() };
        let mut drafts = lock(drafts);
        let mut found = Vec::new();
        for left in self.left.drain(..) {
            let Ok(draft) = &left.draft else { continue };
            let editor = place_of(draft.kind);
            // An older text of the same kind stays for the next time.
            if let Ok(draft) = drafts.take_over(&left, editor) {
                // It is kept now, whatever it is going to be.
                self.kept[editor as usize] = Some(u64::MAX);
                found.push(draft);
            }
        }
        found
    }

    /// Forgets them.
    pub(super) fn discard_left(&mut self) -> Result<(), Diagnostic> {
        let Some(drafts) = &self.drafts else { return Ok(()) };
        let drafts = lock(drafts);
        self.left.drain(..).try_for_each(|left| drafts.discard(&left))
    }
}

fn lock(drafts: &Mutex<Drafts>) -> MutexGuard<'_, Drafts> {
    drafts.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether it is nothing but values of a built-in session.
fn is_play(left: &LeftBehind) -> bool {
    let built_in = |draft: &Draft| draft.kind == Kind::Session && matches!(draft.location, Some(Location::Preset(_)));
    left.draft.as_ref().is_ok_and(built_in)
}

/// Formulas before scenes before sessions, the newest first. Of values of built-in sessions only the newest stay: they would become ever more.
fn sorted_out(mut left: Vec<LeftBehind>, drafts: &Drafts) -> Vec<LeftBehind> {
    left.sort_by_key(|left| left.draft.as_ref().ok().map(|draft| (place_of(draft.kind), Reverse(draft.time))));
    let mut seen = false;
    // Where one cannot be removed, it is there the next time too.
    left.retain(|left| !is_play(left) || !std::mem::replace(&mut seen, true) || drafts.discard(left).is_err());
    left
}

/// Which of the three a kind is.
fn place_of(kind: Kind) -> u32 {
    match kind {
        Kind::Formula => 0,
        Kind::Scene => 1,
        Kind::Session | Kind::Material => 2,
    }
}

/// What is to be kept of something that is not saved.
pub(super) struct Unsaved {
    pub(super) kind: Kind,
    pub(super) location: Option<Location>,
    pub(super) text: String,
}
