//! `illuminator render`: writes a picture to a file, or to standard output.

use crate::cli::engine;
use crate::cli::input::load;
use crate::cli::options::InputOptions;
use crate::cli::output::{PictureTarget, check_distinct};
use crate::cli::report::{Failure, print_bytes, warn, warn_of_picture};
use clap::Args;
use illuminator::backends::{BackendChoice, CHOICES, DEFAULT, named};
use illuminator::picture::{EXPOSURES, Format, ToneCurve, Transfer, file_bytes, save};
use std::path::PathBuf;

/// Options of `render`.
#[derive(Args, Debug)]
pub(super) struct Options {
    #[command(flatten)]
    input: InputOptions,
    /// Write 8-bit components with the sRGB transfer function [default: as the session says]
    #[arg(long)]
    srgb: bool,
    /// Write 8-bit components as they are
    #[arg(long, conflicts_with = "srgb")]
    linear: bool,
    /// Exposure in stops, -16 to 16: 1 makes the picture twice as bright [default: that of the session]
    #[arg(long, value_name = "STOPS", value_parser = exposure, allow_negative_numbers = true)]
    exposure: Option<f32>,
    /// Tone curve [default: that of the session]
    #[arg(long, value_name = "NAME", value_parser = ToneCurve::ALL.map(ToneCurve::name))]
    curve: Option<String>,
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
    let format = target.format();
    let of_view = [
        ("--srgb", options.srgb),
        ("--linear", options.linear),
        ("--exposure", options.exposure.is_some()),
        ("--curve", options.curve.is_some()),
    ];
    for (option, _) in of_view.into_iter().filter(|(_, is_given)| *is_given && format == Format::Exr) {
        warn(format!("OpenEXR files hold linear numbers; `{option}` changes nothing"));
    }
    let input = load(&options.input)?;
    if let PictureTarget::File(path, _) = target {
        check_distinct(path, &input.files)?;
    }
    // The argument parser accepts known names only.
    let backend: &BackendChoice = named(&options.backend).unwrap_or(&DEFAULT);
    let machine = &options.input.machine;
    let mut frame = engine::on_threads(machine, || engine::picture(&input, options.samples, backend, machine))??;
    let mut view = input.picture.view;
    if options.srgb {
        view.transfer = Transfer::Srgb;
    } else if options.linear {
        view.transfer = Transfer::Linear;
    }
    view.exposure = options.exposure.unwrap_or(view.exposure);
    view.curve = options.curve.as_deref().and_then(ToneCurve::named).unwrap_or(view.curve);
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

fn exposure(text: &str) -> Result<f32, String> {
    let stops = text.trim().parse().ok().filter(|stops| EXPOSURES.contains(stops));
    stops.ok_or_else(|| format!("expected stops from {} to {}", EXPOSURES.start(), EXPOSURES.end()))
}
