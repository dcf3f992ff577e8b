//! Compares the pictures of two backends, and decides which differences are errors.
//!
//! They agree if every component differs by at most [`TOLERANCE`], and is NaN or infinite in both or in neither. A
//! larger difference is excused only if the formula is ill-conditioned: the interpreter's own result moves as far when
//! its intermediate results are perturbed by a few units in the last place, see `judge`.

mod judge;

use crate::backends::interpreter::Interpreted;
use crate::evaluate::Evaluator;
use crate::picture::Frame;

/// The largest difference of two components. It is absolute, or relative if the interpreter's component is larger than
/// 1.
pub const TOLERANCE: f32 = 1e-4;
/// With this many unexcused differences the backends disagree. The other differences are not judged.
const MOST_JUDGED: usize = 256;
/// The share of 8-bit components that may differ by one step.
const STEPS_SHARE: f64 = 1e-3;

/// A component in which the backends differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The pixel, row by row from the top left.
    pub pixel: usize,
    /// 0 red, 1 green, 2 blue.
    pub component: usize,
    /// The value of compiled code.
    pub compiled: f32,
    /// The value of the interpreter.
    pub interpreted: f32,
}

impl Difference {
    /// The difference, relative if the interpreter's value is larger than 1. Infinite if one value is NaN or infinite
    /// and the other is not the same.
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

/// The result of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    /// How many components were compared.
    pub components: usize,
    /// How many pixels of compiled code have a NaN.
    pub nan_pixels: usize,
    /// The largest difference that is not excused.
    pub worst: Option<Difference>,
    /// How many components differ by more than the tolerance and are not excused.
    pub failed: usize,
    /// How many differ by more than the tolerance and are excused.
    pub excused: usize,
    /// How many components of the 8-bit pictures differ by one step, without the excused ones.
    pub one_step: usize,
    /// How many of them differ by more than one step.
    pub more_steps: usize,
}

impl Verification {
    /// Whether the backends agree.
    pub fn passes(&self) -> bool {
        self.failed == 0 && self.more_steps == 0 && self.one_step as f64 <= STEPS_SHARE * self.components as f64
    }
}

/// Compares the backends on these parameter numbers. Both have the same passes.
pub fn verify(compiled: &dyn Evaluator, interpreted: &Interpreted, parameters: &[f32]) -> Verification {
    let frames = [compiled.frame(parameters), interpreted.frame(parameters)];
    verify_pictures(frames.each_ref(), interpreted, parameters)
}

/// Compares the pictures of these parameter numbers: that of compiled code, and that of the interpreter.
pub fn verify_pictures([compiled, other]: [&Frame; 2], interpreted: &Interpreted, parameters: &[f32]) -> Verification {
    compare(compiled, other, |difference| judge::excuses(interpreted, parameters, difference))
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
            if difference.size() > TOLERANCE && found.failed < MOST_JUDGED && excuse(&difference) {
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
}
