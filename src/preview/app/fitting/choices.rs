//! What may move in a fit: parameters and their bounds, as the user chooses them. Choices are kept by name, so they
//! outlive changes of the formula and the scene.

use crate::fit::request::{FittedOwners, usual};
use crate::fit::unknowns::FreeParameter;
use crate::fit::words::short;
use crate::formula::{Formula, ParameterId, Term};
use crate::lang::display_text::one_line;
use crate::lang::types::Type;
use crate::lang::variables::Owner;
use crate::preview::app::theme::section;
use crate::workspace::{OwnerId, Values};
use egui::{DragValue, Grid, RichText, Ui, vec2};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// The width of a field for a bound, in points.
const BOUND_WIDTH: f32 = 54.0;

/// A parameter by the name of its owner, if that has one, and its own.
type RowKey = (Option<String>, String);

/// What the user chose of a parameter.
#[derive(Debug, Clone, Copy, Default)]
struct RowChoice {
    /// Whether it may move; none: as usual.
    free: Option<bool>,
    /// Bounds in place of its own.
    range: Option<[f32; 2]>,
}

/// The parameters that are offered.
struct OfferedRows {
    formula: Arc<Formula>,
    owners: FittedOwners,
    is_picture: bool,
    rows: Vec<(OwnerId, ParameterId)>,
    /// Those that are free if the user does not say.
    usual: Vec<(OwnerId, ParameterId)>,
}

/// The choices.
#[derive(Default)]
pub(super) struct FreeChoices {
    chosen: BTreeMap<RowKey, RowChoice>,
    offered: Option<OfferedRows>,
}

impl OfferedRows {
    /// The numbers and colours of the body that the formula reads; for a picture, all of the body and the light, then
    /// those of other bodies and lights, and of the scene.
    fn new(formula: &Arc<Formula>, values: &Values, owners: FittedOwners, is_picture: bool) -> Self {
        let table = values.table();
        let used = formula.terms_of(formula.result);
        let parameter = |term| if let Term::Parameter(id) = formula.term(term) { Some(*id) } else { None };
        let read: BTreeSet<ParameterId> = used.into_iter().filter_map(parameter).collect();
        let mut rows = Vec::new();
        let mut offered: Vec<OwnerId> = owners.body.into_iter().collect();
        if is_picture {
            offered.extend(owners.light);
            let others = [Owner::Body, Owner::Light, Owner::Global].into_iter().flat_map(|kind| table.owners().of_kind(kind));
            offered.extend(others.filter(|owner| ![owners.body, owners.light].contains(&Some(*owner))));
        }
        for owner in offered {
            let is_offered = |id: &ParameterId| {
                let parameter = formula.parameter(*id);
                let is_smooth = parameter.ty != Type::Texture && !parameter.is_whole();
                is_smooth && (is_picture || read.contains(id))
            };
            rows.extend(table.parameters_of(owner.kind()).filter(is_offered).map(|id| (owner, id)));
        }
        let body = |free: FreeParameter| owners.body.map(|body| (body, free.parameter));
        let usual = usual(table, formula, owners).into_iter().filter_map(body).collect();
        Self { formula: Arc::clone(formula), owners, is_picture, rows, usual }
    }
}

fn key_of(values: &Values, (owner, id): (OwnerId, ParameterId)) -> RowKey {
    let table = values.table();
    (table.owners().name(owner).map(str::to_owned), table.parameter(id).name.clone())
}

impl FreeChoices {
    /// Takes the formula, and whose values are fitted.
    pub(super) fn follow(&mut self, formula: &Arc<Formula>, values: &Values, owners: FittedOwners, is_picture: bool) {
        let is_same = |offered: &OfferedRows| {
            Arc::ptr_eq(&offered.formula, formula) && offered.owners == owners && offered.is_picture == is_picture
        };
        if !self.offered.as_ref().is_some_and(is_same) {
            self.offered = Some(OfferedRows::new(formula, values, owners, is_picture));
        }
    }

    /// The parameters that may move, with bounds where the user gave some.
    pub(super) fn free(&self, values: &Values) -> Vec<FreeParameter> {
        let Some(offered) = &self.offered else { return Vec::new() };
        let free = |of: &(OwnerId, ParameterId)| {
            let choice = self.chosen.get(&key_of(values, *of)).copied().unwrap_or_default();
            let is_free = choice.free.unwrap_or_else(|| offered.usual.contains(of));
            let range = choice.range.map(|range| within(range, values.table().parameter(of.1).range));
            let can = values.lock_of(of.0, of.1).is_none();
            (is_free && can).then_some(FreeParameter { parameter: of.1, owner: of.0.index(), range })
        };
        offered.rows.iter().filter_map(free).collect()
    }

