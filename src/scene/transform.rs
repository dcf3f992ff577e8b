//! Transforms of bodies: `scale`, `rotate`, `translate`, `fit`, in the order in which they are written.
//!
//! They are kept as written. What they do to a surface is computed in [`crate::world`], because `fit` needs the box
//! around the body.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::keywords::Keyword;
use crate::lang::token::{Mark, TokenKind};
use crate::scene::syntax::Syntax;
use crate::scene::values::{SceneNumber, Vector, positive, vector};
use crate::scene::{MAX_COORDINATE, MIN_LENGTH};
use glam::{DAffine3, DMat3, DVec3};
use std::fmt::{Display, Formatter, Result as FmtResult};

/// What happens to a body, about the origin of the scene. Directions and lengths are those of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transform {
    /// Larger by a factor, which is not 0; below 0, it is mirrored too.
    Scale(f64),
    /// Larger by a factor along each axis. None is 0; below 0, the axis is turned round.
    Stretch(DVec3),
    /// Turned about an axis by an angle in degrees, counter-clockwise seen from where the axis points to.
    Rotate {
        /// The axis, of any length but 0.
        axis: DVec3,
        /// The angle.
        degrees: f64,
    },
    /// Moved.
    Translate(DVec3),
    /// Moved and scaled in all directions alike.
    Fit {
        /// Where the middle of the box around the body is afterwards.
        center: DVec3,
        /// How long the largest side of this box is afterwards, greater than 0.
        size: f64,
    },
}

/// The sine and the cosine of an angle in degrees, exact at right angles.
pub(super) fn sine_and_cosine(degrees: f64) -> (f64, f64) {
    let turn = degrees.rem_euclid(360.0);
    let quarter = (turn / 90.0).round();
    let (sine, cosine) = (turn - 90.0 * quarter).to_radians().sin_cos();
    match quarter as i64 % 4 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Rodrigues' rotation matrix: about an axis of any length but 0, counter-clockwise seen from where it points to.
pub(super) fn rotation(axis: DVec3, degrees: f64) -> DMat3 {
    let (sine, cosine) = sine_and_cosine(degrees);
    let axis = axis.normalize();
    let turned = |one: DVec3| cosine * one + sine * axis.cross(one) + (1.0 - cosine) * axis.dot(one) * axis;
    DMat3::from_cols(turned(DVec3::X), turned(DVec3::Y), turned(DVec3::Z))
}

impl Transform {
    /// How each is written, in the order in which messages name them.
    pub const SYNTAX: &'static [Syntax<Self>] = &[
        Syntax {
            keyword: Keyword {
                word: "scale",
                doc: "`scale NUMBER` or `scale <x, y, z>`: makes the body larger about the origin, or stretches it along the axes",
            },
            clauses: &[],
            example: "scale <1, 0.5, 2>",
            is_single: false,
            parse: scale,
        },
        Syntax {
            keyword: Keyword {
                word: "rotate",
                doc: "`rotate <x, y, z> DEGREES`: turns the body about this axis through the origin",
            },
            clauses: &[],
            example: "rotate <0, 1, 0> 30",
            is_single: false,
            parse: rotate,
        },
        Syntax {
            keyword: Keyword { word: "translate", doc: "`translate <x, y, z>`: moves the body" },
            clauses: &[],
            example: "translate <0, 1, 0>",
            is_single: false,
            parse: translate,
        },
        Syntax {
            keyword: Keyword {
                word: "fit",
                doc: "`fit <x, y, z> SIZE`: moves and scales the body so that the box around it is centred there and its \
                      largest side has this length",
            },
            clauses: &[],
            example: "fit <0, 1, 0> 2",
            is_single: false,
            parse: fit,
        },
    ];

    /// What it does to points; `None` if that depends on the body.
    pub fn map(&self) -> Option<DAffine3> {
        match self {
            Transform::Scale(factor) => Some(DAffine3::from_scale(DVec3::splat(*factor))),
            Transform::Stretch(factors) => Some(DAffine3::from_scale(*factors)),
            Transform::Rotate { axis, degrees } => Some(DAffine3::from_mat3(rotation(*axis, *degrees))),
            Transform::Translate(by) => Some(DAffine3::from_translation(*by)),
            Transform::Fit { .. } => None,
        }
    }
}

impl Display for Transform {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        match self {
            Transform::Scale(factor) => write!(f, "scale {}", SceneNumber(*factor)),
            Transform::Stretch(factors) => write!(f, "scale {}", Vector(*factors)),
            Transform::Rotate { axis, degrees } => write!(f, "rotate {} {}", Vector(*axis), SceneNumber(*degrees)),
            Transform::Translate(by) => write!(f, "translate {}", Vector(*by)),
            Transform::Fit { center, size } => write!(f, "fit {} {}", Vector(*center), SceneNumber(*size)),
        }
    }
}

