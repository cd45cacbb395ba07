//! Progress bars. That of a build has the phase, share of the whole build, speed, elapsed time, and
//! about how much time is left. Bars are shown only on a terminal, and not if the tool is quiet.
//!
//! The time left is that of the whole build. Each phase has a typical share of it. The phases that
//! are over, and the current one as far as it went, say how much longer or shorter this build
//! takes.

use std::io::IsTerminal;
use std::ops::Deref;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use delaunay_tiles::input::Reading;
use delaunay_tiles::io::start_thread;
use delaunay_tiles::overviews::OverviewProgress;
use delaunay_tiles::{Phase, Progress};
use indicatif::{BinaryBytes, FormattedDuration, ProgressBar, ProgressStyle};

use crate::quiet;

/// The length of the bar.
const LENGTH: u64 = 1000;
/// The time between two looks at what is followed.
const INTERVAL: Duration = Duration::from_millis(100);
/// The share of a build that must be over before the time left is shown.
const LEAST_SHARE: f64 = 0.02;

/// A progress bar that follows a build, or the reading of a file, until it is dropped.
pub struct Bar {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// Returns the bytes of the input that were read so far, and the total if it is known.
pub type InputProgress = Arc<dyn Fn() -> (u64, Option<u64>) + Send + Sync>;

impl Bar {
    /// Shows a bar of a build on standard error, if that is a terminal.
    pub fn of_build(progress: Arc<Progress>, input: InputProgress) -> Self {
        Self::show(move |stop| follow(&progress, &input, stop))
    }

    /// Shows a bar of the reading of a file of this many bytes, if they are known, on standard error,
    /// if that is a terminal.
    pub fn of_reading(reading: Reading, total: Option<u64>) -> Self {
        Self::show(move |stop| follow_reading(&reading, total, stop))
    }

    /// Shows a bar of the overviews of a file on standard error, if that is a terminal.
    pub fn of_overviews(progress: Arc<OverviewProgress>) -> Self {
        Self::show(move |stop| follow_overviews(&progress, stop))
    }

    /// Shows how long `what` takes on standard error, from one second on, if that is a terminal.
    pub fn of_waiting(what: &'static str) -> Self {
        Self::show(move |stop| wait(what, stop))
    }

    fn show(follow: impl FnOnce(&AtomicBool) + Send + 'static) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let thread = are_shown().then(|| {
            let stop = Arc::clone(&stop);
            start_thread("progress", move || follow(&stop))
        });
        // Without a thread, no bar is shown.
        let thread = thread.and_then(Result::ok);
        Self { stop, thread }
    }
}

/// A bar that its owner moves, until it is dropped.
pub struct OwnBar(ProgressBar);

impl OwnBar {
    /// Shows a bar of this length on standard error, if bars are shown.
    pub fn new(length: u64, style: &str) -> Self {
        Self(match are_shown() {
            true => shown(ProgressBar::new(length), style),
            false => ProgressBar::hidden(),
        })
    }
}

impl Deref for OwnBar {
    type Target = ProgressBar;

    fn deref(&self) -> &ProgressBar {
        &self.0
    }
}

impl Drop for OwnBar {
    fn drop(&mut self) {
        remove(&self.0);
    }
}

/// The bar that is on the terminal.
static SHOWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Runs `print`, which prints lines to the terminal, while no bar is there.
pub fn apart<T>(print: impl FnOnce() -> T) -> T {
    let bar = SHOWN.lock().unwrap_or_else(PoisonError::into_inner).clone();
    match bar {
        Some(bar) => bar.suspend(print),
        None => print(),
    }
}

/// Puts a bar on the terminal.
fn shown(bar: ProgressBar, style: &str) -> ProgressBar {
    if let Ok(style) = ProgressStyle::with_template(style) {
        bar.set_style(style);
    }
    *SHOWN.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.clone());
    bar
}

/// Removes a bar from the terminal.
fn remove(bar: &ProgressBar) {
    *SHOWN.lock().unwrap_or_else(PoisonError::into_inner) = None;
    bar.finish_and_clear();
}

/// Returns whether bars are shown.
pub fn are_shown() -> bool {
    std::io::stderr().is_terminal() && !quiet::is_set()
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A failure of the bar does not fail the build.
            let _ = thread.join();
        }
    }
}

