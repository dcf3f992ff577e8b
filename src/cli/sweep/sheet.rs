//! The contact sheet: where pictures and labels are, and how they are drawn.
//!
//! One parameter gives rows of pictures with a label under each. Two give a table: the first one changes from row to
//! row, the second one from column to column. A title says which formula and scene the pictures show.

use crate::cli::report::Failure;
use crate::cli::sweep::cells::SweptParameter;
use crate::cli::sweep::lettering::Lettering;
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::picture::Bitmap;

/// A sheet has at most this many pixels in a row and in a column. Many viewers show no larger pictures.
const MOST_SIDE: u64 = 16_384;

/// The colours of paper, of names and values, and of the second line of the title.
const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [34, 34, 34];
const FAINT_INK: [u8; 3] = [110, 110, 110];

/// The height of a line of labels is the height of a picture divided by this, within the limits.
const LINES_PER_PICTURE: u32 = 22;
const LINE_LIMITS: [u32; 2] = [15, 40];

/// Pictures of one parameter are arranged so that the sheet is about this wide for its height.
const ASPECT: f64 = 1.6;
/// A single row may have this many pictures.
const SHORT_ROW: u32 = 4;

/// Where everything is on a sheet, in pixels from the top left corner.
pub(super) struct Sheet {
    /// Width and height.
    size: [u32; 2],
    /// The top left corner of each picture.
    corners: Vec<[u32; 2]>,
    lines: Vec<LabelLine>,
    lettering: Lettering,
    title_lettering: Lettering,
}

/// A line of text with its top left corner.
struct LabelLine {
    at: [u32; 2],
    text: String,
    kind: LineKind,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum LineKind {
    Title,
    Subtitle,
    Label,
}

/// The pictures, their labels, and the room that they take, before the title is put above them. Pixels are counted
/// from the top left corner of this part.
struct PictureGrid {
    size: [u64; 2],
    corners: Vec<[u64; 2]>,
    labels: Vec<([u64; 2], String)>,
    /// What is varied, if labels have no room for names.
    subtitle: Option<String>,
}

impl Sheet {
    /// The sheet for pictures of this size.
    ///
    /// `columns` is the number of pictures in a row if one parameter is varied.
    ///
    /// # Errors
    /// The sheet would be too large.
    pub(super) fn new(
        title: &str,
        parameters: &[SweptParameter],
        picture: [u32; 2],
        columns: Option<u32>,
    ) -> Result<Self, Failure> {
        let [low, high] = LINE_LIMITS;
        let line = (picture[1] / LINES_PER_PICTURE).clamp(low, high);
        let (lettering, title_lettering) = (Lettering::new(line)?, Lettering::new(line + line / 4)?);
        let space = Spacing { picture: picture.map(u64::from), line: lettering.height().into(), gap: u64::from(line) / 2 + 2 };
        let body = match parameters {
            [rows, columns] => space.table(rows, columns, &lettering),
            [one, ..] => space.rows(one, columns, &lettering),
            [] => return Err(Failure::command_line("a sheet needs a parameter that is varied")),
        };
        let margin = u64::from(line);
        // A title may make a narrow sheet wider, up to a limit.
        let widest = body.size[0].max(24 * u64::from(line));
        let mut title_lines = vec![(title_lettering.shortened(title, widest as u32), LineKind::Title)];
        title_lines.extend(body.subtitle.map(|text| (lettering.shortened(&text, widest as u32), LineKind::Subtitle)));
        let mut lines = Vec::new();
        let (mut y, mut width) = (margin, body.size[0]);
        for (text, kind) in title_lines {
            let lettering = if kind == LineKind::Title { &title_lettering } else { &lettering };
            width = width.max(lettering.width(&text).into());
            lines.push(LabelLine { at: [margin as u32, y as u32], text, kind });
            y += u64::from(lettering.height());
        }
        let top = y + space.gap;
        let size = [width + 2 * margin, top + body.size[1] + margin];
        if size.iter().any(|side| *side > MOST_SIDE) {
            return Err(too_large(size, picture));
        }
        // Everything is within the size.
        let place = |[x, y]: [u64; 2]| [(margin + x) as u32, (top + y) as u32];
        let labels = body.labels.into_iter();
        lines.extend(labels.map(|(at, text)| LabelLine { at: place(at), text, kind: LineKind::Label }));
        let corners = body.corners.into_iter().map(place).collect();
        Ok(Self { size: size.map(|side| side as u32), corners, lines, lettering, title_lettering })
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The top left corner of a picture.
    pub(super) fn corner(&self, index: usize) -> [u32; 2] {
        self.corners[index]
    }

    /// The sheet with all text and without pictures.
    pub(super) fn draw(&self) -> Bitmap {
        let mut bitmap = Bitmap::filled(self.size[0], self.size[1], PAPER);
        for LabelLine { at, text, kind } in &self.lines {
            let (lettering, colour) = match kind {
                LineKind::Title => (&self.title_lettering, INK),
                LineKind::Subtitle => (&self.lettering, FAINT_INK),
                LineKind::Label => (&self.lettering, INK),
            };
            lettering.draw(&mut bitmap, *at, text, colour);
        }
        bitmap
    }
}

/// What the parts of a sheet measure, in pixels.
struct Spacing {
    /// Width and height of a picture.
    picture: [u64; 2],
    /// The height of a line of labels.
    line: u64,
    /// Between two pictures.
    gap: u64,
}

impl Spacing {
    /// Rows of pictures with a label under each.
    fn rows(&self, parameter: &SweptParameter, columns: Option<u32>, lettering: &Lettering) -> PictureGrid {
        let [width, height] = self.picture;
        let (labels, has_names) = labels(parameter, width, lettering);
        let pitch = [width.max(widest(&labels, lettering)) + self.gap, height + self.gap / 2 + self.line + self.gap];
        let count = labels.len() as u64;
        let columns = columns.map_or_else(|| columns_for(count, pitch), u64::from).clamp(1, count.max(1));
        let mut corners = Vec::new();
        let mut placed = Vec::new();
        for (index, text) in (0..).zip(labels) {
            let middle = index % columns * pitch[0] + (pitch[0] - self.gap) / 2;
            let top = index / columns * pitch[1];
            corners.push([middle - width / 2, top]);
            let half = u64::from(lettering.width(&text)) / 2;
            placed.push(([middle - half.min(middle), top + height + self.gap / 2], text));
        }
        let size = [columns * pitch[0] - self.gap, count.div_ceil(columns) * pitch[1] - self.gap];
        PictureGrid { size, corners, labels: placed, subtitle: (!has_names).then(|| parameter.name.clone()) }
    }

