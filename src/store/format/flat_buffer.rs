//! FlatBuffers as parts of a file: written with padding, and verified before they are read.

use bytes::Bytes;
use flatbuffers::{FlatBufferBuilder, WIPOffset};

use crate::store::format::damage::Damage;
use crate::store::format::entry::Extent;

/// Returns the bytes of a FlatBuffer, padded to a multiple of 8 bytes.
pub(super) fn finished<T>(mut builder: FlatBufferBuilder<'_>, root: WIPOffset<T>) -> Vec<u8> {
    builder.finish(root, None);
    let mut bytes = builder.finished_data().to_vec();
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// Verifies the structure of a FlatBuffer and returns its root table.
pub(crate) fn verified<'b, T>(bytes: &'b [u8], what: &str) -> Result<T, Damage>
where
    T: flatbuffers::Follow<'b, Inner = T> + flatbuffers::Verifiable + 'b,
{
    // Parts of a buffer may be shared, but unpacking them must not take many times its size.
    let options = flatbuffers::VerifierOptions {
        max_apparent_size: 4 * bytes.len() + 4096,
        ..flatbuffers::VerifierOptions::default()
    };
    flatbuffers::root_with_opts::<T>(&options, bytes)
        .map_err(|error| Damage::new(format!("{what} is no valid FlatBuffer: {error}")))
}

/// Checks a CRC-32C. `what` names the bytes in the error.
pub(crate) fn check_crc(what: &str, bytes: &[u8], expected: u32) -> Result<(), Damage> {
    let found = crc32c::crc32c(bytes);
    if found == expected {
        Ok(())
    } else {
        Err(Damage::new(format!(
            "the checksum of {what} is {found:08x}, not {expected:08x}"
        )))
    }
}

/// Returns the bytes of an extent if they are within `bytes`, which start at `offset` in the file.
pub(crate) fn within(bytes: &Bytes, offset: u64, extent: Extent) -> Option<Bytes> {
    let start = usize::try_from(extent.offset.checked_sub(offset)?).ok()?;
    let end = start.checked_add(extent.length as usize)?;
    (end <= bytes.len()).then(|| bytes.slice(start..end))
}
