//! The list of keys: all groups, in as many columns as fit.

use crate::preview::app::action::shortcuts;
use crate::preview::app::key_groups::{KeyGroup, OTHER_KEYS};
use crate::preview::app::modal::modal;
use crate::preview::app::scene_actions::scene_shortcuts;
use egui::{Align, Context, Grid, Label, Layout, RichText, ScrollArea, Ui, vec2};

/// The width of a column, and of the keys in it, in points.
const COLUMN: f32 = 430.0;
const KEYS: f32 = 150.0;
/// The space between two columns.
const GAP: f32 = 24.0;
/// What the dialog needs beside the list: margins, a scroll bar, the title and the button.
const EXTRA: egui::Vec2 = vec2(90.0, 150.0);

/// A group with its lines: keys, and what they do.
type GroupLines = (KeyGroup, Vec<(String, &'static str)>);

/// All groups.
fn groups(context: &Context) -> Vec<GroupLines> {
    let lines = |group: KeyGroup| {
        let own = shortcuts().into_iter().map(|one| (one.group, one.keys, one.about));
        let of_scene = scene_shortcuts().into_iter().map(|one| (one.group, one.keys, one.about));
        let keys = own.chain(of_scene).map(|(of, keys, about)| (of, context.format_shortcut(&keys), about));
        let all = keys.chain(OTHER_KEYS.map(|(of, keys, about)| (of, keys.to_owned(), about)));
        all.filter(|(of, ..)| *of == group).map(|(_, keys, about)| (keys, about)).collect()
    };
    KeyGroup::ALL.map(|group| (group, lines(group))).into()
}

/// Where the columns end: groups stay in order, and the columns are about as long as each other.
fn column_ends(lengths: &[usize], columns: usize) -> Vec<usize> {
    let total: usize = lengths.iter().sum();
    let mut ends = Vec::new();
    let mut length = 0;
    for (index, own) in lengths.iter().enumerate() {
        // A group belongs to the column in which its middle is.
        let due = (ends.len() + 1) * total;
        if ends.len() + 1 < columns && columns * (2 * length + own) > 2 * due {
            ends.push(index);
        }
        length += own;
    }
    ends.push(lengths.len());
    ends
}

/// Draws the list as a dialog. Returns whether it was closed.
pub(super) fn key_list_ui(context: &Context) -> bool {
    let room = context.content_rect().size() - EXTRA;
    let columns = ((room.x + GAP) / (COLUMN + GAP)).floor().clamp(1.0, 3.0);
    let width = COLUMN.min(room.x);
    let all = groups(context);
    // A heading takes about as much as two lines.
    let lengths: Vec<usize> = all.iter().map(|(_, lines)| lines.len() + 2).collect();
    let modal = modal(context, "Keys and mouse", |ui| {
        ui.set_width(columns * (width + GAP));
        let height = room.y.max(60.0);
        ScrollArea::vertical().max_height(height).min_scrolled_height(height).auto_shrink([false, true]).show(ui, |ui| {
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = GAP;
                let mut start = 0;
                for end in column_ends(&lengths, columns as usize) {
                    ui.allocate_ui_with_layout(vec2(width, 0.0), Layout::top_down(Align::LEFT), |ui| {
                        ui.set_width(width);
                        all[start..end].iter().for_each(|group| group_ui(ui, group, width));
                    });
                    start = end;
                }
            });
        });
        ui.add_space(8.0);
        ui.button("Close").clicked()
    });
    modal.inner || modal.should_close()
}

/// Draws a group.
fn group_ui(ui: &mut Ui, (group, lines): &GroupLines, width: f32) {
    ui.label(RichText::new(group.title()).strong().size(15.0));
    ui.spacing_mut().interact_size.y = 17.0;
    Grid::new(group.title()).num_columns(2).min_col_width(KEYS).spacing([12.0, 3.0]).show(ui, |ui| {
        for (keys, about) in lines {
            ui.monospace(keys);
            ui.scope(|ui| {
                ui.set_width(width - KEYS - 12.0);
                ui.add(Label::new(*about).wrap());
            });
            ui.end_row();
        }
    });
    ui.add_space(12.0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_in_one_group_and_columns_are_balanced() {
        let context = Context::default();
        let all = groups(&context);
        let lines: usize = all.iter().map(|(_, lines)| lines.len()).sum();
        assert_eq!(lines, shortcuts().len() + scene_shortcuts().len() + OTHER_KEYS.len());
        assert!(all.iter().all(|(_, lines)| !lines.is_empty()));
        assert_eq!(column_ends(&[5, 5, 5, 5], 2), [2, 4]);
        assert_eq!(column_ends(&[5, 5, 20], 2), [2, 3]);
        assert_eq!(column_ends(&[1, 2, 3], 1), [3]);
        assert_eq!(column_ends(&[4, 4, 4], 3), [1, 2, 3]);
    }
}
