//! Every operator and function of the language, defined once.
//!
//! A row of the table gives an overload's name in the bytecode, how it is written, its types, where it comes from, a
//! line for the reference, and its meaning in terms of the [`Scalars`] primitives. The parser's and checker's
//! knowledge, the interpreter, the expression graph (and so the compiled code), constant folding, the printed reference
//! and the tests all derive from here.

use crate::lang::scalars::{Floats, Scalars};
use crate::lang::token::Mark;
use crate::lang::types::{Origin, Type};
use smallvec::SmallVec;

/// How an operation is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Form {
    /// Before its operand.
    Prefix(Mark),
    /// Between its operands.
    Infix(Mark),
    /// Like `.`, if both operands are known to be directions of unit length.
    UnitDot,
    /// `name(a, b, …)`.
    Function(&'static str),
    /// A name without operands.
    Constant(&'static str),
    /// `name(u, v)`, where the name is that of a texture parameter.
    Texture,
    /// `measured("file")` or `measured("file", l, v)`.
    Measured,
    /// `<x, y, z>` or `<x>`.
    Vector,
    /// `if(condition, then, else)`.
    Conditional,
}

/// A sum or a product of an expression over the whole numbers of a range: `sum(i, 0, 4, expression)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Repetition {
    /// `sum`
    Sum,
    /// `product`
    Product,
}

impl Repetition {
    /// Both.
    pub const ALL: [Repetition; 2] = [Repetition::Sum, Repetition::Product];
    /// The most terms.
    pub const MOST_TERMS: u32 = 256;

    /// The name by which it is called.
    pub fn name(self) -> &'static str {
        match self {
            Repetition::Sum => "sum",
            Repetition::Product => "product",
        }
    }

    /// How it is called.
    pub fn usage(self) -> String {
        format!("{}(i, from, to, expression)", self.name())
    }

    /// The operator between the terms.
    pub fn operator(self) -> Form {
        Form::Infix(match self {
            Repetition::Sum => Mark::Plus,
            Repetition::Product => Mark::Star,
        })
    }

    /// The value of an empty range.
    pub fn empty(self) -> f32 {
        match self {
            Repetition::Sum => 0.0,
            Repetition::Product => 1.0,
        }
    }

    /// What it means, in one line.
    pub fn doc(self) -> &'static str {
        match self {
            Repetition::Sum => "the sum of the expression for each whole number i from..to; both are constant, at most 256 terms",
            Repetition::Product => "the product of the expression for each whole number i from..to, like sum",
        }
    }

    /// The repetition of this name.
    pub fn named(name: &str) -> Option<Repetition> {
        Self::ALL.into_iter().find(|repetition| repetition.name() == name)
    }
}

/// Operands and results of operations: a stack of scalars. A vector takes three, its first component deepest.
#[derive(Debug, Clone)]
pub struct Stack<T> {
    slots: Vec<T>,
    top: usize,
}

impl<T: Copy> Stack<T> {
    /// An empty stack for at most `depth` scalars; unused slots hold `filler`.
    pub fn new(depth: usize, filler: T) -> Self {
        Self { slots: vec![filler; depth], top: 0 }
    }

    /// Pushes a scalar.
    ///
    /// # Panics
    /// The stack is full: the depth given to [`new`](Self::new) must suffice for whoever fills it.
    #[inline]
    pub fn push(&mut self, value: T) {
        self.slots[self.top] = value;
        self.top += 1;
    }

    /// Removes the topmost `N` scalars, and returns them, deepest first.
    ///
    /// # Panics
    /// There are fewer.
    #[inline(always)]
    pub fn pop<const N: usize>(&mut self) -> [T; N] {
        let top = self.top;
        self.top -= N;
        // One bounds check for all of them: this is the inner loop of the interpreter.
        let slots = &self.slots[self.top..top];
        std::array::from_fn(|index| slots[index])
    }

    /// The number of scalars.
    pub fn len(&self) -> usize {
        self.top
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.top == 0
    }

    /// Removes everything.
    pub fn clear(&mut self) {
        self.top = 0;
    }
}

macro_rules! type_of {
    (S) => {
        Type::Scalar
    };
    (V) => {
        Type::Vector
    };
    (B) => {
        Type::Truth
    };
    (T) => {
        Type::Texture
    };
}

macro_rules! take {
    ($slots:ident, $at:ident, V) => {{
        $at += 3;
        [$slots[$at - 3], $slots[$at - 2], $slots[$at - 1]]
    }};
    ($slots:ident, $at:ident, $scalar:ident) => {{
        $at += 1;
        $slots[$at - 1]
    }};
}

