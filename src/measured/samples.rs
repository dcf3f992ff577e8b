//! Lists of measured samples in texts: for fitting formulas, not for pictures.

use crate::measured::error::{Flaw, MeasuredError};
use glam::DVec3;
use std::borrow::Cow;

/// The reflectance for one pair of directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReflectanceSample {
    /// The direction to the light: a unit vector above the horizon, normal +z, tangent +x.
    pub light: DVec3,
    /// The direction to the view, likewise.
    pub view: DVec3,
    /// Red, green and blue of the reflectance, linear, in 1/sr. Noise may make it negative.
    pub value: DVec3,
}

/// Samples in the order of their file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReflectanceSamples {
    /// The samples; at least one if they were read from a file.
    pub samples: Vec<ReflectanceSample>,
}

/// A column of a list.
struct SampleColumn {
    name: &'static str,
    /// Other names that are understood.
    aliases: &'static [&'static str],
    is_angle: bool,
}

/// What may stand between numbers. Beside a semicolon or a tab, a comma is a decimal one.
const SEPARATORS: [char; 3] = [';', '\t', ','];

/// The columns, in the order of a list without a header. *i* is the light, *o* the view.
const COLUMNS: [SampleColumn; 7] = [
    SampleColumn { name: "theta_i", aliases: &["theta_in", "theta_l"], is_angle: true },
    SampleColumn { name: "phi_i", aliases: &["phi_in", "phi_l"], is_angle: true },
    SampleColumn { name: "theta_o", aliases: &["theta_out", "theta_v"], is_angle: true },
    SampleColumn { name: "phi_o", aliases: &["phi_out", "phi_v"], is_angle: true },
    SampleColumn { name: "r", aliases: &["red"], is_angle: false },
    SampleColumn { name: "g", aliases: &["green"], is_angle: false },
    SampleColumn { name: "b", aliases: &["blue"], is_angle: false },
];

/// The column of `COLUMNS` that stands at each place of a line, and what its numbers are multiplied by; none for a
/// column that is not read.
type ColumnOrder = Vec<Option<(usize, f64)>>;

/// Makes a number of UTF-16 of its bytes.
type UnitReader = fn([u8; 2]) -> u16;

/// The marks at the beginning of texts in UTF-16, and how their bytes make a number.
const UTF16: [([u8; 2], UnitReader); 2] = [([0xff, 0xfe], u16::from_le_bytes), ([0xfe, 0xff], u16::from_be_bytes)];

/// Whether bytes begin as a text in UTF-16 does.
pub(super) fn is_utf16(beginning: &[u8]) -> bool {
    UTF16.iter().any(|(mark, _)| beginning.starts_with(mark))
}

/// The text of a file in UTF-8, or in UTF-16 with a mark at its beginning, as spreadsheets write it.
pub(super) fn text_of(bytes: &[u8]) -> Result<Cow<'_, str>, Flaw> {
    let Some((_, number)) = UTF16.iter().find(|(mark, _)| bytes.starts_with(mark)) else {
        let text = std::str::from_utf8(bytes).map_err(|error| Flaw::at_byte(error.valid_up_to(), "it is no UTF-8 text"))?;
        return Ok(Cow::Borrowed(text));
    };
    let (pairs, rest) = bytes[2..].as_chunks::<2>();
    let text: Result<String, _> = char::decode_utf16(pairs.iter().map(|pair| number(*pair))).collect();
    let text = text.ok().filter(|_| rest.is_empty()).ok_or_else(|| Flaw::new("it is no UTF-16 text, as which it begins"))?;
    Ok(Cow::Owned(text))
}

/// A word of a line: its column, counted from 1, and its text.
type ListWord<'t> = (usize, &'t str);

