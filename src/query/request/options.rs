//! The options of a query.

use std::str::FromStr;
use std::time::Duration;

use super::error::QueryError;
use super::explored::Explored;
use super::tiles_used::TilesUsed;

/// The accuracy of answers. All answers have a lower and an upper bound, so the accuracy reached is
/// known.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Mode {
    /// Exact except for rounding.
    #[default]
    Exact,
    /// The upper bound is at most 1 + this tolerance times the lower bound, except for rounding. A
    /// path is a [fast](Self::Fast) one if its bounds are close enough. Otherwise the exact search
    /// runs until they are. Streams of sites and of paths are exact.
    Within(f64),
    /// A short path along edges of the triangulation, shortened by the funnel algorithm. Its length
    /// is the value, and not less than the true distance. The lower bound is the straight line, or,
    /// if that is more and the file states that it has no break lines, a lower bound of all paths
    /// along edges, divided by 2.42 (Bose and Keil 2006). The path along edges to a site is a
    /// shortest one; to a point it is at most 1/8 longer. Sites within a radius are exact.
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

/// The error of parsing a text that names no mode.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a mode is exact, fast, or within: followed by a number that is not negative, such as within:0.05")]
pub struct UnknownMode;

/// Returns whether a number is a valid tolerance: finite and not negative.
pub(crate) fn is_tolerance(tolerance: f64) -> bool {
    tolerance >= 0.0 && tolerance.is_finite()
}

/// The limits of a query, and what it returns in addition to distances.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, Default)]
pub struct QueryOptions {
    pub(crate) max_tiles: Option<u64>,
    pub(crate) max_time: Option<Duration>,
    pub(crate) paths: bool,
    pub(crate) certify: bool,
    pub(crate) explored: Option<Explored>,
    pub(crate) tiles_used: Option<TilesUsed>,
    pub(crate) mode: Mode,
    pub(crate) first: Option<usize>,
    pub(crate) search: Search,
}

/// How the nearest sites are searched for. The answers are the same.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Search {
    /// The way that is expected to be faster: searches that aim if the number of sites is
    /// [given](QueryOptions::first) and sites are sparse, and otherwise one wavefront.
    #[default]
    Auto,
    /// One wavefront to all sites, nearest first.
    Wavefront,
    /// Searches that aim at groups of the sites that are nearest by Euclidean distance. This needs
    /// the [number of sites](QueryOptions::first).
    Aimed,
}

impl FromStr for Search {
    type Err = UnknownSearch;

    fn from_str(text: &str) -> Result<Self, UnknownSearch> {
        match text {
            "auto" => Ok(Self::Auto),
            "wavefront" => Ok(Self::Wavefront),
            "aimed" => Ok(Self::Aimed),
            _ => Err(UnknownSearch),
        }
    }
}

/// The error of parsing a text that names no way to search.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a search is auto, wavefront or aimed")]
pub struct UnknownSearch;

impl QueryOptions {
    /// Ends a stream of nearest sites after `count` sites. A query that knows the number can choose
    /// the faster [`Search`].
    #[must_use]
    pub fn first(mut self, count: usize) -> Self {
        self.first = Some(count);
        self
    }

    /// Chooses how the nearest sites are searched for.
    #[must_use]
    pub fn search(mut self, search: Search) -> Self {
        self.search = search;
        self
    }

    /// Limits the query to `tiles` different tiles. A query that needs more ends with
    /// [`QueryError::OutOfBudget`].
    #[must_use]
    pub fn max_tiles(mut self, tiles: u64) -> Self {
        self.max_tiles = Some(tiles);
        self
    }

    /// Limits the query to `time`. A query that takes longer ends with [`QueryError::OutOfBudget`].
    #[must_use]
    pub fn max_time(mut self, time: Duration) -> Self {
        self.max_time = Some(time);
        self
    }

    /// Sets the accuracy of answers.
    #[must_use]
    pub fn mode(mut self, mode: Mode) -> Self {
        self.mode = mode;
        self
    }

    /// Requests the path to each site, in addition to its length.
    #[must_use]
    pub fn paths(mut self) -> Self {
        self.paths = true;
        self
    }

    /// Proves each path by a walk through the triangles that it passes, with exact predicates.
    /// Implies [`paths`](Self::paths).
    #[must_use]
    pub fn certified(mut self) -> Self {
        self.paths = true;
        self.certify = true;
        self
    }

    /// Collects the triangles that the search passes.
    #[must_use]
    pub fn explored(mut self, into: &Explored) -> Self {
        self.explored = Some(into.clone());
        self
    }

    /// Counts the tiles that the query uses.
    #[must_use]
    pub fn tiles_used(mut self, into: &TilesUsed) -> Self {
        self.tiles_used = Some(into.clone());
        self
    }
}

impl Mode {
    /// Returns the mode, or an error if its tolerance is invalid.
    pub(crate) fn check(self) -> Result<Self, QueryError> {
        match self {
            Self::Within(tolerance) if !is_tolerance(tolerance) => Err(QueryError::NoTolerance { tolerance }),
            mode => Ok(mode),
        }
    }
}
