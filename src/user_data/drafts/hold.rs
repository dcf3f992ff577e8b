//! The folder of one running program, and the lock that tells whether the program still runs.
//!
//! The system lets go of a lock when the program ends, however it ends. What is in the folder beside the lock is not known here.

use crate::files::{UNFINISHED_PREFIX, open_regular};
use crate::user_data::store::make_folder;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

const LOCK: &str = "lock";

/// A folder that is this program's as long as this lives.
#[derive(Debug)]
pub(super) struct Hold {
    folder: PathBuf,
    lock: File,
}

impl Hold {
    /// Makes a new folder beside those of other programs.
    pub(super) fn make(beside: &Path) -> io::Result<Hold> {
        // Another program may find the folder before it is locked, and remove it. It hardly does so twice.
        const ATTEMPTS: u32 = 16;
        for _ in 0..ATTEMPTS {
            make_folder(beside)?;
            let prefix = format!("{}-", std::process::id());
            let folder = tempfile::Builder::new().prefix(&prefix).tempdir_in(beside)?.keep();
            let path = folder.join(LOCK);
            let lock = match OpenOptions::new().write(true).create_new(true).open(&path) {
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                Err(error) => {
                    // As on a full disk: each attempt would leave an empty folder.
                    drop(fs::remove_dir(&folder));
                    return Err(error);
                }
                Ok(lock) => lock,
            };
            match lock.try_lock() {
                Err(TryLockError::WouldBlock) => continue,
                // A file system without locks: better a draft that is not found by itself than none.
                Ok(()) | Err(TryLockError::Error(_)) => {}
            }
            if path.exists() {
                return Ok(Hold { folder, lock });
            }
        }
        Err(io::Error::other("other programs remove what this one makes"))
    }

    /// Takes the folder of a program that is gone; none where that program runs, or another has the folder already.
    pub(super) fn take(folder: &Path) -> io::Result<Option<Hold>> {
        let path = folder.join(LOCK);
        let mut options = OpenOptions::new();
        options.write(true);
        let lock = match open_regular(&path, &mut options).map_err(io::Error::from) {
            // Empty it is of no use to anybody, and whoever is just making it makes another. With drafts it has lost its lock.
            Err(error) if error.kind() == ErrorKind::NotFound => {
                if fs::remove_dir(folder).is_ok() || !folder.exists() {
                    return Ok(None);
                }
                open_regular(&path, options.create(true).truncate(false))?.0
            }
            lock => lock?.0,
        };
        match lock.try_lock() {
            Ok(()) => Ok(path.exists().then(|| Hold { folder: folder.to_owned(), lock })),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(error)) => Err(error),
        }
    }

    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether nobody has taken the folder away.
    pub(super) fn is_there(&self) -> bool {
        self.folder.join(LOCK).exists()
    }

    /// Removes the folder where nothing is left in it, and what a crash left half written. It is no harm where that fails: there
    /// is nothing in it then.
    pub(super) fn tidy(&self) {
        let Ok(entries) = fs::read_dir(&self.folder) else { return };
        let names: Vec<_> = entries.flatten().map(|entry| entry.file_name()).filter(|name| name != LOCK).collect();
        if names.iter().all(|name| name.as_encoded_bytes().starts_with(UNFINISHED_PREFIX.as_bytes())) {
            names.iter().for_each(|name| drop(fs::remove_file(self.folder.join(name))));
            // Only who has the lock removes it, and the last thing before the folder: so none is ever locked that is not there.
            drop(fs::remove_file(self.folder.join(LOCK)));
            drop(fs::remove_dir(&self.folder));
        }
    }
}

impl Drop for Hold {
    fn drop(&mut self) {
        // Closing alone would not do while a child process is being started, which has the file for a moment too.
        drop(self.lock.unlock());
    }
}
