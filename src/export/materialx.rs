//! MaterialX: a node for the formula, its graph of standard nodes, and a material that shows it.
//!
//! No surface shader of MaterialX takes a function of the light, so the direction to one light is an input of the node,
//! and the material gives off what the node computes.

use crate::export::ExportedFunction;
use crate::export::dialect::Dialect;
use crate::export::names::FreeNames;
use crate::export::nodes::{COORDINATES, FROM_VIEWER, NodeGraph, input_name, numbers};
use crate::export::parameters::{ParameterBlock, comment, meaning};
use crate::export::walk::write;
use crate::formula::{Parameter, ParameterId};
use crate::lang::noise::permutation;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::types::Type;
use crate::lang::variables::Variable;
use std::collections::{BTreeMap, BTreeSet};

/// The document with these functions. `header` has comments that begin with `//`.
pub(super) fn document(header: &str, block: &ParameterBlock, exported: &[ExportedFunction], mut names: FreeNames) -> String {
    let node = &exported[0].name;
    // The inputs for variables keep their names, and so do outputs.
    let outputs = SurfaceTerm::ALL.iter().map(|term| term.name()).chain([OUT]);
    let own = INPUTS.iter().map(|variable| input_name(*variable)).chain([FROM_VIEWER, COORDINATES]).chain(outputs).chain(GLOBALS);
    let own: BTreeSet<&str> = own.collect();
    own.iter().for_each(|name| _ = names.take(name));
    let parameters: BTreeMap<ParameterId, (String, &'static str)> = block
        .members
        .iter()
        .map(|(id, name)| {
            let name = if own.contains(&**name) { names.take(name) } else { name.clone() };
            (*id, (name, input_type(block.formula.parameter(*id))))
        })
        .collect();
    let mut graph = NodeGraph::new(block.dialect, block.formula, &parameters, node, names);
    let values: Vec<_> = exported.iter().map(|own| write(&mut graph, block.formula, own.root)).collect();
    let outputs: Vec<_> = values.into_iter().map(|value| graph.output(value)).collect();
    let (nodes, connected) = graph.text(&outputs.iter().map(|(value, _)| *value).collect::<Vec<_>>());
    let output_names = || exported.iter().map(|own| own.term.map_or(OUT, SurfaceTerm::name));
    let mut text = "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\" colorspace=\"lin_rec709\">\n".to_owned();
    for line in header.lines() {
        text += &format!("  <!-- {} -->\n", line.trim_start_matches("// ").replace("--", "- -"));
    }
    text += &format!(
        "  <nodedef name=\"ND_{node}\" node=\"{node}\" nodegroup=\"illumination\" doc=\"{}\">\n",
        quoted(&exported[0].doc)
    );
    for (id, (name, ty)) in &parameters {
        text += &parameter_input(block.formula.parameter(*id), name, ty);
    }
    text += &variable_inputs(&graph.variables().collect());
    for ((name, (_, ty)), own) in output_names().zip(&outputs).zip(exported) {
        text += &format!("    <output name=\"{name}\" type=\"{ty}\" doc=\"{}\" />\n", quoted(&own.doc));
    }
    text += &format!("  </nodedef>\n  <nodegraph name=\"NG_{node}\" nodedef=\"ND_{node}\">\n{nodes}");
    for ((name, (_, ty)), connected) in output_names().zip(&outputs).zip(connected) {
        text += &format!("    <output name=\"{name}\" type=\"{ty}\" nodename=\"{connected}\" />\n");
    }
    text += "  </nodegraph>\n";
    let [power, noise] = ["power", "noise"].map(|what| format!("{node}_{what}"));
    if graph.calls(&power) {
        text += &block.dialect.power.replace("@NODE@", &power);
    }
    if graph.calls(&noise) {
        text += &noise_nodes(block.dialect, &noise);
    }
    text + &material(node, exported.len() > 1) + "</materialx>\n"
}

/// The variables that are inputs of their own names.
const INPUTS: [Variable; 9] = [
    Variable::Normal,
    Variable::GeometricNormal,
    Variable::Tangent,
    Variable::ToLight,
    Variable::Point,
    Variable::Distance,
    Variable::Visible,
    Variable::RelativeIndex,
    Variable::TotalReflection,
];

/// The output for the light.
const OUT: &str = "out";

/// A material that shows the light of the node, with the defaults of its inputs.
fn material(node: &str, has_more_outputs: bool) -> String {
    let (ty, output) = if has_more_outputs { ("multioutput", format!(" output=\"{OUT}\"")) } else { ("color3", String::new()) };
    format!(
        "  <{node} name=\"{node}_light\" type=\"{ty}\" />\n  <surface_unlit name=\"{node}_surface\" type=\"surfaceshader\">\n    \
         <input name=\"emission_color\" type=\"color3\" nodename=\"{node}_light\"{output} />\n  </surface_unlit>\n  \
         <surfacematerial name=\"{node}_material\" type=\"material\">\n    \
         <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"{node}_surface\" />\n  </surfacematerial>\n"
    )
}

/// The type of the input for a parameter.
fn input_type(parameter: &Parameter) -> &'static str {
    match parameter.ty {
        Type::Vector if parameter.colour || parameter.predefined.is_some() => "color3",
        Type::Vector => "vector3",
        Type::Scalar | Type::Truth if parameter.switch => "boolean",
        Type::Scalar | Type::Truth if !parameter.choices.is_empty() => "integer",
        Type::Scalar | Type::Truth => "float",
        Type::Texture => "filename",
    }
}

