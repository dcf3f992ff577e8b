//! Names of bodies and lights from names of other programs, which may be any text.

use crate::scene::naming::{as_identifier, words};
use std::collections::{BTreeMap, BTreeSet};

/// Names that are taken. Capitals and small letters count as the same, because names of bodies become names of files.
#[derive(Default)]
pub(super) struct UniqueNames {
    taken: BTreeSet<String>,
    /// The last number that was put behind a name.
    numbers: BTreeMap<String, u64>,
}

impl UniqueNames {
    /// A name like `wanted`. If that is taken, `more` tells it apart, or else a number. `fallback` is used where
    /// nothing is left of `wanted` and `more`.
    pub(super) fn take(&mut self, wanted: &str, more: &str, fallback: &str) -> String {
        let [wanted, more] = [wanted, more].map(words);
        let first = [&wanted, &more].into_iter().find(|name| !name.is_empty()).map_or(fallback, String::as_str);
        let both = if wanted.is_empty() || more.is_empty() { None } else { Some(format!("{wanted}_{more}")) };
        let candidates = [Some(first.to_owned()), both].into_iter().flatten().map(|name| as_identifier(&name, fallback));
        let mut last = String::new();
        for name in candidates {
            if self.taken.insert(name.to_lowercase()) {
                return name;
            }
            last = name;
        }
        let number = self.numbers.entry(last.to_lowercase()).or_insert(1);
        loop {
            *number += 1;
            let name = format!("{last}_{number}");
            if self.taken.insert(name.to_lowercase()) {
                return name;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_valid_and_different() {
        let mut names = UniqueNames::default();
        let mut take = |wanted: &str, more: &str| names.take(wanted, more, "part");
        assert_eq!(take("Mesh.001", ""), "Mesh_001");
        assert_eq!(take("mesh 001", "Red glass"), "mesh_001_Red_glass");
        assert_eq!(take("mesh 001", "Red glass"), "mesh_001_Red_glass_2");
        assert_eq!(take("MESH_001", ""), "MESH_001_2", "files of this name would be one on some systems");
        assert_eq!(take("", "wood"), "wood");
        assert_eq!([take("", ""), take("   ", "!"), take("日本", "")], ["part", "part_2", "part_3"]);
        assert_eq!(take("7 wheels", ""), "part_7_wheels");
        assert_eq!(take("lights", ""), "lights_part");
        assert_eq!(take("a\"; b\n", "../x"), "a_b");
        assert_eq!(take(&"long".repeat(100), "").len(), crate::scene::naming::LONGEST);
        assert_eq!(take("_hidden_", ""), "hidden");
    }

    #[test]
    fn equal_names_are_numbered_in_time() {
        let mut names = UniqueNames::default();
        let last = (0..20_000).map(|_| names.take("x", "", "part")).last();
        assert_eq!(last.as_deref(), Some("x_20000"));
    }
}
