//! Formulas as source text of other languages: C and shading languages.
//!
//! The same writer serves all of them. `dialect` has a row of spellings for each language. An operation that a language
//! does not have becomes a function that is written from its meaning in terms of primitives (`helpers`).
//!
//! The text has a function for the colour that a light adds at a hit, before ki, and one for each term of the lighting
//! equation that the formula gives for every hit. Rays, lights and sums over them stay with the renderer.

mod brdf;
mod dialect;
mod helpers;
#[cfg(feature = "gpu")]
mod kernel_text;
mod materialx;
mod names;
mod nodes;
mod osl;
mod parameters;
mod spelling;
mod walk;
mod writer;

pub use brdf::ExportError;
#[cfg(feature = "gpu")]
pub use kernel_text::{wgsl_noise, wgsl_primitive};

use crate::formula::{Formula, ParameterId, Term, TermId};
use crate::lang::ast::Relation;
use crate::lang::scalars::Primitive;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::types::Type;
use dialect::{DIALECTS, Dialect, Language, ZERO};
use helpers::helper;
use names::FreeNames;
use osl::OslFunction;
use parameters::{ParameterBlock, comment};
use std::collections::BTreeSet;
use writer::Shared;

/// A language that formulas can be written in, as an index into the table of dialects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExportTarget(usize);

impl ExportTarget {
    /// Every language.
    pub fn all() -> impl Iterator<Item = ExportTarget> {
        (0..DIALECTS.len()).map(ExportTarget)
    }

    /// Its name on the command line: `glsl`.
    pub fn name(self) -> &'static str {
        self.dialect().name
    }

    /// What it is, in a few words.
    pub fn doc(self) -> &'static str {
        self.dialect().doc
    }

    /// The language of this name.
    pub fn named(name: &str) -> Option<ExportTarget> {
        Self::all().find(|target| target.name() == name)
    }

    fn dialect(self) -> &'static Dialect {
        &DIALECTS[self.0]
    }
}

/// A function of a file: the colour that a light adds, or a term that the formula gives for every hit.
struct ExportedFunction {
    name: String,
    doc: String,
    root: TermId,
    /// The term, if it is one.
    term: Option<SurfaceTerm>,
}

/// Writes the formula in the target language. The main function is called `name`, or similarly where the language does
/// not allow that name. `origin` says in a comment where the formula comes from.
///
/// # Errors
/// The language cannot express the formula.
pub fn export(formula: &Formula, name: &str, origin: &str, target: ExportTarget) -> Result<String, ExportError> {
    let dialect = target.dialect();
    let mut names = FreeNames::new(dialect);
    let exported = exported_functions(formula, name, dialect, &mut names);
    let function = &*exported[0].name;
    let used: BTreeSet<TermId> = exported.iter().flat_map(|own| formula.terms_of(own.root)).collect();
    if let Some(Term::Material(id)) = used.iter().map(|id| formula.term(*id)).find(|term| matches!(term, Term::Material(_))) {
        return Err(ExportError::Measured(formula.material(*id).path.clone()));
    }
    let read: BTreeSet<ParameterId> = used
        .iter()
        .filter_map(|id| match formula.term(*id) {
            Term::Parameter(parameter) => Some(*parameter),
            Term::Number(_) | Term::Variable(_) | Term::Material(_) | Term::Apply(..) | Term::ByComponents(..) => None,
        })
        .collect();
    let block = names.take(&format!("{}Parameters", camel(function)));
    let members: Vec<(ParameterId, String)> = read.iter().map(|id| (*id, names.take(&formula.parameter(*id).name))).collect();
    let mut of_texture = |(id, name): &(ParameterId, String)| {
        let is_texture = formula.parameter(*id).ty == Type::Texture;
        is_texture.then(|| (name.clone(), names.take(&format!("{name}_sampler"))))
    };
    let samplers = members.iter().filter_map(&mut of_texture).collect();
    let [defaults, white] = ["defaults", "white"].map(|what| names.take(&format!("{function}_{what}")));
    let block = ParameterBlock { dialect, formula, name: block, defaults, members, samplers, white };
    let header = header(formula, function, origin, dialect);
    if dialect.language == Language::MaterialX {
        return Ok(materialx::document(&header, &block, &exported, names));
    }
    let (helpers, functions) = written_functions(&block, &exported, names, origin)?;
    let body = [helpers.join("\n"), functions.join("\n")].join("\n");
    let mut parts = prelude(dialect, &body);
    parts.push(body.trim_start().to_owned());
    if dialect.language == Language::Brdf {
        return brdf::file(&header, &block, &parts.join("\n"));
    }
    let before = [header, dialect.prologue.to_owned(), block.text()];
    Ok(before.into_iter().filter(|part| !part.is_empty()).chain(parts).collect::<Vec<_>>().join("\n"))
}

