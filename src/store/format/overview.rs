//! Where the overviews of a file lie, and what the root of the directory says of them.

use std::ops::Range;

use crate::store::format::damage::Damage;
use crate::store::format::generated::directory as schema;
use crate::store::format::limits::{BLOCK, FIRST_EXTENT, MAX_OVERVIEWS};

/// A level of detail: the Delaunay triangulation of a subset of the vertices of the file, stored in
/// the same file.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Overview {
    /// The number of vertices.
    pub vertices: u64,
    /// The number of bytes that it takes in the file.
    pub bytes: u64,
    /// The largest difference of height between the overview and the file at a vertex of the file,
    /// in units of z; 0 without z.
    pub largest_error: f64,
    /// The root mean square of these differences over all vertices of the file; 0 without z.
    pub rms_error: f64,
}

/// An overview, and where it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OverviewEntry {
    /// The offset of its first byte.
    pub(crate) offset: u64,
    /// The generation of the file that it belongs to.
    pub(crate) generation: u64,
    /// The checksum of its superblock.
    pub(crate) crc: u32,
    pub(crate) overview: Overview,
}

impl OverviewEntry {
    /// Returns the range of its bytes.
    pub(super) fn range(&self) -> Range<u64> {
        self.offset..self.end()
    }

    /// Returns the offset behind its last byte.
    fn end(&self) -> u64 {
        self.offset + self.overview.bytes
    }

    /// Returns whether it contains a byte of a part of `length` bytes at `offset`.
    fn overlaps(&self, offset: u64, length: u64) -> bool {
        self.offset < offset.saturating_add(length) && offset < self.end()
    }
}

/// The overviews of a file in one of its generations.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overviews {
    /// Those that may be used, from the finest to the coarsest, and where they are.
    pub(crate) fresh: Vec<Overview>,
    pub(crate) places: Vec<OverviewEntry>,
    /// Those of earlier generations.
    pub(crate) stale: Vec<Overview>,
}

impl Overviews {
    pub(crate) fn of(entries: &[OverviewEntry], generation: u64) -> Self {
        let (places, stale): (Vec<_>, Vec<_>) = entries.iter().partition(|entry| entry.generation == generation);
        let overviews = |entries: &[OverviewEntry]| entries.iter().map(|entry| entry.overview).collect();
        Self {
            fresh: overviews(&places),
            stale: overviews(&stale),
            places,
        }
    }
}

pub(super) fn encode(entry: &OverviewEntry) -> schema::Overview {
    let Overview {
        vertices,
        bytes,
        largest_error,
        rms_error,
    } = entry.overview;
    schema::Overview::new(
        entry.offset,
        bytes,
        entry.generation,
        vertices,
        largest_error,
        rms_error,
        entry.crc,
        0,
    )
}

/// Decodes the overviews of a file of `file_length` bytes. The error says what is wrong.
pub(super) fn decode(
    list: impl ExactSizeIterator<Item = schema::Overview>,
    file_length: u64,
) -> Result<Vec<OverviewEntry>, Damage> {
    if list.len() > MAX_OVERVIEWS {
        let count = list.len();
        return Err(Damage::new(format!(
            "it has {count} overviews, more than {MAX_OVERVIEWS}"
        )));
    }
    let entries: Vec<OverviewEntry> = list.map(|overview| entry(&overview)).collect();
    for (number, entry) in entries.iter().enumerate() {
        let wrong = |what: &str| Err(Damage::new(format!("overview {number} {what}")));
        let end = entry.offset.checked_add(entry.overview.bytes);
        let is_inside = entry.offset >= FIRST_EXTENT && end.is_some_and(|end| end <= file_length);
        if !is_inside || entry.overview.bytes <= FIRST_EXTENT {
            return wrong("does not lie within the file");
        }
        if !entry.offset.is_multiple_of(BLOCK) {
            return wrong("does not start at a multiple of 4096");
        }
        let Overview {
            largest_error,
            rms_error,
            ..
        } = entry.overview;
        let is_error = |error: f64| error.is_finite() && error >= 0.0;
        if !is_error(largest_error) || !is_error(rms_error) || rms_error > largest_error {
            return wrong("has errors that cannot be");
        }
        if entry.generation == 0 || entry.overview.vertices == 0 {
            return wrong("has no vertices or no generation");
        }
        let before = &entries[..number];
        if before
            .iter()
            .any(|other| other.overlaps(entry.offset, entry.overview.bytes))
        {
            return wrong("lies in another one");
        }
        let finer = before.iter().filter(|other| other.generation == entry.generation);
        if finer
            .into_iter()
            .any(|finer| finer.overview.vertices <= entry.overview.vertices)
        {
            return wrong("is not coarser than the one before it");
        }
    }
    Ok(entries)
}

