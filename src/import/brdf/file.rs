//! The parts of a file of BRDF Explorer: parameters, and a shader.

use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::{Source, SourceSpan};
use crate::lang::variables::Owner;
use std::ops::Range;

/// A parameter of a model.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BrdfParameter {
    pub(super) name: String,
    pub(super) span: SourceSpan,
    pub(super) value: BrdfValue,
    /// What the comment above it says, and more if this program wrote the comment.
    pub(super) note: Option<BrdfNote>,
}

/// The kind of a parameter, and its default.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum BrdfValue {
    /// Least, greatest, default.
    Float([f32; 3]),
    Truth(bool),
    Colour([f32; 3]),
}

/// What a comment says of a parameter.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct BrdfNote {
    pub(super) doc: String,
    /// What this program's exports say: what the parameter belongs to, its range, and the names of its values.
    pub(super) owner: Option<Owner>,
    pub(super) range: Option<[f32; 2]>,
    pub(super) choices: Vec<String>,
}

/// A file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BrdfFile {
    pub(super) parameters: Vec<BrdfParameter>,
    /// Where the shader is in the text.
    pub(super) shader: Range<usize>,
    /// Whether this program wrote it, so that the model has the colour of the light if it should.
    pub(super) is_export: bool,
}

/// The lines of a text with their places. They end with a line feed, a carriage return, or both, as in the shader.
fn lines(text: &str) -> impl Iterator<Item = (Range<usize>, &str)> {
    let mut at = 0;
    let lines = text.split_inclusive(['\n', '\r']).map(move |line| {
        let start = at;
        at += line.len();
        (start..at, line)
    });
    lines.filter(|(place, line)| *line != "\n" || !text[..place.start].ends_with('\r'))
}

/// Finds the parts of a file.
pub(super) fn file(source: &Source, diagnostics: &mut Diagnostics) -> Option<BrdfFile> {
    let text = source.text();
    let word = text.trim_start_matches('\u{feff}').split_whitespace().next().unwrap_or_default();
    if word != "analytic" {
        let span = SourceSpan::new(0, lines(text).next().map_or(0, |(_, line)| line.trim_end().len()));
        let error = Diagnostic::error("this is no model of BRDF Explorer in GLSL").at(span, "expected `analytic`");
        diagnostics.push(error.help("files of measurements have no formula"));
        return None;
    }
    let mut parameters = Vec::new();
    let mut shader = None;
    let mut part: Option<(&str, usize)> = None;
    let mut comment: Option<&str> = None;
    for (place, line) in lines(text) {
        let trimmed = line.trim();
        let start = place.start + line.len() - line.trim_start().len();
        let span = SourceSpan::new(start, start + trimmed.len());
        if let Some(begun) = trimmed.strip_prefix("::begin") {
            part = Some((begun.trim(), place.end));
        } else if trimmed.starts_with("::end") {
            if let Some(("shader", start)) = part.take() {
                shader = Some(start..place.start.max(start));
            }
        } else if matches!(part, Some(("parameters", _))) && !trimmed.is_empty() {
            if let Some(said) = trimmed.strip_prefix('#') {
                comment = Some(said.trim());
                continue;
            }
            match parameter(trimmed, span, comment) {
                Ok(parameter) => parameters.push(parameter),
                Err(error) => diagnostics.push(*error),
            }
        }
        comment = None;
    }
    if shader.is_none() {
        let error = Diagnostic::error("the file has no shader");
        diagnostics.push(error.help("a shader stands between lines `::begin shader` and `::end shader`"));
    }
    let mut comments =
        lines(text).map(|(_, line)| line).take_while(|line| !line.starts_with("::")).filter(|line| line.starts_with('#'));
    let is_export = comments.any(|line| line.contains(", written by Illuminator from "));
    Some(BrdfFile { parameters, shader: shader?, is_export })
}

/// Reads the line of a parameter.
fn parameter(line: &str, span: SourceSpan, comment: Option<&str>) -> Result<BrdfParameter, Box<Diagnostic>> {
    let line = line.split('#').next().unwrap_or_default();
    let words: Vec<&str> = line.split_whitespace().collect();
    let wrong = |what: &str, usage: &str| {
        let error = Diagnostic::error(what).at(span, "");
        Box::new(error.help(format!("a parameter is written `{usage}`")))
    };
    let numbers = |usage: &str| -> Result<Vec<f32>, Box<Diagnostic>> {
        let read = |word: &&str| word.parse::<f32>().ok().filter(|number| number.is_finite());
        let numbers: Option<Vec<f32>> = words.iter().skip(2).map(read).collect();
        numbers.ok_or_else(|| wrong("a parameter has a value that is no number", usage))
    };
    let usages = ["float NAME LEAST GREATEST DEFAULT", "bool NAME DEFAULT", "color NAME RED GREEN BLUE"];
    let value = match (words.first().copied(), words.len()) {
        (Some("float"), 5) => match numbers(usages[0])?[..] {
            [low, high, default] if low <= high => BrdfValue::Float([low, high, default]),
            _ => return Err(wrong("the least value of a parameter is above the greatest", usages[0])),
        },
        (Some("float"), _) => return Err(wrong("a number is declared in another way", usages[0])),
        (Some("bool"), 3) => BrdfValue::Truth(words[2] != "0" && words[2] != "false"),
        (Some("bool"), _) => return Err(wrong("a switch is declared in another way", usages[1])),
        (Some("color"), 5) => match numbers(usages[2])?[..] {
            [red, green, blue] => BrdfValue::Colour([red, green, blue]),
            _ => return Err(wrong("a colour is declared in another way", usages[2])),
        },
        (Some("color"), _) => return Err(wrong("a colour is declared in another way", usages[2])),
        _ => return Err(wrong("a parameter has a type that is not known", "float …`, `bool …` or `color …")),
    };
    let is_part = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    if !words[1].chars().all(is_part) || words[1].starts_with(|first: char| first.is_ascii_digit()) {
        return Err(wrong("a parameter has a name that GLSL does not allow", usages[0]));
    }
    Ok(BrdfParameter { name: words[1].to_owned(), span, value, note: comment.map(note) })
}

/// Reads the comment above a parameter. Exports of this program have a comment such as
/// `body parameter, 0..1, default 0.6, 0 smooth, 1 rough: how it is`.
fn note(comment: &str) -> BrdfNote {
    let (facts, doc) = comment.split_once(": ").unwrap_or((comment, ""));
    let mut parts = facts.split(", ");
    let first = parts.next().unwrap_or_default();
    let Some(owner) = Owner::ALL.into_iter().find(|owner| first == format!("{} parameter", owner.adjective())) else {
        return BrdfNote { doc: comment.to_owned(), ..BrdfNote::default() };
    };
    let parts: Vec<&str> = parts.collect();
    let mut choices: Vec<String> = Vec::new();
    for part in &parts {
        // A name may have commas.
        match (part.strip_prefix(&format!("{} ", choices.len())), choices.last_mut()) {
            (Some(name), _) => choices.push(name.to_owned()),
            (None, Some(last)) => *last += &format!(", {part}"),
            (None, None) => {}
        }
    }
    let range = parts.first().and_then(|range| range.split_once(".."));
    let number = |text: &str| text.parse::<f32>().ok().filter(|number| number.is_finite());
    BrdfNote {
        doc: doc.to_owned(),
        owner: Some(owner),
        range: range.and_then(|(low, high)| Some([number(low)?, number(high)?])).filter(|[low, high]| low <= high),
        choices,
    }
}
