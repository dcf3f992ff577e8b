//! Amounts of memory, as people read them.

use std::fmt;

/// An amount of memory in bytes, written for people: `3.3 KiB`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemorySize(pub u64);

impl fmt::Display for MemorySize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
        match units.into_iter().find(|(shift, _)| self.0 >> shift > 0) {
            Some((shift, unit)) => write!(f, "{:.1} {unit}", self.0 as f64 / f64::from(1_u32 << shift)),
            None => write!(f, "{} bytes", self.0),
        }
    }
}
