//! Finds vertices by their coordinates.

use crate::geometry::Point;

/// Marks an empty slot.
const NONE: u32 = u32::MAX;

/// Up to this number of searches, reading all points for each is faster than filling a table.
const FEW: usize = 6;

/// A hash table of points by their coordinates, with open addressing: a leaf looks up both ends of
/// each of its segments.
#[derive(Debug)]
pub(crate) struct PointTable<'a> {
    points: &'a [Point],
    /// The index of a point, or [`NONE`]. The number of slots is a power of two and at least twice
    /// the number of points. Without slots, each search reads all points.
    slots: Vec<u32>,
}

impl<'a> PointTable<'a> {
    /// Creates a table of distinct points.
    pub(crate) fn new(points: &'a [Point]) -> Self {
        let mut this = Self {
            points,
            slots: vec![NONE; (2 * points.len()).next_power_of_two().max(2)],
        };
        for (&point, index) in points.iter().zip(0..) {
            let mut slot = this.first_slot(point);
            while this.slots[slot] != NONE {
                slot = this.next_slot(slot);
            }
            this.slots[slot] = index;
        }
        this
    }

    /// Creates a table of distinct points for this number of searches.
    pub(crate) fn for_searches(points: &'a [Point], searches: usize) -> Self {
        match searches > FEW {
            true => Self::new(points),
            false => Self {
                points,
                slots: Vec::new(),
            },
        }
    }

    /// Returns the index of the point with these coordinates.
    pub(crate) fn at(&self, point: Point) -> Option<u32> {
        if self.slots.is_empty() {
            let found = self.points.iter().position(|&other| other == point);
            return found.map(|index| index as u32);
        }
        let mut slot = self.first_slot(point);
        loop {
            match self.slots[slot] {
                NONE => return None,
                index if self.points[index as usize] == point => return Some(index),
                _ => slot = self.next_slot(slot),
            }
        }
    }

    fn first_slot(&self, point: Point) -> usize {
        // Coordinates that are small integers differ only in their high bits. Both halves of a
        // product depend on all of these.
        let mix = |bits: u64| {
            let wide = u128::from(bits) * 0x9e37_79b9_7f4a_7c15;
            (wide >> 64) as u64 ^ wide as u64
        };
        let hash = mix(point.y.to_bits() ^ mix(point.x.to_bits() ^ 0x2545_f491_4f6c_dd1d));
        (hash >> 32) as usize & (self.slots.len() - 1)
    }

    fn next_slot(&self, slot: usize) -> usize {
        (slot + 1) & (self.slots.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_found_and_no_other() {
        let grids = [1.0, 1e-30, 4096.0].map(|step: f64| {
            let coordinates = (0..60).flat_map(move |x| (0..50).map(move |y| (x, y)));
            coordinates
                .map(move |(x, y)| Point::new(f64::from(x) * step, f64::from(y) * step))
                .collect::<Vec<_>>()
        });
        for points in grids {
            let tables = [1, points.len()].map(|searches| PointTable::for_searches(&points, searches));
            for (&point, index) in points.iter().zip(0..) {
                for table in &tables {
                    assert_eq!(table.at(point), Some(index));
                    assert_eq!(table.at(Point::new(point.x, -1.0 - point.y)), None);
                }
            }
        }
        assert_eq!(PointTable::new(&[]).at(Point::new(0.0, 0.0)), None);
    }
}
