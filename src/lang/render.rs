//! Diagnostics as text: file, line, column, the source line and a mark under the span, drawn by `ariadne`.
//!
//! Very long lines (a formula pasted without line breaks) are cut to a window around the mark before they are drawn.

use crate::lang::diagnostic::{Diagnostic, Severity};
use crate::lang::source::{Source, Span};
use ariadne::{Color, Config, IndexType, Label, Report, ReportKind};
use std::ops::Range;

/// Lines longer than this many bytes are cut around the mark.
const LONG_LINE: usize = 240;
/// Bytes kept on either side of a mark in a line that is cut.
const KEPT: usize = 80;

/// Draws one diagnostic; see [`Diagnostic::render`].
pub(super) fn render(diagnostic: &Diagnostic, source: &Source, colour: bool) -> String {
    let (kind, ink) = match diagnostic.severity() {
        Severity::Warning => (ReportKind::Warning, Color::Yellow),
        Severity::Error => (ReportKind::Error, Color::Red),
    };
    let Some(main) = diagnostic.span() else {
        let word = match diagnostic.severity() {
            Severity::Warning => "Warning",
            Severity::Error => "Error",
        };
        let mut text = format!("{word}: {}\n", diagnostic.message());
        for hint in diagnostic.hints() {
            text.push_str(&format!("  Help: {hint}\n"));
        }
        return text;
    };
    if diagnostic.labels().iter().any(|label| line_around(source, label.span).len() > LONG_LINE) {
        return render_cut(diagnostic, source, main);
    }
    let name = source.name().to_owned();
    let place = |span: Span| (name.clone(), visible(source, span));
    let mut report = Report::build(kind, place(main))
        .with_config(Config::default().with_color(colour).with_index_type(IndexType::Byte).with_tab_width(4))
        .with_message(diagnostic.message());
    for (order, label) in diagnostic.labels().iter().enumerate() {
        let ink = if order == 0 { ink } else { Color::Blue };
        let text = if label.text.is_empty() { "here" } else { &label.text };
        report = report.with_label(Label::new(place(label.span)).with_message(text).with_color(ink));
    }
    for hint in diagnostic.hints() {
        report = report.with_help(hint);
    }
    let mut bytes = Vec::new();
    let cache = (name.clone(), ariadne::Source::from(printable(source.text())));
    match report.finish().write(cache, &mut bytes) {
        Ok(()) => {
            let places = diagnostic.labels().iter().map(|label| source.position(visible(source, label.span).start as u32));
            without_trailing_blanks(&with_true_places(
                &String::from_utf8_lossy(&bytes),
                source.name(),
                &places.collect::<Vec<_>>(),
            ))
        }
        // Writing to memory does not fail; were it to, the message alone is better than nothing.
        Err(_) => format!("{}\n", diagnostic.message()),
    }
}

/// `ariadne` heads every further block of lines with the place of the main mark; this puts that of the block's own mark there.
fn with_true_places(text: &str, name: &str, places: &[(usize, usize)]) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let numbered = |line: &str| line.split('│').next().and_then(|margin| margin.trim().parse::<usize>().ok());
    let head = format!("[ {name}:");
    let mut out = String::with_capacity(text.len());
    for (index, line) in lines.iter().enumerate() {
        let shown = lines[index..].iter().skip(1).find_map(|line| numbered(line));
        let place = places.iter().find(|(number, _)| Some(*number) == shown);
        match (line.trim_start().strip_prefix("├─").and(line.find(&head)), place) {
            (Some(start), Some((number, column))) => {
                out.push_str(&line[..start]);
                out.push_str(&format!("{head}{number}:{column} ]\n"));
            }
            (Some(_), None) | (None, _) => {
                out.push_str(line);
                out.push('\n');
            }
        }
    }
    out
}

