//! Widgets and the picture into pixels, on the CPU.
//!
//! The window is cut into tiles. Everything that is to be drawn is put down as *items* in order, each tile knows those that touch it and a
//! hash of them, and only tiles whose hash is another than that of what they show are drawn again. The picture lies under all items and is
//! copied, not blended. Colours are blended as egui has them: in gamma space, with premultiplied alpha.
//!
//! Here is what is kept from frame to frame and which tiles are drawn; how triangles become items is in `item`, items become pixels in
//! `raster`, and the textures are in `texture`. Nothing here knows a window.

mod colour;
mod item;
mod raster;
mod region;
#[cfg(test)]
mod tests;
mod texture;

pub use region::Region;

use crate::preview::PictureView;
use egui::epaint::{ClippedPrimitive, textures::TexturesDelta};
use item::{Content, Item};
use rayon::prelude::*;
use std::hash::Hasher;
use texture::Textures;

/// Width and height of a tile.
const TILE: usize = 64;

/// So many tiles, drawn anew, are worth waking other threads for.
const MANY: usize = 12;

/// More threads than this do not draw faster: the time goes into memory.
const THREADS: usize = 4;

/// Paints frames, each onto what the last one left.
#[derive(Debug)]
pub struct Painter {
    pixels: Vec<u32>,
    size: [usize; 2],
    tiles: Vec<Tile>,
    textures: Textures,
    items: Vec<Item>,
    changed: Vec<Region>,
    /// Threads of its own: those of the engine may be in the middle of a picture, and a click would wait for them.
    threads: Option<rayon::ThreadPool>,
}

/// What is to be drawn.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// Width and height, in pixels.
    pub size: [usize; 2],
    /// Pixels a point.
    pub scale: f32,
    /// The colour below everything, `0x00RRGGBB`.
    pub background: u32,
    /// The widgets, from back to front.
    pub widgets: &'a [ClippedPrimitive],
    /// The picture under them.
    pub picture: Option<PictureView<'a>>,
}

/// A part of the window.
#[derive(Debug, Default)]
struct Tile {
    /// What it shows; `None` where it was never drawn.
    shown: Option<u64>,
    /// What it is to show.
    due: u64,
    /// The items that touch it, from back to front.
    items: Vec<u32>,
    /// Nothing behind the first of `items` is seen.
    covered: bool,
}

impl Tile {
    fn is_stale(&self) -> bool {
        self.shown != Some(self.due)
    }
}

impl Default for Painter {
    fn default() -> Self {
        Self::new()
    }
}

