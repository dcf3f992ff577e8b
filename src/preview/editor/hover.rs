//! What is known about the word under the pointer, as a tooltip.

use super::palette::Palette;
use crate::assist::completion::Candidate;
use crate::assist::meaning::{author_doc, meaning_at};
use crate::assist::words::Words;
use crate::lang::ast::FormulaFile;
use crate::lang::parser::parse;
use crate::preview::editor::Document;
use egui::{RichText, Ui};
use std::ops::Range;

/// The syntax of the formula that was pointed at last, which has the author's comments.
#[derive(Debug, Default)]
pub(super) struct PointedSyntax {
    /// The document and its revision.
    of: Option<(u64, u64)>,
    file: FormulaFile,
}

impl PointedSyntax {
    /// What the author's comments say about a name of a formula.
    fn doc(&mut self, document: &Document, name: &str) -> Option<String> {
        let of = Some((document.id(), document.revision()));
        if self.of != of {
            (self.of, self.file) = (of, parse(&document.source()).0);
        }
        author_doc(&self.file, name)
    }

    /// What is known about the word at a byte, and the bytes of the word.
    pub(super) fn meaning(&mut self, document: &Document, words: &Words, byte: usize) -> Option<(Candidate, Range<usize>)> {
        meaning_at(document.kind(), document.text(), words, byte, |name| self.doc(document, name))
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
