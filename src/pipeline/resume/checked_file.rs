//! Files with a checksum, which are replaced as a whole.
//!
//! ```text
//! 0   magic     8 bytes
//! 8   CRC-32C   of the body, u32
//! 12  body
//! ```

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

/// Bytes before the body.
const HEADER: usize = 12;

/// Writes a file atomically: it is renamed to `path` once it is complete and synced.
pub(crate) fn write(path: &Path, magic: &[u8; 8], body: &[u8]) -> io::Result<()> {
    let unfinished = path.with_extension("new");
    let mut file = File::create(&unfinished)?;
    file.write_all(&bytes(magic, body))?;
    file.sync_all()?;
    fs::rename(unfinished, path)
}

/// Returns the bytes of a file.
pub(crate) fn bytes(magic: &[u8; 8], body: &[u8]) -> Vec<u8> {
    [&magic[..], &crc32c::crc32c(body).to_le_bytes(), body].concat()
}

/// Reads the body of a file. Returns `None` if there is no file, or if it is damaged.
pub(crate) fn read(path: &Path, magic: &[u8; 8]) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = match fs::read(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        read => read?,
    };
    let Some((header, body)) = bytes.split_at_checked(HEADER) else {
        return Ok(None);
    };
    if header[..8] != magic[..] || header[8..] != crc32c::crc32c(body).to_le_bytes() {
        return Ok(None);
    }
    Ok(Some(bytes.split_off(HEADER)))
}
