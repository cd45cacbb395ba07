//! Brings results that threads finish in any order into the order of their numbers.

use std::collections::BTreeMap;

use parking_lot::{Condvar, Mutex};

/// Takes items by number from any thread and hands them on in order.
///
/// At most `window` items ahead of the next one are begun, so that few wait here.
pub(crate) struct Ordered<T, F> {
    state: Mutex<State<T, F>>,
    moved: Condvar,
    window: u32,
}

struct State<T, F> {
    next: u32,
    waiting: BTreeMap<u32, T>,
    sink: F,
    closed: bool,
}

/// Nobody takes the items any more.
#[derive(Debug)]
pub(crate) struct Closed;

impl<T, F: FnMut(u32, T) -> Result<(), Closed>> Ordered<T, F> {
    /// The first item has number `next`.
    pub(crate) fn new(next: u32, window: u32, sink: F) -> Self {
        Self {
            state: Mutex::new(State {
                next,
                waiting: BTreeMap::new(),
                sink,
                closed: false,
            }),
            moved: Condvar::new(),
            window,
        }
    }

    /// Waits until work on this number may begin. Numbers must be begun in order, so that the one that all wait for is
    /// always under way.
    pub(crate) fn begin(&self, number: u32) -> Result<(), Closed> {
        let mut state = self.state.lock();
        while !state.closed && number >= state.next + self.window {
            self.moved.wait(&mut state);
        }
        if state.closed { Err(Closed) } else { Ok(()) }
    }

    /// Hands in a result.
    pub(crate) fn put(&self, number: u32, item: T) -> Result<(), Closed> {
        let mut guard = self.state.lock();
        let state = &mut *guard;
        state.waiting.insert(number, item);
        while let Some(item) = state.waiting.remove(&state.next) {
            if (state.sink)(state.next, item).is_err() {
                state.closed = true;
            }
            state.next += 1;
        }
        self.moved.notify_all();
        if state.closed { Err(Closed) } else { Ok(()) }
    }

    /// Lets all who wait go.
    pub(crate) fn close(&self) {
        self.state.lock().closed = true;
        self.moved.notify_all();
    }
}
