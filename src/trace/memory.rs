//! How much memory a picture may take on this machine.

use std::path::Path;
use sysinfo::System;

/// The limit where nothing is known of the machine, in bytes.
const FALLBACK: u64 = 1 << 30;

/// The default limit for a picture in bytes: half of what this process can still get, within the limits of control
/// groups (versions 1 and 2) and of the process.
pub fn usable_memory() -> u64 {
    let limits = [system_free(), control_group_free(), process_free()];
    limits.into_iter().flatten().min().map_or(FALLBACK, |free| free / 2)
}

/// The bytes that are free on the machine.
fn system_free() -> Option<u64> {
    let mut system = System::new();
    system.refresh_memory();
    Some(system.available_memory()).filter(|free| *free > 0)
}

/// The bytes that are left in the control group of this process, and in all those that it is part of.
fn control_group_free() -> Option<u64> {
    let read = |path: &Path| std::fs::read_to_string(path).ok();
    group_free(&read(Path::new("/proc/self/cgroup"))?, &read)
}

/// A version of control groups: where its files are, and what they are called.
struct GroupFiles {
    root: &'static str,
    limit: &'static str,
    used: &'static str,
    /// The line of `memory.stat` that counts file pages which can be given back at once.
    reclaimable: &'static str,
}

const VERSION_1: GroupFiles = GroupFiles {
    root: "/sys/fs/cgroup/memory",
    limit: "memory.limit_in_bytes",
    used: "memory.usage_in_bytes",
    reclaimable: "total_inactive_file",
};
const VERSION_2: GroupFiles =
    GroupFiles { root: "/sys/fs/cgroup", limit: "memory.max", used: "memory.current", reclaimable: "inactive_file" };

/// The bytes that are left in the groups that `groups`, the text of `/proc/self/cgroup`, names.
fn group_free(groups: &str, read: &dyn Fn(&Path) -> Option<String>) -> Option<u64> {
    let of_line = |line: &str| {
        // Number, controllers, path.
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next()?, parts.next()?);
        let files = match controllers {
            "" => VERSION_2,
            _ if controllers.split(',').any(|controller| controller == "memory") => VERSION_1,
            _ => return None,
        };
        // The limits of groups above hold too. Within a container the path may be one of the host: then only the root
        // is there.
        let path = Path::new(path.trim_start_matches('/'));
        path.ancestors().filter_map(|group| free_in(&files, &Path::new(files.root).join(group), read)).min()
    };
    groups.lines().filter_map(of_line).min()
}

/// The bytes that are left in one group; `None` where it has no limit.
fn free_in(files: &GroupFiles, group: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Option<u64> {
    let number = |name: &str| read(&group.join(name))?.trim().parse::<u64>().ok();
    // Without a limit it is `max`, or a number near 2⁶³.
    let limit = number(files.limit).filter(|limit| *limit < 1 << 62)?;
    let used = number(files.used).unwrap_or(0);
    let stat = read(&group.join("memory.stat")).unwrap_or_default();
    let reclaimable = stat.lines().find_map(|line| line.strip_prefix(files.reclaimable)?.trim().parse::<u64>().ok());
    Some(limit.saturating_sub(used.saturating_sub(reclaimable.unwrap_or(0))))
}

/// The bytes of address space that the limits of this process (`ulimit -v`, `-d`) leave.
#[cfg(unix)]
fn process_free() -> Option<u64> {
    use rustix::process::{Resource, getrlimit};
    let pages = |field: usize| {
        let sizes = std::fs::read_to_string("/proc/self/statm").ok()?;
        sizes.split_whitespace().nth(field)?.parse::<u64>().ok()
    };
    let left = |resource: Resource, field: usize| {
        let limit = getrlimit(resource).current?;
        Some(limit.saturating_sub(pages(field)?.saturating_mul(rustix::param::page_size() as u64)))
    };
    // The whole address space, and data with stacks.
    [left(Resource::As, 0), left(Resource::Data, 5)].into_iter().flatten().min()
}

/// Not known elsewhere.
#[cfg(not(unix))]
fn process_free() -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    fn free(groups: &str, files: &[(&str, &str)]) -> Option<u64> {
        let files: HashMap<&str, &str> = files.iter().copied().collect();
        group_free(groups, &|path| files.get(path.to_str()?).map(|text| (*text).to_owned()))
    }

    #[test]
    fn the_tightest_group_above_counts_in_version_2() {
        let files = [
            ("/sys/fs/cgroup/user/job/memory.max", "max\n"),
            ("/sys/fs/cgroup/user/memory.max", "1000\n"),
            ("/sys/fs/cgroup/user/memory.current", "700\n"),
            ("/sys/fs/cgroup/user/memory.stat", "anon 500\ninactive_file 200\nactive_file 0\n"),
        ];
        assert_eq!(free("0::/user/job\n", &files), Some(500));
        assert_eq!(free("0::/other\n", &files), None);
    }

    #[test]
    fn the_memory_controller_counts_in_version_1() {
        let files = [
            ("/sys/fs/cgroup/memory/box/memory.limit_in_bytes", "4096\n"),
            ("/sys/fs/cgroup/memory/box/memory.usage_in_bytes", "1096\n"),
            ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n"),
        ];
        assert_eq!(free("5:cpu,cpuacct:/box\n4:memory:/box\n0::/\n", &files), Some(3000));
        // In a container the path is the host's, and its own group is the root.
        let inside = [("/sys/fs/cgroup/memory/memory.limit_in_bytes", "512\n")];
        assert_eq!(free("4:memory:/docker/abc\n", &inside), Some(512));
    }

    #[test]
    fn this_machine_has_memory() {
        assert!(usable_memory() > 1 << 20);
    }
}