/// The words of a line without its comment and without quotes. They are separated by semicolons, tabs or commas, or by
/// blanks alone.
fn words(line: &str) -> Vec<ListWord<'_>> {
    let line = line.split('#').next().unwrap_or_default();
    let separator = SEPARATORS.into_iter().find(|separator| line.contains(*separator));
    let mut words = Vec::new();
    let mut start = 0;
    let mut push = |range: std::ops::Range<usize>| {
        let text = &line[range.clone()];
        let blanks = text.len() - text.trim_start().len();
        // A tab may follow a comma.
        let word = if separator == Some('\t') { text.trim().trim_end_matches(',') } else { text.trim() };
        let is_quoted = word.len() > 1 && word.starts_with('"') && word.ends_with('"');
        let word = if is_quoted { word[1..word.len() - 1].trim() } else { word };
        words.push((line[..range.start + blanks].chars().count() + 1, word));
    };
    match separator {
        Some(separator) => {
            for (end, _) in line.match_indices(separator) {
                push(start..end);
                start = end + separator.len_utf8();
            }
            push(start..line.len());
        }
        None => {
            for word in line.split_whitespace() {
                let begin = line[start..].find(word).map_or(start, |offset| start + offset);
                push(begin..begin + word.len());
                start = begin + word.len();
            }
        }
    }
    if words.iter().all(|(_, word)| word.is_empty()) { Vec::new() } else { words }
}

/// The column that a word of a header names, and what its numbers are multiplied by: degrees are turned into radians.
fn named(word: &str) -> Option<(usize, f64)> {
    /// Whether a unit is the degree.
    const UNITS: [(&str, bool); 5] = [("deg", true), ("degrees", true), ("°", true), ("rad", false), ("radians", false)];
    let word = word.to_ascii_lowercase();
    let (name, unit) = UNITS
        .iter()
        .find_map(|(unit, degrees)| {
            let inner = word.trim_end_matches([')', ']']).strip_suffix(unit)?;
            Some((inner.trim_end_matches(['_', ' ', '(', '[']), Some(*degrees)))
        })
        .unwrap_or((word.as_str(), None));
    let index = COLUMNS.iter().position(|column| column.name == name || column.aliases.contains(&name))?;
    let degrees = unit.unwrap_or(true);
    match COLUMNS[index].is_angle {
        true => Some((index, if degrees { 1.0_f64.to_radians() } else { 1.0 })),
        false => unit.is_none().then_some((index, 1.0)),
    }
}

/// The columns by the header of a list.
fn header(line: usize, words: &[ListWord]) -> Result<ColumnOrder, Flaw> {
    let names = || COLUMNS.map(|column| column.name).join(",");
    let hint = || format!("a header names the columns: {}; angles may end in `_deg` or `_rad`", names());
    let mut layout = ColumnOrder::new();
    let mut found = [false; COLUMNS.len()];
    for (column, word) in words {
        let named = named(word);
        if let Some((index, _)) = named
            && std::mem::replace(&mut found[index], true)
        {
            return Err(Flaw::at(line, *column, format!("there are two columns `{}`", COLUMNS[index].name)).hint(hint()));
        }
        layout.push(named);
    }
    match (found.iter().position(|found| !found), words.iter().zip(&layout).find(|(_, named)| named.is_none())) {
        (None, _) => Ok(layout),
        (Some(_), Some(((column, word), _))) => {
            Err(Flaw::at(line, *column, format!("`{word}` is no number and no name of a column")).hint(hint()))
        }
        (Some(index), None) => Err(Flaw::at(line, 1, format!("there is no column `{}`", COLUMNS[index].name)).hint(hint())),
    }
}

