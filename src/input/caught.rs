//! Catching the panics of a decoder.
//!
//! The process's panic hook reports a panic before the panic can be caught, and the hook belongs to
//! the program, not to a library. A hook can therefore ask here whether a panic becomes an error.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static IS_CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Returns whether a reader catches a panic on this thread and turns it into an
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

/// Returns the result of `work`; `None` if it panics. After a panic, the state that `work` leaves
/// behind must not be used again.
#[cfg_attr(
    not(any(feature = "las", feature = "parquet")),
    allow(dead_code, reason = "only the decoders of LAZ and of Parquet panic")
)]
pub fn catch<T>(work: impl FnOnce() -> T) -> Option<T> {
    let before = IS_CAUGHT.replace(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    IS_CAUGHT.set(before);
    result.ok()
}
