//! Importing files of other programs.

use crate::messages::check;
use crate::{folder, run, told, write};
use illuminator::lang::source::Source;
use illuminator::mesh::{Reading, read};
use illuminator::workspace::{Location, Session};
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Two walls and a pane of glass, with a file of materials.
const HOUSE: &str = "mtllib house.mtl\no House.001\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 2 -3\nv 0 0 -3\nusemtl Red brick\nf 1 2 3 4\n\
    usemtl glass\nf 1 4 5 6\no lights\nusemtl Red brick\nf 2 1 6\nl 1 2\n";
const MATERIALS: &str = "newmtl Red brick\nKd 0.6 0.2 0.1\nKs 0.05 0.05 0.05\nNs 20\nillum 2\nmap_Kd brick.png\n\
    newmtl glass\nKd 0 0 0\nKs 1 1 1\nNs 900\nNi 1.5\nTf 1 1 1\nillum 7\n";

/// A triangle of three positions, in base64, in a document with a camera and three lights.
const TRIANGLE: &str = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"],
"extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "name": "Lamp", "intensity": 90, "spot": {}},
    {"type": "directional", "intensity": 5, "color": [1, 0.5, 0.25]}]}},
"buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
"materials": [{"name": "gold", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.75, 0.25, 1], "roughnessFactor": 0.2}}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
"cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1, "aspectRatio": 1.5}}],
"nodes": [{"name": "Sail", "mesh": 0, "scale": [2, 2, 2], "children": [1]}, {"camera": 0, "translation": [0, 0, 5]},
    {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0.5, 0.5, 3]},
    {"name": "Sun", "extensions": {"KHR_lights_punctual": {"light": 1}}}],
"scenes": [{"nodes": [0, 2, 3]}], "scene": 0}"#;

fn written(folder: &Path, names: [&str; 2]) -> String {
    let text = |name: &str| fs::read_to_string(folder.join(name)).expect("a file");
    names.map(|name| format!("== {name}\n{}", text(name))).join("\n")
}

/// The corners of the triangles in a mesh.
fn corners(path: &Path) -> Vec<[[f64; 3]; 3]> {
    let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &AtomicBool::new(false) };
    let (mesh, _) = read(path, &reading).expect("a mesh");
    mesh.triangles().iter().map(|triangle| triangle.map(|vertex| mesh.positions()[vertex as usize].to_array())).collect()
}

#[test]
fn an_obj_file_becomes_a_scene_and_a_session() {
    let folder = folder();
    write(&folder, "house.obj", HOUSE);
    write(&folder, "house.mtl", MATERIALS);
    let said = told(folder.path(), "import house.obj -o out.scene");
    insta::assert_snapshot!("obj", format!("{said}\n{}", written(folder.path(), ["out.scene", "out.toml"])));
    let pane = corners(&folder.path().join("out-meshes/House_001_glass.ply"));
    // Clockwise, and the file has it counter-clockwise.
    assert_eq!(pane, [[[0., 0., 0.], [0., 2., -3.], [0., 2., 0.]], [[0., 0., 0.], [0., 0., -3.], [0., 2., -3.]]]);
    let names = fs::read_dir(folder.path().join("out-meshes")).expect("a folder").count();
    assert_eq!(names, 3);
    assert_eq!(
        told(folder.path(), "check out.scene out.toml").lines().filter(|line| line.ends_with("0 errors, 0 warnings")).count(),
        2
    );
    // The wall is red, what is around it is not, and nothing is amiss.
    assert_eq!(told(folder.path(), "render out.toml --size 64x36 -o out.exr"), "exit status 0\n");
    let picture = image::open(folder.path().join("out.exr")).expect("a picture").to_rgb32f();
    let red = picture.pixels().filter(|pixel| pixel[0] > 2.0 * pixel[2]).count();
    assert!((100..1500).contains(&red), "{red} of {} pixels", 64 * 36);
}

#[test]
fn a_gltf_file_becomes_a_scene_and_a_session() {
    let folder = folder();
    write(&folder, "sail.gltf", TRIANGLE);
    let said = told(folder.path(), "import sail.gltf -o sub/sail.scene");
    insta::assert_snapshot!("gltf", format!("{said}\n{}", written(folder.path(), ["sub/sail.scene", "sub/sail.toml"])));
    let sail = corners(&folder.path().join("sub/sail-meshes/Sail.ply"));
    assert_eq!(sail, [[[0., 0., 0.], [0., 2., 0.], [2., 0., 0.]]]);
    let session = fs::read_to_string(folder.path().join("sub/sail.toml")).expect("a session");
    let session = Session::parse(&Source::new("sail.toml", session)).expect("a session without mistakes").0;
    assert_eq!((session.scene, session.picture.size), (Location::File("sail.scene".into()), [1080, 720]));
    assert_eq!(told(folder.path(), "render sub/sail.toml --size 60x40 -o sail.exr"), "exit status 0\n");
    let picture = image::open(folder.path().join("sail.exr")).expect("a picture").to_rgb32f();
    // The sail has a side of 2, and the picture is 2 · 10 · tan(0.35 rad) = 7.3 high: (40/7.3)² · 2 pixels.
    let sail = picture.pixels().filter(|pixel| pixel.0 != picture.get_pixel(0, 0).0).count();
    assert!((50..70).contains(&sail), "{sail}");
}

