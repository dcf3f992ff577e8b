//! What values a scalar can take: an interval, and whether NaN or −0 can occur. Each primitive says in its row of
//! [`scalars`](crate::lang::scalars) how the interval of its result follows from those of its operands.
//!
//! An interval is an over-estimate: every result of either backend lies in it, rounding included.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// An interval of values, and whether NaN or −0 can occur besides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The lower end, −∞ included.
    pub low: f64,
    /// The upper end, ∞ included.
    pub high: f64,
    /// Whether NaN can occur.
    pub nan: bool,
    /// Whether −0 can occur. It matters because 1/−0 is −∞.
    pub negative_zero: bool,
}

/// By how much rounded angles can exceed the exact ±π/2 and π.
const ANGLE_SLACK: f64 = 1e-6;

impl Interval {
    /// Any value at all.
    pub const ANYTHING: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY, nan: true, negative_zero: true };
    /// Any number but infinity and NaN.
    pub const FINITE: Interval = Interval { low: -(f32::MAX as f64), high: f32::MAX as f64, nan: false, negative_zero: true };
    /// A truth value: 0 or 1.
    pub const TRUTH: Interval = Interval { low: 0.0, high: 1.0, nan: false, negative_zero: false };

    /// The numbers from `low` to `high`; −0 among them if 0 is.
    pub fn new(low: f64, high: f64) -> Self {
        Self { low, high, nan: false, negative_zero: low <= 0.0 && high >= 0.0 }
    }

    /// One number.
    pub fn constant(value: f32) -> Self {
        if value.is_nan() {
            return Self::ANYTHING;
        }
        Self { low: value.into(), high: value.into(), nan: false, negative_zero: value == 0.0 && value.is_sign_negative() }
    }

    /// Whether all values are numbers of magnitude up to `limit`.
    pub fn within(&self, limit: f64) -> bool {
        !self.nan && self.low >= -limit && self.high <= limit
    }

    /// The largest magnitude.
    pub fn magnitude(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// Whether no value is below 0 or NaN.
    pub fn not_negative(&self) -> bool {
        !self.nan && self.low >= 0.0
    }

    /// The smallest interval that holds both.
    pub fn hull(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            nan: self.nan || other.nan,
            negative_zero: self.negative_zero || other.negative_zero,
        }
    }

    /// The results in `f32` of exact values in this interval: ends rounded outwards, infinite beyond the largest
    /// number, and zero with the same sign below the smallest normal one.
    pub fn rounded(mut self) -> Self {
        if self.low.is_nan() || self.high.is_nan() {
            return Self::ANYTHING;
        }
        // Rounding to the nearest never crosses a number that `f32` holds, so the next one outwards bounds it.
        let low = self.low as f32;
        self.low = if f64::from(low) > self.low { low.next_down() } else { low }.into();
        let high = self.high as f32;
        self.high = if f64::from(high) < self.high { high.next_up() } else { high }.into();
        let least = f64::from(f32::MIN_POSITIVE);
        if self.low > 0.0 && self.low < least {
            self.low = 0.0;
        }
        if self.high < 0.0 && self.high > -least {
            self.high = 0.0;
        }
        self.negative_zero = (self.negative_zero || self.low < 0.0) && self.contains_zero();
        self
    }

    /// Ends moved outwards by as much as a computed function can differ from the exact one. 0 stays 0.
    pub(super) fn approximated(self) -> Self {
        const RELATIVE: f64 = 1e-6;
        let outwards = |end: f64, by: f64| if end.is_infinite() { end } else { end + by * end.abs() };
        Self { low: outwards(self.low, -RELATIVE), high: outwards(self.high, RELATIVE), ..self }
    }

    fn contains_zero(&self) -> bool {
        self.low <= 0.0 && self.high >= 0.0
    }

    fn is_infinite(&self) -> bool {
        self.low == f64::NEG_INFINITY || self.high == f64::INFINITY
    }

    /// The smallest magnitude.
    fn least_magnitude(&self) -> f64 {
        if self.contains_zero() { 0.0 } else { self.low.abs().min(self.high.abs()) }
    }

    /// The interval of an exactly rounded function that grows with its argument.
    pub(super) fn growing(self, function: impl Fn(f64) -> f64) -> Self {
        Self { nan: self.nan, ..Self::new(function(self.low), function(self.high)) }
    }

    /// The interval of an exponential function.
    pub(super) fn exponential(self, function: impl Fn(f64) -> f64) -> Self {
        Self { negative_zero: false, ..self.growing(function).approximated() }
    }

    /// The interval of a logarithm.
    pub(super) fn logarithm(self, function: impl Fn(f64) -> f64) -> Self {
        Self { nan: self.nan || self.low < 0.0, ..self.growing(|x| function(x.max(0.0))).approximated() }
    }

    /// The interval whose ends are the extremes of these, or anything where one of them is undefined.
    fn spanned(corners: [f64; 4], nan: bool, negative_zero: bool) -> Self {
        if corners.iter().any(|corner| corner.is_nan()) {
            return Self::ANYTHING;
        }
        let low = corners.into_iter().fold(f64::INFINITY, f64::min);
        let high = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Self { low, high, nan, negative_zero }
    }

    /// x · x
    pub fn squared(self) -> Self {
        Self { low: self.least_magnitude().powi(2), high: self.magnitude().powi(2), nan: self.nan, negative_zero: false }
    }

    /// √x
    pub(super) fn sqrt(self) -> Self {
        let root = self.growing(|x| x.max(0.0).sqrt());
        Self { nan: self.nan || self.low < 0.0, negative_zero: self.negative_zero, ..root }
    }

    /// |x|
    pub(super) fn abs(self) -> Self {
        Self { low: self.least_magnitude(), high: self.magnitude(), nan: self.nan, negative_zero: false }
    }

    /// The lesser of x and y, or y where either is NaN.
    pub(super) fn min(self, y: Self) -> Self {
        self.chosen(y, f64::min)
    }

    /// The greater of x and y, or y where either is NaN.
    pub(super) fn max(self, y: Self) -> Self {
        self.chosen(y, f64::max)
    }

    fn chosen(self, y: Self, choose: impl Fn(f64, f64) -> f64) -> Self {
        let negative_zero = self.negative_zero || y.negative_zero;
        if self.nan || y.nan {
            return Self { nan: y.nan, negative_zero, ..self.hull(y) };
        }
        Self { low: choose(self.low, y.low), high: choose(self.high, y.high), nan: false, negative_zero }
    }

    /// xʸ as C's `powf`.
    pub(super) fn powf(self, y: Self) -> Self {
        if !self.not_negative() || y.nan {
            return Self::ANYTHING;
        }
        let bounded = y.low >= 0.0 && (self.high <= 1.0 || self.high < f64::INFINITY && y.high < f64::INFINITY);
        let high = if bounded { self.high.max(1.0).powf(y.high) } else { f64::INFINITY };
        let low = if self.negative_zero && y.low < 0.0 { f64::NEG_INFINITY } else { 0.0 };
        Self { low, high, nan: false, negative_zero: self.negative_zero }.approximated()
    }

    /// Sine or cosine.
    pub(super) fn circular(self) -> Self {
        Self { nan: self.nan || self.is_infinite(), ..Self::new(-1.0, 1.0) }
    }

    /// Tangent.
    pub(super) fn tan(self) -> Self {
        Self { nan: self.nan || self.is_infinite(), ..Self::ANYTHING }
    }

    /// Arc sine.
    pub(super) fn asin(self) -> Self {
        Self { nan: !self.within(1.0), ..Self::new(-FRAC_PI_2 - ANGLE_SLACK, FRAC_PI_2 + ANGLE_SLACK) }
    }

    /// Arc cosine.
    pub(super) fn acos(self) -> Self {
        Self { nan: !self.within(1.0), negative_zero: false, ..Self::new(0.0, PI + ANGLE_SLACK) }
    }

    /// Arc tangent.
    pub(super) fn atan(self) -> Self {
        Self { nan: self.nan, ..Self::new(-FRAC_PI_2 - ANGLE_SLACK, FRAC_PI_2 + ANGLE_SLACK) }
    }

    /// The angle of the point (x, y).
    pub(super) fn atan2(self, x: Self) -> Self {
        Self { nan: self.nan || x.nan, ..Self::new(-PI - ANGLE_SLACK, PI + ANGLE_SLACK) }
    }
}

