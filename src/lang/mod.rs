//! The formula language: its text, its syntax, and the tables that define it.
//!
//! In the order of the way from text to syntax: [`source`] and [`diagnostic`] (what is read, what is said about it), [`token`] and
//! [`lexer`] (words, shared with the scene language), [`cursor`] and [`parser`] (grammar), [`ast`] (syntax) and [`printer`] (syntax as text
//! again). The tables: [`scalars`] (scalar primitives and their meaning), [`builtins`] (operators and functions in terms of
//! them), [`variables`] (variables and predefined parameters), [`keywords`] (the other words), printed by [`reference`](mod@reference). Whose a name is and whether types fit is the
//! [formula](crate::formula)'s business.

pub mod ast;
pub mod builtins;
pub mod cursor;
pub mod diagnostic;
pub mod keywords;
pub mod lexer;
pub mod noise;
mod parse_expression;
pub mod parser;
pub mod printer;
pub mod reference;
mod render;
pub mod scalars;
pub mod source;
pub mod token;
pub mod types;
pub mod variables;
