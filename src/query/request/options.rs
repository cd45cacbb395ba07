//! What a query may use.

use std::str::FromStr;
use std::time::Duration;

use super::error::QueryError;
use super::explored::Explored;

/// How exact answers are to be. All have a lower and an upper bound, so that one can tell.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Mode {
    /// Exact, but for rounding.
    #[default]
    Exact,
    /// The upper bound is at most 1 + this times the lower one, but for rounding. Paths are [fast](Self::Fast) ones where the bounds of
    /// these are close enough; else the exact search goes on until they are. Streams of sites and of paths are exact.
    Within(f64),
    /// A short way along edges of the triangulation, pulled taut: its length is the value, and not less than the true one. The lower
    /// bound is the straight line, or, where the file says that it has no break lines, a length that all ways along edges have at least,
    /// divided by 2.42 (Bose and Keil 2006), if that is more. The way along edges is a shortest one to a site, and to a point at most 1/8
    /// longer than that.
    Fast,
}

impl FromStr for Mode {
    type Err = UnknownMode;

    fn from_str(text: &str) -> Result<Self, UnknownMode> {
        let tolerance = |text: &str| text.parse().ok().filter(|&tolerance| is_tolerance(tolerance));
        match (text, text.strip_prefix("within:")) {
            ("exact", _) => Ok(Self::Exact),
            ("fast", _) => Ok(Self::Fast),
            (_, Some(part)) => tolerance(part).map(Self::Within).ok_or(UnknownMode),
            _ => Err(UnknownMode),
        }
    }
}

/// A text names no mode.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a mode is exact, fast, or within: and a number that is not negative, as within:0.05")]
pub struct UnknownMode;

/// Whether bounds may differ by such a part.
pub(crate) fn is_tolerance(tolerance: f64) -> bool {
    tolerance >= 0.0 && tolerance.is_finite()
}

/// What a query may use, and what it gives back beside distances.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, Default)]
pub struct QueryOptions {
    pub(crate) max_tiles: Option<u64>,
    pub(crate) max_time: Option<Duration>,
    pub(crate) paths: bool,
    pub(crate) certify: bool,
    pub(crate) explored: Option<Explored>,
    pub(crate) mode: Mode,
}

impl QueryOptions {
    /// Lets the query ask for so many different tiles at most. It then ends with [`QueryError::OutOfBudget`].
    #[must_use]
    pub fn max_tiles(mut self, tiles: u64) -> Self {
        self.max_tiles = Some(tiles);
        self
    }

    /// Lets the query take so long at most. It then ends with [`QueryError::OutOfBudget`].
    #[must_use]
    pub fn max_time(mut self, time: Duration) -> Self {
        self.max_time = Some(time);
        self
    }

    /// Says how exact answers are to be.
    #[must_use]
    pub fn mode(mut self, mode: Mode) -> Self {
        self.mode = mode;
        self
    }

    /// Asks for the path to each site, and not just how long it is.
    #[must_use]
    pub fn paths(mut self) -> Self {
        self.paths = true;
        self
    }

    /// Has each path proved by a walk through the triangles that it passes, with exact predicates. Asks for paths.
    #[must_use]
    pub fn certified(mut self) -> Self {
        self.paths = true;
        self.certify = true;
        self
    }

    /// Has the triangles collected that the search goes through.
    #[must_use]
    pub fn explored(mut self, into: &Explored) -> Self {
        self.explored = Some(into.clone());
        self
    }
}

impl Mode {
    /// Fails if this asks for what cannot be.
    pub(crate) fn check(self) -> Result<Self, QueryError> {
        match self {
            Self::Within(tolerance) if !is_tolerance(tolerance) => Err(QueryError::NoTolerance { tolerance }),
            mode => Ok(mode),
        }
    }
}
