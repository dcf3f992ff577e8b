//! Tests of functions, sums, conditions, components and predefined parameters: values of expressions without variables.

use crate::formula::Formula;
use crate::formula::graph::Graph;
use crate::lang::source::Source;
use crate::lang::variables::Predefined;

fn parsed(text: &str) -> Formula {
    let source = Source::new("test", text);
    Formula::parse(&source).unwrap_or_else(|errors| panic!("{text}\n{:#}", errors.located(&source))).0
}

/// The messages about a text, one for each line.
fn said(text: &str) -> String {
    let source = Source::new("test", text);
    let diagnostics = match Formula::parse(&source) {
        Ok((_, warnings)) => warnings,
        Err(errors) => errors,
    };
    diagnostics.located(&source).to_string()
}

/// The colour of a formula in which everything is constant.
fn colour(lines: &str) -> [f32; 3] {
    let graph = Graph::new(&parsed(&format!("formula; {lines}")));
    let leaf = |_| panic!("`{lines}` has no variables");
    graph.evaluate(&graph.result(), leaf).try_into().expect("three components")
}

#[test]
fn functions_are_called_with_values() {
    assert_eq!(colour("F(x) = x^2 + 1; = <F(3), F(F(1)), F(0) + F(2)>;"), [10.0, 5.0, 6.0]);
    // One definition serves scalars and vectors, and functions may be used before they are defined.
    assert_eq!(colour("G(x) = H(x, 2); H(a, b) = a*b; = G(<1, 2, 3>)*G(2);"), [8.0, 16.0, 24.0]);
    assert_eq!(colour("A = B(2); B(x) = x*C; C = 5; = <A, B(C), 0>;"), [10.0, 25.0, 0.0]);
    // Their own names hide all others, and only inside.
    assert_eq!(colour("x = 7; f(x) = x + 1; = <x, f(1), x>;"), [7.0, 2.0, 7.0]);
    // A call in a term of a sum does not see the sum's variable.
    assert_eq!(colour("i = 10; f(x) = x*i; = <sum(i, 1, 3, f(i)), 0, 0>;"), [60.0, 0.0, 0.0]);
}

#[test]
fn sums_and_products_are_written_out() {
    assert_eq!(colour("= <sum(i, 0, 4, i^2), product(i, 1, 5, i), sum(i, 1, 2, sum(j, i, 3, i*j))>;"), [30.0, 120.0, 16.0]);
    assert_eq!(colour("= sum(i, 1, 3, <1, i, i^2>);"), [3.0, 6.0, 14.0]);
    // Empty ranges, and bounds that are no whole numbers.
    assert_eq!(colour("= <sum(i, 2, 1, i), product(i, 2, 1, i), sum(i, 0.5, 2.5, i)>;"), [0.0, 1.0, 3.0]);
    assert_eq!(colour("= sum(i, 2, 1, <i>) + product(i, 2, 1, <i>);"), [1.0; 3]);
    assert_eq!(colour("n = 2*3; f(m) = sum(i, 1, m, i); = <f(n), f(2), sum(i, -1, 1, i)>;"), [21.0, 3.0, 0.0]);
    assert_eq!(colour("= <sum(i, 1, 256, 1), 0, 0>;"), [256.0, 0.0, 0.0]);
}

#[test]
fn sums_have_bounds() {
    assert_eq!(said("formula; = Cd*sum(i, 1, 257, i);"), "test:1:15: error: the sum has 257 terms\n");
    assert_eq!(said("formula; = Cd*sum(i, 1, kr, i);"), "test:1:25: error: a bound of a sum is not a constant\n");
    assert_eq!(said("formula; = Cd*sum(1, 1, 2, 3);"), "test:1:19: error: `sum` needs a name for its whole number\n");
    assert_eq!(said("formula; = Cd*sum(i, 1, 2);"), "test:1:15: error: `sum` takes 4 arguments, not 3\n");
    let nested = "formula; = Cd*sum(i, 1, 256, sum(j, 1, 256, sum(k, 1, 256, i*j*k)));";
    let large = "the formula has more than 100000 operations";
    assert_eq!(said(nested), format!("test:1:60: error: {large}\n"));
    // Each function calls the next one three times with other arguments.
    let chain: String = (0..30).map(|n| format!("f{n}(x) = f{0}(x) + f{0}(x + 1) + f{0}(2*x);", n + 1)).collect();
    assert!(said(&format!("formula; {chain} f30(x) = x*alpha; = Cd*f0(kr);")).contains(large));
    // With the same arguments a call is evaluated once.
    let chain: String = (0..30).map(|n| format!("f{n}(x) = f{0}(x) + f{0}(x) + f{0}(x);", n + 1)).collect();
    assert!(parsed(&format!("formula; {chain} f30(x) = x*alpha; = Cd*f0(kr);")).terms.len() < 1000);
}

