//! What the user chooses of a chart: the view, directions of light, and what is shown of the model.

use crate::instrument::view::{Component, InstrumentView, LightUse, Shown, VIEWS, ViewSettings};
use egui::{ComboBox, DragValue, Grid, Slider, Ui};

/// The most angles of the light in one chart.
const MOST_ANGLES: usize = 6;
/// The greatest angle of the light, in degrees.
const STEEPEST: f64 = 89.0;

/// The greatest coordinate of a surface that can be typed.
const FARTHEST: f64 = 1e4;

/// The choices.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ChartControls {
    /// The index of the view among [`VIEWS`].
    view: usize,
    /// The angles of the light in views that show several together, in degrees from the normal.
    angles: Vec<f64>,
    /// The angle of the light in views that show one.
    angle: f64,
    /// The azimuth of the light, in degrees from the tangent.
    azimuth: f64,
    /// The angle of the viewer in the plane of curves, in degrees from the normal.
    viewer: f64,
    /// The coordinates of the surface, `u` and `v`.
    coordinates: [f64; 2],
    /// From the plane of incidence to the plane of curves, in degrees.
    plane: f64,
    is_log: bool,
    false_colours: bool,
    /// Which number of colours; none as it suits the view.
    component: Option<Component>,
    shown: Shown,
    /// From where lobes are seen.
    seen_from: [f64; 2],
}

impl Default for ChartControls {
    fn default() -> Self {
        let ViewSettings { light_azimuth, plane, is_log, false_colours, component, shown, seen_from, .. } =
            ViewSettings::default();
        Self {
            view: 0,
            angles: vec![0.0, 30.0, 60.0],
            angle: 45.0,
            azimuth: light_azimuth,
            viewer: 30.0,
            coordinates: [0.0; 2],
            plane,
            is_log,
            false_colours,
            component,
            shown,
            seen_from,
        }
    }
}

