//! Tests of all formats: small files, damaged files, and bytes that are changed at random.

use super::*;
use glam::{DVec3, Vec2, Vec3};
use proptest::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{LazyLock, Mutex};

static NEVER: AtomicBool = AtomicBool::new(false);

/// Reads bytes as a file with this name.
pub(super) fn parse_within(memory: u64, name: &str, bytes: &[u8]) -> Result<(TriangleMesh, MeshRepairs), MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read(&path, &Reading { memory, progress: &|_| (), cancelled: &NEVER })
}

pub(super) fn parse(name: &str, bytes: impl AsRef<[u8]>) -> (TriangleMesh, MeshRepairs) {
    parse_within(1 << 30, name, bytes.as_ref()).unwrap_or_else(|error| panic!("{error:#}"))
}

/// The model in a file that reads no other.
pub(super) fn parse_model(name: &str, bytes: impl AsRef<[u8]>) -> MeshModel {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let reading = Reading { memory: 1 << 30, progress: &|_| (), cancelled: &NEVER };
    read_model(&path, &reading).unwrap_or_else(|error| panic!("{error:#}"))
}

/// The error of a file as it is shown, with its details, without its folder.
pub(super) fn refused(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let error = parse_within(1 << 30, name, bytes.as_ref()).unwrap_err();
    let text = format!("{error:#}");
    let at = text.find(&format!("/{name}")).unwrap_or_else(|| panic!("the file is named: {text}"));
    let start = text[..at].rfind(['`', '\n']).map_or(0, |before| before + 1);
    format!("{}{}", &text[..start], &text[at + 1..])
}

/// The corners of each triangle.
pub(super) fn corners(mesh: &TriangleMesh) -> Vec<[[f64; 3]; 3]> {
    let corners = |triangle: &[u32; 3]| triangle.map(|vertex| mesh.positions()[vertex as usize].to_array());
    mesh.triangles().iter().map(corners).collect()
}

const O: [f64; 3] = [0.0, 0.0, 0.0];
const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const XY: [f64; 3] = [1.0, 1.0, 0.0];

const SQUARE_OBJ: &str = "# a square\no square\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvn 0 0 2\n\
    usemtl red\ns off\nf 1/1/1 2/2/1 3//1 -1/1/-1\n";

/// Two objects of one group, with two materials. The faces of the first one are not together.
pub(super) const SEVERAL_PARTS: &str = "g walls\no house\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 2\nvt 0.25 0.5\n\
    usemtl red\nf 1//1 2//1 3//1\nusemtl blue\nf 1 2 3\nl 1 2\nusemtl red\nf 1//1 3//1 4//1\no roof\nf 1/1 2 4\n";

#[test]
fn obj_square_is_turned_and_complete() {
    let (mesh, repairs) = parse("square.OBJ", SQUARE_OBJ);
    assert_eq!(corners(&mesh), [[O, XY, X], [O, Y, XY]], "clockwise seen from +z");
    assert_eq!(mesh.normals(), [Vec3::Z; 4]);
    assert_eq!(mesh.uvs(), [Vec2::ZERO, Vec2::X, Vec2::ZERO, Vec2::ZERO]);
    assert_eq!(mesh.bounding_box().map(|corner| corner.to_array()), [O, XY]);
    assert_eq!(repairs, MeshRepairs::default());
    let [a, b, c] = corners(&mesh)[0].map(DVec3::from_array);
    assert!((c - a).cross(b - a).z > 0.0, "the front is towards +z, as that of the file");
}

#[test]
fn obj_lines_in_all_their_forms() {
    let joined = "v 0 0 0\r\nv 1 0 \\\r\n 0\r\n\r\nv 0 1 0 0.5 0.5 0.5\r\nl 1 2\nf -3 \\\n -2 -1 # end";
    assert_eq!(corners(&parse("a.obj", joined).0), [[O, Y, X]]);
    let unused = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\nf 2 2 3\n";
    let (mesh, repairs) = parse("a.obj", unused);
    assert_eq!(mesh.positions().len(), 3, "what nothing uses does not enlarge the box");
    assert_eq!(repairs.degenerate_triangles, 1);
    assert!(mesh.normals().is_empty());
}

