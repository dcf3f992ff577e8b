//! Rows of parameters: names, sliders, numbers and signs, in columns that all rows of the panel share.

use crate::formula::{Parameter, ParameterId};
use crate::lang::display_text::one_line;
use crate::lang::types::Type;
use crate::lang::variables::Owner;
use crate::picture::Transfer;
use crate::preview::app::colours::{hex_ui, picker_ui, swatch_button};
use crate::preview::app::image_rows::{ImageEdit, image_cells, image_name};
use crate::preview::app::number_field::{EditPhase, NUMBER_WIDTH, number_ui, phase};
use crate::preview::workshop::is_movable;
use crate::workspace::{OwnerId, Values};
use egui::{
    Align2, Color32, ComboBox, Popup, PopupCloseBehavior, Response, Sense, Slider, Stroke, TextStyle, TextWrapMode, Ui,
    WidgetInfo, WidgetText, WidgetType, pos2, vec2,
};

/// What the user did with a value.
pub(super) enum ValueEdit {
    /// Moved it while holding it.
    Drag([f32; 3]),
    /// Set it.
    Set([f32; 3]),
    /// Released it, maybe with a last movement.
    Release([f32; 3]),
    /// Gives it to all owners of the same kind.
    Copy,
    /// Wants to see which pixels depend on it.
    ShowSensitivity,
    /// Wants to choose the image of a texture.
    ChooseImage,
}

/// The space between two columns, in points.
const GAP: f32 = 5.0;
/// The width of the mark of a component.
const MARK: f32 = 9.0;
/// The width of the sign at the end of a row.
const SIGN: f32 = 16.0;
/// The least width of a slider.
const LEAST_SLIDER: f32 = 36.0;

/// The widths of the columns that differ between panels, in points.
#[derive(Clone, Copy)]
pub(super) struct RowColumns {
    name: f32,
    slider: f32,
}

impl RowColumns {
    /// RowColumns for these names that fill the panel. Names that are too long are shortened.
    pub(super) fn new<'n>(ui: &Ui, names: impl Iterator<Item = &'n str>) -> Self {
        let font = TextStyle::Body.resolve(ui.style());
        let colour = ui.visuals().text_color();
        let width = |name: &str| ui.painter().layout_no_wrap(name.to_owned(), font.clone(), colour).size().x;
        let room = ui.available_width();
        let name = names.map(width).fold(40.0, f32::max).ceil().min((0.36 * room).floor());
        let slider = room - name - MARK - NUMBER_WIDTH - SIGN - 4.0 * GAP;
        Self { name, slider: slider.max(LEAST_SLIDER) }
    }
}

/// What all rows of the panel need.
pub(super) struct RowContext<'v> {
    pub(super) values: &'v Values,
    /// How colours are displayed.
    pub(super) transfer: Transfer,
    pub(super) columns: RowColumns,
}

