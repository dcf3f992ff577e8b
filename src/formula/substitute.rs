//! The same formula with a measured material in place of its result, for some bodies.

use crate::formula::{Formula, MaterialFile, MaterialId, Parameter, ParameterId, Term, TermId};
use crate::lang::source::Source;
use crate::lang::variables::{Owner, Predefined};

/// What takes the place of the result. `Cd` stands for the result that bodies have whose switch is 0.
const TEXT: &str = "body_specific; own: scalar; formula; = if(own > 0.5, IL*measured(\"material\")*max(0, N.L), Cd);";

/// The name of the switch. No formula can declare it.
const SWITCH: &str = "is measured";

impl Formula {
    /// The same formula with one more parameter of bodies: where it is 1, lights add what the measured material of this
    /// number reflects, π·f·cos θ times `IL`, in place of the result. Ambient light, emission and the weights of rays
    /// stay those of the formula. `None` if it has too many parameters.
    pub fn with_measured(&self, path: &str, number: f32) -> Option<(Formula, ParameterId)> {
        let (own, _) = Formula::parse(&Source::new("measured", TEXT)).ok()?;
        let switch = own.parameter_named("own")?;
        let body_colour = own.predefined(Predefined::BodyColour);
        let mut result = self.clone();
        let id = ParameterId(u32::try_from(result.parameters.len()).ok()?);
        let of_bodies = self.parameters.iter().filter(|parameter| parameter.owner == Owner::Body);
        let slot = of_bodies.map(|parameter| parameter.slot + parameter.ty.slots() as u32).max().unwrap_or(0);
        result.parameters.push(Parameter { name: SWITCH.to_owned(), slot, ..own.parameter(switch).clone() });
        let material = MaterialId(u32::try_from(result.materials.len()).ok()?);
        let named = own.materials.first()?;
        result.materials.push(MaterialFile { path: path.to_owned(), number, ..named.clone() });
        let first = u32::try_from(result.terms.len()).ok()?;
        let stands_in = |term: &TermId| *own.term(*term) == Term::Parameter(body_colour);
        let moved = |term: &TermId| if stands_in(term) { self.result } else { TermId(first + term.0) };
        for term in &own.terms {
            let all = |operands: &[TermId]| operands.iter().map(moved).collect();
            result.terms.push(match term {
                Term::Number(_) | Term::Variable(_) => term.clone(),
                Term::Parameter(parameter) if *parameter == switch => Term::Parameter(id),
                // The predefined parameters are the first ones of each formula.
                Term::Parameter(parameter) => Term::Parameter(*parameter),
                Term::Material(_) => Term::Material(material),
                Term::Apply(operation, operands) => Term::Apply(*operation, all(operands)),
                Term::ByComponents(operation, operands) => Term::ByComponents(*operation, all(operands)),
            });
        }
        result.result = moved(&own.result);
        Some((result, id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::at_point::term_values;
    use crate::lang::variables::Variable;

    #[test]
    fn a_switch_chooses_between_the_formula_and_the_material() {
        let text = "body_specific; kd: scalar, default 0.25; formula; HALF = 0.5*kd; = HALF*IL*Cd*max(0, N.L);";
        let (formula, _) = Formula::parse(&Source::new("test", text)).unwrap();
        // Material 0 reflects nothing.
        let (twin, switch) = formula.with_measured("gold.binary", 0.0).unwrap();
        assert_eq!((twin.parameter(switch).name.as_str(), twin.materials[0].path.as_str()), (SWITCH, "gold.binary"));
        assert_eq!(twin.parameter(switch).slot as usize + 1, twin.slots(Owner::Body));
        let values = |formula: &Formula, own: f32| {
            let is_upright = |variable| matches!(variable, Variable::ToLight | Variable::ToViewer | Variable::Normal);
            let variable = |variable| if is_upright(variable) { [0.0, 0.0, 1.0] } else { [0.0; 3] };
            let parameter = |id: ParameterId| if id == switch { [own; 3] } else { formula.parameter(id).default };
            term_values(formula, &variable, &parameter)[formula.result.0 as usize]
        };
        assert_eq!(values(&twin, 0.0), values(&formula, 0.0));
        assert!(values(&formula, 0.0)[0] > 0.0);
        assert_eq!(values(&twin, 1.0), [0.0; 3]);
    }
}
