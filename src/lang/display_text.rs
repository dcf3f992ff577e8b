//! Text as a terminal, a log file or the window may show it: without characters that act on the display, and not too
//! long.
//!
//! Names and paths come from files and command lines, so they can hold anything: escape sequences, characters that
//! reverse the direction of writing, a megabyte of letters. All text of messages goes through [`one_line`] or
//! [`many_lines`]: diagnostics when they are made, everything else where it leaves the program.

use std::borrow::Cow;
use std::ops::RangeInclusive;

/// The longest run of characters without white space in a message. Names and paths of ordinary length fit.
const LONGEST_WORD: usize = 160;
/// The longest line of a message, in characters.
const LONGEST_LINE: usize = 1200;
/// The most lines that a message may have.
const MOST_LINES: usize = 1000;
/// What stands for the part that is left out.
const ELLIPSIS: char = '…';

/// Characters without a picture of their own, beside control characters: they are invisible, or they change how their
/// neighbours are ordered or joined. In ascending order.
const INVISIBLE: [RangeInclusive<char>; 17] = [
    '\u{ad}'..='\u{ad}',       // soft hyphen
    '\u{61c}'..='\u{61c}',     // Arabic letter mark
    '\u{115f}'..='\u{1160}',   // Hangul fillers
    '\u{17b4}'..='\u{17b5}',   // Khmer inherent vowels
    '\u{180b}'..='\u{180f}',   // Mongolian variation selectors and vowel separator
    '\u{200b}'..='\u{200f}',   // zero width space, joiners, direction marks
    '\u{2028}'..='\u{202e}',   // line and paragraph separator, embedding and overriding of direction
    '\u{2060}'..='\u{206f}',   // word joiner, invisible operators, isolation of direction
    '\u{3164}'..='\u{3164}',   // Hangul filler
    '\u{fe00}'..='\u{fe0f}',   // variation selectors
    '\u{feff}'..='\u{feff}',   // byte order mark
    '\u{ffa0}'..='\u{ffa0}',   // halfwidth Hangul filler
    '\u{fff0}'..='\u{fffb}',   // interlinear annotation
    '\u{13430}'..='\u{1343f}', // joining of Egyptian hieroglyphs
    '\u{1bca0}'..='\u{1bca3}', // control of shorthand
    '\u{1d173}'..='\u{1d17a}', // control of musical notation
    '\u{e0000}'..='\u{e0fff}', // tags, variation selectors
];

/// Whether a character must not be shown as it is.
pub fn is_hidden(character: char) -> bool {
    character.is_control() || character >= *INVISIBLE[0].start() && INVISIBLE.iter().any(|range| range.contains(&character))
}

/// Adds a character as it may be shown: a hidden one as an escape, `\n` or `\u{202e}`.
pub fn push_shown(character: char, text: &mut String) {
    match character {
        '\t' | '\n' | '\r' => text.extend(character.escape_default()),
        _ if is_hidden(character) => text.extend(character.escape_unicode()),
        _ => text.push(character),
    }
}

/// How many characters a character takes where it is shown.
pub fn shown_length(character: char) -> usize {
    match character {
        '\t' | '\n' | '\r' => 2,
        _ if is_hidden(character) => character.escape_unicode().len(),
        _ => 1,
    }
}

/// A text as one line of a message. Hidden characters, line ends too, are written as escapes; long words, and a long
/// text, lose their middle.
pub fn one_line(text: &str) -> String {
    if text.len() <= LONGEST_WORD && !text.chars().any(is_hidden) {
        return text.to_owned();
    }
    let mut shortened = String::new();
    // White space that is hidden is shown as an escape, which is part of a word.
    let blank = |character: char| character.is_whitespace() && !is_hidden(character);
    for piece in text.split_inclusive(blank) {
        let word = piece.trim_end_matches(blank);
        shortened.push_str(&without_middle(word, LONGEST_WORD));
        shortened.push_str(&piece[word.len()..]);
    }
    let mut line = String::with_capacity(shortened.len());
    without_middle(&shortened, LONGEST_LINE).chars().for_each(|character| push_shown(character, &mut line));
    line
}

