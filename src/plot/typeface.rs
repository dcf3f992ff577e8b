//! The built-in fonts: how wide texts are, and the outlines of their letters.

use ab_glyph::{Font, FontRef, GlyphId, OutlineCurve, Point};
use epaint_default_fonts::{HACK_REGULAR, UBUNTU_LIGHT};
use std::sync::LazyLock;

/// Behind this character, which no font has, one character of a text is small and low.
pub(super) const SUBSCRIPT: char = '\u{e001}';

/// A letter with a small low one behind it, as texts of charts have it.
pub fn subscript(letter: &str, low: char) -> String {
    format!("{letter}{SUBSCRIPT}{low}")
}

/// A text of a chart for where there are no small low letters.
pub fn plain(text: &str) -> String {
    text.chars().filter(|letter| *letter != SUBSCRIPT).collect()
}

/// How large a subscript is, as a part of the size of the text.
pub(super) const SUBSCRIPT_SIZE: f64 = 0.72;
/// How far it is below the baseline, as a part of the size of the text.
pub(super) const SUBSCRIPT_DROP: f64 = 0.17;

/// The fonts. A letter that the first one lacks is taken from the second one.
static FONTS: LazyLock<Vec<FontRef<'static>>> =
    LazyLock::new(|| [UBUNTU_LIGHT, HACK_REGULAR].into_iter().filter_map(|bytes| FontRef::try_from_slice(bytes).ok()).collect());

/// A letter of a line of text.
pub(super) struct PlacedLetter {
    font: &'static FontRef<'static>,
    glyph: GlyphId,
    /// Where it begins, in units, from the beginning of the line, and how far its baseline is below that of the line.
    place: [f64; 2],
    /// Units of the figure for each unit of the font.
    scale: f64,
}

/// A piece of an outline, in units from the beginning of the line, downwards.
pub(super) enum OutlinePiece {
    Move([f64; 2]),
    Line([f64; 2]),
    Quad([f64; 2], [f64; 2]),
    Cubic([f64; 2], [f64; 2], [f64; 2]),
}

impl PlacedLetter {
    /// Its outline.
    pub(super) fn outline(&self) -> Vec<OutlinePiece> {
        let Some(outline) = self.font.outline(self.glyph) else { return Vec::new() };
        let at =
            |point: &Point| [self.place[0] + f64::from(point.x) * self.scale, self.place[1] - f64::from(point.y) * self.scale];
        let mut pieces = Vec::new();
        let mut pen: Option<Point> = None;
        for curve in &outline.curves {
            let (from, to, piece) = match curve {
                OutlineCurve::Line(from, to) => (from, to, OutlinePiece::Line(at(to))),
                OutlineCurve::Quad(from, control, to) => (from, to, OutlinePiece::Quad(at(control), at(to))),
                OutlineCurve::Cubic(from, first, second, to) => (from, to, OutlinePiece::Cubic(at(first), at(second), at(to))),
            };
            if pen != Some(*from) {
                pieces.push(OutlinePiece::Move(at(from)));
            }
            pieces.push(piece);
            pen = Some(*to);
        }
        pieces
    }
}

/// The letters of a line of text in a size, and its width.
pub(super) fn lay(text: &str, size: f64) -> (Vec<PlacedLetter>, f64) {
    let (mut letters, mut at) = (Vec::new(), 0.0);
    let mut last: Option<(usize, GlyphId)> = None;
    let mut is_low = false;
    for character in text.chars() {
        if character == SUBSCRIPT {
            is_low = true;
            continue;
        }
        let has = |font: &FontRef| font.glyph_id(character).0 != 0;
        let index = FONTS.iter().position(has).unwrap_or(0);
        let Some(font) = FONTS.get(index) else { continue };
        let glyph = font.glyph_id(character);
        let share = if is_low { SUBSCRIPT_SIZE } else { 1.0 };
        let scale = size * share / f64::from(font.units_per_em().unwrap_or(1000.0));
        if let Some((_, left)) = last.filter(|(other, _)| *other == index && !is_low) {
            at += f64::from(font.kern_unscaled(left, glyph)) * scale;
        }
        let drop = if is_low { SUBSCRIPT_DROP * size } else { 0.0 };
        letters.push(PlacedLetter { font, glyph, place: [at, drop], scale });
        at += f64::from(font.h_advance_unscaled(glyph)) * scale;
        last = (!is_low).then_some((index, glyph));
        is_low = false;
    }
    (letters, at)
}

/// The width of a text in a size.
pub(super) fn width(text: &str, size: f64) -> f64 {
    lay(text, size).1
}

/// The text, or as much of its beginning as is not wider than this, with an ellipsis.
pub(super) fn shortened(text: &str, size: f64, widest: f64) -> String {
    let mut kept = text.to_owned();
    let mut shown = kept.clone();
    while width(&shown, size) > widest && kept.pop().is_some() {
        shown = format!("{}…", kept.trim_end());
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fonts_have_what_charts_say() {
        for character in "θφπωαρ°−·²³⁻¹⁰⁴⁵⁶⁷⁸⁹×…≤∫ABCabc012".chars() {
            assert!(FONTS.iter().any(|font| font.glyph_id(character).0 != 0), "{character}");
        }
    }

    #[test]
    fn widths_follow_the_size() {
        let [small, large] = [10.0, 20.0].map(|size| width("incoming angle", size));
        assert!(small > 40.0 && small < 90.0 && (large - 2.0 * small).abs() < 1e-9, "{small} {large}");
        assert_eq!(width("", 10.0), 0.0);
        assert!(width(&format!("θ{SUBSCRIPT}h"), 10.0) < width("θh", 10.0));
        let short = shortened("a long name of a file", 10.0, 50.0);
        assert!(short.starts_with("a long") && short.ends_with('…') && width(&short, 10.0) <= 50.0, "{short}");
    }
}
