//! What is known about the word under the pointer, as a tooltip.

use super::palette::Palette;
use crate::assist::completion::Candidate;
use crate::assist::meaning::meaning_at;
use crate::assist::symbols::{Symbol, symbols};
use crate::assist::words::Words;
use crate::preview::editor::Document;
use egui::{RichText, Ui};
use std::ops::Range;

/// The names that the text defines that was pointed at last, with the author's comments.
#[derive(Debug, Default)]
pub(super) struct PointedNames {
    /// The document and its revision.
    of: Option<(u64, u64)>,
    symbols: Vec<Symbol>,
}

impl PointedNames {
    /// What is known about the word at a byte, and the bytes of the word.
    pub(super) fn meaning(&mut self, document: &Document, words: &Words, byte: usize) -> Option<(Candidate, Range<usize>)> {
        let of = Some((document.id(), document.revision()));
        if self.of != of {
            (self.of, self.symbols) = (of, symbols(document.kind(), &document.source()));
        }
        meaning_at(document.kind(), document.text(), words, byte, &self.symbols)
    }
}

/// Draws what is known about a word, as a tooltip.
pub(super) fn hover_ui(ui: &mut Ui, known: &Candidate, palette: &Palette) {
    ui.set_max_width(420.0);
    ui.label(RichText::new(&known.name).monospace().strong().color(palette.of(known.class)));
    if !known.doc.is_empty() {
        ui.label(&known.doc);
    }
    if !known.types.is_empty() {
        ui.label(RichText::new(&known.types).monospace().weak());
    }
}
