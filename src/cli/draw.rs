//! Diagnostics drawn for a terminal: place, message, and the lines of the source with marks under them, by the library
//! `ariadne`.
//!
//! The library never gets the text itself. It gets a text with the marked lines as [`Excerpt`]s and empty lines for the
//! others, so that line numbers are right. So it never sees what it cannot draw: hidden characters, other kinds of line
//! ends, very long lines, and places outside the text.

use ariadne::{Color, Config, IndexType, Label, Report, ReportKind};
use illuminator::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use illuminator::lang::display_text::one_line;
use illuminator::lang::excerpt::Excerpt;
use illuminator::lang::source::Source;
use std::collections::BTreeMap;
use std::ops::Range;

/// Stands for the name of the source in what `ariadne` draws. No text that is shown contains it, so it is only where
/// `ariadne` writes the name.
const NAME: &str = "\0";

/// Draws diagnostics one below the other, with an empty line between them.
pub(super) fn draw_all(diagnostics: &Diagnostics, source: &Source, colour: bool) -> String {
    diagnostics.iter().map(|diagnostic| draw(diagnostic, source, colour)).collect::<Vec<_>>().join("\n")
}

/// Draws one diagnostic. The text ends with a line end.
pub(super) fn draw(diagnostic: &Diagnostic, source: &Source, colour: bool) -> String {
    if diagnostic.labels().is_empty() {
        return without_place(diagnostic);
    }
    let (kind, main_colour) = match diagnostic.severity() {
        Severity::Warning => (ReportKind::Warning, Color::Yellow),
        Severity::Error => (ReportKind::Error, Color::Red),
    };
    let sheet = MarkedLines::new(diagnostic, source);
    let label_span = |index: usize| (NAME, sheet.marks[index].clone());
    let mut report = Report::build(kind, label_span(0))
        .with_config(Config::default().with_color(colour).with_index_type(IndexType::Byte))
        .with_message(diagnostic.message());
    for (index, label) in diagnostic.labels().iter().enumerate() {
        let text = if label.text.is_empty() { "here" } else { &label.text };
        let label_colour = if index == 0 { main_colour } else { Color::Blue };
        report = report.with_label(Label::new(label_span(index)).with_message(text).with_color(label_colour));
    }
    for hint in diagnostic.hints() {
        report = report.with_help(hint);
    }
    let mut bytes = Vec::new();
    let cache = (NAME, ariadne::Source::from(sheet.text.as_str()));
    match report.finish().write(cache, &mut bytes) {
        Ok(()) => sheet.with_places(&String::from_utf8_lossy(&bytes), &one_line(source.name())),
        // Writing to memory does not fail; if it did, the message alone would be better than nothing.
        Err(_) => without_place(diagnostic),
    }
}

/// A diagnostic without its places.
fn without_place(diagnostic: &Diagnostic) -> String {
    let severity = match diagnostic.severity() {
        Severity::Warning => "Warning",
        Severity::Error => "Error",
    };
    let mut text = format!("{severity}: {}\n", diagnostic.message());
    diagnostic.hints().iter().for_each(|hint| text.push_str(&format!("  Help: {hint}\n")));
    text
}

/// The lines of a source that a diagnostic marks, each at its line number; the other lines are empty.
struct MarkedLines {
    text: String,
    /// The ranges of `text` to mark, one for each label. None is empty.
    marks: Vec<Range<usize>>,
    /// Line and column in the source where each label begins, counted from 1.
    places: Vec<(usize, usize)>,
    /// The line in which each label ends.
    last_lines: Vec<usize>,
}

/// What a label marks in one line: the bytes of the line, and whether the label begins or ends there.
struct PartOfLine {
    label: usize,
    bytes: Range<usize>,
    begins: bool,
    ends: bool,
}

impl MarkedLines {
    fn new(diagnostic: &Diagnostic, source: &Source) -> Self {
        // By line number: the range of the line in the source, and its marks.
        let mut lines: BTreeMap<usize, (Range<usize>, Vec<PartOfLine>)> = BTreeMap::new();
        let (mut places, mut last_lines) = (Vec::new(), Vec::new());
        for (label, span) in diagnostic.labels().iter().map(|label| label.span).enumerate() {
            let mark = source.mark(span);
            // The last byte that is marked. A line end counts as part of its line.
            let last = mark.end.saturating_sub(1).max(mark.start);
            let [(first_line, column), (last_line, _)] = [mark.start, last].map(|at| source.position(at as u32));
            places.push((first_line, column));
            last_lines.push(last_line);
            let [first, last] = [mark.start, last].map(|at| source.line(at));
            let in_line = |line: &Range<usize>, at: usize| at.clamp(line.start, line.end) - line.start;
            let mut add = |number: usize, line: Range<usize>, [begins, ends]: [bool; 2]| {
                let bytes = in_line(&line, mark.start)..in_line(&line, mark.end);
                lines.entry(number).or_insert((line, Vec::new())).1.push(PartOfLine { label, bytes, begins, ends });
            };
            if first_line == last_line {
                add(first_line, first, [true, true]);
            } else {
                add(first_line, first, [true, false]);
                add(last_line, last, [false, true]);
            }
        }
        let mut text = String::new();
        let mut marks = vec![0..0; places.len()];
        let mut number = 1;
        for (line_number, (line, parts)) in lines {
            text.extend(std::iter::repeat_n('\n', line_number - number));
            number = line_number;
            let bytes: Vec<Range<usize>> = parts.iter().map(|part| part.bytes.clone()).collect();
            let excerpt = Excerpt::new(&source.text()[line], &bytes);
            for (part, mark) in parts.iter().zip(excerpt.marks) {
                if part.begins {
                    marks[part.label].start = text.len() + mark.start;
                }
                if part.ends {
                    marks[part.label].end = text.len() + mark.end;
                }
            }
            text.push_str(&excerpt.text);
        }
        text.push('\n');
        Self { text, marks, places, last_lines }
    }

