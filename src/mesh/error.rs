//! Why a mesh was not read: what is wrong, and where.

use crate::lang::display_text::one_line;
use crate::lang::excerpt::Excerpt;
use crate::lang::lines::{count_line_ends, line_end, line_start};
use crate::lang::memory_size::MemorySize;
use std::fmt;
use std::ops::Range;
use thiserror::Error;

/// The longest part of a line that is kept to be shown, in bytes.
const LONGEST_EXCERPT: usize = 200;

/// Why a mesh was not read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum MeshError {
    /// The caller cancelled the work.
    #[error("the work was cancelled")]
    Cancelled,
    /// The mesh needs more memory than the budget. It may need still more: reading ended here.
    #[error(
        "`{}` is too large: it needs {} or more, and {} are allowed",
        one_line(file), MemorySize(*needed), MemorySize(*allowed)
    )]
    Memory {
        /// The file.
        file: String,
        /// The bytes that are needed at least.
        needed: u64,
        /// The memory budget in bytes.
        allowed: u64,
    },
    /// The file cannot be opened or read, or it is not a mesh.
    #[error(transparent)]
    File(MeshFileError),
    /// The contents of the file are wrong.
    #[error(transparent)]
    Content(Box<MeshMistake>),
}

/// Why a file was not read at all. The message names the file. `{:#}` adds the hint.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub struct MeshFileError {
    /// What is wrong, one line.
    pub message: String,
    /// What was expected, or the likely fix.
    pub hint: Option<String>,
}

/// What is wrong in the contents of a file. `{}` gives one line, `FILE:LINE:COLUMN: MESSAGE`; `{:#}` adds the line of
/// the text with a mark, and the hint.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub struct MeshMistake {
    /// The file.
    pub file: String,
    /// Where, if it is one place.
    pub place: Option<MeshPlace>,
    /// What is wrong, one line.
    pub message: String,
    /// What was expected, or the likely fix.
    pub hint: Option<String>,
}

/// A place in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MeshPlace {
    /// In a text.
    Text {
        /// The line, counted from 1.
        line: usize,
        /// The column in characters, counted from 1.
        column: usize,
        /// The line, or the part of it around the place.
        excerpt: String,
        /// The marked part of the excerpt, in bytes.
        mark: Range<usize>,
    },
    /// In a binary file: the number of bytes before the place.
    Byte(usize),
}

impl MeshError {
    /// Whether the caller cancelled the work.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, MeshError::Cancelled)
    }

    /// What was expected, or the likely fix.
    pub fn hint(&self) -> Option<&str> {
        match self {
            MeshError::File(error) => error.hint.as_deref(),
            MeshError::Content(mistake) => mistake.hint.as_deref(),
            MeshError::Cancelled | MeshError::Memory { .. } => None,
        }
    }
}

impl fmt::Display for MeshFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&one_line(&self.message))?;
        write_hint(f, self.hint.as_deref())
    }
}

impl MeshMistake {
    /// What is wrong, and the line of the text with a mark, if it is in a text.
    pub fn with_excerpt(&self) -> String {
        let (file, message) = (one_line(&self.file), one_line(&self.message));
        match &self.place {
            Some(MeshPlace::Text { line, column, excerpt, mark }) => {
                let excerpt = Excerpt::new(excerpt, std::slice::from_ref(mark));
                let (text, carets) = (excerpt.text.trim_end().to_owned(), excerpt.carets());
                format!("{file}:{line}:{column}: {message}\n    {text}\n    {}", carets.trim_end())
            }
            Some(MeshPlace::Byte(offset)) => format!("{file}: {message} (at byte {offset})"),
            None => format!("{file}: {message}"),
        }
    }
}

impl fmt::Display for MeshMistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.with_excerpt();
        f.write_str(if f.alternate() { &text } else { text.lines().next().unwrap_or_default() })?;
        write_hint(f, self.hint.as_deref())
    }
}

/// The hint on a line of its own, in the long form.
fn write_hint(f: &mut fmt::Formatter<'_>, hint: Option<&str>) -> fmt::Result {
    match hint.filter(|_| f.alternate()) {
        Some(hint) => write!(f, "\n    help: {}", one_line(hint)),
        None => Ok(()),
    }
}

