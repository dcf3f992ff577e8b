//! The reference of the formula language: everything that a formula can name, to search and insert.

use super::palette::Palette;
use crate::lang::keywords::{self, Keyword};
use crate::lang::reference::{Row, Table, tables};
use crate::lang::types::Origin;
use egui::{CollapsingHeader, RichText, ScrollArea, TextEdit, Ui};

/// Draws the reference. `query` has words that must all occur. Returns the text to insert if a name was clicked.
pub fn reference_ui(ui: &mut Ui, query: &mut String) -> Option<String> {
    let palette = Palette::suiting(ui.visuals());
    let mut chosen = None;
    ui.horizontal(|ui| {
        let label = ui.label("Search");
        ui.add(TextEdit::singleline(query).desired_width(f32::INFINITY).hint_text("name, type or meaning")).labelled_by(label.id);
    });
    let sought: Vec<String> = query.split_whitespace().map(str::to_lowercase).collect();
    let mut nothing = true;
    ScrollArea::vertical().id_salt("reference").auto_shrink([false, false]).show(ui, |ui| {
        for table in all_tables() {
            let rows: Vec<&Row> = table.rows.iter().filter(|row| fits(row, &table.title, &sought)).collect();
            if rows.is_empty() {
                continue;
            }
            nothing = false;
            let header = CollapsingHeader::new(&table.title).default_open(true);
            // Search results are shown even if their table was collapsed.
            header.open((!sought.is_empty()).then_some(true)).show(ui, |ui| {
                for row in rows {
                    if row_ui(ui, row, &palette) {
                        chosen = Some(insertion(row));
                    }
                }
            });
        }
        if nothing {
            ui.weak("No match.");
        }
    });
    chosen
}

/// The tables of the language; the words of formula files come first.
fn all_tables() -> Vec<Table> {
    let row = |keyword: &Keyword, ending: &str| Row {
        name: keyword.word,
        form: format!("{}{ending}", keyword.word),
        types: String::new(),
        origin: Origin::Thesis,
        doc: keyword.doc.to_owned(),
    };
    let table = |title: &str, keywords: &[Keyword], ending: &str| Table {
        title: title.to_owned(),
        rows: keywords.iter().map(|keyword| row(keyword, ending)).collect(),
    };
    let mut all = vec![
        table("Sections of a formula file", &keywords::FORMULA_SECTIONS, ";"),
        table("Types of parameters", &keywords::TYPES, ""),
        table("Attributes of parameters", &keywords::PARAMETER_ATTRIBUTES, ""),
    ];
    all.extend(tables());
    all
}

/// Whether all searched words occur in a row or in the title of its table.
fn fits(row: &Row, title: &str, sought: &[String]) -> bool {
    let whole = format!("{} {} {} {title}", row.form, row.types, row.doc).to_lowercase();
    sought.iter().all(|word| whole.contains(word))
}

/// The text that a row inserts: the name, with what must follow it.
fn insertion(row: &Row) -> String {
    let rest = row.form.strip_prefix(row.name).unwrap_or("");
    match rest.chars().next() {
        Some('(') => format!("{}(", row.name),
        Some(';') => row.form.clone(),
        _ => row.name.to_owned(),
    }
}

/// Draws a row. Returns whether its name was clicked.
fn row_ui(ui: &mut Ui, row: &Row, palette: &Palette) -> bool {
    let response = ui.horizontal_wrapped(|ui| {
        let name = RichText::new(&row.form).monospace().color(palette.function);
        let clicked = ui.link(name).on_hover_text("Click to insert").clicked();
        if !row.types.is_empty() {
            ui.label(RichText::new(&row.types).monospace().color(palette.plain));
        }
        ui.label(&row.doc);
        if row.origin == Origin::Added {
            ui.label(RichText::new("[+]").small().color(palette.comment))
                .on_hover_text("A formula may give this name another meaning");
        }
        clicked
    });
    response.inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_by_all_their_words() {
        let found = |query: &str| -> Vec<&'static str> {
            let sought: Vec<String> = query.split_whitespace().map(str::to_lowercase).collect();
            let tables = all_tables();
            tables
                .iter()
                .flat_map(|table| table.rows.iter().filter(|row| fits(row, &table.title, &sought)).map(|row| row.name))
                .collect()
        };
        assert_eq!(found("CROSS product"), ["cross"]);
        assert_eq!(found("light body_specific"), [""; 0]);
        assert!(found("angle").contains(&"alpha"));
        assert!(found("").len() > 60);
    }

    #[test]
    fn what_is_inserted_can_be_gone_on_with() {
        let inserted =
            |name: &str| all_tables().iter().flat_map(|table| &table.rows).find(|row| row.name == name).map(insertion).unwrap();
        for (name, expected) in [("max", "max("), ("pi", "pi"), ("N", "N"), ("formula", "formula;"), ("if", "if("), ("^", "^")] {
            assert_eq!(inserted(name), expected);
        }
    }
}
