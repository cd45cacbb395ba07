//! The protocol by which readers keep edits from overwriting what they read, under the checker of
//! `interleavings`. `generation_lock.rs` is compiled a second time here, over a model of a file: two
//! superblocks, and a block of data for each generation. A reader may be interrupted at each read, an
//! edit before each write.

#[path = "../../src/store/generation_lock.rs"]
mod generation_lock;

use std::io;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard};

use bytes::Bytes;
use delaunay_tiles::io::ReadAt;
use futures::future::{BoxFuture, FutureExt};
use shuttle::future::{spawn, yield_now};

use self::generation_lock::lock_generation;
use crate::interleavings::explore;
use crate::store::format::superblock::Superblock;

const EDITS: u64 = 4;

/// The file, as everybody sees it.
struct Model {
    /// The superblocks.
    generations: [u64; 2],
    /// The block that has the data of each generation.
    places: Vec<usize>,
    /// The generation whose data each block has.
    blocks: Vec<u64>,
    /// The generations that readers have locked.
    locks: Vec<u64>,
    /// The number of blocks that were overwritten.
    reused: u64,
}

#[derive(Clone)]
struct File(Arc<Mutex<Model>>);

impl File {
    fn new() -> Self {
        Self(Arc::new(Mutex::new(Model {
            generations: [1, 0],
            places: vec![0, 0],
            blocks: vec![1],
            locks: Vec::new(),
            reused: 0,
        })))
    }

    fn model(&self) -> MutexGuard<'_, Model> {
        self.0.lock().unwrap()
    }

    /// Makes the next generation, as an edit does: it overwrites a block that the generation in force
    /// does not use if nobody has locked an earlier one.
    async fn edit(&self) {
        let (in_force, place) = {
            let model = self.model();
            let in_force = model.generations[0].max(model.generations[1]);
            let used = model.places[in_force as usize];
            let is_locked = model.locks.iter().any(|&locked| locked < in_force);
            let free = (0..model.blocks.len()).find(|&block| block != used && !is_locked);
            (in_force, free.unwrap_or(model.blocks.len()))
        };
        yield_now().await;
        {
            let mut model = self.model();
            match model.blocks.get_mut(place) {
                Some(block) => {
                    *block = in_force + 1;
                    model.reused += 1;
                }
                None => model.blocks.push(in_force + 1),
            }
            model.places.push(place);
        }
        yield_now().await;
        let mut model = self.model();
        let older = usize::from(model.generations[1] < model.generations[0]);
        model.generations[older] = in_force + 1;
    }
}

/// A file that a reader has open.
struct Opened {
    file: File,
    locked: Mutex<Vec<u64>>,
}

impl Opened {
    fn new(file: &File) -> Self {
        Self {
            file: file.clone(),
            locked: Mutex::default(),
        }
    }

    /// Returns the generation in force.
    async fn generation(&self) -> u64 {
        let head = self.read_at(0..16).await.unwrap();
        Superblock::choose(&head).unwrap().superblock.generation
    }

    /// Reads the data of a generation. Fails if they were overwritten.
    async fn read(&self, generation: u64) {
        yield_now().await;
        let place = self.file.model().places[generation as usize];
        yield_now().await;
        let found = self.file.model().blocks[place];
        assert_eq!(found, generation, "the data of a reader were overwritten");
    }
}

impl ReadAt for Opened {
    fn length(&self) -> u64 {
        16
    }

    fn backend(&self) -> &'static str {
        "model"
    }

    /// Reads both superblocks, one after the other.
    fn read_at(&self, _: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        let file = self.file.clone();
        async move {
            let first = file.model().generations[0];
            yield_now().await;
            let second = file.model().generations[1];
            yield_now().await;
            Ok(Bytes::from([first.to_le_bytes(), second.to_le_bytes()].concat()))
        }
        .boxed()
    }

    fn lock_shared(&self, number: u64) -> io::Result<()> {
        self.file.model().locks.push(number);
        self.locked.lock().unwrap().push(number);
        Ok(())
    }
}

impl Drop for Opened {
    fn drop(&mut self) {
        let mut model = self.file.model();
        for number in self.locked.lock().unwrap().drain(..) {
            let place = model.locks.iter().position(|&locked| locked == number).unwrap();
            model.locks.swap_remove(place);
        }
    }
}

/// Reads a file while it is edited. `open` returns the generation to read, if the reader need not start
/// again.
fn read_during_edits<F: Future<Output = Option<u64>> + Send>(
    schedules: usize,
    open: impl Fn(Arc<Opened>) -> F + Copy + Send + Sync + 'static,
) {
    let reused = Arc::new(Mutex::new(0));
    let count = Arc::clone(&reused);
    explore(schedules, move || {
        let count = Arc::clone(&count);
        async move {
            let file = File::new();
            let readers: Vec<_> = (0..2)
                .map(|_| {
                    let file = file.clone();
                    spawn(async move {
                        loop {
                            let opened = Arc::new(Opened::new(&file));
                            if let Some(generation) = open(Arc::clone(&opened)).await {
                                break opened.read(generation).await;
                            }
                        }
                    })
                })
                .collect();
            for _ in 0..EDITS {
                file.edit().await;
            }
            for reader in readers {
                reader.await.unwrap();
            }
            *count.lock().unwrap() += file.model().reused;
        }
    });
    assert!(*reused.lock().unwrap() > 100, "hardly any block was overwritten");
}

#[test]
fn edits_never_overwrite_what_a_reader_reads() {
    read_during_edits(4000, |opened| async move {
        match lock_generation(&*opened).await {
            true => Some(opened.generation().await),
            false => None,
        }
    });
}

/// The checker finds what the protocol prevents.
#[test]
#[should_panic(expected = "the data of a reader were overwritten")]
fn a_reader_that_does_not_look_again_after_it_locked_is_found() {
    read_during_edits(4000, |opened| async move {
        let generation = opened.generation().await;
        opened.lock_shared(generation).unwrap();
        Some(generation)
    });
}
