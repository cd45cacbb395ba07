//! The progress of an export.

use indicatif::ProgressBar;

/// Returns a function that shows the number of tiles done on a bar.
pub fn shown_on(bar: &ProgressBar) -> impl FnMut(u64, u64) + Send {
    |done, total| {
        bar.set_length(total);
        bar.set_position(done);
    }
}
