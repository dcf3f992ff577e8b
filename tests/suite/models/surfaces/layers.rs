//! Thin films and lacquer: Fresnel's law and interference in complex numbers, and the light between layers.

use super::{Hit, Model, PI, Triple, UP, all_close, close, direction, hit, model, near};
use crate::models::sound_in_corners;
use std::ops::{Add, Div, Mul, Sub};

/// A complex number.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    fn norm(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }

    /// The root whose imaginary part is not negative: a wave that fades.
    fn root(self) -> Self {
        let (length, angle) = (self.norm().sqrt().sqrt(), self.1.atan2(self.0) / 2.0);
        Complex(length * angle.cos(), length * angle.sin())
    }
}

impl Add for Complex {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Complex(self.0 + other.0, self.1 + other.1)
    }
}

impl Sub for Complex {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Complex(self.0 - other.0, self.1 - other.1)
    }
}

impl Mul for Complex {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Complex(self.0 * other.0 - self.1 * other.1, self.0 * other.1 + self.1 * other.0)
    }
}

impl Div for Complex {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let product = self * Complex(other.0, -other.1);
        Complex(product.0 / other.norm(), product.1 / other.norm())
    }
}

/// A number as a complex one.
fn real(x: f64) -> Complex {
    Complex(x, 0.0)
}

/// What a film reflects of unpolarized light, by the characteristic matrix of a layer (Born and Wolf, section 1.6),
/// which knows no sum of Airy's. Lengths in nanometres; the cosine is that outside.
fn film(thickness: f64, index: f64, ground: Complex, wavelength: f64, cosine: f64) -> f64 {
    let sine2 = real(1.0 - cosine * cosine);
    // The normal parts of the wave vectors, in the film and in the ground.
    let inside = (real(index * index) - sine2).root();
    let below = (ground * ground - sine2).root();
    let phase = 2.0 * PI * thickness * inside.0 / wavelength;
    let polarization = |outside: Complex, inside: Complex, below: Complex| {
        // Admittances; the matrix is [cos, -i sin/inside; -i sin inside, cos].
        let (cos, sin) = (real(phase.cos()), Complex(0.0, -phase.sin()));
        let field = cos + sin / inside * below;
        let flow = sin * inside + cos * below;
        ((outside * field - flow) / (outside * field + flow)).norm()
    };
    let across = polarization(real(cosine), inside, below);
    let along = polarization(real(1.0 / cosine), real(index * index) / inside, ground * ground / below);
    f64::midpoint(across, along)
}

/// What a built-in formula mirrors of rays at this angle in degrees, from outside.
fn mirrored(model: &mut Model, polar: f64) -> Triple {
    model.value("reflected", &Hit { eta: 0.5, ..Hit::new(UP, direction(polar, 0.0)) })
}

const WAVELENGTHS: Triple = [650.0, 550.0, 450.0];

#[test]
fn layers_are_sound_with_all_sliders_at_their_ends() {
    for name in ["thin-film", "lacquer"] {
        sound_in_corners(name, 25);
    }
}

#[test]
fn films_agree_with_the_matrix_of_a_layer() {
    let titanium = ([2.7407, 2.5418, 2.267], [3.8143, 3.4345, 3.0385]);
    let grounds = [([1.0; 3], [0.0; 3]), ([1.52; 3], [0.0; 3]), titanium, ([0.18, 0.42, 1.37], [3.42, 2.35, 1.77])];
    for (n2, k2) in grounds {
        for (d, n1) in [(0.0, 1.33), (62.0, 2.4), (380.0, 1.33), (1250.0, 1.6)] {
            let mut model = model("thin-film", &[("d", &[d]), ("n1", &[n1]), ("n2", &n2), ("k2", &k2)]);
            for polar in [0.0, 30.0, 60.0, 75.0, 85.0_f64] {
                let wanted = [0, 1, 2].map(|channel| {
                    film(d, n1, Complex(n2[channel], k2[channel]), WAVELENGTHS[channel], polar.to_radians().cos())
                });
                let found = mirrored(&mut model, polar);
                (0..3).for_each(|channel| near(found[channel], wanted[channel], 5e-4));
            }
        }
    }
}