#[test]
fn names_of_old_formulas_stay_theirs() {
    assert_eq!(colour("sum = 2; product = 3; = <sum, product, sum*product>;"), [2.0, 3.0, 6.0]);
    assert_eq!(colour("sum(a, b) = a + b; = <sum(1, 2)>;"), [3.0; 3]);
    assert_eq!(said("formula; T = 1; = <T>;"), "");
    // u, v and Ng are everybody's names.
    assert_eq!(said("formula; u = N.L; v(Ng) = Ng*u; = <v(2)>;"), "");
    assert_eq!(said("global; u: scalar; body_specific; v: scalar, default 2; formula; = <u*v>;"), "");
    assert_eq!(said("formula; f(u) = 2*u; = <sum(v, 0, 3, f(v))>;"), "");
    assert_eq!(said("formula; f(u) = 2*u; = <f(1 + u)>;"), "test:1:12: warning: the argument `u` hides a variable\n");
    assert_eq!(colour("u = 2; v = u + 1; = <u, v, sum(u, 0, 3, u)>;"), [2.0, 3.0, 6.0]);
    assert_eq!(said("formula; mix = 1; = <mix>;"), "test:1:10: warning: `mix` hides a function of the language\n");
    let predefined = parsed("body_specific; predefined: scalar; formula; = <predefined>;");
    assert!(predefined.parameter_named("predefined").is_some());
}

