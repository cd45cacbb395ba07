//! Sites: points with an id. Several may be at the same position. All are kept in memory until
//! their tiles are written.

use crate::constraints::without_z::NO_Z;
use crate::geometry::Point;
use crate::input::{PointBatch, SiteBatch, SiteId};
use crate::pipeline::error::BuildError;

/// Number of sites in a batch of points.
const BATCH: usize = 8192;

/// The sites so far.
#[derive(Debug, Default)]
pub(crate) struct Sites {
    points: Vec<Point>,
    /// z of each site, or empty.
    z: Vec<f64>,
    ids: Vec<SiteId>,
    /// Bytes of the ids that are text.
    text: u64,
}

impl Sites {
    /// Adds the sites of a batch.
    pub(crate) fn push(&mut self, batch: &SiteBatch) -> Result<(), BuildError> {
        let (points, z, ids) = (batch.points.len(), batch.z.len(), batch.ids.len());
        if ids != points || !(z == points || z == 0) {
            return Err(BuildError::SiteBatch { sites: points, z, ids });
        }
        for ((&point, z), site) in batch
            .points
            .iter()
            .zip(batch.z.iter().map(Some).chain(std::iter::repeat(None)))
            .zip(self.count()..)
        {
            let z = z.copied().unwrap_or(NO_Z);
            if !point.is_valid() || z.is_infinite() {
                return Err(BuildError::InvalidSite { site, point, z });
            }
        }
        if z > 0 || !self.z.is_empty() {
            self.z.resize(self.points.len(), NO_Z);
            self.z.extend_from_slice(&batch.z);
            self.z.resize(self.points.len() + points, NO_Z);
        }
        self.points.extend(batch.points.iter().map(|point| point.normalized()));
        let text = |id: &SiteId| match id {
            SiteId::Number(_) => 0,
            SiteId::Text(text) => text.len() as u64,
        };
        self.text += batch.ids.iter().map(text).sum::<u64>();
        self.ids.extend_from_slice(&batch.ids);
        Ok(())
    }

    pub(crate) fn count(&self) -> u64 {
        self.points.len() as u64
    }

    /// Returns the positions of the sites.
    pub(crate) fn points(&self) -> &[Point] {
        &self.points
    }

    pub(crate) fn has_z(&self) -> bool {
        !self.z.is_empty()
    }

    /// Returns whether a site has no z.
    pub(crate) fn lacks_z(&self) -> bool {
        !self.points.is_empty() && (self.z.is_empty() || self.z.iter().any(|z| z.is_nan()))
    }

    /// Returns the size in bytes.
    pub(crate) fn byte_size(&self) -> u64 {
        let bytes = self.points.capacity() * size_of::<Point>()
            + self.z.capacity() * size_of::<f64>()
            + self.ids.capacity() * size_of::<SiteId>();
        bytes as u64 + self.text
    }

    /// Takes all sites out as points, with ascending record numbers from `first_record` on. Their
    /// ids stay.
    pub(crate) fn take_points(&mut self, first_record: u64) -> impl Iterator<Item = PointBatch> + use<> {
        let (points, z) = (std::mem::take(&mut self.points), std::mem::take(&mut self.z));
        let starts = (0..points.len()).step_by(BATCH);
        starts.map(move |start| {
            let end = points.len().min(start + BATCH);
            PointBatch {
                points: points[start..end].to_vec(),
                z: z.get(start..end).unwrap_or_default().to_vec(),
                records: (start as u64..end as u64)
                    .map(|at| first_record.saturating_add(at))
                    .collect(),
            }
        })
    }

    /// Returns the ids, in order.
    pub(crate) fn into_ids(self) -> Vec<SiteId> {
        self.ids
    }
}
