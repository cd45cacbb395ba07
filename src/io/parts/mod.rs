//! A file whose bytes lie in several objects, read as one file.
//!
//! A [manifest] says which bytes lie where. Objects are opened when they are first read.

pub(crate) mod manifest;

use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use foldhash::{HashMap, HashMapExt};
use futures::future::{BoxFuture, FutureExt, ready, try_join_all};
use tokio::sync::OnceCell;

use crate::io::backend::{Backend, open_whole};
use crate::io::file::{ReadAt, length_of};
#[cfg(feature = "object-store")]
use crate::io::object::{ObjectFile, Objects};
use crate::io::output_file::folder_of;
use crate::io::regular::open_regular;
use manifest::{MOST_BYTES, Manifest};

/// The alignment of FlatBuffers in memory, which is also that of their offsets in the file.
const ALIGNMENT: u64 = 8;

/// Opens an object by its name in the manifest.
type Open = dyn Fn(&str) -> BoxFuture<'static, io::Result<Arc<dyn ReadAt>>> + Send + Sync;

/// A file in parts, for reading. Clones share the objects.
#[derive(Clone)]
pub(crate) struct PartsFile(Arc<Inner>);

struct Inner {
    /// In the order of their offsets.
    parts: Vec<PartOf>,
    objects: Vec<Object>,
    open: Box<Open>,
    length: u64,
}

/// Bytes of the file.
struct PartOf {
    range: Range<u64>,
    /// The offset of the first of them in the object.
    from: u64,
    /// The number of the object.
    object: usize,
}

struct Object {
    name: String,
    file: OnceCell<Arc<dyn ReadAt>>,
}

/// A piece of a range that is read.
#[derive(Clone)]
struct Piece {
    /// The object and the bytes of it; `None` between parts.
    of: Option<(usize, Range<u64>)>,
    length: usize,
}

/// Opens a file on disk by its manifest.
pub(super) fn open(path: &Path, backend: Backend) -> io::Result<Arc<dyn ReadAt>> {
    let (file, _) = open_regular(path, std::fs::File::options().read(true))?;
    let mut text = Vec::new();
    file.take(MOST_BYTES + 1).read_to_end(&mut text)?;
    let folder = folder_of(path).to_owned();
    let open = move |name: &str| {
        let opened = open_whole(&folder.join(name), backend);
        ready(opened).boxed()
    };
    Ok(Arc::new(PartsFile::new(&text, open)?))
}

/// Opens a file in an object store, or on a web server, by the address of its manifest.
#[cfg(feature = "object-store")]
pub(crate) async fn open_url(url: &str) -> io::Result<PartsFile> {
    let (objects, path) = Objects::at(url)?;
    open_in(objects, &path).await
}

/// Opens a file in an object store by the path of its manifest.
#[cfg(feature = "object-store")]
pub(crate) async fn open_in(objects: Objects, path: &str) -> io::Result<PartsFile> {
    let manifest = ObjectFile::among(&objects, path).await?;
    // One byte more than it may have tells that it has more.
    let text = manifest.read_at(0..manifest.length().min(MOST_BYTES + 1)).await?;
    let folder = path
        .rsplit_once('/')
        .map_or(String::new(), |(folder, _)| format!("{folder}/"));
    let open = move |name: &str| {
        let (objects, path) = (objects.clone(), format!("{folder}{name}"));
        async move { Ok(Arc::new(ObjectFile::among(&objects, &path).await?) as Arc<dyn ReadAt>) }.boxed()
    };
    PartsFile::new(&text, open)
}

impl PartsFile {
    /// Creates the file of a manifest, whose objects `open` opens.
    pub(super) fn new(
        text: &[u8],
        open: impl Fn(&str) -> BoxFuture<'static, io::Result<Arc<dyn ReadAt>>> + Send + Sync + 'static,
    ) -> io::Result<Self> {
        let invalid =
            |what: String| io::Error::new(io::ErrorKind::InvalidData, format!("the manifest of parts: {what}"));
        if text.len() as u64 > MOST_BYTES {
            return Err(invalid(format!("it has more than {MOST_BYTES} bytes")));
        }
        let manifest = Manifest::parse(text).map_err(invalid)?;
        let length = manifest.length();
        let (mut objects, mut numbers) = (Vec::new(), HashMap::new());
        let parts = manifest.parts.into_iter().map(|part| {
            let object = *numbers.entry(part.name.clone()).or_insert_with(|| {
                objects.push(Object {
                    name: part.name,
                    file: OnceCell::new(),
                });
                objects.len() - 1
            });
            PartOf {
                range: part.range,
                from: part.from,
                object,
            }
        });
        let parts = parts.collect();
        Ok(Self(Arc::new(Inner {
            parts,
            objects,
            open: Box::new(open),
            length,
        })))
    }
}

