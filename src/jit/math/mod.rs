//! Elementary functions as Cranelift IR: four `f32` lanes, no branches, no calls.
//!
//! Cranelift has no vector `exp`, `sin` and the like, and a library call for each lane would cost more than the rest of
//! a formula. Each method here appends the instructions of one function to the function under construction: arithmetic,
//! comparisons and bit operations on vectors of 128 bits.
//!
//! In every special case (zeros, infinities, NaN) a function means what C's `f32` function means. Kernels run with FTZ
//! and DAZ, so subnormal arguments and results count as zero. Errors are in units in the last place (ulp), against
//! `f64` references, measured over 20 to 35 million samples a function: first with fused multiply-add (FMA), then
//! without.
//!
//! Rules that shape the code:
//!
//! - [`VectorMath::constant`] emits a load at every use. Sixteen registers are too few to keep the coefficients of
//!   several polynomials, and a load next to its use is cheaper than a spill.
//! - `fmin` and `fmax` have rules for NaN and −0 that cost several instructions. A comparison and a `bitselect` become
//!   one `minps`; the order of the operands decides what NaN does.
//! - `fma` is emitted only where the processor has it. Elsewhere it would be a library call for each lane, so where a
//!   product must be exact the operands are split instead (Dekker 1971).
//! - Polynomials are minimax fits (Remez exchange, or linear programming where the basis vanishes inside the interval).
//!   Their coefficients were rounded to `f32` one after the other, and the remaining ones fitted again each time. The
//!   "error" of a fit is that of the rounded polynomial in exact arithmetic.

pub(crate) mod exponential;
pub(crate) mod inverse;
pub(crate) mod trigonometric;

use cranelift_codegen::ir::condcodes::FloatCC;
use cranelift_codegen::ir::types::{F32X4, I8X16, I16X8, I32, I32X4};
use cranelift_codegen::ir::{Constant, ConstantData, Endianness, InstBuilder, MemFlagsData, Type, Value};
use cranelift_frontend::FunctionBuilder;

/// The sign bit of an `f32`.
const SIGN: u32 = 0x8000_0000;

/// All bits of an `f32` but the sign.
const MAGNITUDE: u32 = 0x7fff_ffff;

/// π/2 is `FRAC_PI_2` plus this.
pub(crate) const FRAC_PI_2_TAIL: f32 = -4.371139e-8;

/// 1.5 · 2²³. Added to a float of magnitude up to 2²², it leaves the nearest integer in the low
/// bits of the sum's mantissa, and subtracted again, the integer as a float.
pub(crate) const ROUNDER: f32 = 12_582_912.0;

/// Emits code for the elementary functions into the function under construction.
///
/// Every operand and result is an `F32X4`, except masks: they are `I32X4` in which every lane is all ones or all zeros,
/// as `fcmp` yields them.
pub(in crate::jit) struct VectorMath<'a, 'f> {
    builder: &'a mut FunctionBuilder<'f>,
    fma: bool,
    sixteen: bool,
}

impl<'a, 'f> VectorMath<'a, 'f> {
    /// `fma`: the processor has fused multiply-add. `sixteen`: the code is going to be widened to sixteen lanes, which
    /// have instructions that four lanes do not have.
    pub(in crate::jit) fn new(builder: &'a mut FunctionBuilder<'f>, fma: bool, sixteen: bool) -> Self {
        Self { builder, fma, sixteen }
    }

    /// Splits finite x into its fraction in [0, 1) and its whole part. The latter may be x itself:
    /// [`scaled`](Self::scaled) rounds it down.
    fn split_whole(&mut self, x: Value) -> [Value; 2] {
        if self.sixteen {
            return [self.placeholder(I8X16, x, x), x];
        }
        let whole = self.floor(x);
        [self.sub(x, whole), whole]
    }

    /// x · 2ⁿ for whole n from −127, where it is 0, to 128, where it is infinite.
    fn scaled(&mut self, x: Value, n: Value) -> Value {
        if self.sixteen {
            return self.placeholder(I16X8, x, n);
        }
        let power = self.power_of_two(n);
        self.mul(x, power)
    }

