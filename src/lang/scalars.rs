//! The scalar operations (primitives) of which all operations of the language are made, each defined once.
//!
//! A row of the table gives a primitive's name, operands and meaning on `f32`. The table defines the [`Primitive`] enumeration,
//! the [`Scalars`] trait with a method for every primitive, and [`Floats`], which computes them. Other implementations of
//! [`Scalars`] give the primitives another meaning: the expression graph records them, the code generator emits instructions
//! for them. An implementation that forgets a primitive does not compile. The operators and functions of the language are
//! written in terms of these methods, in [`builtins`](crate::lang::builtins).

use crate::lang::noise;

macro_rules! primitives {
    ($($(#[$doc:meta])* $variant:ident $method:ident($($operand:ident),+) = $meaning:expr;)*) => {
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
                use Primitive::{And, Equal, Less, LessEqual, Not, Or};
                matches!(self, Less | LessEqual | Equal | And | Or | Not)
            }

            /// How many operands it takes.
            pub fn arity(self) -> usize {
                match self {
                    $(Primitive::$variant => [$(stringify!($operand)),+].len(),)*
                }
            }

            /// Applies it to operands; `scalars` gives it its meaning.
            ///
            /// # Panics
            /// The number of operands is not its [`arity`](Self::arity): an error of the caller, not of its input.
            pub fn apply<M: Scalars>(self, scalars: &mut M, operands: &[M::Value]) -> M::Value {
                match (self, operands) {
                    $((Primitive::$variant, &[$($operand),+]) => scalars.$method($($operand),+),)*
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
    };
}
// `Variant method(operands) = meaning on f32;` Truth values are 1 and 0. Every operand is normal, zero, infinite or NaN, and so
// is every result, see `flush`.
primitives! {
    /// −x
    Neg neg(x) = -x;
    /// x + y
    Add add(x, y) = x + y;
    /// x − y
    Sub sub(x, y) = x - y;
    /// x · y
    Mul mul(x, y) = x * y;
    /// x / y
    Div div(x, y) = x / y;
    /// √x
    Sqrt sqrt(x) = x.sqrt();
    /// The largest whole number not above x.
    Floor floor(x) = x.floor();
    /// The smallest whole number not below x.
    Ceil ceil(x) = x.ceil();
    /// |x|
    Abs abs(x) = x.abs();
    /// x if x < y, else y; so y if either is NaN.
    Min min(x, y) = if x < y { x } else { y };
    /// x if x > y, else y; so y if either is NaN.
    Max max(x, y) = if x > y { x } else { y };
    /// eˣ
    Exp exp(x) = x.exp();
    /// 2ˣ
    Exp2 exp2(x) = x.exp2();
    /// Natural logarithm.
    Log log(x) = x.ln();
    /// Logarithm to base 2.
    Log2 log2(x) = x.log2();
    /// xʸ as C's `powf`.
    Pow pow(x, y) = x.powf(y);
    /// Sine of x radians.
    Sin sin(x) = x.sin();
    /// Cosine of x radians.
    Cos cos(x) = x.cos();
    /// Tangent of x radians.
    Tan tan(x) = x.tan();
    /// Arc sine in radians.
    Asin asin(x) = x.asin();
    /// Arc cosine in radians.
    Acos acos(x) = x.acos();
    /// Arc tangent in radians.
    Atan atan(x) = x.atan();
    /// The angle of the point (x, y) in radians, −π..π.
    Atan2 atan2(y, x) = y.atan2(x);
    /// Perlin's noise summed over octaves at the point (x, y, z); see [`noise::perlin`].
    Perlin perlin(x, y, z, a, b, n) = noise::perlin([x, y, z], a, b, n);
    /// Whether x < y.
    Less less(x, y) = truth(x < y);
    /// Whether x ≤ y.
    LessEqual less_equal(x, y) = truth(x <= y);
    /// Whether x = y.
    Equal equal(x, y) = truth(x == y);
    /// Whether both hold.
    And and(p, q) = truth(p != 0.0 && q != 0.0);
    /// Whether at least one holds.
    Or or(p, q) = truth(p != 0.0 || q != 0.0);
    /// Whether it does not hold.
    Not not(p) = truth(p == 0.0);
    /// x if p holds, else y.
    Select select(p, x, y) = if p != 0.0 { x } else { y };
}

/// A meaning of the scalar operations that treats all of them alike: as nodes of a graph, or computed and then disturbed.
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

/// Subnormal numbers count as zero (with their sign).
#[inline]
pub fn flush(x: f32) -> f32 {
    if x.abs() < f32::MIN_POSITIVE { 0.0_f32.copysign(x) } else { x }
}

fn truth(holds: bool) -> f32 {
    if holds { 1.0 } else { 0.0 }
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
}
