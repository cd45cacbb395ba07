//! Panics of a decoder, caught.
//!
//! A panic is reported by the process's panic hook before anybody can catch it, and the hook is the
//! program's, not a library's. So this says to the hook whether the panic is one that becomes an
//! error.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static IS_CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Whether a panic on this thread is caught by a reader, and becomes an
/// [`InputError`](crate::input::InputError). For panic hooks, which need not report such a panic.
///
/// ```
/// let before = std::panic::take_hook();
/// std::panic::set_hook(Box::new(move |panic| {
///     if !delaunay_tiles::input::panic_is_caught() {
///         before(panic);
///     }
/// }));
/// ```
#[must_use]
pub fn panic_is_caught() -> bool {
    IS_CAUGHT.get()
}

/// What the work gives; `None` if it panics. What it leaves behind then must not be used again.
#[cfg_attr(not(feature = "las"), allow(dead_code, reason = "only the decoder of LAZ panics"))]
pub fn catch<T>(work: impl FnOnce() -> T) -> Option<T> {
    let before = IS_CAUGHT.replace(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    IS_CAUGHT.set(before);
    result.ok()
}
