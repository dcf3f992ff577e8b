//! Sine, cosine and tangent.

use super::{ROUNDER, VectorMath};
use cranelift_codegen::ir::condcodes::FloatCC;
use cranelift_codegen::ir::{InstBuilder, Value};
use std::f32::consts::{FRAC_1_PI, FRAC_2_PI};

/// (sin r − r) / r³ as a polynomial in r², |r| ≤ 1.58, degree 3, relative error of the sine 6.7e-9.
pub(crate) const SIN: [f32; 4] = [-0.1666666, 0.0083330665, -0.0001980944, 2.6051405e-6];

/// (tan r − r) / r³ as a polynomial in r², |r| ≤ 0.7935, degree 5, relative error of the tangent 2.1e-8.
pub(crate) const TAN: [f32; 6] = [0.3333313, 0.13339539, 0.053349357, 0.024653297, 0.002758911, 0.009600681];

/// The largest angle whose tangent is computed; beyond, the result is 0.
pub(crate) const TAN_RANGE: f32 = 131_072.0;

/// π as a sum of parts of 24 bits. All are positive, so that 0 times each has the same sign and −0 stays −0.
const PI: [f32; 3] = [3.1415925, 1.5099579e-7, 1.0780606e-14];

/// π as a sum of parts of eight bits, the last of 24. Their products with whole and half numbers up to 2¹⁵ are exact.
pub(crate) const PI_SHORT: [f32; 7] =
    [3.140625, 9.651184e-4, 2.5331974e-6, 1.9790605e-9, 5.1159077e-12, 1.0769163e-14, 1.1442378e-17];

/// A number that is lost when it is added to the square of any angle but 0.
const TINY: f32 = 7.888609e-31;

impl VectorMath<'_, '_> {
    /// sin x = (−1)ⁿ sin(x − nπ) with the nearest whole n. So one polynomial on [−π/2, π/2] is enough. The reduction
    /// follows Cody & Waite 1980.
    ///
    /// Error up to 1.7 ulp (2.0 without FMA) for |x| ≤ 10⁵, also at the floats nearest to multiples of π. Beyond, the
    /// result is less and less accurate, but stays in [−1, 1]. Keeps −0; NaN for ±∞.
    pub(in crate::jit) fn sin(&mut self, x: Value) -> Value {
        let inverse = self.constant(FRAC_1_PI);
        let rounder = self.constant(ROUNDER);
        let rounded = self.mul_add(x, inverse, rounder);
        let rounder = self.constant(ROUNDER);
        let n = self.sub(rounded, rounder);
        let r = self.reduce(x, n, 1.0);
        self.alternating_sine(r, rounded)
    }

    /// cos x = −(−1)ⁿ sin(x − (n + ½)π), otherwise as [`Self::sin`].
    ///
    /// Error up to 1.8 ulp (2.1 without FMA) for |x| ≤ 10⁵, also at the floats nearest to the zeros. Beyond, the result
    /// stays in [−1, 1]. NaN for ±∞.
    pub(in crate::jit) fn cos(&mut self, x: Value) -> Value {
        let inverse = self.constant(FRAC_1_PI);
        let half = self.constant(-0.5);
        let quotient = self.mul_add(x, inverse, half);
        // One more turns even into odd numbers, which is the minus sign.
        let rounder = self.constant(ROUNDER + 1.0);
        let rounded = self.add(quotient, rounder);
        let rounder = self.constant(ROUNDER + 1.0);
        let n = self.sub(rounded, rounder);
        let half = self.constant(0.5);
        let n = self.add(n, half);
        let r = self.reduce(x, n, 1.0);
        self.alternating_sine(r, rounded)
    }

    /// tan x = tan r for even n, −1 / tan r for odd n, where r = x − n π/2 with the nearest whole n.
    ///
    /// Error up to 3.1 ulp (3.1 without FMA) for |x| ≤ 10⁵, also at the floats nearest to zeros and poles. Beyond 2¹⁷
    /// the result is 0. Keeps −0; NaN for ±∞.
    pub(in crate::jit) fn tan(&mut self, x: Value) -> Value {
        let inverse = self.constant(FRAC_2_PI);
        let rounder = self.constant(ROUNDER);
        let rounded = self.mul_add(x, inverse, rounder);
        let rounder = self.constant(ROUNDER);
        let n = self.sub(rounded, rounder);
        let r = self.reduce(x, n, 0.5);
        let square = self.mul(r, r);
        let series = self.polynomial(square, &TAN);
        let cube = self.mul(r, square);
        let tangent = self.mul_add(cube, series, r);
        let minus_one = self.constant(-1.0);
        let cotangent = self.builder.ins().fdiv(minus_one, tangent);
        let parity = self.parity_sign(rounded);
        let result = self.select_by_sign(parity, cotangent, tangent);
        // x − x is 0 for finite x and NaN for the others.
        let magnitude = self.abs(x);
        let range = self.constant(TAN_RANGE);
        let inside = self.compare(FloatCC::LessThanOrEqual, magnitude, range);
        let outside = self.sub(x, x);
        self.select(inside, result, outside)
    }

    /// x − n · scale · π. The relative error is small however near to 0 the difference is.
    fn reduce(&mut self, x: Value, n: Value, scale: f32) -> Value {
        if self.fma {
            // The first step is exact, since x and the product have the same leading bits. The others round once,
            // relative to their result.
            return PI.iter().fold(x, |r, part| {
                let part = self.constant(-part * scale);
                self.mul_add(n, part, r)
            });
        }
        let [first, second, third, fourth, fifth, rest @ ..] = PI_SHORT;
        let part = self.scale(n, first * scale);
        let r = self.sub(x, part);
        let part = self.scale(n, second * scale);
        let r = self.sub(r, part);
        // Everything so far is exact. The next two steps are exact only where r gets small. Elsewhere a subtraction
        // gives their rounding errors exactly, and these are added to the fifth.
        let mut error = None;
        let mut r = r;
        for part in [third, fourth] {
            let part = self.scale(n, part * scale);
            let next = self.sub(r, part);
            let taken = self.sub(r, next);
            let lost = self.sub(taken, part);
            error = Some(error.map_or(lost, |error| self.add(error, lost)));
            r = next;
        }
        let part = self.scale(n, fifth * scale);
        let part = error.map_or(part, |error| self.sub(part, error));
        let r = self.sub(r, part);
        rest.iter().fold(r, |r, part| {
            let part = self.scale(n, part * scale);
            self.sub(r, part)
        })
    }

    /// sin r, negated where `rounded`, a whole number plus [`ROUNDER`], is odd.
    fn alternating_sine(&mut self, r: Value, rounded: Value) -> Value {
        // For r = −0 the square must be negative, so that the cubic term is −0 too and the sum keeps its sign.
        let tiny = self.constant(-TINY);
        let square = self.mul_add(r, r, tiny);
        let series = self.polynomial(square, &SIN);
        let cube = self.mul(r, square);
        let sine = self.mul_add(cube, series, r);
        // Near ±π/2 rounding can go one step beyond 1. For larger angles r can be anything up to infinite: then all
        // terms have the same sign, and the sum is clamped.
        let sine = self.at_most(sine, 1.0);
        let sine = self.at_least(sine, -1.0);
        let parity = self.parity_sign(rounded);
        self.xor(sine, parity)
    }

    /// The sign bit set where `rounded`, a whole number plus [`ROUNDER`], is odd.
    fn parity_sign(&mut self, rounded: Value) -> Value {
        let bits = self.int(rounded);
        self.shift_left(bits, 31)
    }
}