impl Neg for Interval {
    type Output = Interval;

    fn neg(self) -> Self {
        Self { nan: self.nan, negative_zero: self.contains_zero(), ..Self::new(-self.high, -self.low) }
    }
}

impl Add for Interval {
    type Output = Interval;

    fn add(self, y: Self) -> Self {
        let undefined =
            self.high == f64::INFINITY && y.low == f64::NEG_INFINITY || self.low == f64::NEG_INFINITY && y.high == f64::INFINITY;
        if undefined {
            return Self::ANYTHING;
        }
        Self {
            low: self.low + y.low,
            high: self.high + y.high,
            nan: self.nan || y.nan,
            negative_zero: self.negative_zero && y.negative_zero,
        }
    }
}

impl Sub for Interval {
    type Output = Interval;

    fn sub(self, y: Self) -> Self {
        self + -y
    }
}

impl Mul for Interval {
    type Output = Interval;

    fn mul(self, y: Self) -> Self {
        let undefined = self.is_infinite() && y.contains_zero() || y.is_infinite() && self.contains_zero();
        let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        let corners =
            [product(self.low, y.low), product(self.low, y.high), product(self.high, y.low), product(self.high, y.high)];
        let negative_zero = self.negative_zero || y.negative_zero || self.low < 0.0 || y.low < 0.0;
        Self::spanned(corners, self.nan || y.nan || undefined, negative_zero)
    }
}

impl Div for Interval {
    type Output = Interval;

    fn div(self, y: Self) -> Self {
        let undefined = self.contains_zero() && y.contains_zero() || self.is_infinite() && y.is_infinite();
        let nan = self.nan || y.nan || undefined;
        if y.low > 0.0 || y.high < 0.0 {
            return Self::spanned([self.low / y.low, self.low / y.high, self.high / y.low, self.high / y.high], nan, true);
        }
        if self.low >= 0.0 && y.low >= 0.0 && !y.negative_zero {
            let low = if y.high == f64::INFINITY { 0.0 } else { self.low / y.high };
            return Self { low, high: f64::INFINITY, nan, negative_zero: self.negative_zero };
        }
        Self { nan, ..Self::ANYTHING }
    }
}
