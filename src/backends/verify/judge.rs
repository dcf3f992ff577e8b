//! Judges a difference between the backends: is the interpreter's own result as uncertain?
//!
//! A difference is excused in three cases:
//!
//! 1. The compiled result equals the result of the same program in `f64`, which hardly rounds and does not overflow.
//!    Then the interpreter is wrong.
//! 2. In `f64` with the range of `f32`, the result is at least as far away from the interpreter's result.
//! 3. A search finds perturbations of the intermediate results, of up to [`PERTURBATION`] units in the last place, that
//!    move the result as far. A step of the search replaces the perturbations of some consecutive operations by random
//!    ones, and keeps them if the result moves further. So the contributions of different records to a pixel can be
//!    moved one after the other.
//!
//! A pixel may be the mean of several passes. Then its result is the mean of the results of their programs, and the
//! search goes through the operations of all of them.
//!
//! Results below the smallest normal number are flushed to 0. There, that number is the unit in the last place.

use crate::backends::interpreter::Interpreted;
use crate::backends::verify::{Difference, TOLERANCE, distance};
use crate::bytecode::Programs;
use crate::evaluate::Evaluator;
use crate::lang::scalars::{Doubles, Floats, Primitive, Recorder, Scalars, flush};
use std::f32::consts::FRAC_PI_2;

/// The largest perturbation of an intermediate result, in units in the last place.
const PERTURBATION: f32 = 8.0;
/// Sine, cosine and tangent are accurate up to this angle in radians. For larger angles, the language promises only the
/// range of the result.
const ACCURATE_ANGLE: f32 = 1e5;
/// How many perturbed programs are run before a difference counts as an error, but at least [`FEWEST_TRIALS`] for each
/// pass.
const TRIALS: u32 = 8192;
const FEWEST_TRIALS: u32 = 256;
/// Programs of passes are kept up to this many bytes. The others are written again for each trial.
const KEPT_BYTES: usize = 64 << 20;

/// Whether a difference is excused.
pub(super) fn excuses(interpreted: &Interpreted, parameters: &[f32], difference: &Difference) -> bool {
    let trials = (TRIALS / interpreted.passes() as u32).max(FEWEST_TRIALS);
    let mean = MeanOfPasses::new(interpreted, parameters, difference, KEPT_BYTES);
    if distance(difference.compiled, mean.of(&mut Doubles, 0.0) as f32) <= TOLERANCE {
        return true;
    }
    let moved_by = |moved: f64| distance(moved as f32, difference.interpreted);
    let enough = difference.size() - TOLERANCE;
    if moved_by(mean.of(&mut Unrounded, 0.0)) >= enough {
        return true;
    }
    let mut random = Random::new(difference.pixel);
    let mut best = Perturbations::default();
    let mut farthest = 0.0;
    (0..trials).any(|_| {
        let mut trial = best.varied(&mut random);
        let moved = moved_by(mean.of(&mut trial, 0.0));
        if moved >= farthest {
            farthest = moved;
            best = trial;
        }
        moved >= enough
    })
}

/// A component of a pixel as the mean of passes.
struct MeanOfPasses<'m> {
    interpreted: &'m Interpreted,
    parameters: &'m [f32],
    pixel: u32,
    component: usize,
    /// The programs of the first passes.
    kept: Programs,
}

impl<'m> MeanOfPasses<'m> {
    /// The pixel and the component of a difference. About this many bytes of programs are kept.
    fn new(interpreted: &'m Interpreted, parameters: &'m [f32], difference: &Difference, bytes: usize) -> Self {
        let (pixel, mut kept) = (difference.pixel as u32, Programs::new());
        for pass in 0..interpreted.passes() {
            interpreted.add_program(pixel, pass, &mut kept);
            if kept.bytes() > bytes {
                break;
            }
        }
        Self { interpreted, parameters, pixel, component: difference.component, kept }
    }

    /// The mean under a meaning of the operations, which are met in the order of the passes.
    fn of<M>(&self, meaning: &mut M, zero: M::Value) -> f64
    where
        M: Scalars<Value: PartialEq + Into<f64>>,
    {
        let mut memory = self.kept.memory(zero);
        let mut sum = 0.0;
        for index in 0..self.kept.len() {
            sum += self.kept.run(meaning, index, self.parameters, &mut memory)[self.component].into();
        }
        let mut other = Programs::new();
        for pass in self.kept.len()..self.interpreted.passes() {
            other.clear();
            self.interpreted.add_program(self.pixel, pass, &mut other);
            sum += other.run(meaning, 0, self.parameters, &mut other.memory(zero))[self.component].into();
        }
        sum / self.interpreted.passes() as f64
    }
}

/// The reference meaning in `f64`, with the range of `f32`.
struct Unrounded;

impl Recorder for Unrounded {
    type Value = f64;

