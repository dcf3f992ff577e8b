//! Words and numbers of texts that may have millions of lines.

use crate::mesh::error::Fault;
use crate::mesh::triangle_mesh::{is_coordinate, wrong_coordinate};
use std::ops::Range;
use std::str::FromStr;

/// A word with its place in the file.
#[derive(Clone)]
pub(super) struct TextWord<'t> {
    /// Its bytes.
    pub(super) bytes: &'t [u8],
    /// Where they are.
    pub(super) at: Range<usize>,
}

impl TextWord<'_> {
    /// The word as it is shown in messages.
    pub(super) fn shown(&self) -> String {
        const LONGEST: usize = 40;
        let text = String::from_utf8_lossy(&self.bytes[..self.bytes.len().min(LONGEST)]).into_owned();
        if self.bytes.len() > LONGEST { text + "…" } else { text }
    }

    /// Whether it is this keyword, in small letters or capitals.
    pub(super) fn is(&self, keyword: &str) -> bool {
        self.bytes.eq_ignore_ascii_case(keyword.as_bytes())
    }

    /// The number that it is.
    pub(super) fn parse<T: FromStr>(&self) -> Option<T> {
        std::str::from_utf8(self.bytes).ok()?.parse().ok()
    }

    /// The number that it is, which may be infinite or not a number.
    pub(super) fn number(&self) -> Result<f64, Fault> {
        self.parse().ok_or_else(|| Fault::at(self.at.clone(), format!("`{}` is not a number", self.shown())))
    }

    /// The coordinate that it is.
    pub(super) fn coordinate(&self) -> Result<f64, Fault> {
        let number = self.number()?;
        if is_coordinate(number) { Ok(number) } else { Err(Fault::at(self.at.clone(), wrong_coordinate(number))) }
    }
}

/// Reads the words of a text one after the other.
#[derive(Clone)]
pub(super) struct TextCursor<'t> {
    text: &'t [u8],
    at: usize,
}

impl<'t> TextCursor<'t> {
    /// A cursor at a place in a text.
    pub(super) fn new(text: &'t [u8], at: usize) -> Self {
        Self { text, at }
    }

    /// Where the cursor is.
    pub(super) fn offset(&self) -> usize {
        self.at
    }

    /// The place of the cursor, for messages about what is missing there.
    pub(super) fn here(&self) -> Range<usize> {
        self.at..self.at
    }

    /// Whether nothing is left.
    pub(super) fn is_at_end(&self) -> bool {
        self.at >= self.text.len()
    }

    /// The next word of this line. A backslash at the end of a line joins it with the next one.
    pub(super) fn word_in_line(&mut self) -> Option<TextWord<'t>> {
        loop {
            match self.text.get(self.at)? {
                b'\n' | b'\r' => return None,
                b'\\' if matches!(self.text.get(self.at + 1), Some(b'\n' | b'\r')) => {
                    self.at += 1;
                    self.skip_line_end();
                }
                byte if is_blank(*byte) => self.at += 1,
                _ => return Some(self.take_word()),
            }
        }
    }

    /// The next word of the text.
    pub(super) fn word(&mut self) -> Option<TextWord<'t>> {
        while is_blank(*self.text.get(self.at)?) || matches!(self.text[self.at], b'\n' | b'\r') {
            self.at += 1;
        }
        Some(self.take_word())
    }

    /// The rest of this line without the blanks around it. It may be empty.
    pub(super) fn rest_of_line(&mut self) -> TextWord<'t> {
        let start = self.at;
        while self.text.get(self.at).is_some_and(|byte| !matches!(byte, b'\n' | b'\r')) {
            self.at += 1;
        }
        let rest = &self.text[start..self.at];
        let start = start + rest.len() - rest.trim_ascii_start().len();
        let bytes = rest.trim_ascii();
        TextWord { bytes, at: start..start + bytes.len() }
    }

    /// Goes to the beginning of the next line.
    pub(super) fn skip_line(&mut self) {
        while self.text.get(self.at).is_some_and(|byte| !matches!(byte, b'\n' | b'\r')) {
            self.at += 1;
        }
        self.skip_line_end();
    }

    fn skip_line_end(&mut self) {
        match self.text[self.at.min(self.text.len())..] {
            [b'\r', b'\n', ..] => self.at += 2,
            [b'\r' | b'\n', ..] => self.at += 1,
            _ => {}
        }
    }

    #[inline]
    fn take_word(&mut self) -> TextWord<'t> {
        let start = self.at;
        while self.text.get(self.at).is_some_and(|byte| !is_blank(*byte) && !matches!(byte, b'\n' | b'\r')) {
            self.at += 1;
        }
        TextWord { bytes: &self.text[start..self.at], at: start..self.at }
    }
}

#[inline]
fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0b | 0x0c)
}
