//! The result of a fit: its table and sentences, and what it does to the values.

use crate::fit::unknowns::FitNumber;
use crate::fit::words::{
    LoneEffect, binding, binds, bound, certainty, hardly_fell, name_of, one_way, short, starts, undefined, undetermined,
};
use crate::formula::Formula;
use crate::plot::Chart;
use crate::preview::app::fitting::data::compared;
use crate::preview::app::fitting::work::{Fitted, FittingTask};
use crate::preview::workshop::Workshop;
use crate::workspace::session::NamedValue;
use crate::workspace::{Assignment, Session, Values};
use crate::world::World;
use egui::{Align, Grid, Label, Layout, RichText, ScrollArea, Ui, vec2};
use std::sync::Arc;

/// A row of the table, in words.
struct ResultRow {
    name: String,
    before: String,
    after: String,
    certainty: String,
}

/// Which values of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FittingSide {
    /// Those that it began with.
    Before,
    /// Those that it found.
    After,
}

/// The result.
pub(super) struct FittingResult {
    formula: Arc<Formula>,
    world: Arc<World>,
    /// All values before and after.
    all: [Values; 2],
    /// Those that were fitted, by name, before and after.
    fitted: [Vec<NamedValue>; 2],
    /// What was fitted to what.
    described: String,
    rows: Vec<ResultRow>,
    residual: String,
    sentences: Vec<String>,
    /// What is said if the fit was cancelled, so that the values are no minimum.
    pub(super) cancelled: Option<&'static str>,
    pub(super) chart: Arc<Chart>,
}

impl FittingResult {
    pub(super) fn new(task: &FittingTask, found: Fitted) -> Self {
        let Fitted { solution, values, undefined: undefined_samples, asymmetry, chart, seconds } = found;
        let (unknowns, table) = (&task.unknowns, task.values.table());
        let numbers = unknowns.numbers();
        let row = |(index, (number, before)): (usize, (&FitNumber, &f64))| ResultRow {
            name: name_of(table, number),
            before: short(*before),
            after: solution.values.get(index).copied().map_or_else(String::new, short),
            certainty: certainty(
                solution.deviations.get(index).copied().flatten(),
                index >= unknowns.free(),
                bound(&solution, index),
            ),
        };
        let start = unknowns.start();
        let rows = numbers.iter().zip(&start).enumerate().map(row).collect();
        let [before, after] = solution.residuals;
        let of_cancelled = match after < before {
            true => "The fit was cancelled; these are the best values so far.",
            false => "The fit was cancelled before it found better values.",
        };
        let what = compared(task.settings.metric, task.data.is_picture());
        let residual = format!("Residual {before:.2e} → {after:.2e} (root mean square, {what})");
        let outcomes: Vec<(f64, usize)> = solution.starts.iter().map(|start| (start.residual, start.evaluations)).collect();
        let mut sentences = vec![starts(&outcomes, before, seconds)];
        let group = |group: &Vec<FitNumber>| {
            let names: Vec<String> = group.iter().map(|number| name_of(table, number)).collect();
            (names, LoneEffect::of_group(group, &solution.stepwise, &solution.elsewhere))
        };
        sentences.extend(binding(table, &solution).iter().map(|condition| binds(condition)));
        sentences.extend(undetermined(&solution.undetermined.iter().map(group).collect::<Vec<_>>()));
        sentences.extend(hardly_fell([before, after], task.data.is_picture()).filter(|_| !solution.cancelled).map(str::to_owned));
        let undefined_samples = undefined_samples.filter(|[count, _]| *count > 0);
        sentences.extend(asymmetry.and_then(one_way));
        sentences.extend(undefined_samples.map(|[count, samples]| undefined(count, samples)));
        let is_fitted = |owner: usize, id| numbers.iter().any(|number| (number.owner, number.parameter) == (owner, id));
        let of = |values: &Values| {
            let named = values.iter().zip(Session::name_values(values));
            named.filter(|((owner, id, _), _)| is_fitted(owner.index(), *id)).map(|(_, named)| named).collect()
        };
        Self {
            formula: Arc::clone(&task.formula),
            world: Arc::clone(&task.world),
            fitted: [of(&task.values), of(&values)],
            all: [task.values.clone(), values],
            described: task.described.clone(),
            rows,
            residual,
            sentences: sentences.iter().map(|text| sentence(text)).collect(),
            cancelled: solution.cancelled.then_some(of_cancelled),
            chart: Arc::new(chart),
        }
    }

