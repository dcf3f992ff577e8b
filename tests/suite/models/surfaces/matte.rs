//! Oren and Nayar's model, EON, and Minnaert's law.

use super::{Given, Hit, PI, Triple, UP, all_close, close, direction, hemisphere, hit, model, near, reciprocal};
use super::{slanted, sound_in_all_corners};

#[test]
fn matte_models_are_sound_with_all_sliders_at_their_ends() {
    for name in ["oren-nayar", "eon", "minnaert"] {
        sound_in_all_corners(name);
    }
}

#[test]
fn matte_models_have_lamberts_law_as_their_limit() {
    let colour = [0.8, 0.4, 0.2];
    let lambert: [Given; 3] = [&[("sigma", &[0.0])], &[("r", &[0.0])], &[("k", &[1.0])]];
    for (name, given) in ["oren-nayar", "eon", "minnaert"].into_iter().zip(lambert) {
        let model = model(name, &[given, &[("Cd", &colour)]].concat());
        for hit in slanted() {
            all_close(model.shade(&hit), colour.map(|part| part * hit.light[2]));
        }
    }
}

/// Oren and Nayar's L1 and L2 in their angles, times π, for light of 1. Angles in radians.
fn oren_nayar(hit: &Hit, sigma: f64, rho: f64, inter: bool) -> f64 {
    let (light, viewer) = (hit.light[2].acos(), hit.viewer[2].acos());
    let azimuth = |direction: Triple| direction[1].atan2(direction[0]);
    let cosine = (azimuth(hit.light) - azimuth(hit.viewer)).cos();
    let (large, small) = (light.max(viewer), light.min(viewer));
    let s2 = sigma.powi(2);
    let c1 = 1.0 - 0.5 * s2 / (s2 + 0.33);
    let back = if cosine >= 0.0 { 0.0 } else { (2.0 * small / PI).powi(3) };
    let c2 = 0.45 * s2 / (s2 + 0.09) * (large.sin() - back);
    let c3 = 0.125 * s2 / (s2 + 0.09) * (4.0 * large * small / (PI * PI)).powi(2);
    let tangents = cosine * c2 * small.tan() + (1.0 - cosine.abs()) * c3 * f64::midpoint(large, small).tan();
    let once = rho * light.cos() * (c1 + tangents);
    let twice = 0.17 * rho * rho * light.cos() * s2 / (s2 + 0.13) * (1.0 - cosine * (2.0 * small / PI).powi(2));
    (once + if inter { twice } else { 0.0 }).max(0.0)
}

#[test]
fn oren_and_nayars_model_by_its_angles() {
    for sigma in [5.0, 20.0, 40.0, 75.0_f64] {
        for (inter, switch) in [(false, 0.0), (true, 1.0)] {
            let clay = model("oren-nayar", &[("sigma", &[sigma]), ("inter", &[switch]), ("Cd", &[0.9, 0.5, 0.1])]);
            for hit in slanted() {
                let wanted = [0.9, 0.5, 0.1].map(|rho| oren_nayar(&hit, sigma.to_radians(), rho, inter));
                all_close(clay.shade(&hit), wanted);
            }
            reciprocal(&clay);
        }
    }
    // By hand: plaster of 30 degrees and 0.9 straight on: s2 = 0.274156, C1 = 0.773103, L2 = 0.17 0.81 0.678329.
    let plaster = model("oren-nayar", &[("sigma", &[30.0]), ("Cd", &[0.9])]);
    close(plaster.shade(&Hit::new(UP, UP))[0], 0.9 * 0.773_103 + 0.17 * 0.81 * 0.678_329);
    // The short form: A + B max(0, cos) sin a tan b, at 40 degrees to the same side.
    let short = model("oren-nayar", &[("sigma", &[30.0]), ("Cd", &[0.9]), ("qualitative", &[1.0])]);
    let angle = 40.0_f64.to_radians();
    let wanted = 0.9 * angle.cos() * (0.773_103 + 0.45 * 0.752_855 * angle.sin() * angle.tan());
    close(short.shade(&hit((40.0, 10.0), (40.0, 10.0)))[0], wanted);
    close(short.shade(&hit((40.0, 10.0), (40.0, 190.0)))[0], 0.9 * angle.cos() * 0.773_103);
}

#[test]
fn oren_and_nayars_white_loses_light_as_computed() {
    // By a script in double precision, with the formula in angles: the share sent back for rho = 1.
    for (sigma, polar, share) in [(10.0, 0.0, 0.990_13), (10.0, 85.0, 1.0238), (30.0, 45.0, 0.900_57), (60.0, 75.0, 0.847_31)] {
        let white = model("oren-nayar", &[("sigma", &[sigma]), ("Cd", &[1.0])]);
        near(white.albedo(polar, 30)[0], share, 1e-3);
    }
    // A full disc of sigma = 60 is nearly flat: at 60 degrees it is still brighter than 0.8 of the middle.
    let clay = model("oren-nayar", &[("sigma", &[60.0]), ("Cd", &[0.6])]);
    let disc = |angle: f64| clay.shade(&hit((angle, 0.0), (angle, 0.0)))[0];
    assert!(disc(60.0) / disc(0.0) > 0.8, "{}", disc(60.0) / disc(0.0));
}

