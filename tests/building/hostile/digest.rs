//! Changes of the digest that a file stores.

use std::ops::Range;

use super::surgery::Patient;
use crate::support::flat::Table;
use crate::support::open_bytes;

/// The slots of the sums in the root.
const SUMS: Range<usize> = 39..46;

/// Returns the offsets of the sums of the digest in the file.
pub fn digest_sums(patient: &Patient) -> Vec<usize> {
    let root = Table::root(&patient.bytes[patient.root.at..]);
    SUMS.map(|slot| patient.root.at + root.field(slot).unwrap()).collect()
}

/// Makes the stored digest that of the tiles, if they can be read. The file's checksums are right.
pub async fn fix_digest(patient: &mut Patient) {
    let Ok(reader) = open_bytes(patient.bytes.clone()).await else {
        return;
    };
    let Ok(digest) = reader.recompute_digest().await else {
        return;
    };
    let sums = [
        digest.triangles,
        digest.vertices,
        digest.constraint_edges,
        digest.holes,
        digest.vertices_with_z,
        digest.edge_sources,
        digest.sites,
    ];
    for (at, sum) in digest_sums(patient).into_iter().zip(sums) {
        patient.put(at, &sum.count.to_le_bytes());
        patient.put(at + 8, &sum.sum.to_le_bytes());
    }
    patient.sew();
}
