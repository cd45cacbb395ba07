//! Counts the reads that opening a file and reading a tile take, and the round trips among them.

use std::io;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

use bytes::Bytes;
use delaunay_tiles::io::{MemoryFile, ReadAt};
use delaunay_tiles::store::{OpenOptions, TileId, TileReader};
use futures::future::{BoxFuture, FutureExt};

use super::town;
use crate::support::runtime;

/// A file that counts its reads, as if on a distant server.
#[derive(Clone)]
struct Counted {
    file: MemoryFile,
    reads: Arc<AtomicUsize>,
    /// The length of the longest chain of reads, each of which began after the one before it was
    /// answered.
    round_trips: Arc<AtomicUsize>,
}

impl ReadAt for Counted {
    fn length(&self) -> u64 {
        self.file.length()
    }

    fn backend(&self) -> &'static str {
        "counted"
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        self.reads.fetch_add(1, SeqCst);
        let (read, round_trips) = (self.file.read_at(range), Arc::clone(&self.round_trips));
        let mine = round_trips.load(SeqCst) + 1;
        async move {
            // Reads that are requested together run together.
            tokio::task::yield_now().await;
            round_trips.fetch_max(mine, SeqCst);
            read.await
        }
        .boxed()
    }
}

#[test]
fn opening_takes_one_read_and_one_tile_three_in_two_round_trips() {
    let file = Counted {
        file: MemoryFile::new(town()),
        reads: Arc::default(),
        round_trips: Arc::default(),
    };
    let counts = || (file.reads.load(SeqCst), file.round_trips.load(SeqCst));
    runtime().block_on(async {
        let reader = TileReader::open_source(file.clone(), "town", OpenOptions::default())
            .await
            .unwrap();
        assert_eq!(counts(), (1, 1));
        reader.tile(TileId(5)).await.unwrap();
        assert_eq!(counts(), (4, 3));
        reader.tile(TileId(5)).await.unwrap();
        assert_eq!(counts(), (4, 3), "it is in the cache");
    });
}
