//! Exponentials, logarithms and powers.

use super::{ROUNDER, VectorMath};
use cranelift_codegen::ir::condcodes::FloatCC;
use cranelift_codegen::ir::types::F32X4;
use cranelift_codegen::ir::{InstBuilder, Value};
use std::f32::consts::{LN_2, LOG2_E};

/// 2^f on [0, 1], degree 6, absolute error 4.3e-9. The first coefficient is exactly 1, so that
/// whole exponents give exact powers of two; degree 5 would leave 2.4 ulp, and 5 in powers.
const EXP2: [f32; 7] = [1.0, LN_2, 0.2402278, 0.055490993, 0.009665556, 0.0012547864, 0.00021367423];

/// e^f on [0, ln 2], degree 6, absolute error 4.3e-9.
const EXP: [f32; 7] = [1.0, 1.0, 0.50000274, 0.166627, 0.04187299, 0.007841026, 0.0019273191];

/// ln 2 in two parts; the first has ten bits, so that a multiple of it by an exponent is exact
/// (Cody & Waite 1980, constants of Cephes).
const LN_2_HEAD: f32 = 0.6933594;
const LN_2_TAIL: f32 = -2.1219444e-4;

/// log2(1 + r) / r on [√½ − 1, √2 − 1], degree 8, relative error 2.8e-8.
const LOG2: [f32; 9] = [LOG2_E, -0.7213474, 0.48090896, -0.36070058, 0.2879535, -0.2390149, 0.21548083, -0.20678698, 0.12584242];

/// (ln(1 + r) − r) / r² on [√½ − 1, √2 − 1], degree 7, relative error of the logarithm 3.0e-8.
const LOG: [f32; 8] = [-0.4999999, 0.33333945, -0.25001776, 0.1996224, -0.16570313, 0.14916354, -0.14307721, 0.08738795];

/// (2 log2(e) artanh(s) − 2 log2(e) s) / s³ as a polynomial in s², for |s| up to
/// (√2 − 1) / (√2 + 1); degree 3, relative error of the logarithm 1.1e-11.
const ARTANH: [f32; 4] = [0.9617967, 0.5770788, 0.41192728, 0.33648953];

/// 2 log2(e), rounded, with what the rounding took; and as a head of twelve bits and a tail.
const TWO_LOG2_E: f32 = 2.0 * LOG2_E;
const TWO_LOG2_E_ERROR: f32 = 3.851926e-8;
const TWO_LOG2_E_HEAD: f32 = 2.8847656;
const TWO_LOG2_E_TAIL: f32 = 6.244568e-4;

/// Keeps the first twelve bits of a mantissa: the product of two such numbers is exact.
const TWELVE_BITS: u32 = 0xffff_f000;

/// More than the tail of an exponent may reach where it matters: 2²⁰.
const TAIL_LIMIT: f32 = 1_048_576.0;