#[test]
fn normals_that_are_missing_are_computed_and_counted() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nvn nan 0 0\nvn 0.6 0 0.8\nvt nan 0\nf 1/1/1 2/1/2 3/1/3\n";
    let (mesh, repairs) = parse("a.obj", text);
    assert_eq!(mesh.normals(), [Vec3::Z, Vec3::Z, Vec3::new(0.6, 0.0, 0.8)]);
    assert_eq!(repairs, MeshRepairs { missing_normals: 2, unusable_uvs: 3, ..MeshRepairs::default() });
    let (mesh, repairs) = parse("a.obj", text.replace("vn 0.6 0 0.8", "vn 0 0 0"));
    assert!(mesh.normals().is_empty(), "no normal is usable");
    assert_eq!(repairs.missing_normals, 0);
    let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &NEVER };
    assert_eq!(mesh.smooth("a.obj", &reading).unwrap().normals(), [Vec3::Z; 3]);
}

#[test]
fn obj_mistakes_have_places() {
    let start = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let cases = [
        ("f 1 2 9\n", "a.obj:4:7: there is no position 9: 3 stand before this line\n    f 1 2 9\n          ^"),
        ("f 1 2 -4\n", "a.obj:4:7: there is no position -4"),
        ("f 0 1 2\n", "a.obj:4:3: there is no position 0"),
        ("f 1/7 2 3\n", "a.obj:4:5: there is no texture coordinate 7: 0 stand"),
        ("f 1//1 2 3\n", "a.obj:4:6: there is no normal 1"),
        ("f 1/1/1/1 2 3\n", "a.obj:4:"),
        ("f 1 2\n", "a.obj:4:1: a face has at least three corners, and this one has 2"),
        ("f a b c\n", "a.obj:4:3: `a` is not an index"),
        ("f 99999999999999999999 1 2", "a.obj:4:3: `99999999999999999999` is not an index"),
        ("f -9223372036854775808 1 2", "a.obj:4:3: there is no position"),
        ("v 1 2\n", "a.obj:4:1: a number is missing: a position has three coordinates"),
        ("v 1 2 x\n", "a.obj:4:7: `x` is not a number"),
        ("v 1 2 nan\n", "a.obj:4:7: a coordinate is not a number"),
        ("v 1 -inf 0\n", "a.obj:4:5: a coordinate is infinite"),
        ("v 1 1e31 0\n", "a.obj:4:5: the coordinate 1e31 is too large"),
        ("\u{1}\u{2} 0\n", "a.obj:4:1: "),
        ("", "a.obj: it has no triangles"),
        ("f 1 1 2\nf 2 2 2\n", "a.obj: none of its 2 triangles has an area"),
    ];
    for (text, expected) in cases {
        let found = refused("a.obj", format!("{start}{text}"));
        assert!(found.starts_with(expected), "{found}");
    }
    assert_eq!(refused("a.obj", ""), "a.obj: the file is empty");
}

/// A PLY file of a square in two faces.
fn ply(encoding: &str, records: impl AsRef<[u8]>) -> Vec<u8> {
    let header = format!(
        "ply\nformat {encoding} 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty double y\n\
         property short z\nproperty uchar red\nelement edge 1\nproperty list uchar short ends\nelement face 2\n\
         property list uchar int vertex_indices\nproperty float quality\nend_header\n"
    );
    [header.as_bytes(), records.as_ref()].concat()
}

fn binary_records(big: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut put = |number: &[u8]| {
        let mut number = number.to_vec();
        if big {
            number.reverse();
        }
        bytes.extend(number);
    };
    for [x, y, z] in [O, X, XY, Y] {
        put(&(x as f32).to_le_bytes());
        put(&y.to_le_bytes());
        put(&(z as i16).to_le_bytes());
        put(&[7]);
    }
    put(&[2]);
    put(&1_i16.to_le_bytes());
    put(&2_i16.to_le_bytes());
    for face in [[0, 1, 2], [0, 2, 3]] {
        put(&[3]);
        face.iter().for_each(|vertex: &i32| put(&vertex.to_le_bytes()));
        put(&1_f32.to_le_bytes());
    }
    bytes
}

