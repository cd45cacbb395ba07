//! What the plan of a build leaves for its tasks, besides runs of points: the settings, the tile
//! numbers of each block, and its segments.

use std::hash::{BuildHasher, RandomState};
use std::io;
use std::ops::Range;
use std::path::Path;
use std::time::SystemTime;

use crate::constraints::segment::Segment;
use crate::constraints::segments::blocks::BlockSegments;
use crate::input::MissingZ;
use crate::pipeline::error::BuildError;
use crate::pipeline::options::BuildOptions;
use crate::pipeline::plan::Block;
use crate::pipeline::resume::checked_file;
use crate::pipeline::resume::codec::{Stored, decoded, stored};
use crate::pipeline::work_folder::WorkFolder;
use crate::store::MAX_TILES;

const MAGIC: &[u8; 8] = b"dttask01";

/// The settings of a build that its tasks need, and the tile numbers of its blocks.
#[derive(Debug)]
pub(crate) struct SavedTasks {
    /// Distinguishes these tasks from all others.
    pub(super) id: u64,
    tile_vertices: usize,
    merge_vertices: usize,
    threads: usize,
    memory: u64,
    engine: String,
    duplicates: String,
    /// 0 to 2, in the order of [`MISSING_Z`].
    missing_z: u8,
    exterior_is_hole: bool,
    compress: bool,
    /// The first tile number of each block, and behind the last one.
    first_tiles: Vec<u32>,
}

stored! {
    SavedTasks {
        id, tile_vertices, merge_vertices, threads, memory, engine, duplicates, missing_z, exterior_is_hole, compress,
        first_tiles,
    }
}

const MISSING_Z: [MissingZ; 3] = [MissingZ::Drape, MissingZ::Error, MissingZ::Zero];

impl SavedTasks {
    /// Returns the settings of a build, with ranges of tile numbers for its blocks.
    pub(crate) fn of(options: &BuildOptions, blocks: &[Block]) -> Result<Self, BuildError> {
        let points = blocks.iter().map(|block| block.points);
        Ok(Self {
            // A random number, with the time.
            id: RandomState::new().hash_one(SystemTime::now()),
            tile_vertices: options.tile_vertices,
            merge_vertices: options.merge_vertices,
            threads: options.threads,
            memory: options.memory,
            engine: options.engine.to_string(),
            duplicates: options.duplicates.to_string(),
            missing_z: MISSING_Z
                .iter()
                .position(|&rule| rule == options.missing_z)
                .unwrap_or(0) as u8,
            exterior_is_hole: options.exterior_is_hole,
            compress: options.compress,
            first_tiles: first_tiles(points, options.tile_vertices as u64)?,
        })
    }

    /// Returns the settings as options; `None` if one of them is unknown.
    pub(crate) fn options(&self) -> Option<BuildOptions> {
        let options = BuildOptions::default()
            .tile_vertices(self.tile_vertices)
            .merge_vertices(self.merge_vertices)
            .threads(self.threads)
            .memory(self.memory)
            .engine(self.engine.parse().ok()?)
            .duplicates(self.duplicates.parse().ok()?)
            .missing_z(*MISSING_Z.get(usize::from(self.missing_z))?)
            .exterior_is_hole(self.exterior_is_hole)
            .compress(self.compress);
        options.check().is_ok().then_some(options)
    }

    /// Returns what distinguishes these tasks from all others.
    pub(crate) fn id(&self) -> u64 {
        self.id
    }

    /// Returns the tile numbers of each block.
    pub(crate) fn tiles(&self) -> Vec<Range<u32>> {
        self.first_tiles.windows(2).map(|ends| ends[0]..ends[1]).collect()
    }

    /// Reads the settings. Returns `None` if there are none, or if they are damaged.
    pub(crate) fn load(folder: &WorkFolder) -> io::Result<Option<Self>> {
        read(&folder.tasks())
    }

    /// Writes the segments of each block, then the settings.
    pub(crate) fn save(&self, folder: &WorkFolder, segments: &BlockSegments) -> io::Result<()> {
        for block in 0..self.first_tiles.len() as u32 - 1 {
            if segments.count(block) > 0 {
                write(&folder.segments_of(block), &segments.take(block)?)?;
            }
        }
        write(&folder.tasks(), self)
    }
}

/// Reads the segments of a block.
pub(crate) fn segments_of(folder: &WorkFolder, block: u32) -> io::Result<Vec<Segment>> {
    let path = folder.segments_of(block);
    match path.exists() {
        true => read(&path)?.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, "the segments are damaged")),
        false => Ok(Vec::new()),
    }
}

/// Returns the first tile number of each block with these numbers of points, and the end of the last
/// one. A block has as many tiles as its points fill, and more if points lie on the cuts, at the same
/// coordinate.
fn first_tiles(points: impl Iterator<Item = u64>, tile_vertices: u64) -> Result<Vec<u32>, BuildError> {
    let mut next = 0_u64;
    let ends = points.map(|points| {
        let full = points.div_ceil(tile_vertices);
        next += full + full / 8 + 8;
        u32::try_from(next).ok().filter(|&next| next <= MAX_TILES)
    });
    let all: Option<Vec<u32>> = std::iter::once(Some(0)).chain(ends).collect();
    all.ok_or(BuildError::TooManyTiles { max: MAX_TILES })
}

fn write(path: &Path, value: &impl Stored) -> io::Result<()> {
    let mut body = Vec::new();
    value.put(&mut body);
    checked_file::write(path, MAGIC, &body)
}

/// Reads a value. Returns `None` if there is none, or if it is damaged.
fn read<T: Stored>(path: &Path) -> io::Result<Option<T>> {
    Ok(checked_file::read(path, MAGIC)?.and_then(|body| decoded(&body)))
}
