//! Remembers the sizes of panels that the user drags.

use crate::user_data::settings::{PanelSide, PanelSizes};
use egui::panel::PanelState;
use egui::{Context, Id};

/// Notes the size of a panel when the user has dragged its border. Panels also shrink in a small window; that is not
/// what the user chose, so it is not noted.
pub(super) fn remember(context: &Context, panel: Id, side: PanelSide, sizes: &mut PanelSizes) {
    // The border of a panel has this id in egui.
    let border = panel.with("__resize");
    if let Some(state) = PanelState::load(context, panel).filter(|_| context.drag_stopped_id() == Some(border)) {
        let [width, height] = [state.size().x, state.size().y];
        sizes.set(
            side,
            match side {
                PanelSide::Texts | PanelSide::Parameters | PanelSide::InstrumentsAtRight => width,
                PanelSide::Owners | PanelSide::Inspector | PanelSide::Instruments | PanelSide::Fitting => height,
            },
        );
    }
}
