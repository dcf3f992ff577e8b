//! A checked illumination model: its parameters, their invariants, and its expression with every name and type
//! resolved.
//!
//! Bytecode and compiled code are made from it. It holds no values: those belong to bodies, lights and the scene.
//! [`Formula::parse`] turns text into a [`Formula`]. [`graph`] to [`separation`] analyse it for compiled code.

pub mod binding;
pub mod binding_time;
mod check;
pub mod derivative;
pub mod equation;
mod evaluated_lights;
pub mod graph;
pub mod invariants;
pub mod layout;
mod lighting;
mod linear;
pub mod power;
mod range;
mod rewrite;
pub mod separation;
mod substitute;
pub mod tangent;
pub mod variants;
pub mod written;

use crate::formula::written::Written;
use crate::lang::ast::Relation;
use crate::lang::builtins::Operation;
use crate::lang::source::SourceSpan;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::types::Type;
use crate::lang::variables::{Owner, Predefined, Variable};

/// A parameter, as an index into [`Formula::parameters`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ParameterId(pub u32);

/// A parameter, predefined or declared. Its values, one for each owner, are stored elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its name in formulas.
    pub name: String,
    /// What it belongs to.
    pub owner: Owner,
    /// Scalar, vector or texture.
    pub ty: Type,
    /// Bounds of the value, or of each component. None: unbounded.
    pub range: Option<[f32; 2]>,
    /// The default. That of a scalar is the first component; the others are 0.
    pub default: [f32; 3],
    /// Whether it gets a slider in the first row.
    pub slider: bool,
    /// Whether it gets a colour picker.
    pub colour: bool,
    /// Whether it is 0 or 1, with a check box.
    pub switch: bool,
    /// The names of its values 0, 1, …, for a menu. Empty: it has no menu.
    pub choices: Vec<String>,
    /// The image of a texture: the path of its default as written, and its place in the text. The number of a texture
    /// that was read from it is the [`default`](Self::default).
    pub image: Option<(String, SourceSpan)>,
    /// What the author's comment at the declaration says, as one line. It may hold any characters.
    pub doc: Option<String>,
    /// Which predefined parameter it is, if it is one.
    pub predefined: Option<Predefined>,
    /// The index of its first number among the numbers of its owner, see [`Formula::slots`].
    pub slot: u32,
}

impl Parameter {
    /// Whether it takes whole numbers only: a switch, or a choice.
    pub fn is_whole(&self) -> bool {
        self.switch || !self.choices.is_empty()
    }

    /// The nearest value that it can take, and whether it differs. NaN becomes the lower bound, or 0 without bounds.
    pub fn clamp(&self, value: f32) -> (f32, bool) {
        let [low, high] = self.range.unwrap_or([f32::MIN, f32::MAX]);
        let nearest = if value.is_nan() { self.range.map_or(0.0, |range| range[0]) } else { value.clamp(low, high) };
        let nearest = if self.is_whole() { nearest.round() } else { nearest };
        (nearest, nearest != value)
    }
}

/// A condition on scalar parameters of one owner: their sum is 1, or at most 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Invariant {
    /// The parameters in the order of naming. One that is named twice counts twice.
    pub terms: Vec<ParameterId>,
    /// `=` or `<=`.
    pub relation: Relation,
}

/// A measured material that a formula names, as an index into [`Formula::materials`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// A file of a measured material.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialFile {
    /// The path as written.
    pub path: String,
    /// Where it is named first.
    pub span: SourceSpan,
    /// The number of the material that was read from it; 0 before, where its reflectance is 0.
    pub number: f32,
}

/// An expression, as an index into [`Formula::terms`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TermId(pub u32);

/// An expression whose names and types are resolved.
#[derive(Debug, Clone, PartialEq)]
pub enum Term {
    /// A number.
    Number(f32),
    /// A value of the hit.
    Variable(Variable),
    /// The value of a parameter.
    Parameter(ParameterId),
    /// The number of a measured material.
    Material(MaterialId),
    /// An operation on other expressions.
    Apply(Operation, Vec<TermId>),
    /// An operation on numbers, for each component of vectors. Scalars are the same for all components.
    ByComponents(Operation, Vec<TermId>),
}

impl Term {
    /// The expressions that it uses.
    pub fn operands(&self) -> &[TermId] {
        match self {
            Term::Number(_) | Term::Variable(_) | Term::Parameter(_) | Term::Material(_) => &[],
            Term::Apply(_, operands) | Term::ByComponents(_, operands) => operands,
        }
    }
}

