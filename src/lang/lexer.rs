//! Splits a text into words, by the lexical rules that the formula and the scene language share.
//!
//! The rules of white space, comments, numbers, identifiers, `#uses` and punctuation are here; the grammar is not.

use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::display_text::is_hidden;
use crate::lang::lines::{LINE_ENDS, line_end};
use crate::lang::source::{BYTE_ORDER_MARK, Source, SourceSpan};
use crate::lang::token::{Mark, Token, TokenKind};

/// How many unknown characters a message shows.
const MOST_SHOWN: usize = 20;

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

    /// `digits`, `digits.digits`, `.digits`, or `digits.` if no other dot follows; then an optional exponent.
    fn number(&mut self, start: usize) {
        let digits = |byte: u8| byte.is_ascii_digit();
        self.at += self.run_length(digits);
        if self.rest().starts_with('.') && !self.rest().starts_with("..") {
            self.at += 1;
            self.at += self.run_length(digits);
        }
        if self.rest().starts_with(['e', 'E']) {
            let sign = usize::from(self.rest()[1..].starts_with(['+', '-']));
            if self.digit_at(self.at + 1 + sign) {
                self.at += 1 + sign;
                self.at += self.run_length(digits);
            }
        }
        // Rust can read every text of this form.
        let value = self.text[start..self.at].parse::<f64>().unwrap_or(f64::INFINITY);
        if value.is_infinite() {
            self.found.diagnostics.push(
                Diagnostic::error("this number is too large")
                    .at(SourceSpan::new(start, self.at), "larger than the largest number")
                    .help(format!("numbers go up to about {:e}", f32::MAX)),
            );
        }
        self.push(if value.is_finite() { TokenKind::Number(value) } else { TokenKind::Unknown }, start);
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
        let colour = colour(name);
        let message = match colour {
            _ if name.is_empty() => "a stray `#`".to_owned(),
            Some(_) => format!("colours are not written `#{name}`"),
            None => format!("`#{name}` has no meaning"),
        };
        let hint = match colour {
            Some([red, green, blue]) => format!("write `<{red}, {green}, {blue}>`: red, green and blue, each 0..1"),
            None => "only `#uses FILE;` begins with `#`; comments are written `// …` or `/* … */`".to_owned(),
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

    /// A run of characters that cannot begin a word.
    fn strangers(&mut self, start: usize) {
        let known = |character: char| {
            is_blank(character)
                || character.is_ascii_alphanumeric()
                || "_#\"".contains(character)
                || Mark::ALL.iter().any(|mark| mark.spelling().starts_with(character))
        };
        let first_hidden = self.rest().chars().next().is_some_and(is_hidden);
        self.at += self
            .rest()
            .char_indices()
            .find(|(offset, c)| *offset > 0 && (known(*c) || is_hidden(*c) != first_hidden))
            .map_or(self.rest().len(), |(offset, _)| offset);
        let text = &self.text[start..self.at];
        let span = SourceSpan::new(start, self.at);
        if self.closes_stranger(text) {
            self.push(TokenKind::Unknown, start);
            return;
        }
        let diagnostic = match text.chars().next().filter(|first| is_hidden(*first)) {
            Some(hidden) => Diagnostic::error(format!("an invisible character, U+{:04X}, is in the text", u32::from(hidden)))
                .at(span, "here")
                .help("delete it; it probably came with a copied text"),
            None => {
                let shown: String = text.chars().take(MOST_SHOWN).collect();
                let rest = if shown.len() < text.len() { "…" } else { "" };
                Diagnostic::error(format!("`{shown}{rest}` is not part of the language"))
                    .at(span, "not understood")
                    .help_if(self.stranger_hint(text))
            }
        };
        self.found.diagnostics.push(diagnostic);
        self.push(TokenKind::Unknown, start);
    }

    /// Whether these characters close what others that have been reported opened, as `]` after `[`.
    fn closes_stranger(&self, text: &str) -> bool {
        let opening = match text {
            "]" | "]]" => "[",
            "}" => "{",
            "|" | "||" => "|",
            "”" => "“",
            "’" | "'" => text,
            _ => return false,
        };
        let statement = self.found.tokens.iter().rev().take_while(|token| token.kind != TokenKind::Mark(Mark::Semicolon));
        let mut unknown = statement.filter(|token| token.kind == TokenKind::Unknown);
        unknown.any(|token| &self.text[token.span.range()] == opening)
    }

    /// How the language writes what these characters mean elsewhere.
    fn stranger_hint(&self, text: &str) -> Option<String> {
        let component = || {
            let before = match &self.found.tokens.last()?.kind {
                TokenKind::Word(word) => word.as_str(),
                TokenKind::Number(_)
                | TokenKind::Uses(..)
                | TokenKind::Text(_)
                | TokenKind::Mark(_)
                | TokenKind::Unknown
                | TokenKind::End => return None,
            };
            let get = match self.rest().chars().next()? {
                '0' => "getx",
                '1' => "gety",
                '2' => "getz",
                _ => return None,
            };
            Some(format!("a component of a vector is written `{get}({before})`"))
        };
        let hint = match text {
            "&" => "the logical operators are `&&`, `||` and `!`",
            "|" => "the absolute value is `abs(x)`, a vector's length `length(v)`; the logical operators are `&&`, `||` and `!`",
            "?" => "a choice is written `if(condition, then, else)`",
            "%" => "the remainder is `mod(x, y)`",
            "²" | "³" | "⁴" | "⁵" => "powers are written `x^2`",
            "√" => "the square root is `sqrt(x)`",
            "≤" => "write `<=`",
            "≥" => "write `>=`",
            "≠" => "write `!=`",
            "−" | "–" | "—" => "the minus sign is `-`",
            "×" | "·" | "∙" | "⋅" => "multiplication is `*`, the dot product `.`",
            "÷" => "division is `/`",
            "“" | "”" | "„" | "‘" | "’" | "'" => "quotation marks are written `\"`",
            "α" | "β" | "γ" | "π" => "the angles are written `alpha`, `beta`, `gamma`, and π is `pi`",
            "[" => return component().or_else(|| Some("vectors are written `<x, y, z>`, and only `(` `)` group".to_owned())),
            "]" | "{" | "}" => "vectors are written `<x, y, z>`, and only `(` `)` group",
            _ if text.chars().all(char::is_alphabetic) => "names have the letters A to Z and a to z, digits and `_`",
            _ => return None,
        };
        Some(hint.to_owned())
    }
}

/// Whether a character separates words.
fn is_blank(character: char) -> bool {
    character.is_whitespace() && (!is_hidden(character) || matches!(character, '\t' | '\r' | '\n'))
}

/// The colour that `#rgb` or `#rrggbb` means elsewhere: red, green and blue, 0..1, rounded to three digits.
fn colour(digits: &str) -> Option<[f64; 3]> {
    let step = match digits.len() {
        3 => 1,
        6 => 2,
        _ => return None,
    };
    let component = |index: usize| {
        let value = u32::from_str_radix(digits.get(step * index..step * (index + 1))?, 16).ok()?;
        let largest = if step == 1 { 15.0 } else { 255.0 };
        Some((f64::from(value) / largest * 1000.0).round() / 1000.0)
    };
    Some([component(0)?, component(1)?, component(2)?])
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
        assert_eq!(kinds("0...5"), [Number(0.0), M(Mark::DotDot), Number(0.5), End]);
        assert_eq!(kinds("N.L"), [word("N"), M(Mark::Dot), word("L"), End]);
        assert_eq!(kinds("1.N"), [Number(1.0), word("N"), End]);
        assert_eq!(kinds("1.5e-3 .25 2.E1 7e"), [Number(1.5e-3), Number(0.25), Number(20.0), Number(7.0), word("e"), End]);
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
    fn strangers_are_reported_and_passed_over() {
        let TokenizedText { tokens, diagnostics, .. } = tokenize(&Source::new("t", "a & b § c $$ d | e"));
        assert_eq!(tokens.iter().filter(|token| token.kind == TokenKind::Unknown).count(), 4);
        assert_eq!(tokens.len(), 10);
        assert_eq!(diagnostics.len(), 4, "{diagnostics:?}");
    }

    #[test]
    fn an_open_comment_is_an_error_at_its_beginning() {
        let TokenizedText { diagnostics, .. } = tokenize(&Source::new("t", "a /* b"));
        assert_eq!(diagnostics.iter().next().and_then(Diagnostic::span), Some(SourceSpan::new(2, 4)));
    }
}
