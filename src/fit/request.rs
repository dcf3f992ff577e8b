//! Fits of the values of a project: which of them may move, how they are compared with data, and what comes out.

use crate::engine::{Engine, EngineError, Subject, Task};
use crate::fit::directions::{LARGEST_ANGLE, pairs};
use crate::fit::metric::Metric;
use crate::fit::picture::{PictureMisfit, TargetPicture};
use crate::fit::samples::{FitSample, SampleMisfit};
use crate::fit::solve::Solution;
use crate::fit::unknowns::{FitNumber, FreeParameter, Unknowns};
use crate::formula::{Formula, ParameterId, Term};
use crate::instrument::direction::brdf;
use crate::instrument::model::{FormulaModel, ModelProgram, Place};
use crate::instrument::{DirectionPair, Reflectance};
use crate::lang::ast::Constant;
use crate::lang::diagnostic::nearest;
use crate::lang::types::Type;
use crate::lang::variables::Owner;
use crate::measured::ReflectanceSamples;
use crate::picture::{Frame, ReadPicture, ToneCurve, ViewTransform};
use crate::sensitivity::Sensitivity;
use crate::trace::Hits;
use crate::workspace::assignment::parse_value;
use crate::workspace::{Assignment, OwnerId, ParameterTable, Values};
use std::str::FromStr;
use std::sync::Arc;
use thiserror::Error;

/// A parameter that may move, as a user names it: `kd`, `ball.kd`, or with bounds, `ball.kd=0..0.5`.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeName {
    /// The body or light; `None`: the one that is fitted.
    pub owner: Option<String>,
    /// The parameter.
    pub parameter: String,
    /// Bounds within those of the parameter.
    pub range: Option<[f32; 2]>,
}

/// Why a name stands for no parameter that can move.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FreeNameError {
    /// It is written in another way.
    #[error("expected a parameter such as kd, ball.kd or kd=0..0.5")]
    Form,
    /// There is no such parameter.
    #[error("the formula has no parameter `{0}`")]
    Parameter(String, String),
    /// There is no such body or light.
    #[error("the scene has no body or light `{0}`")]
    Owner(String, Option<String>),
    /// The owner has no such parameter.
    #[error("`{0}` has no parameter `{1}`; it is a {2} parameter")]
    Kind(String, String, &'static str),
    /// Nothing has the parameter.
    #[error("the scene has no {1} that `{0}` could belong to")]
    Nobody(String, &'static str),
}

impl FreeNameError {
    /// The likely fix.
    pub fn hint(&self) -> Option<String> {
        match self {
            FreeNameError::Parameter(_, hint) => Some(hint.clone()),
            FreeNameError::Owner(_, near) => near.as_ref().map(|near| format!("did you mean `{near}`?")),
            FreeNameError::Form | FreeNameError::Kind(..) | FreeNameError::Nobody(..) => None,
        }
    }
}

impl FromStr for FreeName {
    type Err = FreeNameError;

    fn from_str(text: &str) -> Result<Self, FreeNameError> {
        let (name, range) = match text.split_once('=') {
            Some((name, range)) => (name, Some(range)),
            None => (text, None),
        };
        let number = |text: &str| match parse_value(text) {
            Some(Constant::Scalar(number)) => Ok(number),
            Some(Constant::Vector(_)) | None => Err(FreeNameError::Form),
        };
        let range = range.map(|range| {
            let (low, high) = range.split_once("..").ok_or(FreeNameError::Form)?;
            Ok([number(low.trim())?, number(high.trim())?])
        });
        let (owner, parameter) = match name.trim().split_once('.') {
            Some((owner, parameter)) => (Some(owner.trim()), parameter.trim()),
            None => (None, name.trim()),
        };
        let is_name = |name: &str| !name.is_empty() && !name.contains(|c: char| c.is_whitespace() || c == '.');
        if !is_name(parameter) || !owner.is_none_or(is_name) {
            return Err(FreeNameError::Form);
        }
        Ok(Self { owner: owner.map(str::to_owned), parameter: parameter.to_owned(), range: range.transpose()? })
    }
}

/// The body and the light whose values are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FittedOwners {
    /// The body.
    pub body: Option<OwnerId>,
    /// The light.
    pub light: Option<OwnerId>,
}

impl FittedOwners {
    /// The owner of parameters of a kind.
    pub fn of_kind(self, kind: Owner) -> Option<OwnerId> {
        match kind {
            Owner::Global => Some(OwnerId::Global),
            Owner::Body => self.body,
            Owner::Light => self.light,
        }
    }
}

