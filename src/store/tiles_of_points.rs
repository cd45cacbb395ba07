//! The tiles of many points.
//!
//! In: points. Out: for each tile whose cell contains some of them, the numbers of these points.
//! Threads look up the points in chunks. Parts of the k-d tree are read as points need them.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use futures::stream;
use futures::stream::{StreamExt, TryStreamExt};

use crate::collections::bucket_sort::bucket_sort;
use crate::geometry::Point;
use crate::store::error::ReadError;
use crate::store::format::ids::TileId;
use crate::store::format::page::Page;
use crate::store::format::page_list::PageList;
use crate::store::pages::Pages;
use crate::store::pass::spawn;
use crate::store::reader::TileReader;

/// The largest number of points that a thread looks up at once.
const CHUNK: usize = 1 << 16;
/// The number of lists or pages of the directory that are read at once.
const AT_ONCE: usize = 8;
/// So many lists or pages of the directory are read before any point is looked up.
const FEW: usize = 4;

/// The points in the cell of a tile.
#[derive(Debug)]
pub(crate) struct PointsOfTile {
    pub(crate) tile: TileId,
    /// None is empty, and none has more than 65,536 points.
    pub(crate) pieces: Vec<Piece>,
}

/// Some points in the cell of a tile.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// The points of a chunk, by tile: the tile in the upper half, the number of the point in the lower.
    chunk: Arc<Vec<u64>>,
    range: Range<usize>,
}

impl Piece {
    /// Returns how many points these are.
    pub(crate) fn len(&self) -> usize {
        self.range.len()
    }

    /// Returns the numbers of the points in ascending order.
    pub(crate) fn numbers(&self) -> impl ExactSizeIterator<Item = u32> {
        self.chunk[self.range.clone()].iter().map(|&pair| pair as u32)
    }
}

/// A part of the directory that is not in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Missing {
    List(u32),
    Page(u32),
    /// The tree leads to a part without cells, which valid files do not have.
    Nothing,
}

/// The parts of the directory that a search has read.
#[derive(Clone)]
struct PartsRead {
    pages: Arc<Pages>,
    lists: Vec<Option<Arc<PageList>>>,
    /// By number.
    of_lists: Vec<Option<Arc<Page>>>,
}

impl PartsRead {
    /// Returns the tile whose cell contains a point.
    fn tile_at(&self, p: Point) -> Result<TileId, Missing> {
        let list = self.pages.root.tree.leaf_at(p).ok_or(Missing::Nothing)?;
        let in_memory = self.lists.get(list as usize).and_then(Option::as_ref);
        let page = in_memory.ok_or(Missing::List(list))?.tree.leaf_at(p);
        let page = page.ok_or(Missing::Nothing)?;
        let in_memory = self.of_lists.get(page as usize).and_then(Option::as_ref);
        let tile = in_memory.ok_or(Missing::Page(page))?.tree.leaf_at(p);
        tile.ok_or(Missing::Nothing)
    }

    /// Returns the points of a chunk within the bounds of the file, in the order of their tiles. The
    /// error is what has to be read first.
    fn look_up(&self, points: &[Point], range: Range<usize>) -> Result<Vec<u64>, BTreeSet<Missing>> {
        let bounds = self.pages.root.metadata.bounds;
        let (mut found, mut missing) = (Vec::with_capacity(range.len()), BTreeSet::new());
        for (point, number) in points[range.clone()].iter().zip(range.start as u64..) {
            let point = point.representable();
            if !bounds.contains(point) {
                continue;
            }
            match self.tile_at(point) {
                Ok(tile) => found.push(u64::from(tile.0) << 32 | number),
                Err(part) => drop(missing.insert(part)),
            }
        }
        if !missing.is_empty() {
            return Err(missing);
        }
        let tiles = self.pages.root.next_tile as usize;
        Ok(bucket_sort(&found, tiles, |pair| (pair >> 32) as u32, |&pair| pair))
    }

