//! Splitting of lines that cross: the subsegments of a build's segments, and its crossing points
//! with their z.
//!
//! In: all segments, with z at the ends of some. Out: subsegments that do not cross, and the points
//! at which segments were cut, with z where a line through them has z at both ends. Everything is
//! in memory.
//!
//! Of several lines through a point, the first one that has z determines the point's z. The first
//! line is the one with the smallest number (break lines come before walls, and walls before
//! obstacles), and of its segments the one whose ends come first. So the z is a function of the
//! lines; their order and direction do not matter. Along a segment, z is linear in the coordinate
//! that changes more. Rounding takes no z beyond the z of the ends.

use std::cmp::Ordering;

use crate::constraints::crossings::ends::Ends;
use crate::constraints::crossings::split::{PointSource, any_cross, split};
use crate::constraints::error::{ConstraintError, SplitError};
use crate::constraints::polygons::arrivals::PolygonNumbers;
use crate::constraints::polygons::check::InvertedPolygons;
use crate::constraints::polygons::counter::PolygonCounter;
use crate::constraints::polygons::repair::{PartOf, PolygonRepair, Subsegment, repair};
use crate::constraints::segment::Segment;
use crate::constraints::segments::spool::SegmentSpool;
use crate::constraints::without_z::NO_Z;
use crate::geometry::{Point, Rect};
use crate::input::PointBatch;
use crate::memory::{MemoryShortage, MemoryUse};
use crate::store::{EdgeSource, LineBatch, LineKind, LinePart};

/// Bytes of a segment, and of a crossing, while segments are split.
const BYTES: u64 = 300;
/// Number of subsegments or points of a batch.
const BATCH: usize = 8192;

/// A segment before it was split.
#[derive(Clone, Copy, Debug)]
struct InputSegment {
    ends: [Point; 2],
    source: EdgeSource,
    /// z at both ends, or [`NO_Z`].
    z: [f64; 2],
    /// The number of its polygon, if it belongs to one.
    polygon: u64,
}

/// Segments to split where they cross, as a build splits them.
///
/// ```
/// use delaunay_tiles::{ConstraintError, LinesToSplit};
/// use delaunay_tiles::geometry::Point;
/// use delaunay_tiles::store::{EdgeSource, LineBatch, LineKind, LinePart};
///
/// let line = |[a, b, c, d]: [f64; 4]| [Point::new(a, b), Point::new(c, d)];
/// let wall = |number| LinePart::whole(EdgeSource::new(LineKind::Wall, number));
/// let mut lines = LinesToSplit::new(1 << 20);
/// let crossing = LineBatch {
///     ends: vec![line([0.0, 0.0, 4.0, 4.0]), line([0.0, 4.0, 4.0, 0.0])],
///     sources: vec![wall(0), wall(1)],
/// };
/// lines.push(&crossing, &[], &[])?;
/// // There are no other points.
/// let split = lines.split(|_, _| Ok::<_, ConstraintError>(()))?;
/// assert_eq!(split.crossings(), 1);
/// assert_eq!(split.points(0).next().unwrap().points, [Point::new(2.0, 2.0)]);
/// let subsegments = split.subsegments().next().unwrap();
/// assert_eq!(subsegments.ends.len(), 4);
/// // Each has one end of the wall, and one at the crossing.
/// assert!(subsegments.sources.iter().all(|part| part.begins() != part.ends()));
/// # Ok::<(), ConstraintError>(())
/// ```
#[derive(Debug)]
pub struct LinesToSplit {
    segments: Vec<InputSegment>,
    /// Bytes of memory that it may take.
    memory: u64,
    /// Segments are split at these borders too.
    borders: Vec<[Point; 2]>,
    counter: PolygonCounter,
}

impl LinesToSplit {
    /// Makes an empty list that may take `memory` bytes of memory. A segment takes about 300 bytes,
    /// and so does a crossing.
    #[must_use]
    pub fn new(memory: u64) -> Self {
        Self {
            segments: Vec::new(),
            memory,
            borders: Vec::new(),
            counter: PolygonCounter::default(),
        }
    }

    /// Also splits the segments where they cross `borders`: the borders that the file of these
    /// lines records.
    #[must_use]
    pub fn at_borders(mut self, borders: &[[Point; 2]]) -> Self {
        self.borders = borders.to_vec();
        self
    }

