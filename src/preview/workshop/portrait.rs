//! A picture on its way into a file: everything that it is made of, on no thread in particular.

use crate::engine::{Engine, EngineError, Subject, Task};
use crate::evaluate::Frame;
use crate::picture::{Transfer, save};
use crate::trace::Hits;
use std::path::Path;
use std::sync::Arc;

/// A picture to be saved.
pub struct Portrait {
    pub(super) subject: Subject,
    pub(super) engine: Engine,
    /// Its hits, if they are there already.
    pub(super) hits: Option<Arc<Hits>>,
    pub(super) numbers: Vec<f32>,
    pub(super) transfer: Transfer,
}

impl Portrait {
    /// Computes it, and saves it in the format that the suffix names. How many of its pixels held NaN.
    ///
    /// # Errors
    /// There is no such format, or the file cannot be written; the text is for people. An existing file is unharmed.
    pub fn save(&self, path: &Path) -> Result<usize, String> {
        let mut frame = self.frame().map_err(|error| error.to_string())?;
        let undefined = frame.clean();
        save(path, &frame, self.transfer)?;
        Ok(undefined)
    }

    fn frame(&self) -> Result<Frame, EngineError> {
        let evaluator = match &self.hits {
            Some(hits) => self.engine.prepare(&self.subject, hits)?,
            None => self.engine.evaluator(&self.subject, &Task::UNWATCHED)?,
        };
        Ok(evaluator.frame(&self.numbers))
    }
}
