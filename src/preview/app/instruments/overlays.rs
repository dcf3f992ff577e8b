//! Models beside the formula in the charts: kept ones, and measured materials.

use crate::instrument::held::HeldFormula;
use crate::instrument::view::NamedModel;
use crate::lang::display_text::one_line;
use crate::measured::MeasuredMaterial;
use crate::plot::ChartTheme;
use egui::{Color32, Label, RichText, Sense, Ui, vec2};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The most models beside the formula.
pub(super) const MOST_OVERLAYS: usize = 6;

/// A model beside the formula.
pub(super) struct OverlayModel {
    pub(super) name: String,
    /// What it is, in a few words.
    about: String,
    content: OverlayContent,
}

/// What a model is.
enum OverlayContent {
    Kept(Box<HeldFormula>),
    Measured(PathBuf, Arc<MeasuredMaterial>),
}

/// All models beside the formula.
#[derive(Default)]
pub(super) struct Overlays {
    pub(super) models: Vec<OverlayModel>,
    /// How many were kept so far.
    kept: usize,
}

impl Overlays {
    /// Whether there is room for one more.
    pub(super) fn has_room(&self) -> bool {
        self.models.len() < MOST_OVERLAYS
    }

    /// Keeps a formula with its values. `formula` is its name, and `about` says of what it is.
    pub(super) fn keep(&mut self, formula: &str, about: &str, held: HeldFormula) {
        if self.has_room() {
            self.kept += 1;
            let name = format!("{} {}", one_line(formula), self.kept);
            let mut lines = vec![about.to_owned()];
            lines.extend(values_of(&held));
            self.models.push(OverlayModel { name, about: lines.join("\n"), content: OverlayContent::Kept(Box::new(held)) });
        }
    }

    /// Adds a measured material.
    pub(super) fn add(&mut self, path: &Path, material: Arc<MeasuredMaterial>) {
        if self.has_room() {
            let name = path.file_name().map_or_else(|| "measured".to_owned(), |name| one_line(&name.to_string_lossy()));
            let about = format!("measured: {}", one_line(&path.display().to_string()));
            self.models.push(OverlayModel { name, about, content: OverlayContent::Measured(path.to_owned(), material) });
        }
    }

    /// The models, in their order. `keeps_pairs` says whether the same pairs of directions are asked for again.
    pub(super) fn named(&self, keeps_pairs: bool) -> impl Iterator<Item = NamedModel> {
        self.models.iter().map(move |overlay| NamedModel {
            name: overlay.name.clone(),
            model: match &overlay.content {
                OverlayContent::Kept(held) => Arc::new(HeldFormula { keeps_pairs, ..(**held).clone() }),
                OverlayContent::Measured(_, material) => Arc::clone(material) as _,
            },
        })
    }

    /// Draws the list. `now` is the name of the formula with its present values, which has the first colour, and
    /// `comparing` the file that is compared in the picture. Returns whether the list has changed, and the file whose
    /// comparison shall begin or end.
    pub(super) fn ui(&mut self, ui: &mut Ui, now: &str, theme: ChartTheme, comparing: Option<&Path>) -> (bool, Option<PathBuf>) {
        if self.models.is_empty() {
            return (false, None);
        }
        let mut compared = None;
        let mut removed = None;
        entry_ui(ui, 0, theme, now, "The formula with its present values");
        for (index, overlay) in self.models.iter().enumerate() {
            ui.horizontal(|ui| {
                if ui.small_button("×").on_hover_text(format!("Remove {}", overlay.name)).clicked() {
                    removed = Some(index);
                }
                entry_ui(ui, index + 1, theme, &overlay.name, &overlay.about);
            });
            if let OverlayContent::Measured(path, _) = &overlay.content {
                let (name, about) = match comparing == Some(path) {
                    true => ("End the comparison", "Show the formula alone in the picture"),
                    false => (
                        "Compare in the picture",
                        "The left half of the picture has this material on the body, the right half the formula",
                    ),
                };
                ui.horizontal(|ui| {
                    ui.add_space(BELOW_NAME);
                    if ui.small_button(name).on_hover_text(about).clicked() {
                        compared = Some(path.clone());
                    }
                });
            }
        }
        (removed.map(|index| self.models.remove(index)).is_some(), compared)
    }

    /// The file of the measured material that was added last.
    pub(super) fn last_measured(&self) -> Option<&Path> {
        self.models.iter().rev().find_map(|overlay| match &overlay.content {
            OverlayContent::Measured(path, _) => Some(path.as_path()),
            OverlayContent::Kept(_) => None,
        })
    }
}

/// How far the button of a material stands to the right, below its name, in points.
const BELOW_NAME: f32 = 24.0;

/// The colour of a model in charts, and its name.
fn entry_ui(ui: &mut Ui, index: usize, theme: ChartTheme, name: &str, about: &str) {
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(14.0, 10.0), Sense::hover());
        let [red, green, blue] = theme.curve(index);
        ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(red, green, blue));
        ui.add(Label::new(RichText::new(name)).truncate()).on_hover_text(about);
    });
}

/// The values of what a formula declares itself, a line each.
fn values_of(held: &HeldFormula) -> Vec<String> {
    const MOST: usize = 24;
    let formula = &held.compiled.formula;
    let line = |(id, number): (crate::formula::ParameterId, &[f32; 3])| {
        let parameter = formula.parameter(id);
        let [red, green, blue] = number;
        let value = if parameter.ty.slots() == 3 { format!("<{red}, {green}, {blue}>") } else { format!("{red}") };
        format!("{} = {value}", parameter.name)
    };
    formula.parameter_ids().zip(&held.numbers).map(line).take(MOST).collect()
}
