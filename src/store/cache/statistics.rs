//! Statistics of a cache.

use std::fmt;

/// Statistics of a cache since it was created.
///
/// Each request for a tile counts as one hit, miss or shared load. The one exception: if a load is
/// cancelled because its runtime ends, a waiting caller starts the load again, which counts as
/// another miss.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CacheStatistics {
    /// Requests for tiles that were in the cache.
    pub hits: u64,
    /// Requests for tiles that had to be loaded.
    pub misses: u64,
    /// Requests that waited for a load that was already running.
    pub shared_loads: u64,
    /// Tiles that were evicted.
    pub evictions: u64,
    /// Tiles that were written back after a change.
    pub write_backs: u64,
    /// Bytes held at present.
    pub bytes: usize,
    /// Bytes of tiles that cannot be evicted at present because they are pinned or being written.
    pub pinned_bytes: usize,
    /// The maximum number of bytes held at any time. It exceeds the capacity only by tiles that
    /// could not be evicted.
    pub most_bytes: usize,
}

impl fmt::Display for CacheStatistics {
    /// Writes one line, such as `812 hits, 95 misses, 3 loads shared, 40 evictions, 12.4 MiB held,
    /// 16.0 MiB at most`. Write-backs and pinned bytes are included only if there are any.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mebibytes = |bytes: usize| bytes as f64 / f64::from(1 << 20);
        write!(
            f,
            "{} hits, {} misses, {} loads shared, {} evictions, ",
            self.hits, self.misses, self.shared_loads, self.evictions
        )?;
        if self.write_backs > 0 {
            write!(f, "{} written back, ", self.write_backs)?;
        }
        write!(f, "{:.1} MiB held", mebibytes(self.bytes))?;
        if self.pinned_bytes > 0 {
            write!(f, " ({:.1} MiB pinned)", mebibytes(self.pinned_bytes))?;
        }
        write!(f, ", {:.1} MiB at most", mebibytes(self.most_bytes))
    }
}
