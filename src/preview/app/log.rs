//! What happened: times of compiling and tracing, what was found, how drags ran; and a strip of the last frames.

use crate::evaluate::Method;
use crate::preview::FrameTimes;
use crate::preview::renderer::Event;
use crate::preview::workshop::Workshop;
use egui::{Color32, Pos2, Rect, ScrollArea, Sense, Stroke, Ui, pos2, vec2};
use std::collections::VecDeque;
use std::time::Duration;

/// So many lines, and frames, are kept.
const LINES: usize = 500;
const FRAMES: usize = 160;

/// The log.
#[derive(Default)]
pub(super) struct Log {
    lines: VecDeque<String>,
    /// Milliseconds of the last pictures.
    frames: VecDeque<f32>,
    drag: Option<DragTimes>,
    /// What the window did: milliseconds of layout, painting and present.
    window: [f32; 3],
    bytes_per_pixel: Option<f64>,
}

/// How a drag runs.
struct DragTimes {
    label: String,
    method: Option<Method>,
    times: Vec<f32>,
}

impl Log {
    /// Adds a line.
    pub(super) fn say(&mut self, line: String) {
        if self.lines.len() == LINES {
            self.lines.pop_front();
        }
        self.lines.push_back(line);
    }

    /// Takes note of what happened in the background.
    pub(super) fn take(&mut self, event: &Event, workshop: &Workshop) {
        match event {
            Event::Compiled(time) => self.say(format!("compiled in {}", milliseconds(*time))),
            Event::Traced { time, counts, size: [width, height], full } => {
                let pixels = (u64::from(*width) * u64::from(*height)).max(1) as f64;
                let kind = if *full { "traced" } else { "traced coarsely" };
                self.say(format!(
                    "{kind} {width}×{height} in {}: {} hits, {} lit records, {:.1} records a pixel",
                    milliseconds(*time),
                    thousands(counts.hits),
                    thousands(counts.records),
                    counts.records as f64 / pixels
                ));
            }
            Event::Ready { time, bytes_per_pixel } => {
                self.bytes_per_pixel = Some(*bytes_per_pixel);
                self.say(format!("ready in {}: {bytes_per_pixel:.1} bytes a pixel", milliseconds(*time)));
            }
            Event::Frame { method, time } => self.frame(*method, *time, workshop),
            Event::Failed(message) => self.say(format!("error: {message}")),
        }
    }

    fn frame(&mut self, method: Option<Method>, time: Duration, workshop: &Workshop) {
        let time = time.as_secs_f32() * 1e3;
        if self.frames.len() == FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(time);
        let label = workshop.held().map(|(owner, id)| workshop.values().roster().label(owner, id));
        match (label, &mut self.drag) {
            (Some(label), Some(drag)) if drag.label == label => {
                drag.method = method.or(drag.method);
                drag.times.push(time);
            }
            (Some(label), _) => {
                self.end_drag();
                self.drag = Some(DragTimes { label, method, times: vec![time] });
            }
            (None, _) => self.end_drag(),
        }
    }

    fn end_drag(&mut self) {
        let Some(DragTimes { label, method, times }) = self.drag.take() else { return };
        let mean = times.iter().sum::<f32>() / times.len().max(1) as f32;
        let method = method.map_or("interpreter", Method::name);
        self.say(format!("dragged {label}: {method}, {} frames, {mean:.2} ms a frame, {:.0} frames/s", times.len(), 1e3 / mean));
    }

    /// The memory at rest, in bytes a pixel, as far as it is known.
    pub(super) fn bytes_per_pixel(&self) -> Option<f64> {
        self.bytes_per_pixel
    }

    /// What the last picture took, in milliseconds.
    pub(super) fn last_frame(&self) -> Option<f32> {
        self.frames.back().copied()
    }

    /// Takes note of what the window did.
    pub(super) fn note_frame(&mut self, times: &FrameTimes) {
        let present = times.present.unwrap_or_default();
        self.window = [times.layout, times.painting, present].map(|time| time.as_secs_f32() * 1e3);
    }

    /// Draws it.
    pub(super) fn ui(&self, ui: &mut Ui) {
        ui.horizontal_top(|ui| {
            let strip = vec2(2.0 * FRAMES as f32, (ui.available_height() - 40.0).clamp(24.0, 90.0));
            ui.vertical(|ui| {
                ui.label("Evaluation of the last pictures");
                let (rect, _) = ui.allocate_exact_size(strip, Sense::hover());
                self.strip(ui, rect);
                let [layout, painting, present] = self.window;
                ui.small(format!("window: layout {layout:.1}, painting {painting:.1}, present {present:.1} ms"));
            });
            ui.separator();
            ScrollArea::vertical().auto_shrink(false).stick_to_bottom(true).show(ui, |ui| {
                ui.vertical(|ui| {
                    for line in &self.lines {
                        ui.monospace(line);
                    }
                });
            });
        });
    }

    fn strip(&self, ui: &Ui, rect: Rect) {
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
        let most = self.frames.iter().copied().fold(4.0_f32, f32::max);
        let height = |time: f32| rect.bottom() - time / most * (rect.height() - 14.0);
        for (index, time) in self.frames.iter().enumerate() {
            let left = rect.left() + 2.0 * index as f32;
            let bar = Rect::from_min_max(pos2(left, height(*time)), Pos2::new(left + 1.5, rect.bottom()));
            painter.rect_filled(bar, 0.0, ui.visuals().selection.stroke.color);
        }
        // A sixtieth of a second, where it is in sight.
        if most > 16.7 {
            let line = Stroke::new(1.0, Color32::from_rgb(200, 120, 60));
            painter.hline(rect.x_range(), height(1000.0 / 60.0), line);
        }
        let font = egui::TextStyle::Small.resolve(ui.style());
        painter.text(rect.left_top(), egui::Align2::LEFT_TOP, format!(" {most:.1} ms"), font, ui.visuals().text_color());
    }
}

/// A time for people.
pub(super) fn milliseconds(time: Duration) -> String {
    let time = time.as_secs_f64() * 1e3;
    if time < 10.0 {
        format!("{time:.2} ms")
    } else if time < 1000.0 {
        format!("{time:.0} ms")
    } else {
        format!("{:.2} s", time / 1e3)
    }
}

/// A count for people: 4 193 257.
pub(super) fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}
