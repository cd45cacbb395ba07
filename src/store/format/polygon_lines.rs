//! Polygons of several lines: which lines are rings of one polygon.

use flatbuffers::FlatBufferBuilder;

use crate::store::format::damage::Damage;
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::flat_buffer::{finished, verified};
use crate::store::format::generated::directory as schema;
use crate::store::format::line_source::LineSource;

/// A line of an obstacle whose polygon has another line with a smaller number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PolygonLine {
    /// The number of the line.
    pub line: u64,
    /// The smallest number of a line of the polygon, which stands for the polygon.
    pub polygon: u64,
}

/// Returns the lines of polygons as a file has them: in order, each with the first line of its
/// polygon, and only those of obstacles that `lines` knows.
pub(crate) fn in_order(mut its: Vec<PolygonLine>, lines: &[LineSource]) -> Vec<PolygonLine> {
    its.retain(|of| of.polygon < of.line && is_obstacle(lines, of.line) && is_obstacle(lines, of.polygon));
    its.sort_unstable_by_key(|of| (of.line, of.polygon));
    its.dedup_by_key(|of| of.line);
    // The polygon of a smaller line is final already.
    for at in 0..its.len() {
        its[at].polygon = polygon_of(&its[..at], its[at].polygon);
    }
    its
}

fn is_obstacle(lines: &[LineSource], number: u64) -> bool {
    number <= EdgeSource::MAX_NUMBER && LineSource::knows(lines, EdgeSource::new(LineKind::Obstacle, number))
}

/// Returns the polygon of a line. `lines` is in order.
pub(crate) fn polygon_of(lines: &[PolygonLine], line: u64) -> u64 {
    let found = lines.binary_search_by_key(&line, |line| line.line);
    found.map_or(line, |at| lines[at].polygon)
}

pub(super) fn encode(lines: &[PolygonLine]) -> Vec<u8> {
    let mut builder = FlatBufferBuilder::new();
    let lines: Vec<_> = lines
        .iter()
        .map(|of| schema::PolygonLine::new(of.line, of.polygon))
        .collect();
    let list = Some(builder.create_vector(&lines));
    let root = schema::PolygonLines::create(&mut builder, &schema::PolygonLinesArgs { list });
    finished(builder, root)
}

/// Decodes the list. `lines` are the sources of lines. The error says what is wrong.
pub(super) fn decode(bytes: &[u8], lines: &[LineSource]) -> Result<Vec<PolygonLine>, Damage> {
    let table: schema::PolygonLines<'_> = verified(bytes, "the list of polygons of several lines")?;
    let its = table.list().iter().map(|of| PolygonLine {
        line: of.line(),
        polygon: of.polygon(),
    });
    let its: Vec<PolygonLine> = its.collect();
    check_polygon_lines(&its, lines)?;
    Ok(its)
}

/// Checks that lines ascend, that each follows the first line of its polygon, and that both are
/// lines of obstacles.
fn check_polygon_lines(its: &[PolygonLine], lines: &[LineSource]) -> Result<(), Damage> {
    let ascend = its.windows(2).all(|pair| pair[0].line < pair[1].line);
    let is_right = |of: &PolygonLine| {
        of.polygon < of.line
            && is_obstacle(lines, of.line)
            && is_obstacle(lines, of.polygon)
            && polygon_of(its, of.polygon) == of.polygon
    };
    match ascend && its.iter().all(is_right) {
        true => Ok(()),
        false => Err(Damage::new("its polygons of several lines are inconsistent")),
    }
}
