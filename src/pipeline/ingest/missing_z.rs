//! Vertices without z, where others have it: found before anything is triangulated.
//!
//! Until a vertex is written, the z of a point, an end of a line, a crossing point or a site that
//! has none is [`NO_Z`]. Of several at one place the [rule](DuplicateRule) says which one the
//! vertex is; if that one has no z, the vertex has none.

use crate::constraints::segment::Segment;
use crate::constraints::without_z::{VertexWithoutZ, WithoutZ};
use crate::geometry::Point;
use crate::pipeline::ingest::point_store::{Attributes, Item};
use crate::pipeline::options::DuplicateRule;
use crate::store::EdgeSource;

/// From which record numbers on points are what they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Firsts {
    pub(crate) end: u64,
    pub(crate) crossing: u64,
    pub(crate) site: u64,
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
pub(crate) struct FoundWithoutZ {
    pub(crate) count: u64,
    first: Option<(u64, Point, Option<EdgeSource>)>,
}

impl FoundWithoutZ {
    /// Those among the items of a leaf.
    pub(crate) fn in_leaf(items: &[Item], attributes: &Attributes, rule: DuplicateRule) -> Self {
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
    pub(crate) fn name_line(&mut self, segments: &[Segment]) {
        if let Some((_, point, line)) = &mut self.first {
            let there = segments.iter().filter(|segment| segment.ends.contains(point));
            *line = there.map(|segment| segment.source).min_by_key(|source| source.number());
        }
    }

    /// Takes all of another.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.count += other.count;
        let both = self.first.into_iter().chain(other.first);
        self.first = both.min_by_key(|(record, ..)| *record);
    }

    /// The first one.
    pub(crate) fn first(&self, firsts: Firsts) -> Option<VertexWithoutZ> {
        self.first.map(|(record, point, line)| VertexWithoutZ {
            what: firsts.what(record),
            point,
            line,
        })
    }
}
