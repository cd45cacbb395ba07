//! Vertices without z take it from the surface: the triangulation of the points alone. Vertices in
//! ponds take that of their pond.
//!
//! In: the file of that triangulation, and a block of points, ends of lines, crossing points and
//! sites. Out: the block, in which each vertex has a z. The z depends on the position alone, so it
//! is the same whatever the blocks.

use std::cmp::Ordering;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

use tokio::task::yield_now;

use crate::edit::EditError;
use crate::geometry::{MortonSquare, Point, Rect};
use crate::io::Backend;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::point_store::{Attributes, PointStore};
use crate::pipeline::options::Progress;
use crate::pipeline::records::Draped;
use crate::store::divide::Item;
use crate::store::{Cache, OpenOptions, ReadError, TileReader};
use crate::terrain::{Outline, Ponds};

/// Number of points after which other tasks get their turn.
const AT_ONCE: usize = 256;
/// Number of edges of shores up to which all are searched for each item.
const FEW_EDGES: usize = 64;
/// Number of items up to which the same ponds are searched for all of them.
const FEW_ITEMS: usize = 1 << 10;
/// Number of items after which other tasks get their turn.
const MOST_ITEMS: usize = 1 << 18;

/// The triangulation of the points of a build, from which other vertices take their z.
pub(crate) struct PointSurface {
    reader: TileReader,
    rules: Draping,
    progress: Arc<Progress>,
}

/// Which vertices take which z.
#[derive(Clone, Debug)]
pub(crate) struct Draping {
    /// First record number of vertices that may take their z from the surface, if they have none.
    /// `None` if none may.
    pub(crate) first_lacking: Option<u64>,
    /// First record number of vertices that are no points of the input.
    pub(crate) first_end: u64,
    pub(crate) outline: Outline,
    pub(crate) ponds: Ponds,
}

impl PointSurface {
    /// Opens the file of the triangulation. Tiles in memory may take about `memory` bytes.
    pub(crate) async fn open(
        path: &Path,
        rules: Draping,
        memory: u64,
        progress: Arc<Progress>,
    ) -> Result<Self, ReadError> {
        let cache = Cache::new(memory as usize);
        let options = OpenOptions::default().cache(&cache).backend(Backend::Threads);
        Ok(Self {
            reader: TileReader::open(path, options).await?,
            rules,
            progress,
        })
    }

    /// Gives their z to the vertices of a block that are in ponds, and to those that have none, other
    /// than points of the input. The order of the block's items changes. Returns the numbers of these
    /// vertices.
    pub(crate) async fn drape(&self, store: &mut PointStore) -> Result<Draped, BuildError> {
        let flattened = self.flatten(store).await?;
        let draped = match self.rules.first_lacking {
            Some(first) => self.drape_lacking(store, first).await?,
            None => Draped::default(),
        };
        Ok(Draped { flattened, ..draped })
    }

    /// Gives the z of their pond to the vertices of a block that are in ponds. Returns the number of
    /// those that are points of the input.
    async fn flatten(&self, store: &mut PointStore) -> Result<u64, BuildError> {
        let mut flattened = 0;
        if self.rules.ponds.is_empty() {
            return Ok(flattened);
        }
        let PointStore { items, attributes } = store;
        let bounds = |items: &[Item]| Rect::around(items.iter().map(|item| item.point));
        let near = self.rules.ponds.near(bounds(items));
        let mut parts = vec![(&mut items[..], near)];
        // A part with many ponds is halved, so that few of them are searched for each item.
        while let Some((items, ponds)) = parts.pop() {
            self.give_turn().await?;
            let most = if ponds.edge_count() > FEW_EDGES {
                FEW_ITEMS
            } else {
                MOST_ITEMS
            };
            if items.len() > most {
                let (left, right) = halves(items);
                for half in [left, right] {
                    let near = ponds.near(bounds(half));
                    parts.push((half, near));
                }
                continue;
            }
            for item in &*items {
                if let Some(z) = ponds.z_at(item.point) {
                    attributes.set_z(item.position, z);
                    let is_point = attributes.record(item.position) < self.rules.first_end;
                    flattened += u64::from(is_point);
                }
            }
        }
        Ok(flattened)
    }