/// The input for a parameter.
fn parameter_input(parameter: &Parameter, name: &str, ty: &str) -> String {
    let first = parameter.default[0];
    let value = match (ty, parameter.ty) {
        (_, Type::Vector) => numbers(parameter.default),
        (_, Type::Texture) => String::new(),
        ("boolean", _) => (first != 0.0).to_string(),
        _ => numbers([first]),
    };
    let mut notes = vec![format!("uiname=\"{}\"", quoted(&parameter.name))];
    let is_number = !parameter.is_whole() && parameter.ty != Type::Texture;
    if let Some([low, high]) = parameter.range.filter(|_| is_number) {
        let slots = parameter.ty.slots();
        let end = |number: f32| numbers(vec![number; slots]);
        notes.push(format!("uimin=\"{}\" uimax=\"{}\"", end(low), end(high)));
    }
    if !parameter.choices.is_empty() {
        // A comma parts the names.
        let names: Vec<String> = parameter.choices.iter().map(|name| quoted(name).replace(',', ";")).collect();
        let values = (0..names.len()).map(|number| number.to_string()).collect::<Vec<_>>().join(", ");
        notes.push(format!("enum=\"{}\" enumvalues=\"{values}\"", names.join(", ")));
    }
    let uniform = if parameter.ty == Type::Texture { " uniform=\"true\"" } else { "" };
    let doc = meaning(parameter).map(|doc| format!(" doc=\"{}\"", quoted(doc))).unwrap_or_default();
    format!("    <input name=\"{name}\" type=\"{ty}\" value=\"{value}\"{uniform} {}{doc} />\n", notes.join(" "))
}

/// The inputs for the variables that the graph reads. Those that MaterialX knows are connected to its geometry.
fn variable_inputs(read: &BTreeSet<Variable>) -> String {
    let mut lines = Vec::new();
    for variable in read {
        let own = input_name(*variable);
        let (name, ty, source, doc) = match variable {
            Variable::Normal | Variable::GeometricNormal => {
                (own, "vector3", "defaultgeomprop=\"Nworld\"", variable.doc())
            }
            Variable::Tangent => (own, "vector3", "defaultgeomprop=\"Tworld\"", variable.doc()),
            Variable::Point => (own, "vector3", "defaultgeomprop=\"Pworld\"", variable.doc()),
            Variable::ToLight => (own, "vector3", "value=\"0.40825, 0.8165, 0.40825\"", variable.doc()),
            Variable::ToViewer => {
                (FROM_VIEWER, "vector3", "defaultgeomprop=\"Vworld\"", "direction from the viewer to the hit, of unit length")
            }
            Variable::SurfaceU | Variable::SurfaceV => {
                (COORDINATES, "vector2", "defaultgeomprop=\"UV0\"", "surface coordinates u and v")
            }
            Variable::RelativeIndex => (own, "float", "value=\"0.6666667\"", variable.doc()),
            Variable::TotalReflection => (own, "float", "value=\"0.0\"", variable.doc()),
            Variable::Distance | Variable::Visible => (own, "float", "value=\"1.0\"", variable.doc()),
            // The graph computes these from others.
            Variable::Mirrored | Variable::Halfway | Variable::Bitangent | Variable::Alpha | Variable::Beta | Variable::Gamma
            // No formula can name these.
            | Variable::Radiance | Variable::SampleWeight | Variable::WeightedRadiance => continue,
        };
        let line = format!("    <input name=\"{name}\" type=\"{ty}\" {source} doc=\"{}\" />\n", quoted(doc));
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    lines.concat()
}

/// The nodes for noise.
fn noise_nodes(dialect: &Dialect, node: &str) -> String {
    let numbers = permutation().iter().map(u8::to_string).collect::<Vec<_>>().join(", ");
    let digits: String = permutation().iter().map(|number| format!("{number:03}")).collect();
    dialect.noise.replace("@NODE@", node).replace("@PERMUTATION@", &numbers).replace("@DIGITS@", &digits)
}

/// The variables of every shader in OSL. A parameter of one of these names would hide it.
const GLOBALS: [&str; 9] = ["P", "I", "N", "Ng", "u", "v", "L", "dPdu", "dPdv"];

/// Text in an attribute.
fn quoted(text: &str) -> String {
    comment(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
