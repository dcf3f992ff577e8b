//! Libraries read, found, saved and met by formulas.

use super::*;
use crate::files::Readable;
use crate::formula::Formula;
use crate::lang::ast::Constant;
use crate::lang::diagnostic::Diagnostic;
use crate::scene::Scene;
use crate::workspace::Location;
use crate::workspace::warning::ValueWarning;
use std::fs;

const TEXT: &str = "# metals\nversion = 1\n\n[gold] # yellow\nCd = [1, 0.8, 0.3]\nkr = 0.25\nkd = 0.5\n\n[\"red plastic\"]\nkd = 0.7\n\
                    [aluminium]\nkr = 0.5\n";

fn source(text: &str) -> Source {
    Source::new("m.toml", text)
}

fn library(text: &str) -> Library {
    Library::parse(&source(text)).unwrap_or_else(|errors| panic!("{}", errors.located(&source(text)))).0
}

fn names(library: &Library) -> Vec<&str> {
    library.iter().map(Material::name).collect()
}

fn messages(diagnostics: &Diagnostics) -> Vec<&str> {
    diagnostics.iter().map(Diagnostic::message).collect()
}

/// A library without the places of its text.
fn bare(library: &Library) -> Library {
    let mut bare = library.clone();
    bare.materials
        .iter_mut()
        .flat_map(|material| &mut material.properties)
        .for_each(|property| property.span = SourceSpan::default());
    bare
}

