//! Edits of the form of a body: of the numbers of its shape and of its transforms, and transforms that are added.

use super::align::{Decimals, realigned, rounded_text};
use super::declarations::SceneText;
use super::{Precision, SceneObject, TextReplacement};
use crate::scene::{BodyForm, BodyId, Transform};

/// How exactly the numbers of a transform are written: places and lengths as those of shapes, factors and angles to
/// four digits.
fn decimals(precision: Precision, transform: &Transform) -> Decimals {
    match transform {
        Transform::Scale(factor) => Decimals::of_factors(precision, *factor),
        Transform::Stretch(factors) => Decimals::of_factors(precision, factors.abs().min_element()),
        Transform::Rotate { axis, .. } => Decimals::of_factors(precision, axis.length()),
        Transform::Translate(_) | Transform::Fit { .. } => Decimals::of_lengths(precision),
    }
}

/// The replacements that give a body another form; `None` if there is no such body.
pub(super) fn replaced(text: &SceneText, body: BodyId, new: &BodyForm, precision: Precision) -> Option<Vec<TextReplacement>> {
    let old = &text.scene().bodies.get(body.index())?.form;
    let value = text.value(SceneObject::Body(body))?;
    let steps = text.transforms(body)?;
    let behind_shape = text.end_of(value.end.checked_sub(1)?)?;
    let mut replaced = realigned(text, value, &old.shape, &new.shape, |_| Decimals::of_lengths(precision));
    let common = old.transforms.len().min(new.transforms.len());
    for ((step, old), new) in steps.iter().zip(&old.transforms).zip(&new.transforms) {
        let decimals = decimals(precision, new);
        replaced.extend(realigned(text, step.clone(), old, new, |_| decimals));
    }
    // Transforms less: with the comma before each.
    for step in steps.iter().skip(common) {
        let start = text.end_of(step.start.checked_sub(2)?)?;
        replaced.push(TextReplacement { range: start..text.end_of(step.end.checked_sub(1)?)?, text: String::new() });
    }
    // Transforms more, behind the last one.
    let more: String =
        new.transforms.iter().skip(common).map(|transform| format!(", {}", rounded_text(transform, precision))).collect();
    if !more.is_empty() {
        let last = steps.last().map_or(Some(behind_shape), |last| text.end_of(last.end.checked_sub(1)?))?;
        replaced.push(TextReplacement { range: last..last, text: more });
    }
    Some(replaced)
}
