//! Editing commands that egui's widget does not have: line breaks that keep the indentation, indenting, comments.
//!
//! They turn a text and a selection into an edit and a new selection. No widget is known here.

use super::history::{Edit, Selection};
use std::ops::Range;

/// What `Tab` inserts.
pub(super) const INDENT: &str = "    ";
const COMMENT: &str = "//";

/// A line break that keeps the indentation of the line.
pub(super) fn line_break(text: &str, selection: Selection) -> (Edit, Selection) {
    let range = selection.range();
    let line = &text[line_start(text, range.start)..range.start];
    let inserted = format!("\n{}", &line[..blanks(line)]);
    let cursor = Selection::cursor(range.start + inserted.len());
    (Edit::replacing(text, range, inserted), cursor)
}

/// Four spaces; or, if several lines are selected, each moved right by four spaces.
pub(super) fn indent(text: &str, selection: Selection) -> Option<(Edit, Selection)> {
    let range = selection.range();
    if !text[range.clone()].contains('\n') {
        let cursor = Selection::cursor(range.start + INDENT.len());
        return Some((Edit::replacing(text, range, INDENT), cursor));
    }
    by_lines(text, selection, |line| if line.trim().is_empty() { line.to_owned() } else { format!("{INDENT}{line}") })
}

/// Each selected line moved left, by up to four spaces or a tab.
pub(super) fn outdent(text: &str, selection: Selection) -> Option<(Edit, Selection)> {
    by_lines(text, selection, |line| {
        let spaces = line.bytes().take(INDENT.len()).take_while(|byte| *byte == b' ').count();
        line.strip_prefix('\t').unwrap_or(&line[spaces..]).to_owned()
    })
}

/// Comments the selected lines out; or removes the comments if all lines have them.
pub(super) fn toggle_comment(text: &str, selection: Selection) -> Option<(Edit, Selection)> {
    let lines = &text[lines_around(text, selection.range())];
    let full = || lines.lines().filter(|line| !line.trim().is_empty());
    let commented = full().next().is_some() && full().all(|line| line.trim_start().starts_with(COMMENT));
    let column = full().map(blanks).min().unwrap_or(0);
    by_lines(text, selection, |line| {
        if commented {
            let (head, rest) = line.split_at(blanks(line));
            let rest = rest.strip_prefix(COMMENT).unwrap_or(rest);
            format!("{head}{}", rest.strip_prefix(' ').unwrap_or(rest))
        } else if line.trim().is_empty() && full().next().is_some() {
            line.to_owned()
        } else {
            let (head, rest) = line.split_at(line.floor_char_boundary(column));
            format!("{head}{COMMENT} {rest}")
        }
    })
}

/// Changes every line of the selection. A cursor stays at its character; a selection becomes all of the lines.
fn by_lines(text: &str, selection: Selection, change: impl Fn(&str) -> String) -> Option<(Edit, Selection)> {
    let lines = lines_around(text, selection.range());
    let old = &text[lines.clone()];
    let new: Vec<String> = old.split('\n').map(change).collect();
    let new = new.join("\n");
    if new == old {
        return None;
    }
    let after = if selection.range().is_empty() {
        // Counted from the end of the line, because only its start changes.
        let behind = lines.end - selection.head;
        let kept = new.len().saturating_sub(behind);
        Selection::cursor(lines.start + new.floor_char_boundary(kept))
    } else {
        Selection { anchor: lines.start, head: lines.start + new.len() }
    };
    Some((Edit::replacing(text, lines, new), after))
}

/// The lines of a range, without the last line break. A line is not included if the range only reaches its start.
fn lines_around(text: &str, range: Range<usize>) -> Range<usize> {
    let start = line_start(text, range.start);
    let last = if range.end > range.start && text[..range.end].ends_with('\n') { range.end - 1 } else { range.end };
    let end = text[last..].find('\n').map_or(text.len(), |offset| last + offset);
    start..end
}

fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |newline| newline + 1)
}

/// The bytes of white space at the start of a line.
fn blanks(line: &str) -> usize {
    line.len() - line.trim_start_matches([' ', '\t']).len()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text after a command, with `[` and `]` around the selection, or `|` at the cursor.
    fn done(marked: &str, command: impl Fn(&str, Selection) -> Option<(Edit, Selection)>) -> String {
        let offset = |mark: &str| marked.find(mark);
        let text = marked.replace(['[', ']', '|'], "");
        let selection = match (offset("["), offset("]"), offset("|")) {
            (Some(start), Some(end), _) => Selection { anchor: start, head: end - 1 },
            (_, _, Some(at)) => Selection::cursor(at),
            _ => panic!("no mark in {marked}"),
        };
        let (mut text, selection) = match command(&text, selection) {
            Some((edit, after)) => {
                let mut new = text;
                edit.apply(&mut new);
                (new, after)
            }
            None => (text, selection),
        };
        let range = selection.range();
        if range.is_empty() {
            text.insert(range.end, '|');
        } else {
            text.insert(range.end, ']');
            text.insert(range.start, '[');
        }
        text
    }

    #[test]
    fn line_breaks_keep_the_indentation() {
        let broken = |marked| done(marked, |text, selection| Some(line_break(text, selection)));
        assert_eq!(broken("  kd = 1;|"), "  kd = 1;\n  |");
        assert_eq!(broken("|  kd"), "\n|  kd");
        assert_eq!(broken("a[č]b"), "a\n|b");
    }

    #[test]
    fn lines_are_indented_and_moved_back() {
        assert_eq!(done("a|b", indent), "a    |b");
        assert_eq!(done("[a\n\nb]\nc", indent), "[    a\n\n    b]\nc");
        assert_eq!(done("x\n[a\nb\n]c", indent), "x\n[    a\n    b]\nc");
        assert_eq!(done("[    a\n  b\n\tc]", outdent), "[a\nb\nc]");
        assert_eq!(done("  |a", outdent), "|a");
        assert_eq!(done("a|", outdent), "a|");
    }

    #[test]
    fn comments_come_and_go() {
        assert_eq!(done("  kd = č|;", toggle_comment), "  // kd = č|;");
        assert_eq!(done("  // kd|;", toggle_comment), "  kd|;");
        assert_eq!(done("[a\n\n  b]", toggle_comment), "[// a\n\n//   b]");
        assert_eq!(done("[// a\n\n//   b]", toggle_comment), "[a\n\n  b]");
        assert_eq!(done("|", toggle_comment), "// |");
        assert_eq!(done("|a", toggle_comment), "// |a");
    }
}
