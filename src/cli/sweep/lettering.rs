//! Text drawn into pictures, with the font that the window uses for formulas.

use crate::cli::report::Failure;
use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use epaint_default_fonts::HACK_REGULAR;
use illuminator::picture::Bitmap;

/// Stands for what was left out.
const ELLIPSIS: char = '…';

/// A font in one size.
pub(super) struct Lettering {
    font: FontRef<'static>,
    scale: PxScale,
}

impl Lettering {
    /// The font in a size: the height of a line in pixels.
    pub(super) fn new(size: u32) -> Result<Self, Failure> {
        let font = FontRef::try_from_slice(HACK_REGULAR)
            .map_err(|error| Failure::input(format!("the built-in font cannot be read: {error}")))?;
        Ok(Self { font, scale: PxScale::from(size as f32) })
    }

    /// The height of a line in pixels.
    pub(super) fn height(&self) -> u32 {
        self.font.as_scaled(self.scale).height().ceil() as u32
    }

    /// The width of a text in pixels.
    pub(super) fn width(&self, text: &str) -> u32 {
        self.lay(text).1.ceil() as u32
    }

    /// The text, or as much of its beginning as is not wider than this, with an ellipsis.
    pub(super) fn shortened(&self, text: &str, width: u32) -> String {
        let mut kept = text.to_owned();
        let mut shown = kept.clone();
        while self.width(&shown) > width && kept.pop().is_some() {
            shown = format!("{}{ELLIPSIS}", kept.trim_end());
        }
        if self.width(&shown) > width { String::new() } else { shown }
    }

    /// Draws a line of text. Its top left corner is at `x`, `y`.
    pub(super) fn draw(&self, bitmap: &mut Bitmap, [x, y]: [u32; 2], text: &str, colour: [u8; 3]) {
        let scaled = self.font.as_scaled(self.scale);
        // A baseline between two rows of pixels would blur every letter.
        let baseline = scaled.ascent().round();
        for mut glyph in self.lay(text).0 {
            glyph.position = point(x as f32 + glyph.position.x, y as f32 + baseline);
            let Some(outline) = self.font.outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            outline.draw(|column, row, coverage| {
                let (column, row) = (corner.x + column as f32, corner.y + row as f32);
                if column >= 0.0 && row >= 0.0 {
                    bitmap.mix([column as u32, row as u32], colour, coverage.min(1.0));
                }
            });
        }
    }

    /// The glyphs of a line from 0, and its width in pixels.
    fn lay(&self, text: &str) -> (Vec<Glyph>, f32) {
        let scaled = self.font.as_scaled(self.scale);
        let (mut glyphs, mut at) = (Vec::new(), 0.0);
        let mut last = None;
        for character in text.chars() {
            let id = scaled.glyph_id(character);
            at += last.map_or(0.0, |last| scaled.kern(last, id));
            glyphs.push(id.with_scale_and_position(self.scale, point(at, 0.0)));
            at += scaled.h_advance(id);
            last = Some(id);
        }
        (glyphs, at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lettering() -> Lettering {
        Lettering::new(16).unwrap_or_else(|_| panic!("a font"))
    }

    #[test]
    fn text_covers_pixels_within_its_box_only() {
        let lettering = lettering();
        let (width, height) = (lettering.width("kd = 0.25"), lettering.height());
        let mut bitmap = Bitmap::filled(width + 20, height + 20, [255; 3]);
        lettering.draw(&mut bitmap, [10, 10], "kd = 0.25", [0; 3]);
        let dark = |x: u32, y: u32| bitmap.bytes()[3 * (y * (width + 20) + x) as usize] < 128;
        let places = (0..height + 20).flat_map(|y| (0..width + 20).map(move |x| [x, y]));
        let dark: Vec<[u32; 2]> = places.filter(|[x, y]| dark(*x, *y)).collect();
        assert!(dark.len() > 60 && dark.len() < (width * height / 3) as usize, "{} of {width}×{height}", dark.len());
        assert!(dark.iter().all(|[x, y]| (9..=10 + width).contains(x) && (10..10 + height).contains(y)), "{dark:?}");
        // Nothing is drawn outside of the picture, and nothing fails.
        lettering.draw(&mut bitmap, [width, height + 15], "cut off", [0; 3]);
    }

    #[test]
    fn signs_of_labels_are_in_the_font() {
        let lettering = lettering();
        for sign in "abz ABZ 0123456789 .=<>,*·×…→↓#ä".chars() {
            assert_ne!(lettering.font.glyph_id(sign).0, 0, "{sign}");
        }
    }

    #[test]
    fn long_texts_are_shortened() {
        let lettering = lettering();
        assert_eq!(lettering.shortened("short", 500), "short");
        let shortened = lettering.shortened("a very long name of a formula", 100);
        assert!(shortened.starts_with("a very") && shortened.ends_with('…'), "{shortened}");
        assert!(lettering.width(&shortened) <= 100);
        assert_eq!(lettering.shortened("name", 0), "");
    }
}
