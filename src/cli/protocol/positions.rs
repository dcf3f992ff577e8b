//! Places in a text as the Language Server Protocol counts them: lines, and UTF-16 units in a line, both from 0.

use illuminator::lang::lines::line_end;
use illuminator::lang::source::BYTE_ORDER_MARK;
use lsp_types::{Position, Range};
use std::ops::Range as Bytes;

/// The lines of a text, to convert places.
pub(in crate::cli) struct Positions<'t> {
    text: &'t str,
    /// Offsets of the first byte of each line.
    starts: Vec<usize>,
    /// The length of the byte order mark, which does not count in a file.
    mark: usize,
}

impl<'t> Positions<'t> {
    /// The places of a text of an editor.
    pub(in crate::cli) fn new(text: &'t str) -> Self {
        let mut starts = vec![0];
        let bytes = text.as_bytes();
        let mut at = line_end(bytes, 0);
        while at < bytes.len() {
            at += if bytes[at..].starts_with(b"\r\n") { 2 } else { 1 };
            starts.push(at);
            at = line_end(bytes, at);
        }
        Self { text, starts, mark: 0 }
    }

    /// The places of the contents of a file. A byte order mark is no character of it.
    pub(in crate::cli) fn of_file(text: &'t str) -> Self {
        let mark = if text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len_utf8() } else { 0 };
        Self { mark, ..Self::new(text) }
    }

    /// The place of a byte; a byte beyond the end means the end, and one in a character its first byte.
    pub(in crate::cli) fn position(&self, byte: usize) -> Position {
        let byte = self.text.floor_char_boundary(byte);
        let line = self.starts.partition_point(|start| *start <= byte).saturating_sub(1);
        let start = self.starts[line] + if line == 0 { self.mark } else { 0 };
        let units: usize = self.text.get(start..byte).unwrap_or("").chars().map(char::len_utf16).sum();
        Position { line: small(line), character: small(units) }
    }

    /// The place of a range of bytes.
    pub(in crate::cli) fn range(&self, bytes: Bytes<usize>) -> Range {
        Range { start: self.position(bytes.start), end: self.position(bytes.end) }
    }

    /// The byte at a place. A place behind the end of its line means that end, and a line beyond the last the end of
    /// the text.
    pub(in crate::cli) fn byte(&self, position: Position) -> usize {
        let Some(start) = self.starts.get(position.line as usize) else { return self.text.len() };
        let line = &self.text[*start..line_end(self.text.as_bytes(), *start)];
        let mut units = 0;
        for (offset, character) in line.char_indices() {
            units += character.len_utf16();
            if units > position.character as usize {
                return start + offset;
            }
        }
        start + line.len()
    }

    /// The bytes of a range; a reversed one is empty.
    pub(in crate::cli) fn bytes(&self, range: Range) -> Bytes<usize> {
        let start = self.byte(range.start);
        start..self.byte(range.end).max(start)
    }
}

fn small(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(line: u32, character: u32) -> Position {
        Position { line, character }
    }

    #[test]
    fn characters_beyond_the_first_plane_count_twice() {
        let text = "a😀é\r\nb\rc\n";
        let positions = Positions::new(text);
        let of = |part: &str| positions.position(text.find(part).unwrap());
        assert_eq!([of("a"), of("😀"), of("é"), of("\r\n")], [at(0, 0), at(0, 1), at(0, 3), at(0, 4)]);
        assert_eq!([of("b"), of("c"), positions.position(999)], [at(1, 0), at(2, 0), at(3, 0)]);
        for (byte, _) in text.char_indices().filter(|(byte, _)| !text[..*byte].ends_with('\r')) {
            assert_eq!(positions.byte(positions.position(byte)), byte);
        }
        assert_eq!(positions.byte(at(0, 2)), 1, "in the middle of a pair");
        assert_eq!([positions.byte(at(1, 77)), positions.byte(at(9, 0))], [text.find('b').unwrap() + 1, text.len()]);
        assert_eq!(positions.bytes(Range { start: at(2, 0), end: at(0, 0) }).len(), 0);
    }

    #[test]
    fn a_byte_order_mark_is_no_character_of_a_file() {
        assert_eq!(Positions::of_file("\u{feff}ab").position(4), at(0, 1));
        assert_eq!(Positions::of_file("\u{feff}ab").position(0), at(0, 0));
        assert_eq!(Positions::new("\u{feff}ab").position(4), at(0, 2));
    }
}
