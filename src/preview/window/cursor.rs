//! The pointer shapes of minifb for those of egui.

use egui::CursorIcon;
use minifb::CursorStyle;

/// The closest shape.
pub(super) fn style(icon: CursorIcon) -> CursorStyle {
    match icon {
        CursorIcon::Text | CursorIcon::VerticalText => CursorStyle::Ibeam,
        CursorIcon::Crosshair | CursorIcon::Cell => CursorStyle::Crosshair,
        CursorIcon::PointingHand | CursorIcon::Grab => CursorStyle::OpenHand,
        CursorIcon::Grabbing => CursorStyle::ClosedHand,
        CursorIcon::ResizeHorizontal | CursorIcon::ResizeColumn | CursorIcon::ResizeEast | CursorIcon::ResizeWest => {
            CursorStyle::ResizeLeftRight
        }
        CursorIcon::ResizeVertical | CursorIcon::ResizeRow | CursorIcon::ResizeNorth | CursorIcon::ResizeSouth => {
            CursorStyle::ResizeUpDown
        }
        CursorIcon::Move
        | CursorIcon::AllScroll
        | CursorIcon::ResizeNeSw
        | CursorIcon::ResizeNwSe
        | CursorIcon::ResizeNorthEast
        | CursorIcon::ResizeNorthWest
        | CursorIcon::ResizeSouthEast
        | CursorIcon::ResizeSouthWest => CursorStyle::ResizeAll,
        CursorIcon::Default
        | CursorIcon::None
        | CursorIcon::ContextMenu
        | CursorIcon::Help
        | CursorIcon::Progress
        | CursorIcon::Wait
        | CursorIcon::Alias
        | CursorIcon::Copy
        | CursorIcon::NoDrop
        | CursorIcon::NotAllowed
        | CursorIcon::ZoomIn
        | CursorIcon::ZoomOut => CursorStyle::Arrow,
    }
}
