//! How shapes and kinds of lights are written: what each of them says about its own text, and the tables of all.
//!
//! A shape or a kind of light is one file (its values, [`TextForm`], `Display`, `Movable`) and one row in the table
//! of its enumeration. Transforms of bodies have a table too.
//! The parser, its messages and the editor read the tables; nothing else names a shape.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::keywords::Keyword;
use std::fmt::Display;

/// How a shape or a kind of light is written. `Display` prints what [`parse`](Self::parse) reads, the keyword included.
pub(super) trait TextForm: Display + Sized {
    /// The word that it begins with, and its whole form in one line.
    const KEYWORD: Keyword;
    /// The words between its values.
    const CLAUSES: &'static [Keyword];
    /// An example, as `Display` prints it.
    const EXAMPLE: &'static str;
    /// Whether a scene has at most one.
    const IS_SINGLE: bool = false;

    /// Reads what follows the keyword, up to the attributes or the `;`. `None` where a value is out of range: that is
    /// reported, and parsing continues behind it.
    ///
    /// # Errors
    /// The text has another form; that is reported, and the rest of the declaration is passed over.
    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported>;
}

/// A row of a table: how one kind of `T` is written.
#[derive(Debug)]
pub struct Syntax<T: 'static> {
    /// The word that it begins with, and its whole form in one line.
    pub keyword: Keyword,
    /// The words between its values.
    pub clauses: &'static [Keyword],
    /// An example, as `Display` prints it.
    pub example: &'static str,
    /// Whether a scene has at most one.
    pub is_single: bool,
    /// Reads what follows the keyword, see [`TextForm::parse`].
    pub(super) parse: fn(&mut Cursor) -> Result<Option<T>, Reported>,
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

    /// How it is written, as a sentence about a shape.
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
                    keyword: <$value as $crate::scene::syntax::TextForm>::KEYWORD,
                    clauses: <$value as $crate::scene::syntax::TextForm>::CLAUSES,
                    example: <$value as $crate::scene::syntax::TextForm>::EXAMPLE,
                    is_single: <$value as $crate::scene::syntax::TextForm>::IS_SINGLE,
                    parse: |cursor| {
                        let value = <$value as $crate::scene::syntax::TextForm>::parse(cursor)?;
                        Ok(value.map($name::$kind))
                    },
                },)*
            ];
        }

        impl $name {
            /// The word that it begins with.
            pub fn keyword(&self) -> $crate::lang::keywords::Keyword {
                match self {
                    $($name::$kind(_) => <$value as $crate::scene::syntax::TextForm>::KEYWORD,)*
                }
            }

            /// The point that stands for it, in world coordinates; `None` if it is nowhere in particular.
            pub fn anchor(&self) -> Option<glam::DVec3> {
                match self {
                    $($name::$kind(value) => $crate::scene::movable::Movable::anchor(value),)*
                }
            }

            /// The same, moved by a vector in world units; `None` if it would be too far away.
            pub fn moved(&self, by: glam::DVec3) -> Option<Self> {
                match self {
                    $($name::$kind(value) => $crate::scene::movable::Movable::moved(value, by).map($name::$kind),)*
                }
            }

            /// The same, larger by a factor greater than 0, with the anchor where it is; `None` if it has no size, or
            /// if it would be too large or too small.
            pub fn scaled(&self, by: f64) -> Option<Self> {
                match self {
                    $($name::$kind(value) => $crate::scene::movable::Movable::scaled(value, by).map($name::$kind),)*
                }
            }

            /// The same, larger by a factor along each axis of the scene, with the anchor where it is; `None` if that
            /// is no longer of this kind.
            pub fn stretched(&self, by: glam::DVec3) -> Option<Self> {
                match self {
                    $($name::$kind(value) => $crate::scene::movable::Movable::stretched(value, by).map($name::$kind),)*
                }
            }

            /// The normal of what is flat, along which a factor changes nothing.
            pub fn flat_normal(&self) -> Option<glam::DVec3> {
                match self {
                    $($name::$kind(value) => $crate::scene::movable::Movable::flat_normal(value),)*
                }
            }

            /// Its radius in world units, if it has one.
            pub fn radius(&self) -> Option<f64> {
                match self {
                    $($name::$kind(value) => $crate::scene::movable::Movable::radius(value),)*
                }
            }
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
    use crate::lang::source::Source;
    use crate::scene::{LightKind, Scene, Shape, Transform};

    /// Of every shape, light and transform: its keyword, all its words, and its example.
    fn all() -> impl Iterator<Item = (Keyword, Vec<&'static str>, String)> {
        fn of<T>(syntax: &'static Syntax<T>) -> (Keyword, Vec<&'static str>, String) {
            (syntax.keyword, syntax.words().map(|keyword| keyword.word).collect(), syntax.example.to_owned())
        }
        let of_body = |(keyword, words, example): (Keyword, Vec<&'static str>, String)| {
            (keyword, words, format!("{}, {example}", Shape::SYNTAX[0].example))
        };
        let transforms = Transform::SYNTAX.iter().map(of).map(of_body);
        Shape::SYNTAX.iter().map(of).chain(LightKind::SYNTAX.iter().map(of)).chain(transforms)
    }

    #[test]
    fn the_language_reference_shows_every_word() {
        let reference = include_str!("../../docs/manual/src/scenes.md");
        for word in all().flat_map(|(_, words, _)| words) {
            assert!(
                reference.contains(&format!("\"{word}\"")),
                "docs/manual/src/scenes.md does not show `{word}` in its grammar"
            );
        }
    }

    #[test]
    fn the_line_about_a_keyword_begins_with_its_form() {
        for (Keyword { word, doc }, ..) in all() {
            assert!(doc.starts_with(&format!("`{word}")), "{doc}");
        }
    }

    #[test]
    fn every_example_reads_back_unchanged() {
        let shapes = Shape::SYNTAX.iter().map(|shape| format!("{}: {};\n", shape.keyword.word, shape.example));
        let ball = Shape::SYNTAX[0].example;
        let transforms = Transform::SYNTAX.iter().map(|row| format!("t_{}: {ball}, {};\n", row.keyword.word, row.example));
        let bodies: String = shapes.chain(transforms).collect();
        let lights: String =
            LightKind::SYNTAX.iter().map(|light| format!("l_{}: {};\n", light.keyword.word, light.example)).collect();
        let text =
            format!("bodies;\n{bodies}lights;\n{lights}camera;\nposition <0, 0, 9>;\ngaze <0, 0, -1>;\nup <0, 1, 0>;\nfov 45;\n");
        let source = Source::new("scene", text.clone());
        let (scene, warnings) = Scene::parse(&source).unwrap_or_else(|errors| panic!("{errors:?}"));
        assert!(warnings.is_empty());
        assert_eq!(scene.to_string(), text);
        for text in all().map(|(_, _, example)| example) {
            // Every example without one of its words is an error of this declaration alone.
            for (at, _) in text.match_indices(' ') {
                let broken = format!("bodies; b: {}; lights; camera;", &text[..at]);
                assert!(Scene::parse(&Source::new("scene", broken)).is_err());
            }
        }
    }
}
