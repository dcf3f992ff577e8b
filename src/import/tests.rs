//! Tests of what is made of models.

use super::*;
use crate::formula::Formula;
use crate::mesh::{
    LightSource, MeshParts, MeshRepairs, ModelCamera, ModelImage, ModelLight, ModelMaterial, ModelPart, PhongLook, PhysicalLook,
    Reading,
};
use crate::scene::Scene;
use crate::workspace::{FileKind, Values, presets};
use std::path::Path;
use std::sync::atomic::AtomicBool;

const PHYSICAL: PhysicalLook = PhysicalLook {
    base: [0.5, 0.25, 0.125],
    coverage: 1.0,
    metallic: 0.0,
    roughness: 0.5,
    specular: 1.0,
    specular_color: [1.0; 3],
    coat: 0.0,
    coat_roughness: 0.0,
    transmission: 0.0,
    index: 1.5,
    is_thin: false,
};

const PHONG: PhongLook = PhongLook {
    diffuse: [0.5, 0.25, 0.125],
    specular: [0.0; 3],
    sharpness: 50.0,
    index: None,
    coverage: 1.0,
    filter: [0.0; 3],
    illumination: 2,
};

/// A triangle with its corners on the axes, this far from the origin.
fn triangle(size: f64) -> TriangleMesh {
    let parts =
        MeshParts { positions: DVec3::AXES.map(|axis| size * axis).to_vec(), triangles: vec![[0, 1, 2]], ..MeshParts::default() };
    let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &AtomicBool::new(false) };
    TriangleMesh::new("triangle", parts, &reading).unwrap().0
}

/// A model of a triangle for each look.
fn model(looks: &[ModelLook]) -> MeshModel {
    let part =
        |(material, _): (usize, &ModelLook)| ModelPart { name: "tri".to_owned(), material: Some(material), mesh: triangle(2.0) };
    let material = |look: &ModelLook| ModelMaterial { name: String::new(), look: look.clone(), image: None };
    MeshModel {
        parts: looks.iter().enumerate().map(part).collect(),
        materials: looks.iter().map(material).collect(),
        images: Vec::new(),
        camera: None,
        lights: Vec::new(),
        repairs: MeshRepairs::default(),
        omissions: Omissions::default(),
    }
}

fn planned(model: MeshModel) -> ImportPlan {
    plan(model, "a.glb", &ImportTarget::new(Path::new("some/where.scene")).unwrap()).unwrap()
}

fn look(look: ModelLook) -> ImportedLook {
    ImportedLook::new(Some(&look))
}

fn number(look: &ImportedLook, parameter: &str) -> Option<f32> {
    look.values.iter().find(|(name, _)| *name == parameter).map(|(_, value)| match value {
        Constant::Scalar(number) => *number,
        Constant::Vector([red, ..]) => *red,
    })
}

#[test]
fn what_is_neither_mirror_nor_glass_sends_no_rays() {
    let matte = look(ModelLook::Physical(PHYSICAL));
    assert_eq!(matte.values, [("Cd", Constant::Vector([0.5, 0.25, 0.125])), ("specular_roughness", Constant::Scalar(0.5))]);
    assert_eq!((matte.is_opaque, matte.is_matte, matte.refractive_index), (true, true, None));
    let matte = look(ModelLook::Phong(PHONG));
    let [kd, ks] = [1.0, 0.0].map(Constant::Scalar);
    assert_eq!(matte.values, [("Cd", Constant::Vector([0.5, 0.25, 0.125])), ("kd", kd), ("ks", ks)]);
    assert_eq!((matte.is_opaque, matte.is_matte), (true, true));
    // A rough metal has no mirror image.
    let metal = PhysicalLook { metallic: 1.0, roughness: 0.9, ..PHYSICAL };
    assert!(look(ModelLook::Physical(metal)).is_matte, "0.5 · 0.1² is less than a hundredth");
}

