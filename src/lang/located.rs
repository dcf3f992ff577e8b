//! Diagnostics as plain text, with the places in their source as lines and columns.

use crate::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::lang::display_text::one_line;
use crate::lang::excerpt::Excerpt;
use crate::lang::source::Source;
use std::fmt;

/// Diagnostics with the text that they are about; see [`Diagnostics::located`].
#[derive(Debug, Clone, Copy)]
pub struct Located<'d> {
    diagnostics: &'d Diagnostics,
    source: &'d Source,
}

impl Diagnostics {
    /// The diagnostics as text. `{}` gives a line for each, `FILE:LINE:COLUMN: error: MESSAGE`; `{:#}` adds the line of
    /// the source with a mark under the place, remarks and hints.
    ///
    /// ```
    /// use illuminator::{formula::Formula, lang::source::Source};
    ///
    /// let source = Source::new("lambert", "formula;\n= IL*Cb*max(0, N.L);");
    /// let errors = Formula::parse(&source).unwrap_err();
    /// assert_eq!(errors.located(&source).to_string(), "lambert:2:6: error: `Cb` is not known\n");
    /// ```
    pub fn located<'d>(&'d self, source: &'d Source) -> Located<'d> {
        Located { diagnostics: self, source }
    }
}

impl fmt::Display for Located<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = one_line(self.source.name());
        for diagnostic in self.diagnostics.iter() {
            write_head(f, diagnostic, &name, self.source)?;
            if f.alternate() {
                write_details(f, diagnostic, self.source)?;
            }
        }
        Ok(())
    }
}

/// Place, severity and message, on one line.
fn write_head(f: &mut fmt::Formatter<'_>, diagnostic: &Diagnostic, name: &str, source: &Source) -> fmt::Result {
    match diagnostic.span() {
        Some(span) => {
            let (line, column) = source.position(source.mark(span).start as u32);
            write!(f, "{name}:{line}:{column}: ")?;
        }
        None if name.is_empty() => {}
        None => write!(f, "{name}: ")?,
    }
    let severity = match diagnostic.severity() {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    writeln!(f, "{severity}: {}", diagnostic.message())
}

/// The line of the source with its mark, the remarks on all places, and the hints.
fn write_details(f: &mut fmt::Formatter<'_>, diagnostic: &Diagnostic, source: &Source) -> fmt::Result {
    let mut labels = diagnostic.labels().iter();
    if let Some(main) = labels.next() {
        let mark = source.mark(main.span);
        let line = source.line(mark.start);
        let in_line = |offset: usize| offset.clamp(line.start, line.end) - line.start;
        let in_line = in_line(mark.start)..in_line(mark.end);
        let excerpt = Excerpt::new(&source.text()[line], std::slice::from_ref(&in_line));
        writeln!(f, "    {}", excerpt.text.trim_end())?;
        writeln!(f, "{}", format!("    {} {}", excerpt.carets(), main.text).trim_end())?;
    }
    for label in labels {
        let (line, column) = source.position(source.mark(label.span).start as u32);
        writeln!(f, "{}", format!("    {line}:{column}: {}", label.text).trim_end())?;
    }
    diagnostic.hints().iter().try_for_each(|hint| writeln!(f, "    help: {hint}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::display_text::is_hidden;
    use crate::lang::source::SourceSpan;
    use proptest::prelude::*;

    #[test]
    fn both_forms_of_text() {
        let source = Source::new("model", "formula;\n\ta = 1.N;\n= a;\n");
        let diagnostics = Diagnostics::from(
            Diagnostic::error("a number stands before a name")
                .at(SourceSpan::new(14, 17), "a mark")
                .at(SourceSpan::new(9, 10), "another")
                .help("write more"),
        );
        assert_eq!(diagnostics.located(&source).to_string(), "model:2:6: error: a number stands before a name\n");
        insta::assert_snapshot!(format!("{:#}", diagnostics.located(&source)), @r"
        model:2:6: error: a number stands before a name
                a = 1.N;
                    ^^^ a mark
            2:1: another
            help: write more
        ");
        let whole = Diagnostics::from(Diagnostic::warning("nothing is here"));
        assert_eq!(format!("{:#}", whole.located(&source)), "model: warning: nothing is here\n");
        assert_eq!(format!("{:#}", whole.located(&Source::new("", ""))), "warning: nothing is here\n");
    }

    #[test]
    fn texts_without_anything_to_see_can_be_marked() {
        for text in ["", "\u{a0}", "\u{85}", "\u{2003}", "\u{2028}", "\u{feff}", "\r", "\r\n \r\n"] {
            let source = Source::new("blank", text);
            let end = text.len();
            let shown = format!(
                "{:#}",
                Diagnostics::from(Diagnostic::error("nothing").at(SourceSpan::new(end, end), "")).located(&source)
            );
            assert!(shown.starts_with("blank:") && shown.ends_with("^\n"), "{text:?}: {shown}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn every_diagnostic_can_be_shown(
            text in "([ -~]|[\u{0}-\u{9f}]|[\r\n\t]|\\PC|\u{feff}|\u{2028}|\u{1f600}|\u{301}|\u{5149}){0,300}",
            spans in prop::collection::vec((0..400_u32, 0..400_u32), 0..5),
            message in any::<String>(),
        ) {
            let source = Source::new(message.as_str(), text);
            let marked = |all: Diagnostic, (start, end): (u32, u32)| all.at(SourceSpan { start, end }, &message);
            let diagnostics = Diagnostics::from(spans.into_iter().fold(Diagnostic::error(&message), marked).help(&message));
            for shown in [format!("{}", diagnostics.located(&source)), format!("{:#}", diagnostics.located(&source))] {
                prop_assert!(!shown.chars().any(|c| c != '\n' && is_hidden(c)), "{:?}", shown);
            }
        }
    }
}
