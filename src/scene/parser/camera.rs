//! Parses the clauses of the camera: position, gaze, up, fov (thesis 9.3.1).

use super::SceneParser;
use crate::lang::cursor::{Placed, Reported};
use crate::lang::diagnostic::{Diagnostic, nearest};
use crate::lang::keywords;
use crate::lang::source::SourceSpan;
use crate::lang::token::{Mark, TokenKind};
use crate::scene::foreign;
use crate::scene::values::{SceneNumber, Vector, vector};
use crate::scene::{Camera, CameraError};
use glam::DVec3;

/// The clauses in their order.
const CLAUSES: [&str; 4] = keywords::words(&keywords::CAMERA_CLAUSES);

/// The clauses parsed so far.
#[derive(Default)]
struct Clauses {
    /// Where each of [`CLAUSES`] stands first.
    seen: [Option<SourceSpan>; 4],
    /// Position, gaze and up.
    vectors: [Option<Placed<DVec3>>; 3],
    fov: Option<Placed<f64>>,
}

impl SceneParser {
    /// Parses everything behind `camera;`, whose place is `header`.
    pub(super) fn camera_section(&mut self, header: SourceSpan) {
        let mut clauses = Clauses::default();
        while *self.cursor.kind(0) != TokenKind::End && self.header().is_none() {
            let complete = clauses.seen.iter().all(Option::is_some);
            let known = self.cursor.word(0).is_some_and(|word| CLAUSES.contains(&word));
            if complete && !known {
                // The caller reports what follows the camera, once.
                break;
            }
            let start = self.cursor.position();
            if self.clause(&mut clauses).is_err() {
                if self.cursor.position() == start {
                    self.cursor.advance();
                }
                self.skip_clause();
            }
        }
        let missing: Vec<_> =
            CLAUSES.iter().zip(&clauses.seen).filter(|(_, seen)| seen.is_none()).map(|(name, _)| *name).collect();
        if !missing.is_empty() {
            let names = missing.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            let diagnostic = Diagnostic::error(format!("the camera lacks {names}")).at(header, "in this section");
            let form = "a camera is `position <x,y,z>; gaze <x,y,z>; up <x,y,z>; fov DEGREES;`";
            self.cursor.report(diagnostic.help(form));
        }
        if let (Some(camera), None) = (self.camera_of(&clauses), &self.camera) {
            self.camera = Some(camera);
        }
    }

    /// Parses the camera if its header is missing, which is reported. Whether the current word begins a clause of it.
    pub(super) fn camera_without_header(&mut self) -> bool {
        let clause = self.cursor.word(0).is_some_and(|word| CLAUSES.contains(&word));
        let value = matches!(self.cursor.kind(1), TokenKind::Number(_) | TokenKind::Mark(Mark::Less));
        if !clause || !value {
            return false;
        }
        let span = self.cursor.span();
        let word = self.cursor.word(0).unwrap_or_default();
        let diagnostic = Diagnostic::error(format!("expected `camera;` before `{word}`")).at(span, "this belongs to the camera");
        self.cursor.report(diagnostic.help("the camera has a section of its own, `camera;`, behind bodies and lights"));
        self.seen[2].get_or_insert(span);
        self.camera_section(span);
        true
    }

    /// For a place that is looked at, `lookat <x, y, z>`: the gaze to it from the position, if both are there.
    fn gaze_to(&self, clauses: &Clauses, word: &str) -> Option<String> {
        let (_, remark) = foreign::camera_clause(word).filter(|(_, remark)| *remark == foreign::TARGET)?;
        let position = clauses.vectors[0]?.value;
        let component = |at: usize| match (self.cursor.kind(at), self.cursor.kind(at + 1)) {
            (TokenKind::Mark(Mark::Minus), TokenKind::Number(value)) => Some((-value, at + 3)),
            (TokenKind::Number(value), _) => Some((*value, at + 2)),
            _ => None,
        };
        let (x, next) = component(2)?;
        let (y, next) = component(next)?;
        let (z, _) = component(next)?;
        let rounded = |number: f64| (number * 1e6).round() / 1e6;
        let gaze = (DVec3::new(x, y, z) - position).to_array().map(rounded);
        Some(format!("{remark}; here `gaze {};`", Vector(DVec3::from(gaze))))
    }

