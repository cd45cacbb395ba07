//! What a cache has done, for programs and for people.

use std::fmt;

/// What a cache has done so far.
///
/// Whoever asks for a tile has a hit, a miss or a shared load; only where a load was cancelled with its runtime and begun
/// anew, there is another miss.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CacheStatistics {
    /// Tiles that were there.
    pub hits: u64,
    /// Tiles that had to be loaded.
    pub misses: u64,
    /// Callers that waited for a load that was under way.
    pub shared_loads: u64,
    /// Tiles that had to go.
    pub evictions: u64,
    /// Tiles that were changed and then saved.
    pub write_backs: u64,
    /// Bytes held now.
    pub bytes: usize,
    /// Bytes of tiles that cannot go now, because they are pinned or being saved.
    pub pinned_bytes: usize,
    /// The most bytes held at once. More than the capacity only by what could not go.
    pub most_bytes: usize,
}

impl fmt::Display for CacheStatistics {
    /// On one line: `812 hits, 95 misses, 3 loads shared, 40 evictions, 12.4 MiB held`, and what else there is to say.
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
