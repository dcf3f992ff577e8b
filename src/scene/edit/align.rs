//! Compares the words of a text with those of a printed value, to find which numbers of the text must change.

use super::declarations::SceneText;
use super::{Precision, TextReplacement};
use crate::lang::lexer::tokenize;
use crate::lang::source::{Source, SourceSpan};
use crate::lang::token::{Mark, Token, TokenKind};
use crate::scene::values::SceneNumber;
use crate::scene::{Camera, LightKind};
use std::fmt::Display;
use std::ops::Range;

/// The digits to which a direction is written, as a part of its length: 10⁻⁴.
const DIRECTION_DIGITS: i32 = 4;
/// The decimals of angles in degrees.
const ANGLE_DECIMALS: i32 = 2;

/// To how many decimals a number is written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Decimals {
    /// `None`: so that it reads back exactly.
    count: Option<i32>,
    /// Whether it gets at least the decimals that it had.
    keeps: bool,
}

impl Decimals {
    pub(super) fn of_lengths(precision: Precision) -> Self {
        match precision {
            Precision::Exact => Self { count: None, keeps: false },
            Precision::Decimals(count) => Self { count: Some(count), keeps: true },
        }
    }

    /// Of a factor or an angle: four digits.
    pub(super) fn of_factors(precision: Precision, of: f64) -> Self {
        match precision {
            Precision::Exact => Self { count: None, keeps: false },
            Precision::Decimals(_) if of == 0.0 => Self { count: Some(DIRECTION_DIGITS), keeps: true },
            Precision::Decimals(_) => Self { count: Some(DIRECTION_DIGITS - of.abs().log10().floor() as i32), keeps: true },
        }
    }

    /// Of the numbers of a camera, counted in the order of its text: position, gaze, up, fov.
    pub(super) fn of_camera(precision: Precision, number: usize, camera: &Camera) -> Self {
        let Precision::Decimals(count) = precision else { return Self { count: None, keeps: false } };
        let direction = |length: f64| DIRECTION_DIGITS - length.log10().floor() as i32;
        let count = match number {
            0..3 => count,
            3..6 => direction(camera.gaze().length()),
            6..9 => direction(camera.up().length()),
            _ => ANGLE_DECIMALS,
        };
        Self { count: Some(count), keeps: false }
    }

    /// Of the numbers of a light, counted in the order of its text.
    pub(super) fn of_light(precision: Precision, number: usize, light: &LightKind) -> Self {
        match (light, precision) {
            (LightKind::Directional(light), _) => Self::of_factors(precision, light.direction().length()),
            // Behind the position and the target.
            (LightKind::Spot(_), Precision::Decimals(_)) if number >= 6 => Self { count: Some(ANGLE_DECIMALS), keeps: true },
            (LightKind::Environment(_), Precision::Decimals(_)) => Self { count: Some(ANGLE_DECIMALS), keeps: true },
            (
                LightKind::Environment(_)
                | LightKind::Spot(_)
                | LightKind::Point(_)
                | LightKind::Sphere(_)
                | LightKind::Rectangle(_),
                _,
            ) => Self::of_lengths(precision),
        }
    }

    fn write(self, new: f64, old: Option<f64>) -> f64 {
        // Zeros at the end of a whole number are as good as none: 25000 has −3 decimals.
        let had = |old: f64| match format!("{old}").split_once('.') {
            Some((_, decimals)) => decimals.len() as i32,
            None if old == 0.0 => i32::MIN,
            None => format!("{old}").trim_end_matches('0').len() as i32 - format!("{old}").len() as i32,
        };
        match self.count {
            None => new,
            Some(count) => rounded(new, old.filter(|_| self.keeps).map_or(count, |old| count.max(had(old)))),
        }
    }
}

/// A number to this many decimals, or to tens, hundreds and so on below 0.
pub(crate) fn rounded(number: f64, decimals: i32) -> f64 {
    let result = match usize::try_from(decimals) {
        // Through decimal digits, so that no sum of powers of two makes 0.30000000000000004 of them.
        Ok(decimals) => format!("{number:.*}", decimals.min(60)).parse().unwrap_or(number),
        Err(_) => {
            let step = 10f64.powi(-decimals);
            (number / step).round() * step
        }
    };
    // Without the sign of -0.
    if result == 0.0 { 0.0 } else { result }
}

/// What `Display` prints of a value, with every number rounded. `decimals` says how, by its index among the numbers.
pub(super) fn rounded_text(value: &impl Display, decimals: impl Fn(usize) -> Decimals) -> String {
    let source = Source::new("value", value.to_string());
    let numbers = words(&tokenize(&source).tokens).into_iter().filter_map(|(word, span)| match word {
        Word::Number(number) => Some((number, span)),
        Word::Other(_) => None,
    });
    let replaced = numbers.enumerate().map(|(index, (number, span))| {
        let text = SceneNumber(decimals(index).write(number, None)).to_string();
        TextReplacement { range: span.range(), text }
    });
    super::applied(source.text(), &replaced.collect::<Vec<_>>())
}

/// A word of a text. A number has its sign.
#[derive(Debug, Clone, PartialEq)]
enum Word {
    Number(f64),
    Other(TokenKind),
}

fn words(tokens: &[Token]) -> Vec<(Word, SourceSpan)> {
    let mut words = Vec::new();
    let mut tokens = tokens.iter().peekable();
    while let Some(Token { kind, span, .. }) = tokens.next() {
        let negative = *kind == TokenKind::Mark(Mark::Minus);
        let word = match (kind, tokens.peek()) {
            (TokenKind::Number(value), _) => (Word::Number(*value), *span),
            (_, Some(Token { kind: TokenKind::Number(value), span: end, .. })) if negative => {
                tokens.next();
                (Word::Number(-value), span.to(*end))
            }
            (TokenKind::End, _) => continue,
            (other, _) => (Word::Other(other.clone()), *span),
        };
        words.push(word);
    }
    words
}

/// The replacements that make `new` of `old` in a range of tokens that declares `old`. `decimals` says how each number
/// is written, by its index among the numbers. If the words of `new` are others, everything is written again.
pub(super) fn realigned<T: Display>(
    text: &SceneText,
    tokens: Range<usize>,
    old: &T,
    new: &T,
    decimals: impl Fn(usize) -> Decimals,
) -> Vec<TextReplacement> {
    let printed = |value: &T| words(&tokenize(&Source::new("value", value.to_string())).tokens);
    let (written, old, wanted) = (words(text.tokens(tokens)), printed(old), printed(new));
    let alike = |(one, _): &(Word, SourceSpan), (other, _): &(Word, SourceSpan)| match (one, other) {
        (Word::Number(_), Word::Number(_)) => true,
        (one, other) => one == other,
    };
    let aligned = written.len() == wanted.len()
        && written.len() == old.len()
        && written.iter().zip(&wanted).all(|(one, other)| alike(one, other));
    if !aligned {
        let Some(((_, first), (_, last))) = written.first().zip(written.last()) else { return Vec::new() };
        return vec![TextReplacement { range: first.to(*last).range(), text: rounded_text(new, decimals) }];
    }
    let mut replaced = Vec::new();
    let mut index = 0;
    for (((written, span), (old, _)), (wanted, _)) in written.iter().zip(&old).zip(&wanted) {
        let (Word::Number(written), Word::Number(old), Word::Number(wanted)) = (written, old, wanted) else { continue };
        let number = decimals(index).write(*wanted, Some(*written));
        index += 1;
        if wanted != old && number != *written {
            replaced.push(TextReplacement { range: span.range(), text: SceneNumber(number).to_string() });
        }
    }
    replaced
}
