//! A wave and its tiles.

use std::sync::Arc;

use super::found::Found;
use super::goal::Goal;
use super::parts::Part;
use super::step::Step;
use super::wave::Wave;
use crate::geometry::Point;
use crate::query::answer::{Distance, Path};
use crate::query::free_space::Place;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::query::route;
use crate::store::{Tile, TileReader};

/// What a wave comes to that need not arrive.
pub(crate) enum Approach {
    Found(Found),
    /// All that was not found has at least this length.
    Beyond(f64),
}

/// A wave and its tiles.
pub(crate) struct Run {
    pub(crate) tiles: Tiles,
    pub(crate) wave: Box<Wave>,
    pub(crate) tile: Arc<Tile>,
    source: Place,
    pub(crate) options: QueryOptions,
}

impl Run {
    /// Starts a wave at a free place.
    pub(crate) async fn start(
        mut tiles: Tiles,
        source: Place,
        goal: Goal,
        limit: f64,
        options: QueryOptions,
    ) -> Result<Self, QueryError> {
        options.mode.check()?;
        let mut wave = Wave::new(&source, goal, limit, tiles.outside_is_free());
        if options.explored.is_some() {
            wave.keep_parts();
        }
        let tile = tiles.last().await?;
        Ok(Self {
            wave,
            tile,
            tiles,
            source,
            options,
        })
    }

    /// Starts a wave at a point, which must be free.
    pub(crate) async fn from_point(
        reader: &TileReader,
        at: Point,
        goal: Goal,
        limit: f64,
        options: QueryOptions,
    ) -> Result<Self, QueryError> {
        let mut tiles = Tiles::new(reader, &options);
        let source = Place::find_free(&mut tiles, at).await?;
        Self::start(tiles, source, goal, limit, options).await
    }

    /// The next thing that is found.
    pub(crate) async fn next(&mut self) -> Result<Option<Found>, QueryError> {
        loop {
            let found = self.advance().await?;
            self.wave.take_parts();
            if let Some(found) = found {
                return Ok(found);
            }
        }
    }

    /// Takes a step: what it found, or that there is no more, if it came to either.
    async fn advance(&mut self) -> Result<Option<Option<Found>>, QueryError> {
        match self.step()? {
            Step::Found(found) => return Ok(Some(Some(found))),
            Step::Done => return Ok(Some(None)),
            step => {
                let went_on = self.go_on(step).await;
                went_on.map_err(|error| error.at_least(self.wave.front()))?;
            }
        }
        Ok(None)
    }

    /// A step of the wave in the tile at hand.
    pub(crate) fn step(&mut self) -> Result<Step, QueryError> {
        let step = self.wave.step(&self.tile);
        if let Some(explored) = &self.options.explored {
            explored.add(self.wave.parts().iter().filter_map(Part::triangle));
        }
        self.tiles.checked(self.tile.id(), step)
    }

    /// Makes ready for the step after one that found nothing.
    pub(crate) async fn go_on(&mut self, step: Step) -> Result<(), QueryError> {
        if let Step::Need(id) = step {
            if let Some(width) = self.tiles.width_of_lost(id) {
                // The front of the wave goes through more tiles than the cache holds.
                self.wave.lead(width);
            }
            self.tiles.ask_ahead(id, || self.wave.ahead(id));
            self.tile = self.tiles.get(id).await?;
            return Ok(());
        }
        tokio::task::yield_now().await;
        self.tiles.check_time()
    }

    /// Has the wave keep what it sees.
    pub(crate) fn keep_parts(&mut self) {
        self.wave.keep_parts();
    }

    /// What the wave sees next, some parts at a time, whatever it finds; none when it is over.
    pub(crate) async fn next_parts(&mut self) -> Result<Option<Vec<Part>>, QueryError> {
        let mut is_over = false;
        loop {
            let parts = self.wave.take_parts();
            if is_over || !parts.is_empty() {
                return Ok((!parts.is_empty()).then_some(parts));
            }
            is_over = self.advance().await?.is_some_and(|found| found.is_none());
        }
    }

    /// Where a root of the wave is, and how long the way to it is.
    pub(crate) fn root_at(&self, root: u32) -> (Point, f64) {
        self.wave.root_at(root)
    }

    /// The way to what was found.
    pub(crate) async fn path(&mut self, found: &Found, to: &Place) -> Result<Path, QueryError> {
        let mut way = self.wave.way(found.root);
        way.push((to.point, to.vertex()));
        let ends = [&self.source, to];
        let path = route::path(&mut self.tiles, &way, ends, found.length, self.options.certify).await;
        path.map_err(|error| error.at_least(found.length))
    }

    pub(crate) fn legs(&self, found: &Found) -> usize {
        self.wave.way(found.root).len()
    }
}

impl Run {
    /// The next thing that is found, unless all that was not is known to be at least so far away before that, or there is nothing.
    pub(crate) async fn next_beyond(&mut self, enough: f64) -> Result<Approach, QueryError> {
        loop {
            let step = self.step()?;
            self.wave.take_parts();
            if let Step::Found(found) = step {
                return Ok(Approach::Found(found));
            }
            let front = Distance::of_legs(self.wave.front(), self.wave.root_count() + 1).lower;
            if front >= enough {
                return Ok(Approach::Beyond(front));
            }
            self.go_on(step).await.map_err(|error| error.at_least(front))?;
        }
    }
}