#[test]
fn metals_reflect_and_glass_refracts() {
    let metal = look(ModelLook::Physical(PhysicalLook { metallic: 1.0, roughness: 0.5, ..PHYSICAL }));
    // The brightest component of its colour, times the square of 1 - 0.5.
    assert_eq!((number(&metal, "kr"), metal.is_opaque, metal.is_matte), (Some(0.125), true, false));
    assert_eq!(number(&metal, "base_metalness"), Some(1.0));
    let water = PhysicalLook { transmission: 1.0, roughness: 0.0, index: 1.33, ..PHYSICAL };
    let water = look(ModelLook::Physical(water));
    // ((1.33 - 1)/(1.33 + 1))² = 0.02006 of the light is reflected.
    assert_eq!((number(&water, "kr"), number(&water, "kt")), (Some(0.0201), Some(0.9799)));
    assert_eq!((number(&water, "base_weight"), number(&water, "specular_ior")), (Some(0.0), Some(1.33)));
    assert_eq!((water.refractive_index, water.is_opaque, water.is_matte), (Some(1.33), false, false));
    let pane = PhysicalLook { transmission: 1.0, roughness: 0.0, is_thin: true, ..PHYSICAL };
    let pane = look(ModelLook::Physical(pane));
    assert_eq!((number(&pane, "kr"), number(&pane, "kt"), pane.refractive_index), (Some(0.04), Some(0.96), Some(1.0)));
    // What is blended is a veil, and bends no light.
    let veil = look(ModelLook::Physical(PhysicalLook { coverage: 0.25, ..PHYSICAL }));
    assert_eq!((number(&veil, "kt"), veil.refractive_index, veil.is_matte), (Some(0.75), Some(1.0), true));
    let coated = look(ModelLook::Physical(PhysicalLook { coat: 0.5, coat_roughness: 0.2, index: 0.0, ..PHYSICAL }));
    assert_eq!((number(&coated, "coat_weight"), number(&coated, "coat_roughness")), (Some(0.5), Some(0.2)));
    assert_eq!(number(&coated, "specular_ior"), Some(1.0), "glTF writes 0 for no refraction");
}

#[test]
fn models_of_illumination_say_what_reflects_and_refracts() {
    let shiny = PhongLook { specular: [0.2, 0.4, 0.1], ..PHONG };
    let highlight = look(ModelLook::Phong(shiny.clone()));
    let found = ["kd", "ks", "Cs", "h"].map(|parameter| number(&highlight, parameter));
    assert_eq!(found, [Some(0.6), Some(0.4), Some(0.5), Some(50.0)]);
    assert!(highlight.is_matte, "2 has highlights only");
    let mirror = look(ModelLook::Phong(PhongLook { illumination: 3, ..shiny.clone() }));
    assert_eq!((number(&mirror, "kr"), mirror.is_opaque), (Some(0.4), true));
    let glass = PhongLook { illumination: 7, filter: [1.0, 0.5, 0.5], index: Some(1.5), ..PHONG };
    let glass = look(ModelLook::Phong(glass));
    // ((1.5 - 1)/(1.5 + 1))² = 0.04.
    assert_eq!((number(&glass, "kr"), number(&glass, "kt"), number(&glass, "kd")), (Some(0.04), Some(0.96), Some(0.04)));
    assert_eq!(glass.refractive_index, Some(1.5));
    let veil = look(ModelLook::Phong(PhongLook { coverage: 0.25, ..shiny.clone() }));
    assert_eq!((number(&veil, "kt"), number(&veil, "kd"), veil.refractive_index), (Some(0.75), Some(0.25), Some(1.0)));
    let ignored = look(ModelLook::Phong(PhongLook { filter: [1.0; 3], ..shiny }));
    assert!(ignored.is_opaque, "2 lets no light pass but by d");
}

/// The warnings of the session of a plan, with spheres in place of its meshes.
fn warnings(plan: &ImportPlan) -> Vec<String> {
    let Location::Preset(formula) = &plan.session.formula else { panic!("{}", plan.session.formula) };
    let formula = presets::text(FileKind::Formula, formula).unwrap();
    let scene = Scene::parse(&Source::new("scene", plan.scene.as_str())).unwrap().0;
    let formula = crate::formula::Formula::parse(&Source::new("formula", formula)).unwrap().0;
    let mut values = Values::defaults(&formula, &scene);
    let text = plan.session.to_toml(Path::new("some")).unwrap();
    let session = Session::parse(&Source::new("session", text)).unwrap().0;
    let (assignments, unused) = session.assignments(values.table());
    let warnings = values.assign(&assignments);
    unused.iter().map(|unused| format!("{unused:?}")).chain(warnings.iter().map(|warning| format!("{warning:?}"))).collect()
}

