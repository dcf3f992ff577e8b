//! Tests of unknown numbers.

use super::*;
use crate::lang::source::Source;

const TEXT: &str = "body_specific; a: scalar, constraint 0..1, default 0.25; b: scalar, constraint 0..1, default 0.5;
    c: scalar, constraint 0..1; h: scalar, constraint 1..1000, default 10; free: scalar, default 3; w: scalar, switch;
    invariants; a + b + c = 1; formula; = (a + 2*b + 3*c + h + free + w)*Cd;";

fn formula() -> Formula {
    Formula::parse(&Source::new("test", TEXT)).unwrap().0
}

fn unknowns(names: &[&str]) -> Result<Unknowns, UnknownsError> {
    let formula = formula();
    let free: Vec<FreeParameter> = names
        .iter()
        .map(|name| FreeParameter { parameter: formula.parameter_named(name).unwrap(), owner: 0, range: None })
        .collect();
    Unknowns::new(&formula, &free, &|id, _| formula.parameter(id).default)
}

#[test]
fn values_and_variables_belong_together() {
    let unknowns = unknowns(&["a", "b", "h", "free", "Cd"]).unwrap();
    assert_eq!((unknowns.free(), unknowns.numbers().len()), (7, 8));
    let start = unknowns.start();
    assert_eq!(start[..4], [0.25, 0.5, 10.0, 3.0]);
    assert!((start[7] - 0.25).abs() < 1e-12, "c follows: {start:?}");
    let values = unknowns.values(&unknowns.variables(&start));
    assert!(values.iter().zip(&start).all(|(one, other)| (one - other).abs() < 1e-9), "{values:?} {start:?}");
    // Whatever the variables are, values are within the bounds.
    let values = unknowns.values(&[40.0, -3.0, 1e3, 0.0, 9.0, 8.0, 7.0]);
    assert!((0.0..=1.0).contains(&values[0]) && (1.0..=1000.0).contains(&values[2]));
    assert!((unknowns.values(&unknowns.start_at(&[0.5; 7]))[2] - 1000.0_f64.sqrt()).abs() < 1e-6, "a logarithmic middle");
}

#[test]
fn equations_follow_the_chain() {
    let unknowns = unknowns(&["a", "h"]).unwrap();
    let variables = unknowns.variables(&[0.3, 20.0]);
    // One residual: 2a + 3h + 5c, with its derivatives.
    let at = |variables: &[f64]| {
        let values = unknowns.values(variables);
        2.0 * values[0] + 3.0 * values[1] + 5.0 * values[2]
    };
    let mut equations = NormalEquations::new(3);
    equations.add(1.0, &[2.0, 3.0, 5.0, at(&variables)]);
    let gradient = unknowns.in_variables(&equations, &variables, 1.0).curvature();
    for index in 0..2 {
        let mut moved = variables.clone();
        moved[index] += 1e-6;
        let slope = (at(&moved) - at(&variables)) / 1e-6;
        assert!((gradient[(index, index)].sqrt() - slope.abs()).abs() < 1e-4 * slope.abs(), "{index}");
    }
}

#[test]
fn invariants_that_are_violated_count() {
    let unknowns = unknowns(&["a", "b"]).unwrap();
    let mut equations = NormalEquations::new(3);
    equations.add(1.0, &[0.0, 0.0, 0.0, 1.0]);
    let square = |values: &[f64]| unknowns.in_variables(&equations, &unknowns.variables(values), 100.0).square();
    assert_eq!(square(&[0.5, 0.4]), 1.0);
    assert!(square(&[0.8, 0.5]) > 5.0, "c would be -0.3");
}

#[test]
fn values_are_moved_to_where_invariants_hold() {
    let unknowns = unknowns(&["a", "b", "h"]).unwrap();
    let settled = unknowns.settled(&[0.8, 0.4, 10.0]);
    // c would be -0.2: a and b give way alike.
    assert!(settled.iter().zip([0.7, 0.3, 10.0, 0.0]).all(|(found, wanted)| (found - wanted).abs() < 1e-9), "{settled:?}");
    assert_eq!(unknowns.settled(&[0.3, 0.4, 10.0])[..3], [0.3, 0.4, 10.0]);
    assert_eq!((unknowns.bound_at(0, 1.0), unknowns.bound_at(0, 0.5), unknowns.bound_at(2, 1.0)), (Some(1), None, Some(0)));
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    assert_eq!(unknowns(&[]), Err(UnknownsError::Nothing));
    assert!(matches!(unknowns(&["w"]), Err(UnknownsError::NotSmooth(..))));
    let message = unknowns(&["c"]).unwrap_err().to_string();
    assert!(message.contains("c = 1 - a - b"), "{message}");
    let formula = formula();
    let a = FreeParameter { parameter: formula.parameter_named("a").unwrap(), owner: 0, range: Some([0.5, 2.0]) };
    let error = Unknowns::new(&formula, &[a], &|_, _| [0.0; 3]);
    assert!(matches!(error, Err(UnknownsError::Bounds(..))), "{error:?}");
    let error = Unknowns::new(&formula, &[FreeParameter { range: Some([0.5, 0.2]), ..a }], &|_, _| [0.0; 3]);
    assert!(matches!(error, Err(UnknownsError::Order(..))), "{error:?}");
    let whole = FreeParameter { range: None, ..a };
    let error = Unknowns::new(&formula, &[whole, whole], &|_, _| [0.0; 3]);
    assert_eq!(error, Err(UnknownsError::Twice("a".to_owned())));
}