fn follow(progress: &Progress, input: &InputProgress, stop: &AtomicBool) {
    let bar = shown(ProgressBar::new(LENGTH), "{prefix:8} {wide_bar} {percent:>3}%  {msg}");
    let began = Instant::now();
    let (mut phase, mut phase_began) = (Phase::Read, began);
    let mut whole = WholeBuild::default();
    while !stop.load(Ordering::Relaxed) {
        let (now, done, total) = progress.state();
        if now != phase {
            (phase, phase_began) = (now, Instant::now());
        }
        let (done, total) = match now {
            // The beginnings of files are read twice, so more than the total may be read.
            Phase::Read => match input() {
                (done, Some(total)) => (done.min(total), Some(total)),
                unknown => unknown,
            },
            _ => (done, Some(total)),
        };
        let share = total.filter(|&total| total > 0).map(|total| done as f64 / total as f64);
        let elapsed = began.elapsed();
        let left = whole.left(now, share, elapsed);
        bar.set_position((whole.share * LENGTH as f64) as u64);
        bar.set_prefix(now.name());
        let rate = progress.points() as f64 / phase_began.elapsed().as_secs_f64().max(1e-3);
        let detail = match now {
            Phase::Read => format!("{} read, ", BinaryBytes(done)),
            Phase::Borders => format!("{done} of {} tiles, ", total.unwrap_or(0)),
            _ => String::new(),
        };
        bar.set_message(format!(
            "{detail}{:.2} M points/s  {}",
            rate / 1e6,
            times(elapsed, left)
        ));
        thread::park_timeout(INTERVAL);
    }
    remove(&bar);
}

fn follow_reading(reading: &Reading, total: Option<u64>, stop: &AtomicBool) {
    let style = "read {wide_bar} {percent:>3}%  {binary_bytes} of {binary_total_bytes}, {binary_bytes_per_sec}";
    let bar = shown(total.map_or_else(ProgressBar::no_length, ProgressBar::new), style);
    while !stop.load(Ordering::Relaxed) {
        // The beginning of a file is read twice.
        bar.set_position(total.unwrap_or(u64::MAX).min(reading.bytes()));
        thread::park_timeout(INTERVAL);
    }
    remove(&bar);
}

fn wait(what: &'static str, stop: &AtomicBool) {
    const PATIENCE: Duration = Duration::from_secs(1);
    let began = Instant::now();
    while began.elapsed() < PATIENCE {
        if stop.load(Ordering::Relaxed) {
            return;
        }
        thread::park_timeout(PATIENCE);
    }
    let bar = shown(
        ProgressBar::new_spinner().with_elapsed(began.elapsed()),
        "{spinner} {msg}  {elapsed}",
    );
    bar.set_message(what);
    while !stop.load(Ordering::Relaxed) {
        bar.tick();
        thread::park_timeout(INTERVAL);
    }
    remove(&bar);
}

fn follow_overviews(progress: &OverviewProgress, stop: &AtomicBool) {
    let style = "{prefix:8} {wide_bar} {pos:>6} of {len} tiles  {elapsed}";
    let bar = shown(ProgressBar::no_length(), style);
    while !stop.load(Ordering::Relaxed) {
        let (level, done, total) = progress.state();
        bar.set_prefix(match level {
            0 => "errors".to_owned(),
            level => format!("level {level}"),
        });
        bar.set_length(total);
        bar.set_position(done);
        thread::park_timeout(INTERVAL);
    }
    remove(&bar);
}

/// Formats the elapsed time and the time left.
fn times(elapsed: Duration, left: Option<Duration>) -> String {
    let seconds = |time: Duration| FormattedDuration(Duration::from_secs(time.as_secs_f64().round() as u64));
    match left {
        Some(left) => format!("{} elapsed, about {} left", seconds(elapsed), seconds(left)),
        None => format!("{} elapsed", seconds(elapsed)),
    }
}

/// Returns the typical share of a phase in the time of a build.
const fn weight(phase: Phase) -> f64 {
    match phase {
        Phase::Read => 0.25,
        Phase::Divide => 0.0,
        Phase::Conquer => 0.6,
        Phase::Borders => 0.12,
        // The last one.
        _ => 0.03,
    }
}

