//! The coloured layout of a text. It is made line by line, so a change costs only the changed line.
//!
//! The widget asks for the layout at least once per frame. If the text has not changed, it is the same layout again;
//! otherwise the unchanged lines keep theirs. Layouts refer to the atlas of glyphs, so all are dropped when the atlas
//! may have been cleared.

use super::lines::Lines;
use super::palette::Palette;
use crate::assist::words::{Class, Words};
use crate::workspace::FileKind;
use egui::text::{ByteIndex, LayoutJob, LayoutSection, TextFormat};
use egui::{Context, FontId, Galley};
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::Arc;

/// What the appearance of a line depends on, beside its words.
#[derive(Debug, Clone, PartialEq)]
struct LayoutKey {
    font: FontId,
    palette: Palette,
    pixels_per_point: f32,
    options: egui::epaint::TextOptions,
}

/// A text with its words, lines and layout.
pub(super) struct Laid {
    kind: FileKind,
    text: String,
    /// The words.
    pub words: Words,
    /// The positions of the lines.
    pub lines: Lines,
    /// The layout: one row per line.
    pub galley: Arc<Galley>,
}

/// The current layout, and the cached lines for the next one.
#[derive(Default)]
pub(super) struct Colouring {
    look: Option<LayoutKey>,
    laid: Option<Arc<Laid>>,
    /// Layouts by line and by the classes in it.
    kept: HashMap<u64, Arc<Galley>>,
    /// The last pass that asked for a layout, and how full the atlas of glyphs was then.
    seen: (u64, f32),
}

impl Colouring {
    /// The layout of a text; the current one if nothing changed.
    pub(super) fn lay(&mut self, context: &Context, kind: FileKind, text: &str, font: &FontId, palette: &Palette) -> Arc<Laid> {
        self.drop_stale(context, font, palette);
        let same = self.laid.take().filter(|laid| laid.kind == kind && laid.text == text);
        let laid = same.unwrap_or_else(|| {
            let (words, lines) = (Words::new(kind, text), Lines::new(text));
            let galley = self.galley(context, text, &words, &lines, font, palette);
            Arc::new(Laid { kind, text: text.to_owned(), words, lines, galley })
        });
        self.seen.1 = context.fonts(|fonts| fonts.font_atlas_fill_ratio());
        Arc::clone(self.laid.insert(laid))
    }

    /// Drops cached lines that look different now, or whose glyphs may have moved. The atlas is cleared between two
    /// passes, and is less full then. After passes without a layout, nothing is known.
    fn drop_stale(&mut self, context: &Context, font: &FontId, palette: &Palette) {
        let pass = context.cumulative_pass_nr();
        let (full, options) = context.fonts(|fonts| (fonts.font_atlas_fill_ratio(), *fonts.options()));
        let look = LayoutKey { font: font.clone(), palette: *palette, pixels_per_point: context.pixels_per_point(), options };
        if self.look.as_ref() != Some(&look) || pass > self.seen.0 + 1 || full < self.seen.1 {
            self.look = Some(look);
            self.laid = None;
            self.kept.clear();
        }
        self.seen = (pass, full);
    }

    fn galley(
        &mut self,
        context: &Context,
        text: &str,
        words: &Words,
        lines: &Lines,
        font: &FontId,
        palette: &Palette,
    ) -> Arc<Galley> {
        let mut kept = HashMap::with_capacity(lines.count());
        let mut first = 0;
        let galleys: Vec<Arc<Galley>> = (0..lines.count())
            .map(|line| {
                let whole = lines.bytes(line);
                let inner = &text[whole.clone()];
                let inner = inner.strip_suffix('\n').unwrap_or(inner);
                let range = whole.start..whole.start + inner.len();
                first += words.pieces[first..].partition_point(|(piece, _)| piece.end <= range.start);
                let pieces = words.pieces[first..].iter().take_while(|(piece, _)| piece.start < range.end);
                let pieces: Vec<(Range<usize>, Class)> = pieces
                    .map(|(piece, class)| {
                        (piece.start.max(range.start) - range.start..piece.end.min(range.end) - range.start, *class)
                    })
                    .collect();
                let mut hasher = DefaultHasher::new();
                (inner, &pieces).hash(&mut hasher);
                let key = hasher.finish();
                let galley = self.kept.get(&key).map(Arc::clone);
                let galley =
                    galley.unwrap_or_else(|| context.fonts_mut(|fonts| fonts.layout_job(job(inner, &pieces, font, palette))));
                kept.insert(key, Arc::clone(&galley));
                galley
            })
            .collect();
        self.kept = kept;
        let whole = LayoutJob::simple(text.to_owned(), font.clone(), palette.plain, f32::INFINITY);
        Arc::new(Galley::concat(Arc::new(whole), &galleys, context.pixels_per_point()))
    }
}

/// A coloured line.
fn job(line: &str, pieces: &[(Range<usize>, Class)], font: &FontId, palette: &Palette) -> LayoutJob {
    let mut job = LayoutJob { text: line.to_owned(), keep_trailing_whitespace: true, ..LayoutJob::default() };
    let mut push = |range: Range<usize>, class| {
        let format = TextFormat::simple(font.clone(), palette.of(class));
        let byte_range = ByteIndex(range.start)..ByteIndex(range.end);
        job.sections.push(LayoutSection { leading_space: 0.0, byte_range, format });
    };
    let mut at = 0;
    for (range, class) in pieces {
        if at < range.start {
            push(at..range.start, Class::Plain);
        }
        push(range.clone(), *class);
        at = range.end;
    }
    // An empty line needs a section too, which gives its height.
    if at < line.len() || line.is_empty() {
        push(at..line.len(), Class::Plain);
    }
    job
}
