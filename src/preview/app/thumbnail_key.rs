//! What a thumbnail is of.

use crate::workspace::{FileKind, Location};
use std::path::PathBuf;
use std::time::SystemTime;

/// What a thumbnail is of. A file that was changed has another one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ThumbnailKey {
    kind: FileKind,
    location: Location,
    changed: Option<SystemTime>,
}

impl ThumbnailKey {
    /// The thumbnail of a file as it is now. This asks the file system, so call it when a list opens.
    pub(super) fn new(kind: FileKind, location: Location) -> Self {
        let changed = location.file().and_then(|path| std::fs::metadata(path).and_then(|data| data.modified()).ok());
        Self { kind, location, changed }
    }

    /// The thumbnail of a built-in file.
    pub(super) fn preset(kind: FileKind, name: &str) -> Self {
        Self { kind, location: Location::Preset(name.to_owned()), changed: None }
    }

    /// The thumbnail of a file of the user.
    pub(super) fn file(kind: FileKind, path: PathBuf) -> Self {
        Self::new(kind, Location::File(path))
    }

    /// The kind of the file.
    pub(super) fn kind(&self) -> FileKind {
        self.kind
    }

    /// Where the file is.
    pub(super) fn location(&self) -> &Location {
        &self.location
    }
}
