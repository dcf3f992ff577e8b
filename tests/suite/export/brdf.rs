//! Files of BRDF Explorer: what this program exports and imports again, and what GLSL means.

use super::{formulas, parameters, value, variables};
use illuminator::export::{ExportTarget, export};
use illuminator::formula::Formula;
use illuminator::import::formula_of_brdf;
use illuminator::lang::source::Source;
use illuminator::lang::types::Type;
use illuminator::lang::variables::Variable;
use proptest::test_runner::{RngAlgorithm, TestRng};
use std::collections::HashMap;

/// The formula of a file.
fn imported(name: &str, text: &str) -> Result<Formula, String> {
    let source = Source::new(name, text);
    let translated = formula_of_brdf(&source).map_err(|errors| errors.located(&source).to_string())?;
    let source = Source::new("imported", translated.text);
    let (formula, warnings) =
        Formula::parse(&source).unwrap_or_else(|errors| panic!("{name}: {}\n{}", errors.located(&source), source.text()));
    assert!(warnings.is_empty(), "{name}: {}\n{}", warnings.located(&source), source.text());
    Ok(formula)
}

#[test]
fn exported_models_are_the_same_when_they_are_imported() {
    let target = ExportTarget::named("brdf").expect("a language");
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let (mut same, mut refused) = (0, Vec::new());
    for (name, formula) in formulas() {
        let Ok(text) = export(&formula, &name, &name, target) else { continue };
        let back = match imported(&name, &text) {
            Ok(back) => back,
            Err(errors) => {
                refused.push((name, errors));
                continue;
            }
        };
        for _ in 0..50 {
            let mut variables = variables(&mut rng);
            let values = parameters(&formula, &mut rng);
            // BRDF Explorer knows one normal, and no shadows.
            variables.insert(Variable::GeometricNormal, variables[&Variable::Normal]);
            variables.insert(Variable::Visible, [1.0; 3]);
            let own = back.parameter_ids().map(|id| {
                let parameter = back.parameter(id);
                let same = formula.parameter_named(&parameter.name);
                let wanted = parameter.name.trim_start_matches("f_");
                let same = same.or_else(|| formula.parameter_named(wanted.rsplit_once('_').map_or(wanted, |(name, _)| name)));
                same.map_or(parameter.default, |id| values[id.0 as usize])
            });
            let own: Vec<[f32; 3]> = own.collect();
            let expected = value(&formula, formula.result, &variables, &values);
            let found = value(&back, back.result, &variables, &own);
            for (found, expected) in found.iter().zip(expected) {
                let near = (found - expected).abs() <= 2e-3 * (expected.abs() + 0.05);
                assert!(near || found.is_nan() && expected.is_nan() || !expected.is_finite(), "{name}: {found}, not {expected}");
            }
        }
        for id in back.parameter_ids() {
            let parameter = back.parameter(id);
            // Those that the formula does not read are left out.
            if !["float", "bool", "color"].iter().any(|ty| text.contains(&format!("\n{ty} {} ", parameter.name))) {
                continue;
            }
            if let Some(own) = formula.parameter_named(&parameter.name) {
                let own = formula.parameter(own);
                assert_eq!(
                    (parameter.owner, parameter.range, parameter.switch, &parameter.doc),
                    (own.owner, own.range, own.switch, &own.doc),
                    "{name}: {}",
                    own.name
                );
                assert!(parameter.ty == Type::Texture || parameter.default == own.default, "{name}: {}", own.name);
            }
        }
        same += 1;
    }
    assert!(same >= 30, "{same}: {refused:#?}");
    for (name, errors) in &refused {
        assert!(errors.contains("loops are not translated") || errors.contains("arrays are not translated"), "{name}: {errors}");
    }
}

/// A file with parameters and a shader.
fn file(declarations: &str, shader: &str) -> String {
    format!("analytic\n\n::begin parameters\n{declarations}\n::end parameters\n\n::begin shader\n{shader}\n::end shader\n")
}

