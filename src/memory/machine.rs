//! The machine's memory, and the process's peak use of it.

use std::fs;

use rustix::process::{Resource, getrlimit};

/// Returns the default memory budget in bytes: a quarter of the smallest of the machine's memory,
/// the limit of the process's cgroup, and its own limits (`RLIMIT_AS`, `RLIMIT_DATA`). If none of
/// these is known, it is 1 GiB.
#[must_use]
pub fn default_memory() -> u64 {
    available_memory() / 4
}

/// Returns the memory in bytes of which [`default_memory`] is a quarter.
pub(crate) fn available_memory() -> u64 {
    let limit = |resource| getrlimit(resource).current;
    let limits = [
        installed_memory(),
        cgroup_limit(),
        limit(Resource::As),
        limit(Resource::Data),
    ];
    limits.into_iter().flatten().min().unwrap_or(4 << 30)
}

fn installed_memory() -> Option<u64> {
    kibibytes("/proc/meminfo", "MemTotal:")
}

/// Returns the smallest limit of the cgroup of this process and the cgroups above it (version 2, or
/// version 1's memory controller).
fn cgroup_limit() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let limits = groups.lines().filter_map(|line| {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, path) = (fields.next()?, fields.next()?);
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            c if c.split(',').any(|c| c == "memory") => ("/sys/fs/cgroup/memory", "memory.limit_in_bytes"),
            _ => return None,
        };
        let group = std::path::Path::new(path.trim_start_matches('/'));
        group
            .ancestors()
            .filter_map(|group| fs::read_to_string(format!("{root}/{}/{file}", group.display())).ok())
            .filter_map(|limit| limit.trim().parse::<u64>().ok())
            .min()
    });
    limits.min()
}

/// Returns the largest resident size of this process so far, in bytes.
#[must_use]
pub fn peak_memory() -> Option<u64> {
    kibibytes("/proc/self/status", "VmHWM:")
}

fn kibibytes(file: &str, key: &str) -> Option<u64> {
    let text = fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let number: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(number * 1024)
}
