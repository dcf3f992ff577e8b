//! Drawing items into one tile.
//!
//! A pixel belongs to a shape if its centre is inside. A centre on an edge belongs to the shape to the right or below.
//! Edges are computed row by row from their upper end, whichever shape they belong to, so shapes that share an edge
//! neither overlap nor leave a gap.

use super::colour::{blend, span, tinted};
use super::item::{Content, Item, PaintTriangle, edge};
use super::pixel_rect::PixelRect;
use super::texture::{Texture, Textures};

/// The tile to draw into.
pub(super) struct Canvas<'a> {
    /// The rows of pixels that contain the tile.
    band: &'a mut [u32],
    width: usize,
    /// The window row of the first of them.
    top: i32,
    area: PixelRect,
}

impl<'a> Canvas<'a> {
    /// The tile with this area, in a band of bounds rows that starts at row `top`.
    pub(super) fn new(band: &'a mut [u32], width: usize, top: i32, area: PixelRect) -> Self {
        Self { band, width, top, area }
    }

    pub(super) fn area(&self) -> PixelRect {
        self.area
    }

    /// The pixels of a row from `left` up to `right`, which must be in the tile.
    pub(super) fn row(&mut self, y: i32, left: i32, right: i32) -> &mut [u32] {
        let start = (y - self.top) as usize * self.width;
        &mut self.band[start + left as usize..start + right.max(left) as usize]
    }

    pub(super) fn clear(&mut self, colour: u32) {
        self.fill(self.area, colour | 0xff00_0000);
    }

    pub(super) fn draw(&mut self, item: &Item, textures: &Textures) {
        let area = item.area.intersection(self.area);
        if area.is_empty() {
            return;
        }
        match &item.content {
            Content::Fill(colour) => self.fill(area, *colour),
            Content::Copy { texture, shift, tint } => {
                if let Some(texture) = textures.get(*texture) {
                    self.copy(area, texture, *shift, *tint);
                }
            }
            Content::Stretch { texture, from, step, tint } => {
                if let Some(texture) = textures.get(*texture) {
                    self.stretch(area, texture, *from, *step, *tint);
                }
            }
            Content::Triangle(triangle) => self.triangle(area, triangle, textures),
        }
    }

    fn fill(&mut self, area: PixelRect, colour: u32) {
        for y in area.top..area.bottom {
            span(self.row(y, area.left, area.right), colour);
        }
    }

    fn copy(&mut self, area: PixelRect, texture: &Texture, shift: [i64; 2], tint: u32) {
        for y in area.top..area.bottom {
            let row = self.row(y, area.left, area.right);
            let [Ok(from), Ok(line)] = [i64::from(area.left) + shift[0], i64::from(y) + shift[1]].map(usize::try_from) else {
                continue;
            };
            for (pixel, &texel) in row.iter_mut().zip(texture.row(line, from, (area.right - area.left) as usize)) {
                if texel != 0 {
                    blend(pixel, tinted(texel, tint));
                }
            }
        }
    }

    fn stretch(&mut self, area: PixelRect, texture: &Texture, from: [f64; 2], step: [f64; 2], tint: u32) {
        let fine = step.iter().all(|step| step.abs() > 1.0);
        for y in area.top..area.bottom {
            let line = (from[1] + f64::from(y) * step[1]) as f32;
            let row = self.row(y, area.left, area.right);
            for (x, pixel) in (area.left..).zip(row) {
                let at = (from[0] + f64::from(x) * step[0]) as f32;
                blend(pixel, tinted(texture.sample([at, line], fine), tint));
            }
        }
    }

