//! Formulas that are exported as WGSL, on a graphics device: they compute what they mean.

use crate::export::{Sample, formulas, parameters, value, variables};
use illuminator::backends::gpu::compute_once;
use illuminator::export::{ExportTarget, export};
use illuminator::formula::{Formula, Term, TermId};
use illuminator::lang::builtins::Operation;
use illuminator::lang::types::Type;
use illuminator::lang::variables::Variable;
use proptest::test_runner::{RngAlgorithm, TestRng};
use std::fmt::Write;

/// How far a result may be off, as a part of its size. WGSL leaves the accuracy of functions to the device: arc
/// functions of Mesa's software device have an error of about 1e-4, and powers and circular functions of about 1e-5.
fn tolerance(formula: &Formula) -> f32 {
    let uses = |wanted: &[Operation]| {
        formula.terms.iter().any(|term| match term {
            Term::Apply(operation, _) | Term::ByComponents(operation, _) => wanted.contains(operation),
            Term::Number(_) | Term::Variable(_) | Term::Parameter(_) | Term::Material(_) => false,
        })
    };
    use Operation::{Acos, Asin, Atan, Atan2, Cos, Exp, Exp2, Log, Log2, Pow, PowerSS, Sin, Tan, Tanh};
    let reads_angles = [Variable::Alpha, Variable::Beta, Variable::Gamma];
    let reads = formula.terms.iter().any(|term| matches!(term, Term::Variable(variable) if reads_angles.contains(variable)));
    if reads || uses(&[Acos, Asin, Atan, Atan2]) {
        2e-3
    } else if uses(&[Cos, Exp, Exp2, Log, Log2, Pow, PowerSS, Sin, Tan, Tanh]) {
        1e-3
    } else {
        2e-4
    }
}

/// Reads numbers of a sample, one after the other.
struct Reader {
    numbers: usize,
}

impl Reader {
    fn scalar(&mut self) -> String {
        self.numbers += 1;
        format!("numbers_of_samples[first_of_sample + {}u]", self.numbers - 1)
    }

    fn value(&mut self, is_vector: bool) -> String {
        if is_vector { format!("vec3f({})", [0; 3].map(|_| self.scalar()).join(", ")) } else { self.scalar() }
    }
}

/// The numbers of a value, as [`Reader::value`] reads them.
fn numbers(value: [f32; 3], is_vector: bool) -> Vec<f32> {
    value[..if is_vector { 3 } else { 1 }].to_vec()
}

/// The names and types of what stands between two marks: `N: vec3f, eta: f32`.
fn declared(text: &str, begin: &str, end: &str) -> Vec<(String, bool)> {
    let Some((_, rest)) = text.split_once(begin) else { return Vec::new() };
    let inside = rest.split_once(end).expect("the end of it").0;
    let declaration = |part: &str| {
        let (name, ty) = part.split_once(": ")?;
        let is_name = name.trim().chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
        is_name.then(|| (name.trim().to_owned(), ty.starts_with("vec3f")))
    };
    let lines = inside.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.flat_map(|line| line.split(',').filter_map(declaration).collect::<Vec<_>>()).collect()
}

