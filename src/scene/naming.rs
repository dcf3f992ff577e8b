//! Names that the languages allow, from any text, such as the name of a file.

use crate::lang::variables::RESERVED;

/// The longest name that is made, in characters, but for a number at its end.
pub(crate) const LONGEST: usize = 48;

/// The letters, digits and `_` of a name; what is between them becomes one `_`.
pub(crate) fn words(name: &str) -> String {
    let is_kept = |character: char| character.is_ascii_alphanumeric();
    let words = name.split(|character| !is_kept(character)).filter(|word| !word.is_empty());
    let joined = words.collect::<Vec<_>>().join("_");
    // It is ASCII.
    joined[..joined.len().min(LONGEST)].trim_end_matches('_').to_owned()
}

/// A name that the languages allow.
pub(crate) fn as_identifier(name: &str, fallback: &str) -> String {
    if name.starts_with(|first: char| first.is_ascii_digit()) {
        format!("{fallback}_{name}")
    } else if RESERVED.contains(&name) {
        format!("{name}_{fallback}")
    } else {
        name.to_owned()
    }
}