/// The text with other marks for control characters, which a terminal would obey; places stay what they are.
fn printable(text: &str) -> String {
    let obeyed = |c: char| c.is_ascii_control() && !matches!(c, '\n' | '\r' | '\t');
    text.chars().map(|c| if obeyed(c) { '?' } else { c }).collect()
}

fn without_trailing_blanks(text: &str) -> String {
    text.lines().map(|line| line.trim_end().to_owned() + "\n").collect()
}

/// A span as a non-empty range within the text, so that there is something to mark even at its end.
fn visible(source: &Source, span: Span) -> Range<usize> {
    let text = source.text();
    let end = span.range().end.min(text.len());
    let start = span.range().start.min(end);
    if start < end {
        return start..end;
    }
    if start == text.len() || text[start..].starts_with(['\n', '\r']) {
        // Behind the last character of a line: mark that character.
        let before = text[..start].trim_end();
        let last = before.chars().next_back().map_or(0, char::len_utf8);
        return before.len() - last..before.len().max(1).min(text.len());
    }
    start..start + text[start..].chars().next().map_or(0, char::len_utf8)
}

/// The line in which `span` begins.
fn line_around(source: &Source, span: Span) -> &str {
    let text = source.text();
    let place = visible(source, span).start;
    let start = text[..place].rfind('\n').map_or(0, |newline| newline + 1);
    let end = text[place..].find('\n').map_or(text.len(), |newline| place + newline);
    &text[start..end]
}

/// The form for very long lines: a window of the line with carets under the mark.
fn render_cut(diagnostic: &Diagnostic, source: &Source, main: Span) -> String {
    let text = source.text();
    let place = visible(source, main);
    let (line, column) = source.position(main.start);
    let whole = line_around(source, main);
    let line_start = whole.as_ptr() as usize - text.as_ptr() as usize;
    let line_end = line_start + whole.len();
    let boundary = |mut offset: usize| {
        while !text.is_char_boundary(offset) {
            offset -= 1;
        }
        offset
    };
    let from = boundary(place.start.saturating_sub(KEPT).max(line_start));
    let to = boundary((place.start + KEPT).min(line_end));
    let mark_end = place.end.clamp(place.start, to);
    let word = match diagnostic.severity() {
        Severity::Warning => "Warning",
        Severity::Error => "Error",
    };
    let before = if from > line_start { "… " } else { "" };
    let after = if to < line_end { " …" } else { "" };
    let gap = before.chars().count() + text[from..place.start].chars().count();
    let carets = text[place.start..mark_end].chars().count().max(1);
    let mut out = format!("{word}: {}\n   ╭─[ {}:{line}:{column} ]\n   │\n", diagnostic.message(), source.name());
    out.push_str(&format!("   │ {before}{}{after}\n", printable(&text[from..to]).replace('\t', " ").trim_end()));
    out.push_str(&format!("   │ {}{} {}\n", " ".repeat(gap), "^".repeat(carets), diagnostic.labels()[0].text));
    for label in &diagnostic.labels()[1..] {
        let (line, column) = source.position(label.span.start);
        out.push_str(&format!("   │ line {line}, column {column}: {}\n", label.text));
    }
    for hint in diagnostic.hints() {
        out.push_str(&format!("   │ Help: {hint}\n"));
    }
    out.push_str("───╯\n");
    without_trailing_blanks(&out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_cut_around_the_mark() {
        let text = format!("{}X{}", "(".repeat(5000), ")".repeat(5000));
        let source = Source::new("deep", text);
        let shown = Diagnostic::error("too deep").at(Span::new(5000, 5001), "here").render(&source, false);
        assert!(shown.contains("deep:1:5001"), "{shown}");
        assert!(shown.lines().all(|line| line.chars().count() < 200), "{shown}");
    }

    #[test]
    fn the_end_of_an_empty_text_can_be_marked() {
        let source = Source::new("empty", "");
        let shown = Diagnostic::error("nothing here").at(Span::new(0, 0), "").render(&source, false);
        assert!(shown.contains("nothing here"), "{shown}");
    }
}
