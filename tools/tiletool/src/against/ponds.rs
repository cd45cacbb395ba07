//! The ponds of a build, with the z that the tile file has at their shores.

use delaunay_tiles::TileReader;
use delaunay_tiles::input::{PointBatch, SegmentBatch};
use delaunay_tiles::terrain::{Ponds, Shores, Surface};

use crate::lines::LineInput;

/// The ponds of a build, and the z at the ends of each edge of their shores.
pub struct BuildPonds {
    ponds: Ponds,
    z_of_edges: Vec<[f64; 2]>,
}

impl BuildPonds {
    /// Reads the shores, which come before all other lines. Returns `None` if there are no ponds.
    pub async fn of(mut lines: LineInput, reader: &TileReader) -> anyhow::Result<Option<Self>> {
        let (mut shores, mut batch) = (Shores::default(), SegmentBatch::default());
        while lines.next_batch(&mut batch)?.is_some() && lines.is_of_ponds() {
            shores.push(&batch);
        }
        if shores.count() == 0 {
            return Ok(None);
        }
        let (mut z, all) = (Vec::new(), Surface::default().holes(true));
        for corner in shores.corners() {
            z.push(reader.surface_z(corner.x, corner.y, all).await?.unwrap_or(f64::NAN));
        }
        let ponds = shores.with_z(z);
        let z_of_edges = ponds.z_of_edges();
        Ok(Some(Self { ponds, z_of_edges }))
    }

    /// Returns the bytes that ponds take per edge.
    pub fn byte_size(&self) -> u64 {
        self.z_of_edges.len() as u64 * Shores::BYTES_PER_EDGE
    }

    /// Returns the z at the ends of each edge of the shores, in the order of the files.
    pub fn z_of_edges(&self) -> &[[f64; 2]] {
        &self.z_of_edges
    }

    /// Gives the z of their pond to the points that are in ponds.
    pub fn flatten(&self, batch: &mut PointBatch) {
        for (at, &point) in batch.points.iter().enumerate() {
            if let Some(z) = self.ponds.z_at(point.normalized()) {
                batch.z.resize(batch.points.len(), f64::NAN);
                batch.z[at] = z;
            }
        }
    }
}
