//! The textures that a kernel looks up: their texels on the device.

use crate::backends::gpu::device::GraphicsDevice;
use crate::lang::scalars::flush;
use crate::texture::numbered;
use wgpu::{Buffer, BufferUsages};

/// The textures of some numbers.
pub(super) struct DeviceTextures {
    /// The numbers, in order.
    numbers: Vec<u32>,
    pub(super) texels: Buffer,
    /// For each number of a texture up to the largest: where its texels begin, its width and its height.
    pub(super) table: Buffer,
}

impl DeviceTextures {
    /// The numbers of textures among these parameter numbers, which are at these indices.
    pub(super) fn numbers(parameters: &[f32], indices: &[usize]) -> Vec<u32> {
        // The number of a texture is rounded, see `texture::numbered`.
        let mut numbers: Vec<u32> = indices.iter().map(|index| (flush(parameters[*index]) + 0.5) as u32).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers.retain(|number| numbered(*number as f32).is_some());
        numbers
    }

    /// Whether it holds these textures.
    pub(super) fn holds(&self, numbers: &[u32]) -> bool {
        self.numbers == numbers
    }

    /// Gives the device the texels of these textures. `None` if they do not fit into one buffer.
    pub(super) fn new(device: &GraphicsDevice, numbers: Vec<u32>) -> Option<Self> {
        let mut table = vec![[0_u32; 4]; numbers.last().map_or(0, |number| *number as usize + 1)];
        let mut texels: Vec<f32> = Vec::new();
        for number in &numbers {
            let Some(texture) = numbered(*number as f32) else { continue };
            let [width, height] = texture.size();
            let bytes = (texels.len() as u64 + 3 * u64::from(width) * u64::from(height)) * size_of::<f32>() as u64;
            if bytes > device.largest() || bytes > u64::from(u32::MAX) {
                return None;
            }
            table[*number as usize] = [texels.len() as u32, width, height, 0];
            texels.extend((0..height).flat_map(|y| (0..width).flat_map(move |x| texture.texel(x, y))));
        }
        let storage = BufferUsages::STORAGE;
        let (texels, table) =
            (device.filled(storage, bytemuck::cast_slice(&texels)), device.filled(storage, bytemuck::cast_slice(&table)));
        Some(Self { numbers, texels, table })
    }
}
