//! A line on its way: its intervals, some stretches at a time.

use futures::Stream;
use std::collections::VecDeque;

use super::envelope::{Arc, Span};
use super::interval::{AlongInterval, SiteAlong};
use super::line::{Line, Passed};
use super::search::{Candidates, Search, Stretch};
use crate::geometry::Point;
use crate::query::along::envelope;
use crate::query::free_space::Place;
use crate::query::request::{QueryError, QueryOptions, Tiles, representable, unfold};
use crate::store::TileReader;

/// Stretches that are taken together at most: a site near both ends of a group is searched from twice.
const GROUP: usize = 64;

/// A line on its way.
struct Along {
    search: Search,
    passed: Passed,
    /// Stretches to come, the next one last.
    open: Vec<Stretch>,
    /// How many to take together.
    group: usize,
    /// How far it came.
    end: f64,
    /// Intervals that are found. The last one may become longer, unless it is at the end of the line.
    found: VecDeque<AlongInterval>,
    failed: Option<QueryError>,
}

impl Along {
    async fn start(
        reader: &TileReader,
        from: Point,
        to: Point,
        k: usize,
        options: QueryOptions,
    ) -> Result<Self, QueryError> {
        let [from, to] = [from, to].map(|p| Point::new(representable(p.x), representable(p.y)).normalized());
        let mut tiles = Tiles::new(reader, &options);
        // Also tells whether they are points, and whether there are triangles.
        let start = Place::find(&mut tiles, from).await?;
        Place::find(&mut tiles, to).await?;
        let line = Line { from, to };
        let mut this = Self {
            search: Search::new(tiles, options, line, k),
            passed: Passed::default(),
            open: Vec::new(),
            group: 1,
            end: 0.0,
            found: VecDeque::new(),
            failed: None,
        };
        if from == to {
            let sites = match start.is_free {
                true => Some(this.search.at_a_point(start).await?),
                false => None,
            };
            this.push([0.0, 1.0], sites);
        } else {
            this.passed = this.search.pass().await?;
            this.open = this.passed.stretches().into_iter().rev().map(Stretch::whole).collect();
        }
        Ok(this)
    }

    /// The next interval.
    async fn next(&mut self) -> Result<Option<AlongInterval>, QueryError> {
        // One that may become longer is held back.
        while self.found.len() < 2 && self.end < 1.0 && self.failed.is_none() {
            if self.open.is_empty() {
                self.push([self.end, 1.0], None);
            } else if let Err(error) = self.take_group().await {
                self.failed = Some(error);
            }
        }
        match (self.found.pop_front(), self.failed.take()) {
            (Some(found), failed) => {
                self.failed = failed;
                Ok(Some(found))
            }
            (None, Some(error)) => Err(error),
            (None, None) => Ok(None),
        }
    }

    /// Finds the intervals of the next few stretches.
    async fn take_group(&mut self) -> Result<(), QueryError> {
        let mut candidates = Candidates::new();
        let mut taken: Vec<[f64; 2]> = Vec::new();
        let mut count = 0;
        while count < self.group
            && let Some(stretch) = self.open.pop()
        {
            if self.search.k > 0
                && !self
                    .search
                    .find_candidates(&self.passed, &stretch, &mut candidates)
                    .await?
            {
                let [first, second] = stretch.halves();
                self.open.extend([second, first]);
                continue;
            }
            count += 1;
            match taken.last_mut() {
                Some(last) if last[1] == stretch.range[0] => last[1] = stretch.range[1],
                _ => taken.push(stretch.range),
            }
        }
        self.group = (2 * self.group).min(GROUP);
        let (mut sites, mut arcs) = (Vec::new(), Vec::new());
        for candidate in candidates.into_values() {
            let (vertex, limit) = (candidate.vertex, candidate.limit);
            let own = self.search.arcs(&self.passed, vertex, limit, sites.len()).await?;
            for (number, id) in candidate.sites {
                let site = sites.len();
                arcs.extend(own.iter().map(|&arc| Arc { site, ..arc }));
                sites.push((number, id, vertex));
            }
        }
        let arcs = envelope::joined(arcs);
        let order: Vec<u64> = sites.iter().map(|&(number, ..)| number).collect();
        for range in taken {
            if self.end < range[0] {
                self.push([self.end, range[0]], None);
            }
            let spans = envelope::nearest(self.search.line, range, &arcs, self.search.k, &order);
            for Span { range, sites: near } in spans {
                let near = near.into_iter().map(|(site, distances)| {
                    let (number, id, vertex) = sites[site].clone();
                    SiteAlong {
                        number,
                        id,
                        vertex,
                        distances,
                    }
                });
                self.push(range, Some(near.collect()));
            }
        }
        Ok(())
    }

    /// Takes an interval that begins where the last one ends, or joins it with that.
    fn push(&mut self, [from_t, to_t]: [f64; 2], sites: Option<Vec<SiteAlong>>) {
        let line = self.search.line;
        self.end = to_t;
        if let (Some(last), Some(sites)) = (self.found.back_mut(), &sites)
            && let Some(before) = &mut last.sites
            && before
                .iter()
                .map(|site| site.number)
                .eq(sites.iter().map(|site| site.number))
        {
            for (before, site) in before.iter_mut().zip(sites) {
                before.distances[1] = site.distances[1];
            }
            (last.to_t, last.to) = (to_t, line.at(to_t));
            return;
        }
        self.found.push_back(AlongInterval {
            from_t,
            to_t,
            from: line.at(from_t),
            to: line.at(to_t),
            sites,
        });
    }
}

/// The nearest sites along a line.
impl TileReader {
    /// The `k` nearest sites by walking distance from each point of a straight line, as intervals of the line on which they,
    /// and their order, stay the same. The intervals come in order and cover the line; those in obstacles have no list.
    ///
    /// Within an interval the order is that of the distances; sites whose distances agree within a part in 10^12 come by their
    /// numbers. Where an interval ends, two distances are equal to within a part in 10^9, or something blocks the way along the line.
    /// A line of one point is one interval.
    ///
    /// The tiles that the line passes are read first, and the intervals come as they are found. The options' limits hold for all searches
    /// together; when they are reached, the intervals that came before stand, and the stream ends with
    /// [`QueryError::OutOfBudget`]: the last of them may then end early. Otherwise it ends as [`nearest_sites`](Self::nearest_sites).
    ///
    /// [Examples](crate::query#examples).
    pub fn nearest_along(
        &self,
        from: Point,
        to: Point,
        k: usize,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<AlongInterval, QueryError>> + Send + Unpin + 'static + use<> {
        let reader = self.clone();
        // What was not found can be anywhere.
        let anywhere = |error: QueryError| error.at_least(0.0);
        let start = async move { Along::start(&reader, from, to, k, options).await.map_err(anywhere) };
        unfold(start, move |mut along: Along| async move {
            let next = along.next().await.map_err(anywhere)?;
            Ok(next.map(|interval| (interval, along)))
        })
    }
}
