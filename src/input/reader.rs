//! What the reader of a format does: the one thing that a source knows of it.

use super::InputError;
use super::sample::RandomAccess;
use super::sink::Sink;

/// What a format does.
pub(super) trait Reader: Send {
    /// Whether its points have z. Known from the start.
    fn has_z(&self) -> bool;

    /// The coordinate reference system, if the file has told it by now.
    fn crs(&self) -> Option<&str> {
        None
    }

    /// How many records are still to come, as far as the file's beginning and its size tell. A claim: nothing may be
    /// allocated by it.
    fn expected_points(&self) -> Option<u64> {
        None
    }

    /// How to read the records in any order, if the format allows it and the input is a regular file.
    fn random_access(&self) -> Option<RandomAccess> {
        None
    }

    /// Puts points into the sink until it is full (true) or the file is at its end (false).
    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError>;

    /// What a person should know, when the file is at its end.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}