/// The parameter that a name stands for.
///
/// # Errors
/// There is no such parameter, body or light.
pub fn named(
    name: &FreeName,
    table: &ParameterTable,
    formula: &Formula,
    owners: FittedOwners,
) -> Result<FreeParameter, FreeNameError> {
    let Some(id) = table.parameter_named(&name.parameter) else {
        let names = || formula.parameters.iter().map(|parameter| parameter.name.as_str());
        let hint = match nearest(&name.parameter, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("its parameters are {}", names().collect::<Vec<_>>().join(", ")),
        };
        return Err(FreeNameError::Parameter(name.parameter.clone(), hint));
    };
    let kind = formula.parameter(id).owner;
    let owner = match &name.owner {
        None => owners.of_kind(kind).ok_or_else(|| FreeNameError::Nobody(name.parameter.clone(), kind.adjective()))?,
        Some(owner) => {
            let found = table.owners().named(owner).ok_or_else(|| {
                let near = nearest(owner, table.owners().names());
                FreeNameError::Owner(owner.clone(), near.map(str::to_owned))
            })?;
            if found.kind() != kind {
                return Err(FreeNameError::Kind(owner.clone(), name.parameter.clone(), kind.adjective()));
            }
            found
        }
    };
    Ok(FreeParameter { parameter: id, owner: owner.index(), range: name.range })
}

/// The parameters of the fitted body that are free if nobody says: those that the formula reads, that can move
/// smoothly, and that do not follow from others.
pub fn usual(table: &ParameterTable, formula: &Formula, owners: FittedOwners) -> Vec<FreeParameter> {
    let Some(body) = owners.body else { return Vec::new() };
    let used = formula.terms_of(formula.result);
    let reads = |id: ParameterId| used.iter().any(|term| *formula.term(*term) == Term::Parameter(id));
    let is_free = |id: &ParameterId| {
        let parameter = formula.parameter(*id);
        let smooth = parameter.ty != Type::Texture && !parameter.is_whole();
        let wide = parameter.range.is_none_or(|[low, high]| low < high);
        smooth && wide && !table.system(Owner::Body).is_locked(*id) && reads(*id)
    };
    let found = table.parameters_of(Owner::Body).filter(is_free);
    found.map(|parameter| FreeParameter { parameter, owner: body.index(), range: None }).collect()
}

/// The unknowns of a project where these parameters are free.
///
/// # Errors
/// See [`Unknowns::new`].
pub fn unknowns(
    free: &[FreeParameter],
    formula: &Formula,
    values: &Values,
) -> Result<Unknowns, crate::fit::unknowns::UnknownsError> {
    Unknowns::new(formula, free, &|id, owner| value_of(values, formula, id, owner))
}

/// The value of a parameter of the owner with an index. A scalar is repeated three times.
fn value_of(values: &Values, formula: &Formula, id: ParameterId, owner: usize) -> [f32; 3] {
    let kind = formula.parameter(id).owner;
    let owner = values.table().owners().of_kind(kind).nth(owner);
    match owner.map(|owner| values.get(owner, id)) {
        Some([x, y, z]) => [*x, *y, *z],
        Some(own) => [own.first().copied().unwrap_or_default(); 3],
        None => [0.0; 3],
    }
}

/// The misfit of a formula with the values of a project to samples of reflectance.
pub fn sample_misfit(
    formula: &Formula,
    values: &Values,
    owners: FittedOwners,
    unknowns: &Unknowns,
    samples: &[FitSample],
    metric: Metric,
) -> SampleMisfit {
    let numbers = values.of_surface(formula, [owners.body, owners.light]);
    SampleMisfit::new(formula, numbers, &Place::default(), unknowns.numbers(), samples, metric)
}

/// How much the reflectance of a formula changes when light and view change places: the mean change as a share of the
/// mean reflectance, 0 for a reciprocal one.
pub fn asymmetry(formula: &Formula, values: &Values, owners: FittedOwners) -> f64 {
    const PAIRS: usize = 500;
    let numbers = values.of_surface(formula, [owners.body, owners.light]);
    let model = FormulaModel::new(Arc::new(ModelProgram::new(formula)), numbers, Place::default());
    let pairs = pairs(PAIRS, LARGEST_ANGLE);
    let there: Vec<DirectionPair> = pairs.iter().map(|weighted| weighted.pair).collect();
    let back: Vec<DirectionPair> = there.iter().map(DirectionPair::exchanged).collect();
    let brdfs = |pairs: &[DirectionPair]| -> Vec<[f64; 3]> {
        pairs.iter().zip(model.values(pairs)).map(|(pair, value)| brdf(pair, value)).collect()
    };
    let [there, back] = [&there, &back].map(|pairs| brdfs(pairs));
    let (mut change, mut sum) = (0.0, 0.0);
    for ((there, back), weighted) in there.iter().zip(&back).zip(&pairs) {
        for (there, back) in there.iter().zip(back).filter(|(there, back)| there.is_finite() && back.is_finite()) {
            change += weighted.weight * (there - back).abs();
            sum += weighted.weight * 0.5 * (there + back).abs();
        }
    }
    if sum > 0.0 { change / sum } else { 0.0 }
}

