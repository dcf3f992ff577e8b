//! The marks around the text: line numbers, the line of the cursor, underlines of errors, parentheses.
//!
//! They are drawn for the rows of a layout, and only for those in view.

use super::colouring::Laid;
use super::lines::fitting;
use super::palette::Palette;
use crate::lang::diagnostic::{Diagnostic, Severity};
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};
use std::ops::Range;
use std::sync::Arc;

/// A text on the screen.
pub(super) struct VisibleText {
    /// The layout.
    pub laid: Arc<Laid>,
    /// Where it starts on the screen.
    pub origin: Pos2,
    /// The part of the screen that shows it.
    pub clip: Rect,
}

impl VisibleText {
    /// The lines in view.
    fn visible(&self) -> Range<usize> {
        let rows = &self.laid.galley.rows;
        let [top, bottom] = [self.clip.top() - self.origin.y, self.clip.bottom() - self.origin.y];
        rows.partition_point(|row| row.max_y() < top)..rows.partition_point(|row| row.min_y() <= bottom)
    }

    /// The top and the bottom of a line on the screen.
    fn heights(&self, line: usize) -> [f32; 2] {
        let rows = &self.laid.galley.rows;
        rows.get(line)
            .or(rows.last())
            .map_or([self.origin.y; 2], |row| [self.origin.y + row.min_y(), self.origin.y + row.max_y()])
    }

    /// Where a byte is on the screen: a vertical line, as high as its row.
    pub(super) fn caret(&self, text: &str, byte: usize) -> [Pos2; 2] {
        let (line, column) = self.laid.lines.place(text, byte);
        let x = self.laid.galley.rows.get(line).map_or(0.0, |row| row.pos.x + row.x_offset(column.into()));
        self.heights(line).map(|y| pos2(self.origin.x + x, y))
    }

    /// The rectangles, one per line, that cover a range of bytes, as far as they are in view. Each has a minimum
    /// width, so it is visible.
    pub(super) fn rectangles(&self, text: &str, range: Range<usize>) -> Vec<Rect> {
        let range = fitting(text, range);
        let lines = &self.laid.lines;
        let visible = self.visible();
        let touched = lines.line_of(range.start).max(visible.start)..(lines.line_of(range.end) + 1).min(visible.end);
        touched
            .filter_map(|line| {
                let bytes = lines.bytes(line);
                let end = if text[bytes.clone()].ends_with('\n') { bytes.end - 1 } else { bytes.end };
                let [from, to] = [range.start.max(bytes.start), range.end.min(end)];
                // A line is not included if the range only reaches its start.
                if from > end || (to <= from && range.start < bytes.start) {
                    return None;
                }
                let [[start, _], [_, stop]] = [self.caret(text, from), self.caret(text, to.max(from))];
                Some(Rect::from_min_max(start, pos2(stop.x.max(start.x + 6.0), stop.y)))
            })
            .collect()
    }

    /// Draws what is behind the text: the line of the cursor, matches, and the parentheses at the cursor.
    pub(super) fn behind(
        &self,
        text: &str,
        cursor: usize,
        found: &[Range<usize>],
        selected: &Range<usize>,
        palette: &Palette,
    ) -> Vec<Shape> {
        let [top, bottom] = self.heights(self.laid.lines.line_of(cursor));
        let line = Rect::from_x_y_ranges(self.clip.x_range(), top..=bottom);
        let mut shapes = vec![Shape::rect_filled(line, 0.0, palette.line)];
        let visible = self.visible();
        let [first, last] = [visible.start, visible.end].map(|line| self.laid.lines.bytes(line).start);
        for range in found.iter().filter(|range| range.end >= first && range.start <= last.max(first)) {
            let colour = if range == selected { palette.found_here } else { palette.found };
            shapes.extend(self.rectangles(text, range.clone()).into_iter().map(|rect| Shape::rect_filled(rect, 2.0, colour)));
        }
        if let Some((one, other)) = self.laid.words.brackets(cursor) {
            let colour = if other.is_some() { palette.bracket } else { palette.error };
            for at in [Some(one), other].into_iter().flatten() {
                let boxes = self.rectangles(text, at..at + 1).into_iter();
                shapes
                    .extend(boxes.map(|rect| Shape::rect_stroke(rect, 2.0, Stroke::new(1.0, colour), egui::StrokeKind::Inside)));
            }
        }
        shapes
    }

