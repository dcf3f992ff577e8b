//! Texts with their names, and places in them as people count them: lines and columns.
//!
//! Nothing here reads files. The caller passes the bytes.

use crate::lang::diagnostic::Diagnostic;
use crate::lang::lines::{LINE_ENDS, count_line_ends, line_end, line_start};
pub use crate::lang::span::SourceSpan;
use std::ops::Range;

/// The largest text that is read, in bytes. A formula or a scene is a page or two, and one that a program writes may
/// declare a hundred thousand bodies. A larger file is a mistake: a picture given as a formula, say.
pub const MAX_BYTES: usize = 16 << 20;

/// The byte order mark with which a UTF-8 file may begin. It is no part of the first line.
pub const BYTE_ORDER_MARK: char = '\u{feff}';

/// A text with the name under which the user knows it: a path, or `preset:NAME`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    name: String,
    text: String,
}

impl Source {
    /// A source from a text. A byte order mark stays in the text (the lexer skips it), so that offsets are those in the
    /// file.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { name: name.into(), text: text.into() }
    }

    /// A source from the bytes of a file.
    ///
    /// # Errors
    /// The text is larger than [`MAX_BYTES`] or not UTF-8. The diagnostic has no place in a text.
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
                let start = line_start(error.as_bytes(), valid);
                let line = count_line_ends(&error.as_bytes()[..start]) + 1;
                let byte = valid - start + 1;
                Err(Diagnostic::error(format!("`{name}` is not UTF-8 text: bad byte at line {line}, byte {byte} of it"))
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

    /// The text under `span`; empty if the span does not fit the text.
    pub fn slice(&self, span: SourceSpan) -> &str {
        self.text.get(span.range()).unwrap_or("")
    }

    /// Line and column of a byte offset, both counted from 1, the column in characters. An offset beyond the end means
    /// the end; one within a character, or within a CRLF, means its first byte.
    pub fn position(&self, offset: u32) -> (usize, usize) {
        let mut offset = self.text.floor_char_boundary(offset as usize);
        if self.text[..offset].ends_with('\r') && self.text[offset..].starts_with('\n') {
            offset -= 1;
        }
        let start = line_start(self.text.as_bytes(), offset);
        let line = count_line_ends(&self.text.as_bytes()[..start]) + 1;
        let before = &self.text[start..offset];
        let before = if start == 0 { before.strip_prefix(BYTE_ORDER_MARK).unwrap_or(before) } else { before };
        (line, before.chars().count() + 1)
    }

    /// The range of the line that holds the character at `offset`, without its line end and without a byte order mark.
    pub fn line(&self, offset: usize) -> Range<usize> {
        let offset = self.text.floor_char_boundary(offset);
        let bytes = self.text.as_bytes();
        let start = line_start(bytes, offset);
        let mark = if start == 0 && self.text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len_utf8() } else { 0 };
        start + mark..line_end(bytes, start + mark)
    }

    /// The range of the text that a span means, whatever the span is: within the text, not reversed, and of whole
    /// characters.
    pub fn fit(&self, span: SourceSpan) -> Range<usize> {
        let start = self.text.floor_char_boundary(span.range().start);
        start..self.text.ceil_char_boundary(span.range().end).max(start)
    }

    /// The range of the text to mark for a span, so that there is something to see: an empty span means the character
    /// behind it; at the end of a line, the last character before it that is not white space. The range is empty only
    /// if there is no such character.
    pub fn mark(&self, span: SourceSpan) -> Range<usize> {
        let fitting = self.fit(span);
        if !fitting.is_empty() {
            return fitting;
        }
        let at = fitting.start;
        let (before, behind) = self.text.split_at(at);
        if let Some(character) = behind.chars().next().filter(|character| !LINE_ENDS.contains(character)) {
            return at..at + character.len_utf8();
        }
        let before = before.trim_end();
        match before.chars().next_back().filter(|_| before != BYTE_ORDER_MARK.encode_utf8(&mut [0; 3])) {
            Some(last) => before.len() - last.len_utf8()..before.len(),
            None => at..at,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn positions_count_characters_from_one() {
        let source = Source::new("f", "\u{feff}aé\r\nß= x");
        assert_eq!(source.position(3), (1, 1));
        assert_eq!(source.position(6), (1, 3));
        assert_eq!(source.position(7), (1, 3), "within the CRLF");
        assert_eq!(source.position(10), (2, 2));
        assert_eq!(source.position(9999), (2, 5));
    }

    #[test]
    fn lines_end_as_in_an_editor() {
        let place = |text: &str| {
            let at = text.find('X').expect("the mark");
            Source::new("f", text).position(at as u32)
        };
        assert_eq!(place("a\rb\r\rcX"), (4, 2));
        assert_eq!(place("a\r\nb\r\n\r\ncX"), (4, 2));
        assert_eq!(place("a\nb\n\ncX"), (4, 2));
        assert_eq!(place("a\u{85}b\u{2028}c\u{2029}d\u{b}e\u{c}X"), (1, 11));
        assert_eq!(place("\u{feff}a\n\u{feff}X"), (2, 2), "only the first one is a byte order mark");
    }

    #[test]
    fn a_line_has_no_line_end() {
        let source = Source::new("f", "\u{feff}a\r\nb\rc\n\nd");
        let lines: Vec<&str> = (0..source.text().len() + 2).map(|at| &source.text()[source.line(at)]).collect();
        assert_eq!(lines, ["a", "a", "a", "a", "a", "a", "b", "b", "c", "c", "", "d", "d", "d"]);
    }

    #[test]
    fn bytes_that_are_not_utf8_are_located() {
        let message = |bytes: &[u8]| Source::from_bytes("f", bytes.to_vec()).unwrap_err().message().to_owned();
        assert!(message(b"one\ntw\xff").contains("line 2, byte 3"));
        assert!(message(b"one\r\rtw\xff").contains("line 3, byte 3"));
        assert!(message(b"one\r\ntw\xff").contains("line 2, byte 3"));
    }

    #[test]
    fn an_empty_span_marks_what_can_be_seen() {
        let mark = |text: &str, at: usize| {
            let source = Source::new("f", text);
            let range = source.mark(SourceSpan::new(at, at));
            source.text()[range].to_owned()
        };
        assert_eq!(mark("ab\ncd", 1), "b");
        assert_eq!(mark("ab \ncd", 3), "b");
        assert_eq!(mark("ab\u{2003}\r\n\r\n", 9), "b");
        for text in ["", "\u{a0}", "\u{85}", "\u{2003}", "\u{2028}", "\u{feff}", " \u{feff}"] {
            assert_eq!(mark(text, text.len()), if text.starts_with(' ') { "\u{feff}" } else { "" }, "{text:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn every_span_fits(text in any::<String>(), start in 0..200_u32, end in 0..200_u32) {
            let source = Source::new("f", text.as_str());
            for range in [source.fit(SourceSpan { start, end }), source.mark(SourceSpan { start, end }), source.line(start as usize)] {
                prop_assert!(text.get(range).is_some());
            }
            let (line, column) = source.position(start);
            prop_assert!(line >= 1 && column >= 1);
        }
    }
}
