//! Source texts and places in them: files as read, byte spans, lines and columns.
//!
//! Nothing here reads files; whoever does hands over the bytes.

use crate::lang::diagnostic::Diagnostic;
use std::ops::Range;

/// The largest text that is taken in, in bytes. A formula or a scene is a page or two; what is larger is a mistake
/// (a picture given as a formula, say), and the tools that mark errors in it should not have to cope.
pub const MAX_BYTES: usize = 4 << 20;

/// A half-open range of byte offsets into one [`Source`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Span {
    /// Offset of the first byte.
    pub start: u32,
    /// Offset behind the last byte.
    pub end: u32,
}

impl Span {
    /// The span from `start` up to, not including, `end`.
    pub fn new(start: usize, end: usize) -> Self {
        let narrow = |offset: usize| u32::try_from(offset).unwrap_or(u32::MAX);
        Self { start: narrow(start), end: narrow(end) }
    }

    /// The smallest span that covers both.
    pub fn to(self, other: Span) -> Span {
        Span { start: self.start.min(other.start), end: self.end.max(other.end) }
    }

    /// The span as a range of indices.
    pub fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// A text with the name under which the user knows it: a path, or `preset:NAME`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    name: String,
    text: String,
}

impl Source {
    /// A source from text at hand. A byte order mark stays in the text (the lexer skips it), so that offsets are the file's.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { name: name.into(), text: text.into() }
    }

    /// A source from the bytes of a file.
    ///
    /// # Errors
    /// Text that is larger than [`MAX_BYTES`] or not UTF-8; the diagnostic then stands alone, without a marked line.
    pub fn from_bytes(name: impl Into<String>, bytes: Vec<u8>) -> Result<Self, Diagnostic> {
        let name = name.into();
        if bytes.len() > MAX_BYTES {
            return Err(Diagnostic::error(format!("`{name}` is too large: {} bytes", bytes.len()))
                .help(format!("formulas, scenes and sessions are texts of at most {MAX_BYTES} bytes")));
        }
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Self { name, text }),
            Err(error) => {
                let valid = error.utf8_error().valid_up_to();
                let before = &error.as_bytes()[..valid];
                let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
                let column = valid - before.iter().rposition(|&byte| byte == b'\n').map_or(0, |newline| newline + 1) + 1;
                Err(Diagnostic::error(format!("`{name}` is not UTF-8 text: bad byte at line {line}, byte {column} of it"))
                    .help("save the file as UTF-8; pictures and other binary files cannot be read here"))
            }
        }
    }

    /// The name under which the user knows the text.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The text under `span`; empty where the span is not one of this source.
    pub fn slice(&self, span: Span) -> &str {
        self.text.get(span.range()).unwrap_or("")
    }

    /// Line and column of a byte offset, both counted from 1, the column in characters.
    pub fn position(&self, offset: u32) -> (usize, usize) {
        let mut offset = (offset as usize).min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &self.text[..offset];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.bytes().filter(|&byte| byte == b'\n').count() + 1;
        let column = before[line_start..].trim_start_matches('\u{feff}').chars().count() + 1;
        (line, column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_characters_from_one() {
        let source = Source::new("f", "\u{feff}aé\r\nß= x");
        assert_eq!(source.position(3), (1, 1));
        assert_eq!(source.position(6), (1, 3));
        assert_eq!(source.position(10), (2, 2));
        assert_eq!(source.position(9999), (2, 5));
    }

    #[test]
    fn bytes_that_are_not_utf8_are_located() {
        let error = Source::from_bytes("f", b"one\ntw\xff".to_vec()).unwrap_err();
        assert!(error.message().contains("line 2, byte 3"), "{}", error.message());
    }
}