/// Checks that no overview contains a part of the directory.
pub(crate) fn check_apart(entries: &[OverviewEntry], offset: u64, length: u64) -> Result<(), Damage> {
    match entries.iter().position(|entry| entry.overlaps(offset, length)) {
        Some(number) => Err(Damage::new(format!(
            "overview {number} contains a part of the directory"
        ))),
        None => Ok(()),
    }
}

fn entry(overview: &schema::Overview) -> OverviewEntry {
    OverviewEntry {
        offset: overview.offset(),
        generation: overview.generation(),
        crc: overview.crc(),
        overview: Overview {
            vertices: overview.vertices(),
            bytes: overview.length(),
            largest_error: overview.largest_error(),
            rms_error: overview.rms_error(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::format::root::Root;

    const LENGTH: u64 = 1 << 40;

    fn overview(offset: u64, vertices: u64) -> OverviewEntry {
        OverviewEntry {
            offset,
            generation: 3,
            crc: 7,
            overview: Overview {
                vertices,
                bytes: 1 << 33,
                largest_error: 2.0,
                rms_error: 0.5,
            },
        }
    }

    fn decoded(overviews: &[OverviewEntry]) -> Result<Vec<OverviewEntry>, Damage> {
        let root = Root {
            overviews: overviews.to_vec(),
            ..Root::default()
        };
        Ok(Root::decode(&root.encode().into(), LENGTH)?.overviews)
    }

    #[test]
    fn overviews_are_read_as_they_were_written() {
        let both = [overview(8192, 100), overview(1 << 35, 25)];
        assert_eq!(decoded(&both), Ok(both.to_vec()));
        assert_eq!(decoded(&[]), Ok(Vec::new()));
    }

    type Fault = fn(&mut [OverviewEntry; 2]);

    #[test]
    fn overviews_that_cannot_be_are_rejected() {
        let faults: [(Fault, &str); 12] = [
            (|all| all[1].offset = 4096, "within the file"),
            (|all| all[1].offset = LENGTH - 4096, "within the file"),
            (|all| all[1].offset = u64::MAX - 4095, "within the file"),
            (|all| all[1].overview.bytes = 8192, "within the file"),
            (|all| all[1].offset += 8, "multiple of 4096"),
            (|all| all[1].overview.largest_error = f64::NAN, "errors"),
            (|all| all[1].overview.rms_error = f64::INFINITY, "errors"),
            (|all| all[1].overview.rms_error = 2.5, "errors"),
            (|all| all[0].generation = 0, "no generation"),
            (|all| all[1].overview.vertices = 0, "no vertices"),
            (|all| all[1].offset = 4 << 12, "in another one"),
            (|all| all[1].overview.vertices = 100, "not coarser"),
        ];
        for (fault, message) in faults {
            let mut both = [overview(8192, 100), overview(1 << 35, 25)];
            fault(&mut both);
            let error = decoded(&both).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
        let many: Vec<_> = (0..33).map(|i| overview(8192 + (i << 34), 100 - i)).collect();
        assert!(decoded(&many[..32]).is_ok());
        assert!(decoded(&many).is_err());
    }

    #[test]
    fn an_overview_may_not_contain_the_directory() {
        let one = [overview(8192, 100)];
        for (offset, length, is_apart) in [
            (4096, 4096, true),
            (4096, 4097, false),
            (8192 + (1 << 33) - 1, 9, false),
            (8192 + (1 << 33), 9, true),
        ] {
            assert_eq!(check_apart(&one, offset, length).is_ok(), is_apart, "{offset}");
        }
    }
}
