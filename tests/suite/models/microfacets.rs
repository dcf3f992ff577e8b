//! Models of surfaces made of facets, and their relatives: from Torrance and Sparrow's to OpenPBR.
//!
//! In these tests a facet is seen straight on where light and viewer are opposite each other about the normal.

mod anisotropic;
mod cook_torrance;
mod disney;
mod mirrors;
mod openpbr;
mod walter;

use crate::models::{Hit, Model, SINGLE, cross, direction, dot, hemisphere, near};

/// The reflectance of a smooth surface for unpolarized light, from the complex index n − ik and the cosine of the angle
/// of incidence: the squares of the complex amplitudes of both polarizations.
pub(super) fn fresnel(n: f64, k: f64, cosine: f64) -> f64 {
    let index = Complex(n, -k);
    let square = index.times(index);
    let inside = Complex(square.0 - (1.0 - cosine * cosine), square.1).root();
    let amplitude =
        |ahead: Complex| Complex(ahead.0 - inside.0, ahead.1 - inside.1).over(Complex(ahead.0 + inside.0, ahead.1 + inside.1));
    let perpendicular = amplitude(Complex(cosine, 0.0));
    let parallel = amplitude(Complex(square.0 * cosine, square.1 * cosine));
    (perpendicular.norm() + parallel.norm()) / 2.0
}

#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    fn times(self, other: Self) -> Self {
        Complex(self.0 * other.0 - self.1 * other.1, self.0 * other.1 + self.1 * other.0)
    }

    fn norm(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }

    fn over(self, other: Self) -> Self {
        let product = self.times(Complex(other.0, -other.1));
        Complex(product.0 / other.norm(), product.1 / other.norm())
    }

    fn root(self) -> Self {
        let (length, angle) = (self.norm().sqrt().sqrt(), self.1.atan2(self.0) / 2.0);
        Complex(length * angle.cos(), length * angle.sin())
    }
}

/// Light and viewer at the same angle to the normal, in degrees, opposite each other.
pub(super) fn mirror(polar: f64) -> Hit {
    Hit::new(direction(polar, 0.0), direction(polar, 180.0))
}

/// Light, viewer and normal in one line.
pub(super) fn straight() -> Hit {
    mirror(0.0)
}

/// Pairs of directions without symmetry.
pub(super) fn pairs() -> [Hit; 4] {
    [
        Hit::new(direction(35.0, 20.0), direction(50.0, 160.0)),
        Hit::new(direction(70.0, 75.0), direction(40.0, 0.0)),
        Hit::new(direction(20.0, 200.0), direction(65.0, 15.0)),
        Hit::new(direction(80.0, 10.0), direction(75.0, 205.0)),
    ]
}

/// Asserts that the BRDF is the same with light and viewer exchanged.
#[track_caller]
pub(super) fn reciprocal(model: &Model) {
    for hit in pairs() {
        let (there, back) = (model.shade(&hit), model.shade(&hit.swapped()));
        for channel in 0..3 {
            near(there[channel] / hit.light[2], back[channel] / hit.viewer[2], SINGLE);
        }
    }
}

/// The integral of a distribution of facets, a macro, times the cosine of their angle: the area that they cover, seen
/// from above.
pub(super) fn covered(model: &mut Model, distribution: &str, steps: usize) -> f64 {
    hemisphere(steps, |facet| model.value(distribution, &Hit::new(facet, facet)).map(|x| x * facet[2]))[0]
}

/// Asserts that the surface sends back no more than it gets, in these directions of the viewer.
#[track_caller]
pub(super) fn sends_no_more_than_it_gets(model: &Model, angles: &[f64], slack: f64) {
    for polar in angles {
        let albedo = model.albedo(*polar, 32);
        assert!(albedo.iter().all(|x| *x <= 1.0 + slack), "{albedo:?} at {polar} degrees");
    }
}

#[test]
fn the_direct_formula_of_fresnel_has_its_closed_forms() {
    near(fresnel(1.5, 0.0, 1.0), 0.04, 1e-12);
    near(fresnel(1.5, 0.0, 0.0), 1.0, 1e-12);
    near(fresnel(0.5, 2.0, 1.0), (0.25 + 4.0) / (2.25 + 4.0), 1e-12);
    // At Brewster's angle only perpendicular light is reflected: ((n^2 - 1)/(n^2 + 1))^2, half of it.
    near(fresnel(1.5, 0.0, 1.0 / 3.25_f64.sqrt()), (1.25_f64 / 3.25).powi(2) / 2.0, 1e-12);
}

#[test]
fn colours_are_numbers_in_all_corners() {
    for name in [
        "torrance-sparrow",
        "cook-torrance",
        "ward",
        "ggx",
        "ggx-anisotropic",
        "disney",
        "disney-diffuse",
        "openpbr",
        "ashikhmin-shirley",
        "brushed-metal",
        "fresnel-glass",
        "coloured-mirror",
    ] {
        crate::models::sound_in_all_corners(name);
    }
}
