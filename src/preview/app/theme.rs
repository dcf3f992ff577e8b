//! Colours, fonts and spacing, in a dark and a light theme.

use crate::user_data::settings::ThemeSetting;
use egui::style::{HandleShape, ScrollStyle};
use egui::{
    Color32, Context, CornerRadius, FontDefinitions, FontFamily, FontId, Margin, Response, RichText, Stroke, TextStyle, Ui,
    Visuals, vec2,
};

/// A theme.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Theme {
    /// Light text on a dark background, which does not outshine the picture.
    #[default]
    Dark,
    /// Dark text on a light background.
    Light,
}

impl Theme {
    /// The theme of the settings. `desktop` is whether the desktop is dark, if it says so.
    pub(super) fn from_setting(setting: ThemeSetting, desktop: Option<bool>) -> Self {
        if setting.is_dark(desktop) { Theme::Dark } else { Theme::Light }
    }

    /// The colour of the pane around a picture that does not fill it, `0x00RRGGBB`. It is a grey without a hue, so it
    /// does not change how the colours of the picture look.
    pub(super) fn pane_background(dark: bool) -> u32 {
        if dark { 0x002d_2d2d } else { 0x00b4_b4b4 }
    }
}

/// The name of a setting in menus.
pub(super) fn setting_name(setting: ThemeSetting) -> &'static str {
    match setting {
        ThemeSetting::System => "As the desktop",
        ThemeSetting::Dark => "Dark",
        ThemeSetting::Light => "Light",
    }
}

/// The height of a row of widgets, in points.
pub(super) const ROW_HEIGHT: f32 = 22.0;

/// The greys and the accents of a theme. The greys of panels have no hue either.
struct Shades {
    panel: Color32,
    window: Color32,
    /// The background of texts.
    field: Color32,
    /// The background of widgets at rest, under the pointer, and pressed.
    widget: [Color32; 3],
    /// The lines between panels.
    line: Color32,
    text: Color32,
    strong: Color32,
    /// How strong secondary text is, 0..1.
    weak: f32,
    /// The background of what is selected, and the filled part of sliders.
    accent: Color32,
    /// The text on the accent.
    on_accent: Color32,
    warning: Color32,
    error: Color32,
}

const DARK: Shades = Shades {
    panel: Color32::from_gray(34),
    window: Color32::from_gray(40),
    field: Color32::from_gray(23),
    widget: [Color32::from_gray(60), Color32::from_gray(76), Color32::from_gray(90)],
    line: Color32::from_gray(56),
    text: Color32::from_gray(214),
    strong: Color32::from_gray(246),
    weak: 0.68,
    accent: Color32::from_rgb(122, 172, 238),
    on_accent: Color32::from_rgb(14, 18, 26),
    warning: Color32::from_rgb(238, 186, 84),
    error: Color32::from_rgb(255, 122, 116),
};

const LIGHT: Shades = Shades {
    panel: Color32::from_gray(240),
    window: Color32::from_gray(248),
    field: Color32::from_gray(255),
    widget: [Color32::from_gray(220), Color32::from_gray(206), Color32::from_gray(192)],
    line: Color32::from_gray(206),
    text: Color32::from_gray(38),
    strong: Color32::from_gray(8),
    weak: 0.74,
    accent: Color32::from_rgb(38, 100, 186),
    on_accent: Color32::WHITE,
    warning: Color32::from_rgb(146, 84, 0),
    error: Color32::from_rgb(188, 24, 24),
};

/// The colours of egui for a theme.
fn visuals(theme: Theme) -> Visuals {
    let (mut visuals, shades) = match theme {
        Theme::Dark => (Visuals::dark(), DARK),
        Theme::Light => (Visuals::light(), LIGHT),
    };
    visuals.panel_fill = shades.panel;
    visuals.window_fill = shades.window;
    visuals.window_stroke = Stroke::new(1.0, shades.line);
    visuals.extreme_bg_color = shades.field;
    visuals.faint_bg_color = shades.widget[0].gamma_multiply(0.4);
    visuals.weak_text_alpha = shades.weak;
    visuals.warn_fg_color = shades.warning;
    visuals.error_fg_color = shades.error;
    visuals.hyperlink_color = shades.accent;
    // The dialog for files also writes the name of the selected file in the colour of the selection.
    visuals.selection.bg_fill = shades.accent;
    visuals.selection.stroke = Stroke::new(1.0, shades.on_accent);
    visuals.slider_trailing_fill = true;
    visuals.handle_shape = HandleShape::Circle;
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.fg_stroke.color = shades.text;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, shades.line);
    for (widget, fill) in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active].into_iter().zip(shades.widget) {
        widget.bg_fill = fill;
        widget.weak_bg_fill = fill;
        widget.bg_stroke = Stroke::NONE;
        widget.expansion = 0.0;
        widget.corner_radius = CornerRadius::same(4);
    }
    widgets.open.weak_bg_fill = shades.widget[0];
    widgets.open.fg_stroke.color = shades.text;
    widgets.inactive.fg_stroke.color = shades.text;
    widgets.hovered.fg_stroke.color = shades.strong;
    widgets.active.fg_stroke.color = shades.strong;
    visuals
}