    /// A placeholder for an instruction that only AVX-512 has, in code that is going to be widened: see
    /// [`super::widen`].
    fn placeholder(&mut self, lanes: Type, x: Value, y: Value) -> Value {
        let [x, y] = [x, y].map(|value| self.reinterpret(value, lanes));
        let result = self.builder.ins().ssub_sat(x, y);
        self.reinterpret(result, F32X4)
    }

    /// The largest whole number not above `x`. Exact; keeps the sign of zero. One `roundps`.
    pub(in crate::jit) fn floor(&mut self, x: Value) -> Value {
        self.builder.ins().floor(x)
    }

    /// The smallest whole number not below `x`. Exact; keeps the sign of zero. One `roundps`.
    pub(in crate::jit) fn ceil(&mut self, x: Value) -> Value {
        self.builder.ins().ceil(x)
    }

    /// `value` in all four lanes: a load of its own at every call.
    pub(in crate::jit) fn constant(&mut self, value: f32) -> Value {
        let handle = self.pool(value.to_bits());
        self.builder.ins().vconst(F32X4, handle)
    }

    /// a·b + c, in one rounding where the processor can.
    pub(in crate::jit) fn mul_add(&mut self, a: Value, b: Value, c: Value) -> Value {
        if self.fma {
            self.builder.ins().fma(a, b, c)
        } else {
            let product = self.builder.ins().fmul(a, b);
            self.builder.ins().fadd(product, c)
        }
    }

    /// Compares lane by lane: an `I32X4` mask, all ones where the comparison holds.
    pub(in crate::jit) fn compare(&mut self, condition: FloatCC, a: Value, b: Value) -> Value {
        self.builder.ins().fcmp(condition, a, b)
    }

    /// Where `a` ≥ `b` or one of them is NaN, as a mask.
    fn not_less(&mut self, a: Value, b: Value) -> Value {
        if cfg!(target_arch = "aarch64") {
            // Cranelift has no such comparison of vectors for AArch64.
            let less = self.compare(FloatCC::LessThan, a, b);
            return self.builder.ins().bnot(less);
        }
        self.compare(FloatCC::UnorderedOrGreaterThanOrEqual, a, b)
    }

    /// `a` in the lanes where `mask` is set, `b` elsewhere. It becomes a single blend if `mask` comes straight from a
    /// comparison.
    pub(in crate::jit) fn select(&mut self, mask: Value, a: Value, b: Value) -> Value {
        let mask = self.float(mask);
        self.builder.ins().bitselect(mask, a, b)
    }

    /// |x|.
    pub(in crate::jit) fn abs(&mut self, x: Value) -> Value {
        self.and_bits(x, MAGNITUDE)
    }

    /// The smaller of `x` and `limit`; NaN stays NaN. One `minps`.
    pub(in crate::jit) fn at_most(&mut self, x: Value, limit: f32) -> Value {
        // `minps a, b` is `a < b ? a : b`: the second operand wins when either is NaN.
        let limit = self.constant(limit);
        self.lesser(limit, x)
    }

    /// The greater of `x` and `limit`; NaN stays NaN. One `maxps`.
    pub(in crate::jit) fn at_least(&mut self, x: Value, limit: f32) -> Value {
        let limit = self.constant(limit);
        self.greater(limit, x)
    }

    /// `a < b ? a : b`, hence `b` when either is NaN.
    pub(in crate::jit) fn lesser(&mut self, a: Value, b: Value) -> Value {
        let mask = self.compare(FloatCC::LessThan, a, b);
        self.select(mask, a, b)
    }

    /// `a > b ? a : b`, hence `b` when either is NaN.
    pub(in crate::jit) fn greater(&mut self, a: Value, b: Value) -> Value {
        // Written as `b < a`: the form that Cranelift recognises as `maxps`.
        let mask = self.compare(FloatCC::LessThan, b, a);
        self.select(mask, a, b)
    }

    /// `a` in the lanes where the sign bit of `bits` is set, `b` elsewhere.
    fn select_by_sign(&mut self, bits: Value, a: Value, b: Value) -> Value {
        let bits = self.int(bits);
        if cfg!(target_arch = "aarch64") {
            // AArch64 has no instruction that selects by the sign bit.
            let mask = self.shift_right(bits, 31);
            return self.select(mask, a, b);
        }
        let (a, b) = (self.int(a), self.int(b));
        let chosen = self.builder.ins().blendv(bits, a, b);
        self.float(chosen)
    }

