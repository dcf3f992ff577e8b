//! The types of the language.

use std::fmt;

/// The type of an expression.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Type {
    /// One number.
    Scalar,
    /// Three numbers: a direction, a point, a colour.
    Vector,
    /// The result of a comparison: a condition. Where a number is needed, it is 0 or 1.
    Truth,
    /// An image, as the value of a parameter: the number of a texture. Expressions have none, but call it.
    Texture,
}

impl Type {
    /// The number of scalars in a value of this type.
    pub const fn slots(self) -> usize {
        match self {
            Type::Scalar | Type::Truth | Type::Texture => 1,
            Type::Vector => 3,
        }
    }

    /// The letter that stands for it in signatures.
    pub const fn letter(self) -> char {
        match self {
            Type::Scalar => 'S',
            Type::Vector => 'V',
            Type::Truth => 'B',
            Type::Texture => 'T',
        }
    }

    /// The type with its article, for messages.
    pub const fn with_article(self) -> &'static str {
        match self {
            Type::Scalar => "a scalar",
            Type::Vector => "a vector",
            Type::Truth => "a comparison",
            Type::Texture => "a texture",
        }
    }
}

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Type::Scalar => "scalar",
            Type::Vector => "vector",
            Type::Truth => "comparison",
            Type::Texture => "texture",
        })
    }
}

/// Where a name or an operation comes from; it decides whether formulas may redefine it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// Defined by the thesis: formulas may not redefine it.
    Thesis,
    /// Added since: formulas may redefine it, so that old formulas keep working.
    Added,
    /// Used by the evaluation alone: no formula can write its name.
    Internal,
}
