//! Sorts results that threads finish in any order by their numbers.

use std::collections::BTreeMap;

use parking_lot::{Condvar, Mutex};

/// Takes numbered items from any thread and passes them on in order.
///
/// An item may begin only if its number is less than `window` ahead of the next item to be passed
/// on, which bounds the number of waiting items.
pub(crate) struct Ordered<T, F> {
    state: Mutex<OrderedState<T, F>>,
    moved: Condvar,
    window: u32,
}

struct OrderedState<T, F> {
    next: u32,
    waiting: BTreeMap<u32, T>,
    sink: F,
    closed: bool,
}

/// The sink takes no more items.
#[derive(Debug)]
pub(crate) struct Closed;

impl<T, F: FnMut(u32, T) -> Result<(), Closed>> Ordered<T, F> {
    /// Creates a queue whose first item has number `next`.
    pub(crate) fn new(next: u32, window: u32, sink: F) -> Self {
        Self {
            state: Mutex::new(OrderedState {
                next,
                waiting: BTreeMap::new(),
                sink,
                closed: false,
            }),
            moved: Condvar::new(),
            window,
        }
    }

    /// Waits until work on `number` may begin. Numbers must be begun in order, so that the item
    /// that all others wait for is always in work.
    pub(crate) fn begin(&self, number: u32) -> Result<(), Closed> {
        let mut state = self.state.lock();
        while !state.closed && number >= state.next + self.window {
            self.moved.wait(&mut state);
        }
        if state.closed { Err(Closed) } else { Ok(()) }
    }

    /// Adds a result, and passes on all results that are next in order.
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

    /// Closes the queue and wakes all waiting threads.
    pub(crate) fn close(&self) {
        self.state.lock().closed = true;
        self.moved.notify_all();
    }
}