/// A text of several lines, each as [`one_line`] makes it. Of very many lines the first are shown.
pub fn many_lines(text: &str) -> String {
    let mut lines = text.split_inclusive('\n');
    let mut shown = String::new();
    for line in lines.by_ref().take(MOST_LINES) {
        let content = line.strip_suffix('\n').unwrap_or(line);
        shown.push_str(&one_line(content));
        shown.push_str(&line[content.len()..]);
    }
    if lines.next().is_some() {
        shown.push(ELLIPSIS);
        shown.push('\n');
    }
    shown
}

/// The results of a command, which may be long: nothing is left out, but hidden characters other than line ends are
/// written as escapes.
pub fn escaped_lines(text: &str) -> Cow<'_, str> {
    let allowed = |character| character == '\n' || !is_hidden(character);
    if text.chars().all(allowed) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    text.chars().for_each(|character| if allowed(character) { shown.push(character) } else { push_shown(character, &mut shown) });
    Cow::Owned(shown)
}

/// The text if it takes at most `longest` characters where it is shown; else its beginning and its end.
fn without_middle(text: &str, longest: usize) -> Cow<'_, str> {
    let fits = |length: &mut usize, character: char| {
        *length += shown_length(character);
        (*length <= longest).then_some(*length)
    };
    if text.chars().scan(0, |length, character| fits(length, character)).count() == text.chars().count() {
        return Cow::Borrowed(text);
    }
    let half = (longest - 1) / 2;
    let head = prefix_length(text.char_indices(), half);
    let tail = text.len() - prefix_length(text.char_indices().rev().map(|(at, c)| (text.len() - at - c.len_utf8(), c)), half);
    Cow::Owned(format!("{}{ELLIPSIS}{}", &text[..head], &text[tail..]))
}

/// How many bytes the first characters have that take at most `longest` characters where they are shown.
fn prefix_length(characters: impl Iterator<Item = (usize, char)>, longest: usize) -> usize {
    let mut length = 0;
    let mut bytes = 0;
    for (at, character) in characters {
        length += shown_length(character);
        if length > longest {
            break;
        }
        bytes = at + character.len_utf8();
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn characters_that_act_on_the_display_are_escaped() {
        let text = "a\u{1b}[31mb\u{9b}1mc\u{202e}d\u{2066}e\u{200b}f\r\ng\t\0h\u{7f}";
        assert_eq!(one_line(text), "a\\u{1b}[31mb\\u{9b}1mc\\u{202e}d\\u{2066}e\\u{200b}f\\r\\ng\\t\\u{0}h\\u{7f}");
        assert_eq!(many_lines("a\nb\u{7}\n\nc"), "a\nb\\u{7}\n\nc");
        assert_eq!(escaped_lines("a\nb\u{85}"), "a\nb\\u{85}");
    }

    #[test]
    fn ordinary_text_stays() {
        for text in [
            "",
            "`kd` is unknown",
            "  indented",
            "Příliš žluťoučký kůň",
            "光の色",
            "e\u{301}",
            "1\u{202f}000\u{a0}px",
            "\\u{1b} `'\"",
        ] {
            assert_eq!(one_line(text), text);
            assert_eq!(escaped_lines(text), text);
        }
    }

    #[test]
    fn long_words_and_long_texts_lose_their_middle() {
        let name = format!("begin{}end", "x".repeat(1 << 20));
        let shown = one_line(&format!("`{name}` is not known"));
        assert!(shown.starts_with("`beginxxx") && shown.ends_with("xxend` is not known"), "{shown}");
        assert_eq!(shown.chars().count(), 159 + " is not known".len());
        let blanks = one_line(&"a ".repeat(1 << 20));
        assert_eq!(blanks.chars().count(), 1199);
        assert_eq!(many_lines(&"a\n".repeat(5000)).lines().count(), 1001);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn nothing_hidden_is_left_and_nothing_is_too_long(text in any::<String>(), hostile in "[\u{0}-\u{a0}\u{200b}-\u{206f} a]{0,3000}") {
            for text in [text, hostile] {
                let line = one_line(&text);
                prop_assert!(!line.chars().any(is_hidden));
                prop_assert!(line.chars().count() <= LONGEST_LINE);
                // The rests of two words may meet where the middle of the line is left out.
                prop_assert!(line.split_whitespace().all(|word| word.chars().count() <= 2 * LONGEST_WORD + 1));
                prop_assert!(!escaped_lines(&text).chars().any(|c| c != '\n' && is_hidden(c)));
            }
        }
    }
}
