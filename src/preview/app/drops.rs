//! Files that are dropped on the window: texts are opened, meshes become bodies, images are explained.

use crate::files::Readable;
use crate::lang::display_text::one_line;
use crate::lang::types::Type;
use crate::mesh::MeshFormat;
use crate::preview::app::scene_actions::MeshSpot;
use crate::preview::app::{Action, App, user_state};
use crate::workspace::measured_files::is_named_like_material;
use crate::workspace::{FileKind, LINEAR_SUFFIXES, Location, kind_of, kind_of_file, read_source, textures};
use egui::{Align2, FontId, LayerId, Order, Rect, Stroke, StrokeKind, Ui, pos2, vec2};
use glam::DVec3;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// The most files that are named while they are over the window.
const NAMED: usize = 5;

/// What a file seems to be, by its suffix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Guess {
    Mesh,
    Image,
    Measured,
    Text(Option<FileKind>),
}

fn suffix_of(path: &Path) -> String {
    path.extension().and_then(|suffix| suffix.to_str()).unwrap_or_default().to_lowercase()
}

/// Whether an image can be the environment of a scene.
fn may_be_environment(path: &Path) -> bool {
    LINEAR_SUFFIXES.contains(&suffix_of(path).as_str())
}

fn guess(path: &Path) -> Guess {
    let suffix = suffix_of(path);
    if MeshFormat::of(path).is_some() {
        Guess::Mesh
    } else if textures::SUFFIXES.contains(&suffix.as_str()) {
        Guess::Image
    } else if is_named_like_material(path) {
        Guess::Measured
    } else {
        Guess::Text(match suffix.as_str() {
            "session" => Some(FileKind::Session),
            other => [FileKind::Formula, FileKind::Scene, FileKind::Session].into_iter().find(|kind| kind.suffix() == other),
        })
    }
}

fn name_of(path: &Path) -> String {
    one_line(&path.file_name().unwrap_or(path.as_os_str()).to_string_lossy())
}

/// What a drop of a file would do, for the user.
fn promise(path: &Path) -> String {
    let name = name_of(path);
    match guess(path) {
        Guess::Mesh => format!("Add {name} to the scene"),
        Guess::Image if may_be_environment(path) => format!("{name} is an image, for an environment or a texture"),
        Guess::Image => format!("{name} is an image, for a texture"),
        Guess::Measured => format!("{name} is a measured material, for a formula"),
        Guess::Text(Some(kind)) => format!("Open the {} {name}", kind.noun()),
        Guess::Text(None) => format!("Open {name}"),
    }
}

/// How a measured material is used.
fn about_measured(path: &Path) -> String {
    let name = name_of(path);
    format!(
        "{name} is a measured material. To use it, save the formula in the same folder, and write \
         `= IL*measured(\"{name}\")*max(0, N.L);`."
    )
}

/// The kind of a text that is opened.
///
/// # Errors
/// It cannot be read, or is not of a kind that is opened.
fn kind_of_text(path: &Path) -> Result<FileKind, String> {
    let source = read_source(path, None, Readable::Regular).map_err(|error| user_state::line(&error))?;
    let by_suffix = match guess(path) {
        Guess::Text(kind) => kind,
        Guess::Mesh | Guess::Image | Guess::Measured => None,
    };
    match kind_of(source.text()).map(|_| kind_of_file(path, source.text())).or(by_suffix) {
        Some(FileKind::Material) => {
            let name = name_of(path);
            Err(format!("{name} is a material library. A formula names it: `#uses {name};` in its first line."))
        }
        Some(kind) => Ok(kind),
        None => Err(format!("{} is no formula, scene, session or mesh.", name_of(path))),
    }
}

/// The order in which files are handled: a session brings its own scene and formula, and a scene its bodies.
fn rank(action: &Action) -> u32 {
    let Action::Open(kind, _) = action else { return 3 };
    match kind {
        FileKind::Session => 0,
        FileKind::Scene => 1,
        FileKind::Formula | FileKind::Material => 2,
    }
}

/// A point of the image plane, moved so far from the edges of a picture that what stands there is in view.
fn within([x, y]: [f64; 2], aspect: f64) -> [f64; 2] {
    /// Something as large as meshes that are added, in half heights of the picture.
    const ROOM: f64 = 0.4;
    let most = (aspect - ROOM).max(0.0);
    [x.clamp(-most, most), y.clamp(ROOM - 1.3, 1.0 - 2.0 * ROOM)]
}

impl App {
    /// Takes files that were dropped, and handles one after the other: a question about the first one, or its files,
    /// come before the next. `waits` says whether a dialog is open.
    pub(super) fn follow_drops(&mut self, ui: &Ui, waits: bool, actions: &mut Vec<Action>) {
        let (files, pointer) = ui.input(|input| (input.raw.dropped_files.clone(), input.pointer.latest_pos()));
        let paths: Vec<PathBuf> = files.iter().map(|file| file.path().to_owned()).collect();
        if !paths.is_empty() {
            let view = self.scene_view();
            let at = pointer.filter(|at| view.picture().contains(*at)).map(|at| view.image_point(at));
            let [width, height] = view.placement.full().map(f64::from);
            self.note_drop(&paths, within(at.unwrap_or(MeshSpot::MIDDLE.at), width / height.max(1.0)));
        }
        if !waits
            && !self.dialogs.are_waiting()
            && self.asset_loading.progress().is_none()
            && let Some(action) = self.dropped.waiting.pop_front()
        {
            actions.push(action);
        }
        if !self.dropped.waiting.is_empty() {
            ui.ctx().request_repaint();
        }
    }

