//! Autosave: unsaved work is kept as drafts, so that a crash loses nothing.
//!
//! The interface notes what changed. A background thread writes it, or whoever ends the program: what is noted waits where any
//! thread can get at it.

use crate::lang::diagnostic::Diagnostic;
use crate::user_data::drafts::Drafts;
use crate::workspace::FileKind;
use crate::workspace::Location;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The drafts of a window, one each.
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

    /// The draft that holds work of a kind.
    pub(super) fn of(kind: FileKind) -> DraftSlot {
        match kind {
            FileKind::Formula => DraftSlot::Formula,
            FileKind::Scene => DraftSlot::Scene,
            FileKind::Session | FileKind::Material => DraftSlot::Session,
        }
    }

    /// The number of its file.
    pub(super) fn editor(self) -> u32 {
        self as u32
    }
}

/// Unsaved work as it goes into a draft.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Unsaved {
    pub(super) kind: FileKind,
    pub(super) location: Option<Location>,
    pub(super) text: String,
}

/// What becomes of a draft.
#[derive(Debug)]
enum Change {
    Keep(Unsaved),
    Remove,
}

/// The drafts of a window. Clones share them.
#[derive(Clone)]
pub(super) struct Autosave {
    shared: Arc<Shared>,
}

struct Shared {
    drafts: Mutex<Drafts>,
    /// The changes that are not on disk yet.
    waiting: Mutex<PerDraft<Option<Change>>>,
}

impl Autosave {
    pub(super) fn new(drafts: Drafts) -> Self {
        Self { shared: Arc::new(Shared { drafts: Mutex::new(drafts), waiting: Mutex::default() }) }
    }

    /// Notes that a draft should hold this, or that its work is saved. Nothing is written yet.
    pub(super) fn note(&self, slot: DraftSlot, unsaved: Option<Unsaved>) {
        lock(&self.shared.waiting)[slot as usize] = Some(unsaved.map_or(Change::Remove, Change::Keep));
    }

    /// Whether anything that was noted is not on disk yet.
    pub(super) fn is_waiting(&self) -> bool {
        lock(&self.shared.waiting).iter().any(Option::is_some)
    }

    /// Writes what was noted; it is on disk when this returns. What cannot be written goes on waiting.
    ///
    /// # Errors
    /// Why something could not be written.
    pub(super) fn flush(&self) -> Result<(), Diagnostic> {
        self.shared.flush()
    }

    /// Writes what was noted, as long as the window has not dropped all of this.
    pub(super) fn last_resort(&self) -> impl Fn() + Send + Sync + use<> {
        let shared = Arc::downgrade(&self.shared);
        move || {
            if let Some(shared) = shared.upgrade() {
                // The program is ending: nobody is left to hear that it failed.
                let _ = Autosave { shared }.flush();
            }
        }
    }

    /// The drafts themselves, while no other thread writes any.
    pub(super) fn drafts(&self) -> MutexGuard<'_, Drafts> {
        lock(&self.shared.drafts)
    }
}

impl Shared {
    fn flush(&self) -> Result<(), Diagnostic> {
        // Changes are taken under this lock, so a later one is never overtaken by an earlier one on another thread.
        let mut drafts = lock(&self.drafts);
        let changes = std::mem::take(&mut *lock(&self.waiting));
        let mut outcome = Ok(());
        for (slot, change) in DraftSlot::ALL.into_iter().zip(changes) {
            let Some(change) = change else { continue };
            let done = match &change {
                Change::Keep(Unsaved { kind, location, text }) => drafts.keep(slot.editor(), *kind, location.as_ref(), text),
                Change::Remove => drafts.remove(slot.editor()),
            };
            if let Err(error) = done {
                outcome = Err(error);
                // Unless something newer was noted meanwhile.
                lock(&self.waiting)[slot as usize].get_or_insert(change);
            }
        }
        outcome
    }
}

impl Drop for Shared {
    /// Where the interface panics, what it noted last is written here.
    fn drop(&mut self) {
        let _ = self.flush();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