/// Why a reader gave up. It knows offsets, and neither names nor lines.
#[derive(Debug)]
pub(super) enum Fault {
    Cancelled,
    Memory {
        needed: u64,
        allowed: u64,
    },
    File(Box<MeshFileError>),
    Content(Box<Mistake>),
    /// In another file, which the file names.
    Elsewhere(Box<MeshError>),
}

/// What is wrong in the contents of a file, with the range of its bytes if it is one place.
#[derive(Debug)]
pub(super) struct Mistake {
    at: Option<Range<usize>>,
    message: String,
    hint: Option<String>,
}

/// How places in a file are told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Places {
    /// As lines and columns.
    Lines,
    /// As the number of bytes before them.
    Offsets,
}

impl Fault {
    /// A mistake of the file as a whole.
    pub(super) fn new(message: impl Into<String>) -> Self {
        Fault::Content(Box::new(Mistake { at: None, message: message.into(), hint: None }))
    }

    /// A mistake at a place.
    pub(super) fn at(at: Range<usize>, message: impl Into<String>) -> Self {
        Fault::Content(Box::new(Mistake { at: Some(at), message: message.into(), hint: None }))
    }

    /// Whether the contents of the file itself are wrong.
    pub(super) fn is_of_content(&self) -> bool {
        match self {
            Fault::Content(_) => true,
            Fault::Cancelled | Fault::Memory { .. } | Fault::File(_) | Fault::Elsewhere(_) => false,
        }
    }

    /// The same with a hint.
    pub(super) fn help(mut self, hint: impl Into<String>) -> Self {
        if let Fault::Content(mistake) = &mut self {
            mistake.hint = Some(hint.into());
        }
        self
    }

    /// The same at a place, if it has none.
    pub(super) fn or_at(mut self, at: Range<usize>) -> Self {
        if let Fault::Content(mistake) = &mut self {
            mistake.at.get_or_insert(at);
        }
        self
    }

    /// The same with the part of the file in front of the message.
    pub(super) fn within(mut self, part: &str) -> Self {
        if let Fault::Content(mistake) = &mut self {
            mistake.message = format!("{part}: {}", mistake.message);
        }
        self
    }

    /// The error for the user.
    pub(super) fn in_file(self, file: &str, bytes: &[u8], places: impl FnOnce(usize) -> Places) -> MeshError {
        match self {
            Fault::Cancelled => MeshError::Cancelled,
            Fault::Memory { needed, allowed } => MeshError::Memory { file: file.to_owned(), needed, allowed },
            Fault::File(error) => MeshError::File(*error),
            Fault::Elsewhere(error) => *error,
            Fault::Content(mistake) => {
                let Mistake { at, message, hint } = *mistake;
                let place = at.map(|at| match places(at.start) {
                    Places::Lines => in_lines(bytes, at),
                    Places::Offsets => MeshPlace::Byte(at.start),
                });
                MeshError::Content(Box::new(MeshMistake { file: file.to_owned(), place, message, hint }))
            }
        }
    }
}

/// A place in a text that may not be UTF-8. Of a long line only a part is kept.
fn in_lines(bytes: &[u8], at: Range<usize>) -> MeshPlace {
    let start = line_start(bytes, at.start);
    let end = line_end(bytes, at.start.max(start));
    let (mark_start, mark_end) = (at.start.clamp(start, end), at.end.clamp(start, end));
    let text = |range: Range<usize>| String::from_utf8_lossy(&bytes[range]).into_owned();
    let kept_start = start.max(mark_start.saturating_sub(LONGEST_EXCERPT / 2));
    let kept_end = end.min(mark_start + LONGEST_EXCERPT / 2);
    let before = text(kept_start..mark_start);
    let marked = text(mark_start..mark_end.min(kept_end));
    let behind = text(mark_end.min(kept_end)..kept_end);
    MeshPlace::Text {
        line: count_line_ends(&bytes[..start]) + 1,
        column: String::from_utf8_lossy(&bytes[start..mark_start]).chars().count() + 1,
        mark: before.len()..before.len() + marked.len(),
        excerpt: before + &marked + &behind,
    }
}
