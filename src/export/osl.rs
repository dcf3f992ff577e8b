//! Open Shading Language: a shader that calls the functions of a formula.
//!
//! Renderers make pictures of closures, and none of these is a formula. So the shader evaluates the formula for one
//! light, whose place is a parameter, and gives colours: for emission, for masks, and for mixing closures.

use crate::export::ExportedFunction;
use crate::export::names::FreeNames;
use crate::export::parameters::{ParameterBlock, comment, meaning};
use crate::formula::{Formula, Parameter, Term};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::types::Type;
use crate::lang::variables::Variable;
use std::collections::BTreeSet;

/// A function of the file, for the shader.
pub(super) struct OslFunction<'e> {
    /// What it gives.
    pub(super) function: &'e ExportedFunction,
    /// The variables that are its arguments.
    pub(super) arguments: Vec<Variable>,
}

impl OslFunction<'_> {
    /// The name of the output of the shader.
    fn output(&self) -> &'static str {
        self.function.term.map_or("colour", SurfaceTerm::name)
    }

    fn is_number(&self, formula: &Formula) -> bool {
        formula.ty(self.function.root) != Type::Vector
    }

    /// The expression that calls it, as a colour or a number.
    fn call(&self, formula: &Formula, arguments: &[(Variable, String)]) -> String {
        let terms = formula.terms_of(self.function.root);
        let reads = terms.iter().any(|id| matches!(formula.term(*id), Term::Parameter(_)));
        let own = self.arguments.iter().filter_map(|variable| arguments.iter().find(|(known, _)| known == variable));
        let given = reads.then_some("parameters").into_iter().chain(own.map(|(_, text)| &**text));
        let call = format!("{}({})", self.function.name, given.collect::<Vec<_>>().join(", "));
        if self.is_number(formula) { call } else { format!("(color){call}") }
    }
}

/// The variables that every shader has, as far as this one reads them, and closures.
const GLOBALS: &str = "P I N Ng u v dPdu ashikhmin_velvet background debug diffuse emission holdout microfacet \
    oren_nayar phong reflection refraction sheen subsurface translucent transparent ward";

/// The shader of this name. The first of the functions is that of light.
pub(super) fn shader(name: &str, origin: &str, block: &ParameterBlock, functions: &[OslFunction]) -> String {
    let mut names = FreeNames::new(block.dialect);
    let taken = functions.iter().map(|own| &*own.function.name).chain([name, &block.name, "parameters"]);
    GLOBALS.split(' ').chain(taken).for_each(|name| _ = names.take(name));
    let read: BTreeSet<Variable> = functions.iter().flat_map(|function| function.arguments.iter().copied()).collect();
    let mut lines = vec![
        "// The formula for one light. A surface without closures is black, so connect the outputs.".to_owned(),
        format!("shader {name}"),
        format!("    [[ string help = \"{} of {}, for one light\" ]]", quoted(&functions[0].function.name), quoted(origin)),
        "(".to_owned(),
    ];
    let members: Vec<(&Parameter, &str, String)> =
        block.members.iter().map(|(id, member)| (block.formula.parameter(*id), &**member, names.take(member))).collect();
    lines.extend(members.iter().map(|(parameter, _, name)| declaration(block, parameter, name)));
    let [light, index] = ["light_position", "refractive_index"].map(|name| names.take(name));
    lines.push(format!(
        "    point {light} = point(\"world\", 2.0, 4.0, 6.0)\n        \
         [[ string label = \"light position\", string help = \"Where the light is.\" ]],"
    ));
    let crossing = read.iter().any(|variable| variable.is_of_crossing());
    if crossing {
        lines.push(format!(
            "    float {index} = 1.5\n        [[ string label = \"refractive index\", \
             string help = \"That of the body.\", float min = 1.0, float max = 3.0 ]],"
        ));
    }
    let outputs: Vec<String> = functions.iter().map(|function| names.take(function.output())).collect();
    let declared = functions.iter().zip(&outputs).map(|(function, output)| {
        let ty = if function.is_number(block.formula) { "float" } else { "color" };
        format!("    output {ty} {output} = 0.0\n        [[ string help = \"{}\" ]]", quoted(&function.function.doc))
    });
    lines.push(declared.collect::<Vec<_>>().join(",\n"));
    lines.push(")\n{".to_owned());
    let mut variables = ShaderVariables { names: &mut names, light: &light, index: &index, read: &read };
    let (statements, arguments) = variables.values();
    lines.extend(statements);
    if !members.is_empty() {
        // Textures are the last members.
        let is_texture = |own: &&(&Parameter, &str, String)| own.0.ty == Type::Texture;
        let (textures, numbers): (Vec<_>, Vec<_>) = members.iter().partition(is_texture);
        let converted = numbers.into_iter().chain(textures).map(|(parameter, _, name)| converted(parameter, name));
        let values = converted.collect::<Vec<_>>().join(", ");
        lines.push(format!("    {} parameters = {{ {values} }};", block.name));
    }
    for (function, output) in functions.iter().zip(&outputs) {
        let call = function.call(block.formula, &arguments);
        lines.push(match function.function.term.is_none() && !read.contains(&Variable::Visible) {
            true => format!("    if (faces_light) {{ {output} = {call}; }}"),
            false => format!("    {output} = {call};"),
        });
    }
    lines.push("}\n".to_owned());
    lines.join("\n")
}

