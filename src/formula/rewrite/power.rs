//! Powers of static bases: xʸ = 2^(y·log₂|x|), with the sign of a negative base. The logarithm is static, so a frame
//! computes a product and a power of 2.

use super::Rewriter;
use crate::formula::binding_time::BindingTime;
use crate::formula::graph::NodeId;
use crate::formula::linear::LinearForm;
use crate::lang::interval::Interval;
use crate::lang::scalars::Primitive;

/// The largest logarithm of a power of a cosine that exceeds 1 only by rounding.
const LARGEST_ROUNDED_LOGARITHM: f64 = 60.0;
/// The smallest magnitude of an exponent other than 0.
const SMALLEST_EXPONENT: f32 = 1e-36;

/// Whether a power by a logarithm in single precision is accurate enough. Its relative error grows with the logarithm
/// of the power. If the base is at most 1, a power with a large logarithm is nearly 0, or, with a negative exponent,
/// larger than any colour.
fn is_accurate(base: Interval, exponent: Interval) -> bool {
    const LARGEST_BASE: f64 = 1.0 + 1e-5;
    const LARGEST_LOGARITHM: f64 = 8.0;
    let logarithm = if base.low > 0.0 { base.low.log2().abs().max(base.high.log2().abs()) } else { f64::INFINITY };
    base.magnitude() <= LARGEST_BASE || logarithm * exponent.magnitude() <= LARGEST_LOGARITHM
}