macro_rules! put {
    ($stack:ident, $value:expr, V) => {{
        let [x, y, z] = $value;
        $stack.push(x);
        $stack.push(y);
        $stack.push(z);
    }};
    ($stack:ident, $value:expr, $scalar:ident) => {{
        let value = $value;
        $stack.push(value);
    }};
}

macro_rules! operations {
    ($($variant:ident $form:ident $(($spelling:expr))? [$($operand:ident: $type:ident),*] -> $result:ident
        $origin:ident $doc:literal, |$m:ident| $meaning:expr;)*) => {
        /// An operator or function for certain types of operands. Its number is its opcode in the bytecode.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u8)]
        pub enum Operation {
            $(#[doc = $doc] $variant,)*
        }

        impl Operation {
            /// Every operation, in the order of the table.
            pub const ALL: &[Operation] = &[$(Operation::$variant,)*];

            /// Its name in the bytecode.
            pub fn name(self) -> &'static str {
                match self {
                    $(Operation::$variant => stringify!($variant),)*
                }
            }

            /// How it is written.
            pub fn form(self) -> Form {
                match self {
                    $(Operation::$variant => Form::$form $(($spelling))?,)*
                }
            }

            /// The types of its operands.
            pub fn operands(self) -> &'static [Type] {
                match self {
                    $(Operation::$variant => &[$(type_of!($type)),*],)*
                }
            }

            /// The names of its operands, as the reference shows them.
            pub fn operand_names(self) -> &'static [&'static str] {
                match self {
                    $(Operation::$variant => &[$(stringify!($operand)),*],)*
                }
            }

            /// The type of its result.
            pub fn result(self) -> Type {
                match self {
                    $(Operation::$variant => type_of!($result),)*
                }
            }

            /// Where it comes from.
            pub fn origin(self) -> Origin {
                match self {
                    $(Operation::$variant => Origin::$origin,)*
                }
            }

            /// What it means, in one line.
            pub fn doc(self) -> &'static str {
                match self {
                    $(Operation::$variant => $doc,)*
                }
            }

            /// Replaces its operands on top of the stack by its result; `scalars` gives the primitives their meaning.
            #[inline]
            #[allow(unused_assignments, unused_mut, unused_variables, reason = "of operations without operands")]
            pub fn apply<M: Scalars>(self, scalars: &mut M, stack: &mut Stack<M::Value>) {
                match self {
                    $(Operation::$variant => {
                        const SLOTS: usize = 0 $(+ type_of!($type).slots())*;
                        let slots = stack.pop::<SLOTS>();
                        let mut at = 0;
                        $(let $operand = take!(slots, at, $type);)*
                        let $m = &mut *scalars;
                        put!(stack, $meaning, $result);
                    })*
                }
            }
        }
    };
}

