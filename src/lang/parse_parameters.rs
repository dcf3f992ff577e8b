//! Parses the sections before the formula: declarations with their attributes, lines about predefined parameters, and
//! invariants.

use crate::lang::ast::{Constant, Declaration, InvariantLine, Name, ParameterAttributes, PredefinedLine, Relation, Section};
use crate::lang::cursor::{Placed, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::foreign;
use crate::lang::keywords;
use crate::lang::parser::FormulaParser;
use crate::lang::source::SourceSpan;
use crate::lang::token::{Mark, TokenKind};
use crate::lang::types::Type;
use crate::lang::variables::Owner;

const ATTRIBUTES: [&str; 6] = keywords::words(&keywords::PARAMETER_ATTRIBUTES);

impl FormulaParser<'_> {
    /// Whether the current word may begin a line of a section.
    fn sees_line(&self) -> bool {
        self.cursor.word(0).is_some_and(|word| word != "formula") && !self.cursor.sees_section()
    }

    pub(super) fn declarations(&mut self, owner: Owner) {
        let mut list = Vec::new();
        while self.sees_line() {
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
        let ty = self.declared_type()?;
        let mut attributes = ParameterAttributes::default();
        let outcome = self.attributes(&name, &mut attributes);
        let doc = self.doc(name.span);
        list.push(Declaration { name, owner, ty, attributes, doc });
        outcome
    }

    /// Parses the type of a parameter. A type of another language is reported and read as ours.
    fn declared_type(&mut self) -> Result<Type, Reported> {
        let ty = match self.cursor.word(0) {
            Some("scalar") => Type::Scalar,
            Some("vector") => Type::Vector,
            other => {
                let Some((ty, ours)) = other.and_then(foreign::ty) else {
                    return Err(self.cursor.unknown_word("`scalar` or `vector`", &keywords::words(&keywords::TYPES)));
                };
                let diagnostic = self.cursor.unexpected("`scalar` or `vector`").help(format!("write `{ours}`"));
                self.cursor.report(diagnostic);
                ty
            }
        };
        self.cursor.advance();
        Ok(ty)
    }

    /// Parses the lines of the section `predefined`.
    pub(super) fn predefined(&mut self) {
        let mut list = Vec::new();
        while self.sees_line() {
            if let Err(Reported) = self.predefined_line(&mut list) {
                self.cursor.skip_statement();
            }
        }
        self.file.sections.push(Section::Predefined(list));
    }

    fn predefined_line(&mut self, list: &mut Vec<PredefinedLine>) -> Result<(), Reported> {
        let name = self.cursor.name("the name of a predefined parameter")?;
        self.cursor.expect(Mark::Colon, "between the parameter's name and its attributes")?;
        if let Some("scalar" | "vector") = self.cursor.word(0) {
            let diagnostic = Diagnostic::error("the type of a predefined parameter stays as it is")
                .at(self.cursor.span(), "expected an attribute")
                .help(format!("leave the type out: `{}: constraint 0..1, default 0.5;`", name.text));
            self.cursor.report(diagnostic);
            self.cursor.advance();
            self.cursor.accept(Mark::Comma);
        }
        let mut attributes = ParameterAttributes::default();
        let mut seen = Vec::new();
        let outcome = self.counted_attribute(&mut seen, &mut attributes);
        let outcome = outcome.and_then(|()| self.more_attributes(&name, seen, &mut attributes));
        let doc = self.doc(name.span);
        list.push(PredefinedLine { name, attributes, doc });
        outcome
    }

    fn attributes(&mut self, name: &Name, attributes: &mut ParameterAttributes) -> Result<(), Reported> {
        self.more_attributes(name, Vec::new(), attributes)
    }

    /// Parses the attributes after those in `seen`, each after a comma, and the `;`.
    fn more_attributes(
        &mut self,
        name: &Name,
        mut seen: Vec<(String, SourceSpan)>,
        attributes: &mut ParameterAttributes,
    ) -> Result<(), Reported> {
        while self.cursor.accept(Mark::Comma) {
            self.counted_attribute(&mut seen, attributes)?;
        }
        if self.cursor.word(0).is_some_and(|word| ATTRIBUTES.contains(&word)) {
            return Err(self.cursor.expected("`,` before the next attribute"));
        }
        if self.cursor.sees_mark(0, Mark::Equal) {
            let diagnostic = self.cursor.unexpected("`,` or `;`").help("a default is an attribute: `, default 0.5;`");
            return Err(self.cursor.report(diagnostic));
        }
        let outcome = self.cursor.expect(Mark::Semicolon, &format!("after the declaration of `{}`", name.text));
        // If only the `;` is missing, the next declaration is complete.
        if self.cursor.word(0).is_some() && self.cursor.sees_mark(1, Mark::Colon) { Ok(()) } else { outcome }
    }

    /// Parses an attribute, and reports one that is given twice.
    fn counted_attribute(
        &mut self,
        seen: &mut Vec<(String, SourceSpan)>,
        attributes: &mut ParameterAttributes,
    ) -> Result<(), Reported> {
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
        self.attribute(&word, span, attributes)
    }

    fn attribute(&mut self, word: &str, span: SourceSpan, attributes: &mut ParameterAttributes) -> Result<(), Reported> {
        if !ATTRIBUTES.contains(&word) {
            let known = ATTRIBUTES.map(|attribute| format!("`{attribute}`"));
            let (last, others) = known.split_last().map_or((String::new(), String::new()), |(a, b)| (a.clone(), b.join(", ")));
            let hint = foreign::attribute(word);
            let Some(ours) = hint else {
                return Err(self.cursor.unknown_word(&format!("an attribute: {others} or {last}"), &ATTRIBUTES));
            };
            let diagnostic = self.cursor.unexpected(&format!("an attribute: {others} or {last}"));
            return Err(self.cursor.report(diagnostic.help(format!("did you mean `{ours}`?"))));
        }
        self.cursor.advance();
        match word {
            "constraint" => {
                let low = self.single("the lower bound, as in `constraint 0..1`")?;
                self.cursor.expect(Mark::DotDot, "between the bounds, as in `constraint 0..1`")?;
                let high = self.single("the upper bound, as in `constraint 0..1`")?;
                attributes.range = Some(([low, high], span.to(self.cursor.previous_span())));
            }
            "default" => {
                let value = if self.cursor.sees_mark(0, Mark::Less) {
                    let [x, y, z] = self.cursor.vector("the default value")?.value;
                    Constant::Vector([self.narrow(x)?, self.narrow(y)?, self.narrow(z)?])
                } else {
                    Constant::Scalar(self.single("the default value, a number or a vector `<x, y, z>`")?)
                };
                attributes.default = Some((value, span.to(self.cursor.previous_span())));
            }
            "slider" => attributes.slider = Some(span),
            "switch" => attributes.switch = Some(span),
            "choices" => {
                let names = self.choices()?;
                attributes.choices = Some((names, span.to(self.cursor.previous_span())));
            }
            _ => attributes.colour = Some(span),
        }
        Ok(())
    }

    /// Parses the names after `choices`.
    fn choices(&mut self) -> Result<Vec<String>, Reported> {
        let mut names = Vec::new();
        loop {
            let TokenKind::Text(name) = self.cursor.kind(0) else {
                let diagnostic = self.cursor.unexpected("a name in quotation marks, as in `choices \"GGX\", \"Beckmann\"`");
                return Err(self.cursor.report(diagnostic));
            };
            let name = name.trim().to_owned();
            if name.is_empty() || names.contains(&name) {
                let what = if name.is_empty() {
                    "a choice has no name".to_owned()
                } else {
                    format!("the choice \"{name}\" is there twice")
                };
                let diagnostic = Diagnostic::error(what).at(self.cursor.span(), "every choice needs a name of its own");
                self.cursor.report(diagnostic);
            }
            names.push(name);
            self.cursor.advance();
            if !(self.cursor.sees_mark(0, Mark::Comma) && matches!(self.cursor.kind(1), TokenKind::Text(_))) {
                return Ok(names);
            }
            self.cursor.advance();
        }
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

    pub(super) fn invariants(&mut self) {
        let mut lines = Vec::new();
        while self.sees_line() {
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
}
