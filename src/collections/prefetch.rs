//! Hints to the processor.

/// Asks the processor to load an element that will soon be used, without waiting for it. Does
/// nothing if there is no such element.
#[inline]
#[allow(
    unsafe_code,
    reason = "a third of a search for a path of 33 km was the first reads of tasks, roots and hints"
)]
pub(crate) fn prefetch<T>(elements: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(element) = elements.get(index) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: A hint never faults, and changes nothing that a program can observe but time.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(element).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (elements, index);
}