    fn record_constant(&mut self, value: f32) -> f64 {
        flush(value).into()
    }

    fn record(&mut self, primitive: Primitive, operands: &[f64]) -> f64 {
        let value = primitive.apply(&mut Doubles, operands);
        match value.abs() {
            size if size > f64::from(f32::MAX) => f64::INFINITY.copysign(value),
            size if size < f64::from(f32::MIN_POSITIVE) => 0.0_f64.copysign(value),
            _ => value,
        }
    }
}

/// The reference meaning with every result perturbed.
#[derive(Clone, Default)]
struct Perturbations {
    /// The perturbation of each operation in the order of the program, as a share of [`PERTURBATION`], −1 to 1.
    /// Operations beyond the end have 0.
    shares: Vec<f32>,
    /// The next operation.
    next: usize,
}

impl Perturbations {
    /// The same with other shares for some consecutive operations: all, or half of them, a quarter, and so on.
    fn varied(&self, random: &mut Random) -> Self {
        let count = self.next.max(1);
        let mut shares = self.shares.clone();
        shares.resize(count, 0.0);
        let length = (count >> random.below(usize::BITS - count.leading_zeros())).max(1);
        let first = random.below((count - length + 1) as u32) as usize;
        shares[first..first + length].iter_mut().for_each(|share| *share = random.share());
        Self { shares, next: 0 }
    }

    fn next_share(&mut self) -> f32 {
        let share = self.shares.get(self.next).copied().unwrap_or(0.0);
        self.next += 1;
        share
    }
}

impl Recorder for Perturbations {
    type Value = f32;

    fn record_constant(&mut self, value: f32) -> f32 {
        flush(value)
    }

    fn record(&mut self, primitive: Primitive, operands: &[f32]) -> f32 {
        let share = self.next_share();
        let is_angle = matches!(primitive, Primitive::Sin | Primitive::Cos | Primitive::Tan);
        if is_angle && operands[0].is_finite() && operands[0].abs() > ACCURATE_ANGLE {
            return if primitive == Primitive::Tan { (FRAC_PI_2 * share).tan() } else { share };
        }
        let value = primitive.apply(&mut Floats, operands);
        if primitive.yields_truth() || !value.is_finite() {
            return value;
        }
        let units = (share * PERTURBATION).round();
        if value.abs() <= PERTURBATION * f32::MIN_POSITIVE {
            let operands: Vec<f64> = operands.iter().map(|operand| f64::from(*operand)).collect();
            let exact = primitive.apply(&mut Doubles, &operands);
            // A result that is exactly 0 stays 0.
            let moved = if exact == 0.0 { 0.0 } else { exact.abs() + f64::from(units * f32::MIN_POSITIVE) };
            return flush((moved.max(0.0) as f32).copysign(value));
        }
        let magnitude = value.abs().to_bits().saturating_add_signed(units as i32);
        f32::from_bits(magnitude.min(f32::INFINITY.to_bits())).copysign(value)
    }
}

/// Random numbers by xorshift64* (Vigna 2016).
struct Random(u64);

