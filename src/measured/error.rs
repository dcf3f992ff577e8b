//! Why measurements were not read: which file, where in it, what was expected.

use std::fmt;
use std::path::Path;
use thiserror::Error;

/// Why measurements were not read. `{}` gives one line that names the file, and the place if there is one. `{:#}` adds
/// the hint.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub struct MeasuredError {
    /// The file, as it was named.
    pub file: String,
    /// Where in the file, if it is one place.
    pub place: Option<MeasuredPlace>,
    /// What is wrong.
    pub message: String,
    /// What was expected, or the likely fix.
    pub hint: Option<String>,
}

/// A place in a file of measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeasuredPlace {
    /// In a text: line and column in characters, both counted from 1.
    Text {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
    },
    /// In a binary file: the number of bytes before the place.
    Byte(u64),
}

impl MeasuredError {
    /// What is wrong, and where, without the name of the file.
    pub fn reason(&self) -> String {
        match self.place {
            Some(MeasuredPlace::Text { line, column }) => format!("line {line}, column {column}: {}", self.message),
            Some(MeasuredPlace::Byte(offset)) => format!("{} (at byte {offset})", self.message),
            None => self.message.clone(),
        }
    }
}

impl fmt::Display for MeasuredError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The name of a file, and words of its text, may hold characters that end lines.
        let line = format!("cannot read the measured material `{}`: {}", self.file, self.reason());
        f.write_str(&line.replace(char::is_control, "\u{FFFD}"))?;
        match &self.hint {
            Some(hint) if f.alternate() => write!(f, "\n{hint}"),
            Some(_) | None => Ok(()),
        }
    }
}

/// What is wrong with the contents of a file, whose name is not known here.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Flaw {
    place: Option<MeasuredPlace>,
    message: String,
    hint: Option<String>,
}

impl Flaw {
    /// Something is wrong in the file as a whole.
    pub(super) fn new(message: impl Into<String>) -> Self {
        Self { place: None, message: message.into(), hint: None }
    }

    /// Something is wrong behind this many bytes.
    pub(super) fn at_byte(offset: usize, message: impl Into<String>) -> Self {
        Self { place: Some(MeasuredPlace::Byte(offset as u64)), ..Self::new(message) }
    }

    /// Something is wrong in a text; line and column are counted from 1.
    pub(super) fn at(line: usize, column: usize, message: impl Into<String>) -> Self {
        Self { place: Some(MeasuredPlace::Text { line, column }), ..Self::new(message) }
    }

    /// With what was expected, or the likely fix.
    pub(super) fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }

    /// The error for a file.
    pub(super) fn in_file(self, path: &Path) -> MeasuredError {
        let Self { place, message, hint } = self;
        MeasuredError { file: path.display().to_string(), place, message, hint }
    }
}
