//! Giving a name of a text another spelling, at all its places.

use crate::assist::symbols::{Symbol, SymbolKind, symbol_at};
use crate::assist::words::{Class, Words};
use crate::formula::Formula;
use crate::lang::diagnostic::{Diagnostics, Severity};
use crate::lang::source::{Source, SourceSpan};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::token::{Token, TokenKind};
use crate::scene::Scene;
use crate::workspace::FileKind;
use std::fmt;

/// Why a name cannot be changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RenameError {
    /// The text defines no name there.
    NoName,
    /// The new name has characters that names do not have.
    NotAName(String),
    /// The new name stands in the text already, and the two would become one.
    InUse(String),
    /// A macro of this name gives a term of the lighting equation.
    Term(SurfaceTerm),
    /// The text would have an error that it does not have now.
    Mistake(String),
}

impl fmt::Display for RenameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RenameError::NoName => write!(f, "no name that this file defines stands here"),
            RenameError::NotAName(name) => {
                write!(f, "`{name}` is not a name: names have the letters A to Z and a to z, digits and `_`")
            }
            RenameError::InUse(name) => write!(f, "`{name}` has another meaning in this file"),
            RenameError::Term(term) => write!(f, "the name `{}` has a meaning: {}", term.name(), term.doc()),
            RenameError::Mistake(message) => write!(f, "{message}"),
        }
    }
}

impl std::error::Error for RenameError {}

/// The name at a byte and its place there, if the text defines one.
///
/// # Errors
/// The name has a meaning, so it cannot be changed.
pub fn renamable(kind: FileKind, source: &Source, byte: usize) -> Result<Option<(Symbol, SourceSpan)>, RenameError> {
    let found = symbol_at(kind, source, byte);
    match found.as_ref().and_then(|(symbol, _)| given_term(kind, symbol, source)) {
        Some(term) => Err(RenameError::Term(term)),
        None => Ok(found),
    }
}

/// The places where the new name must stand so that the name at a byte is changed. Before and after, the text means the
/// same.
///
/// # Errors
/// The text defines no name there, or the new name is not possible.
pub fn renamed(kind: FileKind, source: &Source, byte: usize, new: &str) -> Result<Vec<SourceSpan>, RenameError> {
    let (symbol, _) = symbol_at(kind, source, byte).ok_or(RenameError::NoName)?;
    if symbol.name == new {
        return Ok(Vec::new());
    }
    let letters = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if new.is_empty() || new.starts_with(|c: char| c.is_ascii_digit()) || !new.chars().all(letters) {
        return Err(RenameError::NotAName(new.chars().take(64).collect()));
    }
    if kind == FileKind::Formula
        && !symbol.kind.is_local()
        && let Some(term) = given_term(kind, &symbol, source).or(SurfaceTerm::named(new))
    {
        return Err(RenameError::Term(term));
    }
    let words = Words::new(kind, source.text());
    let stands = |token: &Token| {
        matches!(&token.kind, TokenKind::Word(word) if word == new) && words.class_at(token.span.range().start) != Class::Keyword
    };
    if words.tokens.iter().any(stands) {
        return Err(RenameError::InUse(new.to_owned()));
    }
    let mut text = source.text().to_owned();
    symbol.places.iter().rev().for_each(|place| text.replace_range(place.range(), new));
    let [before, after] = [source.text(), text.as_str()].map(|text| errors(kind, &Source::new(source.name(), text)));
    match after.iter().find(|message| !before.contains(message)) {
        Some(message) if after.len() > before.len() => Err(RenameError::Mistake(message.clone())),
        Some(_) | None => Ok(symbol.places),
    }
}

