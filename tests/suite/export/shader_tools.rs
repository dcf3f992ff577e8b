//! Checks with tools of Python packages: MaterialX, and OSL's compiler in Blender's package.
//!
//! `SHADER_TOOLS` names a Python with both. `.ci/run` makes one. Without it, these tests check nothing.

use super::{MORE, Sample, formulas, parameters, value, variables};
use illuminator::export::{ExportTarget, export};
use illuminator::formula::{Formula, Term, TermId};
use illuminator::lang::builtins::Operation;
use illuminator::lang::source::Source;
use illuminator::lang::types::Type;
use illuminator::lang::variables::Variable;
use proptest::test_runner::{RngAlgorithm, TestRng};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// The Python with the packages.
fn python() -> Option<String> {
    let own = std::env::var("SHADER_TOOLS").ok();
    if own.is_none() {
        eprintln!("not checked: SHADER_TOOLS names no Python with the packages MaterialX and bpy");
    }
    own
}

/// Runs a script of this folder on a folder of files.
fn run(python: &str, script: &str, folder: &Path) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite/export").join(script);
    let output = Command::new(python).arg(script).arg(folder).output().expect("Python");
    let (told, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{told}\n{errors}");
}

/// Formulas of which languages without infinite numbers and NaN make something else.
const INFINITE: [&str; 1] = ["infinite"];

/// Numbers that a shader is to print: those of a call, and what they should be.
struct Expected {
    name: String,
    tolerance: f32,
    calls: Vec<(String, [f32; 3])>,
}

/// A formula with a texture beside those of the tests.
fn textured() -> (String, Formula) {
    let text = "body_specific; image: texture, default \"preset:checker\"; kd: scalar, switch; \
        n: scalar, choices \"one, two\", \"<three>\"; formula; = image(2*u, v)*kd*n;";
    ("textured".to_owned(), Formula::parse(&Source::new("textured", text)).expect("a formula").0)
}

/// The parts of a list between the parentheses of a function: types and names.
fn signature(text: &str, begin: &str) -> Vec<(String, String)> {
    let inside = text.split_once(begin).expect("the function").1.split_once(')').expect("its parameters").0;
    let parts = inside.split(", ").filter(|part| !part.is_empty()).map(|part| part.rsplit_once(' ').expect("type and name"));
    parts.map(|(ty, name)| (ty.to_owned(), name.to_owned())).collect()
}

/// A value as OSL writes it.
fn literal(ty: &str, value: [f32; 3]) -> String {
    match ty {
        "vector" | "color" => format!("{ty}({:?}, {:?}, {:?})", value[0], value[1], value[2]),
        "int" => format!("{}", value[0] as i32),
        _ => format!("{:?}", value[0]),
    }
}

/// The value of a parameter of this name, as exports change it.
fn parameter(formula: &Formula, name: &str, values: &[[f32; 3]]) -> Option<[f32; 3]> {
    let id = formula.parameter_named(name).or_else(|| formula.parameter_named(name.rsplit_once('_')?.0))?;
    Some(values[id.0 as usize])
}

/// A shader that prints what calls of functions give. `call` writes a call for a sample as an expression of the type
/// `vector`, with statements before it.
fn printing(calls: &[(String, String)]) -> String {
    let mut text = "shader printing(output color colour = 0.0)\n{\n    vector r = vector(0.0);\n".to_owned();
    for (statements, call) in calls {
        writeln!(text, "    {statements}r = {call};").expect("memory");
        text += "    printf(\"RESULT %.9g %.9g %.9g\\n\", r[0], r[1], r[2]);\n";
    }
    text + "    colour = (color)r;\n}\n"
}

/// The number of samples of each formula.
const SAMPLES: usize = 6;

/// The functions of a formula, by the names of an export in OSL, and what they are for samples.
fn samples(formula: &Formula, rng: &mut TestRng) -> Vec<Sample> {
    (0..SAMPLES).map(|_| (variables(rng), parameters(formula, rng))).collect()
}

