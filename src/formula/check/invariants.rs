//! Resolves the names of invariants, and checks whether they can hold and how they change defaults (thesis 4.2.7).

use crate::formula::check::names::{Meaning, Names};
use crate::formula::invariants::{DefaultConflict, Inconsistent, InvariantSystem, default_conflicts};
use crate::formula::{Invariant, Parameter, ParameterId};
use crate::lang::ast::{FormulaFile, Name};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::SourceSpan;
use crate::lang::types::Type;
use crate::lang::variables::Owner;

/// The valid invariants, in the order of the file, with their places.
pub(super) fn invariants(
    file: &FormulaFile,
    parameters: &[Parameter],
    names: &Names,
    diagnostics: &mut Diagnostics,
) -> Vec<(Invariant, SourceSpan)> {
    let mut list = Vec::new();
    for line in file.invariants() {
        let found: Vec<Option<ParameterId>> =
            line.terms.iter().map(|term| parameter(term, parameters, names, diagnostics)).collect();
        let Some(terms) = found.into_iter().collect::<Option<Vec<ParameterId>>>() else { continue };
        let owner = |id: ParameterId| parameters[id.0 as usize].owner;
        let other = terms.iter().position(|term| owner(*term) != owner(terms[0]));
        if let Some(other) = other {
            let [first, second] = [0, other].map(|index| (&line.terms[index], owner(terms[index]).adjective()));
            diagnostics.push(
                Diagnostic::error("an invariant joins parameters of different owners")
                    .at(second.0.span, format!("`{}` is a {} parameter", second.0.text, second.1))
                    .at(first.0.span, format!("`{}` is a {} parameter", first.0.text, first.1))
                    .help("all parameters of one invariant must stand in the same section"),
            );
            continue;
        }
        list.push((Invariant { terms, relation: line.relation }, line.span));
    }
    list
}

/// The parameter with this name, if it may take part in an invariant.
fn parameter(term: &Name, parameters: &[Parameter], names: &Names, diagnostics: &mut Diagnostics) -> Option<ParameterId> {
    let Some(Meaning::Parameter(id)) = names.meaning(&term.text) else {
        let hint = names.suggestion(
            &term.text,
            |meaning| matches!(meaning, Meaning::Parameter(id) if parameters[id.0 as usize].ty == Type::Scalar),
        );
        let what = names
            .meaning(&term.text)
            .map_or("not known".to_owned(), |meaning| format!("{}, not a parameter", meaning.describe()));
        diagnostics.push(
            Diagnostic::error(format!("`{}` in an invariant is {what}", term.text))
                .at(term.span, "expected a scalar parameter with the range 0..1")
                .help_if(hint),
        );
        return None;
    };
    let parameter = &parameters[id.0 as usize];
    let problem = match (parameter.ty, parameter.range) {
        (Type::Texture, _) => "it is a texture".to_owned(),
        (Type::Vector | Type::Truth, _) => "it is a vector".to_owned(),
        (Type::Scalar, None) => "it has no `constraint`".to_owned(),
        (Type::Scalar, Some([low, high])) if low != 0.0 || high != 1.0 => format!("its range is {low}..{high}"),
        (Type::Scalar, Some(_)) => return Some(id),
    };
    let mut diagnostic = Diagnostic::error(format!("`{}` cannot take part in an invariant: {problem}", term.text))
        .at(term.span, "expected a scalar parameter with the range 0..1");
    if let Some(span) = names.given_at(&term.text) {
        diagnostic = diagnostic.at(span, "declared here").help("declare it `scalar, constraint 0..1`");
    }
    diagnostics.push(diagnostic);
    None
}

/// The largest number of invariants of a formula. Models have two or three. The time to solve them grows faster than
/// the cube of their number.
const MOST_INVARIANTS: usize = 64;

/// Reports invariants that contradict each other, and warns about redundant ones and about defaults that they change.
pub(super) fn solve(
    file: &FormulaFile,
    parameters: &[Parameter],
    invariants: &[(Invariant, SourceSpan)],
    diagnostics: &mut Diagnostics,
) {
    let (invariants, spans): (Vec<Invariant>, Vec<SourceSpan>) = invariants.iter().cloned().unzip();
    if let Some(beyond) = spans.get(MOST_INVARIANTS) {
        diagnostics.push(
            Diagnostic::error("there are too many invariants")
                .at(*beyond, format!("more than {MOST_INVARIANTS} cannot be solved while a slider moves")),
        );
        return;
    }
    let mut contradict = false;
    for owner in Owner::ALL {
        match InvariantSystem::new(parameters, &invariants, owner) {
            Ok((_, redundant)) => {
                for index in redundant {
                    diagnostics.push(
                        Diagnostic::warning("this invariant follows from the others")
                            .at(spans[index], "says nothing new")
                            .help("leave it out"),
                    );
                }
            }
            Err(Inconsistent { invariants: circle }) => {
                contradict = true;
                let mut error =
                    Diagnostic::error("these invariants cannot hold together while every parameter stays within 0..1");
                for (number, index) in circle.iter().enumerate() {
                    error = error.at(spans[*index], if number == 0 { "no values satisfy this" } else { "together with this" });
                }
                diagnostics.push(error.help("leave one of them out, or write `<= 1` instead of `= 1`"));
            }
        }
    }
    if contradict {
        return;
    }
    for DefaultConflict { parameter: id, given, settled } in default_conflicts(parameters, &invariants) {
        let parameter = &parameters[id.0 as usize];
        let declared = file.declarations().find(|declaration| declaration.name.text == parameter.name);
        let mut terms = file.invariants().flat_map(|line| &line.terms);
        let named = terms.find(|term| term.text == parameter.name).map(|term| term.span);
        let span = declared.and_then(|declaration| declaration.attributes.default.map(|(_, span)| span)).or(named);
        let system = InvariantSystem::new(parameters, &invariants, parameter.owner).ok();
        let why = match system.and_then(|(system, _)| system.explanation(id)) {
            Some(explanation) => format!("it follows from the others: {explanation}"),
            None => "the parameters named before it leave no more".to_owned(),
        };
        let mut warning = Diagnostic::warning(format!("the default {given} of `{}` gives way to {settled}", parameter.name));
        if let Some(span) = span {
            warning = warning.at(span, why);
        }
        diagnostics.push(warning);
    }
}
