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
use crate::lang::variables::{Owner, Predefined};

/// The type of a declaration.
enum DeclaredType {
    /// It is there.
    Given(Type),
    /// It is missing; this is the one that fits the attribute in its place.
    LeftOut(Type),
}

/// What stands behind the `:` of a declaration.
const EXPECTED_TYPE: &str = "`scalar`, `vector` or `texture`";

const ATTRIBUTES: [&str; 6] = keywords::words(&keywords::PARAMETER_ATTRIBUTES);

impl FormulaParser<'_> {
    /// Whether the current word may begin a line of a section.
    fn sees_line(&self) -> bool {
        self.cursor.word(0).is_some_and(|word| word != "formula") && !self.sees_head()
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
        if self.type_before_name(owner, list) {
            return Err(Reported);
        }
        let name = self.cursor.name("the name of a parameter")?;
        let others = self.other_names(&name)?;
        if self.cursor.sees_mark(0, Mark::Equal) {
            list.push(self.plain_declaration(name.clone(), owner));
            let diagnostic = self
                .cursor
                .unexpected("`:` and a type")
                .help("macros (`NAME = expression;`) belong under `formula;`; parameters are declared `name: scalar;`");
            return Err(self.cursor.report(diagnostic));
        }
        if ATTRIBUTES.contains(&name.text.as_str()) && !self.cursor.sees_mark(0, Mark::Colon) {
            let diagnostic = Diagnostic::error(format!("`{}` stands outside of a declaration", name.text));
            let help = format!("attributes stand before the `;`: `name: scalar, {} …;`", name.text);
            return Err(self.cursor.report(diagnostic.at(name.span, "an attribute").help(help)));
        }
        let colon = self.cursor.expect(Mark::Colon, "between the parameter's name and its type");
        if colon.is_err() && !matches!(self.cursor.word(0), Some("scalar" | "vector" | "texture")) {
            return Err(Reported);
        }
        let mut attributes = ParameterAttributes::default();
        let ty = self.declared_type(&name);
        if ty.is_err() && Predefined::named(&name.text).is_none() {
            list.push(self.plain_declaration(name.clone(), owner));
        }
        let (ty, outcome) = match ty? {
            DeclaredType::Given(ty) => (ty, self.more_attributes(&name, Some(ty), Vec::new(), &mut attributes)),
            // An attribute stands in its place, which has been reported.
            DeclaredType::LeftOut(ty) => (ty, self.first_and_more_attributes(&name, Some(ty), &mut attributes)),
        };
        let doc = self.doc(name.span);
        let others =
            others.into_iter().map(|name| Declaration { name, owner, ty, attributes: ParameterAttributes::default(), doc: None });
        list.push(Declaration { name, owner, ty, attributes, doc });
        list.extend(others);
        outcome
    }

    /// The declaration of a scalar for one that cannot be read, so that uses of it are not reported too.
    fn plain_declaration(&self, name: Name, owner: Owner) -> Declaration {
        Declaration { name, owner, ty: Type::Scalar, attributes: ParameterAttributes::default(), doc: None }
    }

    /// Parses `, b, c` after the first name of a declaration: other languages declare several at once.
    fn other_names(&mut self, first: &Name) -> Result<Vec<Name>, Reported> {
        let mut names = Vec::new();
        let comma = self.cursor.span();
        while self.cursor.accept(Mark::Comma) {
            names.push(self.cursor.name("the name of a parameter")?);
        }
        if let Some(second) = names.first() {
            let diagnostic = Diagnostic::error("each parameter needs a declaration of its own").at(comma, "expected `:`");
            let help = format!("write `{}: scalar; {}: scalar;`", first.text, second.text);
            self.cursor.report(diagnostic.help(help));
        }
        Ok(names)
    }

    /// Parses the type of a parameter. A type of another language is reported and read as ours.
    fn declared_type(&mut self, name: &Name) -> Result<DeclaredType, Reported> {
        let word = self.cursor.word(0).unwrap_or_default().to_owned();
        let ty = match word.as_str() {
            "scalar" => Type::Scalar,
            "vector" => Type::Vector,
            "texture" => Type::Texture,
            attribute if ATTRIBUTES.contains(&attribute) => {
                if Predefined::named(&name.text).is_some() {
                    let diagnostic = Diagnostic::error(format!("`{}` is a predefined parameter", name.text))
                        .at(name.span, "its type stays, and its attributes do not belong here");
                    return Err(self.cursor.report(diagnostic.help("put this line under `predefined;`")));
                }
                let (ty, ours) = if word == "color" { (Type::Vector, "vector") } else { (Type::Scalar, "scalar") };
                let diagnostic = self.cursor.unexpected(EXPECTED_TYPE);
                self.cursor.report(diagnostic.help(format!("write `{}: {ours}, {word}`", name.text)));
                return Ok(DeclaredType::LeftOut(ty));
            }
            other => {
                let Some((ty, ours)) = foreign::ty(other) else {
                    return Err(self.cursor.unknown_word(EXPECTED_TYPE, &keywords::words(&keywords::TYPES)));
                };
                let diagnostic = self.cursor.unexpected(EXPECTED_TYPE).help(format!("write `{ours}`"));
                if *self.cursor.kind(1) == TokenKind::Unknown {
                    // `enum { A, B }`: the braces belong to the type.
                    let span = self.cursor.span().to(self.cursor.statement_end());
                    self.cursor.report_instead(span, diagnostic);
                } else {
                    self.cursor.report(diagnostic);
                }
                ty
            }
        };
        self.cursor.advance();
        Ok(DeclaredType::Given(ty))
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
        let reports = self.cursor.report_count();
        if let Err(reported) = self.cursor.expect(Mark::Colon, "between the parameter's name and its attributes") {
            self.cursor.help_since(reports, &format!("write `{}: default 0.5;`", name.text));
            return Err(reported);
        }
        if let Some("scalar" | "vector" | "texture") = self.cursor.word(0) {
            let diagnostic = Diagnostic::error("the type of a predefined parameter stays as it is")
                .at(self.cursor.span(), "expected an attribute")
                .help(format!("leave the type out: `{}: constraint 0..1, default 0.5;`", name.text));
            self.cursor.report(diagnostic);
            self.cursor.advance();
            self.cursor.accept(Mark::Comma);
        }
        let mut attributes = ParameterAttributes::default();
        let outcome = self.first_and_more_attributes(&name, None, &mut attributes);
        let doc = self.doc(name.span);
        list.push(PredefinedLine { name, attributes, doc });
        outcome
    }

    /// Parses the attributes, each but the first after a comma, and the `;`. `declared` is the type that the line
    /// gives.
    fn first_and_more_attributes(
        &mut self,
        name: &Name,
        declared: Option<Type>,
        attributes: &mut ParameterAttributes,
    ) -> Result<(), Reported> {
        let mut seen = Vec::new();
        self.counted_attribute(declared, &mut seen, attributes)?;
        self.more_attributes(name, declared, seen, attributes)
    }

    /// Parses the attributes after those in `seen`, each after a comma, and the `;`.
    fn more_attributes(
        &mut self,
        name: &Name,
        declared: Option<Type>,
        mut seen: Vec<(String, SourceSpan)>,
        attributes: &mut ParameterAttributes,
    ) -> Result<(), Reported> {
        while self.cursor.accept(Mark::Comma) {
            self.counted_attribute(declared, &mut seen, attributes)?;
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
        declared: Option<Type>,
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
        self.attribute(&word, span, declared, attributes)
    }

    fn attribute(
        &mut self,
        word: &str,
        span: SourceSpan,
        declared: Option<Type>,
        attributes: &mut ParameterAttributes,
    ) -> Result<(), Reported> {
        if !ATTRIBUTES.contains(&word) {
            let known = ATTRIBUTES.map(|attribute| format!("`{attribute}`"));
            let (last, others) = known.split_last().map_or((String::new(), String::new()), |(a, b)| (a.clone(), b.join(", ")));
            let expected = format!("an attribute: {others} or {last}");
            let number = matches!(self.cursor.kind(0), TokenKind::Number(_));
            let hint = match foreign::attribute(word) {
                Some(ours) => Some(format!("did you mean `{ours}`?")),
                None if number && self.cursor.sees_mark(1, Mark::DotDot) => Some("did you mean `constraint 0..1`?".to_owned()),
                None if number => Some("did you mean `default 0.5`? Decimal numbers have a dot".to_owned()),
                None => None,
            };
            let Some(hint) = hint else {
                return Err(self.cursor.unknown_word(&expected, &ATTRIBUTES));
            };
            let diagnostic = self.cursor.unexpected(&expected).help(hint);
            if *self.cursor.kind(1) == TokenKind::Unknown {
                // `range [0, 1]`: the brackets belong to the attribute.
                return Err(self.cursor.report_instead(span.to(self.cursor.statement_end()), diagnostic));
            }
            return Err(self.cursor.report(diagnostic));
        }
        self.cursor.advance();
        match word {
            "constraint" => {
                self.cursor.pass_marks_after(word, &[Mark::Colon, Mark::Equal]);
                let bounds = match self.range_of_other_languages() {
                    Some(bounds) => bounds,
                    None => self.range()?,
                };
                attributes.range = Some((bounds, span.to(self.cursor.previous_span())));
            }
            "default" => {
                self.cursor.pass_marks_after(word, &[Mark::Colon, Mark::Equal]);
                if let (Some(Type::Texture), TokenKind::Text(path)) = (declared, self.cursor.kind(0)) {
                    let path = path.clone();
                    self.cursor.advance();
                    attributes.image = Some((path, self.cursor.previous_span()));
                    return Ok(());
                }
                if declared == Some(Type::Texture) && self.cursor.word(0).is_some() {
                    let diagnostic = self.cursor.unexpected("the path of an image in quotation marks");
                    return Err(self.cursor.report(diagnostic.help("write `default \"image.png\"`")));
                }
                let value = self.default_value(attributes.choices.as_ref().map(|(names, _)| names.as_slice()))?;
                attributes.default = Some((value, span.to(self.cursor.previous_span())));
            }
            "choices" => {
                self.cursor.pass_marks_after(word, &[Mark::Colon, Mark::Equal]);
                let names = self.choices()?;
                attributes.choices = Some((names, span.to(self.cursor.previous_span())));
            }
            "slider" => attributes.slider = Some(span),
            "switch" => attributes.switch = Some(span),
            _ => attributes.colour = Some(span),
        }
        let is_value = match self.cursor.kind(0) {
            TokenKind::Number(_) | TokenKind::Mark(Mark::Less | Mark::Open | Mark::Equal) => true,
            TokenKind::Word(next) => !ATTRIBUTES.contains(&next.as_str()) && !self.cursor.peek(0).begins_line,
            TokenKind::Mark(_) | TokenKind::Uses(..) | TokenKind::Text(_) | TokenKind::Unknown | TokenKind::End => false,
        };
        if is_value && matches!(word, "slider" | "switch" | "color") {
            let help = match word {
                "color" => "a colour at the start is written `default <1, 0.5, 0>, color`",
                _ => "a range is written `constraint 0..1`, and the value at the start `default 0.5`",
            };
            let diagnostic =
                Diagnostic::error(format!("`{word}` has no value of its own")).at(self.cursor.span(), "expected `,` or `;`");
            return Err(self.cursor.report(diagnostic.help(help)));
        }
        Ok(())
    }

    /// Parses the range after `constraint`.
    fn range(&mut self) -> Result<[f32; 2], Reported> {
        let reports = self.cursor.report_count();
        let range = self.bounds();
        if range.is_err() {
            let help = "a range has two bounds; a large one, as in `0..1000`, or no `constraint` at all lets any value in";
            self.cursor.help_since(reports, help);
        }
        range
    }

    fn bounds(&mut self) -> Result<[f32; 2], Reported> {
        let low = self.single("the lower bound, as in `constraint 0..1`")?;
        self.cursor.expect(Mark::DotDot, "between the bounds, as in `constraint 0..1`")?;
        let high = self.single("the upper bound, as in `constraint 0..1`")?;
        Ok([low, high])
    }

    /// Parses the value after `default`.
    fn default_value(&mut self, choices: Option<&[String]>) -> Result<Constant, Reported> {
        if let (TokenKind::Mark(Mark::Less), TokenKind::Number(x), TokenKind::Mark(Mark::Greater)) =
            (self.cursor.kind(0), self.cursor.kind(1), self.cursor.kind(2))
        {
            let span = self.cursor.span().to(self.cursor.peek(2).span);
            let help = format!("write `default <{x}, {x}, {x}>` for a vector, or `default {x}` for a scalar");
            let diagnostic = Diagnostic::error("a default vector has three numbers").at(span, "expected `<x, y, z>`");
            return Err(self.cursor.report(diagnostic.help(help)));
        }
        if let TokenKind::Text(text) = self.cursor.kind(0) {
            let place = choices.and_then(|names| names.iter().position(|name| name == text));
            let is_image = text.contains('.') && choices.is_none();
            let help = match place {
                _ if is_image => format!("images are defaults of textures: `: texture, default \"{text}\";`"),
                Some(place) => format!("write `default {place}`: choices are numbered 0, 1, … in their order"),
                None => "a default is a number: choices are numbered 0, 1, … in their order".to_owned(),
            };
            let diagnostic = self.cursor.unexpected("the default value, a number").help(help);
            return Err(self.cursor.report(diagnostic));
        }
        let list = self.cursor.numbers_ahead().len() == 3;
        if self.cursor.sees_mark(0, Mark::Less) || self.cursor.sees_mark(0, Mark::Open) || list {
            let [x, y, z] = self.cursor.vector("the default value")?.value;
            return Ok(Constant::Vector([self.narrow(x)?, self.narrow(y)?, self.narrow(z)?]));
        }
        if let Some(word) = self.cursor.word(0).filter(|word| foreign::values::number(word).is_none()) {
            let help = match foreign::function(word).filter(|_| self.cursor.sees_mark(1, Mark::Open)) {
                Some(_) => "a colour is written `<1, 0.5, 0>`: red, green and blue, each 0..1".to_owned(),
                None if self.cursor.sees_mark(1, Mark::Open) => "numbers alone stand here; work the value out".to_owned(),
                None => "a default is written as a number, a colour as `<1, 0.5, 0>`".to_owned(),
            };
            let diagnostic = self.cursor.unexpected("the default value, a number or a vector `<x, y, z>`");
            return Err(self.cursor.report(diagnostic.help(help)));
        }
        Ok(Constant::Scalar(self.single("the default value, a number or a vector `<x, y, z>`")?))
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
        while self.sees_line() || matches!(self.cursor.kind(0), TokenKind::Number(_)) {
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
        if let TokenKind::Number(_) = self.cursor.kind(0) {
            let diagnostic = self.cursor.unexpected("the name of a parameter").help(FORM);
            return Err(self.cursor.report(diagnostic));
        }
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
        if let Some(Mark::Plus | Mark::Minus | Mark::Star) = self.cursor.mark() {
            let diagnostic = self.cursor.unexpected("`;` after the 1").help(FORM);
            return Err(self.cursor.report(diagnostic));
        }
        self.cursor.expect(Mark::Semicolon, "after the invariant")?;
        Ok(InvariantLine { terms, relation, span })
    }
}
