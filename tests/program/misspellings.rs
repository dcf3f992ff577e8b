//! The exact messages about what people type who know other languages, or think of paper.

use crate::{folder, told, write};

/// The messages about a formula file, with its text above.
pub(crate) fn said(text: &str) -> String {
    let folder = folder();
    write(&folder, "model", text);
    format!("{text}\n{}\n", told(folder.path(), "check --kind formula model"))
}

/// Each of these lines as the last line of a formula, with its messages.
pub(crate) fn lines(lines: &[&str]) -> String {
    let head = "body_specific;\na: scalar, constraint 0..1;\nformula;\n";
    lines.iter().map(|line| said(&format!("{head}{line}\n")).replace(head, "")).collect::<Vec<_>>().join("\n")
}

#[test]
fn declarations() {
    let sections = [
        "R: scalar;",
        "a: float;",
        "a: vec3, default <1, 0, 0>;",
        "a: vector, default #ff8800;",
        "a: scalar, range 0..1;",
        "a: scalar = 1;",
    ];
    let texts = sections.map(|line| said(&format!("body_specific;\n{line}\nformula;\n= Cd*max(0, N.L);\n")));
    insta::assert_snapshot!("declarations", texts.join("\n"));
    let texts = [
        "body-specific;\na: scalar;\nformula;\n= Cd*a;",
        "predefined;\nkd: default 1;\nformula;\n= Cd;",
        "body_specific;\npow: scalar;\nformula;\n= Cd*pow(0.5, 2);",
    ];
    insta::assert_snapshot!("sections", texts.map(said).join("\n"));
}

#[test]
fn statements() {
    insta::assert_snapshot!(
        "statements",
        lines(&[
            "Cd*max(0, N.L);",
            "float d = max(0, N.L);\n= Cd*d;",
            "d := N.L;\n= Cd*d;",
            "return Cd*a;",
            "let d = 1;\nreturn Cd*d;",
            "f(float x) = x;\n= Cd*f(1);",
            "d = 1\n= Cd*d;",
            "Cd = Cd*2;\n= Cd;"
        ])
    );
}

#[test]
fn groupings() {
    insta::assert_snapshot!(
        "groupings",
        lines(&[
            "= Cd*(N.L/N.V);",
            "= Cd*(1-N.V^5);",
            "= Cd*N.L;",
            "= Cd*N.L*IL + IL*R.V^20;",
            "= Cd*exp(-a^2);",
            "x = Cd*N.L/pi;\n= x + Cd;",
            "= Cd*pow(N.H, 20)*N.L;"
        ])
    );
}

#[test]
fn components() {
    insta::assert_snapshot!(
        "components",
        lines(&["= <Cd.x, 0, 0>;", "= <Cd[0], 0, 0>;", "= Cd*point.y;", "= Cd.rgb;", "= <Cd.a>;", "= Cd*getx(N.L);"])
    );
}

#[test]
fn words_of_other_languages() {
    insta::assert_snapshot!(
        "words",
        lines(&[
            "= Cd*NdotL;",
            "= Cd*cos_theta_i;",
            "= refract(-V, N, 1.5);",
            "= Cd/M_PI;",
            "= Cd*inversesqrt(a);",
            "= Cd*if(N.L > 0 and N.V > 0, 1, 0);",
            "= Cd*if(N.L ≤ 0, 0, 1);",
            "= vec3(1, 0, 0);",
            "= a > 0.5 ? Cd : IL;",
            "= Cd*(a > 0.5);",
            "= Cd*a > 0.5;",
            "= Cd*sinh(a);",
            "= Cd*a²;",
            "= Cd*sqrt{a};",
            "= Cd + 0.5;",
            "= 0.5;",
            "= Cd*ln(a);",
            "= Cd*|N.L|;",
            "= Cd*max(0, N·L);",
            "= Cd*roughness;",
            "= Cd*Max(0, N.L);",
            "= Cd*2a;",
        ])
    );
}

#[test]
fn words_that_are_kindly_accepted() {
    let text = lines(&["= Cd*saturate(dot(N, L));", "= lerp(Cd, IL, a)*tanh(1);", "= saturate(Cd)*a;"]);
    assert_eq!(text.matches("0 errors, 0 warnings").count(), 3, "{text}");
}

#[test]
fn characters_that_nobody_sees() {
    let text = ["= Cd*\u{200b}a;", "= Cd*\u{2028}a;", "= Cd\u{a0}* a; // \u{200b}", "= Cd*\u{1}a;", "= Cd*a;\u{feff}"];
    insta::assert_snapshot!("invisible", lines(&text).replace(['\u{200b}', '\u{2028}', '\u{1}', '\u{feff}'], "\u{fffd}"));
}
