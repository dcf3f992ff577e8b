//! The log: times of compiling and tracing, numbers of hits, statistics of drags, and a chart of the last frames.

use crate::lang::display_text::one_line;
use crate::lang::memory_size::MemorySize;
use crate::plan::Method;
use crate::preview::FrameTimes;
use crate::preview::renderer::{Event, PassCount};
use crate::preview::workshop::Workshop;
use egui::{Color32, Pos2, Rect, ScrollArea, Sense, Stroke, Ui, pos2, vec2};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// How many lines and frames are kept.
const LINES: usize = 500;
const FRAMES: usize = 160;

/// The log.
#[derive(Default)]
pub(super) struct Log {
    lines: VecDeque<String>,
    /// The times of the last pictures, in milliseconds.
    frames: VecDeque<f32>,
    drag: Option<DragTimes>,
    /// The times of the last frame: layout, painting and present, in milliseconds.
    window: [f32; 3],
    bytes_per_pixel: Option<f64>,
    /// How many passes the last picture has.
    last_passes: Option<PassCount>,
    /// How many NaN pixels the log has reported.
    undefined: usize,
    /// The first of them.
    first_undefined: Option<[u32; 2]>,
    /// Receives every line too.
    listener: Option<LogListener>,
}

type LogListener = Box<dyn FnMut(&str)>;

/// Statistics of a drag: of a slider, or of something in the scene.
#[derive(Default)]
struct DragTimes {
    label: String,
    /// The size of the last picture of a scene that is moved by hand.
    size: Option<[u32; 2]>,
    method: Option<Method>,
    /// The times of its pictures, in milliseconds.
    times: Vec<f32>,
    /// The stamp of the values after the last pointer movement.
    moved: Option<u64>,
    /// The stamps of values that are not on the screen yet, with the time of the pointer movement.
    awaited: VecDeque<(u64, Instant)>,
    /// The times from a pointer movement to its picture on the screen, in milliseconds.
    delays: Vec<f32>,
    /// The sums of layout, painting and present times of these frames, in milliseconds.
    window: [f32; 3],
}

impl Log {
    /// Adds a line. Names in it may hold any characters.
    pub(super) fn add(&mut self, line: impl AsRef<str>) {
        let line = one_line(line.as_ref());
        if let Some(listener) = &mut self.listener {
            listener(&line);
        }
        if self.lines.len() == LINES {
            self.lines.pop_front();
        }
        self.lines.push_back(line);
    }

    /// How many lines start with a word.
    #[cfg(test)]
    pub(super) fn lines_with(&self, word: &str) -> usize {
        self.lines.iter().filter(|line| line.starts_with(word)).count()
    }

    /// How many passes the last picture has.
    pub(super) fn last_passes(&self) -> PassCount {
        self.last_passes.unwrap_or_default()
    }

    /// Adds lines that are safe to display already, such as diagnostics with source lines.
    pub(super) fn say_lines(&mut self, text: &str) {
        text.lines().for_each(|line| self.add(line));
    }

    /// Passes every line to a listener too, starting with those that are there.
    pub(super) fn set_listener(&mut self, mut listener: impl FnMut(&str) + 'static) {
        self.lines.iter().for_each(|line| listener(line));
        self.listener = Some(Box::new(listener));
    }