/// A checked illumination model.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    /// The path of the material library, as written.
    pub uses: Option<String>,
    /// All parameters: the predefined ones first, in the order of their table, then the declared ones in the order of
    /// the file.
    pub parameters: Vec<Parameter>,
    /// All invariants, in the order of the file.
    pub invariants: Vec<Invariant>,
    /// The measured materials, each file once, in the order in which they are met.
    pub materials: Vec<MaterialFile>,
    /// All expressions, operands before their users. A macro is there once, however often it is used.
    pub terms: Vec<Term>,
    /// The macros by name, in the order of the file.
    pub macros: Vec<(String, TermId)>,
    /// The colour: a vector.
    pub result: TermId,
    /// The terms of the lighting equation that the formula gives for every hit.
    pub surface: SurfaceTerms,
    /// The text that the expressions were made from.
    pub written: Written,
}

/// The terms of the lighting equation that macros give for every hit, see [`SurfaceTerm`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SurfaceTerms {
    terms: [Option<TermId>; SurfaceTerm::COUNT],
}

impl SurfaceTerms {
    /// The expression of a term, if the formula gives it.
    pub fn get(&self, term: SurfaceTerm) -> Option<TermId> {
        self.terms[term as usize]
    }

    /// Sets the expression of a term.
    pub fn set(&mut self, term: SurfaceTerm, id: TermId) {
        self.terms[term as usize] = Some(id);
    }

    /// The terms that the formula gives.
    pub fn iter(&self) -> impl Iterator<Item = (SurfaceTerm, TermId)> {
        SurfaceTerm::ALL.iter().filter_map(|term| Some((*term, self.get(*term)?)))
    }

    /// Whether the formula gives any.
    pub fn is_empty(&self) -> bool {
        self.terms.iter().all(Option::is_none)
    }
}

impl Formula {
    /// The parameter of this index.
    pub fn parameter(&self, id: ParameterId) -> &Parameter {
        &self.parameters[id.0 as usize]
    }

    /// The indices of all parameters.
    pub fn parameter_ids(&self) -> impl Iterator<Item = ParameterId> + use<> {
        (0..self.parameters.len() as u32).map(ParameterId)
    }

    /// The parameter of this name.
    pub fn parameter_named(&self, name: &str) -> Option<ParameterId> {
        self.parameter_ids().find(|id| self.parameter(*id).name == name)
    }

    /// The predefined parameter of this kind.
    pub fn predefined(&self, predefined: Predefined) -> ParameterId {
        // The predefined parameters come first, in the order of their table.
        ParameterId(predefined as u32)
    }

    /// How many numbers the parameters of one owner of this kind have; a vector has three.
    pub fn slots(&self, owner: Owner) -> usize {
        self.parameters.iter().filter(|parameter| parameter.owner == owner).map(|parameter| parameter.ty.slots()).sum()
    }

    /// The measured material of this index.
    pub fn material(&self, id: MaterialId) -> &MaterialFile {
        &self.materials[id.0 as usize]
    }

    /// The expression of this index.
    pub fn term(&self, id: TermId) -> &Term {
        &self.terms[id.0 as usize]
    }

    /// The type of an expression.
    pub fn ty(&self, id: TermId) -> Type {
        match self.term(id) {
            Term::Number(_) | Term::Material(_) => Type::Scalar,
            Term::Variable(variable) => variable.ty(),
            Term::Parameter(parameter) => self.parameter(*parameter).ty,
            Term::Apply(operation, _) => operation.result(),
            Term::ByComponents(..) => Type::Vector,
        }
    }

    /// The expressions that `root` is computed from, itself included, users before their operands.
    pub fn terms_of(&self, root: TermId) -> Vec<TermId> {
        let mut is_used = vec![false; self.terms.len()];
        is_used[root.0 as usize] = true;
        let mut used = Vec::new();
        // Operands come before their users.
        for index in (0..=root.0).rev() {
            if is_used[index as usize] {
                let id = TermId(index);
                self.term(id).operands().iter().for_each(|operand| is_used[operand.0 as usize] = true);
                used.push(id);
            }
        }
        used
    }

    /// Which operands of an operation are vectors, as [`Operation::apply_by_components`] takes it: a bit for each.
    pub fn vectors(&self, operands: &[TermId]) -> u8 {
        let bits = operands.iter().enumerate().map(|(index, id)| u8::from(self.ty(*id) == Type::Vector) << index);
        bits.fold(0, |all, bit| all | bit)
    }
}
