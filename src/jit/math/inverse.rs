//! The inverse trigonometric functions.

use super::{FRAC_PI_2_TAIL, SIGN, VectorMath};
use cranelift_codegen::ir::condcodes::FloatCC;
use cranelift_codegen::ir::{InstBuilder, Value};
use std::f32::consts::{FRAC_PI_2, PI};

/// (asin s − s) / s³ as a polynomial in s², |s| ≤ ½, degree 4, relative error of the arcsine 4.9e-9.
pub(crate) const ASIN: [f32; 5] = [0.16666752, 0.074953094, 0.045469154, 0.024184743, 0.042158388];

/// acos a / √(1 − a) on [0, 1], degree 7, relative error 2.8e-8; the form is that of Hastings 1955.
pub(crate) const ACOS: [f32; 8] =
    [FRAC_PI_2, -0.21460323, 0.0890383, -0.05049173, 0.031727992, -0.01824149, 0.0074695176, -0.0014822034];

/// (atan t − t) / t³ as a polynomial in t², |t| ≤ 1, degree 7, relative error of the arctangent 1.7e-8.
pub(crate) const ATAN: [f32; 8] =
    [-0.33333153, 0.19993767, -0.14211008, 0.10665822, -0.075518385, 0.043207597, -0.01636541, 0.0029200881];

impl VectorMath<'_, '_> {
    /// asin x: a polynomial up to ½, and beyond it π/2 − 2 asin √((1 − x) / 2) by the same polynomial (Cephes).
    ///
    /// Error up to 2.1 ulp (2.1 without FMA). NaN outside [−1, 1]; keeps −0.
    pub(in crate::jit) fn asin(&mut self, x: Value) -> Value {
        let a = self.abs(x);
        let sign = self.xor(x, a);
        let half = self.constant(0.5);
        let large = self.compare(FloatCC::GreaterThan, a, half);
        let factor = self.constant(-0.5);
        let half = self.constant(0.5);
        let folded_square = self.mul_add(a, factor, half);
        let own_square = self.mul(a, a);
        let square = self.select(large, folded_square, own_square);
        // For |x| above 1 this is the root of a negative number: NaN.
        let root = self.builder.ins().sqrt(folded_square);
        let folded = self.scale(root, -2.0);
        let s = self.select(large, folded, a);
        let offset = self.constant(FRAC_PI_2);
        let offset = self.keep(large, offset);
        let offset_tail = self.constant(FRAC_PI_2_TAIL);
        let offset_tail = self.keep(large, offset_tail);
        let series = self.polynomial(square, &ASIN);
        let result = self.offset_series(offset, offset_tail, s, square, series);
        self.xor(result, sign)
    }

    /// acos x = √(1 − |x|) times a polynomial of |x|, and for negative x π minus that.
    ///
    /// Error up to 2.6 ulp (2.6 without FMA). NaN outside [−1, 1].
    pub(in crate::jit) fn acos(&mut self, x: Value) -> Value {
        let a = self.abs(x);
        let one = self.constant(1.0);
        let remainder = self.sub(one, a);
        let root = self.builder.ins().sqrt(remainder);
        let series = self.polynomial(a, &ACOS);
        let angle = self.mul(root, series);
        let pi = self.constant(PI);
        let reflected = self.mul_sub_from(root, series, pi);
        self.select_by_sign(x, reflected, angle)
    }

    /// atan x: an odd polynomial up to 1, and beyond it π/2 + atan(−1 / x).
    ///
    /// Error up to 1.4 ulp (1.5 without FMA). ±π/2 at ±∞; keeps −0.
    pub(in crate::jit) fn atan(&mut self, x: Value) -> Value {
        let a = self.abs(x);
        let sign = self.xor(x, a);
        let one = self.constant(1.0);
        let large = self.compare(FloatCC::GreaterThan, a, one);
        let minus_one = self.constant(-1.0);
        let folded = self.builder.ins().fdiv(minus_one, a);
        let t = self.select(large, folded, a);
        let offset = self.constant(FRAC_PI_2);
        let offset = self.keep(large, offset);
        let offset_tail = self.constant(FRAC_PI_2_TAIL);
        let offset_tail = self.keep(large, offset_tail);
        let square = self.mul(t, t);
        let series = self.polynomial(square, &ATAN);
        let result = self.offset_series(offset, offset_tail, t, square, series);
        self.xor(result, sign)
    }

    /// The angle of the point (x, y), in [−π, π]: the arctangent of the smaller over the larger magnitude, mirrored
    /// into the octant.
    ///
    /// Error up to 1.8 ulp (1.8 without FMA). Signed zeros and infinities as C's `atan2f`. NaN if either operand is.
    pub(in crate::jit) fn atan2(&mut self, y: Value, x: Value) -> Value {
        let ax = self.abs(x);
        let ay = self.abs(y);
        let steep = self.compare(FloatCC::GreaterThan, ay, ax);
        // If either is NaN, one of these is `ay` and the other `ax`, and the quotient is NaN.
        let small = self.lesser(ax, ay);
        let large = self.greater(ay, ax);
        // 0 / 0 becomes 0, and ∞ / ∞ becomes 1.
        let large = self.at_least(large, f32::MIN_POSITIVE);
        let quotient = self.builder.ins().fdiv(small, large);
        let equal = self.compare(FloatCC::Equal, small, large);
        let one = self.constant(1.0);
        let t = self.select(equal, one, quotient);

        // Quadrant angle and direction: +t, π/2 − t, π/2 + t, π − t.
        let bits = self.int(x);
        let leftward = self.shift_right(bits, 31);
        let pi = self.constant(PI);
        let flat_offset = self.keep(leftward, pi);
        let steep_offset = self.constant(FRAC_PI_2);
        let offset = self.select(steep, steep_offset, flat_offset);
        let offset_tail = self.scale(offset, FRAC_PI_2_TAIL / FRAC_PI_2);
        let direction = self.xor(steep, x);
        let direction = self.and_bits(direction, SIGN);
        let square = self.mul(t, t);
        let t = self.xor(t, direction);
        let series = self.polynomial(square, &ATAN);
        let result = self.offset_series(offset, offset_tail, t, square, series);
        let sign = self.and_bits(y, SIGN);
        self.xor(result, sign)
    }

    /// offset + t + t · t² · series, where the offset has a tail. The large terms are added first, so that their sum
    /// rounds once, and the small ones separately.
    fn offset_series(&mut self, offset: Value, offset_tail: Value, t: Value, square: Value, series: Value) -> Value {
        let cube = self.mul(t, square);
        let small = self.mul_add(cube, series, offset_tail);
        let large = self.add(offset, t);
        self.add(large, small)
    }
}
