//! Measured materials from the command line: pictures, mistakes and what is not possible with them.

use crate::files::render;
use crate::{folder, told, write};
use glam::DVec3;
use illuminator::measured::merl;
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

const SCENE: &str = "bodies;\nball: sphere, center <0,0,0>, radius 1;\nlights;\nl: point, <2,3,4>;\nm: point, <-3,1,2>;\n
    camera;\nposition <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 30;\n";

/// A file of the MERL format beside the other files.
fn write_merl(folder: &tempfile::TempDir, name: &str, reflectance: impl Fn(DVec3, DVec3) -> DVec3) {
    std::fs::write(folder.path().join(name), merl::bytes(reflectance)).expect("a file");
}

/// The pictures of two formulas by a backend, with the environment dark.
fn both(folder: &Path, backend: &str, names: [&str; 2]) -> [image::Rgb32FImage; 2] {
    names.map(|name| {
        let arguments = format!("--formula {name} --scene s.scene --size 48x40 --backend {backend}");
        render(folder, &arguments, "out.exr").into_rgb32f()
    })
}

#[test]
fn a_matte_file_gives_the_picture_of_the_matte_formula() {
    let folder = folder();
    write_merl(&folder, "matte.binary", |_, _| DVec3::new(0.5, 0.25, 1.0) / PI);
    write(&folder, "s.scene", SCENE);
    write(&folder, "a.formula", "formula;\n= IL*measured(\"matte.binary\")*max(0, N.L);\n");
    write(&folder, "b.formula", "formula;\n= IL*<0.5, 0.25, 1>*max(0, N.L);\n");
    for backend in ["jit", "interpreter"] {
        let [measured, matte] = both(folder.path(), backend, ["a.formula", "b.formula"]);
        assert!(matte.pixels().filter(|pixel| pixel.0[2] > 0.3).count() > 100, "the ball is seen");
        for (found, expected) in measured.pixels().zip(matte.pixels()) {
            assert!(
                found.0.iter().zip(expected.0).all(|(found, expected)| (found - expected).abs() < 1e-5),
                "{found:?} {expected:?}"
            );
        }
    }
}

#[test]
fn a_file_of_a_known_model_gives_nearly_its_picture() {
    let folder = folder();
    // Blinn's highlight on a matte ground.
    let model = |light: DVec3, view: DVec3| {
        let highlight = (light + view).normalize().z.powi(30);
        (DVec3::new(0.4, 0.2, 0.1) + DVec3::splat(2.0 * highlight)) / PI
    };
    write_merl(&folder, "plastic.binary", model);
    write(&folder, "s.scene", SCENE);
    write(&folder, "a.formula", "formula;\n= IL*measured(\"plastic.binary\")*max(0, N.L);\n");
    write(&folder, "b.formula", "formula;\n= IL*(<0.4, 0.2, 0.1> + <2>*(N.H)^30)*max(0, N.L);\n");
    for backend in ["jit", "interpreter"] {
        let [measured, known] = both(folder.path(), backend, ["a.formula", "b.formula"]);
        let brightest = known.pixels().map(|pixel| pixel.0[0]).fold(0.0, f32::max);
        assert!(brightest > 1.0, "a highlight is seen");
        for (found, expected) in measured.pixels().zip(known.pixels()) {
            let close = |(found, expected): (&f32, f32)| (found - expected).abs() < 0.005 * expected + 1e-3;
            assert!(found.0.iter().zip(expected.0).all(close), "{found:?} {expected:?}");
        }
    }
}

#[test]
fn mistakes_with_measured_materials_are_explained() {
    let folder = folder();
    write(&folder, "s.scene", SCENE);
    write(&folder, "empty.binary", "");
    write(&folder, "list.csv", "0,0,30,0,0.1,0.1,0.1\n");
    write(&folder, "torn.bsdf", "tensor_file\0\u{1}\0\u{1}\0");
    write(&folder, "other.bsdf", "\u{1}\u{2}\u{3}");
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/measured/isotropic_rgb.bsdf");
    std::fs::copy(reference, folder.path().join("gold.bsdf")).expect("copied");
    let mut text = String::new();
    for formula in [
        "= IL*measured(\"gold.bsdf\")*max(0, N.L);",
        "= IL*measured(\"godl.bsdf\")*max(0, N.L);",
        "= IL*measured(\"empty.binary\")*max(0, N.L);",
        "= IL*measured(\"torn.bsdf\");\n",
        "= IL*measured(\"other.bsdf\");",
        "= IL*measured(\"list.csv\");",
        "= IL*measured(\"sub\");",
        "= IL*measured(\"\");",
        "A = measured(\"one.bsdf\"); = A + measured(\"one.bsdf\") + measured(\"two.bsdf\");",
        "= IL*measured(gold);",
        "= IL*measured(gold.bsdf);",
        "= IL*measured();",
        "= IL*measured;",
        "= IL*measured(N);",
        "= IL*measured(\"gold.bsdf\", L);",
        "= IL*measured(\"gold.bsdf\", N.L, V);",
        "= IL*measured(\"gold.bsdf\", \"gold.bsdf\", V);",
        "= IL*measured(\"gold.bsdf\", L, V, N);",
        "= IL*mesured(\"gold.bsdf\");",
        "= IL*max(\"gold.bsdf\", 1);",
        "= measured(\"gold.bsdf\").N;",
        "emission = measured(\"gold.bsdf\"); = IL;",
        "emission = measured(\"gold.bsdf\", V, N); = IL;",
        "measured(x) = x*x; = IL*measured(\"gold.bsdf\");",
        "measured = 2; = IL*measured;",
        "= IL*measured(\"gold.bsdf;",
    ] {
        write(&folder, "f", &format!("formula;\n{formula}\n"));
        writeln!(text, "{formula}\n{}", told(folder.path(), "check f --kind formula")).expect("a text");
    }
    write(&folder, "f", "formula;\n= IL*measured(\"gold.bsdf\")*max(0, N.L);\n");
    for arguments in ["export f --to glsl", "export f --to brdf", "export f --to materialx", "fmt f --check"] {
        writeln!(text, "{arguments}\n{}", told(folder.path(), arguments)).expect("a text");
    }
    insta::assert_snapshot!(text);
}
