//! TOML texts with the span of every key and value, so diagnostics can point to them.

use crate::lang::ast::Constant;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::source::{Source, SourceSpan};
use crate::workspace::assignment::FileValue;
use serde::Serialize;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

/// The version of the files that are written. No other version is read.
pub(crate) const VERSION: i64 = 1;

/// The key of the version.
pub(crate) const VERSION_KEY: &str = "version";

/// The value of a parameter for serialisation.
#[derive(Serialize)]
#[serde(untagged)]
pub(crate) enum TomlNumber {
    Scalar(f32),
    Vector([f32; 3]),
    Text(String),
}

impl From<&FileValue> for TomlNumber {
    fn from(value: &FileValue) -> Self {
        match value {
            FileValue::Constant(constant) => (*constant).into(),
            FileValue::Image(path) => TomlNumber::Text(path.display().to_string()),
        }
    }
}

impl From<Constant> for TomlNumber {
    fn from(value: Constant) -> Self {
        match value {
            Constant::Scalar(number) => TomlNumber::Scalar(number),
            Constant::Vector(numbers) => TomlNumber::Vector(numbers),
        }
    }
}

/// A key of a table with its value.
pub(crate) struct TomlEntry<'t> {
    pub(crate) key: &'t str,
    pub(crate) key_span: SourceSpan,
    pub(crate) value: Value<'t>,
}

/// A value with its span.
#[derive(Clone, Copy)]
pub(crate) struct Value<'t> {
    value: &'t DeValue<'t>,
    pub(crate) span: SourceSpan,
}

/// Parses a TOML text.
///
/// # Errors
/// All errors of the syntax.
pub(crate) fn parse(source: &Source) -> Result<DeTable<'_>, Diagnostics> {
    let (table, diagnostics) = parse_in_parts(source);
    if diagnostics.is_empty() { Ok(table) } else { Err(diagnostics) }
}

/// What can be read of a TOML text, and all errors of the syntax.
pub(crate) fn parse_in_parts(source: &Source) -> (DeTable<'_>, Diagnostics) {
    let (table, errors) = DeTable::parse_recoverable(source.text());
    let mut diagnostics = Diagnostics::new();
    // Duplicates up to here have been reported.
    let mut reported_until = 0;
    for error in errors {
        let range = error.span().unwrap_or(0..0);
        if error.message() == DUPLICATE && !range.is_empty() {
            if range.start >= reported_until {
                let key = source.slice(span(range.clone()));
                let message = format!("`{key}` occurs twice");
                diagnostics.push(Diagnostic::error(message).at(span(range.clone()), "").help("each name may occur only once"));
                reported_until = end_of_table(source.text(), range.start);
            }
            continue;
        }
        let diagnostic = Diagnostic::error(error.message());
        diagnostics.push(diagnostic.at(span(range), "").help("this must be a TOML file (https://toml.io)"));
    }
    (table.into_inner(), diagnostics)
}

/// The library's message about a duplicate name.
const DUPLICATE: &str = "duplicate key";

/// The end of the table whose header is on the line at byte `start`, or `start` if the line is no header. The keys in
/// a second table of the same name are reported as duplicates too.
fn end_of_table(text: &str, start: usize) -> usize {
    let (before, behind) = text.split_at_checked(start).unwrap_or((text, ""));
    let line = before.rsplit('\n').next().unwrap_or_default();
    if !line.trim_start().starts_with('[') {
        return start;
    }
    behind.find("\n[").map_or(text.len(), |length| start + length)
}

fn span(range: Range<usize>) -> SourceSpan {
    SourceSpan::new(range.start, range.end)
}

/// The entries of a table, in the order of the text.
pub(crate) fn entries<'t>(table: &'t DeTable<'t>) -> Vec<TomlEntry<'t>> {
    let mut entries: Vec<TomlEntry<'t>> = table
        .iter()
        .map(|(key, value)| TomlEntry { key: key.get_ref(), key_span: span(key.span()), value: spanned(value) })
        .collect();
    entries.sort_by_key(|entry| entry.key_span);
    entries
}

fn spanned<'t>(value: &'t Spanned<DeValue<'t>>) -> Value<'t> {
    Value { value: value.get_ref(), span: span(value.span()) }
}

impl<'t> Value<'t> {
    fn mismatch(self, expected: &str) -> Diagnostic {
        let found = match self.value {
            DeValue::String(_) => "a text",
            DeValue::Integer(_) => "a whole number",
            DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "true or false",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "a list",
            DeValue::Table(_) => "a table",
        };
        Diagnostic::error(format!("expected {expected}, found {found}")).at(self.span, format!("expected {expected}"))
    }

