//! Borders for a pass over all tiles, many in one read: they are short and lie side by side, and a disk is asked once for all of them
//! instead of once between any two cores.

use std::io;
use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt, Shared};

use crate::io::ReadAt;
use crate::store::format::directory::Directory;
use crate::store::format::ids::TileId;

/// Bytes of borders that are read at once, at most.
const MOST: u64 = 512 << 10;
/// Bytes of memory from which on a pass may have that much more of it.
const MEMORY: u64 = 64 << 20;

type Read = Shared<BoxFuture<'static, Result<Bytes, Arc<io::Error>>>>;

/// Reads borders for tiles that are asked for in order.
pub(super) struct BordersAhead {
    source: Arc<dyn ReadAt>,
    /// The last range that was read, and what came of it.
    last: Option<(Range<u64>, Read)>,
    is_used: bool,
}

/// A border that is being read with others.
pub(super) struct BorderAhead {
    read: Read,
    part: Range<usize>,
}

impl BordersAhead {
    /// For a pass over so many of the tiles, which may use so much memory if there is a limit.
    pub(super) fn new(directory: &Directory, source: &Arc<dyn ReadAt>, tiles: usize, memory: Option<u64>) -> Self {
        Self {
            source: Arc::clone(source),
            last: None,
            is_used: tiles == directory.tiles.len() && memory.is_none_or(|memory| memory >= MEMORY),
        }
    }

    /// The border of a tile, if it is read with others. The read begins when the first of them is awaited.
    pub(super) fn of(&mut self, id: TileId, directory: &Directory) -> Option<BorderAhead> {
        let tiles = directory.tiles.get(id.0 as usize..).filter(|_| self.is_used)?;
        let wanted = tiles.first()?.border.range();
        let holds = |(range, _): &(Range<u64>, Read)| range.start <= wanted.start && wanted.end <= range.end;
        if !self.last.as_ref().is_some_and(holds) {
            let mut range = wanted.clone();
            for next in tiles[1..].iter().map(|tile| tile.border.range()) {
                // They are aligned to 8 bytes.
                if next.start != range.end.next_multiple_of(8) || next.end - range.start > MOST {
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
