//! The reading position of a parser in a list of words: how words are expected, and how parsing goes on after an error.
//! Numbers and constant vectors are read in `cursor/values.rs`.

mod values;

use crate::lang::ast::Name;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::lexer::{TokenizedText, tokenize};
use crate::lang::source::{Source, SourceSpan};
use crate::lang::token::{Mark, Token, TokenKind};
use crate::lang::variables::{PREDEFINED_SECTION, RESERVED};

/// An error that has been reported; the parser goes on at the next statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reported;

/// A value with its place.
#[derive(Debug, Clone, Copy)]
pub struct Placed<T> {
    /// The value.
    pub value: T,
    /// Its place.
    pub span: SourceSpan,
}

/// A parser's position in the words of a source.
#[derive(Debug)]
pub struct Cursor {
    tokens: Vec<Token>,
    comments: Vec<SourceSpan>,
    at: usize,
    diagnostics: Diagnostics,
    /// How many words were looked at since the last one was read. A test fails when a parser does not go on.
    #[cfg(test)]
    looks: std::cell::Cell<usize>,
}

impl Cursor {
    /// The beginning of a source. Errors in its characters are reported here.
    pub fn new(source: &Source) -> Self {
        let TokenizedText { tokens, comments, diagnostics } = tokenize(source);
        Self {
            tokens,
            comments,
            at: 0,
            diagnostics,
            #[cfg(test)]
            looks: std::cell::Cell::new(0),
        }
    }

    /// Everything that was reported, in the order of places.
    pub fn into_diagnostics(mut self) -> Diagnostics {
        self.diagnostics.sort();
        self.diagnostics
    }

    /// All comments of the source, in order.
    pub fn comments(&self) -> &[SourceSpan] {
        &self.comments
    }

    /// The word `ahead` words after the current one, or the end of the text.
    pub fn peek(&self, ahead: usize) -> &Token {
        #[cfg(test)]
        {
            self.looks.set(self.looks.get() + 1);
            assert!(self.looks.get() < 100_000, "the parser does not get past word {}", self.at);
        }
        // The lexer always ends the list with `End`.
        &self.tokens[(self.at + ahead).min(self.tokens.len() - 1)]
    }

    /// The kind of the word `ahead` words after the current one.
    pub fn kind(&self, ahead: usize) -> &TokenKind {
        &self.peek(ahead).kind
    }

    /// The number of words that have been read.
    pub fn position(&self) -> usize {
        self.at
    }

    /// The place of the current word.
    pub fn span(&self) -> SourceSpan {
        self.peek(0).span
    }

    /// The place of the word before the current one.
    pub fn previous_span(&self) -> SourceSpan {
        self.tokens[self.at.saturating_sub(1)].span
    }

    /// The word before the current one if it is a mark.
    pub fn previous_mark(&self) -> Option<Mark> {
        self.tokens[self.at.saturating_sub(1)].kind.mark()
    }

    /// The word before a `^` before the word that has been read last: `cos` in `cos^2`.
    pub fn function_with_exponent(&self) -> Option<&str> {
        let before = |count: usize| self.at.checked_sub(count).map(|at| &self.tokens[at].kind);
        match (before(3)?, before(2)?) {
            (TokenKind::Word(word), TokenKind::Mark(Mark::Caret)) => Some(word),
            _ => None,
        }
    }

    /// Whether all words have been read.
    pub fn at_end(&self) -> bool {
        self.peek(0).kind == TokenKind::End
    }

    /// Moves past the current word, and returns it.
    pub fn advance(&mut self) -> Token {
        let token = self.peek(0).clone();
        #[cfg(test)]
        self.looks.set(0);
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        token
    }

    /// Whether the word `ahead` words after the current one is this mark.
    pub fn sees_mark(&self, ahead: usize, mark: Mark) -> bool {
        self.peek(ahead).kind == TokenKind::Mark(mark)
    }

    /// The current word if it is a mark.
    pub fn mark(&self) -> Option<Mark> {
        self.peek(0).kind.mark()
    }

    /// The name or keyword `ahead` words after the current one.
    pub fn word(&self, ahead: usize) -> Option<&str> {
        self.peek(ahead).kind.word()
    }

    /// Replaces the current word by this one, and the next by a `;`.
    pub fn rename(&mut self, word: &str) {
        let end = self.tokens.len() - 1;
        self.tokens[self.at.min(end)].kind = TokenKind::Word(word.to_owned());
        if self.at + 1 < end {
            self.tokens[self.at + 1].kind = TokenKind::Mark(Mark::Semicolon);
        }
    }

    /// Replaces the current word by a mark.
    pub fn replace(&mut self, mark: Mark) {
        let end = self.tokens.len() - 1;
        self.tokens[self.at.min(end)].kind = TokenKind::Mark(mark);
    }

    /// Moves past the current word if it is this mark. Whether it is.
    pub fn accept(&mut self, mark: Mark) -> bool {
        let found = self.sees_mark(0, mark);
        if found {
            self.advance();
        }
        found
    }

    /// Moves past the current word if it is this one. Whether it is.
    pub fn accept_word(&mut self, word: &str) -> bool {
        let found = self.word(0) == Some(word);
        if found {
            self.advance();
        }
        found
    }