#[test]
fn what_cannot_be_imported_is_explained() {
    let folder = folder();
    write(&folder, "house.obj", HOUSE);
    write(&folder, "house.mtl", &MATERIALS.replace("Ns 20", "Ns shiny"));
    write(&folder, "cut.gltf", &TRIANGLE[..100]);
    let packed = r#"{"extensionsRequired": ["KHR_draco_mesh_compression"], "asset""#;
    write(&folder, "packed.gltf", &TRIANGLE.replacen(r#"{"asset""#, packed, 1));
    write(&folder, "a.ply", "ply\n");
    write(&folder, "points.obj", "v 0 0 0\nv 1 0 0\np 1 2\n");
    check(
        "import_mistakes",
        &folder,
        &[
            "import house.obj",
            "import house.obj -o out.toml",
            "import house.obj -o none/out.scene",
            "import house.obj -o out.scene",
            "import none.obj -o out.scene",
            "import a.ply -o out.scene",
            "import session.toml -o out.scene",
            "import cut.gltf -o out.scene",
            "import packed.gltf -o out.scene",
            "import points.obj -o out.scene",
            "import house.obj -o out.scene --memory 1KiB",
        ],
    );
    assert!(!folder.path().join("out-meshes").exists());
}

#[test]
fn files_are_replaced_only_if_that_is_asked_for() {
    let folder = folder();
    write(&folder, "sail.gltf", TRIANGLE);
    write(&folder, "sail.toml", "mine");
    let refused = told(folder.path(), "import sail.gltf -o sail.scene");
    assert!(refused.contains("there is already `sail.toml`") && refused.ends_with("exit status 2\n"), "{refused}");
    assert_eq!(fs::read_to_string(folder.path().join("sail.toml")).expect("a file"), "mine");
    assert!(run(folder.path(), "import sail.gltf -o sail.scene --force").status.success());
    let other = folder.path().join("sail-meshes/other.ply");
    fs::write(&other, "mine").expect("a file");
    assert!(run(folder.path(), "import sail.gltf -o sail.scene --force").status.success());
    assert_eq!(fs::read_to_string(&other).expect("a file"), "mine", "other files stay");
    let again = told(folder.path(), "import sail.gltf -o sail.scene --force");
    assert!(again.contains("Note: of earlier imports there is still: `sail-meshes/other.ply`\n"), "{again}");
    assert!(!run(folder.path(), "import sail.gltf -o sail.scene").status.success());
}

/// A square in the plane z = 0, seen from the front, with the image of a material.
const SIGN: &str =
    "mtllib sign.mtl\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl sign\nf 1/1 2/2 3/3 4/4\n";

#[test]
fn images_of_materials_are_seen_upright() {
    let folder = folder();
    write(&folder, "sign.obj", SIGN);
    write(&folder, "sign.mtl", "newmtl sign\nKd 1 1 1\nmap_Kd sign.png\n");
    // Red above, green below on the left, blue below on the right.
    let sign = image::RgbImage::from_fn(64, 64, |x, y| {
        image::Rgb(if y < 32 {
            [255, 0, 0]
        } else if x < 32 {
            [0, 255, 0]
        } else {
            [0, 0, 255]
        })
    });
    sign.save(folder.path().join("sign.png")).expect("a picture");
    let said = told(folder.path(), "import sign.obj -o sub/s.scene");
    let expected = "sub/s.scene: 1 body, 2 lights added, camera added\nsub/s.toml: session with the formula sub/s.formula\n\
        sub/s-meshes: 1 mesh of 2 triangles\nsub/s-textures: 1 image\nexit status 0\n";
    assert_eq!(said, expected);
    fs::remove_file(folder.path().join("sign.png")).expect("the image is copied");
    let checked = told(folder.path(), "check sub/s.formula sub/s.scene sub/s.toml");
    assert_eq!(checked.lines().filter(|line| line.ends_with("0 errors, 0 warnings")).count(), 3, "{checked}");
    assert_eq!(told(folder.path(), "render sub/s.toml --size 96x96 -o s.exr"), "exit status 0\n");
    let picture = image::open(folder.path().join("s.exr")).expect("a picture").to_rgb32f();
    let strongest = |x: u32, y: u32| {
        let pixel = picture.get_pixel(x, y).0;
        let found = (0..3).find(|channel| (0..3).all(|other| other == *channel || pixel[*channel] > 10.0 * pixel[other]));
        found.unwrap_or_else(|| panic!("{pixel:?} at {x}, {y}"))
    };
    assert_eq!([(36, 34), (60, 34), (36, 62), (60, 62)].map(|(x, y)| strongest(x, y)), [0, 0, 1, 2]);
    // An import with images does not write over a formula, unless that is asked for.
    fs::remove_file(folder.path().join("sub/s.toml")).expect("a file");
    fs::remove_file(folder.path().join("sub/s.scene")).expect("a file");
    fs::remove_dir_all(folder.path().join("sub/s-meshes")).expect("a folder");
    sign.save(folder.path().join("sign.png")).expect("a picture");
    let refused = told(folder.path(), "import sign.obj -o sub/s.scene");
    assert!(refused.contains("there is already `sub/s.formula`, `sub/s-textures`"), "{refused}");
}

#[test]
fn a_model_of_brdf_explorer_becomes_a_formula() {
    let folder = folder();
    let model = "analytic\n\n::begin parameters\n# sharpness\nfloat n 1 500 60\nbool on 1\ncolor Cd .9 .5 .2\nfloat alpha 0 1 2\n\
        ::end parameters\n\n::begin shader\nconst float PI = 3.14159265358979;\nfloat sqr(float x) { return x*x; }\n\
        vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)\n{\n    vec3 H = normalize(L + V);\n    float d = pow(max(0, dot(N, H)), n);\n    \
        if (on) d *= (n + 2)/(2*PI);\n    if (dot(N, V) < 0) return vec3(0);\n    return Cd/PI + sqr(alpha)*d + 1/2;\n}\n::end shader\n";
    write(&folder, "lobe.brdf", model);
    let said = told(folder.path(), "import lobe.brdf -o lobe.formula");
    let formula = fs::read_to_string(folder.path().join("lobe.formula")).expect("a formula");
    insta::assert_snapshot!("brdf", format!("{said}\n== lobe.formula\n{formula}"));
    assert!(told(folder.path(), "check lobe.formula").ends_with("0 errors, 0 warnings\nexit status 0\n"));
    assert_eq!(
        told(folder.path(), "render preset:studio --formula lobe.formula --size 32x24 -o lobe.png").lines().last(),
        Some("exit status 0")
    );
}

#[test]
fn what_of_brdf_explorer_is_not_translated_is_said() {
    let folder = folder();
    let file = |name: &str, declarations: &str, shader: &str| {
        let head = format!("analytic\n::begin parameters\n{declarations}\n::end parameters");
        write(&folder, name, &format!("{head}\n::begin shader\n{shader}\n::end shader\n"));
    };
    let model = |body: &str| format!("vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)\n{{\n{body}\n}}");
    let declared = "#define TWO 2\nconst float T[2] = float[2](1.0, 2.0);\nfloat f(inout float x) { return x; }\nmat3 m(float x) { return mat3(x); }\n";
    let body = "    float s = 0.0;\n    for (int i = 0; i < 3; i++) { s += T[i]; }\n    vec2 v = vec2(1.0);\n    int k = int(L.x);\n    \
        float a = T[0];\n    float b = TWO;\n    float c = f(s);\n    float d = f(1.0) + m(1.0)[0];\n    float e = refract(L, N, 1.0).x;\n    \
        vec3 g = L + true;\n    g.x = what;\n    float h = V.xy + dot(L);\n    bool p = L < V;\n    float q = L;\n    q += 1.0;\n    \
        absent = 1.0;\n    emit(L);\n    float r; s = r;\n    discard;\n    return s;";
    file("foreign.brdf", "", &(declared.to_owned() + &model(body)));
    file("syntax.brdf", "", &model("    return L * ;"));
    file("other.brdf", "", "vec3 BRDF(vec3 L, vec3 V) { return L; }");
    file("none.brdf", "", "float f(float x) { return x; }");
    file("open.brdf", "", &model("    if (L.x > 0.0) return L;"));
    file("parameters.brdf", "int n 1 2 3\nfloat a 1 0 0\nfloat b 0 1\nbool c\ncolor d 1 1\nfloat e 0 1 x\nfloat f-g 0 1 1", "");
    write(&folder, "measured.brdf", "bin3d\n");
    write(&folder, "half.brdf", "analytic\n::begin shader\n");
    write(&folder, "there.formula", "");
    check(
        "import_brdf",
        &folder,
        &[
            "import foreign.brdf -o a.formula",
            "import syntax.brdf -o a.formula",
            "import other.brdf -o a.formula",
            "import none.brdf -o a.formula",
            "import open.brdf -o a.formula",
            "import parameters.brdf -o a.formula",
            "import measured.brdf -o a.formula",
            "import half.brdf -o a.formula",
            "import half.brdf -o a.scene",
            "import half.brdf -o there.formula",
            "import half.brdf -o nowhere/a.formula",
            "import absent.brdf -o a.formula",
        ],
    );
    assert!(!folder.path().join("a.formula").exists());
}
