//! A formula at one point, without a scene: the values of its terms for directions and parameters that the caller
//! gives, by the reference meaning.

use crate::formula::{Formula, ParameterId, Term};
use crate::lang::builtins::Stack;
use crate::lang::scalars::flush;
use crate::lang::variables::Variable;
use glam::DVec3;

/// The values of all terms of a formula, from those of its variables and parameters. Scalars are repeated three times,
/// here and there.
pub fn term_values(
    formula: &Formula,
    variable: &dyn Fn(Variable) -> [f32; 3],
    parameter: &dyn Fn(ParameterId) -> [f32; 3],
) -> Vec<[f32; 3]> {
    let mut values: Vec<[f32; 3]> = Vec::with_capacity(formula.terms.len());
    let mut stack = Stack::new(16, 0.0);
    let mut operands_at_hand = Vec::new();
    for term in &formula.terms {
        values.push(match term {
            Term::Number(value) => [flush(*value); 3],
            Term::Variable(symbol) => variable(*symbol).map(flush),
            Term::Parameter(id) => parameter(*id),
            Term::Material(id) => [formula.material(*id).number; 3],
            Term::Apply(operation, operands) => {
                operands_at_hand.clear();
                operands_at_hand.extend(operands.iter().map(|operand| values[operand.0 as usize]));
                operation.on_numbers(&operands_at_hand, &mut stack)
            }
            Term::ByComponents(operation, operands) => std::array::from_fn(|component| {
                operands_at_hand.clear();
                operands_at_hand.extend(operands.iter().map(|operand| [values[operand.0 as usize][component]; 3]));
                operation.on_numbers(&operands_at_hand, &mut stack)[0]
            }),
        });
    }
    values
}

/// The value of a variable at a point of which some variables are given. Others follow from them, as at a hit: `R` from
/// N and L, for instance. Scalars are repeated three times. What does not follow from others is plain: N is
/// <0, 0, 1>, `Ng` is N, T is perpendicular to N and as close to <1, 0, 0> as possible, the point is the origin, the
/// light is visible and at a distance of 1, and the index does not change. `None` if L or V is needed and not given.
pub fn variable_at_point(variable: Variable, given: &dyn Fn(Variable) -> Option<DVec3>) -> Option<DVec3> {
    if let Some(value) = given(variable) {
        return Some(value);
    }
    let of = |variable: Variable| variable_at_point(variable, given);
    let angle = |one: Variable, other: Variable| Some(DVec3::splat(of(one)?.dot(of(other)?).clamp(-1.0, 1.0).acos()));
    match variable {
        Variable::Normal => Some(DVec3::Z),
        Variable::ToLight | Variable::ToViewer => None,
        Variable::Mirrored => {
            let (normal, light) = (of(Variable::Normal)?, of(Variable::ToLight)?);
            Some(2.0 * normal.dot(light) * normal - light)
        }
        Variable::Halfway => {
            let sum = of(Variable::ToLight)? + of(Variable::ToViewer)?;
            sum.try_normalize().or_else(|| of(Variable::Normal))
        }
        Variable::Alpha => angle(Variable::Normal, Variable::ToLight),
        Variable::Beta => angle(Variable::Mirrored, Variable::ToViewer),
        Variable::Gamma => angle(Variable::Normal, Variable::ToViewer),
        Variable::GeometricNormal => of(Variable::Normal),
        Variable::Tangent => {
            let normal = of(Variable::Normal)?;
            let across = |axis: DVec3| (axis - normal * normal.dot(axis)).try_normalize();
            Some(across(DVec3::X).or_else(|| across(DVec3::Y)).unwrap_or(DVec3::X))
        }
        Variable::Bitangent => Some(of(Variable::Normal)?.cross(of(Variable::Tangent)?)),
        Variable::Point | Variable::SurfaceU | Variable::SurfaceV | Variable::TotalReflection => Some(DVec3::ZERO),
        Variable::Distance
        | Variable::Visible
        | Variable::RelativeIndex
        | Variable::Radiance
        | Variable::SampleWeight
        | Variable::WeightedRadiance => Some(DVec3::ONE),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;

    #[test]
    fn variables_follow_from_directions() {
        let (light, view) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.6, 0.0, 0.8));
        let directions = [(Variable::ToLight, light), (Variable::ToViewer, view)];
        let given = |variable| directions.iter().find(|(known, _)| *known == variable).map(|(_, direction)| *direction);
        let of = |variable: Variable| variable_at_point(variable, &given).unwrap();
        assert_eq!(of(Variable::Normal), DVec3::Z);
        assert!(of(Variable::Mirrored).abs_diff_eq(view, 1e-15));
        assert!(of(Variable::Halfway).abs_diff_eq(DVec3::Z, 1e-15));
        assert!((of(Variable::Alpha).x - 0.8_f64.acos()).abs() < 1e-15);
        assert!(of(Variable::Beta).x < 1e-7);
        assert_eq!((of(Variable::Tangent), of(Variable::Bitangent)), (DVec3::X, DVec3::Y));
        assert!(Variable::ALL.iter().all(|variable| of(*variable).is_finite()));
        let of_nothing = |variable: Variable| variable_at_point(variable, &|_| None);
        assert_eq!((of_nothing(Variable::Mirrored), of_nothing(Variable::Tangent)), (None, Some(DVec3::X)));
    }

    #[test]
    fn a_formula_has_its_value_at_a_point() {
        let text = "body_specific; kd: scalar; formula; D = kd*max(0, N.L); = <D, 2*D, alpha>;";
        let (formula, _) = Formula::parse(&Source::new("test", text)).unwrap();
        let given = |variable: Variable| (variable == Variable::ToLight).then_some(DVec3::new(0.0, 0.6, 0.8));
        let variable = |variable: Variable| variable_at_point(variable, &given).unwrap().as_vec3().to_array();
        let values = term_values(&formula, &variable, &|_| [0.5; 3]);
        let [first, second, third] = values[formula.result.0 as usize];
        assert!((first - 0.4).abs() < 1e-7 && (second - 0.8).abs() < 1e-7 && (third - 0.8_f32.acos()).abs() < 1e-6);
        assert!((values[formula.macros[0].1.0 as usize][0] - 0.4).abs() < 1e-7);
    }
}
