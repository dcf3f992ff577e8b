//! Where spaces stand between the words of a line.
//!
//! One space is around `+`, `-` between operands, comparisons, `&&`, `||` and `=`, and behind `,` and `:`. None is
//! around `.`, `^` and `..`, inside brackets, and before `,`, `;` and `:`. None is around `*` and `/` either, unless
//! the author has put them between two expressions in parentheses, as in `(a - b) / (c - d)`.

use crate::lang::lexer::tokenize;
use crate::lang::lines::LINE_ENDS;
use crate::lang::source::Source;
use crate::lang::token::{Mark, Token, TokenKind};

/// How a word stands to its neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// A name, keyword, number or text.
    Operand,
    /// `(`
    OpenParenthesis,
    /// `<` of a vector.
    OpenVector,
    /// `)`, or `>` of a vector.
    Closing,
    /// An operator before its operand.
    Prefix,
    /// An operator between operands with spaces around it.
    Wide,
    /// An operator between operands without spaces around it.
    Tight,
    /// `,`
    Comma,
    /// `:`
    Colon,
    /// `;`
    Semicolon,
}

/// How a word is placed on its line.
#[derive(Debug, Clone, Copy)]
pub(super) struct WordPlacement {
    role: Role,
    /// Offset of the word in the source.
    pub start: usize,
    /// Whether the word begins the head of a section, or is `#uses`.
    pub is_head: bool,
    /// Whether it is the `=` of a macro or a function, behind the name.
    pub is_definition: bool,
}

impl WordPlacement {
    /// Whether it is `(`, or `<` of a vector.
    pub(super) fn opens(self) -> bool {
        matches!(self.role, Role::OpenParenthesis | Role::OpenVector)
    }

    /// Whether it is `:`.
    pub(super) fn is_colon(self) -> bool {
        self.role == Role::Colon
    }

    /// Whether no space parts it from a comment before it.
    pub(super) fn hugs_comment(self) -> bool {
        matches!(self.role, Role::Comma | Role::Semicolon | Role::Closing)
    }
}

/// Whether the word at an index is the head of a section, a word with nothing but its `;`, or `#uses`.
pub(super) fn is_head(tokens: &[Token], at: usize) -> bool {
    let mark = |at: usize| tokens.get(at).is_some_and(|token| token.kind == TokenKind::Mark(Mark::Semicolon));
    match tokens[at].kind {
        TokenKind::Word(_) => mark(at + 1),
        TokenKind::Uses(..) => true,
        TokenKind::Number(_) | TokenKind::Text(_) | TokenKind::Mark(_) | TokenKind::Unknown | TokenKind::End => false,
    }
}

/// The placement of each word.
pub(super) fn placements(text: &str, tokens: &[Token]) -> Vec<WordPlacement> {
    let mut reader = RoleReader { has_expressions: false, open: Vec::new(), behind_operand: false };
    let mut found: Vec<WordPlacement> = Vec::with_capacity(tokens.len());
    let (mut begins, mut words) = (true, 0);
    for (at, token) in tokens.iter().enumerate() {
        let is_head = begins && is_head(tokens, at);
        if let (true, TokenKind::Word(word)) = (is_head, &token.kind) {
            reader.has_expressions = ["formula", "invariants"].contains(&word.as_str());
        }
        words = if begins { 1 } else { words + 1 };
        let role = reader.role(&token.kind);
        // The `=` of a definition is the first of its statement; before it are a name and perhaps arguments.
        let is_definition = token.kind == TokenKind::Mark(Mark::Equal) && words > 1 && reader.open.is_empty();
        found.push(WordPlacement { role, start: token.span.range().start, is_head, is_definition });
        begins = matches!(token.kind, TokenKind::Mark(Mark::Semicolon) | TokenKind::Uses(..));
    }
    for at in 0..tokens.len() {
        if matches!(tokens[at].kind, TokenKind::Mark(Mark::Star | Mark::Slash)) {
            found[at].role = if is_wide(text, tokens, &found, at) { Role::Wide } else { Role::Tight };
        }
    }
    found
}

