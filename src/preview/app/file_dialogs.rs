//! The dialogs for files: which files they list, and which name and folder they suggest.

use crate::lang::display_text::one_line;
use crate::measured;
use crate::mesh::FORMATS;
use crate::picture::Format;
use crate::plot::ChartFormat;
use crate::preview::app::question::Question;
use crate::preview::app::scene_actions::MeshSpot;
use crate::preview::app::{Action, InstrumentAction};
use crate::workspace::FileKind;
use crate::workspace::Location;
use crate::workspace::OwnerId;
use crate::workspace::textures::SUFFIXES;
use egui::layers::ShapeIdx;
use egui::{Align2, Context, Id, Key, LayerId, Memory, Order, Shape, TextFormat};
use egui_file_dialog::{DialogState, FileDialog};
use std::path::{Path, PathBuf};

/// What a file dialog is for.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Purpose {
    Open(FileKind),
    Image(OwnerId, String),
    Mesh,
    Save(Option<FileKind>),
    Measured,
    SaveChart,
    FittingData,
}

/// The file dialog that is open, and the folder that was used last.
#[derive(Default)]
pub(super) struct FileDialogs {
    shown: Option<(FileDialog, Purpose)>,
    /// The widget that had the keyboard in the last frame, and whether Escape took the keyboard from it then.
    focused: (Option<Id>, bool),
    last_folder: Option<PathBuf>,
}

/// The name of the filter for images.
const IMAGES: &str = "Images";

/// The name of the filter for meshes.
const MESHES: &str = "Meshes";

/// The name of the filter for measured materials.
const MEASURED: &str = "Measured materials";

/// The name of the filter for what formulas are fitted to.
const FITTING_DATA: &str = "Data and pictures";

/// The format that is suggested for pictures.
const PICTURE: Format = Format::Png;

/// The files of a kind.
fn plural(kind: FileKind) -> &'static str {
    match kind {
        FileKind::Formula => "Formulas",
        FileKind::Scene => "Scenes",
        FileKind::Session => "Sessions",
        FileKind::Material => "Material libraries",
    }
}

/// The name of a filter, with its suffix: `Formulas (*.formula)`.
fn filter_name(kind: FileKind) -> String {
    format!("{} (*.{})", plural(kind), kind.suffix())
}

/// A dialog in the middle of the window, in a folder or else in the working directory.
fn dialog(title: &str, folder: Option<&Path>) -> FileDialog {
    let mut dialog = FileDialog::new().title(title).anchor(Align2::CENTER_CENTER, [0.0, 0.0]);
    dialog.config_mut().labels.file_filter_all_files = "All files".to_owned();
    dialog.config_mut().labels.save_extension_any = "All files".to_owned();
    match folder.filter(|folder| folder.is_dir()).and_then(|folder| std::path::absolute(folder).ok()) {
        Some(folder) => dialog.initial_directory(folder),
        None => dialog,
    }
}

impl FileDialogs {
    /// Shows the dialog that opens a file. `near` is the folder that it shows if none was used before.
    pub(super) fn open(&mut self, kind: FileKind, near: Option<&Path>) {
        let name = filter_name(kind);
        let dialog = dialog(&format!("Open {}", kind.noun()), self.last_folder.as_deref().or(near));
        let mut dialog = dialog.add_file_filter_extensions(&name, vec![kind.suffix()]).default_file_filter(&name);
        dialog.pick_file();
        self.shown = Some((dialog, Purpose::Open(kind)));
    }

    /// Shows the dialog that chooses the image of a texture of an owner. `near` is as for [`open`](Self::open).
    pub(super) fn choose_image(&mut self, owner: OwnerId, parameter: String, near: Option<&Path>) {
        let dialog = dialog("Choose an image", self.last_folder.as_deref().or(near));
        let mut dialog = dialog.add_file_filter_extensions(IMAGES, SUFFIXES.to_vec()).default_file_filter(IMAGES);
        dialog.pick_file();
        self.shown = Some((dialog, Purpose::Image(owner, parameter)));
    }

    /// Shows the dialog that chooses a mesh. `near` is as for [`open`](Self::open).
    pub(super) fn choose_mesh(&mut self, near: Option<&Path>) {
        let dialog = dialog("Add a mesh", self.last_folder.as_deref().or(near));
        let suffixes: Vec<&str> = FORMATS.iter().flat_map(|format| format.suffixes.iter().copied()).collect();
        let mut dialog = dialog.add_file_filter_extensions(MESHES, suffixes).default_file_filter(MESHES);
        dialog.pick_file();
        self.shown = Some((dialog, Purpose::Mesh));
    }

