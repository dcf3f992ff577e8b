//! Dragged sliders: each way to make a frame gives the picture of the general kernel.

use crate::agreement::formulas::{Case, SIZE, ingredients, number, runner};
use crate::agreement::only_draws_in_full;
use illuminator::backends::verify::TOLERANCE;
use illuminator::evaluate::{Evaluator, Framebuffer};
use illuminator::formula::Parameter;
use illuminator::lang::types::Type;
use illuminator::picture::{Frame, ToneCurve, Transfer, ViewTransform};
use illuminator::plan::Method;
use proptest::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The byte of a component. The byte of NaN is 0.
fn byte(component: f32, view: ViewTransform) -> u32 {
    let exposed = f64::from(component.max(0.0)) * 2f64.powf(f64::from(view.exposure));
    let curved = match view.curve {
        ToneCurve::None => exposed,
        ToneCurve::Reinhard => exposed / (1.0 + exposed),
        ToneCurve::Aces => (exposed * (2.51 * exposed + 0.03)) / (exposed * (2.43 * exposed + 0.59) + 0.14),
    };
    // A fraction of two infinite numbers is the limit of the curve.
    let linear = if exposed.is_infinite() { 1.0 } else { curved.min(1.0) };
    let stored = match view.transfer {
        Transfer::Linear => linear,
        Transfer::Srgb if linear <= 0.003_130_8 => 12.92 * linear,
        Transfer::Srgb => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
    };
    (stored * 255.0).round() as u32
}

/// The view transforms of pictures in tests: every way of writing bytes.
pub(super) const VIEWS: [ViewTransform; 3] = [
    ViewTransform { exposure: 0.0, curve: ToneCurve::None, transfer: Transfer::Linear },
    ViewTransform { exposure: 0.0, curve: ToneCurve::None, transfer: Transfer::Srgb },
    ViewTransform { exposure: 0.7, curve: ToneCurve::Aces, transfer: Transfer::Srgb },
];

/// How many components of a drawn picture are not the byte of a number within the tolerance.
pub(super) fn wrong(drawn: &Framebuffer, frame: &Frame) -> usize {
    let pixels = drawn.pixels.iter().zip(&frame.linear);
    let components =
        pixels.flat_map(|(word, colour)| (0..3).map(move |component| (word >> (16 - 8 * component) & 0xff, colour[component])));
    let is_wrong = |(found, exact): &(u32, f32)| {
        let slack = TOLERANCE * exact.abs().max(1.0);
        let [low, high] = if exact.is_finite() { [exact - slack, exact + slack] } else { [*exact; 2] };
        let range = byte(low, drawn.view())..=byte(high, drawn.view());
        !range.contains(found)
    };
    components.filter(is_wrong).count()
}

/// The parameter whose number has this index.
fn parameter_at(case: &Case, index: usize) -> Option<&Parameter> {
    let (owner, _, slot) = case.layout.owner_of(index)?;
    let holds = |parameter: &&Parameter| {
        let first = parameter.slot as usize;
        parameter.owner == owner && (first..first + parameter.ty.slots()).contains(&slot)
    };
    case.formula.parameters.iter().find(holds)
}

/// The numbers that a slider for this number may move. For a scalar: itself and all scalars of its owner with the range
/// 0..1, because invariants may bind them. For a component of a colour: the colour.
pub(super) fn together(case: &Case, index: usize) -> Vec<usize> {
    let Some((owner, owner_index, slot)) = case.layout.owner_of(index) else { return Vec::new() };
    let own = parameter_at(case, index);
    let row = case.layout.row(owner, owner_index);
    if let Some(colour) = own.filter(|parameter| parameter.ty == Type::Vector) {
        return (0..3).map(|component| row + colour.slot as usize + component).collect();
    }
    let bound = |parameter: &&Parameter| {
        parameter.owner == owner
            && parameter.ty == Type::Scalar
            && (parameter.range == Some([0.0, 1.0]) || parameter.slot as usize == slot)
    };
    case.formula.parameters.iter().filter(bound).map(|parameter| row + parameter.slot as usize).collect()
}

static METHODS: [AtomicUsize; 3] = [const { AtomicUsize::new(0) }; 3];

/// Drags numbers of one owner through `values`, before and after the preparation. The numbers differ from each other.
pub(super) fn drag(
    case: &Case,
    evaluator: &Arc<dyn Evaluator>,
    moved: &[usize],
    values: &[f32],
    view: ViewTransform,
) -> Result<Method, TestCaseError> {
    let failed = |error: &dyn std::fmt::Display| TestCaseError::fail(error.to_string());
    let mut memory = case.memory.clone();
    let drag = Arc::clone(evaluator).drag(moved, &memory, usize::MAX, None);
    let mut drag = drag.map_err(|error| failed(&error))?;
    let mut drawn = Framebuffer::black(SIZE.0, SIZE.1, view);
    for turn in 0..values.len() {
        for (index, value) in moved.iter().zip(values.iter().cycle().skip(turn)) {
            memory[*index] = parameter_at(case, *index).ok_or_else(|| failed(&"a parameter"))?.clamp(*value).0;
        }
        if turn == 1 {
            // The rest is drawn with everything prepared.
            while !drag.prepare() {}
        }
        drag.frame(&memory, &mut drawn);
        drag.prepare();
        let frame = evaluator.frame(&memory);
        let numbers: Vec<f32> = moved.iter().map(|index| memory[*index]).collect();
        prop_assert_eq!(wrong(&drawn, &frame), 0, "{} by {:?}, moved {:?} to {:?}", &case.text, drag.method(), moved, numbers);
    }
    Ok(drag.method())
}

#[test]
pub(super) fn random_drags_give_the_general_picture() {
    let view = prop::sample::select(&VIEWS[..]);
    let strategy = (ingredients(), any::<prop::sample::Index>(), any::<bool>(), proptest::collection::vec(number(), 4), view);
    let outcome = runner(600).run(&strategy, |((scalar, vector, result, numbers), which, all, values, view)| {
        let case = Case::new([&scalar, &vector, &result], &numbers)?;
        let index = which.index(case.layout.len());
        let moved = if all { together(&case, index) } else { vec![index] };
        for evaluator in &case.evaluators {
            let method = drag(&case, evaluator, &moved, &values, view)?;
            METHODS[method as usize].fetch_add(1, Ordering::Relaxed);
        }
        Ok(())
    });
    let methods = METHODS.each_ref().map(|count| count.load(Ordering::Relaxed));
    println!("images, specialised, general: {methods:?}");
    if let Err(error) = outcome {
        panic!("{error}");
    }
    let all = methods[..2].iter().all(|count| *count > 20);
    assert!(all || only_draws_in_full(), "each way is tried: {methods:?}");
}
