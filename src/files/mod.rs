//! Files on disk: opening them without waiting for what is not a file, replacing them whole or not at all, and numbers
//! for what was read from them.
//!
//! No text is parsed here, and no picture is encoded. The callers bring the contents.

mod numbered;
mod open;
mod replace;
mod stamp;

use std::io::{self, ErrorKind};

pub use numbered::{NoRoom, NumberedFiles};
pub use open::{FileType, OpenError, Readable, open, open_regular};
pub use replace::{UNFINISHED_PREFIX, follow_links, remove_unfinished, replace_file, replace_text};
pub use stamp::FileStamp;

/// What the system says about an error, without its number.
pub fn reason(error: &io::Error) -> String {
    const PLAIN: [(ErrorKind, &str); 4] = [
        (ErrorKind::NotFound, "there is no such file"),
        (ErrorKind::PermissionDenied, "permission denied"),
        (ErrorKind::NotADirectory, "a part of the path is not a folder"),
        (ErrorKind::StorageFull, "the disk is full"),
    ];
    let known = PLAIN.iter().find(|(kind, _)| *kind == error.kind());
    known.map_or_else(
        || error.to_string().split(" (os error").next().unwrap_or_default().to_lowercase(),
        |(_, text)| (*text).to_owned(),
    )
}