#[test]
fn every_value_fits_the_formula() {
    // Steps of a 97th avoid round numbers.
    let share = |number: usize| (number % 98) as f64 / 97.0;
    let physical = (0..300).map(|number| {
        ModelLook::Physical(PhysicalLook {
            metallic: share(number),
            roughness: share(number * 3) / 2.0,
            transmission: share(number * 5),
            coverage: if number % 4 == 0 { share(number * 7) } else { 1.0 },
            index: 5.0 * share(number),
            coat: share(number * 2),
            base: [1e300, -5.0, share(number)],
            ..PHYSICAL
        })
    });
    let phong = (0..300).map(|number| {
        ModelLook::Phong(PhongLook {
            specular: [share(number), share(number * 3), 2.0 * share(number * 5)],
            sharpness: 2000.0 * share(number) - 10.0,
            illumination: (number % 11) as u32,
            filter: [share(number * 2); 3],
            coverage: if number % 3 == 0 { share(number * 7) } else { 1.0 },
            index: Some(3.0 * share(number) - 0.5),
            ..PHONG
        })
    });
    for looks in [physical.collect::<Vec<_>>(), phong.collect()] {
        let plan = planned(model(&looks));
        assert_eq!(plan.meshes.len(), 300);
        assert_eq!(warnings(&plan), Vec::<String>::new());
    }
}

#[test]
fn a_scene_without_lights_and_camera_gets_some() {
    let plan = planned(model(&[ModelLook::Physical(PHYSICAL), ModelLook::Phong(PHONG)]));
    let expected = "// Made from a.glb by `illuminator import`.\n\nbodies;\n\
        tri: mesh, \"where-meshes/tri.ply\", opaque, matte;\ntri_2: mesh, \"where-meshes/tri_2.ply\", opaque, matte;\nlights;\nkey: ";
    assert!(plan.scene.starts_with(expected), "{}", plan.scene);
    assert_eq!((plan.lights, plan.has_camera), ((2, false), false));
    assert_eq!(formatted(&Source::new("scene", plan.scene.as_str())).unwrap(), plan.scene);
    let Scene { lights, camera, .. } = Scene::parse(&Source::new("scene", plan.scene)).unwrap().0;
    // The whole triangle is in the picture, and fills it well.
    let aspect = 1280.0 / 720.0;
    let seen = DVec3::AXES.map(|axis| camera.project(2.0 * axis).unwrap());
    let largest = seen.iter().fold(0.0, |largest: f64, [x, y]| largest.max(x.abs() / aspect).max(y.abs()));
    assert!(largest < 1.0 && largest > 0.4, "{seen:?}");
    // The key light is up to the left of the camera, on its side.
    let [right, up, forward] = camera.axes();
    let from_middle = lights[0].kind.anchor().unwrap() - DVec3::splat(1.0);
    assert!(from_middle.dot(right) < 0.0 && from_middle.dot(up) > 0.0 && from_middle.dot(forward) < 0.0);
}

#[test]
fn lights_are_compared_in_the_middle_of_the_bodies() {
    // The middle is (1, 1, 1).
    let light = |name: &str, source, intensity, color| ModelLight { name: name.to_owned(), source, color, intensity };
    let spot = |angles| LightSource::Spot { place: DVec3::new(1.0, 21.0, 1.0), direction: DVec3::NEG_Y, angles };
    let lights = vec![
        light("lamp", LightSource::Point(DVec3::new(1.0, 1.0, 11.0)), 1000.0, [1.0, 0.5, 0.0]),
        light("tri", spot([0.5, 1.0]), 1000.0, [1.0; 3]),
        light("", LightSource::Directional(DVec3::NEG_Y), 5.0, [2.0, 1.0, 1.0]),
    ];
    let camera =
        ModelCamera { position: DVec3::new(0.0, 0.0, 5.0), gaze: DVec3::NEG_Z, up: DVec3::Y, fov: 40.0, aspect: Some(2.0) };
    let plan = planned(MeshModel { lights, camera: Some(camera), ..model(&[ModelLook::Phong(PHONG)]) });
    let value = |owner: &str, parameter: &str| {
        let is_it = |value: &&NamedValue| value.owner == OwnerName::Light(owner.to_owned()) && value.parameter == parameter;
        plan.session.values.iter().find(is_it).map(|value| value.value.clone())
    };
    // 1000/10² = 10 lux, 1000/20² = 2.5 lux, and 2 · 5 = 10 lux.
    let [lamp, spot, sun] = ["lamp", "tri_2", "light"].map(|name| value(name, "ki"));
    assert_eq!([lamp, spot, sun], [1.0, 0.25, 1.0].map(|number| Some(FileValue::Constant(Constant::Scalar(number)))));
    assert_eq!(value("lamp", "IL"), Some(FileValue::Constant(Constant::Vector([1.0, 0.5, 0.0]))));
    assert_eq!(value("light", "IL"), Some(FileValue::Constant(Constant::Vector([1.0, 0.5, 0.5]))));
    assert_eq!(plan.session.picture.size, [1440, 720]);
    assert!(plan.scene.contains("\nlight: directional, <0, -1, 0>;\n"), "{}", plan.scene);
    // Half a radian and one radian, towards what is as far away as the middle.
    let written = "\ntri_2: spot, <1, 21, 1>, target <1, 1, 1>, angle 57.29578, soft 28.64789;\n";
    assert!(plan.scene.contains(written), "{}", plan.scene);
    assert!(plan.scene.contains("position <0, 0, 5>;\ngaze <0, 0, -1>;\n"), "{}", plan.scene);
    let simplified: Vec<String> = plan.simplified.iter().map(ToString::to_string).collect();
    assert_eq!(simplified.len(), 1, "{simplified:?}");
    assert_eq!(warnings(&plan), Vec::<String>::new());
}

