//! The names of layers of a GeoPackage: `FILE.gpkg:LAYER`.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

/// What separates the file from the layer.
const MARK: &[u8] = b".gpkg:";

/// Returns the file and the layer that a path names; `None` if it names no layer.
pub fn split(path: &Path) -> Option<(&Path, &str)> {
    let bytes = path.as_os_str().as_bytes();
    let at = bytes
        .windows(MARK.len())
        .position(|part| part.eq_ignore_ascii_case(MARK))?;
    let (file, layer) = bytes.split_at(at + MARK.len() - 1);
    let layer = std::str::from_utf8(layer.get(1..)?).ok()?;
    (!layer.is_empty()).then_some((Path::new(OsStr::from_bytes(file)), layer))
}

/// Returns the file that a path names, without the layer.
pub fn file(path: &Path) -> &Path {
    split(path).map_or(path, |(file, _)| file)
}
