//! The exact messages about what people type who know other languages: numbers, signs, statements, names and scenes.
//! Each mistake is one error, or one warning.

use crate::misspellings::{lines, said};
use crate::{folder, told, write};

/// Compares the messages about these lines, each of which is one mistake.
fn check_lines(name: &str, texts: &[&str]) {
    let text = lines(texts);
    insta::assert_snapshot!(name, text);
    check_count(&text, texts.len());
}

/// Compares the messages about these declarations, each of which is one mistake.
fn check_declarations(name: &str, declarations: &[&str]) {
    let texts = declarations.iter().map(|line| said(&format!("body_specific;\n{line}\nformula;\n= Cd*a;\n")));
    let text = texts.collect::<Vec<_>>().join("\n");
    insta::assert_snapshot!(name, text);
    check_count(&text, declarations.len());
}

/// Compares the messages about these scenes, each of which is one mistake.
fn check_scenes(name: &str, scenes: impl IntoIterator<Item = String>) {
    let folder = folder();
    let messages = scenes.into_iter().map(|scene| {
        write(&folder, "scene", &scene);
        format!("{scene}\n{}", told(folder.path(), "check --kind scene scene"))
    });
    let messages: Vec<String> = messages.collect();
    let text = messages.join("\n");
    insta::assert_snapshot!(name, text);
    check_count(&text, messages.len());
}

/// Whether a text tells of this many files with one error or one warning each.
fn check_count(text: &str, count: usize) {
    let of_one = text.matches(", 1 error, 0 warnings").count() + text.matches(", 0 errors, 1 warning\n").count();
    assert_eq!(of_one, count, "{text}");
}

#[test]
fn numbers() {
    check_lines(
        "numbers",
        &[
            "= Cd*1.0f;",
            "= Cd*1.f;",
            "= Cd*.5f;",
            "= Cd*0x10;",
            "= Cd*1e;",
            "= Cd*50%;",
            "= Cd*1_000;",
            "= Cd*cos(45deg);",
            "= Cd*1e400;",
            "= Cd*1e39;",
            "= Cd*5(N.L);",
            "= Cd*2 N.L;",
            "= Cd*cos^2(alpha);",
        ],
    );
}

#[test]
fn signs() {
    check_lines(
        "signs",
        &[
            "% comment\n= Cd*a;",
            "# comment\n= Cd*a;",
            "= Cd*\\max(0, a);",
            "= Cd \\cdot a;",
            "= Cd*\\frac{1}{a};",
            "= Cd*\\alpha;",
            "= Cd*sum_{i=1}^{3} i;",
            "= Cd*Σ(i, 1, 3, i);",
            "= Cd*√a;",
            "= Cd·a;",
            "= Cd×a;",
            "= Cd*π;",
            "= Cd*a²;",
            "= Cd*a^{5};",
            "= Cd*a**2;",
            "= Cd*max(0; N.L);",
            "= <1; 0, 0>;",
            "= (1, 0, 0);",
            "= Cd*std::max(0, a);",
            "= Cd*if(a =< 1, 1, 0);",
            "= Cd*if(a <> 1, 1, 0);",
            "= Cd*if(a = 1, 1, 0);",
        ],
    );
}

#[test]
fn statements_of_other_languages() {
    check_lines(
        "foreign_statements",
        &[
            "F(x) { return x*2; }\n= Cd*F(a);",
            "float F(float x) { return x*2; }\n= Cd*F(a);",
            "def F(x):\n    return x*x\n= Cd*F(a);",
            "function y = F(x)\n  y = x*2;\nend\n= Cd*F(a);",
            "F = lambda x: x*2;\n= Cd*F(a);",
            "F = @(x) x*2;\n= Cd*F(a);",
            "const float d = a;\n= Cd*d;",
            "uniform float k;\n= Cd*k;",
            "if (a > 0.5) { D = 1; } else { D = 2; }\n= Cd*D;",
            "if a > 0.5:\n    D = 1\nelse:\n    D = 2\n= Cd*D;",
            "D = 0;\nfor (int i = 0; i < 3; i++) { D += i; }\n= Cd*D;",
            "for i = 1:3\n D = i;\nend\n= Cd*D;",
            "import math\n= Cd;",
            "D = 1;\nD += 2;\n= Cd*D;",
            "D == 1;\n= Cd*D;",
            "void main() {\n  gl_FragColor = vec4(Cd, 1.0);\n}",
            "= Cd*(a if a > 0.5 else 1);",
            "= Cd*if(a > 1, 1);",
            "= Cd*if(a > 0.5) 1 else 0;",
            "= Cd*a;;",
        ],
    );
}

