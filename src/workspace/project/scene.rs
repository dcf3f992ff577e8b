//! Reading a scene with the files that it names.

use crate::engine::Task;
use crate::files::Readable;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::mesh::Reading;
use crate::scene::Scene;
use crate::workspace::project::{SessionText, session_source};
use crate::workspace::{AssetLoadError, AssetStore, FileKind, Location, Session};
use crate::world::Assets;

/// Parses the text of a scene at a location, and reads the files that it names, which may take this much memory in
/// bytes.
///
/// # Errors
/// All errors of the text; or those of the files, with the warnings. Work that was cancelled is an error too.
pub fn parse_scene_with_assets(
    source: &Source,
    location: &Location,
    store: &AssetStore,
    memory: u64,
    task: &Task,
) -> Result<((Scene, Assets), Diagnostics), Diagnostics> {
    let (scene, mut diagnostics) = Scene::parse(source)?;
    let reading = Reading { memory, progress: task.progress, cancelled: task.cancelled };
    let (assets, found) = match store.load(&scene, location, &reading) {
        Ok((assets, warnings)) => (Some(assets), warnings),
        Err(AssetLoadError::Unusable(errors)) => (None, errors),
        Err(AssetLoadError::Cancelled) => (None, Diagnostic::error("reading the files of the scene was cancelled").into()),
    };
    found.into_iter().for_each(|diagnostic| diagnostics.push(diagnostic));
    diagnostics.sort();
    match assets {
        Some(assets) => Ok(((scene, assets), diagnostics)),
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
