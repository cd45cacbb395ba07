//! What a batch of points promises, checked.

use crate::input::PointBatch;
use crate::pipeline::error::BuildError;

/// Returns an error if a point is not [valid](crate::geometry::Point::is_valid), a z is not finite, or the
/// arrays differ in length.
pub(crate) fn check_batch(batch: &PointBatch) -> Result<(), BuildError> {
    let (points, z, records) = (batch.points.len(), batch.z.len(), batch.records.len());
    if records != points || !(z == points || z == 0) {
        return Err(BuildError::Batch { points, z, records });
    }
    if let Some((&z, &record)) = batch.z.iter().zip(&batch.records).find(|(z, _)| !z.is_finite()) {
        return Err(BuildError::InvalidZ { record, z });
    }
    let invalid = batch.points.iter().zip(&batch.records).find(|(p, _)| !p.is_valid());
    match invalid {
        Some((&point, &record)) => Err(BuildError::InvalidPoint { record, point }),
        None => Ok(()),
    }
}
