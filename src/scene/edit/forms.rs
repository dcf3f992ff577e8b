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
    let behind = |step: Option<usize>| match step {
        Some(step) => text.end_of(steps.get(step)?.end.checked_sub(1)?),
        None => text.end_of(value.end.checked_sub(1)?),
    };
    let mut replaced = realigned(text, value.clone(), &old.shape, &new.shape, |_| Decimals::of_lengths(precision));
    // The step of the text behind which others are added.
    let mut last = None;
    let mut added = String::new();
    let add = |added: &mut String, last: Option<usize>, replaced: &mut Vec<TextReplacement>| {
        if !added.is_empty() {
            let at = behind(last)?;
            replaced.push(TextReplacement { range: at..at, text: std::mem::take(added) });
        }
        Some(())
    };
    for pair in paired(&old.transforms, &new.transforms) {
        match pair {
            Pairing::Both(step, transform) => {
                add(&mut added, last, &mut replaced)?;
                let (old, new) = (old.transforms.get(step)?, new.transforms.get(transform)?);
                let decimals = decimals(precision, new);
                replaced.extend(realigned(text, steps.get(step)?.clone(), old, new, |_| decimals));
                last = Some(step);
            }
            // With the comma before it.
            Pairing::Old(step) => {
                add(&mut added, last, &mut replaced)?;
                let start = text.end_of(steps.get(step)?.start.checked_sub(2)?)?;
                replaced.push(TextReplacement { range: start..behind(Some(step))?, text: String::new() });
                last = Some(step);
            }
            Pairing::New(transform) => {
                let transform = new.transforms.get(transform)?;
                let decimals = decimals(precision, transform);
                added.push_str(&format!(", {}", rounded_text(transform, |_| decimals)));
            }
        }
    }
    add(&mut added, last, &mut replaced)?;
    Some(replaced)
}

/// A form as a body that is added has it, with rounded numbers.
pub(super) fn rounded_form(form: &BodyForm, precision: Precision) -> String {
    let mut text = rounded_text(&form.shape, |_| Decimals::of_lengths(precision));
    for transform in &form.transforms {
        let decimals = decimals(precision, transform);
        text.push_str(&format!(", {}", rounded_text(transform, |_| decimals)));
    }
    text
}

/// What becomes of transforms: indices into the old and the new ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pairing {
    Both(usize, usize),
    Old(usize),
    New(usize),
}

/// How well a transform can be written in the place of another one.
fn likeness(old: &Transform, new: &Transform) -> usize {
    use Transform::{Fit, Rotate, Scale, Stretch, Translate};
    let is_same_kind = match (old, new) {
        (Scale(_) | Stretch(_), Scale(_) | Stretch(_))
        | (Rotate { .. }, Rotate { .. })
        | (Translate(_), Translate(_))
        | (Fit { .. }, Fit { .. }) => true,
        (Scale(_) | Stretch(_) | Rotate { .. } | Translate(_) | Fit { .. }, _) => false,
    };
    usize::from(is_same_kind) + usize::from(old == new)
}

/// Which of the new transforms are old ones, changed or not, in their order: those that are most alike.
fn paired(old: &[Transform], new: &[Transform]) -> Vec<Pairing> {
    // best[i][j]: how alike the rests of both are, from i and j on.
    let mut best = vec![vec![0; new.len() + 1]; old.len() + 1];
    for i in (0..old.len()).rev() {
        for j in (0..new.len()).rev() {
            let like = likeness(&old[i], &new[j]);
            let both = if like > 0 { like + best[i + 1][j + 1] } else { 0 };
            best[i][j] = both.max(best[i + 1][j]).max(best[i][j + 1]);
        }
    }
    let (mut i, mut j, mut pairs) = (0, 0, Vec::new());
    while i < old.len() || j < new.len() {
        let like = if i < old.len() && j < new.len() { likeness(&old[i], &new[j]) } else { 0 };
        if like > 0 && best[i][j] == like + best[i + 1][j + 1] {
            pairs.push(Pairing::Both(i, j));
            (i, j) = (i + 1, j + 1);
        } else if j < new.len() && (i == old.len() || best[i][j] == best[i][j + 1]) {
            pairs.push(Pairing::New(j));
            j += 1;
        } else {
            pairs.push(Pairing::Old(i));
            i += 1;
        }
    }
    pairs
}
