//! What is said to the user about a text: errors and warnings with the places that they concern.
//!
//! A [`Diagnostic`] says what is wrong, where, what was expected and what the likely fix is. Parsers and checkers
//! collect as many as they can find in [`Diagnostics`]. These are plain data: [`located`](mod@crate::lang::located)
//! gives them as plain text, and the command line and the window show them in their own ways. All text in them may be
//! shown anywhere, see [`display_text`](crate::lang::display_text).

use crate::lang::display_text::one_line;
use crate::lang::span::SourceSpan;

/// How many errors, and how many warnings, are kept for one text.
pub const MOST: usize = 100;
/// How many places one diagnostic marks.
const MOST_LABELS: usize = 12;
/// Longer names than this resemble no other name by mistake.
const LONGEST_MISSPELT: usize = 64;

/// How serious a diagnostic is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The text is accepted, but probably means something else than its author thinks.
    Warning,
    /// The text cannot be accepted.
    Error,
}

/// A marked place with a remark.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// The place.
    pub span: SourceSpan,
    /// The remark, one line; may be empty.
    pub text: String,
}

/// One error or warning. Each of its texts is one line that may be shown anywhere.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    severity: Severity,
    message: String,
    labels: Vec<Label>,
    hints: Vec<String>,
}

impl Diagnostic {
    /// An error; the message is one sentence without a full stop. Messages of libraries may begin with the word
    /// "error". It is left out, because the severity is shown in front of the message.
    pub fn error(message: impl AsRef<str>) -> Self {
        let message = one_line(without_severity(message.as_ref()));
        Self { severity: Severity::Error, message, labels: Vec::new(), hints: Vec::new() }
    }

    /// A warning; the message is one sentence without a full stop.
    pub fn warning(message: impl AsRef<str>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message) }
    }

    /// Marks a place. The first marked place is the place of the diagnostic. Places beyond a dozen are not kept.
    #[must_use]
    pub fn at(mut self, span: SourceSpan, text: impl AsRef<str>) -> Self {
        if self.labels.len() < MOST_LABELS {
            self.labels.push(Label { span, text: one_line(text.as_ref()) });
        }
        self
    }

    /// Adds a hint: what was expected, or the likely fix.
    #[must_use]
    pub fn help(mut self, text: impl AsRef<str>) -> Self {
        self.hints.push(one_line(text.as_ref()));
        self
    }

    /// Adds a hint if there is one.
    #[must_use]
    pub fn help_if(self, text: Option<impl AsRef<str>>) -> Self {
        match text {
            Some(text) => self.help(text),
            None => self,
        }
    }

    /// How serious it is.
    pub fn severity(&self) -> Severity {
        self.severity
    }

    /// The sentence that says what is wrong.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The marked places, the main one first. None if the diagnostic concerns the whole file.
    pub fn labels(&self) -> &[Label] {
        &self.labels
    }

    /// The hints.
    pub fn hints(&self) -> &[String] {
        &self.hints
    }

    /// The main place.
    pub fn span(&self) -> Option<SourceSpan> {
        self.labels.first().map(|label| label.span)
    }
}

/// A message without severities at its start, such as `Error: `.
fn without_severity(message: &str) -> &str {
    let mut rest = message.trim_start();
    while let Some((word, behind)) = rest.split_once(':')
        && ["error", "warning"].contains(&word.to_ascii_lowercase().as_str())
    {
        rest = behind.trim_start();
    }
    rest
}

/// The diagnostics of one text, in the order in which they were found until [`sort`](Diagnostics::sort) is called.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
}

