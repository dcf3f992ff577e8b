//! The small row in a corner of the picture that chooses what the handles of the selected thing do.

use crate::preview::app::action::shortcut_of;
use crate::preview::app::hand::object::has_tool;
use crate::preview::app::{Action, App, HandleTool, SceneAction};
use egui::{
    Color32, CornerRadius, Painter, Pos2, Rect, Sense, Shape, Stroke, StrokeKind, Ui, Vec2, WidgetInfo, WidgetType, vec2,
};

/// The side of a button, in points.
const BUTTON: f32 = 28.0;
/// The distance of the row from the edges of the picture, and of its buttons from its own edge.
const MARGIN: f32 = 10.0;
const PADDING: f32 = 3.0;

impl App {
    /// Draws the row if what is selected has handles of several tools.
    pub(super) fn tool_row(&self, ui: &Ui, actions: &mut Vec<Action>) {
        let view = self.scene_view();
        let has_tool = |tool: &HandleTool| view.selected.is_some_and(|object| has_tool(view.world.scene(), object, *tool));
        let tools: Vec<HandleTool> = HandleTool::ALL.into_iter().filter(has_tool).collect();
        let count = tools.len() as f32;
        let size = vec2(count * BUTTON + 2.0 * PADDING, BUTTON + 2.0 * PADDING);
        let row = Rect::from_min_size(view.picture().min + Vec2::splat(MARGIN), size);
        if !self.hand.markers || tools.len() < 2 || !view.picture().contains_rect(row.expand(MARGIN)) {
            return;
        }
        let painter = ui.painter_at(view.area);
        let visuals = ui.visuals();
        painter.rect(row, 6.0, visuals.window_fill.gamma_multiply(0.92), visuals.window_stroke, StrokeKind::Inside);
        for (place, tool) in tools.into_iter().enumerate() {
            let corner = row.min + vec2(PADDING + place as f32 * BUTTON, PADDING);
            let button = Rect::from_min_size(corner, Vec2::splat(BUTTON));
            let action = Action::Scene(SceneAction::Handles(tool));
            // A drag on it is none on the picture.
            let response = ui.interact(button, ui.id().with(("handles", place)), Sense::click_and_drag());
            let selected = view.selected.is_some_and(|object| view.tool_of(object) == tool);
            let info = || WidgetInfo::selected(WidgetType::SelectableLabel, true, selected, tool.name());
            response.widget_info(info);
            let style = ui.style().interact_selectable(&response, selected);
            if selected || response.hovered() {
                painter.rect_filled(button.shrink(1.0), CornerRadius::same(4), style.weak_bg_fill);
            }
            icon(&painter, button.center(), tool, style.text_color());
            let keys = shortcut_of(&action, ui);
            let tooltip = format!("{} what is selected with handles ({keys})", tool.name());
            if response.on_hover_text(tooltip).clicked() {
                actions.push(action);
            }
        }
    }
}

/// Draws the icon of a tool: arrows in four directions, an arrow that turns, a square that becomes larger.
fn icon(painter: &Painter, at: Pos2, tool: HandleTool, colour: Color32) {
    let stroke = Stroke::new(1.5, colour);
    let head = |tip: Pos2, towards: Vec2, size: f32| {
        let across = vec2(-towards.y, towards.x);
        let back = tip - size * towards;
        let points = vec![tip, back + 0.75 * size * across, back - 0.75 * size * across];
        painter.add(Shape::convex_polygon(points, colour, Stroke::NONE));
    };
    match tool {
        HandleTool::Move => {
            for towards in [Vec2::UP, Vec2::DOWN, Vec2::LEFT, Vec2::RIGHT] {
                painter.line_segment([at, at + 6.0 * towards], stroke);
                head(at + 9.0 * towards, towards, 4.0);
            }
        }
        HandleTool::Rotate => {
            let radius = 7.0;
            let points = (0..=20).map(|step| {
                // From the upper right, round to the upper left.
                let angle = (-35.0 + 280.0 * step as f32 / 20.0).to_radians();
                at + radius * Vec2::angled(angle)
            });
            let points: Vec<Pos2> = points.collect();
            let start = points[0];
            painter.add(Shape::line(points, stroke));
            head(start + 3.5 * Vec2::angled(-125f32.to_radians()), Vec2::angled(-125f32.to_radians()), 5.0);
        }
        HandleTool::Scale => {
            let small = Rect::from_min_max(at + vec2(-8.0, 1.0), at + vec2(-1.0, 8.0));
            painter.rect_stroke(small, 1.0, stroke, StrokeKind::Inside);
            let towards = vec2(1.0, -1.0).normalized();
            painter.line_segment([at + vec2(0.5, -0.5), at + vec2(5.5, -5.5)], stroke);
            head(at + vec2(8.0, -8.0), towards, 5.0);
        }
    }
}
