//! Writes the directory of a tile file, and then the superblocks.
//!
//! ```text
//! new file      superblocks | root, short lists, lists of pages | cores | borders | lists, pages
//! edited file   … what was there …                 | changed tiles | changed lists and pages,
//!                                                    changed lists of pages, root
//! ```
//!
//! Only parts without an extent in the directory's layout are written; the others are in the file
//! already.

use std::io;

use bytes::Bytes;
use xxhash_rust::xxh3::Xxh3;

use crate::io::WriteAt;
use crate::store::format::directory::Directory;
use crate::store::format::extent::Extent;
use crate::store::format::limits::{BLOCK, FIRST_EXTENT, MAX_PAGE, PAGE_TILES};
use crate::store::format::lists::OfLists;
use crate::store::format::metadata::Metadata;
use crate::store::format::page::PageRef;
use crate::store::format::page_list::PageList;
use crate::store::format::root::Root;
use crate::store::format::superblock::{FileId, InForce, Superblock};
use crate::store::writer::TileWriter;

/// The number of bytes of the root, without its references to lists of pages.
const ROOT_BYTES: u64 = 1024;
/// The maximum number of bytes of the lists behind the root, so that they are in the first read.
const SHORT_LISTS_BYTES: u64 = 2560;
/// The alignment of the lists that are no lists of pages.
const LIST_ALIGNMENT: u64 = 8;
/// The number of bytes of a reference to an overview.
const OVERVIEW_BYTES: u64 = 56;
/// The number of bytes for a page in a list of pages.
const PAGE_REF_BYTES: u64 = 34;

/// Returns where the extents of a new file start, given the expected number of tiles, so that the
/// root, short lists and the lists of pages have room before them.
pub(crate) fn front_end_for(tiles: u64) -> u64 {
    // Subtrees fill pages at least by half, unless the tree is out of balance.
    let pages = (2 * tiles).div_ceil(PAGE_TILES.into());
    FIRST_EXTENT + (ROOT_BYTES + SHORT_LISTS_BYTES + PAGE_REF_BYTES * pages).next_multiple_of(BLOCK)
}

/// Returns where the extents of a copy of a file start, so that the directory of this many tiles and
/// overviews has room before them.
pub(crate) fn front_end_of_copy(tiles: u64, overviews: usize) -> u64 {
    let room = OVERVIEW_BYTES * overviews as u64;
    front_end_for(tiles) + room.next_multiple_of(BLOCK)
}

/// What the file is, apart from its content.
#[derive(Clone, Copy, Debug)]
struct Identity {
    generation: u64,
    /// `None` in a new file, whose identity follows from its directory.
    file_id: Option<FileId>,
}

impl<W: WriteAt> TileWriter<W> {
    /// Writes the directory of a new file, synchronises everything to the medium, and then writes
    /// the superblocks.
    ///
    /// Returns the length of the file in bytes.
    pub(crate) async fn finish(self, directory: &Directory) -> io::Result<u64> {
        let identity = Identity {
            generation: 1,
            file_id: None,
        };
        Ok(self.finish_as(directory, identity).await?.file_length)
    }

    /// Finishes a copy of a file like [`finish`](Self::finish). Returns its superblock.
    pub(crate) async fn finish_copy(self, directory: &Directory, of: &InForce) -> io::Result<Superblock> {
        let identity = Identity {
            generation: of.superblock.generation,
            file_id: Some(of.superblock.file_id),
        };
        self.finish_as(directory, identity).await
    }

    /// Finishes a new file like [`finish`](Self::finish) that takes the place of another one, as its
    /// next generation. It has an identity of its own, so that no cache takes its tiles for those of
    /// the other. Returns its length in bytes.
    pub(crate) async fn finish_next(self, directory: &Directory, before: &InForce) -> io::Result<u64> {
        let identity = Identity {
            generation: before.superblock.generation + 1,
            file_id: None,
        };
        Ok(self.finish_as(directory, identity).await?.file_length)
    }