#[test]
fn names_of_other_languages() {
    check_lines(
        "foreign_names",
        &[
            "= Cd*theta;",
            "= Cd*theta_h;",
            "= Cd*theta_d;",
            "= Cd*(lightDir.N);",
            "= Cd*(N.viewDir);",
            "= Cd*(normal.L);",
            "= Cd*(N.halfVector);",
            "= Cd*math.exp(a);",
            "= Cd*np.pi;",
            "= Cd*Math.pow(a, 2);",
            "= Cd*np.arccos(a);",
            "= Cd*e^(a);",
            "= Cd*if(on, 1, 0);",
            "= Cd*if(false, 1, 0);",
            "= Cd*if(any(Cd), 1, 0);",
            "= Cd*Sum(i, 1, 3, i);",
            "= Cd*powf(a, 2);",
            "= Cd*uv;",
            "= NG*a;",
            "= Cd*texture(a);",
            "= Cd*sin(N, 1);",
            "= Cd*pow(a);",
            "= Cd*cos alpha;",
            "= 1/Cd;",
            "x = Cd.x;\n= <x>;",
        ],
    );
}

#[test]
fn silent_mistakes() {
    check_lines(
        "silent",
        &[
            "reflectd = a;\n= Cd;",
            "emision = Cd;\n= Cd;",
            "Reflected = a;\n= Cd;",
            "ambiant = Cd;\n= Cd;",
            "mirror = a;\n= Cd;",
            "x = 1;\n= Cd;",
            "F(x) = x;\n= Cd;",
            "reflected(x) = x;\n= Cd;",
            "reflected(x) = x;\n= Cd*reflected(a);",
            "= Cd*sum(i, 0, 2.5, i);",
            "= Cd*sum(i, 0, 0/0, i);",
            "= Cd*sum(i, 0, 1e30, i);",
            "x = !a + 1;\n= Cd*x;",
            "F(x) = x + foo;\n= Cd;",
            "F(x) = Cd + 1 + x;\n= Cd;",
            "F(x) = sqrt(x, 1, 2);\n= Cd;",
        ],
    );
}

#[test]
fn declarations_of_other_languages() {
    check_declarations(
        "foreign_declarations",
        &[
            "a: scalar, constraint 0...5;",
            "a: scalar, constraint [0, 1];",
            "a: scalar, constraint 0 to 1;",
            "a: scalar, constraint 0-1;",
            "a: scalar, constraint >= 0;",
            "a: scalar, range [0, 1];",
            "a: scalar, default 1/3;",
            "a: scalar, default pi;",
            "a: scalar, default true;",
            "a: scalar, default = 0.5;",
            "a: scalar, default 0,5;",
            "a: vector, default <0.5>;",
            "a: vector, default (1, 0, 0);",
            "a: vector, default rgb(255, 0, 0);",
            "a: vector, default #ff8800;",
            "a: scalar, choices \"x\", \"y\", default \"y\";",
            "a: scalar, slider 0..1;",
            "scalar a = 0.5;",
            "const float a = 0.5;",
            "a, m: scalar;",
            "a: enum { A, B };",
            "a: bool;",
            "a: int;",
            "a: switch;",
            "a: color;",
            "a: scaler;",
            "a = 0.5;",
            "a: scalar, default 1e999;",
        ],
    );
}

