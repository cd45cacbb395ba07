//! The location of the test data.
#![allow(dead_code, reason = "each test uses its part")]

use std::env;
use std::path::PathBuf;

/// Returns the path of a file of the repository's test data.
pub fn data(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data").join(path)
}

/// Returns the path of a file of the data that is too large, or not free, to be in the repository,
/// if it is there: in the folder that the environment variable `DELAUNAY_TILES_SHARED_DATA` names,
/// or in `shared/data` beside the repository. Otherwise says so and returns `None`.
pub fn shared(path: &str) -> Option<PathBuf> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let beside = root
        .ancestors()
        .skip(2)
        .take(2)
        .map(|folder| folder.join("shared/data"));
    let named = env::var_os("DELAUNAY_TILES_SHARED_DATA").map(PathBuf::from);
    let mut paths = named.into_iter().chain(beside).map(|folder| folder.join(path));
    let found = paths.find(|path| path.exists());
    if found.is_none() {
        println!("skipped: {path} is not here");
    }
    found
}