/// The name of a view with a capital letter.
pub(super) fn title(view: &InstrumentView) -> String {
    let mut letters = view.name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

impl ChartControls {
    /// The view.
    pub(super) fn view(&self) -> &'static InstrumentView {
        &VIEWS[self.view.min(VIEWS.len() - 1)]
    }

    /// Chooses the view of a name.
    pub(super) fn choose(&mut self, name: &str) {
        self.view = VIEWS.iter().position(|view| view.name == name).unwrap_or(self.view);
    }

    /// Takes the directions of a hit: polar angle and azimuth of the light and of the viewer, in degrees.
    pub(super) fn look(&mut self, [light, azimuth]: [f64; 2], [viewer, around]: [f64; 2]) {
        let light = light.min(STEEPEST);
        (self.angles, self.angle, self.azimuth) = (vec![light], light, turned(azimuth));
        self.viewer = viewer.min(STEEPEST);
        self.plane = turned(around - azimuth - 180.0);
    }

    /// The coordinates of the surface.
    pub(super) fn coordinates(&self) -> [f64; 2] {
        self.coordinates
    }

    /// Takes the coordinates of a hit.
    pub(super) fn place_at(&mut self, coordinates: [f64; 2]) {
        self.coordinates = coordinates;
    }

    /// The angle of the viewer, in views for which its numbers are read out.
    pub(super) fn viewer(&self) -> Option<f64> {
        matches!(self.view().name, "polar" | "cartesian" | "lobe" | "slice").then_some(self.viewer)
    }

    /// Turns lobes with the mouse, which was moved by these points.
    pub(super) fn turn(&mut self, [right, down]: [f32; 2]) {
        let [azimuth, elevation] = self.seen_from;
        self.seen_from =
            [(azimuth - 0.5 * f64::from(right)).rem_euclid(360.0), (elevation + 0.5 * f64::from(down)).clamp(-5.0, 90.0)];
    }

    /// What the view is told.
    pub(super) fn settings(&self) -> ViewSettings {
        ViewSettings {
            light_polar: match self.view().lights {
                LightUse::Several => self.angles.clone(),
                LightUse::One => vec![self.angle],
                // The chart has every angle, but one of them is read out.
                LightUse::All if self.viewer().is_some() => vec![self.angle],
                LightUse::All | LightUse::Integrated => Vec::new(),
            },
            light_azimuth: self.azimuth,
            plane: self.plane,
            is_log: self.is_log,
            false_colours: self.false_colours,
            component: self.component,
            shown: self.shown,
            seen_from: self.seen_from,
            ..ViewSettings::default()
        }
    }

    /// Draws the names of all views, of which one is chosen.
    pub(super) fn views_ui(&mut self, ui: &mut Ui) {
        for (index, view) in VIEWS.iter().enumerate() {
            if ui.selectable_label(self.view == index, title(view)).on_hover_text(view.doc).clicked() {
                self.view = index;
            }
        }
    }

    /// Draws the choices that the view has; the coordinates of the surface only if the formula reads them.
    pub(super) fn ui(&mut self, ui: &mut Ui, reads_coordinates: bool) {
        self.directions_ui(ui);
        if reads_coordinates {
            self.coordinates_ui(ui);
        }
        let view = self.view().name;
        if !matches!(view, "furnace" | "reciprocity" | "sphere") {
            let named = |component: Option<Component>| {
                let found = Component::ALL.iter().find(|(_, other)| Some(*other) == component);
                found.map_or("as suits", |(name, _)| name)
            };
            ComboBox::from_id_salt("component").width(120.0).selected_text(named(self.component)).show_ui(ui, |ui| {
                let all = std::iter::once(None).chain(Component::ALL.iter().map(|(_, component)| Some(*component)));
                for component in all {
                    ui.selectable_value(&mut self.component, component, named(component));
                }
            });
        }
        ui.horizontal_wrapped(|ui| {
            if matches!(view, "polar" | "cartesian" | "lobe") {
                let brdf = ui.selectable_value(&mut self.shown, Shown::Brdf, "BRDF");
                brdf.on_hover_text("The reflectance in 1/sr");
                let value = ui.selectable_value(&mut self.shown, Shown::Value, "value");
                value.on_hover_text("The value of the formula for white light: π · BRDF · cos θ of the light");
            }
            if !matches!(view, "furnace" | "reciprocity" | "sphere") {
                ui.checkbox(&mut self.is_log, "log").on_hover_text("Equal distances are equal ratios");
            }
        });
        if view == "slice" {
            ui.checkbox(&mut self.false_colours, "false colours");
        }
    }

    /// Draws the directions of light and viewer.
    fn directions_ui(&mut self, ui: &mut Ui) {
        let has_viewer = self.viewer().is_some();
        match self.view().lights {
            LightUse::Several => self.angles_ui(ui),
            LightUse::All if !has_viewer => {}
            LightUse::One | LightUse::All => {
                ui.label("Light at").on_hover_text("The angle of the light from the normal");
                ui.spacing_mut().slider_width = 96.0;
                ui.add(Slider::new(&mut self.angle, 0.0..=STEEPEST).suffix("°").fixed_decimals(0));
            }
            LightUse::Integrated => {}
        }
        let view = self.view().name;
        Grid::new("directions").num_columns(2).show(ui, |ui| {
            if has_viewer {
                let about = "The angle of the viewer from the normal, whose numbers are read out above the chart: positive at the \
                             side of the mirror direction, in the plane of the curves";
                let label = ui.label("Viewer at").on_hover_text(about);
                let field = DragValue::new(&mut self.viewer).range(-STEEPEST..=STEEPEST).speed(0.5).max_decimals(1).suffix("°");
                ui.add(field).labelled_by(label.id);
                ui.end_row();
            }
            let about = "The direction of the light about the normal, from the tangent. Anisotropic models depend on it";
            ui.label("azimuth").on_hover_text(about);
            angle_field(ui, &mut self.azimuth, 360.0);
            ui.end_row();
            if has_viewer || view == "reciprocity" {
                let about = "The angle between the plane of incidence and the plane in which the viewer is";
                ui.label("plane").on_hover_text(about);
                angle_field(ui, &mut self.plane, 360.0);
                ui.end_row();
            }
        });
    }

    /// Draws the coordinates of the surface.
    fn coordinates_ui(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            for (name, number) in ["u", "v"].into_iter().zip(&mut self.coordinates) {
                let label = ui.label(name).on_hover_text("A coordinate of the surface, which the formula reads");
                let field = DragValue::new(number).range(-FARTHEST..=FARTHEST).speed(0.005).max_decimals(4);
                ui.add(field).labelled_by(label.id);
                if !number.is_finite() {
                    *number = 0.0;
                }
            }
        });
    }

    /// Draws the list of angles of the light.
    fn angles_ui(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.label("Light at").on_hover_text("Angles of the light from the normal, each with a curve");
            for angle in &mut self.angles {
                angle_field(ui, angle, STEEPEST);
            }
            let can_grow = self.angles.len() < MOST_ANGLES;
            if ui.add_enabled(can_grow, egui::Button::new("+").small()).on_hover_text("One more angle").clicked() {
                let last = self.angles.last().copied().unwrap_or(0.0);
                self.angles.push((last + 15.0).min(STEEPEST));
            }
            let can_shrink = self.angles.len() > 1;
            if ui.add_enabled(can_shrink, egui::Button::new("−").small()).on_hover_text("One angle fewer").clicked() {
                self.angles.pop();
            }
        });
    }
}

/// An angle from −180 to 180 degrees.
fn turned(angle: f64) -> f64 {
    (angle + 180.0).rem_euclid(360.0) - 180.0
}

/// A field for an angle in degrees.
fn angle_field(ui: &mut Ui, angle: &mut f64, most: f64) {
    let least = if most > 90.0 { -most } else { 0.0 };
    ui.add(DragValue::new(angle).range(least..=most).speed(0.5).max_decimals(1).suffix("°"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_lie_in_the_plane_of_the_viewer_of_a_hit() {
        let mut controls = ChartControls::default();
        controls.look([35.0, 300.0], [20.0, 100.0]);
        let settings = controls.settings();
        assert_eq!(controls.viewer(), Some(20.0));
        assert_eq!((settings.light_polar, settings.light_azimuth), (vec![35.0], -60.0));
        // The curves are at the azimuth of the light + 180 + plane.
        assert_eq!((settings.light_azimuth + 180.0 + settings.plane).rem_euclid(360.0), 100.0);
    }
}
