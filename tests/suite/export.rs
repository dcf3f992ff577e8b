//! Formulas in other languages: compilers take the texts, and compiled C computes what the formula means.

mod brdf;
mod shader_tools;

use illuminator::evaluate::at_point::term_values;
use illuminator::export::{ExportTarget, export};
use illuminator::formula::{Formula, Term, TermId};
use illuminator::lang::builtins::Operation;
use illuminator::lang::source::Source;
use illuminator::lang::types::Type;
use illuminator::lang::variables::Variable;
use illuminator::workspace::{FileKind, presets};
use proptest::prelude::Rng;
use proptest::test_runner::{RngAlgorithm, TestRng};
use std::collections::{HashMap, HashSet};
use std::fmt::Write;
use std::process::Command;

/// Formulas with what the built-in ones do not have.
const MORE: [(&str, &str); 10] = [
    ("functions", "body_specific; a: scalar, constraint -2..2; b: scalar, constraint 0.1..3; v: vector, constraint -1..2; formula;
        = <sin(a) + cos(b) + tan(a/2), asin(a/3) + acos(a/3) + atan(a), atan2(a, b) + tanh(a) + erf(b)>
        + <exp(a) + exp2(b), log(b) + log2(b), sqrt(b) + abs(a) + sign(a)>
        + <floor(a) + ceil(a) + fract(a), mod(a, b) + step(a, b) + smoothstep(a, 2.5, b), radians(a) + saturate(a) + min(a, b, 1) + max(a, b, 1)>
        + mix(v, N, b/3) + lerp(L, v, 0.25) + min(v, N) + max(v, L) + clamp(v, 0, b/3) + sqrt(abs(v)) + v/(b + 1) + v*N - (-v)/<2, 3, 4>
        + cross(N, v) + reflect(L, N) + normalize(v + <3>)*length(v) + <distance(v, N), dot(v, V), mix(a, b, 0.3) + lerp(b, a, 0.6)>;"),
    ("powers", "body_specific; a: scalar, constraint -2..2; b: scalar, constraint 0.1..3; formula;
        = <a^2 + a^3 + (-a)^-1 + a^0, b^a + pow(b, 2.5), a^4/(1 + a^2)> - <b - (a - 1) - (b/(a*(b + 3))), b/a*b, -(-a) - -b>;"),
    ("choices", "body_specific; a: scalar, constraint -2..2; b: scalar, constraint 0.1..3; formula;
        = if(a < b && (a > 0 || b >= 1) && !(a == b), <1, a, b>, if(a <= -1 || a != a, N, <if(b > 1, 2, 3)>)) + (a > 0)*<1>;"),
    ("noisy", "body_specific; a: scalar, constraint 0.5..3; n: scalar, constraint 0..5; formula;
        = <perlin(point, 2, a, n), perlin(point*17, a, 2, 3), perlin(-9*N, 1.5, 2, n)>;"),
    ("plain", "formula; refracted = total; ambient = N; emission = <1>; = <max(0, N.L)>;"),
    ("infinite", "body_specific; a: scalar, constraint 1..2; formula;
        = if(a < 0, <1/0, log(0), sqrt(-1)> + normalize(<0, 0, 0>) + <acos(2), 0/0, -1/0>, <a>)
        + <sum(i, 0, 3, if(i == 0, a, a/i)), 1/4 + 2^3, min(1/0, a)>;"),
    ("collisions", "body_specific; op_add_vv: scalar, constraint 0..1; BRDF: scalar, constraint 0..1; cosine: scalar, constraint 0..1;
        exposure: scalar, constraint 0..1; gl_x: scalar, constraint 0..1; noise_sum: scalar, constraint 0..1; formula;
        op_erf = 2*op_add_vv; sum_2 = erf(gl_x); parameters = V; defaults = sum_2*N;
        = op_erf*Cd + IL*cosine*exposure + defaults*BRDF + parameters*noise_sum + perlin(N, 2, 2, 2)*<1> + H;"),
    ("angles", "body_specific; h: scalar, constraint 1..1000; formula; = <exp(-h*gamma^2), exp(-h*alpha^2), exp(-h*beta^2)>;"),
    ("derived", "formula; = <alpha, beta, gamma> + R + H + B + <u, v, dist> + Ng + T + point + <visible>;"),
    ("weights", "body_specific; float: scalar, constraint 0..1; return: scalar, constraint 0..1; formula; struct = float + return;
        reflected = kr*if(total, 1, struct*eta); refracted = kt*Cd; ambient = Ca()*ka; emission = <0, struct, 1>; = IL*struct;"),
];

/// All formulas of these tests: their names and texts.
pub(super) fn formulas() -> Vec<(String, Formula)> {
    let built_in = presets::names(FileKind::Formula);
    let built_in = built_in.map(|name| (name.to_owned(), presets::text(FileKind::Formula, name).expect("a built-in formula")));
    let more = MORE.iter().map(|(name, text)| ((*name).to_owned(), *text));
    let parsed = |(name, text): (String, &str)| {
        let source = Source::new(&name, text.replace("Ca()", "Cd"));
        let (formula, _) = Formula::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        (name, formula)
    };
    built_in.chain(more).map(parsed).collect()
}

#[test]
fn the_formulas_of_these_tests_have_every_operation() {
    let used: HashSet<Operation> = formulas()
        .iter()
        .flat_map(|(_, formula)| formula.terms.clone())
        .filter_map(|term| match term {
            Term::Apply(operation, _) | Term::ByComponents(operation, _) => Some(operation),
            Term::Number(_) | Term::Variable(_) | Term::Parameter(_) | Term::Material(_) => None,
        })
        .collect();
    let missing: Vec<&Operation> = Operation::ALL.iter().filter(|own| !used.contains(own)).collect();
    // Formulas with measured materials are not exported.
    assert_eq!(missing, [&Operation::TextureColour, &Operation::MeasuredReflectance], "add them to `MORE`");
}

/// The value of an expression by the reference meaning.
pub(super) fn value(
    formula: &Formula,
    root: TermId,
    variables: &HashMap<Variable, [f32; 3]>,
    parameters: &[[f32; 3]],
) -> [f32; 3] {
    term_values(formula, &|variable| variables[&variable], &|id| parameters[id.0 as usize])[root.0 as usize]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A number between two others.
fn between(low: f64, high: f64, rng: &mut TestRng) -> f64 {
    low + (high - low) * f64::from(rng.next_u32()) / (f64::from(u32::MAX) + 1.0)
}

/// Variables of a hit and a light. Those that follow from others do so in double precision.
pub(super) fn variables(rng: &mut TestRng) -> HashMap<Variable, [f32; 3]> {
    let mut any = |low: f64, high: f64| [0; 3].map(|_| between(low, high, rng));
    let normal = unit(any(-1.0, 1.0));
    let side = |v: [f64; 3]| if dot(v, normal) < 0.0 { v.map(|x| -x) } else { v };
    let (light, view) = (side(unit(any(-1.0, 1.0))), side(unit(any(-1.0, 1.0))));
    let tangent = unit(cross(normal, unit(any(-1.0, 1.0))));
    let cosine = dot(normal, light);
    let mirrored: [f64; 3] = std::array::from_fn(|at| 2.0 * cosine * normal[at] - light[at]);
    let half = unit(std::array::from_fn(|at| light[at] + view[at]));
    let angle = |a, b| [dot(a, b).clamp(-1.0, 1.0).acos(); 3];
    let one = |number: f64| [number; 3];
    let numbers = any(0.0, 1.0);
    let of = |variable: Variable| match variable {
        Variable::Normal => normal,
        Variable::ToLight => light,
        Variable::ToViewer => view,
        Variable::Mirrored => mirrored,
        Variable::Halfway => half,
        Variable::Tangent => tangent,
        Variable::Bitangent => cross(normal, tangent),
        Variable::GeometricNormal => unit([normal[0], normal[1], normal[2] + 0.1]),
        Variable::Alpha => angle(normal, light),
        Variable::Beta => angle(mirrored, view),
        Variable::Gamma => angle(normal, view),
        Variable::Point => numbers.map(|x| 20.0 * x - 10.0),
        Variable::SurfaceU => one(numbers[0]),
        Variable::SurfaceV => one(numbers[1]),
        Variable::Distance => one(0.1 + 9.0 * numbers[2]),
        Variable::RelativeIndex => one(0.5 + numbers[2]),
        Variable::TotalReflection | Variable::Visible => one(f64::from(u8::from(numbers[0] > 0.5))),
        Variable::Radiance | Variable::SampleWeight | Variable::WeightedRadiance => one(1.0),
    };
    Variable::ALL.iter().map(|variable| (*variable, of(*variable).map(|x| x as f32))).collect()
}

/// Values of all parameters, within their ranges.
pub(super) fn parameters(formula: &Formula, rng: &mut TestRng) -> Vec<[f32; 3]> {
    let mut of = |id| {
        let parameter = formula.parameter(id);
        let [low, high] = parameter.range.unwrap_or([-1.0, 3.0]);
        let any = [0; 3].map(|_| parameter.clamp(between(low.into(), high.min(low + 100.0).into(), rng) as f32).0);
        if parameter.ty == Type::Vector { any } else { [any[0]; 3] }
    };
    formula.parameter_ids().map(&mut of).collect()
}

/// A number as C writes it exactly.
fn literal(number: f32) -> String {
    format!("{:?}f", f64::from(number))
}

fn vector(numbers: [f32; 3]) -> String {
    format!("make_vec3({})", numbers.map(literal).join(", "))
}

/// The parameters of a function of this name in a text: their types and names.
fn signature(text: &str, name: &str) -> Vec<(String, String)> {
    let begin = ["vec3", "float3", "float"].map(|ty| format!("{ty} {name}("));
    let line = text.lines().find(|line| begin.iter().any(|begin| line.contains(begin))).expect("the function");
    let inside = line.split_once('(').expect("parameters").1.trim_end_matches(") {");
    let parts = inside.split(", ").filter(|part| !part.is_empty()).map(|part| part.rsplit_once(' ').expect("type and name"));
    parts.map(|(ty, name)| (ty.to_owned(), name.to_owned())).collect()
}

/// A program that prints what a formula gives for these samples.
fn program(text: &str, roots: &[(String, TermId)], samples: &[Sample], formula: &Formula) -> String {
    let mut program = text.to_owned();
    program += "\n#include <stdio.h>\nstatic inline void print3(vec3 v) { printf(\"%.9g %.9g %.9g\\n\", v.x, v.y, v.z); }\n";
    program += "static inline void print1(float x) { printf(\"%.9g %.9g %.9g\\n\", x, x, x); }\nint main(void) {\n";
    for (variables, parameters) in samples {
        for (name, root) in roots {
            let mut arguments = Vec::new();
            for (ty, name) in signature(text, name) {
                if ty.ends_with("Parameters ") || name == "*parameters" {
                    let block = ty.trim_start_matches("const ").trim();
                    let members = text.split_once(&format!("typedef struct {block} {{\n")).expect("the parameters").1;
                    let members = members.lines().take_while(|line| !line.starts_with('}'));
                    let values: Vec<String> = members
                        .map(|line| {
                            let name = line.split(';').next().and_then(|own| own.split(' ').next_back()).expect("a name");
                            let wanted = name.trim_end_matches("_2").trim_start_matches("f_");
                            let id = formula.parameter_named(wanted).expect("a parameter");
                            let value = parameters[id.0 as usize];
                            if formula.parameter(id).ty == Type::Vector {
                                format!(".{name} = {{{}}}", value.map(literal).join(", "))
                            } else {
                                format!(".{name} = {}", literal(value[0]))
                            }
                        })
                        .collect();
                    arguments.push(format!("&(const {block}){{{}}}", values.join(", ")));
                    continue;
                }
                let variable = Variable::named(&name).expect("a variable");
                let value = variables[&variable];
                arguments.push(if ty == "vec3" { vector(value) } else { literal(value[0]) });
            }
            let print = if formula.ty(*root) == Type::Vector { "print3" } else { "print1" };
            writeln!(program, "    {print}({name}({}));", arguments.join(", ")).expect("memory");
        }
    }
    program + "    return 0;\n}\n"
}

/// The variables and the parameters of a call.
pub(super) type Sample = (HashMap<Variable, [f32; 3]>, Vec<[f32; 3]>);

#[test]
fn c_computes_what_formulas_mean() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let c = ExportTarget::named("c").expect("C");
    for (name, formula) in formulas() {
        if formula.parameter_ids().any(|id| formula.parameter(id).ty == Type::Texture) {
            continue;
        }
        let text = export(&formula, &name, &name, c).expect("C has everything");
        let main = name.replace('-', "_");
        let surface = formula.surface.iter().map(|(term, root)| (format!("{main}_{}", term.name()), root));
        let roots: Vec<(String, TermId)> = std::iter::once((main.clone(), formula.result)).chain(surface).collect();
        let samples: Vec<Sample> = (0..50).map(|_| (variables(&mut rng), parameters(&formula, &mut rng))).collect();
        let (source, binary) = (folder.path().join(format!("{main}.c")), folder.path().join(&main));
        std::fs::write(&source, program(&text, &roots, &samples, &formula)).expect("a file");
        let flags = ["-std=c99", "-O1", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-pedantic"];
        let built = Command::new("gcc").args(flags).arg(&source).arg("-o").arg(&binary).arg("-lm").output().expect("gcc");
        assert!(built.status.success(), "{name}: {}\n{text}", String::from_utf8_lossy(&built.stderr));
        let output = Command::new(&binary).output().expect("the program");
        let printed = String::from_utf8(output.stdout).expect("numbers");
        let lines: Vec<&str> = printed.lines().collect();
        assert_eq!(lines.len(), samples.len() * roots.len(), "{name}");
        let calls = samples.iter().flat_map(|sample| roots.iter().map(move |root| (sample, root)));
        for (line, ((variables, parameters), (function, root))) in lines.iter().zip(calls) {
            let expected = value(&formula, *root, variables, parameters);
            let found: Vec<f32> = line.split(' ').map(|number| number.parse().expect("a number")).collect();
            for (found, expected) in found.iter().zip(expected) {
                // Variables that follow from others are rounded once more in C, and powers make that more.
                let near = (found - expected).abs() <= 2e-4 * (expected.abs() + 0.05);
                let same = near || *found == expected || found.is_nan() && expected.is_nan();
                assert!(same, "{function}: {found}, not {expected}\n{text}");
            }
        }
    }
}

/// All formulas with all shading languages: the name of the formula, the language, and the text.
fn shaders() -> Vec<(String, &'static str, String)> {
    let textured = "body_specific; image: texture, default \"preset:checker\"; kd: scalar; formula; = image(2*u, v)*kd;";
    let (textured, _) = Formula::parse(&Source::new("textured", textured)).expect("a formula");
    let all: Vec<(String, Formula)> = formulas().into_iter().chain([("textured".to_owned(), textured)]).collect();
    let targets = ["glsl", "hlsl", "wgsl"].map(|name| ExportTarget::named(name).expect("a language"));
    let text = |(name, formula): &(String, Formula), target| export(formula, name, name, target).expect("these have everything");
    all.iter().flat_map(|own| targets.map(|target| (own.0.clone(), target.name(), text(own, target)))).collect()
}

/// A call of a function of this name with numbers.
fn call(text: &str, name: &str, vector: &str) -> String {
    let arguments: Vec<String> = signature(text, name)
        .iter()
        .map(|(ty, _)| if ty == vector { format!("{vector}(0.5, 0.25, 0.75)") } else { "0.5".to_owned() })
        .collect();
    format!("{name}({})", arguments.join(", "))
}

#[test]
fn a_compiler_of_wgsl_and_glsl_takes_formulas() {
    for (name, language, text) in shaders() {
        let module = match language {
            "wgsl" => naga::front::wgsl::parse_str(&text)
                .unwrap_or_else(|error| panic!("{name}: {}\n{text}", error.emit_to_string(&text))),
            // It knows no textures with a sampler. The reference compiler does.
            "glsl" if text.contains("sampler2D") => continue,
            "glsl" => {
                let options = naga::front::glsl::Options::from(naga::ShaderStage::Fragment);
                let text = format!("{text}\nvoid main() {{}}\n");
                let parsed = naga::front::glsl::Frontend::default().parse(&options, &text);
                parsed.unwrap_or_else(|errors| panic!("{name}: {}\n{text}", errors.emit_to_string(&text)))
            }
            _ => continue,
        };
        let (flags, capabilities) = (naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
        let valid = naga::valid::Validator::new(flags, capabilities).validate(&module);
        assert!(valid.is_ok(), "{name} in {language}: {valid:?}\n{text}");
        assert!(!module.functions.is_empty());
    }
}

#[test]
fn the_reference_compiler_takes_glsl_and_hlsl() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, language, text) in shaders() {
        let main = name.replace('-', "_");
        let (program, options) = match language {
            "glsl" => {
                let output = "layout(location = 0) out vec4 colour;";
                let call = call(&text, &main, "vec3");
                (format!("{text}\n{output}\nvoid main() {{ colour = vec4({call}, 1.0); }}\n"), vec!["-S", "frag"])
            }
            "hlsl" => {
                let call = call(&text, &main, "float3");
                let body = format!("float4 main() : SV_Target {{ return float4({call}, 1.0); }}");
                (
                    format!("{text}\n{body}\n"),
                    vec!["-D", "-S", "frag", "-e", "main", "-V", "--auto-map-bindings", "-o", "/dev/null"],
                )
            }
            _ => continue,
        };
        let file = folder.path().join(format!("{main}.{language}"));
        std::fs::write(&file, &program).expect("a file");
        let output = Command::new("glslangValidator")
            .args(options)
            .arg(&file)
            .output()
            .expect("glslangValidator, of the package glslang-tools");
        assert!(output.status.success(), "{name} in {language}: {}\n{program}", String::from_utf8_lossy(&output.stdout));
    }
}

/// The file for BRDF Explorer as a shader: parameters become uniforms, as it declares them.
fn shader_of_brdf(file: &str) -> String {
    let between = |begin: &str, end: &str| {
        let rest = file.split_once(&format!("::begin {begin}\n")).expect("the beginning of a part").1;
        rest.split_once(&format!("::end {end}\n")).expect("its end").0.to_owned()
    };
    assert!(file.starts_with("analytic\n"));
    let declarations = between("parameters", "parameters");
    let uniforms = declarations.lines().filter(|line| !line.starts_with('#')).map(|line| {
        let words: Vec<&str> = line.split(' ').collect();
        assert!(words.len() == if words[0] == "bool" { 3 } else { 5 }, "{line}");
        assert!(words[2..].iter().all(|number| number.parse::<f32>().is_ok()), "{line}");
        let ty = if words[0] == "color" { "vec3" } else { words[0] };
        format!("uniform {ty} {};\n", words[1])
    });
    let main = "out vec4 colour;\nin vec3 L, V, N, X, Y;\nvoid main() { colour = vec4(BRDF(L, V, N, X, Y), 1.0); }\n";
    format!("#version 150\n{}{}{main}", uniforms.collect::<String>(), between("shader", "shader"))
}

#[test]
fn brdf_explorer_gets_models_of_directions() {
    let folder = tempfile::tempdir().expect("a folder");
    let target = ExportTarget::named("brdf").expect("a language");
    let (mut written, mut refused) = (0, Vec::new());
    for (name, formula) in formulas() {
        let file = match export(&formula, &name, &name, target) {
            Ok(file) => file,
            Err(error) => {
                refused.push(format!("{name}: {error}"));
                continue;
            }
        };
        let shader = folder.path().join(format!("{name}.frag"));
        std::fs::write(&shader, shader_of_brdf(&file)).expect("a file");
        let output =
            Command::new("glslangValidator").arg(&shader).output().expect("glslangValidator, of the package glslang-tools");
        assert!(output.status.success(), "{name}: {}\n{file}", String::from_utf8_lossy(&output.stdout));
        written += 1;
    }
    // Those that read the place of the hit or the distance of the light.
    assert!(written > 30 && refused.iter().any(|own| own.starts_with("marble: the formula reads `point`")), "{refused:?}");
}

#[test]
fn textures_of_c_are_functions_and_white_by_default() {
    let text = "body_specific; image: texture, default \"preset:checker\"; formula; = 2*image(u, v);";
    let (formula, _) = Formula::parse(&Source::new("textured", text)).expect("a formula");
    let text = export(&formula, "textured", "textured", ExportTarget::named("c").expect("C")).expect("C has everything");
    let folder = tempfile::tempdir().expect("a folder");
    let (source, binary) = (folder.path().join("textured.c"), folder.path().join("textured"));
    let main = "\n#include <stdio.h>\nstatic vec3 ramp(float u, float v) { return make_vec3(u, v, 0.5f); }\n\
        int main(void) {\n    TexturedParameters own = textured_defaults();\n    const vec3 white = textured(&own, 0.25f, 0.75f);\n    \
        own.image = ramp;\n    const vec3 v = textured(&own, 0.25f, 0.75f);\n    \
        printf(\"%g %g %g %g\", white.x, v.x, v.y, v.z);\n    return 0;\n}\n";
    std::fs::write(&source, text + main).expect("a file");
    let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"];
    let built = Command::new("gcc").args(flags).arg(&source).arg("-o").arg(&binary).output().expect("gcc");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    assert_eq!(Command::new(&binary).output().expect("the program").stdout, b"2 0.5 1.5 1");
}
