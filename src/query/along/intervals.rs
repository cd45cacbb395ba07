//! The stream of intervals along a line, computed in groups.

use futures::Stream;
use std::collections::VecDeque;

use super::envelope::{Arc, Span};
use super::interval::{AlongInterval, SiteAlong};
use super::line::{LineSections, QueryLine};
use super::search::{Candidates, FreeInterval, LineSearch};
use crate::geometry::Point;
use crate::query::along::envelope;
use crate::query::free_space::QueryPoint;
use crate::query::request::{QueryError, QueryOptions, Tiles, unfold};
use crate::store::TileReader;

/// The maximum number of free intervals that are processed together. A site near both ends of a
/// group is searched from twice.
const GROUP: usize = 64;

/// The state of a query along a line.
struct LineQuery {
    search: LineSearch,
    sections: LineSections,
    /// Free intervals still to be processed, the next one last.
    open: Vec<FreeInterval>,
    /// The number of free intervals to process together.
    group: usize,
    /// The position up to which the line is processed.
    end: f64,
    /// Intervals that are found. The last one may become longer, unless it ends at the end of the
    /// line.
    found: VecDeque<AlongInterval>,
    failed: Option<QueryError>,
}

impl LineQuery {
    async fn start(
        reader: &TileReader,
        from: Point,
        to: Point,
        k: usize,
        options: QueryOptions,
    ) -> Result<Self, QueryError> {
        let [from, to] = [from, to].map(Point::representable);
        let mut tiles = Tiles::new(reader, &options);
        // Also fails if a point is invalid or there are no triangles.
        let start = QueryPoint::find(&mut tiles, from).await?;
        QueryPoint::find(&mut tiles, to).await?;
        let line = QueryLine { from, to };
        let mut this = Self {
            search: LineSearch::new(tiles, options, line, k),
            sections: LineSections::default(),
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
            this.sections = this.search.pass().await?;
            this.open = this
                .sections
                .free_intervals()
                .into_iter()
                .rev()
                .map(FreeInterval::whole)
                .collect();
        }
        Ok(this)
    }

    /// Returns the next interval.
    async fn next(&mut self) -> Result<Option<AlongInterval>, QueryError> {
        // An interval that may become longer is held back.
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

    /// Finds the intervals of the next group of free intervals.
    async fn take_group(&mut self) -> Result<(), QueryError> {
        let mut candidates = Candidates::new();
        let mut taken: Vec<[f64; 2]> = Vec::new();
        let mut count = 0;
        while count < self.group
            && let Some(interval) = self.open.pop()
        {
            if self.search.k > 0
                && !self
                    .search
                    .find_candidates(&self.sections, &interval, &mut candidates)
                    .await?
            {
                let [first, second] = interval.halves();
                self.open.extend([second, first]);
                continue;
            }
            count += 1;
            match taken.last_mut() {
                Some(last) if last[1] == interval.range[0] => last[1] = interval.range[1],
                _ => taken.push(interval.range),
            }
        }
        self.group = (2 * self.group).min(GROUP);
        let (mut sites, mut arcs) = (Vec::new(), Vec::new());
        for candidate in candidates.into_values() {
            let (vertex, limit) = (candidate.vertex, candidate.limit);
            let own = self.search.arcs(&self.sections, vertex, limit, sites.len()).await?;
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

    /// Appends an interval that starts where the last one ends, or joins it with the last one.
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
    /// Returns the `k` nearest sites by walking distance from each point of the segment from `from`
    /// to `to`, as intervals on which the sites and their order stay the same. The intervals come
    /// in order and cover the segment; those in obstacles have no list.
    ///
    /// Within an interval the sites are ordered by distance. Sites whose distances differ by at
    /// most one part in 10^12 are ordered by their numbers. Where an interval ends, two distances
    /// are equal to within one part in 10^9, or something blocks the way along the line. A segment
    /// of one point is one interval.
    ///
    /// The tiles along the segment are read first, and the intervals come as they are found. The
    /// options' limits hold for all searches together. If a limit is reached, the intervals that
    /// came before are correct, and the stream ends with [`QueryError::OutOfBudget`]; the last
    /// interval may then end early. Otherwise the stream ends as
    /// [`nearest_sites`](Self::nearest_sites).
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
        // Nothing is known about the distance of what was not found.
        let anywhere = |error: QueryError| error.lower_bound(0.0);
        let start = async move { LineQuery::start(&reader, from, to, k, options).await.map_err(anywhere) };
        unfold(start, move |mut along: LineQuery| async move {
            let next = along.next().await.map_err(anywhere)?;
            Ok(next.map(|interval| (interval, along)))
        })
    }
}