    /// Lets a parameter move.
    #[cfg(test)]
    pub(super) fn choose(&mut self, owner: &str, parameter: &str) {
        self.chosen.entry((Some(owner.to_owned()), parameter.to_owned())).or_default().free = Some(true);
    }

    /// Draws the parameters.
    pub(super) fn ui(&mut self, ui: &mut Ui, values: &Values) {
        let Some(offered) = &self.offered else { return };
        if offered.rows.is_empty() {
            ui.weak("The formula reads no number or colour that could be fitted.");
            return;
        }
        let mut before = None;
        Grid::new("free parameters").num_columns(3).spacing(vec2(10.0, 4.0)).show(ui, |ui| {
            for of in &offered.rows {
                if before != Some(of.0) {
                    before = Some(of.0);
                    section(ui, values.table().owners().name(of.0).unwrap_or("Scene"));
                    if *of == offered.rows[0] {
                        ui.label(RichText::new("value now").small().weak());
                        ui.label(RichText::new("may move within").small().weak());
                    }
                    ui.end_row();
                }
                let choice = self.chosen.entry(key_of(values, *of)).or_default();
                row_ui(ui, values, *of, (choice, offered.usual.contains(of)));
                ui.end_row();
            }
        });
    }
}

/// Draws a parameter. `is_usual` says whether it is free if the user does not say.
fn row_ui(ui: &mut Ui, values: &Values, (owner, id): (OwnerId, ParameterId), (choice, is_usual): (&mut RowChoice, bool)) {
    let parameter = values.table().parameter(id);
    let lock = values.lock_of(owner, id);
    let mut is_free = lock.is_none() && choice.free.unwrap_or(is_usual);
    let about = parameter.doc.as_deref().map(one_line).unwrap_or_default();
    let about = if about.is_empty() { "Whether the fit may move it".to_owned() } else { about };
    let check = ui.add_enabled(lock.is_none(), egui::Checkbox::new(&mut is_free, one_line(&parameter.name)));
    if check.on_hover_text(about).changed() {
        choice.free = Some(is_free);
    }
    let numbers = values.get(owner, id);
    let exact: Vec<String> = numbers.iter().map(f32::to_string).collect();
    let text = match numbers {
        [one] => short(f64::from(*one)),
        all => all.iter().map(|number| format!("{number:.2}")).collect::<Vec<_>>().join(" "),
    };
    ui.label(RichText::new(text).monospace()).on_hover_text(exact.join(", "));
    match lock {
        Some(reason) if values.table().fixed(owner, id).is_none() => {
            ui.label(RichText::new(format!("follows: {reason}")).weak());
        }
        Some(reason) => {
            ui.label(RichText::new("always 0").weak()).on_hover_text(reason);
        }
        None => {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 5.0;
                ui.add_enabled_ui(is_free, |ui| bounds_ui(ui, choice, parameter.range, numbers));
            });
        }
    }
}

/// Draws the bounds of a parameter with a range of its own, and a value.
fn bounds_ui(ui: &mut Ui, choice: &mut RowChoice, own: Option<[f32; 2]>, value: &[f32]) {
    let Some(mut range) = choice.range.map(|range| within(range, own)).or(own) else {
        if ui.small_button("no bounds").on_hover_text("Click to give it bounds").clicked() {
            let least = value.iter().copied().fold(0.0, f32::min);
            choice.range = Some([least, value.iter().copied().fold(1.0, f32::max)]);
        }
        return;
    };
    let [least, most] = own.unwrap_or([f32::MIN, f32::MAX]);
    let before = range;
    let speed = f64::from(range[1] - range[0]).clamp(1e-3, 1e6) / 200.0;
    ui.spacing_mut().interact_size.x = BOUND_WIDTH;
    let [low, high] = &mut range;
    ui.add(bound(low, least..=*high, speed)).on_hover_text("The least value that the fit may give it");
    ui.label("to");
    ui.add(bound(high, *low..=most, speed)).on_hover_text("The greatest value that the fit may give it");
    if range != before {
        choice.range = Some(range);
    }
    if choice.range.is_some() && ui.small_button("×").on_hover_text("Back to its own range").clicked() {
        choice.range = None;
    }
}

/// A field for a bound within limits.
fn bound(number: &mut f32, limits: RangeInclusive<f32>, speed: f64) -> DragValue<'_> {
    DragValue::new(number).range(limits).speed(speed).max_decimals(4).update_while_editing(false)
}

/// The part of a range that lies within the parameter's own, which another formula may have changed.
fn within([low, high]: [f32; 2], own: Option<[f32; 2]>) -> [f32; 2] {
    let [least, most] = own.unwrap_or([f32::MIN, f32::MAX]);
    // A number that was typed may be NaN, which neither `max` nor `min` keeps.
    let low = low.max(least).min(most);
    [low, high.max(low).min(most)]
}
