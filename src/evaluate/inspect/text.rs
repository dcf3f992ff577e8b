//! An inspection as indented text: rays stand under the hits where they start, indented by two spaces.
//!
//! A ray of weight 0 is one line at the hit where it starts.

use crate::evaluate::inspect::figures::{figures, vector_figures, weight_figures};
use crate::evaluate::inspect::{
    Crossing, End, InspectedEnvironment, InspectedHit, InspectedLight, InspectedMiss, InspectedRay, Inspection, Inspector,
    InstanceLine, Onward, PassColours, Visibility,
};
use crate::formula::equation::weight_parameter;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::variables::Predefined;
use crate::scene::{BodyId, LightKind, Scene};
use crate::trace::Edge;
use crate::world::{INFINITELY_FAR, Side};
use glam::DVec3;

/// The longest line of equal expressions, in characters without its indentation. Longer ones stand below each other.
const WIDTH: usize = 120;

struct InspectionWriter<'w> {
    inspector: &'w Inspector<'w>,
    inspection: &'w Inspection,
    text: String,
    /// Steps of indentation.
    depth: usize,
}

fn scalar(value: f32) -> String {
    figures(f64::from(value))
}

fn colour(light: [f32; 3]) -> String {
    vector_figures(light.map(f64::from))
}

fn vector(vector: DVec3) -> String {
    vector_figures(vector.to_array())
}

fn angle(degrees: f64) -> String {
    format!("{}°", figures(degrees))
}

/// The line that stands for calls that are left out, if there are any.
pub fn left_out(calls: usize) -> Option<String> {
    match calls {
        0 => None,
        1 => Some("… one more call is left out".to_owned()),
        _ => Some(format!("… {calls} more calls are left out")),
    }
}

impl Inspector<'_> {
    /// An inspection of a picture of one pass as text of many lines, its numbers rounded to four digits.
    pub fn text(&self, inspection: &Inspection) -> String {
        self.text_under("", inspection)
    }

    /// An inspection of one of several passes of a picture as text, which says which pass it is.
    pub fn text_of_pass(&self, inspection: &Inspection) -> String {
        self.text_under(&format!(" in pass {}", inspection.pass), inspection)
    }

    fn text_under(&self, pass: &str, inspection: &Inspection) -> String {
        let mut writer = InspectionWriter { inspector: self, inspection, text: String::new(), depth: 0 };
        let [column, row] = inspection.pixel;
        writer.line(&format!("pixel ({column}, {row}){pass}: {}", colour(inspection.total)));
        inspection.rays.iter().filter(|ray| !ray.is_cut()).for_each(|ray| writer.ray(ray));
        writer.text
    }
}

impl PassColours {
    /// The mean, and a line with the colour of each pass, of this pixel.
    pub fn text(&self, [column, row]: [u32; 2]) -> String {
        let (count, mean) = (self.colours.len(), colour(self.mean()));
        let head = format!("pixel ({column}, {row}): {mean}, the mean of {count} passes\n");
        let lines = self.colours.iter().enumerate().map(|(pass, own)| format!("  pass {pass}: {}\n", colour(*own)));
        std::iter::once(head).chain(lines).collect()
    }
}

impl InspectedEnvironment {
    /// What is seen of the environment with its numbers: ki*IL*radiance.
    pub fn text(&self, scene: &Scene) -> String {
        let factors = [scalar(self.intensity), colour(self.colour), colour(self.radiance)].join("*");
        let name = &scene.light(self.light).name;
        format!("environment `{name}`: ki*IL*radiance = {factors} = {}", colour(self.contribution))
    }
}

impl InspectedLight {
    /// That a light sends nothing to the hit. If the formula reads `visible`, its value is added all the same.
    pub fn dark_text(&self) -> &'static str {
        if self.evaluated { "radiance 0 here" } else { "sends nothing here" }
    }

    /// The sample of a light that is more than a point: its direction, its point if it is not infinitely far away, its
    /// radiance and its weight if they are not 1.
    pub fn sample_text(&self, scene: &Scene, hit: &InspectedHit) -> Option<String> {
        if matches!(scene.light(self.light).kind, LightKind::Point(_)) {
            return None;
        }
        let mut text = format!("sample: direction {}", vector(self.sample.direction));
        if let Some(point) = self.sample.point(hit.surface.point) {
            text.push_str(&format!(", point {}", vector(point)));
        }
        if self.sample.radiance != [1.0; 3] {
            text.push_str(&format!(", radiance {}", colour(self.sample.radiance)));
        }
        if self.sample.weight != 1.0 {
            text.push_str(&format!(", weight {}", scalar(self.sample.weight)));
        }
        Some(text)
    }
}

