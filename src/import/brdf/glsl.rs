//! The part of GLSL that models of BRDF Explorer are written in, as a tree.

use crate::lang::source::SourceSpan;

/// A type of GLSL that formulas have, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GlslType {
    Float,
    /// Whole numbers. Only constants are divided.
    Int,
    Bool,
    Vec3,
}

impl GlslType {
    /// The type of this name.
    pub(super) fn named(name: &str) -> Option<GlslType> {
        Some(match name {
            "float" => GlslType::Float,
            "int" => GlslType::Int,
            "bool" => GlslType::Bool,
            "vec3" => GlslType::Vec3,
            _ => return None,
        })
    }

    /// Its name.
    pub(super) fn name(self) -> &'static str {
        match self {
            GlslType::Float => "float",
            GlslType::Int => "int",
            GlslType::Bool => "bool",
            GlslType::Vec3 => "vec3",
        }
    }
}

/// A name with its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GlslName {
    pub(super) text: String,
    pub(super) span: SourceSpan,
}

/// An expression with its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GlslExpression {
    pub(super) kind: GlslExpressionKind,
    pub(super) span: SourceSpan,
    /// The number of expressions within each other, from here down.
    pub(super) depth: usize,
}

/// What an expression is.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum GlslExpressionKind {
    /// A number as written, without a suffix.
    Number(String),
    Truth(bool),
    Name(String),
    Negative(Box<GlslExpression>),
    Not(Box<GlslExpression>),
    Binary(BinaryOperator, Box<GlslExpression>, Box<GlslExpression>),
    Conditional(Box<[GlslExpression; 3]>),
    Call(GlslName, Vec<GlslExpression>),
    /// `v.xyz`
    Member(Box<GlslExpression>, GlslName),
    /// `v[0]`
    Index(Box<GlslExpression>, Box<GlslExpression>),
}

/// An operator between two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BinaryOperator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
    And,
    ExclusiveOr,
    Or,
}

impl BinaryOperator {
    /// Every operator with its sign, and how it binds: greater numbers bind more tightly.
    pub(super) const ALL: [(BinaryOperator, &'static str, u8); 13] = [
        (BinaryOperator::Add, "+", 6),
        (BinaryOperator::Subtract, "-", 6),
        (BinaryOperator::Multiply, "*", 7),
        (BinaryOperator::Divide, "/", 7),
        (BinaryOperator::Less, "<", 5),
        (BinaryOperator::LessEqual, "<=", 5),
        (BinaryOperator::Greater, ">", 5),
        (BinaryOperator::GreaterEqual, ">=", 5),
        (BinaryOperator::Equal, "==", 4),
        (BinaryOperator::NotEqual, "!=", 4),
        (BinaryOperator::And, "&&", 3),
        (BinaryOperator::ExclusiveOr, "^^", 2),
        (BinaryOperator::Or, "||", 1),
    ];
}

/// A statement.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum GlslStatement {
    /// `float a = 1, b;`
    Declare(GlslType, Vec<(GlslName, Option<GlslExpression>)>),
    /// `a = 1;`, `a *= 2;`, `v.x = 1;`: the name, the component, the operator, and the value.
    Assign(GlslName, Option<GlslComponent>, Option<BinaryOperator>, GlslExpression),
    If(GlslExpression, Vec<GlslStatement>, Vec<GlslStatement>),
    Return(Option<GlslExpression>, SourceSpan),
    Block(Vec<GlslStatement>),
    /// What formulas cannot say, and why.
    Foreign(SourceSpan, String),
}

/// The component that an assignment changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct GlslComponent(pub(super) usize);

/// A function.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GlslFunction {
    pub(super) name: GlslName,
    /// What it returns; `None` for types that formulas do not have.
    pub(super) result: Option<GlslType>,
    /// Its parameters, or why it cannot be translated.
    pub(super) parameters: Result<Vec<(GlslName, GlslType)>, (SourceSpan, String)>,
    pub(super) body: Vec<GlslStatement>,
}

/// What a shader declares.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct GlslShader {
    pub(super) functions: Vec<GlslFunction>,
    /// Constants and variables outside of functions.
    pub(super) globals: Vec<(GlslName, GlslType, Option<GlslExpression>)>,
    /// Names that mean what formulas do not have, such as arrays.
    pub(super) foreign: Vec<(GlslName, String)>,
}
