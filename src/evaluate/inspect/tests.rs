//! Pixels whose light can be worked out by hand.

use super::*;
use crate::lang::source::Source;
use crate::scene::Scene;
use crate::texture::{self, TextureImage};
use crate::workspace::{Assignment, NamedAssignment, Values};
use std::path::PathBuf;

/// A formula on a scene with values, looked into at the one pixel of a picture.
struct Bench {
    formula: Formula,
    world: World,
    values: Values,
    view: View,
}

impl Bench {
    fn new(formula: &str, scene: &str, settings: &[&str]) -> Self {
        let source = Source::new("formula", formula);
        let formula = Formula::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source))).0;
        let source = Source::new("scene", scene);
        let scene = Scene::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source))).0;
        let mut values = Values::defaults(&formula, &scene);
        let given: Vec<_> = settings
            .iter()
            .flat_map(|text| text.parse::<NamedAssignment>().expect("a setting").resolve(values.table()).expect("known names"))
            .collect();
        assert_eq!(values.assign(&given), []);
        Self {
            formula,
            world: World::new(scene, &crate::world::Assets::NONE).expect("no meshes"),
            values,
            view: View::new(1, 1).expect("a size"),
        }
    }

    fn inspector(&self) -> Inspector<'_> {
        Inspector::new(&self.formula, &self.world, self.values.numbers())
    }

    fn inspect(&self) -> Inspection {
        self.inspector().inspect(&self.view, [0, 0]).expect("the one pixel")
    }
}

const LAMBERT: &str = "body_specific; kd: scalar, constraint 0..1, default 0.5;
    formula; DIFFUSE = kd*IL*Cd*max(0, N.L); = (DIFFUSE);";
const PREFETCH_DISTANCE: &str = "camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 30;";

fn near(one: f64, other: f64) {
    assert!((one - other).abs() < 1e-9, "{one} is not {other}");
}

fn alike(one: [f32; 3], other: [f32; 3]) {
    assert!(one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-6), "{one:?} is not {other:?}");
}

#[test]
fn lamberts_law_in_the_middle_of_a_sphere() {
    // The hit is (0, 0, 1), N is z, the light 5 away along (0, 3, 4): N·L is 0.8.
    let scene = format!(
        "bodies; ball: sphere, center <0,0,0>, radius 1, opaque, matte; lights; key: point, <0,3,5>; {PREFETCH_DISTANCE}"
    );
    let bench = Bench::new(LAMBERT, &scene, &["ball.Cd=<0.9, 0.2, 0.1>", "key.ki=0.5"]);
    let inspection = bench.inspect();
    assert_eq!(inspection.rays.len(), 1);
    let hit = inspection.hit(0).expect("a hit");
    near(hit.surface.distance, 4.0);
    near(hit.incidence, 0.0);
    let light = &hit.lights[0];
    assert_eq!(light.visibility, Visibility::Lit);
    near(light.angle, 0.8_f64.acos().to_degrees());
    assert_eq!(light.variables.distance, 5.0);
    alike(light.local, [0.36, 0.08, 0.04]);
    alike(light.contribution, [0.18, 0.04, 0.02]);
    alike(hit.ambient, [0.09, 0.02, 0.01]);
    alike(inspection.rays[0].own, [0.27, 0.06, 0.03]);
    assert_eq!(inspection.total, inspection.rays[0].own);
    assert_eq!((hit.reflected, hit.refracted, hit.crossing), (Onward::Matte, Onward::Opaque, None));

    let instance = bench.inspector().instance(hit, LightId(0)).expect("a light of the scene");
    let [diffuse, result] = instance.lines.as_slice() else { panic!("{instance:?}") };
    assert_eq!(diffuse.name.as_deref(), Some("DIFFUSE"));
    assert_eq!(diffuse.written, "kd*IL*Cd*max(0, N.L)");
    assert_eq!(diffuse.numbers, "0.5*<1, 1, 1>*<0.9, 0.2, 0.1>*max(0, 0.8)");
    assert_eq!(diffuse.value.to_string(), "<0.36, 0.08, 0.04>");
    assert_eq!(diffuse.value, Quantity::Vector(light.local));
    assert_eq!((result.name.as_deref(), result.written.as_str()), (None, "DIFFUSE"));
    assert_eq!(result.numbers, diffuse.value.to_string());
    assert_eq!(bench.inspector().instance(hit, LightId(1)), None);
}

