//! Exponentials, logarithms and powers.

use super::{ROUNDER, VectorMath};
use cranelift_codegen::ir::condcodes::FloatCC;
use cranelift_codegen::ir::types::F32X4;
use cranelift_codegen::ir::{InstBuilder, Value};
use std::f32::consts::{LN_2, LOG2_E};

/// 2^f on [0, 1], degree 6, absolute error 4.3e-9. The first coefficient is exactly 1, so that whole exponents give
/// exact powers of two. Degree 5 would have an error of 2.4 ulp, and 5 ulp in powers.
pub(crate) const EXP2: [f32; 7] = [1.0, LN_2, 0.2402278, 0.055490993, 0.009665556, 0.0012547864, 0.00021367423];

/// e^f on [0, ln 2], degree 6, absolute error 4.3e-9.
pub(crate) const EXP: [f32; 7] = [1.0, 1.0, 0.50000274, 0.166627, 0.04187299, 0.007841026, 0.0019273191];

/// ln 2 in two parts. The first has ten bits, so that its product with an exponent is exact (Cody & Waite 1980,
/// constants of Cephes).
pub(crate) const LN_2_HEAD: f32 = 0.6933594;
pub(crate) const LN_2_TAIL: f32 = -2.1219444e-4;

/// log2(1 + r) / r on [√½ − 1, √2 − 1], degree 8, relative error 2.8e-8.
pub(crate) const LOG2: [f32; 9] =
    [LOG2_E, -0.7213474, 0.48090896, -0.36070058, 0.2879535, -0.2390149, 0.21548083, -0.20678698, 0.12584242];

/// (ln(1 + r) − r) / r² on [√½ − 1, √2 − 1], degree 7, relative error of the logarithm 3.0e-8.
pub(crate) const LOG: [f32; 8] =
    [-0.4999999, 0.33333945, -0.25001776, 0.1996224, -0.16570313, 0.14916354, -0.14307721, 0.08738795];

/// (2 log2(e) artanh(s) − 2 log2(e) s) / s³ as a polynomial in s², for |s| up to (√2 − 1) / (√2 + 1), degree 3,
/// relative error of the logarithm 1.1e-11.
pub(crate) const ARTANH: [f32; 4] = [0.9617967, 0.5770788, 0.41192728, 0.33648953];

/// 2 log2(e), rounded, and the rounding error; and the same number as a head of twelve bits and a tail.
pub(crate) const TWO_LOG2_E: f32 = 2.0 * LOG2_E;
const TWO_LOG2_E_ERROR: f32 = 3.851926e-8;
pub(crate) const TWO_LOG2_E_HEAD: f32 = 2.8847656;
pub(crate) const TWO_LOG2_E_TAIL: f32 = 6.244568e-4;

/// A mask for the first twelve bits of a mantissa. The product of two such numbers is exact.
const TWELVE_BITS: u32 = 0xffff_f000;

/// A bound of the tail of an exponent, 2²⁰: beyond it the result is infinite or 0 anyway.
pub(crate) const TAIL_LIMIT: f32 = 1_048_576.0;

/// The bits of √½. Subtracted from the bits of a float they make its exponent field that of the power of two 2^e for
/// which the number divided by it lies in [√½, √2).
const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
const EXPONENT_FIELD: u32 = 0xff80_0000;
const MANTISSA_WIDTH: u32 = 23;

/// A float x as 2^e · (1 + r).
struct Scaled {
    /// e · 2²³, as integers.
    exponent_field: Value,
    /// 1 + r, in [√½, √2).
    significand: Value,
}

impl VectorMath<'_, '_> {
    /// 2^x. The whole part becomes an exponent, and a polynomial gives the power of the fraction in [0, 1).
    ///
    /// Error up to 1.3 ulp (1.6 without FMA; 1.6 in sixteen lanes). Exact for whole x. Infinite from 128 on, exactly 0
    /// below −126.
    pub(in crate::jit) fn exp2(&mut self, x: Value) -> Value {
        // At the limits the power of two itself is infinite or zero, see `power_of_two`.
        let x = self.at_most(x, 128.0);
        let x = self.at_least(x, -127.0);
        let [fraction, whole] = self.split_whole(x);
        let significand = self.polynomial(fraction, &EXP2);
        self.scaled(significand, whole)
    }