/// How far results may be off. OSL computes powers and sines of few digits, and MaterialX writes numbers with six
/// decimals. Noise of a fine grain is rounded more.
fn tolerance(formula: &Formula) -> f32 {
    let is_noise = |term: &Term| matches!(term, Term::Apply(Operation::Perlin, _));
    if formula.terms.iter().any(is_noise) { 0.1 } else { 0.01 }
}

/// Compares what shaders printed with what was expected.
fn compare(folder: &Path, expected: &[Expected]) {
    for Expected { name, tolerance, calls } in expected {
        let printed = std::fs::read_to_string(folder.join(format!("run-{name}.txt"))).expect("what was printed");
        // Cycles runs the shader more than once.
        let found = printed.lines().filter_map(|line| line.strip_prefix("RESULT ")).take(calls.len());
        let found: Vec<&str> = found.collect();
        assert_eq!(found.len(), calls.len(), "{name}: {printed}");
        for (line, (what, expected)) in found.into_iter().zip(calls) {
            let found: Vec<f32> = line.split(' ').map(|number| number.parse().expect("a number")).collect();
            for (found, expected) in found.iter().zip(expected) {
                let near = (found - expected).abs() <= tolerance * (expected.abs() + 0.05);
                assert!(near || !expected.is_finite(), "{name}, {what}: {found}, not {expected}");
            }
        }
    }
}

#[test]
fn osl_computes_what_formulas_mean() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let target = ExportTarget::named("osl").expect("a language");
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut expected = Vec::new();
    for (name, formula) in formulas().into_iter().chain([textured()]) {
        let text = export(&formula, &name, &name, target).expect("OSL has everything");
        std::fs::write(folder.path().join(format!("{name}.osl")), &text).expect("a file");
        if INFINITE.contains(&&*name) || formula.parameter_ids().any(|id| formula.parameter(id).ty == Type::Texture) {
            continue;
        }
        let functions = text.split_once("// The formula for one light.").expect("the shader").0;
        let main = name.replace('-', "_");
        let surface = formula.surface.iter().map(|(term, root)| (format!("{main}_{}", term.name()), root));
        let roots: Vec<(String, TermId)> = std::iter::once((main.clone(), formula.result)).chain(surface).collect();
        let (mut shader, mut own) = (Vec::new(), Vec::new());
        for (number, (variables, values)) in samples(&formula, &mut rng).into_iter().enumerate() {
            for (function, root) in &roots {
                let ty = if formula.ty(*root) == Type::Vector { "vector" } else { "float" };
                let mut before = String::new();
                let arguments = signature(functions, &format!("\n{ty} {function}(")).into_iter().map(|(ty, name)| {
                    if name != "parameters" {
                        return literal(&ty, variables[&Variable::named(name.trim_end_matches("_2")).expect("a variable")]);
                    }
                    let members = functions.split_once(&format!("struct {ty} {{\n")).expect("the parameters").1;
                    let members = members.lines().take_while(|line| !line.starts_with('}')).map(|line| {
                        let (ty, name) = line.split_once(';').expect("a member").0.trim().split_once(' ').expect("a name");
                        literal(ty, parameter(&formula, name.trim_start_matches("f_"), &values).expect("a parameter"))
                    });
                    let members = members.collect::<Vec<_>>().join(", ");
                    let block = format!("p{number}_{function}");
                    write!(before, "{ty} {block} = {{ {members} }}; ").expect("memory");
                    block
                });
                let call = format!("{function}({})", arguments.collect::<Vec<_>>().join(", "));
                shader.push((before, if ty == "float" { format!("vector({call})") } else { call.clone() }));
                own.push((call, value(&formula, *root, &variables, &values)));
            }
        }
        let file = folder.path().join(format!("run-{name}.osl"));
        std::fs::write(file, functions.to_owned() + &printing(&shader)).expect("a file");
        expected.push(Expected { name, tolerance: tolerance(&formula), calls: own });
    }
    run(&python, "osl.py", folder.path());
    compare(folder.path(), &expected);
    assert!(expected.len() > 35 + MORE.len() - 5);
}

