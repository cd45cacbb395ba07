//! Bytes of a small tile file are changed. With right checksums any answer and any error will do, but no panic, no hang and no
//! memory without bounds; with the checksums as they were, an answer must be the same as before.

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

use hostile::Place;

/// A file of a few hundred vertices takes a second; this is a hang.
const LIMIT: Duration = Duration::from_secs(60);
/// Changes of a round.
const CHANGES: u64 = 20;

/// Changes bytes, several times.
pub fn round(_: &Context, mut random: ChaCha8Rng) -> anyhow::Result<Counts> {
    let random = &mut random;
    for _ in 0..CHANGES {
        let count = 1 + below(random, 6);
        let change: Vec<u8> = (0..5 * count).map(|_| below(random, 256) as u8).collect();
        match below(random, 4) {
            0 => within_limit(move || keep_checksums(&change))??,
            1 => within_limit(move || hostile::run(&change, Place::Superblock))?,
            2 => within_limit(move || hostile::run(&change, Place::Directory))?,
            _ => within_limit(move || hostile::run(&change, Place::Tile))?,
        }
    }
    Ok(vec![("changed files", CHANGES)])
}

/// Runs something on a thread of its own; a panic and a hang are errors.
fn within_limit<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> anyhow::Result<T> {
    let (done, result) = mpsc::channel();
    thread::Builder::new().spawn(move || {
        // Nobody waits for what takes too long.
        let _ = done.send(panic::catch_unwind(panic::AssertUnwindSafe(work)));
    })?;
    match result.recv_timeout(LIMIT) {
        Ok(Ok(done)) => Ok(done),
        Ok(Err(_)) => bail!("it panicked"),
        Err(_) => bail!("it hangs, or takes more than {} s", LIMIT.as_secs()),
    }
}

/// Changes bytes anywhere, and leaves the checksums.
fn keep_checksums(changes: &[u8]) -> anyhow::Result<()> {
    static RIGHT: OnceLock<Option<Digest>> = OnceLock::new();
    let mut bytes = hostile::town().bytes;
    let right = *RIGHT.get_or_init(|| digest(bytes.clone()));
    ensure!(right.is_some(), "the file cannot be read as it is");
    for change in changes.chunks_exact(5) {
        let at = u32::from_le_bytes([change[0], change[1], change[2], 0]) as usize % bytes.len();
        bytes[at] ^= change[3].max(1);
    }
    let changed = digest(bytes);
    ensure!(changed.is_none() || changed == right, "an answer is another one");
    Ok(())
}

/// The digest of a file, if it can be read.
fn digest(bytes: Vec<u8>) -> Option<Digest> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .ok()?;
    runtime.block_on(async {
        let reader = TileReader::open_source(MemoryFile::new(bytes), "file", OpenOptions::default()).await;
        reader.ok()?.digest().await.ok()
    })
}
