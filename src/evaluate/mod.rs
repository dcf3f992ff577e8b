//! Hits and parameter values into pictures: which kernel runs over which records, and how contributions add up to pixels.
//!
//! A pixel is a flat sum over ray paths (equation (2) of the thesis multiplied out, see [`Tile`](crate::trace::Tile)). The compiled
//! backend keeps the static values of every record in columns (`columns`) and, each frame, runs the contribution kernel
//! over the groups whose path weight is not 0 (`compiled`; in which order, `program` keeps from frame to frame). The interpreter backend writes each pixel's program and runs it
//! (`interpreted`). [`inspect`] tells how one pixel comes about. All take parameter numbers as one array in the order of [`Layout`](crate::formula::layout::Layout).

mod columns;
mod compiled;
mod drag;
mod frame;
mod framebuffer;
pub mod inspect;
mod interpreted;
mod memory;
mod pass;
mod planes;
mod program;
pub mod verify;

pub use compiled::Compiled;
pub use drag::{Drag, Method};
pub use frame::Frame;
pub use framebuffer::Framebuffer;
pub use interpreted::{Interpreted, Timing};

use crate::bytecode::CodeTooLarge;
use crate::formula::Formula;
use crate::formula::binding::Bindings;
use crate::jit::{CompileError, CompiledFormula};
use crate::scene::Scene;
use crate::trace::{Budget, Hits, Mismatch};
use std::sync::Arc;
use thiserror::Error;

/// How formulas are evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backend {
    /// By compiled code.
    #[default]
    Jit,
    /// By the reference interpreter.
    Interpreter,
}

/// Why a formula cannot be evaluated on a scene.
#[derive(Debug, Error)]
pub enum EvaluateError {
    /// There is no compiled code.
    #[error(transparent)]
    Compile(#[from] CompileError),
    /// There is no bytecode.
    #[error(transparent)]
    Code(#[from] CodeTooLarge),
    /// The hits belong to another scene; an error of the caller.
    #[error(transparent)]
    Hits(#[from] Mismatch),
}

/// A formula on a traced scene, ready to make pictures of parameter values.
pub enum Evaluator {
    /// By compiled code.
    Compiled(Compiled),
    /// By the reference interpreter.
    Interpreted(Interpreted),
}

impl Evaluator {
    /// Makes a formula ready on a traced scene: compiles it and works out the static values of all hits, or writes its bytecode.
    ///
    /// # Errors
    /// The backend cannot take the formula, or `hits` are not of this scene.
    pub fn new(formula: &Arc<Formula>, scene: &Arc<Scene>, hits: &Arc<Hits>, backend: Backend) -> Result<Self, EvaluateError> {
        Ok(match backend {
            Backend::Jit => {
                let compiled = Arc::new(CompiledFormula::new(formula)?);
                Evaluator::Compiled(Compiled::new(compiled, formula, scene, hits)?)
            }
            Backend::Interpreter => Evaluator::Interpreted(Interpreted::new(formula, scene, hits.view)?),
        })
    }

    /// The picture that these parameter numbers give, unclamped and linear. Each lies within the range of its parameter, where that has
    /// one, and none is NaN or infinite, as [`Parameter::clamp`](crate::formula::Parameter::clamp) leaves them: compiled code relies on
    /// that, and beyond it the picture may be another than the formula's.
    ///
    /// # Panics
    /// Where there are fewer numbers than the [`Layout`](crate::formula::layout::Layout) of formula and scene has.
    pub fn frame(&self, memory: &[f32]) -> Frame {
        match self {
            Evaluator::Compiled(compiled) => compiled.frame(memory),
            Evaluator::Interpreted(interpreted) => interpreted.frame(memory).0,
        }
    }
}

/// A memory budget for tracing that leaves room for what the compiled backend keeps of each hit and record of this formula.
pub fn budget(bytes: u64, bindings: &Bindings) -> Budget {
    let number = size_of::<f32>() as u64;
    Budget {
        bytes,
        bytes_per_hit: number * bindings.frontier.hits.len() as u64,
        bytes_per_record: number * bindings.frontier.records.len() as u64,
        bytes_per_pixel: 3 * number,
    }
}
