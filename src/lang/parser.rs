//! Parses the words of a formula file into syntax, by recursive descent (thesis 9.1). Here are the file and its
//! sections; `parse_parameters`, `parse_formula` and `parse_expression` have what stands in them, and `parse_foreign`
//! what stands there in the form of another language.
//!
//! After an error the parser goes on with the next statement, so that one run reports all independent mistakes. Names
//! and types are not checked here.

use crate::lang::ast::{Declaration, Expr, ExprId, ExprKind, FormulaFile, Name, ParameterAttributes, Section};
use crate::lang::comments::doc;
use crate::lang::cursor::Cursor;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::foreign;
use crate::lang::keywords;
use crate::lang::source::{Source, SourceSpan};
use crate::lang::token::{Mark, TokenKind};
use crate::lang::types::Type;
use crate::lang::variables::{Owner, PREDEFINED_SECTION};

/// Parses a formula file. The syntax is as complete as the text allows; it may be used only if there are no errors.
pub fn parse(source: &Source) -> (FormulaFile, Diagnostics) {
    let mut parser = FormulaParser { source, cursor: Cursor::new(source), file: FormulaFile::default(), foreign_seen: false };
    parser.file();
    (parser.file, parser.cursor.into_diagnostics())
}

pub(super) struct FormulaParser<'s> {
    source: &'s Source,
    pub(super) cursor: Cursor,
    pub(super) file: FormulaFile,
    /// Whether a statement of another language has been reported.
    pub(super) foreign_seen: bool,
}

pub(super) const SECTIONS: [&str; 6] = keywords::words(&keywords::FORMULA_SECTIONS);

/// What follows a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Next {
    /// Another section, or the head of the formula.
    Section,
    /// Macros and the result, whose head is missing. That has been reported.
    FormulaWithoutHead,
    /// Nothing that can be parsed. That has been reported.
    Nothing,
}