/// √½ as bits: subtracted from a float's bits it makes the exponent field that of the nearest
/// power of two in the logarithmic sense, and the rest of the number lies in [√½, √2).
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
    /// 2^x. The whole part becomes an exponent, the fraction in [0, 1) goes through a polynomial.
    ///
    /// Error up to 1.3 ulp (1.6 without FMA; 1.6 in sixteen lanes). Exact for whole x. From 128 on infinite, below −126
    /// exactly 0.
    pub(in crate::jit) fn exp2(&mut self, x: Value) -> Value {
        // At the limits the power of two itself is infinite or zero, see `power_of_two`.
        let x = self.at_most(x, 128.0);
        let x = self.at_least(x, -127.0);
        let [fraction, whole] = self.parted(x);
        let significand = self.polynomial(fraction, &EXP2);
        self.scaled(significand, whole)
    }

    /// e^x. x = n ln 2 + f with whole n and f in [0, ln 2), up to rounding; ln 2 in two parts
    /// (Cody & Waite 1980), e^f by a polynomial.
    ///
    /// Error up to 1.5 ulp (1.8 without FMA). Overflows to infinity; below the normal numbers
    /// exactly 0.
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

    /// log2 x: the exponent plus r times a polynomial of r, where r is the significand in
    /// [√½, √2) less 1. The centring on 1 keeps the relative error small where the result is.
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
        // The exponent comes as e · 2²³; the constants take the factor, which saves a shift.
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
    /// The logarithm is carried as the sum of two floats, about 30 bits, since an error of it
    /// grows by y log2 x, up to 128: with s = (m − 1) / (m + 1) for the significand m,
    /// log2 m = 2 log2(e) artanh s, whose first term alone needs the extra precision (the scheme
    /// of fdlibm's `powf`). The product with y is a sum of two floats as well.
    ///
    /// Error up to 3.0 ulp (3.6 without FMA). Special cases are those of C's `powf`.
    pub(in crate::jit) fn pow(&mut self, x: Value, y: Value) -> Value {
        let base = self.abs(x);
        let (log, log_tail) = self.extended_log2(base);

        // Whole and odd exponents. From 2²⁴ on all floats are even and both tests agree.
        let floor = self.floor(y);
        let broken = self.compare(FloatCC::NotEqual, floor, y);
        let half = self.scale(y, 0.5);
        let half_floor = self.floor(half);
        let half_broken = self.compare(FloatCC::NotEqual, half_floor, half);
        let odd = self.builder.ins().band_not(half_broken, broken);

        // A negative base with a broken exponent has no power; infinity and zero, which come
        // after, have one. (All ones are a NaN.)
        let zero = self.constant(0.0);
        let negative = self.compare(FloatCC::LessThan, x, zero);
        let undefined = self.builder.ins().band(negative, broken);
        let log = self.or(log, undefined);
        let infinity = self.constant(f32::INFINITY);
        let finite = self.compare(FloatCC::LessThan, base, infinity);
        let log = self.select(finite, log, base);
        let zero = self.constant(0.0);
        let vanishing = self.compare(FloatCC::Equal, base, zero);
        let minus_infinity = self.constant(f32::NEG_INFINITY);
        let log = self.select(vanishing, minus_infinity, log);

        // 1^y is 1 even for NaN: 1^0 instead. No base but 1 gives a finite and nonzero result
        // beyond 2³², and with y so limited the products stay finite.
        let one = self.constant(1.0);
        let not_one = self.compare(FloatCC::NotEqual, x, one);
        let exponent = self.keep(not_one, y);
        let exponent = self.at_most(exponent, 4_294_967_296.0);
        let exponent = self.at_least(exponent, -4_294_967_296.0);

        let (product, tail) = self.extended_product(exponent, log, log_tail);
        let sum = self.add(product, tail);
        let whole = self.floor(sum);
        // 2^128 would be infinite too early: the polynomial may yet be below 1. Far above, it
        // grows until the result overflows.
        let whole = self.at_most(whole, 127.0);
        let fraction = self.sub(product, whole);
        let fraction = self.add(fraction, tail);
        let significand = self.polynomial(fraction, &EXP2);
        let power = self.power_of_two(whole);
        let result = self.mul(significand, power);
        let least = self.constant(-127.0);
        let above = self.compare(FloatCC::UnorderedOrGreaterThanOrEqual, sum, least);
        let result = self.keep(above, result);

        // x^0 is 1 even for NaN.
        let zero = self.constant(0.0);
        let nothing = self.compare(FloatCC::Equal, y, zero);
        let one = self.constant(1.0);
        let result = self.select(nothing, one, result);
        let sign = self.and_bits(x, super::SIGN);
        let sign = self.keep(odd, sign);
        self.xor(result, sign)
    }

    /// 2^n for a whole n from −126 to 127; 0 for −127 and infinite for 128.
    pub(super) fn power_of_two(&mut self, n: Value) -> Value {
        // The sum's low bits hold n plus the bias; the shift makes them the exponent field and
        // drops the rest. Cheaper than a conversion, whose overflow rules cost nine instructions.
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

    /// The significand less 1: exact.
    fn less_one(&mut self, scaled: &Scaled) -> Value {
        let one = self.constant(1.0);
        self.sub(scaled.significand, one)
    }

    /// `result` where x is positive and finite, else what a logarithm is there.
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

    /// log2 of a positive finite x as head + tail. Without fused multiply-add the head has only
    /// twelve bits, for [`Self::extended_product`].
    fn extended_log2(&mut self, x: Value) -> (Value, Value) {
        let scaled = self.split(x);
        let exponent = self.exponent(&scaled);
        let numerator = self.less_one(&scaled);
        let one = self.constant(1.0);
        let denominator = self.add(scaled.significand, one);
        let one = self.constant(1.0);
        let reciprocal = self.builder.ins().fdiv(one, denominator);
        let quotient = self.mul(numerator, reciprocal);
        // What the quotient leaves of the numerator is exact only if the products are.
        let (quotient, denominator) = if self.fma {
            (quotient, denominator)
        } else {
            (self.and_bits(quotient, TWELVE_BITS), self.and_bits(denominator, TWELVE_BITS))
        };
        let one = self.constant(1.0);
        let denominator_tail = self.sub(denominator, one);
        let denominator_tail = self.sub(scaled.significand, denominator_tail);
        let rest = self.mul_sub_from(quotient, denominator, numerator);
        let rest = self.mul_sub_from(quotient, denominator_tail, rest);
        let rest = self.mul(rest, reciprocal);

        if self.fma {
            // Both sums are exact but for the last rounding of the tail.
            let factor = self.constant(TWO_LOG2_E);
            let head = self.mul_add(quotient, factor, exponent);
            let kept = self.sub(exponent, head);
            let factor = self.constant(TWO_LOG2_E);
            let tail = self.mul_add(quotient, factor, kept);
            let factor = self.constant(TWO_LOG2_E_ERROR);
            let tail = self.mul_add(quotient, factor, tail);
            return (head, self.artanh_tail(quotient, rest, tail));
        }
        // Exact product, and exact error of the sum: the exponent is 0 or outweighs it.
        let first = self.scale(quotient, TWO_LOG2_E_HEAD);
        let head = self.add(exponent, first);
        let kept = self.sub(head, exponent);
        let tail = self.sub(first, kept);
        let factor = self.constant(TWO_LOG2_E_TAIL);
        let tail = self.mul_add(quotient, factor, tail);
        // The series wants a quotient of full length and the rest of that.
        let full = self.add(quotient, rest);
        let moved = self.sub(full, quotient);
        let factor = self.constant(TWO_LOG2_E);
        let tail = self.mul_add(moved, factor, tail);
        let rest = self.sub(rest, moved);
        let tail = self.artanh_tail(full, rest, tail);
        // The tail goes in before the cut, to be small where it meets the rest of the product.
        let sum = self.add(head, tail);
        let short = self.and_bits(sum, TWELVE_BITS);
        let cut = self.sub(head, short);
        (short, self.add(tail, cut))
    }

    /// tail + 2 log2(e) (artanh(s + rest) − s), for a rest that is a rounding error of s.
    fn artanh_tail(&mut self, s: Value, rest: Value, tail: Value) -> Value {
        let square = self.mul(s, s);
        let factor = self.constant(TWO_LOG2_E);
        let another = self.constant(TWO_LOG2_E);
        let slope = self.mul_add(square, factor, another);
        let tail = self.mul_add(rest, slope, tail);
        let series = self.polynomial(square, &ARTANH);
        let cube = self.mul(s, square);
        self.mul_add(cube, series, tail)
    }

    /// y · (head + tail) as the sum of two floats, the first of them y · head to twelve or
    /// twenty-four bits.
    fn extended_product(&mut self, y: Value, head: Value, tail: Value) -> (Value, Value) {
        // With an infinite head the tail is NaN or infinite; the limit takes its place, and the
        // sum remains infinite.
        let limit = self.constant(TAIL_LIMIT);
        if self.fma {
            let product = self.mul(y, head);
            let negated = self.builder.ins().fneg(product);
            let rest = self.builder.ins().fma(y, head, negated);
            let tail = self.builder.ins().fma(y, tail, rest);
            return (product, self.lesser(tail, limit));
        }
        // Dekker's split of y (1971); the head is short already. Masking bits would be shorter
        // but can make an infinity of a NaN.
        let wide = self.scale(y, 4097.0);
        let y_head = self.sub(wide, y);
        let y_head = self.sub(wide, y_head);
        let y_tail = self.sub(y, y_head);
        let product = self.mul(y_head, head);
        let rest = self.mul(y_tail, head);
        let tail = self.mul_add(y, tail, rest);
        let tail = self.lesser(tail, limit);
        (product, self.at_least(tail, -TAIL_LIMIT))
    }
}
