//! Opens tile files, and opens them again when they were changed.

#[cfg(feature = "object-store")]
use std::io;
use std::path::Path;
use std::sync::Arc;

use futures::future::FutureExt;

#[cfg(feature = "object-store")]
use crate::io::is_manifest;
use crate::io::{Backend, ReadAt};
use crate::memory::FileShares;
use crate::store::cache::Cache;
use crate::store::error::ReadError;
use crate::store::format::overview::Overviews;
use crate::store::generation_lock::lock_generation;
use crate::store::open_options::{OpenOptions, Origin};
use crate::store::pages::Pages;
use crate::store::reader::TileReader;
use crate::{io as files, shown};

impl TileReader {
    /// Opens a file. Where the name ends with `.parts`, the file is in parts, and this is its manifest.
    ///
    /// # Errors
    ///
    /// Returns an error if the file cannot be read, is no tile file, has a damaged directory, or if
    /// the directory needs more memory than the reader may use.
    pub async fn open(path: impl AsRef<Path>, options: OpenOptions) -> Result<Self, ReadError> {
        let path = path.as_ref();
        let name: Arc<str> = shown::path(path).into();
        let cannot_open = |error| ReadError::Io {
            file: Arc::clone(&name),
            what: "the file".to_owned(),
            source: Arc::new(error),
        };
        let backend = options.backend.map_or_else(Backend::from_environment, Ok);
        let backend = backend.map_err(cannot_open)?;
        let file = loop {
            let file = files::open(path, backend).map_err(cannot_open)?;
            if lock_generation(&file).await {
                break file;
            }
        };
        let origin = Origin::Path(path.to_owned(), options.backend);
        Self::open_from(file, name, options, origin).await
    }

    /// Opens a file on a web server or in an object store: `http://…`, `https://…` or
    /// `s3://bucket/…`. See [`ObjectFile::open`](crate::io::ObjectFile::open). Where the name ends with
    /// `.parts`, the file is in parts, and this is its manifest.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`open`](Self::open), and errors of the server.
    #[cfg(feature = "object-store")]
    pub async fn open_url(url: &str, options: OpenOptions) -> Result<Self, ReadError> {
        let opened: io::Result<Arc<dyn ReadAt>> = match is_manifest(url) {
            true => files::open_url(url).await.map(|file| Arc::new(file) as _),
            false => files::ObjectFile::open(url).await.map(|file| Arc::new(file) as _),
        };
        let file = opened.map_err(|error| ReadError::Io {
            file: shown::text(url).into(),
            what: "the file".to_owned(),
            source: Arc::new(error),
        })?;
        let origin = Origin::Url(url.to_owned());
        Self::open_from(file, shown::text(url).into(), options, origin).await
    }

    /// Opens a file on any backend. Errors contain `name` as the name of the file.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`open`](Self::open).
    pub async fn open_source(
        source: impl ReadAt + 'static,
        name: &str,
        options: OpenOptions,
    ) -> Result<Self, ReadError> {
        Self::open_from(Arc::new(source), name.into(), options, Origin::Given).await
    }

    fn open_from(
        source: Arc<dyn ReadAt>,
        name: Arc<str>,
        options: OpenOptions,
        origin: Origin,
    ) -> impl Future<Output = Result<Self, ReadError>> + Send {
        async move {
            let cache = options.cache;
            let cache = cache.unwrap_or_else(|| Cache::new(FileShares(options.memory).cache()));
            let pages = Pages::open(source, name, cache).await?;
            tracing::debug!(
                file = &*pages.name,
                backend = pages.source.backend(),
                note = pages.source.note(),
                tiles = pages.root.metadata.tiles,
                "opened"
            );
            let overviews = Overviews::of(&pages.root.overviews, pages.in_force.superblock.generation);
            Ok(Self::of(pages, options.memory, overviews, origin))
        }
        .boxed()
    }

    /// Opens the file again if an edit has changed it since it was opened, and returns whether it
    /// has. From then on, this reader sees the new state; others, clones too, and streams that were
    /// begun keep the old one. The cache stays the same. A reader of a given
    /// [source](Self::open_source) keeps what it has.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`open`](Self::open). Then the reader keeps what it has.
    ///
    /// # Example
    ///
    /// ```
    /// use delaunay_tiles::input::PointBatch;
    /// use delaunay_tiles::{BuildOptions, Builder, EditOptions, Editor, OpenOptions, Point, TileReader};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("field.tiles");
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// # let points: Vec<Point> = (0..100).map(|i| Point::new(f64::from(i % 10), f64::from(i / 10))).collect();
    /// # let mut builder = Builder::new(&path, BuildOptions::default())?;
    /// # builder.push(&PointBatch { records: (0..100).collect(), points, z: vec![] }).await?;
    /// # builder.finish().await?;
    /// let mut reader = TileReader::open(&path, OpenOptions::default()).await?;
    /// let mut transaction = Editor::open(&path, EditOptions::default().memory(64 << 20)).await?.begin().await?;
    /// transaction.delete(&[Point::new(0.0, 0.0)])?;
    /// transaction.commit().await?;
    /// assert_eq!(reader.metadata().vertices, 100);
    /// assert!(reader.refresh().await?);
    /// assert_eq!(reader.metadata().vertices, 99);
    /// # Ok(())
    /// # })
    /// # }
    /// ```
    pub async fn refresh(&mut self) -> Result<bool, ReadError> {
        let (origin, options) = self.origin();
        let new = match origin {
            &Origin::Path(ref path, backend) => Self::open(path, OpenOptions { backend, ..options }).await?,
            #[cfg(feature = "object-store")]
            Origin::Url(url) => Self::open_url(url, options).await?,
            Origin::Given => return Ok(false),
        };
        let is_new = (new.file_id(), new.generation()) != (self.file_id(), self.generation());
        if is_new {
            *self = new;
        }
        Ok(is_new)
    }
}