/// A spot at (0, 3, 5) whose axis is turned by this many degrees from the direction to the hit at (0, 0, 1).
fn turned_spot(degrees: f64) -> String {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let [y, z] = [-0.6 * cosine + 0.8 * sine, -0.6 * sine - 0.8 * cosine];
    format!(
        "bodies; ball: sphere, center <0,0,0>, radius 1, opaque, matte;
         lights; key: spot, <0,3,5>, target <0, {}, {}>, angle 20, soft 10; {PREFETCH_DISTANCE}",
        3.0 + y,
        5.0 + z
    )
}

#[test]
fn what_a_light_sends_is_a_factor_of_its_colour() {
    // Half of the way from the edge of the cone to where it is soft: the smooth step is 1/2 there.
    let scene = turned_spot(15.0);
    let settings = ["ball.Cd=<0.9, 0.2, 0.1>", "key.ki=0.5", "ka=0"];
    let bench = Bench::new(LAMBERT, &scene, &settings);
    let inspection = bench.inspect();
    let hit = inspection.hit(0).expect("a hit");
    let light = &hit.lights[0];
    assert_eq!(light.visibility, Visibility::Lit);
    alike(light.sample.radiance, [0.5; 3]);
    assert_eq!(light.sample.weight, 1.0);
    let point = light.sample.point(hit.surface.point).expect("a point");
    assert!(point.abs_diff_eq([0.0, 3.0, 5.0].into(), 1e-9), "{point}");
    alike(light.local, [0.18, 0.04, 0.02]);
    alike(light.contribution, [0.09, 0.02, 0.01]);
    let text = bench.inspector().text(&inspection);
    let lines = "    sample: direction <0, 0.6, 0.8>, point <0, 3, 5>, radiance <0.5, 0.5, 0.5>
    DIFFUSE = kd*IL*Cd*max(0, N.L) = 0.5*<0.5, 0.5, 0.5>*<0.9, 0.2, 0.1>*max(0, 0.8) = <0.18, 0.04, 0.02>
    local = DIFFUSE = <0.18, 0.04, 0.02>
    ki*local = 0.5*<0.18, 0.04, 0.02> = <0.09, 0.02, 0.01>
";
    assert!(text.contains(lines), "{text}");
    // A formula that is not proportional to the colour of the light.
    let bench = Bench::new("formula; = IL*IL*Cd;", &scene, &settings);
    let inspection = bench.inspect();
    let light = &inspection.hit(0).expect("a hit").lights[0];
    alike(light.local, [0.225, 0.05, 0.025]);
    alike(light.contribution, [0.1125, 0.025, 0.0125]);
    alike(inspection.total, light.contribution);
}

#[test]
fn a_direction_of_the_environment_counts_its_share_of_all() {
    // A white environment is drawn evenly from 4π, and a matte surface under all of it has its own colour: the share of
    // a direction is 4π/π.
    let scene =
        format!("bodies; ball: sphere, center <0,0,0>, radius 1, opaque, matte; lights; sky: environment; {PREFETCH_DISTANCE}");
    let bench = Bench::new(LAMBERT, &scene, &["ball.Cd=<0.9, 0.2, 0.1>", "sky.ki=0.5", "ka=0"]);
    let view = bench.view;
    let inspections = (0..64).filter_map(|pass| bench.inspector().inspect(&view.with_pass(pass), [0, 0]));
    let is_lit = |inspection: &Inspection| inspection.hit(0).is_some_and(|hit| hit.lights[0].visibility == Visibility::Lit);
    let inspection = inspections.into_iter().find(is_lit).expect("a pass in which the direction is in front of the ball");
    let hit = inspection.hit(0).expect("a hit");
    let light = &hit.lights[0];
    assert_eq!((light.sample.radiance, light.sample.point(hit.surface.point)), ([1.0; 3], None));
    near(f64::from(light.sample.weight), 4.0);
    let cosine = hit.surface.shading_normal.dot(light.sample.direction) as f32;
    alike(light.local, [0.45, 0.1, 0.05].map(|colour: f32| colour * cosine));
    alike(light.contribution, [0.9, 0.2, 0.1].map(|colour: f32| colour * cosine));
    let text = bench.inspector().text(&inspection);
    let line = format!("    ki*weight*local = 0.5*4*{}", vector_figures(light.local.map(f64::from)));
    assert!(text.contains(&line) && text.contains(", weight 4\n"), "{text}");
}

