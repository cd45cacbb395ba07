//! What an archive contains.

use std::fmt;
use std::str::FromStr;

use crate::map_tiles::{DrawLimits, GridKind, Layer};

/// A range of zooms, both ends included.
///
/// ```
/// use delaunay_tiles::map_archive::Zooms;
///
/// let zooms: Zooms = "3..9".parse().unwrap();
/// assert_eq!((zooms.first(), zooms.last()), (3, 9));
/// assert_eq!("9".parse(), Ok(Zooms::new(9, 9).unwrap()));
/// assert!("9..3".parse::<Zooms>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Zooms {
    first: u8,
    last: u8,
}

/// The text is no range of zooms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownZooms {
    /// It is not one or two numbers.
    #[error("zooms are a range such as 0..14, or one number, from 0 to {}", Zooms::DEEPEST)]
    Text,
    /// The second number is less than the first.
    #[error("the first zoom, {first}, is greater than the last, {last}; give {last}..{first}")]
    Reversed {
        /// The first number.
        first: u8,
        /// The second number.
        last: u8,
    },
}

impl Zooms {
    /// The deepest zoom of an archive: numbers of deeper tiles are not exact in viewers, which are
    /// programs in JavaScript.
    pub const DEEPEST: u8 = 26;

    /// Returns a range. `None` if the first zoom is greater than the last, or the last greater than
    /// [`DEEPEST`](Self::DEEPEST).
    #[must_use]
    pub const fn new(first: u8, last: u8) -> Option<Self> {
        if first <= last && last <= Self::DEEPEST {
            Some(Self { first, last })
        } else {
            None
        }
    }

    /// Returns the first zoom.
    #[must_use]
    pub const fn first(self) -> u8 {
        self.first
    }

    /// Returns the last zoom.
    #[must_use]
    pub const fn last(self) -> u8 {
        self.last
    }
}

impl fmt::Display for Zooms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.first, self.last)
    }
}

impl FromStr for Zooms {
    type Err = UnknownZooms;

    fn from_str(text: &str) -> Result<Self, UnknownZooms> {
        let number = |text: &str| {
            let is_number = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
            let number = text.parse().ok().filter(|zoom| is_number && *zoom <= Self::DEEPEST);
            number.ok_or(UnknownZooms::Text)
        };
        let (first, last) = match text.split_once("..") {
            Some((first, last)) => (number(first)?, number(last)?),
            None => (number(text)?, number(text)?),
        };
        Self::new(first, last).ok_or(UnknownZooms::Reversed { first, last })
    }
}

/// What an archive contains, and what its making may take.
///
/// ```
/// use delaunay_tiles::map_archive::ArchiveOptions;
/// use delaunay_tiles::map_tiles::{GridKind, Layer};
///
/// let options = ArchiveOptions::new(GridKind::Native, Layer::Mesh).zooms("0..5".parse().ok());
/// # let _ = options;
/// ```
#[derive(Clone, Debug)]
pub struct ArchiveOptions {
    pub(super) grid: GridKind,
    pub(super) layer: Layer,
    pub(super) zooms: Option<Zooms>,
    pub(super) max_tiles: u64,
    pub(super) max_picture_tiles: u32,
    pub(super) directory_memory: u64,
    pub(super) at_once: usize,
    pub(super) name: String,
    pub(super) attribution: Option<String>,
}

impl ArchiveOptions {
    /// Creates the options for a layer in a grid: all zooms that
    /// [`MapSource::facts`](crate::map_tiles::MapSource::facts) proposes, up to a million map tiles.
    #[must_use]
    pub fn new(grid: GridKind, layer: Layer) -> Self {
        Self {
            grid,
            layer,
            zooms: None,
            max_tiles: 1_000_000,
            max_picture_tiles: 64,
            directory_memory: 256 << 20,
            at_once: 4,
            name: "map".to_owned(),
            attribution: None,
        }
    }

    /// Sets the zooms. `None`, the default, stands for those that the layer proposes.
    #[must_use]
    pub fn zooms(mut self, zooms: Option<Zooms>) -> Self {
        self.zooms = zooms;
        self
    }

    /// Sets the maximum number of map tiles; a million by default. More are an error before any is drawn.
    #[must_use]
    pub fn max_tiles(mut self, count: u64) -> Self {
        self.max_tiles = count;
        self
    }

    /// Sets the maximum number of tiles of the file that a map tile may be drawn from, as
    /// [`DrawLimits::max_tiles`](crate::map_tiles::DrawLimits::max_tiles); 64 by default.
    #[must_use]
    pub fn max_picture_tiles(mut self, count: u32) -> Self {
        self.max_picture_tiles = count;
        self
    }

    /// Sets the bytes of memory that the directory of the archive may take, of which it needs
    /// [some](super::ArchivePlan::DIRECTORY) for each map tile; 256 MiB by default.
    #[must_use]
    pub fn directory_memory(mut self, bytes: u64) -> Self {
        self.directory_memory = bytes;
        self
    }

    /// Sets the number of map tiles that are drawn at once; 4 by default.
    #[must_use]
    pub fn at_once(mut self, count: usize) -> Self {
        self.at_once = count.max(1);
        self
    }

    /// Sets the name that viewers show; `map` by default.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Sets whom the data are of, as viewers show it. `None` by default.
    #[must_use]
    pub fn attribution(mut self, attribution: Option<String>) -> Self {
        self.attribution = attribution;
        self
    }

    pub(super) fn limits(&self) -> DrawLimits {
        DrawLimits {
            max_tiles: self.max_picture_tiles,
            deadline: None,
        }
    }
}
