//! The picture below the widgets: where it is in the window, and how its part of a tile is drawn.

use crate::preview::PictureView;
use crate::preview::paint::pixel_rect::PixelRect;
use crate::preview::paint::raster::Canvas;
use crate::preview::resampling::{Axis, RowSum};
use std::hash::Hasher;

/// The picture and its position in the window.
pub(super) struct PlacedPicture<'a> {
    view: PictureView<'a>,
    /// The part of the pane that is in the window.
    pub(super) area: PixelRect,
    /// The part of it that the picture covers.
    covered: PixelRect,
    /// The position of the upper left corner of the picture.
    corner: [i64; 2],
    scaling: Scaling,
}

/// Rows of the scaled picture, over its whole width, for the tiles of one band. A row is scaled when the first tile
/// needs it. Tile by tile, parts of rows would be read, which takes longer.
#[derive(Default)]
pub(super) struct ScaledRows {
    rows: Vec<(i32, Vec<u32>)>,
    sum: RowSum,
}

impl ScaledRows {
    /// The row `y` of the screen, which `scale` makes.
    fn row(&mut self, y: i32, scale: impl FnOnce(&mut RowSum) -> Vec<u32>) -> &[u32] {
        let index = match self.rows.binary_search_by_key(&y, |(row, _)| *row) {
            Ok(index) => index,
            Err(index) => {
                let pixels = scale(&mut self.sum);
                self.rows.insert(index, (y, pixels));
                index
            }
        };
        &self.rows[index].1
    }
}

/// How pixels of the picture become those of the screen.
enum Scaling {
    /// Each is a square of this many pixels.
    Whole(usize),
    /// By area. The axes are those of `covered`, from left to right and from top to bottom.
    Area([Axis; 2]),
}

impl<'a> PlacedPicture<'a> {
    /// `None` if no part of the pane is visible, or there are too few pixels.
    pub(super) fn new(view: &PictureView<'a>, scale: f32, bounds: PixelRect) -> Option<Self> {
        let pane = PixelRect::of(view.pane, scale);
        let area = pane.intersection(bounds);
        let enough = view.width.checked_mul(view.height).is_some_and(|count| count <= view.pixels.len());
        if !enough || area.is_empty() {
            return None;
        }
        let corner = [i64::from(pane.left) + i64::from(view.offset[0]), i64::from(pane.top) + i64::from(view.offset[1])];
        let has_pixels = view.width > 0 && view.height > 0;
        let [shown_width, shown_height] = if has_pixels { view.shown.map(|side| side as usize) } else { [0, 0] };
        let covered = {
            // Every part of `area` has coordinates that fit into 32 bits.
            let within = |at: i64, low: i32, high: i32| at.clamp(i64::from(low), i64::from(high)) as i32;
            let [right, bottom] = [corner[0] + shown_width as i64, corner[1] + shown_height as i64];
            PixelRect {
                left: within(corner[0], area.left, area.right),
                top: within(corner[1], area.top, area.bottom),
                right: within(right, area.left, area.right),
                bottom: within(bottom, area.top, area.bottom),
            }
        };
        let zoom = shown_width / view.width.max(1);
        let is_whole = zoom > 0 && [view.width * zoom, view.height * zoom] == [shown_width, shown_height];
        let scaling = if is_whole || covered.is_empty() {
            Scaling::Whole(zoom.max(1))
        } else {
            let seen = |from: i32, to: i32, corner: i64| (i64::from(from) - corner) as usize..(i64::from(to) - corner) as usize;
            Scaling::Area([
                Axis::new(view.width, shown_width, seen(covered.left, covered.right, corner[0])),
                Axis::new(view.height, shown_height, seen(covered.top, covered.bottom, corner[1])),
            ])
        };
        Some(Self { view: *view, area, covered, corner, scaling })
    }

    /// The hash of what it shows, over a ground with this hash.
    pub(super) fn hash(&self, ground: u64) -> u64 {
        super::hash(|hasher| {
            hasher.write_u64(ground);
            hasher.write_u64(self.view.version);
            self.area.write(hasher);
            self.corner.iter().for_each(|&at| hasher.write_i64(at));
            [self.view.width, self.view.height].iter().for_each(|&side| hasher.write_usize(side));
            self.view.shown.iter().for_each(|&side| hasher.write_u32(side));
            hasher.write_u32(self.view.around);
        })
    }

    /// Draws the part that is in the area of a canvas. `scaled` belongs to the canvases of one band of tiles.
    pub(super) fn draw(&self, canvas: &mut Canvas<'_>, scaled: &mut ScaledRows) {
        let pane = self.area.intersection(canvas.area());
        let seen = self.covered.intersection(pane);
        for y in pane.top..pane.bottom {
            let row = canvas.row(y, pane.left, pane.right);
            if seen.is_empty() || !(seen.top..seen.bottom).contains(&y) {
                row.fill(self.view.around);
                continue;
            }
            let [from, to] = [seen.left, seen.right].map(|x| (x - pane.left) as usize);
            row[..from].fill(self.view.around);
            row[to..].fill(self.view.around);
            self.draw_row(y, seen.left, &mut row[from..to], scaled);
        }
    }

    /// Draws pixels of one row of the screen, from `x` on. All of them are in `covered`.
    fn draw_row(&self, y: i32, x: i32, into: &mut [u32], scaled: &mut ScaledRows) {
        match &self.scaling {
            Scaling::Whole(zoom) => {
                let [left, top] = [i64::from(x) - self.corner[0], i64::from(y) - self.corner[1]].map(|at| at as usize);
                let pixels = self.row(top / zoom);
                if *zoom == 1 {
                    into.copy_from_slice(&pixels[left..left + into.len()]);
                } else {
                    for (at, pixel) in (left..).zip(into) {
                        *pixel = pixels[at / zoom];
                    }
                }
            }
            Scaling::Area([columns, rows]) => {
                let row = scaled.row(y, |sum| {
                    sum.set(|line| &self.row(line)[columns.range()], rows.below((y - self.covered.top) as usize));
                    let mut pixels = vec![0; (self.covered.right - self.covered.left) as usize];
                    columns.write_means(sum, &mut pixels);
                    pixels
                });
                let left = (x - self.covered.left) as usize;
                into.copy_from_slice(&row[left..left + into.len()]);
            }
        }
    }

    /// A row of the picture.
    fn row(&self, line: usize) -> &[u32] {
        &self.view.pixels[line * self.view.width..(line + 1) * self.view.width]
    }
}
