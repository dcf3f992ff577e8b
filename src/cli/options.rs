//! Options that several commands share, and how their values are read.

use crate::cli::report::warn;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Args, Command};
use illuminator::backends::{BackendChoice, CHOICES, DEFAULT, lacking, named};
use illuminator::lang::ast::Constant;
use illuminator::lang::display_text::one_line;
use illuminator::picture::{EXPOSURES, ToneCurve, Transfer, ViewTransform};
use illuminator::trace::{MAX_DEPTH, MAX_PASSES, MAX_SIDE};
use illuminator::workspace::NamedAssignment;
use illuminator::workspace::assignment::parse_value;
use illuminator::workspace::materials::MaterialAssignment;
use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// What the picture shows.
#[derive(Args, Debug, Clone)]
pub(super) struct InputOptions {
    /// Session file [default: preset:default]
    pub(super) session: Option<OsString>,
    /// Formula file; values of the session stay where the formula has the same parameter
    #[arg(long, short, value_name = "FILE")]
    pub(super) formula: Option<OsString>,
    /// Scene file; values of the session stay where the scene has the same body or light
    #[arg(long, short, value_name = "FILE")]
    pub(super) scene: Option<OsString>,
    /// Give a body a material of the formula's library, or all bodies with *=NAME; --set overrides its values
    #[arg(long = "material", value_name = "BODY=NAME", value_parser = read::<MaterialAssignment>)]
    pub(super) materials: Vec<MaterialAssignment>,
    /// Set a value: ball.kd=0.3, key.IL=<1,0.9,0.8>, ka=0.1, *.kd=0.3 for all
    #[arg(long = "set", value_name = "OWNER.PARAM=VALUE", value_parser = read::<NamedAssignment>)]
    pub(super) settings: Vec<NamedAssignment>,
    /// Picture size in pixels, such as 640x480
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<[u32; 2]>,
    /// Maximum depth of reflections and refractions, 1 to 9
    #[arg(long, value_name = "N", value_parser = whole(1..=MAX_DEPTH), allow_negative_numbers = true)]
    pub(super) depth: Option<u32>,
    /// Send shadow rays
    #[arg(long, overrides_with = "no_shadows")]
    pub(super) shadows: bool,
    /// Send no shadow rays: every light reaches everything
    #[arg(long)]
    pub(super) no_shadows: bool,
    /// Refractive index of bodies that give none
    #[arg(long, value_name = "X", value_parser = index, allow_negative_numbers = true)]
    pub(super) ior: Option<f64>,
    /// Colour of rays that hit nothing, <r,g,b> or #rrggbb
    #[arg(long, value_name = "COLOUR", value_parser = colour)]
    pub(super) background: Option<ColourArgument>,
    #[command(flatten)]
    pub(super) machine: MachineOptions,
}

/// What the program may use of the machine.
#[derive(Args, Debug, Clone)]
pub(super) struct MachineOptions {
    /// Number of threads, 1 to 1024 [default: one for each core]
    #[arg(long, value_name = "N", value_parser = whole(1_u16..=1024), allow_negative_numbers = true)]
    pub(super) threads: Option<u16>,
    /// Memory limit, in MiB or as in 2GiB [default: half of the free memory]
    #[arg(long, value_name = "SIZE", value_parser = memory)]
    pub(super) memory: Option<u64>,
}

/// How many passes a picture is the mean of.
#[derive(Args, Debug, Default, Clone)]
pub(super) struct PassOptions {
    /// Take the mean of N passes, 1 to 65536: in each, rays go through other points of their pixels, and hits take
    /// other points of lights [default: that of the session, or 1]
    #[arg(long, value_name = "N", value_parser = whole(1..=MAX_PASSES), allow_negative_numbers = true)]
    pub(super) samples: Option<u32>,
}

/// How pictures are made and written.
#[derive(Args, Debug)]
pub(super) struct PictureOptions {
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
    #[command(flatten)]
    pub(super) passes: PassOptions,
    #[command(flatten)]
    backend: BackendOptions,
}

/// What evaluates the formula.
#[derive(Args, Debug)]
pub(super) struct BackendOptions {
    /// Backend that evaluates the formula: compiled code, or the reference interpreter
    #[arg(long, default_value = DEFAULT.name, value_parser = BackendParser)]
    pub(super) backend: BackendChoice,
}

/// Takes the names of backends. One that this build lacks has a message of its own.
#[derive(Clone, Copy)]
struct BackendParser;

impl TypedValueParser for BackendParser {
    type Value = BackendChoice;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<BackendChoice, clap::Error> {
        if let Some(message) = value.to_str().and_then(lacking) {
            return Err(clap::Error::raw(ErrorKind::InvalidValue, message).with_cmd(command));
        }
        let names = PossibleValuesParser::new(CHOICES.iter().map(|choice| choice.name));
        let name = names.parse_ref(command, argument, value)?;
        // The parser accepts known names only.
        Ok(*named(&name).unwrap_or(&DEFAULT))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(CHOICES.iter().map(|choice| PossibleValue::new(choice.name))))
    }
}

impl PictureOptions {
    /// The backend.
    pub(super) fn backend(&self) -> &BackendChoice {
        &self.backend.backend
    }