/// The term of the lighting equation that a macro gives. One that the formula itself reads gives none. A text with
/// errors does not tell, so there the name decides.
fn given_term(kind: FileKind, symbol: &Symbol, source: &Source) -> Option<SurfaceTerm> {
    let gives = |term: &SurfaceTerm| Formula::parse(source).map_or(true, |(formula, _)| formula.surface.get(*term).is_some());
    let is_macro = kind == FileKind::Formula && symbol.kind == SymbolKind::Macro;
    SurfaceTerm::named(&symbol.name).filter(|_| is_macro).filter(gives)
}

/// The messages of the errors of a text.
fn errors(kind: FileKind, source: &Source) -> Vec<String> {
    let diagnostics = match kind {
        FileKind::Formula => Formula::parse(source).err(),
        FileKind::Scene => Scene::parse(source).err(),
        FileKind::Session | FileKind::Material => None,
    };
    let messages = |all: Diagnostics| -> Vec<String> {
        let errors = all.iter().filter(|diagnostic| diagnostic.severity() == Severity::Error);
        errors.map(|diagnostic| diagnostic.message().to_owned()).collect()
    };
    diagnostics.map_or_else(Vec::new, messages)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "body_specific;\nkd: scalar;\nks: scalar, slider;\nformula;\nF(x) = x*kd*ks;\nemission = kd*Cd;\n= IL*F(1)*Cd;";

    /// The text with the name that begins where `at` does changed.
    fn outcome(at: &str, new: &str) -> Result<String, RenameError> {
        let byte = TEXT.find(at).unwrap();
        let places = renamed(FileKind::Formula, &Source::new("t", TEXT), byte, new)?;
        let mut text = TEXT.to_owned();
        places.iter().rev().for_each(|place| text.replace_range(place.range(), new));
        Ok(text)
    }

    #[test]
    fn all_places_change_and_nothing_else() {
        assert_eq!(outcome("kd*ks", "diffuse"), Ok(TEXT.replace("kd", "diffuse")));
        assert_eq!(outcome("F(1)", "G"), Ok(TEXT.replace("F(", "G(")));
        assert_eq!(outcome("x*kd", "cosine"), Ok(TEXT.replace("F(x) = x*", "F(cosine) = cosine*")));
        assert_eq!(outcome("ks:", "slider"), Ok(TEXT.replace("ks", "slider")), "keywords are no names");
        assert_eq!(outcome("kd", "kd"), Ok(TEXT.to_owned()));
    }

    #[test]
    fn an_ordinary_macro_with_the_name_of_a_term_changes() {
        let text = "formula;\nreflected = N.L;\n= reflected*Cd;";
        let places = renamed(FileKind::Formula, &Source::new("t", text), 10, "cosine").unwrap();
        assert_eq!(places.len(), 2);
        let text = text.replace("reflected*", "");
        assert!(matches!(renamed(FileKind::Formula, &Source::new("t", text), 10, "cosine"), Err(RenameError::Term(_))));
    }

    #[test]
    fn names_that_are_taken_are_refused() {
        let message = |at: &str, new: &str| outcome(at, new).unwrap_err().to_string();
        assert_eq!(message("kd", "ks"), "`ks` has another meaning in this file");
        assert_eq!(message("x*kd", "kd"), "`kd` has another meaning in this file");
        assert_eq!(message("kd", "IL"), "`IL` has another meaning in this file");
        assert_eq!(message("kd", "kr"), "`kr` is already the predefined parameter: weight of the reflected ray");
        assert_eq!(message("kd", "k d"), "`k d` is not a name: names have the letters A to Z and a to z, digits and `_`");
        assert_eq!(message("kd", ""), "`` is not a name: names have the letters A to Z and a to z, digits and `_`");
        assert_eq!(
            message("emission", "glow"),
            "the name `emission` has a meaning: light that a hit sends out by itself, a colour, added to the ambient light"
        );
        assert_eq!(
            message("kd", "ambient"),
            "the name `ambient` has a meaning: ambient light at a hit, a colour, in place of ka*Cd*Ia"
        );
        assert_eq!(message("Cd;", "colour"), "no name that this file defines stands here");
    }
}
