//! Both backends on the same input: how far apart they are, and whether that is far enough to be an error.
//!
//! They agree where every component differs by at most [`TOLERANCE`] and is NaN or infinite in both or neither. A larger
//! difference is excused only where the formula is so ill-conditioned that the interpreter's own result moves as much when its
//! intermediate results are disturbed by a few units in the last place.

use crate::backends::interpreter::Interpreted;
use crate::evaluate::{Evaluator, Frame};
use crate::lang::scalars::{Floats, Primitive, Recorder, flush};
use std::f32::consts::FRAC_PI_2;

/// The largest difference of two components, absolute or relative to the interpreter's where that is beyond 1.
pub const TOLERANCE: f32 = 1e-4;
/// By how many units in the last place intermediate results are disturbed, at most.
const DISTURBANCE: i32 = 8;
/// Sine, cosine and tangent are accurate up to this angle in radians; beyond, they are merely within range.
const ACCURATE_ANGLE: f32 = 1e5;
/// How many disturbed results are looked at before a difference counts as unexcused.
const TRIALS: u32 = 256;
/// The share of 8-bit components that may differ, each by one step.
const STEPS_SHARE: f64 = 1e-3;

/// A component in which the backends differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The pixel, row by row from the top left.
    pub pixel: usize,
    /// 0 red, 1 green, 2 blue.
    pub component: usize,
    /// By compiled code.
    pub compiled: f32,
    /// By the interpreter.
    pub interpreted: f32,
}

impl Difference {
    /// The difference as the tolerance counts it; infinite where one is NaN or infinite and the other is not the same.
    pub fn size(&self) -> f32 {
        distance(self.compiled, self.interpreted)
    }
}

fn distance(value: f32, reference: f32) -> f32 {
    if value == reference || (value.is_nan() && reference.is_nan()) {
        0.0
    } else if value.is_finite() && reference.is_finite() {
        (value - reference).abs() / reference.abs().max(1.0)
    } else {
        f32::INFINITY
    }
}

/// What the comparison found.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    /// How many components were compared.
    pub components: usize,
    /// How many pixels hold a NaN by compiled code.
    pub nan_pixels: usize,
    /// The largest difference that is not excused.
    pub worst: Option<Difference>,
    /// How many components differ by more than the tolerance without excuse.
    pub failed: usize,
    /// How many differ by more than the tolerance, and are excused.
    pub excused: usize,
    /// How many components of the 8-bit pictures differ by one step, where nothing had to be excused.
    pub one_step: usize,
    /// How many differ by more than one step.
    pub more_steps: usize,
}

impl Verification {
    /// Whether the backends agree.
    pub fn passes(&self) -> bool {
        self.failed == 0 && self.more_steps == 0 && self.one_step as f64 <= STEPS_SHARE * self.components as f64
    }
}

/// Compares the backends on these parameter numbers.
pub fn verify(compiled: &dyn Evaluator, interpreted: &Interpreted, memory: &[f32]) -> Verification {
    let one = compiled.frame(memory);
    let other = interpreted.frame(memory);
    compare(&one, &other, |difference| excused(interpreted, memory, difference))
}

fn compare(compiled: &Frame, interpreted: &Frame, excuse: impl Fn(&Difference) -> bool) -> Verification {
    let mut found = Verification {
        components: 3 * compiled.linear.len(),
        nan_pixels: compiled.linear.iter().filter(|pixel| pixel.iter().any(|component| component.is_nan())).count(),
        worst: None,
        failed: 0,
        excused: 0,
        one_step: 0,
        more_steps: 0,
    };
    let pixels = compiled.linear.iter().zip(&interpreted.linear).enumerate();
    for (pixel, (one, other)) in pixels {
        for component in 0..3 {
            let difference = Difference { pixel, component, compiled: one[component], interpreted: other[component] };
            if difference.size() > TOLERANCE && excuse(&difference) {
                found.excused += 1;
                continue;
            }
            found.failed += usize::from(difference.size() > TOLERANCE);
            if difference.size() > found.worst.map_or(0.0, |worst| worst.size()) {
                found.worst = Some(difference);
            }
            match step(one[component]).abs_diff(step(other[component])) {
                0 => {}
                1 => found.one_step += 1,
                _ => found.more_steps += 1,
            }
        }
    }
    found
}

