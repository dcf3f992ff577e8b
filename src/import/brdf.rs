//! Formulas from files of BRDF Explorer (Walt Disney Animation Studios): parameters, and a function in GLSL.
//!
//! A model there is a bidirectional reflectance distribution function. A formula gives the light that leaves a hit: the
//! function times π, times the cosine of the angle between normal and light, times the colour of the light.

mod builtins;
mod file;
mod glsl;
mod names;
mod parameters;
mod parser;
mod tokens;
mod translation;
mod written;

use crate::lang::diagnostic::Diagnostics;
use crate::lang::display_text::one_line;
use crate::lang::format::formatted;
use crate::lang::source::Source;
use names::FormulaNames;
use parameters::BrdfDeclaration;
use std::collections::HashSet;
use translation::Translation;

/// A translated file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BrdfFormula {
    /// The text of the formula.
    pub text: String,
    /// The number of its parameters.
    pub parameters: usize,
    /// What is not quite as in the file: warnings, with places in it.
    pub remarks: Diagnostics,
}

/// Translates a file of BRDF Explorer.
///
/// # Errors
/// What cannot be translated, with places in the file.
pub fn formula_of_brdf(source: &Source) -> Result<BrdfFormula, Diagnostics> {
    let name = source.name().rsplit(['/', '\\']).next().unwrap_or_default();
    let mut diagnostics = Diagnostics::new();
    let Some(file) = file::file(source, &mut diagnostics) else { return Err(diagnostics) };
    let words = tokens::tokens(source.text(), file.shader.clone(), &mut diagnostics);
    let shader = parser::parse(words, file.shader.end, &mut diagnostics);
    let mut names = FormulaNames::new();
    let declared: Vec<BrdfDeclaration> =
        file.parameters.iter().map(|parameter| BrdfDeclaration::new(parameter, &mut names, &mut diagnostics)).collect();
    if diagnostics.has_errors() {
        return Err(diagnostics);
    }
    let values = declared.iter().map(|own| (own.parameter.name.clone(), own.value())).collect();
    let mut translation = Translation::new(&shader, names, values);
    let model = translation.model(file.shader.end);
    diagnostics.extend(translation.diagnostics);
    diagnostics.sort();
    let Some(model) = model else { return Err(diagnostics) };
    let mut text = format!("// From `{}` of BRDF Explorer.\n{}\nformula;\n", one_line(name), parameters::sections(&declared));
    for (head, expression) in needed(&translation.definitions, &model.text) {
        text += &format!("{head} = {expression};\n");
    }
    let light = if file.is_export || declared.iter().any(BrdfDeclaration::is_light_colour) { "" } else { "IL*" };
    text += &format!("\n= {light}pi*max(0, dot(N, L))*{};\n", model.text);
    let text = formatted(&Source::new(source.name(), text.clone())).unwrap_or(text);
    Ok(BrdfFormula { text, parameters: declared.len(), remarks: diagnostics })
}

/// The definitions that an expression needs, in their order.
fn needed<'d>(definitions: &'d [(String, String)], result: &str) -> Vec<&'d (String, String)> {
    let mut names: HashSet<&str> = words(result).collect();
    let mut kept = Vec::new();
    // Definitions use earlier ones alone.
    for definition in definitions.iter().rev() {
        let (head, expression) = definition;
        let name = head.split('(').next().unwrap_or_default();
        if names.contains(name) {
            names.extend(words(expression));
            kept.push(definition);
        }
    }
    kept.reverse();
    kept
}

/// The names in a text.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| !(letter.is_ascii_alphanumeric() || letter == '_')).filter(|word| !word.is_empty())
}
