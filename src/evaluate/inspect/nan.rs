//! Where NaN comes from in a pixel: the innermost expression of the formula that is NaN although its operands are not,
//! or a product or a sum of infinite numbers.

use crate::evaluate::inspect::Inspector;
use crate::evaluate::inspect::figures::Quantity;
use crate::evaluate::inspect::report::{End, InspectedHit, InspectedLight, Inspection, Onward};
use crate::formula::equation::weighed_by;
use crate::formula::{Formula, Term, TermId};
use crate::lang::builtins::Form;
use crate::lang::surface_terms::SurfaceTerm;
use crate::scene::{BodyId, LightId};

/// Why a pixel is NaN.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NanCause {
    /// An expression of the formula is NaN.
    Expression(NanOrigin),
    /// At the surface of this body, an infinite number is multiplied by a weight of 0.
    InfiniteTimesZero(BodyId),
    /// Infinite numbers of both signs are added up.
    BothSigns,
}

/// The expression that is NaN.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NanOrigin {
    /// The body at whose surface it is NaN.
    pub body: BodyId,
    /// The light for which it is; `None`: it is evaluated once for the surface, whatever the lights.
    pub light: Option<LightId>,
    /// The macro or function in which the expression is typed; `None`: in the result.
    pub typed_in: Option<String>,
    /// The expression as it is typed: `sqrt(-COSINE)`.
    pub written: String,
    /// Its operation with rounded numbers for its operands: `sqrt(-0.8333)`.
    pub numbers: String,
}

fn has_nan(light: [f32; 3]) -> bool {
    light.into_iter().any(f32::is_nan)
}

impl Inspector<'_> {
    /// Why a pixel is NaN; `None` if it is not, or if the cause is not found.
    pub fn nan_cause(&self, inspection: &Inspection) -> Option<NanCause> {
        // Children come after their parents, so this ends.
        let mut index = 0;
        loop {
            let ray = inspection.rays.get(index).filter(|ray| has_nan(ray.total))?;
            let End::Hit(hit) = &ray.end else { return None };
            if has_nan(ray.own) {
                return self.cause_of_own(hit);
            }
            let children = [(hit.reflected, SurfaceTerm::Reflected), (hit.refracted, SurfaceTerm::Refracted)];
            let children = children.into_iter().filter_map(|(onward, term)| match onward {
                Onward::Ray(child) => Some((child, inspection.rays.get(child)?, term)),
                Onward::Matte | Onward::Opaque | Onward::TotalReflection | Onward::Depth => None,
            });
            let found = children.into_iter().find(|(_, child, _)| has_nan(weighed_by(child.factor, child.total)));
            match found {
                None => return Some(NanCause::BothSigns),
                Some((_, child, term)) if has_nan(child.factor) => return self.cause_of_term(hit, term),
                Some((next, child, _)) if has_nan(child.total) => index = next,
                Some(_) => return Some(NanCause::InfiniteTimesZero(hit.body())),
            }
        }
    }

    /// Why the light of a hit itself is NaN.
    fn cause_of_own(&self, hit: &InspectedHit) -> Option<NanCause> {
        if let Some(light) = hit.lights.iter().find(|light| has_nan(light.contribution)) {
            return self.cause_of_light(hit, light);
        }
        let terms = [(SurfaceTerm::Ambient, hit.ambient), (SurfaceTerm::Emission, hit.emission.unwrap_or_default())];
        match terms.into_iter().find(|(_, value)| has_nan(*value)) {
            Some((term, _)) => self.cause_of_term(hit, term),
            None => Some(NanCause::BothSigns),
        }
    }

    fn cause_of_light(&self, hit: &InspectedHit, light: &InspectedLight) -> Option<NanCause> {
        if has_nan(light.local) {
            let values = self.values_at(hit, light);
            return Some(self.origin_at(hit, Some(light.light), self.formula.result, &values));
        }
        let is_infinite = light.local.into_iter().any(f32::is_infinite);
        (is_infinite && light.sample.weight == 0.0).then(|| NanCause::InfiniteTimesZero(hit.body()))
    }

    fn cause_of_term(&self, hit: &InspectedHit, term: SurfaceTerm) -> Option<NanCause> {
        let root = self.formula.surface.get(term)?;
        let value = |symbol| hit.variables.value(symbol).unwrap_or_default();
        let values = self.values(self.formula, hit.body(), None, &value);
        Some(self.origin_at(hit, None, root, &values))
    }

    fn origin_at(&self, hit: &InspectedHit, light: Option<LightId>, root: TermId, values: &[[f32; 3]]) -> NanCause {
        let formula = self.formula;
        let mut id = root;
        // Operands have smaller numbers than their users, so this ends.
        while let Some(next) = nan_operand(formula, id, values) {
            id = next;
        }
        let (typed_in, written) = formula.written.origin(id);
        let number = |operand: TermId| Quantity::new(formula.ty(operand), values[operand.0 as usize]).to_string();
        NanCause::Expression(NanOrigin {
            body: hit.body(),
            light,
            typed_in: typed_in.map(str::to_owned),
            written,
            numbers: formula.with_operands(id, number),
        })
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
        Term::Number(_) | Term::Variable(_) | Term::Parameter(_) | Term::Material(_) => None,
    }
}