impl Inner {
    /// Returns the pieces of a range, in order.
    fn pieces(&self, range: &Range<u64>) -> io::Result<Vec<Piece>> {
        if length_of(range)? > 0 && range.end > self.length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let (mut pieces, mut at) = (Vec::new(), range.start);
        let first = self.parts.partition_point(|part| part.range.end <= at);
        for part in &self.parts[first..] {
            if part.range.start >= range.end {
                break;
            }
            let start = part.range.start.max(at);
            pieces.extend((start > at).then(|| Piece {
                of: None,
                length: (start - at) as usize,
            }));
            at = part.range.end.min(range.end);
            let in_object = part.from + (start - part.range.start)..part.from + (at - part.range.start);
            pieces.push(Piece {
                of: Some((part.object, in_object)),
                length: (at - start) as usize,
            });
        }
        Ok(pieces)
    }

    /// Reads ranges of an object.
    async fn read(&self, object: usize, ranges: &[Range<u64>]) -> io::Result<Vec<Bytes>> {
        let Object { name, file } = &self.objects[object];
        let named = |error: io::Error| io::Error::new(error.kind(), format!("its part {name}: {error}"));
        let file = file.get_or_try_init(|| (self.open)(name)).await.map_err(named)?;
        file.read_many(ranges).await.map_err(named)
    }
}

impl ReadAt for PartsFile {
    fn length(&self) -> u64 {
        self.0.length
    }

    fn backend(&self) -> &'static str {
        "parts"
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        let read = self.read_many(&[range]);
        async move { Ok(read.await?.pop().unwrap_or_default()) }.boxed()
    }

    fn read_many(&self, ranges: &[Range<u64>]) -> BoxFuture<'static, io::Result<Vec<Bytes>>> {
        let inner = Arc::clone(&self.0);
        let asked: io::Result<Vec<_>> = ranges
            .iter()
            .map(|range| Ok((range.start, inner.pieces(range)?)))
            .collect();
        let asked = match asked {
            Ok(asked) => asked,
            Err(error) => return ready(Err(error)).boxed(),
        };
        async move {
            let mut of_objects: HashMap<usize, Vec<Range<u64>>> = HashMap::new();
            for (object, range) in asked
                .iter()
                .flat_map(|(_, pieces)| pieces)
                .filter_map(|piece| piece.of.clone())
            {
                of_objects.entry(object).or_default().push(range);
            }
            let reads = of_objects.into_iter().map(|(object, ranges)| {
                let inner = &inner;
                async move { Ok::<_, io::Error>((object, inner.read(object, &ranges).await?.into_iter())) }
            });
            let mut answers: HashMap<_, _> = try_join_all(reads).await?.into_iter().collect();
            let mut next = |object: usize| answers.get_mut(&object).and_then(Iterator::next).unwrap_or_default();
            Ok(asked
                .iter()
                .map(|(start, pieces)| joined(*start, pieces, &mut next))
                .collect())
        }
        .boxed()
    }

    fn rest(&self) {
        let opened = self.0.objects.iter().filter_map(|object| object.file.get());
        opened.for_each(|file| file.rest());
    }
}

/// Returns the bytes of pieces, of which `next` returns those of an object, at an address with the
/// alignment that `start` has in the file.
fn joined(start: u64, pieces: &[Piece], next: &mut dyn FnMut(usize) -> Bytes) -> Bytes {
    if let [
        Piece {
            of: Some((object, _)), ..
        },
    ] = pieces
    {
        return next(*object);
    }
    let ahead = (start % ALIGNMENT) as usize;
    let mut all = vec![0; ahead];
    for piece in pieces {
        match &piece.of {
            Some((object, _)) => all.extend_from_slice(&next(*object)),
            None => all.resize(all.len() + piece.length, 0),
        }
    }
    Bytes::from(all).slice(ahead..)
}