operations! {
    NegS Prefix(Mark::Minus) [x: S] -> S Thesis "the negative", |m| m.neg(x);
    NegV Prefix(Mark::Minus) [x: V] -> V Added "the opposite vector", |m| x.map(|x| m.neg(x));
    AddSS Infix(Mark::Plus) [x: S, y: S] -> S Thesis "sum", |m| m.add(x, y);
    AddVV Infix(Mark::Plus) [x: V, y: V] -> V Thesis "sum by components", |m| zip(x, y, |x, y| m.add(x, y));
    SubSS Infix(Mark::Minus) [x: S, y: S] -> S Thesis "difference", |m| m.sub(x, y);
    SubVV Infix(Mark::Minus) [x: V, y: V] -> V Thesis "difference by components", |m| zip(x, y, |x, y| m.sub(x, y));
    MulSS Infix(Mark::Star) [x: S, y: S] -> S Thesis "product", |m| m.mul(x, y);
    MulVV Infix(Mark::Star) [x: V, y: V] -> V Thesis "product by components", |m| zip(x, y, |x, y| m.mul(x, y));
    MulVS Infix(Mark::Star) [x: V, y: S] -> V Thesis "vector times scalar", |m| x.map(|x| m.mul(x, y));
    MulSV Infix(Mark::Star) [x: S, y: V] -> V Thesis "scalar times vector", |m| y.map(|y| m.mul(x, y));
    DivSS Infix(Mark::Slash) [x: S, y: S] -> S Thesis "quotient", |m| m.div(x, y);
    DivVS Infix(Mark::Slash) [x: V, y: S] -> V Thesis "vector divided by scalar", |m| x.map(|x| m.div(x, y));
    DivVV Infix(Mark::Slash) [x: V, y: V] -> V Added "quotient by components", |m| zip(x, y, |x, y| m.div(x, y));
    DotVV Infix(Mark::Dot) [x: V, y: V] -> S Thesis "dot product", |m| dot(m, x, y);
    PowerSS Infix(Mark::Caret) [x: S, y: S] -> S Thesis
        "x to the power y, as C's powf: whole exponents take negative bases, and x^0 = 1", |m| m.pow(x, y);
    UnitDotVV UnitDot [x: V, y: V] -> S Thesis "dot product of two directions of unit length, within -1..1", |m| {
        let cosine = dot(m, x, y);
        let (low, high) = (m.constant(-1.0), m.constant(1.0));
        // In this order NaN stays NaN.
        let raised = m.max(low, cosine);
        m.min(high, raised)
    };
    TextureColour Texture [texture: T, u: S, v: S] -> V Added
        "colour of a texture parameter at (u, v), linear RGB; it repeats outside 0..1, and (0, 0) is the lower left corner", |m| {
        let components = [0.0, 1.0, 2.0].map(|index| m.constant(index));
        components.map(|component| m.texture(texture, u, v, component))
    };
    MeasuredReflectance Measured [file: S, l: V, v: V, normal: V, tangent: V] -> V Added
        "π times the reflectance of a measured material for the directions l and v, which are L and V if they are left out; see the manual", |m| {
        let light = hemisphere(m, l, normal, tangent);
        let view = hemisphere(m, v, normal, tangent);
        let components = [0.0, 1.0, 2.0].map(|index| m.constant(index));
        components.map(|component| m.measured(file, light[0], light[1], view[0], view[1], component))
    };
    MakeVector Vector [x: S, y: S, z: S] -> V Thesis "the vector of three components", |m| { let _ = &m; [x, y, z] };
    Spread Vector [x: S] -> V Added "the vector of three equal components, the same as <x, x, x>", |m| { let _ = &m; [x; 3] };
    Sqrt Function("sqrt") [x: S] -> S Thesis "square root", |m| m.sqrt(x);
    Floor Function("floor") [x: S] -> S Thesis "the largest whole number not above x", |m| m.floor(x);
    Ceil Function("ceil") [x: S] -> S Added "the smallest whole number not below x", |m| m.ceil(x);
    Exp Function("exp") [x: S] -> S Thesis "e to the power x", |m| m.exp(x);
    Exp2 Function("exp2") [x: S] -> S Added "2 to the power x", |m| m.exp2(x);
    Log Function("log") [x: S] -> S Thesis "natural logarithm", |m| m.log(x);
    Log2 Function("log2") [x: S] -> S Added "logarithm to base 2", |m| m.log2(x);
    Pow Function("pow") [x: S, y: S] -> S Thesis "the same as x^y", |m| m.pow(x, y);
    Sin Function("sin") [x: S] -> S Thesis "sine of an angle in radians", |m| m.sin(x);
    Cos Function("cos") [x: S] -> S Thesis "cosine of an angle in radians", |m| m.cos(x);
    Tan Function("tan") [x: S] -> S Thesis "tangent of an angle in radians", |m| m.tan(x);
    Asin Function("asin") [x: S] -> S Added "arc sine, in radians", |m| m.asin(x);
    Acos Function("acos") [x: S] -> S Added "arc cosine, in radians", |m| m.acos(x);
    Atan Function("atan") [x: S] -> S Added "arc tangent, in radians", |m| m.atan(x);
    Atan2 Function("atan2") [y: S, x: S] -> S Added "the angle of the point (x, y), in radians, -pi..pi", |m| m.atan2(y, x);
    Tanh Function("tanh") [x: S] -> S Added "hyperbolic tangent", |m| tanh(m, x);
    Erf Function("erf") [x: S] -> S Added "error function", |m| erf(m, x);
    Radians Function("radians") [x: S] -> S Added "degrees into radians", |m| {
        let factor = m.constant(std::f32::consts::PI / 180.0);
        m.mul(x, factor)
    };
    Abs Function("abs") [x: S] -> S Added "absolute value", |m| m.abs(x);
    Sign Function("sign") [x: S] -> S Added "1, 0 or -1 by the sign of x", |m| {
        let (zero, plus, minus) = (m.constant(0.0), m.constant(1.0), m.constant(-1.0));
        let (above, below) = (m.less(zero, x), m.less(x, zero));
        let rest = m.select(below, minus, x);
        m.select(above, plus, rest)
    };
    Fract Function("fract") [x: S] -> S Added "x - floor(x)", |m| { let whole = m.floor(x); m.sub(x, whole) };
    Mod Function("mod") [x: S, y: S] -> S Added "x - y*floor(x/y)", |m| {
        let quotient = m.div(x, y);
        let whole = m.floor(quotient);
        let part = m.mul(y, whole);
        m.sub(x, part)
    };
    Step Function("step") [e: S, x: S] -> S Added "0 if x < e, else 1", |m| {
        let (zero, one) = (m.constant(0.0), m.constant(1.0));
        let below = m.less(x, e);
        m.select(below, zero, one)
    };
    MinSS Function("min") [x: S, y: S] -> S Thesis "x if x < y, else y", |m| m.min(x, y);
    MinSSS Function("min") [x: S, y: S, z: S] -> S Thesis "min(min(x, y), z)", |m| { let low = m.min(x, y); m.min(low, z) };
    MinVV Function("min") [x: V, y: V] -> V Added "min by components", |m| zip(x, y, |x, y| m.min(x, y));
    MaxSS Function("max") [x: S, y: S] -> S Thesis "x if x > y, else y", |m| m.max(x, y);
    MaxSSS Function("max") [x: S, y: S, z: S] -> S Thesis "max(max(x, y), z)", |m| { let high = m.max(x, y); m.max(high, z) };
    MaxVV Function("max") [x: V, y: V] -> V Added "max by components", |m| zip(x, y, |x, y| m.max(x, y));
    Clamp Function("clamp") [x: S, lo: S, hi: S] -> S Added "min(max(x, lo), hi)", |m| clamp(m, x, lo, hi);
    Saturate Function("saturate") [x: S] -> S Added "clamp(x, 0, 1)", |m| {
        let (zero, one) = (m.constant(0.0), m.constant(1.0));
        clamp(m, x, zero, one)
    };
    MixS Function("mix") [a: S, b: S, t: S] -> S Added "a*(1 - t) + b*t", |m| {
        let [mixed, ..] = mix(m, [a; 3], [b; 3], t);
        mixed
    };
    MixV Function("mix") [a: V, b: V, t: S] -> V Added "a*(1 - t) + b*t", |m| mix(m, a, b, t);
    LerpS Function("lerp") [a: S, b: S, t: S] -> S Added "the same as mix(a, b, t)", |m| {
        let [mixed, ..] = mix(m, [a; 3], [b; 3], t);
        mixed
    };
    LerpV Function("lerp") [a: V, b: V, t: S] -> V Added "the same as mix(a, b, t)", |m| mix(m, a, b, t);
    Smoothstep Function("smoothstep") [e0: S, e1: S, x: S] -> S Added
        "t*t*(3 - 2*t) with t = clamp((x - e0)/(e1 - e0), 0, 1)", |m| {
        let (zero, one, two, three) = (m.constant(0.0), m.constant(1.0), m.constant(2.0), m.constant(3.0));
        let (rise, width) = (m.sub(x, e0), m.sub(e1, e0));
        let ratio = m.div(rise, width);
        let t = clamp(m, ratio, zero, one);
        let (square, twice) = (m.mul(t, t), m.mul(two, t));
        let rest = m.sub(three, twice);
        m.mul(square, rest)
    };
    GetX Function("getx") [v: V] -> S Thesis "the first component", |m| { let _ = &m; v[0] };
    GetY Function("gety") [v: V] -> S Thesis "the second component", |m| { let _ = &m; v[1] };
    GetZ Function("getz") [v: V] -> S Thesis "the third component", |m| { let _ = &m; v[2] };
    Dot Function("dot") [x: V, y: V] -> S Added "the same as x.y", |m| dot(m, x, y);
    Cross Function("cross") [x: V, y: V] -> V Added "cross product", |m| cross(m, x, y);
    Reflect Function("reflect") [i: V, n: V] -> V Added "i - 2*(n.i)*n", |m| {
        let two = m.constant(2.0);
        let cosine = dot(m, n, i);
        let twice = m.mul(two, cosine);
        zip(i, n, |i, n| { let part = m.mul(twice, n); m.sub(i, part) })
    };
    Normalize Function("normalize") [v: V] -> V Added "v / length(v)", |m| {
        let long = length(m, v);
        v.map(|x| m.div(x, long))
    };
    Length Function("length") [v: V] -> S Added "sqrt(v.v)", |m| length(m, v);
    Distance Function("distance") [x: V, y: V] -> S Added "length(x - y)", |m| {
        let apart = zip(x, y, |x, y| m.sub(x, y));
        length(m, apart)
    };
    Perlin Function("perlin") [pt: V, a: S, b: S, n: S] -> S Thesis
        "sum of noise(b^i*pt)/a^i for i = 0 .. n-1, Perlin's improved noise; n is rounded down, 0..32",
        |m| m.perlin(pt[0], pt[1], pt[2], a, b, n);
    Pi Constant("pi") [] -> S Added "the ratio of a circle's circumference to its diameter",
        |m| m.constant(std::f32::consts::PI);
    Less Infix(Mark::Less) [x: S, y: S] -> B Added "whether x is less than y", |m| m.less(x, y);
    LessEqual Infix(Mark::LessEqual) [x: S, y: S] -> B Added "whether x is at most y", |m| m.less_equal(x, y);
    Greater Infix(Mark::Greater) [x: S, y: S] -> B Added "whether x is greater than y", |m| m.less(y, x);
    GreaterEqual Infix(Mark::GreaterEqual) [x: S, y: S] -> B Added "whether x is at least y", |m| m.less_equal(y, x);
    Equal Infix(Mark::EqualEqual) [x: S, y: S] -> B Added "whether x equals y", |m| m.equal(x, y);
    NotEqual Infix(Mark::NotEqual) [x: S, y: S] -> B Added "whether x differs from y (true for NaN)", |m| {
        let same = m.equal(x, y);
        m.not(same)
    };
    And Infix(Mark::AndAnd) [p: B, q: B] -> B Added "whether both hold", |m| m.and(p, q);
    Or Infix(Mark::OrOr) [p: B, q: B] -> B Added "whether at least one holds", |m| m.or(p, q);
    Not Prefix(Mark::Not) [p: B] -> B Added "whether it does not hold", |m| m.not(p);
    IfS Conditional [condition: B, then: S, other: S] -> S Added
        "then if the condition holds, else the other; the one not taken does not matter", |m| m.select(condition, then, other);
    IfV Conditional [condition: B, then: V, other: V] -> V Added
        "then if the condition holds, else the other; the one not taken does not matter",
        |m| zip(then, other, |then, other| m.select(condition, then, other));
}