    /// Records an event of the renderer.
    pub(super) fn record(&mut self, event: &Event, workshop: &Workshop) {
        match event {
            Event::Compiled(time) => self.add(format!("compiled in {}", milliseconds(*time))),
            Event::Traced { time, counts, size: [width, height], full } => {
                let pixels = (u64::from(*width) * u64::from(*height)).max(1) as f64;
                let kind = if *full { "traced" } else { "traced coarsely" };
                self.add(format!(
                    "{kind} {width}×{height} in {}: {} hits, {} lit records, {:.1} records a pixel",
                    milliseconds(*time),
                    thousands(counts.hits),
                    thousands(counts.records),
                    counts.records as f64 / pixels
                ));
            }
            Event::Ready { time, bytes_per_pixel } => {
                self.bytes_per_pixel = Some(*bytes_per_pixel);
                self.add(format!("ready in {}: {bytes_per_pixel:.1} bytes a pixel", milliseconds(*time)));
            }
            Event::Frame { method, time, passes } => {
                self.last_passes = Some(*passes);
                self.frame(*method, *time, workshop);
            }
            Event::Passes { kept, wanted, time, bytes } => {
                let memory = if kept < wanted { format!("; there is no memory for more of {wanted}") } else { String::new() };
                let [width, height] = workshop.size();
                self.bytes_per_pixel = Some(*bytes as f64 / f64::from((width * height).max(1)));
                let (time, bytes) = (milliseconds(*time), MemorySize(*bytes));
                self.add(format!("traced {kept} passes: {time} for those after the first, {bytes} of memory{memory}"));
            }
            Event::Moved { time, size } => self.moved(*time, *size, workshop),
            Event::Undefined(pixels, first) => {
                self.first_undefined = *first;
                if std::mem::replace(&mut self.undefined, *pixels) != *pixels && *pixels > 0 {
                    self.add(format!("the picture has {}", undefined_pixels(*pixels)));
                }
            }
            Event::Reviewed(Some(finding)) => self.add(finding.message()),
            Event::Reviewed(None) => {}
            // A notice says it, which is in the log too.
            Event::Failed(_) => {}
        }
    }

    fn frame(&mut self, method: Option<Method>, time: Duration, workshop: &Workshop) {
        let time = time.as_secs_f32() * 1e3;
        if self.frames.len() == FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(time);
        if self.dragged(workshop)
            && let Some(drag) = &mut self.drag
        {
            drag.method = method.or(drag.method);
            drag.times.push(time);
        }
    }

    /// Records a picture of a scene that is moved by hand.
    fn moved(&mut self, time: Duration, size: [u32; 2], workshop: &Workshop) {
        if self.dragged(workshop)
            && let Some(drag) = &mut self.drag
        {
            drag.size = Some(size);
            drag.times.push(time.as_secs_f32() * 1e3);
        }
    }

    /// Records what is held: a slider, or something in the scene. Returns whether there is something.
    fn dragged(&mut self, workshop: &Workshop) -> bool {
        let label = workshop.held().map(|(owner, id)| workshop.values().table().label(owner, id));
        let label = label.or_else(|| workshop.moving().map(str::to_owned));
        if self.drag.as_ref().map(|drag| &drag.label) != label.as_ref() {
            self.end_drag();
            self.drag = label.map(|label| DragTimes { label, ..DragTimes::default() });
        }
        self.drag.is_some()
    }

    fn end_drag(&mut self) {
        let Some(DragTimes { label, method, times, mut delays, window, size, .. }) = self.drag.take() else { return };
        if times.is_empty() {
            return;
        }
        let mean = times.iter().sum::<f32>() / times.len() as f32;
        let method = method.map_or("interpreter", Method::name);
        let frames = times.len();
        let line = match size {
            Some([width, height]) => {
                format!("moved {label}: {frames} pictures, {mean:.1} ms each, the last one {width}×{height}")
            }
            None => format!("dragged {label}: {method}, {frames} frames, {mean:.2} ms a frame, {:.0} frames/s", 1e3 / mean),
        };
        self.add(line);
        if delays.is_empty() {
            return;
        }
        delays.sort_by(f32::total_cmp);
        // Never beyond the last one.
        let share = |part: f32| delays[((delays.len() - 1) as f32 * part).round() as usize];
        let [layout, painting, present] = window.map(|sum| sum / delays.len() as f32);
        self.add(format!(
            "  from pointer to screen {:.1} ms, 99 % within {:.1} ms; layout {layout:.1}, painting {painting:.1}, present {present:.1} ms",
            share(0.5),
            share(0.99),
        ));
    }