fn formula(text: &str) -> Formula {
    Formula::parse(&Source::new("f", text)).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

/// Two parameters of which one follows from the other.
fn thesis() -> Formula {
    formula(
        "body_specific; kd: scalar, constraint 0..1, default 0.2; h: scalar, constraint 5..500, default 150;
         ks: scalar, constraint 0..1, default 0.5; invariants; ks+kd=1; kr+kt=1; formula; = kd*ks*h*Cd;",
    )
}

fn scene() -> Scene {
    let text = "bodies; ball: sphere, center <0,0,0>, radius 1; solid: sphere, center <3,0,0>, radius 1, opaque;
         lights; key: point, <9,9,9>; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
    Scene::parse(&Source::new("s", text)).unwrap().0
}

fn give(values: &mut Values, material: &Material, body: u32) -> Vec<String> {
    let (assignments, warnings) = material.assignments(values.table(), BodyId(body));
    let warnings: Vec<String> = warnings.iter().map(|warning| warning.message().to_owned()).collect();
    let taken: Vec<String> = values.assign(&assignments).iter().map(ValueWarning::to_string).collect();
    [warnings, taken].concat()
}

fn scalar(number: f32) -> FileValue {
    FileValue::Constant(Constant::Scalar(number))
}

fn vector(numbers: [f32; 3]) -> FileValue {
    FileValue::Constant(Constant::Vector(numbers))
}

#[test]
fn a_library_is_read_in_its_order() {
    let (library, warnings) = Library::parse(&source(TEXT)).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(names(&library), ["gold", "red plastic", "aluminium"]);
    let gold = library.get("gold").unwrap();
    let properties: Vec<_> =
        gold.properties.iter().map(|property| (property.parameter.as_str(), property.value.clone())).collect();
    assert_eq!(properties, [("Cd", vector([1.0, 0.8, 0.3])), ("kr", scalar(0.25)), ("kd", scalar(0.5))]);
    assert_eq!(library.get("silver"), None);
    assert!(Library::parse(&source("\u{feff}version = 1\r\n")).unwrap().0.is_empty());
}

#[test]
fn all_errors_are_reported_at_once() {
    let text = "gold = 3\n[\"\"]\nkr = 1\n[\" x \"]\n[silver]\nCd = [1, 2]\nkr = true\nkt = nan\nkd = { a = 1 }\n[empty]\n";
    let errors = Library::parse(&source(text)).unwrap_err();
    assert_eq!(
        messages(&errors),
        [
            "the file has no version",
            "expected a table, found a whole number",
            "a material needs a name",
            "the name of a material must be one line, without spaces at its ends",
            "expected three numbers `[x, y, z]`",
            "expected a number, or three as `[x, y, z]`, found true or false",
            "this number is too large or not finite",
            "expected a number, or three as `[x, y, z]`, found a table",
            "the material `empty` has no values and changes nothing",
        ]
    );
    let (library, warnings) = Library::parse(&source("version = 1\n[empty]\n")).unwrap();
    assert_eq!((library.len(), warnings.len()), (1, 1));
}

#[test]
fn damaged_and_foreign_libraries_are_refused() {
    let errors = |text: &str| Library::parse(&source(text)).unwrap_err();
    assert_eq!(messages(&errors("version = 2\n[gold]\nkr = 1")), ["version 2 of this file cannot be read"]);
    assert!(!errors("version = 1\n[gold]\nkr = 1\n[gold]\nkr = 2\n").is_empty());
    assert!(!errors("version = 1\n[gold]\nkr = 1\nkr = 2\n").is_empty());
    assert!(!errors("version = 1\n[gold\nkr = ").is_empty());
    assert!(!errors("[version]\nkr = 1").is_empty());
}

#[test]
fn names_are_such_that_a_library_can_hold_them() {
    let name = |name: &str| Material::new(name).map(|material| material.name().to_owned());
    assert_eq!(name("").err(), Some(NameError::Empty));
    assert_eq!(name(" \t").err(), Some(NameError::Empty));
    assert_eq!(name("version").err(), Some(NameError::Reserved));
    assert_eq!(name("a\nb").err(), Some(NameError::Form));
    assert_eq!(name("gold ").err(), Some(NameError::Form));
    for fine in ["Gold", "18 carat", "a.b", "\"'\\", "=", "žluť", "[x]", "#"] {
        let mut one = Library::default();
        one.put(Material { properties: library(TEXT).get("gold").unwrap().properties.clone(), ..Material::new(fine).unwrap() });
        assert_eq!(bare(&library(&one.to_toml().unwrap())), bare(&one), "{fine}");
    }
}

#[test]
fn what_is_saved_is_read_back() {
    let mut first = library(TEXT);
    let value = vector([0.1, f32::MIN_POSITIVE, -3.402_823_5e38]);
    first.materials[1].properties.push(Property { parameter: "odd name".to_owned(), value, span: SourceSpan::default() });
    let text = first.to_toml().unwrap();
    assert!(text.starts_with("version = 1\n\n[gold]\nCd = [1.0, 0.8, 0.3]\nkr = 0.25\n"), "{text}");
    assert_eq!(bare(&library(&text)), bare(&first));
    assert_eq!(library(&Library::default().to_toml().unwrap()), Library::default());
}

#[test]
fn materials_are_added_replaced_and_taken_out() {
    let mut library = library(TEXT);
    let gold = Material::new("gold").unwrap();
    assert!(library.put(gold.clone()).is_some());
    assert_eq!(library.get("gold"), Some(&gold));
    assert!(library.put(Material::new("silver").unwrap()).is_none());
    assert!(library.remove("red plastic").is_some() && library.remove("red plastic").is_none());
    assert_eq!(names(&library), ["gold", "aluminium", "silver"]);
}

#[test]
fn a_material_goes_through_ranges_and_invariants() {
    let mut values = Values::defaults(&thesis(), &scene());
    let library = library("version = 1\n[m]\nks = 0.25\nkd = 0.5\nh = 1\nkr = [1, 1, 1]\nki = 1\nshine = 2\n");
    assert_eq!(
        give(&mut values, library.get("m").unwrap(), 0),
        [
            "`kr` is a scalar in the formula; this value is ignored",
            "the formula has no body parameter `ki`; its value is ignored",
            "the formula has no body parameter `shine`; its value is ignored",
            "`ball.h` = 1 is outside 5..500; 5 is used",
            "`ball.kd` = 0.5 is ignored: it follows from other values (kd = 1 - ks) and is 0.75",
        ]
    );
    let ks = values.table().parameter_named("ks").unwrap();
    assert_eq!([values.body(BodyId(0), ks), values.body(BodyId(1), ks)], [[0.25], [0.5]]);
}

#[test]
fn a_body_gets_back_what_was_read_out_of_it() {
    let model = thesis();
    let mut values = Values::defaults(&model, &scene());
    let library = library("version = 1\n[m]\nCd = [0.1, 0.2, 0.3]\nks = 0.3\nkr = 0.45\nh = 7.25\n");
    assert_eq!(give(&mut values, library.get("m").unwrap(), 0), [""; 0]);
    assert_eq!(give(&mut values, library.get("m").unwrap(), 1), [""; 0]);
    for body in 0..2 {
        let material = Material::of_body("copy", &values, BodyId(body)).unwrap();
        assert_eq!(material.properties.len(), 6);
        for other in 0..2 {
            let mut fresh = Values::defaults(&model, &scene());
            assert_eq!(give(&mut fresh, &material, other), [""; 0], "{body} to {other}");
            for id in values.table().parameters_of(Owner::Body) {
                assert_eq!(fresh.body(BodyId(other), id), values.body(BodyId(other), id));
            }
        }
    }
    // Where kt is bound by no equation, an opaque body's is the 0 that its user sees.
    let free = formula("formula; = kt*Cd;");
    let kt = library_of("kt = 0.5");
    let (mut values, scene) = (Values::defaults(&free, &scene()), scene());
    give(&mut values, &kt, 0);
    let opaque = Scene::parse(&Source::new("s", scene_with("ball: sphere, center <0,0,0>, radius 1, opaque;"))).unwrap().0;
    let (values, _) = values.carry_over(&free, &opaque);
    let material = Material::of_body("copy", &values, BodyId(0)).unwrap();
    let mut others = Values::defaults(&free, &scene);
    assert_eq!(give(&mut others, &material, 0), [""; 0]);
    assert_eq!(others.body(BodyId(0), values.table().parameter_named("kt").unwrap()), [0.0]);
    assert_eq!(Material::of_body("none", &values, BodyId(9)).unwrap().properties, []);
}

fn library_of(values: &str) -> Material {
    library(&format!("version = 1\n[m]\n{values}\n")).get("m").unwrap().clone()
}

fn scene_with(bodies: &str) -> String {
    format!("bodies; {bodies} lights; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;")
}

#[test]
fn libraries_are_looked_for_beside_the_formula() {
    let folder = tempfile::tempdir().unwrap();
    let formula = Location::File(folder.path().join("models/phong.txt"));
    let location = |uses: &str, formula: &Location| LibraryLocation::find(Some(uses), Some(formula), Some(folder.path()));
    let file = |uses: &str, formula: &Location| location(uses, formula).unwrap().file().map(Path::to_owned);
    // One that exists nowhere is to be made beside the formula.
    let beside = folder.path().join("models/lib/m.toml");
    assert_eq!(file("lib/m.toml", &formula), Some(beside.clone()));
    // One of the working directory, which tests run in, counts where there is none beside the formula.
    assert_eq!(file("Cargo.toml", &formula), Some("Cargo.toml".into()));
    fs::create_dir(folder.path().join("models")).unwrap();
    fs::write(folder.path().join("models/Cargo.toml"), "").unwrap();
    assert_eq!(file("Cargo.toml", &formula), Some(folder.path().join("models/Cargo.toml")));
    let absolute = folder.path().join("m.toml");
    assert_eq!(file(&absolute.display().to_string(), &formula), Some(absolute));
}

#[test]
fn libraries_of_built_in_formulas_are_kept_in_the_data_folder() {
    let data = Path::new("data");
    let of = |uses: &str, data: Option<&Path>| LibraryLocation::find(Some(uses), Some(&Location::new("preset:phong")), data);
    let location = of("preset:phong", Some(data)).unwrap();
    assert_eq!((location.built_in(), location.file()), (Some("phong"), Some(Path::new("data/materials/phong.toml"))));
    let location = of("preset/material/PhongMaterial.txt", Some(data)).unwrap();
    assert_eq!((location.built_in(), location.file()), (None, Some(Path::new("data/materials/PhongMaterial.txt"))));
    assert_eq!(of("../../x.toml", Some(data)).unwrap().file(), Some(Path::new("data/materials/x.toml")));
    assert_eq!(of("Cargo.toml", Some(data)).unwrap().file(), Some(Path::new("Cargo.toml")));
    assert_eq!(of("preset:phong", None).unwrap().file(), None);
    let error = of("preset:fong", None).unwrap_err();
    assert_eq!(error.message(), "there is no built-in material library `preset:fong`");
    assert_eq!(error.hints(), ["did you mean `preset:phong`?"]);
    let error = LibraryLocation::find(None, None, None).unwrap_err();
    assert_eq!(error.message(), "materials are off: the formula names no file for them");
}

fn shelf(uses: &str, data: &Path) -> Materials {
    let location = LibraryLocation::find(Some(uses), Some(&Location::new("preset:phong")), Some(data)).unwrap();
    let (shelf, found) = Materials::open(location, Readable::Regular).unwrap_or_else(|found| panic!("{found}"));
    assert!(found.diagnostics.is_empty());
    shelf
}

#[test]
fn what_is_saved_lies_over_what_is_built_in() {
    let data = tempfile::tempdir().unwrap();
    let mut shelf = shelf("preset:phong", data.path());
    let built_in: Vec<String> = names(shelf.library()).into_iter().map(str::to_owned).collect();
    let gold = library(TEXT).get("gold").unwrap().clone();
    assert!(shelf.is_built_in("gold") && shelf.source_of("gold").name() == "preset:phong");
    shelf.put(gold.clone()).unwrap();
    shelf.put(Material { name: "my own".to_owned(), ..gold.clone() }).unwrap();
    assert!(!shelf.is_built_in("gold") && !shelf.is_built_in("my own") && !shelf.is_built_in("none"));
    // Order is kept, and another program sees the same.
    let location = shelf.location().clone();
    assert_eq!(shelf, Materials::open(location.clone(), Readable::Regular).unwrap().0);
    assert_eq!(names(shelf.library()), [built_in.iter().map(String::as_str).collect(), vec!["my own"]].concat());
    assert_eq!(bare(shelf.library()).get("gold"), bare(&library(TEXT)).get("gold"));
    let marked = shelf.get("gold").unwrap().properties[0].span;
    assert_eq!(shelf.source_of("gold").slice(marked), "Cd");
    // What hides a built-in one can be deleted, the built-in one cannot.
    shelf.remove("gold").unwrap();
    assert_eq!(
        shelf.get("gold"),
        library(crate::workspace::presets::text(crate::workspace::FileKind::Material, "phong").unwrap()).get("gold")
    );
    let error = shelf.remove("gold").unwrap_err();
    assert_eq!(messages(&error.diagnostics), ["the material `gold` is built in and cannot be deleted"]);
    shelf.remove("my own").unwrap();
    let error = shelf.remove("my own").unwrap_err();
    assert!(messages(&error.diagnostics)[0].starts_with("there is no material `my own` in `preset:phong`"), "{error:?}");
    assert_eq!(names(shelf.library()), built_in);
}

#[test]
fn a_library_is_made_when_a_material_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("preset/material/PhongMaterial.txt");
    let formula = Location::File(folder.path().join("phong.txt"));
    let location = LibraryLocation::find(Some("preset/material/PhongMaterial.txt"), Some(&formula), None).unwrap();
    let (mut one, _) = Materials::open(location.clone(), Readable::Regular).unwrap();
    assert!(one.library().is_empty() && !path.exists());
    let (mut other, _) = Materials::open(location.clone(), Readable::Regular).unwrap();
    one.put(Material::new("one").unwrap()).unwrap();
    other.put(Material::new("other").unwrap()).unwrap();
    assert_eq!(names(other.library()), ["one", "other"], "what another has saved stays");
    other.remove("one").unwrap();
    let (read, _) = Library::parse(&source(&fs::read_to_string(&path).unwrap())).unwrap();
    assert_eq!(names(&read), ["other"]);
}

