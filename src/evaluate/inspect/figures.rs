//! Numbers rounded for readers: four significant digits, without trailing zeros.
//!
//! Code that calculates further must use the exact numbers.

use crate::lang::types::Type;
use std::fmt;

/// How many digits are written.
const DIGITS: usize = 4;
/// A component is written as 0 if it is smaller than this share of the largest one. Rounding leaves such components in
/// a direction along an axis.
const NOTHING: f64 = 1e-6;
/// Powers of ten of the first digit within which numbers are written out.
const WRITTEN_OUT: std::ops::RangeInclusive<i32> = -4..=5;

/// A number rounded to four significant digits: `0.8333`, `12350`, `1.235e6`, `NaN`, `-inf`.
pub fn figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        // Without the sign of −0.
        return (value + 0.0).to_string();
    }
    let rounded = format!("{value:.places$e}", places = DIGITS - 1);
    let (digits, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    if exponent.parse().is_ok_and(|exponent: i32| WRITTEN_OUT.contains(&exponent)) {
        // The shortest text of the rounded number has no digits beyond those.
        return rounded.parse().map_or(rounded, |rounded: f64| rounded.to_string());
    }
    let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    format!("{digits}e{exponent}")
}

/// A vector rounded in the same way: `<0.6, 0, 0.8>`. A component that is tiny beside the largest one is written as 0.
pub fn vector_figures(vector: [f64; 3]) -> String {
    let largest = vector.iter().map(|component| component.abs()).filter(|size| size.is_finite()).fold(0.0, f64::max);
    let [x, y, z] = vector.map(|component| figures(if component.abs() < NOTHING * largest { 0.0 } else { component }));
    format!("<{x}, {y}, {z}>")
}

/// A number or a vector of a formula.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quantity {
    /// A number.
    Scalar(f32),
    /// Three numbers.
    Vector([f32; 3]),
}

impl Quantity {
    /// A quantity of this type. A scalar is the first component.
    pub(super) fn new(ty: Type, value: [f32; 3]) -> Self {
        match ty {
            Type::Scalar | Type::Truth | Type::Texture => Quantity::Scalar(value[0]),
            Type::Vector => Quantity::Vector(value),
        }
    }
}

/// Writes it rounded.
impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Quantity::Scalar(value) => f.write_str(&figures(f64::from(*value))),
            Quantity::Vector(value) => f.write_str(&vector_figures(value.map(f64::from))),
        }
    }
}

/// A weight of red, green and blue: one number if it is the same for all of them.
pub fn weight_figures(weight: [f64; 3]) -> String {
    if weight == [weight[0]; 3] { figures(weight[0]) } else { vector_figures(weight) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_digits_and_no_more_zeros_than_needed() {
        for (value, text) in [
            (0.833_333, "0.8333"),
            (0.45, "0.45"),
            (-0.0, "0"),
            (-2.0, "-2"),
            (12_345.678, "12350"),
            (999_960.0, "1e6"),
            (1.234_56e6, "1.235e6"),
            (-0.000_123_46, "-0.0001235"),
            (1e-5, "1e-5"),
            (1.5e-20, "1.5e-20"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(figures(value), text);
        }
        assert_eq!(figures(f64::from(0.6_f32)), "0.6");
    }

    #[test]
    fn what_rounding_leaves_of_an_axis_is_nothing() {
        assert_eq!(vector_figures([6e-17, 1.0, -0.25]), "<0, 1, -0.25>");
        assert_eq!(vector_figures([1e-20, 0.0, 0.0]), "<1e-20, 0, 0>");
        assert_eq!(vector_figures([f64::INFINITY, 1.0, f64::NAN]), "<inf, 1, NaN>");
    }
}
