//! The files that are served.
//!
//! A file that is replaced or edited is noticed while the service runs. Requests work on one
//! [snapshot], so they see its old or its new state.

mod id;
mod served;
pub(crate) mod snapshot;
mod stamp;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use delaunay_tiles::shown;
use delaunay_tiles::store::{Cache, ReadError};

pub(crate) use served::Served;
pub(crate) use snapshot::Snapshot;

use crate::problem::Problem;

/// The files that are served, by their ids: the names without folder and ending.
///
/// Clones share the files.
#[derive(Clone)]
pub struct Catalog {
    files: Arc<Vec<Served>>,
    cache: Cache,
}

/// Why files cannot be served. These errors have paths; they are for the one who starts the service.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CatalogError {
    /// A file cannot be read.
    #[error("{file}: it cannot be served")]
    Read {
        /// The path of the file.
        file: String,
        /// The reason, with the id of the file.
        source: ReadError,
    },
    /// The name of a file cannot be an id.
    #[error("{file}: {reason}")]
    Name {
        /// The path of the file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// Two files have the same id.
    #[error("{first} and {second} have the same name in URLs, {id}; rename one of them")]
    Clash {
        /// The id.
        id: String,
        /// The path of the first file.
        first: String,
        /// The path of the second file.
        second: String,
    },
}

impl Catalog {
    /// Opens files. Their tiles are in this cache, which other readers may share. Must be awaited within
    /// a tokio runtime.
    ///
    /// # Errors
    /// Fails if a file cannot be read, if its name cannot be in a URL, or if two have the same.
    pub async fn open(files: impl IntoIterator<Item = impl AsRef<Path>>, cache: &Cache) -> Result<Self, CatalogError> {
        let mut paths: Vec<(String, PathBuf)> = Vec::new();
        for path in files {
            let path = path.as_ref();
            let id = id::of(path).map_err(|reason| CatalogError::Name {
                file: shown::path(path),
                reason,
            })?;
            if let Some((_, first)) = paths.iter().find(|(other, _)| *other == id) {
                return Err(CatalogError::Clash {
                    id,
                    first: shown::path(first),
                    second: shown::path(path),
                });
            }
            paths.push((id, path.to_owned()));
        }
        let mut files = Vec::new();
        for (id, path) in paths {
            let file = shown::path(&path);
            let served = Served::open(id, path, cache).await;
            files.push(served.map_err(|source| CatalogError::Read { file, source })?);
        }
        Ok(Self {
            files: Arc::new(files),
            cache: cache.clone(),
        })
    }

    /// Returns the ids of all files, in the order in which they were given.
    pub fn ids(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|file| &*file.id)
    }

    /// Returns the cache of tiles.
    #[must_use]
    pub fn cache(&self) -> &Cache {
        &self.cache
    }

    pub(crate) fn files(&self) -> &[Served] {
        &self.files
    }

    /// Returns the file of an id.
    pub(crate) fn get(&self, id: &str) -> Result<&Served, Problem> {
        let file = self.files.iter().find(|file| file.id == id);
        file.ok_or_else(|| Problem::missing("path", "there is no file of this name", "see /catalog for all files"))
    }
}
