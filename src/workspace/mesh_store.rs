//! Reading the meshes that scenes name.
//!
//! A path in a scene is relative to the folder of the scene, and `preset:NAME` names a built-in mesh. A store keeps
//! what it has read, also the mistakes, by the path, length and time of modification of the file. So a file is read
//! again if it has changed, and only then. Of a glTF file, the files that it names are not watched.

use crate::bvh::MeshTree;
use crate::files::FileStamp;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::mesh::{MeshError, MeshPlace, MeshRepairs, Reading, TriangleMesh, read, read_bytes};
use crate::scene::shape::NamedMesh;
use crate::scene::{Body, Scene};
use crate::workspace::Location;
use crate::workspace::presets::{MESHES, PresetMesh};
use crate::world::Meshes;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The prefix of the names of built-in meshes.
const PRESET: &str = "preset:";
/// The share of reading in the whole work on a mesh. The rest is its tree.
const READING: f64 = 0.6;
/// What a tree takes for each triangle at most while it is built, in bytes.
const TREE_BYTES: u64 = 250;

/// Meshes that were read. It can be shared between threads.
#[derive(Debug, Default)]
pub struct MeshStore {
    kept: Mutex<Vec<KeptMesh>>,
}

/// What was read of a file.
#[derive(Debug, Clone)]
struct KeptMesh {
    origin: MeshOrigin,
    needs_normals: bool,
    outcome: Result<(Arc<MeshTree>, MeshRepairs), MeshError>,
}

/// Where a mesh comes from, and which contents the file has.
#[derive(Debug, Clone, PartialEq)]
enum MeshOrigin {
    BuiltIn(&'static str),
    File(FileStamp),
    /// There is no such file, or it cannot be looked at.
    Missing(PathBuf),
}

/// Why the meshes of a scene were not read.
#[derive(Debug, Clone, PartialEq)]
pub enum MeshLoadError {
    /// The work was cancelled.
    Cancelled,
    /// What is wrong, at the names in the text of the scene.
    Unusable(Diagnostics),
}

/// The mesh that a key names.
enum Found {
    BuiltIn(&'static PresetMesh),
    File(PathBuf),
}

impl MeshStore {
    /// The meshes of a scene that is at `scene_location`, with warnings at their names in the text of the scene.
    ///
    /// ```
    /// # use illuminator::{lang::source::Source, mesh::Reading, scene::Scene, trace::View};
    /// # use illuminator::{engine::Subject, formula::Formula, workspace::{Location, MeshStore}};
    /// let text = "bodies; stone: mesh, \"preset:gem\", fit <0,0,0> 2; lights; key: point, <3,4,5>;
    ///     camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 40;";
    /// let (scene, _) = Scene::parse(&Source::new("gem.scene", text)).map_err(|errors| errors.len()).unwrap();
    /// let (store, place) = (MeshStore::default(), Location::new("gem.scene"));
    /// let (meshes, _) = store.load(&scene, &place, &Reading::unwatched(1 << 30)).unwrap();
    /// let (formula, _) = Formula::parse(&Source::new("lambert", "formula; = IL*Cd*max(0, N.L);")).unwrap();
    /// let subject = Subject::new(formula, scene, &meshes, View::new(64, 48)?)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A mesh cannot be used, or the work was cancelled.
    pub fn load(
        &self,
        scene: &Scene,
        scene_location: &Location,
        reading: &Reading,
    ) -> Result<(Meshes, Diagnostics), MeshLoadError> {
        let (mut meshes, mut found) = (Meshes::NONE, Diagnostics::default());
        let needed = meshes.missing(scene);
        let mut used = Vec::new();
        for (index, (body, key)) in needed.iter().enumerate() {
            let tell = |share: f64| (reading.progress)((index as f64 + share) / needed.len() as f64);
            // Those that are read already count.
            let memory = reading.memory.saturating_sub(meshes.memory());
            let kept = find(&key.path, scene_location).map(|found| {
                let part = Reading { memory, progress: &tell, cancelled: reading.cancelled };
                self.of_file(&found, key.needs_normals, &part)
            });
            match kept {
                Ok(KeptMesh { outcome: Err(MeshError::Cancelled), .. }) => return Err(MeshLoadError::Cancelled),
                Ok(kept) => {
                    match &kept.outcome {
                        Ok((tree, repairs)) => {
                            meshes.insert(key.clone(), Arc::clone(tree));
                            warnings(repairs, tree.mesh()).for_each(|warning| found.push(at_name(warning, body, "in this mesh")));
                        }
                        Err(error) => {
                            let missing = matches!(kept.origin, MeshOrigin::Missing(_)) && !Path::new(&key.path).is_absolute();
                            let hint = missing.then(|| "a relative path starts from the folder of the scene".to_owned());
                            found.push(mistake(error, body).help_if(hint));
                        }
                    }
                    used.push(kept.origin);
                }
                Err(diagnostic) => found.push(at_name(diagnostic, body, "this mesh")),
            }
        }
        self.forget_others(&used);
        found.sort();
        if found.has_errors() { Err(MeshLoadError::Unusable(found)) } else { Ok((meshes, found)) }
    }

