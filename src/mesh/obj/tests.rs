//! Tests of the parts and materials of OBJ files.

use crate::mesh::ledger::Reading;
use crate::mesh::model::{ModelLook, PhongLook};
use crate::mesh::tests::{SEVERAL_PARTS, corners, damage, damages, parse, parse_model};
use crate::mesh::{MeshError, MeshModel, read_model};
use glam::{Vec2, Vec3};
use proptest::prelude::*;
use std::sync::atomic::AtomicBool;

const USING_MATERIALS: &str = "mtllib of a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl Glass (blue)\nf 1 2 3\nusemtl plain\nf 3 2 1\n\
    usemtl Glass (blue)\nf 1 2 3\n";
const MATERIALS: &str = "# by hand\nnewmtl unused\nKd 9 9 9\nnewmtl Glass (blue)\n Kd 0.1 0.2 0.3\nKs 0.5\nNs 250\nNi 1.45\nTr 0.75\n\
    Tf 1 1 0.5\nillum 7\nmap_Kd -s 1 1 1 a.png\nKe 0 0 0\nPr 0.5\n\nnewmtl plain\nkd spectral a.rfl\nKe 1 0 0\nd -halo 0.5";

/// Reads an OBJ file with a file of materials beside it.
fn with_materials(obj: &str, mtl: &[u8]) -> Result<MeshModel, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), obj).unwrap();
    std::fs::write(folder.path().join("of a.mtl"), mtl).unwrap();
    let reading = Reading { memory: 1 << 24, progress: &|_| (), cancelled: &AtomicBool::new(false) };
    let place = format!("{}/", folder.path().display());
    read_model(&folder.path().join("a.obj"), &reading).map_err(|error| format!("{error:#}").replace(&place, ""))
}

fn omissions(model: &MeshModel) -> Vec<String> {
    model.omissions.iter().map(ToString::to_string).collect()
}

#[test]
fn faces_of_one_object_and_one_material_are_a_part() {
    let model = parse_model("a.obj", SEVERAL_PARTS);
    let parts: Vec<(&str, usize)> = model.parts.iter().map(|part| (part.name.as_str(), part.mesh.triangles().len())).collect();
    // The second face of `red` stands behind those of `blue`.
    assert_eq!(parts, [("house walls", 2), ("house walls", 1), ("roof walls", 1)]);
    let [first, second, third] = [0, 1, 2].map(|part| &model.parts[part].mesh);
    assert_eq!(corners(first), [[[0., 0., 0.], [1., 1., 0.], [1., 0., 0.]], [[0., 0., 0.], [0., 1., 0.], [1., 1., 0.]]]);
    assert_eq!(second.positions().len(), 3, "vertices of other parts are left out");
    assert_eq!((first.normals(), second.normals().len()), (&[Vec3::Z; 4][..], 0));
    assert_eq!(third.uvs(), [Vec2::new(0.25, 0.5), Vec2::ZERO, Vec2::ZERO]);
    let none = "2 materials that no file describes: their bodies have the default colour";
    assert_eq!(omissions(&model), ["1 line element", none]);
    // The parts together are the mesh of the file.
    let (mesh, _) = parse("a.obj", SEVERAL_PARTS);
    let mut all: Vec<_> = model.parts.iter().flat_map(|part| corners(&part.mesh)).collect();
    let mut whole = corners(&mesh);
    for list in [&mut all, &mut whole] {
        list.sort_by(|one, other| one.partial_cmp(other).unwrap());
    }
    assert_eq!(all, whole);
}

#[test]
fn parts_of_one_smooth_group_get_normals() {
    // Two triangles with an edge in common, at a right angle.
    let positions = "v 0 0 0\nv 0 1 0\nv 1 0 0\nv 0 0 1\n";
    let normals = |faces: &str| parse_model("a.obj", format!("{positions}{faces}")).parts[0].mesh.normals().to_vec();
    let smooth = normals("s 1\nf 1 3 2\nf 1 2 4\n");
    // On the edge, the mean of +z and +x; both triangles have the same angles there.
    let half = 0.5_f32.sqrt();
    assert!(smooth[0].abs_diff_eq(Vec3::new(half, 0.0, half), 1e-6), "{smooth:?}");
    for flat in
        ["f 1 3 2\nf 1 2 4\n", "s off\nf 1 3 2\nf 1 2 4\n", "s 1\nf 1 3 2\ns 2\nf 1 2 4\n", "s 1\nf 1 3 2\ns 0\nf 1 2 4\n"]
    {
        assert_eq!(normals(flat), [], "{flat}");
    }
}

#[test]
fn materials_are_read_as_written() {
    let model = with_materials(USING_MATERIALS, MATERIALS.as_bytes()).unwrap();
    assert_eq!(model.materials.iter().map(|material| material.name.as_str()).collect::<Vec<_>>(), ["Glass (blue)", "plain"]);
    assert_eq!(model.parts.iter().map(|part| part.material).collect::<Vec<_>>(), [Some(0), Some(1)]);
    let glass = PhongLook {
        diffuse: [0.1, 0.2, 0.3],
        specular: [0.5; 3],
        sharpness: 250.0,
        index: Some(1.45),
        coverage: 0.25,
        filter: [1.0, 1.0, 0.5],
        illumination: 7,
    };
    assert_eq!(model.materials[0].look, ModelLook::Phong(glass));
    let ModelLook::Phong(plain) = &model.materials[1].look else { panic!("{model:?}") };
    assert_eq!((plain.diffuse, plain.coverage, plain.illumination, plain.index), ([0.8; 3], 0.5, 2, None));
    let expected = [
        "1 texture with place or scale: the surface coordinates alone say where it is",
        "1 number of physical materials: `Pr`, `Pm` and the like are no part of MTL files proper",
        "1 colour not in RGB",
        "1 material with a light of their own: it is not shown",
        "1 image of base colours: cannot read the picture `FOLDER/a.png`: there is no such file",
    ];
    let mut found = omissions(&model);
    let last = found.last_mut().unwrap();
    // The folder is a temporary one.
    *last = last.replacen(&last[last.find('`').unwrap() + 1..last.rfind('/').unwrap()], "FOLDER", 1);
    assert_eq!(found, expected);
}

