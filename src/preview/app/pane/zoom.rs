//! How large a picture is in its pane.

use egui::Vec2;

/// How large the picture is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Zoom {
    /// The whole picture has the size of the session, and is fitted into the pane.
    #[default]
    Fit,
    /// The picture is made as large as its pane.
    Pane,
    /// The picture has the size of the session, and this many screen pixels for each of its own.
    Fixed(f32),
}

impl Zoom {
    /// One screen pixel for each pixel of the picture.
    pub const ACTUAL: Self = Zoom::Fixed(1.0);

    /// Screen pixels for each pixel of a picture of this size. `room` is the size of the pane, in screen pixels.
    pub(super) fn factor(self, size: [u32; 2], room: Vec2) -> f32 {
        match self {
            Zoom::Fixed(factor) => factor,
            // A picture of another size than the pane will soon be replaced.
            Zoom::Fit | Zoom::Pane => {
                let [width, height] = size.map(|side| side.max(1) as f32);
                (room.x / width).min(room.y / height).max(0.0)
            }
        }
    }
}

/// The zoom factors of the wheel and of keys.
const STEPS: [f32; 16] = [1.0 / 16.0, 0.125, 0.25, 1.0 / 3.0, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 32.0];

/// The zoom factor some steps above or below this one.
pub(super) fn step(factor: f32, steps: i32) -> f32 {
    // A factor that is shown as the same percentage is the same.
    const NEAR: f32 = 1.005;
    let last = STEPS.len() - 1;
    let others = steps.unsigned_abs().min(4) as usize;
    if steps >= 0 {
        let above = STEPS.partition_point(|step| *step <= factor * NEAR);
        STEPS[(above + others).saturating_sub(1).min(last)]
    } else {
        let below = STEPS.partition_point(|step| *step < factor / NEAR);
        STEPS[below.saturating_sub(others).min(last)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::vec2;

    #[test]
    fn a_fitted_picture_touches_two_edges() {
        assert_eq!(Zoom::Fit.factor([1280, 720], vec2(640.0, 700.0)), 0.5);
        assert_eq!(Zoom::Fit.factor([64, 48], vec2(640.0, 96.0)), 2.0);
        assert_eq!(Zoom::ACTUAL.factor([1280, 720], vec2(640.0, 700.0)), 1.0);
    }

    #[test]
    fn steps_lead_to_the_next_factor_and_end() {
        assert_eq!([step(1.0, 1), step(1.0, -1), step(1.2, 1), step(1.2, -1), step(0.453, 2)], [1.5, 0.7, 1.5, 1.0, 0.7]);
        assert_eq!([step(16.0, 4), step(0.1, -9), step(100.0, -1), step(0.001, 1)], [32.0, 1.0 / 16.0, 32.0, 1.0 / 16.0]);
    }
}
