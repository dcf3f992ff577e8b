//! Equal positions found.

use crate::mesh::error::Fault;
use crate::mesh::ledger::Ledger;
use foldhash::fast::FixedState;
use glam::DVec3;
use std::hash::{BuildHasher, Hasher};

/// Stands for no index in a table.
const EMPTY: u32 = u32::MAX;
const FIRST_TABLE: usize = 1 << 8;

/// A growing list of different positions. Each can be found by its coordinates; 0 and -0 are equal.
pub(super) struct WeldedPositions {
    list: Vec<DVec3>,
    /// Indices into the list by hash, with free slots between them: at least half of all.
    table: Vec<u32>,
}

impl WeldedPositions {
    pub(super) fn new(ledger: &mut Ledger) -> Result<Self, Fault> {
        Ok(Self { list: Vec::new(), table: empty_table(FIRST_TABLE, ledger)? })
    }

    /// The index of a position. A new one is added to the list.
    pub(super) fn index(&mut self, position: DVec3, ledger: &mut Ledger) -> Result<u32, Fault> {
        if self.list.len() * 2 >= self.table.len() {
            self.grow(ledger)?;
        }
        // Without negative zeros.
        let position = position + DVec3::ZERO;
        let slot = self.slot(position);
        if self.table[slot] == EMPTY {
            self.table[slot] = index(self.list.len())?;
            ledger.push(&mut self.list, position)?;
        }
        Ok(self.table[slot])
    }

    /// The positions in the order in which they were added.
    pub(super) fn into_list(self, ledger: &mut Ledger) -> Vec<DVec3> {
        ledger.release(self.table);
        self.list
    }

    /// The slot that holds a position, or the free one that it would get.
    fn slot(&self, position: DVec3) -> usize {
        let mut hasher = FixedState::with_seed(0).build_hasher();
        position.to_array().iter().for_each(|number| hasher.write_u64(number.to_bits()));
        let last = self.table.len() - 1;
        let mut slot = hasher.finish() as usize & last;
        while self.table[slot] != EMPTY && self.list[self.table[slot] as usize] != position {
            slot = (slot + 1) & last;
        }
        slot
    }

    fn grow(&mut self, ledger: &mut Ledger) -> Result<(), Fault> {
        let larger = empty_table(self.table.len() * 2, ledger)?;
        ledger.release(std::mem::replace(&mut self.table, larger));
        for (index, position) in self.list.iter().enumerate() {
            let slot = self.slot(*position);
            self.table[slot] = index as u32;
        }
        Ok(())
    }
}

fn empty_table(length: usize, ledger: &mut Ledger) -> Result<Vec<u32>, Fault> {
    let mut table = Vec::new();
    ledger.reserve(&mut table, length)?;
    table.resize(length, EMPTY);
    Ok(table)
}

/// The index of the next vertex.
pub(super) fn index(count: usize) -> Result<u32, Fault> {
    match u32::try_from(count) {
        Ok(index) if index < u32::MAX => Ok(index),
        Ok(_) | Err(_) => Err(Fault::new(format!("there are more than {} vertices", u32::MAX - 1))),
    }
}
