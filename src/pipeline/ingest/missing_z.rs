//! Vertices without z when others have it, found before anything is triangulated.
//!
//! Until a vertex is written, the z of a point, a line's end, a crossing point or a site without z
//! is [`NO_Z`](crate::constraints::without_z::NO_Z). The [rule](DuplicateRule) selects one of
//! several points at the same position as the vertex. If that point has no z, the vertex has none.

use crate::constraints::segment::Segment;
use crate::constraints::without_z::{VertexWithoutZ, WithoutZ};
use crate::geometry::Point;
use crate::pipeline::ingest::point_store::Attributes;
use crate::pipeline::options::DuplicateRule;
use crate::store::EdgeSource;
use crate::store::divide::Item;

/// The first record number of each kind of point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstRecords {
    pub(crate) end: u64,
    pub(crate) crossing: u64,
    pub(crate) site: u64,
}

impl FirstRecords {
    fn what(self, record: u64) -> WithoutZ {
        match record {
            record if record >= self.site => WithoutZ::Site(record - self.site),
            record if record >= self.crossing => WithoutZ::Crossing,
            record if record >= self.end => WithoutZ::End,
            record => WithoutZ::Point(record),
        }
    }
}

/// The number of vertices without z, and the one with the smallest record number. Does not depend
/// on the order in which they are found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FoundWithoutZ {
    pub(crate) count: u64,
    first: Option<(u64, Point, Option<EdgeSource>)>,
}

impl FoundWithoutZ {
    /// Returns the vertices without z among the items of a leaf.
    pub(crate) fn in_leaf(items: &[Item], attributes: &Attributes, rule: DuplicateRule) -> Self {
        let of = |item: &Item| (attributes.z(item.position), attributes.record(item.position));
        let lacking = items.iter().filter(|item| attributes.z(item.position).is_nan());
        let mut points: Vec<Point> = lacking.map(|item| item.point).collect();
        points.sort_unstable_by(|a, b| a.lex_cmp(*b));
        points.dedup();
        let mut there: Vec<(usize, &Item)> = match points.is_empty() {
            true => Vec::new(),
            false => {
                let index = |item: &Item| points.binary_search_by(|point| point.lex_cmp(item.point)).ok();
                items.iter().filter_map(|item| Some((index(item)?, item))).collect()
            }
        };
        there.sort_unstable_by_key(|(index, _)| *index);
        let mut found = Self::default();
        for at_point in there.chunk_by(|a, b| a.0 == b.0) {
            let all = at_point.iter().map(|(_, item)| of(item));
            let kept = all.reduce(|best, next| if rule.prefers(next, best) { next } else { best });
            if let Some((z, record)) = kept
                && z.is_nan()
            {
                found.merge(&Self {
                    count: 1,
                    first: Some((record, points[at_point[0].0], None)),
                });
            }
        }
        found
    }

    /// Finds the line of the first vertex among `segments`.
    pub(crate) fn name_line(&mut self, segments: &[Segment]) {
        if let Some((_, point, line)) = &mut self.first {
            let there = segments.iter().filter(|segment| segment.ends.contains(point));
            *line = there
                .map(|segment| segment.source.source())
                .min_by_key(|source| source.number());
        }
    }

    /// Adds the vertices of `other`.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.count += other.count;
        let both = self.first.into_iter().chain(other.first);
        self.first = both.min_by_key(|(record, ..)| *record);
    }

    /// Returns the vertex with the smallest record number.
    pub(crate) fn first(&self, firsts: FirstRecords) -> Option<VertexWithoutZ> {
        self.first.map(|(record, point, line)| VertexWithoutZ {
            what: firsts.what(record),
            point,
            line,
        })
    }
}