    /// Reads parts of the directory.
    async fn read(&mut self, missing: impl IntoIterator<Item = Missing>) -> Result<(), ReadError> {
        let pages = &self.pages;
        let reads = stream::iter(missing).map(|part| async move {
            Ok(match part {
                Missing::List(list) => (part, Some(pages.page_list(list as usize).await?), None),
                Missing::Page(page) => (part, None, Some(pages.page(page).await?)),
                Missing::Nothing => (part, None, None),
            })
        });
        let read: Vec<_> = reads.buffered(AT_ONCE).try_collect().await?;
        for (part, list, page) in read {
            match part {
                Missing::List(number) if (number as usize) < self.lists.len() => self.lists[number as usize] = list,
                Missing::Page(number) if (number as usize) < self.of_lists.len() => {
                    self.of_lists[number as usize] = page;
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl TileReader {
    /// Returns the tiles whose cells contain points, in order, and which points these are. Points outside
    /// the box around all vertices are in none. `threads` threads compute.
    ///
    /// # Errors
    /// If a part of the directory cannot be read or is damaged.
    ///
    /// # Panics
    /// If there are more than 2³² points.
    pub(crate) async fn tiles_of_points(
        &self,
        points: &Arc<[Point]>,
        threads: usize,
    ) -> Result<Vec<PointsOfTile>, ReadError> {
        assert!(u32::try_from(points.len().saturating_sub(1)).is_ok(), "too many points");
        let mut parts = self.no_parts();
        self.read_if_few(&mut parts).await?;
        let size = points.len().div_ceil(threads.max(1)).clamp(1, CHUNK);
        let starts = (0..points.len()).step_by(size);
        let mut todo: Vec<_> = starts.map(|start| start..(start + size).min(points.len())).collect();
        let mut done = Vec::with_capacity(todo.len());
        while !todo.is_empty() {
            let known = Arc::new(parts.clone());
            let tasks = stream::iter(std::mem::take(&mut todo)).map(|range| {
                let (known, points) = (Arc::clone(&known), Arc::clone(points));
                spawn(move || (range.clone(), known.look_up(&points, range)))
            });
            let found: Vec<_> = tasks.buffered(threads.max(1)).try_collect().await?;
            let mut missing = BTreeSet::new();
            for (range, found) in found {
                match found {
                    Ok(chunk) => done.push(Arc::new(chunk)),
                    Err(parts) => {
                        missing.extend(parts);
                        todo.push(range);
                    }
                }
            }
            if missing.contains(&Missing::Nothing) {
                return Err(self.empty_part());
            }
            parts.read(missing).await?;
        }
        Ok(grouped(&done))
    }

    fn no_parts(&self) -> PartsRead {
        let root = &self.pages().root;
        PartsRead {
            pages: Arc::clone(self.pages()),
            lists: vec![None; root.page_lists.len()],
            of_lists: vec![None; root.pages as usize],
        }
    }

    /// Reads the whole tree if it has few parts, so that no point is looked up twice.
    async fn read_if_few(&self, parts: &mut PartsRead) -> Result<(), ReadError> {
        if parts.lists.len() <= FEW {
            parts.read((0..parts.lists.len() as u32).map(Missing::List)).await?;
        }
        if parts.of_lists.len() <= FEW {
            parts.read((0..parts.of_lists.len() as u32).map(Missing::Page)).await?;
        }
        Ok(())
    }
}

/// Groups the points of all chunks by tile.
fn grouped(chunks: &[Arc<Vec<u64>>]) -> Vec<PointsOfTile> {
    let mut pieces = Vec::new();
    for chunk in chunks {
        let mut end = 0;
        for group in chunk.chunk_by(|a, b| a >> 32 == b >> 32) {
            let range = end..end + group.len();
            end = range.end;
            let chunk = Arc::clone(chunk);
            pieces.push(((group[0] >> 32) as u32, Piece { chunk, range }));
        }
    }
    // A stable sort: the pieces of a tile stay in the order of the chunks.
    pieces.sort_by_key(|&(tile, _)| tile);
    let mut groups: Vec<PointsOfTile> = Vec::new();
    for (tile, piece) in pieces {
        match groups.last_mut() {
            Some(group) if group.tile.0 == tile => group.pieces.push(piece),
            _ => groups.push(PointsOfTile {
                tile: TileId(tile),
                pieces: vec![piece],
            }),
        }
    }
    groups
}
