//! The result of an inspection as plain data: the tree of a pixel's rays.

use crate::scene::{BodyId, LightId};
use crate::trace::{Edge, HitVariables, LightVariables};
use crate::world::{LightSample, Ray, SurfaceHit};

/// How the colour of one pixel is made up in one pass.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// The pixel: column and row, from the top left.
    pub pixel: [u32; 2],
    /// The pass, counted from 0.
    pub pass: u32,
    /// Its rays, parents before children and the reflected child's whole tree before the refracted; the primary ray is
    /// the first.
    pub rays: Vec<InspectedRay>,
    /// The pixel's linear red, green and blue, unclamped: the interpreter's, bit for bit.
    pub total: [f32; 3],
}

/// A ray and the light that it brings.
#[derive(Debug, Clone, PartialEq)]
pub struct InspectedRay {
    /// Whether it is the primary ray, reflected or refracted.
    pub edge: Edge,
    /// The ray at whose hit it starts, as an index into [`Inspection::rays`]; `None`: the camera.
    pub parent: Option<usize>,
    /// 1 for the primary ray; the depth of its parent plus 1 for others.
    pub depth: u32,
    /// Where it starts and goes, in world coordinates.
    pub ray: Ray,
    /// Its weight at the hit where it starts, red, green and blue: kr or kt of the body, or what the formula gives; 1
    /// for the primary ray.
    pub factor: [f32; 3],
    /// The weight of its path, red, green and blue: the product of the factors of the rays up to it.
    pub weight: [f64; 3],
    /// Where it ends.
    pub end: End,
    /// Light at its end, linear RGB. Of a hit: Σ ki·weight·local, with the weights of the samples of lights, plus
    /// ka·Cd·Ia or what the formula gives in its place, plus what the surface emits. Otherwise the background, plus
    /// ki·IL·radiance of the environment.
    pub own: [f32; 3],
    /// Light that it brings, linear RGB, by equation (2) of thesis 4.2.3: `own`, plus the light of its children times
    /// their factors.
    pub total: [f32; 3],
    /// What its end adds to the pixel, linear RGB: `weight`·`own`, and 0 where the weight is 0.
    pub contribution: [f32; 3],
}

/// Where a ray ends.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// Nowhere: it leaves the scene.
    Miss(InspectedMiss),
    /// On a body.
    Hit(Box<InspectedHit>),
}

/// What a ray that leaves the scene brings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InspectedMiss {
    /// The background, linear RGB.
    pub background: [f32; 3],
    /// The environment, if the scene has one.
    pub environment: Option<InspectedEnvironment>,
}

/// What a ray that leaves the scene sees of the environment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InspectedEnvironment {
    /// The light that it is.
    pub light: LightId,
    /// ki, its intensity.
    pub intensity: f32,
    /// IL, its colour, linear RGB.
    pub colour: [f32; 3],
    /// Its radiance from the direction of the ray, linear RGB.
    pub radiance: [f32; 3],
    /// ki·IL·radiance, linear RGB.
    pub contribution: [f32; 3],
}

/// A hit and everything that is added up there.
#[derive(Debug, Clone, PartialEq)]
pub struct InspectedHit {
    /// Which body, where, from which side, how far from the ray's start (f64, world units).
    pub surface: SurfaceHit,
    /// The variables that formulas read here.
    pub variables: HitVariables,
    /// The angle between the ray and the normal in degrees, 0..90.
    pub incidence: f64,
    /// How the ray is refracted; `None`: the body is opaque.
    pub crossing: Option<Crossing>,
    /// ka·Cd·Ia, or what the formula gives in its place, linear RGB.
    pub ambient: [f32; 3],
    /// What the surface emits, linear RGB, if the formula gives it.
    pub emission: Option<[f32; 3]>,
    /// The weights of the reflected and of the refracted ray, red, green and blue: kr and kt, or what the formula
    /// gives.
    pub weights: [[f32; 3]; 2],
    /// Every emitter of the scene, in the order of their lights.
    pub lights: Vec<InspectedLight>,
    /// The reflected ray.
    pub reflected: Onward,
    /// The refracted ray.
    pub refracted: Onward,
}

impl InspectedHit {
    /// The body.
    pub fn body(&self) -> BodyId {
        self.surface.body
    }
}

/// The passage through a surface by Snell's law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Whether the ray enters the body, from index 1; otherwise it leaves the body.
    pub entering: bool,
    /// n₁/n₂, greater than 0.
    pub n12: f64,
    /// The angle between the refracted ray and the normal in degrees, 0..90; `None`: total internal reflection.
    pub angle: Option<f64>,
}

impl Crossing {
    /// The critical angle in degrees, 0..90: beyond it all light is reflected; `None` where n12 is at most 1 and there
    /// is none.
    pub fn critical(&self) -> Option<f64> {
        (self.n12 > 1.0).then(|| (1.0 / self.n12).asin().to_degrees())
    }
}

/// Whether a child ray is followed, or why there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Onward {
    /// It is followed: an index into [`Inspection::rays`].
    Ray(usize),
    /// There is none: the body is matte.
    Matte,
    /// There is none: the body is opaque.
    Opaque,
    /// There is none: the angle of incidence is beyond the critical one.
    TotalReflection,
    /// It is not followed: the greatest depth is reached.
    Depth,
}

/// What a light does at a hit.
#[derive(Debug, Clone, PartialEq)]
pub struct InspectedLight {
    /// The light.
    pub light: LightId,
    /// Whether it reaches the hit.
    pub visibility: Visibility,
    /// Whether it adds the value of the formula: it reaches the hit, or the formula reads `visible`.
    pub evaluated: bool,
    /// The angle between the normal and the direction to the light in degrees, 0..180.
    pub angle: f64,
    /// Where the light comes from, and what it sends. Lights of many points or directions have another sample in each
    /// pass.
    pub sample: LightSample,
    /// The variables that formulas read here for this light, such as its distance.
    pub variables: LightVariables,
    /// ki, its intensity, in the range that the formula gives it: 0..1 if it gives none.
    pub intensity: f32,
    /// The value of the formula for it, with `IL` times the radiance of the sample, linear RGB, even if that is not
    /// added.
    pub local: [f32; 3],
    /// ki·weight·local with the weight of the sample, linear RGB; 0 if the formula is not evaluated for the light or ki
    /// is 0.
    pub contribution: [f32; 3],
}

/// Whether a light reaches a hit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Visibility {
    /// It does. Without shadow rays every light does that sends something there.
    Lit,
    /// It sends nothing there: the hit is outside the cone of a spot, or the map of the environment is black in the
    /// direction that was drawn.
    Dark,
    /// It is behind the surface: N·L ≤ 0. These bodies are in between, the nearest to the hit first: this one, if the
    /// light would have to pass through it.
    Away(Vec<BodyId>),
    /// These bodies are in between, the nearest to the hit first; there is at least one.
    Shadowed(Vec<BodyId>),
}

impl InspectedRay {
    /// Whether its path adds nothing: its weight is 0.
    pub fn is_cut(&self) -> bool {
        self.weight == [0.0; 3]
    }
}

impl Inspection {
    /// The hit of the ray of this index; `None` where there is no such ray, or it leaves the scene.
    pub fn hit(&self, ray: usize) -> Option<&InspectedHit> {
        match &self.rays.get(ray)?.end {
            End::Hit(hit) => Some(hit),
            End::Miss(_) => None,
        }
    }
}