    /// Lets other tasks go on.
    ///
    /// # Errors
    /// Fails if the build was cancelled.
    async fn give_turn(&self) -> Result<(), BuildError> {
        yield_now().await;
        match self.progress.is_cancelled() {
            true => Err(BuildError::Cancelled),
            false => Ok(()),
        }
    }

    /// Gives a z to each vertex of a block that has none and has at least this record number.
    async fn drape_lacking(&self, store: &mut PointStore, first: u64) -> Result<Draped, BuildError> {
        let mut draped = Draped::default();
        let lacking = Lacking::find(store, first);
        let PointStore { items, attributes } = store;
        let lacking_items = &items[..lacking.has_other.len()];
        let mut first = 0;
        for (number, group) in lacking_items
            .chunk_by(|a, b| ({ a.point }) == ({ b.point }))
            .enumerate()
        {
            if number % AT_ONCE == 0 {
                self.give_turn().await?;
            }
            if !lacking.has_other[first]
                && let Some(z) = self.z_at(group[0].point, &mut draped).await.map_err(EditError::Read)?
            {
                group.iter().for_each(|item| attributes.set_z(item.position, z));
                draped.vertices += 1;
            }
            first += group.len();
        }
        Ok(draped)
    }

    /// Returns the z at a point, or at the nearest point of the hull, and counts the latter. `None`
    /// if the surface is empty.
    async fn z_at(&self, point: Point, draped: &mut Draped) -> Result<Option<f64>, ReadError> {
        if let Some(z) = self.reader.z_at(point.x, point.y).await? {
            return Ok(Some(z));
        }
        draped.outside += 1;
        Ok(self.rules.outline.z_near(point))
    }

    /// Returns which vertices take which z.
    pub(crate) fn rules(&self) -> &Draping {
        &self.rules
    }

    /// Returns the ponds.
    pub(crate) fn ponds(&self) -> &Ponds {
        &self.rules.ponds
    }

    /// Returns the number of ponds.
    pub(crate) fn pond_count(&self) -> u64 {
        self.rules.ponds.count() as u64
    }
}

impl fmt::Debug for PointSurface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PointSurface")
            .field("ponds", &self.pond_count())
            .finish_non_exhaustive()
    }
}

/// Returns the two halves of items along the longer side of the rectangle around them.
fn halves(items: &mut [Item]) -> (&mut [Item], &mut [Item]) {
    let (width, height) = Rect::around(items.iter().map(|item| item.point)).size();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        let (a, b) = ({ a.point }, { b.point });
        match width > height {
            true => a.x.total_cmp(&b.x),
            false => a.y.total_cmp(&b.y),
        }
    });
    items.split_at_mut(middle)
}

/// The items of a block without z, which were moved to its front and sorted along a curve.
struct Lacking {
    /// For each of them: if it is the first one at its position, whether an item that determines
    /// the z is there too: one that has z, or a point of the input.
    has_other: Vec<bool>,
}

impl Lacking {
    fn find(store: &mut PointStore, first_end: u64) -> Self {
        let PointStore { items, attributes } = store;
        let lacks = |item: &Item| lacks_z(item, attributes, first_end);
        let mut count = 0;
        for index in 0..items.len() {
            if lacks(&items[index]) {
                items.swap(index, count);
                count += 1;
            }
        }
        let (lacking, others) = items.split_at_mut(count);
        let bounds = Rect::around(lacking.iter().map(|item| item.point));
        let square = MortonSquare::around(bounds);
        let order = |a: Point, b: Point| -> Ordering {
            let keys = square.key(a).cmp(&square.key(b));
            keys.then_with(|| a.lex_cmp(b))
        };
        lacking.sort_unstable_by(|a, b| order(a.point, b.point));
        let mut has_other = vec![false; count];
        for point in others.iter().map(|item| item.point).filter(|&p| bounds.contains(p)) {
            let first = lacking.partition_point(|item| order(item.point, point).is_lt());
            if lacking.get(first).is_some_and(|item| order(item.point, point).is_eq()) {
                has_other[first] = true;
            }
        }
        Self { has_other }
    }
}

/// Returns whether an item has no z and is not a point of the input.
fn lacks_z(item: &Item, attributes: &Attributes, first_end: u64) -> bool {
    attributes.z(item.position).is_nan() && attributes.record(item.position) >= first_end
}
