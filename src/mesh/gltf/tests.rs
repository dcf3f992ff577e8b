//! Tests of glTF files.

use crate::mesh::model::{LightSource, ModelLook};
use crate::mesh::tests::{corners, parse, parse_model, parse_within, refused};
use crate::mesh::{MeshError, MeshModel, Reading, read, read_model};
use glam::{DVec3, Vec2, Vec3};
use std::sync::atomic::AtomicBool;

const O: [f64; 3] = [0.0, 0.0, 0.0];
const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const XY: [f64; 3] = [1.0, 1.0, 0.0];

/// Four positions of a square (48 bytes), the indices 0 1 2 3 and 0 2 3 as bytes, padding, and the normal -z of a
/// vertex.
fn buffer() -> Vec<u8> {
    let mut bytes: Vec<u8> = [O, X, XY, Y].iter().flatten().flat_map(|number| (*number as f32).to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0, 2, 3, 0, 0]);
    bytes.extend([0.0_f32, 0.0, -3.0].iter().flat_map(|number| number.to_le_bytes()));
    bytes
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let bits = (0..3).fold(0, |bits, place| bits << 8 | u32::from(three.get(place).copied().unwrap_or(0)));
        for place in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * place)) as usize & 63] as char;
            text.push(if place > three.len() { '=' } else { letter });
        }
    }
    text
}

/// A document with the square. `uri` is that of the buffer, with its comma.
fn document(uri: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}},
"buffers": [{{{uri}"byteLength": 68}}],
"bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 6}},
  {{"buffer": 0, "byteOffset": 56, "byteLength": 12}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
  {{"bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR"}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
"nodes": [{{"mesh": 0}}], "scenes": [{{"nodes": [0]}}], "scene": 0}}"#
    )
}

