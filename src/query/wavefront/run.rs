//! A wavefront and the tiles that drive it.

use std::sync::Arc;

use super::found::FoundTarget;
use super::goal::Goal;
use super::regions::VisibleRegion;
use super::state::Wavefront;
use super::step::WavefrontStep;
use crate::geometry::Point;
use crate::query::answer::{Distance, Path};
use crate::query::free_space::QueryPoint;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::query::route;
use crate::store::{Tile, TileReader};

/// The outcome of a search that may end before it finds a target.
pub(crate) enum Approach {
    Found(FoundTarget),
    /// Every target that was not found is at least this far away.
    AtLeast(f64),
}

/// A wavefront and the tiles that drive it.
pub(crate) struct WavefrontRun {
    pub(crate) tiles: Tiles,
    pub(crate) wavefront: Box<Wavefront>,
    pub(crate) tile: Arc<Tile>,
    source: QueryPoint,
    pub(crate) options: QueryOptions,
}

impl WavefrontRun {
    /// Starts a wavefront at a free point.
    pub(crate) async fn start(
        mut tiles: Tiles,
        source: QueryPoint,
        goal: Goal,
        limit: f64,
        options: QueryOptions,
    ) -> Result<Self, QueryError> {
        options.mode.check()?;
        let mut wavefront = Wavefront::new(&source, goal, limit, tiles.outside_is_free());
        if options.explored.is_some() {
            wavefront.keep_regions();
        }
        let tile = tiles.last().await?;
        Ok(Self {
            wavefront,
            tile,
            tiles,
            source,
            options,
        })
    }

    /// Starts a wavefront at `at`, which must be free.
    pub(crate) async fn from_point(
        reader: &TileReader,
        at: Point,
        goal: Goal,
        limit: f64,
        options: QueryOptions,
    ) -> Result<Self, QueryError> {
        let mut tiles = Tiles::new(reader, &options);
        let source = QueryPoint::find_free(&mut tiles, at).await?;
        Self::start(tiles, source, goal, limit, options).await
    }

    /// Returns the next target.
    pub(crate) async fn next(&mut self) -> Result<Option<FoundTarget>, QueryError> {
        loop {
            let found = self.advance().await?;
            self.wavefront.take_regions();
            if let Some(found) = found {
                return Ok(found);
            }
        }
    }

    /// Returns the next target, or `None` if the wavefront passes more than `most` triangles before
    /// it is found.
    pub(crate) async fn next_before(&mut self, most: u64) -> Result<Option<FoundTarget>, QueryError> {
        while self.wavefront.passed() <= most {
            let found = self.advance().await?;
            self.wavefront.take_regions();
            if let Some(found) = found {
                return Ok(found);
            }
        }
        Ok(None)
    }

    /// Takes a step. Returns the target that it found, or `Some(None)` if there are no more.
    async fn advance(&mut self) -> Result<Option<Option<FoundTarget>>, QueryError> {
        match self.step()? {
            WavefrontStep::Found(found) => return Ok(Some(Some(found))),
            WavefrontStep::Done => return Ok(Some(None)),
            step => {
                let went_on = self.go_on(step).await;
                went_on.map_err(|error| error.lower_bound(self.wavefront.front()))?;
            }
        }
        Ok(None)
    }

    /// Takes a step of the wavefront in the current tile.
    pub(crate) fn step(&mut self) -> Result<WavefrontStep, QueryError> {
        let step = self.wavefront.step(&self.tile);
        if let Some(explored) = &self.options.explored {
            explored.add(self.wavefront.explored());
        }
        self.tiles.checked(self.tile.id(), step)
    }

    /// Prepares the next step after one that found nothing.
    pub(crate) async fn go_on(&mut self, step: WavefrontStep) -> Result<(), QueryError> {
        if let WavefrontStep::Need(id) = step {
            if let Some(width) = self.tiles.width_of_lost(id) {
                // The front of the wavefront passes more tiles than the cache holds.
                self.wavefront.lead(width);
            }
            self.tiles.ask_ahead(id, || self.wavefront.ahead(id));
            self.tile = self.tiles.get(id).await?;
            return Ok(());
        }
        tokio::task::yield_now().await;
        self.tiles.check_time()
    }

    /// Makes the wavefront keep the regions that it sees.
    pub(crate) fn keep_regions(&mut self) {
        self.wavefront.keep_regions();
    }

    /// Returns the next regions that the wavefront sees, whatever it finds; `None` at the end.
    pub(crate) async fn next_regions(&mut self) -> Result<Option<Vec<VisibleRegion>>, QueryError> {
        let mut goes_on = true;
        loop {
            let regions = self.wavefront.take_regions();
            if !goes_on || !regions.is_empty() {
                return Ok((!regions.is_empty()).then_some(regions));
            }
            goes_on = self.go_further().await?;
        }
    }

    /// Takes a step, whatever it finds. Returns whether there are more.
    pub(crate) async fn go_further(&mut self) -> Result<bool, QueryError> {
        Ok(self.advance().await?.is_none_or(|found| found.is_some()))
    }

    /// Returns the position of a root, and the length of the path to it.
    pub(crate) fn root_at(&self, root: u32) -> (Point, f64) {
        self.wavefront.root_at(root)
    }

    /// Returns the path to a target.
    pub(crate) async fn path(&mut self, found: &FoundTarget, to: &QueryPoint) -> Result<Path, QueryError> {
        let mut way = self.wavefront.way(found.root);
        way.push((to.point, to.vertex()));
        let ends = [&self.source, to];
        let path = route::path(&mut self.tiles, &way, ends, found.length, self.options.certify).await;
        path.map_err(|error| error.lower_bound(found.length))
    }

    pub(crate) fn legs(&self, found: &FoundTarget) -> usize {
        self.wavefront.depth(found.root)
    }
}

impl WavefrontRun {
    /// Returns the next target, unless all remaining targets are known to be at least `enough` away
    /// before it is found, or there are none.
    pub(crate) async fn next_beyond(&mut self, enough: f64) -> Result<Approach, QueryError> {
        loop {
            let step = self.step()?;
            self.wavefront.take_regions();
            if let WavefrontStep::Found(found) = step {
                return Ok(Approach::Found(found));
            }
            let front = Distance::of_legs(self.wavefront.front(), self.wavefront.root_count() + 1).lower;
            if front >= enough {
                return Ok(Approach::AtLeast(front));
            }
            self.go_on(step).await.map_err(|error| error.lower_bound(front))?;
        }
    }
}
