//! Where NaN comes from in a pixel: the innermost expression of the formula that is NaN although its operands are not.

use crate::evaluate::inspect::Inspector;
use crate::evaluate::inspect::figures::Quantity;
use crate::evaluate::inspect::report::{End, InspectedHit, InspectedLight, Inspection, Visibility};
use crate::formula::{Formula, Term, TermId};
use crate::lang::builtins::Form;
use crate::scene::{BodyId, LightId};

/// Where NaN comes from in a pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NanOrigin {
    /// The body at whose surface the formula is NaN.
    pub body: BodyId,
    /// The light for which it is.
    pub light: LightId,
    /// The macro or function in which the expression is typed; `None`: in the result.
    pub typed_in: Option<String>,
    /// The expression as it is typed: `sqrt(-COSINE)`.
    pub written: String,
    /// Its operation with rounded numbers for its operands: `sqrt(-0.8333)`.
    pub numbers: String,
}

impl Inspector<'_> {
    /// Where the NaN of a pixel comes from; `None` if the formula is NaN at no hit that adds to the pixel. Then there
    /// is none in the pixel, or infinite numbers of both signs are added up.
    pub fn nan_origin(&self, inspection: &Inspection) -> Option<NanOrigin> {
        let is_nan = |light: &&InspectedLight| {
            light.visibility == Visibility::Lit && light.contribution.iter().any(|component| component.is_nan())
        };
        let hits = inspection.rays.iter().filter(|ray| !ray.is_cut()).filter_map(|ray| match &ray.end {
            End::Hit(hit) => Some(hit),
            End::Background => None,
        });
        let found = hits.into_iter().find_map(|hit| hit.lights.iter().find(is_nan).map(|light| (hit, light)));
        found.map(|(hit, light)| self.origin_at(hit, light))
    }

    fn origin_at(&self, hit: &InspectedHit, light: &InspectedLight) -> NanOrigin {
        let formula = self.formula;
        let values = self.values_at(hit, light);
        let mut id = formula.result;
        // Operands have smaller numbers than their users, so this ends.
        while let Some(next) = nan_operand(formula, id, &values) {
            id = next;
        }
        let (typed_in, written) = formula.written.origin(id);
        let number = |operand: TermId| Quantity::new(formula.ty(operand), values[operand.0 as usize]).to_string();
        NanOrigin {
            body: hit.body(),
            light: light.light,
            typed_in: typed_in.map(str::to_owned),
            written,
            numbers: formula.with_operands(id, number),
        }
    }
}

/// The first operand of a term that is NaN, of those that its value depends on.
fn nan_operand(formula: &Formula, id: TermId, values: &[[f32; 3]]) -> Option<TermId> {
    let value = |id: TermId| &values[id.0 as usize];
    // Scalars stand three times.
    let component = value(id).iter().position(|component| component.is_nan())?;
    let is_nan = |id: &TermId| value(*id).iter().any(|component| component.is_nan());
    let is_nan_there = |id: &TermId| value(*id)[component].is_nan();
    match formula.term(id) {
        Term::Apply(operation, operands) | Term::ByComponents(operation, operands) => {
            match (operation.form(), operands.as_slice()) {
                // The branch that is not taken may be NaN.
                (Form::Conditional, [condition, then, other]) => {
                    let taken = if value(*condition)[component] == 0.0 { other } else { then };
                    [*condition, *taken].into_iter().find(is_nan_there)
                }
                _ => operands.iter().copied().find(is_nan_there).or_else(|| operands.iter().copied().find(is_nan)),
            }
        }
        Term::Number(_) | Term::Variable(_) | Term::Parameter(_) => None,
    }
}
