//! The terms of a formula while they are made.

use crate::formula::{Term, TermId};
use crate::lang::ast::ExprId;
use crate::lang::builtins::{Operation, Stack};
use crate::lang::scalars::flush;
use crate::lang::types::Type;
use crate::lang::variables::Variable;
use std::collections::HashMap;

/// A term with its type.
pub(super) type Settled = (TermId, Type);

/// What a term is: its bits and the first terms that are equal to its operands.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum TermContent {
    Number(u32),
    Variable(Variable),
    Parameter(u32),
    Material(u32),
    Apply(Operation, Vec<TermId>),
    ByComponents(Operation, Vec<TermId>),
}

/// Terms, operands before their users, with what is known about each.
#[derive(Default)]
pub(super) struct Terms {
    list: Vec<Term>,
    /// The expression that each was made for.
    origins: Vec<ExprId>,
    /// The expression that terms are made for now.
    pub(super) origin: ExprId,
    /// The first term that is equal to each.
    canonical: Vec<TermId>,
    first: HashMap<TermContent, TermId>,
    /// The values of terms without variables and parameters; a scalar three times.
    constants: Vec<Option<[f32; 3]>>,
    /// Whether each is a direction of unit length.
    directions: Vec<bool>,
    stack: Option<Stack<f32>>,
}

impl Terms {
    /// Functions and sums do not make more terms than this.
    pub(super) const MOST: usize = 100_000;

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// All terms, and the expression that each was made for.
    pub(super) fn into_lists(self) -> (Vec<Term>, Vec<ExprId>) {
        (self.list, self.origins)
    }

    pub(super) fn is_variable(&self, id: TermId) -> bool {
        matches!(self.list[id.0 as usize], Term::Variable(_))
    }

    /// The first term that is equal to this one.
    pub(super) fn canonical(&self, id: TermId) -> TermId {
        self.canonical[id.0 as usize]
    }

    /// The value of a term without variables and parameters; a scalar three times.
    pub(super) fn constant(&self, id: TermId) -> Option<[f32; 3]> {
        self.constants[id.0 as usize]
    }

    /// Whether a term is known to be a direction of unit length.
    pub(super) fn is_direction(&self, id: TermId) -> bool {
        self.directions[id.0 as usize]
    }

    /// Adds a term of this type.
    pub(super) fn add(&mut self, term: Term, ty: Type) -> Settled {
        // There are fewer than 2³² terms: a text has fewer expressions, and functions and sums make few more.
        let id = TermId(self.list.len() as u32);
        let alike = |operands: &[TermId]| operands.iter().map(|operand| self.canonical(*operand)).collect();
        let content = match &term {
            Term::Number(value) => TermContent::Number(value.to_bits()),
            Term::Variable(variable) => TermContent::Variable(*variable),
            Term::Parameter(parameter) => TermContent::Parameter(parameter.0),
            Term::Material(material) => TermContent::Material(material.0),
            Term::Apply(operation, operands) => TermContent::Apply(*operation, alike(operands)),
            Term::ByComponents(operation, operands) => TermContent::ByComponents(*operation, alike(operands)),
        };
        self.directions.push(self.has_unit_length(&term));
        let constant = self.value(&term);
        self.constants.push(constant);
        self.list.push(term);
        self.origins.push(self.origin);
        let first = *self.first.entry(content).or_insert(id);
        self.canonical.push(first);
        (id, ty)
    }

    pub(super) fn number(&mut self, value: f32) -> Settled {
        self.add(Term::Number(value), Type::Scalar)
    }

    /// A number as a value of a type: a vector has it three times.
    pub(super) fn spread_number(&mut self, value: f32, ty: Type) -> Settled {
        let (number, scalar) = self.number(value);
        match ty {
            Type::Vector => self.add(Term::Apply(Operation::Spread, vec![number]), Type::Vector),
            Type::Scalar | Type::Truth | Type::Texture => (number, scalar),
        }
    }

    /// A condition as the number 1 or 0; everything else as it is.
    pub(super) fn as_value(&mut self, (term, ty): Settled) -> Settled {
        if ty != Type::Truth {
            return (term, ty);
        }
        let ((one, _), (zero, _)) = (self.number(1.0), self.number(0.0));
        self.add(Term::Apply(Operation::IfS, vec![term, one, zero]), Type::Scalar)
    }

    /// A scalar as the condition that it is not 0; everything else as it is.
    pub(super) fn as_condition(&mut self, (term, ty): Settled) -> Settled {
        if ty != Type::Scalar {
            return (term, ty);
        }
        if let Term::Apply(Operation::IfS, operands) = &self.list[term.0 as usize]
            && let [condition, then, other] = operands[..]
            && self.constant(then) == Some([1.0; 3])
            && self.constant(other) == Some([0.0; 3])
        {
            // It was a condition before.
            return (condition, Type::Truth);
        }
        let (zero, _) = self.number(0.0);
        self.add(Term::Apply(Operation::NotEqual, vec![term, zero]), Type::Truth)
    }

    fn has_unit_length(&self, term: &Term) -> bool {
        match term {
            Term::Variable(variable) => variable.is_direction(),
            Term::Apply(Operation::Normalize, _) => true,
            Term::Apply(Operation::NegV, operands) | Term::Apply(Operation::Reflect, operands) => {
                operands.iter().all(|operand| self.is_direction(*operand))
            }
            Term::Apply(Operation::IfV, operands) => operands[1..].iter().all(|operand| self.is_direction(*operand)),
            Term::Apply(..) | Term::ByComponents(..) => false,
            Term::Number(_) | Term::Parameter(_) | Term::Material(_) => false,
        }
    }

    /// The value of a term from those of its operands, if they are constants.
    fn value(&mut self, term: &Term) -> Option<[f32; 3]> {
        let (operation, operands) = match term {
            Term::Number(value) => return Some([flush(*value); 3]),
            // Which number a material has is known later.
            Term::Variable(_) | Term::Parameter(_) | Term::Material(_) | Term::ByComponents(..) => return None,
            Term::Apply(operation, operands) => (operation, operands),
        };
        let values: Option<Vec<[f32; 3]>> = operands.iter().map(|operand| self.constant(*operand)).collect();
        let stack = self.stack.get_or_insert_with(|| Stack::new(16, 0.0));
        values.map(|values| operation.on_numbers(&values, stack))
    }
}
