//! Painting widgets and the picture on the CPU.
//!
//! The window is divided into tiles. Everything to draw becomes a list of *items*. Each tile knows the items that
//! touch it, and a hash of them. Only a tile whose hash changed is drawn again. The picture is below all items, and is
//! scaled, not blended. Colours are blended as in egui: in gamma space, with premultiplied alpha.
//!
//! This module keeps the state between frames, and decides which tiles are drawn. `item` turns triangles into items,
//! `raster` draws items, `placed_picture` draws the picture, and `texture` holds the textures.
//! No window is known here.

mod colour;
mod item;
mod pixel_rect;
mod placed_picture;
mod raster;
#[cfg(test)]
mod tests;
mod texture;

pub use pixel_rect::PixelRect;

use crate::preview::PictureView;
use egui::epaint::{ClippedPrimitive, textures::TexturesDelta};
use item::{Content, Item};
use placed_picture::{PlacedPicture, ScaledRows};
use rayon::prelude::*;
use std::hash::Hasher;
use texture::Textures;

/// The width and height of a tile.
const TILE_SIZE: usize = 64;

/// Other threads help to draw if at least this many tiles changed.
const PARALLEL_TILES: usize = 12;

/// More threads are not faster, because memory is the limit.
const MAX_THREADS: usize = 4;

/// Paints frames, each over the previous one.
#[derive(Debug)]
pub struct Painter {
    pixels: Vec<u32>,
    size: [usize; 2],
    tiles: Vec<ScreenTile>,
    textures: Textures,
    items: Vec<Item>,
    changed: Vec<PixelRect>,
    /// A thread pool of its own: the threads of the engine may be busy, and a click would wait for them.
    threads: Option<rayon::ThreadPool>,
}

/// What to paint.
#[derive(Debug, Clone, Copy)]
pub struct PaintInput<'a> {
    /// Width and height, in pixels.
    pub size: [usize; 2],
    /// Pixels per point.
    pub scale: f32,
    /// The background colour, `0x00RRGGBB`.
    pub background: u32,
    /// The widgets, from back to front.
    pub widgets: &'a [ClippedPrimitive],
    /// The picture below the widgets.
    pub picture: Option<PictureView<'a>>,
}

/// A tile of the window.
#[derive(Debug, Default)]
struct ScreenTile {
    /// The hash of what it shows; `None` if it was never drawn.
    shown_hash: Option<u64>,
    /// The hash of what it should show.
    wanted_hash: u64,
    /// The items that touch it, from back to front.
    items: Vec<u32>,
    /// Whether the first of `items` hides everything below it.
    covered: bool,
}

impl ScreenTile {
    fn is_stale(&self) -> bool {
        self.shown_hash != Some(self.wanted_hash)
    }
}

impl Default for Painter {
    fn default() -> Self {
        Self::new()
    }
}

impl Painter {
    /// A painter that has not painted yet.
    #[must_use]
    pub fn new() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let threads = rayon::ThreadPoolBuilder::new().num_threads(cores.min(MAX_THREADS)).thread_name(|_| "paint".into());
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

    /// Applies changes of textures, and leaves `delta` empty. New textures can be used at once; freed ones are dropped
    /// after the next frame.
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

    /// The regions where the last frame differs from the previous one.
    #[must_use]
    pub fn changed(&self) -> &[PixelRect] {
        &self.changed
    }

    /// Paints a frame. Returns the regions that differ from the previous frame. They do not overlap, and none is
    /// empty.
    pub fn paint(&mut self, frame: &PaintInput<'_>) -> &[PixelRect] {
        self.resize(frame.size);
        let picture = frame.picture.as_ref().and_then(|view| PlacedPicture::new(view, frame.scale, self.bounds()));
        self.assign_items(frame, picture.as_ref());
        self.draw(frame.background, picture.as_ref());
        self.textures.free();
        self.collect_changes();
        &self.changed
    }

    fn bounds(&self) -> PixelRect {
        let side = |length: usize| i32::try_from(length).unwrap_or(i32::MAX);
        PixelRect { left: 0, top: 0, right: side(self.size[0]), bottom: side(self.size[1]) }
    }

    fn resize(&mut self, size: [usize; 2]) {
        if self.size == size {
            return;
        }
        self.size = size;
        self.pixels.clear();
        self.pixels.resize(size[0] * size[1], 0);
        self.tiles.clear();
        self.tiles.resize_with(size[0].div_ceil(TILE_SIZE) * size[1].div_ceil(TILE_SIZE), ScreenTile::default);
    }

