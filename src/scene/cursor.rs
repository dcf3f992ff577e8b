//! The reader's place in the words of a scene, and the small things that stand everywhere in it: marks, keywords, numbers,
//! vectors. What a scene consists of is the parser's business.

use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::source::Span;
use crate::lang::token::{Mark, Token, TokenKind};
use crate::scene::MAX_COORDINATE;
use glam::DVec3;

/// Says that an error was reported and the rest of the declaration cannot be read.
#[derive(Debug)]
pub(super) struct Lost;

/// A value and where it stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed<T> {
    pub(super) value: T,
    pub(super) span: Span,
}

/// The words, how many of them are read, and what was wrong with them.
pub(super) struct Cursor {
    tokens: Vec<Token>,
    at: usize,
    diagnostics: Diagnostics,
}

impl Cursor {
    /// At the first of `tokens`, which must be ended by [`TokenKind::End`] as the lexer does.
    pub(super) fn new(tokens: Vec<Token>, diagnostics: Diagnostics) -> Self {
        Self { tokens, at: 0, diagnostics }
    }

    /// What was wrong, in the order of places.
    pub(super) fn into_diagnostics(mut self) -> Diagnostics {
        self.diagnostics.sort();
        self.diagnostics
    }

    /// How many words are read.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    fn token(&self, ahead: usize) -> Option<&Token> {
        self.tokens.get(self.at + ahead).or(self.tokens.last())
    }

    /// The word `ahead` words from here; behind the last one, the end.
    pub(super) fn kind(&self, ahead: usize) -> &TokenKind {
        self.token(ahead).map_or(&TokenKind::End, |token| &token.kind)
    }

    /// Where the next word stands.
    pub(super) fn span(&self) -> Span {
        self.token(0).map_or(Span::default(), |token| token.span)
    }

    /// Where the last word read stands.
    fn span_before(&self) -> Span {
        self.at.checked_sub(1).and_then(|before| self.tokens.get(before)).map_or(self.span(), |token| token.span)
    }

    /// Passes over the next word, unless it is the end.
    pub(super) fn advance(&mut self) {
        if *self.kind(0) != TokenKind::End {
            self.at += 1;
        }
    }

    /// Reports an error or a warning.
    pub(super) fn report(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// The next word, if it is an identifier.
    pub(super) fn word(&self) -> Option<&str> {
        self.word_ahead(0)
    }

    /// The word `ahead` words from here, if it is an identifier.
    pub(super) fn word_ahead(&self, ahead: usize) -> Option<&str> {
        match self.kind(ahead) {
            TokenKind::Word(word) => Some(word),
            TokenKind::Number(_) | TokenKind::Uses(..) | TokenKind::Mark(_) | TokenKind::End => None,
        }
    }

    /// Whether the word `ahead` words from here is that mark.
    pub(super) fn mark_ahead(&self, ahead: usize, mark: Mark) -> bool {
        *self.kind(ahead) == TokenKind::Mark(mark)
    }

    /// Passes over the mark, if it is next.
    pub(super) fn accept(&mut self, mark: Mark) -> bool {
        let there = self.mark_ahead(0, mark);
        if there {
            self.advance();
        }
        there
    }

    /// Passes over the mark, or reports that it is missing `place`: "after the name", say.
    pub(super) fn expect(&mut self, mark: Mark, place: &str) -> Result<(), Lost> {
        if self.accept(mark) {
            return Ok(());
        }
        let found = self.kind(0).describe();
        let missing = Diagnostic::error(format!("expected `{}` {place}, found {found}", mark.spelling()));
        let diagnostic = if mark == Mark::Semicolon {
            // What is missing at the end of something is looked for there, not on the next line.
            let end = self.span_before().end;
            missing.at(Span { start: end, end }, format!("`;` belongs here, before {found}"))
        } else {
            missing.at(self.span(), "found this")
        };
        self.report(diagnostic);
        Err(Lost)
    }

    /// Passes over the keyword, or reports that it is missing `place`.
    pub(super) fn expect_word(&mut self, keyword: &str, place: &str) -> Result<(), Lost> {
        if self.word() == Some(keyword) {
            self.advance();
            return Ok(());
        }
        let hint = self.word().and_then(|word| nearest(word, [keyword])).map(|near| format!("did you mean `{near}`?"));
        let message = format!("expected `{keyword}` {place}, found {}", self.kind(0).describe());
        self.report(Diagnostic::error(message).at(self.span(), "found this").help_if(hint));
        Err(Lost)
    }

    /// A number with an optional minus sign; `what` names it in messages.
    pub(super) fn number(&mut self, what: &str) -> Result<Placed<f64>, Lost> {
        let start = self.span();
        let negative = self.accept(Mark::Minus);
        let TokenKind::Number(value) = *self.kind(0) else {
            let diagnostic = Diagnostic::error(format!("expected {what}, found {}", self.kind(0).describe()));
            self.report(diagnostic.at(self.span(), "a number belongs here"));
            return Err(Lost);
        };
        let span = start.to(self.span());
        self.advance();
        Ok(Placed { value: if negative { -value } else { value }, span })
    }

    /// A vector `<x, y, z>` of numbers up to [`MAX_COORDINATE`]; `what` names it in messages. A component beyond is reported,
    /// and NaN in the value, which no shape and no camera accepts: so it does not lead to further errors.
    pub(super) fn vector(&mut self, what: &str) -> Result<Placed<DVec3>, Lost> {
        let start = self.span();
        if !self.accept(Mark::Less) {
            let diagnostic = Diagnostic::error(format!("expected {what}, found {}", self.kind(0).describe()));
            self.report(diagnostic.at(start, "a vector belongs here").help("vectors are written `<x, y, z>`"));
            return Err(Lost);
        }
        let mut components = [0.0; 3];
        for (place, component) in components.iter_mut().enumerate() {
            if place > 0 {
                self.expect(Mark::Comma, &format!("between the components of {what}"))?;
            }
            let number = self.number(&format!("a component of {what}"))?;
            if number.value.abs() > MAX_COORDINATE {
                let diagnostic = Diagnostic::error(format!("a component of {what} is too large"));
                self.report(diagnostic.at(number.span, format!("scenes reach from {:e} to {MAX_COORDINATE:e}", -MAX_COORDINATE)));
                *component = f64::NAN;
            } else {
                *component = number.value;
            }
        }
        let end = self.span();
        if self.mark_ahead(0, Mark::Comma) {
            let diagnostic = Diagnostic::error(format!("{what} has more than three components"));
            self.report(diagnostic.at(end, "expected `>`").help("vectors are written `<x, y, z>`"));
            return Err(Lost);
        }
        self.expect(Mark::Greater, &format!("after the three components of {what}"))?;
        Ok(Placed { value: DVec3::from(components), span: start.to(end) })
    }
}
