//! The pixel inspector: the ray tree of a pixel, what each ray adds, and the formula with its numbers. If the picture
//! is the mean of several passes, it shows the mean, the colours of all of them and the rays of the first, or those of
//! one.

use crate::evaluate::inspect::{
    End, InspectedHit, InspectedLight, InspectedMiss, Inspection, Inspector, InstanceLine, Onward, PassColours, Visibility,
    figures, left_out, vector_figures, weight_figures,
};
use crate::preview::app::colours::{paint_swatch, shown_colour};
use crate::preview::app::instruments::InstrumentPlace;
use crate::preview::app::pane::Placement;
use crate::preview::app::panel_sizes::{remember, wanted_size};
use crate::preview::app::pixel_dependence::{OwnedParameter, PixelDependence};
use crate::preview::workshop::Workshop;
use crate::scene::BodyId;
use crate::trace::Edge;
use crate::user_data::settings::{PanelSide, PanelSizes};
use egui::{
    Align, CollapsingHeader, Color32, DragValue, Id, Label, Layout, Panel, Rect, RichText, ScrollArea, Sense, Stroke, StrokeKind,
    Ui, vec2,
};
use std::time::{Duration, Instant};

/// The inspector.
#[derive(Default)]
pub(super) struct InspectorPanel {
    /// Whether the inspector is open.
    pub(super) open: bool,
    /// How many passes are traced, and how many there will be; 0 counts as 1.
    passes: [u32; 2],
    /// The pass whose rays are shown; `None`: the mean. With one pass, its rays are shown.
    shown_pass: Option<u32>,
    inspected: Option<InspectedPixel>,
    /// A hit and a light that the instruments shall show.
    place: Option<InstrumentPlace>,
    dependence: PixelDependence,
}

/// The inspected pixel.
struct InspectedPixel {
    /// The stamp of its values.
    stamp: u64,
    /// Its rays in the shown pass; in the first one if the mean is shown.
    inspection: Inspection,
    /// Its colours in the passes from the first one on, as far as they are known.
    colours: PassColours,
}

impl InspectorPanel {
    /// Sets how many passes of the picture in view are traced, and how many there will be.
    pub(super) fn set_passes(&mut self, passes: [u32; 2]) {
        self.passes = passes;
        let last = passes[1].saturating_sub(1);
        self.shown_pass = self.shown_pass.map(|pass| pass.min(last));
    }

    /// Whether the picture is, or will be, the mean of several passes.
    fn has_several_passes(&self) -> bool {
        self.passes[1] > 1
    }

    /// Whether the colours of all passes are shown, not the rays of one.
    fn shows_mean(&self) -> bool {
        self.has_several_passes() && self.shown_pass.is_none()
    }

    /// A hit and a light that the instruments shall show, once.
    pub(super) fn take_place(&mut self) -> Option<InstrumentPlace> {
        self.place.take()
    }

    /// Inspects a pixel.
    pub(super) fn inspect(&mut self, workshop: &Workshop, pixel: [u32; 2]) {
        let Ok(view) = workshop.view() else { return };
        let (stamp, pass) = (workshop.stamp(), self.shown_pass.unwrap_or(0));
        let inspection = inspector_of(workshop).inspect(&view.with_pass(pass), pixel);
        let known = self.inspected.take().filter(|before| before.stamp == stamp && before.inspection.pixel == pixel);
        self.inspected = inspection.map(|inspection| {
            let colours = known.map(|known| known.colours).unwrap_or_default();
            InspectedPixel { stamp, inspection, colours }
        });
    }

    /// Finds out more colours of the passes, for a short time. They are found on this thread, because the others may be
    /// tracing. Returns whether all are known.
    fn find_colours(&mut self, workshop: &Workshop) -> bool {
        /// A frame may take this much longer.
        const LONGEST: Duration = Duration::from_millis(4);
        let (passes, start) = (self.passes[0].max(1) as usize, Instant::now());
        let (Some(pixel), Ok(view)) = (&mut self.inspected, workshop.view()) else { return true };
        let inspector = inspector_of(workshop);
        let PassColours { colours } = &mut pixel.colours;
        while colours.len() < passes && start.elapsed() < LONGEST {
            let Some(found) = inspector.inspect(&view.with_pass(colours.len() as u32), pixel.inspection.pixel) else { break };
            colours.push(found.total);
        }
        colours.truncate(passes);
        colours.len() == passes
    }

