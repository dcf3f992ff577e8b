//! Why a picture is black, or all of one colour.

use super::{PictureSummary, ReviewedPicture};
use crate::evaluate::inspect::{Inspection, Inspector, Visibility, figures};
use crate::formula::layout::Layout;
use crate::formula::{Parameter, ParameterId};
use crate::lang::variables::{Owner, Predefined};
use crate::scene::{BodyId, Scene};
use crate::trace::Tracer;
use crate::world::{Side, SurfaceHit};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fmt;

/// How many primary rays are looked at first, in each direction of the picture.
const GRID: u32 = 64;
/// How many pixels with a body are looked into.
const LOOKED_INTO: usize = 48;
/// The most names in a sentence.
const FEW: usize = 6;

/// Why a picture is black, or all of one colour.
#[derive(Debug, Clone, PartialEq)]
pub enum PlainCause {
    /// No primary ray meets a body, so every pixel is the background, and the environment if there is one.
    NoBodySeen {
        /// Whether the scene has bodies.
        has_bodies: bool,
        /// Whether the scene has an environment, which is seen too.
        has_environment: bool,
    },
    /// The camera is inside this body.
    InsideBody(String),
    /// The largest component is greater than 0 but too small to be shown. An exposure of this many stops shows it.
    TooDark(f32, f32),
    /// The components are negative, the smallest one is this.
    Negative(f32),
    /// The scene has no lights.
    NoLights,
    /// No light reaches what is seen. These are the reasons that were found.
    Unlit(BTreeSet<UnlitReason>),
    /// Values of 0: with other values of any of these parameters, or of all of them, something is seen.
    Zero {
        /// The parameters.
        names: Vec<String>,
        /// Whether each of them alone is enough.
        each: bool,
    },
    /// The formula gives 0 at every point that was looked at.
    FormulaIsZero,
    /// None of these.
    Unknown,
}

/// Why a light does not reach what is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum UnlitReason {
    /// It is behind a surface.
    Behind,
    /// Bodies are in between.
    Between,
    /// It is a spot whose cone is elsewhere.
    Elsewhere,
    /// It is an environment that is black.
    BlackEnvironment,
}

impl fmt::Display for UnlitReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            UnlitReason::Behind => "lights are behind the surfaces",
            UnlitReason::Between => "bodies are in between",
            UnlitReason::Elsewhere => "spots shine elsewhere",
            UnlitReason::BlackEnvironment => "the image of the environment is black",
        })
    }
}

impl fmt::Display for PlainCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PlainCause::NoBodySeen { has_bodies, has_environment } => f.write_str(match (has_bodies, has_environment) {
                (true, false) => "the camera sees no body, only the background",
                (true, true) => "the camera sees no body, only the environment and the background",
                (false, false) => "the scene has no bodies, so only the background is seen",
                (false, true) => "the scene has no bodies, so only the environment and the background are seen",
            }),
            PlainCause::InsideBody(name) => write!(f, "the camera is inside the body {name}"),
            PlainCause::TooDark(largest, stops) => {
                write!(
                    f,
                    "its largest component is {}, too dark to be seen; an exposure of {} shows it",
                    figures(f64::from(*largest)),
                    figures(f64::from(*stops))
                )
            }
            PlainCause::Negative(smallest) => {
                write!(f, "the formula gives negative numbers, down to {}", figures(f64::from(*smallest)))
            }
            PlainCause::NoLights => f.write_str("the scene has no lights"),
            PlainCause::Unlit(reasons) => {
                let reasons: Vec<String> = reasons.iter().map(UnlitReason::to_string).collect();
                write!(f, "no light reaches what is seen: {}", reasons.join(", "))
            }
            PlainCause::Zero { names, each } => zero(f, names, *each),
            PlainCause::FormulaIsZero => f.write_str("the formula gives 0 wherever light falls on what is seen"),
            PlainCause::Unknown => f.write_str("no cause was found"),
        }
    }
}

