//! The pixel inspector: the ray tree of a pixel, what each ray adds, and the formula with its numbers.

use crate::evaluate::inspect::{
    End, InspectedHit, InspectedLight, Inspection, Inspector, Onward, Visibility, figures, vector_figures,
};
use crate::preview::workshop::Workshop;
use crate::trace::Edge;
use egui::{CollapsingHeader, Color32, Context, Rect, RichText, ScrollArea, Sense, Ui, Window, vec2};

/// The inspector.
#[derive(Default)]
pub(super) struct InspectorPanel {
    /// Whether the inspector is open.
    pub(super) open: bool,
    /// The inspected pixel, and the stamp of its values.
    inspection: Option<(Inspection, u64)>,
}

impl InspectorPanel {
    /// Inspects a pixel.
    pub(super) fn inspect(&mut self, workshop: &Workshop, pixel: [u32; 2]) {
        let Ok(view) = workshop.view() else { return };
        let inspector = Inspector::new(workshop.formula(), workshop.world(), workshop.values().numbers());
        self.inspection = inspector.inspect(&view, pixel).map(|inspection| (inspection, workshop.stamp()));
    }

    /// Draws the inspector with the current values. It first appears in a corner of the picture's pane.
    pub(super) fn ui(&mut self, context: &Context, workshop: &Workshop, pane: Rect) {
        if !self.open {
            return;
        }
        if let Some((inspection, stamp)) = &self.inspection
            && *stamp != workshop.stamp()
        {
            let pixel = inspection.pixel;
            self.inspect(workshop, pixel);
        }
        let mut open = true;
        let window = Window::new("Pixel inspector").open(&mut open).default_size([480.0, 420.0]).resizable(true);
        window.default_pos(pane.min + vec2(16.0, 16.0)).show(context, |ui| match &self.inspection {
            Some((inspection, _)) => tree_ui(ui, workshop, inspection),
            None => {
                ui.label("Click a pixel of the picture to see its rays, what lights them, and the formula with its numbers.");
            }
        });
        self.open = open;
    }
}

/// A square of a colour, as in pictures.
fn swatch(ui: &mut Ui, colour: [f32; 3]) {
    let [red, green, blue] = colour.map(|component| (255.0 * component.clamp(0.0, 1.0)).round() as u8);
    let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
    ui.painter().rect_filled(Rect::from_center_size(rect.center(), vec2(12.0, 12.0)), 2.0, Color32::from_rgb(red, green, blue));
}

fn colour_text(colour: [f32; 3]) -> String {
    format!("<{}>", colour.map(|component| figures(f64::from(component))).join(", "))
}

fn tree_ui(ui: &mut Ui, workshop: &Workshop, inspection: &Inspection) {
    ui.horizontal(|ui| {
        let [x, y] = inspection.pixel;
        ui.strong(format!("Pixel ({x}, {y})"));
        swatch(ui, inspection.total);
        ui.monospace(colour_text(inspection.total));
    });
    ui.separator();
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        for (index, ray) in inspection.rays.iter().enumerate() {
            if ray.parent.is_none() {
                ray_ui(ui, workshop, inspection, index);
            }
        }
    });
}

fn ray_ui(ui: &mut Ui, workshop: &Workshop, inspection: &Inspection, index: usize) {
    let Some(ray) = inspection.rays.get(index) else { return };
    let name = match &ray.end {
        End::Background => "background",
        End::Hit(hit) => workshop.scene().body(hit.body()).name.as_str(),
    };
    let way = match ray.edge {
        Edge::Primary => "seen",
        Edge::Reflected => "reflected",
        Edge::Refracted => "refracted",
    };
    let leads_on = inspection.rays.iter().any(|child| child.parent == Some(index));
    let title = format!("{name}   {way}, weight {}, adds {}", figures(ray.weight), colour_text(sum_below(inspection, index)));
    let title = if ray.weight == 0.0 { RichText::new(title).weak() } else { RichText::new(title) };
    CollapsingHeader::new(title).id_salt(index).default_open(ray.depth == 1).show(ui, |ui| {
        if leads_on {
            ui.weak(format!("{} from this hit itself, the rest from rays that continue", colour_text(ray.contribution)));
        }
        if let End::Hit(hit) = &ray.end {
            hit_ui(ui, workshop, hit);
        }
        let children = inspection.rays.iter().enumerate().filter(|(_, child)| child.parent == Some(index));
        for (child, _) in children {
            ray_ui(ui, workshop, inspection, child);
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

fn hit_ui(ui: &mut Ui, workshop: &Workshop, hit: &InspectedHit) {
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
        swatch(ui, hit.ambient);
        ui.label(format!("ambient {}", colour_text(hit.ambient)));
    });
    for light in &hit.lights {
        light_ui(ui, workshop, hit, light);
    }
}

fn light_ui(ui: &mut Ui, workshop: &Workshop, hit: &InspectedHit, light: &InspectedLight) {
    let scene = workshop.scene();
    let name = &scene.light(light.light).name;
    let state = match &light.visibility {
        Visibility::Lit => colour_text(light.contribution),
        Visibility::Away => "behind the surface".to_owned(),
        Visibility::Shadowed(bodies) => {
            let names: Vec<&str> = bodies.iter().map(|body| scene.body(*body).name.as_str()).collect();
            format!("in the shadow of {}", names.join(", "))
        }
    };
    let title = format!("light {name}, {}°: {state}", figures(light.angle));
    CollapsingHeader::new(title).id_salt(("light", light.light)).show(ui, |ui| {
        let inspector = Inspector::new(workshop.formula(), workshop.world(), workshop.values().numbers());
        let Some(instance) = inspector.instance(hit, light.light) else { return };
        for line in &instance.lines {
            let name = line.name.as_deref().unwrap_or("");
            ui.monospace(format!("{name} = {}", line.written));
            ui.monospace(RichText::new(format!("   = {}", line.numbers)).weak());
            ui.monospace(format!("   = {}", line.value));
        }
        ui.monospace(format!(
            "times ki {}: {}",
            figures(f64::from(light.intensity)),
            vector_figures(light.contribution.map(f64::from))
        ));
    });
}
