//! A file in an object store, or on a web server, read by byte range.
//!
//! Opening requests the first bytes, and so learns the length and the version (the ETag). These
//! bytes are kept, since every user of a file reads its beginning. Every later request is for this
//! version only: an object that changed is an error, never a mixture of two versions. Ranges that
//! are read at once and are close together become one request. Requests run on a thread of their
//! own, because the connections of a client belong to the runtime in which they were made.

mod address;
mod errors;
mod guard;
mod objects;
mod runtime;

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;
use std::{fmt, io};

use bytes::Bytes;
use futures::StreamExt;
use futures::future::{BoxFuture, FutureExt, ready};
use object_store::path::Path;
use object_store::{
    GetOptions, GetRange, GetResult, OBJECT_STORE_COALESCE_DEFAULT, ObjectStore, ObjectStoreExt, coalesce_ranges,
};

use crate::io::file::{FIRST_READ, ReadAt, length_of};
use crate::shown;
use address::PATIENCE;
use errors::{changed, explained};
pub(crate) use objects::Objects;
use runtime::on_runtime;

/// The alignment of FlatBuffers in memory, which is also that of their offsets in the file.
const ALIGNMENT: usize = 8;
/// The number of bytes allocated before any have arrived.
const TRUSTED: usize = 1 << 20;

/// A file in an object store, for reading. Clones share it.
#[derive(Clone)]
pub struct ObjectFile {
    object: Arc<Object>,
    /// The first bytes of the file.
    beginning: Bytes,
    note: Option<Arc<str>>,
}

struct Object {
    store: Arc<dyn ObjectStore>,
    path: Path,
    /// The name for errors.
    name: String,
    length: u64,
    /// The tag of the version that was opened, if the store has tags.
    e_tag: Option<String>,
}

impl fmt::Debug for ObjectFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("ObjectFile").field(&self.object.name).finish()
    }
}

impl ObjectFile {
    /// Opens the object at `http://…`, `https://…` or `s3://bucket/…`. Credentials for S3, and its
    /// endpoint if it differs from the default, come from environment variables such as
    /// `AWS_ACCESS_KEY_ID`.
    ///
    /// # Errors
    /// Fails if the address is none of these, or with the server's error.
    pub async fn open(url: &str) -> io::Result<Self> {
        Self::open_within(url, PATIENCE).await
    }

    /// Opens an object as [`open`](Self::open) does, with a time limit for each request, from its
    /// start to the last byte of its answer; [`open`](Self::open) uses 30 seconds. A request that
    /// failed is repeated within the same time again, at most three times.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub async fn open_within(url: &str, timeout: Duration) -> io::Result<Self> {
        let (store, path) = address::resolve(url, timeout)?;
        Self::open_named(store, path, shown::text(url).into_owned()).await
    }

    /// Opens an object of any store.
    ///
    /// # Errors
    /// Fails with the store's error.
    pub async fn open_in(store: Arc<dyn ObjectStore>, path: &str) -> io::Result<Self> {
        let name = format!("{store}: {path}");
        let path = Path::parse(path).map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
        Self::open_named(store, path, name).await
    }

    /// Opens an object beside others.
    pub(crate) async fn among(objects: &Objects, path: &str) -> io::Result<Self> {
        Self::open_in(Arc::clone(&objects.store), path).await
    }

    async fn open_named(store: Arc<dyn ObjectStore>, path: Path, name: String) -> io::Result<Self> {
        let opened = async move {
            let options = GetOptions {
                range: Some(GetRange::Bounded(0..FIRST_READ)),
                ..GetOptions::default()
            };
            let answer = match store.get_opts(&path, options).await {
                Ok(answer) => Ok(answer),
                // An empty object satisfies no range request.
                Err(error) => match store.head(&path).await {
                    Ok(meta) if meta.size == 0 => Err(meta),
                    _ => return Err(explained(&name, error)),
                },
            };
            let meta = answer.as_ref().map_or_else(|empty| empty, |answer| &answer.meta);
            let object = Object {
                length: meta.size,
                e_tag: meta.e_tag.clone(),
                store,
                path,
                name,
            };
            let beginning = match answer {
                Ok(answer) => object.collect(answer, 0..FIRST_READ.min(object.length)).await?,
                Err(_) => Bytes::new(),
            };
            Ok((Arc::new(object), beginning))
        };
        let (object, beginning) = on_runtime(opened).await?;
        let note = "the server sends no version tags, so a change while reading may be noticed late";
        Ok(Self {
            note: object.e_tag.is_none().then(|| note.into()),
            object,
            beginning,
        })
    }
}

