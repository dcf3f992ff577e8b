//! Parses the words of a formula file into syntax, by recursive descent (thesis 9.1).
//!
//! After an error the parser goes on with the next statement, so that one run reports all independent mistakes. Names
//! and types are not checked here.

use crate::lang::ast::{Constant, Declaration, FormulaFile, InvariantLine, MacroLine, Relation, Section};
use crate::lang::ast::{Expr, ExprId, ExprKind};
use crate::lang::comments::doc;
use crate::lang::cursor::{Cursor, Placed, Reported};
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::keywords;
use crate::lang::source::{Source, SourceSpan};
use crate::lang::token::{Mark, TokenKind};
use crate::lang::types::Type;
use crate::lang::variables::Owner;

/// Parses a formula file. The syntax is as complete as the text allows; it may be used only if there are no errors.
pub fn parse(source: &Source) -> (FormulaFile, Diagnostics) {
    let mut parser = FormulaParser { source, cursor: Cursor::new(source), file: FormulaFile::default() };
    parser.file();
    (parser.file, parser.cursor.into_diagnostics())
}

pub(super) struct FormulaParser<'s> {
    source: &'s Source,
    pub(super) cursor: Cursor,
    pub(super) file: FormulaFile,
}

const SECTIONS: [&str; 5] = keywords::words(&keywords::FORMULA_SECTIONS);
const ATTRIBUTES: [&str; 4] = keywords::words(&keywords::PARAMETER_ATTRIBUTES);