    /// Whether the current word and the next are the head of a section, `word;`.
    pub fn sees_section(&self) -> bool {
        let head = |word: &str| RESERVED.contains(&word) || word == PREDEFINED_SECTION;
        self.word(0).is_some_and(head) && self.sees_mark(1, Mark::Semicolon)
    }

    /// Reports that something else was expected here.
    pub fn expected(&mut self, what: &str) -> Reported {
        let diagnostic = self.unexpected(what);
        self.report(diagnostic)
    }

    /// The error that something else was expected here, to which the caller can add a hint.
    pub fn unexpected(&self, what: &str) -> Diagnostic {
        let found = self.peek(0).kind.describe();
        Diagnostic::error(format!("expected {what}, found {found}")).at(self.span(), format!("expected {what}"))
    }

    /// Reports an error or a warning, unless the lexer has reported the current word.
    pub fn report(&mut self, diagnostic: Diagnostic) -> Reported {
        if *self.kind(0) != TokenKind::Unknown {
            self.diagnostics.push(diagnostic);
        }
        Reported
    }

    /// Moves past the mark, or reports that it is missing; `context` says where, as in "after the name".
    ///
    /// # Errors
    /// The current word is another one.
    pub fn expect(&mut self, mark: Mark, context: &str) -> Result<(), Reported> {
        if self.accept(mark) {
            return Ok(());
        }
        let found = self.kind(0).describe();
        let missing = Diagnostic::error(format!("expected `{}` {context}, found {found}", mark.spelling()));
        let diagnostic = if mark == Mark::Semicolon {
            // People look for what is missing at the end of something there, not on the next line.
            let end = self.previous_span().end;
            missing.at(SourceSpan { start: end, end }, format!("`;` belongs here, before {found}"))
        } else {
            missing.at(self.span(), "found this")
        };
        Err(self.report(diagnostic))
    }

    /// Moves past the keyword before a value, or reports that it is missing; `context` says where.
    ///
    /// # Errors
    /// The current word is another one.
    pub fn expect_word(&mut self, keyword: &str, context: &str) -> Result<(), Reported> {
        if !self.accept_word(keyword) {
            return Err(self.unknown_word(&format!("`{keyword}` {context}"), &[keyword]));
        }
        self.pass_marks_after(keyword, &[Mark::Colon, Mark::Equal]);
        Ok(())
    }

    /// Reads a name that the text gives to something; `what` describes it in messages, as in "the name of a parameter".
    ///
    /// # Errors
    /// The current word is no name, or a reserved one.
    pub fn name(&mut self, what: &str) -> Result<Name, Reported> {
        let Some(word) = self.word(0) else { return Err(self.expected(what)) };
        let name = Name { text: word.to_owned(), span: self.span() };
        if RESERVED.contains(&word) {
            let diagnostic = Diagnostic::error(format!("`{word}` may not name anything"))
                .at(name.span, format!("expected {what}"))
                .help(format!("the words {} begin sections; choose another name", RESERVED.join(", ")));
            return Err(self.report(diagnostic));
        }
        self.advance();
        Ok(name)
    }

    /// Reports marks between a word and its value, as in `default = 0.5`, and moves past them.
    pub fn pass_marks_after(&mut self, word: &str, marks: &[Mark]) {
        for stray in marks {
            let place = self.span();
            if self.accept(*stray) {
                let diagnostic = Diagnostic::error(format!("no `{}` stands after `{word}`", stray.spelling()));
                self.report(diagnostic.at(place, "leave this out"));
            }
        }
    }

    /// How many errors and warnings there are by now.
    pub fn report_count(&self) -> usize {
        self.diagnostics.len()
    }

    /// Adds a hint to the last report, if there are more than this many.
    pub fn help_since(&mut self, count: usize, hint: &str) {
        if self.diagnostics.len() > count {
            self.diagnostics.help_last(hint);
        }
    }

    /// Reports something in place of what was reported within a span, as about characters that belong to it.
    pub fn report_instead(&mut self, span: SourceSpan, diagnostic: Diagnostic) -> Reported {
        self.diagnostics.remove_within(span);
        self.diagnostics.push(diagnostic);
        Reported
    }

    /// Whether characters that are no word come before the end of the statement. The lexer has reported them.
    pub fn statement_has_unknown(&self) -> bool {
        let rest = self.tokens[self.at..].iter().take_while(|token| token.kind != TokenKind::Mark(Mark::Semicolon));
        rest.into_iter().any(|token| token.kind == TokenKind::Unknown)
    }

    /// The place of the `;` that ends the current statement.
    pub fn statement_end(&self) -> SourceSpan {
        let ends = |token: &&Token| token.kind == TokenKind::Mark(Mark::Semicolon) || token.kind == TokenKind::End;
        self.tokens[self.at..].iter().find(ends).map_or(self.span(), |token| token.span)
    }

    /// Moves past the rest of a statement: past the next `;`, or to the head of the next section.
    pub fn skip_statement(&mut self) {
        while !self.at_end() && !self.sees_section() {
            if self.advance().kind == TokenKind::Mark(Mark::Semicolon) {
                return;
            }
        }
    }

    /// Reports a word that is not known here, with the most similar of the known ones.
    pub fn unknown_word(&mut self, what: &str, known: &[&str]) -> Reported {
        let hint =
            self.word(0).and_then(|word| nearest(word, known.iter().copied())).map(|near| format!("did you mean `{near}`?"));
        let diagnostic = self.unexpected(what).help_if(hint);
        self.report(diagnostic)
    }
}