    /// c − a·b, in one rounding where the processor can.
    fn mul_sub_from(&mut self, a: Value, b: Value, c: Value) -> Value {
        if self.fma {
            // Cranelift folds the negation into `vfnmadd`.
            let negated = self.builder.ins().fneg(a);
            self.builder.ins().fma(negated, b, c)
        } else {
            let product = self.builder.ins().fmul(a, b);
            self.builder.ins().fsub(c, product)
        }
    }

    /// A polynomial by Horner's rule. The first coefficient is that of x⁰.
    fn polynomial(&mut self, x: Value, coefficients: &[f32]) -> Value {
        let mut descending = coefficients.iter().rev();
        let mut sum = self.constant(descending.next().copied().unwrap_or(0.0));
        for &coefficient in descending {
            let coefficient = self.constant(coefficient);
            sum = self.mul_add(sum, x, coefficient);
        }
        sum
    }

    /// a + b.
    fn add(&mut self, a: Value, b: Value) -> Value {
        self.builder.ins().fadd(a, b)
    }

    /// a − b.
    fn sub(&mut self, a: Value, b: Value) -> Value {
        self.builder.ins().fsub(a, b)
    }

    /// a · b.
    fn mul(&mut self, a: Value, b: Value) -> Value {
        self.builder.ins().fmul(a, b)
    }

    /// x · factor.
    fn scale(&mut self, x: Value, factor: f32) -> Value {
        let factor = self.constant(factor);
        self.mul(x, factor)
    }

    /// The lanes of a float vector as integers, bit for bit.
    fn int(&mut self, x: Value) -> Value {
        self.reinterpret(x, I32X4)
    }

    /// The lanes of an integer vector as floats, bit for bit.
    fn float(&mut self, x: Value) -> Value {
        self.reinterpret(x, F32X4)
    }

    fn reinterpret(&mut self, x: Value, ty: Type) -> Value {
        if self.builder.func.dfg.value_type(x) == ty {
            return x;
        }
        self.builder.ins().bitcast(ty, MemFlagsData::new().with_endianness(Endianness::Little), x)
    }

    /// The bits of each lane moved left, as integers.
    fn shift_left(&mut self, bits: Value, count: u32) -> Value {
        let count = self.builder.ins().iconst(I32, i64::from(count));
        self.builder.ins().ishl(bits, count)
    }

    /// The bits of each lane moved right, as integers, with copies of the sign bit on the left.
    fn shift_right(&mut self, bits: Value, count: u32) -> Value {
        let count = self.builder.ins().iconst(I32, i64::from(count));
        self.builder.ins().sshr(bits, count)
    }

    /// `bits` in all four lanes, as integers.
    fn bits(&mut self, bits: u32) -> Value {
        let handle = self.pool(bits);
        self.builder.ins().vconst(I32X4, handle)
    }

    fn pool(&mut self, bits: u32) -> Constant {
        let lanes = [bits; 4].map(u32::to_le_bytes).concat();
        self.builder.func.dfg.constants.insert(ConstantData::from(lanes.as_slice()))
    }

    /// The bits of x that are set in `mask`.
    fn and_bits(&mut self, x: Value, mask: u32) -> Value {
        let x = self.int(x);
        let mask = self.bits(mask);
        let masked = self.builder.ins().band(x, mask);
        self.float(masked)
    }

    /// x where `mask` (an `I32X4`) is set, +0 elsewhere.
    fn keep(&mut self, mask: Value, x: Value) -> Value {
        let x = self.int(x);
        let masked = self.builder.ins().band(x, mask);
        self.float(masked)
    }

    /// The bits set in either operand.
    fn or(&mut self, a: Value, b: Value) -> Value {
        let (a, b) = (self.int(a), self.int(b));
        let both = self.builder.ins().bor(a, b);
        self.float(both)
    }

    /// The bits set in one operand only.
    fn xor(&mut self, a: Value, b: Value) -> Value {
        let (a, b) = (self.int(a), self.int(b));
        let flipped = self.builder.ins().bxor(a, b);
        self.float(flipped)
    }
}
