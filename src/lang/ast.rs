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
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExprId(pub u32);

/// An expression with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// Its place, without the parentheses around it.
    pub span: SourceSpan,
    /// Its place with the parentheses of its own, if it has any.
    pub outer: SourceSpan,
}

impl Expr {
    /// Whether it has parentheses of its own.
    pub fn parenthesised(&self) -> bool {
        self.outer != self.span
    }
}

/// The kinds of expressions.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprKind {
    /// A number.
    Number(f32),
    /// A variable, parameter, macro or constant.
    Name(String),
    /// A text in quotation marks, as written: the path of a measured material.
    Text(String),
    /// `name(arguments)`, with the place of the name.
    Call(Name, Vec<ExprId>),
    /// An operator before its operand.
    Prefix(Mark, ExprId),
    /// An operator between its two operands, with its place.
    Infix(Mark, SourceSpan, [ExprId; 2]),
    /// `<x, y, z>`, or `<x>` for three equal components.
    Vector(Vec<ExprId>),
    /// `if(condition, then, else)`.
    Conditional([ExprId; 3]),
    /// Something that could not be read and was reported.
    Missing,
}

impl ExprKind {
    /// The operator between two operands, and the operands, if it is one.
    pub fn infix(&self) -> Option<(Mark, [ExprId; 2])> {
        if let ExprKind::Infix(mark, _, operands) = self { Some((*mark, *operands)) } else { None }
    }

    /// The name that it reads or calls, if it does.
    pub fn name(&self) -> Option<&str> {
        if let ExprKind::Name(name) = self { Some(name) } else { self.callee().map(|callee| callee.text.as_str()) }
    }

    /// The name of the function that it calls, with its place, if it is a call.
    pub fn callee(&self) -> Option<&Name> {
        if let ExprKind::Call(callee, _) = self { Some(callee) } else { None }
    }

    /// The operands, in order.
    pub fn operands(&self) -> &[ExprId] {
        match self {
            ExprKind::Number(_) | ExprKind::Name(_) | ExprKind::Text(_) | ExprKind::Missing => &[],
            ExprKind::Call(_, operands) | ExprKind::Vector(operands) => operands,
            ExprKind::Prefix(_, operand) => std::slice::from_ref(operand),
            ExprKind::Infix(_, _, operands) => operands,
            ExprKind::Conditional(parts) => parts,
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

/// The attributes of a parameter, each with its place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParameterAttributes {
    /// `constraint a..b`
    pub range: Option<([f32; 2], SourceSpan)>,
    /// `default …`
    pub default: Option<(Constant, SourceSpan)>,
    /// `default "…"`: the path of the image of a texture, as written.
    pub image: Option<(String, SourceSpan)>,
    /// `slider`
    pub slider: Option<SourceSpan>,
    /// `color`
    pub colour: Option<SourceSpan>,
    /// `switch`
    pub switch: Option<SourceSpan>,
    /// `choices "…", "…"`: the names of the values 0, 1, …
    pub choices: Option<(Vec<String>, SourceSpan)>,
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
    /// What is said about its values.
    pub attributes: ParameterAttributes,
    /// What the comments at the declaration say, see [`doc`](crate::lang::comments::doc).
    pub doc: Option<String>,
}

/// New attributes for a predefined parameter: `ki: constraint 0..50, default 1;`
#[derive(Debug, Clone, PartialEq)]
pub struct PredefinedLine {
    /// The name of the parameter.
    pub name: Name,
    /// What is said about its values.
    pub attributes: ParameterAttributes,
    /// What the comments at the line say, see [`doc`](crate::lang::comments::doc).
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

/// A macro, `NAME = expression;`, or a function, `NAME(x, y) = expression;`.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// Its name.
    pub name: Name,
    /// The names of the arguments of a function; `None` for a macro.
    pub arguments: Option<Vec<Name>>,
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
    /// `predefined;`
    Predefined(Vec<PredefinedLine>),
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
    /// The macros and functions, in the order of the file.
    pub definitions: Vec<Definition>,
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
            Section::Predefined(_) | Section::Invariants(_) => &[],
        })
    }

    /// All lines about predefined parameters, in the order of the file.
    pub fn predefined(&self) -> impl Iterator<Item = &PredefinedLine> {
        self.sections.iter().flat_map(|section| match section {
            Section::Predefined(lines) => lines.as_slice(),
            Section::Parameters(..) | Section::Invariants(_) => &[],
        })
    }

    /// All invariants, in the order of the file.
    pub fn invariants(&self) -> impl Iterator<Item = &InvariantLine> {
        self.sections.iter().flat_map(|section| match section {
            Section::Invariants(lines) => lines.as_slice(),
            Section::Parameters(..) | Section::Predefined(_) => &[],
        })
    }
}
