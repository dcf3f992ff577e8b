//! `illuminator render`: writes a picture to a file, or to standard output.

mod parts;

use crate::cli::engine;
use crate::cli::farm::FarmOptions;
use crate::cli::input::load;
use crate::cli::options::{InputOptions, PictureOptions};
use crate::cli::output::{PictureTarget, check_distinct};
use crate::cli::report::{Failure, print_bytes, warn_of_picture};
use clap::Args;
use illuminator::picture::{Format, file_bytes, save};
use parts::PassesInParts;
use std::path::PathBuf;
use std::time::Instant;

/// Options of `render`.
#[derive(Args, Debug)]
pub(super) struct Options {
    #[command(flatten)]
    input: InputOptions,
    #[command(flatten)]
    picture: PictureOptions,
    /// Picture file: .png, .bmp, or .exr for linear unclamped floats; - writes PNG to standard output
    #[arg(long = "output", short, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    farm: FarmOptions,
}

/// Makes the picture.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let start = Instant::now();
    let target = PictureTarget::new(&options.output)?;
    let format = target.format();
    if format == Format::Exr {
        options.picture.warn_of_linear_files();
    }
    let input = load(&options.input, &options.picture.passes)?;
    if let PictureTarget::File(path, _) = target {
        check_distinct(path, &input.files)?;
    }
    let machine = &options.input.machine;
    let work = || PassesInParts::new(options, &input, &target);
    let mut frame = if let Some(kind) = options.farm.job {
        return work()?.write_job(kind, start);
    } else if let Some(part) = options.farm.part {
        return work()?.make_part(part);
    } else if options.farm.merge {
        work()?.merge()?
    } else {
        engine::on_threads(machine, || engine::picture(&input, options.picture.backend(), machine))??
    };
    let view = options.picture.view(input.picture.view);
    warn_of_picture(&input, &frame, view);
    frame.clean();
    match target {
        PictureTarget::File(path, _) => save(path, &frame, view).map_err(Failure::input),
        PictureTarget::StandardOutput => {
            let bytes = file_bytes(&frame, format, view);
            print_bytes(&bytes.map_err(|error| Failure::input(format!("cannot write the picture: {error}")))?)
        }
    }
}
