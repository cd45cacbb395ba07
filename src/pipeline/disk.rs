//! How much room a build needs on the disk.

use crate::pipeline::error::BuildError;
use crate::pipeline::work_folder::WorkFolder;

/// What a build has still to write.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DiskLoad {
    pub(crate) points: u64,
    pub(crate) has_z: bool,
    pub(crate) segments: u64,
    /// Bytes of segments that go to the disk, while all of them are there.
    pub(crate) segment_bytes: u64,
    /// Bytes of points and segments that stand there already, and go away meanwhile.
    pub(crate) spilled_bytes: u64,
}

impl DiskLoad {
    /// Bytes of the file, and of what is spilled.
    ///
    /// Points at one place take less; nobody knows how many there are.
    fn bytes(self) -> [u64; 2] {
        /// Bytes of a vertex in the file, as measured without z.
        const VERTEX_BYTES: u64 = 53;
        /// Bytes of the border log for each point, where points lie evenly.
        const BORDER_BYTES: u64 = 5;
        /// Bytes of an edge's source in the file, and of a segment in the border log: a fifth of the edges are there.
        const SOURCE_BYTES: u64 = 8;
        let of_points = self
            .points
            .saturating_mul(VERTEX_BYTES + if self.has_z { 8 } else { 0 });
        let of_segments = self.segments.saturating_mul(SOURCE_BYTES);
        let log = self.points.saturating_mul(BORDER_BYTES).saturating_add(of_segments);
        let spilled = log.saturating_add(self.segment_bytes);
        [of_points.saturating_add(of_segments), spilled]
    }
}

/// Fails if there is not enough room on the disk for what a build has still to write.
pub(crate) fn check_disk(folder: &WorkFolder, load: DiskLoad) -> Result<(), BuildError> {
    let [output, spilled] = load.bytes();
    let there = load.spilled_bytes;
    let needs = if folder.spill() == folder.path() {
        vec![(folder.path(), output.saturating_add(spilled).saturating_sub(there))]
    } else {
        vec![(folder.path(), output), (folder.spill(), spilled.saturating_sub(there))]
    };
    for (path, needed) in needs {
        // Where the system does not tell, nothing is lost.
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
    fn the_disk_has_room_for_segments_too() {
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
        assert_eq!(with_segments.bytes(), [61_000 + 4000, 5000 + 4000 + 30_000]);
        let absurd = DiskLoad {
            points: u64::MAX,
            segments: u64::MAX,
            segment_bytes: u64::MAX,
            ..points
        };
        assert_eq!(absurd.bytes(), [u64::MAX; 2]);
    }
}
