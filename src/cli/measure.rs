//! `illuminator measure`: whether a formula conserves energy, and what else its numbers are.

mod report;
mod text;

use crate::cli::engine::on_threads;
use crate::cli::model::ModelOptions;
use crate::cli::report::{Failure, print, print_json};
use clap::Args;
use illuminator::instrument::expressions::expression_ranges;
use illuminator::instrument::measurement::ModelMeasurement;
use report::MeasurementReport;

/// Options of `measure`.
#[derive(Args, Debug)]
pub(super) struct Options {
    #[command(flatten)]
    model: ModelOptions,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Measures and reports.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let opened = options.model.open()?;
    let report = on_threads(&options.model.machine, || {
        let measured = ModelMeasurement::of(opened.named.model.as_ref());
        let valued = opened.valued.as_ref();
        let (expressions, pairs) =
            valued.map_or_else(Default::default, |valued| expression_ranges(&valued.formula, &valued.numbers));
        MeasurementReport::new(&opened.described, &measured, &expressions, pairs)
    })?;
    if options.json { print_json(&report) } else { print(&text::table(&report)) }
}
