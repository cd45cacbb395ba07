//! Chance that everyone agrees on: a hash of the position.

use xxhash_rust::xxh3::xxh3_64_with_seed;

use crate::geometry::Point;

/// The hash of a point, another one for each seed.
pub(super) fn hash(p: Point, seed: u64) -> u64 {
    let mut bytes = [0; 16];
    bytes[..8].copy_from_slice(&p.x.to_le_bytes());
    bytes[8..].copy_from_slice(&p.y.to_le_bytes());
    xxh3_64_with_seed(&bytes, seed)
}

/// Returns whether a hash is among the lowest `share` of all hashes.
pub(super) fn is_below(hash: u64, share: f64) -> bool {
    // Rounded down, so that a share of 1 is all of them.
    (hash as f64) < share * 2f64.powi(64)
}
