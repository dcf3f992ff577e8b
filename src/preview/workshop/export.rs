//! Saves a picture on a background thread. An export holds everything that the thread needs.

use crate::engine::{Engine, EngineError, Subject, Task};
use crate::picture::Frame;
use crate::picture::{ViewTransform, save};
use crate::trace::Hits;
use std::path::Path;
use std::sync::Arc;

/// A picture to be saved.
pub struct PictureExport {
    pub(super) subject: Subject,
    pub(super) engine: Engine,
    /// The hits, if they have been traced.
    pub(super) hits: Option<Arc<Hits>>,
    pub(super) numbers: Vec<f32>,
    pub(super) transform: ViewTransform,
}

impl PictureExport {
    /// Computes the picture and saves it in the format of the path's suffix. Returns how many of its pixels were NaN.
    ///
    /// # Errors
    /// The suffix names no format, or the file cannot be written. The error is for the user. An existing file is then
    /// unchanged.
    pub fn save(&self, path: &Path) -> Result<usize, String> {
        let mut frame = self.frame().map_err(|error| error.to_string())?;
        let undefined = frame.clean();
        save(path, &frame, self.transform)?;
        Ok(undefined)
    }

    fn frame(&self) -> Result<Frame, EngineError> {
        let evaluator = match &self.hits {
            Some(hits) => self.engine.prepare(&self.subject, hits, &self.numbers)?,
            None => self.engine.evaluator(&self.subject, &self.numbers, &Task::UNWATCHED)?,
        };
        Ok(evaluator.frame(&self.numbers))
    }
}