/// What a shader gives for directions: the sum of its components without the factors that formulas have.
fn model(formula: &Formula, variables: &HashMap<Variable, [f32; 3]>, values: &[(&str, f32)]) -> [f32; 3] {
    let own = formula.parameter_ids().map(|id| {
        let parameter = formula.parameter(id);
        let given = values.iter().find(|(name, _)| *name == parameter.name);
        given.map_or(parameter.default, |(_, number)| [*number; 3])
    });
    let own: Vec<[f32; 3]> = own.collect();
    let cosine = dot(variables[&Variable::Normal], variables[&Variable::ToLight]);
    value(formula, formula.result, variables, &own).map(|number| number / (std::f32::consts::PI * cosine))
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Statements of all kinds that are translated.
const STATEMENTS: &str = "
        #version 120
        const float PI = 3.14159265, TWO = 2.;
        float sqr(float x) { return x*x; }
        vec3 sqr(vec3 v) { return v*v; }
        /* A function whose results depend on conditions. */
        float ramp(float a, float b, float x)
        {
            if (a < b) {
                if (x < a) return 0.0;
                if (x >= b) return 1.0;
                x = (x - a)/(b - a);
            } else if (a > b) {
                if (x <= b) return 1.0;
                if (x > a) return 0.0;
                x = 1 - (x - b)/(a - b);
            } else return x < a ? 0.0 : 1.0;
            return x*x*(3 - TWO*x);
        }
        float unused(float x) { for (int i = 0; i < 3; i++) x += 1.0; return x; }
        vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)
        {
            float c = dot(N, L), d = -c, e;
            c *= 2; c -= .5e0; d += 1.0/4.0; e = d;
            { float c = 7.0; e = e + c; }
            vec3 v = vec3(c, d, e); v.y += 1.0; v[2] = v.x - v.b;
            if (on && !(c > k)) { e = -1.0; v = v.zyx; } else e /= 2;
            v = 1 + v; v = 2.0 - v; v = sqr(v) + sqr(v.x) + sqr(e);
            float r = ramp(0.2, 0.8, c) + 2.0*ramp(0.9, 0.1, d) + 4.0*ramp(0.3, 0.3, e);
            return v/(1.0 + abs(v))*(on ? 1.0 : 0.5) + r + 1/2 + vec3(7/2, mod(-c, 0.3), max(k, atan(c, d))) - inversesqrt(v + 20.0);
        }";

#[test]
fn statements_and_functions_mean_what_they_mean_in_glsl() {
    let text = file("# how much\nfloat k 0 2 .25\nbool on 1", STATEMENTS);
    let formula = imported("statements", &text).expect("plain arithmetic");
    let sqr = |x: f32| x * x;
    let ramp = |a: f32, b: f32, x: f32| {
        let x = if a < b {
            if x < a {
                return 0.0;
            }
            if x >= b {
                return 1.0;
            }
            (x - a) / (b - a)
        } else if a > b {
            if x <= b {
                return 1.0;
            }
            if x > a {
                return 0.0;
            }
            1.0 - (x - b) / (a - b)
        } else {
            return if x < a { 0.0 } else { 1.0 };
        };
        x * x * (3.0 - 2.0 * x)
    };
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    for sample in 0..200 {
        let variables = variables(&mut rng);
        let (k, on) = (sample as f32 * 0.01, sample % 3 > 0);
        let cosine = dot(variables[&Variable::Normal], variables[&Variable::ToLight]);
        let (c, d) = (2.0 * cosine - 0.5, 0.25 - cosine);
        let mut e = d + 7.0;
        let mut v = [c, d + 1.0, c - e];
        if on && (c <= k) {
            e = -1.0;
            v.reverse();
        } else {
            e /= 2.0;
        }
        let v = v.map(|x| 2.0 - (1.0 + x));
        let first = sqr(v[0]);
        let v = v.map(|x| sqr(x) + first + sqr(e));
        let r = ramp(0.2, 0.8, c) + 2.0 * ramp(0.9, 0.1, d) + 4.0 * ramp(0.3, 0.3, e);
        let added = [3.0, -c - 0.3 * (-c / 0.3).floor(), k.max(c.atan2(d))];
        let expected: [f32; 3] = std::array::from_fn(|at| {
            v[at] / (1.0 + v[at].abs()) * if on { 1.0 } else { 0.5 } + r + added[at] - 1.0 / (v[at] + 20.0).sqrt()
        });
        let found = model(&formula, &variables, &[("k", k), ("on", f32::from(u8::from(on)))]);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= 1e-3 * (expected.abs() + 1.0), "{sample}: {found}, not {expected}");
        }
    }
}

#[test]
fn any_text_is_translated_or_refused() {
    let whole = file(
        "# body parameter, 0..1, default 0.5: it\nfloat k 0 1 .5\nbool b 1\ncolor Cd 1 1 1",
        "const int T[2] = int[2](1, 2);\nfloat f(float x) { if (x > 0.) return x; else { x = -x; } return x*k; }\n\
         vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) { vec3 H = normalize(L + V); return Cd*f(dot(N, H))*(b ? 1.0 : .5); }",
    );
    assert!(imported("whole", &whole).is_ok());
    let try_it = |text: &str| drop(formula_of_brdf(&Source::new("any", text)));
    for end in (0..whole.len()).filter(|end| whole.is_char_boundary(*end)) {
        try_it(&whole[..end]);
        let mut changed = whole.clone();
        changed.replace_range(end..=end, ["(", "}", ";", "é", "0", "", "-", "if(", "::end"][end % 9]);
        try_it(&changed);
    }
}

