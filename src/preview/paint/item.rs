//! Turning triangles into items: what is drawn at once, its area, and its hash.
//!
//! Most triangles come in pairs that form an axis-aligned rectangle of one colour, plain or with a letter. Such a pair
//! becomes one item. Triangles that are empty or not finite are left out.

use super::colour::pack;
use super::hash;
use super::pixel_rect::PixelRect;
use super::texture::{Texture, Textures};
use egui::epaint::{ClippedPrimitive, Mesh, Primitive, TextureId, Vertex};
use std::hash::{Hash, Hasher};

/// The largest distance between texels and pixels that still counts as aligned.
const EXACT: f64 = 0.02;

/// An item.
#[derive(Debug)]
pub(super) struct Item {
    /// The pixels that it may change; never empty.
    pub(super) area: PixelRect,
    pub(super) content: Content,
    /// A hash of everything that its pixels depend on.
    pub(super) hash: u64,
}

/// The content of an item. Colours are premultiplied, `0xAARRGGBB`.
#[derive(Debug)]
pub(super) enum Content {
    /// One colour.
    Fill(u32),
    /// Texels aligned with pixels. The texel of a pixel is `shift` away from it.
    Copy { texture: TextureId, shift: [i64; 2], tint: u32 },
    /// A scaled rectangle of texels: pixel 0 has texel `from`, and each next pixel is `step` texels further.
    Stretch { texture: TextureId, from: [f64; 2], step: [f64; 2], tint: u32 },
    /// A triangle with interpolated colours, and a texture if it has one.
    Triangle(Box<PaintTriangle>),
}

/// A triangle.
#[derive(Debug)]
pub(super) struct PaintTriangle {
    /// The corners, in pixels.
    pub(super) corners: [[f64; 2]; 3],
    /// The colours at the corners.
    pub(super) colours: [u32; 3],
    /// The texture, and the position of the corners on it, in texels.
    pub(super) texture: Option<(TextureId, [[f64; 2]; 3])>,
}

/// A corner in pixels.
#[derive(Clone, Copy)]
struct Corner {
    at: [f64; 2],
    texel: [f64; 2],
    colour: u32,
}

/// Collects the items of `widgets`, in order.
pub(super) fn collect(widgets: &[ClippedPrimitive], scale: f32, bounds: PixelRect, textures: &Textures, items: &mut Vec<Item>) {
    for widget in widgets {
        // Callbacks paint with a graphics card, which is not used here.
        let Primitive::Mesh(mesh) = &widget.primitive else { continue };
        let clip = PixelRect::of(widget.clip_rect, scale).intersection(bounds);
        let Some(texture) = textures.get(mesh.texture_id).filter(|_| !clip.is_empty()) else { continue };
        ItemCollector { mesh, texture, scale, clip, items }.run();
    }
}

struct ItemCollector<'a> {
    mesh: &'a Mesh,
    texture: &'a Texture,
    scale: f32,
    clip: PixelRect,
    items: &'a mut Vec<Item>,
}

