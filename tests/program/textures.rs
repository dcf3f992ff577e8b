//! Textures from the command line: values, mistakes and pictures.

use crate::files::render;
use crate::{folder, told, write};
use image::{Rgb, RgbImage};
use std::fmt::Write;

/// Left red, right grey of which sRGB has 188.
fn halves() -> RgbImage {
    RgbImage::from_fn(4, 2, |x, _| if x < 2 { Rgb([255, 0, 0]) } else { Rgb([188; 3]) })
}

const SCENE: &str = "bodies;\nwall: rectangle, <-1,-1,0>, <-1,1,0>, <1,1,0>;\nlights;\nl: point, <0,0,9>;\n
    camera;\nposition <0,0,3>; gaze <0,0,-1>; up <0,1,0>; fov 30;\n";

#[test]
fn a_picture_shows_the_image() {
    let folder = folder();
    halves().save(folder.path().join("halves.png")).expect("a file");
    // u goes from the first corner to the second, upwards.
    write(
        &folder,
        "t.formula",
        "body_specific;\nwood: texture, default \"halves.png\";\nformula;\nemission = wood(v, u);\nambient = <0>;\n= <0>;\n",
    );
    write(&folder, "t.scene", SCENE);
    for backend in ["jit", "interpreter"] {
        let arguments = format!("--formula t.formula --scene t.scene --size 64x48 --backend {backend}");
        let picture = render(folder.path(), &arguments, "out.exr").into_rgb32f();
        assert_eq!(picture.get_pixel(20, 24).0, [1.0, 0.0, 0.0]);
        let grey = picture.get_pixel(44, 24).0;
        assert!(grey.iter().all(|component| (component - 0.502_886_5).abs() < 1e-5), "{grey:?}");
        let white = render(folder.path(), &format!("{arguments} --set wall.wood=none"), "out.exr").into_rgb32f();
        assert_eq!(white.get_pixel(20, 24).0, [1.0; 3]);
    }
}

#[test]
fn mistakes_with_textures_are_explained() {
    let folder = folder();
    halves().save(folder.path().join("halves.png")).expect("a file");
    write(&folder, "t.scene", SCENE);
    write(&folder, "torn.png", "\u{89}PNG");
    write(&folder, "good", "body_specific;\nwood: texture;\nformula;\n= IL*wood(u, v);\n");
    let session = "version = 1\nformula = \"good\"\nscene = \"t.scene\"\n[bodies.wall]\nwood = \"hales.png\"\n";
    write(&folder, "t.toml", session);
    let formulas = [
        "wood: texture, default \"hales.png\";|= IL*wood(u, v);",
        "wood: texture, default \"torn.png\";|= IL*wood(u, v);",
        "wood: texture, default \"\";|= IL*wood(u, v);",
        "wood: texture, default 0.5, slider, constraint 0..1;|= IL*wood(u, v);",
        "wood: texture, default halves.png;|= IL*wood(u, v);",
        "wood: scalar, default \"halves.png\";|= IL*wood;",
        "wood: sampler2D;|= IL*wood(u, v);",
        "wood: texture;|= IL*wood;",
        "wood: texture;|= IL*wood(u);",
        "wood: texture;|= IL*wood(N, v);",
        "wood: texture;|= IL*texture(wood, u, v);",
        "wood: texture;\ninvariants; wood + kr = 1;|= IL*wood(u, v);",
        "wood: texture;|F(t) = t(u, v); = IL*F(wood);",
        "p: scalar;|= IL*p(u, v);",
    ];
    let mut text = String::new();
    for formula in formulas {
        write(&folder, "f", &format!("body_specific;\n{}\n", formula.replace('|', "\nformula;\n")));
        writeln!(text, "{formula}\n{}", told(folder.path(), "check f --kind formula")).expect("a text");
    }
    for arguments in [
        "check t.toml",
        "render t.toml -o out.png",
        "render t.toml -o out.png --set wall.wood=halves.png",
        "render --formula good --scene t.scene -o out.png --set wall.wood=halvse.png",
        "render --formula good --scene t.scene -o out.png --set wall.wood=torn.png",
        "render --formula good --scene t.scene -o out.png --set wall.wood=3",
        "render --formula good --scene t.scene -o out.png --set wall.kr=halves.png",
        "sweep --formula good --scene t.scene -o out.png --vary wall.wood=halves.png,torn.png",
        "sweep --formula good --scene t.scene -o out.png --vary wall.wood=0..1:3",
    ] {
        writeln!(text, "{arguments}\n{}", told(folder.path(), arguments)).expect("a text");
    }
    insta::assert_snapshot!(text);
}