impl InspectionWriter<'_> {
    fn line(&mut self, line: &str) {
        self.text.extend(std::iter::repeat_n("  ", self.depth));
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// Writes `head = one = another = …`. Equal neighbours are written once.
    fn equal(&mut self, head: &str, mut texts: Vec<String>) {
        texts.dedup();
        let whole = format!("{head} = {}", texts.join(" = "));
        if whole.chars().count() <= WIDTH {
            return self.line(&whole);
        }
        let blank = " ".repeat(head.chars().count());
        for (index, text) in texts.iter().enumerate() {
            self.line(&format!("{} = {text}", if index == 0 { head } else { &blank }));
        }
    }

    fn ray(&mut self, ray: &InspectedRay) {
        self.depth = ray.depth as usize - 1;
        let kind = match ray.edge {
            Edge::Primary => "primary ray".to_owned(),
            Edge::Reflected => format!("reflected ray, {}", self.weight(SurfaceTerm::Reflected, ray.factor)),
            Edge::Refracted => format!("refracted ray, {}", self.weight(SurfaceTerm::Refracted, ray.factor)),
        };
        self.line(&format!("{kind}: from {} along {}", vector(ray.ray.origin), vector(ray.ray.direction)));
        self.depth += 1;
        match &ray.end {
            End::Miss(miss) => self.miss(ray, miss),
            End::Hit(hit) => self.hit(ray, hit),
        }
        if ray.edge != Edge::Primary {
            let product = format!("{}*{}", weight_figures(ray.weight), colour(ray.own));
            self.equal("to the pixel: weight*own", vec![product, colour(ray.contribution)]);
        }
    }

    fn miss(&mut self, ray: &InspectedRay, miss: &InspectedMiss) {
        self.line(&format!("leaves the scene: background {}", colour(miss.background)));
        let Some(environment) = &miss.environment else { return };
        self.line(&environment.text(self.inspector.world.scene()));
        let terms = [miss.background, environment.contribution].map(colour);
        self.equal("own", vec![terms.join(" + "), colour(ray.own)]);
    }

    fn hit(&mut self, ray: &InspectedRay, hit: &InspectedHit) {
        let surface = &hit.surface;
        let side = match surface.side {
            Side::Front => "front",
            Side::Back => "back",
        };
        self.line(&format!(
            "hits the {side} of `{}` at {}, distance {}, {} from the normal {}",
            self.inspector.world.scene().body(surface.body).name,
            vector(surface.point),
            figures(surface.distance),
            angle(hit.incidence),
            vector(surface.shading_normal),
        ));
        hit.lights.iter().for_each(|light| self.light(hit, light));
        if self.inspector.formula.surface.get(SurfaceTerm::Ambient).is_some() {
            self.equal("ambient light: ambient", vec![colour(hit.ambient)]);
        } else {
            let body_colour = self.inspector.predefined(Predefined::BodyColour, surface.body.index());
            let [weight, ambient] =
                [Predefined::Ambient, Predefined::AmbientColour].map(|known| self.inspector.predefined(known, 0));
            let product = format!("{}*{}*{}", scalar(weight[0]), colour(body_colour), colour(ambient));
            self.equal("ambient light: ka*Cd*Ia", vec![product, colour(hit.ambient)]);
        }
        if let Some(emission) = hit.emission {
            self.equal("emitted light: emission", vec![colour(emission)]);
        }
        let [reflection, refraction] = hit.weights;
        self.onward("reflected ray", hit, hit.reflected, (SurfaceTerm::Reflected, reflection));
        self.onward("refracted ray", hit, hit.refracted, (SurfaceTerm::Refracted, refraction));
        self.sum(ray, hit);
    }

    fn light(&mut self, hit: &InspectedHit, light: &InspectedLight) {
        let scene = self.inspector.world.scene();
        let name = &scene.light(light.light).name;
        let distance = match light.variables.distance {
            distance if distance < INFINITELY_FAR as f32 => format!("distance {}", scalar(distance)),
            _ => "infinitely far away".to_owned(),
        };
        let position = format!("{} from the normal, {distance}", angle(light.angle));
        let shadow = |bodies: &[BodyId]| {
            let names: Vec<String> = bodies.iter().map(|body| format!("`{}`", scene.body(*body).name)).collect();
            format!("in the shadow of {}, ", names.join(", "))
        };
        let state = match &light.visibility {
            Visibility::Lit => String::new(),
            Visibility::Dark => format!("{}, ", light.dark_text()),
            Visibility::Away(bodies) if light.evaluated && !bodies.is_empty() => {
                format!("behind the surface, {}", shadow(bodies))
            }
            Visibility::Away(_) => "behind the surface, ".to_owned(),
            Visibility::Shadowed(bodies) => shadow(bodies),
        };
        let is_out = light.intensity == 0.0;
        let out = if light.evaluated && is_out { "out, ki = 0, " } else { "" };
        self.line(&format!("light `{name}`: {out}{state}{position}"));
        if !light.evaluated || is_out {
            return;
        }
        self.depth += 1;
        if let Some(line) = light.sample_text(scene, hit) {
            self.line(&line);
        }
        for line in self.inspector.instance(hit, light.light).into_iter().flat_map(|instance| instance.lines) {
            self.instance_line(line);
        }
        let (intensity, local) = (scalar(light.intensity), colour(light.local));
        let (name, product) = match light.sample.weight {
            1.0 => ("ki*local", format!("{intensity}*{local}")),
            weight => ("ki*weight*local", format!("{intensity}*{}*{local}", scalar(weight))),
        };
        self.equal(name, vec![product, colour(light.contribution)]);
        self.depth -= 1;
    }

    fn instance_line(&mut self, line: InstanceLine) {
        let name = line.name.as_deref().unwrap_or("local");
        self.equal(name, vec![line.written, line.numbers, line.value.to_string()]);
        self.depth += 1;
        for call in line.calls {
            self.equal(call.name.as_deref().unwrap_or_default(), vec![call.written, call.numbers, call.value.to_string()]);
        }
        if let Some(line) = left_out(line.calls_left_out) {
            self.line(&line);
        }
        self.depth -= 1;
    }

    /// The weight of a ray with its name: `kr = 0.5`, or that of the macro that gives it.
    fn weight(&self, term: SurfaceTerm, factor: [f32; 3]) -> String {
        let given = self.inspector.formula.surface.get(term).map(|_| term.name());
        let name = given.or_else(|| weight_parameter(term).map(Predefined::name)).unwrap_or_default();
        format!("{name} = {}", weight_figures(factor.map(f64::from)))
    }

    /// The line about a child ray at the hit where it starts.
    fn onward(&mut self, name: &str, hit: &InspectedHit, onward: Onward, (term, factor): (SurfaceTerm, [f32; 3])) {
        let weight = self.weight(term, factor);
        let what = match onward {
            Onward::Matte => "none, the body is matte".to_owned(),
            Onward::Opaque => "none, the body is opaque".to_owned(),
            Onward::TotalReflection => {
                let critical = hit.crossing.and_then(|crossing| crossing.critical()).map_or_else(String::new, angle);
                format!("none, total internal reflection: {} exceeds the critical angle {critical}", angle(hit.incidence))
            }
            Onward::Depth => format!("{weight}, not followed any deeper"),
            Onward::Ray(_) if factor == [0.0; 3] => weight,
            Onward::Ray(child) => {
                let refracted = self.inspection.rays.get(child).is_some_and(|child| child.edge == Edge::Refracted);
                let Some(Crossing { entering, n12, angle: Some(degrees) }) = hit.crossing.filter(|_| refracted) else { return };
                let way = if entering { "entering" } else { "leaving" };
                format!("{weight}, {way} with n12 = {}, {} from the normal", figures(n12), angle(degrees))
            }
        };
        self.line(&format!("{name}: {what}"));
    }

    /// Equation (2) of thesis 4.2.3 with its numbers.
    fn sum(&mut self, ray: &InspectedRay, hit: &InspectedHit) {
        let lights = hit.lights.iter().filter(|light| light.evaluated && light.intensity != 0.0);
        let terms: Vec<String> =
            lights.map(|light| light.contribution).chain([hit.ambient]).chain(hit.emission).map(colour).collect();
        self.equal("own", vec![terms.join(" + "), colour(ray.own)]);
        let mut whole = colour(ray.own);
        for child in [hit.reflected, hit.refracted] {
            if let Onward::Ray(child) = child
                && let Some(child) = self.inspection.rays.get(child).filter(|child| child.factor != [0.0; 3])
            {
                whole.push_str(&format!(" + {}*{}", weight_figures(child.factor.map(f64::from)), colour(child.total)));
            }
        }
        self.equal("E", vec![whole, colour(ray.total)]);
    }
}