#[test]
fn what_is_deep_or_long_is_refused() {
    let shader =
        |body: &str, before: &str| file("", &format!("{before}vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) {{ {body} }}"));
    let many = 20_000;
    let deep = [
        format!("return {}L{};", "(".repeat(many), ")".repeat(many)),
        format!("return {}L;", "- ".repeat(many)),
        format!("return L{};", " + L".repeat(many)),
        format!("return L{};", ".xyz".repeat(many)),
        format!("{} return L; {}", "{".repeat(many), "}".repeat(many)),
        format!("{} return L;", "if (true) ".repeat(many)),
        format!("{} return L; return L;", "if (true) return L; else ".repeat(many)),
        format!("return {} L;", "true ? L : ".repeat(many)),
    ];
    for body in deep {
        let error = imported("deep", &shader(&body, "")).expect_err("too deep");
        assert!(error.contains("within each other"), "{error}");
    }
    // Each function calls the one before it twice, and is too long for a function of the formula.
    let long = "x + ".repeat(80);
    let functions: String = (1..30)
        .map(|number| format!("float f{number}(float x) {{ return {long}f{0}(x)*f{0}(x + 1.0); }}\n", number - 1))
        .collect();
    let error = imported("long", &shader("return vec3(f29(1.0));", &format!("float f0(float x) {{ return x; }}\n{functions}")));
    assert!(error.expect_err("too long").contains("more than 4000 values"));
    let many_returns = "if (L.x > 0.5) return L; ".repeat(200) + "return V;";
    let error = imported("long", &shader(&many_returns, ""));
    assert!(error.expect_err("too many").contains("at more than 100 places"));
    let error = imported("loop", &shader("return vec3(f(1.0));", "float f(float x) { return f(x); }\n"));
    assert!(error.expect_err("a loop").contains("calls itself"));
}

/// The function `BRDF` with this body, after declarations.
fn shader(before: &str, body: &str) -> String {
    format!("{before}\nvec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) {{ {body} }}")
}

/// Why a model with this function cannot be translated.
fn refusal(before: &str, body: &str) -> String {
    imported("refused", &file("", &shader(before, body))).map(|_| ()).expect_err("what is not translated")
}

#[test]
fn lines_end_as_in_the_shader() {
    let whole = file("# how much\nfloat k 0 2 1", &shader("#version 120", "return vec3(0.25*k);"));
    for end in ["\n", "\r", "\r\n", "\u{a0}\n", "\u{3000}\r"] {
        let formula = imported("lines", &whole.replace('\n', end)).expect("a model");
        let parameter = formula.parameter(formula.parameter_named("k").expect("a parameter"));
        assert_eq!(parameter.doc.as_deref(), Some("how much"), "{end:?}");
    }
    for blank in ["\u{a0}", "\u{3000}", "\u{2028}"] {
        let text = whole.replace("::begin shader\n", &format!("::begin shader{blank}\n"));
        assert!(imported("blank", &text).is_ok(), "{blank:?}");
        let cut = text.split_once(blank).expect("the blank").0.to_owned() + blank;
        assert!(imported("cut", &cut).is_err());
    }
}

#[test]
fn an_expression_that_grows_by_operations_is_refused() {
    let nested = |function: &str| format!("return vec3({}L.x{});", format!("{function}(").repeat(60), ")".repeat(60));
    let bodies = [format!("return L{};", ".zyx".repeat(60)), nested("trunc"), format!("return {};", faced(60))];
    for body in bodies {
        let error = refusal("", &body);
        assert!(error.contains("has more than 10000 characters in a formula") && error.contains("refused:"), "{error}");
    }
    // Functions that call each other add to the depth.
    let functions: String = (1..30)
        .map(|number| {
            format!("float f{number}(float x) {{ return {}f{}(x){}; }}\n", "abs(".repeat(90), number - 1, ")".repeat(90))
        })
        .collect();
    let error = refusal(&format!("float f0(float x) {{ return x; }}\n{functions}"), "return vec3(f29(L.x));");
    assert!(error.contains("more than 250 expressions within each other"), "{error}");
    let constants: String = (1..20_000).map(|number| format!("const float a{number} = a{}*L;\n", number - 1)).collect();
    let error = refusal(&constants, "return vec3(a19999);");
    assert!(error.contains("more than 250 expressions within each other"), "{error}");
}

