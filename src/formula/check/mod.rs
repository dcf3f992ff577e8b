//! Checks the syntax tree and makes a [`Formula`]: the meaning of names, the types of expressions, parameters and
//! invariants.
//!
//! All mistakes are reported together. An expression with a mistake has no type, and expressions that use it are not
//! reported.

mod definitions;
mod expressions;
mod grouping;
mod invariants;
mod leaves;
mod lookups;
mod mismatch;
mod names;
mod parameters;
mod resolve;
mod substitution;
mod surface;
mod terms;
#[cfg(test)]
mod tests;
mod unused;

use crate::formula::Formula;
use crate::lang::diagnostic::Diagnostics;
use crate::lang::parser;
use crate::lang::source::Source;

impl Formula {
    /// Parses and checks a formula file. Returns the formula and the warnings.
    ///
    /// # Errors
    /// All errors and warnings of the text.
    pub fn parse(source: &Source) -> Result<(Formula, Diagnostics), Diagnostics> {
        check(source, Substitution::Values)
    }

    /// The same, with a warning for each macro that would give another value if it stood for its text, as in the
    /// program of the thesis (9.2.5).
    ///
    /// # Errors
    /// All errors and warnings of the text.
    pub fn parse_as_thesis(source: &Source) -> Result<(Formula, Diagnostics), Diagnostics> {
        check(source, Substitution::WarnOfTexts)
    }
}

/// Whether macros that could be meant as texts are reported.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Substitution {
    Values,
    WarnOfTexts,
}

fn check(source: &Source, substitution: Substitution) -> Result<(Formula, Diagnostics), Diagnostics> {
    let (file, mut diagnostics) = parser::parse(source);
    let parameters = parameters::parameters(&file, &mut diagnostics);
    let names = names::Names::collect(&file, &parameters, &mut diagnostics);
    let invariants = invariants::invariants(&file, &parameters, &names, &mut diagnostics);
    invariants::solve(&file, &parameters, &invariants, &mut diagnostics);
    resolve::check(&file, &parameters, &names, &mut diagnostics);
    let expressions = expressions::check(&file, source, &parameters, &names, &mut diagnostics);
    grouping::warn(&file, source, &expressions, &mut diagnostics);
    if substitution == Substitution::WarnOfTexts {
        substitution::warn(&file, &names, &expressions, &mut diagnostics);
    }
    let surface = surface::surface_terms(&file, &parameters, &names, &expressions, &mut diagnostics);
    // What reads a macro may be part of a mistake.
    if !diagnostics.has_errors() {
        unused::warn(&file, &names, &mut diagnostics);
    }
    let formula = expressions.result.map(|result| Formula {
        surface,
        uses: file.uses.as_ref().map(|(path, _)| path.clone()),
        parameters,
        invariants: invariants.into_iter().map(|(invariant, _)| invariant).collect(),
        macros: expressions.macros,
        materials: expressions.materials,
        terms: expressions.terms,
        result,
        written: expressions.written,
    });
    diagnostics.sort();
    match formula {
        Some(formula) if !diagnostics.has_errors() => Ok((formula, diagnostics)),
        _ => Err(diagnostics),
    }
}