    /// Shows the dialog that chooses a measured material. `near` is as for [`open`](Self::open).
    pub(super) fn choose_measured(&mut self, near: Option<&Path>) {
        let dialog = dialog("Show a measured material", self.last_folder.as_deref().or(near));
        let of_materials = measured::FORMATS.iter().filter(|format| format.has_all_directions);
        let suffixes: Vec<&str> = of_materials.flat_map(|format| format.suffixes.iter().copied()).collect();
        let mut dialog = dialog.add_file_filter_extensions(MEASURED, suffixes).default_file_filter(MEASURED);
        dialog.pick_file();
        self.shown = Some((dialog, Purpose::Measured));
    }

    /// Shows the dialog that chooses what a formula is fitted to. `near` is as for [`open`](Self::open).
    pub(super) fn choose_fitting_data(&mut self, near: Option<&Path>) {
        let dialog = dialog("Choose data to fit to", self.last_folder.as_deref().or(near));
        let measured = measured::FORMATS.iter().flat_map(|format| format.suffixes.iter().copied());
        let suffixes: Vec<&str> = measured.chain(Format::ALL.into_iter().map(Format::suffix)).collect();
        let mut dialog = dialog.add_file_filter_extensions(FITTING_DATA, suffixes).default_file_filter(FITTING_DATA);
        dialog.pick_file();
        self.shown = Some((dialog, Purpose::FittingData));
    }

    /// Shows the dialog that saves a chart, with a suggested name.
    pub(super) fn save_chart(&mut self, suggested: &Suggestion) {
        let folder = suggested.folder.as_deref().or(self.last_folder.as_deref());
        let dialog = dialog("Save chart", folder).default_file_name(&suggested.name);
        let add = |dialog: FileDialog, format: ChartFormat| dialog.add_save_extension(format.name(), format.suffix());
        let mut dialog = ChartFormat::ALL.into_iter().fold(dialog, add).default_save_extension(ChartFormat::ALL[0].name());
        dialog.save_file();
        self.shown = Some((dialog, Purpose::SaveChart));
    }

    /// Shows the dialog that saves something of this kind, or the picture, with a suggested path.
    pub(super) fn save(&mut self, kind: Option<FileKind>, title: &str, suggested: &Suggestion) {
        let folder = suggested.folder.as_deref().or(self.last_folder.as_deref());
        let dialog = dialog(title, folder).default_file_name(&suggested.name);
        let mut dialog = match kind {
            Some(kind) => {
                // The dialog writes the suffix behind the name.
                dialog.add_save_extension(plural(kind), kind.suffix()).default_save_extension(plural(kind))
            }
            None => {
                let name = |format: Format| format.suffix().to_uppercase();
                let add = |dialog: FileDialog, format: Format| dialog.add_save_extension(&name(format), format.suffix());
                Format::ALL.into_iter().fold(dialog, add).default_save_extension(&name(PICTURE))
            }
        };
        dialog.save_file();
        self.shown = Some((dialog, Purpose::Save(kind)));
    }

    /// Whether a dialog is open. It is not one of egui's modal dialogs.
    pub(super) fn is_open(&self) -> bool {
        self.shown.as_ref().is_some_and(|(dialog, _)| *dialog.state() == DialogState::Open)
    }

    /// Draws the open dialog. Returns a question if a file would be replaced that the user has not seen in it.
    pub(super) fn ui(&mut self, context: &Context, actions: &mut Vec<Action>) -> Option<Question> {
        let (focused, was_escaped) = self.focused;
        let (dialog, purpose) = self.shown.as_mut()?;
        // The dialog itself closes a field that is open for a moment. Any other field loses the keyboard and stays:
        // then Escape was for the dialog.
        if was_escaped && focused.is_some_and(|id| context.read_response(id).is_some()) {
            (self.shown, self.focused) = (None, (None, false));
            actions.push(Action::StopSaving);
            return None;
        }
        // The search field is black in any theme, so its text would be unreadable in the light theme.
        dialog.config_mut().show_search = context.global_style().visuals.dark_mode;
        dialog.update(context);
        let escaped = focused.is_some() && context.input(|input| input.key_pressed(Key::Escape));
        if escaped {
            self.focused = (focused, true);
            context.request_repaint();
        } else {
            self.focused = (context.memory(Memory::focused), false);
        }
        legible(context, dialog.get_window_id());
        let (purpose, picked) = (purpose.clone(), dialog.take_picked());
        let Some(path) = picked else {
            if *dialog.state() != DialogState::Open {
                self.shown = None;
                actions.push(Action::StopSaving);
            }
            return None;
        };
        self.shown = None;
        self.last_folder = path.parent().map(Path::to_owned);
        match purpose {
            Purpose::Open(kind) => actions.push(Action::Open(kind, Location::File(path))),
            Purpose::Image(owner, parameter) => actions.push(Action::SetImage(owner, parameter, path)),
            Purpose::Mesh => actions.push(Action::AddMesh(path, MeshSpot::MIDDLE)),
            Purpose::Measured => actions.push(Action::Instruments(InstrumentAction::AddMeasured(path))),
            Purpose::SaveChart if path.extension().is_some() => actions.push(Action::Instruments(InstrumentAction::Save(path))),
            Purpose::SaveChart => {
                return replacing(
                    path,
                    ChartFormat::ALL[0].suffix(),
                    |path| Action::Instruments(InstrumentAction::Save(path)),
                    actions,
                );
            }
            Purpose::FittingData => actions.push(Action::FitTo(path)),
            Purpose::Save(kind) if path.extension().is_some() => actions.push(Action::SaveTo(kind, path)),
            Purpose::Save(kind) => {
                let suffix = kind.map_or(PICTURE.suffix(), FileKind::suffix);
                return replacing(path, suffix, |path| Action::SaveTo(kind, path), actions);
            }
        }
        None
    }
}

