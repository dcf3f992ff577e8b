//! Meshes from files become bodies of the scene: well sized, in view, and with a path from the folder of the scene.

use crate::lang::diagnostic::Diagnostic;
use crate::mesh::{MeshFormat, Reading};
use crate::preview::app::asset_loading::AfterReading;
use crate::preview::app::hand::sight::{pivot, place_to_stand};
use crate::preview::app::scene_actions::MeshSpot;
use crate::preview::app::{App, user_state};
use crate::scene::edit::{Precision, SceneChange, edit, unused_name};
use crate::scene::naming::{as_identifier, words};
use crate::scene::shape::NamedMesh;
use crate::scene::{BodyForm, BodyId, Scene, Shape, Transform};
use crate::trace::usable_memory;
use crate::workspace::{AssetLoadError, Location};
use crate::world::{Assets, World};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

/// The largest side of a mesh that is added, as a part of the picture's height.
const SIZE: f64 = 0.35;
/// The distance between meshes that are added together, as a part of their size.
const APART: f64 = 1.2;

/// How the scene at `place` names a file: by a path from its folder; by an absolute one if the scene is in no file.
fn name_of(path: &Path, place: &Location) -> String {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    match place.file().filter(|scene| !scene.as_os_str().is_empty()).and_then(Path::parent) {
        Some(folder) => Location::File(absolute).relative_to(folder).replace(std::path::MAIN_SEPARATOR, "/"),
        None => absolute.display().to_string(),
    }
}

/// Where the box around a mesh is to be, so that it stands at a point: the middle, and the length of the largest side.
fn standing(low: DVec3, high: DVec3, at: DVec3, upright: DVec3, size: f64) -> DVec3 {
    let sides = high - low;
    let largest = sides.max_element();
    let scale = if largest > 0.0 { size / largest } else { 0.0 };
    at + 0.5 * scale * sides.dot(upright.abs()) * upright
}

impl App {
    /// Shows the dialog that chooses a mesh, in the folder of the scene if none was used before.
    pub(super) fn show_mesh_dialog(&mut self) {
        let of_scene = self.documents.scene.location().and_then(Location::file);
        let near = of_scene.or_else(|| self.session.as_ref().and_then(Location::file)).and_then(Path::parent);
        self.dialogs.files.choose_mesh(near);
    }

    /// Adds the mesh in a file to the scene, and selects it. A large file is read in the background first. If it cannot
    /// be used, the scene stays as it is, and a message says why.
    pub(super) fn add_mesh(&mut self, path: &Path, place: MeshSpot) {
        if let Err(reason) = self.try_to_add_mesh(path, place) {
            self.dialogs.show_message("The mesh was not added", reason);
        }
    }

    fn try_to_add_mesh(&mut self, path: &Path, place: MeshSpot) -> Result<(), String> {
        if MeshFormat::of(path).is_none() {
            return Err(format!("`{}` is not a mesh by its suffix.", path.display()));
        }
        if !self.scene_text_can_follow() {
            return Ok(());
        }
        let scene_place = self.documents.scene.place();
        let named = name_of(path, &scene_place);
        let mesh = NamedMesh::new(named.as_str())
            .ok_or_else(|| format!("A scene cannot name the file `{named}`: it has a quotation mark, or blanks around it."))?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let name = self.name_like(&as_identifier(&non_empty(words(&stem)), "mesh"));
        if place.rank == 0 {
            self.dropped.middle = None;
        }
        let world = self.workshop.world();
        let camera = &world.scene().camera;
        let high = |point: DVec3| 2.0 * SIZE * camera.depth_of(point) * (camera.fov().to_radians() / 2.0).tan();
        let stand = || place_to_stand(world, place.at, 0.5 * high(pivot(world, place.at, None)));
        let middle = *self.dropped.middle.get_or_insert_with(stand);
        let (distance, size) = (camera.depth_of(middle), high(middle));
        let [right, ..] = camera.axes();
        let beside = f64::from(place.rank) - 0.5 * f64::from(place.count.saturating_sub(1));
        let at = middle + beside * APART * size * right;
        let precision = Precision::for_size(distance);
        let rounded = |center: DVec3, size: f64| {
            let size = precision.round(DVec3::splat(size)).x;
            vec![Transform::Fit { center: precision.round(center), size }]
        };
        let form = |transforms| BodyForm { shape: Shape::Mesh(mesh.clone()), transforms };
        // With the files of the scene, because others are forgotten.
        let change = SceneChange::AddBody(name.clone(), form(rounded(at, size)));
        let scene = edit(&self.documents.scene.source(), &change, precision).map_err(|refusal| refusal.to_string())?.scene;
        if self.reads_first(scene.clone(), scene_place.clone(), AfterReading::AddMesh(path.to_owned(), place)) {
            return Ok(());
        }
        let bounds = self.bounds_of_last(scene, &scene_place)?;
        let center = standing(bounds[0], bounds[1], at, self.workshop.scene().camera.upright(), size);
        let change = SceneChange::AddBody(name.clone(), form(rounded(center, size)));
        self.add(change, precision, &name, crate::lang::variables::Owner::Body);
        self.log.add(format!("{name}: added from {}", path.display()));
        Ok(())
    }