/// A button that stands out, in the accent of the theme.
pub(super) fn main_button<'a>(ui: &Ui, label: &'a str) -> egui::Button<'a> {
    let selection = ui.visuals().selection;
    egui::Button::new(RichText::new(label).color(selection.stroke.color)).fill(selection.bg_fill)
}

/// Applies the theme to a context.
pub(super) fn apply(context: &Context, theme: Theme) {
    context.set_theme(match theme {
        Theme::Dark => egui::Theme::Dark,
        Theme::Light => egui::Theme::Light,
    });
    // Arrows and other signs of messages are in the monospaced font alone.
    let mut fonts = FontDefinitions::default();
    let signs = fonts.families.get(&FontFamily::Monospace).cloned().unwrap_or_default();
    fonts.families.entry(FontFamily::Proportional).or_default().extend(signs);
    context.set_fonts(fonts);
    context.set_visuals_of(egui::Theme::Dark, visuals(Theme::Dark));
    context.set_visuals_of(egui::Theme::Light, visuals(Theme::Light));
    context.all_styles_mut(|style| {
        style.text_styles.insert(TextStyle::Body, FontId::proportional(14.0));
        style.text_styles.insert(TextStyle::Button, FontId::proportional(14.0));
        style.text_styles.insert(TextStyle::Monospace, FontId::monospace(13.0));
        style.text_styles.insert(TextStyle::Small, FontId::proportional(12.0));
        style.text_styles.insert(TextStyle::Heading, FontId::proportional(17.0));
        // Digits of one width.
        style.drag_value_text_style = TextStyle::Monospace;
        style.spacing.item_spacing = vec2(8.0, 5.0);
        style.spacing.button_padding = vec2(7.0, 2.0);
        style.spacing.interact_size = vec2(40.0, ROW_HEIGHT);
        style.spacing.slider_width = 130.0;
        style.spacing.slider_rail_height = 4.0;
        style.spacing.window_margin = Margin::same(10);
        style.spacing.menu_margin = Margin::same(8);
        // Bars that always show where a panel scrolls, with space of their own.
        style.spacing.scroll = ScrollStyle::thin();
        // No animations: each of their steps would be a frame to paint.
        style.animation_time = 0.0;
    });
}

/// Draws the title of a section.
pub(super) fn section(ui: &mut Ui, title: &str) -> Response {
    ui.label(RichText::new(title).small().strong())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The relative luminance of a colour by the guidelines for web content (WCAG 2), from its bytes.
    fn luminance(colour: Color32) -> f64 {
        assert_eq!(colour.a(), 255, "what is under a translucent colour would count");
        let linear = |byte: u8| {
            let stored = f64::from(byte) / 255.0;
            if stored <= 0.04045 { stored / 12.92 } else { ((stored + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(colour.r()) + 0.7152 * linear(colour.g()) + 0.0722 * linear(colour.b())
    }

    fn contrast(one: Color32, other: Color32) -> f64 {
        let [darker, lighter] = {
            let mut both = [luminance(one), luminance(other)];
            both.sort_by(f64::total_cmp);
            both
        };
        (lighter + 0.05) / (darker + 0.05)
    }

    #[test]
    fn contrast_is_that_of_the_guidelines() {
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-9);
        // From the table of an independent checker.
        assert!((contrast(Color32::from_gray(119), Color32::WHITE) - 4.48).abs() < 0.01);
        assert!((contrast(Color32::from_rgb(255, 0, 0), Color32::WHITE) - 4.0).abs() < 0.01);
    }

    #[test]
    fn every_text_is_legible_in_both_themes() {
        const LEAST: f64 = 4.5;
        for theme in [Theme::Dark, Theme::Light] {
            let visuals = visuals(theme);
            let check = |what: &str, text: Color32, behind: Color32| {
                let contrast = contrast(text, behind);
                assert!(contrast >= LEAST, "{theme:?}: {what} has a contrast of {contrast:.2}");
            };
            // Selected text, the selected file in a list, a selected tab or body.
            check("selected text", visuals.selection.stroke.color, visuals.selection.bg_fill);
            // The name of the selected file below the list.
            check("the name of the selected file", visuals.selection.bg_fill, visuals.window_fill);
            for behind in [visuals.panel_fill, visuals.window_fill, visuals.extreme_bg_color] {
                check("text", visuals.text_color(), behind);
                check("strong text", visuals.strong_text_color(), behind);
                check("a warning", visuals.warn_fg_color, behind);
                check("an error", visuals.error_fg_color, behind);
                let weak = visuals.text_color().lerp_to_gamma(behind, 1.0 - visuals.weak_text_alpha);
                check("weak text", weak, behind);
            }
            for widget in [&visuals.widgets.inactive, &visuals.widgets.hovered, &visuals.widgets.active, &visuals.widgets.open] {
                check("a button", widget.text_color(), widget.weak_bg_fill);
            }
        }
    }
}
