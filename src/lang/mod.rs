//! The formula language: its text, its syntax, and the tables that define it.
//!
//! On the way from text to syntax:
//!
//! 1. [`lines`], [`span`] and [`source`]: texts and places in them.
//! 2. [`diagnostic`]: what is said about a text. [`display_text`], [`excerpt`] and [`located`]: how it may be shown.
//! 3. [`token`] and [`lexer`]: words, shared with the scene language.
//! 4. [`cursor`] and [`parser`]: grammar.
//! 5. [`ast`] and [`printer`]: syntax, and syntax as text again. [`format`](mod@format) gives a text a regular layout.
//!
//! The tables are [`scalars`] (scalar primitives and their meaning), [`builtins`] (operators and functions in terms of
//! them), [`variables`] (variables and predefined parameters), [`surface_terms`] (terms of the lighting equation that
//! macros give) and [`keywords`] (the other words). [`foreign`] and [`colour`] have what other languages
//! write in another way. [`reference`](mod@reference) prints them.
//!
//! What a name stands for and whether types fit is decided in [`formula`](crate::formula).

pub mod ast;
pub mod builtins;
pub mod colour;
pub mod comments;
pub mod cursor;
pub mod diagnostic;
pub mod display_text;
pub mod excerpt;
pub mod foreign;
pub mod format;
pub mod interval;
pub mod keywords;
pub mod lexer;
pub mod lines;
pub mod located;
pub mod memory_size;
pub mod noise;
mod parse_expression;
mod parse_foreign;
mod parse_formula;
mod parse_parameters;
pub mod parser;
pub mod printer;
pub mod reference;
pub mod scalars;
pub mod source;
pub mod span;
pub mod surface_terms;
pub mod token;
pub mod types;
pub mod variables;
