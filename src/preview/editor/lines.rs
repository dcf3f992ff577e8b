//! The positions of lines in bytes and in characters: diagnostics count bytes, and widgets count characters.
//!
//! Every position is adjusted to the text: one beyond its end becomes its end, and one inside a character becomes the
//! start of the character.

use std::ops::Range;

/// The positions of the lines of a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Lines {
    /// The byte and the character where each line starts.
    starts: Vec<[usize; 2]>,
    /// The length in bytes and in characters.
    end: [usize; 2],
}

impl Lines {
    /// The lines of a text: one more than it has line breaks.
    pub(super) fn new(text: &str) -> Self {
        let mut starts = vec![[0, 0]];
        let mut at = [0, 0];
        for line in text.split_inclusive('\n') {
            at = [at[0] + line.len(), at[1] + line.chars().count()];
            if line.ends_with('\n') {
                starts.push(at);
            }
        }
        Self { starts, end: at }
    }

    /// The number of lines, at least one.
    pub(super) fn count(&self) -> usize {
        self.starts.len()
    }

    /// The line of a byte, counted from 0.
    pub(super) fn line_of(&self, byte: usize) -> usize {
        self.starts.partition_point(|start| start[0] <= byte).saturating_sub(1)
    }

    /// The bytes of a line, with its line break.
    pub(super) fn bytes(&self, line: usize) -> Range<usize> {
        let start = |line: usize| self.starts.get(line).map_or(self.end[0], |start| start[0]);
        start(line)..start(line + 1)
    }

    /// Line and column of a byte, both counted from 0. The column counts characters.
    pub(super) fn place(&self, text: &str, byte: usize) -> (usize, usize) {
        let byte = floor(text, byte);
        let line = self.line_of(byte);
        (line, text[self.starts[line][0]..byte].chars().count())
    }

    /// The number of characters before a byte.
    pub(super) fn char_of(&self, text: &str, byte: usize) -> usize {
        let (line, column) = self.place(text, byte);
        self.starts[line][1] + column
    }

    /// The byte where a character starts.
    pub(super) fn byte_of(&self, text: &str, character: usize) -> usize {
        if character >= self.end[1] {
            return text.len();
        }
        let line = self.starts.partition_point(|start| start[1] <= character).saturating_sub(1);
        let [byte, first] = self.starts[line];
        text[byte..].char_indices().nth(character - first).map_or(text.len(), |(offset, _)| byte + offset)
    }
}

/// The start of the character at a byte.
pub(super) fn floor(text: &str, byte: usize) -> usize {
    text.floor_char_boundary(byte)
}

/// A range of bytes, adjusted to the text.
pub(super) fn fitting(text: &str, range: Range<usize>) -> Range<usize> {
    let start = floor(text, range.start);
    start..floor(text, range.end).max(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_and_characters_are_reported_apart() {
        let text = "č😀x\nβ\n";
        let lines = Lines::new(text);
        assert_eq!(lines.count(), 3);
        for (character, (byte, _)) in text.char_indices().enumerate() {
            assert_eq!(lines.char_of(text, byte), character);
            assert_eq!(lines.byte_of(text, character), byte);
        }
        assert_eq!(lines.place(text, 6), (0, 2));
        assert_eq!(lines.place(text, 8), (1, 0));
        assert_eq!(lines.bytes(1), 8..11);
        assert_eq!(lines.place(text, 99), (2, 0));
        assert_eq!(lines.byte_of(text, 99), text.len());
        assert_eq!(fitting(text, 1..4), 0..2);
    }

    #[test]
    fn an_empty_text_has_one_line() {
        let lines = Lines::new("");
        assert_eq!((lines.count(), lines.place("", 0), lines.bytes(0)), (1, (0, 0), 0..0));
    }
}
