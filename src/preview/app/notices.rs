//! Notices: messages about the user's work. They stay in view until they are dismissed, or are no longer true.

use crate::lang::display_text::{many_lines, one_line};
use egui::{Color32, CornerRadius, Frame, Margin, RichText, ScrollArea, Stroke, Ui, vec2};

/// The topic of a notice. There is at most one notice on a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Topic {
    /// The folder for user data.
    Home,
    /// Reading settings.
    Settings,
    /// Saving settings.
    SavingSettings,
    /// The list of recent files.
    Recent,
    /// Drafts of unsaved work.
    Drafts,
    /// Drafts of earlier runs.
    LeftDrafts,
    /// The startup session.
    Startup,
    /// The values of the open session.
    Session,
    /// The mistakes in the texts of the open session.
    Mistakes,
    /// The material library.
    Materials,
    /// The picture.
    Picture,
    /// The text of the scene, which does not follow a change by hand.
    SceneText,
}

/// How serious a notice is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum NoticeLevel {
    /// Something differs from what the user may expect.
    Warning,
    /// Work is in danger, or something does not work.
    Error,
}

/// A message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Notice {
    pub(super) topic: Topic,
    pub(super) severity: NoticeLevel,
    /// A short summary.
    pub(super) title: String,
    /// The reason, the consequences, and what helps; may have several lines.
    pub(super) details: String,
}

impl Notice {
    pub(super) fn warning(topic: Topic, title: impl AsRef<str>, details: impl AsRef<str>) -> Self {
        Self::new(topic, NoticeLevel::Warning, title.as_ref(), details.as_ref())
    }

    pub(super) fn error(topic: Topic, title: impl AsRef<str>, details: impl AsRef<str>) -> Self {
        Self::new(topic, NoticeLevel::Error, title.as_ref(), details.as_ref())
    }

    /// A notice whose texts are safe to display. Names in them may hold any characters.
    fn new(topic: Topic, severity: NoticeLevel, title: &str, details: &str) -> Self {
        Self { topic, severity, title: one_line(title), details: many_lines(details) }
    }
}

/// The notices.
#[derive(Default)]
pub(super) struct Notices {
    /// In the order of drawing: errors first, newer ones before older ones.
    shown: Vec<Notice>,
    /// Notices that were dismissed and are still true. They are not shown again.
    dismissed: Vec<Notice>,
}

impl Notices {
    /// Shows a notice instead of an earlier one on its topic. Returns whether it is new.
    pub(super) fn show(&mut self, notice: Notice) -> bool {
        if self.dismissed.contains(&notice) || self.shown.contains(&notice) {
            return false;
        }
        self.clear(notice.topic);
        self.shown.insert(0, notice);
        self.shown.sort_by_key(|notice| std::cmp::Reverse(notice.severity));
        true
    }

    /// Removes the notice on a topic, dismissed or not, because it is no longer true. Returns whether there was one.
    pub(super) fn clear(&mut self, topic: Topic) -> bool {
        let before = self.shown.len() + self.dismissed.len();
        for notices in [&mut self.shown, &mut self.dismissed] {
            notices.retain(|notice| notice.topic != topic);
        }
        self.shown.len() + self.dismissed.len() < before
    }

    /// Whether there is nothing to draw.
    pub(super) fn is_empty(&self) -> bool {
        self.shown.is_empty()
    }

    /// The notices in view.
    #[cfg(test)]
    pub(super) fn shown(&self) -> &[Notice] {
        &self.shown
    }

    /// Draws the notices in view, each with a button to dismiss it.
    pub(super) fn ui(&mut self, ui: &mut Ui) {
        let most_height = (0.3 * ui.ctx().content_rect().height()).max(80.0);
        let mut dismissed = None;
        if self.shown.len() > 1 {
            ui.horizontal(|ui| {
                ui.strong(format!("{} notices", self.shown.len()));
                if ui.small_button("Dismiss all").clicked() {
                    dismissed = Some(0..self.shown.len());
                }
            });
        }
        let scrolled = ScrollArea::vertical().max_height(most_height).min_scrolled_height(most_height);
        scrolled.auto_shrink([false, true]).show(ui, |ui| {
            for (index, notice) in self.shown.iter().enumerate() {
                if notice_ui(ui, notice) {
                    dismissed = Some(index..index + 1);
                }
            }
        });
        if let Some(range) = dismissed {
            self.dismissed.extend(self.shown.drain(range));
        }
    }
}

