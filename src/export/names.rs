//! Names that are free in a target language.

use crate::export::dialect::{Dialect, PRELUDE};
use crate::export::helpers::helper_name;
use crate::lang::builtins::Operation;
use std::collections::{HashMap, HashSet};

/// The names of a file in a target language. Each is given once.
pub(super) struct FreeNames {
    taken: HashSet<String>,
    /// The number that the next name with this beginning tries first.
    next: HashMap<String, usize>,
}

impl FreeNames {
    /// All names but those that mean something in the language.
    pub(super) fn new(dialect: &Dialect) -> Self {
        let functions = dialect.natives.iter().map(|(_, name)| *name).chain(dialect.primitives.iter().map(|(_, name)| *name));
        let words = dialect.reserved.split_whitespace().chain(PRELUDE).chain(functions);
        let helpers = Operation::ALL.iter().map(|operation| helper_name(*operation));
        Self { taken: words.map(str::to_owned).chain(helpers).collect(), next: HashMap::new() }
    }

    /// The name itself if it is free, or with the first number that makes it free. Characters that no identifier may
    /// have become underscores. Languages reserve names that begin with an underscore or have two.
    pub(super) fn take(&mut self, wanted: &str) -> String {
        let mut name: String = wanted.chars().map(|own| if own.is_ascii_alphanumeric() { own } else { '_' }).collect();
        while name.contains("__") {
            name = name.replace("__", "_");
        }
        let name = name.trim_matches('_');
        let name = if name.is_empty() || name.starts_with("gl_") || name.starts_with(|first: char| first.is_ascii_digit()) {
            format!("f_{name}").trim_end_matches('_').to_owned()
        } else {
            name.to_owned()
        };
        if self.taken.insert(name.clone()) {
            return name;
        }
        let next = self.next.entry(name.clone()).or_insert(2);
        loop {
            let numbered = format!("{name}_{next}");
            *next += 1;
            if self.taken.insert(numbered.clone()) {
                return numbered;
            }
        }
    }

    /// The same names, for a function of its own.
    pub(super) fn inside(&self) -> Self {
        Self { taken: self.taken.clone(), next: self.next.clone() }
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
        assert_eq!(["op_erf", "gl_x", "kd_2", "kd"].map(|name| names.take(name)), ["op_erf_2", "f_gl_x", "kd_2_2", "kd_3"]);
    }
}
