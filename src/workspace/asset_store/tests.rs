//! Files that scenes name, sound and damaged.

use super::meshes::READING;
use super::*;
use crate::bvh::MeshTree;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::source::Source;
use insta::assert_snapshot;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

fn source(bodies: &str) -> Source {
    let rest = "lights; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
    Source::new("test.scene", format!("bodies;\n{bodies}\n{rest}"))
}

fn scene(bodies: &str) -> Scene {
    Scene::parse(&source(bodies)).unwrap().0
}

fn said(diagnostics: Diagnostics, bodies: &str, folder: &Path) -> String {
    let text = format!("{:#}", diagnostics.located(&source(bodies)));
    text.replace(&folder.display().to_string(), "FOLDER")
}

#[test]
fn an_unchanged_file_is_read_once() {
    let folder = tempfile::tempdir().unwrap();
    let (path, place) = (folder.path().join("a.obj"), Location::File(folder.path().join("test.scene")));
    fs::write(&path, SQUARE).unwrap();
    let store = AssetStore::default();
    let scene = scene("a: mesh, \"a.obj\"; b: mesh, \"./a.obj\", scale 2; c: mesh, \"a.obj\", smooth;");
    let load = || store.load(&scene, &place, &Reading::unwatched(1 << 20)).unwrap().0.meshes;
    assert_eq!((store.bytes_to_read(&scene, &place), store.has_changed(&scene, &place)), (3 * SQUARE.len() as u64, true));
    let first = load();
    let trees: Vec<&Arc<MeshTree>> = first
        .missing(&scene)
        .is_empty()
        .then_some(&scene.bodies)
        .into_iter()
        .flatten()
        .map(|body| first.get(&crate::world::MeshKey::of(body).unwrap()).unwrap())
        .collect();
    assert!(Arc::ptr_eq(trees[0], trees[1]) && !Arc::ptr_eq(trees[0], trees[2]));
    assert!(trees[0].mesh().normals().is_empty() && trees[2].mesh().normals().len() == 4);
    assert_eq!((store.bytes_to_read(&scene, &place), store.has_changed(&scene, &place)), (0, false));
    let again = load();
    let key = crate::world::MeshKey::of(&scene.bodies[0]).unwrap();
    assert!(Arc::ptr_eq(first.get(&key).unwrap(), again.get(&key).unwrap()));
    // Another length is another file.
    fs::write(&path, SQUARE.replace("f 1 2 3 4", "f 1 2 3")).unwrap();
    assert!(store.has_changed(&scene, &place));
    let changed = load();
    assert_eq!((first.get(&key).unwrap().mesh().triangles().len(), changed.get(&key).unwrap().mesh().triangles().len()), (2, 1));
}

#[test]
fn normals_of_a_file_serve_smooth_bodies_too() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("n.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n").unwrap();
    let place = Location::File(folder.path().join("test.scene"));
    for bodies in ["a: mesh, \"n.obj\"; b: mesh, \"n.obj\", smooth;", "b: mesh, \"n.obj\", smooth; a: mesh, \"n.obj\", flat;"] {
        let scene = scene(bodies);
        let (Assets { meshes, .. }, _) = AssetStore::default().load(&scene, &place, &Reading::unwatched(1 << 20)).unwrap();
        let keys = [0, 1].map(|body| crate::world::MeshKey::of(&scene.bodies[body]).unwrap());
        let [one, other] = keys.map(|key| meshes.get(&key).unwrap());
        assert!(Arc::ptr_eq(one, other));
        assert_eq!(meshes.memory(), one.memory() + one.mesh().memory());
    }
}

