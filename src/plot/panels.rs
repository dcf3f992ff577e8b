//! Several pictures of one form on a sheet, each with its name.

use crate::plot::figure::Anchor;
use crate::plot::layout::{ChartArea, ChartSheet};
use crate::plot::typeface::shortened;

/// Where several pictures are.
pub(super) struct PanelPlaces {
    /// The area of each.
    pub(super) areas: Vec<ChartArea>,
    /// The width that each has for itself, with what is beside its area.
    pub(super) cell_width: f64,
}

/// Places for `count` pictures whose width is `aspect` times their height, as large as possible, in reading order. Each
/// keeps `margins` at the left, top, right and bottom for itself.
pub(super) fn arranged(area: &ChartArea, count: usize, aspect: f64, margins: [f64; 4]) -> PanelPlaces {
    let count = count.max(1);
    let cell = |columns: usize| {
        let rows = count.div_ceil(columns);
        let [left, top, right, bottom] = margins;
        let width = (area.width / columns as f64 - left - right).max(4.0);
        let height = (area.height / rows as f64 - top - bottom).max(4.0);
        (width.min(height * aspect), columns, rows)
    };
    let all = (1..=count).map(cell);
    let (width, columns, rows) = all.max_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((area.width, 1, 1));
    let height = width / aspect;
    let place = |index: usize| {
        let (column, row) = (index % columns, index / columns);
        let (wide, high) = (area.width / columns as f64, area.height / rows as f64);
        let [left, top, right, bottom] = margins;
        ChartArea {
            left: area.left + (column as f64) * wide + left + 0.5 * (wide - left - right - width),
            top: area.top + (row as f64) * high + top + 0.5 * (high - top - bottom - height),
            width,
            height,
        }
    };
    PanelPlaces { areas: (0..count).map(place).collect(), cell_width: area.width / columns as f64 }
}

/// Writes the name of a picture above its place, within the width of its cell.
pub(super) fn caption(sheet: &mut ChartSheet, place: &ChartArea, cell_width: f64, name: &str) {
    let style = (sheet.title_size(), sheet.theme.text());
    let name = shortened(name, style.0, (cell_width - sheet.label_size()).max(place.width));
    let at = [place.left + 0.5 * place.width, place.top - 0.6 * sheet.label_size()];
    sheet.figure.text(name, at, Anchor::Middle, style);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_are_as_large_as_possible() {
        let area = ChartArea { left: 0.0, top: 0.0, width: 400.0, height: 200.0 };
        let PanelPlaces { areas: two, cell_width } = arranged(&area, 2, 1.0, [0.0; 4]);
        assert_eq!(cell_width, 200.0);
        assert_eq!(two[0], ChartArea { left: 0.0, top: 0.0, width: 200.0, height: 200.0 });
        assert_eq!(two[1], ChartArea { left: 200.0, top: 0.0, width: 200.0, height: 200.0 });
        let five = arranged(&area, 5, 1.0, [0.0, 20.0, 0.0, 0.0]).areas;
        assert!(five.len() == 5 && five.iter().all(|place| place.right() <= 400.0 && place.bottom() <= 200.0));
    }
}
