//! `illuminator render`: writes a picture to a file, or to standard output.

use crate::cli::engine;
use crate::cli::input::load;
use crate::cli::options::{InputOptions, PictureOptions};
use crate::cli::output::{PictureTarget, check_distinct};
use crate::cli::report::{Failure, print_bytes, warn_of_picture};
use clap::Args;
use illuminator::picture::{Format, file_bytes, save};
use std::path::PathBuf;

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
}

/// Makes the picture.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
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
    let mut frame = engine::on_threads(machine, || engine::picture(&input, options.picture.backend(), machine))??;
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
