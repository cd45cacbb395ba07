//! Requests that compute, and a bounded queue before them.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

use crate::problem::Problem;

/// Permission to compute, until it is dropped.
pub struct Slot(#[expect(dead_code, reason = "it is held")] OwnedSemaphorePermit);

/// Requests that compute.
pub struct Slots {
    free: Arc<Semaphore>,
    waiting: AtomicUsize,
    queue: usize,
    all: usize,
    patience: Duration,
}

/// A place in the queue.
struct Waiting<'a>(&'a AtomicUsize);

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Slots {
    /// Creates `all` slots, and a queue for them in which a request waits for at most `patience`.
    pub fn new(all: usize, queue: usize, patience: Duration) -> Self {
        let all = all.clamp(1, Semaphore::MAX_PERMITS);
        Self {
            free: Arc::new(Semaphore::new(all)),
            waiting: AtomicUsize::new(0),
            queue,
            all,
            patience,
        }
    }

    /// Waits for a slot.
    ///
    /// # Errors
    /// Fails at once if the queue is full.
    pub async fn enter(&self) -> Result<Slot, Problem> {
        if let Ok(permit) = Arc::clone(&self.free).try_acquire_owned() {
            return Ok(Slot(permit));
        }
        let before = self.waiting.fetch_add(1, Ordering::Relaxed);
        let _waiting = Waiting(&self.waiting);
        let busy = || Problem::busy("too many requests wait for their answers");
        if before >= self.queue {
            return Err(busy());
        }
        match timeout(self.patience, Arc::clone(&self.free).acquire_owned()).await {
            Ok(Ok(permit)) => Ok(Slot(permit)),
            _ => Err(busy()),
        }
    }

    /// Returns how many requests compute.
    pub fn running(&self) -> usize {
        self.all - self.free.available_permits()
    }

    /// Returns how many requests wait.
    pub fn waiting(&self) -> usize {
        self.waiting.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use futures::FutureExt;

    use super::*;

    #[tokio::test]
    async fn a_full_queue_refuses_at_once() {
        let slots = Slots::new(1, 1, Duration::from_secs(60));
        let slot = slots.enter().await.ok();
        assert!(slot.is_some());
        let mut waits = Box::pin(slots.enter());
        assert!(waits.as_mut().now_or_never().is_none());
        assert_eq!((slots.running(), slots.waiting()), (1, 1));
        assert!(slots.enter().await.is_err());
        drop(slot);
        assert!(waits.await.is_ok());
        assert_eq!((slots.running(), slots.waiting()), (0, 0));
    }

    #[tokio::test]
    async fn one_who_leaves_the_queue_makes_room() {
        let slots = Slots::new(1, 1, Duration::from_secs(60));
        let _slot = slots.enter().await.ok();
        assert!(Box::pin(slots.enter()).as_mut().now_or_never().is_none());
        assert_eq!(slots.waiting(), 0);
    }
}
