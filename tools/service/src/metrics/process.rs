//! Memory of the process.

use std::fs;

/// Bytes of a page of memory, as Linux counts them on the machines that it commonly runs on.
const PAGE: u64 = 4096;

/// Returns the resident bytes of this process; 0 if the system does not say.
pub fn resident() -> u64 {
    let text = fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = text.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok());
    pages.unwrap_or(0) * PAGE
}