/// Combines two vectors by components.
fn zip<T: Copy>(x: [T; 3], y: [T; 3], mut combine: impl FnMut(T, T) -> T) -> [T; 3] {
    [combine(x[0], y[0]), combine(x[1], y[1]), combine(x[2], y[2])]
}

fn dot<M: Scalars>(m: &mut M, x: [M::Value; 3], y: [M::Value; 3]) -> M::Value {
    let [a, b, c] = zip(x, y, |x, y| m.mul(x, y));
    let partial = m.add(a, b);
    m.add(partial, c)
}

fn cross<M: Scalars>(m: &mut M, x: [M::Value; 3], y: [M::Value; 3]) -> [M::Value; 3] {
    let mut minor = |i: usize, j: usize| {
        let (plus, minus) = (m.mul(x[i], y[j]), m.mul(x[j], y[i]));
        m.sub(plus, minus)
    };
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn length<M: Scalars>(m: &mut M, v: [M::Value; 3]) -> M::Value {
    let square = dot(m, v, v);
    m.sqrt(square)
}

/// The stereographic coordinates of a direction of any length, where the normal is +z and the tangent +x: x/(1 + z) and
/// y/(1 + z). Directions above the horizon lie inside of the unit circle.
fn hemisphere<M: Scalars>(m: &mut M, direction: [M::Value; 3], normal: [M::Value; 3], tangent: [M::Value; 3]) -> [M::Value; 2] {
    let bitangent = cross(m, normal, tangent);
    let place = [tangent, bitangent, normal].map(|axis| dot(m, direction, axis));
    let radius = length(m, place);
    let [x, y, z] = place;
    let divisor = m.add(radius, z);
    [x, y].map(|coordinate| m.div(coordinate, divisor))
}

/// By S. Moshier's `tanhf` (Cephes): a polynomial near 0, where 1 − 2/(e²ˣ + 1) would cancel.
fn tanh<M: Scalars>(m: &mut M, x: M::Value) -> M::Value {
    let magnitude = m.abs(x);
    let square = m.mul(x, x);
    let series = polynomial(m, square, &[-5.704_988_7e-3, 2.063_908_8e-2, -5.373_971_6e-2, 1.333_144_2e-1, -3.333_328e-1]);
    let cube = m.mul(square, x);
    let correction = m.mul(series, cube);
    let near = m.add(x, correction);
    let (one, two, zero) = (m.constant(1.0), m.constant(2.0), m.constant(0.0));
    let twice = m.mul(two, magnitude);
    let power = m.exp(twice);
    let denominator = m.add(power, one);
    let rest = m.div(two, denominator);
    let far = m.sub(one, rest);
    let opposite = m.neg(far);
    let negative = m.less(x, zero);
    let far = m.select(negative, opposite, far);
    let limit = m.constant(0.625);
    let small = m.less(magnitude, limit);
    m.select(small, near, far)
}

/// A Maclaurin series below 1, and above it 1 − t·p(t)·e^(−x²) with t = 1/(1 + 0.3275911·x) (Abramowitz and Stegun,
/// Handbook of Mathematical Functions, 7.1.26). The error is below 2e-7.
fn erf<M: Scalars>(m: &mut M, x: M::Value) -> M::Value {
    let magnitude = m.abs(x);
    let square = m.mul(x, x);
    // 2/√π · (−1)ⁿ/(n!·(2n + 1)), from n = 9 down to 0.
    let series = polynomial(
        m,
        square,
        &[
            -1.636_584_5e-7,
            1.646_211_4e-6,
            -1.492_565e-5,
            1.205_533_3e-4,
            -8.548_327e-4,
            5.223_978e-3,
            -2.686_617e-2,
            1.128_379_2e-1,
            -3.761_264e-1,
            std::f32::consts::FRAC_2_SQRT_PI,
        ],
    );
    let near = m.mul(series, x);
    let (zero, one, factor) = (m.constant(0.0), m.constant(1.0), m.constant(0.327_591_1));
    let scaled = m.mul(factor, magnitude);
    let denominator = m.add(one, scaled);
    let t = m.div(one, denominator);
    let sum = polynomial(m, t, &[1.061_405_4, -1.453_152, 1.421_413_8, -0.284_496_73, 0.254_829_6]);
    let product = m.mul(sum, t);
    let exponent = m.neg(square);
    let bell = m.exp(exponent);
    let rest = m.mul(product, bell);
    let far = m.sub(one, rest);
    let opposite = m.neg(far);
    let negative = m.less(x, zero);
    let far = m.select(negative, opposite, far);
    let small = m.less(magnitude, one);
    m.select(small, near, far)
}

/// The polynomial with these coefficients, the highest power first.
fn polynomial<M: Scalars>(m: &mut M, x: M::Value, coefficients: &[f32]) -> M::Value {
    let mut sum = m.constant(coefficients[0]);
    for coefficient in &coefficients[1..] {
        let product = m.mul(sum, x);
        let coefficient = m.constant(*coefficient);
        sum = m.add(product, coefficient);
    }
    sum
}

fn clamp<M: Scalars>(m: &mut M, x: M::Value, lo: M::Value, hi: M::Value) -> M::Value {
    let raised = m.max(x, lo);
    m.min(raised, hi)
}

fn mix<M: Scalars>(m: &mut M, a: [M::Value; 3], b: [M::Value; 3], t: M::Value) -> [M::Value; 3] {
    let one = m.constant(1.0);
    let rest = m.sub(one, t);
    zip(a, b, |a, b| {
        let (first, second) = (m.mul(a, rest), m.mul(b, t));
        m.add(first, second)
    })
}

impl Form {
    /// Every overload written in this way.
    pub fn overloads(self) -> impl Iterator<Item = Operation> {
        Operation::ALL.iter().copied().filter(move |operation| operation.form() == self)
    }

    /// The overload for operands of these types.
    pub fn resolve(self, operands: &[Type]) -> Option<Operation> {
        self.overloads().find(|operation| operation.operands() == operands)
    }

    /// The overload for numbers that gives this form's result for operands of these types component by component. At
    /// least one of them is a vector. Only functions of numbers and `^` work by components.
    pub fn resolve_by_components(self, operands: &[Type]) -> Option<Operation> {
        let works = match self {
            Form::Function(_) | Form::Infix(Mark::Caret) => true,
            Form::Prefix(_)
            | Form::Infix(_)
            | Form::UnitDot
            | Form::Constant(_)
            | Form::Texture
            | Form::Measured
            | Form::Vector
            | Form::Conditional => false,
        };
        let numbers = operands.iter().all(|ty| matches!(ty, Type::Scalar | Type::Vector)) && operands.contains(&Type::Vector);
        let mut overloads = self.overloads().filter(|overload| overload.operands().len() == operands.len());
        overloads.find(|overload| works && numbers && overload.works_by_components())
    }

    /// The word or mark by which it is known.
    pub fn spelling(self) -> &'static str {
        match self {
            Form::Prefix(mark) | Form::Infix(mark) => mark.spelling(),
            Form::Function(name) | Form::Constant(name) => name,
            Form::UnitDot => Mark::Dot.spelling(),
            Form::Texture => "texture",
            Form::Measured => "measured",
            Form::Vector => "<,,>",
            Form::Conditional => "if",
        }
    }
}

