//! The points of a build, in memory, from their arrival until their tile is made.

use crate::geometry::Point;
use crate::input::PointBatch;

/// A point and its place in the arrays of what goes with it.
///
/// Packed, because a sixth of the memory of a build would be padding.
#[derive(Clone, Copy, Debug)]
#[repr(C, packed(4))]
pub(super) struct Item {
    pub(super) point: Point,
    pub(super) position: u32,
}

/// What goes with the points, by position.
#[derive(Debug, Default)]
pub(super) struct Attributes {
    /// z of each, or nothing.
    z: Vec<f64>,
    /// Record number of each; nothing as long as it equals the position.
    records: Vec<u64>,
}

/// All points that came in.
#[derive(Debug, Default)]
pub(super) struct PointStore {
    pub(super) items: Vec<Item>,
    pub(super) attributes: Attributes,
}

impl PointStore {
    /// The most points that a store holds: positions are 32 bits wide.
    pub(super) const MAX_POINTS: usize = u32::MAX as usize;

    /// Adds the points of a batch; with those before, they must not be more than [`MAX_POINTS`](Self::MAX_POINTS).
    pub(super) fn push(&mut self, batch: &PointBatch) {
        let first = self.items.len() as u64;
        let items = batch.points.iter().zip(first as u32..);
        self.items.extend(items.map(|(&p, position)| Item {
            point: p.normalized(),
            position,
        }));
        let attributes = &mut self.attributes;
        if !batch.z.is_empty() {
            // Batches before may have come without z.
            attributes.z.resize(first as usize, 0.0);
            attributes.z.extend_from_slice(&batch.z);
        } else if !attributes.z.is_empty() {
            attributes.z.resize(self.items.len(), 0.0);
        }
        let plain = attributes.records.is_empty() && batch.records.iter().zip(first..).all(|(&r, p)| r == p);
        if !plain {
            if attributes.records.is_empty() {
                attributes.records.extend(0..first);
            }
            attributes.records.extend_from_slice(&batch.records);
        }
    }

    /// Bytes that the points take.
    pub(super) fn byte_size(&self) -> u64 {
        let attributes = self.attributes.z.len() + self.attributes.records.len();
        (self.items.len() * size_of::<Item>() + attributes * 8) as u64
    }
}

impl Attributes {
    pub(super) fn has_z(&self) -> bool {
        !self.z.is_empty()
    }

    /// z at a position; 0 if there is none.
    pub(super) fn z(&self, position: u32) -> f64 {
        self.z.get(position as usize).copied().unwrap_or(0.0)
    }

    pub(super) fn record(&self, position: u32) -> u64 {
        self.records.get(position as usize).copied().unwrap_or(position.into())
    }
}