/// Passes over a `:` or `=` behind a keyword, which is reported.
fn behind(cursor: &mut Cursor, word: &str) {
    cursor.pass_marks_after(word, &[Mark::Colon, Mark::Equal]);
}

/// Whether a vector is ahead, or what is meant as one.
fn sees_vector(cursor: &Cursor) -> bool {
    cursor.sees_mark(0, Mark::Less) || cursor.sees_mark(0, Mark::Open)
}

/// Parses one factor or three.
fn scale(cursor: &mut Cursor) -> Result<Option<Transform>, Reported> {
    behind(cursor, "scale");
    let start = cursor.span();
    if sees_vector(cursor) {
        let factors = vector(cursor, "the scale")?;
        if factors.value.is_nan() {
            return Ok(None);
        }
        let transform = factors.value.to_array().into_iter().all(is_factor).then_some(Transform::Stretch(factors.value));
        if transform.is_none() {
            let zero = (0..3).find(|axis| factors.value[*axis] == 0.0).map(|axis| format!(" along {}", ["x", "y", "z"][axis]));
            report_flat(cursor, zero.as_deref(), factors.span);
        }
        return Ok(transform);
    }
    let factor = cursor.number("the scale")?;
    let more = cursor.sees_mark(0, Mark::Comma) && matches!(cursor.kind(1), TokenKind::Number(_) | TokenKind::Mark(Mark::Minus));
    if more {
        let diagnostic = Diagnostic::error("`scale` has one factor, or a vector of three");
        let place = start.to(cursor.peek(1).span);
        return Err(
            cursor.report(diagnostic.at(place, "more than one number").help("three factors are written `scale <x, y, z>`"))
        );
    }
    if factor.value.abs() > MAX_COORDINATE {
        let diagnostic = Diagnostic::error("the scale is too large");
        cursor.report(diagnostic.at(factor.span, format!("at most {MAX_COORDINATE:e}")));
        return Ok(None);
    }
    if !is_factor(factor.value) {
        report_flat(cursor, (factor.value == 0.0).then_some(""), factor.span);
        return Ok(None);
    }
    Ok(Some(Transform::Scale(factor.value)))
}

fn is_factor(factor: f64) -> bool {
    (MIN_LENGTH..=MAX_COORDINATE).contains(&factor.abs())
}

/// Reports a scale that leaves nothing of a body. `zero` says along which axis it is 0; otherwise it is too small.
fn report_flat(cursor: &mut Cursor, zero: Option<&str>, span: crate::lang::source::SourceSpan) {
    let (message, mark) = match zero {
        Some("") => ("the scale is 0".to_owned(), "nothing would be left of the body".to_owned()),
        Some(along) => (format!("the scale{along} is 0"), "the body would be flat".to_owned()),
        None => ("the scale is too small".to_owned(), format!("at least {MIN_LENGTH:e}")),
    };
    let help = "a flat body is a `rectangle`, a `disc` or a `triangle`; a scale below 0 mirrors";
    cursor.report(Diagnostic::error(message).at(span, mark).help(help));
}

/// The name of an axis with its vector.
fn axis_of_name(word: &str) -> Option<(&'static str, Vector)> {
    ["x", "y", "z"].into_iter().zip(DVec3::AXES.map(Vector)).find(|(name, _)| word.eq_ignore_ascii_case(name))
}

