//! The words of GLSL.

use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::SourceSpan;
use std::ops::Range;

/// A word of GLSL with its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct GlslToken<'t> {
    pub(super) text: &'t str,
    pub(super) kind: GlslTokenKind,
    pub(super) span: SourceSpan,
}

/// What a word is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GlslTokenKind {
    Name,
    Number,
    /// A sign, or several that belong together.
    Mark,
    /// A line that begins with `#`.
    Directive,
}

/// Signs of more than one character.
const MARKS: [&str; 18] =
    ["<<=", ">>=", "<<", ">>", "++", "--", "+=", "-=", "*=", "/=", "%=", "<=", ">=", "==", "!=", "&&", "||", "^^"];

/// The words of a part of a text. Comments are left out.
pub(super) fn tokens<'t>(text: &'t str, part: Range<usize>, diagnostics: &mut Diagnostics) -> Vec<GlslToken<'t>> {
    let mut found = Vec::new();
    let mut at = part.start;
    let mut begins_line = true;
    while let Some(first) = text[at..part.end].chars().next() {
        let rest = &text[at..part.end];
        if first.is_whitespace() {
            begins_line |= first == '\n' || first == '\r';
            at += first.len_utf8();
            continue;
        }
        if rest.starts_with("//") {
            at += rest.find(['\n', '\r']).unwrap_or(rest.len());
            continue;
        }
        if rest.starts_with("/*") {
            match rest.find("*/") {
                Some(end) => at += end + 2,
                None => {
                    let span = SourceSpan::new(at, at + 2);
                    diagnostics.push(Diagnostic::error("a comment does not end").at(span, "it begins here"));
                    at = part.end;
                }
            }
            continue;
        }
        let is_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        let (kind, length) = if first == '#' && begins_line {
            (GlslTokenKind::Directive, rest.find(['\n', '\r']).unwrap_or(rest.len()))
        } else if first.is_ascii_digit() || first == '.' && rest[1..].starts_with(|next: char| next.is_ascii_digit()) {
            (GlslTokenKind::Number, number_length(rest))
        } else if is_word(first) {
            (GlslTokenKind::Name, rest.find(|letter| !is_word(letter)).unwrap_or(rest.len()))
        } else {
            let mark = MARKS.iter().find(|mark| rest.starts_with(**mark));
            (GlslTokenKind::Mark, mark.map_or(first.len_utf8(), |mark| mark.len()))
        };
        found.push(GlslToken { text: &rest[..length], kind, span: SourceSpan::new(at, at + length) });
        at += length;
        begins_line = false;
    }
    found
}

/// The length of a number at the beginning of a text, with its suffix.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut length = 0;
    while let Some(byte) = bytes.get(length) {
        let is_sign =
            matches!(byte, b'+' | b'-') && length > 0 && matches!(bytes[length - 1], b'e' | b'E') && !text.starts_with("0x");
        if !(byte.is_ascii_alphanumeric() || *byte == b'.' || is_sign) {
            break;
        }
        length += 1;
    }
    length
}