    /// What `ariadne` has drawn, with the name and the places of the source. `ariadne` starts each section of lines
    /// with the name and a place in the marked lines. Spaces at the ends of lines are removed.
    fn with_places(&self, drawn: &str, name: &str) -> String {
        let mut section_places = self.section_places();
        let mut text = String::with_capacity(drawn.len());
        for line in drawn.lines() {
            match line.split_once(NAME) {
                Some((before, behind)) => {
                    let behind = behind.trim_start_matches(|c: char| c == ':' || c.is_ascii_digit());
                    let (number, column) = section_places.next().unwrap_or(self.places[0]);
                    text.push_str(&format!("{before}{name}:{number}:{column}{behind}"));
                }
                None => text.push_str(line),
            }
            text.truncate(text.trim_end_matches(' ').len());
            text.push('\n');
        }
        text
    }

    /// The place of the first label of each section. `ariadne` begins a new section at a label that ends in an
    /// earlier line than the one before.
    fn section_places(&self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.places.len())
            .filter(|&label| label == 0 || self.last_lines[label] < self.last_lines[label - 1])
            .map(|label| self.places[label])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use illuminator::formula::Formula;
    use illuminator::lang::display_text::is_hidden;
    use illuminator::lang::source::SourceSpan;
    use illuminator::scene::Scene;
    use illuminator::workspace::{Library, Session};
    use proptest::prelude::*;

    fn error(text: &str, spans: &[(usize, usize)]) -> String {
        let marked = |all: Diagnostic, (order, (start, end)): (usize, &(usize, usize))| {
            all.at(SourceSpan { start: *start as u32, end: *end as u32 }, format!("remark {order}"))
        };
        let diagnostic = spans.iter().enumerate().fold(Diagnostic::error("the message"), marked).help("the help");
        draw(&diagnostic, &Source::new("name", text), false)
    }