const PLY_TEXT: &str = "0 0 0 7\n1 0 0 7\n1 1 0 7\n0 1 0 7\n2 1 2\n3 0 1 2 1\n3 0 2 3 1\n";

#[test]
fn ply_encodings_give_the_same_square() {
    let expected = [[O, XY, X], [O, Y, XY]];
    let files = [
        ply("ascii", PLY_TEXT),
        ply("ascii", PLY_TEXT.trim_end().replace('\n', "\r\n")),
        ply("binary_little_endian", binary_records(false)),
        ply("binary_big_endian", binary_records(true)),
    ];
    for file in files {
        assert_eq!(corners(&parse("a.ply", file).0), expected);
    }
}

#[test]
fn ply_polygons_strips_normals_and_order() {
    let vertices = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n";
    let records = "0 0 0 0 0 1 .5 .25\n1 0 0 0 0 1 0 0\n1 1 0 0 0 1 0 0\n0 1 0 0 0 1 0 0\n";
    let polygon = format!("ply\nformat ascii 1.0\n{vertices}element face 1\nproperty list uint8 uint32 vertex_index\n");
    let (mesh, _) = parse("a.ply", format!("{polygon}end_header\n{records}4 0 1 2 3\n"));
    assert_eq!(corners(&mesh), [[O, XY, X], [O, Y, XY]]);
    assert_eq!(mesh.normals(), [Vec3::Z; 4]);
    assert_eq!(mesh.uvs()[0], Vec2::new(0.5, 0.25));
    let strips = format!("ply\nformat ascii 1.0\n{vertices}element tristrips 1\nproperty list int int vertex_indices\n");
    let (mesh, _) = parse("a.ply", format!("{strips}end_header\n{records}8 0 1 3 2 -1 0 1 2\n"));
    // The triangles of the strip 0 1 3 2 are 0 1 3 and 3 1 2.
    assert_eq!(corners(&mesh), [[O, Y, X], [Y, XY, X], [O, XY, X]]);
    let first = "ply\nformat ascii 1.0\nelement face 1\nproperty list uint8 uint32 vertex_index\n";
    let (mesh, _) = parse("a.ply", format!("{first}{vertices}end_header\n3 0 1 3\n{records}"));
    assert_eq!(corners(&mesh), [[O, Y, X]]);
}

#[test]
fn ply_mistakes_have_places() {
    let text = String::from_utf8(ply("ascii", PLY_TEXT)).unwrap();
    let change = |from: &str, to: &str| {
        assert!(text.contains(from));
        refused("a.ply", text.replace(from, to))
    };
    let cases = [
        (change("ply\n", "obj\n"), "a.ply:1:1: a PLY file begins with the line `ply`"),
        (change("ascii", "morse"), "a.ply:2:8: the encoding `morse` is not known"),
        (change("format ascii 1.0\n", ""), "a.ply:13:1: the header has no line `format`"),
        (change("double", "real"), "a.ply:6:10: the type `real` is not known"),
        (change("end_header\n", "end\n"), "a.ply:14:1: `end` is not known in a header"),
        (change("vertex 4", "vertex x"), "a.ply:4:16: `x` is not a number of records"),
        (change("vertex 4", "vertex 4000000000"), "a.ply:4:1: the header gives 4000000000 records of `vertex`"),
        (change("face 2", "face 20"), "a.ply:11:1: the header gives 20 records of `face`"),
        (change("face 2", "face 3"), "a.ply:22:1: the file ends in record 3 of 3 of `face`"),
        (change("property double y\n", ""), "a.ply:4:1: a vertex has no position"),
        (change("vertex_indices", "corners"), "a.ply:11:1: the element `face` has no list `vertex_indices`"),
        (change("1 1 0 7", "1 nan 0 7"), "a.ply:17:1: a coordinate is not a number"),
        (change("3 0 2 3 1", "3 0 2 4 1"), "a.ply:21:1: there is no vertex 4: the file has 4"),
        (change("3 0 2 3 1", "3 0 2 -1 1"), "a.ply:21:1: there is no vertex -1"),
        (change("3 0 2 3 1", "900 0 2 3 1"), "a.ply:21:1: a list has 900 values, but there is place for"),
        (change("3 0 2 3 1", "3 0 2"), "a.ply:22:1: the file ends in record 2 of 2 of `face`"),
        (change("element vertex 4\n", ""), "a.ply:4:1: a property stands before the first element"),
        (change("3 0 1 2 1\n3 0 2 3 1\n", "0 1\n1 2 0\n"), "a.ply: it has no triangles"),
    ];
    for (found, expected) in cases {
        assert!(found.starts_with(expected), "{found}\nexpected {expected}");
    }
    let header = &text[..text.find("end_header").unwrap()];
    assert!(refused("a.ply", header).contains("the header does not end"));
    let file = ply("binary_little_endian", binary_records(false));
    let found = refused("a.ply", &file[..file.len() - 1]);
    assert!(found.contains("the file ends in record 2 of 2 of `face` (at byte"), "{found}");
}