    /// A table with a label over each column and one in front of each row.
    fn table(&self, rows: &SweptParameter, columns: &SweptParameter, lettering: &Lettering) -> PictureGrid {
        let [width, height] = self.picture;
        let (row_labels, rows_have_names) = labels(rows, width, lettering);
        let (column_labels, columns_have_names) = labels(columns, width, lettering);
        let left = widest(&row_labels, lettering) + self.gap;
        let top = self.line + self.gap / 2;
        let pitch = [width.max(widest(&column_labels, lettering)) + self.gap, height.max(self.line) + self.gap];
        let middle = |column: u64| left + column * pitch[0] + (pitch[0] - self.gap) / 2;
        let mut placed = Vec::new();
        for (column, text) in (0..).zip(&column_labels) {
            let half = u64::from(lettering.width(text)) / 2;
            placed.push(([middle(column) - half, 0], text.clone()));
        }
        let mut corners = Vec::new();
        for (row, text) in (0..).zip(&row_labels) {
            let centre = top + row * pitch[1] + (pitch[1] - self.gap) / 2;
            let end = left - self.gap;
            placed.push(([end - u64::from(lettering.width(text)).min(end), centre - self.line / 2], text.clone()));
            corners.extend((0..column_labels.len() as u64).map(|column| [middle(column) - width / 2, centre - height / 2]));
        }
        let size = [left + column_labels.len() as u64 * pitch[0] - self.gap, top + row_labels.len() as u64 * pitch[1] - self.gap];
        let subtitle = format!("rows: {}, columns: {}", rows.name, columns.name);
        let has_names = rows_have_names && columns_have_names;
        PictureGrid { size, corners, labels: placed, subtitle: (!has_names).then_some(subtitle) }
    }
}

/// The labels of a parameter's steps: name and value, or the value alone if not all of them fit into this width. The
/// flag says whether there are names.
fn labels(parameter: &SweptParameter, width: u64, lettering: &Lettering) -> (Vec<String>, bool) {
    let values = parameter.texts();
    let named: Vec<String> = values.iter().map(|value| format!("{} = {value}", parameter.name)).collect();
    if widest(&named, lettering) <= width { (named, true) } else { (values, false) }
}

fn widest(texts: &[String], lettering: &Lettering) -> u64 {
    texts.iter().map(|text| u64::from(lettering.width(text))).max().unwrap_or(0)
}

/// The number of columns for pictures that take this much room each.
fn columns_for(count: u64, [width, height]: [u64; 2]) -> u64 {
    if count <= u64::from(SHORT_ROW) {
        return count;
    }
    // How far the sheet is from the wanted form, and how much of it is empty.
    let cost = |columns: u64| {
        let rows = count.div_ceil(columns);
        let aspect = (columns * width) as f64 / (rows * height) as f64;
        (aspect / ASPECT).ln().abs() + (columns * rows - count) as f64 / count as f64
    };
    (1..=count).min_by(|one, other| cost(*one).total_cmp(&cost(*other))).unwrap_or(count)
}

fn too_large([width, height]: [u64; 2], picture: [u32; 2]) -> Failure {
    let message = format!("the contact sheet would be {width}×{height} pixels; each side can have {MOST_SIDE}");
    let share = (MOST_SIDE as f64 / width.max(height) as f64).min(1.0);
    // Labels and gaps become smaller too, but not in proportion.
    let [width, height] = picture.map(|side| (0.9 * share * f64::from(side)) as u32);
    let error = Diagnostic::error(message);
    let numbered = "write numbered pictures, as in `-o pictures/%04d.png`";
    Failure::Input(if width.min(height) >= 16 {
        error.help(format!("make the pictures smaller, as with `--size {width}x{height}`, or {numbered}"))
    } else {
        error.help(format!("give fewer values, or {numbered}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(name: &str, count: u32) -> SweptParameter {
        let values = (0..count).map(|step| vec![step as f32 / 8.0]).collect();
        SweptParameter { name: name.to_owned(), values, choices: Vec::new() }
    }

    fn sheet(parameters: &[SweptParameter], picture: [u32; 2]) -> Sheet {
        Sheet::new("formula on scene", parameters, picture, None).unwrap_or_else(|_| panic!("a sheet"))
    }

    /// The boxes of everything on a sheet: corner and size.
    fn boxes(sheet: &Sheet, picture: [u32; 2]) -> Vec<[u32; 4]> {
        let pictures = sheet.corners.iter().map(|[x, y]| [*x, *y, picture[0], picture[1]]);
        let lines = sheet.lines.iter().map(|LabelLine { at: [x, y], text, kind }| {
            let lettering = if *kind == LineKind::Title { &sheet.title_lettering } else { &sheet.lettering };
            [*x, *y, lettering.width(text), lettering.height()]
        });
        pictures.chain(lines).collect()
    }

    #[test]
    fn nothing_overlaps_and_nothing_is_outside() {
        for picture in [[640, 480], [160, 120], [32, 24], [1, 1], [24, 400], [1600, 200]] {
            for counts in [vec![1], vec![3], vec![5], vec![17], vec![1, 1], vec![3, 4], vec![1, 9], vec![6, 2]] {
                let parameters: Vec<_> = counts.iter().map(|count| parameter("ball.shininess", *count)).collect();
                let sheet = sheet(&parameters, picture);
                let boxes = boxes(&sheet, picture);
                assert_eq!(sheet.corners.len() as u32, counts.iter().product::<u32>(), "{picture:?} {counts:?}");
                for (index, [x, y, width, height]) in boxes.iter().enumerate() {
                    assert!(x + width <= sheet.size[0] && y + height <= sheet.size[1], "{picture:?} {counts:?}");
                    for [other_x, other_y, other_width, other_height] in &boxes[..index] {
                        let apart = x + width <= *other_x
                            || other_x + other_width <= *x
                            || y + height <= *other_y
                            || other_y + other_height <= *y;
                        assert!(apart, "{picture:?} {counts:?}: {:?}", boxes[index]);
                    }
                }
            }
        }
    }

    #[test]
    fn names_are_on_the_sheet_once_or_in_every_label() {
        let texts = |sheet: &Sheet| sheet.lines.iter().map(|line| line.text.clone()).collect::<Vec<_>>();
        let wide = texts(&sheet(&[parameter("ball.kd", 2)], [320, 240]));
        assert_eq!(wide, ["formula on scene", "ball.kd = 0.000", "ball.kd = 0.125"]);
        let narrow = texts(&sheet(&[parameter("ball.kd", 2)], [32, 24]));
        assert_eq!(narrow, ["formula on scene", "ball.kd", "0.000", "0.125"]);
        let table = texts(&sheet(&[parameter("a.kd", 2), parameter("ball.shininess", 1)], [100, 75]));
        assert_eq!(table, ["formula on scene", "rows: a.kd, columns: ball.shininess", "0", "a.kd = 0.000", "a.kd = 0.125"]);
    }

    #[test]
    fn pictures_of_one_parameter_fill_a_sheet_of_usual_form() {
        let columns = |count| columns_for(count, [648, 510]);
        assert_eq!([1, 2, 4].map(columns), [1, 2, 4]);
        assert_eq!([6, 9, 12, 25].map(columns), [3, 3, 4, 5]);
        assert_eq!(columns_for(12, [60, 400]), 12);
        let given = Sheet::new("t", &[parameter("kd", 5)], [100, 75], Some(1)).unwrap_or_else(|_| panic!("a sheet"));
        assert!(given.corners.iter().all(|corner| corner[0] == given.corners[0][0]));
    }

    #[test]
    fn sheets_that_are_too_large_are_refused_with_a_size_that_fits() {
        let parameters = || [parameter("a.b", 30), parameter("c.d", 30)];
        let Err(Failure::Input(error)) = Sheet::new("t", &parameters(), [640, 480], None) else { panic!("no error") };
        assert!(error.message().ends_with("each side can have 16384"), "{}", error.message());
        let hint = error.hints()[0].clone();
        let size = hint.split("--size ").nth(1).and_then(|rest| rest.split('`').next()).expect("a size");
        let (width, height) = size.split_once('x').expect("two numbers");
        let size = [width, height].map(|side| side.parse().expect("a number"));
        assert!(size[0] > 400, "{hint}");
        assert!(Sheet::new("t", &parameters(), size, None).is_ok(), "{hint}");
    }
}
