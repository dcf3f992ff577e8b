//! Splits a text into words, by the lexical rules that the formula and the scene language share.
//!
//! The rules of white space, comments, identifiers, `#uses` and punctuation are here, those of numbers in
//! `lexer/numbers.rs`. `lexer/strangers.rs` says what characters mean elsewhere that are no part of the language. The
//! grammar is not here.

mod numbers;
mod strangers;

use crate::lang::colour::{hexadecimal_colour, linear_from_srgb};
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::display_text::is_hidden;
use crate::lang::lines::{LINE_ENDS, line_end};
use crate::lang::source::{BYTE_ORDER_MARK, Source, SourceSpan};
use crate::lang::token::{Mark, Token, TokenKind};

/// A text as words and comments.
#[derive(Debug, Clone, Default)]
pub struct TokenizedText {
    /// The words, with [`TokenKind::End`] after the last. Characters that cannot begin a word are
    /// [`TokenKind::Unknown`].
    pub tokens: Vec<Token>,
    /// The comments, in order, each with the marks that begin and end it.
    pub comments: Vec<SourceSpan>,
    /// What is wrong with the characters.
    pub diagnostics: Diagnostics,
}

/// The words and the comments of a text.
pub fn tokenize(source: &Source) -> TokenizedText {
    let mut lexer = Lexer { text: source.text(), at: 0, found: TokenizedText::default() };
    lexer.run();
    lexer.found
}

struct Lexer<'s> {
    text: &'s str,
    at: usize,
    found: TokenizedText,
}