#[test]
fn sections_of_other_names() {
    let texts = [
        "body-specific;\na: scalar;\nformula;\n= Cd*a;",
        "body;\na: scalar;\nformula;\n= Cd*a;",
        "parameters;\na: scalar;\nformula;\n= Cd*a;",
        "body_specific:\na: scalar;\nformula;\n= Cd*a;",
        "body_specific;\na: scalar;\nFormula;\n= Cd*a;",
        "formula:\n= Cd;",
        "formula;\nbody_specific;\na: scalar;\n= Cd*a;",
        "global;\nka: constraint 0..2;\nformula;\n= Cd;",
        "global;\nka: scalar, constraint 0..2;\nformula;\n= Cd;",
        "predefined;\nkr: switch;\nformula;\n= Cd;",
        "predefined;\nki: choices \"a\", \"b\";\nformula;\n= Cd;",
        "invariants;\nkr = 1 - kt;\nformula;\n= Cd;",
    ];
    let text = texts.map(said).join("\n");
    insta::assert_snapshot!("foreign_sections", text);
    check_count(&text, texts.len());
}

#[test]
fn formulas_that_are_too_long_are_refused() {
    let text = said(&format!("formula;\n= {}Cd;", "Cd + ".repeat(200_000))).replace("Cd + ", "");
    assert!(text.contains("the formula has more than 100000 operations"), "{text}");
    assert_eq!(text.matches("Error: ").count(), 1, "{text}");
}

#[test]
fn numbers_that_are_too_large_are_refused() {
    let folder = folder();
    let text = told(folder.path(), "render session.toml -o out.png --set ball.h=1e999");
    insta::assert_snapshot!("large_value", text);
}

/// The clauses of a camera without a mistake.
const CAMERA: &str = "position <0,1,6>; gaze <0,0,-1>; up <0,1,0>; fov 40;\n";

#[test]
fn bodies_of_other_programs() {
    let bodies = [
        "b: sphere, <0,1,0>, 1;",
        "b: sphere, radius 1, center <0,1,0>;",
        "b: sphere, center: <0,1,0>, radius 1;",
        "b: sphere, center <0,1,0>, radius = 1;",
        "b: sphere, center (0,1,0), radius 1;",
        "b: sphere, center <0,0,0>, radius 1/2;",
        "b: sphere, center <0,0,0>, radius 1, color <1,0,0>;",
        "b: sphere, center <0,0,0>, radius 1, ior 1.5;",
        "b: cube, <0,0,0>, 1;",
        "b: disk, <0,1,0>, 1;",
        "b: plane, <0,1,0>, 0;",
        "b: mesh, \"a.obj\";",
        "b: torus;",
        "b = sphere, center <0,0,0>, radius 1;",
        "sphere b, center <0,0,0>, radius 1;",
        "sphere: center <0,0,0>, radius 1;",
        "k: point, <1,2,3>;",
    ];
    check_scenes("foreign_bodies", bodies.map(|body| format!("bodies;\n{body}\nlights;\ncamera;\n{CAMERA}")));
}

#[test]
fn lights_and_cameras_of_other_programs() {
    let lights = [
        "k: point, position <1,2,3>;",
        "k: point, (1,2,3);",
        "k: sun, <0,-1,0>;",
        "k: spot, <1,2,3>, direction <0,-1,0>, cutoff 30;",
        "k: area, <0,1,0>;",
        "k: ambient, <1,1,1>;",
        "k: point, <1,2,3>, intensity 5;",
    ];
    let lights = lights.map(|light| format!("bodies;\nlights;\n{light}\ncamera;\n{CAMERA}"));
    let cameras = [
        "position <0,1,6>; lookat <0,0,0>; up <0,1,0>; fov 40;",
        "position <0,1,6>; look_at <0,-1,0>; up <0,1,0>; fov 40;",
        "position <0,1,6>; target <0,0,0>; up <0,1,0>; fov 40;",
        "eye <0,1,6>; gaze <0,0,-1>; up <0,1,0>; fov 40;",
        "position <0,1,6>; gaze <0,0,-1>; up <0,1,0>; angle 40;",
        "position <0,1,6>; gaze <0,0,-1>; fov 40; up <0,1,0>;",
    ];
    let cameras = cameras.map(|camera| format!("bodies;\nlights;\ncamera;\n{camera}\n"));
    let sections = [
        format!("bodies;\nlights;\n{CAMERA}"),
        format!("objects;\nlights;\ncamera;\n{CAMERA}"),
        format!("bodies;\nlights:\ncamera;\n{CAMERA}"),
    ];
    check_scenes("foreign_lights_and_cameras", lights.into_iter().chain(cameras).chain(sections));
}
