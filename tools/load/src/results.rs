//! What clients saw.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// What clients saw.
#[derive(Default)]
pub struct Results(Mutex<Seen>);

#[derive(Default)]
struct Seen {
    /// Counts by status; 0 is a connection that ended without an answer.
    statuses: BTreeMap<u16, u64>,
    /// Times of answers with the status 200, in microseconds.
    times: Vec<u64>,
    complaint: Option<String>,
    /// Answers of each state of the town, by version.
    versions: BTreeMap<String, u64>,
    /// Bodies by path and tag.
    bodies: BTreeMap<(String, String), Vec<u8>>,
}

impl Results {
    fn with<T>(&self, f: impl FnOnce(&mut Seen) -> T) -> T {
        f(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Counts an answer.
    pub fn count(&self, path: &str, status: u16, time: Duration) {
        self.with(|seen| {
            *seen.statuses.entry(status).or_default() += 1;
            if status == 200 {
                seen.times.push(time.as_micros() as u64);
            }
        });
        if status >= 500 && status != 503 {
            self.complain(format!("{path}: status {status}"));
        }
    }

    /// Counts an answer of a state.
    pub fn version(&self, version: &str) {
        self.with(|seen| *seen.versions.entry(version.to_owned()).or_default() += 1);
    }

    /// Checks that the answer to a path with this tag is always the same.
    pub fn same(&self, path: &str, tag: &str, body: &[u8]) {
        let key = (path.to_owned(), tag.to_owned());
        let is_same = self.with(|seen| seen.bodies.entry(key).or_insert_with(|| body.to_vec()) == body);
        if !is_same {
            self.complain(format!("{path}: two answers with the tag {tag}"));
        }
    }

    /// Says what is wrong. The first complaint stays.
    pub fn complain(&self, what: String) {
        self.with(|seen| _ = seen.complaint.get_or_insert(what));
    }

    /// Returns what is wrong.
    pub fn complaint(&self) -> Option<String> {
        self.with(|seen| match (&seen.complaint, seen.times.is_empty()) {
            (Some(complaint), _) => Some(complaint.clone()),
            (None, true) => Some("nothing was answered".to_owned()),
            (None, false) => None,
        })
    }

    /// Returns what there was, as text.
    pub fn report(&self, seconds: u64) -> String {
        self.with(|seen| {
            seen.times.sort_unstable();
            let all: u64 = seen.statuses.values().sum();
            let at = |share: f64| {
                let place = (share * seen.times.len() as f64) as usize;
                let time = seen.times.get(place.min(seen.times.len().saturating_sub(1)));
                time.map_or(f64::NAN, |time| *time as f64 / 1000.0)
            };
            let mut text = format!("{} answers a second:", all / seconds.max(1));
            for (status, count) in &seen.statuses {
                _ = write!(text, " {count} of {status}");
            }
            _ = write!(
                text,
                "\n200 within {:.1} ms (half), {:.1} ms (90 %), {:.1} ms (99 %), {:.1} ms (99.9 %)",
                at(0.5),
                at(0.9),
                at(0.99),
                at(0.999)
            );
            _ = write!(
                text,
                "\n{} states of the town, {} answers compared by tag",
                seen.versions.len(),
                seen.bodies.len()
            );
            text
        })
    }
}