#[test]
fn files_that_cannot_be_changed_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.toml");
    let location = LibraryLocation::find(Some("m.toml"), Some(&Location::File(folder.path().join("f.txt"))), None).unwrap();
    fs::write(&path, TEXT).unwrap();
    let (mut shelf, _) = Materials::open(location.clone(), Readable::Regular).unwrap();
    let before = shelf.clone();
    let message = |error: SourceDiagnostics| messages(&error.diagnostics)[0].replace(&folder.path().display().to_string(), "F");
    let protect = |readonly: bool| {
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(readonly);
        fs::set_permissions(&path, permissions).unwrap();
    };
    protect(true);
    let silver = Material::new("silver").unwrap();
    let error = shelf.put(silver.clone()).unwrap_err();
    assert_eq!(message(error), "cannot write the material library `F/m.toml`: permission denied");
    assert_eq!((fs::read_to_string(&path).unwrap().as_str(), &shelf), (TEXT, &before));
    protect(false);
    // What was damaged meanwhile may be mended by hand; it is not replaced.
    fs::write(&path, "version = 1\n[gold").unwrap();
    assert!(shelf.put(silver.clone()).is_err() && shelf.remove("gold").is_err());
    assert_eq!((fs::read_to_string(&path).unwrap().as_str(), &shelf), ("version = 1\n[gold", &before));
    assert!(Materials::open(location.clone(), Readable::Regular).is_err());
    fs::remove_file(&path).unwrap();
    fs::create_dir(&path).unwrap();
    assert_eq!(message(shelf.put(silver.clone()).unwrap_err()), "`F/m.toml` is a folder, not a material library");
    let nowhere = LibraryLocation::find(Some("preset:phong"), None, None).unwrap();
    let error = Materials::open(nowhere, Readable::Regular).unwrap().0.put(silver).unwrap_err();
    assert_eq!(message(error), "materials for `preset:phong` cannot be saved: there is no folder for data of this user");
}