/// That the values of some parameters are 0.
fn zero(f: &mut fmt::Formatter<'_>, names: &[String], each: bool) -> fmt::Result {
    let others = match names.len().saturating_sub(FEW) {
        0 => String::new(),
        more => format!(" and {more} others"),
    };
    let listed = names[..names.len().min(FEW)].join(", ");
    match (names.len(), each) {
        (1, _) => write!(f, "{listed} is 0 everywhere"),
        (_, true) => write!(f, "{listed}{others} are 0 everywhere; another value of any of them shows something"),
        (_, false) => write!(f, "{listed}{others} are all 0 everywhere"),
    }
}

/// Why a picture is black.
pub(super) fn of_black(picture: &ReviewedPicture, summary: &PictureSummary) -> PlainCause {
    let [smallest, largest] = summary.range;
    if largest > 0.0 {
        // Half of the range of what is shown.
        return PlainCause::TooDark(largest, (0.5 / largest).log2().ceil());
    }
    if smallest < 0.0 {
        return PlainCause::Negative(smallest);
    }
    let hits = match visible(picture) {
        Ok(hits) => hits,
        Err(cause) => return cause,
    };
    let step = hits.len().div_ceil(LOOKED_INTO).max(1);
    let pixels: Vec<[u32; 2]> = hits.iter().step_by(step).map(|(pixel, _)| *pixel).collect();
    let seen: BTreeSet<BodyId> = hits.iter().map(|(_, hit)| hit.body).collect();
    let inspector = Inspector::new(picture.formula, picture.world, picture.numbers);
    if picture.world.scene().lights.is_empty() {
        return PlainCause::NoLights;
    }
    let mut reasons = BTreeSet::new();
    let mut inspections = pixels.iter().filter_map(|pixel| inspector.inspect(picture.view, *pixel));
    if !inspections.any(|inspection| is_lit(picture.world.scene(), &inspection, &mut reasons)) {
        return PlainCause::Unlit(reasons);
    }
    zero_parameters(picture, &seen, &pixels).unwrap_or(PlainCause::FormulaIsZero)
}

/// Why all pixels have one colour.
pub(super) fn of_one_colour(picture: &ReviewedPicture) -> PlainCause {
    visible(picture).err().unwrap_or(PlainCause::Unknown)
}

/// The pixels of a grid in which bodies are seen.
///
/// # Errors
/// No body is seen, or the camera is inside one.
fn visible(picture: &ReviewedPicture) -> Result<Vec<([u32; 2], SurfaceHit)>, PlainCause> {
    let (view, world) = (picture.view, picture.world);
    let tracer = Tracer::new(world, view);
    let [columns, rows] = [view.width(), view.height()].map(|side| side.min(GRID));
    let on_grid =
        |index: u32, count: u32, side: u32| ((2 * u64::from(index) + 1) * u64::from(side) / (2 * u64::from(count))) as u32;
    let pixels = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
    let pixels = pixels.map(|[column, row]| [on_grid(column, columns, view.width()), on_grid(row, rows, view.height())]);
    let hits: Vec<([u32; 2], SurfaceHit)> =
        pixels.filter_map(|pixel @ [x, y]| tracer.hit(&tracer.primary(y * view.width() + x)).map(|hit| (pixel, hit))).collect();
    let Some((_, first)) = hits.first() else {
        // A small body may be between the rays of the grid.
        let found =
            (0..view.pixels()).into_par_iter().find_map_any(|pixel| tracer.hit(&tracer.primary(pixel)).map(|hit| (pixel, hit)));
        let at = |pixel: u32| [pixel % view.width(), pixel / view.width()];
        let (has_bodies, has_environment) = (!world.scene().bodies.is_empty(), world.environment().is_some());
        return found.map(|(pixel, hit)| vec![(at(pixel), hit)]).ok_or(PlainCause::NoBodySeen { has_bodies, has_environment });
    };
    let (camera, bounds) = (world.scene().camera.position(), world.bounds(first.body));
    let is_inside = camera.cmpgt(bounds.low).all() && camera.cmplt(bounds.high).all();
    if is_inside && hits.iter().all(|(_, hit)| (hit.body, hit.side) == (first.body, Side::Back)) {
        return Err(PlainCause::InsideBody(world.scene().body(first.body).name.clone()));
    }
    Ok(hits)
}