    /// The view transform of a session, changed as the options say.
    pub(super) fn view(&self, session: ViewTransform) -> ViewTransform {
        let mut view = session;
        if self.srgb {
            view.transfer = Transfer::Srgb;
        } else if self.linear {
            view.transfer = Transfer::Linear;
        }
        view.exposure = self.exposure.unwrap_or(view.exposure);
        view.curve = self.curve.as_deref().and_then(ToneCurve::named).unwrap_or(view.curve);
        view
    }

    /// Warns of the options that change nothing in files with linear numbers.
    pub(super) fn warn_of_linear_files(&self) {
        let of_view = [
            ("--srgb", self.srgb),
            ("--linear", self.linear),
            ("--exposure", self.exposure.is_some()),
            ("--curve", self.curve.is_some()),
        ];
        for (option, _) in of_view.into_iter().filter(|(_, is_given)| *is_given) {
            warn(format!("OpenEXR files hold linear numbers; `{option}` changes nothing"));
        }
    }
}

/// A colour as given. It is a type of its own because the parser of arguments takes arrays for lists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ColourArgument(pub(super) [f32; 3]);

/// Reads a value by its own rules. The message, which repeats the user's words, is made safe.
pub(super) fn read<T: FromStr<Err: Display>>(text: &str) -> Result<T, String> {
    text.parse().map_err(|error: T::Err| one_line(&error.to_string()))
}

/// A parser of whole numbers within a range. Its message is worded as for the values of sessions.
pub(super) fn whole<N>(range: RangeInclusive<N>) -> impl Fn(&str) -> Result<N, String> + Clone + Send + Sync + 'static
where
    N: FromStr + PartialOrd + Display + Clone + Send + Sync + 'static,
{
    move |text| {
        let number = text.trim().parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("expected a whole number from {} to {}", range.start(), range.end()))
    }
}

pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let form = || format!("expected a size such as 640x480, each side 1 to {MAX_SIDE}");
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(form)?;
    let side = |text: &str| text.trim().parse().ok().filter(|side| (1..=MAX_SIDE).contains(side)).ok_or_else(form);
    Ok([side(width)?, side(height)?])
}

fn exposure(text: &str) -> Result<f32, String> {
    let stops = text.trim().parse().ok().filter(|stops| EXPOSURES.contains(stops));
    stops.ok_or_else(|| format!("expected stops from {} to {}", EXPOSURES.start(), EXPOSURES.end()))
}

fn index(text: &str) -> Result<f64, String> {
    /// The limits are those of the scene language.
    const RANGE: RangeInclusive<f64> = 1e-30..=1e30;
    text.trim().parse().ok().filter(|index| RANGE.contains(index)).ok_or_else(|| "expected a number greater than 0".to_owned())
}

fn colour(text: &str) -> Result<ColourArgument, String> {
    match parse_value(text) {
        Some(Constant::Vector(components)) => Ok(ColourArgument(components)),
        Some(Constant::Scalar(_)) | None => Err("expected a colour, <r,g,b> with components 0 to 1, or #rrggbb".to_owned()),
    }
}

pub(super) fn memory(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, u32); 13] = [
        ("tib", 40),
        ("gib", 30),
        ("mib", 20),
        ("kib", 10),
        ("tb", 40),
        ("gb", 30),
        ("mb", 20),
        ("kb", 10),
        ("t", 40),
        ("g", 30),
        ("m", 20),
        ("k", 10),
        ("b", 0),
    ];
    let lower = text.trim().to_lowercase();
    let suffixed = UNITS.iter().find_map(|(unit, shift)| Some((lower.strip_suffix(unit)?, *shift)));
    let (number, shift) = suffixed.unwrap_or((&lower, 20));
    let bytes = number.trim().parse::<f64>().ok().map(|number| number * 2f64.powi(shift as i32));
    // The cast saturates.
    bytes
        .filter(|bytes| bytes.is_finite() && *bytes >= 1.0)
        .map(|bytes| bytes as u64)
        .ok_or_else(|| "expected an amount of memory such as 512 (MiB), 300MiB or 2GiB".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        assert_eq!(size("1×16384"), Ok([1, 16384]));
        for text in ["640", "0x5", "5x0", "99999x5", "-5x5", "5x5x5", "ax5", ""] {
            assert!(size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn whole_numbers_are_read_within_their_range() {
        let read = whole(1_u32..=65536);
        assert_eq!((read("1"), read(" 65536 ")), (Ok(1), Ok(65536)));
        for text in ["0", "65537", "99999999999999999999", "-1", "1e3", "2.5", "auto", ""] {
            assert_eq!(read(text), Err("expected a whole number from 1 to 65536".to_owned()), "{text}");
        }
    }

    #[test]
    fn amounts_of_memory_are_read() {
        assert_eq!(memory("512"), Ok(512 << 20));
        assert_eq!(memory("1.5 GiB"), Ok(3 << 29));
        assert_eq!(memory("300MB"), Ok(300 << 20));
        assert_eq!(memory("4096b"), Ok(4096));
        for text in ["", "x", "-5", "0", "inf", "nan", "5x"] {
            assert!(memory(text).is_err(), "{text}");
        }
    }

    #[test]
    fn indices_and_colours_are_read() {
        assert_eq!(index("1.33"), Ok(1.33));
        assert!(["0", "-1", "nan", "inf", "x"].iter().all(|text| index(text).is_err()));
        assert_eq!(colour("#00ff00"), Ok(ColourArgument([0.0, 1.0, 0.0])));
        assert!(colour("1").is_err());
    }
}
