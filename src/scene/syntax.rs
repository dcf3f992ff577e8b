//! How shapes and kinds of lights are written: what each of them says about its own text, and the tables of all.
//!
//! A shape or a kind of light is one file (its values, [`Declaration`] and `Display`) and one row in the table of its enumeration.
//! The parser, its messages and the editor read the tables; nothing else names a shape.

use crate::lang::cursor::Reported;
use crate::lang::keywords::Keyword;
use crate::scene::parser::Parser;
use std::fmt::Display;

/// How a shape or a kind of light is written. `Display` prints what [`parse`](Self::parse) reads, the keyword included.
pub(super) trait Declaration: Display + Sized {
    /// The word that it begins with, and its whole form in one line.
    const KEYWORD: Keyword;
    /// The words between its values.
    const CLAUSES: &'static [Keyword];

    /// Reads what follows the keyword, up to the attributes or the `;`. `None` where a value is out of range: that is
    /// reported, and the parser goes on behind it.
    ///
    /// # Errors
    /// The text has another form; that is reported, and the rest of the declaration is passed over.
    fn parse(parser: &mut Parser) -> Result<Option<Self>, Reported>;
}

/// A row of a table: how one kind of `T` is written.
#[derive(Debug)]
pub struct Syntax<T: 'static> {
    /// The word that it begins with, and its whole form in one line.
    pub keyword: Keyword,
    /// The words between its values.
    pub clauses: &'static [Keyword],
    /// Reads what follows the keyword, see [`Declaration::parse`].
    pub(super) parse: fn(&mut Parser) -> Result<Option<T>, Reported>,
}

impl<T> Syntax<T> {
    /// Its words: the one that it begins with, and those between its values.
    pub fn words(&self) -> impl Iterator<Item = &Keyword> {
        std::iter::once(&self.keyword).chain(self.clauses)
    }

    /// Whether the word stands between its values.
    pub(super) fn has_clause(&self, word: &str) -> bool {
        self.clauses.iter().any(|clause| clause.word == word)
    }

    /// How it is written, as a sentence.
    pub(super) fn form(&self) -> String {
        format!("a {} is written {}", self.keyword.word, self.keyword.doc)
    }
}

/// Declares an enumeration of things that are written in a scene, with the table `SYNTAX` of how each is written.
macro_rules! declarations {
    ($(#[$doc:meta])* $name:ident { $($(#[$kind_doc:meta])* $kind:ident($value:ident),)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq)]
        pub enum $name {
            $($(#[$kind_doc])* $kind($value),)*
        }

        impl $name {
            /// How each kind is written, in the order in which messages name them.
            pub const SYNTAX: &'static [$crate::scene::syntax::Syntax<Self>] = &[
                $($crate::scene::syntax::Syntax {
                    keyword: <$value as $crate::scene::syntax::Declaration>::KEYWORD,
                    clauses: <$value as $crate::scene::syntax::Declaration>::CLAUSES,
                    parse: |parser| {
                        let value = <$value as $crate::scene::syntax::Declaration>::parse(parser)?;
                        Ok(value.map($name::$kind))
                    },
                },)*
            ];
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                match self {
                    $($name::$kind(value) => value.fmt(f),)*
                }
            }
        }
    };
}

pub(super) use declarations;

#[cfg(test)]
mod tests {
    use super::Syntax;
    use crate::lang::keywords::Keyword;
    use crate::scene::{LightKind, Shape};

    #[test]
    fn the_language_reference_shows_every_shape_and_light() {
        let reference = include_str!("../../docs/language.md");
        for Keyword { word, .. } in
            Shape::SYNTAX.iter().flat_map(Syntax::words).chain(LightKind::SYNTAX.iter().flat_map(Syntax::words))
        {
            assert!(reference.contains(&format!("\"{word}\"")), "docs/language.md does not show `{word}` in its grammar");
        }
        for Keyword { word, doc } in
            Shape::SYNTAX.iter().map(|kind| kind.keyword).chain(LightKind::SYNTAX.iter().map(|kind| kind.keyword))
        {
            // The line begins with the whole form, in backquotes.
            assert!(doc.starts_with(&format!("`{word}")), "{doc}");
        }
    }
}
