//! Formulas in other languages, from the command line.

use crate::messages::check;
use crate::{folder, run, told, write};
use std::fs;

#[test]
fn a_formula_is_written_to_a_file_or_to_standard_output() {
    let folder = folder();
    let printed = String::from_utf8(run(folder.path(), "export model.txt --to wgsl").stdout).expect("text");
    insta::assert_snapshot!("wgsl", printed);
    assert_eq!(
        told(folder.path(), "export model.txt --to wgsl -o model.wgsl"),
        "model.wgsl: model.txt in WGSL, for WebGPU\nexit status 0\n"
    );
    assert_eq!(fs::read_to_string(folder.path().join("model.wgsl")).expect("a file"), printed);
    for language in ["c", "glsl", "hlsl", "osl", "materialx", "brdf"] {
        let printed = String::from_utf8(run(folder.path(), &format!("export model.txt --to {language}")).stdout).expect("text");
        insta::assert_snapshot!(language, printed);
    }
}

#[test]
fn what_cannot_be_exported_is_said() {
    let folder = folder();
    write(&folder, "wrong.formula", "formula; = kd;");
    write(&folder, "textured.formula", "body_specific; wood: texture; formula; = IL*wood(N.L, 0);");
    check(
        "export",
        &folder,
        &[
            "export model.txt",
            "export model.txt --to java",
            "export sub/place.txt --to c",
            "export session.toml --to c",
            "export preset:studio --to c",
            "export wrong.formula --to c",
            "export preset:marble --to brdf",
            "export textured.formula --to brdf",
            "export model.txt --to c -o model.txt",
            "export model.txt --to c -o nowhere/model.h",
        ],
    );
    assert!(fs::read_to_string(folder.path().join("model.txt")).expect("a file").starts_with("body_specific"));
}

#[test]
fn comments_of_authors_stay_in_their_lines() {
    let folder = folder();
    let formula = "body_specific;\nkd: scalar; // one \\ two\u{2028}three ??/\nks: scalar; // end ??/\nformula;\n= kd*Cd*ks;\n";
    write(&folder, "odd.formula", formula);
    for language in ["c", "glsl", "hlsl", "wgsl", "osl", "materialx", "brdf"] {
        let printed = String::from_utf8(run(folder.path(), &format!("export odd.formula --to {language}")).stdout).expect("text");
        assert!(printed.contains("three") && !printed.contains(['\\', '\u{2028}']) && !printed.contains("??/"), "{printed}");
    }
}
