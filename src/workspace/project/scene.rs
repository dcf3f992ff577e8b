//! Reading a scene with its meshes.

use crate::engine::Task;
use crate::files::Readable;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::mesh::Reading;
use crate::scene::Scene;
use crate::workspace::project::{SessionText, session_source};
use crate::workspace::{FileKind, Location, MeshLoadError, MeshStore, Session};
use crate::world::Meshes;

/// Parses the text of a scene at a location, and reads its meshes, which may take this much memory in bytes.
///
/// # Errors
/// All errors of the text; or those of the meshes, with the warnings. Work that was cancelled is an error too.
pub fn parse_scene_with_meshes(
    source: &Source,
    location: &Location,
    store: &MeshStore,
    memory: u64,
    task: &Task,
) -> Result<((Scene, Meshes), Diagnostics), Diagnostics> {
    let (scene, mut diagnostics) = Scene::parse(source)?;
    let reading = Reading { memory, progress: task.progress, cancelled: task.cancelled };
    let (meshes, found) = match store.load(&scene, location, &reading) {
        Ok((meshes, warnings)) => (Some(meshes), warnings),
        Err(MeshLoadError::Unusable(errors)) => (None, errors),
        Err(MeshLoadError::Cancelled) => (None, Diagnostic::error("reading the meshes was cancelled").into()),
    };
    found.into_iter().for_each(|diagnostic| diagnostics.push(diagnostic));
    diagnostics.sort();
    match meshes {
        Some(meshes) => Ok(((scene, meshes), diagnostics)),
        None => Err(diagnostics),
    }
}

/// The scene that the session at a location is of, and where it is; `None` where one of them has errors.
pub fn scene_of_session(location: &Location) -> Option<(Scene, Location)> {
    let (source, folder) = session_source(&SessionText::At(location.clone()), Readable::Regular).ok()?;
    let session = Session::parse_in_parts(&source).0?.with_paths_from(folder.as_deref());
    let text = session.scene.read(FileKind::Scene, Readable::Regular).ok()?;
    let (scene, _) = Scene::parse(&text).ok()?;
    Some((scene, session.scene))
}