/// The samples of a list, which all count the same.
pub fn listed_samples(list: &ReflectanceSamples) -> Vec<FitSample> {
    let sample = |sample: &crate::measured::ReflectanceSample| FitSample {
        pair: DirectionPair { light: sample.light.as_vec3().to_array(), view: sample.view.as_vec3().to_array() },
        value: (sample.value * sample.light.z).to_array(),
        weight: 1.0,
    };
    list.samples.iter().map(sample).collect()
}

/// The misfit of the picture of a project to another picture, with the hits of its passes.
///
/// # Errors
/// The formula or its derivative is too large for the backend, or memory does not suffice.
pub fn picture_misfit(
    engine: &Engine,
    subject: &Subject,
    hits: &[Arc<Hits>],
    values: &Values,
    unknowns: &Unknowns,
    (target, metric): (TargetPicture, Metric),
) -> Result<PictureMisfit, EngineError> {
    let numbers = unknowns.numbers();
    let mut moving: Vec<ParameterId> = numbers.iter().map(|number| number.parameter).collect();
    moving.dedup();
    let sensitivity = Sensitivity::new(engine, subject, hits, &moving, values.numbers())?;
    let layout = values.table().layout();
    let index = |number: &FitNumber| {
        layout.index(subject.formula.parameter(number.parameter), number.owner) + usize::from(number.component)
    };
    let indices = numbers.iter().map(index).collect();
    Ok(PictureMisfit::new(sensitivity, values.numbers().to_vec(), indices, target, metric))
}

/// Traces the passes of a picture.
///
/// # Errors
/// Memory does not suffice, or the task was cancelled.
pub fn traced(engine: &Engine, subject: &Subject, passes: u32, task: &Task) -> Result<Vec<Arc<Hits>>, EngineError> {
    let count = passes.max(1);
    (0..count)
        .map(|pass| {
            let view = subject.view.with_pass(subject.view.pass() + pass);
            let tell = |share: f64| (task.progress)((f64::from(pass) + share) / f64::from(count));
            engine.trace(&Subject { view, ..subject.clone() }, &Task { progress: &tell, ..*task })
        })
        .collect()
}

/// The linear colours of a picture that was read. A file of bytes was made with this view transform.
///
/// # Errors
/// The view transform has a tone curve, which cannot be undone.
pub fn target(read: ReadPicture, view: &ViewTransform) -> Result<TargetPicture, String> {
    let ReadPicture { mut numbers, is_linear } = read;
    if !is_linear {
        if view.curve != ToneCurve::None {
            return Err(format!(
                "the tone curve `{}` of its colours cannot be undone; fit to an OpenEXR file",
                view.curve.name()
            ));
        }
        for component in numbers.linear.as_flattened_mut() {
            *component = (view.transfer.decode(f64::from(*component)) / view.factor()) as f32;
        }
    }
    let end = (!is_linear).then(|| (1.0 / view.factor()) as f32);
    Ok(TargetPicture { frame: numbers, end })
}

/// The values of a project where the unknown ones have those of a solution.
pub fn fitted(values: &Values, unknowns: &Unknowns, solution: &Solution) -> Values {
    let mut result = values.clone();
    let mut assignments: Vec<Assignment> = Vec::new();
    for (number, value) in unknowns.numbers().iter().zip(&solution.values).take(unknowns.free()) {
        let kind = values.table().parameter(number.parameter).owner;
        let Some(owner) = values.table().owners().of_kind(kind).nth(number.owner) else { continue };
        let same = |assignment: &Assignment| assignment.owner == owner && assignment.parameter == number.parameter;
        let index = assignments.iter().position(same).unwrap_or_else(|| {
            let own = values.get(owner, number.parameter);
            let mut value = [0.0; 3];
            value[..own.len()].copy_from_slice(own);
            assignments.push(Assignment { owner, parameter: number.parameter, value });
            assignments.len() - 1
        });
        assignments[index].value[usize::from(number.component)] = *value as f32;
    }
    // Together, so that none has to give way to an old value of another one.
    result.assign(&assignments);
    result
}

/// The differences of two pictures of one size.
pub fn difference(one: &Frame, other: &Frame) -> Vec<f64> {
    let pixel = |(one, other): (&[f32; 3], &[f32; 3])| {
        let components = one.iter().zip(other).map(|(one, other)| f64::from((one - other).abs()));
        components.fold(0.0, f64::max)
    };
    one.linear.iter().zip(&other.linear).map(pixel).collect()
}
