//! Numbers that can be typed or dragged, all written with the same number of digits.

use egui::{DragValue, Response, Ui};

/// The width of a number in points: six digits, a point and a sign.
pub(super) const NUMBER_WIDTH: f32 = 68.0;

/// How the user changed a value.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum EditPhase {
    Dragged,
    Set,
    Released,
}

/// How a widget was used.
pub(super) fn phase(response: &Response) -> Option<EditPhase> {
    if response.drag_stopped() {
        Some(EditPhase::Released)
    } else if response.changed() {
        Some(if response.dragged() { EditPhase::Dragged } else { EditPhase::Set })
    } else {
        None
    }
}

/// A number 0..1 that can be typed or dragged, such as a component of a colour.
/// The field has this width in points.
pub(super) fn component_ui(ui: &mut Ui, width: f32, number: &mut f32) -> Option<EditPhase> {
    number_ui(ui, 1.0 / 400.0, width, number)
}

/// A number that can be typed or dragged, by `speed` for each point.
pub(super) fn number_ui(ui: &mut Ui, speed: f64, width: f32, number: &mut f32) -> Option<EditPhase> {
    let exact = *number;
    ui.spacing_mut().interact_size.x = width;
    // While it is edited, the whole number is shown, so that nothing is rounded.
    let is_edited = ui.memory(|memory| memory.has_focus(ui.next_auto_id()));
    // The widget has no limits: a number out of range is corrected later, with a message.
    let field = DragValue::new(number).speed(speed).max_decimals(4).update_while_editing(false);
    let field = field.custom_formatter(|shown, _| if is_edited { (shown as f32).to_string() } else { number_text(shown as f32) });
    let response = ui.add(field);
    let done = phase(&response);
    if !is_edited {
        response.on_hover_text(exact.to_string());
    }
    done
}

/// A number for the column of numbers: four digits, and the points below each other as far as the size allows it.
fn number_text(number: f32) -> String {
    let size = number.abs();
    let text = match size {
        _ if !number.is_finite() => number.to_string(),
        0.0 => "0.000".to_owned(),
        _ if size < 5e-4 => format!("{number:.0e}"),
        _ if size < 9.9995 => format!("{number:.3}"),
        _ if size < 99.995 => format!("{number:.2}"),
        _ if size < 999.95 => format!("{number:.1}"),
        _ if size < 99_999.5 => format!("{number:.0}"),
        _ => format!("{number:.1e}"),
    };
    format!("{text:>6}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_one_width_and_at_least_four_digits() {
        let numbers = [0.0, 1.0, 0.6, 0.0625, 9.9996, 60.0, 150.0, 999.96, 12_345.0, -0.25, 0.001];
        let texts = numbers.map(number_text);
        let wanted =
            [" 0.000", " 1.000", " 0.600", " 0.062", " 10.00", " 60.00", " 150.0", "  1000", " 12345", "-0.250", " 0.001"];
        assert_eq!(texts, wanted);
        // What has no such digits keeps its size.
        assert_eq!([3e-5, -2e-7, 1.5e9, f32::INFINITY].map(number_text), ["  3e-5", " -2e-7", " 1.5e9", "   inf"]);
    }
}
