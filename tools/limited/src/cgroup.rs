//! A cgroup with a limit of memory, made by hand: with the memory controller of version 1, or in
//! version 2 where it is delegated.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

/// A group of processes that together get no more memory than its limit; beyond it the system kills
/// one of them. The page cache counts too, but is reclaimed first. The group is removed on drop.
#[derive(Debug)]
pub struct Group {
    folder: PathBuf,
}

impl Group {
    /// Makes a group below this process's own.
    ///
    /// # Errors
    /// If there is no hierarchy with a memory controller, or it cannot be written.
    pub fn new(bytes: u64) -> io::Result<Self> {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("limited-{}-{}", process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let text = fs::read_to_string("/proc/self/cgroup")?;
        let mut refused = io::Error::from(io::ErrorKind::NotFound);
        for (root, own, is_first) in text.lines().filter_map(hierarchy) {
            // Within a container the group's own name may not exist, and the root is the
            // container's.
            for parent in [Path::new(root).join(own.trim_start_matches('/')), PathBuf::from(root)] {
                match Self::in_folder(parent.join(&name), bytes, is_first) {
                    Ok(group) => return Ok(group),
                    Err(error) => refused = error,
                }
            }
        }
        Err(refused)
    }

    fn in_folder(folder: PathBuf, bytes: u64, is_first: bool) -> io::Result<Self> {
        let [limit, with_swap, no_swap] = match is_first {
            true => ["memory.limit_in_bytes", "memory.memsw.limit_in_bytes", ""],
            false => ["memory.max", "", "memory.swap.max"],
        };
        fs::create_dir(&folder)?;
        let group = Self { folder };
        group.write(limit, &bytes.to_string())?;
        // If swap is not counted, there is nothing to forbid.
        for (file, value) in [(with_swap, bytes), (no_swap, 0)] {
            if group.folder.join(file).is_file() {
                group.write(file, &value.to_string())?;
            }
        }
        Ok(group)
    }

    fn write(&self, file: &str, value: &str) -> io::Result<()> {
        let path = self.folder.join(file);
        // The file must exist already: a folder that is no cgroup gets none.
        fs::OpenOptions::new().write(true).open(&path)?;
        fs::write(path, value)
    }

    /// Returns the file to which a process writes its number to join.
    pub fn processes(&self) -> PathBuf {
        self.folder.join("cgroup.procs")
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        // A process that has just ended may be counted for a moment.
        for _ in 0..100 {
            match fs::remove_dir(&self.folder) {
                Err(error) if error.kind() == io::ErrorKind::ResourceBusy => {
                    std::thread::sleep(std::time::Duration::from_millis(10));
                }
                _ => return,
            }
        }
    }
}

/// Parses a line of `/proc/self/cgroup`: the mount point of the hierarchy, the group in it, and
/// whether it is version 1.
fn hierarchy(line: &str) -> Option<(&'static str, &str, bool)> {
    let mut fields = line.splitn(3, ':').skip(1);
    match (fields.next()?, fields.next()?) {
        ("", own) => Some(("/sys/fs/cgroup", own, false)),
        (controllers, own) => {
            let has_memory = controllers.split(',').any(|controller| controller == "memory");
            has_memory.then_some(("/sys/fs/cgroup/memory", own, true))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_both_cgroup_versions_are_distinguished() {
        assert_eq!(
            hierarchy("0::/user.slice"),
            Some(("/sys/fs/cgroup", "/user.slice", false))
        );
        assert_eq!(hierarchy("9:memory:/a"), Some(("/sys/fs/cgroup/memory", "/a", true)));
        assert_eq!(hierarchy("3:cpu,cpuacct:/a"), None);
    }
}
