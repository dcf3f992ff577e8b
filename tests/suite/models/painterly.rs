//! Grounds of planets, sheets that send light back, shades of drawings, solid patterns, lights in physical units.

use super::{Hit, Model, SINGLE, Triple, direction, dot, hemisphere, near, normalize, sound_in_all_corners};
use std::f64::consts::PI;

const UP: Triple = [0.0, 0.0, 1.0];
const WHITE: &[f64] = &[1.0, 1.0, 1.0];
const BLACK: &[f64] = &[0.0, 0.0, 0.0];

/// Values of parameters by name: one number, or the three of a vector.
type Given<'a> = &'a [(&'a str, &'a [f64])];

/// A built-in formula with values of some parameters.
fn model(name: &str, given: Given) -> Model {
    let mut model = Model::built_in(name);
    for (name, value) in given {
        model.assign(name, [0, 1, 2].map(|component| value[component.min(value.len() - 1)]));
    }
    model
}

#[track_caller]
fn close(found: f64, wanted: f64) {
    near(found, wanted, SINGLE);
}

#[track_caller]
fn all_close(found: Triple, wanted: Triple) {
    (0..3).for_each(|channel| close(found[channel], wanted[channel]));
}

/// Asserts that light and viewer may be exchanged, at slanted directions.
#[track_caller]
fn reciprocal(model: &Model) {
    for (light, viewer) in [((20.0, 0.0), (60.0, 130.0)), ((5.0, 40.0), (80.0, 220.0)), ((45.0, 10.0), (50.0, 15.0))] {
        let hit = Hit::new(direction(light.0, light.1), direction(viewer.0, viewer.1));
        let one_way = model.shade(&hit).map(|colour| colour / hit.light[2]);
        all_close(one_way, model.shade(&hit.swapped()).map(|colour| colour / hit.viewer[2]));
    }
}

#[test]
fn models_are_sound_with_all_sliders_at_their_ends() {
    for name in ["lommel-seeliger", "hapke", "retroreflection", "gooch", "toon", "marble", "wood", "physical-lights"] {
        sound_in_all_corners(name);
    }
}

#[test]
fn the_full_moon_is_flat() {
    let moon = model("lommel-seeliger", &[("Cd", &[0.8, 0.4, 0.16]), ("xi", &[-0.2])]);
    // p(0) = 0.96/0.8^3 = 1.875, so I/F = w/8*1.875, whatever the slant.
    for angle in [0.0, 30.0, 60.0, 85.0] {
        let both = direction(angle, 70.0);
        all_close(moon.shade(&Hit::new(both, both)), [0.1875, 0.09375, 0.0375]);
    }
    // Lambert's part: the same, times the cosine.
    let both = direction(60.0, 0.0);
    let lambert = model("lommel-seeliger", &[("Cd", WHITE), ("xi", &[-0.2]), ("l", &[0.0])]);
    close(lambert.shade(&Hit::new(both, both))[0], 0.117_187_5);
}

#[test]
fn lommel_and_seeliger_obey_their_closed_forms() {
    let even = model("lommel-seeliger", &[("Cd", WHITE), ("xi", &[0.0])]);
    // The share sent back for w = 1: (1 - m ln((1 + m)/m))/2, m the cosine of the light's angle.
    for angle in [0.0, 50.0, 75.0_f64] {
        let m = angle.to_radians().cos();
        near(even.albedo(angle, 40)[0], (1.0 - m * ((1.0 + m) / m).ln()) / 2.0, 1e-3);
    }
    reciprocal(&model("lommel-seeliger", &[("Cd", WHITE), ("xi", &[0.4]), ("l", &[0.7])]));
    // Seeliger's law of the phases of a ball: 1 - sin(a/2) tan(a/2) ln cot(a/4).
    let whole = |phase: f64| {
        let light = direction(phase, 0.0);
        let seen = |normal: Triple| {
            // The same angles around a normal of +z: light and viewer by their cosines and the angle between them.
            let (lit, slant) = (dot(normal, light), normal[2]);
            if lit <= 0.0 {
                return [0.0; 3];
            }
            let sines = ((1.0 - lit * lit) * (1.0 - slant * slant)).sqrt().max(1e-12);
            let azimuth = ((light[2] - lit * slant) / sines).clamp(-1.0, 1.0).acos().to_degrees();
            let hit = Hit::new(direction(lit.acos().to_degrees(), azimuth), direction(slant.acos().to_degrees(), 0.0));
            even.shade(&hit).map(|colour| colour * slant)
        };
        hemisphere(60, seen)[0]
    };
    let full = whole(0.0);
    for phase in [30.0, 60.0, 90.0, 120.0_f64] {
        let half = phase.to_radians() / 2.0;
        let expected = 1.0 - half.sin() * half.tan() * (1.0 / (half / 2.0).tan()).ln();
        near(whole(phase) / full, expected, 4e-3);
    }
}