    /// Collects the items, and computes what each tile should show.
    fn assign_items(&mut self, frame: &PaintInput<'_>, picture: Option<&PlacedPicture<'_>>) {
        let bounds = self.bounds();
        let columns = self.size[0].div_ceil(TILE_SIZE);
        self.items.clear();
        item::collect(frame.widgets, frame.scale, bounds, &self.textures, &mut self.items);

        let ground = hash(|hasher| hasher.write_u32(frame.background));
        let under = picture.map(|picture| (picture.area, picture.hash(ground)));
        for (index, tile) in self.tiles.iter_mut().enumerate() {
            tile.items.clear();
            tile.covered = false;
            let area = tile_area(index, columns, bounds);
            tile.wanted_hash = under.filter(|(pane, _)| !pane.intersection(area).is_empty()).map_or(ground, |(_, hash)| hash);
        }
        for (number, item) in (0..).zip(&self.items) {
            let [left, right] = [item.area.left, item.area.right - 1].map(|x| x as usize / TILE_SIZE);
            let [top, bottom] = [item.area.top, item.area.bottom - 1].map(|y| y as usize / TILE_SIZE);
            for row in top..=bottom {
                for (column, tile) in (left..).zip(&mut self.tiles[row * columns + left..=row * columns + right]) {
                    if item.is_opaque() && item.area.contains(tile_area(row * columns + column, columns, bounds)) {
                        tile.items.clear();
                        tile.covered = true;
                        tile.wanted_hash = 0;
                    }
                    tile.items.push(number);
                    tile.wanted_hash = hash(|hasher| {
                        hasher.write_u64(tile.wanted_hash);
                        hasher.write_u64(item.hash);
                    });
                }
            }
        }
    }

    /// Draws the tiles that changed.
    fn draw(&mut self, background: u32, picture: Option<&PlacedPicture<'_>>) {
        let bounds = self.bounds();
        let [width, columns] = [self.size[0], self.size[0].div_ceil(TILE_SIZE)];
        let stale = self.tiles.iter().filter(|tile| tile.is_stale()).count();
        if stale == 0 {
            return;
        }
        let (items, textures, tiles) = (&self.items, &self.textures, &self.tiles);
        let draw_band = |(row, band): (usize, &mut [u32])| {
            let mut scaled = ScaledRows::default();
            for (index, tile) in (row * columns..).zip(&tiles[row * columns..(row + 1) * columns]) {
                if !tile.is_stale() {
                    continue;
                }
                let area = tile_area(index, columns, bounds);
                let mut canvas = raster::Canvas::new(band, width, (row * TILE_SIZE) as i32, area);
                if !tile.covered {
                    canvas.clear(background);
                    if let Some(picture) = picture {
                        picture.draw(&mut canvas, &mut scaled);
                    }
                }
                for &number in &tile.items {
                    canvas.draw(&items[number as usize], textures);
                }
            }
        };
        match &self.threads {
            Some(threads) if stale >= PARALLEL_TILES => {
                let pixels = &mut self.pixels;
                threads.install(|| pixels.par_chunks_mut(width * TILE_SIZE).enumerate().for_each(draw_band));
            }
            Some(_) | None => self.pixels.chunks_mut(width * TILE_SIZE).enumerate().for_each(draw_band),
        }
    }

    /// Collects the regions of changed tiles, merged where possible.
    fn collect_changes(&mut self) {
        let bounds = self.bounds();
        let columns = self.size[0].div_ceil(TILE_SIZE);
        self.changed.clear();
        for (index, tile) in self.tiles.iter_mut().enumerate() {
            if !tile.is_stale() {
                continue;
            }
            tile.shown_hash = Some(tile.wanted_hash);
            let area = tile_area(index, columns, bounds);
            match self.changed.last_mut() {
                Some(last) if last.top == area.top && last.right == area.left => last.right = area.right,
                Some(_) | None => self.changed.push(area),
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

/// The area of a tile.
fn tile_area(index: usize, columns: usize, bounds: PixelRect) -> PixelRect {
    let side = TILE_SIZE as i32;
    let [left, top] = [index % columns, index / columns].map(|tile| tile as i32 * side);
    PixelRect { left, top, right: left + side, bottom: top + side }.intersection(bounds)
}

/// The hash of what `write` writes. It may differ between runs.
fn hash(write: impl FnOnce(&mut foldhash::quality::FoldHasher<'static>)) -> u64 {
    use std::hash::BuildHasher;
    let mut hasher = foldhash::quality::FixedState::with_seed(0x696c_6c75).build_hasher();
    write(&mut hasher);
    hasher.finish()
}

impl Item {
    /// Whether it hides everything below its area.
    fn is_opaque(&self) -> bool {
        matches!(self.content, Content::Fill(colour) if colour >> 24 == 0xff)
    }
}