#[test]
fn mistakes_in_functions_are_marked_in_the_body_and_at_the_call() {
    let source = Source::new("test", "formula;\nf(x) = x + 1;\n= f(2)*f(Cd)*f(IL);\n");
    let errors = Formula::parse(&source).expect_err("a vector plus a scalar");
    insta::assert_snapshot!(format!("{:#}", errors.located(&source)), @r"
    test:2:10: error: `+` does not take a vector and a scalar
        f(x) = x + 1;
                 ^ no such operation
        2:8: a vector
        2:12: a scalar
        3:8: in this call
        help: the vector of three equal components is written `<1>`
        help: `+` takes scalar + scalar → scalar, vector + vector → vector
    ");
    assert_eq!(said("formula; f(x) = y; = Cd;"), "test:1:17: error: `y` is not known\n");
    assert_eq!(said("formula; f(x) = x; = Cd*f(1, 2);"), "test:1:25: error: `f` takes 1 argument, not 2\n");
    assert_eq!(said("formula; f(x) = f(x - 1); = Cd*f(1);"), "test:1:17: error: the function `f` uses itself\n");
    assert_eq!(
        said("formula; f(x) = M*x; M = f(1); = Cd*M;"),
        "test:1:26: error: macros and functions use each other in a circle: f → M → f\n"
    );
    assert_eq!(said("formula; f(N) = 2*N; = Cd*f(1);"), "test:1:12: warning: the argument `N` hides a variable\n");
    assert_eq!(
        said("formula; f(Cd, x, x) = 1; = IL;"),
        "test:1:12: warning: the argument `Cd` hides a parameter\ntest:1:19: error: two arguments have the name `x`\n"
    );
    assert_eq!(said("formula; f() = 1; = IL;"), "test:1:11: error: the function `f` has no arguments\n");
    assert_eq!(said("formula; f(x) = 1; f = 2; = IL;"), "test:1:20: error: `f` is named twice\n");
    assert_eq!(said("formula; f(x) = 1; = IL*f;"), "test:1:25: error: `f` is a function and needs arguments\n");
}

#[test]
fn conditions_are_numbers_in_parentheses() {
    assert_eq!(colour("is = 1 < 2; not = !(1 < 2) || 3 == 4; = <is, not, (2 > 1) + (2 >= 2)>;"), [1.0, 0.0, 2.0]);
    assert_eq!(colour("n = 3; = <if(n, 1, 2), if(n - 3, 1, 2), if(!n || n > 2 && n, 5, 6)>;"), [1.0, 2.0, 5.0]);
    assert_eq!(colour("f(x) = x > 1; = <f(2), f(0), if(f(2), 3, 4)>;"), [1.0, 0.0, 3.0]);
    // NaN differs from 0.
    assert_eq!(colour("nan = 0/0; = <if(nan, 1, 2), if(nan == nan, 1, 2), if(nan != 0, 1, 2)>;"), [1.0, 2.0, 1.0]);
    assert_eq!(colour("= if(1, <1, 2, 3>, <(2 > 1)>);"), [1.0, 2.0, 3.0]);
    assert_eq!(said("formula; = <max(0, 1 < 2)>;"), "test:1:22: error: `<` is outside of parentheses\n");
    assert_eq!(said("formula; = Cd*(Cd > 1);"), "test:1:19: error: `>` does not take a vector and a scalar\n");
    assert_eq!(said("formula; = (1 < 2);"), "test:1:13: error: the formula yields a scalar, but a colour is a vector\n");
    assert_eq!(said("formula; = if(Cd, IL, Cd);"), "test:1:15: error: the condition of `if` is a vector\n");
}

#[test]
fn functions_of_numbers_work_by_components_of_vectors() {
    assert_eq!(colour("v = <4, 9, 16>; = sqrt(v);"), [2.0, 3.0, 4.0]);
    assert_eq!(colour("v = <1, 2, 3>; = v^2 + 2^v + v^v;"), [4.0, 12.0, 44.0]);
    assert_eq!(colour("= clamp(<-1, 0.5, 2>, 0, 1) + max(0, <-1, 1, 2>);"), [0.0, 1.5, 3.0]);
    assert_eq!(colour("= mix(<1>, <2>, <0, 0.5, 1>) + saturate(<3>);"), [2.0, 2.5, 3.0]);
    assert_eq!(colour("= dot(<1, 2, 3>, <1>)*<1> + lerp(<0>, <2>, 0.5);"), [7.0; 3]);
    assert_eq!(
        said("formula; = perlin(point, Cd, 1, 2);"),
        "test:1:12: error: `perlin` does not take a vector and a vector and a scalar and a scalar\n"
    );
}

#[test]
fn cosines_stay_within_one() {
    let operations = |text: &str| {
        let formula = parsed(&format!("formula; = <{text}>;"));
        formula
            .terms
            .iter()
            .any(|term| matches!(term, crate::formula::Term::Apply(crate::lang::builtins::Operation::UnitDotVV, _)))
    };
    for unit in ["N.L", "dot(H, V)", "normalize(L - V).N", "(-L).R", "reflect(-L, N).V", "if(N.L > 0, T, B).H"] {
        assert!(operations(unit), "{unit}");
    }
    for other in ["Cd.L", "(L + V).N", "point.point", "(2*N).L"] {
        assert!(!operations(other), "{other}");
    }
}

#[test]
fn groupings_that_surprise_are_warned_of() {
    let quiet = ["= Cd*(N.L);", "= (Cd*N).L*IL;", "= IL*(N.L)*Cd;", "x = 2; = Cd*(-2^2 + (-x)^2 - x^2);", "= Cd*kr*(N.V)^5;"];
    for text in quiet {
        assert_eq!(said(&format!("formula; {text}")), "", "{text}");
    }
    let source = Source::new("test", "formula;\nx = 2;\n= Cd*N.L*IL*(1 - -x^2)*1 - N.V^5*Cd;\n");
    let (_, warnings) = Formula::parse(&source).expect("only warnings");
    insta::assert_snapshot!(format!("{:#}", warnings.located(&source)), @r"
    test:3:3: warning: `Cd*N.L` is read as `(Cd*N).L`
        = Cd*N.L*IL*(1 - -x^2)*1 - N.V^5*Cd;
          ^^^^^^ the dot product takes everything to its left along
        help: did you mean `Cd*(N.L)*IL*(1 - -x^2)*1`?
        help: parentheses make clear what is meant
    test:3:18: warning: `-x^2` is read as `(-x)^2`
        = Cd*N.L*IL*(1 - -x^2)*1 - N.V^5*Cd;
                         ^^^^ the minus binds more tightly than `^`
        help: write `-(x^2)` or `(-x)^2`
    test:3:28: warning: `N.V^5` is read as `N.(V^5)`
        = Cd*N.L*IL*(1 - -x^2)*1 - N.V^5*Cd;
                                   ^^^^^ the dot product takes everything to its left along
        help: did you mean `(N.V)^5*Cd`?
        help: parentheses make clear what is meant
    ");
}

#[test]
fn predefined_parameters_take_other_ranges() {
    let formula =
        parsed("predefined; ki: constraint 0..50, default 20; /* bright */ Cd: default <1, 0, 0>; kr: slider; formula; = Cd;");
    let ki = formula.parameter(formula.predefined(Predefined::Intensity));
    assert_eq!((ki.range, ki.default[0], ki.doc.as_deref()), (Some([0.0, 50.0]), 20.0, Some("bright")));
    let cd = formula.parameter(formula.predefined(Predefined::BodyColour));
    assert_eq!((cd.range, cd.default, cd.colour), (Some([0.0, 1.0]), [1.0, 0.0, 0.0], true));
    let narrow = parsed("predefined; Cd: constraint 0..0.5; formula; = Cd;");
    assert_eq!(narrow.parameter(narrow.predefined(Predefined::BodyColour)).default, [0.5; 3]);
    assert_eq!(said("predefined; kd: default 1; formula; = Cd;"), "test:1:13: error: `kd` is not a predefined parameter\n");
    assert_eq!(said("predefined; kr: default 1; kr: default 0; formula; = Cd;"), "test:1:28: error: `kr` is there twice\n");
    assert_eq!(
        said("predefined; kr: scalar, default 1; formula; = Cd;"),
        "test:1:17: error: the type of a predefined parameter stays as it is\n"
    );
    assert_eq!(
        said("predefined; kr: constraint 0..2; invariants; kr + kt = 1; formula; = Cd;"),
        "test:1:46: error: `kr` cannot take part in an invariant: its range is 0..2\n"
    );
}

#[test]
fn switches_and_choices_are_whole_numbers() {
    let formula = parsed(
        "body_specific; rough: scalar, switch, default 1; model: scalar, choices \"GGX\", \"Beckmann\", \"Phong\"; formula; = Cd;",
    );
    let [rough, model] = ["rough", "model"].map(|name| formula.parameter(formula.parameter_named(name).expect("a parameter")));
    assert_eq!((rough.range, rough.default[0], rough.clamp(0.4)), (Some([0.0, 1.0]), 1.0, (0.0, true)));
    assert_eq!((model.range, model.choices.len(), model.clamp(1.7).0, model.clamp(9.0).0), (Some([0.0, 2.0]), 3, 2.0, 2.0));
    let said = |attributes: &str| said(&format!("global; p: {attributes}; formula; = Cd;"));
    assert_eq!(said("vector, switch"), "test:1:20: error: `p` is a vector, and `switch` is for scalars\n");
    assert_eq!(said("scalar, switch, choices \"a\""), "test:1:28: error: `p` is a switch and has choices\n");
    assert_eq!(said("scalar, constraint 0..5, switch"), "test:1:20: error: `p` has a range and a `switch`\n");
    assert_eq!(said("scalar, switch, slider"), "test:1:28: warning: `p` gets no slider\n");
    assert_eq!(said("scalar, switch, default 0.5"), "test:1:28: warning: the default of `p` is no whole number\n");
    assert_eq!(said("scalar, choices \"a\", \"a\""), "test:1:33: error: the choice \"a\" is there twice\n");
    assert_eq!(
        said("scalar, choices a"),
        "test:1:28: error: expected a name in quotation marks, as in `choices \"GGX\", \"Beckmann\"`, found `a`\n"
    );
    assert_eq!(said("scalar, choices \"a\n"), "test:1:28: error: a text in quotation marks is not closed\n");
}

#[test]
fn a_term_of_a_hit_that_is_read_is_an_ordinary_macro() {
    use crate::lang::surface_terms::SurfaceTerm;
    let read = "formula; emission = <1>; = IL*Cd + emission;";
    assert_eq!(parsed(read).surface.get(SurfaceTerm::Emission), None);
    assert!(said(read).contains("warning: `emission` is an ordinary macro here, because the formula reads it"), "{}", said(read));
    // An argument and the variable of a sum of the same name are others.
    let hidden = "formula; emission = <1>; f(emission) = 2*emission; = IL*Cd*f(sum(emission, 1, 3, emission));";
    assert!(parsed(hidden).surface.get(SurfaceTerm::Emission).is_some());
    assert!(!said(hidden).contains("ordinary macro"), "{}", said(hidden));
}