fn embedded() -> String {
    document(&format!(r#""uri": "data:application/octet-stream;base64,{}", "#, base64(&buffer())))
}

/// The embedded file after changes of its text.
fn changed(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(embedded(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", binary)].concat();
    let length = (12 + chunks.len()) as u32;
    [&b"glTF"[..], &2_u32.to_le_bytes(), &length.to_le_bytes(), &chunks].concat()
}

/// A small file of each kind, for tests that change their bytes.
pub(in crate::mesh) fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let sparse = changed(&[SPARSE, (r#""indices": 1"#, r#""mode": 5"#)]);
    vec![
        ("a.gltf", embedded().into_bytes()),
        ("a.glb", glb(&document(""), &buffer())),
        ("a.gltf", sparse.into_bytes()),
        ("a.gltf", changed(&[MIRRORED]).into_bytes()),
        ("a.gltf", furnished().into_bytes()),
    ]
}

/// The first vertex is moved to (0, 0, -3).
const SPARSE: (&str, &str) = (
    r#""count": 4, "type": "VEC3""#,
    r#""count": 4, "type": "VEC3", "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5121},
    "values": {"bufferView": 2}}"#,
);
/// A child of a node that is moved; the child is turned about z by 90 degrees, and mirrored first.
const MIRRORED: (&str, &str) = (
    r#"[{"mesh": 0}]"#,
    r#"[{"children": [1], "translation": [10, 0, 0]}, {"mesh": 0, "scale": [-2, 1, 1],
    "rotation": [0, 0, 0.70710678118, 0.70710678118]}]"#,
);

#[test]
fn the_same_square_from_all_containers() {
    let expected = [[O, XY, X], [O, Y, XY]];
    assert_eq!(corners(&parse("a.gltf", embedded()).0), expected);
    assert_eq!(corners(&parse("a.glb", glb(&document(""), &buffer())).0), expected);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my data.bin"), buffer()).unwrap();
    std::fs::write(folder.path().join("a.gltf"), document(r#""uri": "my%20data.bin", "#)).unwrap();
    let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &AtomicBool::new(false) };
    assert_eq!(corners(&read(&folder.path().join("a.gltf"), &reading).unwrap().0), expected);
    std::fs::remove_file(folder.path().join("my data.bin")).unwrap();
    let error = read(&folder.path().join("a.gltf"), &reading).unwrap_err();
    assert!(matches!(error, MeshError::File(_)));
    assert!(error.to_string().contains("my data.bin`: there is no such file; `"), "{error}");
}

#[test]
fn strips_fans_and_lists_without_indices() {
    let mode = |mode: &str| corners(&parse("a.gltf", changed(&[(r#""indices": 1"#, mode)])).0);
    assert_eq!(mode(r#""mode": 5"#), [[O, XY, X], [XY, Y, X]].map(|[a, b, c]| [a, b, c]));
    assert_eq!(mode(r#""mode": 6"#), [[O, XY, X], [O, Y, XY]]);
    let three = changed(&[(r#""indices": 1"#, r#""mode": 4"#), (r#""count": 4"#, r#""count": 3"#)]);
    assert_eq!(corners(&parse("a.gltf", three).0), [[O, XY, X]]);
    assert!(refused("a.gltf", changed(&[(r#""indices": 1"#, r#""mode": 1"#)])).contains("it has no triangles"));
}

#[test]
fn transforms_move_positions_and_mirrors_keep_the_front() {
    let (mesh, _) = parse("a.gltf", changed(&[MIRRORED]));
    // (x, y) becomes (10 - y, -2x).
    let expected = [[[10., 0., 0.], [10., -2., 0.], [9., -2., 0.]], [[10., 0., 0.], [9., -2., 0.], [9., 0., 0.]]];
    let found = corners(&mesh);
    let error = found.iter().flatten().flatten().zip(expected.iter().flatten().flatten()).map(|(a, b)| (a - b).abs());
    assert!(error.fold(0.0, f64::max) < 1e-9, "{found:?}");
    let matrix = r#"[{"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1]}]"#;
    assert_eq!(corners(&parse("a.gltf", changed(&[(r#"[{"mesh": 0}]"#, matrix)])).0)[0][0], [5.0, 6.0, 7.0]);
}

#[test]
fn normals_stay_perpendicular() {
    // The positions serve as normals: that of the third vertex is (1, 1, 0).
    let unequal = (r#"[{"mesh": 0}]"#, r#"[{"mesh": 0, "scale": [2, 1, 1]}]"#);
    let normals = (r#""POSITION": 0"#, r#""POSITION": 0, "NORMAL": 0"#);
    let (mesh, repairs) = parse("a.gltf", changed(&[unequal, normals]));
    let expected = Vec3::new(1.0, 2.0, 0.0).normalize();
    let third = mesh.positions().iter().position(|position| position.to_array() == [2.0, 1.0, 0.0]).unwrap();
    assert!((mesh.normals()[third] - expected).length() < 1e-6);
    assert_eq!(repairs.missing_normals, 1, "that of the first vertex is 0");
    assert_eq!(mesh.normals()[0], Vec3::Z);
}

#[test]
fn sparse_and_normalised_numbers() {
    let (mesh, _) = parse("a.gltf", changed(&[SPARSE]));
    assert_eq!(corners(&mesh)[0][0], [0.0, 0.0, -3.0]);
    // The bytes 0 1 2 0 2 3 as three pairs, normalised.
    let uv = (r#""POSITION": 0"#, r#""POSITION": 0, "TEXCOORD_0": 2"#);
    let more = (
        r#""type": "SCALAR"}"#,
        r#""type": "SCALAR"}, {"bufferView": 1, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2"}"#,
    );
    let three = [(r#""count": 4"#, r#""count": 3"#), (r#", "indices": 1"#, ""), uv, more];
    assert_eq!(parse("a.gltf", changed(&three)).0.uvs()[2], Vec2::new(2.0, 252.0) / 255.0, "v is 1 - 3/255");
}

#[test]
fn mistakes_are_told() {
    let required = r#"{"extensionsRequired": ["KHR_draco_mesh_compression"], "asset""#;
    let child = r#"[{"mesh": 0, "children": [0]}]"#;
    let cases = [
        ((r#"{"asset""#, required), "it requires the extension `KHR_draco_mesh_compression`, which is not read"),
        ((r#"[{"mesh": 0}]"#, child), "nodes[0] stands twice in the tree of nodes"),
        ((r#"[{"mesh": 0}]"#, r#"[{"mesh": 3}]"#), "there is no meshes[3]: the file has 1"),
        ((r#"{"nodes": [0]}"#, r#"{"nodes": [5]}"#), "there is no nodes[5]"),
        ((r#""indices": 1"#, r#""indices": 0"#), "accessors[0] holds no indices of vertices"),
        ((r#""indices": 1"#, r#""indices": 9"#), "meshes[0].primitives[0]: there is no accessors[9]"),
        ((r#""indices": 1"#, r#""mode": 9"#), "the mode 9 is not known"),
        ((r#""count": 4"#, r#""count": 2"#), "there is no vertex 2: there are 2"),
        ((r#""count": 4"#, r#""count": 5"#), "accessors[0] has 5 elements, which do not fit into bufferViews[0] of 48 bytes"),
        ((r#""count": 4"#, r#""count": 4000000000"#), "accessors[0] has 4000000000 elements, but the buffers have 68 bytes"),
        ((r#""count": 6"#, r#""count": 5"#), "5 corners are not three for each triangle"),
        ((r#""byteLength": 48"#, r#""byteLength": 480"#), "bufferViews[0] does not fit into its buffer of 68 bytes"),
        ((r#""byteLength": 48"#, r#""byteLength": 48, "byteStride": 4"#), "elements of 12 bytes every 4 bytes"),
        ((r#""byteLength": 68"#, r#""byteLength": 69"#), "buffers[0] has 68 bytes, and 69 are needed"),
        ((r#""componentType": 5126"#, r#""componentType": 1"#), "components of the unknown type 1"),
        ((r#""type": "VEC3""#, r#""type": "VEC4""#), "is of the type `VEC4`, and `VEC3` is needed"),
        ((";base64,", ","), "has data that are not base64"),
        (("base64,", "base64,$"), "has wrong base64"),
        (("data:application", "http://application"), "is not a relative path"),
        (("data:application/octet-stream;base64,", "../../secret/"), "leads out of the folder of the file"),
        (("data:application/octet-stream;base64,", "a/%2e%2e/b/"), "leads out of the folder of the file"),
        ((r#""2.0""#, r#""1.0""#), "it is of version 1.0 of glTF, and only glTF 2.0 is read"),
        (("data:application/octet", "/etc/passwd/octet"), "is not a relative path"),
        ((r#"[{"mesh": 0}]"#, r#"[{"mesh": 0, "scale": [1e300, 1, 1]}]"#), "vertex 1: the coordinate 1e300 is too large"),
    ];
    for (change, expected) in cases {
        let found = refused("a.gltf", changed(&[change]));
        assert!(found.contains(expected), "{found}\nexpected {expected}");
    }
    // The lists of glTF 1.0 are objects.
    let old = r#"{"asset": {"version": "1.0"}, "nodes": {"a": {}}}"#;
    assert!(refused("a.gltf", old).contains("only glTF 2.0 is read"), "{}", refused("a.gltf", old));
    let whole = changed(&[]);
    let found = refused("a.gltf", &whole[..whole.len() / 2]);
    assert!(found.contains("the file ends in the middle of its JSON") && found.ends_with("help: the file is cut off"), "{found}");
    let found = refused("a.gltf", changed(&[(r#""buffer": 0, "byteLength": 48"#, r#""buffer": 0 "byteLength": 48"#)]));
    assert!(found.starts_with("a.gltf:3:30: the JSON of the glTF file is wrong: expected `,` or `}`"), "{found}");
}

#[test]
fn containers_that_are_cut_off_are_told() {
    let whole = glb(&document(""), &buffer());
    let found = refused("a.glb", &whole[..whole.len() - 1]);
    assert!(found.contains("bytes, and it has") && found.contains("(at byte 8)"), "{found}");
    let mut version = whole.clone();
    version[4] = 1;
    assert!(refused("a.glb", &version).contains("it is of version 1 of glTF, and only glTF 2.0 is read"));
    let mut chunk = whole.clone();
    chunk[15] = 0xff;
    assert!(refused("a.glb", &chunk).contains("the file ends in the middle of a chunk"));
    assert!(refused("a.glb", glb(&document(r#""uri": "a.glb/x", "#), &[])).contains("not a folder"));
    let missing = parse_within(1 << 20, "a.glb", &glb(&document(r#""uri": "no.bin", "#), &[])).unwrap_err().to_string();
    assert!(missing.starts_with("cannot read the file `") && missing.contains("no.bin`: there is no such file"), "{missing}");
}

#[test]
fn json_of_many_objects_is_counted_first() {
    let nodes = format!(r#"{{"nodes": [{}{{}}]}}"#, "{},".repeat(10_000));
    let error = parse_within(1 << 20, "a.gltf", nodes.as_bytes()).unwrap_err();
    assert!(matches!(error, MeshError::Memory { .. }), "{error}");
}

/// The square at two nodes, as two primitives of two materials, with two cameras and three lights.
fn furnished() -> String {
    let two = r#"[{"name": "pane", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 1},
        {"attributes": {"POSITION": 0, "COLOR_0": 0}, "indices": 1, "mode": 6, "targets": [{}]},
        {"attributes": {"POSITION": 0}, "mode": 1}]}]"#;
    let nodes = r#"[{"name": "left", "mesh": 0, "children": [1, 2, 3]},
        {"name": "eye", "camera": 1, "translation": [0, 1, 5], "rotation": [0, 0.70710678118, 0, 0.70710678118]},
        {"camera": 0}, {"mesh": 0, "translation": [9, 0, 0], "scale": [-1, 1, 1], "children": [4, 5, 6]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [1, 2, 3]},
        {"name": "sun", "extensions": {"KHR_lights_punctual": {"light": 1}}, "rotation": [-0.70710678118, 0, 0, 0.70710678118]},
        {"extensions": {"KHR_lights_punctual": {"light": 2}}, "camera": 2}]"#;
    let more = r#""extensionsUsed": ["KHR_lights_punctual", "KHR_materials_ior", "ODD_thing"], "textures": [{}, {}],
        "animations": [{"channels": []}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"name": "lamp", "type": "point", "intensity": 50, "color": [1, 0.5, 0]},
        {"type": "directional"}, {"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}}]}},
        "cameras": [{"type": "orthographic", "orthographic": {}}, {"type": "perspective", "perspective": {"yfov": 0.5,
        "aspectRatio": 1.5, "znear": 0.1}}, {"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
        "materials": [{}, {"name": "glass", "alphaMode": "BLEND", "emissiveFactor": [0, 1, 0], "pbrMetallicRoughness":
        {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.25, "roughnessFactor": 0.75}, "extensions":
        {"KHR_materials_ior": {"ior": 1.33}, "KHR_materials_transmission": {"transmissionFactor": 0.9},
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.5}}}], "scene": 0}"#;
    let (mesh, node) = (r#"[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]"#, r#"[{"mesh": 0}]"#);
    changed(&[(mesh, two), (node, nodes), (r#""scene": 0}"#, more)])
}

fn model() -> MeshModel {
    parse_model("a.gltf", furnished())
}

#[test]
fn each_primitive_at_each_node_is_a_part() {
    let model = model();
    let parts: Vec<_> = model.parts.iter().map(|part| (part.name.as_str(), part.material)).collect();
    assert_eq!(parts, [("left", Some(1)), ("left", None), ("pane", Some(1)), ("pane", None)]);
    assert_eq!(corners(&model.parts[0].mesh), [[O, XY, X], [O, Y, XY]]);
    // Mirrored at x = 0 and moved by 9; the front stays the front.
    let mirrored = [[[9., 0., 0.], [8., 0., 0.], [8., 1., 0.]], [[9., 0., 0.], [8., 1., 0.], [9., 1., 0.]]];
    assert_eq!(corners(&model.parts[2].mesh), mirrored);
    let left_out: Vec<String> = model.omissions.iter().map(ToString::to_string).collect();
    let expected = [
        "1 material with a light of their own: it is not shown",
        "1 animation",
        "1 part with morph targets",
        "1 part with colours of vertices",
        "1 extension: `ODD_thing`",
        "1 other camera: the first one is used",
        "1 camera without perspective",
        "2 parts of points or lines",
    ];
    assert_eq!(left_out, expected);
}

#[test]
fn cameras_and_lights_stand_where_their_nodes_are() {
    let model = model();
    let near = |one: DVec3, other: [f64; 3]| assert!(one.abs_diff_eq(DVec3::from_array(other), 1e-9), "{one}");
    let camera = model.camera.unwrap();
    near(camera.position, [0., 1., 5.]);
    // Turned to the left by a right angle.
    near(camera.gaze, [-1., 0., 0.]);
    near(camera.up, [0., 1., 0.]);
    assert!((camera.fov - 28.64788975654116).abs() < 1e-12, "0.5 radians");
    assert_eq!(camera.aspect, Some(1.5));
    let [lamp, sun, spot] = &model.lights[..] else { panic!("{:?}", model.lights) };
    assert_eq!((lamp.name.as_str(), lamp.color, lamp.intensity), ("lamp", [1.0, 0.5, 0.0], 50.0));
    // In the mirrored node: 9 - 1.
    assert_eq!(lamp.source, LightSource::Point(DVec3::new(8.0, 2.0, 3.0)));
    let LightSource::Directional(down) = sun.source else { panic!("{sun:?}") };
    near(down, [0., -1., 0.]);
    assert_eq!((sun.name.as_str(), sun.intensity, sun.color), ("sun", 1.0, [1.0; 3]));
    let LightSource::Spot { place, direction, angles } = spot.source else { panic!("{spot:?}") };
    assert_eq!((place, direction, angles), (DVec3::new(9.0, 0.0, 0.0), DVec3::NEG_Z, [0.25, 0.5]));
}

#[test]
fn materials_are_as_the_file_says() {
    let model = model();
    let [ModelLook::Physical(default), ModelLook::Physical(glass)] = [0, 1].map(|place| &model.materials[place].look) else {
        panic!("{:?}", model.materials)
    };
    assert_eq!((default.base, default.metallic, default.roughness, default.index), ([1.0; 3], 1.0, 1.0, 1.5));
    assert_eq!((default.coverage, default.transmission, default.specular, default.coat), (1.0, 0.0, 1.0, 0.0));
    assert_eq!((glass.base, glass.metallic, glass.roughness, glass.index), ([0.1, 0.2, 0.3], 0.25, 0.75, 1.33));
    assert_eq!((glass.coverage, glass.transmission, glass.coat), (0.4, 0.9, 0.5));
    assert!(default.is_thin && !glass.is_thin);
}

#[test]
fn mistakes_beside_the_triangles_are_told_and_do_not_hinder_the_mesh() {
    let cases = [
        (r#""material": 1"#, r#""material": 7"#, "meshes[0].primitives[0]: there is no materials[7]: the file has 2"),
        (r#""camera": 1"#, r#""camera": 7"#, "nodes[1] has the camera 7: the file has 3"),
        (r#"{"light": 0}"#, r#"{"light": 7}"#, "nodes[4] has the light 7: the file has 3"),
        (r#""type": "spot""#, r#""type": "tube""#, "the JSON of the glTF file is wrong: unknown variant `tube`"),
        (r#""metallicFactor": 0.25"#, r#""metallicFactor": "x""#, "wrong: invalid type: string \"x\", expected a number"),
        (r#"{"light": 0}"#, r#"{"light": -1}"#, "invalid value: integer `-1`, expected a whole number of at least 0"),
        (r#"{"light": 0}"#, r#"{"light": 0.5}"#, "invalid type: floating point `0.5`, expected a whole number of at least 0"),
        (r#""name": "lamp""#, r#""name": 3"#, "invalid type: integer `3`, expected a string"),
        (
            r#""translation": [0, 1, 5]"#,
            r#""scale": [0, 0, 0]"#,
            "the transform of nodes[1] gives its camera no place or no direction",
        ),
    ];
    for (from, to, expected) in cases {
        let text = furnished();
        assert!(text.contains(from), "{from}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &AtomicBool::new(false) };
        let error = read_model(&path, &reading).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\nexpected {expected}");
        assert!(read(&path, &reading).is_ok());
    }
}

#[test]
fn deep_trees_of_nodes_are_walked() {
    let count = 20_000;
    let nodes: Vec<String> = (1..count).map(|child| format!(r#"{{"children": [{child}], "translation": [1, 0, 0]}}"#)).collect();
    let nodes = format!(r#"[{}, {{"mesh": 0}}]"#, nodes.join(", "));
    let model = parse_model("a.gltf", changed(&[(r#"[{"mesh": 0}]"#, &nodes)]));
    assert_eq!(model.parts[0].mesh.bounding_box()[0].x, f64::from(count - 1));
}

/// The square with surface coordinates, and a material whose base texture is `reference`.
fn textured(reference: &str, texture: &str, image: &str, file: Option<(&str, &[u8])>) -> Result<MeshModel, String> {
    let uv: Vec<u8> = [0.0_f32, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0].iter().flat_map(|number| number.to_le_bytes()).collect();
    let png = base64(b"\x89PNG\r\n\x1a\ninside");
    let buffers = format!(
        r#"}}, {{"uri": "data:;base64,{}", "byteLength": 32}}, {{"uri": "data:;base64,{png}", "byteLength": 14}}], "images": [{image}],
        "textures": [{texture}], "samplers": [{{"wrapS": 33071, "magFilter": 9728}}],
        "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {reference}}}, "normalTexture": {{"index": 0}}}}],"#,
        base64(&uv)
    );
    let text = changed(&[
        ("}],", &buffers),
        (r#""bufferViews": ["#, r#""bufferViews": [{"buffer": 1, "byteLength": 32}, {"buffer": 2, "byteLength": 14}, "#),
        (r#""accessors": [{"bufferView": 0"#, r#""accessors": [{"bufferView": 2"#),
        (r#"{"bufferView": 1,"#, r#"{"bufferView": 3,"#),
        (r#""type": "SCALAR"}"#, r#""type": "SCALAR"}, {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC2"}"#),
        (r#""POSITION": 0}"#, r#""POSITION": 0, "TEXCOORD_0": 2}, "material": 0"#),
    ]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, text).unwrap();
    if let Some((name, bytes)) = file {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    read_model(&path, &Reading::unwatched(1 << 20)).map_err(|error| error.to_string())
}

#[test]
fn images_of_base_colours_are_kept() {
    let left_out = |model: &MeshModel| model.omissions.iter().map(ToString::to_string).collect::<Vec<_>>();
    let plain = (r#"{"index": 0}"#, r#"{"source": 0}"#);
    let embedded = [
        r#"{"mimeType": "image/png", "name": "Wood.png", "bufferView": 1}"#.to_owned(),
        format!(r#"{{"uri": "data:image/png;base64,{}", "name": "Wood"}}"#, base64(b"\x89PNG\r\n\x1a\ninside")),
    ];
    for image in &embedded {
        let model = textured(plain.0, plain.1, image, None).unwrap();
        assert_eq!((model.materials[0].image, model.images.len()), (Some(0), 1));
        let found = &model.images[0];
        assert_eq!((found.name.as_str(), found.suffix, &found.bytes[..]), ("Wood", "png", &b"\x89PNG\r\n\x1a\ninside"[..]));
        assert_eq!(left_out(&model), ["1 texture of bumps"]);
        // v goes upwards.
        assert_eq!(model.parts[0].mesh.uvs()[0], Vec2::new(0.0, 1.0));
    }
    let beside = textured(plain.0, plain.1, r#"{"uri": "my%20wood.jpg"}"#, Some(("my wood.jpg", b"\xff\xd8\xff\xe0"))).unwrap();
    assert_eq!((beside.images[0].name.as_str(), beside.images[0].suffix), ("my wood", "jpg"));
    let missing = textured(plain.0, plain.1, r#"{"uri": "wood.jpg"}"#, None).unwrap();
    assert_eq!((missing.materials[0].image, missing.images.len()), (None, 0));
    assert!(left_out(&missing)[1].ends_with("wood.jpg`: there is no such file"), "{:?}", left_out(&missing));
    let webp = textured(plain.0, plain.1, r#"{"uri": "wood.webp"}"#, Some(("wood.webp", b"RIFF"))).unwrap();
    assert_eq!(left_out(&webp)[1], "1 image of base colours: textures are PNG, JPEG, OpenEXR or Radiance HDR");
    let held = textured(plain.0, r#"{"source": 0, "sampler": 0}"#, &embedded[0], None).unwrap();
    let notes =
        ["1 texture held or mirrored at the edges: it repeats here", "1 texture of plain texels: it is interpolated here"];
    assert_eq!(left_out(&held)[1..], notes);
    let second = textured(r#"{"index": 0, "texCoord": 1}"#, plain.1, &embedded[0], None).unwrap();
    assert_eq!((second.materials[0].image, left_out(&second).len()), (None, 2));
    let extension = textured(plain.0, "{}", &embedded[0], None).unwrap();
    assert_eq!(left_out(&extension)[1], "1 image of base colours: its format is one of an extension");
}

#[test]
fn textures_are_moved_turned_and_scaled() {
    let image = r#"{"bufferView": 1}"#;
    let uvs = |transform: &str| {
        let reference = format!(r#"{{"index": 0, "extensions": {{"KHR_texture_transform": {transform}}}}}"#);
        textured(&reference, r#"{"source": 0}"#, image, None).unwrap().parts[0].mesh.uvs().to_vec()
    };
    let near = |found: Vec<Vec2>, expected: [[f32; 2]; 4]| {
        assert!(found.iter().zip(expected).all(|(one, other)| one.abs_diff_eq(Vec2::from(other), 1e-6)), "{found:?}");
    };
    // In the file the corners are (0,0), (1,0), (1,1), (0,1), with v downwards; here v is 1 - that.
    near(uvs("{}"), [[0., 1.], [1., 1.], [1., 0.], [0., 0.]]);
    near(uvs(r#"{"offset": [0.5, 0.25], "scale": [2, 3]}"#), [[0.5, 0.75], [2.5, 0.75], [2.5, -2.25], [0.5, -2.25]]);
    // Counter-clockwise about the upper left corner: where u grew, v of the file now falls.
    near(uvs(r#"{"rotation": 1.5707963267948966}"#), [[0., 1.], [0., 2.], [1., 2.], [1., 1.]]);
}

#[test]
fn wrong_textures_are_told() {
    let image = r#"{"bufferView": 1}"#;
    let refused = |reference: &str, texture: &str, image: &str| textured(reference, texture, image, None).unwrap_err();
    for (reference, texture, image, expected) in [
        (r#"{"index": 5}"#, "{}", image, "there is no textures[5]: the file has 1"),
        (r#"{"index": 0}"#, r#"{"source": 5}"#, image, "there is no images[5]: the file has 1"),
        (r#"{"index": 0}"#, r#"{"source": 0}"#, r#"{"bufferView": 9}"#, "images[0] is not within its buffer"),
        (r#"{"index": 0}"#, r#"{"source": 0}"#, "{}", "images[0] has neither a `uri` nor a `bufferView`"),
        (r#"{"index": 0}"#, r#"{"source": 0}"#, r#"{"uri": "data:x"}"#, "the `uri` of images[0] has data that are not base64"),
        (
            r#"{"index": 0}"#,
            r#"{"source": 0}"#,
            r#"{"uri": "../../../../etc/x://y"}"#,
            "the `uri` of images[0] is not a relative path",
        ),
    ] {
        let error = refused(reference, texture, image);
        assert!(error.contains(expected), "{error}\nexpected {expected}");
    }
}
