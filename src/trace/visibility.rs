//! Which emitters are visible from which hits of a tile: one bit for each pair.

use crate::world::EmitterId;

/// Whether each emitter of the world is visible from each hit of a tile: no body lies between.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VisibilityTable {
    emitters: usize,
    /// The bits of all emitters for hit 0, then those for hit 1, and so on.
    words: Vec<u64>,
}

impl VisibilityTable {
    /// A table for this many hits and emitters, in which no emitter is visible.
    pub(super) fn new(hits: usize, emitters: usize) -> Self {
        Self { emitters, words: vec![0; (hits * emitters).div_ceil(u64::BITS as usize)] }
    }

    /// The bytes of a table of this many hits and emitters, but for rounding.
    pub(super) fn bytes_for(hits: u64, emitters: u64) -> u64 {
        hits.saturating_mul(emitters) / 8
    }

    /// Marks an emitter as visible from a hit. `hit` is the number of the hit in the tile.
    pub(super) fn set(&mut self, hit: u32, emitter: EmitterId) {
        let (word, bit) = self.place(hit, emitter);
        self.words[word] |= 1 << bit;
    }

    /// Whether an emitter is visible from a hit. `hit` is the number of the hit in the tile.
    pub(super) fn get(&self, hit: u32, emitter: EmitterId) -> bool {
        let (word, bit) = self.place(hit, emitter);
        self.words[word] >> bit & 1 == 1
    }

    /// Its memory, in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.words)
    }

    fn place(&self, hit: u32, emitter: EmitterId) -> (usize, usize) {
        let place = hit as usize * self.emitters + emitter.index();
        (place / u64::BITS as usize, place % u64::BITS as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_do_not_touch_each_other() {
        let mut table = VisibilityTable::new(50, 3);
        assert_eq!(table.bytes(), 24);
        let marked = |hit: u32, emitter: u32| (hit * 7 + emitter * 5).is_multiple_of(4);
        let pairs = || (0..50).flat_map(|hit| (0..3).map(move |emitter| (hit, emitter)));
        pairs().filter(|(hit, emitter)| marked(*hit, *emitter)).for_each(|(hit, emitter)| table.set(hit, EmitterId(emitter)));
        assert!(pairs().all(|(hit, emitter)| table.get(hit, EmitterId(emitter)) == marked(hit, emitter)));
    }
}