impl Operation {
    /// Its result on numbers, by the reference meaning; scalars, operands and result, stand three times. There are as
    /// many operands as it takes; `stack` is scratch for sixteen numbers that is empty before and after.
    pub fn on_numbers(self, operands: &[[f32; 3]], stack: &mut Stack<f32>) -> [f32; 3] {
        for (value, ty) in operands.iter().zip(self.operands()) {
            value[..ty.slots()].iter().for_each(|number| stack.push(*number));
        }
        self.apply(&mut Floats, stack);
        match self.result() {
            Type::Scalar | Type::Truth | Type::Texture => [stack.pop::<1>()[0]; 3],
            Type::Vector => stack.pop::<3>(),
        }
    }

    /// Whether it is a function of numbers, and so may work by components of vectors.
    pub fn works_by_components(self) -> bool {
        let operands = self.operands();
        !operands.is_empty() && operands.iter().all(|ty| *ty == Type::Scalar) && self.result() == Type::Scalar
    }

    /// Replaces its operands on top of the stack by its result for each component. Bit `i` of `vectors` is set if
    /// operand `i` is a vector; the others are the same for all components.
    pub fn apply_by_components<M: Scalars>(self, vectors: u8, scalars: &mut M, stack: &mut Stack<M::Value>) {
        let mut operands: SmallVec<[[M::Value; 3]; 4]> = SmallVec::new();
        for index in (0..self.operands().len()).rev() {
            operands.push(if vectors >> index & 1 == 1 { stack.pop::<3>() } else { [stack.pop::<1>()[0]; 3] });
        }
        for component in 0..3 {
            operands.iter().rev().for_each(|operand| stack.push(operand[component]));
            self.apply(scalars, stack);
        }
    }