    /// How many bytes of files would be read for the meshes of a scene at `scene_location`. Built-in meshes and those
    /// that are kept count nothing.
    pub fn bytes_to_read(&self, scene: &Scene, scene_location: &Location) -> u64 {
        let needed = Meshes::NONE.missing(scene);
        let bytes = needed.iter().map(|(_, key)| match find(&key.path, scene_location) {
            Ok(Found::File(path)) => match MeshOrigin::of(&path) {
                origin if self.kept(&origin, key.needs_normals).is_some() => 0,
                MeshOrigin::File(stamp) => stamp.length(),
                MeshOrigin::BuiltIn(_) | MeshOrigin::Missing(_) => 0,
            },
            Ok(Found::BuiltIn(_)) | Err(_) => 0,
        });
        bytes.sum()
    }

    /// Whether a file of the meshes of a scene at `scene_location` is another one than was read.
    pub fn has_changed(&self, scene: &Scene, scene_location: &Location) -> bool {
        let needed = Meshes::NONE.missing(scene);
        needed.iter().any(|(_, key)| match find(&key.path, scene_location) {
            Ok(Found::File(path)) => self.kept(&MeshOrigin::of(&path), key.needs_normals).is_none(),
            Ok(Found::BuiltIn(_)) | Err(_) => false,
        })
    }

    /// Forgets which meshes were too large for the memory. They are tried again.
    pub fn forget_refused(&self) {
        self.lock().retain(|kept| !matches!(kept.outcome, Err(MeshError::Memory { .. })));
    }

    fn lock(&self) -> MutexGuard<'_, Vec<KeptMesh>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is kept of a file that serves a body that needs normals, or does not.
    fn kept(&self, origin: &MeshOrigin, needs_normals: bool) -> Option<KeptMesh> {
        let serves = |kept: &&KeptMesh| {
            // A mesh with normals of its own is the same for both.
            let same = kept.needs_normals == needs_normals;
            kept.origin == *origin
                && (same || !kept.needs_normals && kept.outcome.as_ref().is_ok_and(|(tree, _)| has_normals(tree)))
        };
        self.lock().iter().find(serves).cloned()
    }

    /// Reads a mesh, unless it is kept.
    fn of_file(&self, found: &Found, needs_normals: bool, reading: &Reading) -> KeptMesh {
        let origin = match found {
            Found::BuiltIn(preset) => MeshOrigin::BuiltIn(preset.name),
            Found::File(path) => MeshOrigin::of(path),
        };
        if let Some(kept) = self.kept(&origin, needs_normals) {
            return kept;
        }
        if reading.cancelled.load(Ordering::Relaxed) {
            return KeptMesh { origin, needs_normals, outcome: Err(MeshError::Cancelled) };
        }
        let tell = |share: f64| (reading.progress)(READING * share);
        let part = Reading { progress: &tell, ..*reading };
        let (name, outcome) = match found {
            Found::BuiltIn(preset) => (preset.file.to_owned(), read_bytes(Path::new(preset.file), preset.bytes, &part)),
            Found::File(path) => (path.display().to_string(), read(path, &part)),
        };
        // What the file gives serves bodies that need no normals too.
        let has_own = outcome.as_ref().is_ok_and(|(mesh, _)| !mesh.normals().is_empty());
        let outcome = outcome.and_then(|(mesh, repairs)| {
            let mesh = if needs_normals { mesh.smooth(&name, &part)? } else { mesh };
            let needed = mesh.memory().saturating_add(TREE_BYTES.saturating_mul(mesh.triangles().len() as u64));
            if needed > reading.memory {
                return Err(MeshError::Memory { file: name, needed, allowed: reading.memory });
            }
            let go_on = |share: f64| {
                (reading.progress)(READING + (1.0 - READING) * share);
                !reading.cancelled.load(Ordering::Relaxed)
            };
            let tree = MeshTree::new(Arc::new(mesh), &go_on).ok_or(MeshError::Cancelled)?;
            Ok((Arc::new(tree), repairs))
        });
        (reading.progress)(1.0);
        let kept = KeptMesh { origin, needs_normals: needs_normals && !has_own, outcome };
        if !matches!(kept.outcome, Err(MeshError::Cancelled)) {
            self.lock().push(kept.clone());
        }
        kept
    }

