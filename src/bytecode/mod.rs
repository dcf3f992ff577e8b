//! The reference interpreter: the method of the thesis (5.4). It defines what formulas mean, and is the baseline of
//! speed.
//!
//! 1. [`compile`] turns a formula into postfix code of *type I*, with symbols for variables and parameters.
//! 2. [`program`] instantiates it for every pixel, once for each hit of the ray tree and each light that it is
//!    evaluated for: code of *type II*, with numbers for variables and references for parameters. Equation (2) of the
//!    thesis joins the instances into one program.
//! 3. [`machine`] runs the program on a stack.
//!
//! Unlike the thesis's code, it computes a macro once in an instance and keeps the value in a slot beside the stack. A
//! guard skips whole instances, so no instance loads what another one stored.
//!
//! It uses the mathematical functions of the standard library. It shares only the table of operations with compiled
//! code, so that each checks the other.

pub mod compile;
pub mod instruction;
pub mod machine;
pub mod program;

pub use compile::{Code, CodeTooLarge, FormulaCode};
pub use instruction::Instruction;
pub use program::{Program, Programs};