    /// The memory of the picture at rest, in bytes per pixel, if it is known.
    pub(super) fn bytes_per_pixel(&self) -> Option<f64> {
        self.bytes_per_pixel
    }

    /// The number of NaN pixels of the last picture and the first of them; `None` if there are none.
    pub(super) fn undefined(&self) -> Option<(usize, [u32; 2])> {
        self.first_undefined.map(|first| (self.undefined, first))
    }

    /// The time of the last picture, in milliseconds.
    pub(super) fn last_frame(&self) -> Option<f32> {
        self.frames.back().copied()
    }

    /// Records the times of a frame.
    pub(super) fn record_frame(&mut self, times: &FrameTimes, workshop: &Workshop) {
        let present = times.present.unwrap_or_default();
        self.window = [times.layout, times.painting, present].map(|time| time.as_secs_f32() * 1e3);
        if !self.dragged(workshop) {
            return;
        }
        let Some(drag) = &mut self.drag else { return };
        // A movement that changed no value has no picture.
        if let Some(motion) = times.motion
            && drag.moved.replace(workshop.stamp()) != Some(workshop.stamp())
        {
            drag.awaited.push_back((workshop.stamp(), motion));
        }
        let (Some(_), Some(finished)) = (times.present, times.finished) else { return };
        // The picture also shows all earlier values. The earliest movement has waited longest.
        while let Some((_, motion)) = drag.awaited.pop_front_if(|(stamp, _)| *stamp <= workshop.shown().values) {
            drag.delays.push((finished - motion).as_secs_f32() * 1e3);
            drag.window.iter_mut().zip(self.window).for_each(|(sum, time)| *sum += time);
        }
    }

    /// Draws the log.
    pub(super) fn ui(&self, ui: &mut Ui) {
        ui.horizontal_top(|ui| {
            let strip = vec2(2.0 * FRAMES as f32, (ui.available_height() - 40.0).clamp(24.0, 90.0));
            ui.vertical(|ui| {
                ui.label("Evaluation times of the last pictures");
                let (rect, _) = ui.allocate_exact_size(strip, Sense::hover());
                self.chart(ui, rect);
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

    fn chart(&self, ui: &Ui, rect: Rect) {
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
        let most = self.frames.iter().copied().fold(4.0_f32, f32::max);
        let height = |time: f32| rect.bottom() - time / most * (rect.height() - 14.0);
        for (index, time) in self.frames.iter().enumerate() {
            let left = rect.left() + 2.0 * index as f32;
            let bar = Rect::from_min_max(pos2(left, height(*time)), Pos2::new(left + 1.5, rect.bottom()));
            painter.rect_filled(bar, 0.0, ui.visuals().selection.stroke.color);
        }
        // The line of 60 frames per second, if it is within the chart.
        if most > 16.7 {
            let line = Stroke::new(1.0, Color32::from_rgb(200, 120, 60));
            painter.hline(rect.x_range(), height(1000.0 / 60.0), line);
        }
        let font = egui::TextStyle::Small.resolve(ui.style());
        painter.text(rect.left_top(), egui::Align2::LEFT_TOP, format!(" {most:.1} ms"), font, ui.visuals().text_color());
    }
}

/// A message about pixels that are NaN.
pub(super) fn undefined_pixels(count: usize) -> String {
    let plural = if count == 1 { "pixel" } else { "pixels" };
    format!("{} {plural} where the formula yields no number (NaN); black there", thousands(count as u64))
}

/// A time for the user.
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

/// A count for the user: 4 193 257.
pub(super) fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_safe_and_short() {
        let mut log = Log::default();
        log.add(format!("saved {}\u{1b}[31m\n\u{202e}", "x".repeat(1 << 20)));
        log.say_lines("one\n  two\n");
        let lines: Vec<&str> = log.lines.iter().map(String::as_str).collect();
        assert!(lines[0].ends_with("x\\u{1b}[31m\\n\\u{202e}") && lines[0].len() < 200, "{}", lines[0]);
        assert_eq!(lines[1..], ["one", "  two"]);
    }
}
