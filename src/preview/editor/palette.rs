//! The colours of the editor, in a dark and a light theme.

use crate::assist::words::Class;
use egui::Color32;

/// The colours of the editor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Palette {
    /// The background.
    pub background: Color32,
    /// The background of the line of the cursor.
    pub line: Color32,
    /// Line numbers.
    pub number_of_line: Color32,
    /// Plain text.
    pub plain: Color32,
    /// Keywords.
    pub keyword: Color32,
    /// Functions and constants.
    pub function: Color32,
    /// Variables of a hit.
    pub variable: Color32,
    /// Predefined parameters.
    pub predefined: Color32,
    /// Parameters that the text declares.
    pub parameter: Color32,
    /// Macros, bodies and lights.
    pub named: Color32,
    /// Numbers.
    pub number: Color32,
    /// Comments.
    pub comment: Color32,
    /// `#uses`.
    pub uses: Color32,
    /// Marks of errors, and characters that are no word.
    pub error: Color32,
    /// Marks of warnings.
    pub warning: Color32,
    /// The frame of matching parentheses.
    pub bracket: Color32,
    /// The background of matches.
    pub found: Color32,
    /// The background of the selected completion.
    pub found_here: Color32,
}

impl Palette {
    /// The dark theme.
    pub const DARK: Palette = Palette {
        background: Color32::from_rgb(24, 25, 28),
        line: Color32::from_rgb(36, 38, 43),
        number_of_line: Color32::from_rgb(112, 116, 126),
        plain: Color32::from_rgb(214, 216, 222),
        keyword: Color32::from_rgb(204, 132, 220),
        function: Color32::from_rgb(110, 176, 245),
        variable: Color32::from_rgb(96, 204, 196),
        predefined: Color32::from_rgb(232, 178, 104),
        parameter: Color32::from_rgb(240, 140, 120),
        named: Color32::from_rgb(226, 214, 150),
        number: Color32::from_rgb(160, 206, 130),
        comment: Color32::from_rgb(128, 136, 146),
        uses: Color32::from_rgb(190, 150, 130),
        error: Color32::from_rgb(248, 84, 84),
        warning: Color32::from_rgb(232, 184, 60),
        bracket: Color32::from_rgb(130, 138, 150),
        found: Color32::from_rgb(84, 74, 30),
        found_here: Color32::from_rgb(142, 112, 20),
    };

    /// The light theme.
    pub const LIGHT: Palette = Palette {
        background: Color32::from_rgb(252, 252, 250),
        line: Color32::from_rgb(238, 240, 244),
        number_of_line: Color32::from_rgb(138, 142, 150),
        plain: Color32::from_rgb(40, 42, 48),
        keyword: Color32::from_rgb(138, 44, 160),
        function: Color32::from_rgb(20, 92, 190),
        variable: Color32::from_rgb(0, 118, 112),
        predefined: Color32::from_rgb(158, 92, 0),
        parameter: Color32::from_rgb(184, 52, 34),
        named: Color32::from_rgb(112, 92, 0),
        number: Color32::from_rgb(46, 118, 20),
        comment: Color32::from_rgb(110, 116, 124),
        uses: Color32::from_rgb(126, 84, 62),
        error: Color32::from_rgb(206, 26, 26),
        warning: Color32::from_rgb(176, 122, 0),
        bracket: Color32::from_rgb(120, 126, 136),
        found: Color32::from_rgb(255, 240, 170),
        found_here: Color32::from_rgb(255, 206, 84),
    };

    /// The colours for the theme of egui.
    pub fn suiting(visuals: &egui::Visuals) -> Palette {
        if visuals.dark_mode { Palette::DARK } else { Palette::LIGHT }
    }

    /// The colour of a class.
    pub fn of(&self, class: Class) -> Color32 {
        match class {
            Class::Plain => self.plain,
            Class::Keyword => self.keyword,
            Class::Function => self.function,
            Class::Variable => self.variable,
            Class::Predefined => self.predefined,
            Class::Parameter => self.parameter,
            Class::Named => self.named,
            Class::Number => self.number,
            Class::Comment => self.comment,
            Class::Uses => self.uses,
            Class::Unknown => self.error,
        }
    }
}
