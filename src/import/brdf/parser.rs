//! Parses GLSL.
//!
//! What formulas cannot say becomes a [`GlslStatement::Foreign`] or a foreign name. It is an error only if the model
//! needs it.

mod expressions;

use crate::import::brdf::glsl::{
    BinaryOperator, GlslComponent, GlslExpression, GlslExpressionKind, GlslFunction, GlslName, GlslShader, GlslStatement,
    GlslType,
};
use crate::import::brdf::tokens::{GlslToken, GlslTokenKind};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::SourceSpan;

/// Statements and expressions are at most this deep within each other.
const MOST_NESTING: usize = 100;

/// Words before a type that change nothing here.
const QUALIFIERS: [&str; 10] =
    ["const", "in", "uniform", "highp", "mediump", "lowp", "precise", "invariant", "varying", "static"];

/// A mistake that is reported, or to be reported.
struct SyntaxMistake(SourceSpan, String);

type Parsed<T> = Result<T, SyntaxMistake>;

/// A parser at a place in its words.
pub(super) struct GlslParser<'t> {
    tokens: Vec<GlslToken<'t>>,
    at: usize,
    /// The place behind the last word.
    end: SourceSpan,
    nesting: usize,
}

/// Parses a shader. The first mistake of syntax ends it.
pub(super) fn parse(tokens: Vec<GlslToken>, end: usize, diagnostics: &mut Diagnostics) -> GlslShader {
    let mut parser = GlslParser { tokens, at: 0, end: SourceSpan::new(end, end), nesting: 0 };
    let mut shader = GlslShader::default();
    while parser.peek().is_some() {
        if let Err(SyntaxMistake(span, message)) = parser.declaration(&mut shader) {
            diagnostics.push(Diagnostic::error(format!("the GLSL of the shader cannot be read: {message}")).at(span, ""));
            break;
        }
    }
    shader
}

