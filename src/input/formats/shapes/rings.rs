//! The rings of polygons, directed so that the polygon is on the left of every segment.
//!
//! In: polygons of either winding, their rings closed or not. Out: outer rings counter-clockwise,
//! inner ones clockwise, by the exact sign of their area. That sign is sufficient: parts of a ring
//! that are traversed in both directions (spikes, bridges) cancel out for either winding.
//!
//! A ring without area encloses nothing, and neither do the inner rings of a polygon whose outer
//! ring has no area. Their segments still block the way. Each of them is handed out in both
//! directions, so that neither side of it is the inside.

use std::cmp::Ordering;
use std::path::Path;

use crate::geometry::{Orientation, Point, area_sign, orient2d};
use crate::input::error::{InputError, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::formats::shapes::Shapes;
use crate::input::formats::shapes::event::{Event, Kind};
use crate::input::formats::shapes::features::Features;
use crate::input::lines::{LineTally, SegmentBatch};
use crate::input::point_z::PointZ;
use crate::input::reader::{Reader, Sink};
use crate::shown;

pub struct Rings {
    features: Features,
    /// The vertices of the current ring, each once. No two neighbours are equal.
    ring: Vec<PointZ>,
    /// The progress of handing out the ring, if it has ended.
    pending: Option<PendingRing>,
    /// Whether the outer ring of the current polygon has an area.
    has_area: bool,
    /// The number of polygons that have begun.
    polygons: u64,
    name: String,
    unclosed: u64,
    flat: u64,
    lone: u64,
}

/// The progress of handing out a ring.
#[derive(Clone, Copy)]
struct PendingRing {
    both_ways: bool,
    /// The number of segments handed out so far.
    emitted: usize,
}

fn is_polygon(kind: Kind) -> bool {
    matches!(kind, Kind::Polygon | Kind::MultiPolygon)
}

fn no_polygon(kind: Kind) -> Flaw {
    Flaw::NoPolygon {
        kind: format!("{kind:?}"),
    }
}

/// Returns whether a ring without area has no lobes either: it is collinear, or traverses each of
/// its edges equally often in both directions.
fn is_flat(ring: &[PointZ]) -> bool {
    let Some(first) = ring.first() else { return true };
    let second = ring.iter().find(|point_z| point_z.point != first.point);
    let is_on_line = |other: &PointZ| {
        second.is_none_or(|second| orient2d(first.point, second.point, other.point) == Orientation::Collinear)
    };
    if ring.iter().all(is_on_line) {
        return true;
    }
    let next = ring.iter().cycle().skip(1);
    let ways = ring
        .iter()
        .zip(next)
        .map(|(from, to)| match from.point.lex_cmp(to.point) {
            Ordering::Less => ([from.point, to.point], 1),
            _ => ([to.point, from.point], -1),
        });
    let mut ways: Vec<([Point; 2], i64)> = ways.collect();
    ways.sort_unstable_by(|([a, b], _), ([c, d], _)| a.lex_cmp(*c).then(b.lex_cmp(*d)));
    let mut same = ways.chunk_by(|one, other| one.0 == other.0);
    same.all(|same| same.iter().map(|(_, way)| way).sum::<i64>() == 0)
}

impl Rings {
    pub fn new(shapes: Box<dyn Shapes>, path: &Path) -> Result<Self, InputError> {
        let name = shown::path(path);
        Ok(Self {
            features: Features::new(shapes, None, is_polygon)?,
            ring: Vec::new(),
            pending: None,
            has_area: false,
            polygons: 0,
            name,
            unclosed: 0,
            flat: 0,
            lone: 0,
        })
    }

    /// Ends the current ring, which has this number in its polygon.
    fn end_ring(&mut self, number: u64) {
        if let [first, .., last] = self.ring[..] {
            if first.point == last.point {
                self.ring.pop();
            } else {
                self.unclosed += 1;
            }
        }
        let area = area_sign(self.ring.iter().map(|end| end.point));
        let is_outer = number == 0;
        if is_outer {
            // An outer ring whose lobes cancel out encloses them, one of them with the wrong
            // winding.
            self.has_area = area != Ordering::Equal || !is_flat(&self.ring);
            self.polygons += 1;
        }
        // No event reports an empty outer ring before the first position of the file.
        self.polygons = self.polygons.max(1);
        let both_ways = match is_outer {
            true => !self.has_area,
            false => area == Ordering::Equal || !self.has_area,
        };
        self.flat += u64::from(both_ways && self.ring.len() > 1);
        self.lone += u64::from(self.ring.len() == 1);
        if let [_, rest @ ..] = &mut self.ring[..]
            && is_outer != (area == Ordering::Greater)
            && (area != Ordering::Equal || both_ways)
        {
            rest.reverse();
        }
        self.pending = Some(PendingRing { both_ways, emitted: 0 });
    }

    /// Hands out a segment of a ring that has ended.
    fn emit(&mut self, pending: PendingRing, sink: &mut Sink<'_, SegmentBatch>) {
        let n = self.ring.len();
        let segments = if pending.both_ways { 2 * n } else { n };
        if n < 2 || pending.emitted == segments {
            self.ring.clear();
            self.pending = None;
            return;
        }
        let at = if pending.both_ways {
            pending.emitted / 2
        } else {
            pending.emitted
        };
        let mut ends = [self.ring[at], self.ring[(at + 1) % n]];
        if pending.both_ways && pending.emitted % 2 == 1 {
            ends.reverse();
        }
        sink.polygon_edge(ends, self.features.ended(), self.polygons - 1);
        self.pending = Some(PendingRing {
            emitted: pending.emitted + 1,
            ..pending
        });
    }
}

impl Reader<SegmentBatch> for Rings {
    fn has_z(&self) -> bool {
        self.features.has_z()
    }

    fn crs(&self) -> Option<&str> {
        self.features.crs()
    }

    fn tally(&self) -> LineTally {
        LineTally {
            lines: self.features.ended(),
            polygons: self.polygons,
        }
    }

    fn fill(&mut self, sink: &mut Sink<'_, SegmentBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if let Some(pending) = self.pending {
                self.emit(pending, sink);
                continue;
            }
            let number = sink.line(self.features.ended());
            let wrong = |location, flaw: &Flaw| sink.wrong(RecordKind::Obstacle, number, location, flaw);
            match self.features.next_event()? {
                None => return Ok(false),
                Some(Event::Position(position)) => {
                    let end = match self.features.kind() {
                        Some(kind) if !is_polygon(kind) => Err(no_polygon(kind)),
                        _ => position.point_z(),
                    };
                    let end = end.map_err(|flaw| wrong(position.location, &flaw))?;
                    if self.ring.last().is_none_or(|last| last.point != end.point) {
                        self.ring.push(end);
                    }
                }
                Some(Event::LineEnd(number)) => self.end_ring(number),
                Some(Event::Geometry(kind, location)) if !is_polygon(kind) => {
                    return Err(wrong(location, &no_polygon(kind)));
                }
                Some(Event::Geometry(..)) => self.has_area = false,
                Some(Event::Record(_)) => {}
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        let found = [
            (self.unclosed, "do not end where they begin; they were closed"),
            (
                self.flat,
                "enclose nothing, since they, or the outer rings around them, have no area; their segments still \
                 block the way",
            ),
            (self.lone, "have one position only; they were left out"),
        ];
        let found = found.into_iter().filter(|(rings, _)| *rings > 0);
        let notes = found.map(|(rings, what)| format!("{}: {rings} rings {what}", self.name));
        self.features.notes().into_iter().chain(notes).collect()
    }
}