#[test]
fn hapke_agrees_with_numbers_in_double_precision() {
    let given: Given = &[("Cd", &[0.36]), ("B0", &[1.0]), ("h", &[0.06]), ("b", &[0.25]), ("c", &[0.5]), ("H2002", &[0.0])];
    let mut soil = model("hapke", given);
    // By a script in double precision: sqrt(1 - w) = 0.8, H(1) = 3/2.6, p(0) = 1.6266667.
    close(soil.shade(&Hit::new(UP, UP))[0], 0.175_711_24);
    // Light at 20 degrees and viewer at 40 degrees on the other side: the phase angle is 60 degrees.
    close(soil.shade(&Hit::new(direction(20.0, 0.0), direction(40.0, 180.0)))[0], 0.075_832_62);
    // The opposition effect has half its height where tan(g/2) = h.
    close(soil.value("B", &Hit::new(UP, UP))[0], 1.0);
    let g = 2.0 * 0.06_f64.atan();
    close(soil.value("B", &Hit::new(direction(g.to_degrees(), 0.0), UP))[0], 0.5);
    for h2002 in [0.0, 1.0] {
        reciprocal(&model("hapke", &[("Cd", &[0.9, 0.5, 0.1]), ("b", &[0.4]), ("c", &[-0.3]), ("H2002", &[h2002])]));
    }
}

/// Chandrasekhar's function H for a single-scattering albedo, from its integral equation by iteration.
fn chandrasekhar(albedo: f64, cosine: f64) -> f64 {
    const STEPS: usize = 100;
    let node = |index: usize| (index as f64 + 0.5) / STEPS as f64;
    let root = (1.0 - albedo).sqrt();
    let integral = |table: &[f64], x: f64| {
        let part = |(index, value): (usize, &f64)| node(index) * value / (x + node(index));
        table.iter().enumerate().map(part).sum::<f64>() / STEPS as f64
    };
    let mut table = vec![1.0; STEPS];
    for _ in 0..40 {
        let next: Vec<f64> = (0..STEPS).map(|index| 1.0 / (root + albedo / 2.0 * integral(&table, node(index)))).collect();
        // The mean of two steps converges where the step alone goes to and fro.
        table = table.iter().zip(next).map(|(old, new)| f64::midpoint(*old, new)).collect();
    }
    1.0 / (root + albedo / 2.0 * integral(&table, cosine))
}

#[test]
fn hapkes_h_is_near_the_exact_one() {
    // Chandrasekhar (1950), table XI: H(1) = 2.9078 for w = 1.
    near(chandrasekhar(1.0, 1.0), 2.9078, 2e-3);
    // Light and viewer at one place, b = 0 and B0 = 0: 8 times the colour, divided by w, is H(m)^2.
    for (switch, tolerance) in [(0.0, 0.045), (1.0, 0.011)] {
        for albedo in [0.2, 0.6, 0.9, 1.0] {
            let soil = model("hapke", &[("Cd", &[albedo]), ("B0", &[0.0]), ("b", &[0.0]), ("H2002", &[switch])]);
            for angle in [0.0, 60.0, 84.0_f64] {
                let both = direction(angle, 0.0);
                let found = (8.0 * soil.shade(&Hit::new(both, both))[0] / albedo).sqrt();
                let exact = chandrasekhar(albedo, angle.to_radians().cos());
                assert!((found / exact - 1.0).abs() < tolerance, "w {albedo}, {angle} degrees: {found}, exactly {exact}");
            }
        }
    }
}