    /// Marks the inspected pixel in the picture: a frame around it, with four ticks that also show where the pixel is
    /// small.
    pub(super) fn mark(&self, ui: &Ui, placement: &Placement, pane: Rect) {
        /// The least half width of the frame and the length of the ticks, in points.
        const HALF: f32 = 4.0;
        const TICK: f32 = 7.0;
        let Some(InspectedPixel { inspection, .. }) = self.inspected.as_ref().filter(|_| self.open) else { return };
        let [x, y] = inspection.pixel.map(|coordinate| coordinate as f32);
        let pixel = Rect::from_min_max(placement.position_of([x, y]), placement.position_of([x + 1.0, y + 1.0]));
        let frame = Rect::from_center_size(pixel.center(), (pixel.size() + vec2(2.0, 2.0)).max(vec2(2.0 * HALF, 2.0 * HALF)));
        let ticks = [
            (frame.center_top(), vec2(0.0, -TICK)),
            (frame.center_bottom(), vec2(0.0, TICK)),
            (frame.left_center(), vec2(-TICK, 0.0)),
            (frame.right_center(), vec2(TICK, 0.0)),
        ];
        let painter = ui.painter_at(pane);
        // Dark under light shows on every picture.
        for stroke in [Stroke::new(3.0, Color32::from_black_alpha(170)), Stroke::new(1.0, Color32::WHITE)] {
            painter.rect_stroke(frame, 0.0, stroke, StrokeKind::Middle);
            for (from, along) in ticks {
                painter.line_segment([from, from + along], stroke);
            }
        }
    }

    /// Draws the inspector below the picture, with the current values. `of` is the parameter that was moved
    /// last.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        workshop: &Workshop,
        (of, most): (Option<OwnedParameter>, f32),
        sizes: &mut PanelSizes,
    ) {
        if !self.open {
            return;
        }
        if let Some(InspectedPixel { stamp, inspection, .. }) = &self.inspected
            && (*stamp != workshop.stamp() || inspection.pass != self.shown_pass.unwrap_or(0))
        {
            let pixel = inspection.pixel;
            self.inspect(workshop, pixel);
        }
        if self.shows_mean() && !self.find_colours(workshop) {
            ui.ctx().request_repaint();
        }
        // Half of the room is for the picture.
        let most = most.min(0.5 * ui.available_height()).max(LEAST_HEIGHT);
        let id = Id::new("inspector");
        let size = wanted_size(ui.ctx(), id, PanelSide::Inspector, sizes);
        let panel = Panel::bottom(id).resizable(true).default_size(size);
        panel.size_range(LEAST_HEIGHT..=most).show(ui, |ui| {
            let close = self.header_ui(ui, workshop);
            ui.separator();
            match &self.inspected {
                Some(InspectedPixel { inspection, colours, .. }) => {
                    self.dependence.ui(ui, workshop, inspection, of);
                    let chosen = if self.shows_mean() { passes_ui(ui, workshop, colours) } else { None };
                    tree_ui(ui, workshop, inspection, &mut self.place);
                    self.shown_pass = chosen.or(self.shown_pass);
                }
                None => {
                    ui.label("Click a pixel of the picture to see its rays, what lights them, and the formula with its numbers.");
                    ui.allocate_space(ui.available_size());
                }
            }
            self.open &= !close;
        });
        remember(ui.ctx(), id, PanelSide::Inspector, sizes);
    }

    /// Draws the title, the colour of the pixel, the chooser of passes, and the button that closes the inspector.
    /// Returns whether it was clicked.
    fn header_ui(&mut self, ui: &mut Ui, workshop: &Workshop) -> bool {
        let mut close = false;
        ui.horizontal(|ui| {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                close = ui.small_button("×").on_hover_text("Close the pixel inspector (F5)").clicked();
                if self.has_several_passes()
                    && let Some(InspectedPixel { colours, .. }) = &self.inspected
                {
                    let known = colours.colours.len();
                    self.chooser_ui(ui, known);
                    ui.separator();
                }
                // The rest of the row, which is shortened if it is too long.
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    let Some(InspectedPixel { inspection, colours, .. }) = &self.inspected else {
                        ui.strong("Pixel inspector");
                        return;
                    };
                    let [x, y] = inspection.pixel;
                    ui.strong(format!("Pixel ({x}, {y})"));
                    let colour = if self.shows_mean() { colours.mean() } else { inspection.total };
                    swatch(ui, workshop, colour);
                    ui.add(Label::new(RichText::new(colour_text(colour)).monospace()).truncate());
                });
            });
        });
        close
    }

    /// Draws the choice between the mean of the passes whose colours are known, and one of all passes, from right to
    /// left.
    fn chooser_ui(&mut self, ui: &mut Ui, known: usize) {
        let (last, is_mean) = (self.passes[1].saturating_sub(1), self.shows_mean());
        let mut pass = self.shown_pass.unwrap_or(0);
        let field = ui.add(DragValue::new(&mut pass).range(0..=last).speed(0.1).update_while_editing(false));
        let one = ui.selectable_label(!is_mean, "Pass").on_hover_text("The rays of one pass, counted from 0");
        if field.changed() || one.clicked() {
            self.shown_pass = Some(pass);
        }
        let mean = ui.selectable_label(is_mean, if is_mean { format!("Mean of {known}") } else { "Mean".to_owned() });
        if mean.on_hover_text("The colour of the pixel is the mean of its colours in all passes").clicked() {
            self.shown_pass = None;
        }
    }
}

