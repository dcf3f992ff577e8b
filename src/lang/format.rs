//! Gives the text of a formula or a scene a regular layout: each statement on its own line, with regular spaces.
//!
//! Only spaces and line breaks change. Every word and every comment stays, in its order. Both languages have the same
//! lexical rules, so one layout serves both:
//!
//! - Each statement begins a line. Line breaks inside a statement stay, and so does the indentation behind them.
//! - Of several blank lines, one stays. All lines end as the first one does.
//! - Declarations are indented as the first one is, heads of sections are not.
//! - `=`, types and comments that the author has put in one column stay in one column, see `alignment`.
//! - Spaces are set by the rules of `spacing`.

mod alignment;
mod spacing;

use crate::lang::diagnostic::Diagnostics;
use crate::lang::lexer::{TokenizedText, tokenize};
use crate::lang::lines::{LINE_ENDS, LineEnd, count_line_ends, line_start, with_line_feeds};
use crate::lang::source::{BYTE_ORDER_MARK, Source, SourceSpan};
use crate::lang::token::{Mark, Token, TokenKind};
use alignment::{FormattedLine, Stop, StopKind, written};
use spacing::{WordPlacement, placements, separated};

/// The indentation of a continued statement whose author gave it none.
const CONTINUATION: usize = 4;
/// The most spaces by which declarations are indented.
const MOST_INDENTATION: usize = 8;
/// The spaces for which a tab counts.
const TAB: usize = 4;

/// The text with its layout made regular. Formatting the result again does not change it.
///
/// Meant for texts without errors of syntax: the layout follows the statements.
///
/// # Errors
/// What is wrong with the characters of the text, if something is. Such a text has parts that are no words.
pub fn formatted(source: &Source) -> Result<String, Diagnostics> {
    let TokenizedText { mut tokens, comments, diagnostics } = tokenize(source);
    if diagnostics.has_errors() {
        return Err(diagnostics);
    }
    tokens.pop();
    let text = source.text();
    let placements = placements(text, &tokens);
    let mut layout = LayoutWriter {
        text,
        indent: indentation_of_declarations(text, &tokens),
        lines: Vec::new(),
        before: None,
        statement: None,
        comment_column: None,
    };
    let items = items(&tokens, &comments);
    for (at, item) in items.iter().enumerate() {
        match *item {
            WordOrComment::Token(index) => layout.token(&tokens[index], &placements[index]),
            WordOrComment::Comment(span) => {
                let next = items.get(at + 1).map(|next| next.span(&tokens).start);
                layout.comment(span, next);
            }
        }
    }
    let end = LineEnd::first_in(text).text();
    let mark = if text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.to_string() } else { String::new() };
    // Comments of several lines have line ends of their own.
    Ok(mark + &with_line_feeds(&written(layout.lines)).replace('\n', end))
}

/// A word or a comment.
#[derive(Debug, Clone, Copy)]
enum WordOrComment {
    /// The index of a token.
    Token(usize),
    Comment(SourceSpan),
}

impl WordOrComment {
    fn span(self, tokens: &[Token]) -> SourceSpan {
        match self {
            WordOrComment::Token(index) => tokens[index].span,
            WordOrComment::Comment(span) => span,
        }
    }
}

/// The words and the comments in the order of the text.
fn items(tokens: &[Token], comments: &[SourceSpan]) -> Vec<WordOrComment> {
    let mut items: Vec<WordOrComment> = (0..tokens.len()).map(WordOrComment::Token).collect();
    items.extend(comments.iter().map(|comment| WordOrComment::Comment(*comment)));
    items.sort_by_key(|item| item.span(tokens).start);
    items
}

/// What stands before an item.
#[derive(Debug, Clone, Copy)]
struct Before {
    /// Offset of its end.
    end: usize,
    /// How it is placed; `None` for a comment.
    placement: Option<WordPlacement>,
    /// Whether the line of it may go on with a word.
    open: bool,
}

/// A statement that has begun.
#[derive(Debug, Clone, Copy)]
struct Statement {
    /// The indentation of its first line in the source, and now.
    indents: [usize; 2],
    /// How many words it has so far.
    words: usize,
    /// How many lines there were when it began, with its own.
    line: usize,
}

