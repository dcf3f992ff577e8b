//! How much memory a picture may take.

use sysinfo::System;

/// What may be used where nothing is known of the machine.
const FALLBACK: u64 = 1 << 30;

/// The bytes that may be used: what the user allows, or half of what is free now, limits of control groups heeded.
pub(super) fn budget(allowed: Option<u64>) -> u64 {
    allowed.unwrap_or_else(|| match available() {
        0 => FALLBACK,
        free => free / 2,
    })
}

/// Bytes that are free; 0 where that is not known.
fn available() -> u64 {
    let mut system = System::new();
    system.refresh_memory();
    let free = system.available_memory();
    system.cgroup_limits().map_or(free, |limits| free.min(limits.free_memory))
}
