//! Saves a picture on a background thread. An export holds everything that the thread needs.

use crate::engine::{Engine, Subject, Task};
use crate::picture::Frame;
use crate::picture::{ViewTransform, save};
use std::path::Path;
use std::sync::Arc;

/// A picture to be saved.
pub struct PictureExport {
    pub(super) content: ExportContent,
    pub(super) transform: ViewTransform,
    pub(super) passes: u32,
}

/// Where the colours of a saved picture come from.
pub(super) enum ExportContent {
    /// The picture in view, without NaN, and how many of its pixels had one.
    Shown { frame: Arc<Frame>, undefined: usize },
    /// The picture of these numbers: the one in view is older, coarse, or that of a held slider.
    Other { subject: Box<Subject>, engine: Engine, numbers: Vec<f32> },
}

impl PictureExport {
    /// How many passes the picture has.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Saves the picture in the format of the path's suffix; computes it first if it is not in view. Returns how many
    /// of its pixels were NaN.
    ///
    /// # Errors
    /// The suffix names no format, or the file cannot be written. The error is for the user. An existing file is then
    /// unchanged.
    pub fn save(&self, path: &Path) -> Result<usize, String> {
        let (frame, undefined) = match &self.content {
            ExportContent::Shown { frame, undefined } => (Arc::clone(frame), *undefined),
            ExportContent::Other { subject, engine, numbers } => {
                let frame = engine.picture(subject, numbers, self.passes, &Task::UNWATCHED);
                let mut frame = frame.map_err(|error| error.to_string())?;
                let undefined = frame.clean();
                (Arc::new(frame), undefined)
            }
        };
        save(path, &frame, self.transform)?;
        Ok(undefined)
    }
}