struct LayoutWriter<'s> {
    text: &'s str,
    /// The indentation of declarations.
    indent: usize,
    lines: Vec<FormattedLine>,
    before: Option<Before>,
    statement: Option<Statement>,
    /// The column in the source of the comment behind a line, if the last item was one. It goes on in lines below with
    /// nothing but a comment in this column.
    comment_column: Option<usize>,
}

impl LayoutWriter<'_> {
    /// The line ends between the last item and an offset.
    fn breaks(&self, start: usize) -> usize {
        self.before.map_or(0, |before| count_line_ends(&self.text.as_bytes()[before.end..start]))
    }

    /// The column of an offset in the source, in characters from 0.
    fn column(&self, at: usize) -> usize {
        let line = &self.text[line_start(self.text.as_bytes(), at)..at];
        line.trim_start_matches(BYTE_ORDER_MARK).chars().count()
    }

    fn token(&mut self, token: &Token, placement: &WordPlacement) {
        let (start, end) = (token.span.range().start, token.span.range().end);
        let breaks = self.breaks(start);
        let behind_comment = self.before.is_some_and(|before| before.placement.is_none());
        let ends = matches!(token.kind, TokenKind::Mark(Mark::Semicolon));
        if let Some(mut statement) = self.statement {
            let closed = self.before.is_none_or(|before| !before.open);
            if closed || (breaks > 0 && !ends) {
                self.begin_continuation(start, statement);
            } else {
                self.space(token, placement);
                self.stop(&statement, placement, start);
            }
            statement.words += 1;
            self.statement = Some(statement);
        } else {
            // A comment before the statement on its line stays there.
            let goes_on = behind_comment && breaks == 0 && self.before.is_some_and(|before| before.open);
            if goes_on {
                self.push(" ");
            } else {
                let indent = if placement.is_head { 0 } else { self.indent };
                self.begin_line(indent, breaks > 1);
            }
            let line = self.lines.last();
            let first = line.and_then(|line| line.source_start).unwrap_or(start);
            let indents = [indentation(self.text, first), line.map_or(0, |line| line.indent)];
            self.statement = Some(Statement { indents, words: 1, line: self.lines.len() });
        }
        match &token.kind {
            TokenKind::Uses(path, _) => self.push(&format!("#uses {path};")),
            TokenKind::Number(_) | TokenKind::Word(_) | TokenKind::Text(_) | TokenKind::Mark(_) | TokenKind::Unknown => {
                self.push(&self.text[start..end]);
            }
            TokenKind::End => {}
        }
        if ends || matches!(token.kind, TokenKind::Uses(..)) {
            self.statement = None;
        }
        self.before = Some(Before { end, placement: Some(*placement), open: true });
        self.comment_column = None;
        if let Some(line) = self.lines.last_mut().filter(|line| line.source_start.is_none()) {
            line.source_start = Some(start);
        }
    }

    fn comment(&mut self, span: SourceSpan, next: Option<u32>) {
        let (start, end) = (span.range().start, span.range().end);
        let written = self.text[start..end].trim_end_matches([' ', '\t']);
        let breaks = self.breaks(start);
        let column = self.column(start);
        let breaks_behind =
            next.is_none_or(|next| self.text[end..next as usize].contains(LINE_ENDS)) || written.starts_with("//");
        let mut open = !breaks_behind;
        match self.before {
            Some(before) if breaks == 0 => {
                let gap = self.text[before.end..start].chars().count();
                if self.comment_column.is_some() {
                    self.lines.last_mut().and_then(|line| line.comment.as_mut()).into_iter().for_each(|comment| {
                        comment.text.push(' ');
                        comment.text.push_str(written);
                    });
                    open = false;
                } else if before.placement.is_some() && (breaks_behind || self.statement.is_none()) {
                    if let Some(line) = self.lines.last_mut() {
                        line.put_behind(written, column, gap);
                    }
                    self.comment_column = Some(column);
                    open = false;
                } else {
                    let tight = before.placement.is_some_and(|placement| placement.opens());
                    self.push(if tight { "" } else { " " });
                    self.push(written);
                }
            }
            Some(_) if breaks == 1 && self.comment_column == Some(column) && (breaks_behind || self.statement.is_none()) => {
                let mut line = FormattedLine::new(0, false);
                line.put_behind(written, column, usize::MAX);
                self.lines.push(line);
                open = false;
            }
            Some(_) | None => {
                match self.statement {
                    Some(statement) => self.begin_continuation(start, statement),
                    None => {
                        let indent = if indentation(self.text, start) == 0 { 0 } else { self.indent };
                        self.begin_line(indent, breaks > 1);
                    }
                }
                self.push(written);
                self.comment_column = None;
            }
        }
        if let Some(line) = self.lines.last_mut().filter(|line| line.source_start.is_none()) {
            line.source_start = Some(start);
        }
        self.before = Some(Before { end, placement: None, open });
    }

    fn push(&mut self, text: &str) {
        if let Some(line) = self.lines.last_mut() {
            line.text.push_str(text);
        }
    }

    fn begin_line(&mut self, indent: usize, blank_above: bool) {
        self.lines.push(FormattedLine::new(indent, blank_above && !self.lines.is_empty()));
    }

    /// Begins a line inside a statement, as far to the right of its first line as in the source.
    fn begin_continuation(&mut self, start: usize, statement: Statement) {
        let [source, now] = statement.indents;
        let deeper = indentation(self.text, start).saturating_sub(source);
        self.begin_line(now + if deeper == 0 { CONTINUATION } else { deeper }, false);
    }

    /// Puts a space before a word on its line if there must be one.
    fn space(&mut self, token: &Token, placement: &WordPlacement) {
        let Some(before) = self.before else { return };
        let wanted = match before.placement {
            Some(left) => separated(&left, placement),
            None => !placement.hugs_comment(),
        };
        let Some(line) = self.lines.last_mut() else { return };
        let must = || {
            let word = &self.text[token.span.range()];
            before.placement.is_some_and(|left| spacing::would_merge(&self.text[left.start..before.end], word))
        };
        if !line.text.is_empty() && (wanted || must()) {
            line.text.push(' ');
        }
    }

    /// Remembers the column of what follows the name of a statement.
    fn stop(&mut self, statement: &Statement, placement: &WordPlacement, start: usize) {
        let Some(before) = self.before else { return };
        let left = before.placement;
        let kind = match left {
            _ if placement.is_definition => StopKind::Equal,
            Some(left) if left.is_colon() && statement.words == 2 => StopKind::Type,
            Some(_) | None => return,
        };
        let column = self.column(start);
        let gap = self.text[before.end..start].chars().count();
        if self.lines.len() != statement.line {
            return;
        }
        if let Some(line) = self.lines.last_mut().filter(|line| line.stop.is_none() && !line.text.contains(LINE_ENDS)) {
            line.stop = Some(Stop { kind, at: line.text.len(), column, gap });
        }
    }
}

