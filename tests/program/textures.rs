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
    write(&folder, "empty.png", "");
    write(&folder, "none", "a file of this name is not read");
    halves().save_with_format(folder.path().join("photo"), image::ImageFormat::Png).expect("a file");
    let library = "version = 1\n[bad]\nwood = \"nope.png\"\n[photo]\nwood = \"photo\"\n[white]\nwood = \"none\"\nkr = \"0.1\"\n";
    write(&folder, "lib.toml", library);
    for word in ["photo", "none"] {
        let session = format!("version = 1\nformula = \"good\"\nscene = \"t.scene\"\n[bodies.wall]\nwood = \"{word}\"\n");
        write(&folder, &format!("{word}.toml"), &session);
    }
    write(&folder, "good", "#uses lib.toml;\nbody_specific;\nwood: texture;\nformula;\n= IL*wood(u, v);\n");
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
        "check t.toml photo.toml none.toml lib.toml",
        "render --formula good --scene t.scene -o bad.png --material wall=bad",
        "sweep --formula good --scene t.scene -o bad.png --vary wall.kr=0..1:2 --material *=bad",
        "dump --formula good --scene t.scene --stage rays --pixel 1,1 --material wall=bad",
        "verify --formula good --scene t.scene --material wall=bad",
        "render --formula good --scene t.scene -o out.png --material wall=photo",
        "render --formula good --scene t.scene -o out.png --material wall=white",
        "render t.toml --formula good -o bad.png",
        "render --formula good --scene t.scene -o out.png --set wall.wood=",
        "render --formula good --scene t.scene -o out.png --set wall.wood=\"photo\"",
        "render --formula good --scene t.scene -o out.png --set wall.kr=",
        "render --formula good --scene t.scene -o bad.png --set wall.wood=empty.png",
        "render --formula good --scene t.scene -o bad.png --set wall.wood=empty.png --set wall.kr=x.png",
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
    assert!(!folder.path().join("bad.png").exists(), "no picture where an image is missing");
}
