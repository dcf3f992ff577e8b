//! The words (tokens) of both languages: the output of the lexer and the input of the parsers.

use crate::lang::source::SourceSpan;

/// One word with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// Its place.
    pub span: SourceSpan,
    /// Whether it is the first on its line.
    pub begins_line: bool,
}

/// The kinds of words.
#[derive(Debug, Clone, PartialEq)]
pub enum TokenKind {
    /// An unsigned number.
    Number(f64),
    /// An identifier or a keyword; keywords are words only in their places.
    Word(String),
    /// `#uses` with the raw text up to the `;`, trimmed, and the place of that text. The `;` is part of the token.
    Uses(String, SourceSpan),
    /// A text in quotation marks, without them.
    Text(String),
    /// Punctuation.
    Mark(Mark),
    /// Characters that are no word; the lexer has reported them.
    Unknown,
    /// The end of the text.
    End,
}

impl TokenKind {
    /// The mark, if it is one.
    pub fn mark(&self) -> Option<Mark> {
        match self {
            TokenKind::Mark(mark) => Some(*mark),
            TokenKind::Number(_)
            | TokenKind::Word(_)
            | TokenKind::Uses(..)
            | TokenKind::Text(_)
            | TokenKind::Unknown
            | TokenKind::End => None,
        }
    }

    /// The name or keyword, if it is one.
    pub fn word(&self) -> Option<&str> {
        match self {
            TokenKind::Word(word) => Some(word),
            TokenKind::Number(_)
            | TokenKind::Mark(_)
            | TokenKind::Uses(..)
            | TokenKind::Text(_)
            | TokenKind::Unknown
            | TokenKind::End => None,
        }
    }

    /// How a message names this word: `` `kd` ``, `the number 1.5`, `the end of the file`.
    pub fn describe(&self) -> String {
        match self {
            TokenKind::Number(value) => format!("the number {value}"),
            TokenKind::Word(word) => format!("`{word}`"),
            TokenKind::Uses(..) => "`#uses`".to_owned(),
            TokenKind::Text(text) => format!("the text \"{text}\""),
            TokenKind::Mark(mark) => format!("`{}`", mark.spelling()),
            TokenKind::Unknown => "something that is not part of the language".to_owned(),
            TokenKind::End => "the end of the file".to_owned(),
        }
    }
}

macro_rules! marks {
    ($($name:ident $spelling:literal,)*) => {
        /// Punctuation marks and operators. A mark that begins with another mark comes before it.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Mark {
            $(#[doc = concat!("`", $spelling, "`")] $name,)*
        }

        impl Mark {
            /// Every mark, in the order in which the lexer must try them.
            pub const ALL: &[Mark] = &[$(Mark::$name,)*];

            /// How it is written.
            pub fn spelling(self) -> &'static str {
                match self {
                    $(Mark::$name => $spelling,)*
                }
            }
        }
    };
}

marks! {
    DotDot "..",
    LessEqual "<=",
    GreaterEqual ">=",
    EqualEqual "==",
    NotEqual "!=",
    AndAnd "&&",
    OrOr "||",
    Colon ":",
    Semicolon ";",
    Comma ",",
    Plus "+",
    Minus "-",
    Star "*",
    Slash "/",
    Dot ".",
    Caret "^",
    Open "(",
    Close ")",
    Less "<",
    Greater ">",
    Equal "=",
    Not "!",
}