    fn triangle(&mut self, area: PixelRect, triangle: &PaintTriangle, textures: &Textures) {
        let plain = triangle.texture.is_none() && triangle.colours.iter().all(|colour| *colour == triangle.colours[0]);
        let colours = Slope::of(triangle, triangle.colours.map(|colour| colour.to_le_bytes().map(f64::from)));
        let texels =
            triangle.texture.as_ref().and_then(|(texture, texels)| Some((textures.get(*texture)?, Slope::of(triangle, *texels))));
        if triangle.texture.is_some() && texels.is_none() {
            return;
        }
        for y in area.top..area.bottom {
            let Some((left, right)) = crossing(&triangle.corners, f64::from(y) + 0.5) else { continue };
            let [left, right] = [edge(left).max(area.left), edge(right).min(area.right)];
            if left >= right {
                continue;
            }
            let row = self.row(y, left, right);
            if plain {
                span(row, triangle.colours[0]);
                continue;
            }
            let middle = [f64::from(left) + 0.5, f64::from(y) + 0.5];
            let colour = colours.along(middle);
            match &texels {
                None => {
                    for (pixel, colour) in row.iter_mut().zip(colour) {
                        blend(pixel, u32::from_le_bytes(colour.map(|channel| (channel + 0.5) as u8)));
                    }
                }
                Some((texture, slope)) => {
                    let fine = slope.across.iter().all(|step| step.abs() > 1.0);
                    for ((pixel, colour), texel) in row.iter_mut().zip(colour).zip(slope.along(middle)) {
                        let colour = u32::from_le_bytes(colour.map(|channel| (channel + 0.5) as u8));
                        blend(pixel, tinted(texture.sample(texel, fine), colour));
                    }
                }
            }
        }
    }
}

/// Where the centre of a row enters and leaves a triangle.
fn crossing(corners: &[[f64; 2]; 3], y: f64) -> Option<(f64, f64)> {
    let mut found = [None; 2];
    for [from, to] in [[0, 1], [1, 2], [2, 0]].map(|ends| ends.map(|end| corners[end])) {
        let [upper, lower] = if from[1] <= to[1] { [from, to] } else { [to, from] };
        if upper[1] <= y && y < lower[1] {
            let x = upper[0] + (y - upper[1]) * ((lower[0] - upper[0]) / (lower[1] - upper[1]));
            found[usize::from(found[0].is_some())] = Some(x);
        }
    }
    let [Some(a), Some(b)] = found else { return None };
    Some((a.min(b), a.max(b)))
}

/// Numbers that are interpolated linearly over a triangle.
struct Slope<const N: usize> {
    origin: [f64; 2],
    start: [f64; N],
    across: [f64; N],
    down: [f64; N],
    /// The smallest and largest numbers at the corners, which limit the others.
    low: [f32; N],
    high: [f32; N],
}

impl<const N: usize> Slope<N> {
    fn of(triangle: &PaintTriangle, values: [[f64; N]; 3]) -> Self {
        let [origin, b, c] = triangle.corners;
        let [[bx, by], [cx, cy]] = [b, c].map(|corner| [corner[0] - origin[0], corner[1] - origin[1]]);
        let area = bx * cy - cx * by;
        let rise = |corner: usize, channel: usize| values[corner][channel] - values[0][channel];
        let finite = |number: f64| if number.is_finite() { number } else { 0.0 };
        let fold = |choose: fn(f64, f64) -> f64| {
            std::array::from_fn(|channel| choose(choose(values[0][channel], values[1][channel]), values[2][channel]) as f32)
        };
        Self {
            origin,
            start: values[0],
            across: std::array::from_fn(|channel| finite((rise(1, channel) * cy - rise(2, channel) * by) / area)),
            down: std::array::from_fn(|channel| finite((rise(2, channel) * bx - rise(1, channel) * cx) / area)),
            low: fold(f64::min),
            high: fold(f64::max),
        }
    }

    /// The numbers at a point, and then one pixel further to the right each time.
    fn along(&self, at: [f64; 2]) -> impl Iterator<Item = [f32; N]> {
        let [right, below] = [at[0] - self.origin[0], at[1] - self.origin[1]];
        let start: [f32; N] = std::array::from_fn(|channel| {
            (self.start[channel] + right * self.across[channel] + below * self.down[channel]) as f32
        });
        let step: [f32; N] = self.across.map(|step| step as f32);
        let mut count = 0.0;
        std::iter::repeat_with(move || {
            let now = count;
            count += 1.0;
            std::array::from_fn(|channel| (start[channel] + now * step[channel]).max(self.low[channel]).min(self.high[channel]))
        })
    }
}
