//! The scalar operations (primitives) of which all operations of the language are made, each defined once.
//!
//! A row of the table defines a primitive: its name, its operands, its meaning, what it costs, and which values it can
//! yield. From the table follow the [`Primitive`] enumeration and the [`Scalars`] trait with a method for every
//! primitive. [`Floats`] computes them in `f32`, which is the meaning of the language; [`Doubles`] computes the same in
//! `f64`, to judge results in `f32`. Other implementations of [`Scalars`] give the primitives another meaning: the
//! expression graph records them, the code generator emits instructions for them. An implementation that lacks a
//! primitive does not compile. Operators and functions of the language are written in terms of these methods, in
//! [`builtins`](crate::lang::builtins).

use crate::lang::interval::Interval;
use crate::lang::noise;
use crate::measured::kept;
use crate::texture;

macro_rules! yields_truth {
    (Number) => {
        false
    };
    (Truth) => {
        true
    };
}

macro_rules! primitives {
    ($($(#[$doc:meta])* $variant:ident $method:ident($($operand:ident),+) -> $kind:ident = $meaning:expr,
        cost $cost:literal, interval $interval:expr;)*) => {
        /// A scalar operation.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Primitive {
            $($(#[$doc])* $variant,)*
        }

        /// A meaning of the scalar operations: as arithmetic, as nodes of a graph, as machine instructions.
        pub trait Scalars {
            /// The type of a scalar, and of a truth value.
            type Value: Copy;
            /// The scalar with this value.
            fn constant(&mut self, value: f32) -> Self::Value;
            $($(#[$doc])* fn $method(&mut self, $($operand: Self::Value),+) -> Self::Value;)*
        }

        impl Primitive {
            /// Every primitive.
            pub const ALL: &[Primitive] = &[$(Primitive::$variant,)*];

            /// Its name, as in dumps.
            pub fn name(self) -> &'static str {
                match self {
                    $(Primitive::$variant => stringify!($method),)*
                }
            }

            /// Whether its result is a truth value rather than a number.
            pub fn yields_truth(self) -> bool {
                match self {
                    $(Primitive::$variant => yields_truth!($kind),)*
                }
            }

            /// The most operands that any primitive takes.
            pub const MAX_ARITY: usize = {
                let arities = [$([$(stringify!($operand)),+].len()),*];
                let (mut most, mut index) = (0, 0);
                while index < arities.len() {
                    most = if arities[index] > most { arities[index] } else { most };
                    index += 1;
                }
                most
            };

            /// How many operands it takes.
            pub fn arity(self) -> usize {
                match self {
                    $(Primitive::$variant => [$(stringify!($operand)),+].len(),)*
                }
            }

            /// How many simple instructions (additions, selections) it takes as long as, roughly.
            pub fn cost(self) -> u32 {
                match self {
                    $(Primitive::$variant => $cost,)*
                }
            }

            /// Applies it to operands; `scalars` gives it its meaning.
            ///
            /// # Panics
            /// The number of operands is not its [`arity`](Self::arity).
            pub fn apply<M: Scalars>(self, scalars: &mut M, operands: &[M::Value]) -> M::Value {
                match (self, operands) {
                    $((Primitive::$variant, &[$($operand),+]) => scalars.$method($($operand),+),)*
                    (primitive, operands) => unreachable!("{primitive:?} does not take {} operands", operands.len()),
                }
            }

            /// The values that it can yield for operands with these values.
            ///
            /// # Panics
            /// The number of operands is not its [`arity`](Self::arity).
            #[allow(unused_variables, reason = "of some primitives the result does not depend on the operands")]
            pub fn interval(self, operands: &[Interval]) -> Interval {
                match (self, operands) {
                    $((Primitive::$variant, &[$($operand),+]) => $interval.rounded(),)*
                    (primitive, operands) => unreachable!("{primitive:?} does not take {} operands", operands.len()),
                }
            }
        }

        impl<R: Recorder> Scalars for R {
            type Value = R::Value;

            fn constant(&mut self, value: f32) -> R::Value {
                self.record_constant(value)
            }
            $(fn $method(&mut self, $($operand: R::Value),+) -> R::Value {
                self.record(Primitive::$variant, &[$($operand),+])
            })*
        }

        impl Scalars for Floats {
            type Value = f32;

            fn constant(&mut self, value: f32) -> f32 {
                flush(value)
            }
            $(#[inline] fn $method(&mut self, $($operand: f32),+) -> f32 {
                flush($meaning)
            })*
        }

        impl Scalars for Doubles {
            type Value = f64;

            fn constant(&mut self, value: f32) -> f64 {
                flush(value).into()
            }
            $(fn $method(&mut self, $($operand: f64),+) -> f64 {
                $meaning
            })*
        }
    };
}
// `Variant method(operands) -> kind of result = meaning, cost, interval of the result;`
//
// The meaning is written once for `f32` and `f64`. Truth values are 1 and 0. Every operand is normal, zero, infinite or
// NaN, and so is every result, see `flush`. In the last column operands are intervals.
primitives! {
    /// −x
    Neg neg(x) -> Number = -x, cost 1, interval -x;
    /// x + y
    Add add(x, y) -> Number = x + y, cost 1, interval x + y;
    /// x − y
    Sub sub(x, y) -> Number = x - y, cost 1, interval x - y;
    /// x · y
    Mul mul(x, y) -> Number = x * y, cost 1, interval x * y;
    /// x / y
    Div div(x, y) -> Number = x / y, cost 5, interval x / y;
    /// √x
    Sqrt sqrt(x) -> Number = x.sqrt(), cost 5, interval x.sqrt();
    /// The largest whole number not above x.
    Floor floor(x) -> Number = x.floor(), cost 1, interval x.growing(f64::floor);
    /// The smallest whole number not below x.
    Ceil ceil(x) -> Number = x.ceil(), cost 1, interval x.growing(f64::ceil);
    /// |x|
    Abs abs(x) -> Number = x.abs(), cost 1, interval x.abs();
    /// x if x < y, else y; so y if either is NaN.
    Min min(x, y) -> Number = if x < y { x } else { y }, cost 1, interval x.min(y);
    /// x if x > y, else y; so y if either is NaN.
    Max max(x, y) -> Number = if x > y { x } else { y }, cost 1, interval x.max(y);
    /// eˣ
    Exp exp(x) -> Number = x.exp(), cost 16, interval x.exponential(f64::exp);
    /// 2ˣ
    Exp2 exp2(x) -> Number = x.exp2(), cost 16, interval x.exponential(f64::exp2);
    /// Natural logarithm.
    Log log(x) -> Number = x.ln(), cost 16, interval x.logarithm(f64::ln);
    /// Logarithm to base 2.
    Log2 log2(x) -> Number = x.log2(), cost 16, interval x.logarithm(f64::log2);
    /// xʸ as C's `powf`.
    Pow pow(x, y) -> Number = x.powf(y), cost 60, interval x.powf(y);
    /// Sine of x radians.
    Sin sin(x) -> Number = x.sin(), cost 24, interval x.circular();
    /// Cosine of x radians.
    Cos cos(x) -> Number = x.cos(), cost 24, interval x.circular();
    /// Tangent of x radians.
    Tan tan(x) -> Number = x.tan(), cost 24, interval x.tan();
    /// Arc sine in radians.
    Asin asin(x) -> Number = x.asin(), cost 24, interval x.asin();
    /// Arc cosine in radians.
    Acos acos(x) -> Number = x.acos(), cost 24, interval x.acos();
    /// Arc tangent in radians.
    Atan atan(x) -> Number = x.atan(), cost 24, interval x.atan();
    /// The angle of the point (x, y) in radians, −π..π.
    Atan2 atan2(y, x) -> Number = y.atan2(x), cost 24, interval y.atan2(x);
    /// Perlin's noise summed over octaves at the point (x, y, z); see [`noise::perlin`].
    Perlin perlin(x, y, z, a, b, n) -> Number = noise::perlin([x, y, z], a, b, n), cost 1000, interval Interval::ANYTHING;
    /// A component (0 is red) of the colour of texture number `t` at the surface coordinates (u, v), see
    /// [`texture::component`].
    Texture texture(t, u, v, c) -> Number = texture::component(t, u, v, c), cost 60, interval Interval::FINITE;
    /// A component (0 is red) of π times the reflectance of measured material number `m`, at stereographic coordinates
    /// of the light and of the view, see [`kept::component`].
    Measured measured(m, lx, ly, vx, vy, c) -> Number = kept::component(m, [lx, ly], [vx, vy], c),
        cost 400, interval Interval::new(0.0, kept::LARGEST.into());
    /// Whether x < y.
    Less less(x, y) -> Truth = truth(x < y), cost 1, interval Interval::TRUTH;
    /// Whether x ≤ y.
    LessEqual less_equal(x, y) -> Truth = truth(x <= y), cost 1, interval Interval::TRUTH;
    /// Whether x = y.
    Equal equal(x, y) -> Truth = truth(x == y), cost 1, interval Interval::TRUTH;
    /// Whether both hold.
    And and(p, q) -> Truth = truth(p != 0.0 && q != 0.0), cost 1, interval Interval::TRUTH;
    /// Whether at least one holds.
    Or or(p, q) -> Truth = truth(p != 0.0 || q != 0.0), cost 1, interval Interval::TRUTH;
    /// Whether it does not hold.
    Not not(p) -> Truth = truth(p == 0.0), cost 1, interval Interval::TRUTH;
    /// x if p holds, else y.
    Select select(p, x, y) -> Number = if p != 0.0 { x } else { y }, cost 1, interval x.hull(y);
}

/// A meaning of the scalar operations that treats all of them alike: as nodes of a graph, or computed and then
/// perturbed.
pub trait Recorder {
    /// The type of a scalar, and of a truth value.
    type Value: Copy;
    /// The scalar with this value.
    fn record_constant(&mut self, value: f32) -> Self::Value;
    /// The result of a primitive. The number of operands is its arity.
    fn record(&mut self, primitive: Primitive, operands: &[Self::Value]) -> Self::Value;
}

/// The primitives computed in `f32` with the standard library's mathematics: the reference meaning.
#[derive(Debug, Clone, Copy, Default)]
pub struct Floats;

/// The primitives computed in `f64`: nearly the exact results, without the rounding of `f32`, and without its overflow
/// and underflow.
#[derive(Debug, Clone, Copy, Default)]
pub struct Doubles;

/// The number, or zero with its sign in place of a subnormal one.
#[inline]
pub fn flush(x: f32) -> f32 {
    if x.abs() < f32::MIN_POSITIVE { 0.0_f32.copysign(x) } else { x }
}

fn truth<T: From<u8>>(holds: bool) -> T {
    T::from(u8::from(holds))
}

/// Zeros, the ends of the normal numbers, infinities, NaN, and numbers where functions turn: operands for tests of
/// every primitive.
#[cfg(test)]
pub(crate) const AWKWARD: [f32; 32] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    1.5,
    -2.0,
    3.0,
    0.999_999_94,
    -0.999_999_94,
    1.000_000_1,
    std::f32::consts::PI,
    -std::f32::consts::FRAC_PI_2,
    10.0,
    -100.5,
    88.0,
    1e5,
    -1e5,
    8_388_608.5,
    16_777_216.0,
    1e-10,
    -1e-10,
    1e10,
    -1e20,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// Operands for tests of a primitive: every pair of [`AWKWARD`] numbers where it takes one or two, a spread of them
/// where it takes more.
#[cfg(test)]
pub(crate) fn awkward_operands(primitive: Primitive) -> Vec<Vec<f32>> {
    let number = |index: usize| AWKWARD[index % AWKWARD.len()];
    match primitive.arity() {
        1 => AWKWARD.iter().map(|x| vec![*x]).collect(),
        2 => AWKWARD.iter().flat_map(|x| AWKWARD.iter().map(move |y| vec![*x, *y])).collect(),
        // Steps without a common divisor, so that combinations differ.
        arity => (0..5000)
            .map(|case| (0..arity).map(|index| number(case * (2 * index + 1) / (index + 1) + 7 * index)).collect())
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn min_and_max_take_the_second_operand_where_nothing_compares() {
        let mut m = Floats;
        assert_eq!(m.min(f32::NAN, 2.0), 2.0);
        assert!(m.min(2.0, f32::NAN).is_nan());
        assert_eq!(m.max(f32::NAN, 2.0), 2.0);
        assert!(m.max(2.0, f32::NAN).is_nan());
    }

    #[test]
    fn subnormals_count_as_zero() {
        assert_eq!(Floats.mul(1e-30, 1e-12).to_bits(), 0.0_f32.to_bits());
        assert_eq!(Floats.mul(-1e-30, 1e-12).to_bits(), (-0.0_f32).to_bits());
        assert_eq!(Floats.constant(1e-40), 0.0);
    }

    #[test]
    fn doubles_differ_from_floats_by_rounding_and_range_alone() {
        for &primitive in Primitive::ALL {
            for operands in awkward_operands(primitive) {
                let single = primitive.apply(&mut Floats, &operands);
                let doubles: Vec<f64> = operands.iter().map(|operand| f64::from(*operand)).collect();
                let mut double = primitive.apply(&mut Doubles, &doubles);
                if double.abs() > f64::from(f32::MAX) {
                    double = f64::INFINITY.copysign(double);
                }
                let near = (f64::from(single) - double).abs() <= 4e-7 * double.abs() + 2.0 * f64::from(f32::MIN_POSITIVE);
                // Noise is a sum of many terms, which may be large and cancel.
                let noisy = primitive == Primitive::Perlin;
                let same = f64::from(single) == double || single.is_nan() && double.is_nan();
                assert!(same || near || noisy, "{primitive:?}{operands:?} = {single}, {double} in double precision");
            }
        }
    }

    #[test]
    fn results_lie_in_the_interval_of_every_primitive() {
        // Intervals between neighbours and distant ones among the sorted numbers; NaN and −0 by flags.
        let mut numbers: Vec<f32> = AWKWARD.into_iter().filter(|x| !x.is_nan()).collect();
        numbers.sort_by(f32::total_cmp);
        let count = numbers.len();
        let spans: Vec<[usize; 2]> =
            (0..count).flat_map(|low| [0, 1, 2, 5, count].map(|step| [low, (low + step).min(count - 1)])).collect();
        let interval = |[low, high]: [usize; 2]| {
            let members = &numbers[low..=high];
            let negative_zero = members.iter().any(|x| *x == 0.0 && x.is_sign_negative());
            let ends = [numbers[low], numbers[high]].map(f64::from);
            (Interval { low: ends[0], high: ends[1], nan: false, negative_zero }, members)
        };
        for &primitive in Primitive::ALL {
            let arity = primitive.arity();
            let choices = spans.len().pow(arity.min(2) as u32);
            for choice in 0..choices {
                let chosen: Vec<_> =
                    (0..arity).map(|index| interval(spans[choice / spans.len().pow((index % 2) as u32) % spans.len()])).collect();
                let operands: Vec<Interval> = chosen.iter().map(|(interval, _)| *interval).collect();
                let result = primitive.interval(&operands);
                for sample in 0..8 {
                    let members: Vec<f32> = chosen
                        .iter()
                        .enumerate()
                        .map(|(index, (_, members))| members[sample * (index + 1) * 5 % members.len()])
                        .collect();
                    let value = primitive.apply(&mut Floats, &members);
                    let holds = if value.is_nan() {
                        result.nan
                    } else {
                        let inside = (result.low..=result.high).contains(&f64::from(value));
                        inside && (value != 0.0 || value.is_sign_positive() || result.negative_zero)
                    };
                    assert!(holds, "{primitive:?}{members:?} = {value}, not in {result:?} of {operands:?}");
                }
            }
        }
    }
}
