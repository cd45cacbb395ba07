//! `--memory` under a hard limit that is 16 MiB larger. The limit is set by a cgroup if one can be
//! created, otherwise by a watching process.
//!
//! With glibc's default arenas, lists that doubled, and mappings of huge pages that were not
//! counted, these commands once had up to 140 MiB resident with `--memory 64MiB`, and were killed.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use limited::Limit;
use limited::cases::{self, Runner, Sizes};

const MEBIBYTE: u64 = 1 << 20;
const MEMORY: u64 = 64 * MEBIBYTE;
const MARGIN: u64 = 16 * MEBIBYTE;

/// Sizes at which points are spilled to disk, lines are deferred, and a file is larger than the
/// memory.
const SIZES: Sizes = Sizes {
    points: 1_500_000,
    alpha: 0.5,
    fewer_points: 500_000,
    long_segments: 500,
    crossing_segments: 4000,
    sites: 30_000,
    squares: 40_000,
    seed: 1,
};

#[test]
fn commands_keep_to_their_memory_under_a_hard_limit() {
    let (folder, limit, stop) = (
        tempfile::tempdir().unwrap(),
        Limit::new(MEMORY + MARGIN),
        AtomicBool::new(false),
    );
    let tool = Path::new(crate::PROGRAM);
    cases::prepare(tool, folder.path(), SIZES).unwrap();
    let runner = Runner {
        tool,
        folder: folder.path(),
        limit: &limit,
        stop: &stop,
    };
    for case in &cases::ALL {
        let took = runner.run(case, MEMORY, &[]).unwrap();
        let fault = cases::fault(&took, MEMORY + MARGIN);
        assert_eq!(fault, None, "{}, with {}", case.name, limit.describe());
        if took.own_peak.is_none() {
            eprintln!(
                "the system does not report the memory of a process: {} is not measured",
                case.name
            );
        }
    }
}
