//! Spot lights: `spot, <x, y, z>, target <x, y, z>, angle DEGREES, soft DEGREES`.

use crate::lang::cursor::{Cursor, Placed, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::keywords::Keyword;
use crate::lang::token::Mark;
use crate::scene::foreign;
use crate::scene::movable::Movable;
use crate::scene::syntax::TextForm;
use crate::scene::transform::rotation;
use crate::scene::values::{SceneNumber, Vector, vector};
use crate::scene::{MIN_LENGTH, is_within_reach};
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// The largest angle between the axis of a cone and its edge, in degrees: light in all directions.
const MAX_ANGLE: f64 = 180.0;

/// A point that shines within a cone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotLight {
    position: DVec3,
    target: DVec3,
    angle: f64,
    soft: Option<f64>,
}

/// Why there is no such spot light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SpotLightError {
    /// A coordinate is beyond [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE), or not a number.
    #[error("a coordinate is too large")]
    TooFar,
    /// The target is the position.
    #[error("the target of a spot light is its position")]
    NoDirection,
    /// The angle is not within 0..=180, or it is 0.
    #[error("the angle of a spot light must be greater than 0 and at most {MAX_ANGLE}")]
    Angle,
    /// The soft part of the angle is not within 0 and the angle.
    #[error("the soft part of the angle of a spot light must be at least 0 and at most the angle")]
    Soft,
}

impl SpotLight {
    /// A light at a position that shines towards a target. `angle` is that between the axis of the cone and its edge,
    /// in degrees, 0..=180 without 0. Over the outer `soft` degrees of it, 0..=`angle`, the light gets weaker; `None`
    /// is the same as 0, a sharp edge.
    ///
    /// # Errors
    /// Points too far away; both in one place; angles out of range.
    pub fn new(position: DVec3, target: DVec3, angle: f64, soft: Option<f64>) -> Result<Self, SpotLightError> {
        if !(is_within_reach(position) && is_within_reach(target)) {
            return Err(SpotLightError::TooFar);
        }
        if position.distance(target) < MIN_LENGTH {
            return Err(SpotLightError::NoDirection);
        }
        if !is_angle(angle) {
            return Err(SpotLightError::Angle);
        }
        if soft.is_some_and(|soft| !(0.0..=angle).contains(&soft)) {
            return Err(SpotLightError::Soft);
        }
        Ok(Self { position, target, angle, soft })
    }

    /// Its position in world coordinates.
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// A point on the axis of the cone, in world coordinates. It is not the position.
    pub fn target(&self) -> DVec3 {
        self.target
    }

    /// The angle between the axis of the cone and its edge, in degrees, 0..=180 without 0.
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// How many of these degrees, counted from the edge, are soft: 0..=angle.
    pub fn soft(&self) -> f64 {
        self.soft.unwrap_or(0.0)
    }
}

impl SpotLight {
    /// The same that shines to another target; `None` if there is no such light.
    pub(super) fn aimed(&self, target: DVec3) -> Option<Self> {
        Self::new(self.position, target, self.angle, self.soft).ok()
    }

    /// The same, turned about an axis through its position.
    pub(super) fn turned(&self, axis: DVec3, degrees: f64) -> Option<Self> {
        self.aimed(self.position + rotation(axis, degrees) * (self.target - self.position))
    }
}

fn is_angle(angle: f64) -> bool {
    angle > 0.0 && angle <= MAX_ANGLE
}

impl Movable for SpotLight {
    fn anchor(&self) -> Option<DVec3> {
        Some(self.position)
    }

    /// The target moves too, so that the direction stays.
    fn moved(&self, by: DVec3) -> Option<Self> {
        Self::new(self.position + by, self.target + by, self.angle, self.soft).ok()
    }
}

