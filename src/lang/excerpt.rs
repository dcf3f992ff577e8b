//! A line of a text as it is shown below a message: on one line, safe for any display, cut around a mark if it is long.

use crate::lang::display_text::{push_shown, shown_length};
use std::ops::Range;

/// Lines that take more characters than this are cut.
const LONG_LINE: usize = 240;
/// Characters kept on either side of the beginning of the first mark in a line that is cut.
const KEPT: usize = 80;
/// The distance of tab stops.
const TAB: usize = 4;
/// What stands for a part that is left out, at the beginning and at the end.
const CUT: [&str; 2] = ["… ", " …"];

/// A line as it is shown, with its marks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Excerpt {
    /// The line. It has no tabs, no line ends and no other hidden characters.
    pub text: String,
    /// The marks as ranges of bytes in `text`, in the order in which they were given. None is empty.
    pub marks: Vec<Range<usize>>,
}

impl Excerpt {
    /// Shows a line, without its line end, with marks: ranges of bytes that begin and end between characters of the
    /// line. A mark in a part that is left out is moved to the `…` that stands for it; an empty mark covers the
    /// character behind it, or a blank after the line.
    pub fn new(line: &str, marks: &[Range<usize>]) -> Self {
        let kept = kept_part(line, marks.first().map_or(0, |mark| mark.start));
        let mut text = String::new();
        if kept.start > 0 {
            text.push_str(CUT[0]);
        }
        // For each character that is kept: where it begins in the line, and where in the text.
        let mut offsets = Vec::with_capacity(kept.len());
        let mut column = 0;
        for (offset, character) in line[kept.clone()].char_indices() {
            offsets.push([kept.start + offset, text.len()]);
            if character == '\t' {
                let width = TAB - column % TAB;
                text.extend(std::iter::repeat_n(' ', width));
                column += width;
            } else if is_combining(character) && marks.iter().any(|mark| mark.start == kept.start + offset) {
                // Drawn over the character before it, it could not be marked.
                text.extend(character.escape_unicode());
                column += character.escape_unicode().len();
            } else {
                push_shown(character, &mut text);
                column += shown_length(character);
            }
        }
        offsets.push([kept.end, text.len()]);
        if kept.end < line.len() {
            text.push_str(CUT[1]);
        }
        let in_text = |offset: usize| {
            if offset < kept.start {
                return 0;
            }
            match offsets.get(offsets.partition_point(|[from, _]| *from < offset)) {
                Some([_, shown]) => *shown,
                // In the part that is left out at the end: the `…` there.
                None => text.len() - '…'.len_utf8(),
            }
        };
        let marks: Vec<Range<usize>> = marks.iter().map(|mark| in_text(mark.start)..in_text(mark.end)).collect();
        Self { text, marks }.with_visible_marks()
    }

    /// Makes empty marks one character long.
    fn with_visible_marks(mut self) -> Self {
        if self.marks.iter().any(|mark| mark.start >= self.text.len()) {
            self.text.push(' ');
        }
        for mark in &mut self.marks {
            if mark.start == mark.end {
                mark.end = mark.start + self.text[mark.start..].chars().next().map_or(0, char::len_utf8);
            }
        }
        self
    }

    /// The line of `^` that stands under the first mark, as if every character were one column wide.
    pub fn carets(&self) -> String {
        let Some(mark) = self.marks.first() else { return String::new() };
        let columns = |range: Range<usize>| self.text[range].chars().count();
        format!("{}{}", " ".repeat(columns(0..mark.start)), "^".repeat(columns(mark.clone())))
    }
}

/// Whether a character is drawn together with the one before it, such as an accent. Rust escapes such a character that
/// is alone.
fn is_combining(character: char) -> bool {
    !character.is_ascii() && character.escape_debug().len() > 2
}

/// The part of a line that is shown if this byte is its most important place.
fn kept_part(line: &str, byte: usize) -> Range<usize> {
    let byte = line.floor_char_boundary(byte);
    if bytes_within(line.chars(), LONG_LINE) == line.len() {
        return 0..line.len();
    }
    byte - bytes_within(line[..byte].chars().rev(), KEPT)..byte + bytes_within(line[byte..].chars(), KEPT)
}

/// How many bytes the first of some characters have that take at most `longest` characters where they are shown.
fn bytes_within(characters: impl Iterator<Item = char>, longest: usize) -> usize {
    let mut length = 0;
    let mut bytes = 0;
    for character in characters {
        length += shown_length(character);
        if length > longest {
            break;
        }
        bytes += character.len_utf8();
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::display_text::is_hidden;
    use proptest::prelude::*;

    #[test]
    fn tabs_and_escapes_move_the_marks() {
        let line = "\ta\u{202e}b = ü;";
        let excerpt = Excerpt::new(line, &[5..6, 1..2, 9..11, 12..12]);
        assert_eq!(excerpt.text, "    a\\u{202e}b = ü; ");
        let marked: Vec<&str> = excerpt.marks.iter().map(|mark| &excerpt.text[mark.clone()]).collect();
        assert_eq!(marked, ["b", "a", "ü", " "]);
        assert_eq!(excerpt.carets(), format!("{}^", " ".repeat(13)));
    }

    #[test]
    fn a_combining_character_can_be_marked() {
        let line = "e\u{301}e\u{301}";
        assert_eq!(Excerpt::new(line, &[0..3, 4..6]).text, "e\u{301}e\\u{301}");
        assert_eq!(Excerpt::new(line, &[4..6, 0..1]).carets(), format!("{}^^^^^^^", " ".repeat(3)));
    }

    #[test]
    fn long_lines_are_cut_around_the_first_mark() {
        let line = format!("{}X{}", "(".repeat(5000), ")".repeat(5000));
        let excerpt = Excerpt::new(&line, &[5000..5001, 3..4, 9000..9004]);
        assert_eq!(excerpt.text, format!("… {}X{} …", "(".repeat(80), ")".repeat(79)));
        let marked: Vec<&str> = excerpt.marks.iter().map(|mark| &excerpt.text[mark.clone()]).collect();
        assert_eq!(marked, ["X", "…", "…"]);
        assert_eq!(excerpt.marks[1].start, 0);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn every_line_can_be_shown(line in "[^\r\n]{0,400}", bytes in prop::collection::vec(any::<prop::sample::Index>(), 0..6)) {
            let boundaries: Vec<usize> = line.char_indices().map(|(at, _)| at).chain([line.len()]).collect();
            let bytes: Vec<usize> = bytes.iter().map(|byte| *byte.get(&boundaries)).collect();
            let marks: Vec<Range<usize>> = bytes.chunks(2).map(|two| two[0].min(two[two.len() - 1])..two[0].max(two[two.len() - 1])).collect();
            let excerpt = Excerpt::new(&line, &marks);
            prop_assert!(!excerpt.text.chars().any(is_hidden));
            prop_assert!(excerpt.text.chars().count() <= LONG_LINE + TAB * LONG_LINE);
            prop_assert_eq!(excerpt.marks.len(), marks.len());
            for mark in &excerpt.marks {
                prop_assert!(!mark.is_empty() && excerpt.text.get(mark.clone()).is_some());
            }
            excerpt.carets();
        }
    }
}