#[test]
fn films_have_their_closed_forms() {
    let glass = |d: f64, n1: f64| model("thin-film", &[("d", &[d]), ("n1", &[n1]), ("n2", &[1.52]), ("kt", &[1.0])]);
    // No film: ((n - 1)/(n + 1))^2. A quarter of a wave: ((n - n1^2)/(n + n1^2))^2, in green; half a wave: as no film.
    let bare = (0.52_f64 / 2.52).powi(2);
    all_close(mirrored(&mut glass(0.0, 1.38), 0.0), [bare; 3]);
    let square = 1.38_f64.powi(2);
    let quarter = mirrored(&mut glass(550.0 / (4.0 * 1.38), 1.38), 0.0)[1];
    close(quarter, ((1.52 - square) / (1.52 + square)).powi(2));
    assert!(quarter < bare / 3.0, "a coating that makes glass reflect less");
    close(mirrored(&mut glass(550.0 / (2.0 * 1.38), 1.38), 0.0)[1], bare);
    // The root of the ground's index: green is not reflected at all. And a soap film that is thin is black.
    close(mirrored(&mut glass(550.0 / (4.0 * 1.52_f64.sqrt()), 1.52_f64.sqrt()), 0.0)[1], 0.0);
    all_close(mirrored(&mut model("thin-film", &[("d", &[0.0]), ("n1", &[1.33])]), 70.0), [0.0; 3]);
    // A bubble's brightest: 4 r^2/(1 + r^2)^2 where n1 d is a quarter of a wave, r = 0.33/2.33.
    let r2 = (0.33_f64 / 2.33).powi(2);
    let bubble = &mut model("thin-film", &[("d", &[450.0 / (4.0 * 1.33)]), ("n1", &[1.33])]);
    close(mirrored(bubble, 0.0)[2], 4.0 * r2 / (1.0 + r2).powi(2));
    // Silver at 550 nm without a film: ((n - 1)^2 + k^2)/((n + 1)^2 + k^2).
    let silver = &mut model("thin-film", &[("d", &[0.0]), ("n1", &[1.0]), ("n2", &[0.145]), ("k2", &[3.19])]);
    close(mirrored(silver, 0.0)[1], (0.855_f64.powi(2) + 3.19_f64.powi(2)) / (1.145_f64.powi(2) + 3.19_f64.powi(2)));
}

#[test]
fn rays_share_what_a_film_does_not_keep() {
    let mut glass = model("thin-film", &[("d", &[300.0]), ("n1", &[1.7]), ("n2", &[1.52]), ("kt", &[1.0])]);
    for polar in [0.0, 35.0, 41.0, 60.0_f64] {
        // Inside: the film reflects as it does from outside, along the same path; past the critical angle all.
        let leaving = Hit { eta: 1.52, ..Hit::new(UP, direction(polar, 0.0)) };
        let sine = 1.52 * polar.to_radians().sin();
        let wanted = if sine > 1.0 { [1.0; 3] } else { mirrored(&mut glass, sine.asin().to_degrees()) };
        let mirror = glass.value("reflected", &leaving);
        (0..3).for_each(|channel| near(mirror[channel], wanted[channel], 1e-3));
        let passed = glass.value("refracted", &leaving);
        all_close([0, 1, 2].map(|channel| mirror[channel] + passed[channel]), [1.0; 3]);
    }
    // The lamp's highlight, straight on: R/(4 rough^2)... of GGX with the width rough^2.
    let lamp = model("thin-film", &[("d", &[0.0]), ("n2", &[1.52]), ("n1", &[1.0]), ("rough", &[0.5])]);
    close(lamp.shade(&Hit::new(UP, UP))[0], (0.52_f64 / 2.52).powi(2) / (4.0 * 0.5_f64.powi(4)));
}

