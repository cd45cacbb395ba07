//! Whole objects of a store, beside one that has a name: they are put there, and fetched.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::PathBuf;
use std::sync::Arc;

use bytes::Bytes;
use foldhash::HashSet;
use futures::future::BoxFuture;
use futures::stream::{self, StreamExt, TryStreamExt};
use object_store::path::Path;
use object_store::{Error, ObjectStore, ObjectStoreExt, WriteMultipart};

use crate::io::object::address::{PATIENCE, resolve};
use crate::io::object::errors::explained;
use crate::io::object::runtime::on_runtime;
use crate::io::pool::blocking;
use crate::shown;

/// The bytes of a request. Stores demand at least 5 MiB of each part of an object but the last one.
const CHUNK: u64 = 8 << 20;
/// The number of requests at once.
const AT_ONCE: usize = 2;

/// Objects of a store. Clones share the connections.
#[derive(Clone, Debug)]
pub(crate) struct Objects {
    pub(super) store: Arc<dyn ObjectStore>,
    /// The address for errors.
    name: Arc<str>,
}

impl Objects {
    /// Opens the store of the object at an address, as [`ObjectFile::open`](crate::io::ObjectFile::open)
    /// does. Returns the path of the object too.
    pub(crate) fn at(url: &str) -> io::Result<(Self, String)> {
        let (store, path) = resolve(url, PATIENCE)?;
        Ok((Self::of(store, &shown::text(url)), path.as_ref().to_owned()))
    }

    /// Returns the objects of any store. Errors contain `name`.
    pub(crate) fn of(store: Arc<dyn ObjectStore>, name: &str) -> Self {
        let name = name.into();
        Self { store, name }
    }

    fn failed(&self, path: &Path) -> impl Fn(Error) -> io::Error + Send + 'static {
        let name = format!("{}: {path}", self.name);
        move |error| explained(&name, error)
    }

    /// Puts an object.
    pub(crate) fn put(&self, path: &str, bytes: Bytes) -> BoxFuture<'static, io::Result<()>> {
        let (path, store) = (key(path), Arc::clone(&self.store));
        let failed = self.failed(&path);
        on_runtime(async move { store.put(&path, bytes.into()).await.map(drop).map_err(failed) })
    }

    /// Puts bytes of a file as an object, which is there when it is complete.
    pub(crate) fn put_file(&self, path: &str, file: File, range: Range<u64>) -> BoxFuture<'static, io::Result<()>> {
        let (path, store, file) = (key(path), Arc::clone(&self.store), Arc::new(file));
        let failed = self.failed(&path);
        on_runtime(async move {
            if range.end - range.start <= CHUNK {
                let bytes = read(&file, range).await?;
                return store.put(&path, bytes.into()).await.map(drop).map_err(failed);
            }
            let upload = store.put_multipart(&path).await.map_err(&failed)?;
            let mut upload = WriteMultipart::new_with_chunk_size(upload, CHUNK as usize);
            for chunk in chunks(range) {
                let written = match read(&file, chunk).await {
                    Ok(bytes) => upload
                        .wait_for_capacity(AT_ONCE)
                        .await
                        .map(|()| upload.put(bytes))
                        .map_err(&failed),
                    Err(error) => Err(error),
                };
                if let Err(error) = written {
                    // What was put costs money until it is aborted, and the first error counts.
                    let _ = upload.abort().await;
                    return Err(error);
                }
            }
            upload.finish().await.map(drop).map_err(failed)
        })
    }

    /// Returns the length of an object; `None` if there is none.
    pub(crate) fn length(&self, path: &str) -> BoxFuture<'static, io::Result<Option<u64>>> {
        let (path, store) = (key(path), Arc::clone(&self.store));
        let failed = self.failed(&path);
        on_runtime(async move {
            match store.head(&path).await {
                Ok(meta) => Ok(Some(meta.size)),
                Err(Error::NotFound { .. }) => Ok(None),
                Err(error) => Err(failed(error)),
            }
        })
    }

    /// Fetches an object into a file, which gets its name when it is complete. Returns `false` if there is
    /// no such object.
    pub(crate) fn fetch(&self, path: &str, to: PathBuf) -> BoxFuture<'static, io::Result<bool>> {
        let length = self.length(path);
        let (path, store) = (key(path), Arc::clone(&self.store));
        let failed = self.failed(&path);
        on_runtime(async move {
            let Some(length) = length.await? else {
                return Ok(false);
            };
            let unfinished = to.with_extension("fetched");
            let file = Arc::new(File::create(&unfinished)?);
            let get = |range: Range<u64>| {
                let (store, path, failed) = (&store, &path, &failed);
                async move { Ok::<_, io::Error>((range.start, store.get_range(path, range).await.map_err(failed)?)) }
            };
            let mut chunks = stream::iter(chunks(0..length)).map(get).buffered(AT_ONCE);
            while let Some((at, bytes)) = chunks.try_next().await? {
                let file = Arc::clone(&file);
                blocking(move || file.write_all_at(&bytes, at)).await.flatten()?;
            }
            std::fs::rename(unfinished, to)?;
            Ok(true)
        })
    }

    /// Returns the file names of the objects in a folder.
    pub(crate) fn names_in(&self, folder: &str) -> BoxFuture<'static, io::Result<Vec<String>>> {
        let (path, store) = (key(folder), Arc::clone(&self.store));
        let failed = self.failed(&path);
        on_runtime(async move {
            let names = store
                .list(Some(&path))
                .map_ok(|meta| meta.location.filename().map(str::to_owned));
            let names: Vec<Option<String>> = names.try_collect().await.map_err(failed)?;
            Ok(names.into_iter().flatten().collect())
        })
    }

    /// Removes the objects in those folders of a path for whose names `goes` is true, but those in `but`.
    pub(crate) fn remove_below(
        &self,
        path: &str,
        goes: fn(&str) -> bool,
        but: &[String],
    ) -> BoxFuture<'static, io::Result<()>> {
        let but: HashSet<Path> = but.iter().map(|path| key(path)).collect();
        let (path, store) = (key(path), Arc::clone(&self.store));
        let failed = self.failed(&path);
        on_runtime(async move {
            let all = store.list(Some(&path)).try_filter_map(|meta| {
                let first = meta.location.prefix_match(&path).and_then(|mut below| below.next());
                let goes = first.is_some_and(|name| goes(name.as_ref())) && !but.contains(&meta.location);
                async move { Ok(goes.then_some(meta.location)) }
            });
            let all: Vec<Path> = all.try_collect().await.map_err(&failed)?;
            for object in all {
                store.delete(&object).await.map_err(&failed)?;
            }
            Ok(())
        })
    }
}

