//! The built-in materials with their formulas, and the messages about material libraries.

use illuminator::files::Readable;
use illuminator::formula::Formula;
use illuminator::lang::ast::Constant;
use illuminator::lang::source::{Source, SourceSpan};
use illuminator::scene::{BodyId, Scene};
use illuminator::workspace::Location;
use illuminator::workspace::materials::{LibraryLocation, Property};
use illuminator::workspace::{FileKind, FileValue, presets};
use illuminator::workspace::{Library, Material, Materials, Values};
use proptest::prelude::*;
use std::collections::BTreeSet;

const SCENE: &str = "bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <9,9,9>;
    camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";

/// The built-in formulas that name materials, each with what it names.
fn formulas() -> impl Iterator<Item = (&'static str, Formula, String)> {
    presets::names(FileKind::Formula).filter_map(|name| {
        let text = presets::text(FileKind::Formula, name).expect("a built-in file");
        let (formula, _) = Formula::parse(&Source::new(name, text)).expect("a sound formula");
        let uses = formula.uses.clone()?;
        Some((name, formula, uses))
    })
}

fn scene() -> Scene {
    Scene::parse(&Source::new("scene", SCENE)).expect("a sound scene").0
}

#[test]
fn every_built_in_material_fits_its_formula() {
    let data = tempfile::tempdir().expect("a temporary folder");
    let mut used = BTreeSet::new();
    for (name, formula, uses) in formulas() {
        let location = Location::Preset(name.to_owned());
        let place = LibraryLocation::find(Some(&uses), Some(&location), Some(data.path())).expect("materials are on");
        used.extend(place.built_in().map(str::to_owned));
        let (shelf, _) = Materials::open(place, Readable::Regular).expect("a sound library");
        for material in shelf.library().iter() {
            let mut values = Values::defaults(&formula, &scene());
            let (assignments, left_out) = material.assignments(values.table(), BodyId(0));
            let warnings = values.assign(&assignments);
            assert!(left_out.is_empty() && warnings.is_empty(), "{} of {name}: {left_out:?} {warnings:?}", material.name());
            // It gives every value, so that no value of an earlier material stays.
            let whole = Material::of_body(material.name(), &values, BodyId(0)).expect("a name");
            let bare = |material: &Material| {
                let mut named: Vec<_> = material
                    .properties
                    .iter()
                    .map(|property| {
                        (property.parameter.clone(), property.value.constant().expect("numbers").components().to_vec())
                    })
                    .collect();
                named.sort_by(|one, other| one.0.cmp(&other.0));
                named
            };
            assert_eq!(bare(material), bare(&whole), "{} of {name}", material.name());
        }
    }
    assert_eq!(used, presets::names(FileKind::Material).map(str::to_owned).collect(), "every library belongs to a formula");
}

/// Metals with their indices n and k at 650, 550 and 450 nm, interpolated in the tables of refractiveindex.info:
/// Johnson and Christy (1972, 1974), aluminium of Rakic (1995).
const METALS: [(&str, [f64; 3], [f64; 3]); 7] = [
    ("gold", [0.1556, 0.4241, 1.3831], [3.6024, 2.4721, 1.9155]),
    ("copper", [0.2378, 1.0066, 1.2404], [3.6264, 2.5823, 2.3929]),
    ("silver", [0.0522, 0.0596, 0.0400], [4.4094, 3.5974, 2.6484]),
    ("nickel", [1.9900, 1.9212, 1.7290], [4.2086, 3.6158, 2.9435]),
    ("chromium", [3.1071, 3.1812, 2.3230], [3.3314, 3.3291, 3.1350]),
    ("titanium", [2.7407, 2.5418, 2.2670], [3.8143, 3.4345, 3.0385]),
    ("aluminium", [1.5580, 1.0152, 0.6332], [7.7124, 6.6273, 5.4544]),
];

#[test]
fn metals_have_their_measured_indices() {
    let mut found = 0;
    for name in presets::names(FileKind::Material) {
        let text = presets::text(FileKind::Material, name).expect("a built-in file");
        let table: toml::Table = text.parse().expect("a sound library");
        for (metal, n, k) in METALS {
            let vector = |key: &str| -> Option<Vec<f64>> {
                let components = table.get(metal)?.get(key)?.as_array()?;
                components.iter().map(toml::Value::as_float).collect()
            };
            let (Some(given_n), Some(given_k), Some(colour)) = (vector("n"), vector("k"), vector("Cd")) else {
                continue;
            };
            found += 1;
            for i in 0..3 {
                let (n, k) = (n[i], k[i]);
                // What is reflected straight on is |(n - ik - 1)/(n - ik + 1)|^2.
                let reflected = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
                let pairs = [(given_n[i], n), (given_k[i], k), (colour[i], reflected)];
                assert!(pairs.iter().all(|(given, wanted)| (given - wanted).abs() < 1e-3), "{metal} of {name}: {pairs:?}");
            }
        }
    }
    assert!(found >= 25, "{found} metals were compared");
}

