//! The promise: any number of tasks read through one cache and get right answers, when callers are
//! cancelled, when tiles are evicted, when the file is edited, and when it is replaced or removed
//! meanwhile.

#[path = "../support/mod.rs"]
mod support;

mod generations;
mod interleavings;
mod readers;

/// What `generation_lock.rs` imports.
mod io {
    pub use delaunay_tiles::io::ReadAt;
}

/// What `generation_lock.rs` imports, for the file of `generations`: superblocks are numbers.
mod store {
    pub mod format {
        pub mod limits {
            pub const FIRST_EXTENT: u64 = 16;
        }

        pub mod superblock {
            #[derive(Clone, Copy, Debug, PartialEq)]
            pub struct Superblock {
                pub generation: u64,
            }

            pub struct InForce {
                pub superblock: Superblock,
            }

            impl Superblock {
                pub fn choose(head: &[u8]) -> Result<InForce, ()> {
                    let (numbers, _) = head.as_chunks();
                    let generation = numbers
                        .iter()
                        .map(|&number| u64::from_le_bytes(number))
                        .max()
                        .ok_or(())?;
                    Ok(InForce {
                        superblock: Self { generation },
                    })
                }
            }
        }
    }
}