    /// Adds segments. `z` has the z at both ends of each segment; NaN stands for none, and so does
    /// a missing entry at the end of the list. Segments of zero length are ignored. For obstacles,
    /// `polygons` has the polygon of each segment; if it is empty, each line is a polygon. The
    /// segments of a polygon must be consecutive.
    ///
    /// # Errors
    /// Returns an error if the segments do not fit in memory.
    pub fn push(&mut self, batch: &LineBatch, z: &[[f64; 2]], polygons: &[u64]) -> Result<(), ConstraintError> {
        for (at, (ends, part)) in batch.ends.iter().zip(&batch.sources).enumerate() {
            if ends[0] == ends[1] {
                continue;
            }
            let source = part.source();
            let mut polygon = 0;
            if source.kind() == LineKind::Obstacle {
                let key = polygons.get(at).copied().unwrap_or(source.number());
                self.counter.next(key, source.number());
                polygon = self.counter.number();
            }
            self.segments.push(InputSegment {
                ends: ends.map(Point::normalized),
                source,
                z: z.get(at).copied().unwrap_or([NO_Z; 2]),
                polygon,
            });
        }
        let needed = self.segments.len() as u64 * BYTES;
        check_memory(needed, self.memory)
    }

    /// Splits the segments where they cross. Other vertices split the bent segments on which they
    /// lie. Each call of `points` passes all points and sites of the input within a rectangle, and
    /// possibly more, in batches. Ends of segments may be among them.
    ///
    /// # Errors
    /// Returns an error if there are more crossings than fit in memory, or if segments still cross
    /// after the last round; or the error of `points`.
    pub fn split<E: From<ConstraintError>>(
        self,
        mut points: impl FnMut(Rect, &mut dyn FnMut(&[Point])) -> Result<(), E>,
    ) -> Result<SplitLines, E> {
        self.split_at(&mut |within, take| points(within, take).map_err(Stopped::Points))
            .map_err(|stopped| match stopped {
                Stopped::Split(error) => ConstraintError::Split(error).into(),
                Stopped::Points(error) => error,
            })
    }

    fn split_at<E: From<SplitError>>(self, points: &mut PointSource<'_, E>) -> Result<SplitLines, E> {
        let Self {
            segments,
            memory,
            borders,
            ..
        } = self;
        let mut subsegments = whole(&segments);
        let left = memory.saturating_sub(segments.len() as u64 * BYTES);
        let done = split(&mut subsegments, (left / BYTES) as usize, &borders, points)?;
        // The points at which a segment was split are no ends of it.
        for Subsegment { ends, tag } in &mut subsegments {
            let of_segment = segments[tag.segment as usize].ends;
            tag.is_end = ends.map(|end| of_segment.contains(&end));
        }
        let repair = repair(&mut subsegments, |subsegment| {
            let InputSegment { source, polygon, .. } = segments[subsegment.tag.segment as usize];
            (source.kind() == LineKind::Obstacle).then_some((polygon, source.number()))
        });
        Ok(SplitLines {
            segments,
            subsegments,
            points: done.points,
            crossings: done.crossings.iter().sum(),
            borders,
            repair,
        })
    }

    /// Returns a rectangle around all segments.
    fn bounds(&self) -> Rect {
        Rect::around(self.segments.iter().flat_map(|segment| segment.ends))
    }
}

/// The reason why segments are not split.
enum Stopped<E> {
    Split(SplitError),
    Points(E),
}

impl<E> From<SplitError> for Stopped<E> {
    fn from(error: SplitError) -> Self {
        Self::Split(error)
    }
}

/// The result of splitting segments that crossed.
#[derive(Debug)]
pub struct SplitLines {
    segments: Vec<InputSegment>,
    /// The subsegments, each with its segment.
    subsegments: Vec<Subsegment>,
    /// The points at which segments were cut, in lexicographic order.
    points: Vec<Point>,
    crossings: u64,
    borders: Vec<[Point; 2]>,
    repair: PolygonRepair,
}

/// Returns an error if splitting takes more than `budget` bytes.
fn check_memory(needed: u64, budget: u64) -> Result<(), ConstraintError> {
    match needed > budget {
        true => Err(MemoryShortage {
            of: MemoryUse::Split,
            needed,
            budget,
        }
        .into()),
        false => Ok(()),
    }
}

