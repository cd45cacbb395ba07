//! The positions where an edit may need vertices, by tile.

use foldhash::{HashMap, HashMapExt};

use crate::edit::error::EditError;
use crate::edit::points::{PointCall, tile_at};
use crate::edit::sites::SiteCall;
use crate::edit::tiles::Tiles;
use crate::edit::work::Work;
use crate::geometry::Point;
use crate::store::TileId;

/// What an edit may change in the number of vertices of each tile.
pub(crate) struct Coming {
    /// The positions that may get a vertex, by tile, each once.
    pub(crate) positions: Vec<(TileId, Point)>,
    /// The number of positions whose vertices may go.
    pub(crate) leaving: HashMap<TileId, usize>,
}

impl Coming {
    pub(crate) fn of(tiles: &Tiles, work: &Work) -> Result<Self, EditError> {
        let mut this = Self {
            positions: Vec::new(),
            leaving: HashMap::new(),
        };
        for &call in &work.points.all {
            match call {
                PointCall::Insert(point, ..) => this.come(tiles, point)?,
                PointCall::Move([from, to]) => {
                    this.leave(tiles, from)?;
                    this.come(tiles, to)?;
                }
                PointCall::Delete(point) => this.leave(tiles, point)?,
                PointCall::SetZ(..) => {}
            }
        }
        for site in &work.sites.all {
            if let &SiteCall::Insert(point, ..) = site {
                this.come(tiles, point)?;
            }
        }
        let ends = work.segments.iter().map(|segment| segment.ends);
        for point in ends.filter(|[from, to]| from != to).flatten() {
            this.come(tiles, point)?;
        }
        let by_tile = |a: &(TileId, Point), b: &(TileId, Point)| a.0.cmp(&b.0).then_with(|| a.1.lex_cmp(b.1));
        this.positions.sort_unstable_by(by_tile);
        this.positions.dedup();
        Ok(this)
    }

    fn come(&mut self, tiles: &Tiles, point: Point) -> Result<(), EditError> {
        self.positions.push((tile_at(tiles, point)?, point));
        Ok(())
    }

    fn leave(&mut self, tiles: &Tiles, point: Point) -> Result<(), EditError> {
        *self.leaving.entry(tile_at(tiles, point)?).or_default() += 1;
        Ok(())
    }
}