/// The albedo of Fujii's form of Oren and Nayar's model for a white surface, towards an angle in radians.
fn fujii_albedo(angle: f64, r: f64) -> f64 {
    let (sine, cosine) = angle.sin_cos();
    let g = sine * (angle - sine * cosine) + 2.0 / 3.0 * (sine / cosine * (1.0 - sine.powi(3)) - sine);
    (1.0 + r / PI * g) / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r)
}

#[test]
fn eon_keeps_white_white() {
    for r in [0.3, 1.0] {
        let white = model("eon", &[("r", &[r]), ("Cd", &[1.0])]);
        let alone = model("eon", &[("r", &[r]), ("Cd", &[1.0]), ("preserve", &[0.0])]);
        for polar in [0.0, 40.0, 80.0_f64] {
            near(white.albedo(polar, 30)[0], 1.0, 1e-3);
            near(alone.albedo(polar, 30)[0], fujii_albedo(polar.to_radians(), r), 1e-3);
        }
    }
}

#[test]
fn eon_deepens_colours_as_many_scatterings_do() {
    let (r, rho) = (0.9, [0.9, 0.5, 0.1]);
    let mean = (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r) / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
    let clay = model("eon", &[("r", &[r]), ("Cd", &rho)]);
    // rho E + rho^2 Emean/(1 - rho (1 - Emean)) (1 - E): light that comes out after one, and after more scatterings.
    let polar = 30.0_f64;
    let once = fujii_albedo(polar.to_radians(), r);
    let share = clay.albedo(polar, 30);
    for channel in 0..3 {
        let rho = rho[channel];
        near(share[channel], rho * once + rho * rho * mean / (1.0 - rho * (1.0 - mean)) * (1.0 - once), 1e-3);
    }
    // The mean albedo is the integral of E over all directions.
    let integral = hemisphere(60, |light| [fujii_albedo(light[2].acos(), r) * light[2] / PI; 3])[0];
    near(integral, mean, 1e-3);
    reciprocal(&clay);
}

#[test]
fn eon_agrees_with_numbers_in_closed_form() {
    // Straight on, r = 1: AF = 1/(3/2 - 2/(3 pi)) = 0.776560, G(1) = 0, so E = AF, and s = 0.
    let single = model("eon", &[("r", &[1.0]), ("Cd", &[0.6]), ("preserve", &[0.0])]);
    close(single.shade(&Hit::new(UP, UP))[0], 0.6 / (1.5 - 2.0 / (3.0 * PI)));
    // Light and viewer together at 60 degrees: s = 3/4, t = 1/2; and opposite each other: s = -3/4, t = 1.
    close(single.shade(&hit((60.0, 0.0), (60.0, 0.0)))[0], 0.5 * 0.6 / (1.5 - 2.0 / (3.0 * PI)) * 2.5);
    close(single.shade(&hit((60.0, 0.0), (60.0, 180.0)))[0], 0.5 * 0.6 / (1.5 - 2.0 / (3.0 * PI)) * 0.25);
}

#[test]
fn minnaerts_law_and_its_discs() {
    for k in [0.0, 0.5, 0.7, 1.4, 3.0] {
        let moon = model("minnaert", &[("k", &[k]), ("Cd", &[0.9, 0.5, 0.1])]);
        for hit in slanted() {
            let wanted = hit.light[2].powf(k) * hit.viewer[2].powf(k - 1.0);
            all_close(moon.shade(&hit), [0.9, 0.5, 0.1].map(|part| part * wanted));
        }
        reciprocal(&moon);
        // From the normal the share sent back is 2 Cd/(k + 1), and Cd if it is scaled.
        for (scaled, share) in [(0.0, 1.0 / (k + 1.0)), (1.0, 0.5)] {
            let grey = model("minnaert", &[("k", &[k]), ("Cd", &[0.5]), ("scaled", &[scaled])]);
            let sent = |viewer: Triple| grey.shade(&Hit::new(UP, viewer)).map(|x| x * viewer[2] / PI);
            near(hemisphere(60, sent)[0], share, if k < 0.5 { 1e-2 } else { 1e-3 });
        }
    }
    // k = 1/2: the full disc is flat.
    let flat = model("minnaert", &[("k", &[0.5]), ("Cd", &[0.3])]);
    for angle in [0.0, 50.0, 85.0] {
        close(flat.shade(&hit((angle, 0.0), (angle, 0.0)))[0], 0.3);
    }
    // Behind the terminator it is dark, also with k = 0.
    let behind = Hit::new(direction(120.0, 0.0), UP);
    all_close(model("minnaert", &[("k", &[0.0])]).shade(&behind), [0.0; 3]);
    // A tilt of 0.2 of k = 0.8, at 60 degrees: 2 to the powers 1 - 2k of red, green and blue.
    let hazy = model("minnaert", &[("k", &[0.8]), ("tilt", &[0.2]), ("Cd", &[1.0])]);
    let edge = hazy.shade(&hit((60.0, 0.0), (60.0, 0.0)));
    all_close(edge, [0.6_f64, 0.8, 1.0].map(|k| 2.0_f64.powf(1.0 - 2.0 * k)));
}