impl SplitLines {
    /// Splits all segments of a spool within `budget` bytes. `polygons` numbers their polygons, and
    /// `points` passes other vertices. Returns `None` if all segments stay as they are, or if
    /// segments cross but must not, which is reported elsewhere.
    pub(crate) fn of(
        (segments, mut polygons): (&mut SegmentSpool, PolygonNumbers<'_>),
        budget: u64,
        (may_cross, borders): (bool, &dyn Fn(Rect) -> Vec<[Point; 2]>),
        points: &mut PointSource<'_, ConstraintError>,
    ) -> Result<Option<Self>, ConstraintError> {
        let needed = segments.len().saturating_mul(BYTES);
        check_memory(needed, budget)?;
        let mut lines = LinesToSplit::new(budget);
        lines.segments.reserve_exact(segments.len() as usize);
        let z = segments.z_of_ends()?;
        segments.for_each_chunk(|some| {
            for segment in some {
                lines.segments.push(InputSegment {
                    ends: segment.ends,
                    source: segment.source.source(),
                    z: z.get(lines.segments.len()).copied().unwrap_or([NO_Z; 2]),
                    polygon: polygons.next(segment.source.source()),
                });
            }
            Ok(())
        })?;
        drop(z);
        lines.borders = borders(lines.bounds());
        if !may_cross && (lines.borders.is_empty() || any_cross(&lines.segments)) {
            return Ok(None);
        }
        Ok(Some(lines.split_at(points)?).filter(|split| !split.points.is_empty() || split.repair.changes))
    }

    /// Returns the result of the repair of polygons that were inside out, or covered a place more
    /// than once.
    pub(crate) fn repair(&self) -> PolygonRepair {
        self.repair
    }

    /// Returns the polygons that were inside out and were repaired.
    #[must_use]
    pub fn inverted(&self) -> Option<InvertedPolygons> {
        self.repair.inverted
    }

    /// Returns the borders at which segments were split.
    pub(crate) fn borders(&self) -> &[[Point; 2]] {
        &self.borders
    }

    /// Returns the number of pairs that crossed, summed over all rounds.
    #[must_use]
    pub fn crossings(&self) -> u64 {
        self.crossings
    }

    /// Returns the subsegments, which do not cross, each with the source of its segment, in
    /// batches.
    pub fn subsegments(&self) -> impl Iterator<Item = LineBatch> {
        self.subsegments.chunks(BATCH).map(|subsegments| LineBatch {
            ends: subsegments.iter().map(|subsegment| subsegment.ends).collect(),
            sources: subsegments
                .iter()
                .map(|subsegment| self.segment(subsegment).source)
                .collect(),
        })
    }

    /// Returns a subsegment with the part of a line that it is.
    fn segment(&self, subsegment: &Subsegment) -> Segment {
        let PartOf { segment, is_end } = subsegment.tag;
        let source = self.segments[segment as usize].source;
        Segment {
            ends: subsegment.ends,
            source: LinePart::of(source, is_end[0], is_end[1]),
        }
    }

    /// Adds the subsegments to a spool, in the order of their lines.
    pub(crate) fn push_subsegments(&self, spool: &mut SegmentSpool) -> Result<(), ConstraintError> {
        spool.push_parts(self.subsegments.iter().map(|subsegment| self.segment(subsegment)))
    }

    /// Returns the points at which segments were cut, in lexicographic order, with record numbers
    /// from `first_record` on. They have z if any segment has, NaN where no line has z.
    pub fn points(&self, first_record: u64) -> impl Iterator<Item = PointBatch> {
        let z = self.z();
        let points = &self.points;
        (0..points.len()).step_by(BATCH).map(move |start| {
            let end = points.len().min(start + BATCH);
            PointBatch {
                points: points[start..end].to_vec(),
                z: z.get(start..end).unwrap_or_default().to_vec(),
                records: (first_record + start as u64..first_record + end as u64).collect(),
            }
        })
    }

    /// Returns the z of each point, [`NO_Z`] where no line has it; or an empty list if no line has
    /// any.
    fn z(&self) -> Vec<f64> {
        if self.segments.iter().all(|segment| !segment.has_z()) {
            return Vec::new();
        }
        let mut first: Vec<Option<u32>> = vec![None; self.points.len()];
        for subsegment in &self.subsegments {
            let segment = &self.segments[subsegment.tag.segment as usize];
            for end in subsegment.ends.iter().filter(|_| segment.has_z()) {
                if let Ok(index) = self.points.binary_search_by(|point| point.lex_cmp(*end)) {
                    let kept = &mut first[index];
                    if kept.is_none_or(|kept| segment.order(&self.segments[kept as usize]).is_lt()) {
                        *kept = Some(subsegment.tag.segment);
                    }
                }
            }
        }
        let points = self.points.iter().zip(first);
        let z =
            points.map(|(&point, segment)| segment.map_or(NO_Z, |segment| self.segments[segment as usize].z_at(point)));
        z.collect()
    }
}

/// Returns each segment as a part of itself.
fn whole(segments: &[InputSegment]) -> Vec<Subsegment> {
    let whole = segments.iter().zip(0..).map(|(input, segment)| Subsegment {
        ends: input.ends,
        tag: PartOf {
            segment,
            is_end: [true; 2],
        },
    });
    whole.collect()
}

impl Ends for InputSegment {
    fn ends(&self) -> [Point; 2] {
        self.ends
    }
}

impl InputSegment {
    fn has_z(&self) -> bool {
        self.z.iter().all(|z| !z.is_nan())
    }