/// The inspector of what is open.
fn inspector_of(workshop: &Workshop) -> Inspector<'_> {
    Inspector::new(workshop.formula(), workshop.world(), workshop.values().numbers())
}

/// The least height of the inspector, in points.
const LEAST_HEIGHT: f32 = 100.0;

/// A square of a colour, as in pictures.
fn swatch(ui: &mut Ui, workshop: &Workshop, colour: [f32; 3]) {
    let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
    paint_swatch(ui, rect, shown_colour(workshop.settings().view, colour));
}

fn colour_text(colour: [f32; 3]) -> String {
    format!("<{}>", colour.map(|component| figures(f64::from(component))).join(", "))
}

/// Draws a list of the colours of all passes, which can be opened, and the title of the rays of the first. Returns the
/// pass that is clicked.
fn passes_ui(ui: &mut Ui, workshop: &Workshop, colours: &PassColours) -> Option<u32> {
    let mut chosen = None;
    let (height, most) = (ui.spacing().interact_size.y, 0.5 * ui.available_height());
    CollapsingHeader::new("Colours of the passes").show(ui, |ui| {
        let list = ScrollArea::vertical().auto_shrink([false, true]).max_height(most);
        list.show_rows(ui, height, colours.colours.len(), |ui, rows| {
            for pass in rows {
                ui.horizontal(|ui| {
                    ui.set_min_height(height);
                    swatch(ui, workshop, colours.colours[pass]);
                    let link = ui.link(format!("pass {pass}"));
                    if link.on_hover_text("Show the rays of this pass").clicked() {
                        chosen = Some(pass as u32);
                    }
                    ui.monospace(colour_text(colours.colours[pass]));
                });
            }
        });
    });
    ui.weak("The rays of pass 0:");
    chosen
}

fn tree_ui(ui: &mut Ui, workshop: &Workshop, inspection: &Inspection, place: &mut Option<InstrumentPlace>) {
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        for (index, ray) in inspection.rays.iter().enumerate() {
            if ray.parent.is_none() {
                ray_ui(ui, workshop, (inspection, index), place);
            }
        }
    });
}

fn ray_ui(ui: &mut Ui, workshop: &Workshop, (inspection, index): (&Inspection, usize), place: &mut Option<InstrumentPlace>) {
    let Some(ray) = inspection.rays.get(index) else { return };
    let name = match &ray.end {
        End::Miss(InspectedMiss { environment: None, .. }) => "background",
        End::Miss(InspectedMiss { environment: Some(_), .. }) => "environment and background",
        End::Hit(hit) => workshop.scene().body(hit.body()).name.as_str(),
    };
    let way = match ray.edge {
        Edge::Primary => "seen",
        Edge::Reflected => "reflected",
        Edge::Refracted => "refracted",
    };
    let leads_on = inspection.rays.iter().any(|child| child.parent == Some(index));
    let title =
        format!("{name}   {way}, weight {}, adds {}", weight_figures(ray.weight), colour_text(sum_below(inspection, index)));
    let title = if ray.is_cut() { RichText::new(title).weak() } else { RichText::new(title) };
    CollapsingHeader::new(title).id_salt(index).default_open(ray.depth == 1).show(ui, |ui| {
        if leads_on {
            ui.weak(format!("{} from this hit itself, the rest from rays that continue", colour_text(ray.contribution)));
        }
        match &ray.end {
            End::Hit(hit) => hit_ui(ui, workshop, (inspection.pixel, hit), place),
            End::Miss(miss) => miss_ui(ui, workshop, miss),
        }
        let children = inspection.rays.iter().enumerate().filter(|(_, child)| child.parent == Some(index));
        for (child, _) in children {
            ray_ui(ui, workshop, (inspection, child), place);
        }
    });
}

/// What a ray and all rays that continue it add to the pixel.
fn sum_below(inspection: &Inspection, index: usize) -> [f32; 3] {
    let own = inspection.rays.get(index).map_or([0.0; 3], |ray| ray.contribution);
    // Rays come after those that they continue, so this ends.
    let children = (index + 1..inspection.rays.len()).filter(|child| inspection.rays[*child].parent == Some(index));
    children.fold(own, |sum, child| {
        let below = sum_below(inspection, child);
        [0, 1, 2].map(|component| sum[component] + below[component])
    })
}