    /// Parses `NAME VALUE;`.
    fn clause(&mut self, clauses: &mut Clauses) -> Result<(), Reported> {
        let span = self.cursor.span();
        let word = self.cursor.word(0).unwrap_or_default().to_owned();
        let Some(clause) = CLAUSES.iter().position(|name| *name == word) else {
            let expected = CLAUSES.iter().zip(&clauses.seen).find(|(_, seen)| seen.is_none()).map_or("fov", |(name, _)| name);
            let message = format!("expected `{expected}` of the camera, found {}", self.cursor.kind(0).describe());
            let meant = foreign::camera_clause(&word);
            let near = meant.map(|(clause, _)| clause).or_else(|| nearest(&word, CLAUSES));
            let help = match meant {
                Some((_, remark)) => self.gaze_to(clauses, &word).or_else(|| Some(remark.to_owned())),
                None => near.map(|near| format!("did you mean `{near}`?")),
            };
            self.cursor.report(Diagnostic::error(message).at(span, "found this").help_if(help));
            // A misspelt clause counts as present: that it is missing would be a second error for one mistake.
            let near = near.unwrap_or(expected);
            if let Some(near) = CLAUSES.iter().position(|name| *name == near) {
                clauses.seen[near].get_or_insert(span);
            }
            return Err(Reported);
        };
        if let Some(first) = clauses.seen[clause] {
            let diagnostic = Diagnostic::error(format!("the camera's `{word}` is given twice")).at(span, "the second time");
            self.cursor.report(diagnostic.at(first, "the first time"));
        } else if let Some(later) = (clause + 1..CLAUSES.len()).find(|later| clauses.seen[*later].is_some()) {
            let message = format!("the camera's `{word}` must come before `{}`", CLAUSES[later]);
            let diagnostic = Diagnostic::error(message).at(span, "too late");
            self.cursor.report(diagnostic.help("the order is `position`, `gaze`, `up`, `fov`"));
        }
        clauses.seen[clause].get_or_insert(span);
        self.cursor.advance();
        self.cursor.pass_marks_after(&word, &[Mark::Colon, Mark::Equal, Mark::Comma]);
        // The first of two equal clauses counts.
        if let Some(slot) = clauses.vectors.get_mut(clause) {
            let vector = vector(&mut self.cursor, &format!("the camera's {word}"))?;
            slot.get_or_insert(vector);
        } else {
            let fov = self.cursor.degrees("the camera's angle in degrees")?;
            clauses.fov.get_or_insert(fov);
        }
        self.cursor.expect(Mark::Semicolon, &format!("after the camera's `{word}`"))
    }

    /// Skips the rest of a clause: up to its `;`, or to the next clause where the `;` is missing.
    fn skip_clause(&mut self) {
        while *self.cursor.kind(0) != TokenKind::End && !self.cursor.accept(Mark::Semicolon) {
            if self.header().is_some() || self.cursor.word(0).is_some_and(|word| CLAUSES.contains(&word)) {
                return;
            }
            self.cursor.advance();
        }
    }

    /// The camera of these clauses. What is wrong with their values is reported.
    fn camera_of(&mut self, clauses: &Clauses) -> Option<Camera> {
        let [position, gaze, up] = clauses.vectors;
        let wrong_fov = clauses.fov.filter(|fov| !(fov.value > 0.0 && fov.value < 180.0));
        if let Some(fov) = wrong_fov {
            let diagnostic = Diagnostic::error("the camera's `fov` must be greater than 0 and less than 180");
            self.cursor.report(diagnostic.at(fov.span, format!("it is {}, in degrees", SceneNumber(fov.value))));
        }
        let mut zero = false;
        for (vector, word) in [(gaze, "gaze"), (up, "up")] {
            if let Some(vector) = vector.filter(|vector| vector.value == DVec3::ZERO) {
                zero = true;
                let diagnostic = Diagnostic::error(format!("the camera's `{word}` is zero"));
                self.cursor.report(diagnostic.at(vector.span, "this is no direction"));
            }
        }
        // Each value is checked even where another is missing or wrong: harmless values take the place of those.
        let value = |given: Option<Placed<DVec3>>, default| given.map_or(default, |given| given.value);
        let sound_fov = clauses.fov.filter(|_| wrong_fov.is_none()).map(|fov| fov.value);
        let complete = sound_fov.is_some() && clauses.vectors.iter().all(Option::is_some);
        let (position, fov) = (value(position, DVec3::ZERO), sound_fov.unwrap_or(45.0));
        match Camera::new(position, value(gaze, DVec3::NEG_Z), value(up, DVec3::Y), fov) {
            Ok(camera) => return complete.then_some(camera),
            Err(CameraError::Parallel) => {
                if let (Some(gaze), Some(up)) = (gaze, up) {
                    // One of these axes is not parallel to the gaze.
                    let axis = [DVec3::Y, DVec3::Z].into_iter().find(|axis| axis.cross(gaze.value.normalize()).length() > 0.1);
                    let diagnostic = Diagnostic::error("the camera's `gaze` and `up` are parallel").at(up.span, "this direction");
                    let diagnostic = diagnostic.at(gaze.span, "is also this one, or the opposite of it");
                    self.cursor.report(diagnostic.help_if(axis.map(|axis| format!("try `up {};`", Vector(axis)))));
                }
            }
            Err(error @ (CameraError::NoGaze | CameraError::NoUp)) if !zero => {
                // It is not zero, but too short.
                let span = if error == CameraError::NoGaze { gaze } else { up }.map(|vector| vector.span)?;
                self.cursor.report(Diagnostic::error("this direction is too short").at(span, "its length vanishes"));
            }
            // Reported above, or where the number stands.
            Err(CameraError::NoGaze | CameraError::NoUp | CameraError::TooLarge | CameraError::Fov) => {}
        }
        None
    }
}
