//! Reads numbers and constant vectors, as declarations and scenes have them. Arithmetic in their place is worked out
//! for the message.

use super::{Cursor, Placed, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::foreign;
use crate::lang::token::{Mark, TokenKind};

/// A constant that stands ahead: its value, how many words it has, and whether it is a number alone.
struct ConstantAhead {
    value: f64,
    words: usize,
    plain: bool,
    /// Whether it has `pi`, as angles in radians have.
    has_pi: bool,
}

impl Cursor {
    /// Reads a number with an optional minus sign; `what` describes it in messages. Arithmetic with numbers is reported
    /// and read as its value.
    ///
    /// # Errors
    /// The current word is something else.
    pub fn number(&mut self, what: &str) -> Result<Placed<f64>, Reported> {
        let write = |ahead: &ConstantAhead| format!("write `{}`", ahead.value as f32);
        self.number_with_help(what, write).map(|(placed, _)| placed)
    }

    /// Reads an angle in degrees. One that is written with `pi` is in radians, and is read as the degrees of it.
    ///
    /// # Errors
    /// As for [`number`](Self::number).
    pub fn degrees(&mut self, what: &str) -> Result<Placed<f64>, Reported> {
        let write = |ahead: &ConstantAhead| match ahead.has_pi {
            true => format!("write `{}`: angles are in degrees here", ahead.value.to_degrees() as f32),
            false => format!("write `{}`", ahead.value as f32),
        };
        let (Placed { value, span }, has_pi) = self.number_with_help(what, write)?;
        Ok(Placed { value: if has_pi { value.to_degrees() } else { value }, span })
    }

    /// Whether a number is ahead, or what is read as one.
    pub fn sees_number(&self) -> bool {
        self.constant_ahead().is_some()
    }

    /// Reads a number. `write` says what to write in place of arithmetic. Returns also whether it has `pi`.
    fn number_with_help(
        &mut self,
        what: &str,
        write: impl Fn(&ConstantAhead) -> String,
    ) -> Result<(Placed<f64>, bool), Reported> {
        let start = self.span();
        let Some(ahead) = self.constant_ahead() else {
            let negative = usize::from(self.sees_mark(0, Mark::Minus));
            let hint = self.word(negative).and_then(|word| match foreign::values::hint(word) {
                Some(_) if foreign::values::is_nan(word) => Some("every number here has a value".to_owned()),
                Some(hint) => Some(hint),
                None if self.sees_mark(negative + 1, Mark::Open) => {
                    Some("numbers alone stand here; work the value out, and write it as a number".to_owned())
                }
                None => None,
            });
            if negative > 0 {
                self.advance();
            }
            let diagnostic = Diagnostic::error(format!("expected {what}, found {}", self.kind(0).describe()));
            return Err(self.report(diagnostic.at(self.span(), "a number belongs here").help_if(hint)));
        };
        let ConstantAhead { value, words, plain, has_pi } = ahead;
        let span = start.to(self.peek(words - 1).span);
        if !plain {
            let found = if words == 1 { self.kind(0).describe() } else { "an expression".to_owned() };
            let diagnostic = Diagnostic::error(format!("expected {what}, found {found}"));
            self.report(diagnostic.at(span, "a number alone belongs here").help(write(&ahead)));
        }
        for _ in 0..words {
            self.advance();
        }
        Ok((Placed { value, span }, has_pi))
    }

    /// Arithmetic with numbers from the current word on: sums of products.
    fn constant_ahead(&self) -> Option<ConstantAhead> {
        let mut sum = self.product_ahead(0)?;
        loop {
            let sign = match self.kind(sum.words).mark() {
                Some(Mark::Plus) => 1.0,
                Some(Mark::Minus) => -1.0,
                _ => return Some(sum),
            };
            let Some(next) = self.product_ahead(sum.words + 1) else { return Some(sum) };
            let (words, has_pi) = (sum.words + 1 + next.words, sum.has_pi || next.has_pi);
            sum = ConstantAhead { value: sum.value + sign * next.value, words, plain: false, has_pi };
        }
    }

    fn product_ahead(&self, from: usize) -> Option<ConstantAhead> {
        let mut product = self.factor_ahead(from)?;
        loop {
            let mark = self.kind(from + product.words).mark().filter(|mark| matches!(mark, Mark::Star | Mark::Slash));
            let (Some(mark), Some(next)) = (mark, self.factor_ahead(from + product.words + 1)) else { return Some(product) };
            let value = if mark == Mark::Star { product.value * next.value } else { product.value / next.value };
            let (words, has_pi) = (product.words + 1 + next.words, product.has_pi || next.has_pi);
            product = ConstantAhead { value, words, plain: false, has_pi };
        }
    }

    fn factor_ahead(&self, from: usize) -> Option<ConstantAhead> {
        let negative = usize::from(self.sees_mark(from, Mark::Minus));
        let (value, plain, has_pi) = match self.kind(from + negative) {
            TokenKind::Number(value) => (*value, true, false),
            TokenKind::Word(word) => {
                let value = foreign::values::number(word)?;
                (value, false, value == std::f64::consts::PI)
            }
            TokenKind::Uses(..) | TokenKind::Text(_) | TokenKind::Mark(_) | TokenKind::Unknown | TokenKind::End => return None,
        };
        Some(ConstantAhead { value: if negative > 0 { -value } else { value }, words: 1 + negative, plain, has_pi })
    }

    /// Reads a vector `<x, y, z>` of numbers; `what` describes it in messages.
    ///
    /// # Errors
    /// Something else is found.
    pub fn vector(&mut self, what: &str) -> Result<Placed<[Placed<f64>; 3]>, Reported> {
        let start = self.span();
        if !self.accept(Mark::Less) {
            let diagnostic = Diagnostic::error(format!("expected {what}, found {}", self.kind(0).describe()));
            let help = match self.numbers_ahead()[..] {
                [x, y, z] => format!("write `<{x}, {y}, {z}>`"),
                _ => "vectors are written `<x, y, z>`".to_owned(),
            };
            return Err(self.report(diagnostic.at(start, "a vector belongs here").help(help)));
        }
        let mut components = [Placed { value: 0.0, span: start }; 3];
        for (index, component) in components.iter_mut().enumerate() {
            if index > 0 {
                if self.sees_mark(0, Mark::Greater) {
                    let number = if index == 1 { "one component" } else { "two components" };
                    let diagnostic = Diagnostic::error(format!("{what} has only {number}"));
                    let place = start.to(self.span());
                    return Err(self.report(diagnostic.at(place, "expected three").help("vectors are written `<x, y, z>`")));
                }
                self.expect(Mark::Comma, &format!("between the components of {what}"))?;
            }
            *component = self.number(&format!("a component of {what}"))?;
        }
        if self.sees_mark(0, Mark::Comma) {
            let diagnostic = Diagnostic::error(format!("{what} has more than three components"));
            return Err(self.report(diagnostic.at(self.span(), "expected `>` here").help("vectors are written `<x, y, z>`")));
        }
        self.expect(Mark::Greater, &format!("at the end of {what}"))?;
        Ok(Placed { value: components, span: start.to(self.previous_span()) })
    }

    /// The numbers from the current word on, in parentheses or not, with commas between: `(0, 1, 0)`, `0, 1, 0`.
    pub fn numbers_ahead(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        let mut at = usize::from(self.sees_mark(0, Mark::Open));
        while let Some(ConstantAhead { value, words, .. }) = self.factor_ahead(at) {
            numbers.push(value);
            at += words + usize::from(self.sees_mark(at + words, Mark::Comma));
        }
        numbers
    }
}
