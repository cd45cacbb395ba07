//! Bytes of answers that wait for their clients.

use std::sync::Arc;

use bytes::Bytes;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::problem::Problem;

/// The unit in which bytes are counted.
const UNIT: usize = 1 << 10;

/// The number of bytes that wait for clients.
pub struct Outgoing {
    free: Arc<Semaphore>,
    units: usize,
}

/// Bytes that are counted until the last clone of them is dropped.
struct Held {
    bytes: Bytes,
    _permit: OwnedSemaphorePermit,
}

impl AsRef<[u8]> for Held {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Room for bytes that are to be read.
pub struct Reserved(OwnedSemaphorePermit);

impl Reserved {
    /// Fills the room with bytes, which count until they are dropped.
    pub fn fill(self, bytes: Bytes) -> Bytes {
        Bytes::from_owner(Held { bytes, _permit: self.0 })
    }
}

impl Outgoing {
    /// Creates a limit in bytes.
    pub fn new(bytes: usize) -> Self {
        let units = (bytes / UNIT).clamp(1, u32::MAX as usize);
        Self {
            free: Arc::new(Semaphore::new(units)),
            units,
        }
    }

    /// Counts bytes until they are dropped. An answer that is larger than the limit must wait until no
    /// other is there.
    ///
    /// # Errors
    /// Fails if too many bytes wait.
    pub fn hold(&self, bytes: Bytes) -> Result<Bytes, Problem> {
        let units = bytes.len().div_ceil(UNIT).min(self.units);
        let permit = Arc::clone(&self.free).try_acquire_many_owned(units as u32);
        let permit = permit.map_err(|_| Problem::busy("too many answers wait to be read by their clients"))?;
        Ok(Reserved(permit).fill(bytes))
    }

    /// Waits until this many bytes may wait for a client.
    ///
    /// # Errors
    /// Never, because the limit is not closed.
    pub async fn reserve(&self, bytes: usize) -> std::io::Result<Reserved> {
        let units = bytes.div_ceil(UNIT).min(self.units);
        let permit = Arc::clone(&self.free).acquire_many_owned(units as u32).await;
        permit.map(Reserved).map_err(std::io::Error::other)
    }

    /// Returns the number of bytes that wait.
    pub fn bytes(&self) -> usize {
        (self.units - self.free.available_permits()) * UNIT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_count_until_their_last_clone_is_dropped() {
        let outgoing = Outgoing::new(4 * UNIT);
        let three = outgoing.hold(vec![7; 3 * UNIT].into()).unwrap();
        let clone = three.slice(5..6);
        assert!(outgoing.hold(vec![7; 2 * UNIT].into()).is_err());
        drop(three);
        assert_eq!(outgoing.bytes(), 3 * UNIT);
        drop(clone);
        assert!(outgoing.hold(vec![7; 99 * UNIT].into()).is_ok());
    }
}