#[test]
fn hapkes_grains_that_lose_no_light_send_all_of_it_back() {
    let snow = model("hapke", &[("Cd", &[1.0, 0.75, 0.0]), ("B0", &[0.0]), ("b", &[0.0])]);
    for angle in [0.0, 45.0, 70.0_f64] {
        let share = snow.albedo(angle, 30);
        near(share[0], 1.0, 0.015);
        // The share is 1 - sqrt(1 - w) H(m).
        near(share[1], 1.0 - 0.5 * chandrasekhar(0.75, angle.to_radians().cos()), 0.015);
        close(share[2], 0.0);
    }
}

/// Walter's GGX with Smith's masking and Schlick's Fresnel for a reflectance of `f0`: the BRDF times π.
fn ggx(light: Triple, viewer: Triple, rough: f64, f0: f64) -> f64 {
    let half = normalize([0, 1, 2].map(|axis| light[axis] + viewer[axis]));
    let a2 = rough * rough;
    let d = a2 / (PI * (half[2] * half[2] * (a2 - 1.0) + 1.0).powi(2));
    let g = |direction: Triple| {
        let tangent2 = 1.0 / direction[2].powi(2) - 1.0;
        2.0 / (1.0 + (1.0 + a2 * tangent2).sqrt())
    };
    let f = f0 + (1.0 - f0) * (1.0 - dot(half, viewer)).powi(5);
    PI * d * g(light) * g(viewer) * f / (4.0 * light[2] * viewer[2])
}

/// A direction on the other side of +z.
fn opposite(direction: Triple) -> Triple {
    [-direction[0], -direction[1], direction[2]]
}

#[test]
fn retroreflection_is_a_mirror_lobe_turned_back() {
    let lobe_with = |sheet: f64| {
        model("retroreflection", &[("kd", &[0.0]), ("kb", &[1.0]), ("rough", &[0.2]), ("F0", &[0.5]), ("sheet", &[sheet])])
    };
    let lobe = lobe_with(0.0);
    // Straight on: F0/(4 rough^2) = 0.5/0.16.
    close(lobe.shade(&Hit::new(UP, UP))[0], 3.125);
    for (light, viewer) in [((30.0, 0.0), (30.0, 0.0)), ((50.0, 20.0), (40.0, 25.0)), ((70.0, 0.0), (20.0, 180.0))] {
        let (light, viewer) = (direction(light.0, light.1), direction(viewer.0, viewer.1));
        close(lobe.shade(&Hit::new(light, viewer))[0] / light[2], ggx(opposite(light), viewer, 0.2, 0.5));
    }
    reciprocal(&lobe);
    reciprocal(&model(
        "retroreflection",
        &[("kd", &[0.2]), ("kb", &[0.8]), ("rough", &[0.3]), ("F0", &[0.3]), ("sheet", &[1.0])],
    ));
    // Light and viewer at 30 degrees on a sheet of beads: exp(-900/2220) for each.
    let both = Hit::new(direction(30.0, 0.0), direction(30.0, 0.0));
    close(lobe_with(1.0).shade(&both)[0] / lobe.shade(&both)[0], (-1800.0 / 2220.0_f64).exp());
}