    /// Underlines errors and warnings. Returns the diagnostics under the pointer.
    pub(super) fn underline<'d>(
        &self,
        painter: &Painter,
        text: &str,
        diagnostics: &'d [Diagnostic],
        pointer: Option<Pos2>,
        palette: &Palette,
    ) -> Vec<&'d Diagnostic> {
        let mut under = Vec::new();
        // Errors are drawn last, on top of warnings.
        let mut ordered: Vec<&Diagnostic> = diagnostics.iter().collect();
        ordered.sort_by_key(|diagnostic| diagnostic.severity());
        for diagnostic in ordered {
            let Some(span) = diagnostic.span() else { continue };
            for rect in self.rectangles(text, span.range()) {
                painter.add(wave(rect, colour_of(diagnostic.severity(), palette)));
                if pointer.is_some_and(|pointer| rect.expand(2.0).contains(pointer)) {
                    under.push(diagnostic);
                }
            }
        }
        under
    }

    /// The width of the gutter for the numbers of all lines.
    pub(super) fn gutter_width(laid: &Laid, digit: f32) -> f32 {
        let digits = laid.lines.count().max(100).ilog10() + 1;
        digits as f32 * digit + 24.0
    }

    /// Draws the gutter. Returns the diagnostics of the line under the pointer.
    pub(super) fn gutter<'d>(
        &self,
        painter: &Painter,
        (rect, font): (Rect, &FontId),
        (text, cursor): (&str, usize),
        diagnostics: &'d [Diagnostic],
        pointer: Option<Pos2>,
        palette: &Palette,
    ) -> Vec<&'d Diagnostic> {
        let lines = &self.laid.lines;
        let current = lines.line_of(cursor);
        let line_of = |diagnostic: &Diagnostic| diagnostic.span().map_or(0, |span| lines.place(text, span.range().start).0);
        let marked: Vec<(usize, &Diagnostic)> = diagnostics.iter().map(|diagnostic| (line_of(diagnostic), diagnostic)).collect();
        let mut under = Vec::new();
        painter.rect_filled(rect, 0.0, palette.background);
        for line in self.visible() {
            let [top, bottom] = self.heights(line);
            let middle = (top + bottom) / 2.0;
            let here = Rect::from_x_y_ranges(rect.x_range(), top..=bottom);
            if line == current {
                painter.rect_filled(here, 0.0, palette.line);
            }
            let colour = if line == current { palette.plain } else { palette.number_of_line };
            painter.text(pos2(rect.right() - 8.0, middle), Align2::RIGHT_CENTER, line + 1, font.clone(), colour);
            let of_line = || marked.iter().filter(|(of, _)| *of == line).map(|(_, diagnostic)| *diagnostic);
            if let Some(severity) = of_line().map(Diagnostic::severity).max() {
                painter.circle_filled(pos2(rect.left() + 8.0, middle), 3.5, colour_of(severity, palette));
                if pointer.is_some_and(|pointer| here.contains(pointer)) {
                    under.extend(of_line());
                }
            }
        }
        under
    }
}

/// The colour of a severity.
pub(super) fn colour_of(severity: Severity, palette: &Palette) -> Color32 {
    match severity {
        Severity::Error => palette.error,
        Severity::Warning => palette.warning,
    }
}

/// Draws a wavy line at the bottom of a rectangle.
fn wave(rect: Rect, colour: Color32) -> Shape {
    const STEP: f32 = 2.0;
    // A long mark needs no more points than fit on a screen.
    let count = ((rect.width() / STEP).ceil() as usize).clamp(3, 2000);
    let points = (0..=count).map(|at| {
        let up = if at % 2 == 0 { 0.0 } else { -2.0 };
        rect.left_bottom() + vec2((at as f32 * STEP).min(rect.width()), up)
    });
    Shape::line(points.collect(), Stroke::new(1.2, colour))
}
