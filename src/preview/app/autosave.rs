//! Autosave: unsaved work is saved in drafts, so a crash loses nothing.
//!
//! The interface notes changes. A background thread writes them, or whoever ends the program: the noted changes are
//! kept where any thread can write them.

use crate::lang::diagnostic::Diagnostic;
use crate::user_data::drafts::Drafts;
use crate::workspace::FileKind;
use crate::workspace::Location;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The drafts of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DraftSlot {
    Formula,
    Scene,
    Session,
}

/// One value for each draft, in the order of [`DraftSlot::ALL`].
pub(super) type PerDraft<T> = [T; DraftSlot::ALL.len()];

impl DraftSlot {
    pub(super) const ALL: [DraftSlot; 3] = [DraftSlot::Formula, DraftSlot::Scene, DraftSlot::Session];

    /// The draft for work of a kind.
    pub(super) fn of(kind: FileKind) -> DraftSlot {
        match kind {
            FileKind::Formula => DraftSlot::Formula,
            FileKind::Scene => DraftSlot::Scene,
            FileKind::Session | FileKind::Material => DraftSlot::Session,
        }
    }

    /// The number of the draft's file.
    pub(super) fn editor(self) -> u32 {
        self as u32
    }
}

/// Unsaved work for a draft.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Unsaved {
    pub(super) kind: FileKind,
    pub(super) location: Option<Location>,
    /// The session in which a text is open.
    pub(super) session: Option<Location>,
    pub(super) text: String,
}

/// A change of a draft.
#[derive(Debug)]
enum Change {
    Keep(Unsaved),
    Remove,
}

/// The drafts of a window. Clones share them.
#[derive(Clone)]
pub(super) struct Autosave {
    shared: Arc<AutosaveState>,
}

struct AutosaveState {
    drafts: Mutex<Drafts>,
    /// The changes that are not on disk yet.
    waiting: Mutex<PerDraft<Option<Change>>>,
}

impl Autosave {
    pub(super) fn new(drafts: Drafts) -> Self {
        Self { shared: Arc::new(AutosaveState { drafts: Mutex::new(drafts), waiting: Mutex::default() }) }
    }

    /// Notes what a draft should hold; `None` if the work is saved. Nothing is written yet.
    pub(super) fn note(&self, slot: DraftSlot, unsaved: Option<Unsaved>) {
        lock(&self.shared.waiting)[slot as usize] = Some(unsaved.map_or(Change::Remove, Change::Keep));
    }

    /// Whether there are changes that are not on disk yet.
    pub(super) fn is_waiting(&self) -> bool {
        lock(&self.shared.waiting).iter().any(Option::is_some)
    }

    /// Writes the noted changes. They are on disk when this returns. Changes that cannot be written are kept.
    ///
    /// # Errors
    /// A change could not be written.
    pub(super) fn flush(&self) -> Result<(), Diagnostic> {
        self.shared.flush()
    }

    /// A function that writes the noted changes, unless the window has been dropped.
    pub(super) fn last_resort(&self) -> impl Fn() + Send + Sync + use<> {
        let shared = Arc::downgrade(&self.shared);
        move || {
            if let Some(shared) = shared.upgrade() {
                // The program is ending, so nobody can be told of an error.
                let _ = Autosave { shared }.flush();
            }
        }
    }

    /// The drafts. No other thread writes them while they are borrowed.
    pub(super) fn drafts(&self) -> MutexGuard<'_, Drafts> {
        lock(&self.shared.drafts)
    }
}

impl AutosaveState {
    fn flush(&self) -> Result<(), Diagnostic> {
        // This lock is held while changes are taken, so a later change is never overwritten by an earlier one.
        let mut drafts = lock(&self.drafts);
        let changes = std::mem::take(&mut *lock(&self.waiting));
        let mut outcome = Ok(());
        for (slot, change) in DraftSlot::ALL.into_iter().zip(changes) {
            let Some(change) = change else { continue };
            let done = match &change {
                Change::Keep(Unsaved { kind, location, session, text }) => {
                    drafts.keep(slot.editor(), *kind, location.as_ref(), session.as_ref(), text)
                }
                Change::Remove => drafts.remove(slot.editor()),
            };
            if let Err(error) = done {
                outcome = Err(error);
                // Unless a newer change was noted meanwhile.
                lock(&self.waiting)[slot as usize].get_or_insert(change);
            }
        }
        outcome
    }
}

impl Drop for AutosaveState {
    /// Writes the last changes if the interface panics.
    fn drop(&mut self) {
        let _ = self.flush();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