/// Returns the path of an object, which may contain characters that paths have in another form.
fn key(path: &str) -> Path {
    Path::parse(path).unwrap_or_else(|_| Path::from(path))
}

/// Returns the chunks of a range.
fn chunks(range: Range<u64>) -> impl Iterator<Item = Range<u64>> + Send {
    let starts = (range.start..range.end).step_by(CHUNK as usize);
    starts.map(move |start| start..(start + CHUNK).min(range.end))
}

async fn read(file: &Arc<File>, range: Range<u64>) -> io::Result<Bytes> {
    let file = Arc::clone(file);
    let read = blocking(move || {
        let mut bytes = vec![0; (range.end - range.start) as usize];
        file.read_exact_at(&mut bytes, range.start)?;
        Ok(Bytes::from(bytes))
    });
    read.await.flatten()
}

#[cfg(test)]
mod tests {
    use futures::executor::block_on;
    use object_store::memory::InMemory;

    use super::*;

    #[test]
    fn objects_of_any_length_are_put_and_fetched_whole() {
        let folder = tempfile::tempdir().unwrap();
        let [from, to] = ["from", "to"].map(|name| folder.path().join(name));
        let bytes: Vec<u8> = (0..3 * CHUNK + 100_001).map(|i| (i / 7 + i) as u8).collect();
        std::fs::write(&from, &bytes).unwrap();
        let objects = Objects::of(Arc::new(InMemory::new()), "memory");
        block_on(async {
            for range in [
                0..bytes.len(),
                5..6,
                9..9,
                17..CHUNK as usize + 17,
                1..CHUNK as usize + 2,
            ] {
                let file = File::open(&from).unwrap();
                let of_file = range.start as u64..range.end as u64;
                objects.put_file("a/b c", file, of_file).await.unwrap();
                assert_eq!(objects.length("a/b c").await.unwrap(), Some(range.len() as u64));
                assert!(objects.fetch("a/b c", to.clone()).await.unwrap());
                assert!(std::fs::read(&to).unwrap() == bytes[range.clone()], "{range:?}");
            }
            assert!(!objects.fetch("a/none", to.clone()).await.unwrap());
            assert_eq!(objects.length("a/none").await.unwrap(), None);
            let beyond = objects.put_file("a/d", File::open(&from).unwrap(), 0..4 * CHUNK).await;
            assert_eq!(beyond.unwrap_err().kind(), io::ErrorKind::UnexpectedEof);
            assert_eq!(objects.length("a/d").await.unwrap(), None, "an object is not complete");
            objects.put("a/e", Bytes::from_static(b"e")).await.unwrap();
            objects.put("ab", Bytes::from_static(b"ab")).await.unwrap();
            assert_eq!(objects.names_in("a").await.unwrap(), ["b c", "e"]);
            objects.put("a/f", Bytes::from_static(b"f")).await.unwrap();
            let kept = ["a/e".to_owned()];
            objects.remove_below("a", |name| name != "f", &kept).await.unwrap();
            assert_eq!(objects.names_in("a").await.unwrap(), ["e", "f"]);
            assert_eq!(objects.length("ab").await.unwrap(), Some(2));
        });
    }
}
