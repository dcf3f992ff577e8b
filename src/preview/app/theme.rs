//! Colours, fonts and spacing, in a dark and a light theme.

use egui::{Color32, Context, CornerRadius, FontId, Stroke, TextStyle, Visuals};

/// A theme.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Theme {
    /// Light text on a dark background, which does not outshine the picture.
    #[default]
    Dark,
    /// Dark text on a light background.
    Light,
}

impl Theme {
    /// The theme of the settings.
    pub(super) fn from_setting(theme: crate::user_data::settings::ThemeSetting) -> Self {
        if theme.is_dark(None) { Theme::Dark } else { Theme::Light }
    }

    /// The theme for the settings.
    pub(super) fn setting(self) -> crate::user_data::settings::ThemeSetting {
        match self {
            Theme::Dark => crate::user_data::settings::ThemeSetting::Dark,
            Theme::Light => crate::user_data::settings::ThemeSetting::Light,
        }
    }

    /// The name in the menu.
    pub(super) fn name(self) -> &'static str {
        match self {
            Theme::Dark => "Dark",
            Theme::Light => "Light",
        }
    }

    /// The colour of the pane around a picture that does not fill it, `0x00RRGGBB`.
    pub(super) fn pane_background(dark: bool) -> u32 {
        if dark { 0x0013_1417 } else { 0x00b9_bcc2 }
    }
}

/// The colour of selected and active widgets.
const ACCENT: Color32 = Color32::from_rgb(84, 148, 232);

/// Applies the theme to a context.
pub(super) fn apply(context: &Context, theme: Theme) {
    context.set_theme(match theme {
        Theme::Dark => egui::Theme::Dark,
        Theme::Light => egui::Theme::Light,
    });
    let mut dark = Visuals::dark();
    dark.panel_fill = Color32::from_rgb(30, 32, 36);
    dark.window_fill = Color32::from_rgb(36, 38, 43);
    dark.extreme_bg_color = Color32::from_rgb(21, 22, 25);
    dark.faint_bg_color = Color32::from_rgb(38, 40, 45);
    dark.override_text_color = Some(Color32::from_rgb(214, 217, 222));
    let mut light = Visuals::light();
    light.panel_fill = Color32::from_rgb(240, 241, 243);
    light.window_fill = Color32::from_rgb(250, 250, 251);
    light.extreme_bg_color = Color32::WHITE;
    light.override_text_color = Some(Color32::from_rgb(32, 34, 38));
    for (theme, mut visuals) in [(egui::Theme::Dark, dark), (egui::Theme::Light, light)] {
        visuals.selection.bg_fill = ACCENT.gamma_multiply(0.55);
        visuals.selection.stroke = Stroke::new(1.0, ACCENT);
        visuals.slider_trailing_fill = true;
        for widget in [&mut visuals.widgets.inactive, &mut visuals.widgets.hovered, &mut visuals.widgets.active] {
            widget.corner_radius = CornerRadius::same(4);
        }
        context.set_visuals_of(theme, visuals);
    }
    context.all_styles_mut(|style| {
        style.text_styles.insert(TextStyle::Body, FontId::proportional(13.5));
        style.text_styles.insert(TextStyle::Button, FontId::proportional(13.5));
        style.text_styles.insert(TextStyle::Monospace, FontId::monospace(13.0));
        style.text_styles.insert(TextStyle::Small, FontId::proportional(11.5));
        style.text_styles.insert(TextStyle::Heading, FontId::proportional(16.0));
        style.spacing.item_spacing = egui::vec2(8.0, 5.0);
        style.spacing.slider_width = 130.0;
        // No animations: each of their steps would be a frame to paint.
        style.animation_time = 0.0;
    });
}
