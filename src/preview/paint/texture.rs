//! The textures of the widgets: mostly letters, and images that egui was given.

use super::colour::pack;
use egui::epaint::{
    ImageData, ImageDelta, TextureId, textures::TextureFilter, textures::TextureOptions, textures::TextureWrapMode,
    textures::TexturesDelta,
};
use std::collections::HashMap;

/// All textures by egui's identifiers.
#[derive(Debug, Default)]
pub(super) struct Textures {
    all: HashMap<TextureId, Texture>,
    freed: Vec<TextureId>,
    version: u64,
}

/// A texture.
#[derive(Debug)]
pub(super) struct Texture {
    pub(super) size: [usize; 2],
    /// Premultiplied, `0xAARRGGBB`; never empty.
    texels: Vec<u32>,
    options: TextureOptions,
    /// Changes whenever the texture does.
    pub(super) version: u64,
}

impl Textures {
    pub(super) fn get(&self, id: TextureId) -> Option<&Texture> {
        self.all.get(&id)
    }

    pub(super) fn update(&mut self, delta: &mut TexturesDelta) {
        // The order in which different textures are set does not matter.
        for (id, images) in delta.set.drain() {
            self.freed.retain(|freed| *freed != id);
            for image in &images {
                self.version += 1;
                self.set(id, image);
            }
        }
        self.freed.extend(delta.free.drain());
    }

    /// Drops the freed textures.
    pub(super) fn free(&mut self) {
        for id in self.freed.drain(..) {
            self.all.remove(&id);
        }
    }

    fn set(&mut self, id: TextureId, delta: &ImageDelta) {
        let ImageData::Color(image) = &delta.image;
        let [width, height] = image.size;
        if width == 0 || height == 0 || image.pixels.len() < width * height {
            return;
        }
        let texels = image.pixels.iter().map(|texel| pack(texel.to_array()));
        let Some([left, top]) = delta.pos else {
            let texture = Texture { size: image.size, texels: texels.collect(), options: delta.options, version: self.version };
            self.all.insert(id, texture);
            return;
        };
        let Some(texture) = self.all.get_mut(&id) else { return };
        if left + width > texture.size[0] || top + height > texture.size[1] {
            return;
        }
        let texels: Vec<u32> = texels.collect();
        for (row, line) in texels.chunks_exact(width).take(height).enumerate() {
            let start = (top + row) * texture.size[0] + left;
            texture.texels[start..start + width].copy_from_slice(line);
        }
        texture.options = delta.options;
        texture.version = self.version;
    }
}

impl Texture {
    /// A part of a row, as far as it exists.
    pub(super) fn row(&self, line: usize, from: usize, count: usize) -> &[u32] {
        let start = line * self.size[0] + from;
        self.texels.get(start..start + count).unwrap_or_default()
    }

    /// The colour at a point, in texels. `fine` says that texels are smaller than pixels there.
    pub(super) fn sample(&self, at: [f32; 2], fine: bool) -> u32 {
        let filter = if fine { self.options.minification } else { self.options.magnification };
        match filter {
            TextureFilter::Nearest => self.texel(at[0].floor() as i64, at[1].floor() as i64),
            TextureFilter::Linear => {
                let [x, y] = at.map(|at| at - 0.5);
                let [left, top] = [x.floor(), y.floor()];
                let [right, below] = [x - left, y - top];
                let [left, top] = [left as i64, top as i64];
                let corners = [(left, top), (left + 1, top), (left, top + 1), (left + 1, top + 1)];
                let weights = [(1.0 - right) * (1.0 - below), right * (1.0 - below), (1.0 - right) * below, right * below];
                let mut sum = [0.5_f32; 4];
                for ((x, y), weight) in corners.into_iter().zip(weights) {
                    for (sum, channel) in sum.iter_mut().zip(self.texel(x, y).to_le_bytes()) {
                        *sum += weight * f32::from(channel);
                    }
                }
                u32::from_le_bytes(sum.map(|channel| channel as u8))
            }
        }
    }

    fn texel(&self, x: i64, y: i64) -> u32 {
        let wrapped = |at: i64, side: usize| {
            let side = side as i64;
            let at = match self.options.wrap_mode {
                TextureWrapMode::ClampToEdge => at.clamp(0, side - 1),
                TextureWrapMode::Repeat => at.rem_euclid(side),
                TextureWrapMode::MirroredRepeat => {
                    let at = at.rem_euclid(2 * side);
                    at.min(2 * side - 1 - at)
                }
            };
            at as usize
        };
        self.texels[wrapped(y, self.size[1]) * self.size[0] + wrapped(x, self.size[0])]
    }
}