#[test]
fn choices_name_bodies_and_materials() {
    let shelf = shelf("preset:phong", Path::new("nowhere"));
    let table = ParameterTable::new(&thesis(), &scene());
    let resolve = |text: &str| text.parse::<MaterialAssignment>()?.resolve(&shelf, &table);
    assert_eq!(resolve("ball = gold").unwrap().0.len(), 6);
    // The opaque one's kt follows from kr, and counts for nothing.
    assert_eq!(resolve("*=gold").unwrap().0.len(), 11);
    assert_eq!("*= red plastic ".parse::<MaterialAssignment>().unwrap().to_string(), "*=red plastic");
    let error = |text: &str| resolve(text).unwrap_err().to_string();
    for text in ["ball", "=gold", "ball=", ""] {
        assert!(error(text).contains("is not of the form BODY=MATERIAL"), "{text}");
    }
    assert_eq!(error("bal=gold"), "there is no body `bal`; did you mean `ball`?");
    assert_eq!(error("key=gold"), "`key` is a light; only bodies have materials");
    assert_eq!(error("ball=golt"), "there is no material `golt` in `preset:phong`; did you mean `gold`?");
    assert!(error("ball=x").starts_with("there is no material `x` in `preset:phong`; there are chalk, red-plastic, "));
}
