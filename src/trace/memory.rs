//! How much memory this machine has to spare for a picture.

use sysinfo::System;

/// What may be used where nothing is known of the machine.
const FALLBACK: u64 = 1 << 30;

/// The bytes that a picture may take where nobody says otherwise: half of what is free now, limits of control groups heeded.
pub fn usable_memory() -> u64 {
    match available() {
        0 => FALLBACK,
        free => free / 2,
    }
}

/// Bytes that are free; 0 where that is not known.
fn available() -> u64 {
    let mut system = System::new();
    system.refresh_memory();
    let free = system.available_memory();
    system.cgroup_limits().map_or(free, |limits| free.min(limits.free_memory))
}
