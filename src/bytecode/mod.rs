//! The reference interpreter: the scheme of the thesis (5.4), kept as the standard of meaning and of speed.
//!
//! 1. [`compile`] turns a formula into postfix code of *type I*, with symbols for variables and parameters.
//! 2. [`program`] instantiates it for every pixel, once for each hit of the ray tree and each light that reaches it: code of *type II*,
//!    with numbers for variables and references for parameters. Equation (2) of the thesis joins the instances into one program.
//! 3. [`machine`] runs the program on a stack.
//!
//! It computes with the standard library's mathematics and shares nothing with compiled code but the table of operations, so that
//! each checks the other.

pub mod compile;
pub mod instruction;
pub mod machine;
pub mod program;

pub use compile::{Code, CodeTooLarge};
pub use instruction::Instruction;
pub use program::{Program, Programs};