    /// Types of operands and result: `V,S→V`. Of a measured material they are those of its two directions.
    pub fn signature(self) -> String {
        let operands = if self.form() == Form::Measured { &self.operands()[1..3] } else { self.operands() };
        let letters: Vec<String> = operands.iter().map(|operand| operand.letter().to_string()).collect();
        format!("{}→{}", letters.join(","), self.result().letter())
    }
}

/// How a measured material is written, with the directions that may be left out.
pub const MEASURED_USAGES: [&str; 2] = ["measured(\"file\")", "measured(\"file\", l, v)"];

/// The form of the function or constant of this name.
pub fn named(name: &str) -> Option<Form> {
    Operation::ALL.iter().map(|operation| operation.form()).find(|form| match form {
        Form::Function(spelling) | Form::Constant(spelling) => *spelling == name,
        Form::Measured => form.spelling() == name,
        Form::Prefix(_) | Form::Infix(_) | Form::UnitDot | Form::Texture | Form::Vector | Form::Conditional => false,
    })
}

/// The names of all functions and constants, each once.
pub fn names() -> Vec<&'static str> {
    let mut names: Vec<&'static str> = Operation::ALL
        .iter()
        .filter_map(|operation| match operation.form() {
            Form::Function(name) | Form::Constant(name) => Some(name),
            Form::Measured => Some(Form::Measured.spelling()),
            Form::Prefix(_) | Form::Infix(_) | Form::UnitDot | Form::Texture | Form::Vector | Form::Conditional => None,
        })
        .collect();
    names.dedup();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The operation applied to numbers, by the reference meaning.
    fn value(operation: Operation, operands: &[f32]) -> Vec<f32> {
        let mut stack = Stack::new(16, 0.0);
        operands.iter().for_each(|&operand| stack.push(operand));
        operation.apply(&mut Floats, &mut stack);
        match operation.result() {
            Type::Scalar | Type::Truth | Type::Texture => stack.pop::<1>().to_vec(),
            Type::Vector => stack.pop::<3>().to_vec(),
        }
    }

    #[test]
    fn no_two_overloads_are_alike() {
        for (index, one) in Operation::ALL.iter().enumerate() {
            for other in &Operation::ALL[index + 1..] {
                assert!(one.form() != other.form() || one.operands() != other.operands(), "{one:?} and {other:?}");
            }
        }
    }

    #[test]
    fn meanings_agree_with_arithmetic_by_hand() {
        let close = |operation: Operation, operands: &[f32], expected: &[f32]| {
            let got = value(operation, operands);
            assert_eq!(got.len(), expected.len());
            for (got, expected) in got.iter().zip(expected) {
                assert!(
                    (got - expected).abs() <= 1e-6 * expected.abs().max(1.0),
                    "{operation:?}{operands:?} = {got}, not {expected}"
                );
            }
        };
        close(Operation::DotVV, &[1.0, 2.0, 3.0, 4.0, -5.0, 6.0], &[12.0]);
        close(Operation::Cross, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0], &[0.0, 0.0, 1.0]);
        close(Operation::Reflect, &[1.0, -1.0, 0.0, 0.0, 1.0, 0.0], &[1.0, 1.0, 0.0]);
        close(Operation::Normalize, &[3.0, 0.0, 4.0], &[0.6, 0.0, 0.8]);
        close(Operation::Distance, &[1.0, 1.0, 1.0, 1.0, 4.0, 5.0], &[5.0]);
        close(Operation::Smoothstep, &[0.0, 2.0, 1.0], &[0.5]);
        close(Operation::Mod, &[-1.0, 3.0], &[2.0]);
        close(Operation::Fract, &[-0.25], &[0.75]);
        close(Operation::Clamp, &[5.0, 0.0, 2.0], &[2.0]);
        close(Operation::MixV, &[0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 0.25], &[1.0, 2.0, 3.0]);
        close(Operation::Step, &[1.0, 1.0], &[1.0]);
        close(Operation::Sign, &[0.0], &[0.0]);
        close(Operation::Sign, &[-3.0], &[-1.0]);
        close(Operation::Radians, &[180.0], &[std::f32::consts::PI]);
        close(Operation::Pow, &[-2.0, -2.0], &[0.25]);
        close(Operation::Atan2, &[1.0, -1.0], &[0.75 * std::f32::consts::PI]);
        close(Operation::MinSSS, &[3.0, 1.0, 2.0], &[1.0]);
        close(Operation::NotEqual, &[f32::NAN, f32::NAN], &[1.0]);
        close(Operation::Greater, &[2.0, 1.0], &[1.0]);
        close(Operation::IfS, &[0.0, f32::NAN, 7.0], &[7.0]);
        close(Operation::Spread, &[2.5], &[2.5, 2.5, 2.5]);
        close(Operation::Saturate, &[1.5], &[1.0]);
        close(Operation::UnitDotVV, &[1.0, 1e-3, 0.0, 1.0, 1e-3, 0.0], &[1.0]);
    }

    #[test]
    fn tanh_and_erf_agree_with_tables() {
        // Abramowitz and Stegun, tables 4.15 and 7.1.
        let tanh = [(0.01, 0.009_999_67), (0.5, 0.462_117_2), (0.7, 0.604_367_8), (2.0, 0.964_027_6), (9.5, 1.0)];
        let erf = [(0.01, 0.011_283_42), (0.5, 0.520_499_9), (0.98, 0.834_231_5), (1.0, 0.842_700_8), (2.0, 0.995_322_3)];
        for (operation, table) in [(Operation::Tanh, tanh), (Operation::Erf, erf)] {
            for (x, expected) in table {
                for sign in [1.0, -1.0] {
                    let got = value(operation, &[sign * x])[0];
                    assert!((got - sign * expected).abs() <= 4e-7, "{operation:?}({x}) = {got}, not {expected}");
                }
            }
            assert_eq!(value(operation, &[f32::INFINITY]), [1.0]);
            assert_eq!(value(operation, &[f32::NEG_INFINITY]), [-1.0]);
            assert!(value(operation, &[f32::NAN])[0].is_nan());
            // Small numbers keep their relative precision.
            let small = value(operation, &[1e-10])[0];
            let slope = if operation == Operation::Erf { std::f32::consts::FRAC_2_SQRT_PI } else { 1.0 };
            assert!((small / 1e-10 - slope).abs() < 1e-6, "{small}");
        }
    }

    #[test]
    fn functions_of_numbers_work_by_components() {
        let (s, v) = (Type::Scalar, Type::Vector);
        let clamp = named("clamp").expect("a function");
        assert_eq!(clamp.resolve_by_components(&[v, s, s]), Some(Operation::Clamp));
        assert_eq!(clamp.resolve_by_components(&[s, s, s]), None);
        assert_eq!(named("max").and_then(|max| max.resolve_by_components(&[s, v])), Some(Operation::MaxSS));
        assert_eq!(named("getx").and_then(|get| get.resolve_by_components(&[v])), None);
        assert_eq!(Form::Infix(Mark::Plus).resolve_by_components(&[v, s]), None);
        let mut stack = Stack::new(16, 0.0);
        [1.0, 5.0, -1.0, 0.0, 2.0].iter().for_each(|number| stack.push(*number));
        Operation::Clamp.apply_by_components(1, &mut Floats, &mut stack);
        assert_eq!((stack.pop::<3>(), stack.is_empty()), ([1.0, 2.0, 0.0], true));
    }

    #[test]
    fn the_dot_product_of_directions_keeps_nan() {
        assert!(value(Operation::UnitDotVV, &[f32::NAN, 0.0, 0.0, 1.0, 0.0, 0.0])[0].is_nan());
    }

    #[test]
    fn overloads_are_found_by_types() {
        let star = Form::Infix(Mark::Star);
        assert_eq!(star.resolve(&[Type::Vector, Type::Scalar]), Some(Operation::MulVS));
        assert_eq!(star.resolve(&[Type::Truth, Type::Scalar]), None);
        assert_eq!(named("mix").map(|form| form.overloads().count()), Some(2));
    }
}
