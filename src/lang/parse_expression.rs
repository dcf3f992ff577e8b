//! Parses expressions: `expr` and `cond` of the grammar (thesis 9.2.1).

use crate::lang::ast::{ExprId, ExprKind, Name};
use crate::lang::builtins::{self, Form, Repetition};
use crate::lang::cursor::{Placed, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::foreign;
use crate::lang::parser::FormulaParser;
use crate::lang::source::SourceSpan;
use crate::lang::token::{Mark, TokenKind};

/// How deeply expressions may be nested. Nobody writes more levels, and this many fit the stack of any thread.
const MAX_NESTING: usize = 256;

const COMPARISONS: [Mark; 6] = [Mark::Less, Mark::LessEqual, Mark::Greater, Mark::GreaterEqual, Mark::EqualEqual, Mark::NotEqual];

impl FormulaParser<'_> {
    /// Parses `expr`.
    pub(super) fn expression(&mut self) -> Result<ExprId, Reported> {
        self.sum(0)
    }

    /// Parses `expr` or `cond`.
    pub(super) fn value_or_condition(&mut self) -> Result<ExprId, Reported> {
        self.condition(0)
    }

    /// Moves past the mark that must follow an expression, or reports why another word cannot follow.
    pub(super) fn expect_expression_end(&mut self, mark: Mark, purpose: &str) -> Result<(), Reported> {
        let found = self.cursor.mark();
        if found == Some(mark) {
            self.cursor.advance();
            return Ok(());
        }
        if self.cursor.statement_has_unknown() {
            // The lexer has reported it, and it is the likely reason.
            return Err(Reported);
        }
        let span = self.cursor.span();
        let logical = |found: Mark| COMPARISONS.contains(&found) || matches!(found, Mark::AndAnd | Mark::OrOr);
        let diagnostic = match found {
            Some(found) if logical(found) => Diagnostic::error(format!("`{}` is outside of parentheses", found.spelling()))
                .at(span, "here a comparison needs parentheses")
                .help("write `(a < b)`, which is 1 or 0, or `if(a < b, then, else)`"),
            Some(Mark::Colon) if self.cursor.sees_mark(1, Mark::Colon) => Diagnostic::error("`::` is not part of the language")
                .at(span.to(self.cursor.peek(1).span), "expected an operator")
                .help("functions and constants stand alone: write `max(a, b)`, `pi`"),
            Some(Mark::Equal) if self.cursor.sees_mark(1, Mark::Greater) || self.cursor.sees_mark(1, Mark::Less) => {
                let ours = if self.cursor.sees_mark(1, Mark::Greater) { ">=" } else { "<=" };
                Diagnostic::error("an operator is turned round")
                    .at(span.to(self.cursor.peek(1).span), "not understood")
                    .help(format!("write `{ours}`"))
            }
            Some(Mark::Equal) if !self.cursor.peek(0).begins_line => Diagnostic::error("a second `=` in one statement")
                .at(span, format!("expected an operator or `{}`", mark.spelling()))
                .help("is a `;` missing before it? To compare, write `==` inside `if(…)`"),
            Some(Mark::Close) => Diagnostic::error("a `)` without a `(`").at(span, "no `(` is open here"),
            _ if self.operator_missing() => {
                let before = self.source_text(self.cursor.previous_span());
                let after = self.source_text(span);
                let hint = match (foreign::operator(&before), foreign::operator(&after)) {
                    (Some(ours), _) => Some(format!("`{before}` is written `{ours}`")),
                    (None, Some(ours)) => Some(format!("`{after}` is written `{ours}`")),
                    (None, None) if matches!(builtins::named(&before), Some(Form::Function(_))) => {
                        Some(format!("arguments stand in parentheses: `{before}({after})`"))
                    }
                    (None, None) => None,
                };
                Diagnostic::error(format!("an operator is missing between `{before}` and `{after}`"))
                    .at(self.cursor.previous_span().to(span), "expected `*`, `.`, `+` or another operator between the two")
                    .help_if(hint)
            }
            Some(Mark::Comma) if mark == Mark::Close => Diagnostic::error("a `,` in parentheses without a function")
                .at(span, "expected an operator or `)`")
                .help("vectors are written `<x, y, z>`"),
            Some(Mark::Comma) if self.cursor.peek(1).begins_line => {
                Diagnostic::error("a `,` at the end of a statement").at(span, "expected `;`").help("statements end with `;`")
            }
            Some(Mark::Comma) if mark == Mark::Semicolon => Diagnostic::error("a `,` outside parentheses")
                .at(span, "expected an operator or `;`")
                .help("decimal numbers are written with a dot, `1.5`, and vectors `<x, y, z>`"),
            _ => return self.cursor.expect(mark, purpose),
        };
        Err(self.cursor.report(diagnostic))
    }

    /// Whether a value follows another without an operator, on the same line.
    fn operator_missing(&self) -> bool {
        let next = self.cursor.peek(0);
        let value = matches!(next.kind, TokenKind::Word(_) | TokenKind::Number(_) | TokenKind::Mark(Mark::Open));
        value && !next.begins_line && !self.cursor.sees_mark(1, Mark::Equal)
    }

    /// The number of expressions around an operand of an expression with this many around it.
    fn nested(&mut self, nesting: usize) -> Result<usize, Reported> {
        if nesting >= MAX_NESTING {
            let diagnostic = Diagnostic::error("the expression is nested too deeply")
                .at(self.cursor.span(), format!("more than {MAX_NESTING} levels here"))
                .help("give parts of it names: `PART = …;`");
            return Err(self.cursor.report(diagnostic));
        }
        Ok(nesting + 1)
    }

    /// Parses `cond`: comparisons joined by `&&` and `||`. Parentheses in it may hold conditions or values; their types
    /// are checked later.
    fn condition(&mut self, nesting: usize) -> Result<ExprId, Reported> {
        let mut left = self.conjunction(nesting)?;
        while self.cursor.sees_mark(0, Mark::OrOr) {
            left = self.infix(left, nesting, Self::conjunction)?;
        }
        Ok(left)
    }

    fn conjunction(&mut self, nesting: usize) -> Result<ExprId, Reported> {
        let mut left = self.negation(nesting)?;
        while self.cursor.sees_mark(0, Mark::AndAnd) {
            left = self.infix(left, nesting, Self::negation)?;
        }
        Ok(left)
    }

    fn negation(&mut self, nesting: usize) -> Result<ExprId, Reported> {
        if self.cursor.sees_mark(0, Mark::Not) {
            let nesting = self.nested(nesting)?;
            let start = self.cursor.advance().span;
            let operand = self.negation(nesting)?;
            let span = start.to(self.cursor.previous_span());
            return Ok(self.add(ExprKind::Prefix(Mark::Not, operand), span));
        }
        let left = self.sum(nesting)?;
        let compares = |mark: Option<Mark>| mark.is_some_and(|mark| COMPARISONS.contains(&mark));
        if !compares(self.cursor.mark()) {
            return Ok(left);
        }
        let comparison = self.infix(left, nesting, Self::sum)?;
        if compares(self.cursor.mark()) {
            let diagnostic = Diagnostic::error("comparisons cannot be chained")
                .at(self.cursor.span(), "a second comparison")
                .help("write `a < b && b < c`");
            return Err(self.cursor.report(diagnostic));
        }
        Ok(comparison)
    }

    /// Parses the current operator and its right operand; the left one has been parsed.
    fn infix(
        &mut self,
        left: ExprId,
        nesting: usize,
        operand: impl FnOnce(&mut Self, usize) -> Result<ExprId, Reported>,
    ) -> Result<ExprId, Reported> {
        let start = self.file.expr(left).outer;
        let operator = self.cursor.advance();
        let TokenKind::Mark(mark) = operator.kind else { return Err(self.cursor.expected("an operator")) };
        let right = operand(self, nesting)?;
        let span = start.to(self.cursor.previous_span());
        Ok(self.add(ExprKind::Infix(mark, operator.span, [left, right]), span))
    }

    fn sum(&mut self, nesting: usize) -> Result<ExprId, Reported> {
        let mut left = self.product(nesting)?;
        while let Some(Mark::Plus | Mark::Minus) = self.cursor.mark() {
            left = self.infix(left, nesting, Self::product)?;
        }
        Ok(left)
    }

    fn product(&mut self, nesting: usize) -> Result<ExprId, Reported> {
        let mut left = self.power(nesting)?;
        while let Some(Mark::Star | Mark::Slash | Mark::Dot) = self.cursor.mark() {
            self.no_double_star(left)?;
            left = self.infix(left, nesting, Self::power)?;
        }
        Ok(left)
    }

    /// Reports `a**2`.
    fn no_double_star(&mut self, base: ExprId) -> Result<(), Reported> {
        if !(self.cursor.sees_mark(0, Mark::Star) && self.cursor.sees_mark(1, Mark::Star)) {
            return Ok(());
        }
        let span = self.cursor.span().to(self.cursor.peek(1).span);
        let last = self.file.expr(base).kind.infix().map_or(base, |(_, [_, last])| last);
        let base = self.source_text(self.file.expr(last).outer);
        let exponent = match self.cursor.kind(2) {
            TokenKind::Number(_) | TokenKind::Word(_) => self.source_text(self.cursor.peek(2).span),
            TokenKind::Mark(_) | TokenKind::Uses(..) | TokenKind::Text(_) | TokenKind::Unknown | TokenKind::End => "n".to_owned(),
        };
        let short = if base.len() <= 20 { base } else { "x".to_owned() };
        let diagnostic = Diagnostic::error("`**` is not part of the language").at(span, "expected one operator");
        Err(self.cursor.report(diagnostic.help(format!("powers are written `{short}^{exponent}`"))))
    }

    /// `^` groups to the right, and a unary minus binds more tightly: −2^2 is 4.
    fn power(&mut self, nesting: usize) -> Result<ExprId, Reported> {
        let base = self.unary(nesting)?;
        if !self.cursor.sees_mark(0, Mark::Caret) {
            return Ok(base);
        }
        let nesting = self.nested(nesting)?;
        self.infix(base, nesting, Self::power)
    }

    fn unary(&mut self, nesting: usize) -> Result<ExprId, Reported> {
        if !self.cursor.sees_mark(0, Mark::Minus) {
            return self.atom(nesting);
        }
        let nesting = self.nested(nesting)?;
        let start = self.cursor.advance().span;
        let operand = self.unary(nesting)?;
        let span = start.to(self.cursor.previous_span());
        Ok(self.add(ExprKind::Prefix(Mark::Minus, operand), span))
    }

    fn atom(&mut self, nesting: usize) -> Result<ExprId, Reported> {
        let token = self.cursor.peek(0).clone();
        match token.kind {
            TokenKind::Number(value) => {
                self.cursor.advance();
                let text = self.source_text(token.span);
                self.number_stands_alone(&text)?;
                let value = self.narrow(Placed { value, span: token.span })?;
                Ok(self.add(ExprKind::Number(value), token.span))
            }
            TokenKind::Word(word) => {
                let nesting = self.nested(nesting)?;
                let callee = self.cursor.name("a value")?;
                if word == "if" {
                    return self.conditional(nesting, callee);
                }
                if self.cursor.sees_mark(0, Mark::Open) {
                    return self.call(nesting, callee);
                }
                Ok(self.add(ExprKind::Name(word), token.span))
            }
            TokenKind::Mark(Mark::Open) => {
                let inner = self.nested(nesting)?;
                self.cursor.advance();
                let expression = self.condition(inner)?;
                if self.cursor.at_end() || self.cursor.sees_mark(0, Mark::Semicolon) {
                    let diagnostic = Diagnostic::error("a `(` is not closed")
                        .at(token.span, "opened here")
                        .at(self.cursor.span(), "expected `)` before this");
                    return Err(self.cursor.report(diagnostic));
                }
                self.expect_expression_end(Mark::Close, "to close the parenthesis")?;
                self.file.expressions[expression.0 as usize].outer = token.span.to(self.cursor.previous_span());
                Ok(expression)
            }
            TokenKind::Mark(Mark::Less) => {
                let inner = self.nested(nesting)?;
                self.cursor.advance();
                let mut components = vec![self.sum(inner)?];
                if !self.cursor.sees_mark(0, Mark::Greater) {
                    self.expect_component(token.span, Mark::Comma)?;
                    components.push(self.sum(inner)?);
                    self.expect_component(token.span, Mark::Comma)?;
                    components.push(self.sum(inner)?);
                }
                self.expect_component(token.span, Mark::Greater)?;
                let span = token.span.to(self.cursor.previous_span());
                Ok(self.add(ExprKind::Vector(components), span))
            }
            TokenKind::Mark(Mark::Not) => {
                let diagnostic = Diagnostic::error("`!` is outside of parentheses")
                    .at(token.span, "here a condition needs parentheses")
                    .help("write `(!(a < b))`, which is 1 or 0, or `if(!(a < b), then, else)`");
                Err(self.cursor.report(diagnostic))
            }
            TokenKind::Mark(_) | TokenKind::Uses(..) | TokenKind::Text(_) | TokenKind::Unknown | TokenKind::End => {
                let before = self.cursor.previous_mark();
                let hint = match (&token.kind, before) {
                    (TokenKind::Mark(Mark::Greater), Some(Mark::Less)) => {
                        Some("unequal is written `a != b`, and vectors `<x, y, z>`")
                    }
                    (TokenKind::Mark(Mark::Equal), Some(Mark::EqualEqual)) => Some("equal is written `a == b`"),
                    (TokenKind::Mark(Mark::Equal), Some(Mark::NotEqual)) => Some("unequal is written `a != b`"),
                    (TokenKind::Mark(Mark::Plus), Some(Mark::Plus)) => Some("there is no `++`; a macro has one value"),
                    (TokenKind::Mark(Mark::Plus), _) => Some("a sign before a value is `-` alone; leave the `+` out"),
                    (TokenKind::Mark(Mark::Star | Mark::Slash | Mark::Caret), Some(Mark::Dot)) => {
                        Some("`*`, `/` and `^` work by components; leave the `.` out")
                    }
                    (TokenKind::Text(_), _) => Some(
                        "texts are no values, but for the file of `measured(\"file\")`; choices are compared by their \
                         numbers: `model == 0`",
                    ),
                    (TokenKind::Mark(_) | TokenKind::Uses(..) | TokenKind::Number(_) | TokenKind::Word(_), _)
                    | (TokenKind::Unknown | TokenKind::End, _) => None,
                };
                let diagnostic = self.cursor.unexpected("a value: a number, a name, `(…)` or `<x, y, z>`").help_if(hint);
                Err(self.cursor.report(diagnostic))
            }
        }
    }

    /// Moves past the mark after a component of the vector that begins at `open`.
    fn expect_component(&mut self, open: SourceSpan, mark: Mark) -> Result<(), Reported> {
        if mark == Mark::Comma && self.cursor.sees_mark(0, Mark::Semicolon) && !self.cursor.peek(1).begins_line {
            let diagnostic = Diagnostic::error("a `;` between the components of a vector").at(self.cursor.span(), "expected `,`");
            self.cursor.report(diagnostic.help("vectors are written `<x, y, z>`"));
            self.cursor.advance();
            return Ok(());
        }
        let few = mark == Mark::Comma && self.cursor.sees_mark(0, Mark::Greater);
        let many = mark == Mark::Greater && self.cursor.sees_mark(0, Mark::Comma);
        if few || many {
            let count = if few { "fewer" } else { "more" };
            let diagnostic = Diagnostic::error(format!("a vector has three components, this one has {count}"))
                .at(open.to(self.cursor.span()), "expected `<x, y, z>`");
            return Err(self.cursor.report(diagnostic));
        }
        self.expect_expression_end(mark, "in the vector `<x, y, z>`")
    }

    /// Reports a number with a value right after it: `1.N` is the number `1.` and a name, but probably meant as a dot
    /// product.
    fn number_stands_alone(&mut self, text: &str) -> Result<(), Reported> {
        let number = self.cursor.previous_span();
        let next = self.cursor.peek(0).clone();
        if !matches!(next.kind, TokenKind::Word(_) | TokenKind::Number(_) | TokenKind::Mark(Mark::Open)) || next.begins_line {
            return Ok(());
        }
        let described = next.kind.describe();
        let hint = match &next.kind {
            TokenKind::Word(name) if let Some(ours) = foreign::operator(name) => format!("`{name}` is written `{ours}`"),
            TokenKind::Word(name) if text.ends_with('.') => {
                format!(
                    "a dot after digits belongs to the number; write `({}).{name}` for a dot product",
                    text.trim_end_matches('.')
                )
            }
            TokenKind::Word(name) if self.cursor.sees_mark(1, Mark::Dot) => match self.cursor.word(2) {
                Some(other) => format!("write `{text}*({name}.{other})` for a product, or a `,` between arguments"),
                None => format!("write `{text}*{name}` for a product, or a `,` between arguments"),
            },
            TokenKind::Word(name) => format!("write `{text}*{name}` for a product, or a `,` between arguments"),
            TokenKind::Mark(_) if let Some(function) = self.cursor.function_with_exponent() => {
                format!("the power comes behind the arguments: `{function}(…)^{text}`")
            }
            TokenKind::Mark(_) => format!("write `{text}*(…)` for a product"),
            TokenKind::Number(_) | TokenKind::Uses(..) | TokenKind::Text(_) | TokenKind::Unknown | TokenKind::End => {
                "write an operator, or a `,` between arguments".to_owned()
            }
        };
        let diagnostic = Diagnostic::error(format!("a number is directly before {described}"))
            .at(number.to(next.span), "expected an operator between the two")
            .help(hint);
        Err(self.cursor.report(diagnostic))
    }

    /// Parses `(condition, then, else)` after `if`.
    fn conditional(&mut self, nesting: usize, callee: Name) -> Result<ExprId, Reported> {
        self.cursor.expect(Mark::Open, "after `if`, as in `if(a < b, then, else)`")?;
        let condition = self.condition(nesting)?;
        if self.cursor.sees_mark(0, Mark::Close) {
            let diagnostic = Diagnostic::error("`if` lacks its two values")
                .at(callee.span.to(self.cursor.span()), "expected `if(condition, then, else)`");
            return Err(self.cursor.report(diagnostic.help("the values stand in the same parentheses, after commas")));
        }
        self.expect_expression_end(Mark::Comma, "between the condition and the value if it holds")?;
        let then = self.sum(nesting)?;
        if self.cursor.sees_mark(0, Mark::Close) {
            let diagnostic = Diagnostic::error("`if` lacks the value for the other case")
                .at(callee.span.to(self.cursor.span()), "expected `if(condition, then, else)`");
            let zero = "a third value is needed, such as `0`, or `<0>` for a vector";
            return Err(self.cursor.report(diagnostic.help(zero)));
        }
        self.expect_expression_end(Mark::Comma, "between the two values of `if`")?;
        let other = self.sum(nesting)?;
        self.expect_expression_end(Mark::Close, "to close `if(condition, then, else)`")?;
        let span = callee.span.to(self.cursor.previous_span());
        Ok(self.add(ExprKind::Conditional([condition, then, other]), span))
    }

    /// Whether a `;` is here that separates arguments: the statement does not end before a `)` in the same line.
    fn sees_separator(&self) -> bool {
        if !self.cursor.sees_mark(0, Mark::Semicolon) {
            return false;
        }
        let mut depth = 1;
        let mut ahead = 1;
        loop {
            let token = self.cursor.peek(ahead);
            match token.kind.mark() {
                _ if token.begins_line || token.kind == TokenKind::End => return false,
                Some(Mark::Open) => depth += 1,
                Some(Mark::Close) => depth -= 1,
                Some(Mark::Equal) => return false,
                _ => {}
            }
            if depth == 0 {
                return true;
            }
            ahead += 1;
        }
    }

    /// Parses the text that begins the arguments of a function which takes a file.
    fn path(&mut self, callee: &Name) -> Option<ExprId> {
        let token = self.cursor.peek(0).clone();
        let TokenKind::Text(path) = token.kind else { return None };
        if callee.text != Form::Measured.spelling() || self.cursor.previous_mark() != Some(Mark::Open) {
            return None;
        }
        self.cursor.advance();
        Some(self.add(ExprKind::Text(path), token.span))
    }

    /// Parses `(arguments)` after a name.
    fn call(&mut self, nesting: usize, callee: Name) -> Result<ExprId, Reported> {
        let open = self.cursor.advance().span;
        let mut arguments = Vec::new();
        if self.cursor.accept(Mark::Close) {
            let span = callee.span.to(self.cursor.previous_span());
            return Ok(self.add(ExprKind::Call(callee, arguments), span));
        }
        loop {
            let path = self.path(&callee);
            arguments.push(path.map_or_else(|| self.sum(nesting), Ok)?);
            if self.sees_separator() {
                let diagnostic = Diagnostic::error(format!("a `;` between the arguments of `{}`", callee.text));
                let span = self.cursor.span();
                self.cursor.report(diagnostic.at(span, "expected `,`").help("a `;` ends a statement"));
                self.cursor.replace(Mark::Comma);
            }
            if !self.cursor.accept(Mark::Comma) {
                break;
            }
        }
        if self.cursor.at_end() || self.cursor.sees_mark(0, Mark::Semicolon) {
            let diagnostic = Diagnostic::error(format!("the `(` after `{}` is not closed", callee.text))
                .at(open, "opened here")
                .at(self.cursor.span(), "expected `)` before this");
            return Err(self.cursor.report(diagnostic));
        }
        let reports = self.cursor.report_count();
        let end = self.expect_expression_end(Mark::Close, &format!("to close `{}(…)`", callee.text));
        if let (true, Some(repetition)) = (end.is_err(), Repetition::named(&callee.text)) {
            self.cursor.help_since(reports, &format!("write `{}`", repetition.usage()));
        }
        end?;
        let span = callee.span.to(self.cursor.previous_span());
        Ok(self.add(ExprKind::Call(callee, arguments), span))
    }
}