/// Saves to a path with this suffix behind it; asks first if there is a file, which the user has not seen then.
fn replacing(path: PathBuf, suffix: &str, save: impl Fn(PathBuf) -> Action, actions: &mut Vec<Action>) -> Option<Question> {
    let path = path.with_added_extension(suffix);
    if path.exists() {
        let text = format!("There is already a file {}.", one_line(&path.display().to_string()));
        let question = Question::new("Replace the file?", text).answer("Replace", save(path));
        return Some(question.or("Cancel").dismissed(Action::StopSaving));
    }
    actions.push(save(path));
    None
}

/// Gives texts without a colour the colour of the theme. The dialog writes the name of a file that would be replaced
/// in a grey for dark themes.
fn legible(context: &Context, window: Id) {
    let colour = context.global_style().visuals.text_color();
    let default = TextFormat::default().color;
    context.graphics_mut(|graphics| {
        let list = graphics.entry(LayerId::new(Order::Middle, window));
        for index in 0..list.next_idx().0 {
            list.mutate_shape(ShapeIdx(index), |clipped| {
                if let Shape::Text(text) = &mut clipped.shape
                    && text.galley.job.sections.iter().all(|section| section.format.color == default)
                {
                    text.override_text_color = Some(colour);
                }
            });
        }
    });
}

/// A suggestion for the dialog that saves.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Suggestion {
    /// The name of the file.
    pub(super) name: String,
    /// Its folder, if one is better than the one that was used last.
    pub(super) folder: Option<PathBuf>,
}

impl Suggestion {
    /// The suggestion for something of this kind, or the picture: the name of its own file, with the right suffix, or
    /// else that of the session.
    pub(super) fn new(kind: Option<FileKind>, own: Option<&Location>, session: Option<&Location>) -> Self {
        let suffix = kind.map_or(PICTURE.suffix(), FileKind::suffix);
        let stem = |location: &Location| match location {
            Location::File(path) => path.file_stem().map(|stem| stem.to_string_lossy().into_owned()),
            Location::Preset(name) => Some(name.clone()),
        };
        let stem = own.and_then(stem).or_else(|| session.and_then(stem)).unwrap_or_else(|| "untitled".to_owned());
        let folder = |location: &Location| location.file().and_then(Path::parent).map(Path::to_owned);
        let folder = own.and_then(folder).or_else(|| session.and_then(folder)).filter(|folder| !folder.as_os_str().is_empty());
        Self { name: format!("{stem}.{suffix}"), folder }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_from_the_file_or_the_session() {
        let file = |path: &str| Location::File(PathBuf::from(path));
        let name = |kind, own: Option<&Location>, session: Option<&Location>| Suggestion::new(kind, own, session).name;
        let (own, studio) = (file("/a/gold.formula"), Location::Preset("studio".to_owned()));
        assert_eq!(name(Some(FileKind::Formula), Some(&own), Some(&studio)), "gold.formula");
        assert_eq!(name(Some(FileKind::Scene), Some(&studio), None), "studio.scene");
        assert_eq!(name(Some(FileKind::Formula), None, Some(&studio)), "studio.formula");
        assert_eq!(name(Some(FileKind::Session), None, Some(&studio)), "studio.toml");
        assert_eq!(name(None, None, Some(&file("mine.v2.toml"))), "mine.v2.png");
        assert_eq!(name(Some(FileKind::Session), None, None), "untitled.toml");
        assert_eq!(Suggestion::new(None, Some(&own), None).folder, Some(PathBuf::from("/a")));
        assert_eq!(Suggestion::new(None, Some(&file("here.formula")), None).folder, None);
    }

    #[test]
    fn filters_name_their_suffixes() {
        assert_eq!(filter_name(FileKind::Formula), "Formulas (*.formula)");
        assert_eq!(filter_name(FileKind::Session), "Sessions (*.toml)");
    }
}
