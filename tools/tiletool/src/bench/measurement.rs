//! Measurements of operations: bytes, time and processor time.

use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// The bytes, time and processor time of an operation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measurement {
    pub(super) bytes: u64,
    pub(super) seconds: f64,
    /// Processor time of all threads.
    pub(super) cpu_seconds: f64,
}

impl Measurement {
    /// Returns bytes per second, in units of 10⁹.
    pub(super) fn rate(&self) -> f64 {
        self.bytes as f64 / 1e9 / self.seconds
    }

    /// Returns bytes per second of processor time, in units of 10⁹.
    pub(super) fn rate_per_core(&self) -> f64 {
        self.bytes as f64 / 1e9 / self.cpu_seconds
    }
}

/// A clock of elapsed time and processor time.
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

    pub(super) fn measure(&self, bytes: u64) -> Measurement {
        Measurement {
            bytes,
            seconds: self.wall.elapsed().as_secs_f64(),
            cpu_seconds: (cpu_time() - self.cpu).as_secs_f64(),
        }
    }
}

/// Returns the processor time of all threads of the process so far.
fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Returns the middle value by `key`; of an even number of values, the lower of the two. `values`
/// must not be empty.
pub(super) fn median<T: Copy>(values: &[T], key: impl Fn(&T) -> f64) -> T {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| key(a).total_cmp(&key(b)));
    sorted[(sorted.len() - 1) / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_value() {
        for (values, middle) in [(vec![3.0], 3.0), (vec![2.0, 1.0], 1.0), (vec![9.0, 1.0, 5.0], 5.0)] {
            assert_eq!(median(&values, |&v| v), middle);
        }
    }
}
