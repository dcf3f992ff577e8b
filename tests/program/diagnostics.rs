//! The messages of `check` about mistakes in formulas.

use crate::{folder, run, told, write};

/// All errors and warnings of a formula.
fn said(text: &str) -> String {
    let folder = folder();
    write(&folder, "model.formula", text);
    String::from_utf8(run(folder.path(), "check --kind formula model.formula").stderr).expect("text")
}

#[test]
fn five_mistakes_are_five_errors() {
    let text = "body_specific;
kd: scalar, constraint 1..0, default 0.2, slider;
ks: scalar, constraint 0..1, default 0.5, slidr;
invariants;
kd + kz = 1;
formula;
DIFFUSE = kd*IL*Cd*maxx(0, N.L);
SPECULAR = ks*IL*pow(R.V);
= DIFFUSE + SPECULAR;
";
    let said = said(text);
    assert_eq!(said.matches("Error: ").count(), 5, "{said}");
    insta::assert_snapshot!(said);
}

#[test]
fn a_dot_product_of_a_product_is_explained() {
    insta::assert_snapshot!("dot_result", said("formula;\n= Cd*N.L;\n"));
    insta::assert_snapshot!("dot_in_macro", said("formula;\nD = IL*Cd*N.L;\n= D + Cd;\n"));
}

#[test]
fn numbers_before_names_are_explained() {
    insta::assert_snapshot!(said("formula;\nA = 1.N;\nB = 2 kr;\n= <A, B, 3(kt)>;\n"));
}

#[test]
fn names_that_are_taken_or_hidden_are_said() {
    insta::assert_snapshot!(said(
        "body_specific;\nCd: vector;\nH: scalar;\nsqrt: scalar;\nx: scalar;\nbackground: vector;\nformula;\nx = 1;\nN = 2;\nabs = H;\n= Cd*abs;\n"
    ));
}

#[test]
fn circles_of_macros_are_shown() {
    insta::assert_snapshot!(said("formula;\nA = B + 1;\nB = C*2;\nC = A;\nD = D;\n= <A, B, D>;\n"));
}

#[test]
fn substitution_that_would_differ_is_warned_of() {
    let text = "formula;\nM = alpha + beta;\nP = alpha*beta;\nQ = M;\n= <M*2, 1/P, Q^2> + <M + 1, 2*P, 1 - (M)>;\n";
    let folder = folder();
    write(&folder, "model", text);
    insta::assert_snapshot!(told(folder.path(), "check --thesis model"));
    // Everybody expects the value, so that nothing is said unless asked.
    assert!(told(folder.path(), "check model").contains("0 warnings"));
}

#[test]
fn the_thesis_formula_gives_two_warnings() {
    let said = said(include_str!("../../presets/formula/phong-thesis.formula"));
    assert_eq!(said.matches("Warning: ").count(), 2, "{said}");
    insta::assert_snapshot!(said);
}

#[test]
fn invariants_that_cannot_hold_are_refused() {
    insta::assert_snapshot!(said(
        "body_specific;\na: scalar, constraint 0..1;\nb: scalar, constraint 0..1;\nc: scalar, constraint 0..2;\nl: vector;\nglobal;\ng: scalar, constraint 0..1;\n\
         invariants;\na = 1;\nb = 1;\na + b <= 1;\na + c = 1;\na + l = 1;\na + g = 1;\na + nix = 1;\nformula;\n= Cd*a;\n"
    ));
}

#[test]
fn conditions_are_explained() {
    insta::assert_snapshot!(said(
        "formula;\nA = alpha < beta;\nB = if(alpha, 1, 2);\nC = if(1 < 2 < 3, 1, 2);\nD = if(alpha > 1, Cd, 2);\nE = if(Cd == Cd, 1, 2);\n= Cd;\n"
    ));
}

#[test]
fn wrong_structure_is_explained() {
    insta::assert_snapshot!("no_result", said("formula;\nA = 1;\n"));
    insta::assert_snapshot!("stray_word", said("formula;\nA = 1;\nstray\n= A*Cd;\n"));
    // There is one mistake, not two: the skipped part is the result.
    insta::assert_snapshot!("stray_words", said("formula;\nA = 1;\nstray words\n= A*Cd;\n"));
    insta::assert_snapshot!("empty", said(""));
    insta::assert_snapshot!("scene_given", said("bodies;\nlights;\n"));
    insta::assert_snapshot!("declaration_outside", said("kd: scalar;\nformula;\n= Cd;\n"));
    insta::assert_snapshot!("forgotten_semicolon", said("formula;\nA = Cd\nB = IL;\n= A*B\n"));
    insta::assert_snapshot!("behind_the_end", said("formula;\n= Cd;\nA = 1;\n"));
    insta::assert_snapshot!("open_parenthesis", said("formula;\nA = (1 + 2;\n= Cd*max(0, N.L;\n"));
}

#[test]
fn deep_and_long_texts_are_parsed() {
    let deep = said(&format!("formula;\n= {}Cd{};", "(".repeat(100_000), ")".repeat(100_000)));
    assert!(deep.contains("nested too deeply"), "{deep}");
    let minus = said(&format!("formula;\n= {}Cd;", "-".repeat(100_000)));
    assert!(minus.contains("nested too deeply"), "{minus}");
    let power = said(&format!("formula;\n= Cd*{}2;", "2^".repeat(100_000)));
    assert!(power.contains("nested too deeply"), "{power}");
    let long = said(&format!("formula;\n= {}Cd;", "Cd + ".repeat(30_000)));
    assert_eq!(long, "");
    let chain: String = (1..20_000).map(|index| format!("M{index} = M{};\n", index - 1)).collect();
    assert_eq!(said(&format!("formula;\nM0 = Cd;\n{chain}= M19999;\n")), "");
    let garbage = said(&"§".repeat(1_000_000));
    assert!(garbage.contains("not part of the language"));
}