impl FormulaParser<'_> {
    fn file(&mut self) {
        self.uses();
        let mut seen = Vec::new();
        let mut next = Next::Section;
        while next == Next::Section && self.cursor.word(0) != Some("formula") && !self.cursor.at_end() {
            next = self.section(&mut seen);
        }
        match next {
            Next::Section if self.cursor.accept_word("formula") => {
                self.head_end("formula");
                self.formula();
            }
            Next::Section => {
                self.cursor.report(
                    Diagnostic::error("the file has no formula")
                        .at(self.cursor.span(), "expected `formula;` before the end")
                        .help("end the file with `formula;` and `= expression;`"),
                );
            }
            Next::FormulaWithoutHead => self.formula(),
            Next::Nothing => {}
        }
    }

    /// Parses `#uses` at the beginning of the file.
    fn uses(&mut self) {
        let TokenKind::Uses(path, span) = self.cursor.kind(0) else { return };
        let (path, span) = (path.clone(), *span);
        let whole = self.cursor.advance().span;
        if path.is_empty() {
            self.cursor.report(
                Diagnostic::error("`#uses` names no file")
                    .at(whole, "expected a path after it")
                    .help("write `#uses FILE;`, or remove the line if the formula needs no materials"),
            );
        } else {
            self.file.uses = Some((path, span));
        }
    }

    /// Parses a section before the formula, or reports what is in its place. `seen` has the sections before, with their
    /// heads.
    pub(super) fn section(&mut self, seen: &mut Vec<(String, SourceSpan)>) -> Next {
        let head = self.cursor.span();
        if let TokenKind::Uses(..) = self.cursor.kind(0) {
            self.cursor.advance();
            self.cursor.report(Diagnostic::error("`#uses` must come before all sections").at(head, "move this line up"));
            return Next::Section;
        }
        let word = self.cursor.word(0).map(str::to_owned);
        match word.as_deref() {
            Some(word) if SECTIONS.contains(&word) && (!self.cursor.sees_mark(1, Mark::Colon) || self.sees_head()) => {
                self.cursor.advance();
                if let Some((_, first)) = seen.iter().find(|(name, _)| name == word) {
                    self.cursor.report(
                        Diagnostic::error(format!("a second section `{word}`"))
                            .at(head, "each section may be there only once")
                            .at(*first, "the first is here")
                            .help("move its lines into the first one"),
                    );
                }
                seen.push((word.to_owned(), head));
                self.head_end(word);
                match Owner::ALL.into_iter().find(|owner| owner.section() == word) {
                    Some(owner) => self.declarations(owner),
                    None if word == PREDEFINED_SECTION => self.predefined(),
                    None => self.invariants(),
                }
                Next::Section
            }
            Some("bodies" | "lights" | "camera") if self.cursor.sees_mark(1, Mark::Semicolon) && !self.has_formula() => {
                self.cursor.report(
                    Diagnostic::error("this looks like a scene, not a formula")
                        .at(head, "a section of scene files")
                        .help("give formula and scene the other way round, or check the name of the file"),
                );
                Next::Nothing
            }
            word => self.misplaced(head, word),
        }
    }

    /// Reports a word where a section was expected.
    fn misplaced(&mut self, head: SourceSpan, word: Option<&str>) -> Next {
        if let Some((near, words)) = self.head_in_parts() {
            let span = head.to(self.cursor.peek(words - 1).span);
            let written = self.source_text(span);
            let diagnostic = Diagnostic::error(format!("`{written}` is not a section")).at(span, "expected a section");
            self.cursor.report(diagnostic.help(format!("did you mean `{near};`?")));
            for _ in 1..words {
                self.cursor.advance();
            }
            self.cursor.rename(near);
            return Next::Section;
        }
        // A misspelt head of a section is read as the most similar one.
        let known = |word: &str| nearest(word, SECTIONS).or_else(|| foreign::section(word));
        let near = word.filter(|_| self.sees_head()).and_then(known);
        if let Some(near) = near {
            let diagnostic = self.cursor.unexpected("a section");
            self.cursor.report(diagnostic.help(format!("did you mean `{near};`?")));
            self.cursor.rename(near);
            return Next::Section;
        }
        if word.is_some() && self.cursor.sees_mark(1, Mark::Semicolon) {
            let diagnostic = self.cursor.unexpected("a section (`body_specific;`, `formula;`, …)");
            self.cursor.report(
                diagnostic
                    .help("parameters are declared `name: scalar;`; a formula file ends with `formula;` and `= expression;`"),
            );
            // It may be a parameter, and so is what follows, so that uses of them are not reported too.
            if let Some(text) = word.map(str::to_owned) {
                let name = Name { text, span: head };
                let attributes = ParameterAttributes::default();
                let declaration = Declaration { name, owner: Owner::Body, ty: Type::Scalar, attributes, doc: None };
                self.file.sections.push(Section::Parameters(Owner::Body, vec![declaration]));
            }
            // It may be the head of a section of scenes; skipping would stop at it.
            self.cursor.advance();
            self.cursor.skip_statement();
            self.declarations(Owner::Body);
            return Next::Section;
        }
        if let (TokenKind::Number(_), TokenKind::Word(_)) = (self.cursor.kind(0), self.cursor.kind(1)) {
            let diagnostic = self.cursor.unexpected("a name").help("names begin with a letter or `_`");
            self.cursor.report(diagnostic);
            self.cursor.skip_statement();
            self.declarations(Owner::Body);
            return Next::Section;
        }
        if matches!(word, Some("uses" | "use" | "include" | "import" | "materials")) && self.cursor.word(1).is_some() {
            let diagnostic = self.cursor.unexpected("a section").help("a library of materials is named by `#uses FILE;`");
            self.cursor.report(diagnostic);
            self.cursor.skip_statement();
            return Next::Section;
        }
        if word.is_none() && self.cursor.sees_mark(0, Mark::Equal) || self.cursor.sees_mark(1, Mark::Equal) {
            let diagnostic = Diagnostic::error("an expression before `formula;`").at(head, "expected `formula;` before this");
            self.cursor.report(diagnostic.help("macros and the last line `= …;` belong under `formula;`"));
            return Next::FormulaWithoutHead;
        }
        if !self.cursor.sees_mark(1, Mark::Colon) {
            let diagnostic = self.cursor.unexpected("a section (`body_specific;`, `formula;`, …)");
            self.cursor.report(diagnostic.help("a formula file ends with `formula;` and `= expression;`"));
            return Next::Nothing;
        }
        let diagnostic = Diagnostic::error("a declaration outside a section")
            .at(head, "expected a section first")
            .help("put it under `global;`, `body_specific;` or `light_specific;`");
        self.cursor.report(diagnostic);
        // The word may itself be the head of a section, in the wrong place; skipping would stop at it.
        self.cursor.advance();
        self.cursor.skip_statement();
        Next::Section
    }

    /// The head of a section that is written as several words, `body-specific;` or `body specific;`, and their number.
    fn head_in_parts(&self) -> Option<(&'static str, usize)> {
        let hyphen = usize::from(self.cursor.sees_mark(1, Mark::Minus));
        let (first, second) = (self.cursor.word(0)?, self.cursor.word(1 + hyphen)?);
        let ends = self.cursor.sees_mark(2 + hyphen, Mark::Semicolon) || self.cursor.sees_mark(2 + hyphen, Mark::Colon);
        let joined = format!("{first}_{second}");
        let same = SECTIONS.into_iter().find(|section| joined.eq_ignore_ascii_case(section));
        let known = same.or_else(|| foreign::section(&joined)).or_else(|| nearest(&joined, SECTIONS));
        known.filter(|_| ends).map(|section| (section, 2 + hyphen))
    }

    /// Whether the current word is the head of a section, well or badly spelt: a word before `;`, or before a `:` that
    /// ends a line.
    pub(super) fn sees_head(&self) -> bool {
        let Some(word) = self.cursor.word(0) else { return false };
        let known = || SECTIONS.contains(&word) || nearest(word, SECTIONS).is_some() || foreign::section(word).is_some();
        self.cursor.sees_mark(1, Mark::Semicolon)
            || self.cursor.sees_mark(1, Mark::Colon) && self.cursor.peek(2).begins_line && known()
            || self.head_in_parts().is_some()
    }

    /// Moves past the `;` after the head of a section, or reports what is in its place.
    fn head_end(&mut self, word: &str) {
        let place = self.cursor.span();
        if self.cursor.accept(Mark::Colon) {
            let diagnostic = Diagnostic::error(format!("expected `;` after `{word}`, found `:`")).at(place, "expected `;`");
            self.cursor.report(diagnostic.help(format!("write `{word};`")));
            self.cursor.accept(Mark::Semicolon);
        } else {
            let _ = self.cursor.expect(Mark::Semicolon, &format!("after `{word}`"));
        }
    }

    /// Whether the head of the formula stands somewhere ahead.
    fn has_formula(&self) -> bool {
        let mut ahead = 0;
        while *self.cursor.kind(ahead) != TokenKind::End {
            if self.cursor.word(ahead) == Some("formula") {
                return true;
            }
            ahead += 1;
        }
        false
    }

    /// Whether nothing comes before a span in its line, not even blanks.
    pub(super) fn begins_source_line(&self, span: SourceSpan) -> bool {
        let before = &self.source.text()[..span.start as usize];
        before.is_empty() || before.ends_with(['\n', '\r'])
    }

    /// The text under a span, for messages.
    pub(super) fn source_text(&self, span: SourceSpan) -> String {
        self.source.slice(span).to_owned()
    }

    /// What the comments at the statement say that begins with this name and has just been read.
    pub(super) fn doc(&self, name: SourceSpan) -> Option<String> {
        doc(self.source.text(), self.cursor.comments(), name.to(self.cursor.previous_span()))
    }

    pub(super) fn missing(&mut self) -> ExprId {
        let span = self.cursor.previous_span();
        self.add(ExprKind::Missing, span)
    }

    pub(super) fn add(&mut self, kind: ExprKind, span: SourceSpan) -> ExprId {
        // There are fewer expressions than bytes of text, and a text has fewer than 2³² bytes.
        let id = ExprId(self.file.expressions.len() as u32);
        self.file.expressions.push(Expr { kind, span, outer: span });
        id
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Statements and fragments that begin, end or break sections.
    const PIECES: [&str; 16] = [
        "formula;",
        "global;",
        "body_specific;",
        "invariants;",
        "predefined;",
        "bodies;",
        "camera;",
        "formul;",
        "body specific;",
        "= Cd;",
        "X = 1;",
        "a: scalar;",
        "b",
        "#uses m.materials;",
        "vec3 f(",
        "1 2",
    ];

    /// The cursor fails the test when a parser does not go on.
    #[test]
    fn every_order_of_sections_is_read_to_an_end() {
        for first in PIECES {
            for second in PIECES {
                for third in PIECES {
                    for fourth in PIECES {
                        let text = [first, second, third, fourth].join("\n");
                        let (file, diagnostics) = parse(&Source::new("order", &text));
                        assert!(file.result.is_some() || diagnostics.has_errors(), "{text}");
                    }
                }
            }
        }
    }
}