/// A kernel that calls the functions of a text for many samples, and the numbers of these.
fn kernel(text: &str, roots: &[(String, TermId)], samples: &[Sample], formula: &Formula) -> (String, Vec<f32>) {
    let mut reader = Reader { numbers: 0 };
    let mut body = String::new();
    let block =
        text.lines().find_map(|line| line.split_once("var<uniform> parameters: ")).map(|(_, ty)| ty.trim_end_matches(';'));
    let members = block.map(|ty| declared(text, &format!("struct {ty} {{\n"), "\n}")).unwrap_or_default();
    for (name, is_vector) in &members {
        writeln!(body, "    parameters.{name} = {};", reader.value(*is_vector)).expect("memory");
    }
    let calls: Vec<Vec<(String, bool)>> = roots.iter().map(|(name, _)| declared(text, &format!("fn {name}("), ") ->")).collect();
    for (index, ((name, root), arguments)) in roots.iter().zip(&calls).enumerate() {
        let given: Vec<String> = arguments.iter().map(|(_, is_vector)| reader.value(*is_vector)).collect();
        let made = if formula.ty(*root) == Type::Vector { "" } else { "vec3f" };
        writeln!(body, "    let result_{index}_of_sample = {made}({name}({}));", given.join(", ")).expect("memory");
        for (component, part) in ["x", "y", "z"].iter().enumerate() {
            let at = 3 * index + component;
            let count = 3 * roots.len();
            writeln!(body, "    results_of_samples[id.x * {count}u + {at}u] = result_{index}_of_sample.{part};").expect("memory");
        }
    }
    let mut input = Vec::new();
    for (variables, parameters) in samples {
        for (name, is_vector) in &members {
            let wanted = name.trim_end_matches("_2").trim_start_matches("f_");
            let id = formula.parameter_named(name).or_else(|| formula.parameter_named(wanted)).expect("a parameter");
            input.extend(numbers(parameters[id.0 as usize], *is_vector));
        }
        for (name, is_vector) in calls.iter().flatten() {
            input.extend(numbers(variables[&Variable::named(name).expect("a variable")], *is_vector));
        }
    }
    let own = block.map(|ty| format!("@group(0) @binding(0) var<uniform> parameters: {ty};")).unwrap_or_default();
    let text = text.replace(&own, &own.replace("@group(0) @binding(0) var<uniform>", "var<private>"));
    let kernel = format!(
        "{text}
@group(0) @binding(0) var<storage, read> numbers_of_samples: array<f32>;
@group(0) @binding(1) var<storage, read_write> results_of_samples: array<f32>;
@compute @workgroup_size(1) fn compute_samples(@builtin(global_invocation_id) id: vec3<u32>) {{
    let first_of_sample = id.x * {}u + u32(numbers_of_samples[arrayLength(&numbers_of_samples) - 1u]);
{body}}}",
        reader.numbers
    );
    // The last number is 0: one that the kernel reads in any case.
    input.push(0.0);
    (kernel, input)
}

#[test]
fn wgsl_computes_what_formulas_mean() {
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let wgsl = ExportTarget::named("wgsl").expect("WGSL");
    for (name, formula) in formulas() {
        if formula.parameter_ids().any(|id| formula.parameter(id).ty == Type::Texture) {
            continue;
        }
        let text = export(&formula, &name, &name, wgsl).expect("WGSL has everything");
        let main = name.replace('-', "_");
        let surface = formula.surface.iter().map(|(term, root)| (format!("{main}_{}", term.name()), root));
        let roots: Vec<(String, TermId)> = std::iter::once((main.clone(), formula.result)).chain(surface).collect();
        let samples: Vec<Sample> = (0..50).map(|_| (variables(&mut rng), parameters(&formula, &mut rng))).collect();
        let (kernel, input) = kernel(&text, &roots, &samples, &formula);
        let results = compute_once(&kernel, "compute_samples", &input, 3 * roots.len() * samples.len(), samples.len() as u32);
        let results = results.unwrap_or_else(|error| panic!("{name}: {error}\n{kernel}"));
        let calls = samples.iter().flat_map(|sample| roots.iter().map(move |root| (sample, root)));
        let slack = tolerance(&formula);
        for (found, ((variables, parameters), (function, root))) in results.chunks_exact(3).zip(calls) {
            let expected = value(&formula, *root, variables, parameters);
            for (found, expected) in found.iter().zip(expected) {
                // WGSL promises nothing about numbers that are not finite.
                let near = (found - expected).abs() <= slack * (expected.abs() + 0.05);
                assert!(near || !expected.is_finite(), "{function}: {found}, not {expected}\n{kernel}");
            }
        }
    }
}