#[test]
fn retroreflection_adds_no_light() {
    for rough in [0.2, 0.5, 1.0] {
        let mut lobe = model("retroreflection", &[("kd", &[0.0]), ("kb", &[1.0]), ("rough", &[rough]), ("F0", WHITE)]);
        // For a back vector b choose V = b and L so that R = b: D cos integrates to 1.
        let shape = |b: Triple| lobe.value("D", &Hit::new(opposite(b), b)).map(|d| d * b[2]);
        near(hemisphere(48, shape)[0], 1.0, 3e-3);
        for angle in [0.0, 40.0, 75.0] {
            let share = lobe.albedo(angle, 40)[0];
            assert!(share < 1.005 && share > 0.3, "{rough}, {angle} degrees: {share}");
        }
    }
}

#[test]
fn gooch_goes_from_warm_to_cool() {
    let gooch = |shadow: f64, ks: f64| {
        let colours: Given = &[("Cd", &[0.5, 0.25, 0.1]), ("cool", &[0.0, 0.0, 0.55]), ("warm", &[0.3, 0.3, 0.0])];
        let numbers: Given =
            &[("a", &[0.25]), ("b", &[0.5]), ("shadow", &[shadow]), ("ks", &[ks]), ("h", &[40.0]), ("edge", &[0.3])];
        model("gooch", &[colours, numbers].concat())
    };
    // cool + Cd/4 and warm + Cd/2.
    let (kcool, kwarm) = ([0.125, 0.0625, 0.575], [0.55, 0.425, 0.05]);
    let between = |warmth: f64| [0, 1, 2].map(|channel| warmth * kwarm[channel] + (1.0 - warmth) * kcool[channel]);
    let plain = gooch(1.0, 0.0);
    let lit = |light| Hit::new(light, UP);
    let unlit = |light| Hit { visible: 0.0, ..Hit::new(light, UP) };
    all_close(plain.shade(&lit(UP)), kwarm);
    all_close(plain.shade(&unlit([0.0, 0.0, -1.0])), kcool);
    all_close(plain.shade(&unlit([1.0, 0.0, 0.0])), between(0.5));
    // N.L is 1/2, so three quarters are warm.
    all_close(plain.shade(&lit(direction(60.0, 0.0))), between(0.75));
    // A cast shadow turns the shade to the cool side, fully, half or not at all.
    all_close(plain.shade(&unlit(UP)), kcool);
    all_close(gooch(0.5, 0.0).shade(&unlit(UP)), between(0.5));
    all_close(gooch(0.0, 0.0).shade(&unlit(UP)), kwarm);
    // The highlight, where R.V is 1 and where it is cos 20 degrees. Edges are black.
    all_close(gooch(1.0, 0.5).shade(&lit(UP)), kwarm.map(|channel| channel + 0.5));
    let slanted = lit(direction(20.0, 0.0));
    let highlight = gooch(1.0, 0.5).shade(&slanted)[0] - plain.shade(&slanted)[0];
    close(highlight, 0.5 * 20.0_f64.to_radians().cos().powi(40));
    all_close(plain.shade(&Hit::new(UP, direction(80.0, 0.0))), [0.0; 3]);
}

