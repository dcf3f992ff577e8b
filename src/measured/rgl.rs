//! The format of the material database of EPFL's realistic graphics lab: isotropic and anisotropic reflectance,
//! spectral or RGB (J. Dupuy, W. Jakob, "An Adaptive Parameterization for Efficient Material Acquisition and
//! Rendering", SIGGRAPH Asia 2018, section 4).
//!
//! For each direction to the view, the unit square is mapped to half vectors by the distribution of visible normals
//! `vndf`. On this square lie samples of reflectance times cosine over `ndf`/(4·`sigma`): the distribution of normals,
//! and the area of the microfacets that is seen from the view. So samples are dense where the material reflects most.
//!
//! As in Mitsuba and in pbrt, the direction *i* of a file is that to the view, and the cosine is that of the light. So
//! the reflectance of a file is reciprocal only as far as its measurements are. Negative samples count as 0.

use crate::measured::error::Flaw;
use crate::measured::spectrum;
use crate::measured::tensor::{Tensor, TensorFile};
use crate::measured::warp::{GridWeights, Grids, Warp};
use glam::DVec3;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI, TAU};

/// Cosines of the light are not taken smaller than this, so that the reflectance stays finite.
const SMALLEST_COSINE: f64 = 1e-6;

/// The measurements of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RglMaterial {
    normals: Grids<1>,
    area: Grids<1>,
    visible: Warp,
    /// Linear sRGB.
    colours: Grids<3>,
    /// Whether the colours were divided by `ndf`/(4·`sigma`).
    is_divided: bool,
    /// Whether only differences of azimuths matter.
    is_isotropic: bool,
    /// Into how many like parts the azimuths were divided, of which one was measured: 1, 2 or 4.
    parts: u32,
}

/// What lookups need of the direction to the view.
#[derive(Debug, Clone, Copy)]
pub(super) struct ViewLookup {
    /// What turns or mirrors directions to those that were measured.
    signs: DVec3,
    /// The direction, turned or mirrored.
    view: DVec3,
    /// Its azimuth.
    phi: f64,
    /// The grids around it.
    grids: GridWeights,
    /// `sigma` for it; 0 if that is not needed.
    area: f64,
}

/// The tensor, if all its sizes are at least these, and it has all numbers of them.
fn sized(tensor: Tensor, name: &str, least: &[usize]) -> Result<Tensor, Flaw> {
    let count = tensor.shape.iter().try_fold(1_usize, |product, size| product.checked_mul(*size));
    let large = tensor.shape.iter().zip(least).all(|(size, least)| size >= least);
    if large && count == Some(tensor.numbers.len()) {
        return Ok(tensor);
    }
    let [sizes, least] = [&tensor.shape, least].map(|sizes| sizes.iter().map(usize::to_string).collect::<Vec<_>>().join("×"));
    Err(Flaw::new(format!("the field `{name}` has {sizes} numbers, and at least {least} were expected")))
}

/// Numbers that grow, such as angles.
fn growing(file: &TensorFile, name: &str) -> Result<Vec<f32>, Flaw> {
    let tensor = sized(file.floats(name, 1)?, name, &[1])?;
    if tensor.numbers.windows(2).all(|pair| pair[0] < pair[1]) {
        Ok(tensor.numbers)
    } else {
        Err(Flaw::new(format!("the numbers of the field `{name}` do not grow")))
    }
}

/// A function on one grid.
fn alone(file: &TensorFile, name: &str) -> Result<Grids<1>, Flaw> {
    let tensor = sized(file.floats(name, 2)?, name, &[2, 2])?;
    Ok(Grids::alone([tensor.shape[1], tensor.shape[0]], tensor.numbers.into_iter().map(|number| [number]).collect()))
}

/// The flaw that a field has not one grid for each direction.
fn other_directions(name: &str, found: &[usize], angles: &[Vec<f32>; 2]) -> Flaw {
    let [azimuths, polars] = angles.each_ref().map(Vec::len);
    let [first, second] = [found[0], found[1]];
    let message = format!("the field `{name}` has grids for {first}×{second} directions, and there are {azimuths}×{polars}");
    Flaw::new(message).hint("`phi_i` and `theta_i` are the directions")
}

/// The colours of a file as linear sRGB.
fn colours(file: &TensorFile, angles: &[Vec<f32>; 2]) -> Result<Grids<3>, Flaw> {
    let is_spectral = !file.has("rgb");
    let name = if is_spectral { "spectra" } else { "rgb" };
    if is_spectral && !file.has(name) {
        return Err(Flaw::new("it has neither a field `rgb` nor a field `spectra`"));
    }
    let weights = match is_spectral {
        true => spectrum::weights(&growing(file, "wavelengths")?).ok_or_else(|| {
            Flaw::new("the wavelengths have no visible light").hint("the field `wavelengths` gives them in nanometres")
        })?,
        false => vec![DVec3::X, DVec3::Y, DVec3::Z],
    };
    let Tensor { shape, numbers } = sized(file.floats(name, 5)?, name, &[1, 1, 1, 2, 2])?;
    if [shape[0], shape[1]] != [angles[0].len(), angles[1].len()] {
        return Err(other_directions(name, &shape, angles));
    }
    if shape[2] != weights.len() {
        let (found, expected) = (shape[2], weights.len());
        return Err(Flaw::new(format!("the field `{name}` has {found} components, and {expected} were expected")));
    }
    let points = shape[3] * shape[4];
    let mut values = Vec::with_capacity(numbers.len() / weights.len());
    for grid in numbers.chunks_exact(points * weights.len()) {
        values.extend((0..points).map(|point| {
            let samples =
                weights.iter().enumerate().map(|(index, weight)| *weight * f64::from(grid[index * points + point].max(0.0)));
            samples.sum::<DVec3>().as_vec3().to_array()
        }));
    }
    if values.as_flattened().iter().any(|value| !value.is_finite()) {
        return Err(Flaw::new(format!("numbers of the field `{name}` are too large")));
    }
    Ok(Grids { size: [shape[4], shape[3]], angles: angles.clone(), values })
}

