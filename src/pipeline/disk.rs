//! The disk space that a build needs.

use crate::pipeline::error::BuildError;
use crate::pipeline::work_folder::WorkFolder;

/// The data that a build has still to write.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DiskLoad {
    pub(crate) points: u64,
    pub(crate) has_z: bool,
    pub(crate) segments: u64,
    /// Bytes that the segments take on the disk when all of them are there.
    pub(crate) segment_bytes: u64,
    /// Bytes of points and segments that are on the disk already and are deleted meanwhile.
    pub(crate) spilled_bytes: u64,
}

impl DiskLoad {
    /// Returns the bytes of the file and the bytes of spilled data.
    ///
    /// Duplicate points take less. Their number is not known yet.
    fn bytes(self) -> [u64; 2] {
        /// Bytes of a vertex in the file, measured without z.
        const VERTEX_BYTES: u64 = 53;
        /// Bytes of the border log for each point, measured with evenly distributed points; with z
        /// its triangles are a third longer.
        const BORDER_BYTES: u64 = 5;
        const BORDER_BYTES_WITH_Z: u64 = 7;
        /// Bytes of an edge's source in the file, and of a segment in the border log, which holds a
        /// fifth of the edges.
        const SOURCE_BYTES: u64 = 8;
        let of_points = self
            .points
            .saturating_mul(VERTEX_BYTES + if self.has_z { 8 } else { 0 });
        let of_segments = self.segments.saturating_mul(SOURCE_BYTES);
        let border_bytes = if self.has_z { BORDER_BYTES_WITH_Z } else { BORDER_BYTES };
        let log = self.points.saturating_mul(border_bytes).saturating_add(of_segments);
        let spilled = log.saturating_add(self.segment_bytes);
        [of_points.saturating_add(of_segments), spilled]
    }
}

/// Checks that the disk has room for the data that a build has still to write.
///
/// Returns [`BuildError::Disk`] if it has not.
pub(crate) fn check_disk(folder: &WorkFolder, load: DiskLoad) -> Result<(), BuildError> {
    let [output, spilled] = load.bytes();
    let there = load.spilled_bytes;
    let needs = if folder.spill() == folder.path() {
        vec![(folder.path(), output.saturating_add(spilled).saturating_sub(there))]
    } else {
        vec![(folder.path(), output), (folder.spill(), spilled.saturating_sub(there))]
    };
    for (path, needed) in needs {
        // If the system does not report free space, the check is skipped.
        let Ok(room) = rustix::fs::statvfs(path) else { continue };
        let free = room.f_bavail.saturating_mul(room.f_frsize);
        if needed > free {
            return Err(BuildError::Disk {
                path: path.to_owned(),
                needed,
                free,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_needed_disk_space_includes_segments() {
        let points = DiskLoad {
            points: 1000,
            ..DiskLoad::default()
        };
        assert_eq!(points.bytes(), [53_000, 5000]);
        let with_segments = DiskLoad {
            segments: 500,
            segment_bytes: 500 * 60,
            has_z: true,
            ..points
        };
        assert_eq!(with_segments.bytes(), [61_000 + 4000, 7000 + 4000 + 30_000]);
        let absurd = DiskLoad {
            points: u64::MAX,
            segments: u64::MAX,
            segment_bytes: u64::MAX,
            ..points
        };
        assert_eq!(absurd.bytes(), [u64::MAX; 2]);
    }
}
