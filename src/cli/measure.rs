//! `illuminator measure`: whether a formula conserves energy, and what else its numbers are.

mod report;
mod settings;
mod text;

use crate::cli::engine::on_threads;
use crate::cli::model::{ModelOptions, ValuedFormula};
use crate::cli::report::{Failure, print, print_json, warn};
use clap::Args;
use illuminator::instrument::expressions::expression_ranges;
use illuminator::instrument::measurement::ModelMeasurement;
use report::MeasurementReport;
use settings::over_ranges;

/// Options of `measure`.
#[derive(Args, Debug)]
pub(super) struct Options {
    #[command(flatten)]
    model: ModelOptions,
    /// Also look at the corners of the ranges of all parameters, and at settings between them
    #[arg(long)]
    all: bool,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Measures and reports.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let opened = options.model.open()?;
    let valued = opened.valued.as_ref();
    if options.all && valued.is_none() {
        warn("`--all` changes nothing: a measured material has no parameters");
    }
    let report = on_threads(&options.model.machine, || {
        let measured = ModelMeasurement::of(opened.named.model.as_ref());
        let ranges = |valued: &ValuedFormula| expression_ranges(&valued.formula, &valued.numbers(&valued.values), &valued.place);
        let (expressions, pairs) = valued.map(ranges).unwrap_or_default();
        let findings = valued.filter(|_| options.all).map(over_ranges);
        MeasurementReport::new(&opened.described, &measured, (&expressions, pairs), findings)
    })?;
    if options.json { print_json(&report) } else { print(&text::table(&report)) }
}