#[test]
fn mistakes_in_materials_have_places() {
    let obj = "mtllib of a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    let refused = |line: &str| with_materials(obj, format!("newmtl m\n{line}\n").as_bytes()).unwrap_err();
    let cases = [
        ("Kd 1 x 0", "of a.mtl:2:6: `x` is not a number\n    Kd 1 x 0\n         ^"),
        ("Kd 1 0", "of a.mtl:2:1: a number is missing after `Kd`"),
        ("Ns", "of a.mtl:2:1: a number is missing after `Ns`"),
        ("d nan", "of a.mtl:2:3: `nan` is not a finite number"),
        ("illum 12", "of a.mtl:2:7: `12` is not an illumination model"),
    ];
    for (line, expected) in cases {
        let found = refused(line);
        assert!(found.starts_with(expected), "{found}");
    }
}

#[test]
fn files_of_materials_that_cannot_be_read_are_left_out() {
    let read = |library: &str| {
        let obj = format!("mtllib {library}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
        omissions(&with_materials(&obj, b"").unwrap())
    };
    let missing = "1 material that no file describes: their bodies have the default colour";
    assert_eq!(read("of a.mtl"), [missing, "1 file of materials: it is empty"]);
    assert_eq!(read("/etc/passwd"), [missing, "1 file of materials not named by a relative path"]);
    let found = read("b.mtl c.mtl");
    assert_eq!(found.len(), 3);
    assert!(found[1].contains("b.mtl`: there is no such file") && found[2].contains("c.mtl`"), "{found:?}");
}

#[test]
fn many_names_are_counted_before_they_are_kept() {
    let obj: String = (0..10_000).map(|number| format!("g {number}\n")).collect();
    let path = tempfile::tempdir().unwrap();
    std::fs::write(path.path().join("a.obj"), obj).unwrap();
    let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &AtomicBool::new(false) };
    let error = read_model(&path.path().join("a.obj"), &reading).unwrap_err();
    assert!(matches!(error, MeshError::Memory { .. }), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 500, ..ProptestConfig::default() })]

    #[test]
    fn damaged_materials_are_survived(damages in prop::collection::vec(damages(), 1..6)) {
        let mut bytes = MATERIALS.as_bytes().to_vec();
        damages.iter().for_each(|(way, place, byte)| damage(&mut bytes, *way, *place, *byte));
        match with_materials(USING_MATERIALS, &bytes) {
            Ok(model) => prop_assert!(model.parts.iter().filter_map(|part| part.material).all(|place| place < model.materials.len())),
            Err(message) => prop_assert!(message.starts_with("of a.mtl:"), "{}", message),
        }
    }
}

/// A triangle with surface coordinates, of a material with this line.
fn with_image(line: &str, file: &str, bytes: &[u8]) -> MeshModel {
    let folder = tempfile::tempdir().unwrap();
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n";
    std::fs::write(folder.path().join("a.obj"), obj).unwrap();
    std::fs::write(folder.path().join("a.mtl"), format!("newmtl m\n{line}\nnewmtl unused\nmap_Kd nowhere.png\n")).unwrap();
    std::fs::create_dir(folder.path().join("maps")).unwrap();
    std::fs::write(folder.path().join(file), bytes).unwrap();
    let reading = Reading { memory: 1 << 24, progress: &|_| (), cancelled: &AtomicBool::new(false) };
    read_model(&folder.path().join("a.obj"), &reading).unwrap()
}

#[test]
fn images_of_the_matte_colour_are_found_behind_options() {
    let png = b"\x89PNG\r\n\x1a\n and more";
    for line in
        ["map_Kd maps/old wood.png", "map_Kd -blendu on -mm 0 1 maps\\old wood.png  ", "map_Kd -texres 64 \"maps/old wood.png\""]
    {
        let model = with_image(line, "maps/old wood.png", png);
        assert_eq!((model.materials[0].image, omissions(&model)), (Some(0), vec![]), "{line}");
        let image = &model.images[0];
        assert_eq!((image.name.as_str(), image.suffix, &image.bytes[..]), ("old wood", "png", &png[..]));
    }
    let held = with_image("map_Kd -clamp on a.png", "a.png", png);
    assert_eq!(
        (held.materials[0].image, omissions(&held)),
        (Some(0), vec!["1 texture held at the edges: it repeats here".to_owned()])
    );
    let place = with_image("map_Kd -o 0.5 1 -s 2 a.png", "a.png", png);
    assert_eq!(place.materials[0].image, Some(0));
    assert!(omissions(&place)[0].starts_with("2 textures with place or scale"));
    let other = with_image("map_Kd a.png", "a.png", b"BM");
    assert_eq!(omissions(&other), ["1 image of base colours: textures are PNG, JPEG, OpenEXR or Radiance HDR"]);
    for far in ["/a.png", "map_Kd /etc/a.png"] {
        let model = with_image(far, "a.png", png);
        assert_eq!((model.materials[0].image, model.images.len()), (None, 0), "{far}");
    }
    let bump = with_image("map_Bump a.png\nmap_Ks a.png", "a.png", png);
    assert_eq!((bump.images.len(), omissions(&bump)), (0, vec!["2 textures of other things than colour".to_owned()]));
}