impl Random {
    fn new(seed: usize) -> Self {
        Self((seed as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// A whole number below `limit`, which is not 0.
    fn below(&mut self, limit: u32) -> u32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 32;
        ((bits * u64::from(limit)) >> 32) as u32
    }

    /// A number from −1 to 1; the ends and 0 are frequent.
    fn share(&mut self) -> f32 {
        const STEPS: u32 = 1 << 16;
        match self.below(8) {
            0 => -1.0,
            1 => 1.0,
            2 => 0.0,
            _ => 2.0 * self.below(STEPS + 1) as f32 / STEPS as f32 - 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::formula::layout::Layout;
    use crate::lang::source::Source;
    use crate::lang::variables::Owner;
    use crate::scene::Scene;
    use crate::trace::View;
    use crate::world::{Assets, World};
    use std::sync::Arc;

    #[test]
    fn perturbations_move_results_by_a_few_units_only() {
        let mut random = Random::new(5);
        let mut perturbations = Perturbations::default();
        for _ in 0..100 {
            perturbations = perturbations.varied(&mut random);
            let moved = perturbations.record(Primitive::Add, &[1.0, 1.0]);
            assert!((moved.to_bits().abs_diff(2.0_f32.to_bits())) <= PERTURBATION as u32);
            let largest = perturbations.record(Primitive::Max, &[f32::MAX, 1.0]);
            assert!(largest >= 3.4e38, "{largest}");
        }
        assert_eq!(perturbations.record(Primitive::Less, &[1.0, 2.0]), 1.0);
        assert_eq!(perturbations.record(Primitive::Sub, &[2.0, 2.0]), 0.0);
    }

    #[test]
    fn results_that_underflow_are_perturbed_by_the_smallest_number() {
        let results = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|share| {
            let mut perturbations = Perturbations { shares: vec![share], next: 0 };
            perturbations.record(Primitive::Mul, &[-1e-30, 1e-10]) / f32::MIN_POSITIVE
        });
        assert_eq!(results.map(f32::round), [0.0, 0.0, 0.0, -4.0, -8.0]);
    }

    /// A formula's value on a ball in front of the camera, with this many lights. `ki`, `IL` and the colours are 1,
    /// every other parameter is 0. The picture has one pixel.
    fn on_a_ball(formula: &str, lights: usize, pass: u32) -> (Interpreted, Vec<f32>) {
        let lights_text: String = (0..lights).map(|light| format!("l{light}: point, <{}, 3, 9>; ", light + 1)).collect();
        let scene = format!(
            "bodies; b: sphere, center <0,0,0>, radius 1; lights; {lights_text}
             camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 10;"
        );
        let (scene, _) = Scene::parse(&Source::new("scene", scene)).unwrap();
        let world = Arc::new(World::new(scene, &Assets::NONE).expect("no meshes"));
        let (formula, _) = Formula::parse(&Source::new("formula", format!("formula; = {formula};"))).unwrap();
        let formula = Arc::new(formula);
        let interpreted = Interpreted::new(&formula, &world, View::new(1, 1).unwrap().with_pass(pass)).unwrap();
        let layout = Layout::new(&formula, 1, lights);
        let mut parameters = vec![0.0; layout.len()];
        parameters[layout.row(Owner::Light, 0)..].fill(1.0);
        (interpreted, parameters)
    }

    /// Whether a difference in red of a formula's value is excused, see [`on_a_ball`]. `difference` gives the compiled
    /// value from the interpreted one.
    fn is_excused(formula: &str, lights: usize, difference: impl Fn(f32) -> f32) -> bool {
        let (interpreted, parameters) = on_a_ball(formula, lights, 0);
        let value = interpreted.frame(&parameters).linear[0][0];
        let difference = Difference { pixel: 0, component: 0, compiled: difference(value), interpreted: value };
        assert!(difference.size() > TOLERANCE);
        excuses(&interpreted, &parameters, &difference)
    }

    #[test]
    fn means_of_passes_are_judged_by_the_operations_of_all_of_them() {
        let is_excused = |formula: &str, amount: f32| {
            let (first, parameters) = on_a_ball(formula, 1, 0);
            let interpreted = first.with_passes(4);
            let passes = (0..4).map(|pass| on_a_ball(formula, 1, pass).0.frame(&parameters).linear[0][0]);
            let mean = passes.sum::<f32>() / 4.0;
            assert_eq!(interpreted.frame(&parameters).linear[0][0], mean);
            let difference = Difference { pixel: 0, component: 0, compiled: mean + amount, interpreted: mean };
            for kept in [0, KEPT_BYTES] {
                let again = MeanOfPasses::new(&interpreted, &parameters, &difference, kept);
                assert!((again.of(&mut Floats, 0.0) as f32 - mean).abs() < 1e-6, "{kept}");
            }
            excuses(&interpreted, &parameters, &difference)
        };
        assert!(!is_excused("IL*(N.L)", 0.001));
        assert!(is_excused("IL*sin(3e4*(N.L + 0.25))", 0.0005));
        assert!(!is_excused("IL*sin(3e4*(N.L + 0.25))", 2.5));
    }

    #[test]
    fn only_ill_conditioned_formulas_are_excused() {
        assert!(!is_excused("IL*(N.L)", 1, |value| value + 0.001), "a product of cosines is well-conditioned");
        assert!(!is_excused("IL*exp(N.L)", 1, |value| value + 0.001));
        assert!(!is_excused("IL*exp(N.L)", 1, |_| f32::NAN));
        assert!(is_excused("IL*sin(3e4*(N.L + 0.25))", 1, |value| value + 0.001), "the sine of a large number is not");
        assert!(!is_excused("IL*sin(3e4*(N.L + 0.25))", 1, |value| value + 2.5), "but it stays within its range");
    }

    #[test]
    fn the_exact_value_is_excused() {
        // The cross product of parallel vectors is 0, which has no direction. After rounding it has one, and
        // perturbation hardly ever makes it 0 again.
        let difference = |value: f32| {
            assert!(value.is_finite(), "the interpreter's cross product is not 0");
            f32::NAN
        };
        assert!(is_excused("IL*normalize(cross(0.7*L, L))", 1, difference));
    }

    #[test]
    fn what_several_lights_add_is_perturbed_one_after_the_other() {
        // The sign of the sine of such an angle is arbitrary. One random perturbation in a thousand changes all ten
        // signs at once.
        let formula = "IL*if(sin(1e9*(1 + N.L)) < 0, 0, 1)";
        assert!(is_excused(formula, 10, |value| if value < 5.0 { 10.0 } else { 0.0 }));
        assert!(!is_excused(formula, 10, |_| 20.5));
    }
}