/// An estimate of how far a build is.
#[derive(Debug)]
struct WholeBuild {
    /// The share of the build that is over; never decreases.
    share: f64,
    phase: Phase,
    /// When the phase began, and the share of it that was over then: that of a resumed build.
    began: (Duration, f64),
}

impl Default for WholeBuild {
    fn default() -> Self {
        Self {
            share: 0.0,
            phase: Phase::Read,
            began: (Duration::ZERO, 0.0),
        }
    }
}

impl WholeBuild {
    /// Takes the phase, the share of it that is over (`None` if that is not known), and the time
    /// since the build began. Returns about how much time is left; `None` if that cannot be said
    /// yet.
    fn left(&mut self, phase: Phase, of_phase: Option<f64>, elapsed: Duration) -> Option<Duration> {
        let over = of_phase.unwrap_or(0.0).clamp(0.0, 1.0);
        if phase != self.phase {
            (self.phase, self.began) = (phase, (elapsed, over));
        }
        let earlier = Phase::ALL.into_iter().take_while(|&other| other != phase);
        let share = earlier.map(weight).sum::<f64>() + weight(phase) * over;
        self.share = self.share.max(share);
        // The time that a pipe takes says nothing about the other phases.
        if self.share < LEAST_SHARE || of_phase.is_none() && phase == Phase::Read {
            return None;
        }
        // The time of the whole build, by all phases so far and by the current one alone. The
        // further the current one is, the more it counts.
        let by_all = elapsed.as_secs_f64() / self.share;
        let (began, over_then) = self.began;
        let done = weight(phase) * (over - over_then);
        let by_phase = match done > 0.0 {
            true => (elapsed - began).as_secs_f64() / done,
            false => by_all,
        };
        let whole = by_all + (by_phase - by_all) * over;
        Some(Duration::from_secs_f64(whole * (1.0 - self.share)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(number: f64) -> Duration {
        Duration::from_secs_f64(number)
    }

    #[test]
    fn the_time_left_is_that_of_the_whole_build() {
        let mut whole = WholeBuild::default();
        assert_eq!(whole.left(Phase::Read, Some(0.0), seconds(1.0)), None, "too early");
        // A build whose phases take exactly their typical shares of 100 seconds.
        let mut began = 0.0;
        for phase in Phase::ALL.into_iter().filter(|&phase| weight(phase) > 0.0) {
            for of_phase in [0.0, 0.25, 0.5, 0.99] {
                let elapsed = 100.0 * (began + weight(phase) * of_phase);
                if let Some(left) = whole.left(phase, Some(of_phase), seconds(elapsed)) {
                    assert!((left.as_secs_f64() - (100.0 - elapsed)).abs() < 1e-6, "{phase:?}");
                }
            }
            began += weight(phase);
        }
        assert!((began - 1.0).abs() < 1e-9, "the shares of all phases are the whole");
        let before = whole.share;
        whole.left(Phase::Borders, Some(0.1), seconds(99.0));
        assert!(whole.share >= before, "the bar went back");
    }

    #[test]
    fn a_slow_pipe_does_not_spoil_the_estimate() {
        let mut whole = WholeBuild::default();
        assert_eq!(whole.left(Phase::Read, None, seconds(1000.0)), None);
        whole.left(Phase::Conquer, Some(0.0), seconds(1000.0));
        let left = whole.left(Phase::Conquer, Some(0.99), seconds(1060.0)).unwrap();
        assert!(left < seconds(60.0), "{left:?}");
    }

    #[test]
    fn a_resumed_build_does_not_count_the_work_of_the_interrupted_one() {
        let mut whole = WholeBuild::default();
        whole.left(Phase::Conquer, Some(0.8), seconds(0.0));
        let left = whole.left(Phase::Conquer, Some(0.9), seconds(60.0)).unwrap();
        assert!(left > seconds(60.0), "{left:?}");
    }

    #[test]
    fn times_are_labelled() {
        let left = Some(seconds(30.4));
        assert_eq!(times(seconds(9.6), left), "00:00:10 elapsed, about 00:00:30 left");
        assert_eq!(times(seconds(3700.0), None), "01:01:40 elapsed");
    }
}