/// A sample by the numbers of a line.
fn sample(line: usize, words: &[ListWord], layout: &ColumnOrder) -> Result<ReflectanceSample, Flaw> {
    // A line may end in a separator.
    let is_excess = words.len() > layout.len() && words.last().is_some_and(|(_, word)| word.is_empty());
    let words = &words[..words.len() - usize::from(is_excess)];
    if words.len() != layout.len() {
        let (column, count) = (words.last().map_or(1, |(column, _)| *column), words.len());
        let flaw = Flaw::at(line, column, format!("{count} numbers, and {} were expected", layout.len()));
        return Err(match count == 2 * layout.len() {
            true => flaw.hint("write decimal points, as in 0.5, or separate numbers by semicolons"),
            false => flaw.hint(format!("a line is {}", COLUMNS.map(|column| column.name).join(","))),
        });
    }
    let mut numbers = [0.0; COLUMNS.len()];
    for ((column, word), of) in words.iter().zip(layout) {
        let Some((index, factor)) = of else { continue };
        let flaw = |what: &str| Flaw::at(line, *column, format!("`{word}` is {what}"));
        // A comma that separates nothing is a decimal one.
        let number = word.replace(',', ".").parse::<f64>().map_err(|_| flaw("no number"))?;
        if !number.is_finite() || number.abs() > f64::from(f32::MAX) {
            return Err(flaw("no finite number of single precision"));
        }
        let angle = number * factor;
        let is_polar = COLUMNS[*index].name.starts_with("theta");
        if is_polar && !(0.0..std::f64::consts::FRAC_PI_2).contains(&angle) {
            let message = format!("the polar angle `{word}` is not from 0 to less than 90 degrees");
            let hint = "angles are in degrees unless a header names them `theta_i_rad`; they are counted from the normal";
            return Err(Flaw::at(line, *column, message).hint(hint));
        }
        numbers[*index] = angle;
    }
    let [theta_i, phi_i, theta_o, phi_o, red, green, blue] = numbers;
    let direction = |theta: f64, phi: f64| {
        let (sin, cos) = theta.sin_cos();
        DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
    };
    Ok(ReflectanceSample {
        light: direction(theta_i, phi_i),
        view: direction(theta_o, phi_o),
        value: DVec3::new(red, green, blue),
    })
}

impl ReflectanceSamples {
    /// Reads a list: lines of `theta_i,phi_i,theta_o,phi_o,r,g,b`. *i* is the direction to the light, *o* that to the
    /// view; r, g and b are the reflectance in 1/sr. Angles are in degrees. A first line may name the columns in any
    /// order, and angles there may end in `_rad`. A comment begins with `#`. `file` is named in errors.
    ///
    /// # Errors
    /// A line is no sample, or there is none.
    pub fn of_text(file: &str, text: &str) -> Result<Self, MeasuredError> {
        Self::parse(text).map_err(|flaw| flaw.in_file(std::path::Path::new(file)))
    }

    /// See [`of_text`](Self::of_text).
    pub(super) fn parse(text: &str) -> Result<Self, Flaw> {
        let mut layout: Option<ColumnOrder> = None;
        let mut samples = Vec::new();
        // Lines of old programs end in a lone CR.
        let text = text.trim_start_matches('\u{FEFF}').replace("\r\n", "\n").replace('\r', "\n");
        for (index, line) in text.lines().enumerate() {
            let words = words(line);
            let Some((_, first)) = words.first() else { continue };
            // A line for spreadsheets that says what separates numbers.
            if samples.is_empty() && line.trim().to_ascii_lowercase().starts_with("sep=") {
                continue;
            }
            let layout = match &mut layout {
                Some(layout) => layout,
                None if first.replace(',', ".").parse::<f64>().is_err() => {
                    layout = Some(header(index + 1, &words)?);
                    continue;
                }
                None => {
                    let plain = |(index, column): (usize, &SampleColumn)| {
                        Some((index, if column.is_angle { 1.0_f64.to_radians() } else { 1.0 }))
                    };
                    layout.insert(COLUMNS.iter().enumerate().map(plain).collect())
                }
            };
            samples.push(sample(index + 1, &words, layout)?);
        }
        let hint = || format!("a line is {}", COLUMNS.map(|column| column.name).join(","));
        if samples.is_empty() { Err(Flaw::new("it has no samples").hint(hint())) } else { Ok(Self { samples }) }
    }
}
