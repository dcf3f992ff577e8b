//! Warns about macros and functions that nothing reads. Most often the name of a term of the lighting equation is
//! misspelt, as in `reflectd = …;`, and the picture would not show what the author means.

use crate::formula::check::names::{Meaning, Names};
use crate::lang::ast::{Definition, FormulaFile};
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::foreign;
use crate::lang::surface_terms::SurfaceTerm;
use std::collections::HashSet;

/// Warns about each definition that is named nowhere and gives no term of the lighting equation.
pub(super) fn warn(file: &FormulaFile, names: &Names, diagnostics: &mut Diagnostics) {
    let named: HashSet<&str> = file.expressions.iter().filter_map(|expression| expression.kind.name()).collect();
    for definition in &file.definitions {
        let name = definition.name.text.as_str();
        // A name that is taken already has been reported.
        let is_definition = matches!(names.meaning(name), Some(Meaning::Macro(_) | Meaning::Function(_)));
        if is_definition && !named.contains(name) && SurfaceTerm::named(name).is_none() {
            diagnostics.push(warning(definition));
        }
    }
}

fn warning(definition: &Definition) -> Diagnostic {
    let name = definition.name.text.as_str();
    let near = nearest(name, SurfaceTerm::ALL.iter().map(|term| term.name()));
    let meant = near.and_then(SurfaceTerm::named).or_else(|| foreign::surface_term(name));
    let help = match meant {
        Some(term) => format!("did you mean `{}`, the {}?", term.name(), term.doc()),
        None => "read it in the result, or leave it out".to_owned(),
    };
    let kind = if definition.arguments.is_some() { "function" } else { "macro" };
    Diagnostic::warning(format!("the {kind} `{name}` is never used")).at(definition.name.span, "nothing reads it").help(help)
}