impl RowContext<'_> {
    /// Draws a value with its name. `limit` says why the value is not what the user wanted, if so.
    pub(super) fn value_ui(&self, ui: &mut Ui, owner: OwnerId, id: ParameterId, limit: Option<&str>) -> Option<ValueEdit> {
        let parameter = self.values.table().parameter(id);
        let lock = self.values.lock_of(owner, id);
        let mut value = [0.0; 3];
        self.values.get(owner, id).iter().zip(&mut value).for_each(|(from, to)| *to = *from);
        let signs = Signs { lock: lock.as_deref(), limit };
        let edit = ui.push_id((owner, id), |ui| match parameter.ty {
            Type::Vector => self.vector_ui(ui, parameter, value, (owner, &signs)),
            Type::Texture => {
                let mut edit = None;
                row(ui, |ui| {
                    edit = self.name_ui(ui, parameter, owner, signs.lock);
                    space(ui, MARK);
                    let width = self.columns.slider + GAP + NUMBER_WIDTH;
                    let chosen = image_cells(ui, parameter, value[0], width).map(|chosen| match chosen {
                        ImageEdit::Choose => ValueEdit::ChooseImage,
                        ImageEdit::Clear => ValueEdit::Set([0.0; 3]),
                    });
                    edit = chosen.or(edit.take());
                });
                edit
            }
            Type::Scalar | Type::Truth => {
                let mut edit = None;
                row(ui, |ui| {
                    edit = self.name_ui(ui, parameter, owner, signs.lock);
                    space(ui, MARK);
                    let enabled = ui.add_enabled_ui(signs.lock.is_none(), |ui| {
                        if parameter.is_whole() {
                            self.whole_ui(ui, parameter, value[0])
                        } else {
                            self.number_row(ui, parameter, value[0])
                        }
                    });
                    ui.add_space((ui.available_width() - SIGN).max(0.0));
                    signs.ui(ui);
                    edit = enabled.inner.map(|(number, phase)| ValueEdit::new([number, 0.0, 0.0], phase)).or(edit.take());
                });
                edit
            }
        });
        edit.inner
    }

    /// Draws the rows of a vector: a colour has its swatch and its displayed value beside the name.
    fn vector_ui(&self, ui: &mut Ui, parameter: &Parameter, value: [f32; 3], of: (OwnerId, &Signs)) -> Option<ValueEdit> {
        let (owner, signs) = of;
        let is_colour = parameter.colour || parameter.predefined.is_some();
        let mut edit = None;
        let mut edited = None;
        if is_colour {
            row(ui, |ui| {
                edit = self.name_ui(ui, parameter, owner, signs.lock);
                space(ui, MARK);
                let cells = ui.add_enabled_ui(signs.lock.is_none(), |ui| {
                    let swatch = swatch_button(ui, self.transfer, value);
                    let popup = Popup::from_toggle_button_response(&swatch);
                    let popup = popup.close_behavior(PopupCloseBehavior::CloseOnClickOutside);
                    let picked = popup.show(|ui| picker_ui(ui, self.transfer, value)).and_then(|shown| shown.inner);
                    let entered = hex_ui(ui, self.transfer, value).map(|value| (value, EditPhase::Set));
                    picked.or(entered)
                });
                edited = cells.inner;
                ui.add_space((ui.available_width() - SIGN).max(0.0));
                signs.ui(ui);
            });
        }
        for index in 0..3 {
            ui.push_id(index, |ui| {
                row(ui, |ui| {
                    if is_colour || index > 0 {
                        space(ui, self.columns.name);
                    } else {
                        edit = self.name_ui(ui, parameter, owner, signs.lock);
                    }
                    component_mark(ui, is_colour, index);
                    let cells = ui.add_enabled_ui(signs.lock.is_none(), |ui| self.number_row(ui, parameter, value[index]));
                    if let Some((number, phase)) = cells.inner {
                        let mut moved = value;
                        moved[index] = number;
                        edited = Some((moved, phase));
                    }
                    if !is_colour && index == 0 {
                        signs.ui(ui);
                    }
                });
            });
        }
        edited.map(|(value, phase)| ValueEdit::new(value, phase)).or(edit)
    }

    /// Draws a name with its menu.
    fn name_ui(&self, ui: &mut Ui, parameter: &Parameter, owner: OwnerId, lock: Option<&str>) -> Option<ValueEdit> {
        let mut edit = None;
        let name = name_cell(ui, &parameter.name, self.columns.name).on_hover_text(tooltip(parameter, lock));
        name.context_menu(|ui| {
            if ui.button("Default").clicked() {
                edit = Some(ValueEdit::Set(parameter.default));
            }
            if owner.kind() != Owner::Global && ui.button("Copy to all owners of this kind").clicked() {
                edit = Some(ValueEdit::Copy);
            }
            if is_movable(parameter) && ui.button("Show which pixels depend on it").clicked() {
                edit = Some(ValueEdit::ShowSensitivity);
            }
        });
        if name.double_clicked() {
            edit = Some(ValueEdit::Set(parameter.default));
        }
        edit
    }

    /// Draws a check box for a switch, or a menu for choices.
    fn whole_ui(&self, ui: &mut Ui, parameter: &Parameter, number: f32) -> Option<(f32, EditPhase)> {
        let mut chosen = number;
        if parameter.switch {
            let mut on = number != 0.0;
            let state = if on { "on" } else { "off" };
            ui.checkbox(&mut on, state).on_hover_text(one_line(&parameter.name));
            chosen = f32::from(u8::from(on));
        } else {
            let name = |index: usize| parameter.choices.get(index).map_or_else(|| index.to_string(), |name| one_line(name));
            let width = self.columns.slider + GAP + NUMBER_WIDTH;
            let menu = ComboBox::from_id_salt("choices").width(width).truncate().selected_text(name(number as usize));
            menu.show_ui(ui, |ui| {
                for index in 0..parameter.choices.len() {
                    ui.selectable_value(&mut chosen, index as f32, name(index));
                }
            });
        }
        (chosen != number).then_some((chosen, EditPhase::Set))
    }

    /// Draws a slider and a number.
    fn number_row(&self, ui: &mut Ui, parameter: &Parameter, mut number: f32) -> Option<(f32, EditPhase)> {
        let range @ [low, high] = parameter.range.unwrap_or_else(|| self.extent(ui, number));
        let slider = Slider::new(&mut number, low..=high).show_value(false).logarithmic(is_logarithmic(range));
        ui.spacing_mut().slider_width = self.columns.slider;
        let slid = phase(&ui.add(slider));
        let entered = number_ui(ui, f64::from(high - low) / 400.0, NUMBER_WIDTH, &mut number);
        slid.or(entered).map(|phase| (number, phase))
    }

    /// The extent of the slider of a number without a range: 0..1, and as far as the number ever was.
    fn extent(&self, ui: &Ui, number: f32) -> [f32; 2] {
        let id = ui.id().with("extent");
        let [low, high] = ui.data(|data| data.get_temp(id)).unwrap_or([0.0_f32, 1.0]);
        let extent = [low.min(number), high.max(number)];
        ui.data_mut(|data| data.insert_temp(id, extent));
        extent
    }
}

