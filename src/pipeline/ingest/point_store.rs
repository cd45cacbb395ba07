//! Points in memory, from their own arrival, or that of their block, until their tile is made.

use crate::constraints::without_z::NO_Z;
use crate::geometry::Point;
use crate::input::PointBatch;
use crate::store::divide::Item;

/// The attributes of points, by position.
#[derive(Debug, Default)]
pub(crate) struct Attributes {
    /// z of each point, or empty.
    z: Vec<f64>,
    /// Record number of each point; empty as long as it equals the position.
    records: Vec<u64>,
}

/// All points of a build, or those of a block.
#[derive(Debug, Default)]
pub(crate) struct PointStore {
    pub(crate) items: Vec<Item>,
    pub(crate) attributes: Attributes,
}

impl PointStore {
    /// The most points of a store: positions are 32 bits wide.
    pub(crate) const MAX_POINTS: usize = u32::MAX as usize;

    /// Adds the points of a batch. The store must not exceed [`MAX_POINTS`](Self::MAX_POINTS)
    /// points.
    pub(crate) fn push(&mut self, batch: &PointBatch) {
        let first = self.items.len() as u64;
        let items = batch.points.iter().zip(first as u32..);
        self.items.extend(items.map(|(&p, position)| Item {
            point: p.normalized(),
            position,
        }));
        let attributes = &mut self.attributes;
        if !batch.z.is_empty() {
            // Earlier batches may have had no z.
            attributes.z.resize(first as usize, NO_Z);
            attributes.z.extend_from_slice(&batch.z);
        } else if !attributes.z.is_empty() {
            attributes.z.resize(self.items.len(), NO_Z);
        }
        let plain = attributes.records.is_empty() && batch.records.iter().zip(first..).all(|(&r, p)| r == p);
        if !plain {
            if attributes.records.is_empty() {
                attributes.records.extend(0..first);
            }
            attributes.records.extend_from_slice(&batch.records);
        }
    }

    /// Creates a store with room for `points` points.
    pub(crate) fn with_capacity(points: usize, has_z: bool) -> Self {
        Self {
            items: Vec::with_capacity(points),
            attributes: Attributes {
                z: Vec::with_capacity(if has_z { points } else { 0 }),
                records: Vec::with_capacity(if has_z { points } else { 0 }),
            },
        }
    }

    /// Adds a point of a run. Its position is its record number, as long as that fits in 32 bits
    /// and the points have no other attributes.
    #[inline]
    pub(crate) fn push_record(&mut self, Record { point, z, record }: Record, has_z: bool) {
        let attributes = &mut self.attributes;
        let mut position = record as u32;
        if has_z || u64::from(position) != record || !attributes.records.is_empty() {
            if attributes.records.is_empty() {
                attributes
                    .records
                    .extend(self.items.iter().map(|item| u64::from(item.position)));
                for (item, index) in self.items.iter_mut().zip(0..) {
                    item.position = index;
                }
            }
            position = self.items.len() as u32;
            attributes.records.push(record);
            if has_z {
                attributes.z.resize(self.items.len(), NO_Z);
                attributes.z.push(z);
            }
        }
        self.items.push(Item { point, position });
    }

    /// Returns the bytes that the points take.
    pub(crate) fn byte_size(&self) -> u64 {
        let attributes = self.attributes.z.len() + self.attributes.records.len();
        (self.items.len() * size_of::<Item>() + attributes * 8) as u64
    }
}

impl Attributes {
    pub(crate) fn has_z(&self) -> bool {
        !self.z.is_empty()
    }

    /// Returns the z at a position, or [`NO_Z`].
    pub(crate) fn z(&self, position: u32) -> f64 {
        self.z.get(position as usize).copied().unwrap_or(NO_Z)
    }

    /// Sets the z at a position of points that have z.
    pub(crate) fn set_z(&mut self, position: u32, z: f64) {
        self.z[position as usize] = z;
    }

    pub(crate) fn record(&self, position: u32) -> u64 {
        self.records.get(position as usize).copied().unwrap_or(position.into())
    }
}

/// A point with its attributes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Record {
    pub(crate) point: Point,
    pub(crate) z: f64,
    pub(crate) record: u64,
}