impl RglMaterial {
    /// Reads the fields of a file.
    ///
    /// # Errors
    /// A field is missing, has other sizes than expected, or numbers that mean nothing.
    pub(super) fn new(file: &TensorFile) -> Result<Self, Flaw> {
        let angles = [growing(file, "phi_i")?, growing(file, "theta_i")?];
        for (name, angles, most) in [("phi_i", &angles[0], TAU), ("theta_i", &angles[1], FRAC_PI_2)] {
            if let Some(angle) = angles.iter().find(|angle| f64::from(angle.abs()) > most + 0.01) {
                let flaw = Flaw::new(format!("an angle of the field `{name}` is {angle}, and at most {most:.4} was expected"));
                return Err(flaw.hint("angles are in radians"));
            }
        }
        let vndf = sized(file.floats("vndf", 4)?, "vndf", &[1, 1, 2, 2])?;
        if [vndf.shape[0], vndf.shape[1]] != [angles[0].len(), angles[1].len()] {
            return Err(other_directions("vndf", &vndf.shape, &angles));
        }
        let size = [vndf.shape[3], vndf.shape[2]];
        let values = vndf.numbers.into_iter().map(|number| [number]).collect();
        let visible = Warp::new(Grids { size, angles: angles.clone(), values });
        let visible = visible.ok_or_else(|| Flaw::new("the field `vndf` has a grid that is negative, or 0 everywhere"))?;
        // Two azimuths are the ends of the whole circle.
        let is_isotropic = angles[0].len() <= 2;
        let measured = f64::from(angles[0][angles[0].len() - 1]) - f64::from(angles[0][0]);
        let parts = if is_isotropic { 1.0 } else { (TAU / measured).round() };
        if ![1.0, 2.0, 4.0].contains(&parts) {
            let message = format!("the azimuths `phi_i` cover {:.1} degrees", measured.to_degrees());
            return Err(Flaw::new(message).hint("a whole circle, a half or a quarter were expected"));
        }
        let [normals, area] = [alone(file, "ndf")?, alone(file, "sigma")?];
        for (name, grid) in [("ndf", &normals), ("sigma", &area)] {
            if !grid.values.as_flattened().iter().any(|value| *value > 0.0) {
                return Err(Flaw::new(format!("the field `{name}` has no number above 0")));
            }
        }
        Ok(Self {
            normals,
            area,
            visible,
            colours: colours(file, &angles)?,
            is_divided: file.byte("jacobian")? != 0,
            is_isotropic,
            parts: parts as u32,
        })
    }

    /// Whether only differences of azimuths matter.
    pub(super) fn is_isotropic(&self) -> bool {
        self.is_isotropic
    }

    /// The bytes of memory that it takes, about.
    pub(super) fn bytes(&self) -> u64 {
        let numbers = self.normals.values.len() + self.area.values.len() + 3 * self.colours.values.len();
        (size_of::<f32>() * (numbers + self.visible.count())) as u64
    }

    /// The signs that turn or mirror light and view to the azimuths that were measured: those from −180° on.
    fn signs(&self, view: DVec3) -> DVec3 {
        let turned = |positive: bool| if positive { -1.0 } else { 1.0 };
        let y = turned(view.y >= 0.0);
        match self.parts {
            4 => DVec3::new(turned(view.x >= 0.0), y, 1.0),
            2 => DVec3::new(y, y, 1.0),
            _ => DVec3::ONE,
        }
    }

    /// What lookups need of a unit vector to the view.
    pub(super) fn seen_from(&self, view: DVec3) -> ViewLookup {
        let signs = self.signs(view);
        let view = view * signs;
        let [theta, phi] = angles(view);
        let area = self.is_divided.then(|| self.area.at(&self.area.around(0.0, 0.0), [across(theta), along(phi)])[0]);
        ViewLookup { signs, view, phi, grids: self.visible.around(phi, theta), area: area.unwrap_or(0.0) }
    }

    /// The reflectance in 1/sr between two unit vectors above the horizon.
    pub(super) fn value(&self, light: DVec3, from: &ViewLookup) -> DVec3 {
        let light = light * from.signs;
        let half = (light + from.view).normalize_or(DVec3::Z);
        let [theta, azimuth] = angles(half);
        let about = along(if self.is_isotropic { azimuth - from.phi } else { azimuth });
        let at_half = [across(theta), about - about.floor()];
        let place = self.visible.invert(&from.grids, at_half);
        // The colours lie on grids for the same directions.
        let colour = DVec3::from_array(self.colours.at(&from.grids, place));
        let share =
            if self.is_divided { self.normals.at(&self.normals.around(0.0, 0.0), at_half)[0] / (4.0 * from.area) } else { 1.0 };
        colour * share / light.z.max(SMALLEST_COSINE)
    }
}

/// Polar angle and azimuth.
fn angles(direction: DVec3) -> [f64; 2] {
    let sine = (direction.x * direction.x + direction.y * direction.y).sqrt();
    [sine.atan2(direction.z), direction.y.atan2(direction.x)]
}

/// The coordinate of a polar angle on the unit square.
fn across(theta: f64) -> f64 {
    (theta * FRAC_2_PI).sqrt()
}

/// The coordinate of an azimuth.
fn along(phi: f64) -> f64 {
    (phi + PI) / TAU
}