impl ValueEdit {
    fn new(value: [f32; 3], phase: EditPhase) -> Self {
        match phase {
            EditPhase::Dragged => ValueEdit::Drag(value),
            EditPhase::Set => ValueEdit::Set(value),
            EditPhase::Released => ValueEdit::Release(value),
        }
    }
}

/// What the sign at the end of a row says.
struct Signs<'t> {
    /// Why the value is locked.
    lock: Option<&'t str>,
    /// Why the value is not what the user wanted.
    limit: Option<&'t str>,
}

impl Signs<'_> {
    /// Draws the sign. It takes the same space if there is none.
    fn ui(&self, ui: &mut Ui) {
        let (rect, response) = ui.allocate_exact_size(vec2(SIGN, ui.spacing().interact_size.y), Sense::hover());
        let said = match (self.lock, self.limit) {
            (Some(lock), _) => format!("locked: {lock}"),
            (None, Some(limit)) => limit.to_owned(),
            (None, None) => return,
        };
        response.widget_info(|| WidgetInfo::labeled(WidgetType::Label, true, &said));
        if self.lock.is_some() {
            let colour = ui.visuals().weak_text_color();
            let body = egui::Rect::from_center_size(rect.center() + vec2(0.0, 2.5), vec2(10.0, 7.5));
            let painter = ui.painter();
            // The lower half of the ring is behind the body of the lock.
            painter.circle_stroke(pos2(rect.center().x, body.top()), 3.2, Stroke::new(1.6, colour));
            painter.rect_filled(body, 1.5, colour);
        } else {
            // An end stop. The value is all right, so it has no colour of a warning.
            let stroke = Stroke::new(1.6, ui.visuals().weak_text_color());
            let (painter, at) = (ui.painter(), rect.center());
            painter.line_segment([at + vec2(3.0, -4.5), at + vec2(3.0, 4.5)], stroke);
            painter.line_segment([at + vec2(-4.0, 0.0), at + vec2(2.0, 0.0)], stroke);
        }
        response.on_hover_text(said);
    }
}

