//! The frame of a dialog that waits for an answer.

use egui::{Context, Frame, Modal, ModalResponse, Ui};

/// A modal dialog with margins and a title.
pub(super) fn modal<R>(context: &Context, title: &str, content: impl FnOnce(&mut Ui) -> R) -> ModalResponse<R> {
    let frame = Frame::popup(&context.global_style()).inner_margin(18.0);
    Modal::new(egui::Id::new(("modal", title))).frame(frame).show(context, |ui| {
        ui.heading(title);
        ui.add_space(6.0);
        content(ui)
    })
}