/// Whether the author's spaces around a `*` or `/` stay: between parentheses, and at the start or the end of a line.
fn is_wide(text: &str, tokens: &[Token], placements: &[WordPlacement], at: usize) -> bool {
    let (Some(left), Some(right)) = (at.checked_sub(1), tokens.get(at + 1)) else { return false };
    let gap = |from: &Token, to: &Token| &text[from.span.range().end..to.span.range().start];
    let (before, behind) = (gap(&tokens[left], &tokens[at]), gap(&tokens[at], right));
    if before.is_empty() || behind.is_empty() || right.kind == TokenKind::Mark(Mark::Semicolon) {
        return false;
    }
    let is_between = placements[left].role == Role::Closing && placements[at + 1].opens();
    is_between || before.contains(LINE_ENDS) || behind.contains(LINE_ENDS)
}

/// Finds the roles of words, in their order.
struct RoleReader {
    /// Whether the section has expressions, where `<` and `-` may be operators between operands.
    has_expressions: bool,
    /// The brackets that are open.
    open: Vec<Mark>,
    behind_operand: bool,
}

impl RoleReader {
    fn role(&mut self, kind: &TokenKind) -> Role {
        let between = self.has_expressions && self.behind_operand;
        let role = match kind {
            TokenKind::Mark(mark) => self.mark(*mark, between),
            TokenKind::Number(_)
            | TokenKind::Word(_)
            | TokenKind::Uses(..)
            | TokenKind::Text(_)
            | TokenKind::Unknown
            | TokenKind::End => Role::Operand,
        };
        self.behind_operand = matches!(role, Role::Operand | Role::Closing);
        role
    }

    fn mark(&mut self, mark: Mark, between: bool) -> Role {
        match mark {
            Mark::Open => {
                self.open.push(mark);
                Role::OpenParenthesis
            }
            Mark::Close => {
                self.open.pop();
                Role::Closing
            }
            Mark::Less if !between => {
                self.open.push(mark);
                Role::OpenVector
            }
            Mark::Greater if self.open.last() == Some(&Mark::Less) => {
                self.open.pop();
                Role::Closing
            }
            Mark::Plus | Mark::Minus | Mark::Not if !between => Role::Prefix,
            Mark::Comma => Role::Comma,
            Mark::Colon => Role::Colon,
            Mark::Semicolon => {
                self.open.clear();
                Role::Semicolon
            }
            Mark::DotDot | Mark::Dot | Mark::Caret | Mark::Star | Mark::Slash => Role::Tight,
            Mark::Less
            | Mark::Greater
            | Mark::Plus
            | Mark::Minus
            | Mark::Not
            | Mark::LessEqual
            | Mark::GreaterEqual
            | Mark::EqualEqual
            | Mark::NotEqual
            | Mark::AndAnd
            | Mark::OrOr
            | Mark::Equal => Role::Wide,
        }
    }
}

/// Whether a space stands between two words on one line.
pub(super) fn separated(left: &WordPlacement, right: &WordPlacement) -> bool {
    match (left.role, right.role) {
        (_, Role::Comma | Role::Semicolon | Role::Colon | Role::Closing | Role::Tight) => false,
        (Role::OpenParenthesis | Role::OpenVector | Role::Prefix | Role::Tight, _) => false,
        (Role::Operand | Role::Closing, Role::OpenParenthesis) => false,
        (
            Role::Operand | Role::Closing | Role::Wide | Role::Comma | Role::Colon | Role::Semicolon,
            Role::Operand | Role::OpenVector | Role::OpenParenthesis | Role::Prefix | Role::Wide,
        ) => true,
    }
}

/// Whether two words without a space between them are read as other words, like `1` and `.` before a name.
pub(super) fn would_merge(left: &str, right: &str) -> bool {
    let found = tokenize(&Source::new("", format!("{left}{right}")));
    let is_cut = |token: &Token| token.span.range().end == left.len();
    // Two words and the end of the text.
    found.tokens.len() != 3 || !is_cut(&found.tokens[0]) || !found.comments.is_empty()
}