impl Diagnostics {
    /// An empty list.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a diagnostic, unless an equal one is in the list, or [`MOST`] of its severity are: more would not help.
    /// After the last error a note says that there are more.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let severity = diagnostic.severity;
        let alike = self.list.iter().filter(|other| other.severity == severity).count();
        if alike < MOST {
            if !self.list.contains(&diagnostic) {
                self.list.push(diagnostic);
            }
        } else if alike == MOST && severity == Severity::Error {
            let mut last = Diagnostic::error("there are more errors than are shown");
            if let Some(span) = diagnostic.span() {
                last = last.at(span, "from here on");
            }
            self.list.push(last);
        }
    }

    /// Removes those whose main place is within a span.
    pub fn remove_within(&mut self, span: SourceSpan) {
        let within = |place: SourceSpan| span.start <= place.start && place.end <= span.end;
        self.list.retain(|diagnostic| !diagnostic.span().is_some_and(within));
    }

    /// Adds a hint to the one that was added last.
    pub fn help_last(&mut self, hint: impl AsRef<str>) {
        if let Some(last) = self.list.last_mut() {
            last.hints.push(one_line(hint.as_ref()));
        }
    }

    /// Adds all of `others`.
    pub fn extend(&mut self, others: Diagnostics) {
        others.list.into_iter().for_each(|diagnostic| self.push(diagnostic));
    }

    /// Whether there is an error among them.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Diagnostic> {
        self.list.iter()
    }

    /// Puts them in the order of their places in the text; those without a place come first.
    pub fn sort(&mut self) {
        self.list.sort_by_key(|diagnostic| diagnostic.span());
    }
}

impl IntoIterator for Diagnostics {
    type Item = Diagnostic;
    type IntoIter = std::vec::IntoIter<Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.into_iter()
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self { list: vec![diagnostic] }
    }
}

/// The candidate that most resembles `name`, if one does: for "did you mean".
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = name.chars().take(LONGEST_MISSPELT + 1).count();
    if length > LONGEST_MISSPELT {
        return None;
    }
    let lower_case = name.to_lowercase();
    candidates
        .into_iter()
        .filter(|candidate| *candidate != name)
        .filter_map(|candidate| {
            let longest = candidate.chars().take(2 * LONGEST_MISSPELT).count().max(length);
            // One slip in three or four letters, two in five to seven.
            let limit = (longest + 1) / 3;
            // A name that is much longer is not near, and comparing the two would take long.
            if longest > length + limit {
                return None;
            }
            // A wrong case is the most likely mistake.
            if lower_case == candidate.to_lowercase() {
                return Some((0, candidate));
            }
            let distance = strsim::damerau_levenshtein(name, candidate);
            // Any two names of two letters are "near": for them only a wrong case counts.
            (longest > 2 && distance <= limit).then_some((distance, candidate))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_prefers_case_slips_and_refuses_strangers() {
        assert_eq!(nearest("cd", ["kd", "Cd", "kr"]), Some("Cd"));
        assert_eq!(nearest("sqr", ["sin", "sqrt", "cos"]), Some("sqrt"));
        assert_eq!(nearest("roughness", ["kd", "Cd", "normalize"]), None);
        assert_eq!(nearest("kd", ["Cd", "ka"]), None);
        assert_eq!(nearest("any", ["tanh"]), None);
    }

    #[test]
    fn nearest_does_not_compare_very_long_names() {
        let long = "x".repeat(1 << 22);
        assert_eq!(nearest(&long, [long.replacen('x', "y", 1).as_str()]), None);
        assert_eq!(nearest("xxxy", [long.as_str(), "xxxx"]), Some("xxxx"));
    }

    #[test]
    fn texts_are_safe_and_short() {
        let name = format!("\u{1b}[31m{}\n", "x".repeat(1 << 20));
        let diagnostic = Diagnostic::error(&name).at(SourceSpan::new(0, 1), &name).help(&name);
        for text in [diagnostic.message(), &diagnostic.labels()[0].text, &diagnostic.hints()[0]] {
            assert!(text.starts_with("\\u{1b}[31mxxx") && text.len() < 200, "{text}");
        }
        let many = (0..1000).fold(Diagnostic::error("x"), |all, at| all.at(SourceSpan::new(at, at), ""));
        assert_eq!(many.labels().len(), MOST_LABELS);
    }

    #[test]
    fn a_message_does_not_repeat_its_severity() {
        for message in ["Error: error: no more", "no more", " warning:no more"] {
            assert_eq!(Diagnostic::error(message).message(), "no more");
            assert_eq!(Diagnostic::warning(message).message(), "no more");
        }
        assert_eq!(Diagnostic::error("errors: 5").message(), "errors: 5");
    }

    #[test]
    fn the_same_diagnostic_is_kept_once() {
        let mut diagnostics = Diagnostics::new();
        diagnostics.push(Diagnostic::error("x").at(SourceSpan::new(0, 1), ""));
        diagnostics.push(Diagnostic::error("x").at(SourceSpan::new(0, 1), ""));
        assert_eq!(diagnostics.len(), 1);
    }
}
