//! What the fuzz targets run on a file that a fuzzer changes (`tools/fuzz`), with random changes.

#[path = "../../../tools/fuzz/src/lib.rs"]
#[allow(clippy::duplicate_mod, reason = "the targets are a workspace of their own")]
mod fuzz;

use self::fuzz::{ChangedPart, run};
use crate::support::Random;
use crate::support::cases::cases;

#[test]
fn random_changes_of_each_part_of_a_file_give_answers_or_errors() {
    let parts = [
        ChangedPart::Superblock,
        ChangedPart::Directory,
        ChangedPart::Tile,
        ChangedPart::Tables,
        ChangedPart::Compressed,
    ];
    for (part, seed) in parts.into_iter().zip(1..) {
        let mut random = Random(seed);
        for _ in 0..cases(400) {
            // Five bytes make a change.
            let length = 5 * (1 + random.below(8));
            let data: Vec<u8> = (0..length).map(|_| random.bits() as u8).collect();
            run(&data, part);
        }
    }
}
