//! Remembers the sizes of panels that the user drags, and gives panels back their sizes.

use crate::user_data::settings::{PanelSide, PanelSizes};
use egui::panel::PanelState;
use egui::{Context, Id};

/// The border of a panel that is dragged has this id in egui.
fn border(panel: Id) -> Id {
    panel.with("__resize")
}

/// Whether the size of a side is a width, 0, or a height, 1.
fn axis(side: PanelSide) -> usize {
    match side {
        PanelSide::Texts | PanelSide::Parameters | PanelSide::InstrumentsAtRight | PanelSide::InstrumentsOverWidth => 0,
        PanelSide::Owners
        | PanelSide::Inspector
        | PanelSide::Instruments
        | PanelSide::InstrumentsOverHeight
        | PanelSide::Fitting => 1,
    }
}

/// The size that the user gave a panel. A panel that was made smaller, because there was no room, gets it back.
pub(super) fn wanted_size(context: &Context, panel: Id, side: PanelSide, sizes: &PanelSizes) -> f32 {
    let size = sizes.get(side);
    let held = [context.dragged_id(), context.drag_stopped_id()].contains(&Some(border(panel)));
    if let Some(state) = PanelState::load(context, panel).filter(|_| !held) {
        let (mut outer_rect, axis) = (state.outer_rect, axis(side));
        outer_rect.max[axis] = outer_rect.min[axis] + size;
        context.data_mut(|data| data.insert_persisted(panel, PanelState { outer_rect }));
    }
    size
}

/// Notes the size of a panel when the user has dragged its border. Panels also shrink in a small window; that is not
/// what the user chose, so it is not noted.
pub(super) fn remember(context: &Context, panel: Id, side: PanelSide, sizes: &mut PanelSizes) {
    if let Some(state) = PanelState::load(context, panel).filter(|_| context.drag_stopped_id() == Some(border(panel))) {
        sizes.set(side, state.size()[axis(side)]);
    }
}
