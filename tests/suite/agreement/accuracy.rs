//! The accuracy of the compiled elementary functions, in units in the last place: dense samples against double
//! precision.

use super::operations::{Operands, compiled, formula_of};
use illuminator::jit::Width;
use illuminator::lang::builtins::Operation;

/// The error of `got` in units in the last place of the exact result.
fn units(got: f32, exact: f64) -> f64 {
    let nearest = exact as f32;
    if got == nearest || (got.is_nan() && nearest.is_nan()) || !nearest.is_normal() {
        // At the ends of the range, rounding decides between a number and zero or infinity.
        return 0.0;
    }
    let unit = f64::from(f32::from_bits(nearest.abs().to_bits() + 1)) - f64::from(nearest.abs());
    (f64::from(got) - exact).abs() / unit
}

/// Numbers with magnitudes from 2^low to 2^high and both signs, evenly distributed over the bits.
fn spread(count: usize, low: i32, high: i32) -> Vec<f32> {
    let [first, last] = [low, high].map(|exponent| 2.0_f32.powi(exponent).to_bits());
    let bits = |index: usize| first + ((u64::from(last - first) * index as u64) / count as u64) as u32;
    (0..count).flat_map(|index| [f32::from_bits(bits(index)), -f32::from_bits(bits(index))]).collect()
}

/// The largest error of code for any width. Kernels of uniform values compute four numbers at a time.
fn worst(operation: Operation, cases: &[Vec<f32>], exact: impl Fn(&[f64]) -> f64) -> f64 {
    let error = |(case, got): (&Vec<f32>, [f32; 3])| {
        let numbers: Vec<f64> = case.iter().map(|number| f64::from(*number)).collect();
        units(got[0], exact(&numbers))
    };
    let largest = |width: Width, from: Operands| {
        let (formula, _) = formula_of(operation, from);
        cases.iter().zip(compiled(&formula, width, cases, from)).map(error).fold(0.0, f64::max)
    };
    let of_width = |width: Width| {
        let [narrow, wide] = [Operands::Uniforms, Operands::Columns].map(|from| largest(width, from));
        println!("{operation:?}, {width}: {narrow:.2} units in the last place of uniform values, {wide:.2} of columns");
        narrow.max(wide)
    };
    Width::supported().map(of_width).fold(0.0, f64::max)
}

#[test]
fn functions_of_one_number_are_accurate() {
    type Exact = fn(f64) -> f64;
    let functions: [(Operation, i32, i32, f64, Exact); 11] = [
        (Operation::Exp, -20, 7, 2.0, f64::exp),
        (Operation::Exp2, -20, 7, 2.0, f64::exp2),
        (Operation::Log, -125, 127, 2.0, f64::ln),
        (Operation::Log2, -125, 127, 2.5, f64::log2),
        (Operation::Sin, -40, 16, 2.5, f64::sin),
        (Operation::Cos, -40, 16, 2.5, f64::cos),
        (Operation::Tan, -40, 16, 4.0, f64::tan),
        (Operation::Asin, -40, 0, 3.0, f64::asin),
        (Operation::Acos, -40, 0, 3.0, f64::acos),
        (Operation::Atan, -40, 100, 2.0, f64::atan),
        (Operation::Sqrt, -125, 127, 0.5, f64::sqrt),
    ];
    for (operation, low, high, bound, exact) in functions {
        let cases: Vec<Vec<f32>> = spread(200_000, low, high).into_iter().map(|x| vec![x]).collect();
        let worst = worst(operation, &cases, |numbers| exact(numbers[0]));
        assert!(worst <= bound, "{operation:?} is off by {worst} units in the last place");
    }
}

#[test]
fn powers_and_angles_are_accurate() {
    let bases = spread(600, -30, 30);
    let exponents = spread(300, -8, 7);
    let pairs: Vec<Vec<f32>> = bases.iter().flat_map(|x| exponents.iter().map(move |y| vec![*x, *y])).collect();
    let power = worst(Operation::Pow, &pairs, |numbers| numbers[0].powf(numbers[1]));
    assert!(power <= 4.0, "pow is off by {power} units in the last place");
    let angle = worst(Operation::Atan2, &pairs, |numbers| numbers[0].atan2(numbers[1]));
    assert!(angle <= 2.5, "atan2 is off by {angle} units in the last place");
}
