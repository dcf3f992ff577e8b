//! Environments: `environment, "FILE", rotate DEGREES`.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::keywords::Keyword;
use crate::lang::token::{Mark, TokenKind};
use crate::scene::movable::Movable;
use crate::scene::named_file::{NamedFile, sees_built_in};
use crate::scene::syntax::TextForm;
use crate::scene::transform::sine_and_cosine;
use crate::scene::values::SceneNumber;
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// The word before the angle.
const ROTATE: Keyword = Keyword { word: "rotate", doc: "`rotate DEGREES`: turns the environment about the y axis" };

/// Light from all around: that of an image, or white.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentLight {
    image: Option<NamedFile>,
    rotation: f64,
}

impl EnvironmentLight {
    /// The light of an image, turned about +y by an angle in degrees, which must be finite: counter-clockwise seen from
    /// above. Without an image it is white.
    pub fn new(image: Option<NamedFile>, rotation: f64) -> Self {
        Self { image, rotation }
    }

    /// The image, in latitude-longitude form; `None`: white.
    pub fn image(&self) -> Option<&NamedFile> {
        self.image.as_ref()
    }

    /// The angle about +y by which it is turned, in degrees: counter-clockwise seen from above.
    pub fn rotation(&self) -> f64 {
        self.rotation
    }

    /// The sine and the cosine of the rotation, exact at right angles.
    pub fn sine_and_cosine(&self) -> (f64, f64) {
        sine_and_cosine(self.rotation)
    }
}

impl Movable for EnvironmentLight {
    /// It is everywhere.
    fn anchor(&self) -> Option<DVec3> {
        None
    }

    /// It is the same everywhere.
    fn moved(&self, _: DVec3) -> Option<Self> {
        Some(self.clone())
    }
}

impl TextForm for EnvironmentLight {
    const KEYWORD: Keyword = Keyword {
        word: "environment",
        doc: "`environment, \"FILE\", rotate DEGREES`: light from all around, by an .hdr or .exr image in \
              latitude-longitude form; white without one",
    };
    const CLAUSES: &'static [Keyword] = &[ROTATE];
    const EXAMPLE: &'static str = "environment, \"preset:sky\"";
    const IS_SINGLE: bool = true;

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        let (mut image, mut rotation, mut is_sound) = (None, 0.0, true);
        let is_text = |cursor: &Cursor, ahead: usize| matches!(cursor.kind(ahead), TokenKind::Text(_));
        // A name without quotation marks has a dot before its suffix, or is that of a built-in environment.
        let is_name = is_text(cursor, 1) || cursor.sees_mark(2, Mark::Dot) || sees_built_in(cursor, 1);
        if cursor.sees_mark(0, Mark::Comma) && is_name {
            cursor.advance();
            image = NamedFile::parse(cursor, "environment", "environment, \"FILE.hdr\"")?;
            is_sound = image.is_some();
        }
        if cursor.sees_mark(0, Mark::Comma) && cursor.word(1) == Some(ROTATE.word) {
            cursor.advance();
            cursor.advance();
            cursor.pass_marks_after(ROTATE.word, &[Mark::Colon, Mark::Equal]);
            if cursor.sees_mark(0, Mark::Less) {
                let diagnostic = Diagnostic::error("the rotation of the environment has no axis");
                let diagnostic = diagnostic.at(cursor.span(), "expected a number");
                return Err(cursor.report(diagnostic.help("it turns about the y axis: write `rotate 30`")));
            }
            rotation = cursor.degrees("the rotation of the environment, in degrees")?.value;
        } else if cursor.word(0) == Some(ROTATE.word) || is_text(cursor, 0) {
            let diagnostic = Diagnostic::error(format!("expected `,` before {}", cursor.kind(0).describe()));
            return Err(cursor.report(diagnostic.at(cursor.span(), "found this")));
        }
        Ok(is_sound.then(|| Self::new(image, rotation)))
    }
}

impl Display for EnvironmentLight {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        f.write_str("environment")?;
        if let Some(image) = &self.image {
            write!(f, ", {image}")?;
        }
        if self.rotation != 0.0 {
            write!(f, ", rotate {}", SceneNumber(self.rotation))?;
        }
        Ok(())
    }
}
