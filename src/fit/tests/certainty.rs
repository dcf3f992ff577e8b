//! What a fit says of its values: invariants that bind, numbers that are open, and how exact the others are.

use crate::fit::Misfit;
use crate::fit::normal::NormalEquations;
use crate::fit::solve::{FitOptions, Solution, solve};
use crate::fit::tests::fit_to;
use crate::fit::unknowns::{FitNumber, FreeParameter, LimitOrigin, Unknowns};
use crate::formula::Formula;
use crate::instrument::model::default_numbers;
use crate::lang::source::Source;
use std::sync::atomic::AtomicBool;

/// Residuals that are sums of the values: each row has a factor for each value, and what is wanted.
struct LinearMisfit(Vec<Vec<f64>>);

impl Misfit for LinearMisfit {
    fn evaluate_into(&self, values: &[f64], none: &NormalEquations) -> NormalEquations {
        let mut equations = none.clone();
        for row in &self.0 {
            let (wanted, factors) = row.split_last().unwrap();
            let found: f64 = factors.iter().zip(values).map(|(factor, value)| factor * value).sum();
            let mut row = factors.to_vec();
            row.push(found - wanted);
            equations.add(1.0, &row);
            equations.count(1, 1.0);
        }
        equations
    }
}

const TWO: &str = "body_specific; kd: scalar, constraint 0..1, default 0.2; ks: scalar, constraint 0..1, default 0.3;";

/// Fits two numbers, from several starts.
fn fit_linear(invariants: &str, names: &[&str], rows: &[&[f64]]) -> Solution {
    let text = format!("{TWO} {invariants} formula; = IL*max(0, N.L)*<kd + ks>;");
    let (formula, _) = Formula::parse(&Source::new("test", &text)).unwrap();
    let start = default_numbers(&formula);
    let free: Vec<FreeParameter> = names
        .iter()
        .map(|name| FreeParameter { parameter: formula.parameter_named(name).unwrap(), owner: 0, range: None })
        .collect();
    let unknowns = Unknowns::new(&formula, &free, &|id, _| start[id.0 as usize]).unwrap();
    let misfit = LinearMisfit(rows.iter().map(|row| row.to_vec()).collect());
    solve(&misfit, &unknowns, FitOptions { starts: 2 }, &|_| (), &AtomicBool::new(false))
}

fn near(found: &[f64], wanted: &[f64]) -> bool {
    found.len() == wanted.len() && found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-6)
}

#[test]
fn an_invariant_that_binds_is_an_equality() {
    // The least (2·kd - 1.6)² + (ks - 0.7)². Where kd + ks = 1, it is at 4·(kd - 0.8) = ks - 0.7.
    let rows: [&[f64]; 2] = [&[2.0, 0.0, 1.6], &[0.0, 1.0, 0.7]];
    let solution = fit_linear("invariants; kd + ks <= 1;", &["kd", "ks"], &rows);
    assert!(near(&solution.values, &[0.7, 0.3]), "{solution:?}");
    // Residuals of -0.2 and -0.4, with the slopes 2 and -1 by kd: √((0.04·4 + 0.16)·2) / 5.
    let deviations: Vec<f64> = solution.deviations.iter().flatten().copied().collect();
    assert!(near(&deviations, &[0.16, 0.16]), "{solution:?}");
    assert!(matches!(&solution.binding[..], [(LimitOrigin::Sum(numbers), 1)] if numbers.len() == 2), "{solution:?}");
    // Every start ends at values that are allowed, and has their residual.
    for start in &solution.starts {
        assert!(start.values.iter().sum::<f64>() <= 1.0 + 1e-9, "{start:?}");
        let square = (2.0 * start.values[0] - 1.6).powi(2) + (start.values[1] - 0.7).powi(2);
        assert!(near(&[start.residual], &[(square / 2.0).sqrt()]), "{start:?}");
    }
    let inside = fit_linear("invariants; kd + ks <= 1;", &["kd", "ks"], &[&[2.0, 0.0, 0.8], &[0.0, 1.0, 0.5]]);
    assert!(near(&inside.values, &[0.4, 0.5]) && inside.binding.is_empty(), "{inside:?}");
}