    /// e^x. x = n ln 2 + f with whole n and f in [0, ln 2), up to rounding, with ln 2 in two parts (Cody & Waite 1980).
    /// A polynomial gives e^f.
    ///
    /// Error up to 1.5 ulp (1.8 without FMA). Overflows to infinity; exactly 0 below the normal numbers.
    pub(in crate::jit) fn exp(&mut self, x: Value) -> Value {
        let x = self.at_most(x, 89.0);
        let x = self.at_least(x, -88.0);
        let turns = self.scale(x, LOG2_E);
        let whole = self.floor(turns);
        let head = self.constant(LN_2_HEAD);
        let fraction = self.mul_sub_from(whole, head, x);
        let tail = self.constant(LN_2_TAIL);
        let fraction = self.mul_sub_from(whole, tail, fraction);
        let significand = self.polynomial(fraction, &EXP);
        self.scaled(significand, whole)
    }

    /// log2 x: the exponent plus r times a polynomial of r, where r is the significand in [√½, √2) minus 1. Since that
    /// interval contains 1, the relative error stays small where the result is near 0.
    ///
    /// Error up to 1.9 ulp (2.1 without FMA). Exact for powers of two. −∞ at ±0, NaN below, ∞ at ∞.
    pub(in crate::jit) fn log2(&mut self, x: Value) -> Value {
        let scaled = self.split(x);
        let exponent = self.exponent(&scaled);
        let r = self.less_one(&scaled);
        let ratio = self.polynomial(r, &LOG2);
        let result = self.mul_add(r, ratio, exponent);
        self.logarithm_edges(x, result)
    }

    /// ln x, as [`Self::log2`], with ln 2 in two parts (Cody & Waite 1980).
    ///
    /// Error up to 1.2 ulp (1.2 without FMA). −∞ at ±0, NaN below, ∞ at ∞.
    pub(in crate::jit) fn log(&mut self, x: Value) -> Value {
        // The exponent comes as e · 2²³. The factor is in the constants, which saves a shift.
        const FIELD: f32 = 1.0 / (1 << MANTISSA_WIDTH) as f32;
        let scaled = self.split(x);
        let field = self.builder.ins().fcvt_from_sint(F32X4, scaled.exponent_field);
        let r = self.less_one(&scaled);
        let ratio = self.polynomial(r, &LOG);
        let square = self.mul(r, r);
        let tail = self.scale(field, LN_2_TAIL * FIELD);
        let correction = self.mul_add(square, ratio, tail);
        let inner = self.add(r, correction);
        let head = self.constant(LN_2_HEAD * FIELD);
        let result = self.mul_add(field, head, inner);
        self.logarithm_edges(x, result)
    }