impl Rewriter<'_> {
    /// The power of rewritten operands.
    pub(super) fn power(&mut self, base: NodeId, exponent: NodeId) -> NodeId {
        let (x, y) = (self.interval(base), self.interval(exponent));
        let varies = matches!(self.time(exponent), BindingTime::Uniform | BindingTime::Dynamic);
        if !self.is_static(base) || !varies || x.nan || y.nan || !is_accurate(x, y) {
            return self.record(Primitive::Pow, &[base, exponent]);
        }
        // 0 has a finite logarithm here, so that its product with 0 is 0: x⁰ is 1 for 0 and ∞ too.
        let magnitude = if x.not_negative() { base } else { self.record(Primitive::Abs, &[base]) };
        let logarithm = self.record(Primitive::Log2, &[magnitude]);
        let (least, largest) = (self.constant(f32::MIN), self.constant(f32::MAX));
        let logarithm = self.record(Primitive::Max, &[least, logarithm]);
        let logarithm = self.record(Primitive::Min, &[largest, logarithm]);
        let bounded = self.bounded_exponent(exponent);
        let mut product = self.record(Primitive::Mul, &[bounded, logarithm]);
        // If a cosine exceeds 1 by rounding, its power grows with the exponent without bounds. The exact power is at
        // most 1, and the power of the next smaller number is nearly 0. So the result is arbitrary, and a bounded one
        // can be multiplied out. With a negative exponent, a large power is exact for a base below 1, and must stay.
        let at_most_one = self.exact_intervals[base.0 as usize].high <= 1.0 && y.low >= 0.0;
        if x.high > 1.0 && at_most_one && self.interval(product).high > LARGEST_ROUNDED_LOGARITHM {
            let largest = self.constant(LARGEST_ROUNDED_LOGARITHM as f32);
            product = self.record(Primitive::Min, &[largest, product]);
        }
        let power = self.record(Primitive::Exp2, &[product]);
        if x.not_negative() && (y.low >= 0.0 || !x.negative_zero) {
            return power;
        }
        let sign = self.sign_of_power(base, exponent);
        self.record(Primitive::Mul, &[sign, power])
    }

    /// The exponent, clamped to ±`f32::MAX`, and to a magnitude of at least [`SMALLEST_EXPONENT`] if it is not 0. So
    /// its product with the logarithm of 0 or ∞ is outside the range of 2ˣ, and its product with the logarithm of 1 is
    /// 0.
    fn bounded_exponent(&mut self, exponent: NodeId) -> NodeId {
        let interval = self.interval(exponent);
        let mut bounded = exponent;
        if interval.low < f64::from(SMALLEST_EXPONENT) && interval.high > f64::from(-SMALLEST_EXPONENT) {
            let [zero, up, down] = [0.0, SMALLEST_EXPONENT, -SMALLEST_EXPONENT].map(|value| self.constant(value));
            bounded = zero;
            if interval.low < 0.0 {
                let at_most = self.record(Primitive::Min, &[down, exponent]);
                let negative = self.record(Primitive::Less, &[exponent, zero]);
                bounded = self.record(Primitive::Select, &[negative, at_most, bounded]);
            }
            if interval.high > 0.0 {
                let at_least = self.record(Primitive::Max, &[up, exponent]);
                let positive = self.record(Primitive::Less, &[zero, exponent]);
                bounded = self.record(Primitive::Select, &[positive, at_least, bounded]);
            }
        }
        if interval.high == f64::INFINITY {
            let largest = self.constant(f32::MAX);
            bounded = self.record(Primitive::Min, &[largest, bounded]);
        }
        if interval.low == f64::NEG_INFINITY {
            let least = self.constant(f32::MIN);
            bounded = self.record(Primitive::Max, &[least, bounded]);
        }
        bounded
    }

    /// The factor of |x|ʸ where x may be negative or −0: 1, −1, or NaN.
    fn sign_of_power(&mut self, base: NodeId, exponent: NodeId) -> NodeId {
        let class = self.class_of_base(base);
        let [half, one, minus_one, nan] = [0.5, 1.0, -1.0, f32::NAN].map(|value| self.constant(value));
        let floor = self.record(Primitive::Floor, &[exponent]);
        let is_whole = self.record(Primitive::Equal, &[floor, exponent]);
        let halved = self.record(Primitive::Mul, &[exponent, half]);
        let floor = self.record(Primitive::Floor, &[halved]);
        let is_even = self.record(Primitive::Equal, &[floor, halved]);
        let of_whole = self.record(Primitive::Select, &[is_even, one, minus_one]);
        let whole_or_one = self.record(Primitive::Select, &[is_whole, of_whole, one]);
        let whole_or_nan = self.record(Primitive::Select, &[is_whole, of_whole, nan]);
        let is_positive = self.record(Primitive::Less, &[class, half]);
        let is_extreme = self.record(Primitive::Less, &[one, class]);
        let signed = self.record(Primitive::Select, &[is_extreme, whole_or_one, whole_or_nan]);
        self.record(Primitive::Select, &[is_positive, one, signed])
    }

    /// A static code for the sign of the powers of a base. With it, the rest of the sign is uniform if the exponent is.
    /// 0: no sign. 1: negative for odd exponents, NaN for fractional ones. 2, for −0 and −∞: negative for odd
    /// exponents, positive for fractional ones.
    fn class_of_base(&mut self, base: NodeId) -> NodeId {
        let [zero, one, two] = [0.0, 1.0, 2.0].map(|value| self.constant(value));
        let (least, infinity) = (self.constant(f32::MIN), self.constant(f32::INFINITY));
        let is_infinite = self.record(Primitive::Less, &[base, least]);
        let of_negative = self.record(Primitive::Select, &[is_infinite, two, one]);
        let reciprocal = self.record(Primitive::Div, &[one, base]);
        let minus_infinity = self.record(Primitive::Neg, &[infinity]);
        let has_negative_reciprocal = self.record(Primitive::Equal, &[reciprocal, minus_infinity]);
        let is_zero = self.record(Primitive::Equal, &[base, zero]);
        let is_negative_zero = self.record(Primitive::And, &[has_negative_reciprocal, is_zero]);
        let of_other = self.record(Primitive::Select, &[is_negative_zero, two, zero]);
        let is_negative = self.record(Primitive::Less, &[base, zero]);
        self.record(Primitive::Select, &[is_negative, of_negative, of_other])
    }
}
