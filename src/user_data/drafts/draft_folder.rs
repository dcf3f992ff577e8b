//! The folder of one running program, and the lock that tells whether the program still runs.
//!
//! The system releases a lock when the program ends, in whatever way. What else is in the folder is not known here.

use crate::files::{UNFINISHED_PREFIX, open_regular};
use crate::user_data::store::create_folder;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

const LOCK: &str = "lock";

/// A folder that belongs to this program as long as this value lives.
#[derive(Debug)]
pub(super) struct DraftFolder {
    folder: PathBuf,
    lock: File,
}

impl DraftFolder {
    /// Creates a folder beside those of other programs.
    pub(super) fn create(beside: &Path) -> io::Result<DraftFolder> {
        // Another program may find the folder and remove it before it is locked. That is unlikely to happen twice.
        const ATTEMPTS: u32 = 16;
        for _ in 0..ATTEMPTS {
            create_folder(beside)?;
            let prefix = format!("{}-", std::process::id());
            let folder = tempfile::Builder::new().prefix(&prefix).tempdir_in(beside)?.keep();
            let path = folder.join(LOCK);
            let lock = match OpenOptions::new().write(true).create_new(true).open(&path) {
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                Err(error) => {
                    // Otherwise each attempt on a full disk would leave an empty folder.
                    drop(fs::remove_dir(&folder));
                    return Err(error);
                }
                Ok(lock) => lock,
            };
            match lock.try_lock() {
                Err(TryLockError::WouldBlock) => continue,
                // If the file system has no locks, a draft that is not found later is still better than none.
                Ok(()) | Err(TryLockError::Error(_)) => {}
            }
            if path.exists() {
                return Ok(DraftFolder { folder, lock });
            }
        }
        Err(io::Error::other("other programs remove what this one makes"))
    }

    /// Locks the folder of a program that has ended. `None` if the program still runs, or another program has the
    /// folder.
    pub(super) fn try_lock(folder: &Path) -> io::Result<Option<DraftFolder>> {
        let path = folder.join(LOCK);
        let mut options = OpenOptions::new();
        options.write(true);
        let lock = match open_regular(&path, &mut options).map_err(io::Error::from) {
            // An empty folder is of no use. A program that is just creating it will create another one. A folder with
            // drafts has lost its lock file.
            Err(error) if error.kind() == ErrorKind::NotFound => {
                if fs::remove_dir(folder).is_ok() || !folder.exists() {
                    return Ok(None);
                }
                open_regular(&path, options.create(true).truncate(false))?.0
            }
            lock => lock?.0,
        };
        match lock.try_lock() {
            Ok(()) => Ok(path.exists().then(|| DraftFolder { folder: folder.to_owned(), lock })),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(error)) => Err(error),
        }
    }

    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether the folder still exists.
    pub(super) fn exists(&self) -> bool {
        self.folder.join(LOCK).exists()
    }

    /// Removes the folder if it has no drafts, together with files that a crash left half written. If that fails, an
    /// empty folder stays, which does no harm.
    pub(super) fn remove_if_empty(&self) {
        let Ok(entries) = fs::read_dir(&self.folder) else { return };
        let names: Vec<_> = entries.flatten().map(|entry| entry.file_name()).filter(|name| name != LOCK).collect();
        if names.iter().all(|name| name.as_encoded_bytes().starts_with(UNFINISHED_PREFIX.as_bytes())) {
            names.iter().for_each(|name| drop(fs::remove_file(self.folder.join(name))));
            // Only the owner of the lock removes its file, directly before the folder. So nobody can hold the lock of
            // a folder that does not exist.
            drop(fs::remove_file(self.folder.join(LOCK)));
            drop(fs::remove_dir(&self.folder));
        }
    }
}

impl Drop for DraftFolder {
    fn drop(&mut self) {
        // Closing the file is not enough: a child process that is just being started has it open for a moment too.
        drop(self.lock.unlock());
    }
}
