//! Why an archive was not written.

use std::fmt;
use std::io;

use pmtiles::PmtError;

use crate::map_archive::options::Zooms;
use crate::map_tiles::{DrawError, NoGrid, TileCoord};
use crate::store::ReadError;

/// The error of an archive that was not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ArchiveError {
    /// The file has no such layer, has no tiles in the grid, or cannot be read.
    #[error(transparent)]
    Source(#[from] DrawError),
    /// A map tile was not drawn.
    #[error("map tile {at}: {source}")]
    Draw {
        /// The number of the map tile.
        at: TileCoord,
        /// Why it was not.
        source: DrawError,
    },
    /// A map tile needs more tiles of the file than it may.
    #[error(
        "map tile {at} needs at least {needed} tiles of the file, but only {allowed} are allowed: store overviews in \
         the file, begin with zoom {first} (option `zooms`), or allow more (option `max_picture_tiles`)"
    )]
    OutOfBudget {
        /// The number of the map tile.
        at: TileCoord,
        /// The number of tiles needed is at least this.
        needed: u32,
        /// The number of tiles allowed.
        allowed: u32,
        /// A zoom from which on no map tile needs more.
        first: u8,
    },
    /// There are more map tiles than wanted.
    #[error("{0}")]
    TooMany(Box<TooMany>),
    /// The directory of the archive does not fit into its memory.
    #[error("the directory of {tiles} map tiles needs {needed} bytes of memory, but only {allowed} are allowed")]
    Memory {
        /// The number of map tiles.
        tiles: u64,
        /// The bytes needed.
        needed: u64,
        /// The bytes allowed.
        allowed: u64,
    },
    /// The first zoom that the layer proposes is deeper than any zoom of an archive.
    #[error(
        "the layer begins at a zoom deeper than {}, the deepest of an archive",
        Zooms::DEEPEST
    )]
    Deep,
    /// The file has nothing at these zooms.
    #[error("the file has nothing at the zooms {0}")]
    Nothing(Zooms),
    /// The output failed; [`source`](std::error::Error::source) has the reason.
    #[error("cannot write the archive")]
    Write(#[source] io::Error),
    /// The archive exceeds a limit of its format.
    #[error("{0}")]
    Limit(String),
}

impl ArchiveError {
    /// Returns the error of a map tile. `first` is a zoom from which on no map tile needs too much.
    pub(super) fn of_drawing(at: TileCoord, first: u8, source: DrawError) -> Self {
        match source {
            DrawError::OutOfBudget { needed, allowed } => Self::OutOfBudget {
                at,
                needed,
                allowed,
                // In Web Mercator, the zoom that the layer proposes may be one too early.
                first: first.max(at.z() + 1),
            },
            source => Self::Draw { at, source },
        }
    }
}

impl From<ReadError> for ArchiveError {
    fn from(error: ReadError) -> Self {
        Self::Source(error.into())
    }
}

impl From<NoGrid> for ArchiveError {
    fn from(error: NoGrid) -> Self {
        Self::Source(error.into())
    }
}

impl From<PmtError> for ArchiveError {
    fn from(error: PmtError) -> Self {
        match error {
            PmtError::Reading(error) => Self::Write(error),
            error => Self::Limit(error.to_string()),
        }
    }
}

/// More map tiles than wanted.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TooMany {
    /// The zooms.
    pub zooms: Zooms,
    /// About how many map tiles there are, or more.
    pub tiles: u64,
    /// About how many bytes they have, by those of some of them.
    pub bytes: u64,
    /// The number of map tiles that is allowed.
    pub allowed: u64,
    /// A last zoom with which there are probably not too many.
    pub fitting: Option<u8>,
}

impl fmt::Display for TooMany {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            zooms,
            tiles,
            bytes,
            allowed,
            fitting,
        } = self;
        let mebibytes = bytes.div_ceil(1 << 20);
        write!(
            f,
            "the zooms {zooms} have about {tiles} map tiles or more, with {mebibytes} MiB, but only {allowed} map tiles are \
             allowed; allow more (option `max_tiles`), or "
        )?;
        match fitting {
            Some(last) => write!(
                f,
                "write fewer zooms, such as {}..{last} (option `zooms`)",
                zooms.first()
            ),
            None => write!(f, "begin with an earlier zoom (option `zooms`)"),
        }
    }
}
