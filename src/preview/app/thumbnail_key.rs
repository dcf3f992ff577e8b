//! What a thumbnail is of.

use crate::files::FileStamp;
use crate::workspace::{FileKind, Location};
use std::path::PathBuf;

/// What a thumbnail is of. A file that was changed has another one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ThumbnailKey {
    kind: FileKind,
    location: Location,
    /// The file as it was. Built-in ones have none.
    stamp: Option<FileStamp>,
}

impl ThumbnailKey {
    /// The thumbnail of a file as it is now. This asks the file system, so call it when a list opens.
    pub(super) fn new(kind: FileKind, location: Location) -> Self {
        let stamp = location.file().and_then(FileStamp::of);
        Self { kind, location, stamp }
    }

    /// The thumbnail of a built-in file.
    pub(super) fn preset(kind: FileKind, name: &str) -> Self {
        Self { kind, location: Location::Preset(name.to_owned()), stamp: None }
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