fn stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes[..5].copy_from_slice(b"solid");
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|number| (*number as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

const STL_TEXT: &str = "solid a square\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   VERTEX 1 1 0\n  \
    endloop\n endfacet\nfacet normal 0 0 1 outer loop vertex -0 0 0 vertex 1 1 0 vertex 0 1 0 endloop endfacet\nendsolid a square\n";

#[test]
fn stl_corners_become_shared_vertices() {
    for file in [stl(&[[O, X, XY], [O, XY, Y]]), STL_TEXT.as_bytes().to_vec()] {
        let (mesh, _) = parse("a.stl", file);
        assert_eq!(corners(&mesh), [[O, XY, X], [O, Y, XY]]);
        assert_eq!(mesh.positions().len(), 4);
    }
}

#[test]
fn stl_mistakes_have_places() {
    let change = |from: &str, to: &str| refused("a.stl", STL_TEXT.replacen(from, to, 1));
    let cases = [
        (change("vertex 1 0 0", "vertex 1 0 inf"), "a.stl:5:15: a coordinate is infinite"),
        (change("vertex 1 0 0", "vertex 1 0"), "a.stl:6:4: `VERTEX` is not a number"),
        (change("endloop", "vertex 0 0 0\nendloop"), "a.stl:7:3: a facet has three corners, and this is a fourth one"),
        (change("endsolid a square\n", ""), "a.stl:10:1: the file ends before `endsolid`"),
        (change("endloop endfacet\nendsolid a square\n", ""), "a.stl:9:71: the file ends where `endloop` was expected"),
        (refused("a.stl", "solid nothing\nendsolid nothing\n"), "a.stl: it has no triangles"),
        (refused("a.stl", "hello"), "a.stl: 5 bytes are too few for an STL file"),
    ];
    for (found, expected) in cases {
        assert!(found.starts_with(expected), "{found}\nexpected {expected}");
    }
    let mut lying = stl(&[[O, X, XY]]);
    lying[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let found = refused("a.stl", &lying);
    assert!(found.starts_with("a.stl: it says that it has 4294967295 triangles, but there is place for 1 only"), "{found}");
    let found = refused("a.stl", stl(&[[O, X, [0.0, f64::NAN, 0.0]]]));
    assert!(found.starts_with("a.stl: a coordinate is not a number (at byte 120)"), "{found}");
}

#[test]
fn data_behind_the_last_record_is_counted() {
    let mut long = stl(&[[O, X, XY], [O, XY, Y]]);
    long[80] = 1;
    let (mesh, repairs) = parse("a.stl", long);
    assert_eq!((mesh.triangles().len(), repairs.bytes_behind), (1, 50));
    let mut padded = stl(&[[O, X, XY]]);
    padded.extend([0; 7]);
    assert_eq!(parse("a.stl", padded).1, MeshRepairs::default());
    let binary = ply("binary_little_endian", binary_records(false));
    assert_eq!(parse("a.ply", &binary).1.bytes_behind, 0);
    assert_eq!(parse("a.ply", [&binary[..], b"more"].concat()).1.bytes_behind, 4);
    let text = ply("ascii", PLY_TEXT);
    assert_eq!(parse("a.ply", [&text[..], b"\n \n"].concat()).1.bytes_behind, 0);
    assert_eq!(parse("a.ply", [&text[..], b"3 0 1 2 1\n"].concat()).1.bytes_behind, 11, "with the end of the line before");
}

#[test]
fn files_that_are_not_meshes_are_refused() {
    assert!(refused("a.png", "x").starts_with("`a.png` is not a mesh by its suffix"));
    let folder = tempfile::tempdir().unwrap();
    let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &NEVER };
    let message = |name: &str| read(&folder.path().join(name), &reading).unwrap_err().to_string();
    assert!(message("none.obj").ends_with("none.obj`: there is no such file"));
    std::fs::create_dir(folder.path().join("folder.ply")).unwrap();
    assert!(message("folder.ply").ends_with("folder.ply` is a folder, not a mesh"));
    std::fs::write(folder.path().join("a.stl"), stl(&[[O, X, XY]])).unwrap();
    let error = read_model(&folder.path().join("a.stl"), &reading).unwrap_err().to_string();
    assert!(error.ends_with("has no parts: it is an STL file"), "{error}");
    assert_eq!(refused("a.obj", "v 0 0 0\nf 1 1 1\n"), "a.obj: its only triangle has no area");
}

#[test]
fn a_mesh_that_does_not_fit_tells_what_it_needs() {
    let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    text.push_str(&"f 1 2 3\n".repeat(2000));
    let message = |memory: u64| parse_within(memory, "a.obj", text.as_bytes()).unwrap_err().to_string();
    assert!(message(1000).contains("it needs 15.6 KiB or more, and 1000 bytes are allowed"), "{}", message(1000));
    assert!(message(30_000).contains("is too large: it needs "), "{}", message(30_000));
    assert!(parse_within(1 << 20, "a.obj", text.as_bytes()).is_ok());
}

#[test]
fn progress_is_told_and_work_is_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, SQUARE_OBJ.repeat(5000)).unwrap();
    let told = Mutex::new(Vec::new());
    let tell = |share: f64| told.lock().unwrap().push(share);
    read(&path, &Reading { memory: 1 << 30, progress: &tell, cancelled: &NEVER }).unwrap();
    let told = told.into_inner().unwrap();
    assert!(told.is_sorted() && told.len() > 5 && told.last() == Some(&1.0), "{told:?}");
    let cancelled = AtomicBool::new(false);
    let stop = |share: f64| cancelled.store(share > 0.3, Ordering::Relaxed);
    let outcome = read(&path, &Reading { memory: 1 << 30, progress: &stop, cancelled: &cancelled });
    assert!(outcome.unwrap_err().is_cancelled());
}