#[test]
fn a_spot_sends_nothing_outside_of_its_cone() {
    let bench = Bench::new(LAMBERT, &turned_spot(21.0), &["ka=0"]);
    let inspection = bench.inspect();
    let light = &inspection.hit(0).expect("a hit").lights[0];
    assert_eq!((&light.visibility, light.evaluated, light.contribution), (&Visibility::Dark, false, [0.0; 3]));
    let text = bench.inspector().text(&inspection);
    assert!(text.contains("  light `key`: sends nothing here, 36.87° from the normal, distance 5\n  ambient"), "{text}");
}

#[test]
fn each_pass_has_a_sample_of_its_own_and_the_mean_is_that_of_all() {
    let scene = format!(
        "bodies; ball: sphere, center <0,0,0>, radius 1, opaque, matte;
         lights; lamp: sphere, center <0,3,5>, radius 0.5; sun: directional, <0,0,-1>; {PREFETCH_DISTANCE}"
    );
    let bench = Bench::new(LAMBERT, &scene, &["ka=0", "sun.ki=0.25"]);
    let inspector = bench.inspector();
    let colours = inspector.pass_colours(&bench.view, [0, 0], 0..64);
    let mut points = Vec::new();
    for (pass, colour) in colours.iter().enumerate() {
        let inspection = inspector.inspect(&bench.view.with_pass(pass as u32), [0, 0]).expect("the pixel");
        assert_eq!((inspection.pass, inspection.total), (pass as u32, *colour));
        // The ball is smaller than the pixel.
        let Some(hit) = inspection.hit(0) else { continue };
        let [lamp, sun] = hit.lights.as_slice() else { panic!("{:?}", hit.lights) };
        let point = lamp.sample.point(hit.surface.point).expect("a point");
        near(point.distance([0.0, 3.0, 5.0].into()), 0.5);
        points.push(point);
        assert_eq!((sun.sample.point(hit.surface.point), sun.sample.direction), (None, [0.0, 0.0, 1.0].into()));
        let text = inspector.text_of_pass(&inspection);
        assert!(text.starts_with(&format!("pixel (0, 0) in pass {pass}: <")), "{text}");
        assert!(text.contains("    sample: direction <0, 0, 1>\n"), "{text}");
    }
    points.sort_by(|one, other| one.x.total_cmp(&other.x));
    assert!(points.len() > 16 && points.windows(2).all(|pair| pair[0] != pair[1]), "{points:?}");
    let mean = PassColours { colours: colours.clone() }.mean();
    let expected = [0, 1, 2].map(|at| (colours.iter().map(|colour| f64::from(colour[at])).sum::<f64>() / 64.0) as f32);
    alike(mean, expected);
    let text = PassColours { colours: colours[..2].to_vec() }.text([0, 0]);
    let [one, other] = [colours[0], colours[1]].map(|colour| vector_figures(colour.map(f64::from)));
    assert!(text.ends_with(&format!(">, the mean of 2 passes\n  pass 0: {one}\n  pass 1: {other}\n")), "{text}");
    assert_eq!(inspector.pass_colours(&bench.view, [1, 0], 0..4), [[0.0; 3]; 0], "outside the picture");
}

#[test]
fn lights_shine_are_hidden_turned_away_or_out() {
    let scene = format!(
        "bodies; ball: sphere, center <0,0,0>, radius 1;
            far: sphere, center <0,6,7>, radius 0.5; near: sphere, center <0,3,4>, radius 0.5;
         lights; hidden: point, <0,9,10>; away: point, <9,0,1>; out: point, <-3,0,5>; {PREFETCH_DISTANCE}"
    );
    let mut bench = Bench::new(LAMBERT, &scene, &["out.ki=0"]);
    bench.view = bench.view.with_depth(1).expect("a depth");
    let inspection = bench.inspect();
    let hit = inspection.hit(0).expect("a hit");
    let visible: Vec<&Visibility> = hit.lights.iter().map(|light| &light.visibility).collect();
    // The nearer of the two first, though it is declared last.
    assert_eq!(visible, [&Visibility::Shadowed(vec![BodyId(2), BodyId(1)]), &Visibility::Away(Vec::new()), &Visibility::Lit]);
    near(hit.lights[0].angle, 45.0);
    near(hit.lights[1].angle, 90.0);
    assert!(hit.lights[2].local[0] > 0.0);
    assert!(hit.lights.iter().all(|light| light.contribution == [0.0; 3]));
    assert_eq!(inspection.total, hit.ambient);
    assert_eq!((hit.reflected, hit.refracted), (Onward::Depth, Onward::Depth));

    bench.view = bench.view.with_shadows(false);
    let inspection = bench.inspect();
    let lights = &inspection.hit(0).expect("a hit").lights;
    assert!(lights.iter().all(|light| light.visibility == Visibility::Lit));
    assert!(lights[0].contribution[0] > 0.0);
}

