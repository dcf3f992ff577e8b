//! How much memory a picture may take on this machine.

use sysinfo::System;

/// The limit where nothing is known of the machine, in bytes.
const FALLBACK: u64 = 1 << 30;

/// The default limit for a picture in bytes: half of what is free now, within the limits of control groups.
pub fn usable_memory() -> u64 {
    match available() {
        0 => FALLBACK,
        free => free / 2,
    }
}

/// The bytes that are free; 0 where that is not known.
fn available() -> u64 {
    let mut system = System::new();
    system.refresh_memory();
    let free = system.available_memory();
    system.cgroup_limits().map_or(free, |limits| free.min(limits.free_memory))
}