/// Fresnel's law for a dielectric of index n, from the angle outside, by Snell's law and both amplitudes.
fn fresnel(n: f64, cosine: f64) -> f64 {
    let inside = (1.0 - (1.0 - cosine * cosine) / (n * n)).sqrt();
    let across = (cosine - n * inside) / (cosine + n * inside);
    let along = (n * cosine - inside) / (n * cosine + inside);
    f64::midpoint(across * across, along * along)
}

/// The share of light, sent up evenly below a coat, that comes back: 2 m F(m) exp(-2 tau/m), F from inside.
fn comes_back(n: f64, tau: f64) -> f64 {
    const STEPS: usize = 20_000;
    let part = |index: usize| {
        let m = (index as f64 + 0.5) / STEPS as f64;
        let outside = 1.0 - n * n * (1.0 - m * m);
        let mirrored = if outside <= 0.0 { 1.0 } else { fresnel(n, outside.sqrt()) };
        2.0 * m * mirrored * (-2.0 * tau / m).exp() / STEPS as f64
    };
    (0..STEPS).map(part).sum()
}

#[test]
fn lacquer_in_double_precision() {
    for (n, d) in [(1.5, 0.0), (1.33, 0.5), (1.8, 2.0)] {
        let (colour, tint) = ([0.9, 0.5, 0.1], [0.95, 0.6, 0.3]);
        let mut lacquer = model("lacquer", &[("n", &[n]), ("d", &[d]), ("Cd", &colour), ("tint", &tint)]);
        for (light, viewer) in [(0.0, 0.0), (30.0, 65.0), (80.0, 20.0), (70.0, 85.0_f64)] {
            let hit = hit((light, 0.0), (viewer, 90.0));
            let base = lacquer.value("BASE", &hit);
            for channel in 0..3 {
                let tau = -f64::ln(tint[channel]) * d;
                let enters = |cosine: f64| {
                    let inside = (1.0 - (1.0 - cosine * cosine) / (n * n)).sqrt();
                    (1.0 - fresnel(n, cosine)) * (-tau / inside).exp()
                };
                let through = enters(hit.light[2]) * enters(hit.viewer[2]) / (n * n);
                let wanted = colour[channel] * through / (1.0 - colour[channel] * comes_back(n, tau));
                near(base[channel], wanted, 1e-3);
            }
        }
    }
}

#[test]
fn white_under_a_clear_coat_loses_no_light() {
    for n in [1.2, 1.5, 2.0] {
        let mut white = model("lacquer", &[("n", &[n]), ("d", &[0.0]), ("Cd", &[1.0])]);
        for polar in [0.0, 75.0_f64] {
            // What is mirrored, and what the colour sends up: the mean of what enters, over all directions.
            let viewer = direction(polar, 0.0);
            let sent = super::hemisphere(24, |light| {
                let base = white.value("BASE", &Hit::new(light, viewer));
                base.map(|x| x * light[2] / PI)
            });
            near(sent[0] + fresnel(n, polar.to_radians().cos()), 1.0, 4e-3);
            close(white.value("reflected", &Hit::new(UP, viewer))[0], fresnel(n, polar.to_radians().cos()));
        }
        // From inside, 1 - (1 - r)/n^2 of it comes back, r the same from outside (Duntley 1942).
        let outside = super::hemisphere(200, |light| [fresnel(n, light[2]) * light[2] / PI; 3])[0];
        near(white.value("K", &Hit::new(UP, UP))[0], 1.0 - (1.0 - outside) / (n * n), 1e-3);
    }
    // Published: r = 0.0918 and 0.5963 inside for n = 1.5 (Duntley; Saunderson's tables: 0.596).
    let mut varnish = model("lacquer", &[("n", &[1.5]), ("d", &[0.0])]);
    near(varnish.value("K", &Hit::new(UP, UP))[0], 0.5963, 1e-3);
    // No coat: Lambert's law.
    let bare = model("lacquer", &[("n", &[1.0]), ("d", &[0.0]), ("Cd", &[0.6])]);
    close(bare.shade(&hit((50.0, 0.0), (30.0, 40.0)))[0], 0.6 * 50.0_f64.to_radians().cos());
}