#[test]
fn a_mirror_shows_what_is_before_it() {
    // The ray comes in along (3, 0, −4)/5, leaves along (3, 0, 4)/5 and hits the wall 5 away at (3, 0, 4).
    let scene =
        "bodies; mirror: rectangle, <-9,9,0>, <9,9,0>, <9,-9,0>, opaque; wall: rectangle, <3,-9,-9>, <3,9,-9>, <3,9,9>, opaque;
        lights; camera; position <-3,0,4>; gaze <3,0,-4>; up <0,1,0>; fov 30;";
    let settings = ["mirror.Cd=<0.2, 0.2, 0.2>", "mirror.kr=0.5", "wall.Cd=<0.8, 0.4, 0.2>", "wall.kr=0.25", "ka=0.5"];
    let mut bench = Bench::new(LAMBERT, scene, &[&settings[..], &["background=<0.8, 0, 0>"]].concat());
    bench.view = bench.view.with_depth(3).expect("a depth");
    let inspection = bench.inspect();
    let [mirror, wall, back] = inspection.rays.as_slice() else { panic!("{} rays", inspection.rays.len()) };
    assert_eq!([mirror.edge, wall.edge, back.edge], [Edge::Primary, Edge::Reflected, Edge::Reflected]);
    assert_eq!([mirror.depth, wall.depth, back.depth], [1, 2, 3]);
    assert_eq!([mirror.weight, wall.weight, back.weight], [[1.0; 3], [0.5; 3], [0.125; 3]]);
    assert_eq!([mirror.parent, wall.parent, back.parent], [None, Some(0), Some(1)]);
    assert!(wall.ray.origin.length() < 1e-9);
    assert!(wall.ray.direction.abs_diff_eq([0.6, 0.0, 0.8].into(), 1e-12));
    let (at_mirror, at_wall) = (inspection.hit(0).expect("the mirror"), inspection.hit(1).expect("the wall"));
    near(at_mirror.incidence, 0.8_f64.acos().to_degrees());
    near(at_wall.incidence, 0.6_f64.acos().to_degrees());
    near(at_wall.surface.distance, 5.0);
    assert_eq!((at_mirror.reflected, at_wall.reflected), (Onward::Ray(1), Onward::Ray(2)));
    assert_eq!(
        (&back.end, inspection.hit(2)),
        (&End::Miss(InspectedMiss { background: [0.8, 0.0, 0.0], environment: None }), None)
    );
    alike(wall.own, [0.4, 0.2, 0.1]);
    alike(wall.total, [0.6, 0.2, 0.1]);
    alike(wall.contribution, [0.2, 0.1, 0.05]);
    alike(back.contribution, [0.1, 0.0, 0.0]);
    alike(inspection.total, [0.4, 0.2, 0.15]);
}