    /// x^y = 2^(y log2 |x|), with a sign where x is negative and y odd.
    ///
    /// The error of the logarithm is multiplied by up to 128, so the logarithm is the sum of two floats, about 30 bits:
    /// with s = (m − 1) / (m + 1) for the significand m, log2 m = 2 log2(e) artanh s, and only the first term needs the
    /// extra precision (as in fdlibm's `powf`). The product with y is a sum of two floats as well.
    ///
    /// Error up to 3.0 ulp (3.6 without FMA). Special cases are those of C's `powf`.
    pub(in crate::jit) fn pow(&mut self, x: Value, y: Value) -> Value {
        let base = self.abs(x);
        let (log, log_tail) = self.extended_log2(base);

        // Fractional and odd exponents. From 2²⁴ on all floats are even.
        let floor = self.floor(y);
        let fractional = self.compare(FloatCC::NotEqual, floor, y);
        let half = self.scale(y, 0.5);
        let half_floor = self.floor(half);
        let half_fractional = self.compare(FloatCC::NotEqual, half_floor, half);
        let odd = self.builder.ins().band_not(half_fractional, fractional);

        // A negative base has no power with a fractional exponent. (All ones are a NaN.) Infinity and zero have one,
        // and replace it below.
        let zero = self.constant(0.0);
        let negative = self.compare(FloatCC::LessThan, x, zero);
        let undefined = self.builder.ins().band(negative, fractional);
        let log = self.or(log, undefined);
        let infinity = self.constant(f32::INFINITY);
        let finite = self.compare(FloatCC::LessThan, base, infinity);
        let log = self.select(finite, log, base);
        let zero = self.constant(0.0);
        let vanishing = self.compare(FloatCC::Equal, base, zero);
        let minus_infinity = self.constant(f32::NEG_INFINITY);
        let log = self.select(vanishing, minus_infinity, log);

        // 1^y is 1 even for NaN, so it is computed as 1^0. With exponents beyond ±2³² every other base has an infinite
        // power or 0, and with exponents within these limits the products stay finite.
        let one = self.constant(1.0);
        let not_one = self.compare(FloatCC::NotEqual, x, one);
        let exponent = self.keep(not_one, y);
        let exponent = self.at_most(exponent, 4_294_967_296.0);
        let exponent = self.at_least(exponent, -4_294_967_296.0);

        let (product, tail) = self.extended_product(exponent, log, log_tail);
        let sum = self.add(product, tail);
        let whole = self.floor(sum);
        // Not 128, which would be infinite although the polynomial may be below 1. With a larger fraction the
        // polynomial grows until the result overflows.
        let whole = self.at_most(whole, 127.0);
        let fraction = self.sub(product, whole);
        let fraction = self.add(fraction, tail);
        let significand = self.polynomial(fraction, &EXP2);
        let power = self.power_of_two(whole);
        let result = self.mul(significand, power);
        let least = self.constant(-127.0);
        let above = self.not_less(sum, least);
        let result = self.keep(above, result);

        // x^0 is 1 even for NaN.
        let zero = self.constant(0.0);
        let no_exponent = self.compare(FloatCC::Equal, y, zero);
        let one = self.constant(1.0);
        let result = self.select(no_exponent, one, result);
        let sign = self.and_bits(x, super::SIGN);
        let sign = self.keep(odd, sign);
        self.xor(result, sign)
    }

    /// 2^n for a whole n from −126 to 127; 0 for −127 and infinite for 128.
    pub(super) fn power_of_two(&mut self, n: Value) -> Value {
        // The low bits of the sum are n plus the bias. The shift makes them the exponent field and drops the other
        // bits. A conversion would cost nine instructions, because of its rules for overflow.
        let rounder = self.constant(ROUNDER + 127.0);
        let biased = self.add(n, rounder);
        let biased = self.int(biased);
        let field = self.shift_left(biased, MANTISSA_WIDTH);
        self.float(field)
    }

    fn split(&mut self, x: Value) -> Scaled {
        let bits = self.int(x);
        let offset = self.bits(SQRT_HALF_BITS);
        let shifted = self.builder.ins().isub(bits, offset);
        let mask = self.bits(EXPONENT_FIELD);
        let exponent_field = self.builder.ins().band(shifted, mask);
        let significand = self.builder.ins().isub(bits, exponent_field);
        Scaled { exponent_field, significand: self.float(significand) }
    }

    fn exponent(&mut self, scaled: &Scaled) -> Value {
        let exponent = self.shift_right(scaled.exponent_field, MANTISSA_WIDTH);
        self.builder.ins().fcvt_from_sint(F32X4, exponent)
    }

    /// The significand minus 1: exact.
    fn less_one(&mut self, scaled: &Scaled) -> Value {
        let one = self.constant(1.0);
        self.sub(scaled.significand, one)
    }

    /// `result` where x is positive and finite, else the special case of a logarithm.
    fn logarithm_edges(&mut self, x: Value, result: Value) -> Value {
        let infinity = self.constant(f32::INFINITY);
        let finite = self.compare(FloatCC::LessThan, x, infinity);
        let result = self.select(finite, result, x);
        let zero = self.constant(0.0);
        let vanishing = self.compare(FloatCC::Equal, x, zero);
        let minus_infinity = self.constant(f32::NEG_INFINITY);
        let result = self.select(vanishing, minus_infinity, result);
        // All ones are a NaN.
        let zero = self.constant(0.0);
        let negative = self.compare(FloatCC::LessThan, x, zero);
        self.or(result, negative)
    }

