//! Edits of a scene's text that leave everything else in it as it is: comments, spaces, the order of declarations.
//!
//! [`edit`] turns a [`SceneChange`] into replacements of parts of the text. Where values change, only the numbers that
//! are different are written again. Nothing here knows the form of a shape or a light: the text of a declaration is
//! compared word by word with what `Display` prints (`align`). The transforms
//! of a body are edited one by one (`forms`). `declarations` finds where declarations begin and end.

mod align;
mod declarations;
mod forms;
#[cfg(test)]
mod tests;

use crate::lang::source::Source;
use crate::scene::{BodyForm, BodyId, Camera, LightId, LightKind, Scene};
pub(crate) use align::rounded;
use align::{Decimals, realigned};
use declarations::SceneText;
use glam::DVec3;
use std::ops::Range;

/// A body or a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SceneObject {
    /// A body.
    Body(BodyId),
    /// A light.
    Light(LightId),
}

/// A change of a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum SceneChange {
    /// Another camera.
    Camera(Camera),
    /// Another form of a body, with a shape of the same kind or of another one.
    Form(BodyId, BodyForm),
    /// Another place, or another kind, of a light.
    Light(LightId, LightKind),
    /// A new body of this name, behind the others.
    AddBody(String, BodyForm),
    /// A new light of this name, behind the others.
    AddLight(String, LightKind),
    /// A copy of a body or light under another name, moved by a vector in world units.
    Duplicate(SceneObject, String, DVec3),
    /// A body or light less.
    Remove(SceneObject),
}

/// How exactly changed numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// So that they read back exactly.
    Exact,
    /// Lengths to this many decimals, or to as many as the text had; below 0, to tens, hundreds and so on. Directions
    /// and angles to about four digits.
    Decimals(i32),
}

impl Precision {
    /// Four digits for numbers of about this size. A distance of the camera makes differences that no picture shows.
    pub fn for_size(size: f64) -> Self {
        let digits = if size.is_normal() { size.abs().log10().floor() } else { 0.0 };
        Precision::Decimals(3 - digits as i32)
    }

    /// A vector in the steps of this precision, in world units.
    pub fn round(self, vector: DVec3) -> DVec3 {
        match self {
            Precision::Exact => vector,
            Precision::Decimals(decimals) => vector.map(|number| align::rounded(number, decimals)),
        }
    }
}

/// The replacement of a part of a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextReplacement {
    /// The part, in bytes.
    pub range: Range<usize>,
    /// What is there afterwards.
    pub text: String,
}

/// An edit of a scene's text.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneEdit {
    /// The replacements, in the order of the text. They do not overlap.
    pub replacements: Vec<TextReplacement>,
    /// The text with these replacements.
    pub text: String,
    /// The scene that the new text declares.
    pub scene: Scene,
}

/// Why a text is not edited.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EditRefusal {
    /// The text has errors. This is the first one.
    #[error("the scene text has an error: {0}")]
    Errors(String),
    /// The text declares no such body or light.
    #[error("the scene has no such body or light")]
    Missing,
    /// The text would have an error then.
    #[error("the scene text would have an error: {0}")]
    Invalid(String),
}

/// The edit of a scene's text that makes a change. Numbers are rounded unless the scene would then be refused.
///
/// # Errors
/// The text has errors, before or after the change; or what is to be changed does not exist.
pub fn edit(source: &Source, change: &SceneChange, precision: Precision) -> Result<SceneEdit, EditRefusal> {
    let (scene, _) = Scene::parse(source).map_err(|errors| {
        let first = errors.iter().next().map(|error| error.message().to_owned());
        EditRefusal::Errors(first.unwrap_or_default())
    })?;
    let text = SceneText::new(source, &scene);
    let attempt = |precision| {
        let replacements = replacements(&text, change, precision).ok_or(EditRefusal::Missing)?;
        let text = applied(source.text(), &replacements);
        match Scene::parse(&Source::new(source.name(), text.as_str())) {
            Ok((scene, _)) => Ok(SceneEdit { replacements, text, scene }),
            Err(errors) => {
                let first = errors.iter().next().map(|error| error.message().to_owned());
                Err(EditRefusal::Invalid(first.unwrap_or_default()))
            }
        }
    };
    match attempt(precision) {
        Err(EditRefusal::Invalid(_)) if precision != Precision::Exact => attempt(Precision::Exact),
        other => other,
    }
}

/// A name that nothing in the scene has: `stem`, or with a number behind it, from 2. A number at the end of `stem` is
/// left out.
pub fn unused_name(scene: &Scene, stem: &str) -> String {
    let stem = Some(stem.trim_end_matches(|last: char| last.is_ascii_digit())).filter(|rest| !rest.is_empty()).unwrap_or(stem);
    let taken = |name: &str| {
        let mut names = scene.bodies.iter().map(|body| &body.name).chain(scene.lights.iter().map(|light| &light.name));
        names.any(|other| other == name)
    };
    let numbered = (2_u64..).map(|number| format!("{stem}{number}"));
    std::iter::once(stem.to_owned()).chain(numbered).find(|name| !taken(name)).unwrap_or_else(|| stem.to_owned())
}

/// The text with these replacements, which are in its order.
fn applied(text: &str, replacements: &[TextReplacement]) -> String {
    let mut result = text.to_owned();
    for TextReplacement { range, text } in replacements.iter().rev() {
        result.replace_range(range.clone(), text);
    }
    result
}

/// The replacements that make a change; `None` if what is to be changed does not exist.
fn replacements(text: &SceneText, change: &SceneChange, precision: Precision) -> Option<Vec<TextReplacement>> {
    let scene = text.scene();
    match change {
        SceneChange::Camera(camera) => {
            let decimals = |number: usize| Decimals::of_camera(precision, number, camera);
            Some(realigned(text, text.camera(), &scene.camera, camera, decimals))
        }
        SceneChange::Form(id, form) => forms::replaced(text, *id, form, precision),
        SceneChange::Light(id, kind) => {
            let old = &scene.lights.get(id.index())?.kind;
            Some(realigned(text, text.value(SceneObject::Light(*id))?, old, kind, |number| {
                Decimals::of_light(precision, number, kind)
            }))
        }
        SceneChange::AddBody(name, form) => {
            Some(vec![text.behind_bodies(&format!("{name}: {};", forms::rounded_form(form, precision)))])
        }
        SceneChange::AddLight(name, kind) => Some(vec![text.behind_lights(&format!(
            "{name}: {};",
            align::rounded_text(kind, |number| Decimals::of_light(precision, number, kind))
        ))]),
        SceneChange::Duplicate(original, name, by) => {
            let range = text.declaration(*original)?;
            let by = precision.round(*by);
            let mut inside = match original {
                SceneObject::Body(id) => {
                    let form = &scene.body(*id).form;
                    forms::replaced(text, *id, &form.moved(by).unwrap_or_else(|| form.clone()), precision)?
                }
                SceneObject::Light(id) => {
                    let kind = &scene.light(*id).kind;
                    let moved = kind.moved(by).unwrap_or_else(|| kind.clone());
                    realigned(text, text.value(*original)?, kind, &moved, |number| Decimals::of_light(precision, number, kind))
                }
            };
            inside.insert(0, TextReplacement { range: text.name(*original)?, text: name.clone() });
            inside.iter_mut().for_each(|one| one.range = one.range.start - range.start..one.range.end - range.start);
            Some(vec![text.behind(*original, &applied(text.slice(range), &inside))?])
        }
        SceneChange::Remove(declared) => Some(vec![TextReplacement { range: text.removable(*declared)?, text: String::new() }]),
    }
}
