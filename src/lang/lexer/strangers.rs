//! Characters that cannot begin a word: what they mean elsewhere, and how the language writes that.

use super::{Lexer, is_blank};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::display_text::is_hidden;
use crate::lang::foreign::marks;
use crate::lang::keywords;
use crate::lang::source::SourceSpan;
use crate::lang::token::{Mark, TokenKind};

/// How many unknown characters a message shows.
const MOST_SHOWN: usize = 20;
/// Characters that are each a word of their own elsewhere.
const SINGLE: &str = "{}[]|\\$@`~?&%";

impl Lexer<'_> {
    /// A run of characters that cannot begin a word.
    pub(super) fn strangers(&mut self, start: usize) {
        if self.rest().starts_with('%') && self.begins_statement() {
            // The rest of the line is most likely a comment.
            let span = SourceSpan::new(start, start + 1);
            self.at = self.line_end(start);
            let error = Diagnostic::error("a `%` does not begin a comment").at(span, "");
            self.found.diagnostics.push(error.help("comments are written `// …` or `/* … */`; the remainder is `mod(x, y)`"));
            return;
        }
        self.at += self.stranger_length();
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

    /// Whether nothing of a statement comes before this place.
    fn begins_statement(&self) -> bool {
        self.found.tokens.last().is_none_or(|token| token.kind == TokenKind::Mark(Mark::Semicolon))
    }

    /// How many bytes belong to one stranger: a bracket, a command of LaTeX, or a run of characters of one kind.
    fn stranger_length(&self) -> usize {
        let known = |character: char| {
            is_blank(character)
                || character.is_ascii_alphanumeric()
                || "_#\"".contains(character)
                || SINGLE.contains(character)
                || Mark::ALL.iter().any(|mark| mark.spelling().starts_with(character))
        };
        let first = self.rest().chars().next().unwrap_or_default();
        if first == '\\' {
            return 1 + self.rest()[1..].bytes().take_while(u8::is_ascii_alphabetic).count();
        }
        if SINGLE.contains(first) {
            return 1;
        }
        // One letter or sign of mathematics has a hint of its own.
        if marks::of_character(first).is_some() {
            return first.len_utf8();
        }
        let ends = |c: char| known(c) || is_hidden(c) != is_hidden(first) || marks::of_character(c).is_some();
        self.rest().char_indices().find(|(offset, c)| *offset > 0 && ends(*c)).map_or(self.rest().len(), |(offset, _)| offset)
    }

    /// Whether these characters belong to others that have been reported, as `]` to `[`, or the `{` of `\frac{1}{2}`.
    fn closes_stranger(&self, text: &str) -> bool {
        let unknown = |token: &&crate::lang::token::Token| token.kind == TokenKind::Unknown;
        let before = |opening: &str| {
            let statement =
                self.found.tokens.iter().rev().take_while(|token| token.kind != TokenKind::Mark(Mark::Semicolon)).filter(unknown);
            statement.into_iter().any(|token| self.text[token.span.range()].starts_with(opening))
        };
        match text {
            "]" => before("["),
            // A block holds statements.
            "}" => self.found.tokens.iter().filter(unknown).any(|token| &self.text[token.span.range()] == "{") || before("\\"),
            "{" => before("\\") || before("{"),
            "|" => before("|"),
            "`" => before("`"),
            "⟩" => before("⟨"),
            "”" => before("“"),
            "’" | "'" => before(text),
            "$" => before("$") || before("\\"),
            _ if text.starts_with('\\') => before("\\") || before("$"),
            _ => false,
        }
    }

    /// How the language writes what these characters mean elsewhere.
    fn stranger_hint(&self, text: &str) -> Option<String> {
        let before = match self.found.tokens.last().map(|token| (&token.kind, token.span)) {
            Some((TokenKind::Word(word), span)) => Some((word.as_str(), span.end as usize == self.at - text.len())),
            Some(_) | None => None,
        };
        let component = || {
            let (before, _) = before.filter(|(_, adjacent)| *adjacent)?;
            let get = match self.rest().chars().next()? {
                '0' => "getx",
                '1' => "gety",
                '2' => "getz",
                _ => return None,
            };
            Some(format!("a component of a vector is written `{get}({before})`"))
        };
        let hint = match text {
            "[" | "{" if let Some(("choices", _)) = before => "choices are written `choices \"one\", \"other\"`",
            "[" if let Some(("constraint", _)) = before => "a range is written `constraint 0..1`",
            "[" => return component().or_else(|| Some("vectors are written `<x, y, z>`, and only `(` `)` group".to_owned())),
            "{" if self.after_caret() => "an exponent is a number or stands in parentheses: `x^5`, `x^(a + 1)`",
            "{" if before.is_some_and(|(word, _)| word.ends_with('_')) => {
                "a name is written `x_i`, and a sum `sum(i, from, to, expression)`"
            }
            "{" if self.begins_block(before.map(|(word, _)| word)) => {
                "there are no blocks: sections begin as in `formula;`, and functions are written `F(x) = expression;`"
            }
            "]" | "{" | "}" => "vectors are written `<x, y, z>`, and only `(` `)` group",
            "∙" | "·" | "×" | "⋅" => "multiplication is `*`, the dot product `.`",
            _ if let Some(command) = text.strip_prefix('\\') => return Some(marks::of_latex(command)),
            _ if let Some(hint) = text.chars().next().and_then(marks::of_character) => return Some(hint),
            _ if text.chars().all(char::is_alphabetic) => "names have the letters A to Z and a to z, digits and `_`",
            _ => return None,
        };
        Some(hint.to_owned())
    }

    fn after_caret(&self) -> bool {
        self.found.tokens.last().is_some_and(|token| token.kind == TokenKind::Mark(Mark::Caret))
    }

    /// Whether a `{` opens a section or the body of a function.
    fn begins_block(&self, before: Option<&str>) -> bool {
        let section = |word: &str| {
            keywords::FORMULA_SECTIONS.iter().chain(&keywords::SCENE_SECTIONS).any(|keyword| keyword.word == word)
                || word == "else"
        };
        let closes = self.found.tokens.last().is_some_and(|token| token.kind == TokenKind::Mark(Mark::Close));
        before.is_some_and(section) || closes
    }
}