/// The declaration of a parameter of the shader.
fn declaration(block: &ParameterBlock, parameter: &Parameter, name: &str) -> String {
    let number = |number: f32| block.dialect.number(number);
    let whole = parameter.default[0].round();
    let value = match parameter.ty {
        Type::Vector => {
            let ty = if is_colour(parameter) { "color" } else { "vector" };
            format!("{ty} {name} = {ty}({})", parameter.default.map(number).join(", "))
        }
        Type::Scalar | Type::Truth if parameter.is_whole() => format!("int {name} = {whole}"),
        Type::Scalar | Type::Truth => format!("float {name} = {}", number(parameter.default[0])),
        Type::Texture => format!("string {name} = \"\""),
    };
    let mut notes = vec![format!("string label = \"{}\"", quoted(&parameter.name))];
    if let Some(doc) = meaning(parameter) {
        notes.push(format!("string help = \"{}\"", quoted(doc)));
    }
    if parameter.switch {
        notes.push("string widget = \"checkBox\"".to_owned());
    } else if !parameter.choices.is_empty() {
        // These characters part the names.
        let plain = |name: &str| quoted(name).replace(['|', ':'], "/");
        let options = parameter.choices.iter().enumerate().map(|(number, name)| format!("{}:{number}", plain(name)));
        let options = options.collect::<Vec<_>>().join("|");
        notes.push(format!("string widget = \"mapper\", string options = \"{options}\""));
    } else if parameter.ty == Type::Texture {
        notes.push("string widget = \"filename\"".to_owned());
    } else if let Some([low, high]) = parameter.range {
        notes.push(format!("float min = {}, float max = {}", number(low), number(high)));
    }
    format!("    {value}\n        [[ {} ]],", notes.join(", "))
}

/// Whether the shader shows a vector as a colour.
fn is_colour(parameter: &Parameter) -> bool {
    parameter.colour || parameter.predefined.is_some()
}

/// A parameter of the shader with the type that functions take.
fn converted(parameter: &Parameter, name: &str) -> String {
    match parameter.ty {
        Type::Vector if is_colour(parameter) => format!("(vector){name}"),
        Type::Scalar | Type::Truth if parameter.is_whole() => format!("(float){name}"),
        Type::Vector | Type::Scalar | Type::Truth | Type::Texture => name.to_owned(),
    }
}

/// Text between quotation marks.
fn quoted(text: &str) -> String {
    comment(text).replace('"', "\\\"")
}

/// What the shader knows of its hit.
struct ShaderVariables<'n> {
    names: &'n mut FreeNames,
    /// The parameters for the place of the light and for the refractive index.
    light: &'n str,
    index: &'n str,
    read: &'n BTreeSet<Variable>,
}

impl ShaderVariables<'_> {
    /// The statements that compute the variables, and the expression for each.
    fn values(&mut self) -> (Vec<String>, Vec<(Variable, String)>) {
        let [view, normal, outer, to_light] =
            ["to_viewer", "normal_to_viewer", "outer_normal", "to_light"].map(|name| self.names.take(name));
        let (light, index) = (self.light, self.index);
        let mut lines = vec![
            format!("    vector {view} = -normalize(I);"),
            format!("    vector {normal} = dot(N, {view}) < 0.0 ? -(vector)N : (vector)N;"),
            format!("    vector {outer} = dot(Ng, {view}) < 0.0 ? -(vector)Ng : (vector)Ng;"),
            format!("    vector {to_light} = normalize({light} - P);"),
            format!("    int faces_light = dot({outer}, {to_light}) > 0.0;"),
        ];
        let [ratio, sine] = ["ratio", "sine"].map(|name| self.names.take(name));
        if self.read.iter().any(|variable| variable.is_of_crossing()) {
            lines.push(format!("    float {ratio} = backfacing() ? {index} : 1.0 / {index};"));
            lines.push(format!("    float {sine} = {ratio} * length(cross({normal}, {view}));"));
        }
        let of = |variable: Variable| match variable {
            Variable::Normal => normal.clone(),
            Variable::GeometricNormal => outer.clone(),
            Variable::ToLight => to_light.clone(),
            Variable::ToViewer => view.clone(),
            Variable::Tangent => "normalize(dPdu)".to_owned(),
            Variable::Point => "(vector)transform(\"world\", P)".to_owned(),
            Variable::SurfaceU => "u".to_owned(),
            Variable::SurfaceV => "v".to_owned(),
            Variable::Distance => format!("distance({light}, P)"),
            Variable::Visible => "(float)faces_light".to_owned(),
            Variable::RelativeIndex => ratio.clone(),
            Variable::TotalReflection => format!("({sine} > 1.0 ? 1.0 : 0.0)"),
            // Functions compute these from others.
            Variable::Mirrored | Variable::Halfway | Variable::Bitangent | Variable::Alpha | Variable::Beta | Variable::Gamma
            // No formula can name these.
            | Variable::Radiance | Variable::SampleWeight | Variable::WeightedRadiance => "1.0".to_owned(),
        };
        (lines, self.read.iter().map(|variable| (*variable, of(*variable))).collect())
    }
}