/// A row whose cells have fixed widths.
fn row(ui: &mut Ui, cells: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = GAP;
        cells(ui);
    });
}

/// An empty cell.
fn space(ui: &mut Ui, width: f32) {
    ui.allocate_exact_size(vec2(width, ui.spacing().interact_size.y), Sense::hover());
}

/// Draws a name in the column of names, shortened if it is too long.
fn name_cell(ui: &mut Ui, name: &str, width: f32) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(width, ui.spacing().interact_size.y), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Label, true, name));
    let colour = if response.hovered() { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
    let text = WidgetText::from(name).into_galley(ui, Some(TextWrapMode::Truncate), width, TextStyle::Body);
    let at = Align2::LEFT_CENTER.anchor_size(rect.left_center(), text.size()).min;
    ui.painter_at(rect).galley(at, text, colour);
    response
}

/// Draws the mark of a component of a vector: its colour, or its letter.
fn component_mark(ui: &mut Ui, is_colour: bool, index: usize) {
    let (rect, _) = ui.allocate_exact_size(vec2(MARK, ui.spacing().interact_size.y), Sense::hover());
    if is_colour {
        let marks = [Color32::from_rgb(222, 84, 84), Color32::from_rgb(78, 172, 88), Color32::from_rgb(84, 130, 226)];
        let bar = egui::Rect::from_center_size(rect.center(), vec2(4.0, 12.0));
        ui.painter().rect_filled(bar, 2.0, marks[index.min(2)]);
    } else {
        let font = TextStyle::Small.resolve(ui.style());
        let letter = ["x", "y", "z"][index.min(2)];
        ui.painter().text(rect.center(), Align2::CENTER_CENTER, letter, font, ui.visuals().weak_text_color());
    }
}

/// A slider is logarithmic if its range covers more than two decades.
fn is_logarithmic([low, high]: [f32; 2]) -> bool {
    low > 0.0 && high / low > 100.0
}

/// A description of a parameter for the tooltip.
fn tooltip(parameter: &Parameter, lock: Option<&str>) -> String {
    let said = parameter.doc.as_deref().map_or_else(String::new, |doc| format!("{}\n", one_line(doc)));
    let mut text = format!("{said}{}: {}", parameter.name, parameter.ty);
    if parameter.switch {
        text.push_str(", 0 or 1");
    } else if !parameter.choices.is_empty() {
        let names: Vec<String> = parameter.choices.iter().enumerate().map(|(index, name)| format!("{index} {name}")).collect();
        text.push_str(&format!(": {}", one_line(&names.join(", "))));
    } else if let Some([low, high]) = parameter.range {
        text.push_str(&format!(", {low} to {high}"));
    }
    if let Some(predefined) = parameter.predefined {
        text.push_str(&format!("\n{}", predefined.doc()));
    }
    match lock {
        Some(lock) => text.push_str(&format!("\nLocked: {lock}")),
        None => {
            let default = match parameter.ty {
                Type::Vector => format!("<{}>", parameter.default.map(|number| number.to_string()).join(", ")),
                Type::Texture => image_name(parameter.default[0]).unwrap_or_else(|| "white".to_owned()),
                Type::Scalar | Type::Truth => parameter.default[0].to_string(),
            };
            text.push_str(&format!("\nDouble-click: the default of the formula, {default}. Right-click: more."));
        }
    }
    text
}
