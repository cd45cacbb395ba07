//! Threads that decode the pieces of a file.
//!
//! In: pieces, for instance the chunks of a LAZ file. Out: each piece decoded, in the order in which
//! they were put in. Nothing else depends on the number of threads.

use parking_lot::Mutex;
use std::cell::OnceCell;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::Builder;

/// The most threads. With more, the reader of the decoded pieces would be the slower part: an
/// estimate, measured with two threads.
const MOST_THREADS: usize = 4;

type Decode<P, D> = dyn Fn(P) -> D + Send + Sync;
/// A piece, and where to send it when it is decoded.
type Job<P, D> = (P, SyncSender<D>);

/// Threads that decode pieces of type `P` to `D`. They start with the first piece, and end when this
/// is dropped.
pub struct Decoders<P, D> {
    threads: usize,
    decode: Arc<Decode<P, D>>,
    /// Empty before the first piece; `None` if the system starts no thread.
    jobs: OnceCell<Option<Sender<Job<P, D>>>>,
    /// The pieces that were put in and not taken, in order.
    pending: VecDeque<Receiver<D>>,
}

impl<P: Send + 'static, D: Send + 'static> Decoders<P, D> {
    /// Creates the decoders; `threads` of them, at most four. `decode` must not panic.
    pub fn new(threads: usize, decode: impl Fn(P) -> D + Send + Sync + 'static) -> Self {
        Self {
            threads: threads.min(MOST_THREADS),
            decode: Arc::new(decode),
            jobs: OnceCell::new(),
            pending: VecDeque::new(),
        }
    }

    /// Returns whether there should be more pieces, so that each thread has one and another waits.
    pub fn want_more(&self) -> bool {
        self.pending.len() <= self.threads
    }

    /// Puts in a piece. If the system starts no thread, it is decoded at once.
    pub fn put(&mut self, piece: P) {
        let (send, receive) = sync_channel(1);
        self.pending.push_back(receive);
        match self.jobs.get_or_init(|| self.start()) {
            Some(jobs) => jobs
                .send((piece, send))
                .expect("a thread receives, as `decode` does not panic"),
            None => send.send((self.decode)(piece)).expect("the receiver is in `pending`"),
        }
    }

    /// Takes the next piece, and waits until it is decoded. Returns `None` if none was put in.
    pub fn take(&mut self) -> Option<D> {
        let next = self.pending.pop_front()?;
        Some(next.recv().expect("`decode` does not panic"))
    }

    /// Starts the threads. Returns where to send pieces; `None` if the system starts no thread.
    fn start(&self) -> Option<Sender<Job<P, D>>> {
        let (send, receive) = channel::<Job<P, D>>();
        let jobs = Arc::new(Mutex::new(receive));
        let mut started = None;
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
            // Not by `io`, which this room does not import: a refusal is no error here.
            if let Err(error) = Builder::new().name(format!("tile-decode-{number}")).spawn(work) {
                tracing::info!(%error, "could not start a decoding thread");
                break;
            }
            started = Some(send.clone());
        }
        started
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
