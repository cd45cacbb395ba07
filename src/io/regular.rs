//! Opening of regular files only: opening a FIFO waits for its writer, and opening a device may
//! have any effect.

use std::fs::{File, Metadata, OpenOptions};
use std::io;
use std::os::unix::fs::FileTypeExt;
use std::path::Path;

/// Opens a regular file with the options `how`, and returns its metadata.
///
/// # Errors
/// Fails with [`io::ErrorKind::IsADirectory`] for a folder and with [`io::ErrorKind::InvalidInput`]
/// for anything else that is not a regular file, without opening it. Also fails with the errors of
/// the operating system.
pub fn open_regular(path: &Path, how: &OpenOptions) -> io::Result<(File, Metadata)> {
    require_regular(&std::fs::metadata(path)?)?;
    let file = how.open(path)?;
    let metadata = file.metadata()?;
    require_regular(&metadata)?;
    Ok((file, metadata))
}

/// Fails if the metadata is not that of a regular file.
pub(super) fn require_regular(metadata: &Metadata) -> io::Result<()> {
    let kind = metadata.file_type();
    if kind.is_file() {
        return Ok(());
    }
    if kind.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
    }
    let what = if kind.is_fifo() {
        "a FIFO"
    } else if kind.is_socket() {
        "a socket"
    } else {
        "a device"
    };
    let message = format!("it is {what} and not a file");
    Err(io::Error::new(io::ErrorKind::InvalidInput, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anything_but_a_regular_file_is_an_error_without_waiting() {
        let folder = tempfile::tempdir().unwrap();
        let fifo = folder.path().join("fifo");
        let made = std::process::Command::new("mkfifo").arg(&fifo).status();
        assert!(made.is_ok_and(|status| status.success()));
        let error = |path: &Path| open_regular(path, File::options().read(true)).unwrap_err();
        assert!(error(&fifo).to_string().contains("a FIFO"));
        assert!(error(Path::new("/dev/zero")).to_string().contains("a device"));
        assert_eq!(error(folder.path()).kind(), io::ErrorKind::IsADirectory);
        assert_eq!(error(&folder.path().join("none")).kind(), io::ErrorKind::NotFound);
    }
}