impl<'t> GlslParser<'t> {
    fn peek(&self) -> Option<GlslToken<'t>> {
        self.tokens.get(self.at).copied()
    }

    fn text(&self, ahead: usize) -> &'t str {
        self.tokens.get(self.at + ahead).map_or("", |token| token.text)
    }

    fn span(&self) -> SourceSpan {
        self.peek().map_or(self.end, |token| token.span)
    }

    fn previous(&self) -> SourceSpan {
        self.at.checked_sub(1).and_then(|at| self.tokens.get(at)).map_or(self.end, |token| token.span)
    }

    /// Moves past a word if it is this one.
    fn takes(&mut self, word: &str) -> bool {
        let is_next = self.text(0) == word;
        self.at += usize::from(is_next);
        is_next
    }

    fn expect(&mut self, word: &str) -> Parsed<()> {
        if self.takes(word) { Ok(()) } else { Err(SyntaxMistake(self.span(), format!("expected `{word}`"))) }
    }

    fn name(&mut self) -> Parsed<GlslName> {
        match self.peek() {
            Some(GlslToken { text, kind: GlslTokenKind::Name, span }) => {
                self.at += 1;
                Ok(GlslName { text: text.to_owned(), span })
            }
            _ => Err(SyntaxMistake(self.span(), "expected a name".to_owned())),
        }
    }

    /// Moves past a group in brackets, whose first bracket is next.
    fn skip_group(&mut self) {
        let mut depth = 0_usize;
        while let Some(token) = self.peek() {
            self.at += 1;
            match token.text {
                "(" | "{" | "[" => depth += 1,
                ")" | "}" | "]" => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth == 0 {
                return;
            }
        }
    }

    /// Moves past a statement, whatever it is.
    fn skip_statement(&mut self) {
        while let Some(token) = self.peek() {
            match token.text {
                ";" => {
                    self.at += 1;
                    return;
                }
                "{" => {
                    self.skip_group();
                    return;
                }
                "(" | "[" => self.skip_group(),
                "}" => return,
                _ => self.at += 1,
            }
        }
    }

    /// Runs a parser one level deeper.
    fn nested<T>(&mut self, parse: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.nesting == MOST_NESTING {
            return Err(SyntaxMistake(self.span(), format!("more than {MOST_NESTING} levels within each other")));
        }
        self.nesting += 1;
        let parsed = parse(self);
        self.nesting -= 1;
        parsed
    }

    fn skip_qualifiers(&mut self) {
        while QUALIFIERS.contains(&self.text(0)) {
            self.at += 1;
        }
    }

    /// A function, a constant, or what is foreign.
    fn declaration(&mut self, shader: &mut GlslShader) -> Parsed<()> {
        if let Some(GlslToken { text, kind: GlslTokenKind::Directive, span }) = self.peek() {
            self.at += 1;
            let name = text.split(|letter: char| !(letter.is_ascii_alphanumeric() || letter == '_')).nth(2);
            if let ("#define", Some(name)) = (text.split_whitespace().next().unwrap_or_default(), name) {
                let name = GlslName { text: name.to_owned(), span };
                shader.foreign.push((name, "macros of the preprocessor are not translated".to_owned()));
            }
            return Ok(());
        }
        if self.takes(";") {
            return Ok(());
        }
        self.skip_qualifiers();
        if matches!(self.text(0), "precision" | "struct") {
            if self.takes("struct") {
                let name = self.name()?;
                shader.foreign.push((name, "structures are not translated".to_owned()));
                self.skip_group();
            }
            self.skip_statement();
            return Ok(());
        }
        let ty = self.name()?;
        let name = self.name()?;
        if self.text(0) == "(" {
            let function = self.function(ty, name)?;
            shader.functions.extend(function);
            return Ok(());
        }
        let known = GlslType::named(&ty.text).filter(|_| self.text(0) != "[");
        let Some(known) = known else {
            let what = if self.text(0) == "[" { "arrays" } else { "values of this type" };
            shader.foreign.push((name, format!("{what} are not translated")));
            self.skip_statement();
            // The elements of an array may stand in braces.
            self.takes(";");
            return Ok(());
        };
        for (name, value) in self.declared(name)? {
            shader.globals.push((name, known, value));
        }
        Ok(())
    }

    /// The rest of a declaration of values, from the first name on.
    fn declared(&mut self, first: GlslName) -> Parsed<Vec<(GlslName, Option<GlslExpression>)>> {
        let mut found = Vec::new();
        let mut name = first;
        loop {
            let value = if self.takes("=") { Some(self.expression()?) } else { None };
            found.push((name, value));
            if !self.takes(",") {
                break;
            }
            name = self.name()?;
        }
        self.expect(";")?;
        Ok(found)
    }

    /// A function from its parameters on. A declaration without a body is none.
    fn function(&mut self, result: GlslName, name: GlslName) -> Parsed<Option<GlslFunction>> {
        self.expect("(")?;
        let mut parameters = Ok(Vec::new());
        while !self.takes(")") {
            self.skip_qualifiers();
            let span = self.span();
            if matches!(self.text(0), "out" | "inout") {
                parameters = Err((span, "functions that change their arguments are not translated".to_owned()));
                self.at += 1;
                continue;
            }
            let ty = self.name()?;
            if ty.text == "void" && self.takes(")") {
                break;
            }
            let own = self.name()?;
            match (GlslType::named(&ty.text).filter(|_| self.text(0) != "["), &mut parameters) {
                (Some(ty), Ok(parameters)) => parameters.push((own, ty)),
                (None, parameters) => *parameters = Err((span, "arguments of this type are not translated".to_owned())),
                (Some(_), Err(_)) => {}
            }
            if self.text(0) == "[" {
                self.skip_group();
            }
            if !self.takes(",") {
                self.expect(")")?;
                break;
            }
        }
        if self.takes(";") {
            return Ok(None);
        }
        let (start, nesting) = (self.at, self.nesting);
        let body = match self.block() {
            Ok(body) => body,
            // The model may not need it.
            Err(SyntaxMistake(span, why)) if self.tokens.get(start).is_some_and(|token| token.text == "{") => {
                (self.at, self.nesting) = (start, nesting);
                self.skip_group();
                parameters = Err((span, why));
                Vec::new()
            }
            Err(mistake) => return Err(mistake),
        };
        Ok(Some(GlslFunction { name, result: GlslType::named(&result.text), parameters, body }))
    }

    /// Statements in braces.
    fn block(&mut self) -> Parsed<Vec<GlslStatement>> {
        self.expect("{")?;
        let mut statements = Vec::new();
        while !self.takes("}") {
            if self.peek().is_none() {
                return Err(SyntaxMistake(self.span(), "expected `}`".to_owned()));
            }
            if !self.takes(";") {
                statements.push(self.nested(Self::statement)?);
            }
        }
        Ok(statements)
    }

    /// A statement or a block, as a list.
    fn branch(&mut self) -> Parsed<Vec<GlslStatement>> {
        if self.text(0) == "{" {
            return self.nested(Self::block);
        }
        if self.takes(";") { Ok(Vec::new()) } else { Ok(vec![self.nested(Self::statement)?]) }
    }

    fn foreign(&mut self, why: &str) -> GlslStatement {
        let span = self.span();
        self.at += 1;
        self.skip_statement();
        GlslStatement::Foreign(span, why.to_owned())
    }

    fn statement(&mut self) -> Parsed<GlslStatement> {
        let span = self.span();
        match self.text(0) {
            "{" => return Ok(GlslStatement::Block(self.nested(Self::block)?)),
            "if" => {
                self.at += 1;
                self.expect("(")?;
                let condition = self.expression()?;
                self.expect(")")?;
                let then = self.branch()?;
                let other = if self.takes("else") { self.branch()? } else { Vec::new() };
                return Ok(GlslStatement::If(condition, then, other));
            }
            "return" => {
                self.at += 1;
                let value = if self.text(0) == ";" { None } else { Some(self.expression()?) };
                self.expect(";")?;
                return Ok(GlslStatement::Return(value, span));
            }
            "for" | "while" => return Ok(self.foreign("loops are not translated")),
            "do" => {
                let statement = self.foreign("loops are not translated");
                self.skip_statement();
                return Ok(statement);
            }
            "switch" => return Ok(self.foreign("`switch` is not translated")),
            "discard" | "break" | "continue" => return Ok(self.foreign("jumps are not translated")),
            _ => {}
        }
        if self.peek().is_some_and(|token| token.kind == GlslTokenKind::Directive) {
            self.at += 1;
            return Ok(GlslStatement::Foreign(span, "directives of the preprocessor are not translated".to_owned()));
        }
        self.skip_qualifiers();
        let is_declaration =
            [0, 1].map(|ahead| self.tokens.get(self.at + ahead).is_some_and(|token| token.kind == GlslTokenKind::Name));
        if is_declaration == [true, true] {
            let ty = self.name()?;
            let name = self.name()?;
            return match GlslType::named(&ty.text).filter(|_| self.text(0) != "[") {
                Some(ty) => Ok(GlslStatement::Declare(ty, self.declared(name)?)),
                None => {
                    self.skip_statement();
                    self.takes(";");
                    let what = if GlslType::named(&ty.text).is_some() { "arrays" } else { "values of this type" };
                    Ok(GlslStatement::Foreign(ty.span, format!("{what} are not translated")))
                }
            };
        }
        self.assignment()
    }

    /// `a = 1;`, `v.x *= 2;`, `a++;`
    fn assignment(&mut self) -> Parsed<GlslStatement> {
        let start = self.span();
        let first = self.text(0);
        if matches!(first, "++" | "--") {
            self.at += 1;
        }
        let name = self.name()?;
        let component = self.component()?;
        let one = |span| GlslExpression { kind: GlslExpressionKind::Number("1".to_owned()), span, depth: 1 };
        let operator = match self.text(0) {
            "=" => None,
            "+=" | "++" => Some(BinaryOperator::Add),
            "-=" | "--" => Some(BinaryOperator::Subtract),
            "*=" => Some(BinaryOperator::Multiply),
            "/=" => Some(BinaryOperator::Divide),
            _ if first == "++" => Some(BinaryOperator::Add),
            _ if first == "--" => Some(BinaryOperator::Subtract),
            "(" => {
                self.skip_statement();
                return Ok(GlslStatement::Foreign(name.span, "calls for an effect are not translated".to_owned()));
            }
            _ => return Err(SyntaxMistake(self.span(), "expected `=`".to_owned())),
        };
        let value = if matches!(first, "++" | "--") {
            one(start)
        } else {
            let sign = self.text(0);
            self.at += 1;
            if matches!(sign, "++" | "--") { one(self.previous()) } else { self.expression()? }
        };
        self.expect(";")?;
        Ok(GlslStatement::Assign(name, component, operator, value))
    }

    /// The component that an assignment names: `.x` or `[0]`.
    fn component(&mut self) -> Parsed<Option<GlslComponent>> {
        if self.takes(".") {
            let member = self.name()?;
            return match component_of(&member.text) {
                Some(index) => Ok(Some(GlslComponent(index))),
                None => Err(SyntaxMistake(member.span, "only one component is changed at a time".to_owned())),
            };
        }
        if self.takes("[") {
            let index = ["0", "1", "2"].iter().position(|number| self.takes(number));
            let index = index.ok_or_else(|| SyntaxMistake(self.span(), "expected 0, 1 or 2".to_owned()))?;
            self.expect("]")?;
            return Ok(Some(GlslComponent(index)));
        }
        Ok(None)
    }
}

/// The number of a component of this name.
pub(super) fn component_of(name: &str) -> Option<usize> {
    ["xrs", "ygt", "zbp"].iter().position(|names| name.len() == 1 && names.contains(name))
}