    /// The value as a text.
    pub(crate) fn text(self) -> Result<&'t str, Diagnostic> {
        self.value.as_str().ok_or_else(|| self.mismatch("a text in quotes"))
    }

    /// The value as true or false.
    pub(crate) fn truth(self) -> Result<bool, Diagnostic> {
        self.value.as_bool().ok_or_else(|| self.mismatch("`true` or `false`"))
    }

    /// The value as a whole number within a range.
    pub(crate) fn whole(self, range: Range<i64>) -> Result<i64, Diagnostic> {
        let expected = format!("a whole number from {} to {}", range.start, range.end - 1);
        let number = self.integer(&expected)?;
        parse_integer(number)
            .filter(|number| range.contains(number))
            .ok_or_else(|| Diagnostic::error(format!("{number} is out of range")).at(self.span, format!("expected {expected}")))
    }

    /// The value as a finite number.
    pub(crate) fn number(self) -> Result<f64, Diagnostic> {
        let number = match (self.value.as_integer(), self.value.as_float()) {
            (Some(number), _) => parse_integer(number).map(|number| number as f64),
            (None, Some(number)) => number.as_str().parse().ok(),
            (None, None) => return Err(self.mismatch("a number")),
        };
        // Parameters are `f32`, and finite.
        number
            .filter(|number: &f64| (*number as f32).is_finite())
            .ok_or_else(|| Diagnostic::error("this number is too large or not finite").at(self.span, "expected a finite number"))
    }

    /// The elements of a list of this length.
    pub(crate) fn list<const N: usize>(self, expected: &str) -> Result<[Value<'t>; N], Diagnostic> {
        let values = self.elements(expected)?;
        let length = values.len();
        values
            .try_into()
            .map_err(|_| Diagnostic::error(format!("expected {expected}")).at(self.span, format!("{length} elements")))
    }

    /// The elements of a list of any length.
    pub(crate) fn elements(self, expected: &str) -> Result<Vec<Value<'t>>, Diagnostic> {
        let list = self.value.as_array().ok_or_else(|| self.mismatch(expected))?;
        Ok(list.iter().map(spanned).collect())
    }

    /// The digits of a whole number, which may be too large for any type.
    pub(crate) fn integer(self, expected: &str) -> Result<&'t DeInteger<'t>, Diagnostic> {
        self.value.as_integer().ok_or_else(|| self.mismatch(expected))
    }

    /// The value of a parameter: a number, or a list of three.
    pub(crate) fn constant(self) -> Result<Constant, Diagnostic> {
        if self.value.as_array().is_some() {
            let [x, y, z] = self.list("three numbers `[x, y, z]`")?;
            return Ok(Constant::Vector([x.number()? as f32, y.number()? as f32, z.number()? as f32]));
        }
        if self.value.as_integer().is_none() && self.value.as_float().is_none() {
            return Err(self.mismatch("a number, or three as `[x, y, z]`"));
        }
        Ok(Constant::Scalar(self.number()? as f32))
    }

    /// The value of a parameter: a number, a list of three, or a text, the path of an image.
    pub(crate) fn given(self) -> Result<FileValue, Diagnostic> {
        match self.value.as_str() {
            Some(text) => Ok(FileValue::of_text(text)),
            None => self.constant().map(FileValue::Constant),
        }
    }

    /// The value as a table.
    pub(crate) fn table(self) -> Result<&'t DeTable<'t>, Diagnostic> {
        self.value.as_table().ok_or_else(|| self.mismatch("a table"))
    }
}

/// A whole number as an `i64`, if it is not too large.
pub(crate) fn parse_integer(number: &DeInteger) -> Option<i64> {
    i64::from_str_radix(number.as_str(), number.radix()).ok()
}

/// The error that a line is missing, at the start of the file.
pub(crate) fn missing(message: &str, line: &str) -> Diagnostic {
    Diagnostic::error(message).at(SourceSpan::default(), format!("expected a line such as `{line}`"))
}

/// Checks the version of a file.
pub(crate) fn check_version(value: Option<Value>, diagnostics: &mut Diagnostics) {
    let Some(value) = value else {
        diagnostics.push(missing("the file has no version", &format!("version = {VERSION}")));
        return;
    };
    match value.whole(0..i64::MAX) {
        Ok(VERSION) => {}
        Ok(other) => diagnostics.push(
            Diagnostic::error(format!("version {other} of this file cannot be read"))
                .at(value.span, format!("expected {VERSION}"))
                .help("it may have been written by another version of the program"),
        ),
        Err(diagnostic) => diagnostics.push(diagnostic),
    }
}

/// The warning that a key is unknown, with the nearest known one.
pub(crate) fn unknown_key(entry: &TomlEntry, known: &[&str]) -> Diagnostic {
    let hint = match nearest(entry.key, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("the known keys are {}", known.join(", ")),
    };
    Diagnostic::warning(format!("`{}` is unknown here and is ignored", entry.key)).at(entry.key_span, "unknown key").help(hint)
}
