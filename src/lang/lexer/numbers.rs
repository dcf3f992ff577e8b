//! Numbers, and how other languages write them: with a suffix, a unit, in another base, with grouped digits.

use super::Lexer;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::source::SourceSpan;
use crate::lang::token::{Mark, TokenKind};

impl Lexer<'_> {
    /// `digits`, `digits.digits`, `.digits`, or `digits.` if no other dot follows; then an optional exponent.
    pub(super) fn number(&mut self, start: usize) {
        let digits = |byte: u8| byte.is_ascii_digit();
        self.at += self.run_length(digits);
        if self.rest().starts_with('.') && !self.rest().starts_with("..") {
            self.at += 1;
            self.at += self.run_length(digits);
        }
        if self.rest().starts_with(['e', 'E']) {
            let sign = usize::from(self.rest()[1..].starts_with(['+', '-']));
            if self.digit_at(self.at + 1 + sign) {
                self.at += 1 + sign;
                self.at += self.run_length(digits);
            }
        }
        // Rust can read every text of this form.
        let value = self.text[start..self.at].parse::<f64>().unwrap_or(f64::INFINITY);
        if value.is_infinite() {
            self.found.diagnostics.push(
                Diagnostic::error("this number is too large")
                    .at(SourceSpan::new(start, self.at), "larger than the largest number")
                    .help(format!("numbers go up to about {:e}", f32::MAX)),
            );
            self.push(TokenKind::Unknown, start);
            return;
        }
        let value = self.foreign_number(start, value);
        self.push(TokenKind::Number(value), start);
    }

    /// Reports letters right behind a number that belong to it in other languages, and moves past them. The number that
    /// is meant.
    fn foreign_number(&mut self, start: usize, value: f64) -> f64 {
        let number = self.text[start..self.at].to_owned();
        let length = self.run_length(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let behind = self.rest()[..length].to_owned();
        let exponent = behind.eq_ignore_ascii_case("e").then(|| self.rest()[length..].starts_with(['+', '-']));
        let based = |base: u32| u64::from_str_radix(behind.get(1..)?, base).ok().filter(|_| number == "0");
        let grouped = || format!("{number}{behind}").replace('_', "").parse::<f64>().ok().filter(|_| behind.starts_with('_'));
        let (length, value, message, help) = match behind.as_str() {
            "" if self.percent() => {
                let part = shown(value / 100.0);
                (1, value, format!("`{number}%` is not a number here"), format!("write `{part}`"))
            }
            "" if self.rest().starts_with('°') => ('°'.len_utf8(), value, unit_message(&number, "°"), angle_help(&number)),
            "" => return value,
            "f" | "F" | "lf" | "LF" | "hf" => {
                let help = format!("write `{number}`, or `{number}*{behind}` for a product");
                (length, value, format!("numbers have no suffix: `{number}{behind}`"), help)
            }
            "deg" | "degrees" | "degree" => (length, value, unit_message(&number, &behind), angle_help(&number)),
            "rad" | "radians" => {
                let degrees = shown(value.to_degrees());
                let help = format!("in a formula write `{number}`; in a scene, where angles are in degrees, write `{degrees}`");
                (length, value, unit_message(&number, &behind), help)
            }
            "e" | "E" => {
                let signs = usize::from(exponent == Some(true));
                let help = format!("write `{number}e-3` for thousandths, or `{number}*{behind}` for a product");
                (length + signs, value, format!("the exponent of `{number}{behind}` has no digits"), help)
            }
            _ if let Some(whole) = based(16).filter(|_| behind.starts_with(['x', 'X'])) => {
                let message = format!("`{number}{behind}` is not a number here: numbers are decimal");
                (length, whole as f64, message, format!("write `{whole}`"))
            }
            _ if let Some(whole) = based(2).filter(|_| behind.starts_with(['b', 'B'])) => {
                let message = format!("`{number}{behind}` is not a number here: numbers are decimal");
                (length, whole as f64, message, format!("write `{whole}`"))
            }
            _ if let Some(whole) = grouped() => {
                (length, whole, format!("digits are not grouped: `{number}{behind}`"), format!("write `{}`", shown(whole)))
            }
            _ => return value,
        };
        self.at += length;
        self.found
            .diagnostics
            .push(Diagnostic::error(message).at(SourceSpan::new(start, self.at), "not a number here").help(help));
        value
    }

    /// Whether a `%` right behind a number makes a part of a hundred of it, and is no remainder.
    fn percent(&self) -> bool {
        let Some(behind) = self.rest().strip_prefix('%') else { return false };
        behind.trim_start().starts_with([';', ',', ')', '>', '*', '.']) || behind.trim_start().is_empty()
    }

    /// Reports `...`, and reads it as `..`: `0...5` would be the range from 0 to 0.5, which nobody means.
    pub(super) fn three_dots(&mut self, start: usize) {
        self.at += "...".len();
        let digits = self.run_length(|byte| byte.is_ascii_digit());
        let before = match self.found.tokens.last() {
            Some(token) if matches!(token.kind, TokenKind::Number(_)) => &self.text[token.span.range()],
            _ => "0",
        };
        let span = SourceSpan::new(start, self.at);
        let error = Diagnostic::error("three dots have two readings").at(span, "expected `..`");
        let error = match &self.rest()[..digits] {
            "" => error.help("ranges are written with two dots: `0..1`"),
            behind => error
                .help(format!("write `{before}..{behind}` for up to {behind}, or `{before}.. 0.{behind}` for up to 0.{behind}")),
        };
        self.found.diagnostics.push(error);
        self.push(TokenKind::Mark(Mark::DotDot), start);
    }
}

fn unit_message(number: &str, unit: &str) -> String {
    format!("numbers have no unit: `{number}{unit}`")
}

fn angle_help(number: &str) -> String {
    format!(
        "in a formula write `radians({number})`, since angles are in radians there; in a scene write `{number}`: angles are in degrees there"
    )
}

/// A number with at most six digits behind the point.
fn shown(value: f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6)
}