impl Painter {
    /// A painter that has painted nothing.
    #[must_use]
    pub fn new() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let threads = rayon::ThreadPoolBuilder::new().num_threads(cores.min(THREADS)).thread_name(|_| "paint".into());
        Self {
            pixels: Vec::new(),
            size: [0, 0],
            tiles: Vec::new(),
            textures: Textures::default(),
            items: Vec::new(),
            changed: Vec::new(),
            threads: if cores > 1 { threads.build().ok() } else { None },
        }
    }

    /// Takes over what became of the textures, and leaves `delta` empty. What is set counts at once, what is freed is so after the next frame.
    pub fn update_textures(&mut self, delta: &mut TexturesDelta) {
        self.textures.update(delta);
    }

    /// The pixels of the last frame, `0x00RRGGBB`, row by row.
    #[must_use]
    pub fn pixels(&self) -> &[u32] {
        &self.pixels
    }

    /// Width and height of the last frame.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Where the last frame differs from the one before.
    #[must_use]
    pub fn changed(&self) -> &[Region] {
        &self.changed
    }

    /// Paints `frame`, and says where it differs from the last one: in places that do not overlap, none of them empty.
    pub fn paint(&mut self, frame: &Frame<'_>) -> &[Region] {
        self.resize(frame.size);
        let picture = frame.picture.as_ref().and_then(|view| Placed::new(view, frame.scale, self.whole()));
        self.plan(frame, picture.as_ref());
        self.draw(frame.background, picture.as_ref());
        self.textures.free();
        self.collect();
        &self.changed
    }

    fn whole(&self) -> Region {
        let side = |length: usize| i32::try_from(length).unwrap_or(i32::MAX);
        Region { left: 0, top: 0, right: side(self.size[0]), bottom: side(self.size[1]) }
    }

    fn resize(&mut self, size: [usize; 2]) {
        if self.size == size {
            return;
        }
        self.size = size;
        self.pixels.clear();
        self.pixels.resize(size[0] * size[1], 0);
        self.tiles.clear();
        self.tiles.resize_with(size[0].div_ceil(TILE) * size[1].div_ceil(TILE), Tile::default);
    }

    /// Finds the items and what each tile is to show.
    fn plan(&mut self, frame: &Frame<'_>, picture: Option<&Placed<'_>>) {
        let whole = self.whole();
        let columns = self.size[0].div_ceil(TILE);
        self.items.clear();
        item::collect(frame.widgets, frame.scale, whole, &self.textures, &mut self.items);

        let ground = hash(|hasher| hasher.write_u32(frame.background));
        let under = picture.map(|picture| (picture.place, picture.hash(ground)));
        for (index, tile) in self.tiles.iter_mut().enumerate() {
            tile.items.clear();
            tile.covered = false;
            let place = place(index, columns, whole);
            tile.due = under.filter(|(pane, _)| !pane.meet(place).is_empty()).map_or(ground, |(_, hash)| hash);
        }
        for (number, item) in (0..).zip(&self.items) {
            let [left, right] = [item.place.left, item.place.right - 1].map(|x| x as usize / TILE);
            let [top, bottom] = [item.place.top, item.place.bottom - 1].map(|y| y as usize / TILE);
            for row in top..=bottom {
                for (column, tile) in (left..).zip(&mut self.tiles[row * columns + left..=row * columns + right]) {
                    if item.is_opaque() && item.place.holds(place(row * columns + column, columns, whole)) {
                        tile.items.clear();
                        tile.covered = true;
                        tile.due = 0;
                    }
                    tile.items.push(number);
                    tile.due = hash(|hasher| {
                        hasher.write_u64(tile.due);
                        hasher.write_u64(item.hash);
                    });
                }
            }
        }
    }

    /// Draws the tiles that are to show something new.
    fn draw(&mut self, background: u32, picture: Option<&Placed<'_>>) {
        let whole = self.whole();
        let [width, columns] = [self.size[0], self.size[0].div_ceil(TILE)];
        let stale = self.tiles.iter().filter(|tile| tile.is_stale()).count();
        if stale == 0 {
            return;
        }
        let (items, textures, tiles) = (&self.items, &self.textures, &self.tiles);
        let draw_band = |(row, band): (usize, &mut [u32])| {
            for (index, tile) in (row * columns..).zip(&tiles[row * columns..(row + 1) * columns]) {
                if !tile.is_stale() {
                    continue;
                }
                let place = place(index, columns, whole);
                let mut canvas = raster::Canvas::new(band, width, (row * TILE) as i32, place);
                if !tile.covered {
                    canvas.clear(background);
                    if let Some(picture) = picture {
                        picture.draw(&mut canvas);
                    }
                }
                for &number in &tile.items {
                    canvas.draw(&items[number as usize], textures);
                }
            }
        };
        match &self.threads {
            Some(threads) if stale >= MANY => {
                let pixels = &mut self.pixels;
                threads.install(|| pixels.par_chunks_mut(width * TILE).enumerate().for_each(draw_band));
            }
            Some(_) | None => self.pixels.chunks_mut(width * TILE).enumerate().for_each(draw_band),
        }
    }

    /// Notes where tiles changed, runs of them as one.
    fn collect(&mut self) {
        let whole = self.whole();
        let columns = self.size[0].div_ceil(TILE);
        self.changed.clear();
        for (index, tile) in self.tiles.iter_mut().enumerate() {
            if !tile.is_stale() {
                continue;
            }
            tile.shown = Some(tile.due);
            let place = place(index, columns, whole);
            match self.changed.last_mut() {
                Some(last) if last.top == place.top && last.right == place.left => last.right = place.right,
                Some(_) | None => self.changed.push(place),
            }
        }
        self.changed.dedup_by(|below, above| {
            let joins = below.left == above.left && below.right == above.right && below.top == above.bottom;
            if joins {
                above.bottom = below.bottom;
            }
            joins
        });
    }
}

