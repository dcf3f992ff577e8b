//! The memory that reading a mesh takes, its progress, and its cancellation.

use crate::mesh::error::Fault;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a reader may use, and whom it tells.
#[derive(Clone, Copy)]
pub struct Reading<'t> {
    /// The memory budget in bytes, for the file and for what is made of it.
    pub memory: u64,
    /// Is called with the share that is done, 0..=1, from time to time.
    pub progress: &'t (dyn Fn(f64) + Sync),
    /// When it is set, the work ends soon.
    pub cancelled: &'t AtomicBool,
}

impl Reading<'static> {
    /// Work that nobody watches or cancels, with a memory budget in bytes.
    pub fn unwatched(memory: u64) -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self { memory, progress: &|_| (), cancelled: &NEVER }
    }
}

/// Counts the memory of lists before it is allocated.
pub(super) struct Ledger<'t> {
    reading: Reading<'t>,
    used: u64,
    /// Whether no progress is told.
    quiet: bool,
}

/// The capacity of a list with its first element.
const FIRST_CAPACITY: usize = 64;
/// Progress is told, and cancellation looked for, once for this many records.
const BLOCK: usize = 1 << 14;

impl<'t> Ledger<'t> {
    pub(super) fn new(reading: &Reading<'t>) -> Self {
        Self { reading: *reading, used: 0, quiet: false }
    }

    /// Counts bytes that are about to be allocated.
    pub(super) fn charge(&mut self, bytes: u64) -> Result<(), Fault> {
        let needed = self.used.saturating_add(bytes);
        if needed > self.reading.memory {
            return Err(Fault::Memory { needed, allowed: self.reading.memory });
        }
        self.used = needed;
        Ok(())
    }

    /// Makes place for this many elements more. Nothing is allocated if they do not fit.
    pub(super) fn reserve<T>(&mut self, list: &mut Vec<T>, more: usize) -> Result<(), Fault> {
        let missing = (list.len().saturating_add(more)).saturating_sub(list.capacity());
        if missing == 0 {
            return Ok(());
        }
        let bytes = (missing as u64).saturating_mul(size_of::<T>() as u64);
        self.charge(bytes)?;
        let refused = Fault::Memory { needed: self.used, allowed: self.reading.memory };
        list.try_reserve_exact(more).map_err(|_| refused)
    }

    /// Adds an element. A full list grows to twice its capacity.
    pub(super) fn push<T>(&mut self, list: &mut Vec<T>, element: T) -> Result<(), Fault> {
        if list.len() == list.capacity() {
            self.reserve(list, list.capacity().max(FIRST_CAPACITY))?;
        }
        list.push(element);
        Ok(())
    }

    /// Frees a list.
    pub(super) fn release<T>(&mut self, list: Vec<T>) {
        self.used = self.used.saturating_sub((list.capacity() as u64).saturating_mul(size_of::<T>() as u64));
        drop(list);
    }

    /// Tells the share that is done, and ends cancelled work.
    pub(super) fn tell(&self, share: f64) -> Result<(), Fault> {
        if !self.quiet {
            (self.reading.progress)(share.clamp(0.0, 1.0));
        }
        self.check(0)
    }

    /// Tells how many of all parts of a file are read, and ends cancelled work.
    pub(super) fn tell_parsing(&self, done: usize, all: usize) -> Result<(), Fault> {
        self.tell(PARSING.0 + PARSING.1 * done as f64 / all.max(1) as f64)
    }

    /// Tells how many of all parts of a file are complete, and ends cancelled work.
    pub(super) fn tell_completing(&self, done: usize, all: usize) -> Result<(), Fault> {
        let before = PARSING.0 + PARSING.1;
        self.tell(before + (1.0 - before) * done as f64 / all.max(1) as f64)
    }

    /// Does a part of the work without telling its progress.
    pub(super) fn quietly<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let before = std::mem::replace(&mut self.quiet, true);
        let result = work(self);
        self.quiet = before;
        result
    }

    /// As [`tell_parsing`](Self::tell_parsing) with bytes as parts, for one record of each block.
    pub(super) fn tell_record(&self, record: usize, offset: usize, bytes: usize) -> Result<(), Fault> {
        if record.is_multiple_of(BLOCK) { self.tell_parsing(offset, bytes) } else { Ok(()) }
    }

    /// Ends cancelled work at one record of each block.
    pub(super) fn check(&self, record: usize) -> Result<(), Fault> {
        let cancelled = record.is_multiple_of(BLOCK) && self.reading.cancelled.load(Ordering::Relaxed);
        if cancelled { Err(Fault::Cancelled) } else { Ok(()) }
    }
}

/// The progress at which a file has been read and parsing begins, and the share of parsing in the whole work. After it
/// the mesh is completed.
pub(super) const PARSING: (f64, f64) = (0.1, 0.7);
