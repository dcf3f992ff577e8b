//! A picture on its way into a file: all that it is made of, on no thread in particular.

use crate::evaluate::{Backend, Evaluator};
use crate::formula::Formula;
use crate::picture::{Transfer, save};
use crate::preview::renderer::tracing_budget;
use crate::scene::Scene;
use crate::trace::{Hits, View, trace};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A picture to be saved.
pub struct Portrait {
    pub(super) formula: Arc<Formula>,
    pub(super) scene: Arc<Scene>,
    pub(super) view: View,
    /// Its hits, if they are there already.
    pub(super) hits: Option<Arc<Hits>>,
    pub(super) backend: Backend,
    pub(super) numbers: Vec<f32>,
    pub(super) transfer: Transfer,
}

impl Portrait {
    /// Computes it, and saves it in the format that the suffix names. How many of its pixels held what is no number.
    ///
    /// # Errors
    /// There is no such format, or the file cannot be written; the text is for people. What was there is unharmed.
    pub fn save(&self, path: &Path) -> Result<usize, String> {
        let hits = match &self.hits {
            Some(hits) => Arc::clone(hits),
            None => {
                let budget = tracing_budget(&self.formula, self.backend);
                let traced = trace(&self.scene, &self.view, &budget, &|_| {}, &AtomicBool::new(false));
                Arc::new(traced.map_err(|error| error.to_string())?)
            }
        };
        let evaluator = Evaluator::new(&self.formula, &self.scene, &hits, self.backend).map_err(|error| error.to_string())?;
        let mut frame = evaluator.frame(&self.numbers);
        let undefined = frame.clean();
        save(path, &frame, self.transfer)?;
        Ok(undefined)
    }
}