    /// Forgets what neither this scene nor anybody else uses.
    fn forget_others(&self, used: &[MeshOrigin]) {
        let in_use = |kept: &KeptMesh| kept.outcome.as_ref().is_ok_and(|(tree, _)| Arc::strong_count(tree) > 1);
        self.lock().retain(|kept| used.contains(&kept.origin) || in_use(kept));
    }
}

fn has_normals(tree: &MeshTree) -> bool {
    !tree.mesh().normals().is_empty()
}

impl MeshOrigin {
    fn of(path: &Path) -> Self {
        FileStamp::of(path).map_or_else(|| MeshOrigin::Missing(path.to_owned()), MeshOrigin::File)
    }
}

/// The file or the built-in mesh that a name in a scene means.
fn find(name: &str, scene_location: &Location) -> Result<Found, Diagnostic> {
    if let Some(name) = name.strip_prefix(PRESET) {
        return MESHES.iter().find(|preset| preset.name == name).map(Found::BuiltIn).ok_or_else(|| {
            let names = MESHES.iter().map(|preset| preset.name);
            let help = match nearest(name, names.clone()) {
                Some(near) => format!("did you mean `{PRESET}{near}`?"),
                None => format!("the built-in ones are {}", names.collect::<Vec<_>>().join(", ")),
            };
            Diagnostic::error(format!("there is no built-in mesh `{PRESET}{name}`")).help(help)
        });
    }
    match scene_location {
        _ if Path::new(name).is_absolute() => Ok(Found::File(PathBuf::from(name))),
        Location::File(scene) => Ok(Found::File(scene.parent().unwrap_or(Path::new("")).join(name))),
        Location::Preset(_) => {
            let diagnostic = Diagnostic::error("a built-in scene has no folder from which a mesh could be read");
            Err(diagnostic.help("save the scene beside the mesh, or name a built-in mesh, `preset:NAME`"))
        }
    }
}

/// A diagnostic at the name of a mesh in the text of the scene.
fn at_name(diagnostic: Diagnostic, body: &Body, mark: &str) -> Diagnostic {
    let span = body.form.shape.mesh().map_or(body.name_span, NamedMesh::span);
    diagnostic.at(span, mark)
}

/// What is wrong with a mesh. The file has a place of its own, which the message names.
fn mistake(error: &MeshError, body: &Body) -> Diagnostic {
    let diagnostic = at_name(Diagnostic::error(error.to_string()), body, "this mesh cannot be used");
    let line = match error {
        MeshError::Content(mistake) => match &mistake.place {
            Some(MeshPlace::Text { line, excerpt, .. }) if !excerpt.trim().is_empty() => {
                Some(format!("line {line} of the file is `{}`", crate::lang::display_text::one_line(excerpt.trim())))
            }
            Some(MeshPlace::Text { .. } | MeshPlace::Byte(_)) | None => None,
        },
        MeshError::Cancelled | MeshError::Memory { .. } | MeshError::File(_) => None,
    };
    diagnostic.help_if(line).help_if(error.hint().map(str::to_owned))
}

/// What was left out or replaced.
fn warnings(repairs: &MeshRepairs, mesh: &TriangleMesh) -> impl Iterator<Item = Diagnostic> {
    let MeshRepairs { degenerate_triangles, missing_normals, unusable_uvs, bytes_behind } = *repairs;
    let counted = |count: u64, one: &str, several: &str| match count {
        1 => format!("1 {one}"),
        count => format!("{count} {several}"),
    };
    let kept = mesh.triangles().len();
    let dropped = (degenerate_triangles > 0).then(|| {
        let what = counted(degenerate_triangles, "triangle has", "triangles have");
        format!("{what} no area and was left out; {kept} are kept").replace("have no area and was", "have no area and were")
    });
    let normals = (missing_normals > 0).then(|| {
        let what = counted(missing_normals, "vertex has", "vertices have");
        format!("{what} no usable normal; the mean of the triangles around is used")
    });
    let uvs = (unusable_uvs > 0).then(|| {
        format!("{} not a number; 0 is used", counted(unusable_uvs, "surface coordinate is", "surface coordinates are"))
    });
    let behind = (bytes_behind > 0).then(|| {
        let what = counted(bytes_behind, "byte", "bytes");
        format!("the file goes on for {what} behind the records that it counts; what is there was left out")
    });
    [dropped, normals, uvs, behind].into_iter().flatten().map(Diagnostic::warning)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use insta::assert_snapshot;
    use std::fs;
    use std::sync::atomic::AtomicBool;

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
        let store = MeshStore::default();
        let scene = scene("a: mesh, \"a.obj\"; b: mesh, \"./a.obj\", scale 2; c: mesh, \"a.obj\", smooth;");
        let load = || store.load(&scene, &place, &Reading::unwatched(1 << 20)).unwrap().0;
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
        assert_eq!(
            (first.get(&key).unwrap().mesh().triangles().len(), changed.get(&key).unwrap().mesh().triangles().len()),
            (2, 1)
        );
    }