#[test]
fn cones_of_other_programs_are_taken_if_they_are_some() {
    let planned_with = |angles| {
        let source = LightSource::Spot { place: DVec3::new(0.0, 9.0, 0.0), direction: DVec3::NEG_Y, angles };
        let light = ModelLight { name: "l".to_owned(), source, color: [1.0; 3], intensity: 1.0 };
        let plan = planned(MeshModel { lights: vec![light], ..model(&[ModelLook::Phong(PHONG)]) });
        let line = plan.scene.lines().find(|line| line.starts_with("l:")).unwrap().to_owned();
        (line, plan.simplified.iter().count())
    };
    let (line, simplified) = planned_with([0.5, 0.5]);
    assert!(line.ends_with(", angle 28.64789;") && simplified == 1, "a sharp edge: {line}");
    for angles in [[0.5, 0.25], [-1.0, 0.5], [0.0, 0.0], [0.0, -1.0], [0.0, 3.2], [0.0, 1e300]] {
        let (line, simplified) = planned_with(angles);
        assert_eq!((line.as_str(), simplified), ("l: point, <0, 9, 0>;", 2), "{angles:?}");
    }
}

#[test]
fn what_is_changed_of_lights_is_told() {
    let told = |intensity| {
        let angles = [0.5, 0.25];
        let source = LightSource::Spot { place: DVec3::new(0.0, 9.0, 0.0), direction: DVec3::NEG_Y, angles };
        let light = ModelLight { name: "l".to_owned(), source, color: [1.0; 3], intensity };
        let plan = planned(MeshModel { lights: vec![light], ..model(&[ModelLook::Phong(PHONG)]) });
        plan.simplified.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let cone = "1 spot light whose cone cannot be used: light goes in all directions instead";
    let strongest =
        "1 strength of lights: ki is 1 for the strongest in the middle of the bodies, and none gets weaker with the distance";
    assert_eq!(told(2.0), [cone, strongest]);
    assert_eq!(told(-5.0), [cone, "1 strength of lights: ki is 0, because no intensity is above 0"]);
}

#[test]
fn models_of_any_size_have_a_camera() {
    for size in [1e-25, 1e-3, 1e12, 1e25] {
        let mut model = model(&[ModelLook::Phong(PHONG)]);
        model.parts[0].mesh = triangle(size);
        assert_eq!(warnings(&planned(model)), Vec::<String>::new());
    }
    let mut model = model(&[ModelLook::Phong(PHONG)]);
    model.parts[0].mesh = triangle(1e30);
    let target = ImportTarget::new(Path::new("a.scene")).unwrap();
    assert!(matches!(plan(model, "a.obj", &target), Err(ImportError::TooLarge)));
}

#[test]
fn more_bodies_than_a_text_can_hold_are_refused() {
    let target = ImportTarget::new(&Path::new(&"long".repeat(50)).with_extension("scene")).unwrap();
    let error = plan(model(&vec![ModelLook::Phong(PHONG); 80_000]), "a.obj", &target).err().map(|error| error.to_string());
    let expected = "it has 80000 parts, and the text of the scene or of the session would have more than 16777216 bytes";
    assert_eq!(error.as_deref(), Some(expected));
}

#[test]
fn names_that_scenes_cannot_write_are_refused() {
    for name in ["a.txt", "a", "a.toml", ".scene", "preset:a.scene"] {
        assert!(ImportTarget::new(Path::new(name)).is_err(), "{name}");
    }
    for name in ["a\"b.scene", "a\nb.scene", " a.scene"] {
        let target = ImportTarget::new(Path::new(name)).unwrap();
        let outcome = plan(model(&[ModelLook::Phong(PHONG)]), "a.obj", &target);
        assert!(matches!(outcome, Err(ImportError::Name { .. })), "{name}");
    }
}

#[test]
fn a_failed_import_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let target = ImportTarget::new(&folder.path().join("a.scene")).unwrap();
    let plan = planned(model(&[ModelLook::Phong(PHONG)]));
    // A folder is where the session would be.
    std::fs::create_dir(target.session()).unwrap();
    let error = plan.write(&target, &|_| ()).unwrap_err();
    assert!(error.to_string().ends_with("a.toml`: it is a folder, not a file"), "{error}");
    assert_eq!(target.existing(true), [target.session()]);
    std::fs::remove_dir(target.session()).unwrap();
    plan.write(&target, &|_| ()).unwrap();
    assert_eq!(target.existing(true).len(), 3);
    assert_eq!(std::fs::read_dir(target.meshes()).unwrap().count(), 1);
    assert_eq!(plan.others(&target), Vec::<std::path::PathBuf>::new());
    let other = target.meshes().join("other.ply");
    std::fs::write(&other, "").unwrap();
    assert_eq!(plan.others(&target), [other]);
}

