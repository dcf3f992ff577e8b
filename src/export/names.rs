//! Names that are free in a target language.

use crate::export::dialect::{Dialect, PRELUDE};
use std::collections::HashSet;

/// The names of a file in a target language. Each is given once.
pub(super) struct FreeNames {
    taken: HashSet<String>,
}

impl FreeNames {
    /// All names but those that mean something in the language.
    pub(super) fn new(dialect: &Dialect) -> Self {
        let functions = dialect.natives.iter().map(|(_, name)| *name).chain(dialect.primitives.iter().map(|(_, name)| *name));
        let words = dialect.reserved.split_whitespace().chain(PRELUDE).chain(functions);
        Self { taken: words.map(str::to_owned).collect() }
    }

    /// The name itself if it is free, or with the first number that makes it free. Characters that no identifier may
    /// have become underscores. Languages reserve names that begin with an underscore or have two.
    pub(super) fn take(&mut self, wanted: &str) -> String {
        let mut name: String = wanted.chars().map(|own| if own.is_ascii_alphanumeric() { own } else { '_' }).collect();
        while name.contains("__") {
            name = name.replace("__", "_");
        }
        let name = name.trim_matches('_');
        let name = if name.is_empty() || name.starts_with(|first: char| first.is_ascii_digit()) {
            format!("f_{name}").trim_end_matches('_').to_owned()
        } else {
            name.to_owned()
        };
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let free = std::iter::once(name.clone()).chain(numbered).find(|name| !self.taken.contains(name));
        let free = free.unwrap_or(name);
        self.taken.insert(free.clone());
        free
    }

    /// The same names, for a function of its own.
    pub(super) fn inside(&self) -> Self {
        Self { taken: self.taken.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::dialect::DIALECTS;

    #[test]
    fn names_are_identifiers_and_free() {
        let mut names = FreeNames::new(&DIALECTS[0]);
        let taken = ["kd", "kd", "float", "double", "a__b", "_x", "7up", "é", "sqrtf"].map(|name| names.take(name));
        assert_eq!(taken, ["kd", "kd_2", "float_2", "double_2", "a_b", "x", "f_7up", "f", "sqrtf_2"]);
        assert_eq!(names.inside().take("kd"), "kd_3");
    }
}
