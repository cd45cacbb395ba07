//! The errors of LAS files.

use crate::input::error::{InputError, Location};
use crate::input::watch::Watched;
use std::error::Error;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

/// A file of lidar points.
pub type FileReader = BufReader<Watched<Arc<File>>>;

const DAMAGED: &str = "the file is damaged";
pub const CUT_SHORT: &str = "the file is cut short, or its header is damaged";

/// What is wrong with the file; becomes an error once the path is known.
pub struct Problem {
    pub problem: String,
    pub hint: &'static str,
    pub source: Option<Box<dyn Error + Send + Sync>>,
}

impl Problem {
    pub fn damaged(problem: impl Into<String>) -> Self {
        Self {
            problem: problem.into(),
            hint: DAMAGED,
            source: None,
        }
    }

    pub fn cut_short(problem: impl Into<String>) -> Self {
        Self {
            hint: CUT_SHORT,
            ..Self::damaged(problem)
        }
    }

    pub fn caused_by(mut self, source: impl Error + Send + Sync + 'static) -> Self {
        self.source = Some(Box::new(source));
        self
    }

    pub fn at(self, path: &Path, location: Location) -> InputError {
        InputError::Malformed {
            path: path.to_owned(),
            location,
            problem: self.problem,
            hint: self.hint,
            source: self.source,
        }
    }
}

/// Returns a fixed-size field up to its first zero.
pub fn trimmed(field: &[u8]) -> &[u8] {
    field.split(|&b| b == 0).next().unwrap_or_default()
}