    async fn finish_as(mut self, directory: &Directory, identity: Identity) -> io::Result<Superblock> {
        let superblock = self.write_directory(directory, identity).await?;
        let block = superblock.encode();
        self.file.write_at(0, [&block[..], &block[..]].concat().into()).await?;
        self.sync().await?;
        Ok(superblock)
    }

    /// Replaces the directory of an existing file, whose superblock in force is `before`. Readers
    /// see either the old or the new directory.
    ///
    /// Returns the length of the file in bytes.
    pub(crate) async fn replace(mut self, directory: &Directory, before: &InForce) -> io::Result<u64> {
        let identity = Identity {
            generation: before.superblock.generation + 1,
            file_id: Some(before.superblock.file_id),
        };
        let superblock = self.write_directory(directory, identity).await?;
        self.file
            .write_at(before.other_offset(), superblock.encode().into())
            .await?;
        self.sync().await?;
        Ok(superblock.file_length)
    }

    /// Writes the directory and waits until everything is on the medium. Returns the superblock
    /// that refers to it.
    async fn write_directory(&mut self, directory: &Directory, identity: Identity) -> io::Result<Superblock> {
        let mut hash = Xxh3::new();
        let (lists, short) = self.write_lists(directory, &mut hash).await?;
        let mut pages: Vec<PageRef> = Vec::with_capacity(directory.layout.pages.len());
        for (number, layout) in directory.layout.pages.iter().enumerate() {
            let page = directory.page(number);
            let extent = match layout.extent {
                Some(extent) => extent,
                None => {
                    let bytes = page.encode();
                    hash.update(&bytes);
                    self.append((&within_limit(bytes)?).into(), BLOCK).await?
                }
            };
            pages.push(page.at(extent, directory.metadata.bounds));
        }
        let root = Root {
            metadata: Metadata {
                line_kinds: directory.lists.line_kinds(),
                ..directory.metadata.clone()
            },
            next_tile: directory.tiles.len() as u32,
            pages: pages.len() as u32,
            lists,
            page_lists: Vec::new(),
            tree: directory.layout.top.clone(),
            overviews: directory.overviews.clone(),
        };
        let (root, end) = self.write_root(directory, root, short, &pages, &mut hash).await?;
        self.flush().await?;
        self.sync().await?;
        Ok(Superblock {
            file_id: identity.file_id.unwrap_or(FileId(hash.digest128())),
            generation: identity.generation,
            // Without tiles, nothing may lie behind the room for the root.
            file_length: match self.length() == self.front_end {
                true => end,
                false => self.length(),
            },
            root,
        })
    }

    /// Writes the lists that are not in the file, except for short ones of a new file. Returns where
    /// the lists are, and the short ones, which belong behind the root.
    async fn write_lists(
        &mut self,
        directory: &Directory,
        hash: &mut Xxh3,
    ) -> io::Result<(OfLists<Option<Extent>>, OfLists<Option<Bytes>>)> {
        let mut lists = directory.layout.lists;
        let mut short = OfLists::default();
        let mut room = match self.front_end {
            FIRST_EXTENT => 0,
            _ => SHORT_LISTS_BYTES,
        };
        for ((list, bytes), short) in lists.iter_mut().zip(directory.lists.encode()).zip(&mut short) {
            let Some(bytes) = bytes.map(Bytes::from) else {
                *list = None;
                continue;
            };
            hash.update(&bytes);
            // A list that is as before is in the file already.
            let is_same =
                |before: Extent| (before.length as usize, before.crc) == (bytes.len(), crc32c::crc32c(&bytes));
            if list.is_some_and(is_same) {
                continue;
            }
            let taken = (bytes.len() as u64).next_multiple_of(LIST_ALIGNMENT);
            if taken <= room {
                room -= taken;
                *short = Some(bytes);
            } else {
                *list = Some(self.append((&bytes).into(), LIST_ALIGNMENT).await?);
            }
        }
        Ok((lists, short))
    }