    /// Decides what is done with dropped files. Meshes stand side by side from a point of the image plane on.
    fn note_drop(&mut self, paths: &[PathBuf], at: [f64; 2]) {
        let (mut found, mut meshes, mut refused) = (Vec::new(), 0, Vec::new());
        let count = paths.iter().filter(|path| guess(path) == Guess::Mesh).count() as u32;
        for path in paths {
            match guess(path) {
                Guess::Mesh => {
                    found.push(Action::AddMesh(path.clone(), MeshSpot { at, rank: meshes, count }));
                    meshes += 1;
                }
                Guess::Image => refused.push(self.about_image(path)),
                Guess::Measured => refused.push(about_measured(path)),
                Guess::Text(_) => match kind_of_text(path) {
                    Ok(kind) => found.push(Action::Open(kind, Location::File(path.clone()))),
                    Err(reason) => refused.push(reason),
                },
            }
        }
        found.sort_by_key(rank);
        self.dropped.waiting.extend(found);
        if !refused.is_empty() {
            self.dialogs.show_message("Not opened", refused.join("\n\n"));
        }
    }

    /// How an image is used.
    fn about_image(&self, path: &Path) -> String {
        let table = self.workshop.values().table();
        let texture = self.workshop.values().iter().find(|(_, id, _)| table.parameter(*id).ty == Type::Texture);
        let name = name_of(path);
        let as_environment = match may_be_environment(path) {
            true => format!(" The scene may be lit by it: write `sky: environment, \"{name}\";` below `lights;`."),
            false => String::new(),
        };
        let as_texture = match texture {
            Some((owner, id, _)) => {
                let (parameter, owner) = (&table.parameter(id).name, table.owners().name(owner).unwrap_or("Scene"));
                format!(
                    "{name} is an image. To use it, select its owner in the list, such as {owner}, and click the name of the \
                     image beside the texture {}.",
                    one_line(parameter)
                )
            }
            None => format!(
                "{name} is an image. Images are for textures, and this formula has none: `wood: texture;` below \
                 `body_specific;` declares one, and `wood(u, v)` is its colour."
            ),
        };
        as_texture + &as_environment
    }

    /// Says what a drop would do while files are over the window.
    pub(super) fn show_hovered_files(&self, ui: &Ui) {
        let hovered = ui.input(|input| input.raw.hovered_files.clone());
        if hovered.is_empty() {
            return;
        }
        let known: Vec<String> = hovered.iter().filter_map(|file| file.path.as_deref()).map(promise).collect();
        let mut lines: Vec<String> = known.iter().take(NAMED).cloned().collect();
        if known.len() > NAMED {
            lines.push(format!("and {} more", known.len() - NAMED));
        }
        if lines.is_empty() {
            lines.push("Open files, or add meshes to the scene".to_owned());
        }
        let visuals = ui.visuals();
        let whole = ui.ctx().content_rect();
        let painter = ui.ctx().layer_painter(LayerId::new(Order::Foreground, egui::Id::new("hovered files")));
        let accent = visuals.selection.bg_fill;
        painter.rect_filled(whole, 0.0, visuals.panel_fill.gamma_multiply(0.6));
        painter.rect_stroke(whole.shrink(6.0), 8.0, Stroke::new(2.0, accent), StrokeKind::Inside);
        let text =
            painter.layout(lines.join("\n"), FontId::proportional(17.0), visuals.strong_text_color(), whole.width() - 80.0);
        let card = Rect::from_center_size(whole.center(), text.size() + vec2(56.0, 36.0));
        painter.rect(card, 10.0, visuals.window_fill, visuals.window_stroke, StrokeKind::Inside);
        let place = Align2::CENTER_CENTER.anchor_size(card.center(), text.size());
        painter.galley(pos2(place.left(), place.top()), text, visuals.strong_text_color());
    }
}

/// What waits to be done with dropped files.
#[derive(Default)]
pub(super) struct DroppedFiles {
    waiting: VecDeque<Action>,
    /// The middle of the meshes that are added together. They stand beside one another, not on the one before.
    pub(super) middle: Option<DVec3>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_suffix_and_first_words() {
        let told = |name: &str| promise(Path::new(name));
        assert_eq!(told("/a/Cow.GLB"), "Add Cow.GLB to the scene");
        assert_eq!(told("wood.jpeg"), "wood.jpeg is an image, for a texture");
        assert_eq!(told("chrome.binary"), "chrome.binary is a measured material, for a formula");
        assert_eq!(told("a.scene"), "Open the scene a.scene");
        assert_eq!([told("a.toml"), told("a.session")], ["Open the session a.toml", "Open the session a.session"]);
        assert_eq!(told("notes.txt"), "Open notes.txt");
        let folder = tempfile::tempdir().unwrap();
        let kind = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            kind_of_text(&path)
        };
        assert_eq!(kind("a.txt", "bodies; lights;"), Ok(FileKind::Scene));
        assert_eq!(kind("b.session", "version = 1\nformula = \"preset:phong\"\n"), Ok(FileKind::Session));
        assert_eq!(kind("c.formula", "= 1;"), Ok(FileKind::Formula));
        assert!(kind("d.txt", "Dear friend,").unwrap_err().contains("d.txt is no formula"));
        assert!(kind("e.toml", "[gold]\nkd = 0.5\n").unwrap_err().contains("#uses e.toml;"));
        assert!(kind_of_text(folder.path()).unwrap_err().contains("is a folder"));
    }
}
