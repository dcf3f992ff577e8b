//! Reading the meshes that scenes name.

use super::Cancelled;
use super::named::{AssetOrigin, BuiltInAsset, FoundAsset, find};
use crate::bvh::MeshTree;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::mesh::{MeshError, MeshPlace, MeshRepairs, Reading, TriangleMesh, read, read_bytes};
use crate::scene::shape::NamedMesh;
use crate::scene::{Body, Scene};
use crate::workspace::Location;
use crate::workspace::presets::{MESHES, PresetMesh};
use crate::world::{MeshKey, Meshes};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The share of reading in the whole work on a mesh. The rest is its tree.
pub(super) const READING: f64 = 0.6;
/// What a tree takes for each triangle at most while it is built, in bytes.
const TREE_BYTES: u64 = 250;

/// Meshes that were read.
#[derive(Debug, Default)]
pub(super) struct KeptMeshes {
    kept: Mutex<Vec<KeptMesh>>,
}

/// What was read of a file.
#[derive(Debug, Clone)]
struct KeptMesh {
    origin: AssetOrigin,
    needs_normals: bool,
    outcome: Result<(Arc<MeshTree>, MeshRepairs), MeshError>,
}

impl BuiltInAsset for PresetMesh {
    const NOUN: &'static str = "mesh";
    const WITH_ARTICLE: &'static str = "a mesh";
    const ALL: &'static [Self] = MESHES;

    fn name(&self) -> &'static str {
        self.name
    }
}

impl KeptMeshes {
    /// Adds the meshes of a scene to `meshes`, and what is wrong with them to `found`.
    pub(super) fn load(
        &self,
        scene: &Scene,
        scene_location: &Location,
        reading: &Reading,
        meshes: &mut Meshes,
        found: &mut Diagnostics,
    ) -> Result<(), Cancelled> {
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
                Ok(KeptMesh { outcome: Err(MeshError::Cancelled), .. }) => return Err(Cancelled),
                Ok(kept) => {
                    match &kept.outcome {
                        Ok((tree, repairs)) => {
                            meshes.insert(key.clone(), Arc::clone(tree));
                            warnings(repairs, tree.mesh()).for_each(|warning| found.push(at_name(warning, body, "in this mesh")));
                        }
                        Err(error) => found.push(mistake(error, body).help_if(kept.origin.missing_hint(&key.path))),
                    }
                    used.push(kept.origin);
                }
                Err(diagnostic) => found.push(at_name(diagnostic, body, "this mesh")),
            }
        }
        self.forget_others(&used);
        Ok(())
    }

    /// The files of the meshes of a scene of which nothing is kept.
    pub(super) fn unread(&self, scene: &Scene, scene_location: &Location) -> Vec<AssetOrigin> {
        let needed = Meshes::NONE.missing(scene);
        let unread = |key: &MeshKey| {
            let origin = FoundAsset::<PresetMesh>::file_origin(&key.path, scene_location)?;
            self.kept(&origin, key.needs_normals).is_none().then_some(origin)
        };
        needed.iter().filter_map(|(_, key)| unread(key)).collect()
    }

    /// Forgets which meshes were too large for the memory. They are tried again.
    pub(super) fn forget_refused(&self) {
        self.lock().retain(|kept| !matches!(kept.outcome, Err(MeshError::Memory { .. })));
    }

    fn lock(&self) -> MutexGuard<'_, Vec<KeptMesh>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is kept of a file that serves a body that needs normals, or does not.
    fn kept(&self, origin: &AssetOrigin, needs_normals: bool) -> Option<KeptMesh> {
        let serves = |kept: &&KeptMesh| {
            // A mesh with normals of its own is the same for both.
            let same = kept.needs_normals == needs_normals;
            kept.origin == *origin
                && (same || !kept.needs_normals && kept.outcome.as_ref().is_ok_and(|(tree, _)| has_normals(tree)))
        };
        self.lock().iter().find(serves).cloned()
    }

    /// Reads a mesh, unless it is kept.
    fn of_file(&self, found: &FoundAsset<PresetMesh>, needs_normals: bool, reading: &Reading) -> KeptMesh {
        let origin = found.origin();
        if let Some(kept) = self.kept(&origin, needs_normals) {
            return kept;
        }
        if reading.cancelled.load(Ordering::Relaxed) {
            return KeptMesh { origin, needs_normals, outcome: Err(MeshError::Cancelled) };
        }
        let tell = |share: f64| (reading.progress)(READING * share);
        let part = Reading { progress: &tell, ..*reading };
        let (name, outcome) = match found {
            FoundAsset::BuiltIn(preset) => (preset.file.to_owned(), read_bytes(Path::new(preset.file), preset.bytes, &part)),
            FoundAsset::File(path) => (path.display().to_string(), read(path, &part)),
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
    fn forget_others(&self, used: &[AssetOrigin]) {
        let in_use = |kept: &KeptMesh| kept.outcome.as_ref().is_ok_and(|(tree, _)| Arc::strong_count(tree) > 1);
        self.lock().retain(|kept| used.contains(&kept.origin) || in_use(kept));
    }
}

fn has_normals(tree: &MeshTree) -> bool {
    !tree.mesh().normals().is_empty()
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