    /// The values of one side that still have a place, and how many have none.
    fn assignments(&self, side: FittingSide, workshop: &Workshop) -> (Vec<Assignment>, usize) {
        let named = &self.fitted[side as usize];
        let values = workshop.values();
        let mut found: Vec<Assignment> = named.iter().filter_map(|value| value.assignment(values.table()).ok()).collect();
        let missing = named.len() - found.len();
        // What follows from others follows by itself.
        found.retain(|value| values.lock_of(value.owner, value.parameter).is_none());
        (found, missing)
    }

    /// Whether all fitted values that have a place are those of one side.
    pub(super) fn is_at(&self, side: FittingSide, workshop: &Workshop) -> bool {
        let values = workshop.values();
        let is_there = |wanted: &Assignment| {
            values.get(wanted.owner, wanted.parameter).iter().zip(wanted.value).all(|(there, wanted)| *there == wanted)
        };
        self.assignments(side, workshop).0.iter().all(is_there)
    }

    /// Sets the fitted values to those of one side, in one step of undo. Returns how many have no place any more.
    pub(super) fn set(&self, side: FittingSide, workshop: &mut Workshop) -> usize {
        let (assignments, missing) = self.assignments(side, workshop);
        // Together, so that none has to give way to an old value of another one.
        workshop.change(|values| {
            values.assign(&assignments);
        });
        missing
    }

    /// Whether it is of something that is no longer there; if so, what has changed.
    pub(super) fn staleness(&self, workshop: &Workshop) -> Option<&'static str> {
        if !Arc::ptr_eq(&self.formula, workshop.formula()) {
            Some("The formula has changed since this fit began. Apply sets the values of parameters that still exist.")
        } else if !Arc::ptr_eq(&self.world, workshop.world()) {
            Some("The scene has changed since this fit began. Apply sets the values of parameters that still exist.")
        } else if self.all.iter().all(|values| values.numbers() != workshop.values().numbers()) {
            Some("Values have changed since this fit began: this is the result for the earlier ones.")
        } else {
            None
        }
    }

    /// Draws the table and the sentences.
    pub(super) fn ui(&self, ui: &mut Ui, workshop: &Workshop) {
        ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            let width = ui.available_width().max(260.0);
            let wrapped = |ui: &mut Ui, text: RichText| {
                ui.scope(|ui| {
                    ui.set_max_width(width);
                    ui.add(Label::new(text).wrap());
                });
            };
            wrapped(ui, RichText::new(&self.described).small().weak());
            if let Some(text) = self.cancelled {
                let text = RichText::new(text);
                wrapped(ui, text.color(ui.visuals().warn_fg_color));
            }
            if let Some(text) = self.staleness(workshop) {
                let text = RichText::new(text);
                wrapped(ui, text.color(ui.visuals().warn_fg_color));
            }
            wrapped(ui, RichText::new(&self.residual).strong());
            ui.add_space(4.0);
            let between = if width < 330.0 { 8.0 } else { 18.0 };
            Grid::new("fitted values").num_columns(4).striped(true).spacing(vec2(between, 4.0)).show(ui, |ui| {
                let head = |ui: &mut Ui, text: &str| right(ui, RichText::new(text).small().weak());
                ui.label(RichText::new("parameter").small().weak());
                ["before", "after"].into_iter().for_each(|title| head(ui, title));
                ui.label(RichText::new("deviation").small().weak());
                ui.end_row();
                for row in &self.rows {
                    ui.label(&row.name);
                    right(ui, RichText::new(&row.before).monospace());
                    right(ui, RichText::new(&row.after).monospace().strong());
                    ui.label(RichText::new(&row.certainty).monospace());
                    ui.end_row();
                }
            });
            ui.add_space(4.0);
            for text in &self.sentences {
                wrapped(ui, RichText::new(text));
            }
        });
    }

    /// The lines of the result, for tests.
    #[cfg(test)]
    pub(super) fn sentences(&self) -> &[String] {
        &self.sentences
    }
}

/// Draws a number at the right of its cell.
fn right(ui: &mut Ui, text: RichText) {
    const LEAST: f32 = 64.0;
    let size = vec2(LEAST, ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Center), |ui| {
        ui.set_min_width(LEAST);
        ui.label(text);
    });
}

/// A line as a sentence.
fn sentence(line: &str) -> String {
    let mut letters = line.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    let end = if line.ends_with('?') { "" } else { "." };
    format!("{first}{}{end}", letters.as_str())
}
