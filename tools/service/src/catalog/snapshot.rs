//! One state of a file.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bytes::{Bytes, BytesMut};
use delaunay_tiles::crs::Crs;
use delaunay_tiles::io::{self, Backend, ReadAt};
use delaunay_tiles::map_tiles::MapSource;
use delaunay_tiles::store::{Cache, OpenOptions, ReadError, TileReader};
use tokio::sync::OnceCell;

/// The length of the two superblocks, the only bytes of a file that edits overwrite.
const HEAD: u64 = 2 * 4096;
/// How often a file is opened again because its superblocks changed meanwhile.
const ATTEMPTS: usize = 5;

/// The number of the next state.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// One state of a file. A request works on one snapshot, so it never sees two states.
pub struct Snapshot {
    /// The reader of this state. Its name is the id.
    pub reader: TileReader,
    /// The coordinate reference system.
    pub crs: Option<Crs>,
    /// A number that no other state of any file has.
    pub number: u64,
    version: Arc<str>,
    /// The superblocks of this state.
    head: Bytes,
    source: Arc<dyn ReadAt>,
    maps: OnceCell<MapSource>,
}

impl Snapshot {
    /// Opens a file.
    ///
    /// # Errors
    /// Fails if the file cannot be read or is no tile file. No error has its path.
    pub async fn open(path: &Path, id: &str, cache: &Cache) -> Result<Self, ReadError> {
        let io_error = |error: std::io::Error| ReadError::Io {
            file: id.into(),
            what: format!("the file: {}", error.kind()),
            source: Arc::new(error),
        };
        for _ in 0..ATTEMPTS {
            let backend = Backend::from_environment().map_err(io_error)?;
            let source = io::open(path, backend).map_err(io_error)?;
            let head = 0..HEAD.min(source.length());
            let before = source.read_at(head.clone()).await.map_err(io_error)?;
            let options = OpenOptions::default().cache(cache);
            let reader = TileReader::open_source(Arc::clone(&source), id, options).await?;
            let crs = reader.crs().await?.map(|text| Crs::new(&text));
            if source.read_at(head).await.map_err(io_error)? == before {
                return Ok(Self {
                    number: NEXT.fetch_add(1, Ordering::Relaxed),
                    version: version(&reader).into(),
                    reader,
                    crs,
                    head: before,
                    source,
                    maps: OnceCell::new(),
                });
            }
        }
        Err(ReadError::Invalid {
            file: id.into(),
            reason: "it changes too quickly".to_owned(),
        })
    }

    /// Returns the name of this state: that of the file, and its generation.
    pub fn version(&self) -> &Arc<str> {
        &self.version
    }

    /// Returns whether another snapshot has the same content.
    pub fn is_same(&self, other: &Self) -> bool {
        let state = |snapshot: &Self| (snapshot.reader.file_id(), snapshot.reader.generation());
        state(self) == state(other)
    }

    /// Returns the file to draw map tiles from. It is opened on the first call.
    ///
    /// # Errors
    /// Fails if it cannot be read.
    pub async fn maps(&self) -> Result<&MapSource, ReadError> {
        self.maps.get_or_try_init(|| MapSource::open(self.reader.clone())).await
    }

    /// Returns the bytes of a range of the file in this state, which must be within its
    /// [length](TileReader::file_length).
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub async fn bytes(&self, range: Range<u64>) -> std::io::Result<Bytes> {
        let read = self.source.read_at(range.clone()).await?;
        let of_head = self.head.len() as u64;
        if range.start >= of_head {
            return Ok(read);
        }
        let end = range.end.min(of_head);
        let mut bytes = BytesMut::from(&self.head[range.start as usize..end as usize]);
        bytes.extend_from_slice(&read[(end - range.start) as usize..]);
        Ok(bytes.freeze())
    }
}

fn version(reader: &TileReader) -> String {
    let id = reader.file_id().to_string();
    format!("{}-{}", &id[..16], reader.generation())
}
