//! Walks over the expressions of a formula and gives each to a writer, operands before their users.
//!
//! Macros become values of their names. Other expressions become values if they are used more than once or are long;
//! the rest is written in place. Variables that follow from others are written by their definitions in the manual.

use crate::formula::{Formula, ParameterId, Term, TermId};
use crate::lang::builtins::Operation;
use crate::lang::variables::Variable;
use std::collections::HashMap;

/// Writes expressions in a target language.
pub(super) trait TermWriter {
    /// A written expression.
    type Written: Clone;

    /// A number.
    fn number(&mut self, number: f32) -> Self::Written;
    /// A variable that does not follow from others. It may be asked for again.
    fn argument(&mut self, variable: Variable) -> Self::Written;
    /// A parameter of the formula.
    fn parameter(&mut self, parameter: ParameterId) -> Self::Written;
    /// An operation on written operands. They have its types: the checker makes conversions terms of their own.
    fn apply(&mut self, operation: Operation, operands: Vec<Self::Written>) -> Self::Written;
    /// An operation on numbers, for each component of vectors.
    fn by_components(&mut self, operation: Operation, operands: Vec<Self::Written>) -> Self::Written;
    /// The same value under a name, which is the wanted one if that is free.
    fn value(&mut self, wanted: &str, value: Self::Written) -> Self::Written;
    /// Whether an expression is so long that it should become a value.
    fn is_long(&self, written: &Self::Written) -> bool;
}

/// The name of values that have none in the formula.
pub(super) const UNNAMED: &str = "v";

/// Writes an expression with all that it needs.
pub(super) fn write<W: TermWriter>(writer: &mut W, formula: &Formula, root: TermId) -> W::Written {
    let mut order = formula.terms_of(root);
    order.reverse();
    let mut uses: HashMap<TermId, usize> = HashMap::new();
    order.iter().flat_map(|id| formula.term(*id).operands()).for_each(|operand| *uses.entry(*operand).or_default() += 1);
    let macros: HashMap<TermId, &str> = formula.macros.iter().map(|(name, id)| (*id, &**name)).collect();
    let mut walk = TermWalk { writer, variables: HashMap::new() };
    // Variables first, so that they have their names.
    let read = order.iter().filter_map(|id| match formula.term(*id) {
        Term::Variable(variable) => Some(*variable),
        Term::Number(_) | Term::Parameter(_) | Term::Material(_) | Term::Apply(..) | Term::ByComponents(..) => None,
    });
    read.for_each(|variable| _ = walk.variable(variable));
    let mut written: HashMap<TermId, W::Written> = HashMap::new();
    for id in &order {
        let term = formula.term(*id);
        let operands = || term.operands().iter().map(|operand| written[operand].clone()).collect();
        let own = match term {
            Term::Number(number) => walk.writer.number(*number),
            Term::Variable(variable) => walk.variable(*variable),
            Term::Parameter(parameter) => walk.writer.parameter(*parameter),
            Term::Material(material) => walk.writer.number(formula.material(*material).number),
            Term::Apply(operation, _) => walk.writer.apply(*operation, operands()),
            Term::ByComponents(operation, _) => walk.writer.by_components(*operation, operands()),
        };
        let is_leaf = term.operands().is_empty();
        let is_shared = uses.get(id).is_some_and(|uses| *uses > 1) || walk.writer.is_long(&own) && *id != root;
        let own = match macros.get(id).filter(|_| !is_leaf) {
            Some(name) => walk.writer.value(name, own),
            None if is_shared && !is_leaf => walk.writer.value(UNNAMED, own),
            None => own,
        };
        written.insert(*id, own);
    }
    written[&root].clone()
}

/// The walk over an expression.
struct TermWalk<'w, W: TermWriter> {
    writer: &'w mut W,
    /// The variables that it reads, and those that they follow from.
    variables: HashMap<Variable, W::Written>,
}

impl<W: TermWriter> TermWalk<'_, W> {
    /// A variable: an argument, or a value that follows from others.
    fn variable(&mut self, variable: Variable) -> W::Written {
        if let Some(known) = self.variables.get(&variable) {
            return known.clone();
        }
        let written = match self.derived(variable) {
            Some(value) => self.writer.value(variable.name(), value),
            None => self.writer.argument(variable),
        };
        self.variables.insert(variable, written.clone());
        written
    }

    /// The angle between two directions. The arc cosine would be wrong for small angles.
    fn angle(&mut self, from: Variable, to: Variable) -> W::Written {
        let (from, to) = (self.variable(from), self.variable(to));
        let cross = self.writer.apply(Operation::Cross, vec![from.clone(), to.clone()]);
        let sine = self.writer.apply(Operation::Length, vec![cross]);
        let cosine = self.writer.apply(Operation::DotVV, vec![from, to]);
        self.writer.apply(Operation::Atan2, vec![sine, cosine])
    }

    /// A variable that follows from others, by its definition in the manual.
    fn derived(&mut self, variable: Variable) -> Option<W::Written> {
        use Operation::{AddVV, Cross, Greater, IfV, Length, MulSS, MulSV, Normalize, SubVV};
        Some(match variable {
            Variable::Mirrored => {
                let (normal, light) = (self.variable(Variable::Normal), self.variable(Variable::ToLight));
                let cosine = self.writer.apply(Operation::DotVV, vec![normal.clone(), light.clone()]);
                let two = self.writer.number(2.0);
                let twice = self.writer.apply(MulSS, vec![two, cosine]);
                let along = self.writer.apply(MulSV, vec![twice, normal]);
                self.writer.apply(SubVV, vec![along, light])
            }
            Variable::Halfway => {
                let (light, view) = (self.variable(Variable::ToLight), self.variable(Variable::ToViewer));
                let normal = self.variable(Variable::Normal);
                let sum = self.writer.apply(AddVV, vec![light, view]);
                let sum = self.writer.value("sum", sum);
                let (length, zero) = (self.writer.apply(Length, vec![sum.clone()]), self.writer.number(0.0));
                let has_direction = self.writer.apply(Greater, vec![length, zero]);
                let direction = self.writer.apply(Normalize, vec![sum]);
                self.writer.apply(IfV, vec![has_direction, direction, normal])
            }
            Variable::Bitangent => {
                let (normal, tangent) = (self.variable(Variable::Normal), self.variable(Variable::Tangent));
                self.writer.apply(Cross, vec![normal, tangent])
            }
            Variable::Alpha => self.angle(Variable::Normal, Variable::ToLight),
            Variable::Beta => self.angle(Variable::Mirrored, Variable::ToViewer),
            Variable::Gamma => self.angle(Variable::Normal, Variable::ToViewer),
            Variable::Normal
            | Variable::ToLight
            | Variable::ToViewer
            | Variable::Point
            | Variable::RelativeIndex
            | Variable::TotalReflection
            | Variable::Tangent
            | Variable::GeometricNormal
            | Variable::SurfaceU
            | Variable::SurfaceV
            | Variable::Distance
            | Variable::Visible
            | Variable::Radiance
            | Variable::SampleWeight
            | Variable::WeightedRadiance => return None,
        })
    }
}
