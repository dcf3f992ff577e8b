//! Formulas as source text of other languages: C and shading languages.
//!
//! One writer writes all of them. [`dialect`] has a row of spellings for each language. An operation that a language
//! does not have becomes a function that is written from its meaning in terms of primitives ([`helpers`]).
//!
//! The text has a function for the colour that a light adds at a hit, before ki, and one for each term of the lighting
//! equation that the formula gives for every hit. Rays, lights and sums over them stay with the renderer.

mod dialect;
mod helpers;
mod names;
mod spelling;
mod writer;

use crate::formula::{Formula, Parameter, ParameterId, Term, TermId};
use crate::lang::ast::Relation;
use crate::lang::noise::permutation;
use crate::lang::scalars::Primitive;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::types::Type;
use dialect::{DIALECTS, Declarations, Dialect, Language};
use helpers::helper;
use names::FreeNames;
use std::collections::{BTreeSet, HashMap};
use writer::Shared;

/// A language that formulas can be written in, as an index into the table of dialects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExportTarget(usize);

impl ExportTarget {
    /// Every language.
    pub fn all() -> impl Iterator<Item = ExportTarget> {
        (0..DIALECTS.len()).map(ExportTarget)
    }

    /// Its name on the command line, which is also the suffix of files: `glsl`.
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

/// The formula as a text of the target language. `name` is that of the main function, as far as the language allows it;
/// `origin` says in a comment where the formula comes from.
pub fn export(formula: &Formula, name: &str, origin: &str, target: ExportTarget) -> String {
    let dialect = target.dialect();
    let mut names = FreeNames::new(dialect);
    let function = names.take(&snake(name));
    let roots: Vec<(String, String, TermId)> = std::iter::once((function.clone(), COLOUR.to_owned(), formula.result))
        .chain(formula.surface.iter().map(|(term, root)| {
            let name = names.take(&format!("{function}_{}", term.name()));
            (name, doc_of(term), root)
        }))
        .collect();
    let used: BTreeSet<TermId> = roots.iter().flat_map(|(.., root)| formula.terms_of(*root)).collect();
    let read: BTreeSet<ParameterId> = used
        .iter()
        .filter_map(|id| match formula.term(*id) {
            Term::Parameter(parameter) => Some(*parameter),
            Term::Number(_) | Term::Variable(_) | Term::Apply(..) | Term::ByComponents(..) => None,
        })
        .collect();
    let block = names.take(&format!("{}Parameters", camel(&function)));
    let members: Vec<(ParameterId, String)> = read.iter().map(|id| (*id, names.take(&formula.parameter(*id).name))).collect();
    let block = ParameterBlock { dialect, formula, name: block, defaults: names.take(&format!("{function}_defaults")), members };
    let mut shared = Shared {
        dialect,
        formula,
        parameters: block.readings(),
        first_parameter: block.first_parameter(),
        names,
        helpers: BTreeSet::new(),
    };
    let functions: Vec<String> = roots.iter().map(|(name, doc, root)| writer::function(&mut shared, name, doc, *root)).collect();
    let helpers: Vec<String> = shared.helpers.iter().map(|operation| helper(dialect, *operation)).collect();
    let body = [helpers.join("\n"), functions.join("\n")].join("\n");
    let mut parts = vec![header(formula, &function, origin, dialect), dialect.prologue.to_owned(), block.text()];
    let calls = |function: &str| body.contains(&format!("{function}("));
    if calls("power") {
        parts.push(dialect.power.to_owned());
    }
    if calls(dialect.primitive(Primitive::Perlin)) {
        parts.push(dialect.noise.replace("@PERMUTATION@", &table()));
    }
    parts.push(body.trim_start().to_owned());
    parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("\n")
}

const COLOUR: &str = "The colour that a light adds at a hit, linear RGB, without the intensity ki of the light.";

fn doc_of(term: SurfaceTerm) -> String {
    format!("{}.", capital(term.doc()))
}

/// What a file begins with.
fn header(formula: &Formula, function: &str, origin: &str, dialect: &Dialect) -> String {
    let mut lines = vec![
        format!("// {function}: an illumination model in {}, written by Illuminator from {}.", dialect.doc, comment(origin)),
        "// Directions have unit length and point away from the surface. Colours are linear RGB.".to_owned(),
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

/// The parameters of a formula in a target language.
struct ParameterBlock<'b> {
    dialect: &'b Dialect,
    formula: &'b Formula,
    /// The name of the type or the block, and of the default values.
    name: String,
    defaults: String,
    /// The used parameters, and their names in the language.
    members: Vec<(ParameterId, String)>,
}

impl ParameterBlock<'_> {
    fn is_texture(&self, id: ParameterId) -> bool {
        self.formula.parameter(id).ty == Type::Texture
    }

    /// How each parameter is read in functions.
    fn readings(&self) -> HashMap<ParameterId, String> {
        let reading = |id: ParameterId, name: &str| match self.dialect.language {
            Language::C => format!("parameters->{name}"),
            Language::Wgsl if !self.is_texture(id) => format!("parameters.{name}"),
            Language::Glsl | Language::Hlsl | Language::Wgsl => name.to_owned(),
        };
        self.members.iter().map(|(id, name)| (*id, reading(*id, name))).collect()
    }

    /// What stands before the parameters of functions.
    fn first_parameter(&self) -> Option<String> {
        (self.dialect.language == Language::C && !self.members.is_empty()).then(|| format!("const {} *parameters", self.name))
    }

    /// The declarations.
    fn text(&self) -> String {
        let (textures, numbers): (Vec<_>, Vec<_>) = self.members.iter().partition(|(id, _)| self.is_texture(*id));
        let mut lines = Vec::new();
        let plain = |own: &Vec<&(ParameterId, String)>, end: &str| -> Vec<String> {
            own.iter().map(|(id, name)| self.member(*id, name, end)).collect()
        };
        match self.dialect.language {
            Language::C if !self.members.is_empty() => {
                lines.push(format!("typedef struct {} {{", self.name));
                lines.extend(plain(&numbers, ";"));
                lines.extend(textures.iter().map(|(id, name)| {
                    let note = note(self.formula.parameter(*id));
                    format!("    vec3 (*{name})(float u, float v); // {note}")
                }));
                lines.push(format!("}} {};\n", self.name));
                let default = |id: ParameterId, name: &str| match self.is_texture(id) {
                    true => format!("        .{name} = 0,"),
                    false => format!("        .{name} = {},", self.default(id)),
                };
                lines.push(format!("static inline {} {}(void) {{", self.name, self.defaults));
                lines.push(format!("    const {} defaults = {{", self.name));
                lines.extend(numbers.iter().chain(&textures).map(|(id, name)| default(*id, name)));
                lines.push("    };\n    return defaults;\n}\n".to_owned());
            }
            Language::Glsl if !numbers.is_empty() => {
                lines.push(format!("layout(std140, binding = 0) uniform {} {{", self.name));
                lines.extend(plain(&numbers, ";"));
                lines.push("};\n".to_owned());
            }
            Language::Hlsl if !numbers.is_empty() => {
                lines.push(format!("cbuffer {} : register(b0) {{", self.name));
                lines.extend(plain(&numbers, ";"));
                lines.push("};\n".to_owned());
            }
            Language::Wgsl if !numbers.is_empty() => {
                lines.push(format!("struct {} {{", self.name));
                lines.extend(plain(&numbers, ","));
                lines.push(format!("}}\n\n@group(0) @binding(0) var<uniform> parameters: {};\n", self.name));
            }
            Language::C | Language::Glsl | Language::Hlsl | Language::Wgsl => {}
        }
        for (index, (id, name)) in textures.iter().enumerate() {
            let note = note(self.formula.parameter(*id));
            match self.dialect.language {
                Language::Glsl => lines.push(format!("layout(binding = {}) uniform sampler2D {name}; // {note}\n", index + 1)),
                Language::Hlsl => lines.push(format!("Texture2D {name}; // {note}\nSamplerState {name}_sampler;\n")),
                Language::Wgsl => lines.push(format!(
                    "@group(0) @binding({}) var {name}: texture_2d<f32>; // {note}\n@group(0) @binding({}) var {name}_sampler: sampler;\n",
                    2 * index + 1,
                    2 * index + 2
                )),
                Language::C => {}
            }
        }
        lines.join("\n")
    }

    /// The declaration of a number or a vector.
    fn member(&self, id: ParameterId, name: &str, end: &str) -> String {
        let parameter = self.formula.parameter(id);
        let ty = self.dialect.ty(parameter.ty);
        let own = match self.dialect.declarations {
            Declarations::TypeFirst { .. } => format!("{ty} {name}"),
            Declarations::Let => format!("{name}: {ty}"),
        };
        format!("    {own}{end} // {}", note(parameter))
    }

    /// The default value.
    fn default(&self, id: ParameterId) -> String {
        let parameter = self.formula.parameter(id);
        let number = |number: f32| self.dialect.number(number);
        match parameter.ty {
            Type::Vector => format!("{{{}}}", parameter.default.map(number).join(", ")),
            Type::Scalar | Type::Truth | Type::Texture => number(parameter.default[0]),
        }
    }
}

/// What is known of a parameter: its owner, its range, its default, and what the author says of it.
fn note(parameter: &Parameter) -> String {
    let mut parts = vec![format!("{} parameter", parameter.owner.adjective())];
    if let Some([low, high]) = parameter.range.filter(|_| parameter.ty != Type::Texture) {
        parts.push(format!("{low}..{high}"));
    }
    match parameter.ty {
        Type::Vector => parts.push(format!("default <{}>", parameter.default.map(|number| number.to_string()).join(", "))),
        Type::Scalar | Type::Truth => parts.push(format!("default {}", parameter.default[0])),
        Type::Texture => parts.push("texture".to_owned()),
    }
    if !parameter.choices.is_empty() {
        let choices = parameter.choices.iter().enumerate().map(|(number, name)| format!("{number} {}", comment(name)));
        parts.push(choices.collect::<Vec<_>>().join(", "));
    }
    let doc = parameter.doc.as_ref().map(|doc| format!(": {}", comment(doc)));
    parts.join(", ") + &doc.unwrap_or_default()
}

/// Text for a comment of one line: without what ends a line in any of the languages, or continues it, such as a
/// backslash at its end or C's trigraph for it.
fn comment(text: &str) -> String {
    let is_kept = |letter: &char| !letter.is_control() && !matches!(letter, '\u{2028}' | '\u{2029}');
    let text: String = text.chars().filter(is_kept).map(|letter| if letter == '\\' { '/' } else { letter }).collect();
    text.replace("??", "? ?")
}

/// The permutation of noise, in rows.
fn table() -> String {
    let rows = permutation().chunks(16).map(|row| row.iter().map(u8::to_string).collect::<Vec<_>>().join(", "));
    rows.map(|row| format!("    {row}")).collect::<Vec<_>>().join(",\n")
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