/// Whether a light reaches a hit of a pixel. If none does, the reasons are added.
fn is_lit(scene: &Scene, inspection: &Inspection, reasons: &mut BTreeSet<UnlitReason>) -> bool {
    let hits = (0..inspection.rays.len()).filter_map(|ray| inspection.hit(ray));
    let mut lights = hits.flat_map(|hit| &hit.lights);
    lights.any(|light| {
        reasons.insert(match light.visibility {
            Visibility::Lit => return true,
            Visibility::Away(_) => UnlitReason::Behind,
            Visibility::Shadowed(_) => UnlitReason::Between,
            Visibility::Dark if scene.light(light.light).kind.environment().is_some() => UnlitReason::BlackEnvironment,
            Visibility::Dark => UnlitReason::Elsewhere,
        });
        false
    })
}

/// The parameters that are 0 for all owners that matter, and with which the pixels are not black.
fn zero_parameters(picture: &ReviewedPicture, seen: &BTreeSet<BodyId>, pixels: &[[u32; 2]]) -> Option<PlainCause> {
    let formula = picture.formula;
    let background = formula.predefined(Predefined::Background);
    let all_zero = |id: &ParameterId| {
        let indices = numbers_of(picture, formula.parameter(*id), seen);
        !indices.is_empty() && indices.iter().all(|index| picture.numbers[*index] == 0.0)
    };
    let mut zero: Vec<ParameterId> = formula.parameter_ids().filter(|id| *id != background).filter(all_zero).collect();
    // Ambient light is seldom what is missed.
    let ambient = [Predefined::Ambient, Predefined::AmbientColour].map(|predefined| formula.predefined(predefined));
    zero.sort_by_key(|id| ambient.contains(id));
    let shows = |raised: &[ParameterId]| {
        let mut numbers = picture.numbers.to_vec();
        for id in raised {
            let parameter = formula.parameter(*id);
            // Large values of parameters without a range may have no meaning.
            let value = parameter.range.map_or(1.0, |[_, high]| high.min(1.0));
            numbers_of(picture, parameter, seen).into_iter().for_each(|index| numbers[index] = value);
        }
        let inspector = Inspector::new(formula, picture.world, &numbers);
        let totals = pixels.iter().filter_map(|pixel| inspector.inspect(picture.view, *pixel)).map(|pixel| pixel.total);
        totals.into_iter().flatten().any(|component| component > 0.0)
    };
    let names = |ids: &[ParameterId]| ids.iter().map(|id| formula.parameter(*id).name.clone()).collect();
    let alone: Vec<ParameterId> = zero.iter().copied().filter(|id| shows(&[*id])).collect();
    if alone.iter().any(|id| !ambient.contains(id)) {
        return Some(PlainCause::Zero { names: names(&alone), each: true });
    }
    // Without those that are not needed, and without ambient light, which shows any body.
    let mut needed: Vec<ParameterId> = zero.into_iter().filter(|id| !ambient.contains(id)).collect();
    if !shows(&needed) {
        return None;
    }
    for id in needed.clone() {
        let rest: Vec<ParameterId> = needed.iter().copied().filter(|other| *other != id).collect();
        if shows(&rest) {
            needed = rest;
        }
    }
    Some(PlainCause::Zero { names: names(&needed), each: false })
}

/// The indices of the numbers of a parameter, for all owners that matter: of bodies, those that are seen.
fn numbers_of(picture: &ReviewedPicture, parameter: &Parameter, seen: &BTreeSet<BodyId>) -> Vec<usize> {
    let scene = picture.world.scene();
    let layout = Layout::new(picture.formula, scene.bodies.len(), scene.lights.len());
    let owners: Vec<usize> = match parameter.owner {
        Owner::Global => vec![0],
        Owner::Body => seen.iter().map(|body| body.index()).collect(),
        Owner::Light => (0..scene.lights.len()).collect(),
    };
    let first = |owner: usize| layout.index(parameter, owner);
    owners.into_iter().flat_map(|owner| first(owner)..first(owner) + parameter.ty.slots()).collect()
}
