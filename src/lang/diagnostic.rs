//! What is told to the user about a text: errors and warnings with places, and their rendering with the marked source.
//!
//! A [`Diagnostic`] says what is wrong, where, what was expected and what the likely mend is. Parsers and checkers collect as
//! many as they can find in [`Diagnostics`]; how they reach a terminal or a window is not decided here.

use crate::lang::source::{Source, Span};

/// How many errors, and how many warnings, are told of one text.
pub const MOST: usize = 100;

/// How grave a diagnostic is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The text is taken as it is, but probably not meant so.
    Warning,
    /// The text cannot be taken.
    Error,
}

/// A marked place and what is to be said of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// What is said under the mark; may be empty.
    pub text: String,
}

/// One error or warning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    severity: Severity,
    message: String,
    labels: Vec<Label>,
    help: Vec<String>,
}

impl Diagnostic {
    /// An error; the message is one sentence without a full stop.
    pub fn error(message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, message: message.into(), labels: Vec::new(), help: Vec::new() }
    }

    /// A warning; the message is one sentence without a full stop.
    pub fn warning(message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message) }
    }

    /// Marks a place. The first place marked is where the diagnostic is said to be.
    #[must_use]
    pub fn at(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Adds a hint: what was expected, or the likely mend.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help.push(text.into());
        self
    }

    /// Adds a hint that there may be.
    #[must_use]
    pub fn help_if(self, text: Option<impl Into<String>>) -> Self {
        match text {
            Some(text) => self.help(text),
            None => self,
        }
    }

    /// How grave it is.
    pub fn severity(&self) -> Severity {
        self.severity
    }

    /// The one sentence that says what is wrong.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The marked places, the main one first. None where the whole file is meant.
    pub fn labels(&self) -> &[Label] {
        &self.labels
    }

    /// The hints.
    pub fn hints(&self) -> &[String] {
        &self.help
    }

    /// Where the main mark begins.
    pub fn span(&self) -> Option<Span> {
        self.labels.first().map(|label| label.span)
    }

    /// The diagnostic as plain or coloured text, with file, line, column, the source lines and marks under the spans.
    pub fn render(&self, source: &Source, colour: bool) -> String {
        crate::lang::render::render(self, source, colour)
    }
}

/// The diagnostics of one text, in the order of their places when asked for.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
}

impl Diagnostics {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one, unless the very same is there already, or so many of its severity that one more helps nobody: who has made more
    /// slips than that has given the wrong file.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let severity = diagnostic.severity;
        let alike = self.list.iter().filter(|other| other.severity == severity).count();
        if alike < MOST {
            if !self.list.contains(&diagnostic) {
                self.list.push(diagnostic);
            }
        } else if alike == MOST && severity == Severity::Error {
            let mut last = Diagnostic::error("there are more errors than are shown");
            last.labels.extend(diagnostic.span().map(|span| Label { span, text: "from here on".to_owned() }));
            self.list.push(last);
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

    /// Whether there is none at all.
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

    /// All of them as text, one after the other.
    pub fn render(&self, source: &Source, colour: bool) -> String {
        self.list.iter().map(|diagnostic| diagnostic.render(source, colour)).collect::<Vec<_>>().join("\n")
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

/// The candidate that is most like `name`, if one is like it at all: for "did you mean".
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .filter(|candidate| *candidate != name)
        .map(|candidate| {
            let distance = strsim::damerau_levenshtein(name, candidate);
            // A wrong case is the likeliest slip of all: count it as next to nothing.
            let caseless = strsim::damerau_levenshtein(&name.to_lowercase(), &candidate.to_lowercase());
            (if caseless == 0 { 0 } else { distance }, candidate)
        })
        .filter(|(distance, candidate)| {
            let longest = candidate.chars().count().max(name.chars().count());
            // Of names of two letters every other is "near": only a wrong case counts.
            *distance == 0 || (longest > 2 && *distance <= longest.div_ceil(3))
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
    }

    #[test]
    fn the_same_diagnostic_is_kept_once() {
        let mut diagnostics = Diagnostics::new();
        diagnostics.push(Diagnostic::error("x").at(Span::new(0, 1), ""));
        diagnostics.push(Diagnostic::error("x").at(Span::new(0, 1), ""));
        assert_eq!(diagnostics.len(), 1);
    }
}
