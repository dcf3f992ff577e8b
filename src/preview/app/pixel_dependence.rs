//! How the inspected pixel changes with a parameter: its derivative, and what one per cent of the range would do.

use crate::evaluate::inspect::{End, Inspection, figures};
use crate::formula::ParameterId;
use crate::lang::display_text::one_line;
use crate::preview::workshop::{MovingParameter, Workshop, is_movable};
use crate::sensitivity::Sensitivity;
use crate::workspace::OwnerId;
use egui::{ComboBox, Label, RichText, Ui};
use std::sync::Arc;

/// A parameter of an owner.
pub(super) type OwnedParameter = (OwnerId, ParameterId);

/// The row of the inspector that says so.
#[derive(Default)]
pub(super) struct PixelDependence {
    /// The parameter that the user chose in the row, until another one is moved.
    chosen: Option<OwnedParameter>,
    /// The parameter that was moved last.
    moved: Option<OwnedParameter>,
    found: Option<PixelChange>,
}

/// What was found of a pixel.
struct PixelChange {
    stamp: u64,
    pixel: [u32; 2],
    of: OwnedParameter,
    asked: MovingParameter,
    sensitivity: Sensitivity,
    /// How fast each component changes.
    slope: [f32; 3],
}

impl PixelDependence {
    /// The derivative of the pixel, and one per cent of the range of the parameter. `None` if the parameter is locked.
    fn find(&mut self, workshop: &Workshop, inspection: &Inspection, of: OwnedParameter) -> Option<([f32; 3], Option<f32>)> {
        let (stamp, pixel, pass) = (workshop.stamp(), inspection.pixel, inspection.pass);
        let is_known = |found: &PixelChange| {
            (found.stamp, found.pixel, found.of, found.asked.subject.view.pass()) == (stamp, pixel, of, pass)
        };
        if let Some(found) = self.found.as_ref().filter(|found| is_known(found)) {
            return Some((found.slope, found.asked.step));
        }
        let mut asked = workshop.moving_parameter(of)?;
        asked.subject.view = asked.subject.view.with_pass(pass);
        let is_prepared = |found: &PixelChange| {
            let MovingParameter { subject, moving, .. } = &found.asked;
            found.pixel == pixel
                && *moving == asked.moving
                && subject.same_hits(&asked.subject)
                && Arc::ptr_eq(&subject.formula, &asked.subject.formula)
        };
        let sensitivity = match self.found.take().filter(is_prepared) {
            Some(found) => found.sensitivity,
            None => Sensitivity::of_pixel(&asked.subject, pixel, &asked.moving),
        };
        let change = sensitivity.change(&asked.numbers, &asked.speeds);
        let slope = change.linear.first().copied().unwrap_or_default();
        let step = asked.step;
        self.found = Some(PixelChange { stamp, pixel, of, asked, sensitivity, slope });
        Some((slope, step))
    }

    /// Draws the row. `moved` is the parameter that was moved last.
    pub(super) fn ui(&mut self, ui: &mut Ui, workshop: &Workshop, inspection: &Inspection, moved: Option<OwnedParameter>) {
        if std::mem::replace(&mut self.moved, moved) != moved {
            self.chosen = None;
        }
        let table = workshop.values().table();
        let exists = |(owner, id): &OwnedParameter| table.indices(*owner, *id).is_some();
        let Some(mut of) = self.chosen.filter(exists).or(moved.filter(exists)) else { return };
        let mut found = None;
        ui.horizontal(|ui| {
            ui.label("∂E/∂").on_hover_text("How fast the colour of the pixel changes with a parameter: its derivative");
            let label = |of: OwnedParameter| one_line(&table.label(of.0, of.1));
            ComboBox::from_id_salt("dependence").selected_text(label(of)).width(120.0).show_ui(ui, |ui| {
                for (owner, id, _) in workshop.values().iter() {
                    if is_movable(table.parameter(id)) && is_near(owner, inspection) {
                        ui.selectable_value(&mut of, (owner, id), label((owner, id)));
                    }
                }
            });
            if Some(of) != moved || self.chosen.is_some() {
                self.chosen = Some(of);
            }
            found = Some(self.find(workshop, inspection, of));
            let text = match found {
                Some(Some((slope, _))) => format!("= {}", colour_text(slope)),
                Some(None) | None => "it cannot be moved here".to_owned(),
            };
            let hover = format!("{text}\nIn pass {}, without exposure and tone curve", inspection.pass);
            ui.add(Label::new(RichText::new(text).monospace()).truncate()).on_hover_text(hover);
        });
        if let Some(Some((slope, Some(step)))) = found {
            ui.add(Label::new(RichText::new(step_text(slope, step)).weak()).truncate());
        }
    }

    /// What the row says of a parameter of the inspected pixel.
    #[cfg(test)]
    pub(super) fn slope(&mut self, workshop: &Workshop, inspection: &Inspection, of: OwnedParameter) -> Option<[f32; 3]> {
        self.find(workshop, inspection, of).map(|(slope, _)| slope)
    }
}

/// Whether the values of an owner may matter for a pixel: those of the scene, of lights, and of the bodies that its
/// rays hit.
fn is_near(owner: OwnerId, inspection: &Inspection) -> bool {
    let OwnerId::Body(body) = owner else { return true };
    inspection.rays.iter().any(|ray| matches!(&ray.end, End::Hit(hit) if hit.body() == body))
}

fn colour_text(colour: [f32; 3]) -> String {
    format!("<{}>", colour.map(|component| figures(f64::from(component))).join(", "))
}

/// What a step of a parameter, one per cent of its range, does to the pixel.
fn step_text(slope: [f32; 3], step: f32) -> String {
    let changed = colour_text(slope.map(|component| step * component));
    format!("1 % of its range ({}): about {changed}", figures(f64::from(step)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_parts_of_the_range() {
        let text = step_text([0.5, 0.0, -1.0], 0.02);
        assert_eq!(text, "1 % of its range (0.02): about <0.01, 0, -0.02>");
    }
}