/// Where a tile is.
fn place(index: usize, columns: usize, whole: Region) -> Region {
    let side = TILE as i32;
    let [left, top] = [index % columns, index / columns].map(|tile| tile as i32 * side);
    Region { left, top, right: left + side, bottom: top + side }.meet(whole)
}

/// The hash of what `write` writes. It need not be the same in another run.
fn hash(write: impl FnOnce(&mut foldhash::quality::FoldHasher<'static>)) -> u64 {
    use std::hash::BuildHasher;
    let mut hasher = foldhash::quality::FixedState::with_seed(0x696c_6c75).build_hasher();
    write(&mut hasher);
    hasher.finish()
}

/// The picture, and where on the window it is.
struct Placed<'a> {
    view: PictureView<'a>,
    place: Region,
    /// Where its left upper corner is.
    corner: [i64; 2],
    zoom: i64,
}

impl<'a> Placed<'a> {
    /// `None` where nothing of its pane is seen, or where there are fewer pixels than it says.
    fn new(view: &PictureView<'a>, scale: f32, whole: Region) -> Option<Self> {
        let pane = Region::of(view.place, scale);
        let place = pane.meet(whole);
        let enough = view.width.checked_mul(view.height).is_some_and(|count| count <= view.pixels.len());
        let corner = [i64::from(pane.left) + i64::from(view.offset[0]), i64::from(pane.top) + i64::from(view.offset[1])];
        (enough && !place.is_empty()).then_some(Self { view: *view, place, corner, zoom: i64::from(view.zoom.max(1)) })
    }

    fn hash(&self, ground: u64) -> u64 {
        hash(|hasher| {
            hasher.write_u64(ground);
            hasher.write_u64(self.view.version);
            self.place.write(hasher);
            self.corner.iter().for_each(|&at| hasher.write_i64(at));
            [self.view.width, self.view.height].iter().for_each(|&side| hasher.write_usize(side));
            hasher.write_i64(self.zoom);
            hasher.write_u32(self.view.around);
        })
    }

    fn draw(&self, canvas: &mut raster::Canvas<'_>) {
        let pane = self.place.meet(canvas.place());
        let beyond = |side: usize| (side as i64).saturating_mul(self.zoom);
        let [left, top] = self.corner;
        let clamp = |at: i64| at.clamp(i64::from(pane.left), i64::from(pane.right).max(i64::from(pane.left)));
        let from = clamp(left);
        let to = clamp(left.saturating_add(beyond(self.view.width))).max(from);
        let split = [(from - i64::from(pane.left)) as usize, (to - i64::from(pane.left)) as usize];
        for y in pane.top..pane.bottom {
            let row = canvas.row(y, pane.left, pane.right);
            let line = (i64::from(y) - top).div_euclid(self.zoom);
            let pixels = usize::try_from(line)
                .ok()
                .filter(|line| *line < self.view.height)
                .map(|line| &self.view.pixels[line * self.view.width..(line + 1) * self.view.width]);
            let Some(pixels) = pixels else {
                row.fill(self.view.around);
                continue;
            };
            row[..split[0]].fill(self.view.around);
            row[split[1]..].fill(self.view.around);
            let seen = &mut row[split[0]..split[1]];
            let skipped = (from - left) as usize;
            if self.zoom == 1 {
                if !seen.is_empty() {
                    seen.copy_from_slice(&pixels[skipped..skipped + seen.len()]);
                }
            } else {
                let zoom = self.zoom as usize;
                for (at, pixel) in (skipped..).zip(seen) {
                    *pixel = pixels[at / zoom];
                }
            }
        }
    }
}

impl Item {
    /// Whether it hides whatever is behind its whole place.
    fn is_opaque(&self) -> bool {
        matches!(self.content, Content::Fill(colour) if colour >> 24 == 0xff)
    }
}