/// Calls of `faceforward` within each other.
fn faced(depth: usize) -> String {
    format!("{}L{}", "faceforward(".repeat(depth), ", V, N)".repeat(depth))
}

#[test]
fn whole_numbers_are_divided_as_in_glsl_or_not_at_all() {
    let bodies = [
        "int i = 1; if (L.x > 0.0) i = 3; return vec3(i/2);",
        "int i = 1; if (L.x > 0.0) i = 3; return vec3((i + 1)/2);",
        "int i = 1; if (L.x > 0.0) i = 3; i /= 2; return vec3(i);",
        "return vec3((L.x > 0.0 ? 1 : 3)/2);",
        "return vec3(-max(1, 3)/2);",
        "return vec3(h(3));",
    ];
    for body in bodies {
        let error = refusal("float h(int n) { return float(n/2); }", body);
        assert!(error.contains("only constants of the type `int` are divided") && error.contains("refused:"), "{error}");
    }
    for body in ["return vec3(2147483647 + 1);", "int i = 65536; i *= 65536; return vec3(i);", "return vec3(3000000000);"] {
        let error = refusal("", body);
        assert!(error.contains("a whole number of more than 32 bits") && error.contains("refused:"), "{error}");
    }
    assert!(refusal("", "return vec3(1/0);").contains("divided by 0"));
    assert!(refusal("", "int i = 1; i %= 2; return L;").contains("cannot be translated"));
    assert!(refusal("", "return vec3(3 % 2);").contains("operators of whole numbers are not translated"));
    let before = "float f(float x) { return 1.0; } float f(int n) { return 2.0*n; }";
    let body = "return vec3(f(2), f(2.0), f(max(1, 2)));";
    let formula = imported("overloads", &file("", &shader(before, body))).expect("two functions");
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let found = model(&formula, &variables(&mut rng), &[]);
    assert!(found.iter().zip([4.0, 1.0, 4.0]).all(|(found, expected)| (found - expected).abs() <= 1e-3), "{found:?}");
    let body = "int i = 1; if (L.x > -2.0) i = 3; i += 4*(L.x > -2.0 ? 2 : 1) + 7/2; return vec3(i*0.5, i/2.0, float(i)/-2);";
    let formula = imported("whole", &file("", &shader("", body))).expect("whole numbers");
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let found = model(&formula, &variables(&mut rng), &[]);
    for (found, expected) in found.iter().zip([7.0, 7.0, -7.0]) {
        assert!((found - expected).abs() <= 1e-3, "{found}, not {expected}");
    }
}

#[test]
fn constants_that_need_themselves_are_refused() {
    for (constants, name) in [("const float a = b; const float b = a;", 'a'), ("const float a = 1.0 + a;", 'a')] {
        let error = refusal(constants, "return vec3(a) + vec3(a);");
        assert_eq!(error.matches(&format!("`{name}` is defined by itself")).count(), 1, "{error}");
        assert!(error.contains("refused:"), "{error}");
    }
}

#[test]
fn a_model_of_too_many_values_is_refused_soon() {
    for statement in ["a = a*1.0001 + 0.1; ", "a = L.x + 1.0; ", "if (a > 0.5) a += 1.0; ", "float c = L.x + 1.0; "] {
        let error = refusal("", &format!("float a = L.x; {} return vec3(a);", statement.repeat(100_000)));
        assert_eq!(error.matches("the model has more than 4000 values").count(), 1, "{}", error.len());
        assert!(error.len() < 1000, "{}", error.len());
    }
    let long =
        format!("float a = L.x; {} return vec3(a);", "a = trunc(trunc(trunc(trunc(trunc(trunc(trunc(a))))))); ".repeat(3_900));
    let error = refusal("", &long);
    assert_eq!(error.matches("the model has more than 4000000 characters").count(), 1, "{}", error.len());
    // The names of the values are found at once, too.
    let body = format!("float a = L.x; {} return vec3(a);", "a = a*1.0001 + 0.1; ".repeat(3_900));
    assert!(formula_of_brdf(&Source::new("many", file("", &shader("", &body)))).is_ok());
}

#[test]
fn a_default_that_is_not_in_its_range_is_noticed() {
    let text = file("float k 0 1 2\nfloat n 0 1 1", &shader("", "return vec3(k*n);"));
    let translated = formula_of_brdf(&Source::new("default", &text)).expect("a formula");
    assert!(translated.text.contains("k: scalar, constraint 0..2, default 2, slider;"), "{}", translated.text);
    let said = translated.remarks.located(&Source::new("default", text)).to_string();
    assert_eq!(said.matches("is not in its range").count(), 1, "{said}");
    assert!(said.contains("the default of `k` is not in its range"), "{said}");
}
