//! The lock by which a reader keeps edits from overwriting what it reads.
//!
//! An edit overwrites what neither the state in force refers to, nor any earlier one that somebody
//! reads. A reader locks the number of the generation that it finds in force. If that generation is
//! still in force after this, every later edit sees the lock. Where files cannot be locked, edits
//! overwrite nothing.

use crate::io::ReadAt;
use crate::store::format::limits::FIRST_EXTENT;
use crate::store::format::superblock::Superblock;
use futures::future::FutureExt;

/// Locks the generation of a file that is in force. Returns false if another one is in force by now:
/// then the file must be opened again. A file that cannot be locked, or is no tile file, is read
/// without a lock.
pub(super) fn lock_generation(source: &dyn ReadAt) -> impl Future<Output = bool> + Send {
    async move {
        let Some(superblock) = in_force(source).await else {
            return true;
        };
        if let Err(error) = source.lock_shared(superblock.generation) {
            tracing::debug!(%error, "cannot lock the state that is read");
            return true;
        }
        in_force(source).await == Some(superblock)
    }
    .boxed()
}

async fn in_force(source: &dyn ReadAt) -> Option<Superblock> {
    let head = source.read_at(0..FIRST_EXTENT.min(source.length())).await.ok()?;
    Superblock::choose(&head).ok().map(|in_force| in_force.superblock)
}
