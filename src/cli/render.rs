//! `illuminator render`: writes a picture to a file, or to standard output.

use crate::cli::engine;
use crate::cli::input::load;
use crate::cli::options::InputOptions;
use crate::cli::output::{PictureTarget, check_distinct};
use crate::cli::report::{Failure, print_bytes, warn};
use clap::Args;
use illuminator::backends::{BackendChoice, CHOICES, DEFAULT, named};
use illuminator::picture::{Format, Transfer, file_bytes, save};
use std::path::PathBuf;

/// Options of `render`.
#[derive(Args, Debug)]
pub(super) struct Options {
    #[command(flatten)]
    input: InputOptions,
    /// Write 8-bit components with the sRGB transfer function
    #[arg(long)]
    srgb: bool,
    /// Use N × N rays for each pixel on a regular grid, 1 to 16
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=16))]
    samples: u32,
    /// Backend that evaluates the formula: compiled code, or the reference interpreter
    #[arg(long, default_value = DEFAULT.name, value_parser = CHOICES.map(|choice| choice.name))]
    backend: String,
    /// Picture file: .png, .bmp, or .exr for linear unclamped floats; - writes PNG to standard output
    #[arg(long = "output", short, value_name = "OUT")]
    output: PathBuf,
}

/// Makes the picture.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let target = PictureTarget::new(&options.output)?;
    if options.srgb && target.format() == Format::Exr {
        warn("OpenEXR files hold linear numbers; `--srgb` changes nothing");
    }
    let input = load(&options.input)?;
    if let PictureTarget::File(path, _) = target {
        check_distinct(path, &input.files)?;
    }
    // The argument parser accepts known names only.
    let backend: &BackendChoice = named(&options.backend).unwrap_or(&DEFAULT);
    let machine = &options.input.machine;
    let mut frame = engine::on_threads(machine, || engine::picture(&input, options.samples, backend, machine))??;
    match frame.clean() {
        0 => {}
        1 => warn("in 1 pixel the formula gives no number (NaN); there the component is 0"),
        pixels => warn(format!("in {pixels} pixels the formula gives no number (NaN); there the component is 0")),
    }
    if let Some((first, rest)) = frame.linear.split_first()
        && !rest.is_empty()
        && rest.iter().all(|pixel| pixel == first)
    {
        let [red, green, blue] = first;
        warn(format!(
            "every pixel has the same colour, <{red}, {green}, {blue}>: no ray hits a body, the camera is inside one, or no light is on"
        ));
    }
    let transfer = if options.srgb { Transfer::Srgb } else { input.picture.transfer() };
    match target {
        PictureTarget::File(path, _) => save(path, &frame, transfer).map_err(Failure::input),
        PictureTarget::StandardOutput => {
            let bytes = file_bytes(&frame, target.format(), transfer);
            print_bytes(&bytes.map_err(|error| Failure::input(format!("cannot write the picture: {error}")))?)
        }
    }
}
