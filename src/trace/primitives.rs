//! Which triangle of a mesh each hit is on.
//!
//! A hit on another body is computed again from its ray. On a mesh that would be a search, so the store keeps the
//! triangle: six bytes for each hit on a mesh, and nothing for others.

use crate::world::PrimitiveId;

/// The triangles of the hits of a tile that are on meshes.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PrimitiveTable {
    /// For each path, where its hits end in the lists. Empty if no hit is on a mesh.
    ends: Vec<u32>,
    /// The pixels of the hits, path by path and in order.
    pixels: Vec<u16>,
    /// Their triangles.
    primitives: Vec<PrimitiveId>,
}

impl PrimitiveTable {
    /// The bytes for each hit on a mesh.
    pub(super) const BYTES_PER_HIT: u64 = (size_of::<u16>() + size_of::<PrimitiveId>()) as u64;

    /// A table of hits in the order of their pixels: the index of the path, the pixel and the triangle of each.
    pub(super) fn new(hits: &[(usize, u16, PrimitiveId)], paths: usize) -> Self {
        if hits.is_empty() {
            return Self::default();
        }
        let mut ends = vec![0; paths];
        hits.iter().for_each(|(path, ..)| ends[*path] += 1);
        let mut sum = 0;
        for end in &mut ends {
            // At first, where the hits of the path start.
            sum += std::mem::replace(end, sum);
        }
        let (mut pixels, mut primitives) = (vec![0; hits.len()], vec![PrimitiveId::ONLY; hits.len()]);
        for (path, pixel, primitive) in hits {
            let at = &mut ends[*path];
            pixels[*at as usize] = *pixel;
            primitives[*at as usize] = *primitive;
            *at += 1;
        }
        Self { ends, pixels, primitives }
    }

    /// The triangle of the hit by the path of that index in that pixel of the tile; `None` if it is on no mesh.
    pub(super) fn get(&self, path: usize, pixel: u16) -> Option<PrimitiveId> {
        let end = *self.ends.get(path)?;
        let start = path.checked_sub(1).map_or(0, |before| self.ends[before]);
        let (start, end) = (start as usize, end as usize);
        let at = self.pixels[start..end].binary_search(&pixel).ok()?;
        Some(self.primitives[start + at])
    }

    /// The memory that it takes, in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.ends) + size_of_val(&*self.pixels) + size_of_val(&*self.primitives)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hits_are_found_by_path_and_pixel() {
        let hits = [(2, 3, 70), (0, 5, 71), (2, 5, 72), (2, 9, 73), (0, 9, 74)];
        let hits = hits.map(|(path, pixel, primitive)| (path, pixel, PrimitiveId(primitive)));
        let table = PrimitiveTable::new(&hits, 4);
        for (path, pixel, primitive) in hits {
            assert_eq!(table.get(path, pixel), Some(primitive));
        }
        for (path, pixel) in [(0, 3), (1, 5), (2, 4), (3, 3), (4, 5), (9, 5)] {
            assert_eq!(table.get(path, pixel), None);
        }
        assert_eq!(PrimitiveTable::new(&[], 4).get(0, 0), None);
        assert_eq!(PrimitiveTable::new(&[], 4).bytes(), 0);
    }
}