fn miss_ui(ui: &mut Ui, workshop: &Workshop, miss: &InspectedMiss) {
    ui.horizontal(|ui| {
        swatch(ui, workshop, miss.background);
        ui.label(format!("background {}", colour_text(miss.background)));
    });
    if let Some(environment) = &miss.environment {
        ui.horizontal(|ui| {
            swatch(ui, workshop, environment.contribution);
            ui.label(environment.text(workshop.scene()));
        });
    }
}

fn hit_ui(ui: &mut Ui, workshop: &Workshop, (pixel, hit): ([u32; 2], &InspectedHit), place: &mut Option<InstrumentPlace>) {
    let mut facts = format!("{}° from the normal", figures(hit.incidence));
    if let Some(crossing) = &hit.crossing {
        facts.push_str(&format!(
            ", {}, n12 = {}",
            if crossing.entering { "from outside" } else { "from inside" },
            figures(crossing.n12)
        ));
    }
    for (name, onward) in [("reflected", hit.reflected), ("refracted", hit.refracted)] {
        let why = match onward {
            Onward::Ray(_) => continue,
            Onward::Matte => "the body is matte",
            Onward::Opaque => "the body is opaque",
            Onward::TotalReflection => "total reflection",
            Onward::Depth => "the depth limit",
        };
        facts.push_str(&format!("; not {name}: {why}"));
    }
    ui.weak(facts);
    ui.horizontal(|ui| {
        swatch(ui, workshop, hit.ambient);
        ui.label(format!("ambient {}", colour_text(hit.ambient)));
    });
    if let Some(emission) = hit.emission {
        ui.horizontal(|ui| {
            swatch(ui, workshop, emission);
            ui.label(format!("emission {}", colour_text(emission)));
        });
    }
    for light in &hit.lights {
        if light_ui(ui, workshop, hit, light) {
            *place = Some(InstrumentPlace::new(pixel, hit, light));
        }
    }
}

/// Draws what a light does at a hit. Returns whether the instruments shall show it.
fn light_ui(ui: &mut Ui, workshop: &Workshop, hit: &InspectedHit, light: &InspectedLight) -> bool {
    let scene = workshop.scene();
    let name = &scene.light(light.light).name;
    let shadow = |bodies: &[BodyId]| {
        let names: Vec<&str> = bodies.iter().map(|body| scene.body(*body).name.as_str()).collect();
        format!("in the shadow of {}", names.join(", "))
    };
    let position = match &light.visibility {
        Visibility::Lit => None,
        Visibility::Dark => Some(light.dark_text().to_owned()),
        Visibility::Away(bodies) if light.evaluated && !bodies.is_empty() => {
            Some(format!("behind the surface, {}", shadow(bodies)))
        }
        Visibility::Away(_) => Some("behind the surface".to_owned()),
        Visibility::Shadowed(bodies) => Some(shadow(bodies)),
    };
    let added = light.evaluated.then(|| colour_text(light.contribution));
    let state = added.into_iter().chain(position).collect::<Vec<_>>().join(", ");
    let title = format!("light {name}, {}°: {state}", figures(light.angle));
    let mut is_wanted = false;
    CollapsingHeader::new(title).id_salt(("light", light.light)).show(ui, |ui| {
        let link = ui.link("Show in the instruments");
        is_wanted = link.on_hover_text("Charts of the formula here, for these directions of light and viewer").clicked();
        if let Some(sample) = light.sample_text(scene, hit) {
            ui.monospace(sample);
        }
        let Some(instance) = inspector_of(workshop).instance(hit, light.light) else { return };
        for line in &instance.lines {
            line_ui(ui, line, "");
            line.calls.iter().for_each(|call| line_ui(ui, call, "   "));
            if let Some(text) = left_out(line.calls_left_out) {
                ui.monospace(format!("   {text}"));
            }
        }
        let weight = match light.sample.weight {
            1.0 => String::new(),
            weight => format!(" and the weight {}", figures(f64::from(weight))),
        };
        ui.monospace(format!(
            "times ki {}{weight}: {}",
            figures(f64::from(light.intensity)),
            vector_figures(light.contribution.map(f64::from))
        ));
    });
    is_wanted
}

/// Draws a macro, the result or a call behind this indentation.
fn line_ui(ui: &mut Ui, line: &InstanceLine, indent: &str) {
    let name = line.name.as_deref().unwrap_or("");
    let value = line.value.to_string();
    ui.monospace(format!("{indent}{name} = {}", line.written));
    if line.written == value {
        // The colour of a texture has no expression.
        return;
    }
    ui.monospace(RichText::new(format!("{indent}   = {}", line.numbers)).weak());
    ui.monospace(format!("{indent}   = {value}"));
}
