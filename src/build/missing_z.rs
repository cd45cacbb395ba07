//! Vertices without z, where others have it: found before anything is triangulated.
//!
//! Until a vertex is written, the z of a point, an end of a line, a crossing point or a site that
//! has none is [`NO_Z`]. Of several at one place the [rule](DuplicateRule) says which one the
//! vertex is; if that one has no z, the vertex has none.

use std::fmt;

use super::options::DuplicateRule;
use super::point_store::{Attributes, Item};
use super::segments::Segment;
use crate::geometry::Point;
use crate::store::EdgeSource;

/// What stands for the z of what has none: the z that come are finite.
pub(super) const NO_Z: f64 = f64::NAN;

/// A vertex that has no z.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct VertexWithoutZ {
    /// What it is.
    pub what: WithoutZ,
    /// Where it lies.
    pub point: Point,
    /// The line of the smallest number that ends there or was cut there, if one does.
    pub line: Option<EdgeSource>,
}

/// What a vertex without z is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WithoutZ {
    /// The point of this record.
    Point(u64),
    /// An end of a line.
    End,
    /// A point where lines cross each other or borders.
    Crossing,
    /// The site of this number.
    Site(u64),
}

impl fmt::Display for VertexWithoutZ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.what, self.line) {
            (WithoutZ::Point(record), _) => write!(f, "record {record}")?,
            (WithoutZ::Site(site), _) => write!(f, "site {site}")?,
            (WithoutZ::End, Some(line)) => write!(f, "an end of {} {}", line.kind(), line.number())?,
            (WithoutZ::End, None) => write!(f, "an end of a line")?,
            (WithoutZ::Crossing, _) => write!(f, "a point where lines cross")?,
        }
        write!(f, " at ({}, {})", self.point.x, self.point.y)
    }
}

/// From which record numbers on points are what they are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Firsts {
    pub(super) end: u64,
    pub(super) crossing: u64,
    pub(super) site: u64,
}

impl Firsts {
    fn what(self, record: u64) -> WithoutZ {
        match record {
            record if record >= self.site => WithoutZ::Site(record - self.site),
            record if record >= self.crossing => WithoutZ::Crossing,
            record if record >= self.end => WithoutZ::End,
            record => WithoutZ::Point(record),
        }
    }
}

/// Vertices without z: how many, and which has the smallest record number. The same however they
/// are found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FoundWithoutZ {
    pub(super) count: u64,
    first: Option<(u64, Point, Option<EdgeSource>)>,
}

impl FoundWithoutZ {
    /// Those among the items of a leaf.
    pub(super) fn in_leaf(items: &[Item], attributes: &Attributes, rule: DuplicateRule) -> Self {
        let of = |item: &Item| (attributes.z(item.position), attributes.record(item.position));
        let lacking = items.iter().filter(|item| attributes.z(item.position).is_nan());
        let mut places: Vec<Point> = lacking.map(|item| item.point).collect();
        places.sort_unstable_by(|a, b| a.lex_cmp(*b));
        places.dedup();
        let mut there: Vec<(usize, &Item)> = match places.is_empty() {
            true => Vec::new(),
            false => {
                let place = |item: &Item| places.binary_search_by(|place| place.lex_cmp(item.point)).ok();
                items.iter().filter_map(|item| Some((place(item)?, item))).collect()
            }
        };
        there.sort_unstable_by_key(|(place, _)| *place);
        let mut found = Self::default();
        for at_place in there.chunk_by(|a, b| a.0 == b.0) {
            let all = at_place.iter().map(|(_, item)| of(item));
            let kept = all.reduce(|best, next| if rule.prefers(next, best) { next } else { best });
            if let Some((z, record)) = kept
                && z.is_nan()
            {
                found.merge(&Self {
                    count: 1,
                    first: Some((record, places[at_place[0].0], None)),
                });
            }
        }
        found
    }

    /// Finds the line of the first one among those that come near.
    pub(super) fn name_line(&mut self, segments: &[Segment]) {
        if let Some((_, point, line)) = &mut self.first {
            let there = segments.iter().filter(|segment| segment.ends.contains(point));
            *line = there.map(|segment| segment.source).min_by_key(|source| source.number());
        }
    }

    /// Takes all of another.
    pub(super) fn merge(&mut self, other: &Self) {
        self.count += other.count;
        let both = self.first.into_iter().chain(other.first);
        self.first = both.min_by_key(|(record, ..)| *record);
    }

    /// The first one.
    pub(super) fn first(&self, firsts: Firsts) -> Option<VertexWithoutZ> {
        self.first.map(|(record, point, line)| VertexWithoutZ {
            what: firsts.what(record),
            point,
            line,
        })
    }
}
