//! Changes bytes of a small tile file. With right checksums any answer and any error is accepted,
//! but no panic, no hang and no unbounded memory. With the old checksums, an answer must be the
//! same as before.

use std::panic;
use std::sync::OnceLock;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use anyhow::{bail, ensure};
use delaunay_tiles::io::MemoryFile;
use delaunay_tiles::store::{Digest, OpenOptions, TileReader};
use rand_chacha::ChaCha8Rng;

use crate::campaign::{Context, Counts, below};

/// The files and questions of the fuzz targets, without the fuzzer.
#[path = "../../fuzz/src/lib.rs"]
#[allow(dead_code, reason = "tests have more uses for some of it")]
mod hostile;

use hostile::ChangedPart;

/// The time after which a query of the file counts as a hang; a file of a few hundred vertices
/// takes a second.
const LIMIT: Duration = Duration::from_secs(60);
/// The number of changes in a round.
const CHANGES: u64 = 20;

/// Changes bytes, [`CHANGES`] times.
pub fn round(_: &Context, mut random: ChaCha8Rng) -> anyhow::Result<Counts> {
    let random = &mut random;
    for _ in 0..CHANGES {
        let count = 1 + below(random, 6);
        let change: Vec<u8> = (0..5 * count).map(|_| below(random, 256) as u8).collect();
        match below(random, 5) {
            0 => within_limit(move || keep_checksums(&change))??,
            1 => within_limit(move || hostile::run(&change, ChangedPart::Superblock))?,
            2 => within_limit(move || hostile::run(&change, ChangedPart::Directory))?,
            3 => within_limit(move || hostile::run(&change, ChangedPart::Compressed))?,
            _ => within_limit(move || hostile::run(&change, ChangedPart::Tile))?,
        }
    }
    Ok(vec![("changed files", CHANGES)])
}

/// Runs `work` on a thread of its own; a panic or a hang is an error.
fn within_limit<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> anyhow::Result<T> {
    let (done, result) = mpsc::channel();
    thread::Builder::new().spawn(move || {
        // The receiver may have stopped waiting.
        let _ = done.send(panic::catch_unwind(panic::AssertUnwindSafe(work)));
    })?;
    match result.recv_timeout(LIMIT) {
        Ok(Ok(done)) => Ok(done),
        Ok(Err(_)) => bail!("it panicked"),
        Err(_) => bail!("it hangs, or takes more than {} s", LIMIT.as_secs()),
    }
}

/// Changes bytes anywhere, and keeps the checksums.
fn keep_checksums(changes: &[u8]) -> anyhow::Result<()> {
    static RIGHT: OnceLock<Option<Digest>> = OnceLock::new();
    let mut bytes = hostile::town(false).bytes;
    let right = *RIGHT.get_or_init(|| digest(bytes.clone()));
    ensure!(right.is_some(), "the unchanged file cannot be read");
    for change in changes.chunks_exact(5) {
        let at = u32::from_le_bytes([change[0], change[1], change[2], 0]) as usize % bytes.len();
        bytes[at] ^= change[3].max(1);
    }
    let changed = digest(bytes);
    ensure!(changed.is_none() || changed == right, "the answer changed");
    Ok(())
}

/// Returns the digest of a file, or `None` if it cannot be read.
fn digest(bytes: Vec<u8>) -> Option<Digest> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .ok()?;
    runtime.block_on(async {
        let reader = TileReader::open_source(MemoryFile::new(bytes), "file", OpenOptions::default()).await;
        reader.ok()?.recompute_digest().await.ok()
    })
}