    /// A name for a new body: this one if nothing has it yet.
    fn name_like(&self, wanted: &str) -> String {
        let is_taken = self.workshop.values().table().owners().named(wanted).is_some();
        if is_taken { unused_name(self.workshop.scene(), wanted) } else { wanted.to_owned() }
    }

    /// The box around the last body of a scene, low and high corner, without its transforms.
    fn bounds_of_last(&self, mut scene: Scene, place: &Location) -> Result<[DVec3; 2], String> {
        let memory = self.workshop.memory().unwrap_or_else(usable_memory);
        let lines = |found: &mut dyn Iterator<Item = &Diagnostic>| found.map(user_state::line).collect::<Vec<_>>().join("\n");
        let (assets, _): (Assets, _) =
            self.workshop.assets().load(&scene, place, &Reading::unwatched(memory)).map_err(|error| match error {
                AssetLoadError::Cancelled => "The work was cancelled.".to_owned(),
                AssetLoadError::Unusable(found) => lines(&mut found.iter()),
            })?;
        scene.bodies.drain(..scene.bodies.len().saturating_sub(1));
        scene.bodies.iter_mut().for_each(|body| body.form.transforms.clear());
        let world = World::new(scene, &assets).map_err(|error| error.to_string())?;
        let bounds = Arc::new(world).bounds(BodyId(0));
        Ok([bounds.low, bounds.high])
    }
}

/// A name, or another one if nothing is left of it.
fn non_empty(name: String) -> String {
    if name.is_empty() { "mesh".to_owned() } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_from_the_folder_of_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        let [inside, beside] = ["scenes", "meshes"].map(|name| folder.path().join(name));
        for folder in [&inside, &beside] {
            std::fs::create_dir(folder).unwrap();
            std::fs::write(folder.join("cow.obj"), "v 0 0 0\n").unwrap();
        }
        let scene = Location::File(inside.join("farm.scene"));
        assert_eq!(name_of(&inside.join("cow.obj"), &scene), "cow.obj");
        assert_eq!(name_of(&beside.join("cow.obj"), &scene), "../meshes/cow.obj");
        for nowhere in [Location::new(""), Location::Preset("studio".to_owned())] {
            assert_eq!(name_of(&inside.join("cow.obj"), &nowhere), inside.join("cow.obj").display().to_string());
        }
    }

    #[test]
    fn a_mesh_stands_on_its_place() {
        // Half as high as it is long: 4 long, so 2 high.
        let middle = standing(DVec3::new(5.0, 7.0, 1.0), DVec3::new(9.0, 9.0, 2.0), DVec3::X, DVec3::Y, 4.0);
        assert_eq!(middle, DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(standing(DVec3::ONE, DVec3::ONE, DVec3::X, DVec3::Y, 4.0), DVec3::X);
    }
}
