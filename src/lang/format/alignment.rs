//! The lines of a formatted text, and what stands in one column.
//!
//! Where the author has put the `=` of definitions in one column, they are in one column afterwards, and so are types
//! behind `:`. Comments behind statements are in one column if those of consecutive lines were; lines without one do
//! not interrupt it. As many spaces as the author has left before the column stay before it.

use crate::lang::lines::LINE_ENDS;
use std::collections::BTreeMap;

/// What may stand in one column inside a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum StopKind {
    /// The `=` of a definition.
    Equal,
    /// What follows the `:` of a declaration.
    Type,
}

/// A place inside a line before which there may be more spaces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stop {
    pub kind: StopKind,
    /// Offset in the text of the line.
    pub at: usize,
    /// The column in the source.
    pub column: usize,
    /// The spaces before it in the source.
    pub gap: usize,
}

/// A comment at the end of a line.
#[derive(Debug, Clone)]
pub(super) struct CommentBehind {
    pub text: String,
    /// The column in the source.
    column: usize,
    /// The spaces before it in the source; at least 1.
    gap: usize,
}

/// A line of the formatted text. A comment in it may have several lines itself.
#[derive(Debug, Clone)]
pub(super) struct FormattedLine {
    blank_above: bool,
    pub indent: usize,
    /// The words; empty if the comment behind the line above goes on here.
    pub text: String,
    pub stop: Option<Stop>,
    pub comment: Option<CommentBehind>,
    /// Offset in the source of what it begins with.
    pub source_start: Option<usize>,
}

impl FormattedLine {
    /// An empty line, indented by a number of spaces.
    pub(super) fn new(indent: usize, blank_above: bool) -> Self {
        Self { blank_above, indent, text: String::new(), stop: None, comment: None, source_start: None }
    }

    /// Puts a comment behind the words, which has the given column, and spaces before it, in the source.
    pub(super) fn put_behind(&mut self, text: &str, column: usize, gap: usize) {
        self.comment = Some(CommentBehind { text: text.to_owned(), column, gap: gap.max(1) });
    }

    /// The column behind the words.
    fn end_column(&self) -> usize {
        match self.text.rfind(LINE_ENDS) {
            // The last line of a comment keeps its indentation.
            Some(at) => self.text[at + 1..].chars().count(),
            None => self.indent + self.text.chars().count(),
        }
    }
}

/// The lines as text, each with a line feed at its end.
pub(super) fn written(mut lines: Vec<FormattedLine>) -> String {
    align_stops(&mut lines);
    let mut text = String::new();
    for (line, column) in lines.iter().zip(comment_columns(&lines)) {
        if line.blank_above {
            text.push('\n');
        }
        if !line.text.is_empty() {
            text.push_str(&" ".repeat(line.indent));
            text.push_str(&line.text);
        }
        if let Some(comment) = &line.comment {
            let used = if line.text.is_empty() { 0 } else { line.end_column() };
            text.push_str(&" ".repeat(column.saturating_sub(used)));
            text.push_str(&comment.text);
        }
        text.push('\n');
    }
    text
}

/// Widens the spaces before the stops of lines that were in one column. Lines are in one column by intent if spaces
/// fill up one of them.
fn align_stops(lines: &mut [FormattedLine]) {
    let mut columns: BTreeMap<(StopKind, usize), Vec<(usize, Stop)>> = BTreeMap::new();
    for (index, line) in lines.iter().enumerate() {
        if let Some(stop) = line.stop {
            columns.entry((stop.kind, stop.column)).or_default().push((index, stop));
        }
    }
    for stops in columns.into_values().filter(|stops| stops.len() > 1 && stops.iter().any(|(_, stop)| stop.gap > 1)) {
        let width = |(index, stop): &(usize, Stop)| lines[*index].indent + lines[*index].text[..stop.at].chars().count();
        let widest = stops.iter().map(width).max().unwrap_or(0);
        let gap = stops.iter().map(|(_, stop)| stop.gap.max(1)).min().unwrap_or(1);
        let missing: Vec<usize> = stops.iter().map(|one| widest - width(one) + gap - 1).collect();
        for ((index, stop), missing) in stops.iter().zip(missing) {
            lines[*index].text.insert_str(stop.at, &" ".repeat(missing));
        }
    }
}

/// The column of the comment behind each line; 0 where there is none.
fn comment_columns(lines: &[FormattedLine]) -> Vec<usize> {
    let mut columns = vec![0; lines.len()];
    let commented: Vec<(usize, &CommentBehind)> =
        lines.iter().enumerate().filter_map(|(index, line)| Some((index, line.comment.as_ref()?))).collect();
    for run in commented.chunk_by(|(_, one), (_, other)| one.column == other.column) {
        let with_words = || run.iter().filter(|(index, _)| !lines[*index].text.is_empty());
        let widest = with_words().map(|(index, _)| lines[*index].end_column()).max().unwrap_or(0);
        let gap = with_words().map(|(_, comment)| comment.gap).min().unwrap_or(1);
        run.iter().for_each(|(index, _)| columns[*index] = widest + gap);
    }
    columns
}