/// Draws a notice. Returns whether it is dismissed.
fn notice_ui(ui: &mut Ui, notice: &Notice) -> bool {
    const BUTTON_WIDTH: f32 = 64.0;
    let [fill, edge] = colours(notice.severity, ui.visuals().dark_mode);
    let frame = Frame::new().fill(fill).stroke(Stroke::new(1.0, edge)).corner_radius(CornerRadius::same(4));
    let shown = frame.inner_margin(Margin::symmetric(10, 7)).show(ui, |ui| {
        ui.horizontal_top(|ui| {
            ui.label(RichText::new("⚠").color(edge).size(16.0));
            let room = ui.available_width() - BUTTON_WIDTH - ui.spacing().item_spacing.x;
            ui.vertical(|ui| {
                ui.set_width(room.max(80.0));
                ui.strong(&notice.title);
                // Markers stand below the marked places, so this needs a monospaced font.
                if notice.details.contains('│') {
                    ui.monospace(&notice.details);
                } else if !notice.details.is_empty() {
                    ui.label(&notice.details);
                }
            });
            ui.add_sized(vec2(BUTTON_WIDTH, 20.0), egui::Button::new("Dismiss")).clicked()
        })
        .inner
    });
    shown.inner
}

/// The fill and the edge colour of a notice.
fn colours(severity: NoticeLevel, dark: bool) -> [Color32; 2] {
    match (severity, dark) {
        (NoticeLevel::Warning, true) => [Color32::from_rgb(54, 46, 28), Color32::from_rgb(222, 170, 62)],
        (NoticeLevel::Warning, false) => [Color32::from_rgb(255, 246, 222), Color32::from_rgb(176, 118, 0)],
        (NoticeLevel::Error, true) => [Color32::from_rgb(60, 33, 33), Color32::from_rgb(236, 104, 96)],
        (NoticeLevel::Error, false) => [Color32::from_rgb(255, 234, 232), Color32::from_rgb(196, 42, 34)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn titles(notices: &Notices) -> Vec<&str> {
        notices.shown().iter().map(|notice| notice.title.as_str()).collect()
    }

    #[test]
    fn a_topic_has_one_notice_and_the_same_is_said_once() {
        let mut notices = Notices::default();
        assert!(notices.show(Notice::error(Topic::Drafts, "not kept", "the disk is full")));
        assert!(notices.show(Notice::warning(Topic::Settings, "defaults are used", "")));
        assert!(!notices.show(Notice::error(Topic::Drafts, "not kept", "the disk is full")));
        assert!(notices.show(Notice::error(Topic::Drafts, "not kept", "permission denied")));
        assert_eq!(titles(&notices), ["not kept", "defaults are used"]);
        assert!(notices.clear(Topic::Drafts) && !notices.clear(Topic::Drafts));
        assert_eq!(titles(&notices), ["defaults are used"]);
    }

    #[test]
    fn what_was_dismissed_comes_back_only_when_it_is_news() {
        let full = || Notice::error(Topic::Drafts, "not kept", "the disk is full");
        let mut notices = Notices::default();
        notices.show(full());
        notices.dismissed.append(&mut notices.shown);
        assert!(!notices.show(full()) && notices.is_empty());
        // Another reason is new, and so is the same reason after it was no longer true.
        assert!(notices.show(Notice::error(Topic::Drafts, "not kept", "permission denied")));
        assert!(notices.show(full()));
        notices.dismissed.append(&mut notices.shown);
        assert!(notices.clear(Topic::Drafts) && notices.show(full()));
    }
}