#[test]
fn the_formula_of_the_thesis_has_a_library_of_the_users() {
    let data = tempfile::tempdir().expect("a temporary folder");
    let (_, formula, uses) = formulas().find(|(name, ..)| *name == "phong-thesis").expect("a built-in formula");
    let location = Location::new("preset:phong-thesis");
    let open = || {
        let place = LibraryLocation::find(Some(&uses), Some(&location), Some(data.path())).expect("materials are on");
        Materials::open(place, Readable::Regular).expect("nothing is wrong").0
    };
    let mut shelf = open();
    assert!(shelf.library().is_empty());
    let values = Values::defaults(&formula, &scene());
    shelf.put(Material::of_body("plain", &values, BodyId(0)).expect("a name")).expect("the folder can be written to");
    assert_eq!(open().library().len(), 1);
    assert!(data.path().join("materials/PhongMaterial.txt").is_file());
}

/// All messages about a library.
fn said(text: &str) -> String {
    let source = Source::new("materials.toml", text);
    match Library::parse(&source) {
        Ok((_, warnings)) => format!("{:#}", warnings.located(&source)),
        Err(errors) => format!("{:#}", errors.located(&source)),
    }
}

#[test]
fn values_that_are_none_are_marked() {
    insta::assert_snapshot!(said("version = 1\nshine = 3\n\n[gold]\nCd = [1, 0.8]\nkr = true\n\n[empty]\n"));
}

#[test]
fn a_second_table_of_a_name_is_marked() {
    insta::assert_snapshot!(said("version = 1\n\n[gold]\nkr = 0.3\n\n[gold]\nkr = 0.4\n"));
}

#[test]
fn values_without_a_place_in_the_formula_are_marked() {
    let text = "version = 1\n\n[gold]\nkr = 0.3\nshine = 40\nCd = 0.5\n";
    let source = Source::new("materials.toml", text);
    let (library, _) = Library::parse(&source).expect("a sound library");
    let (formula, _) = Formula::parse(&Source::new("formula", "formula; = Cd;")).expect("a sound formula");
    let values = Values::defaults(&formula, &scene());
    let (_, left_out) = library.get("gold").expect("the one material").assignments(values.table(), BodyId(0));
    insta::assert_snapshot!(format!("{:#}", left_out.located(&source)));
}

/// Any material, with unusual names and all finite numbers.
fn material() -> impl Strategy<Value = Material> {
    let number = any::<f32>().prop_filter("finite", |x| x.is_finite());
    let value = prop_oneof![
        number.clone().prop_map(Constant::Scalar),
        [number.clone(), number.clone(), number].prop_map(Constant::Vector)
    ];
    let values = proptest::collection::btree_map(prop_oneof!["[a-z]{1,3}", any::<String>()], value, 1..5);
    let name = prop_oneof!["[a-z]{1,2}", any::<String>()];
    (name, values).prop_filter_map("no name", |(name, values)| {
        let mut material = Material::new(name).ok()?;
        let property =
            |(parameter, value)| Property { parameter, value: FileValue::Constant(value), span: SourceSpan::default() };
        material.properties = values.into_iter().map(property).collect();
        Some(material)
    })
}

/// Every value by material and parameter, bit by bit.
fn bits(library: &Library) -> Vec<(&str, &str, Vec<u32>)> {
    let numbers = |value: &Constant| value.components().iter().map(|number| number.to_bits()).collect();
    let values = library.iter().flat_map(|material| material.properties.iter().map(move |property| (material.name(), property)));
    values
        .map(|(name, property)| (name, property.parameter.as_str(), numbers(&property.value.constant().expect("numbers"))))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn saved_libraries_read_back_bit_for_bit(materials in proptest::collection::vec(material(), 0..5)) {
        let mut library = Library::default();
        for material in materials {
            library.put(material);
        }
        let text = library.to_toml().expect("names and numbers");
        let source = Source::new("saved", text.clone());
        let (read, warnings) = Library::parse(&source).map_err(|errors| TestCaseError::fail(errors.located(&source).to_string()))?;
        prop_assert!(warnings.is_empty());
        prop_assert_eq!(bits(&read), bits(&library), "{}", text);
    }

    #[test]
    fn damaged_libraries_are_told_of_or_read(cut in 0..400_usize, junk in "[\\[\\]={},\"#.\na-z0-9]{0,6}") {
        let text = presets::text(FileKind::Material, "phong").expect("a built-in file");
        let (before, behind) = text.split_at(cut);
        for text in [format!("{before}{junk}"), format!("{before}{junk}{behind}")] {
            let source = Source::new("damaged", text);
            match Library::parse(&source) {
                Ok((_, said)) => prop_assert!(!said.has_errors()),
                Err(said) => prop_assert!(said.has_errors() && !said.located(&source).to_string().is_empty()),
            }
        }
    }
}