#[test]
fn materialx_computes_what_formulas_mean() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let target = ExportTarget::named("materialx").expect("a language");
    let all: Vec<(String, Formula)> = formulas().into_iter().chain([textured()]).collect();
    for (name, formula) in &all {
        let text = export(formula, name, name, target).expect("MaterialX has everything");
        std::fs::write(folder.path().join(format!("{name}.mtlx")), text).expect("a file");
    }
    // Documents are valid, and become code in GLSL and OSL, which compilers take.
    run(&python, "materialx.py", folder.path());
    for (name, _) in &all {
        for stage in ["vert", "frag"] {
            let shader = folder.path().join(format!("{name}.{stage}"));
            let output = Command::new("glslangValidator").arg(&shader).output().expect("glslangValidator");
            assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stdout));
        }
    }
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut expected = Vec::new();
    for (name, formula) in &all {
        if INFINITE.contains(&&**name) || formula.parameter_ids().any(|id| formula.parameter(id).ty == Type::Texture) {
            continue;
        }
        let generated = std::fs::read_to_string(folder.path().join(format!("{name}.osl"))).expect("a shader");
        let functions = generated.split_once("\nshader ").expect("the shader").0;
        let function = format!("NG_{}", name.replace('-', "_"));
        let roots: Vec<TermId> = std::iter::once(formula.result).chain(formula.surface.iter().map(|(_, root)| root)).collect();
        let (mut shader, mut own) = (Vec::new(), Vec::new());
        for (number, (variables, values)) in samples(formula, &mut rng).into_iter().enumerate() {
            let mut before = String::new();
            let mut outputs = Vec::new();
            let arguments = signature(functions, &format!("\nvoid {function}(")).into_iter().map(|(ty, name)| {
                if let Some(ty) = ty.strip_prefix("output ") {
                    let output = format!("o{number}_{}", outputs.len());
                    write!(before, "{ty} {output} = 0.0; ").expect("memory");
                    outputs.push((ty == "float", output.clone()));
                    return output;
                }
                if name == "texcoord" {
                    let [u, v] = [Variable::SurfaceU, Variable::SurfaceV].map(|variable| variables[&variable][0]);
                    return format!("vector2({u:?}, {v:?})");
                }
                let value = match variable(&name) {
                    Some(Variable::ToViewer) => variables[&Variable::ToViewer].map(|number| -number),
                    Some(variable) => variables[&variable],
                    // The generator changes names that OSL has, too.
                    None => {
                        let own = parameter(formula, name.trim_start_matches("f_"), &values);
                        own.or_else(|| parameter(formula, name.trim_end_matches('1'), &values)).expect("a parameter")
                    }
                };
                literal(&ty, value)
            });
            let arguments = arguments.collect::<Vec<_>>().join(", ");
            write!(before, "{function}({arguments}); ").expect("memory");
            for ((is_number, output), root) in outputs.into_iter().zip(&roots) {
                let printed = if is_number { format!("vector({output})") } else { format!("(vector){output}") };
                shader.push((std::mem::take(&mut before), printed));
                own.push((format!("{function}({arguments})"), value(formula, *root, &variables, &values)));
            }
        }
        let file = folder.path().join(format!("run-{name}.osl"));
        std::fs::write(file, functions.to_owned() + "\n" + &printing(&shader)).expect("a file");
        expected.push(Expected { name: name.clone(), tolerance: tolerance(formula), calls: own });
    }
    run(&python, "osl.py", folder.path());
    compare(folder.path(), &expected);
}

/// The variable that an input of a node stands for.
fn variable(input: &str) -> Option<Variable> {
    Some(match input {
        // A word of OSL.
        "normal" | "normal1" => Variable::Normal,
        "geometricnormal" => Variable::GeometricNormal,
        "tangent" => Variable::Tangent,
        "position" => Variable::Point,
        "lightdirection" => Variable::ToLight,
        "lightdistance" => Variable::Distance,
        "viewdirection" => Variable::ToViewer,
        "visible" => Variable::Visible,
        "eta" => Variable::RelativeIndex,
        "total" => Variable::TotalReflection,
        _ => return None,
    })
}
