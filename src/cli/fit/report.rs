//! What `fit` prints.

use crate::cli::fit::FitOutcome;
use illuminator::fit::metric::Metric;
use illuminator::fit::unknowns::FitNumber;
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
    starts: Vec<StartReport>,
    /// At how many samples the formula is no finite number; it counts as 0 there.
    #[serde(skip_serializing_if = "Option::is_none")]
    not_finite: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<usize>,
    /// Arguments of `--set` that give these values.
    set: Vec<String>,
    cancelled: bool,
    seconds: f64,
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

/// How a number is called: as in `--set`, with a component for a vector.
fn name_of(project: &Project, number: &FitNumber) -> String {
    let table = project.values.table();
    let parameter = table.parameter(number.parameter);
    let owner = table.owners().of_kind(parameter.owner).nth(number.owner);
    let name = owner.map_or_else(|| parameter.name.clone(), |owner| table.label(owner, number.parameter));
    let component = ["r", "g", "b"][usize::from(number.component.min(2))];
    if parameter.ty.slots() == 3 { format!("{name}.{component}") } else { name }
}

impl FitReport {
    pub(super) fn new(model: &str, to: &str, metric: Metric, project: &Project, outcome: &FitOutcome) -> Self {
        let (unknowns, solution) = (&outcome.unknowns, &outcome.solution);
        let numbers = unknowns.numbers();
        let start = unknowns.start();
        let parameter = |(index, number): (usize, &FitNumber)| FittedReport {
            name: name_of(project, number),
            before: start[index],
            after: solution.values[index],
            deviation: solution.deviations.get(index).copied().flatten(),
            follows: index >= unknowns.free(),
            at_bound: (index < unknowns.free())
                .then(|| unknowns.bound_at(index, solution.values[index]))
                .flatten()
                .map(|bound| ["lower", "upper"][bound]),
        };
        let changed = |(owner, id, value): (illuminator::workspace::OwnerId, _, &[f32])| {
            let is_fitted = numbers.iter().any(|number| number.parameter == id && number.owner == owner.index());
            let differs = project.values.get(owner, id) != value;
            (is_fitted && differs).then(|| {
                let text = match value {
                    [one] => one.to_string(),
                    all => format!("<{}>", all.iter().map(f32::to_string).collect::<Vec<_>>().join(",")),
                };
                format!("{}={text}", project.values.table().label(owner, id))
            })
        };
        let start_report = |start: &illuminator::fit::solve::StartOutcome| StartReport {
            residual: start.residual,
            evaluations: start.evaluations,
            values: start.values.clone(),
        };
        let group = |group: &Vec<FitNumber>| group.iter().map(|number| name_of(project, number)).collect();
        Self {
            model: model.to_owned(),
            to: to.to_owned(),
            metric: metric.name,
            parameters: numbers.iter().enumerate().map(parameter).collect(),
            residual: ResidualReport { before: solution.residuals[0], after: solution.residuals[1] },
            undetermined: solution.undetermined.iter().map(group).collect(),
            stepwise: solution.stepwise.iter().map(|number| name_of(project, number)).collect(),
            starts: solution.starts.iter().map(start_report).collect(),
            not_finite: outcome.undefined.map(|[count, _]| count).filter(|count| *count > 0),
            samples: outcome.undefined.map(|[_, samples]| samples),
            set: outcome.values.iter().filter_map(changed).collect(),
            cancelled: solution.cancelled,
            seconds: outcome.seconds,
        }
    }
}

/// A number with about five digits.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if value.abs() < 1e-4 {
        return format!("{value:.1e}");
    }
    let digits = (4 - value.abs().log10().floor() as i32).clamp(0, 8) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The table.
pub(super) fn table(report: &FitReport) -> String {
    let mut text = format!("{}, fitted to {}\n\n", report.model, report.to);
    let width = report.parameters.iter().map(|parameter| parameter.name.chars().count()).max().unwrap_or(0).max(10);
    // Writing to a string does not fail.
    let _ = writeln!(text, "{:<width$}  {:>10}  {:>10}  {:>11}", "parameter", "before", "after", "deviation");
    for parameter in &report.parameters {
        let certainty = match parameter.deviation {
            _ if parameter.at_bound.is_some() => format!("{} bound", parameter.at_bound.unwrap_or_default()),
            Some(deviation) if deviation > 0.0 => format!("± {deviation:.1e}"),
            Some(_) => "exact".to_owned(),
            None if parameter.follows => "follows".to_owned(),
            None => "open".to_owned(),
        };
        let (before, after) = (short(parameter.before), short(parameter.after));
        let _ = writeln!(text, "{:<width$}  {before:>10}  {after:>10}  {certainty:>11}", parameter.name);
    }
    let ResidualReport { before, after } = report.residual;
    let what = if report.metric == "log" { "log(1 + …)" } else { "linear" };
    let _ = writeln!(text, "\nresidual (root mean square, {what}): {before:.3e} before, {after:.3e} after");
    let best = report.starts.iter().map(|start| start.residual).fold(f64::INFINITY, f64::min);
    let near = report.starts.iter().filter(|start| start.residual <= 1.01 * best + 1e-5 * before).count();
    let evaluations: usize = report.starts.iter().map(|start| start.evaluations).sum();
    let _ = writeln!(
        text,
        "{near} of {} starts came to this minimum, with {evaluations} evaluations in {:.2} s",
        report.starts.len(),
        report.seconds
    );
    for group in &report.undetermined {
        let _ = match group.as_slice() {
            [one] if report.stepwise.contains(one) => {
                writeln!(
                    text,
                    "{one} was not moved: it has an effect in steps only, such as a threshold; try values of it by --set"
                )
            }
            [one] => writeln!(text, "the data do not determine {one}: it has no effect on what is compared"),
            all => writeln!(text, "the data determine {} only together; hold one of them", all.join(", ")),
        };
    }
    if after > 0.9 * before && before > 0.0 && !report.cancelled {
        let _ = writeln!(
            text,
            "the residual hardly fell: do the data belong to this model, and are transfer, exposure and scene the same?"
        );
    }
    if let (Some(count), Some(samples)) = (report.not_finite, report.samples) {
        let _ = writeln!(text, "at {count} of {samples} samples the formula is no finite number; it counts as 0 there");
    }
    if !report.set.is_empty() {
        let arguments: Vec<String> = report.set.iter().map(|setting| format!("--set '{setting}'")).collect();
        let _ = writeln!(text, "\n{}", arguments.join(" "));
    }
    text
}
