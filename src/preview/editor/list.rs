//! The list of completions, below the cursor.

use super::palette::Palette;
use crate::assist::completion::{Candidate, Completion};
use egui::text::LayoutJob;
use egui::{Align, Area, Color32, Context, FontId, Frame, Id, LayerId, Order, Pos2, ScrollArea, TextFormat, pos2, vec2};

/// The largest height and width, in points.
const MOST: [f32; 2] = [220.0, 560.0];
/// The height of a line, in points.
const ROW: f32 = 24.0;

/// The list with its selected completion.
#[derive(Debug, Default)]
pub(super) struct List {
    shown: Option<Completion>,
    chosen: usize,
    /// Whether to scroll to the selected completion.
    moved: bool,
    /// The word at which the user closed the list. It stays closed there.
    dismissed: Option<usize>,
    /// Whether the user opened the list, or selected something in it.
    asked: bool,
}

impl List {
    /// Whether the list is open.
    pub(super) fn is_open(&self) -> bool {
        self.shown.is_some()
    }

    /// Shows completions, or closes the list. The list does not open by itself at a word that is complete, so the keys
    /// stay the text's.
    pub(super) fn offer(&mut self, completion: Option<Completion>, text: &str, asked: bool) {
        self.asked |= asked;
        if completion.as_ref().is_some_and(|completion| self.dismissed.is_some_and(|at| at != completion.word.start)) || asked {
            self.dismissed = None;
        }
        let wanted = |completion: &Completion| {
            let typed = &text[completion.word.clone()];
            let whole = completion.candidates.first().is_some_and(|first| first.name == typed);
            self.asked || (!typed.is_empty() && !whole && self.dismissed.is_none())
        };
        let shown = completion.filter(wanted);
        if self.shown != shown {
            (self.chosen, self.moved) = (0, true);
        }
        self.shown = shown;
        if self.shown.is_none() {
            self.asked = false;
        }
    }

    /// Closes the list.
    pub(super) fn close(&mut self) {
        (self.shown, self.asked) = (None, false);
    }

    /// Closes the list until another word is typed.
    pub(super) fn dismiss(&mut self) {
        self.dismissed = self.shown.as_ref().map(|shown| shown.word.start);
        self.close();
    }

    /// Selects the next or the previous completion, from the end back to the start.
    pub(super) fn step(&mut self, down: bool) {
        if let Some(shown) = &self.shown {
            let count = shown.candidates.len();
            self.chosen = (self.chosen + if down { 1 } else { count - 1 }) % count;
            (self.moved, self.asked) = (true, true);
        }
    }

    /// The selected completion, and the word that it replaces.
    pub(super) fn chosen(&self) -> Option<(std::ops::Range<usize>, &Candidate)> {
        let shown = self.shown.as_ref()?;
        Some((shown.word.clone(), shown.candidates.get(self.chosen)?))
    }

    /// The layer that the list is drawn in.
    pub(super) fn layer(id: Id) -> LayerId {
        LayerId::new(Order::Foreground, id.with("list"))
    }

    /// Draws the list below (or above) the line from `top` to `bottom`. Returns whether a completion was clicked.
    pub(super) fn ui(&mut self, context: &Context, id: Id, [top, bottom]: [Pos2; 2], font: &FontId, palette: &Palette) -> bool {
        let Some(shown) = &self.shown else { return false };
        let screen = context.content_rect();
        let below = screen.bottom() - bottom.y;
        let above = top.y - screen.top();
        let height = MOST[0].min(below.max(above) - 16.0);
        let needed = height.min(shown.candidates.len() as f32 * ROW) + 16.0;
        let drops = below >= needed || below >= above;
        let (pivot, corner) = if drops { (egui::Align2::LEFT_TOP, bottom) } else { (egui::Align2::LEFT_BOTTOM, top) };
        let width = MOST[1].min(screen.width() - 24.0);
        let widest = shown.candidates.iter().map(|candidate| candidate.name.chars().count()).max().unwrap_or(0);
        let mut clicked = None;
        let area = Area::new(Self::layer(id).id)
            .order(Order::Foreground)
            .pivot(pivot)
            .fixed_pos(pos2(corner.x, corner.y))
            .constrain(true);
        area.show(context, |ui| {
            Frame::popup(ui.style()).inner_margin(3.0).show(ui, |ui| {
                ui.set_max_width(width);
                let scroll = ScrollArea::vertical().max_height(height).auto_shrink([true, true]);
                scroll.show(ui, |ui| {
                    ui.spacing_mut().item_spacing = vec2(0.0, 0.0);
                    for (at, candidate) in shown.candidates.iter().enumerate() {
                        let dimmed = if at == self.chosen { palette.plain } else { palette.comment };
                        let job = line(candidate, widest, font, (palette, dimmed), width);
                        let button = egui::Button::selectable(at == self.chosen, job).min_size(vec2(ui.available_width(), 0.0));
                        let response = ui.add(button);
                        if at == self.chosen && self.moved {
                            response.scroll_to_me(Some(Align::Center));
                        }
                        if response.clicked() {
                            clicked = Some(at);
                        }
                        response.on_hover_ui(|ui| {
                            ui.monospace(format!("{} {}", candidate.name, candidate.types));
                            ui.label(&candidate.doc);
                        });
                    }
                });
            });
        });
        self.moved = false;
        self.chosen = clicked.unwrap_or(self.chosen);
        clicked.is_some()
    }
}

/// A line of the list: the name, and a dimmed description.
fn line(candidate: &Candidate, widest: usize, font: &FontId, (palette, dimmed): (&Palette, Color32), width: f32) -> LayoutJob {
    let mut job = LayoutJob::default();
    let gap = " ".repeat((widest + 2).saturating_sub(candidate.name.chars().count()));
    job.append(&(candidate.name.clone() + &gap), 0.0, TextFormat::simple(font.clone(), palette.of(candidate.class)));
    let small = FontId::proportional(font.size * 0.92);
    if !candidate.types.is_empty() {
        // Some fonts lack the arrow of signatures.
        let even = FontId::monospace(font.size * 0.92);
        job.append(&format!("{}   ", candidate.types), 0.0, TextFormat::simple(even, palette.plain));
    }
    job.append(&candidate.doc, 0.0, TextFormat::simple(small, dimmed));
    job.wrap = egui::text::TextWrapping::truncate_at_width(width - 16.0);
    job
}
