//! The syntax of a formula file as written, before names and types are checked.
//!
//! All expressions are in one list, operands before the operations that use them. So code that walks them needs a loop
//! and no recursion, however deeply a text is nested.

use crate::lang::source::SourceSpan;
use crate::lang::token::Mark;
use crate::lang::types::Type;
use crate::lang::variables::Owner;

/// A name with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name {
    /// The name.
    pub text: String,
    /// Its place.
    pub span: SourceSpan,
}

/// An expression, as an index into [`FormulaFile::expressions`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExprId(pub u32);

/// An expression with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// Its place, without the parentheses around it.
    pub span: SourceSpan,
    /// Whether it has parentheses of its own.
    pub parenthesised: bool,
}

/// The kinds of expressions.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprKind {
    /// A number.
    Number(f32),
    /// A variable, parameter, macro or constant.
    Name(String),
    /// `name(arguments)`, with the place of the name.
    Call(Name, Vec<ExprId>),
    /// An operator before its operand.
    Prefix(Mark, ExprId),
    /// An operator between its two operands, with its place.
    Infix(Mark, SourceSpan, [ExprId; 2]),
    /// `<x, y, z>`.
    Vector([ExprId; 3]),
    /// `if(condition, then, else)`.
    Conditional([ExprId; 3]),
    /// Something that could not be read and was reported.
    Missing,
}

impl ExprKind {
    /// The operands, in order.
    pub fn operands(&self) -> &[ExprId] {
        match self {
            ExprKind::Number(_) | ExprKind::Name(_) | ExprKind::Missing => &[],
            ExprKind::Call(_, arguments) => arguments,
            ExprKind::Prefix(_, operand) => std::slice::from_ref(operand),
            ExprKind::Infix(_, _, operands) => operands,
            ExprKind::Vector(parts) | ExprKind::Conditional(parts) => parts,
        }
    }
}

/// A number or a constant vector, as after `default`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Constant {
    /// A number with its sign.
    Scalar(f32),
    /// Three numbers with their signs.
    Vector([f32; 3]),
}

impl Constant {
    /// Its type.
    pub fn ty(self) -> Type {
        match self {
            Constant::Scalar(_) => Type::Scalar,
            Constant::Vector(_) => Type::Vector,
        }
    }

    /// Its numbers: one or three.
    pub fn components(&self) -> &[f32] {
        match self {
            Constant::Scalar(value) => std::slice::from_ref(value),
            Constant::Vector(values) => values,
        }
    }
}

/// The declaration of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Declaration {
    /// The parameter's name.
    pub name: Name,
    /// Its owner, which the section determines.
    pub owner: Owner,
    /// Its type.
    pub ty: Type,
    /// `constraint a..b`, with its place.
    pub range: Option<([f32; 2], SourceSpan)>,
    /// `default …`, with its place.
    pub default: Option<(Constant, SourceSpan)>,
    /// `slider`.
    pub slider: bool,
    /// `color`, with its place.
    pub colour: Option<SourceSpan>,
    /// What the comments at the declaration say, see [`doc`](crate::lang::comments::doc).
    pub doc: Option<String>,
}

/// How the sum of an invariant relates to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// `= 1`
    Equal,
    /// `<= 1`
    AtMost,
}

/// A sum of parameters that must be 1, or at most 1.
#[derive(Debug, Clone, PartialEq)]
pub struct InvariantLine {
    /// The parameters, in the order in which they are named.
    pub terms: Vec<Name>,
    /// `=` or `<=`.
    pub relation: Relation,
    /// The whole line.
    pub span: SourceSpan,
}

/// `NAME = expression;`
#[derive(Debug, Clone, PartialEq)]
pub struct MacroLine {
    /// Its name.
    pub name: Name,
    /// What it stands for.
    pub body: ExprId,
    /// What the comments at the line say, see [`doc`](crate::lang::comments::doc).
    pub doc: Option<String>,
}

/// A section of declarations or invariants, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub enum Section {
    /// `global;`, `body_specific;` or `light_specific;`
    Parameters(Owner, Vec<Declaration>),
    /// `invariants;`
    Invariants(Vec<InvariantLine>),
}

/// A whole formula file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FormulaFile {
    /// The path of `#uses`, with its place.
    pub uses: Option<(String, SourceSpan)>,
    /// The sections before the formula.
    pub sections: Vec<Section>,
    /// The macros, in the order of the file.
    pub macros: Vec<MacroLine>,
    /// The expression after the last `=`.
    pub result: Option<ExprId>,
    /// All expressions, operands before their users.
    pub expressions: Vec<Expr>,
}

impl FormulaFile {
    /// The expression of this index.
    pub fn expr(&self, id: ExprId) -> &Expr {
        &self.expressions[id.0 as usize]
    }

    /// All declarations, in the order of the file.
    pub fn declarations(&self) -> impl Iterator<Item = &Declaration> {
        self.sections.iter().flat_map(|section| match section {
            Section::Parameters(_, declarations) => declarations.as_slice(),
            Section::Invariants(_) => &[],
        })
    }

    /// All invariants, in the order of the file.
    pub fn invariants(&self) -> impl Iterator<Item = &InvariantLine> {
        self.sections.iter().flat_map(|section| match section {
            Section::Invariants(lines) => lines.as_slice(),
            Section::Parameters(..) => &[],
        })
    }
}
