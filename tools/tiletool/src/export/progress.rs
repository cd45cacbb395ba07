//! The progress of an export.

use indicatif::{ProgressBar, ProgressStyle};

use crate::progress;

/// Returns a progress bar that counts tiles, hidden unless bars are shown.
pub fn bar() -> ProgressBar {
    if !progress::are_shown() {
        return ProgressBar::hidden();
    }
    let style = "export   {wide_bar} {percent:>3}%  {eta} left";
    ProgressBar::new(0).with_style(ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()))
}
/// Returns a function that shows the number of tiles done on a bar.
pub fn shown_on(bar: &ProgressBar) -> impl FnMut(u64, u64) + Send {
    |done, total| {
        bar.set_length(total);
        bar.set_position(done);
    }
}