#[test]
fn glass_bends_rays_by_snells_law() {
    // The ray meets the sphere at (0.6, 0, 0.8): sines of 0.6 outside and 0.6/1.5 inside.
    let scene = "bodies; glass: sphere, center <0,0,0>, radius 1, refractive_index 1.5; lights;
        camera; position <0.6,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 30;";
    let settings = ["glass.kt=0.5", "ka=0", "background=<0.8, 0.4, 0.2>"];
    let mut bench = Bench::new(LAMBERT, scene, &settings);
    bench.view = bench.view.with_depth(3).expect("a depth");
    let inspection = bench.inspect();
    let (outer, inner) = (0.6_f64.asin().to_degrees(), 0.4_f64.asin().to_degrees());
    let entry = inspection.hit(0).expect("the glass");
    near(entry.incidence, outer);
    let Some(Crossing { entering: true, n12, angle: Some(angle) }) = entry.crossing else { panic!("{:?}", entry.crossing) };
    near(n12, 1.0 / 1.5);
    near(angle, inner);
    let Onward::Ray(within) = entry.refracted else { panic!("{:?}", entry.refracted) };
    let exit = inspection.hit(within).expect("the other side");
    near(exit.incidence, inner);
    let Some(Crossing { entering: false, n12, angle: Some(angle) }) = exit.crossing else { panic!("{:?}", exit.crossing) };
    near(n12, 1.5);
    near(angle, outer);
    let Onward::Ray(beyond) = exit.refracted else { panic!("{:?}", exit.refracted) };
    let beyond = &inspection.rays[beyond];
    assert_eq!(beyond.weight, [0.25; 3]);
    near(beyond.ray.direction.angle_between(inspection.rays[0].ray.direction).to_degrees(), 2.0 * (outer - inner));
    alike(inspection.total, [0.2, 0.1, 0.05]);
    // Reflected rays weigh nothing and are there all the same.
    let Onward::Ray(reflected) = entry.reflected else { panic!("{:?}", entry.reflected) };
    assert_eq!((inspection.rays[reflected].weight, inspection.rays[reflected].contribution), ([0.0; 3], [0.0; 3]));
    assert!(inspection.rays[reflected].own[0] > 0.0);
}

#[test]
fn beyond_the_critical_angle_all_is_reflected() {
    // The back of the pane is met at 60°; 1/1.5 is the sine of the critical angle.
    let scene = "bodies; pane: rectangle, <-9,-9,0>, <9,-9,0>, <9,9,0>, refractive_index 1.5; lights;
        camera; position <-1.7320508075688772,0,1>; gaze <1.7320508075688772,0,-1>; up <0,1,0>; fov 30;";
    let bench = Bench::new(LAMBERT, scene, &["pane.kt=0.5", "pane.kr=0.5", "ka=0", "background=<0.8, 0.4, 0.2>"]);
    let inspection = bench.inspect();
    let hit = inspection.hit(0).expect("the pane");
    near(hit.incidence, 60.0);
    assert_eq!(hit.crossing, Some(Crossing { entering: false, n12: 1.5, angle: None }));
    near(hit.crossing.and_then(|crossing| crossing.critical()).expect("dense to thin"), (1.0_f64 / 1.5).asin().to_degrees());
    assert_eq!((hit.reflected, hit.refracted), (Onward::Ray(1), Onward::TotalReflection));
    alike(inspection.total, [0.4, 0.2, 0.1]);
}

#[test]
fn a_ray_past_everything_and_a_pixel_past_the_picture() {
    let bench = Bench::new(LAMBERT, &format!("bodies; lights; {PREFETCH_DISTANCE}"), &["background=<0.1, 0.2, 0.3>"]);
    let inspection = bench.inspect();
    assert_eq!(inspection.rays.len(), 1);
    assert_eq!(inspection.rays[0].end, End::Miss(InspectedMiss { background: [0.1, 0.2, 0.3], environment: None }));
    assert_eq!(inspection.total, [0.1, 0.2, 0.3]);
    assert_eq!(bench.inspector().inspect(&bench.view, [1, 0]), None);
    assert_eq!(bench.inspector().inspect(&bench.view, [0, 1]), None);
}

#[test]
fn the_environment_behind_everything_stands_beside_the_background() {
    let scene = format!("bodies; lights; sky: environment; {PREFETCH_DISTANCE}");
    let settings = ["background=<0.1, 0.2, 0.3>", "sky.ki=0.5", "sky.IL=<1, 0.5, 0>"];
    let bench = Bench::new(LAMBERT, &scene, &settings);
    let inspection = bench.inspect();
    // White, so ½·⟨1, ½, 0⟩ is added.
    alike(inspection.total, [0.6, 0.45, 0.3]);
    let text = bench.inspector().text(&inspection);
    let lines = "  leaves the scene: background <0.1, 0.2, 0.3>
  environment `sky`: ki*IL*radiance = 0.5*<1, 0.5, 0>*<1, 1, 1> = <0.5, 0.25, 0>
  own = <0.1, 0.2, 0.3> + <0.5, 0.25, 0> = <0.6, 0.45, 0.3>
";
    assert!(text.contains(lines), "{text}");
}

