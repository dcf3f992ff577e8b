//! What editors show about a text while it is written: classes of words, completions, meanings, names and their uses.
//!
//! The window and the language server build on it. Everything works on texts with mistakes. No widgets and no protocol
//! are known here.

pub mod completion;
pub mod meaning;
pub mod rename;
pub mod symbols;
pub mod words;
