//! `illuminator verify`: whether the backends agree, in the mean of the passes of a picture.

use crate::cli::engine;
use crate::cli::input::load;
use crate::cli::options::{BackendOptions, InputOptions, PassOptions};
use crate::cli::report::{Failure, print, warn_of_picture};
use clap::Args;
use illuminator::backends::REFERENCE;
use illuminator::backends::verify::{TOLERANCE, Verification, verify_pictures};

/// Options of `verify`.
#[derive(Args, Debug)]
pub(super) struct Options {
    #[command(flatten)]
    input: InputOptions,
    #[command(flatten)]
    passes: PassOptions,
    #[command(flatten)]
    backend: BackendOptions,
}

/// Compares a backend with the reference interpreter. It is a failure if they differ.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let input = load(&options.input, &options.passes)?;
    let machine = &options.input.machine;
    let passes = input.picture.passes();
    let verification = engine::on_threads(machine, || {
        let compiled = engine::picture(&input, &options.backend.backend, machine)?;
        warn_of_picture(&input, &compiled, input.picture.view);
        let interpreted = engine::picture(&input, &REFERENCE, machine)?;
        let reference = engine::interpreter(&input.subject)?.with_passes(passes);
        Ok::<_, Failure>(verify_pictures([&compiled, &interpreted], &reference, input.values.numbers()))
    })??;
    print(&describe(&verification, options.backend.backend.name, passes, input.subject.view.width()))?;
    if verification.passes() { Ok(()) } else { Err(Failure::Reported) }
}

fn describe(found: &Verification, backend: &str, passes: u32, width: u32) -> String {
    let share = |count: usize| 100.0 * count as f64 / found.components.max(1) as f64;
    let counted = |what: &str, count: usize| format!("{what:<34}{count:>10}  {:.4} %\n", share(count));
    let mut text = format!("{:<34}{:>10}\n", "components compared", found.components);
    if passes > 1 {
        text.push_str(&format!("{:<34}{passes:>10}\n", "each the mean of passes"));
    }
    let worst = match &found.worst {
        None => "none".to_owned(),
        Some(worst) => {
            let (row, column) = (worst.pixel / width as usize, worst.pixel % width as usize);
            let colour = ["red", "green", "blue"].get(worst.component).unwrap_or(&"");
            let values = format!("{backend} {}, interpreter {}", worst.compiled, worst.interpreted);
            format!("{:.3e} in {colour} of pixel ({column}, {row}): {values}", worst.size())
        }
    };
    text.push_str(&format!("{:<34}{worst}\n", "largest difference"));
    text.push_str(&format!("{:<34}{:>10}\n", "pixels with NaN", found.nan_pixels));
    text.push_str(&counted(&format!("beyond {TOLERANCE:e}"), found.failed));
    text.push_str(&counted("excused: the formula is unstable", found.excused));
    text.push_str(&counted("one step apart in 8 bits", found.one_step));
    text.push_str(&counted("more steps apart", found.more_steps));
    text.push_str(if found.passes() { "pass\n" } else { "FAIL\n" });
    text
}
