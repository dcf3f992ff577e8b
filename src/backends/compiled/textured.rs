//! Formulas that look up textures at static coordinates. The colours lie in columns, so a picture with other textures
//! needs other columns.

use crate::backends::compiled::Compiled;
use crate::evaluate::{Drag, DragBeginning, Drawn, EvaluateError, Evaluator, Framebuffer, WholeFrames};
use crate::formula::Formula;
use crate::jit::CompiledFormula;
use crate::picture::Frame;
use crate::plan::Method;
use crate::trace::{Hits, Mismatch};
use std::ops::Range;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

/// An evaluator that computes all static values again when a texture is replaced.
pub(super) struct Textured {
    kernels: Arc<CompiledFormula>,
    formula: Arc<Formula>,
    /// Those of each pass, at least one.
    hits: Vec<Arc<Hits>>,
    /// The evaluator for the textures of the last picture. `None` while another one is made.
    last: Mutex<Option<Arc<Compiled>>>,
}

impl Textured {
    /// Goes on from an evaluator for these hits.
    pub(super) fn new(hits: Vec<Arc<Hits>>, first: Compiled) -> Self {
        let (kernels, formula) = (Arc::clone(&first.compiled), Arc::clone(&first.formula));
        Self { kernels, formula, hits, last: Mutex::new(Some(Arc::new(first))) }
    }

    /// The evaluator for the textures among these parameter numbers.
    ///
    /// # Errors
    /// [`Compiled::new`] fails. It does not: it has read the same hits before.
    fn with(&self, parameters: &[f32]) -> Result<Arc<Compiled>, Mismatch> {
        let last = || self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = last().as_ref().filter(|known| known.textures.are_in(parameters)) {
            return Ok(Arc::clone(known));
        }
        // The columns of the last textures are given up first, unless a drag holds them. The lock is not held
        // meanwhile.
        drop(last().take());
        let made = Arc::new(Compiled::new(Arc::clone(&self.kernels), &self.formula, &self.hits, parameters)?);
        *last() = Some(Arc::clone(&made));
        Ok(made)
    }
}

impl Evaluator for Textured {
    fn passes(&self) -> usize {
        self.hits.len()
    }

    fn with_pass(&self, hits: &Arc<Hits>) -> Result<Arc<dyn Evaluator>, EvaluateError> {
        let all: Vec<Arc<Hits>> = self.hits.iter().chain([hits]).cloned().collect();
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Ok(match last {
            Some(last) => Arc::new(Self::new(all, last.with_one_more(hits)?)),
            // Another one is being made. Its textures come with the next picture.
            None => {
                let (kernels, formula) = (Arc::clone(&self.kernels), Arc::clone(&self.formula));
                Arc::new(Self { kernels, formula, hits: all, last: Mutex::default() })
            }
        })
    }

    fn sum(&self, passes: Range<usize>, parameters: &[f32], cancelled: &AtomicBool) -> Option<Frame> {
        let view = self.hits[0].view;
        self.with(parameters).map_or_else(
            |_| Some(Frame::black(view.width(), view.height())),
            |compiled| compiled.sum(passes, parameters, cancelled),
        )
    }

    fn draw(&self, parameters: &[f32], framebuffer: &mut Framebuffer) -> Drawn {
        // Looking textures up counts.
        Drawn::timed(|| {
            if let Ok(compiled) = self.with(parameters) {
                compiled.draw(parameters, framebuffer);
            }
        })
    }

    fn drag(
        self: Arc<Self>,
        moved: &[usize],
        parameters: &[f32],
        budget: usize,
        beginning: Option<&DragBeginning>,
    ) -> Result<Box<dyn Drag>, EvaluateError> {
        let compiled = self.with(parameters)?;
        if moved.iter().any(|index| compiled.textures.has(*index)) {
            let pixels = self.hits[0].view.pixels() as usize;
            return Ok(Box::new(WholeFrames::new(self, pixels, parameters, beginning)));
        }
        let own = Arc::clone(&compiled).drag(moved, parameters, budget, beginning)?;
        Ok(Box::new(TexturedDrag { evaluator: self, compiled, own, moved: moved.to_vec(), budget }))
    }

    fn bytes(&self) -> usize {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.as_ref().map_or(0, |compiled| compiled.bytes())
    }
}

/// A drag that begins again when a texture is replaced.
struct TexturedDrag {
    evaluator: Arc<Textured>,
    compiled: Arc<Compiled>,
    own: Box<dyn Drag>,
    moved: Vec<usize>,
    budget: usize,
}

impl Drag for TexturedDrag {
    fn method(&self) -> Method {
        self.own.method()
    }

    fn frame(&mut self, parameters: &[f32], framebuffer: &mut Framebuffer) {
        if !self.compiled.textures.are_in(parameters)
            && let Ok(compiled) = self.evaluator.with(parameters)
            && let Ok(own) = Arc::clone(&compiled).drag(&self.moved, parameters, self.budget, None)
        {
            self.own = own;
            self.compiled = compiled;
        }
        self.own.frame(parameters, framebuffer);
    }

    fn is_of_all_passes(&self) -> bool {
        self.own.is_of_all_passes()
    }

    fn linear(&self, parameters: &[f32]) -> Option<Frame> {
        self.compiled.textures.are_in(parameters).then(|| self.own.linear(parameters)).flatten()
    }

    fn prepare(&mut self) -> bool {
        self.own.prepare()
    }

    fn is_ready(&self) -> bool {
        self.own.is_ready()
    }

    fn bytes(&self) -> usize {
        self.own.bytes()
    }

    fn pixels(&self) -> usize {
        self.own.pixels()
    }
}