/// Parses an axis and an angle.
fn rotate(cursor: &mut Cursor) -> Result<Option<Transform>, Reported> {
    behind(cursor, "rotate");
    if let Some((name, axis)) = cursor.word(0).and_then(axis_of_name) {
        let place = cursor.span();
        cursor.advance();
        cursor.accept(Mark::Comma);
        let angle = if cursor.sees_number() { Some(cursor.degrees("the angle of the rotation")?.value) } else { None };
        let angle = angle.map_or("DEGREES".to_owned(), |angle| SceneNumber(f64::from(angle as f32)).to_string());
        let diagnostic = Diagnostic::error(format!("the axis of the rotation is a vector, not `{name}`"));
        return Err(cursor.report(diagnostic.at(place, "a vector belongs here").help(format!("write `rotate {axis} {angle}`"))));
    }
    if !sees_vector(cursor) && cursor.sees_number() {
        let angle = cursor.degrees("the angle of the rotation")?;
        let diagnostic = Diagnostic::error("expected the axis of the rotation before its angle");
        let help = format!("write `rotate <0, 1, 0> {}` to turn about the y axis", SceneNumber(f64::from(angle.value as f32)));
        return Err(cursor.report(diagnostic.at(angle.span, "the axis comes first").help(help)));
    }
    let axis = vector(cursor, "the axis of the rotation")?;
    if !cursor.sees_number() && !matches!(cursor.kind(0), TokenKind::Mark(Mark::Minus | Mark::Comma)) {
        // Three angles, as other programs write them.
        let angles = axis.value.to_array();
        let turns = (0..3).filter(|index| angles[*index] != 0.0).map(|index| {
            let angle = SceneNumber(angles[index]);
            format!("rotate {} {angle}", Vector(DVec3::AXES[index]))
        });
        let turns = turns.collect::<Vec<_>>().join(", ");
        let diagnostic = Diagnostic::error("expected the angle of the rotation, in degrees").at(axis.span, "this is its axis");
        let help = format!("a rotation is written `rotate <0, 1, 0> 30`; if these are angles, write `{turns}`");
        return Err(cursor.report(diagnostic.help(help)));
    }
    no_comma(cursor, "the axis of the rotation");
    let degrees = cursor.degrees("the angle of the rotation, in degrees")?;
    if degrees.value.abs() > MAX_COORDINATE {
        let diagnostic = Diagnostic::error("the angle of the rotation is too large");
        cursor.report(diagnostic.at(degrees.span, format!("at most {MAX_COORDINATE:e}")));
        return Ok(None);
    }
    if axis.value.length() < MIN_LENGTH {
        let diagnostic = Diagnostic::error("the axis of the rotation is zero").at(axis.span, "this is no direction");
        cursor.report(diagnostic.help("to turn about the vertical axis, write `rotate <0, 1, 0> DEGREES`"));
        return Ok(None);
    }
    // A component out of range is reported where it stands.
    Ok(axis.value.is_finite().then_some(Transform::Rotate { axis: axis.value, degrees: degrees.value }))
}

/// Reports a comma between the two values of a transform, and moves past it.
fn no_comma(cursor: &mut Cursor, what: &str) {
    let place = cursor.span();
    if cursor.accept(Mark::Comma) {
        cursor.report(Diagnostic::error(format!("no `,` stands after {what}")).at(place, "leave this out"));
    }
}

fn translate(cursor: &mut Cursor) -> Result<Option<Transform>, Reported> {
    behind(cursor, "translate");
    let by = vector(cursor, "the way by which the body is moved")?;
    Ok(by.value.is_finite().then_some(Transform::Translate(by.value)))
}

fn fit(cursor: &mut Cursor) -> Result<Option<Transform>, Reported> {
    behind(cursor, "fit");
    if !sees_vector(cursor) && matches!(cursor.kind(0), TokenKind::Number(_)) {
        let size = cursor.number("the size")?;
        let diagnostic = Diagnostic::error("expected where the middle of the body is to be, before its size");
        let help = format!("write `fit <0, 0, 0> {}`", SceneNumber(size.value));
        return Err(cursor.report(diagnostic.at(size.span, "the place comes first").help(help)));
    }
    let center = vector(cursor, "the place of the middle")?;
    no_comma(cursor, "the place of the middle");
    let size = positive(cursor, "the length of the largest side")?;
    Ok(size.filter(|_| center.value.is_finite()).map(|size| Transform::Fit { center: center.value, size }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_exact() {
        for (degrees, expected) in
            [(90.0, (1.0, 0.0)), (-90.0, (-1.0, 0.0)), (180.0, (0.0, -1.0)), (-270.0, (1.0, 0.0)), (720.0, (0.0, 1.0))]
        {
            assert_eq!(sine_and_cosine(degrees), expected, "{degrees}");
        }
        let (sine, cosine) = sine_and_cosine(390.0);
        assert!((sine - 0.5).abs() < 1e-15 && (cosine - 0.75_f64.sqrt()).abs() < 1e-15);
        for degrees in [44.9, 45.0, 45.1, 134.9, 225.0, 315.0, 359.0, -17.0] {
            let (sine, cosine) = sine_and_cosine(degrees);
            let (wanted_sine, wanted_cosine) = degrees.to_radians().sin_cos();
            assert!((sine - wanted_sine).abs() < 1e-14 && (cosine - wanted_cosine).abs() < 1e-14, "{degrees}");
        }
    }

    #[test]
    fn rotations_are_counter_clockwise() {
        let turned = |axis, degrees, point| Transform::Rotate { axis, degrees }.map().unwrap().transform_point3(point);
        assert_eq!(turned(DVec3::Z, 90.0, DVec3::X), DVec3::Y);
        assert_eq!(turned(5.0 * DVec3::Y, 90.0, DVec3::Z), DVec3::X);
        assert!(turned(DVec3::ONE, 120.0, DVec3::X).abs_diff_eq(DVec3::Y, 1e-15));
    }
}
