//! Reads borders for a pass over all tiles, many in one read. Borders are short and adjacent in the
//! file, so one read serves all of them, instead of one read between any two cores.

use std::io;
use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt, Shared};

use crate::io::{HUGE_PAGE, ReadAt};
use crate::store::format::directory::Directory;
use crate::store::format::ids::TileId;

/// The maximum number of bytes of borders per read: with what reads are aligned to, a huge page.
const MAX_READ: u64 = HUGE_PAGE as u64 - (8 << 10);
/// The minimum memory limit, in bytes, with which a pass reads borders ahead.
const MIN_MEMORY: u64 = 64 << 20;

type Read = Shared<BoxFuture<'static, Result<Bytes, Arc<io::Error>>>>;

/// Reads borders for tiles that are requested in order.
pub(super) struct BordersAhead {
    /// The borders of all tiles, each with the component table behind it if there is one, in the
    /// order of the pass. Empty if they are not read ahead.
    borders: Vec<(TileId, Range<u64>)>,
    /// The number of borders of tiles that have been requested.
    requested: usize,
    source: Arc<dyn ReadAt>,
    /// The last range that was read, and its result.
    last: Option<(Range<u64>, Read)>,
}

/// A border that is read together with others.
pub(super) struct BorderAhead {
    read: Read,
    part: Range<usize>,
}

impl BordersAhead {
    /// Creates a reader for a pass over `tiles` tiles that may use `memory` bytes, if there is a
    /// limit.
    pub(super) fn new(directory: &Directory, source: &Arc<dyn ReadAt>, tiles: usize, memory: Option<u64>) -> Self {
        let is_used = tiles == directory.metadata.tiles as usize && memory.is_none_or(|memory| memory >= MIN_MEMORY);
        let borders = directory.tile_ids().filter(|_| is_used);
        Self {
            borders: borders
                .map(|id| {
                    let entry = &directory.tiles[id.0 as usize];
                    (id, entry.border_and_table().unwrap_or(entry.border.range()))
                })
                .collect(),
            requested: 0,
            source: Arc::clone(source),
            last: None,
        }
    }

    /// Returns the border of the next tile, if it is read with others. The read begins when the
    /// first of them is awaited.
    pub(super) fn of(&mut self, id: TileId) -> Option<BorderAhead> {
        let tiles = self.borders.get(self.requested..)?;
        let (next, wanted) = tiles.first()?.clone();
        if next != id {
            return None;
        }
        self.requested += 1;
        let contains = |(range, _): &(Range<u64>, Read)| range.start <= wanted.start && wanted.end <= range.end;
        if !self.last.as_ref().is_some_and(contains) {
            let mut range = wanted.clone();
            for (_, next) in &tiles[1..] {
                // Borders are aligned to 8 bytes.
                if next.start != range.end.next_multiple_of(8) || next.end - range.start > MAX_READ {
                    break;
                }
                range.end = next.end;
            }
            self.last = (range != wanted).then(|| {
                let (source, bytes) = (Arc::clone(&self.source), range.clone());
                let read = async move { source.read_at(bytes).await.map_err(Arc::new) };
                (range, read.boxed().shared())
            });
        }
        let (range, read) = self.last.as_ref()?;
        Some(BorderAhead {
            read: read.clone(),
            part: (wanted.start - range.start) as usize..(wanted.end - range.start) as usize,
        })
    }
}

impl BorderAhead {
    pub(super) async fn bytes(self) -> io::Result<Bytes> {
        let Self { read, part } = self;
        match read.await {
            Ok(bytes) if part.end <= bytes.len() => Ok(bytes.slice(part)),
            Ok(_) => Err(io::ErrorKind::UnexpectedEof.into()),
            Err(error) => Err(io::Error::new(error.kind(), error)),
        }
    }
}