/// The functions of a file, that of light first.
fn exported_functions(formula: &Formula, name: &str, dialect: &Dialect, names: &mut FreeNames) -> Vec<ExportedFunction> {
    let function = names.take(&snake(name));
    let light = ExportedFunction { name: function.clone(), doc: COLOUR.to_owned(), root: formula.result, term: None };
    // BRDF Explorer knows light alone.
    let surface = formula.surface.iter().filter(|_| dialect.language != Language::Brdf);
    let surface = surface.map(|(term, root)| {
        let name = names.take(&format!("{function}_{}", term.name()));
        ExportedFunction { name, doc: doc_of(term), root, term: Some(term) }
    });
    std::iter::once(light).chain(surface).collect()
}

/// The texts of the functions, and of those that they call for operations.
fn written_functions(
    block: &ParameterBlock,
    exported: &[ExportedFunction],
    names: FreeNames,
    origin: &str,
) -> Result<(Vec<String>, Vec<String>), ExportError> {
    let (dialect, formula) = (block.dialect, block.formula);
    let mut shared = Shared { dialect, formula, parameters: block.readings(), block, names, helpers: BTreeSet::new() };
    let (mut functions, mut arguments) = (Vec::new(), Vec::new());
    for own in exported {
        let (text, read) = writer::function(&mut shared, &own.name, &own.doc, own.root);
        functions.push(text);
        if dialect.language == Language::Brdf {
            functions.push(brdf::entry(&own.name, &read)?);
        }
        arguments.push(read);
    }
    if dialect.language == Language::Osl {
        let called = exported.iter().zip(arguments).map(|(function, arguments)| OslFunction { function, arguments });
        let name = shared.names.take(&format!("{}_shader", exported[0].name));
        functions.push(osl::shader(&name, origin, block, &called.collect::<Vec<_>>()));
    }
    let helpers = shared.helpers.iter().map(|operation| helper(dialect, *operation)).collect();
    Ok((helpers, functions))
}

/// What functions call that the file has beside the formula.
fn prelude(dialect: &Dialect, body: &str) -> Vec<String> {
    let mut parts = Vec::new();
    if let Some(zero) = dialect.zero().filter(|_| has_word(body, ZERO)) {
        parts.push(format!("// Constant expressions must be finite, and this is none.\n{zero}"));
    }
    if has_word(body, "power") {
        parts.push(dialect.power.to_owned());
    }
    if has_word(body, dialect.primitive(Primitive::Perlin)) {
        parts.push(dialect.noise_text());
    }
    parts
}

/// Whether a text has a word outside of comments.
fn has_word(text: &str, word: &str) -> bool {
    let is_part = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.flat_map(|line| line.split(|letter: char| !is_part(letter))).any(|own| own == word)
}

const COLOUR: &str = "The colour that a light adds at a hit, linear RGB, without the intensity ki of the light.";

fn doc_of(term: SurfaceTerm) -> String {
    format!("{}.", capital(term.doc()))
}

/// What a file begins with.
fn header(formula: &Formula, function: &str, origin: &str, dialect: &Dialect) -> String {
    let mut lines = vec![
        format!("// {function}: an illumination model in {}, written by Illuminator from {}.", dialect.doc, comment(origin)),
        "// Directions have unit length; L and V point away from the surface. Colours are linear RGB.".to_owned(),
    ];
    let invariants = formula.invariants.iter().map(|invariant| {
        let names: Vec<&str> = invariant.terms.iter().map(|id| &*formula.parameter(*id).name).collect();
        let relation = match invariant.relation {
            Relation::Equal => "=",
            Relation::AtMost => "<=",
        };
        format!("// Parameters are meant to keep {} {relation} 1.", names.join(" + "))
    });
    lines.extend(invariants);
    lines.join("\n") + "\n"
}

/// `cook-torrance` as `cook_torrance`.
fn snake(name: &str) -> String {
    name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '_' }).collect()
}

/// `cook_torrance` as `CookTorrance`.
fn camel(name: &str) -> String {
    name.split('_').map(capital).collect()
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