#[test]
fn what_is_wrong_with_a_mesh_is_said_at_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let place = Location::File(folder.path().join("test.scene"));
    fs::write(folder.path().join("damaged.obj"), SQUARE.replace("f 1 2", "f 1 9")).unwrap();
    fs::write(folder.path().join("text.obj"), "hello").unwrap();
    fs::write(folder.path().join("picture.png"), "").unwrap();
    let bodies = "a: mesh, \"missing.obj\";\nb: mesh, \"damaged.obj\", scale 2;\nc: mesh, \"picture.png\";\nd: mesh, \"text.obj\";\ne: mesh, \"preset:gam\"; f: mesh, \".\";";
    let failed = AssetStore::default().load(&scene(bodies), &place, &Reading::unwatched(1 << 20));
    let Err(AssetLoadError::Unusable(errors)) = failed else { panic!("{failed:?}") };
    assert_snapshot!(said(errors, bodies, folder.path()), @r#"
    test.scene:2:10: error: cannot read the mesh `FOLDER/missing.obj`: there is no such file
        a: mesh, "missing.obj";
                 ^^^^^^^^^^^^^ this mesh cannot be used
        help: a relative path starts from the folder of the scene
    test.scene:3:10: error: FOLDER/damaged.obj:5:5: there is no position 9: 4 stand before this line
        b: mesh, "damaged.obj", scale 2;
                 ^^^^^^^^^^^^^ this mesh cannot be used
        help: line 5 of the file is `f 1 9 3 4`
        help: indices count from 1; negative ones count back from the last line before the face
    test.scene:4:10: error: `FOLDER/picture.png` is not a mesh by its suffix
        c: mesh, "picture.png";
                 ^^^^^^^^^^^^^ this mesh cannot be used
        help: meshes are files with the suffix .obj, .ply, .stl, .gltf, .glb
    test.scene:5:10: error: FOLDER/text.obj: it has no triangles
        d: mesh, "text.obj";
                 ^^^^^^^^^^ this mesh cannot be used
        help: a mesh needs faces; points, lines and curves are not drawn
    test.scene:6:10: error: there is no built-in mesh `preset:gam`
        e: mesh, "preset:gam"; f: mesh, ".";
                 ^^^^^^^^^^^^ this mesh
        help: did you mean `preset:gem`?
    test.scene:6:33: error: `FOLDER/.` is not a mesh by its suffix
        e: mesh, "preset:gam"; f: mesh, ".";
                                        ^^^ this mesh cannot be used
        help: meshes are files with the suffix .obj, .ply, .stl, .gltf, .glb
    "#);
    let bodies = "a: mesh, \"x.obj\";";
    let failed = AssetStore::default().load(&scene(bodies), &Location::new("preset:studio"), &Reading::unwatched(1 << 20));
    let Err(AssetLoadError::Unusable(errors)) = failed else { panic!("{failed:?}") };
    assert_snapshot!(said(errors, bodies, folder.path()), @r#"
    test.scene:2:10: error: a built-in scene has no folder from which a mesh could be read
        a: mesh, "x.obj";
                 ^^^^^^^ this mesh
        help: save the scene beside the mesh, or name a built-in mesh, `preset:NAME`
    "#);
}

#[test]
fn repairs_are_warnings_and_memory_and_cancellation_end_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let place = Location::File(folder.path().join("test.scene"));
    fs::write(folder.path().join("a.obj"), format!("{SQUARE}f 1 1 2\nf 2 3 2\n")).unwrap();
    let (bodies, store) = ("a: mesh, \"a.obj\";", AssetStore::default());
    let (_, warnings) = store.load(&scene(bodies), &place, &Reading::unwatched(1 << 20)).unwrap();
    assert_snapshot!(said(warnings, bodies, folder.path()), @r#"
    test.scene:2:10: warning: 2 triangles have no area and were left out; 2 are kept
        a: mesh, "a.obj";
                 ^^^^^^^ in this mesh
    "#);
    let mut long = vec![0; 84 + 100];
    long[80] = 1;
    long[84 + 24..84 + 28].copy_from_slice(&1.0_f32.to_le_bytes());
    long[84 + 40..84 + 44].copy_from_slice(&1.0_f32.to_le_bytes());
    long[183] = 1;
    fs::write(folder.path().join("a.stl"), long).unwrap();
    let (_, behind) = store.load(&scene("a: mesh, \"a.stl\";"), &place, &Reading::unwatched(1 << 20)).unwrap();
    let message = "the file goes on for 50 bytes behind the records that it counts; what is there was left out";
    assert_eq!(behind.iter().map(Diagnostic::message).collect::<Vec<_>>(), [message]);
    // They are said again when nothing is read.
    let (_, again) = store.load(&scene(bodies), &place, &Reading::unwatched(1 << 20)).unwrap();
    assert_eq!(again.len(), 1);
    let store = AssetStore::default();
    let cancelled = AtomicBool::new(true);
    let reading = Reading { cancelled: &cancelled, ..Reading::unwatched(1 << 20) };
    assert_eq!(store.load(&scene(bodies), &place, &reading).map(drop), Err(AssetLoadError::Cancelled));
    // While the tree is built, too.
    let cancelled = AtomicBool::new(false);
    let cancel = |share: f64| cancelled.store(share > READING, Ordering::Relaxed);
    let reading = Reading { cancelled: &cancelled, progress: &cancel, ..Reading::unwatched(1 << 20) };
    assert_eq!(store.load(&scene(bodies), &place, &reading).map(drop), Err(AssetLoadError::Cancelled));
    assert!(store.has_changed(&scene(bodies), &place), "a cancelled file is tried again");
    let Err(AssetLoadError::Unusable(errors)) = store.load(&scene(bodies), &place, &Reading::unwatched(100)) else { panic!() };
    assert_snapshot!(said(errors, bodies, folder.path()), @r#"
    test.scene:2:10: error: `FOLDER/a.obj` is too large: it needs 314 bytes or more, and 100 bytes are allowed
        a: mesh, "a.obj";
                 ^^^^^^^ this mesh cannot be used
    "#);
    store.forget_refused();
    assert!(store.load(&scene(bodies), &place, &Reading::unwatched(1 << 20)).is_ok());
}

mod maps;