#[test]
fn parts_are_checked() {
    let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &NEVER };
    let parts =
        || MeshParts { positions: [O, X, Y].map(DVec3::from_array).to_vec(), triangles: vec![[0, 1, 2]], ..MeshParts::default() };
    assert!(TriangleMesh::new("parts", parts(), &reading).is_ok());
    let wrong = [
        MeshParts { triangles: vec![[0, 1, 3]], ..parts() },
        MeshParts { triangles: Vec::new(), ..parts() },
        MeshParts { normals: vec![Vec3::Z], ..parts() },
        MeshParts { positions: vec![DVec3::NAN; 3], ..parts() },
    ];
    for parts in wrong {
        assert!(TriangleMesh::new("parts", parts, &reading).is_err());
    }
}

/// A small file of each format and encoding.
static SAMPLES: LazyLock<Vec<(&'static str, Vec<u8>)>> = LazyLock::new(|| {
    let mut samples = vec![
        ("a.obj", SQUARE_OBJ.as_bytes().to_vec()),
        ("a.obj", SEVERAL_PARTS.as_bytes().to_vec()),
        ("a.ply", ply("ascii", PLY_TEXT)),
        ("a.ply", ply("binary_little_endian", binary_records(false))),
        ("a.ply", ply("binary_big_endian", binary_records(true))),
        ("a.stl", stl(&[[O, X, XY], [O, XY, Y]])),
        ("a.stl", STL_TEXT.as_bytes().to_vec()),
    ];
    samples.extend(gltf::tests::samples());
    samples
});

