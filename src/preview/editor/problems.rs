//! The list of errors and warnings. A click on one leads to its place.

use super::document::Document;
use super::marks::colour_of;
use super::palette::Palette;
use crate::lang::diagnostic::{Diagnostic, Severity};
use crate::lang::source::SourceSpan;
use egui::text::LayoutJob;
use egui::{FontId, ScrollArea, TextFormat, TextStyle, Ui, vec2};

/// The indentation of details, in points.
const INDENT: f32 = 18.0;

/// Lists the errors and warnings of documents, errors first, with file, line and column. Returns the key of the
/// document and the span of the one that was clicked.
pub fn problems_ui<K: Copy>(ui: &mut Ui, documents: &[(K, &Document)]) -> Option<(K, SourceSpan)> {
    let palette = Palette::suiting(ui.visuals());
    let mut clicked = None;
    if documents.iter().all(|(_, document)| document.diagnostics().is_empty()) {
        ui.weak("No errors, no warnings.");
        return None;
    }
    ScrollArea::vertical().id_salt("problems").auto_shrink([false, false]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        for (key, document) in documents {
            let source = document.source();
            for severity in [Severity::Error, Severity::Warning] {
                for diagnostic in document.diagnostics().iter().filter(|diagnostic| diagnostic.severity() == severity) {
                    let span = diagnostic.span().unwrap_or_default();
                    let (line, column) = source.position(source.mark(span).start as u32);
                    let place = format!("{}:{line}:{column}", document.short_name());
                    let job = line_of(ui, &place, diagnostic, &palette);
                    let width = ui.available_width();
                    let button = egui::Button::new(job).frame_when_inactive(false).wrap().min_size(vec2(width, 0.0));
                    let mut is_clicked = ui.add(button).clicked();
                    for text in details(diagnostic) {
                        ui.horizontal_top(|ui| {
                            ui.add_space(INDENT);
                            let text = egui::RichText::new(text).color(ui.visuals().text_color());
                            let label = egui::Label::new(text).wrap().selectable(false).sense(egui::Sense::click());
                            is_clicked |= ui.add(label).clicked();
                        });
                    }
                    if is_clicked {
                        clicked = Some((*key, span));
                    }
                }
            }
        }
    });
    clicked
}

/// The first line of a diagnostic: severity, place and message.
fn line_of(ui: &Ui, place: &str, diagnostic: &Diagnostic, palette: &Palette) -> LayoutJob {
    let font: FontId = TextStyle::Body.resolve(ui.style());
    let (strong, dim) = (ui.visuals().strong_text_color(), ui.visuals().text_color());
    let mut job = LayoutJob::default();
    let mut add = |text: &str, colour| job.append(text, 0.0, TextFormat::simple(font.clone(), colour));
    let word = match diagnostic.severity() {
        Severity::Error => "Error",
        Severity::Warning => "Warning",
    };
    add(&format!("{word}  "), colour_of(diagnostic.severity(), palette));
    add(&format!("{place}  "), dim);
    add(diagnostic.message(), strong);
    job
}

/// The details of a diagnostic: its label and its hints.
pub(super) fn details(diagnostic: &Diagnostic) -> impl Iterator<Item = &str> {
    let label = diagnostic.labels().first().map(|label| label.text.as_str()).filter(|text| !text.is_empty());
    label.into_iter().chain(diagnostic.hints().iter().map(String::as_str))
}

/// A diagnostic as a tooltip.
pub(super) fn hover_ui(ui: &mut Ui, diagnostics: &[&Diagnostic]) {
    let palette = Palette::suiting(ui.visuals());
    ui.set_max_width(420.0);
    for diagnostic in diagnostics {
        ui.colored_label(colour_of(diagnostic.severity(), &palette), diagnostic.message());
        for text in details(diagnostic) {
            ui.label(text);
        }
    }
}
