//! What a file was when somebody looked at it, so that a change is noticed.

use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// A file with its size and the time of its last change. Another stamp means other contents. A change that keeps the
/// size, within what the system can tell apart in time, is not noticed.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct FileStamp {
    path: PathBuf,
    length: u64,
    changed: Option<SystemTime>,
}

impl FileStamp {
    /// The stamp of a file by what the system says about it.
    pub fn new(path: &Path, metadata: &Metadata) -> Self {
        Self { path: path.to_owned(), length: metadata.len(), changed: metadata.modified().ok() }
    }

    /// The stamp of the file at a path as it is now, without links in the path. `None` if there is none, or it cannot
    /// be looked at.
    pub fn of(path: &Path) -> Option<Self> {
        Some(Self::new(&path.canonicalize().ok()?, &path.metadata().ok()?))
    }

    /// The size in bytes.
    pub fn length(&self) -> u64 {
        self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_changed_file_has_another_stamp() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        assert_eq!(FileStamp::of(&path), None);
        fs::write(&path, "one").unwrap();
        let first = FileStamp::of(&path).unwrap();
        assert_eq!((first.length(), Some(&first)), (3, FileStamp::of(&folder.path().join(".").join("a")).as_ref()));
        fs::write(&path, "longer").unwrap();
        assert_ne!(FileStamp::of(&path), Some(first.clone()));
        // The same size at another time.
        fs::write(&path, "two").unwrap();
        fs::File::options().write(true).open(&path).unwrap().set_modified(SystemTime::UNIX_EPOCH).unwrap();
        assert_ne!(FileStamp::of(&path), Some(first));
    }
}
