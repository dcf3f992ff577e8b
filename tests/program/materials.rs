//! Materials on the command line.

use crate::messages::check;
use crate::{FORMULA, folder, run, write};
use illuminator::lang::source::Source;
use illuminator::workspace::Library;
use illuminator::workspace::{FileKind, presets};
use std::fs;
use std::path::Path;

const LIBRARY: &str =
    "version = 1\n\n[gold]\nCd = [1, 0.75, 0.25]\nkr = 0.25\nkd = 0.5\nks = 0.5\nh = 50\n\n[odd]\nkd = 1.5\nshine = 2\n";

/// The bytes of the picture that a command line leads to, in floats.
fn picture(folder: &Path, arguments: &str) -> Vec<u8> {
    let done = run(folder, &format!("render {arguments} --backend interpreter --size 64x36 -o out.exr"));
    let said = String::from_utf8_lossy(&done.stderr);
    // Values of the session that another formula takes over are named.
    let is_quiet = said.lines().all(|line| line.starts_with("Note: values kept by name: "));
    assert!(done.status.success() && is_quiet, "{arguments}: {said}");
    fs::read(folder.join("out.exr")).expect("the picture")
}

/// `--set` for every value of a built-in material.
fn settings(library: &str, material: &str, body: &str) -> String {
    let text = presets::text(FileKind::Material, library).expect("a built-in file");
    let (library, _) = Library::parse(&Source::new(library, text)).expect("a sound library");
    let properties = &library.get(material).expect("a built-in material").properties;
    let set = properties.iter().map(|property| {
        let numbers: Vec<String> = property.value.constant().expect("numbers").components().iter().map(f32::to_string).collect();
        let value = if numbers.len() == 1 { numbers.concat() } else { format!("<{}>", numbers.join(",")) };
        format!("--set {body}.{}={value}", property.parameter)
    });
    set.collect::<Vec<_>>().join(" ")
}

#[test]
fn a_material_is_its_values() {
    let folder = folder();
    let plain = picture(folder.path(), "preset:studio");
    let gold = picture(folder.path(), "preset:studio --material ball=gold");
    assert!(plain != gold);
    assert!(gold == picture(folder.path(), &format!("preset:studio {}", settings("phong", "gold", "ball"))));
    // `--set` counts over it, wherever it stands, and the later of two materials.
    let set = picture(folder.path(), "preset:studio --set ball.h=9 --material ball=gold");
    assert!(set != gold && set == picture(folder.path(), "preset:studio --material ball=gold --set ball.h=9"));
    assert!(gold == picture(folder.path(), "preset:studio --material ball=chalk --material ball=gold"));
    // Another model has materials of its own.
    let steel = picture(folder.path(), "preset:studio --formula preset:strauss --material pearl=brushed-steel");
    let values = settings("strauss", "brushed-steel", "pearl");
    assert!(steel == picture(folder.path(), &format!("preset:studio --formula preset:strauss {values}")));
    let all = picture(folder.path(), "preset:studio --material *=chalk");
    assert!(all == picture(folder.path(), "preset:studio --material ball=chalk --material pearl=chalk --material floor=chalk"));
    assert!(!folder.path().join("home").exists(), "nothing is saved where nothing is to be saved");
}

#[test]
fn libraries_are_found_beside_the_formula_and_in_the_working_directory() {
    let folder = folder();
    let model = format!("#uses stuff/metals.txt;\n{FORMULA}");
    write(&folder, "sub/model.txt", &model);
    let render = "session.toml --formula sub/model.txt --material ball=gold";
    let plain = picture(folder.path(), "session.toml --formula sub/model.txt");
    fs::create_dir(folder.path().join("stuff")).expect("a folder");
    write(&folder, "stuff/metals.txt", LIBRARY);
    let gold = picture(folder.path(), render);
    assert!(gold != plain);
    fs::create_dir(folder.path().join("sub/stuff")).expect("a folder");
    write(&folder, "sub/stuff/metals.txt", &LIBRARY.replace("0.75", "0.5"));
    assert!(picture(folder.path(), render) != gold, "the one beside the formula counts");
}

#[cfg(target_os = "linux")]
#[test]
fn what_was_saved_lies_over_what_is_built_in() {
    let folder = folder();
    let gold = picture(folder.path(), "preset:studio --material ball=gold");
    fs::create_dir_all(folder.path().join("home/data/illuminator/materials")).expect("a folder");
    write(&folder, "home/data/illuminator/materials/phong.toml", LIBRARY);
    assert!(picture(folder.path(), "preset:studio --material ball=gold") != gold);
    assert!(picture(folder.path(), "preset:studio --material ball=copper") != gold);
}

#[test]
fn what_is_said() {
    let folder = folder();
    write(&folder, "metals.toml", LIBRARY);
    write(&folder, "torn.toml", "version = 1\n[gold\nkr = 0.3\n");
    write(&folder, "wrong.toml", "version = 2\nshine = 3\n\n[gold]\nCd = [1, 0.8]\nkr = \"much\"\n\n[gold2]\n");
    for (name, uses) in [("metals", "metals.toml"), ("torn", "torn.toml"), ("none", "none.toml"), ("built-in", "preset:fong")] {
        write(&folder, &format!("{name}.formula"), &format!("#uses {uses};\n{FORMULA}"));
    }
    check(
        "materials",
        &folder,
        &[
            "render session.toml -o out.png --material ball",
            "render session.toml -o out.png --material ball=gold",
            "render session.toml -o out.png --formula metals.formula --material ball=golt --material bal=gold --material key=gold",
            "render session.toml -o out.png --backend interpreter --formula metals.formula --material ball=odd",
            "render session.toml -o out.png --formula none.formula --material ball=gold",
            "render session.toml -o out.png --formula torn.formula --material ball=gold",
            "render session.toml -o out.png --formula built-in.formula --material ball=gold",
            "render metals.toml -o out.png",
            "render session.toml -o out.png --formula metals.toml",
            "render session.toml -o out.png --backend interpreter --formula metals.formula --material *=gold --set ball.kd=0.9",
            "check metals.toml wrong.toml torn.toml metals.formula built-in.formula none.formula",
            "check --kind material preset:phong session.toml",
        ],
    );
}

#[test]
fn a_file_that_is_no_library_is_reported_once() {
    let folder = folder();
    let session = "version = 1\nformula = \"model.txt\"\nscene = \"sub/place.txt\"\n";
    let torn = "version = 1\n[gold]\nkr = \"much\"\n[tin]\nks = true\n";
    write(&folder, "words.txt", "hello world\nthis is a text\nof no kind\n");
    write(&folder, "plain.toml", session);
    write(&folder, "torn.toml", torn);
    for (name, library) in
        [("f", "model.txt"), ("s", "sub/place.txt"), ("w", "words.txt"), ("t", "plain.toml"), ("m", "torn.toml"), ("d", "sub")]
    {
        write(&folder, &format!("{name}.formula"), &format!("#uses {library};\n{FORMULA}"));
    }
    let mut commands: Vec<String> = "fswtmd".chars().map(|name| format!("check {name}.formula")).collect();
    let render = |name: char| format!("render session.toml -f {name}.formula --material ball=gold -o out.png");
    commands.extend("fswtd".chars().map(render));
    let commands: Vec<&str> = commands.iter().map(String::as_str).collect();
    crate::messages::check("no_library", &folder, &commands);
}
