//! The reference interpreter: the scheme of the thesis (5.4), kept as the yardstick of meaning and of speed.
//!
//! A formula becomes postfix code of *type I*, with symbols for variables and parameters ([`compile`]). For every pixel it is
//! instantiated, once for each hit of the ray tree and each light that reaches it, to code of *type II*, with numbers for variables and
//! references for parameters, and joined by equation (2) of the thesis into one program ([`program`]), which a stack machine runs
//! ([`machine`]). It computes with the standard library's mathematics and shares nothing with the compiled code but the table
//! of operations, so that either checks the other.

pub mod compile;
pub mod instruction;
pub mod machine;
pub mod program;

pub use compile::{Code, CodeTooLarge};
pub use instruction::Instruction;
pub use program::{Program, Programs};