/// What follows a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
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
                let _ = self.cursor.expect(Mark::Semicolon, "after `formula`");
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
    fn section(&mut self, seen: &mut Vec<(String, SourceSpan)>) -> Next {
        let head = self.cursor.span();
        if let TokenKind::Uses(..) = self.cursor.kind(0) {
            self.cursor.advance();
            self.cursor
                .report(Diagnostic::error("`#uses` must be the first line of the file").at(head, "move this line to the top"));
            return Next::Section;
        }
        let word = self.cursor.word(0).map(str::to_owned);
        match word.as_deref() {
            Some(word @ ("global" | "body_specific" | "light_specific" | "invariants")) => {
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
                let _ = self.cursor.expect(Mark::Semicolon, &format!("after `{word}`"));
                match Owner::ALL.into_iter().find(|owner| owner.section() == word) {
                    Some(owner) => self.declarations(owner),
                    None => self.invariants(),
                }
                Next::Section
            }
            Some("bodies" | "lights" | "camera") if self.cursor.sees_mark(1, Mark::Semicolon) => {
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
        // A misspelt head of a section is read as the most similar one.
        let near = word.and_then(|word| nearest(&word.replace('-', "_"), SECTIONS));
        let ends = self.cursor.sees_mark(1, Mark::Semicolon) || self.cursor.sees_mark(1, Mark::Colon);
        if let Some(near) = near.filter(|_| ends && self.cursor.peek(1).span.start == head.end) {
            let diagnostic = self.cursor.unexpected("a section");
            self.cursor.report(diagnostic.help(format!("did you mean `{near};`?")));
            self.cursor.rename(near);
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

    /// The text under a span, for messages.
    pub(super) fn source_text(&self, span: SourceSpan) -> String {
        self.source.slice(span).to_owned()
    }

    fn declarations(&mut self, owner: Owner) {
        let mut list = Vec::new();
        while self.cursor.word(0).is_some() && !self.cursor.sees_section() {
            if self.cursor.word(0) == Some("formula") {
                break;
            }
            if let Err(Reported) = self.declaration(owner, &mut list) {
                self.cursor.skip_statement();
            }
        }
        self.file.sections.push(Section::Parameters(owner, list));
    }

    /// Parses a declaration. One with a mistake in its attributes is kept, so that uses of the parameter are not
    /// reported too.
    fn declaration(&mut self, owner: Owner, list: &mut Vec<Declaration>) -> Result<(), Reported> {
        let name = self.cursor.name("the name of a parameter")?;
        if self.cursor.sees_mark(0, Mark::Equal) {
            let diagnostic = self
                .cursor
                .unexpected("`:` and a type")
                .help("macros (`NAME = expression;`) belong under `formula;`; parameters are declared `name: scalar;`");
            return Err(self.cursor.report(diagnostic));
        }
        self.cursor.expect(Mark::Colon, "between the parameter's name and its type")?;
        let ty = match self.cursor.word(0) {
            Some("scalar") => Type::Scalar,
            Some("vector") => Type::Vector,
            _ => return Err(self.cursor.unknown_word("`scalar` or `vector`", &keywords::words(&keywords::TYPES))),
        };
        self.cursor.advance();
        let mut declaration = Declaration { name, owner, ty, range: None, default: None, slider: false, colour: None, doc: None };
        let outcome = self.attributes(&mut declaration);
        declaration.doc = self.doc(declaration.name.span);
        list.push(declaration);
        outcome
    }

    fn attributes(&mut self, declaration: &mut Declaration) -> Result<(), Reported> {
        let mut seen: Vec<(String, SourceSpan)> = Vec::new();
        while self.cursor.accept(Mark::Comma) {
            let span = self.cursor.span();
            let word = self.cursor.word(0).unwrap_or_default().to_owned();
            if let Some((_, first)) = seen.iter().find(|(attribute, _)| *attribute == word) {
                self.cursor.report(
                    Diagnostic::error(format!("`{word}` is given twice"))
                        .at(span, "a second time here")
                        .at(*first, "first here")
                        .help("remove one of them"),
                );
            }
            seen.push((word.clone(), span));
            self.attribute(&word, span, declaration)?;
        }
        if self.cursor.word(0).is_some_and(|word| ATTRIBUTES.contains(&word)) {
            return Err(self.cursor.expected("`,` before the next attribute"));
        }
        let outcome = self.cursor.expect(Mark::Semicolon, &format!("after the declaration of `{}`", declaration.name.text));
        // If only the `;` is missing, the next declaration is complete.
        if self.cursor.word(0).is_some() && self.cursor.sees_mark(1, Mark::Colon) { Ok(()) } else { outcome }
    }

    fn attribute(&mut self, word: &str, span: SourceSpan, declaration: &mut Declaration) -> Result<(), Reported> {
        if !ATTRIBUTES.contains(&word) {
            return Err(self.cursor.unknown_word("an attribute: `constraint`, `default`, `slider` or `color`", &ATTRIBUTES));
        }
        self.cursor.advance();
        match word {
            "constraint" => {
                let low = self.single("the lower bound, as in `constraint 0..1`")?;
                self.cursor.expect(Mark::DotDot, "between the bounds, as in `constraint 0..1`")?;
                let high = self.single("the upper bound, as in `constraint 0..1`")?;
                declaration.range = Some(([low, high], span.to(self.cursor.previous_span())));
            }
            "default" => {
                let value = if self.cursor.sees_mark(0, Mark::Less) {
                    let [x, y, z] = self.cursor.vector("the default value")?.value;
                    Constant::Vector([self.narrow(x)?, self.narrow(y)?, self.narrow(z)?])
                } else {
                    Constant::Scalar(self.single("the default value, a number or a vector `<x, y, z>`")?)
                };
                declaration.default = Some((value, span.to(self.cursor.previous_span())));
            }
            "slider" => declaration.slider = true,
            _ => declaration.colour = Some(span),
        }
        Ok(())
    }

    fn single(&mut self, what: &str) -> Result<f32, Reported> {
        let number = self.cursor.number(what)?;
        self.narrow(number)
    }

    /// A number as the language uses it; one that is too large is reported.
    pub(super) fn narrow(&mut self, number: Placed<f64>) -> Result<f32, Reported> {
        let narrow = number.value as f32;
        if narrow.is_infinite() {
            let diagnostic = Diagnostic::error("this number is too large")
                .at(number.span, "larger than the largest number")
                .help(format!("numbers go up to about {:e}", f32::MAX));
            return Err(self.cursor.report(diagnostic));
        }
        Ok(narrow)
    }

    fn invariants(&mut self) {
        let mut lines = Vec::new();
        while self.cursor.word(0).is_some() && !self.cursor.sees_section() && self.cursor.word(0) != Some("formula") {
            match self.invariant() {
                Ok(line) => lines.push(line),
                Err(Reported) => self.cursor.skip_statement(),
            }
        }
        self.file.sections.push(Section::Invariants(lines));
    }

    fn invariant(&mut self) -> Result<InvariantLine, Reported> {
        const FORM: &str = "invariants are sums like `ks + kd = 1;` or `ks + kd <= 1;`";
        let start = self.cursor.span();
        let mut terms = vec![self.cursor.name("the name of a parameter")?];
        while self.cursor.accept(Mark::Plus) {
            terms.push(self.cursor.name("the name of a parameter")?);
        }
        let relation = if self.cursor.accept(Mark::Equal) {
            Relation::Equal
        } else if self.cursor.accept(Mark::LessEqual) {
            Relation::AtMost
        } else {
            let diagnostic = self.cursor.unexpected("`+`, `= 1` or `<= 1`").help(FORM);
            return Err(self.cursor.report(diagnostic));
        };
        if *self.cursor.kind(0) != TokenKind::Number(1.0) {
            let diagnostic = self.cursor.unexpected("`1`").help(FORM);
            return Err(self.cursor.report(diagnostic));
        }
        self.cursor.advance();
        let span = start.to(self.cursor.previous_span());
        self.cursor.expect(Mark::Semicolon, "after the invariant")?;
        Ok(InvariantLine { terms, relation, span })
    }

    fn formula(&mut self) {
        // The name of the last macro if it is alone in its line, before a line that begins with `=`.
        let mut stray = None;
        let mut failed = false;
        while !self.cursor.at_end() {
            if self.cursor.accept(Mark::Equal) {
                match self.expression_statement() {
                    Ok(result) => self.file.result = Some(result),
                    Err(Reported) => {
                        self.file.result = Some(self.missing());
                        self.cursor.skip_statement();
                    }
                }
                if !self.cursor.at_end() {
                    let span = self.cursor.span();
                    self.cursor.report(
                        Diagnostic::error("nothing may follow the formula's last line `= …;`")
                            .at(span, "this is too much")
                            .help("put macros before the last line, and sections before `formula;`"),
                    );
                }
                return;
            }
            let is_stray = self.cursor.sees_mark(1, Mark::Equal) && self.cursor.peek(1).begins_line;
            stray = is_stray.then(|| self.cursor.span());
            if let Err(Reported) = self.macro_line() {
                failed = true;
                self.cursor.skip_statement();
                if self.cursor.sees_section() {
                    self.cursor.expected("the formula's last line, `= expression;`");
                    return;
                }
            }
        }
        if failed {
            // What was skipped may have been the result.
            self.file.result = Some(self.missing());
            return;
        }
        let error = Diagnostic::error("the formula has no result");
        let error = match stray {
            Some(name) => error.at(name, "this makes the line below a macro").help("remove it if that line is the result"),
            None => error.at(self.cursor.previous_span(), "the file ends here"),
        };
        self.cursor.report(error.help("the last line must be `= expression;`, the colour that the formula gives"));
    }

    fn macro_line(&mut self) -> Result<(), Reported> {
        if self.cursor.word(0) == Some("formula") && self.cursor.sees_mark(1, Mark::Semicolon) {
            let diagnostic =
                Diagnostic::error("a second section `formula`").at(self.cursor.span(), "each section may be there only once");
            self.cursor.report(diagnostic.help("remove this line"));
            self.cursor.advance();
            self.cursor.advance();
            return Ok(());
        }
        if self.cursor.sees_mark(1, Mark::Colon) && self.cursor.sees_mark(2, Mark::Equal) {
            let name = self.cursor.name("`NAME = expression;`")?;
            let diagnostic =
                Diagnostic::error("a macro is written `NAME = expression;`").at(self.cursor.span(), "without the `:`");
            self.cursor.report(diagnostic);
            self.cursor.advance();
            self.cursor.advance();
            let body = self.expression_statement();
            let body = body.unwrap_or_else(|Reported| self.missing());
            let doc = self.doc(name.span);
            self.file.macros.push(MacroLine { name, body, doc });
            return Ok(());
        }
        if self.cursor.sees_mark(1, Mark::Colon) {
            let diagnostic = Diagnostic::error("a declaration under `formula;`")
                .at(self.cursor.span(), "expected `NAME = expression;`")
                .help("declare parameters before it, under `global;`, `body_specific;` or `light_specific;`");
            return Err(self.cursor.report(diagnostic));
        }
        let name = self.cursor.name("`NAME = expression;` or the last line `= expression;`")?;
        let body = self.cursor.expect(Mark::Equal, "after the macro's name").and_then(|()| self.expression_statement());
        // A macro with an error keeps its name, so that uses of it are not reported too.
        let (body, outcome) = match body {
            Ok(body) => (body, Ok(())),
            Err(Reported) => (self.missing(), Err(Reported)),
        };
        let doc = self.doc(name.span);
        self.file.macros.push(MacroLine { name, body, doc });
        outcome
    }

    fn expression_statement(&mut self) -> Result<ExprId, Reported> {
        let expression = self.expression()?;
        let outcome = self.expect_expression_end(Mark::Semicolon, "at the end of the expression");
        // If only the `;` is missing, the expression and the next statement are complete.
        let begins = self.cursor.word(0).is_some() && self.cursor.sees_mark(1, Mark::Equal)
            || self.cursor.sees_mark(0, Mark::Equal) && self.cursor.peek(0).begins_line;
        let next_begins = self.cursor.at_end() || begins;
        if outcome.is_err() && !next_begins {
            return Err(Reported);
        }
        Ok(expression)
    }

    /// What the comments at the statement say that begins with this name and has just been read.
    fn doc(&self, name: SourceSpan) -> Option<String> {
        doc(self.source.text(), self.cursor.comments(), name.to(self.cursor.previous_span()))
    }

    fn missing(&mut self) -> ExprId {
        let span = self.cursor.previous_span();
        self.add(ExprKind::Missing, span)
    }

    pub(super) fn add(&mut self, kind: ExprKind, span: SourceSpan) -> ExprId {
        // There are fewer expressions than bytes of text, and a text has fewer than 2³² bytes.
        let id = ExprId(self.file.expressions.len() as u32);
        self.file.expressions.push(Expr { kind, span, parenthesised: false });
        id
    }
}
