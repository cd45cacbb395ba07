//! Threads that decode the pieces of a file.
//!
//! In: pieces, for instance the chunks of a LAZ file. Out: each piece decoded, in the order in which
//! they were put in. Nothing else depends on the number of threads.

use crate::io::start_thread;
use parking_lot::Mutex;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};

/// The number of threads beyond which the reader of the decoded pieces is the slower part.
const MOST_THREADS: usize = 4;

type Decode<P, D> = dyn Fn(P) -> D + Send + Sync;
/// A piece, and where to send it when it is decoded.
type Job<P, D> = (P, SyncSender<D>);

/// Threads that decode pieces of type `P` to `D`. They start with the first piece, and end when this
/// is dropped.
pub struct Decoders<P, D> {
    threads: usize,
    decode: Arc<Decode<P, D>>,
    /// `None` before the first piece, and if the system starts no thread.
    jobs: Option<Sender<Job<P, D>>>,
    is_started: bool,
    /// The pieces that were put in and not taken, in order.
    pending: VecDeque<Receiver<D>>,
}

impl<P: Send + 'static, D: Send + 'static> Decoders<P, D> {
    /// Creates the decoders; `threads` of them, but not more than are of use. `decode` must not
    /// panic.
    pub fn new(threads: usize, decode: impl Fn(P) -> D + Send + Sync + 'static) -> Self {
        Self {
            threads: threads.min(MOST_THREADS),
            decode: Arc::new(decode),
            jobs: None,
            is_started: false,
            pending: VecDeque::new(),
        }
    }

    /// Returns whether there should be more pieces, so that each thread has one and another waits.
    pub fn want_more(&self) -> bool {
        self.pending.len() <= self.threads
    }

    /// Puts in a piece. If the system starts no thread, it is decoded at once.
    pub fn put(&mut self, piece: P) {
        if !self.is_started {
            self.is_started = true;
            self.start();
        }
        let (send, receive) = sync_channel(1);
        self.pending.push_back(receive);
        let unsent = match &self.jobs {
            Some(jobs) => jobs.send((piece, send)).err().map(|error| error.0),
            None => Some((piece, send)),
        };
        if let Some((piece, send)) = unsent {
            // The receiver is in `pending`.
            let _ = send.send((self.decode)(piece));
        }
    }

    /// Takes the next piece, and waits until it is decoded. Returns `None` if none was put in.
    pub fn take(&mut self) -> Option<D> {
        let next = self.pending.pop_front()?;
        Some(next.recv().expect("`decode` does not panic"))
    }

    fn start(&mut self) {
        let (send, receive) = channel::<Job<P, D>>();
        let jobs = Arc::new(Mutex::new(receive));
        for number in 0..self.threads {
            let (jobs, decode) = (Arc::clone(&jobs), Arc::clone(&self.decode));
            let work = move || {
                loop {
                    let job = jobs.lock().recv();
                    let Ok((piece, send)) = job else { return };
                    // Nobody receives it if the reading has ended.
                    let _ = send.send(decode(piece));
                }
            };
            if let Err(error) = start_thread(&format!("tile-decode-{number}"), work) {
                tracing::warn!(%error, "could not start a decoding thread");
                break;
            }
            self.jobs = Some(send.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn pieces_come_out_in_order_whatever_the_number_of_threads() {
        for threads in [0, 1, 2, 9] {
            let mut decoders = Decoders::new(threads, |n: u64| {
                std::thread::sleep(Duration::from_micros(n * 7919 % 500));
                n * n
            });
            let mut put = 0..100;
            let mut taken = Vec::new();
            loop {
                while decoders.want_more() {
                    let Some(n) = put.next() else { break };
                    decoders.put(n);
                }
                let Some(square) = decoders.take() else { break };
                taken.push(square);
            }
            assert_eq!(
                taken,
                (0..100).map(|n| n * n).collect::<Vec<u64>>(),
                "{threads} threads"
            );
        }
    }
}
