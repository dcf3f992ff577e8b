//! The backends: the ways in which formulas are evaluated, chosen by name.
//!
//! - [`interpreter`]: the reference, postfix code on a stack machine;
//! - [`compiled`]: machine code over static columns.
//!
//! [`verify`] holds an evaluator against the reference. What a backend must do is in [`evaluate`](crate::evaluate).

pub mod compiled;
pub mod interpreter;
pub mod verify;

use crate::bytecode::CodeTooLarge;
use crate::evaluate::{Backend, EvaluateError};
use crate::jit::CompileError;
use std::sync::Arc;

impl From<CompileError> for EvaluateError {
    fn from(error: CompileError) -> Self {
        Self::Backend(error.to_string())
    }
}

impl From<CodeTooLarge> for EvaluateError {
    fn from(error: CodeTooLarge) -> Self {
        Self::Backend(error.to_string())
    }
}

/// A backend that can be chosen.
#[derive(Clone, Copy)]
pub struct BackendChoice {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its name in menus.
    pub title: &'static str,
    make: fn() -> Arc<dyn Backend>,
}

impl BackendChoice {
    /// A new one, with nothing compiled yet.
    pub fn make(&self) -> Arc<dyn Backend> {
        (self.make)()
    }
}

impl PartialEq for BackendChoice {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl std::fmt::Debug for BackendChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BackendChoice({})", self.name)
    }
}

/// The default: compiled code.
pub const DEFAULT: BackendChoice =
    BackendChoice { name: compiled::NAME, title: "Compiled code", make: || Arc::new(compiled::Jit::default()) };

/// The reference that defines what a formula means.
pub const REFERENCE: BackendChoice =
    BackendChoice { name: interpreter::NAME, title: "Reference interpreter", make: || Arc::new(interpreter::Interpreter) };

/// Every backend.
pub const CHOICES: [BackendChoice; 2] = [DEFAULT, REFERENCE];

/// The backend of this name.
pub fn named(name: &str) -> Option<&'static BackendChoice> {
    CHOICES.iter().find(|choice| choice.name == name)
}