    /// log2 of a positive finite x as head + tail. Without fused multiply-add the head has only twelve bits, for
    /// [`Self::extended_product`].
    fn extended_log2(&mut self, x: Value) -> (Value, Value) {
        let scaled = self.split(x);
        let exponent = self.exponent(&scaled);
        let numerator = self.less_one(&scaled);
        let one = self.constant(1.0);
        let denominator = self.add(scaled.significand, one);
        let one = self.constant(1.0);
        let reciprocal = self.builder.ins().fdiv(one, denominator);
        let quotient = self.mul(numerator, reciprocal);
        // The remainder of the division is exact only if the products are.
        let (quotient, denominator) = if self.fma {
            (quotient, denominator)
        } else {
            (self.and_bits(quotient, TWELVE_BITS), self.and_bits(denominator, TWELVE_BITS))
        };
        let one = self.constant(1.0);
        let denominator_tail = self.sub(denominator, one);
        let denominator_tail = self.sub(scaled.significand, denominator_tail);
        let remainder = self.mul_sub_from(quotient, denominator, numerator);
        let remainder = self.mul_sub_from(quotient, denominator_tail, remainder);
        let quotient_tail = self.mul(remainder, reciprocal);

        if self.fma {
            // Both sums are exact but for the last rounding of the tail.
            let factor = self.constant(TWO_LOG2_E);
            let head = self.mul_add(quotient, factor, exponent);
            let difference = self.sub(exponent, head);
            let factor = self.constant(TWO_LOG2_E);
            let tail = self.mul_add(quotient, factor, difference);
            let factor = self.constant(TWO_LOG2_E_ERROR);
            let tail = self.mul_add(quotient, factor, tail);
            return (head, self.artanh_tail(quotient, quotient_tail, tail));
        }
        // The product is exact, and so is the error of the sum: the exponent is 0 or the larger number.
        let first = self.scale(quotient, TWO_LOG2_E_HEAD);
        let head = self.add(exponent, first);
        let difference = self.sub(head, exponent);
        let tail = self.sub(first, difference);
        let factor = self.constant(TWO_LOG2_E_TAIL);
        let tail = self.mul_add(quotient, factor, tail);
        // The series takes a quotient of full length and its rounding error.
        let full = self.add(quotient, quotient_tail);
        let added = self.sub(full, quotient);
        let factor = self.constant(TWO_LOG2_E);
        let tail = self.mul_add(added, factor, tail);
        let quotient_tail = self.sub(quotient_tail, added);
        let tail = self.artanh_tail(full, quotient_tail, tail);
        // The tail is added before the head is cut to twelve bits, so that what is cut off is all there is.
        let sum = self.add(head, tail);
        let short = self.and_bits(sum, TWELVE_BITS);
        let cut = self.sub(head, short);
        (short, self.add(tail, cut))
    }

    /// tail + 2 log2(e) (artanh(s + error) − s), where `error` is the rounding error of s.
    fn artanh_tail(&mut self, s: Value, error: Value, tail: Value) -> Value {
        let square = self.mul(s, s);
        let factor = self.constant(TWO_LOG2_E);
        let another = self.constant(TWO_LOG2_E);
        let slope = self.mul_add(square, factor, another);
        let tail = self.mul_add(error, slope, tail);
        let series = self.polynomial(square, &ARTANH);
        let cube = self.mul(s, square);
        self.mul_add(cube, series, tail)
    }

    /// y · (head + tail) as the sum of two floats. The first is y · head to twelve or twenty-four bits.
    fn extended_product(&mut self, y: Value, head: Value, tail: Value) -> (Value, Value) {
        // With an infinite head the tail is NaN or infinite. The limit replaces it, and the sum stays infinite.
        let limit = self.constant(TAIL_LIMIT);
        if self.fma {
            let product = self.mul(y, head);
            let negated = self.builder.ins().fneg(product);
            let error = self.builder.ins().fma(y, head, negated);
            let tail = self.builder.ins().fma(y, tail, error);
            return (product, self.lesser(tail, limit));
        }
        // Dekker's split of y (1971). The head is short already. Masking bits would take fewer instructions but can
        // turn a NaN into an infinity.
        let wide = self.scale(y, 4097.0);
        let y_head = self.sub(wide, y);
        let y_head = self.sub(wide, y_head);
        let y_tail = self.sub(y, y_head);
        let product = self.mul(y_head, head);
        let error = self.mul(y_tail, head);
        let tail = self.mul_add(y, tail, error);
        let tail = self.lesser(tail, limit);
        (product, self.at_least(tail, -TAIL_LIMIT))
    }
}