#[test]
fn toon_has_as_many_tones_as_steps() {
    let toon = |steps: f64| {
        let colours: Given = &[("Cd", &[0.8, 0.4, 0.2]), ("dark", &[0.2]), ("tint", &[0.5, 1.0, 0.25])];
        let numbers: Given = &[("spot", &[0.0]), ("rim", &[0.0]), ("ink", &[0.0]), ("soft", &[0.001]), ("steps", &[steps])];
        model("toon", &[colours, numbers].concat())
    };
    let at = |cosine: f64| Hit::new(direction(cosine.acos().to_degrees(), 0.0), UP);
    // dark tint = <0.1, 0.2, 0.05>; four tones: 0, 1/3, 2/3, 1 of the way to 1.
    let four = toon(4.0);
    let tone = |share: f64| [0.8 * (0.1 + 0.9 * share), 0.4 * (0.2 + 0.8 * share), 0.2 * (0.05 + 0.95 * share)];
    all_close(four.shade(&at(0.1)), tone(0.0));
    all_close(four.shade(&at(0.35)), tone(1.0 / 3.0));
    all_close(four.shade(&at(0.6)), tone(2.0 / 3.0));
    all_close(four.shade(&at(0.9)), tone(1.0));
    all_close(four.shade(&Hit { visible: 0.0, ..at(0.9) }), tone(0.0));
    for steps in 1..=8 {
        let toon = toon(f64::from(steps));
        // A step is k/steps wide; these cosines are in the middles of parts of a step.
        let tones = (0..4 * steps).map(|index| toon.shade(&at((f64::from(index) + 0.5) / f64::from(4 * steps)))[0]);
        let mut tones = Vec::from_iter(tones);
        assert!(tones.is_sorted(), "{tones:?}");
        tones.dedup_by(|one, other| (*one - *other).abs() < 1e-5);
        assert_eq!(tones.len(), steps as usize, "{tones:?}");
    }
    // The spot is white within its radius of 0.3 radians between N and H, so with L up to 0.6 away from V.
    let spot = model("toon", &[("Cd", BLACK), ("spot", &[1.0]), ("size", &[0.3]), ("rim", &[0.0]), ("ink", &[0.0])]);
    let lit = |angle: f64| spot.shade(&Hit::new(direction(angle.to_degrees(), 0.0), UP));
    all_close(lit(0.5), [1.0; 3]);
    all_close(lit(0.7), [0.0; 3]);
}

/// A hit at a point, with the light straight above and the viewer at 60 degrees.
fn at_point(point: Triple) -> Hit {
    Hit { point, ..Hit::new(UP, direction(60.0, 0.0)) }
}

#[test]
fn marble_agrees_with_numbers_in_double_precision() {
    let large: Given = &[("freq", &[3.0]), ("turb", &[5.0]), ("sharp", &[4.0]), ("size", &[1.0]), ("axis", &[1.0, 0.35, 0.6])];
    let mut marble = model("marble", large);
    // By a script with Perlin's reference of improved noise: five octaves, then the sine.
    let numbers = [
        ([0.3, 1.7, -0.45], 0.360_906_42, 0.003_533_869),
        ([2.21, -0.6, 0.9], 0.511_794_6, 0.000_617_680_1),
        ([-1.35, 0.15, 3.4], 0.842_651_7, 0.111_968_59),
    ];
    for (point, noise, share) in numbers {
        close(marble.value("turbulence", &at_point(point))[0], noise);
        close(marble.value("t", &at_point(point))[0], share);
    }
    // Noise vanishes at whole numbers, where the layers are straight: (1/2 + sin(3*(2 + 0.35*5 - 0.6))/2)^4.
    close(marble.value("t", &at_point([2.0, 5.0, -1.0]))[0], (0.5 + (3.0 * 3.15_f64).sin() / 2.0).powi(4));
    let small: Given = &[("freq", &[2.0]), ("turb", &[7.0]), ("sharp", &[5.0]), ("size", &[0.5]), ("axis", &[0.8, 0.6, 0.2])];
    close(model("marble", small).value("t", &at_point([0.3, 1.7, -0.45]))[0], 0.770_796);
    // Colour between stone and vein, and Blinn's gloss: N and H are 30 degrees apart.
    let black: Given = &[("Cd", WHITE), ("vein", BLACK), ("ks", &[0.3]), ("h", &[10.0])];
    let even: Given = &[("turb", &[0.0]), ("freq", &[0.0]), ("sharp", &[4.0])];
    let gloss = 0.3 * 30.0_f64.to_radians().cos().powi(10);
    close(model("marble", &[black, even].concat()).shade(&at_point([0.4, 0.1, 0.2]))[0], 1.0 - 0.5_f64.powi(4) + gloss);
}