/// The spaces at the start of the line that holds an offset.
fn indentation(text: &str, at: usize) -> usize {
    let line = text[line_start(text.as_bytes(), at)..].trim_start_matches(BYTE_ORDER_MARK);
    let blanks = line.bytes().take_while(|byte| matches!(byte, b' ' | b'\t'));
    blanks.map(|byte| if byte == b'\t' { TAB } else { 1 }).sum()
}

/// The indentation of the first declaration that begins a line.
fn indentation_of_declarations(text: &str, tokens: &[Token]) -> usize {
    let ends = |token: &Token| matches!(token.kind, TokenKind::Mark(Mark::Semicolon) | TokenKind::Uses(..));
    let begins_line = |token: &Token| {
        let start = token.span.range().start;
        text[line_start(text.as_bytes(), start)..start].trim_start_matches(BYTE_ORDER_MARK).trim().is_empty()
    };
    let first = tokens.iter().enumerate().find(|(at, token)| {
        let begins = at.checked_sub(1).is_none_or(|before| ends(&tokens[before]));
        begins && !spacing::is_head(tokens, *at) && begins_line(token)
    });
    first.map_or(0, |(_, token)| indentation(text, token.span.range().start).min(MOST_INDENTATION))
}

#[cfg(test)]
mod tests;
