//! What `fit` prints.

use crate::cli::fit::FitOutcome;
use illuminator::fit::metric::Metric;
use illuminator::fit::unknowns::FitNumber;
use illuminator::fit::words::{self, LoneEffect, name_of, short};
use illuminator::workspace::project::Project;
use serde::Serialize;
use std::fmt::Write;

/// The result of a fit, as JSON.
#[derive(Serialize)]
pub(super) struct FitReport {
    /// The formula, with the names of body and light.
    model: String,
    /// The file that it was fitted to.
    to: String,
    metric: &'static str,
    parameters: Vec<FittedReport>,
    residual: ResidualReport,
    /// Names that the data determine only together, or, alone in a group, not at all.
    undetermined: Vec<Vec<String>>,
    /// Those of them that have an effect in steps, so that they could not be moved smoothly.
    stepwise: Vec<String>,
    /// Those of them that have no effect at these values, but one elsewhere in their range.
    elsewhere: Vec<String>,
    /// The invariants that bind, as conditions.
    binding: Vec<String>,
    starts: Vec<StartReport>,
    /// At how many samples the formula is no finite number; it counts as 0 there.
    #[serde(skip_serializing_if = "Option::is_none")]
    not_finite: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<usize>,
    /// How much the formula changes when light and view change places, as a share, if the data cannot.
    #[serde(skip_serializing_if = "Option::is_none")]
    asymmetry: Option<f64>,
    /// Arguments of `--set` that give these values.
    set: Vec<String>,
    cancelled: bool,
    seconds: f64,
    #[serde(skip)]
    is_picture: bool,
}

/// A number that was fitted, or that follows by an invariant.
#[derive(Serialize)]
struct FittedReport {
    name: String,
    before: f64,
    after: f64,
    /// Its standard deviation, if the residuals are noise; none if it is not determined.
    deviation: Option<f64>,
    /// Whether it follows from others.
    follows: bool,
    /// The bound of its range at which it stands.
    #[serde(skip_serializing_if = "Option::is_none")]
    at_bound: Option<&'static str>,
}

/// Root mean squares of residuals, in what the metric compares.
#[derive(Serialize)]
struct ResidualReport {
    before: f64,
    after: f64,
}

#[derive(Serialize)]
struct StartReport {
    residual: f64,
    evaluations: usize,
    values: Vec<f64>,
}

impl FitReport {
    pub(super) fn new(model: &str, to: &str, metric: Metric, project: &Project, outcome: &FitOutcome) -> Self {
        let (unknowns, solution) = (&outcome.unknowns, &outcome.solution);
        let numbers = unknowns.numbers();
        let start = unknowns.start();
        let parameter = |(index, number): (usize, &FitNumber)| FittedReport {
            name: name_of(project.values.table(), number),
            before: start[index],
            after: solution.values[index],
            deviation: solution.deviations.get(index).copied().flatten(),
            follows: index >= unknowns.free(),
            at_bound: words::bound(solution, index),
        };
        let changed = |(owner, id, value): (illuminator::workspace::OwnerId, _, &[f32])| {
            let is_fitted = numbers.iter().any(|number| number.parameter == id && number.owner == owner.index());
            let differs = project.values.get(owner, id) != value;
            (is_fitted && differs).then(|| {
                let text = match value {
                    [one] => one.to_string(),
                    all => format!("<{}>", all.iter().map(f32::to_string).collect::<Vec<_>>().join(",")),
                };
                match outcome.is_alone {
                    true => format!("*.{}={text}", project.values.table().parameter(id).name),
                    false => format!("{}={text}", project.values.table().label(owner, id)),
                }
            })
        };
        let start_report = |start: &illuminator::fit::solve::StartOutcome| StartReport {
            residual: start.residual,
            evaluations: start.evaluations,
            values: start.values.clone(),
        };
        let group = |group: &Vec<FitNumber>| group.iter().map(|number| name_of(project.values.table(), number)).collect();
        Self {
            model: model.to_owned(),
            to: to.to_owned(),
            metric: metric.name,
            parameters: numbers.iter().enumerate().map(parameter).collect(),
            residual: ResidualReport { before: solution.residuals[0], after: solution.residuals[1] },
            undetermined: solution.undetermined.iter().map(group).collect(),
            stepwise: group(&solution.stepwise),
            elsewhere: group(&solution.elsewhere),
            binding: words::binding(project.values.table(), solution),
            starts: solution.starts.iter().map(start_report).collect(),
            not_finite: outcome.undefined.map(|[count, _]| count).filter(|count| *count > 0),
            samples: outcome.undefined.map(|[_, samples]| samples),
            asymmetry: outcome.asymmetry,
            set: outcome.values.iter().filter_map(changed).collect(),
            cancelled: solution.cancelled,
            seconds: outcome.seconds,
            is_picture: outcome.pictures.is_some(),
        }
    }
}

/// The table.
pub(super) fn table(report: &FitReport) -> String {
    let mut text = format!("{}, fitted to {}\n\n", report.model, report.to);
    let width = report.parameters.iter().map(|parameter| parameter.name.chars().count()).max().unwrap_or(0).max(10);
    // Writing to a string does not fail.
    let _ = writeln!(text, "{:<width$}  {:>10}  {:>10}  {:>11}", "parameter", "before", "after", "deviation");
    for parameter in &report.parameters {
        let certainty = words::certainty(parameter.deviation, parameter.follows, parameter.at_bound);
        let (before, after) = (short(parameter.before), short(parameter.after));
        let _ = writeln!(text, "{:<width$}  {before:>10}  {after:>10}  {certainty:>11}", parameter.name);
    }
    let ResidualReport { before, after } = report.residual;
    let what = if report.metric == "log" { "log(1 + …)" } else { "linear" };
    let _ = writeln!(text, "\nresidual (root mean square, {what}): {before:.3e} before, {after:.3e} after");
    let starts: Vec<(f64, usize)> = report.starts.iter().map(|start| (start.residual, start.evaluations)).collect();
    let _ = writeln!(text, "{}", words::starts(&starts, before, report.seconds));
    for condition in &report.binding {
        let _ = writeln!(text, "{}", words::binds(condition));
    }
    let effect = |group: &Vec<String>| (group.clone(), LoneEffect::of_group(group, &report.stepwise, &report.elsewhere));
    for sentence in words::undetermined(&report.undetermined.iter().map(effect).collect::<Vec<_>>()) {
        let _ = writeln!(text, "{sentence}");
    }
    if !report.cancelled {
        let _ = words::hardly_fell([before, after], report.is_picture).map(|words| writeln!(text, "{words}"));
    }
    if let Some(words) = report.asymmetry.and_then(words::one_way) {
        let _ = writeln!(text, "{words}");
    }
    if let (Some(count), Some(samples)) = (report.not_finite, report.samples) {
        let _ = writeln!(text, "{}", words::undefined(count, samples));
    }
    if !report.set.is_empty() {
        let arguments: Vec<String> = report.set.iter().map(|setting| format!("--set '{setting}'")).collect();
        let _ = writeln!(text, "\n{}", arguments.join(" "));
    }
    text
}
