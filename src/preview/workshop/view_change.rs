//! Changes of the view transform: exposure, tone curve and transfer. They can be undone, like changes of values.

use super::Workshop;
use super::history::HistoryEntry;
use crate::picture::ViewTransform;

impl Workshop {
    /// Changes the view transform. The change can be undone.
    pub fn set_view(&mut self, view: ViewTransform) {
        self.release_view();
        self.drag_view(view);
        self.release_view();
    }

    /// Changes the view transform by something that the user holds. All changes until it is released are one step.
    pub fn drag_view(&mut self, view: ViewTransform) {
        if view == self.picture.view {
            return;
        }
        if !self.view_is_held {
            self.history.push(HistoryEntry::View(self.picture.view));
            self.view_is_held = true;
        }
        self.show_through(view);
    }

    /// Ends a change of the view transform.
    pub fn release_view(&mut self) {
        self.view_is_held = false;
    }

    /// Shows the picture through a view transform. Nothing is traced or evaluated again.
    pub(super) fn show_through(&mut self, view: ViewTransform) {
        self.picture.view = view;
        self.request_picture();
    }
}
