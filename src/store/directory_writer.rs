//! Writes the directory of a tile file, and then the superblocks.
//!
//! ```text
//! new file      superblocks | root, lists of pages | cores | borders | lists, pages
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
use crate::store::format::entry::Extent;
use crate::store::format::limits::{BLOCK, FIRST_EXTENT, MAX_PAGE, PAGE_TILES};
use crate::store::format::metadata::Metadata;
use crate::store::format::page::PageRef;
use crate::store::format::page_list::PageList;
use crate::store::format::root::{PageListRef, Root};
use crate::store::format::superblock::{FileId, InForce, Superblock};
use crate::store::writer::TileWriter;

/// The number of bytes of the root, without its references to lists of pages.
const ROOT_BYTES: u64 = 1024;
/// The number of bytes for a page in a list of pages.
const PAGE_REF_BYTES: u64 = 34;

/// Returns where the extents of a new file start, given the expected number of tiles, so that the
/// root and the lists of pages have room before them.
pub(crate) fn front_end_for(tiles: u64) -> u64 {
    // Subtrees fill pages at least by half, unless the tree is out of balance.
    let pages = (2 * tiles).div_ceil(PAGE_TILES.into());
    FIRST_EXTENT + (ROOT_BYTES + PAGE_REF_BYTES * pages).next_multiple_of(BLOCK)
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
        self.finish_as(directory, identity).await
    }

    /// Finishes a copy of a file like [`finish`](Self::finish).
    pub(crate) async fn finish_copy(self, directory: &Directory, of: &InForce) -> io::Result<u64> {
        let identity = Identity {
            generation: of.superblock.generation,
            file_id: Some(of.superblock.file_id),
        };
        self.finish_as(directory, identity).await
    }

    async fn finish_as(mut self, directory: &Directory, identity: Identity) -> io::Result<u64> {
        let superblock = self.write_directory(directory, identity).await?;
        let block = superblock.encode();
        self.file.write_at(0, [&block[..], &block[..]].concat().into()).await?;
        self.sync().await?;
        Ok(superblock.file_length)
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
        let mut lists = directory.layout.lists;
        for (list, bytes) in lists.iter_mut().zip(directory.lists.encode()) {
            let Some(bytes) = bytes else {
                *list = None;
                continue;
            };
            hash.update(&bytes);
            // A list that is as before is in the file already.
            let is_same =
                |before: Extent| (before.length as usize, before.crc) == (bytes.len(), crc32c::crc32c(&bytes));
            if !list.is_some_and(is_same) {
                *list = Some(self.append((&Bytes::from(bytes)).into(), 8).await?);
            }
        }
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
        };
        let root = self.write_root(directory, root, &pages, &mut hash).await?;
        self.flush().await?;
        self.sync().await?;
        Ok(Superblock {
            file_id: identity.file_id.unwrap_or(FileId(hash.digest128())),
            generation: identity.generation,
            // Without tiles, nothing may lie behind the room for the root.
            file_length: match self.length() == self.front_end {
                true => root.range().end,
                false => self.length(),
            },
            root,
        })
    }

    /// Writes the root and the lists of pages that are not in the file: behind the superblocks, if
    /// there is room for them.
    async fn write_root(
        &mut self,
        directory: &Directory,
        mut root: Root,
        pages: &[PageRef],
        hash: &mut Xxh3,
    ) -> io::Result<Extent> {
        let layouts = directory.layout.page_lists.iter().enumerate();
        let lists: Vec<(PageList, Option<Extent>)> = layouts
            .map(|(place, layout)| (directory.page_list(place, pages), layout.extent))
            .collect();
        let new: Vec<Option<Bytes>> = lists
            .iter()
            .map(|(list, extent)| extent.is_none().then(|| within_limit(list.encode())).transpose())
            .collect::<io::Result<_>>()?;
        // The length of the root does not depend on where the lists are.
        let refs = |extents: &[Extent]| -> Vec<PageListRef> {
            lists
                .iter()
                .zip(extents)
                .map(|((list, _), &extent)| list.at(extent))
                .collect()
        };
        let nowhere = Extent::raw(0, 0, 0);
        root.page_lists = refs(&vec![nowhere; lists.len()]);
        let length = root.encode().len() as u64 + new.iter().flatten().map(|list| list.len() as u64).sum::<u64>();
        let is_in_front = FIRST_EXTENT + length <= self.front_end;
        let start = match is_in_front {
            true => FIRST_EXTENT,
            false => self.length().next_multiple_of(BLOCK),
        };
        let mut end = start + root.encode().len() as u64;
        let mut place = |bytes: &Bytes| {
            let offset = end;
            end += bytes.len() as u64;
            extent_of(offset, bytes)
        };
        let extents = lists.iter().zip(&new).map(|((_, before), new)| match (new, before) {
            (Some(bytes), _) => place(bytes),
            (None, before) => before.unwrap_or(nowhere),
        });
        let extents: Vec<Extent> = extents.collect();
        root.page_lists = refs(&extents);
        let bytes = within_limit(root.encode())?;
        let extent = extent_of(start, &bytes);
        let all = [&[bytes][..], &new.into_iter().flatten().collect::<Vec<_>>()]
            .concat()
            .concat();
        hash.update(&all);
        match is_in_front {
            true => self.file.write_at(start, all.into()).await?,
            false => drop(self.append((&Bytes::from(all)).into(), BLOCK).await?),
        }
        Ok(extent)
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
