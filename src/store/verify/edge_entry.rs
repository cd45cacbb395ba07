//! The constraint edges of a tile with their sources, as they are compared with the input.

use std::cmp::Ordering;

use crate::geometry::{Point, compare_lines};
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::line_part::{LinePart, join_equal};
use crate::store::format::metadata::Metadata;
use crate::store::format::tile::Tile;
use crate::store::verify::error::Fault;

/// A constraint edge of a tile with one of its sources, as seen from its smaller end to its larger
/// one.
#[derive(Clone, Copy)]
pub(super) struct EdgeEntry {
    pub(super) ends: [Point; 2],
    pub(super) part: LinePart,
    /// The number of its first copy in the tile, and the number of copies, which are numbered
    /// consecutively. The next numbers are for the ends of segments that it has.
    pub(super) number: u32,
    pub(super) copies: u32,
}

impl EdgeEntry {
    /// Compares the entry with a position: a source, a line in the plane, and a point on it.
    pub(super) fn compare(&self, ends: [Point; 2], source: EdgeSource, from: Point) -> Ordering {
        let line = || compare_lines(self.ends, ends);
        let sources = self.part.source().cmp(&source);
        sources.then_with(line).then_with(|| self.ends[0].lex_cmp(from))
    }

    /// Returns the number of items that it counts as: its copies, and the ends of segments.
    pub(super) fn items(&self) -> u32 {
        self.copies + u32::from(self.part.begins()) + u32::from(self.part.ends())
    }

    /// Returns the numbers of its beginning and its end, if it has an end of a segment there.
    pub(super) fn numbers_of_ends(&self) -> [Option<u32>; 2] {
        let [begins, ends] = [self.part.begins(), self.part.ends()];
        let first = self.number + self.copies;
        [begins.then_some(first), ends.then_some(first + u32::from(begins))]
    }
}

/// Returns the segment from its smaller end to its larger one.
pub(super) fn forward([from, to]: [Point; 2], part: LinePart) -> ([Point; 2], LinePart) {
    match from.lex_cmp(to).is_le() {
        true => ([from, to], part),
        false => ([to, from], part.reversed()),
    }
}

/// What tells lines apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LineNames {
    /// Their numbers.
    Numbers,
    /// Only their kind, and the side of an obstacle's interior: after lines were removed, those of a
    /// build without them have other numbers.
    Kinds,
}

impl LineNames {
    pub(super) fn of(metadata: &Metadata) -> Self {
        match metadata.line_removals {
            0 => Self::Numbers,
            _ => Self::Kinds,
        }
    }

    /// Returns a source with the number 0 if numbers do not matter.
    pub(super) const fn source(self, source: EdgeSource) -> EdgeSource {
        match self {
            Self::Numbers => source,
            Self::Kinds => source.without_number(),
        }
    }
}

/// Returns the entries of a tile, numbered in the order in which they are stored.
pub(super) fn entries(tile: &Tile, names: LineNames) -> impl Iterator<Item = EdgeEntry> {
    let mut number = 0;
    tile.owned_constraints()
        .flat_map(move |edge| {
            let ends = tile.ends(edge).map(|vertex| vertex.point);
            let named = |part: LinePart| LinePart::of(names.source(part.source()), part.begins(), part.ends());
            let mut parts: Vec<LinePart> = tile.edge_parts(edge).map(named).collect();
            if names == LineNames::Kinds {
                parts.sort_unstable();
                join_equal(&mut parts);
            }
            let mut parts = parts.into_iter().peekable();
            // Equal sources are consecutive.
            std::iter::from_fn(move || {
                let part = parts.next()?;
                let mut copies = 1;
                while parts.next_if(|next| next.source() == part.source()).is_some() {
                    copies += 1;
                }
                Some((ends, part, copies))
            })
        })
        .map(move |(ends, part, copies)| {
            let (ends, part) = forward(ends, part);
            let entry = EdgeEntry {
                ends,
                part,
                number,
                copies,
            };
            number += entry.items();
            entry
        })
}

/// Returns the number of items of a tile: its entries, with copies, and their ends of segments.
pub(super) fn count(tile: &Tile, names: LineNames) -> Result<u32, Fault> {
    let mut edges = 0;
    for edge in tile.owned_constraints() {
        let [from, to] = tile.ends(edge).map(|vertex| vertex.point);
        if from == to {
            return Err(Fault::on(edge, "one of its edges has no length"));
        }
        if tile.edge_sources(edge).next().is_none() {
            return Err(Fault::on(edge, "one of its edges is a constraint without a source"));
        }
        edges += 1;
    }
    if edges != tile.edges_with_sources() {
        let reason = "it has sources for edges that are no constraints of its own";
        return Err(Fault::new(reason));
    }
    let mut total = 0;
    for entry in entries(tile, LineNames::Numbers) {
        if entry.copies > 1 && entry.part.kind() != LineKind::Obstacle {
            let [from, to] = entry.ends;
            return Err(Fault::new(format!(
                "its edge from ({}, {}) to ({}, {}) comes from {:?} more than once",
                from.x,
                from.y,
                to.x,
                to.y,
                entry.part.source()
            )));
        }
        total += entry.items();
    }
    Ok(match names {
        LineNames::Numbers => total,
        LineNames::Kinds => entries(tile, names).map(|entry| entry.items()).sum(),
    })
}