#[test]
fn instances_read_like_the_formula() {
    let formula = "body_specific; h: scalar, constraint -9..9, default -2; v: vector, default <-1, 0.5, 0>;
        formula; K = 1.5; EARLY = LATE; LATE = (K - h)^2; TURN = -h^2 + cos(pi);
        SIDE = if(N.L > 0 && gamma < pi, v . N, h); = <LATE, TURN, SIDE> - (v + Cd*(N.v));";
    let scene = format!("bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <0,3,5>; {PREFETCH_DISTANCE}");
    let bench = Bench::new(formula, &scene, &[]);
    let inspection = bench.inspect();
    let instance = bench.inspector().instance(inspection.hit(0).expect("a hit"), LightId(0)).expect("a light");
    let lines: Vec<String> = instance
        .lines
        .iter()
        .map(|line| format!("{} | {} | {} | {}", line.name.as_deref().unwrap_or(""), line.written, line.numbers, line.value))
        .collect();
    assert_eq!(
        lines,
        [
            "K | 1.5 | 1.5 | 1.5",
            "EARLY | LATE | 12.25 | 12.25",
            "LATE | (K - h)^2 | (1.5 - (-2))^2 | 12.25",
            "TURN | -h^2 + cos(pi) | -(-2)^2 + cos(3.142) | 3",
            "SIDE | if(N.L > 0 && gamma < pi, v.N, h) | if(0.8 > 0 && 0 < 3.142, <-1, 0.5, 0>.<0, 0, 1>, -2) | 0",
            " | <LATE, TURN, SIDE> - (v + Cd*(N.v)) | <12.25, 3, 0> - (<-1, 0.5, 0> + <0.8, 0.8, 0.8>*(<0, 0, 1>.<-1, 0.5, 0>)) | <13.25, 2.5, 0>",
        ]
    );
}

#[test]
fn terms_without_weight_add_nothing_and_others_what_they_are() {
    let scene = format!("bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <0,3,5>; {PREFETCH_DISTANCE}");
    let wild = "formula; = Cd/(ka - ka);";
    let inspection = Bench::new(wild, &scene, &["key.ki=0", "ka=0"]).inspect();
    assert_eq!(inspection.total, [0.0; 3]);
    let bench = Bench::new(wild, &scene, &["ball.Cd=<1, 0, 1>"]);
    let inspection = bench.inspect();
    assert!(inspection.total[0].is_infinite() && inspection.total[1].is_nan());
    assert!(bench.inspector().text(&inspection).contains("<inf, NaN, inf>"));
}

#[test]
fn a_formula_that_reads_visible_adds_lights_behind_the_surface_and_in_shadows() {
    let scene = format!(
        "bodies; leaf: rectangle, <-1,-1,1>, <-1,1,1>, <1,1,1>, opaque, matte; stone: sphere, center <0,3,5>, radius 0.5;
         lights; back: point, <3,0,-3>; hidden: point, <0,6,9>; {PREFETCH_DISTANCE}"
    );
    let formula = "formula; THROUGH = 0.5*visible*max(0, -(N.L)); = IL*Cd*(THROUGH + 0.25*(1 - visible));";
    let bench = Bench::new(formula, &scene, &["leaf.Cd=<0.8, 0.4, 0.2>", "ka=0"]);
    let inspection = bench.inspect();
    let hit = inspection.hit(0).expect("a hit");
    let [back, hidden] = hit.lights.as_slice() else { panic!("{} lights", hit.lights.len()) };
    assert_eq!((&back.visibility, back.evaluated, back.variables.visible), (&Visibility::Away(vec![]), true, 1.0));
    assert_eq!((&hidden.visibility, hidden.variables.visible), (&Visibility::Shadowed(vec![BodyId(1)]), 0.0));
    // N·L is −0.8 and 0.8.
    alike(back.contribution, [0.32, 0.16, 0.08]);
    alike(hidden.contribution, [0.2, 0.1, 0.05]);
    alike(inspection.total, [0.52, 0.26, 0.13]);
    let text = bench.inspector().text(&inspection);
    assert!(text.contains("light `back`: behind the surface, 143.1° from the normal, distance 5\n"), "{text}");
    assert!(text.contains("light `hidden`: in the shadow of `stone`, 36.87° from the normal, distance 10\n"), "{text}");
    assert!(text.contains("THROUGH = 0.5*visible*max(0, -(N.L)) = 0.5*1*max(0, -(-0.8)) = 0.4\n"), "{text}");
    assert!(text.contains("own = <0.32, 0.16, 0.08> + <0.2, 0.1, 0.05> + "), "{text}");
}