impl ItemCollector<'_> {
    fn run(mut self) {
        let mut left = self.mesh.indices.as_slice();
        while let [a, b, c, rest @ ..] = left {
            left = rest;
            let Some(first) = self.corners([*a, *b, *c]) else { continue };
            if let [d, e, f, beyond @ ..] = rest
                && let Some(second) = self.corners([*d, *e, *f])
                && self.rectangle(&first, &second)
            {
                left = beyond;
            } else {
                self.triangle(&first);
            }
        }
    }

    fn corners(&self, indices: [u32; 3]) -> Option<[Corner; 3]> {
        let corner = |index: u32| {
            let Vertex { pos, uv, color } = *self.mesh.vertices.get(index as usize)?;
            let at = [pos.x * self.scale, pos.y * self.scale];
            let texel = [uv.x * self.texture.size[0] as f32, uv.y * self.texture.size[1] as f32];
            let finite = at.iter().chain(&texel).all(|number| number.is_finite());
            finite.then(|| Corner { at: at.map(f64::from), texel: texel.map(f64::from), colour: pack(color.to_array()) })
        };
        let [a, b, c] = indices;
        Some([corner(a)?, corner(b)?, corner(c)?])
    }

    /// The pixels with their centre between `low` and `high`.
    fn area(&self, low: [f64; 2], high: [f64; 2]) -> Option<PixelRect> {
        let [left, top] = low.map(edge);
        let [right, bottom] = high.map(edge);
        Some(PixelRect { left, top, right, bottom }.intersection(self.clip)).filter(|area| !area.is_empty())
    }

    /// Turns two triangles into one rectangle, if they form one.
    fn rectangle(&mut self, first: &[Corner; 3], second: &[Corner; 3]) -> bool {
        let all = || first.iter().chain(second);
        let colour = first[0].colour;
        if all().any(|corner| corner.colour != colour) {
            return false;
        }
        let [low, high] = bounds(first);
        let mut texels = [None; 4];
        let mut missing = [0, 0];
        for (triangle, missing) in [first, second].into_iter().zip(&mut missing) {
            let mut seen = 0;
            for corner in triangle {
                // The corner of the rectangle: one bit for right, another one for below.
                let mut number = 0;
                for axis in 0..2 {
                    if corner.at[axis] == high[axis] {
                        number |= 1 << axis;
                    } else if corner.at[axis] != low[axis] {
                        return false;
                    }
                }
                seen |= 1 << number;
                *missing ^= number;
                if *texels[number].get_or_insert(corner.texel) != corner.texel {
                    return false;
                }
            }
            if u32::count_ones(seen) != 3 {
                return false;
            }
        }
        // Each triangle lacks one corner. They form a rectangle if the missing corners are opposite.
        let [Some(a), Some(b), Some(c), Some(d)] = texels else { return false };
        if missing[0] ^ missing[1] != 3 || a[0] != c[0] || b[0] != d[0] || a[1] != b[1] || c[1] != d[1] {
            return false;
        }
        if let Some(area) = self.area(low, high) {
            self.push(area, self.textured(colour, [low, high], [a, d]));
        }
        true
    }

    /// The content of a rectangle with the texels `from` to `to`.
    fn textured(&self, tint: u32, [low, high]: [[f64; 2]; 2], [from, to]: [[f64; 2]; 2]) -> Content {
        let texture = self.mesh.texture_id;
        if from == to {
            return Content::Fill(self.plain(tint, from));
        }
        let step = [0, 1].map(|axis| (to[axis] - from[axis]) / (high[axis] - low[axis]));
        let shift = [0, 1].map(|axis| from[axis] - low[axis]);
        let exact = [0, 1].into_iter().all(|axis| {
            let off = (shift[axis] - shift[axis].round()).abs();
            let drift = ((step[axis] - 1.0) * (high[axis] - low[axis])).abs();
            off < EXACT && drift < EXACT
        });
        if exact {
            Content::Copy { texture, shift: shift.map(|shift| shift.round() as i64), tint }
        } else {
            let from = [0, 1].map(|axis| from[axis] + (0.5 - low[axis]) * step[axis]);
            Content::Stretch { texture, from, step, tint }
        }
    }

    /// The colour of a rectangle that has a single texel.
    fn plain(&self, colour: u32, texel: [f64; 2]) -> u32 {
        super::colour::tinted(self.texture.sample(texel.map(|at| at as f32), false), colour)
    }

    fn triangle(&mut self, corners: &[Corner; 3]) {
        let [low, high] = bounds(corners);
        let Some(area) = self.area(low, high) else { return };
        let texels = corners.map(|corner| corner.texel);
        let mut colours = corners.map(|corner| corner.colour);
        let mut texture = Some((self.mesh.texture_id, texels));
        if texels[0] == texels[1] && texels[0] == texels[2] {
            colours = colours.map(|colour| self.plain(colour, texels[0]));
            texture = None;
        }
        // Corners that neither add nor hide anything: the outer edge of a soft border has one or two, never three.
        if colours == [0; 3] {
            return;
        }
        self.push(
            area,
            Content::Triangle(Box::new(PaintTriangle { corners: corners.map(|corner| corner.at), colours, texture })),
        );
    }

    fn push(&mut self, area: PixelRect, content: Content) {
        if matches!(content, Content::Fill(0)) {
            return;
        }
        let hash = hash(|hasher| {
            area.write(hasher);
            content.write(self.texture.version, hasher);
        });
        self.items.push(Item { area, content, hash });
    }
}

impl Content {
    fn write(&self, version: u64, hasher: &mut impl Hasher) {
        let (kind, texture) = match self {
            Self::Fill(_) => (0, None),
            Self::Copy { texture, .. } => (1, Some(texture)),
            Self::Stretch { texture, .. } => (2, Some(texture)),
            Self::Triangle(triangle) => (3, triangle.texture.as_ref().map(|(texture, _)| texture)),
        };
        hasher.write_u32(kind);
        texture.map(|texture| (texture, version)).hash(hasher);
        let mut points = |points: &[[f64; 2]]| points.as_flattened().iter().for_each(|at| hasher.write_u64(at.to_bits()));
        match self {
            Self::Fill(colour) => hasher.write_u32(*colour),
            Self::Copy { shift, tint, .. } => (shift, tint).hash(hasher),
            Self::Stretch { from, step, tint, .. } => {
                points(&[*from, *step]);
                hasher.write_u32(*tint);
            }
            Self::Triangle(triangle) => {
                points(&triangle.corners);
                triangle.texture.iter().for_each(|(_, texels)| points(texels));
                triangle.colours.hash(hasher);
            }
        }
    }
}

/// The first pixel with its centre at or after `at`.
pub(super) fn edge(at: f64) -> i32 {
    (at - 0.5).ceil() as i32
}

fn bounds(corners: &[Corner; 3]) -> [[f64; 2]; 2] {
    let fold = |choose: fn(f64, f64) -> f64| {
        [0, 1].map(|axis| choose(choose(corners[0].at[axis], corners[1].at[axis]), corners[2].at[axis]))
    };
    [fold(f64::min), fold(f64::max)]
}