/// Reads bytes with little memory. Whatever they are, there is a valid mesh or an error that can be shown.
fn survives(name: &str, bytes: &[u8]) {
    // In a folder that does not exist, so that no other file is read.
    let path = Path::new("/nowhere").join(name);
    let reading = Reading { memory: 4 << 20, progress: &|_| (), cancelled: &NEVER };
    let format = MeshFormat::of(&path).unwrap();
    match format.parse(&MeshFile { path: &path, bytes }, &mut Ledger::new(&reading)) {
        Ok((mesh, _)) => is_sound(&mesh),
        Err(error) => assert!(!format!("{error:#}").is_empty()),
    }
    match format.parse_model(&MeshFile { path: &path, bytes }, &mut Ledger::new(&reading)) {
        Ok(model) => {
            model.parts.iter().for_each(|part| is_sound(&part.mesh));
            let count = model.materials.len();
            assert!(model.parts.iter().filter_map(|part| part.material).all(|material| material < count));
        }
        Err(error) => assert!(!format!("{error:#}").is_empty()),
    }
}

fn is_sound(mesh: &TriangleMesh) {
    let count = mesh.positions().len();
    assert!(!mesh.triangles().is_empty());
    assert!(mesh.triangles().iter().flatten().all(|vertex| (*vertex as usize) < count));
    assert!(mesh.positions().iter().all(|position| position.is_finite()));
    assert!(mesh.normals().iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
    assert!([0, count].contains(&mesh.normals().len()) && [0, count].contains(&mesh.uvs().len()));
}

#[test]
fn files_that_end_anywhere_are_survived() {
    for (name, bytes) in SAMPLES.iter() {
        parse(name, bytes);
        (0..bytes.len()).for_each(|end| survives(name, &bytes[..end]));
    }
}

/// What numbers of damaged texts become, and numbers of damaged binary files.
const WRONG_WORDS: [&str; 12] =
    ["nan", "-inf", "-1", "0", "", "1e39", "1e308", "100000000", "2147483648", "4294967295", "-9223372036854775808", "1e999"];
const WRONG_NUMBERS: [[u8; 4]; 8] = [
    [0xff; 4],
    [0; 4],
    [0, 0, 0xc0, 0x7f],
    [0x7f, 0xc0, 0, 0],
    [0, 0, 0x80, 0x7f],
    [0xff, 0xff, 0xff, 0x7f],
    [0, 0, 0, 0x10],
    [0x10, 0, 0, 0],
];
const DAMAGES: usize = 9;

/// A way of damage, a place, and a byte.
pub(super) fn damages() -> impl Strategy<Value = (usize, prop::sample::Index, u8)> {
    (0..DAMAGES, any::<prop::sample::Index>(), any::<u8>())
}

/// Damages bytes in one of the ways, at a place. `byte` says how, and how much of them.
pub(super) fn damage(bytes: &mut Vec<u8>, way: usize, place: prop::sample::Index, byte: u8) {
    if bytes.is_empty() {
        return;
    }
    let at = place.index(bytes.len());
    let piece = at..bytes.len().min(at + usize::from(byte % 64));
    match way {
        0 => bytes[at] = byte,
        // Digits stay digits, so that numbers change.
        1 => bytes[at] = if bytes[at].is_ascii_digit() { b'0' + byte % 10 } else { byte },
        2 => bytes.insert(at, byte % 128),
        3 => bytes[at] ^= 1 << (byte % 8),
        4 => bytes.truncate(at),
        5 => drop(bytes.drain(piece)),
        6 => {
            let repeated = bytes[piece].to_vec();
            bytes.splice(at..at, repeated);
        }
        7 => {
            let end = bytes.len().min(at + 4);
            bytes.splice(at..end, WRONG_NUMBERS[usize::from(byte) % WRONG_NUMBERS.len()]);
        }
        _ => {
            // The number that begins at the place or behind it.
            let is_number = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-');
            let start = at + bytes[at..].iter().take_while(|byte| !is_number(byte)).count();
            let length = bytes[start..].iter().take_while(|byte| is_number(byte)).count();
            bytes.splice(start..start + length, WRONG_WORDS[usize::from(byte) % WRONG_WORDS.len()].bytes());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 4000, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_of_all_formats_are_survived(
        damages in prop::collection::vec(damages(), 1..6),
    ) {
        for (name, bytes) in SAMPLES.iter() {
            let mut bytes = bytes.clone();
            damages.iter().for_each(|(way, place, byte)| damage(&mut bytes, *way, *place, *byte));
            survives(name, &bytes);
        }
    }
}