impl TextForm for SpotLight {
    const KEYWORD: Keyword = Keyword {
        word: "spot",
        doc: "`spot, <x, y, z>, target <x, y, z>, angle DEGREES`: a light in one point that shines within a cone; \
              `soft DEGREES` may follow",
    };
    const CLAUSES: &'static [Keyword] = &[
        Keyword { word: "target", doc: "a place in the middle of the cone: `target <x, y, z>`" },
        Keyword {
            word: "angle",
            doc: "the angle between the middle of the cone and its edge in degrees, greater than 0, at most 180",
        },
        Keyword {
            word: "soft",
            doc: "over how many degrees within the edge the light gets weaker; without it, the edge is sharp",
        },
    ];
    const EXAMPLE: &'static str = "spot, <3, 5, 4>, target <0, 1, 0>, angle 25, soft 5";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        cursor.expect(Mark::Comma, "after `spot`")?;
        let position = vector(cursor, "the position of the light")?;
        cursor.expect(Mark::Comma, "after the position of the light")?;
        clause(cursor, "target")?;
        let target = vector(cursor, "the target")?;
        cursor.expect(Mark::Comma, "after the target")?;
        clause(cursor, "angle")?;
        let angle = cursor.degrees("the angle, in degrees")?;
        let soft = if cursor.sees_mark(0, Mark::Comma) && cursor.word(1) == Some("soft") {
            cursor.advance();
            clause(cursor, "soft")?;
            Some(cursor.degrees("the soft part of the angle, in degrees")?)
        } else {
            None
        };
        if position.value.distance(target.value) < MIN_LENGTH {
            let diagnostic = Diagnostic::error("the spot light has no direction")
                .at(target.span, "the target is also here")
                .at(position.span, "the position of the light");
            cursor.report(diagnostic.help("give a target in the direction in which the light shines"));
        }
        check_angles(cursor, angle, soft);
        // Coordinates out of range are reported where they stand.
        Ok(Self::new(position.value, target.value, angle.value, soft.map(|soft| soft.value)).ok())
    }
}

/// Moves past the word before a value, or reports what is in its place.
fn clause(cursor: &mut Cursor, word: &str) -> Result<(), Reported> {
    let hint = cursor.word(0).and_then(|found| foreign::spot_clause(found, word));
    let reports = cursor.report_count();
    let passed = cursor.expect_word(word, "of the spot light");
    if let (Err(Reported), Some(hint)) = (&passed, hint) {
        cursor.help_since(reports, hint);
    }
    passed
}

/// Reports angles out of range.
fn check_angles(cursor: &mut Cursor, angle: Placed<f64>, soft: Option<Placed<f64>>) {
    if !is_angle(angle.value) {
        let message = format!("the angle of the spot light must be greater than 0 and at most {MAX_ANGLE}");
        let diagnostic = Diagnostic::error(message).at(angle.span, format!("it is {}", SceneNumber(angle.value)));
        cursor.report(diagnostic.help("it is measured from the middle of the cone to its edge: `angle 30` is 60 degrees wide"));
    } else if let Some(soft) = soft.filter(|soft| !(0.0..=angle.value).contains(&soft.value)) {
        let diagnostic = Diagnostic::error("the soft part of the angle must be at least 0 and at most the angle")
            .at(soft.span, format!("it is {}", SceneNumber(soft.value)))
            .at(angle.span, "the angle");
        let help = format!("with `soft {}`, the light gets weaker from the middle of the cone on", SceneNumber(angle.value));
        cursor.report(diagnostic.help(help));
    }
}

impl Display for SpotLight {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        let [position, target] = [self.position, self.target].map(Vector);
        write!(f, "spot, {position}, target {target}, angle {}", SceneNumber(self.angle))?;
        self.soft.map_or(Ok(()), |soft| write!(f, ", soft {}", SceneNumber(soft)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_spot_lights_are_refused() {
        let spot = |target: DVec3, angle, soft| SpotLight::new(DVec3::ONE, target, angle, Some(soft));
        assert_eq!(spot(DVec3::ONE, 30.0, 0.0), Err(SpotLightError::NoDirection));
        assert_eq!(spot(DVec3::Y * 1e31, 30.0, 0.0), Err(SpotLightError::TooFar));
        for angle in [0.0, -1.0, 180.1, f64::NAN] {
            assert_eq!(spot(DVec3::ZERO, angle, 0.0), Err(SpotLightError::Angle), "{angle}");
        }
        for soft in [-0.1, 30.1, f64::NAN] {
            assert_eq!(spot(DVec3::ZERO, 30.0, soft), Err(SpotLightError::Soft), "{soft}");
        }
        assert!(spot(DVec3::ZERO, 30.0, 30.0).is_ok() && spot(DVec3::ZERO, 180.0, 0.0).is_ok());
    }
}