impl Object {
    /// Requests a range of the version that was opened.
    async fn fetch(&self, range: Range<u64>) -> io::Result<Bytes> {
        if range.is_empty() {
            return Ok(Bytes::new());
        }
        // Weak tags never match.
        let e_tag = self.e_tag.clone().filter(|tag| !tag.starts_with("W/"));
        let options = GetOptions {
            if_match: e_tag,
            range: Some(GetRange::Bounded(range.clone())),
            ..GetOptions::default()
        };
        let answer = self.store.get_opts(&self.path, options).await;
        let answer = answer.map_err(|error| explained(&self.name, error))?;
        // Some servers ignore conditions.
        if answer.meta.size != self.length || self.e_tag.is_some() && answer.meta.e_tag != self.e_tag {
            return Err(changed(&self.name));
        }
        self.collect(answer, range).await
    }

    /// Gathers the bytes of an answer, at an address with the same alignment as the beginning of
    /// the range in the file. Allocates no more memory than bytes have arrived, apart from
    /// [`TRUSTED`].
    async fn collect(&self, answer: GetResult, range: Range<u64>) -> io::Result<Bytes> {
        let length = length_of(&range)?;
        let ahead = (range.start % ALIGNMENT as u64) as usize;
        let mut stream = answer.into_stream();
        let mut bytes = vec![0; ahead];
        bytes.reserve_exact(length.min(TRUSTED));
        while let Some(part) = stream.next().await {
            let part = part.map_err(|error| explained(&self.name, error))?;
            if bytes.is_empty() && part.len() == length && part.as_ptr().addr().is_multiple_of(ALIGNMENT) {
                return Ok(part);
            }
            if part.len() > ahead + length - bytes.len() {
                return Err(self.wrong_length(&range));
            }
            bytes.extend_from_slice(&part);
        }
        if bytes.len() < ahead + length {
            return Err(self.wrong_length(&range));
        }
        Ok(Bytes::from(bytes).slice(ahead..))
    }

    fn wrong_length(&self, range: &Range<u64>) -> io::Error {
        let message = format!("{}: the answer does not have the length of bytes {range:?}", self.name);
        io::Error::new(io::ErrorKind::UnexpectedEof, message)
    }

    fn check(&self, range: &Range<u64>) -> io::Result<()> {
        if length_of(range)? > 0 && range.end > self.length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(())
    }
}

impl ReadAt for ObjectFile {
    fn length(&self) -> u64 {
        self.object.length
    }

    fn backend(&self) -> &'static str {
        "object"
    }

    fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        if let Err(error) = self.object.check(&range) {
            return ready(Err(error)).boxed();
        }
        if range.is_empty() {
            return ready(Ok(Bytes::new())).boxed();
        }
        if range.end <= self.beginning.len() as u64 {
            return ready(Ok(self.beginning.slice(range.start as usize..range.end as usize))).boxed();
        }
        let object = Arc::clone(&self.object);
        on_runtime(async move { object.fetch(range).await })
    }

    fn read_many(&self, ranges: &[Range<u64>]) -> BoxFuture<'static, io::Result<Vec<Bytes>>> {
        if let Some(error) = ranges.iter().find_map(|range| self.object.check(range).err()) {
            return ready(Err(error)).boxed();
        }
        let (object, ranges) = (Arc::clone(&self.object), ranges.to_vec());
        on_runtime(async move {
            // Empty ranges may be at any offset, so they are not requested.
            let asked: Vec<_> = ranges.iter().filter(|range| !range.is_empty()).cloned().collect();
            let fetch = |range| {
                let object = Arc::clone(&object);
                async move { object.fetch(range).await }
            };
            let mut answers = coalesce_ranges(&asked, fetch, OBJECT_STORE_COALESCE_DEFAULT)
                .await?
                .into_iter();
            let answer = |range: &Range<u64>| match range.is_empty() {
                true => Bytes::new(),
                false => answers.next().unwrap_or_default(),
            };
            Ok(ranges.iter().map(answer).collect())
        })
    }
}
