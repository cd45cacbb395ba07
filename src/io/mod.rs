//! Positional reads and writes: the traits, and their backends. This module handles bytes, not
//! tiles.
//!
//! The contract of both traits:
//!
//! - Offsets are 64 bits wide.
//! - A read returns all the requested bytes or an error, never fewer bytes. It allocates no memory
//!   for bytes that do not exist. An empty range reads nothing, at any offset.
//! - A successful write is visible to every later read of the same process, and is on the medium
//!   once [`WriteAt::sync`] has succeeded.
//! - Dropping a future abandons the answer, not the operation.
//! - Futures may be awaited in any runtime, or without one.
//!
//! One test suite checks this for all backends (`conformance`).

mod backend;
mod buffers;
#[cfg(test)]
mod conformance;
mod file;
mod file_lock;
mod memory;
#[cfg(not(feature = "object-store"))]
mod no_objects;
#[cfg(feature = "object-store")]
mod object;
mod open;
mod output_file;
mod parts;
mod pool;
mod range_lock;
mod regular;
mod section;
mod start;
mod threads;
#[cfg(target_os = "linux")]
mod uring;

pub use backend::{BACKEND_VARIABLE, Backend, UnknownBackend};
pub(crate) use buffers::Buffers;
pub(crate) use file::{FIRST_READ, HUGE_PAGE, memory_of};
pub use file::{ReadAt, WriteAt};
pub(crate) use file_lock::FileLock;
pub use memory::MemoryFile;
#[cfg(not(feature = "object-store"))]
pub(crate) use no_objects::Objects;
#[cfg(feature = "object-store")]
pub use object::ObjectFile;
#[cfg(feature = "object-store")]
pub(crate) use object::Objects;
pub use open::open;
pub use output_file::{OutputFile, output_target};
pub(crate) use output_file::{folder_of, is_named, new_output};
pub(crate) use parts::manifest::{FOLDER as PARTS_FOLDER, Manifest, Part, id_name, is_id_name, is_manifest};
#[cfg(feature = "object-store")]
pub(crate) use parts::{open_in, open_url};
pub(crate) use pool::{blocking, in_turn};
pub use regular::open_regular;
pub(crate) use section::Section;
pub(crate) use start::start_scoped;
pub use start::start_thread;
pub use threads::ThreadsFile;
#[cfg(target_os = "linux")]
pub use uring::UringFile;