#[test]
fn wood_agrees_with_numbers_in_double_precision() {
    let shape: Given = &[("rings", &[7.0]), ("wobble", &[0.6]), ("sharp", &[3.0]), ("grain", &[0.35]), ("ks", &[0.0])];
    let place: Given = &[("axis", &[0.15, 1.0, 0.1]), ("heart", &[-0.6, 0.0, -0.8]), ("Cd", WHITE), ("late", WHITE)];
    let mut wood = model("wood", &[shape, place].concat());
    // By a script with Perlin's reference of improved noise: ring, late wood, and what fibres leave of the colour.
    let numbers = [
        ([0.3, 1.7, -0.45], 0.358_399_34, 0.046_036_43, 0.959_952_6),
        ([2.21, -0.6, 0.9], 0.833_429_07, 0.578_903_2, 0.810_443_4),
        ([-1.35, 0.15, 3.4], 0.551_096_65, 0.167_372_2, 0.847_042_4),
    ];
    for (point, ring, late, fibres) in numbers {
        close(wood.value("ring", &at_point(point))[0], ring);
        close(wood.value("LATE", &at_point(point))[0], late);
        close(wood.shade(&at_point(point))[0], fibres);
    }
    // Without noise the rings are cylinders: only the distance from the axis counts, 4 rings in a unit of length.
    let shape: Given = &[("rings", &[4.0]), ("wobble", &[0.0]), ("axis", &[0.0, 0.0, 1.0]), ("heart", BLACK), ("sharp", &[2.0])];
    let mut plain = model("wood", shape);
    for point in [[0.1, 0.0, 7.0], [0.0, 0.35, -2.0], [0.36, 0.48, 0.3]] {
        let length = f64::hypot(point[0], point[1]);
        close(plain.value("ring", &at_point(point))[0], (4.0 * length).fract());
        close(plain.value("LATE", &at_point(point))[0], (4.0 * length).fract().powi(2));
    }
}

#[test]
fn physical_lights_obey_their_laws() {
    let at = |light, distance| Hit { distance, ..Hit::new(light, UP) };
    let plain = model("physical-lights", &[("Cd", WHITE), ("exposure", &[0.0])]);
    // 1 W/sr at 1 m and at 2 m, and at 60 degrees; radiance is irradiance/π.
    all_close(plain.shade(&at(UP, 1.0)), [1.0 / PI; 3]);
    all_close(plain.shade(&at(UP, 2.0)), [0.25 / PI; 3]);
    all_close(plain.shade(&at(direction(60.0, 0.0), 2.0)), [0.125 / PI; 3]);
    all_close(model("physical-lights", &[("Cd", WHITE), ("exposure", &[3.0])]).shade(&at(UP, 2.0)), [2.0 / PI; 3]);
    // Half-way from 30 to 40 degrees off the axis, the beam has half its light; beyond, none.
    for (angle, share) in [(20.0, 1.0), (35.0, 0.5), (41.0, 0.0), (100.0, 0.0)] {
        let aim = direction(angle, 90.0).map(|axis| -0.7 * axis);
        let spot = model("physical-lights", &[("Cd", WHITE), ("aim", &aim), ("cone", &[30.0]), ("soft", &[10.0])]);
        close(spot.shade(&at(UP, 1.0))[0], share / PI);
    }
    // Planck's law at 610, 550 and 465 nm relative to 6504 K, at the same brightness, by a script in double precision.
    for (kelvin, colour) in [
        (1900.0, [2.024_230_4, 0.783_052, 0.133_100_01]),
        (2700.0, [1.560_633_5, 0.901_684_4, 0.323_055_7]),
        (6504.0, [1.0; 3]),
        (10000.0, [0.888_409_8, 1.005_478_4, 1.274_320_8]),
    ] {
        all_close(model("physical-lights", &[("temp", &[kelvin])]).value("COLOUR", &at(UP, 1.0)), colour);
    }
    let formula = plain.formula();
    let ki = formula.parameter(formula.parameter_named("ki").expect("it always exists"));
    assert_eq!(ki.range, Some([0.0, 50.0]));
}
