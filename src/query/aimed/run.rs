//! Searches from one point to targets, group by group.

use super::cost::Expectation;
use super::tree::{Group, Targets};
use crate::query::answer::{Distance, Path, distance};
use crate::query::free_space::QueryPoint;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::query::wavefront::{FoundTarget, Goal, QueryPoints, Target, WavefrontRun};

/// If a wavefront passes this many times as many triangles as expected, the targets that are left
/// become one group.
const TOO_MUCH: f64 = 4.0;

/// A search from one point to targets. Targets that cannot be reached are not found.
pub(crate) struct AimedRun<'t> {
    targets: &'t Targets,
    /// The positions of the targets, by index.
    positions: &'t [QueryPoint],
    /// Whether each target is wanted, and was not found yet.
    is_wanted: Vec<bool>,
    source: QueryPoint,
    options: QueryOptions,
    /// Targets that are farther away are not wanted.
    limit: f64,
    /// The number of triangles that wavefronts have passed, and may pass.
    passed: u64,
    most: u64,
    expectation: Expectation,
    /// The groups to search for, the next one last.
    groups: Vec<Group>,
    stage: Stage,
}

/// A target that was found: its index, and what the wavefront knows of it.
pub(crate) type Reached = (u32, FoundTarget);

enum Stage {
    Between(Option<Tiles>),
    Searching {
        run: Box<WavefrontRun>,
        group: Group,
        missing: usize,
    },
}

impl<'t> AimedRun<'t> {
    /// Starts at a free point. `tiles` are those of the query; `is_wanted` says of each position
    /// whether it is a target of this search.
    pub(crate) fn new(
        tiles: Tiles,
        source: QueryPoint,
        targets: &'t Targets,
        positions: &'t [QueryPoint],
        is_wanted: Vec<bool>,
        expectation: Expectation,
        options: QueryOptions,
    ) -> Self {
        let groups = targets.groups(source.point, &is_wanted, &expectation);
        Self {
            targets,
            positions,
            is_wanted,
            source,
            options,
            limit: f64::INFINITY,
            passed: 0,
            most: u64::MAX,
            expectation,
            groups,
            stage: Stage::Between(Some(tiles)),
        }
    }

    /// Ignores targets that are farther away than `limit`, and gives up after `most` triangles.
    pub(crate) fn within(mut self, limit: f64, most: u64) -> Self {
        (self.limit, self.most) = (limit, most);
        self
    }

    /// Returns the number of triangles that wavefronts have passed. If it exceeds the number that
    /// they may pass, targets may be missing.
    pub(crate) fn passed(&self) -> u64 {
        match &self.stage {
            Stage::Between(_) => self.passed,
            Stage::Searching { run, .. } => self.passed + run.wavefront.passed(),
        }
    }

    /// Returns what is known of the ground by now.
    pub(crate) fn expectation(&self) -> Expectation {
        self.expectation
    }

    /// Returns the next target that is found, in no particular order, or `None` at the end.
    pub(crate) async fn next(&mut self) -> Result<Option<Reached>, QueryError> {
        loop {
            if let Stage::Searching { run, group, missing } = &mut self.stage
                && *missing > 0
                && let Some(found) = run.next_before(self.most.saturating_sub(self.passed)).await?
            {
                let Target::Point(member) = found.target else { continue };
                let index = group.members[member as usize];
                *missing -= 1;
                self.is_wanted[index as usize] = false;
                let straight = distance(self.source.point, self.targets.point(index));
                self.expectation.learn(found.length, straight);
                return Ok(Some((index, found)));
            }
            let Some(tiles) = self.end_search() else {
                return Ok(None);
            };
            if self.passed > self.most {
                self.groups.clear();
            }
            let Some(group) = self.groups.pop() else {
                self.stage = Stage::Between(Some(tiles));
                return Ok(None);
            };
            self.search(tiles, group).await?;
        }
    }

    /// Ends the search for a group, and returns the tiles of the query.
    fn end_search(&mut self) -> Option<Tiles> {
        match std::mem::replace(&mut self.stage, Stage::Between(None)) {
            Stage::Between(tiles) => tiles,
            Stage::Searching { run, group, missing } => {
                let passed = run.wavefront.passed();
                self.passed += passed;
                if missing > 0 && self.limit == f64::INFINITY && self.passed <= self.most {
                    // Nothing was in the way of the search: these cannot be reached. Others may be
                    // unreachable too, and their searches as wide.
                    group
                        .members
                        .iter()
                        .for_each(|&member| self.is_wanted[member as usize] = false);
                }
                if passed as f64 > TOO_MUCH * group.expected.triangles && self.groups.len() > 1 {
                    let from = self.source.point;
                    let rest = self.targets.one_group(from, &self.is_wanted, &self.expectation);
                    self.groups = rest.into_iter().collect();
                }
                Some(run.tiles)
            }
        }
    }

    async fn search(&mut self, mut tiles: Tiles, group: Group) -> Result<(), QueryError> {
        let members = group.members.iter().map(|&member| &self.positions[member as usize]);
        let mut goal = QueryPoints::new(members);
        if group.expected.is_directed {
            goal = goal.aimed();
        }
        // The wavefront begins in the tile that was used last.
        tiles.get(self.source.tile()).await?;
        let (source, options) = (self.source.clone(), self.options.clone());
        let run = WavefrontRun::start(tiles, source, Goal::Points(goal), self.limit, options).await?;
        let missing = group.members.len();
        let run = Box::new(run);
        self.stage = Stage::Searching { run, group, missing };
        Ok(())
    }

    /// Returns the tiles of the query after the last target.
    pub(crate) fn into_tiles(self) -> Option<Tiles> {
        match self.stage {
            Stage::Between(tiles) => tiles,
            Stage::Searching { run, .. } => Some(run.tiles),
        }
    }

    /// Returns the path to a target that was found last.
    pub(crate) async fn path(&mut self, (index, found): &Reached) -> Result<Option<Path>, QueryError> {
        match &mut self.stage {
            Stage::Searching { run, .. } => run.path(found, &self.positions[*index as usize]).await.map(Some),
            Stage::Between(_) => Ok(None),
        }
    }

    /// Returns the distance of a target that was found last.
    pub(crate) fn distance(&self, found: &FoundTarget) -> Distance {
        let legs = match &self.stage {
            Stage::Searching { run, .. } => run.legs(found),
            Stage::Between(_) => 1,
        };
        Distance::of_legs(found.length, legs)
    }
}