/// The 8-bit value of a component; NaN is 0.
fn step(component: f32) -> u8 {
    // The cast saturates and takes NaN to 0.
    (component.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// Whether the interpreter's result moves at least as far when its intermediate results are disturbed.
fn excused(interpreted: &Interpreted, memory: &[f32], difference: &Difference) -> bool {
    let programs = interpreted.program(difference.pixel as u32);
    let mut stack = programs.stack();
    (0..TRIALS).any(|trial| {
        let mut disturbed = Disturbed::new(trial);
        let moved = programs.run(&mut disturbed, 0, memory, &mut stack)[difference.component];
        match (difference.compiled.is_finite(), moved.is_finite()) {
            (true, true) => distance(moved, difference.interpreted) >= difference.size() - TOLERANCE,
            // Where the compiled code has NaN or infinity, so must a disturbed result.
            (false, false) => distance(moved, difference.compiled) == 0.0,
            (true, false) => true,
            (false, true) => false,
        }
    })
}

/// The reference meaning with every result moved by a few units in the last place.
struct Disturbed {
    trial: u32,
    state: u64,
}

impl Disturbed {
    fn new(trial: u32) -> Self {
        Self { trial, state: (u64::from(trial) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) }
    }

    /// By how much to move a result. The first trials move all alike, up and down; the others at random (xorshift64*, Vigna 2016).
    fn step(&mut self) -> i32 {
        match self.trial {
            0 => DISTURBANCE,
            1 => -DISTURBANCE,
            _ => (self.random() % (2 * DISTURBANCE as u32 + 1)) as i32 - DISTURBANCE,
        }
    }

    /// 24 random bits.
    fn random(&mut self) -> u32 {
        self.state ^= self.state >> 12;
        self.state ^= self.state << 25;
        self.state ^= self.state >> 27;
        (self.state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 40) as u32
    }
}

impl Recorder for Disturbed {
    type Value = f32;

    fn record_constant(&mut self, value: f32) -> f32 {
        flush(value)
    }

    fn record(&mut self, primitive: Primitive, operands: &[f32]) -> f32 {
        let turns = matches!(primitive, Primitive::Sin | Primitive::Cos | Primitive::Tan);
        if turns && operands[0].is_finite() && operands[0].abs() > ACCURATE_ANGLE {
            // Of such an angle the language promises no more than the range of the result.
            let share = match self.step() {
                edge @ (DISTURBANCE | 0) => edge as f32 / DISTURBANCE as f32,
                step if step == -DISTURBANCE => -1.0,
                step => (step as f32 + self.random() as f32 / (1 << 24) as f32) / DISTURBANCE as f32,
            };
            return if primitive == Primitive::Tan { (FRAC_PI_2 * share).tan() } else { share };
        }
        let value = primitive.apply(&mut Floats, operands);
        if primitive.yields_truth() || value == 0.0 || !value.is_finite() {
            return value;
        }
        let moved = value.to_bits().wrapping_add_signed(self.step());
        flush(f32::from_bits(moved))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(components: [f32; 3]) -> Frame {
        Frame { width: 1, height: 1, linear: vec![components] }
    }

    #[test]
    fn small_differences_pass_and_large_ones_do_not() {
        let reference = frame([0.5, 100.0, f32::NAN]);
        let passes = |components| compare(&frame(components), &reference, |_| false).passes();
        assert!(passes([0.500_05, 100.005, f32::NAN]));
        assert!(!passes([0.5002, 100.0, f32::NAN]));
        assert!(!passes([0.5, 100.02, f32::NAN]));
        assert!(!passes([0.5, 100.0, 0.0]));
    }

    #[test]
    fn what_is_excused_neither_fails_nor_counts_as_the_worst() {
        let found = compare(&frame([0.9, 0.5, 0.5]), &frame([0.5; 3]), |_| true);
        assert!(found.passes() && found.worst.is_none());
        assert_eq!(found.excused, 1);
    }

    #[test]
    fn disturbance_moves_results_by_a_few_units_only() {
        let mut disturbed = Disturbed::new(5);
        for _ in 0..100 {
            let moved = disturbed.record(Primitive::Add, &[1.0, 1.0]);
            assert!((moved.to_bits().abs_diff(2.0_f32.to_bits())) <= DISTURBANCE as u32);
        }
        assert_eq!(disturbed.record(Primitive::Less, &[1.0, 2.0]), 1.0);
    }

    #[test]
    fn only_ill_conditioned_formulas_are_excused() {
        use crate::formula::Formula;
        use crate::formula::layout::Layout;
        use crate::lang::source::Source;
        use crate::scene::Scene;
        use crate::trace::View;
        use crate::world::World;
        use std::sync::Arc;
        let scene = "bodies; b: sphere, center <0,0,0>, radius 1; lights; l: point, <0,0,9>;
            camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 10;";
        let (scene, _) = Scene::parse(&Source::new("scene", scene)).unwrap();
        let world = Arc::new(World::new(scene));
        // ki, IL and the colours are 1, everything else 0.
        let excuses = |formula: &str, difference: f32| {
            let (formula, _) = Formula::parse(&Source::new("formula", format!("formula; = {formula};"))).unwrap();
            let formula = Arc::new(formula);
            let interpreted = Interpreted::new(&formula, &world, View::new(1, 1).unwrap()).unwrap();
            let layout = Layout::new(&formula, 1, 1);
            let mut memory = vec![0.0; layout.len()];
            memory[layout.row(crate::lang::variables::Owner::Light, 0)..].fill(1.0);
            let value = interpreted.frame(&memory).linear[0][0];
            excused(
                &interpreted,
                &memory,
                &Difference { pixel: 0, component: 0, compiled: value + difference, interpreted: value },
            )
        };
        assert!(!excuses("IL*(N.L)", 0.001), "a product of cosines is well-conditioned");
        assert!(!excuses("IL*exp(N.L)", 0.001));
        assert!(excuses("IL*sin(3e4*(N.L + 0.25))", 0.001), "the sine of a large number is not");
        assert!(!excuses("IL*sin(3e4*(N.L + 0.25))", 2.5), "but it stays within its range");
    }
}
