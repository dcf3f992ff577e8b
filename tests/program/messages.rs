//! The exact messages about wrong input and wrong command lines.

use crate::{FORMULA, SCENE, folder, told, write};

/// Compares the results of several command lines with the stored text.
pub(crate) fn check(name: &str, folder: &tempfile::TempDir, command_lines: &[&str]) {
    let texts = command_lines.iter().map(|arguments| format!("$ illuminator {arguments}\n{}", told(folder.path(), arguments)));
    insta::assert_snapshot!(name, texts.collect::<Vec<_>>().join("\n"));
}

#[test]
fn command_lines() {
    let folder = folder();
    check(
        "command_lines",
        &folder,
        &[
            "frobnicate",
            "render",
            "render -o out.gif",
            "render -o nowhere/out.png",
            "render -o sub",
            "render -o out.png --size 0x480",
            "render -o out.png --size 640",
            "render -o out.png --depth 10",
            "render -o out.png --samples 65537",
            "render -o out.png --samples -1",
            "render -o out.png --samples 1e3",
            "render -o out.png --threads 0",
            "render -o out.png --ior -1",
            "render -o out.png --background red",
            "render -o out.png --memory much",
            "render -o out.png --set ball",
            "render -o out.png --set ball.kd=nan",
            "render session.toml -o out.png --set bal.kd=1 --set ball.kq=1 --set kd=1 --set ball.Cd=1 --set ball.kd=<1,1,1>",
            "bench session.toml --slider ball.x",
            "dump --stage hits",
            "dump --stage ast -o out",
            "dump session.toml --stage bytecode --pixel 99,1",
            "dump session.toml --stage rays",
            "dump session.toml --stage rays --pixel 5,24",
            "dump session.toml --stage rays --pixel 5,2 --pass 1",
            "dump session.toml --stage rays --pixel 5,2 --samples 4 --pass 4",
            "dump session.toml --stage hits --pass 1 -o hits",
            "dump session.toml --stage asm --samples 4",
            "dump session.toml --stage clif --pixel 1,1",
            "check",
        ],
    );
}

#[test]
fn files() {
    let folder = folder();
    write(&folder, "binary", "\u{0}");
    std::fs::write(folder.path().join("latin"), b"formula; = \xe9;").expect("a file");
    write(&folder, "ball.obj", "v 0 0 0\n");
    write(&folder, "old.png", "");
    check(
        "files",
        &folder,
        &[
            "render -o out.png none.toml",
            "render -o out.png --formula modell.txt",
            "render -o out.png --formula sub",
            "render -o out.png --scene preset:glas",
            "render -o out.png --formula preset:glass",
            "render -o out.png model.txt",
            "render -o out.png --formula sub/place.txt --scene model.txt",
            "render session.toml -o out.png --size 4000x4000 --memory 1 --threads 1",
            "check latin binary sub none.txt",
            "render -o out.png ball.obj",
            "render -o out.png --scene ball.obj",
            "render -o out.png old.png",
            "preview ball.obj",
            "check ball.obj old.png",
        ],
    );
}

#[test]
fn warnings_do_not_stop_the_picture() {
    let folder = folder();
    let stale = std::fs::read_to_string(folder.path().join("session.toml")).expect("the session")
        + "shine = 1\n[bodies.cone]\nkd = 1\n[lights.key]\nkd = 1\nki = [1, 1, 1]\n";
    write(&folder, "stale.toml", &stale);
    write(&folder, "nan.txt", "formula; = Cd/(ka - ka)*0;");
    check(
        "warnings",
        &folder,
        &[
            "render session.toml -o out.png --set ball.kd=1.4 --set *.h=-3 --set floor.kt=0.5",
            "render session.toml -o out.png --set ball.kd=0.6 --set ball.ks=0.4",
            "render session.toml -o out.png --formula preset:phong-thesis --set ball.kd=0.3",
            "render stale.toml -o out.png",
            "render stale.toml -o out.png --formula preset:lambert --scene preset:glass --size 8x8",
            "render session.toml -o out.exr --srgb --formula nan.txt --scene sub/place.txt --size 8x6",
        ],
    );
}

#[test]
fn lists() {
    check("lists", &folder(), &["list"]);
}

#[test]
fn checks() {
    let folder = folder();
    write(&folder, "wrong.txt", &FORMULA.replace("kd*IL", "kd*Ll").replace("default 20", "default <1,1,1>"));
    write(&folder, "wrong-scene.txt", &SCENE.replace("radius 1", "radius -1").replace("fov 40", "fov 190"));
    write(&folder, "wrong.toml", "formula = \"wrong.txt\"\nsize = [32, 24, 1]\ndepth = \"deep\"\n[global]\nka = true\n");
    write(&folder, "points.toml", "version = 1\nformula = \"wrong.txt\"\nscene = \"none.txt\"\n");
    write(&folder, "torn.toml", "version = 1\nformula = \"model.txt\nscene = 3 4\n");
    check(
        "checks",
        &folder,
        &[
            "check model.txt sub/place.txt session.toml preset:phong preset:glass",
            "check wrong.txt wrong-scene.txt wrong.toml points.toml torn.toml",
            "check --kind scene model.txt",
            "check glass",
            "check --kind scene glass",
            "check preset:glas preset:nothing",
            "check preset:sky preset:gem",
            "check --kind formula preset:overcast",
            "fmt --stdout preset:overcast preset:default",
            "check glas",
        ],
    );
}