/// A model like [`model`] whose parts have surface coordinates and images.
fn with_images(looks: &[ModelLook]) -> MeshModel {
    let mut model = model(looks);
    let image = ModelImage { name: "old wood".to_owned(), suffix: "png", bytes: b"bytes".to_vec() };
    model.images = vec![image.clone(), ModelImage { name: "unused".to_owned(), ..image.clone() }, image];
    for (material, image) in model.materials.iter_mut().zip([0, 2, 0]) {
        material.image = Some(image);
    }
    for part in &mut model.parts {
        let parts = MeshParts {
            positions: part.mesh.positions().to_vec(),
            uvs: vec![glam::Vec2::ZERO, glam::Vec2::X, glam::Vec2::Y],
            triangles: vec![[0, 1, 2]],
            ..MeshParts::default()
        };
        part.mesh = TriangleMesh::new("triangle", parts, &Reading::unwatched(1 << 20)).unwrap().0;
    }
    model
}

#[test]
fn images_become_textures_of_a_formula() {
    for (looks, preset) in [
        ([ModelLook::Phong(PHONG), ModelLook::Phong(PHONG), ModelLook::Phong(PHONG)], looks::PHONG_FORMULA),
        ([PHYSICAL, PHYSICAL, PHYSICAL].map(ModelLook::Physical), looks::PHYSICAL_FORMULA),
    ] {
        let plan = planned(with_images(&looks));
        assert_eq!(plan.session.formula, Location::File("some/where.formula".into()));
        let files: Vec<&str> = plan.images.iter().map(|(file, _)| file.as_str()).collect();
        assert_eq!(files, ["old_wood.png", "old_wood_2.png"], "unused ones are not written");
        assert!(plan.images.iter().all(|(_, bytes)| bytes == b"bytes"));
        let of_bodies = plan.session.values.iter().filter(|value| value.parameter == "image").map(|value| value.value.clone());
        let expected = ["old_wood.png", "old_wood_2.png", "old_wood.png"];
        let expected = expected.map(|file| FileValue::Image(format!("some/where-textures/{file}").into()));
        assert_eq!(of_bodies.collect::<Vec<_>>(), expected);
        // The formula is sound, and has one parameter more than the built-in one.
        let (formula, warnings) = Formula::parse(&Source::new("made", plan.formula.unwrap())).unwrap();
        assert_eq!(warnings.len(), 0, "{warnings:?}");
        let (built_in, _) = Formula::parse(&Source::new(preset, presets::text(FileKind::Formula, preset).unwrap())).unwrap();
        assert_eq!(formula.parameters.len(), built_in.parameters.len() + 1);
        assert!(formula.parameters.iter().any(|parameter| parameter.name == "image"));
    }
    // Without surface coordinates there is no image.
    let mut flat = model(&[ModelLook::Phong(PHONG)]);
    flat.images = vec![ModelImage { name: String::new(), suffix: "jpg", bytes: Vec::new() }];
    flat.materials[0].image = Some(0);
    let plan = planned(flat);
    assert_eq!((plan.formula, plan.images.len()), (None, 0));
    let left_out: Vec<String> = plan.left_out.iter().map(ToString::to_string).collect();
    assert_eq!(left_out, ["1 image: its part has no surface coordinates"]);
}
