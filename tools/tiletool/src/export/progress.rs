//! The progress of an export.

use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressStyle};

/// Returns a progress bar that counts tiles, hidden if standard error is not a terminal.
pub fn bar(json: bool) -> ProgressBar {
    if json || !io::stderr().is_terminal() {
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
