//! Collections of features, as the tool prints them.

use delaunay_tiles_answers::values::{COLLECTION_END, write_feature};
use serde_json::Value;

use crate::problem::Problem;

/// Writes a collection of features after its head.
///
/// # Errors
/// Never, because memory takes all bytes.
pub fn write(head: String, features: impl IntoIterator<Item = Value>) -> Result<Vec<u8>, Problem> {
    let mut out = head.into_bytes();
    for (feature, before) in features.into_iter().zip(0..) {
        write_feature(&mut out, before, &feature).map_err(|_| Problem::defect())?;
    }
    out.extend_from_slice(COLLECTION_END.as_bytes());
    out.push(b'\n');
    Ok(out)
}