#[test]
fn what_is_outside_a_cone_and_what_is_infinitely_far_away_is_said() {
    let scene = format!(
        "bodies; ball: sphere, center <0,0,0>, radius 1;
         lights; beam: spot, <0,3,5>, target <0,9,5>, angle 20; sun: directional, <0,-3,-4>; {PREFETCH_DISTANCE}"
    );
    for (formula, dark) in [
        ("formula; = IL*Cd*max(0, N.L);", "sends nothing here"),
        ("formula; = IL*Cd*max(0, N.L)*(0.5 + 0.5*visible);", "radiance 0 here"),
    ] {
        let bench = Bench::new(formula, &scene, &["ball.Cd=<1, 0.5, 0>", "ka=0"]);
        let inspection = bench.inspect();
        let hit = inspection.hit(0).expect("a hit");
        let visible: Vec<&Visibility> = hit.lights.iter().map(|light| &light.visibility).collect();
        assert_eq!(visible, [&Visibility::Dark, &Visibility::Lit]);
        alike(hit.lights[1].contribution, [0.8, 0.4, 0.0]);
        let text = bench.inspector().text(&inspection);
        assert!(text.contains(&format!("light `beam`: {dark}, 36.87° from the normal, distance 5\n")), "{text}");
        assert!(text.contains("light `sun`: 36.87° from the normal, infinitely far away\n"), "{text}");
    }
}

/// The lines of an instance at the pixel of a sphere with a light at 0.8 from the normal, calls with two spaces.
fn instance_lines(formula: &str) -> Vec<String> {
    let scene = format!("bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <0,3,5>; {PREFETCH_DISTANCE}");
    let bench = Bench::new(formula, &scene, &[]);
    let inspection = bench.inspect();
    let instance = bench.inspector().instance(inspection.hit(0).expect("a hit"), LightId(0)).expect("a light");
    let text = |line: &InstanceLine| {
        format!("{} | {} | {} | {}", line.name.as_deref().unwrap_or(""), line.written, line.numbers, line.value)
    };
    let with_calls = |line: &InstanceLine| {
        let calls = line.calls.iter().map(|call| format!("  {}", text(call)));
        [text(line)].into_iter().chain(calls).chain(left_out(line.calls_left_out)).collect::<Vec<_>>()
    };
    instance.lines.iter().flat_map(with_calls).collect()
}

#[test]
fn functions_and_sums_read_as_they_were_typed() {
    let lines = instance_lines(
        "formula; Fade(x, n) = Square(x)^n; Square(x) = x*x; M = Fade(N.L, 2) + Square(0.5);
         LAYERS = sum(i, 1, 3, Square(i)*(N.L)); = Cd*M*LAYERS*Square(N.L);",
    );
    assert_eq!(
        lines,
        [
            "M | Fade(N.L, 2) + Square(0.5) | Fade(0.8, 2) + Square(0.5) | 0.6596",
            "  Fade(0.8, 2) | Square(x)^n | Square(0.8)^2 | 0.4096",
            "  Square(0.5) | x*x | 0.5*0.5 | 0.25",
            "  Square(0.8) | x*x | 0.8*0.8 | 0.64",
            "LAYERS | sum(i, 1, 3, Square(i)*(N.L)) | sum(i, 1, 3, Square(i)*0.8) | 11.2",
            "  Square(1) | x*x | 1*1 | 1",
            "  Square(2) | x*x | 2*2 | 4",
            "  Square(3) | x*x | 3*3 | 9",
            // Its call stands above.
            " | Cd*M*LAYERS*Square(N.L) | <0.8, 0.8, 0.8>*0.6596*11.2*Square(0.8) | <3.782, 3.782, 3.782>",
        ]
    );
}

#[test]
fn chains_of_functions_are_short() {
    // Written out, the result would have 2⁵⁰ factors.
    let chain: String = (0..50).map(|n| format!("f{n}(x) = f{0}(x)*f{0}(x);", n + 1)).collect();
    let lines = instance_lines(&format!("formula; {chain} f50(x) = x; = Cd*f0(N.L);"));
    assert_eq!(lines.len(), 1 + Instance::MOST_CALLS + 1);
    assert_eq!(lines[2], "  f1(0.8) | f2(x)*f2(x) | f2(0.8)*f2(0.8) | 0");
    assert_eq!(lines.last().map(String::as_str), Some("… 19 more calls are left out"));
}