    #[test]
    fn several_lines_are_drawn() {
        let text = "a = <1,\r\n  2,\r  3>;\nb = a;\n";
        insta::assert_snapshot!(error(text, &[(4, 19), (21, 22)]), @r"
        Error: the message
           ╭─[ name:1:5 ]
           │
         1 │ ╭─▶ a = <1,
           ┆ ┆
         3 │ ├─▶   3>;
           │ │
           │ ╰─────────── remark 0
         4 │     b = a;
           │      ┬
           │      ╰── remark 1
           │
           │     Help: the help
        ───╯
        ");
    }

    #[test]
    fn sections_have_their_own_places() {
        insta::assert_snapshot!(error("one\ntwo\n\n\nfive\n", &[(10, 12), (1, 2)]), @r"
        Error: the message
           ╭─[ name:5:1 ]
           │
         5 │ five
           │ ─┬
           │  ╰── remark 0
           │
           ├─[ name:1:2 ]
           │
         1 │ one
           │  ┬
           │  ╰── remark 1
           │
           │ Help: the help
        ───╯
        ");
    }

    #[test]
    fn long_lines_are_cut() {
        let text = format!("{}X{}", "(".repeat(5000), ")".repeat(5000));
        let shown = error(&text, &[(5000, 5001), (3, 4)]);
        assert!(shown.contains("name:1:5001 ") && shown.contains("(X)"), "{shown}");
        assert!(shown.lines().all(|line| line.chars().count() < 240), "{shown}");
    }

    #[test]
    fn wide_and_hidden_characters_are_drawn() {
        insta::assert_snapshot!(error("\u{feff}\t光 = \u{202e}é\u{301}X;", &[(17, 18), (15, 17)]), @r"
        Error: the message
           ╭─[ name:1:9 ]
           │
         1 │     光 = \u{202e}é\u{301}X;
           │                   ───┬───┬
           │                      ╰────── remark 1
           │                          │
           │                          ╰── remark 0
           │
           │ Help: the help
        ───╯
        ");
    }

    #[test]
    fn texts_without_anything_to_see_can_be_marked() {
        for text in ["", "\u{a0}", "\u{85}", "\u{2003}", "\u{2028}", "\u{feff}", "\r", "\r\n \r\n"] {
            let shown = error(text, &[(text.len(), text.len())]);
            assert!(shown.contains("[ name:") && shown.contains("remark 0"), "{text:?}: {shown}");
        }
        insta::assert_snapshot!(error("\u{a0}", &[(0, 0)]), @r"
        Error: the message
           ╭─[ name:1:1 ]
           │
         1 │ \u{a0}
           │ ───┬──
           │    ╰──── remark 0
           │
           │ Help: the help
        ───╯
        ");
    }

    /// Everything that the parsers say about a text.
    fn all_diagnostics(source: &Source) -> [Diagnostics; 4] {
        fn said<T>(outcome: Result<(T, Diagnostics), Diagnostics>) -> Diagnostics {
            outcome.map_or_else(|errors| errors, |(_, warnings)| warnings)
        }
        [said(Formula::parse(source)), said(Scene::parse(source)), said(Session::parse(source)), said(Library::parse(source))]
    }

    /// Pieces of the languages, and characters that are unusual in them.
    const PIECES: [&str; 40] = [
        "formula",
        ";",
        "=",
        "Cd",
        "*",
        "N",
        ".",
        "L",
        "(",
        ")",
        "<",
        ">",
        ",",
        "1",
        "0..1",
        "\n",
        "\r",
        "\r\n",
        " ",
        "\t",
        "bodies",
        "lights",
        "camera",
        "kd",
        ":",
        "scalar",
        "#uses",
        "invariants",
        "[",
        "]",
        "\"",
        "version",
        "/*",
        "*/",
        "//",
        "\u{a0}",
        "\u{85}",
        "\u{2028}",
        "\u{feff}",
        "\u{5149}",
    ];

    /// The text without the sequences that colour it.
    fn uncoloured(text: &str) -> String {
        let mut pieces = text.split("\u{1b}[");
        let first = pieces.next().unwrap_or_default().to_owned();
        first + &pieces.map(|piece| piece.split_once('m').expect("the end of a sequence").1).collect::<String>()
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn every_diagnostic_can_be_drawn(
            text in "([ -~]|[\u{0}-\u{9f}]|[\r\n\t]|\\PC|\u{feff}|\u{2028}|\u{1f600}|\u{301}|\u{5149}){0,300}",
            spans in prop::collection::vec((0..400_u32, 0..400_u32), 0..6),
            message in any::<String>(),
        ) {
            let source = Source::new(message.as_str(), text);
            let marked = |all: Diagnostic, (start, end): (u32, u32)| all.at(SourceSpan { start, end }, &message);
            let diagnostic = spans.into_iter().fold(Diagnostic::warning(&message), marked).help(&message);
            let plain = draw(&diagnostic, &source, false);
            prop_assert!(!plain.chars().any(|c| c != '\n' && is_hidden(c)), "{:?}", plain);
            prop_assert!(plain.contains(diagnostic.message()));
            prop_assert!(plain.lines().all(|line| line.chars().count() < 4000));
            let coloured = uncoloured(&draw(&diagnostic, &source, true));
            let without_blanks = |text: &str| text.replace(' ', "");
            prop_assert_eq!(without_blanks(&coloured), without_blanks(&plain));
        }

        #[test]
        fn every_file_can_be_explained(
            bytes in prop::collection::vec(any::<u8>(), 0..100),
            pieces in prop::collection::vec(prop::sample::select(PIECES.as_slice()), 0..40),
        ) {
            for bytes in [bytes, pieces.concat().into_bytes()] {
                let drawn = match Source::from_bytes("f", bytes) {
                    Ok(source) => all_diagnostics(&source).map(|diagnostics| draw_all(&diagnostics, &source, false)).concat(),
                    Err(diagnostic) => draw(&diagnostic, &Source::new("", ""), false),
                };
                prop_assert!(!drawn.chars().any(|c| c != '\n' && is_hidden(c)), "{:?}", drawn);
            }
        }

        #[test]
        fn every_text_of_few_characters_can_be_drawn(
            text in "[a \n\r\t\u{85}\u{2003}\u{5149}]{0,12}",
            spans in prop::collection::vec((0..30_u32, 0..30_u32), 1..4),
        ) {
            let source = Source::new("f", text);
            let marked = |all: Diagnostic, (start, end): (u32, u32)| all.at(SourceSpan { start, end }, "here");
            let diagnostic = spans.into_iter().fold(Diagnostic::error("wrong"), marked);
            let drawn = draw(&diagnostic, &source, false);
            let count = diagnostic.labels().len();
            prop_assert_eq!(drawn.matches("here").count(), count, "every mark is drawn: {}", drawn);
        }
    }
}
