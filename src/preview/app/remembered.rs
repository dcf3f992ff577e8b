//! What outlives a window: settings, recent files, and texts that were not saved.

use crate::lang::diagnostic::Diagnostic;
use crate::presets::Kind;
use crate::preview::editor::Document;
use crate::workspace::drafts::{Draft, Drafts, LeftBehind};
use crate::workspace::folders::Folders;
use crate::workspace::recent::Recent;
use crate::workspace::settings::{Settings, SettingsFile};
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
    /// The texts that are kept already, or are going to be, by their number of changes.
    kept: [Option<u64>; 2],
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
        told.extend(diagnostics.iter().map(|diagnostic| diagnostic.message().to_owned()));
        let remembered = Self {
            settings: reading.settings,
            file: Some(file),
            recent: Some(recent),
            drafts: Some(Arc::new(Mutex::new(drafts))),
            kept: [None, None],
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

    /// What is to be done to keep those texts that are not saved, and to forget those that are; it takes its time. None where all is kept.
    pub(super) fn keeping(
        &mut self,
        documents: &[Document; 2],
    ) -> Option<impl FnOnce() -> Result<(), Diagnostic> + Send + use<>> {
        let drafts = Arc::clone(self.drafts.as_ref()?);
        if self.failed.swap(false, Ordering::Relaxed) {
            // Both are tried again.
            self.kept = [Some(u64::MAX); 2];
        }
        let failed = Arc::clone(&self.failed);
        let mut changed = Vec::new();
        for (editor, (document, kept)) in documents.iter().zip(&mut self.kept).enumerate() {
            let wanted = state(document);
            if wanted != *kept {
                *kept = wanted;
                let text = wanted.map(|_| (document.kind(), document.location().cloned(), document.text().to_owned()));
                // Two editors.
                changed.push((editor as u32, text));
            }
        }
        (!changed.is_empty()).then_some(move || {
            let mut drafts = lock(&drafts);
            let kept = changed.into_iter().try_for_each(|(editor, text)| match text {
                Some((kind, location, text)) => drafts.keep(editor, kind, location.as_ref(), &text),
                None => drafts.remove(editor),
            });
            failed.store(kept.is_err(), Ordering::Relaxed);
            kept
        })
    }

    /// Whether a text was changed since they were kept.
    pub(super) fn is_behind(&self, documents: &[Document; 2]) -> bool {
        let moved = || documents.iter().zip(&self.kept).any(|(document, kept)| state(document) != *kept);
        self.drafts.is_some() && (self.failed.load(Ordering::Relaxed) || moved())
    }

    /// How many unsaved texts of programs that are gone there are.
    pub(super) fn left(&self) -> usize {
        self.left.len()
    }

    /// Takes those texts over that can be read, and forgets the rest of them where they may go.
    pub(super) fn take_left(&mut self) -> Vec<Draft> {
        let Some(drafts) = &self.drafts else { return Vec::new() };
        let mut drafts = lock(drafts);
        let mut found = Vec::new();
        for left in self.left.drain(..) {
            let Ok(draft) = &left.draft else { continue };
            let editor = u32::from(draft.kind != Kind::Formula);
            // An older text of the same kind stays for the next time.
            if let Ok(draft) = drafts.take_over(&left, editor) {
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

/// What is to be kept of a text: another number for each that is not saved.
fn state(document: &Document) -> Option<u64> {
    document.unsaved().then(|| document.id() << 32 ^ document.revision())
}
