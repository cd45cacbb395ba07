//! What an operation took.

use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// What an operation took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Took {
    pub(super) bytes: u64,
    pub(super) seconds: f64,
    /// Processor time of all threads.
    pub(super) cpu_seconds: f64,
}

impl Took {
    /// Bytes by the second, in units of 10⁹.
    pub(super) fn rate(&self) -> f64 {
        self.bytes as f64 / 1e9 / self.seconds
    }

    /// Bytes by the second of processor time, in units of 10⁹.
    pub(super) fn rate_per_core(&self) -> f64 {
        self.bytes as f64 / 1e9 / self.cpu_seconds
    }
}

/// A clock for wall and processors.
pub(super) struct Clock {
    wall: Instant,
    cpu: Duration,
}

impl Clock {
    pub(super) fn start() -> Self {
        Self {
            wall: Instant::now(),
            cpu: cpu_time(),
        }
    }

    pub(super) fn took(&self, bytes: u64) -> Took {
        Took {
            bytes,
            seconds: self.wall.elapsed().as_secs_f64(),
            cpu_seconds: (cpu_time() - self.cpu).as_secs_f64(),
        }
    }
}

/// Processor time of all threads of the process so far.
fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// The one in the middle, by a key; of an even number the lower of two. There must be one.
pub(super) fn median<T: Copy>(values: &[T], key: impl Fn(&T) -> f64) -> T {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| key(a).total_cmp(&key(b)));
    sorted[(sorted.len() - 1) / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_in_the_middle() {
        for (values, middle) in [(vec![3.0], 3.0), (vec![2.0, 1.0], 1.0), (vec![9.0, 1.0, 5.0], 5.0)] {
            assert_eq!(median(&values, |&v| v), middle);
        }
    }
}