impl Lexer<'_> {
    fn run(&mut self) {
        if self.rest().starts_with(BYTE_ORDER_MARK) {
            self.at += BYTE_ORDER_MARK.len_utf8();
        }
        loop {
            self.skip_blanks();
            let Some(first) = self.rest().chars().next() else { break };
            let start = self.at;
            if first.is_ascii_digit() || (first == '.' && self.digit_at(self.at + 1)) {
                self.number(start);
            } else if first.is_ascii_alphabetic() || first == '_' {
                self.at += self.run_length(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
                let word = self.text[start..self.at].to_owned();
                self.push(TokenKind::Word(word), start);
            } else if first == '#' {
                self.number_sign(start);
            } else if first == '"' {
                self.quoted(start);
            } else if self.rest().starts_with("...") {
                self.three_dots(start);
            } else if let Some(mark) = Mark::ALL.iter().find(|mark| self.rest().starts_with(mark.spelling())) {
                self.at += mark.spelling().len();
                self.push(TokenKind::Mark(*mark), start);
            } else {
                self.strangers(start);
            }
        }
        self.push(TokenKind::End, self.at);
    }

    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn digit_at(&self, at: usize) -> bool {
        self.text.as_bytes().get(at).is_some_and(u8::is_ascii_digit)
    }

    /// Where the line that holds `at` ends, before its line end.
    fn line_end(&self, at: usize) -> usize {
        line_end(self.text.as_bytes(), at)
    }

    /// How many bytes from here on satisfy `accept`.
    fn run_length(&self, accept: impl Fn(u8) -> bool) -> usize {
        self.rest().bytes().take_while(|&byte| accept(byte)).count()
    }

    fn push(&mut self, kind: TokenKind, start: usize) {
        let before = self.found.tokens.last().map_or(0, |token| token.span.end as usize);
        let begins_line = self.found.tokens.is_empty() || self.text[before.min(start)..start].contains(LINE_ENDS);
        self.found.tokens.push(Token { kind, span: SourceSpan::new(start, self.at), begins_line });
    }

    fn skip_blanks(&mut self) {
        loop {
            let blanks = self.rest().len() - self.rest().trim_start_matches(is_blank).len();
            self.at += blanks;
            let start = self.at;
            if self.rest().starts_with("//") {
                self.at = self.line_end(self.at);
            } else if self.rest().starts_with("/*") {
                match self.rest()[2..].find("*/") {
                    Some(end) => self.at += 2 + end + 2,
                    None => {
                        self.found.diagnostics.push(
                            Diagnostic::error("a comment is not closed")
                                .at(SourceSpan::new(self.at, self.at + 2), "it begins here and goes on to the end of the file")
                                .help("end it with `*/`; a comment of one line can begin with `//`"),
                        );
                        self.at = self.text.len();
                    }
                }
            } else if blanks == 0 {
                return;
            }
            if self.at > start {
                self.found.comments.push(SourceSpan::new(start, self.at));
            }
        }
    }

    /// `#uses PATH;`, or something that only begins like it.
    fn number_sign(&mut self, start: usize) {
        self.at += 1;
        let word = self.run_length(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        if &self.text[self.at..self.at + word] == "uses" {
            self.uses(start, word);
            return;
        }
        let name = &self.text[self.at..self.at + word];
        let colour = hexadecimal_colour(name);
        let message = match colour {
            _ if name.is_empty() => "a stray `#`".to_owned(),
            Some(_) => format!("colours are not written `#{name}`"),
            None => format!("`#{name}` has no meaning"),
        };
        let hint = match colour {
            Some(stored) => {
                let [red, green, blue] = stored.map(|stored| (linear_from_srgb(stored) * 1000.0).round() / 1000.0);
                format!("write `<{red}, {green}, {blue}>`: the same colour as linear red, green and blue, each 0..1")
            }
            None => match name {
                "define" => "a constant is a macro under `formula;`: `NAME = 3.14;`".to_owned(),
                "include" | "import" | "version" | "pragma" => "all functions of the language are there without it".to_owned(),
                _ if nearest(name, ["uses"]).is_some() => "did you mean `#uses FILE;`?".to_owned(),
                _ => "only `#uses FILE;` begins with `#`; comments are written `// …` or `/* … */`".to_owned(),
            },
        };
        let span = SourceSpan::new(start, self.at + word);
        self.at += word;
        self.found.diagnostics.push(Diagnostic::error(message).at(span, "").help(hint));
        if colour.is_some() {
            self.push(TokenKind::Unknown, start);
        } else {
            // The rest of the line is most likely a comment.
            self.at = self.line_end(start);
        }
    }

    /// The path of `#uses` is raw text up to the `;` on the same line.
    fn uses(&mut self, start: usize, word: usize) {
        self.at += word;
        let line_end = self.line_end(self.at);
        let (path_end, next) = match self.text[self.at..line_end].find(';') {
            Some(length) => (self.at + length, self.at + length + 1),
            None => {
                self.found.diagnostics.push(
                    Diagnostic::error("`#uses` has no `;` at the end of its line")
                        .at(SourceSpan::new(start, start + "#uses".len()), "")
                        .help("write `#uses FILE;` on one line"),
                );
                (line_end, line_end)
            }
        };
        let raw = &self.text[self.at..path_end];
        let path = raw.trim();
        let path_start = self.at + (raw.len() - raw.trim_start().len());
        let path_span = SourceSpan::new(path_start, path_start + path.len());
        self.at = next;
        self.push(TokenKind::Uses(path.to_owned(), path_span), start);
    }

    /// `"text"`, on one line.
    fn quoted(&mut self, start: usize) {
        let line_end = self.line_end(start);
        let inner = start + 1;
        let Some(length) = self.text[inner..line_end].find('"') else {
            self.at = line_end;
            self.found.diagnostics.push(
                Diagnostic::error("a text in quotation marks is not closed")
                    .at(SourceSpan::new(start, inner), "it begins here")
                    .help("end it with `\"` on the same line"),
            );
            self.push(TokenKind::Unknown, start);
            return;
        };
        self.at = inner + length + 1;
        let text = self.text[inner..inner + length].to_owned();
        self.push(TokenKind::Text(text), start);
    }
}

/// Whether a character separates words.
fn is_blank(character: char) -> bool {
    character.is_whitespace() && (!is_hidden(character) || matches!(character, '\t' | '\r' | '\n'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(text: &str) -> Vec<TokenKind> {
        let TokenizedText { tokens, diagnostics, .. } = tokenize(&Source::new("t", text));
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        tokens.into_iter().map(|token| token.kind).collect()
    }

    fn word(text: &str) -> TokenKind {
        TokenKind::Word(text.to_owned())
    }

    #[test]
    fn numbers_and_dots_part_as_the_language_says() {
        use TokenKind::{End, Mark as M, Number};
        assert_eq!(kinds("0..1"), [Number(0.0), M(Mark::DotDot), Number(1.0), End]);
        assert_eq!(kinds("0.. .5"), [Number(0.0), M(Mark::DotDot), Number(0.5), End]);
        assert_eq!(kinds("N.L"), [word("N"), M(Mark::Dot), word("L"), End]);
        assert_eq!(kinds("1.N"), [Number(1.0), word("N"), End]);
        assert_eq!(kinds("1.5e-3 .25 2.E1"), [Number(1.5e-3), Number(0.25), Number(20.0), End]);
    }

    #[test]
    fn blanks_comments_and_bom_part_words() {
        assert_eq!(kinds("\u{feff}a/* * / */b // c\r\nd"), [word("a"), word("b"), word("d"), TokenKind::End]);
    }

    #[test]
    fn a_comment_and_uses_end_with_their_line() {
        for end in ["\n", "\r\n", "\r"] {
            assert_eq!(kinds(&format!("// a \u{85} \u{2028} b{end}c")), [word("c"), TokenKind::End], "{end:?}");
            let TokenizedText { tokens, diagnostics, .. } =
                tokenize(&Source::new("t", format!("#uses x{end}; a{end}b // c{end}d")));
            assert_eq!(diagnostics.len(), 1, "`;` is on the next line: {diagnostics:?}");
            let begins: Vec<bool> = tokens.iter().map(|token| token.begins_line).collect();
            assert_eq!(begins, [true, true, false, true, true, false], "{end:?} {tokens:?}");
        }
    }

    #[test]
    fn the_path_of_uses_is_raw() {
        let tokens = kinds("#uses  my dir/a//b.txt ;x");
        assert!(matches!(&tokens[0], TokenKind::Uses(path, _) if path == "my dir/a//b.txt"));
        assert_eq!(tokens[1], word("x"));
    }

    #[test]
    fn numbers_of_other_languages_are_reported_once_and_read() {
        let cases =
            [("1.0f", 1.0), ("0x10", 16.0), ("0b101", 5.0), ("1e", 1.0), ("1_000", 1000.0), ("40deg", 40.0), ("50%", 50.0)];
        for (text, value) in cases {
            let TokenizedText { tokens, diagnostics, .. } = tokenize(&Source::new("t", text));
            assert_eq!(tokens.len(), 2, "{text}");
            assert_eq!(tokens[0].kind, TokenKind::Number(value), "{text}");
            assert_eq!(diagnostics.len(), 1, "{text}");
        }
        // Parameters may have these names.
        for text in ["2h", "3kd", "2.N", "1 f", "5 % 2"] {
            let TokenizedText { tokens, .. } = tokenize(&Source::new("t", text));
            assert!(tokens.len() > 2, "{text}");
        }
    }

    #[test]
    fn three_dots_are_refused() {
        let TokenizedText { tokens, diagnostics, .. } = tokenize(&Source::new("t", "0...5"));
        assert_eq!(tokens[1].kind, TokenKind::Mark(Mark::DotDot));
        assert_eq!(diagnostics.len(), 1);
    }

    #[test]
    fn strangers_are_reported_and_passed_over() {
        let TokenizedText { tokens, diagnostics, .. } = tokenize(&Source::new("t", "a & b § c $$ d | e"));
        assert_eq!(tokens.iter().filter(|token| token.kind == TokenKind::Unknown).count(), 5);
        assert_eq!(tokens.len(), 11);
        assert_eq!(diagnostics.len(), 4, "{diagnostics:?}");
    }

    #[test]
    fn an_open_comment_is_an_error_at_its_beginning() {
        let TokenizedText { diagnostics, .. } = tokenize(&Source::new("t", "a /* b"));
        assert_eq!(diagnostics.iter().next().and_then(Diagnostic::span), Some(SourceSpan::new(2, 4)));
    }
}