    /// Writes the root, `short` lists, and the lists of pages that are not in the file: behind the
    /// superblocks, if there is room for them. Returns the extent of the root, and where all this
    /// ends.
    async fn write_root(
        &mut self,
        directory: &Directory,
        mut root: Root,
        short: OfLists<Option<Bytes>>,
        pages: &[PageRef],
        hash: &mut Xxh3,
    ) -> io::Result<(Extent, u64)> {
        let layouts = directory.layout.page_lists.iter().enumerate();
        let page_lists = layouts.map(|(place, layout)| {
            let list = directory.page_list(place, pages);
            let new = layout
                .extent
                .is_none()
                .then(|| within_limit(list.encode()))
                .transpose()?;
            Ok((list, layout.extent, new))
        });
        let page_lists: Vec<(PageList, Option<Extent>, Option<Bytes>)> = page_lists.collect::<io::Result<_>>()?;
        // The length of the root does not depend on where the lists are.
        let mut encoded_at = |start: u64, root_length: u64| {
            let mut behind = Behind::new(start + root_length);
            for (list, short) in root.lists.iter_mut().zip(&short) {
                if let Some(bytes) = short {
                    *list = Some(behind.place(bytes, LIST_ALIGNMENT));
                }
            }
            let refs = page_lists.iter().map(|(list, before, new)| match (new, before) {
                (Some(bytes), _) => list.at(behind.place(bytes, 1)),
                (None, before) => list.at(before.expect("a list of pages is new or in the file")),
            });
            root.page_lists = refs.collect();
            within_limit(root.encode()).map(|root| (root, behind))
        };
        let (encoded, behind) = encoded_at(FIRST_EXTENT, 0)?;
        let root_length = encoded.len() as u64;
        let is_in_front = behind.end + root_length + LIST_ALIGNMENT <= self.front_end;
        // Alignments count from the start, which is a multiple of the size of a block.
        let length = encoded_at(FIRST_EXTENT, root_length)?.1.end - FIRST_EXTENT;
        let reused = match is_in_front {
            true => None,
            false => self.take_blocks(length),
        };
        let start = match (is_in_front, reused) {
            (true, _) => FIRST_EXTENT,
            (false, Some(start)) => start,
            (false, None) => self.length().next_multiple_of(BLOCK),
        };
        let (encoded, behind) = encoded_at(start, root_length)?;
        hash.update(&encoded);
        for list in page_lists.iter().filter_map(|(_, _, new)| new.as_ref()) {
            hash.update(list);
        }
        let all: Bytes = [&encoded[..], &behind.bytes].concat().into();
        match is_in_front || reused.is_some() {
            true => self.put(start, all).await?,
            false => drop(self.append((&all).into(), BLOCK).await?),
        }
        Ok((extent_of(start, &encoded), behind.end))
    }
}

/// What lies directly behind the root.
struct Behind {
    end: u64,
    bytes: Vec<u8>,
}

impl Behind {
    fn new(start: u64) -> Self {
        Self {
            end: start,
            bytes: Vec::new(),
        }
    }

    /// Places a part behind the others, at a multiple of `alignment`.
    fn place(&mut self, part: &[u8], alignment: u64) -> Extent {
        let offset = self.end.next_multiple_of(alignment);
        let padding = (offset - self.end) as usize;
        self.bytes.resize(self.bytes.len() + padding, 0);
        self.bytes.extend_from_slice(part);
        self.end = offset + part.len() as u64;
        extent_of(offset, part)
    }
}

fn extent_of(offset: u64, bytes: &[u8]) -> Extent {
    Extent::raw(offset, bytes.len() as u32, crc32c::crc32c(bytes))
}

fn within_limit(bytes: Vec<u8>) -> io::Result<Bytes> {
    if bytes.len() as u64 <= MAX_PAGE {
        return Ok(bytes.into());
    }
    let message = "a part of the directory is larger than the format allows; use larger tiles";
    Err(io::Error::new(io::ErrorKind::FileTooLarge, message))
}