    #[test]
    fn normals_of_a_file_serve_smooth_bodies_too() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("n.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n").unwrap();
        let place = Location::File(folder.path().join("test.scene"));
        for bodies in ["a: mesh, \"n.obj\"; b: mesh, \"n.obj\", smooth;", "b: mesh, \"n.obj\", smooth; a: mesh, \"n.obj\", flat;"]
        {
            let scene = scene(bodies);
            let (meshes, _) = MeshStore::default().load(&scene, &place, &Reading::unwatched(1 << 20)).unwrap();
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
        let bodies =
            "a: mesh, \"missing.obj\";\nb: mesh, \"damaged.obj\", scale 2;\nc: mesh, \"picture.png\";\nd: mesh, \"text.obj\";
            e: mesh, \"preset:gam\"; f: mesh, \".\";";
        let failed = MeshStore::default().load(&scene(bodies), &place, &Reading::unwatched(1 << 20));
        let Err(MeshLoadError::Unusable(errors)) = failed else { panic!("{failed:?}") };
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
        test.scene:6:22: error: there is no built-in mesh `preset:gam`
                        e: mesh, "preset:gam"; f: mesh, ".";
                                 ^^^^^^^^^^^^ this mesh
            help: did you mean `preset:gem`?
        test.scene:6:45: error: `FOLDER/.` is not a mesh by its suffix
                        e: mesh, "preset:gam"; f: mesh, ".";
                                                        ^^^ this mesh cannot be used
            help: meshes are files with the suffix .obj, .ply, .stl, .gltf, .glb
        "#);
        let bodies = "a: mesh, \"x.obj\";";
        let failed = MeshStore::default().load(&scene(bodies), &Location::new("preset:studio"), &Reading::unwatched(1 << 20));
        let Err(MeshLoadError::Unusable(errors)) = failed else { panic!("{failed:?}") };
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
        let (bodies, store) = ("a: mesh, \"a.obj\";", MeshStore::default());
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
        let store = MeshStore::default();
        let cancelled = AtomicBool::new(true);
        let reading = Reading { cancelled: &cancelled, ..Reading::unwatched(1 << 20) };
        assert_eq!(store.load(&scene(bodies), &place, &reading).map(drop), Err(MeshLoadError::Cancelled));
        // While the tree is built, too.
        let cancelled = AtomicBool::new(false);
        let cancel = |share: f64| cancelled.store(share > READING, Ordering::Relaxed);
        let reading = Reading { cancelled: &cancelled, progress: &cancel, ..Reading::unwatched(1 << 20) };
        assert_eq!(store.load(&scene(bodies), &place, &reading).map(drop), Err(MeshLoadError::Cancelled));
        assert!(store.has_changed(&scene(bodies), &place), "a cancelled file is tried again");
        let Err(MeshLoadError::Unusable(errors)) = store.load(&scene(bodies), &place, &Reading::unwatched(100)) else { panic!() };
        assert_snapshot!(said(errors, bodies, folder.path()), @r#"
        test.scene:2:10: error: `FOLDER/a.obj` is too large: it needs 314 bytes or more, and 100 bytes are allowed
            a: mesh, "a.obj";
                     ^^^^^^^ this mesh cannot be used
        "#);
        store.forget_refused();
        assert!(store.load(&scene(bodies), &place, &Reading::unwatched(1 << 20)).is_ok());
    }
}