    /// Returns the ends and their z, from the smaller end on.
    fn in_order(&self) -> ([Point; 2], [f64; 2]) {
        let ([a, b], [z_a, z_b]) = (self.ends, self.z);
        match a.lex_cmp(b).is_le() {
            true => ([a, b], [z_a, z_b]),
            false => ([b, a], [z_b, z_a]),
        }
    }

    /// Compares two segments by which of them determines the z of a point. Equal ones give the same
    /// z.
    fn order(&self, other: &Self) -> Ordering {
        let (([a, b], z), ([c, d], w)) = (self.in_order(), other.in_order());
        let number = self.source.number().cmp(&other.source.number());
        let ends = number.then_with(|| a.lex_cmp(c)).then_with(|| b.lex_cmp(d));
        ends.then_with(|| z[0].total_cmp(&w[0]))
            .then_with(|| z[1].total_cmp(&w[1]))
    }

    /// Returns the z at a point along the segment.
    fn z_at(&self, point: Point) -> f64 {
        let ([a, b], [low, high]) = self.in_order();
        let (width, height) = (b.x - a.x, b.y - a.y);
        let share = if width.abs() >= height.abs() {
            (point.x - a.x) / width
        } else {
            (point.y - a.y) / height
        };
        let z = low * (1.0 - share) + high * share;
        z.clamp(low.min(high), low.max(high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(ends: [[f64; 2]; 2], z: [f64; 2], number: u64) -> InputSegment {
        InputSegment {
            ends: ends.map(|[x, y]| Point::new(x, y)),
            source: EdgeSource::new(LineKind::Wall, number),
            z,
            polygon: 0,
        }
    }

    fn reversed(segment: InputSegment) -> InputSegment {
        InputSegment {
            ends: [segment.ends[1], segment.ends[0]],
            z: [segment.z[1], segment.z[0]],
            ..segment
        }
    }

    #[test]
    fn z_is_linear_along_a_segment() {
        for (ends, z, at, expected) in [
            ([[0.0, 0.0], [8.0, 4.0]], [10.0, 30.0], [2.0, 1.0], 15.0),
            ([[0.0, 0.0], [-4.0, 8.0]], [10.0, 30.0], [-1.0, 2.0], 15.0),
            ([[3.0, 0.0], [3.0, 8.0]], [1.0, 1.0], [3.0, 7.0], 1.0),
            ([[0.0, 0.0], [1.0, 0.0]], [0.1, 0.1], [0.3, 0.0], 0.1),
            ([[0.0, 0.0], [1.0, 0.0]], [f64::MAX, -f64::MAX], [0.5, 0.0], 0.0),
            // Rounding may move a point beyond an end in the other coordinate only; z stays in
            // between.
            ([[0.0, 0.0], [1e-9, 0.0]], [5.0, 7.0], [1e-9, 1e-20], 7.0),
        ] {
            let segment = segment(ends, z, 0);
            let point = Point::new(at[0], at[1]);
            assert_eq!(segment.z_at(point), expected, "{segment:?}");
            assert_eq!(reversed(segment).z_at(point), expected);
            assert!(segment.order(&reversed(segment)).is_eq());
        }
    }

    #[test]
    fn the_first_line_with_z_determines_the_z_of_a_point() {
        let segments = vec![
            segment([[0.0, 0.0], [4.0, 4.0]], [NO_Z; 2], 1),
            segment([[0.0, 4.0], [4.0, 0.0]], [10.0, 30.0], 3),
            segment([[2.0, 0.0], [2.0, 4.0]], [4.0, 8.0], 2),
            segment([[8.0, 0.0], [8.0, 4.0]], [NO_Z; 2], 0),
            segment([[7.0, 1.0], [9.0, 1.0]], [NO_Z; 2], 5),
        ];
        for segments in [
            segments.clone(),
            segments.iter().rev().map(|&segment| reversed(segment)).collect(),
        ] {
            let mut subsegments = whole(&segments);
            let done = split::<_, SplitError>(&mut subsegments, 100, &[], &mut |_, _| Ok(())).unwrap();
            let split = SplitLines {
                segments,
                subsegments,
                points: done.points,
                crossings: done.crossings.iter().sum(),
                borders: Vec::new(),
                repair: PolygonRepair::default(),
            };
            assert_eq!(split.points, [Point::new(2.0, 2.0), Point::new(8.0, 1.0)]);
            assert!(matches!(split.z()[..], [6.0, z] if z.is_nan()));
        }
    }
}
