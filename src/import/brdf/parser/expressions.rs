//! Expressions of GLSL.

use crate::import::brdf::glsl::{BinaryOperator, GlslExpression, GlslExpressionKind, GlslName};
use crate::import::brdf::parser::{GlslParser, MOST_NESTING, Parsed, SyntaxMistake};
use crate::import::brdf::tokens::GlslTokenKind;
use crate::lang::source::SourceSpan;

impl GlslParser<'_> {
    pub(super) fn expression(&mut self) -> Parsed<GlslExpression> {
        self.nested(|parser| {
            let condition = parser.binary(0)?;
            if !parser.takes("?") {
                return Ok(condition);
            }
            let then = parser.expression()?;
            parser.expect(":")?;
            let other = parser.expression()?;
            let span = condition.span.to(other.span);
            parser.made(span, GlslExpressionKind::Conditional(Box::new([condition, then, other])))
        })
    }

    /// Operands of operators that bind more tightly than this.
    fn binary(&mut self, least: u8) -> Parsed<GlslExpression> {
        let mut left = self.unary()?;
        loop {
            let next = BinaryOperator::ALL.iter().find(|(_, sign, binding)| *sign == self.text(0) && *binding > least);
            let Some((operator, _, binding)) = next else {
                if matches!(self.text(0), "%" | "&" | "|" | "^" | "<<" | ">>") {
                    return Err(SyntaxMistake(self.span(), "operators of whole numbers are not translated".to_owned()));
                }
                return Ok(left);
            };
            self.at += 1;
            let right = self.nested(|parser| parser.binary(*binding))?;
            let span = left.span.to(right.span);
            left = self.made(span, GlslExpressionKind::Binary(*operator, Box::new(left), Box::new(right)))?;
        }
    }

    fn unary(&mut self) -> Parsed<GlslExpression> {
        let start = self.span();
        let make: fn(Box<GlslExpression>) -> GlslExpressionKind = match self.text(0) {
            "-" => GlslExpressionKind::Negative,
            "!" => GlslExpressionKind::Not,
            "+" => {
                self.at += 1;
                return self.nested(Self::unary);
            }
            _ => return self.postfix(),
        };
        self.at += 1;
        let operand = self.nested(Self::unary)?;
        self.made(start.to(operand.span), make(Box::new(operand)))
    }

    /// An operand with its components.
    fn postfix(&mut self) -> Parsed<GlslExpression> {
        let mut own = self.primary()?;
        loop {
            if self.takes(".") {
                let member = self.name()?;
                let span = own.span.to(member.span);
                own = self.made(span, GlslExpressionKind::Member(Box::new(own), member))?;
            } else if self.takes("[") {
                let index = self.expression()?;
                self.expect("]")?;
                let span = own.span.to(self.previous());
                own = self.made(span, GlslExpressionKind::Index(Box::new(own), Box::new(index)))?;
            } else {
                return Ok(own);
            }
        }
    }

    fn primary(&mut self) -> Parsed<GlslExpression> {
        let Some(token) = self.peek() else { return Err(SyntaxMistake(self.end, "expected an expression".to_owned())) };
        self.at += 1;
        let kind = match (token.kind, token.text) {
            (GlslTokenKind::Number, text) => {
                GlslExpressionKind::Number(text.trim_end_matches(['f', 'F', 'u', 'U', 'l', 'L']).to_owned())
            }
            (GlslTokenKind::Name, "true") => GlslExpressionKind::Truth(true),
            (GlslTokenKind::Name, "false") => GlslExpressionKind::Truth(false),
            (GlslTokenKind::Name, text) if self.text(0) == "(" => {
                self.at += 1;
                let mut arguments = Vec::new();
                while !self.takes(")") {
                    arguments.push(self.expression()?);
                    if !self.takes(",") {
                        self.expect(")")?;
                        break;
                    }
                }
                let name = GlslName { text: text.to_owned(), span: token.span };
                let span = token.span.to(self.previous());
                return self.made(span, GlslExpressionKind::Call(name, arguments));
            }
            (GlslTokenKind::Name, text) => GlslExpressionKind::Name(text.to_owned()),
            (GlslTokenKind::Mark, "(") => {
                let own = self.expression()?;
                self.expect(")")?;
                return Ok(own);
            }
            (GlslTokenKind::Mark | GlslTokenKind::Directive, _) => {
                return Err(SyntaxMistake(token.span, "expected an expression".to_owned()));
            }
        };
        self.made(token.span, kind)
    }

    /// An expression, unless it is too deep.
    fn made(&self, span: SourceSpan, kind: GlslExpressionKind) -> Parsed<GlslExpression> {
        let depth = match &kind {
            GlslExpressionKind::Number(_) | GlslExpressionKind::Truth(_) | GlslExpressionKind::Name(_) => 0,
            GlslExpressionKind::Negative(own) | GlslExpressionKind::Not(own) | GlslExpressionKind::Member(own, _) => own.depth,
            GlslExpressionKind::Binary(_, left, right) | GlslExpressionKind::Index(left, right) => left.depth.max(right.depth),
            GlslExpressionKind::Conditional(parts) => parts.iter().map(|part| part.depth).max().unwrap_or(0),
            GlslExpressionKind::Call(_, arguments) => arguments.iter().map(|own| own.depth).max().unwrap_or(0),
        } + 1;
        // Sums and products have a level for each term.
        if depth > 2 * MOST_NESTING {
            return Err(SyntaxMistake(span, format!("more than {} operations within each other", 2 * MOST_NESTING)));
        }
        Ok(GlslExpression { kind, span, depth })
    }
}