#[test]
fn invariants_bind_beside_ranges_and_for_one_number() {
    // Along kd + ks = 1 the least is at kd = 1.3, which its range does not let it reach.
    let solution = fit_linear("invariants; kd + ks <= 1;", &["kd", "ks"], &[&[1.0, 0.0, 1.9], &[0.0, 1.0, 0.3]]);
    assert!(near(&solution.values, &[1.0, 0.0]), "{solution:?}");
    assert_eq!(solution.ends, [Some(1), Some(0)]);
    // With ks = 0.3, kd can be 0.7 at most.
    let solution = fit_linear("invariants; kd + ks <= 1;", &["kd"], &[&[1.0, 0.9], &[2.0, 1.9]]);
    assert!(near(&solution.values, &[0.7]) && solution.binding.len() == 1, "{solution:?}");
    assert_eq!((&solution.ends[..], &solution.deviations[..]), (&[Some(1)][..], &[None][..]));
}

fn names(formula: &Formula, numbers: &[FitNumber]) -> Vec<String> {
    numbers.iter().map(|number| formula.parameter(number.parameter).name.clone()).collect()
}

const FOUR: &str = "body_specific; a: scalar, constraint 0..1, default 0.5; b: scalar, constraint 0..1, default 0.4;
    c: scalar, constraint 0..1, default 0.7; h: scalar, constraint 1..200, default 20;";

#[test]
fn what_has_no_effect_at_a_bound_stays_where_it_was() {
    // Without a highlight, its exponent says nothing.
    let text = format!("{FOUR} formula; = IL*max(0, N.L)*<a + b*(max(0, N.H))^h>;");
    let data = format!("{FOUR} formula; = IL*max(0, N.L)*<0.3 - 0.2*(max(0, N.H))^50>;");
    let (formula, solution) = fit_to(&text, &data, &["a", "b", "h"]);
    assert_eq!(solution.values[1..], [0.0, 20.0], "{solution:?}");
    assert_eq!((solution.ends[1], solution.deviations[2]), (Some(0), None));
    assert_eq!(names(&formula, &solution.undetermined.concat()), ["h"]);
    assert!(solution.deviations[0].is_some());
}

#[test]
fn what_has_an_effect_elsewhere_is_no_threshold() {
    // The lobe of c is 0 where c is 0, and so is its slope. That of b is never anything else.
    let lobe = FOUR.replace("default 0.7", "default 0").replace("c: scalar, constraint 0..1", "c: scalar, constraint -1..1");
    let text = format!("{lobe} formula; = IL*max(0, N.L)*<a + max(0, c*(N.V))^3> + 0*<b>;");
    let data = format!("{FOUR} formula; = IL*max(0, N.L)*<0.3>;");
    let (formula, solution) = fit_to(&text, &data, &["a", "b", "c"]);
    assert_eq!(names(&formula, &solution.elsewhere), ["c"], "{solution:?}");
    assert!(solution.stepwise.is_empty() && solution.undetermined.len() == 2, "{solution:?}");
    assert_eq!(solution.values[1..], [0.4_f32, 0.0].map(f64::from));
}

#[test]
fn independent_products_are_groups_of_their_own() {
    let text = format!("{FOUR} d: scalar, constraint 0..1, default 0.6; formula; = IL*max(0, N.L)*<a*b + c*d*(N.V)^2>;");
    let data = format!("{FOUR} formula; = IL*max(0, N.L)*<0.3 + 0.1*(N.V)^2>;");
    let (formula, solution) = fit_to(&text, &data, &["a", "c", "b", "d"]);
    let mut groups: Vec<Vec<String>> = solution.undetermined.iter().map(|group| names(&formula, group)).collect();
    groups.iter_mut().for_each(|group| group.sort());
    assert_eq!(groups, [["a", "b"], ["c", "d"]], "{solution:?}");
}

/// Numbers with a normal distribution: a generator by Marsaglia (2003), and sums of twelve of its numbers.
struct NormalNumbers(u64);

impl NormalNumbers {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

#[test]
fn deviations_hold_for_noise_that_grows_with_the_value() {
    // y = kd·x with a noise of 5 % of y, for x over two decades. If all data had the same noise, the deviation would be
    // √(n·Σx⁴)/Σx² = 2.1 times smaller, and 64 % of the values would lie within 1.96 deviations of the truth.
    let mut noise = NormalNumbers(0x2545_f491_4f6c_dd1d);
    let (truth, repetitions) = (0.6, 1000);
    let within = (0..repetitions).filter(|_| {
        let row = |index: i32| {
            let x = 10.0_f64.powf(f64::from(index) / 100.0 - 1.0);
            vec![x, truth * x * (1.0 + 0.05 * noise.next())]
        };
        let rows: Vec<Vec<f64>> = (0..200).map(row).collect();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let solution = fit_linear("", &["kd"], &rows);
        (solution.values[0] - truth).abs() <= 1.96 * solution.deviations[0].unwrap()
    });
    let share = within.count() as f64 / f64::from(repetitions);
    assert!((0.92..=0.97).contains(&share), "{share}");
}