#[test]
fn the_origin_of_nan_in_functions_is_short_too() {
    let chain: String = (0..50).map(|n| format!("f{n}(x) = f{0}(x)*f{0}(x);", n + 1)).collect();
    let formula = format!("formula; {chain} f50(x) = sqrt(x - 1); = Cd*f0(N.L);");
    let scene = format!("bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <0,3,5>; {PREFETCH_DISTANCE}");
    let bench = Bench::new(&formula, &scene, &[]);
    let Some(NanCause::Expression(origin)) = bench.inspector().nan_cause(&bench.inspect()) else { panic!("NaN") };
    let texts = (origin.typed_in.as_deref(), origin.written.as_str(), origin.numbers.as_str());
    assert_eq!(texts, (Some("f50"), "sqrt(x - 1)", "sqrt(-0.2)"));
}

#[test]
fn measured_materials_are_shown_with_their_files() {
    let scene = "bodies; wall: rectangle, <-1,-1,0>, <-1,1,0>, <3,1,0>; lights; key: point, <0,0,9>;
        camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 30;";
    let formula = "formula; = IL*measured(\"gold.bsdf\") + measured(\"gold.bsdf\", N, <1, 0, 0>) + measured(\"gold.bsdf\");";
    let bench = Bench::new(formula, scene, &[]);
    let inspection = bench.inspect();
    let End::Hit(hit) = &inspection.rays[0].end else { panic!("a hit") };
    let instance = bench.inspector().instance(hit, LightId(0)).expect("a light");
    let names: Vec<&str> = instance.lines[0].calls.iter().filter_map(|call| call.name.as_deref()).collect();
    assert_eq!(names, ["measured(\"gold.bsdf\")", "measured(\"gold.bsdf\", <0, 0, 1>, <1, 0, 0>)"]);
    assert_eq!(
        instance.lines[0].written,
        "IL*measured(\"gold.bsdf\") + measured(\"gold.bsdf\", N, <1, 0, 0>) + measured(\"gold.bsdf\")"
    );
}

#[test]
fn colours_of_textures_are_shown_with_their_files() {
    let scene = "bodies; wall: rectangle, <-1,-1,0>, <-1,1,0>, <3,1,0>; lights; key: point, <0,0,9>;
        camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 30;";
    let formula = "body_specific; wood: texture; sky: texture; formula; F(x) = wood(x, 0)*sky(x, x); emission = wood(v, u);
        = IL*F(u) + wood(v, u);";
    let mut bench = Bench::new(formula, scene, &[]);
    // Red at the left and blue at the right, of one row.
    let image = TextureImage::new(2, 1, vec![[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).expect("two texels");
    let number = texture::keep(PathBuf::from("images/flag.png"), image).expect("room");
    let (owner, parameter, _) = bench.values.iter().find(|(_, id, _)| bench.formula.parameter(*id).name == "wood").expect("it");
    bench.values.assign(&[Assignment { owner, parameter, value: [number, 0.0, 0.0] }]);
    let inspection = bench.inspect();
    let End::Hit(hit) = &inspection.rays[0].end else { panic!("a hit") };
    let instance = bench.inspector().instance(hit, LightId(0)).expect("a light");
    // The hit is at u = 1/2, half of both texels, and v = 1/4, the middle of the first.
    let lookups: Vec<(String, String)> = instance
        .lines
        .iter()
        .flat_map(|line| line.calls.iter().map(|call| (call.name.clone().unwrap_or_default(), call.value.to_string())))
        .collect();
    let expected = [
        ("wood(0.25, 0.5) in flag.png", "<1, 0, 0>"),
        ("F(0.5)", "<0.5, 0, 0.5>"),
        ("wood(0.5, 0) in flag.png", "<0.5, 0, 0.5>"),
        ("sky(0.5, 0.5)", "<1, 1, 1>"),
    ];
    assert_eq!(lookups, expected.map(|(name, value)| (name.to_owned(), value.to_owned())));
    let text = bench.inspector().text(&inspection);
    assert!(text.contains("      wood(0.25, 0.5) in flag.png = <1, 0, 0>\n"), "{text}");
}
