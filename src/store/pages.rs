//! The directory of an open file, page by page: what a tile or a cell needs of it is read on
//! demand.
//!
//! The root stays in memory, and so does each list of pages once it is read: together they take
//! less than a thousandth of the directory. Pages are in the cache.

use std::io;
use std::sync::Arc;

use bytes::Bytes;
use futures::future;
use futures::future::{BoxFuture, FutureExt};
use tokio::sync::OnceCell;

use crate::io::{FIRST_READ, ReadAt};
use crate::store::cache::{Cache, PageKey};
use crate::store::error::ReadError;
use crate::store::format::damage::Damage;
use crate::store::format::directory::Directory;
use crate::store::format::entry::TileEntry;
use crate::store::format::extent::Extent;
use crate::store::format::flat_buffer::{check_crc, within};
use crate::store::format::ids::TileId;
use crate::store::format::limits::{BLOCK, FIRST_EXTENT};
use crate::store::format::lists::{CRS, LIST_NAMES, Lists, OfLists, SOURCES, Source, decode_crs, decode_sources};
use crate::store::format::overview::check_apart;
use crate::store::format::page::{Page, PageRef};
use crate::store::format::page_list::PageList;
use crate::store::format::root::Root;
use crate::store::format::superblock::{InForce, Superblock};

/// The maximum number of bytes of consecutive pages that are read at once.
const PAGES_READ: u64 = 4 << 20;

/// The directory of an open file.
pub(super) struct Pages {
    pub(super) name: Arc<str>,
    pub(super) source: Arc<dyn ReadAt>,
    pub(super) in_force: InForce,
    pub(super) root: Root,
    page_lists: Vec<OnceCell<Arc<PageList>>>,
    /// The bytes of the lists that were in the first read.
    first_lists: OfLists<Option<Bytes>>,
    lists: OnceCell<Arc<Lists>>,
    pub(super) cache: Cache,
}

impl Pages {
    /// Reads and checks the superblock in force and the root.
    pub(super) async fn open(source: Arc<dyn ReadAt>, name: Arc<str>, cache: Cache) -> Result<Self, ReadError> {
        let length = source.length();
        let head = source.read_at(0..length.min(FIRST_READ)).await;
        let head = head.map_err(|error| unreadable(&name, "the superblocks", error))?;
        let damaged = |damage: Damage| invalid(&name, damage);
        let in_force = Superblock::choose(&head[..head.len().min(FIRST_EXTENT as usize)]).map_err(damaged)?;
        let Superblock { file_length, root, .. } = in_force.superblock;
        // An edit may have made the file longer since it was opened: the length is that of then.
        if file_length > length && source.read_at(file_length - 1..file_length).await.is_err() {
            return Err(ReadError::Invalid {
                file: Arc::clone(&name),
                reason: format!("it is cut off: it has {length} of {file_length} bytes"),
            });
        }
        let bytes = match within(&head, 0, root) {
            Some(bytes) => bytes,
            None => source
                .read_at(root.range())
                .await
                .map_err(|error| unreadable(&name, "the directory's root", error))?,
        };
        let of_directory = |damage: Damage| damaged(damage.of("its directory is damaged"));
        check_crc("the directory's root", &bytes, root.crc).map_err(of_directory)?;
        let (offset, length) = (root.offset, root.length.into());
        let root = Root::decode(&bytes, file_length).map_err(of_directory)?;
        check_apart(&root.overviews, offset, length).map_err(of_directory)?;
        let mut page_lists = Vec::with_capacity(root.page_lists.len());
        for (place, list) in root.page_lists.iter().enumerate() {
            // What is in memory anyway need not be read again.
            let list = within(&head, 0, list.extent)
                .map(|bytes| PageList::decode(&bytes, place, &root, file_length))
                .transpose()
                .map_err(of_directory)?;
            page_lists.push(OnceCell::new_with(list.map(Arc::new)));
        }
        let first_lists = root.lists.map(|list| within(&head, 0, list?));
        Ok(Self {
            name,
            source,
            in_force,
            // A slice would keep all bytes of the first read in memory.
            first_lists: first_lists.map(|list| list.map(|bytes| Bytes::copy_from_slice(&bytes))),
            root,
            page_lists,
            lists: OnceCell::new(),
            cache,
        })
    }

    fn file_length(&self) -> u64 {
        self.in_force.superblock.file_length
    }

    fn damaged(&self, damage: Damage) -> ReadError {
        invalid(&self.name, damage.of("its directory is damaged"))
    }

    async fn read(&self, what: &str, extent: Extent) -> Result<Bytes, ReadError> {
        let read = self.source.read_at(extent.range()).await;
        read.map_err(|error| unreadable(&self.name, what, error))
    }

    /// Returns the list of pages at a place in the root.
    pub(super) async fn page_list(&self, place: usize) -> Result<Arc<PageList>, ReadError> {
        match self.page_lists[place].get() {
            Some(list) => Ok(Arc::clone(list)),
            None => self.read_page_list(place).await,
        }
    }

    fn read_page_list(&self, place: usize) -> BoxFuture<'_, Result<Arc<PageList>, ReadError>> {
        let load = move || async move {
            let bytes = self.read("a list of pages", self.root.page_lists[place].extent).await?;
            let list = PageList::decode(&bytes, place, &self.root, self.file_length());
            list.map(Arc::new).map_err(|damage| self.damaged(damage))
        };
        let list = self.page_lists[place].get_or_try_init(load);
        list.map(|list| list.cloned()).boxed()
    }

    /// Returns the page with this number.
    pub(super) async fn page(self: &Arc<Self>, number: u32) -> Result<Arc<Page>, ReadError> {
        let place = self.root.list_of_page(number);
        let list = self.page_list(place).await?;
        self.page_in(&list, place, (number - list.first) as usize).await
    }

    /// Returns the page at a place in a list of pages.
    async fn page_in(self: &Arc<Self>, list: &PageList, of_list: usize, place: usize) -> Result<Arc<Page>, ReadError> {
        let page = list.pages[place];
        match self.cache.page(self.key(page.extent)) {
            Some(page) => Ok(page),
            None => {
                let next = list.next_tile(place, self.root.next_tile(of_list));
                self.load_page(page, next).await
            }
        }
    }

    /// Returns a page, and loads it into the cache if need be. The tiles of the next one are numbered
    /// from `next` on.
    fn load_page(self: &Arc<Self>, page: PageRef, next: u32) -> BoxFuture<'_, Result<Arc<Page>, ReadError>> {
        let this = Arc::clone(self);
        let load = move || async move {
            let bytes = this.read("a page of the directory", page.extent).await?;
            let frame = this.root.frame(this.file_length());
            let page = Page::decode(&bytes, &page, next, &frame);
            page.map(Arc::new).map_err(|damage| this.damaged(damage))
        };
        self.cache.load_page(self.key(page.extent), load).boxed()
    }

    fn key(&self, extent: Extent) -> PageKey {
        PageKey {
            file: self.in_force.superblock.file_id,
            offset: extent.offset,
            crc: extent.crc,
        }
    }

    /// Returns the entry of a tile.
    pub(super) async fn entry(self: &Arc<Self>, id: TileId) -> Result<TileEntry, ReadError> {
        let entry = if id.0 < self.root.next_tile {
            let of_list = self.root.list_with(id);
            let list = self.page_list(of_list).await?;
            let page = self.page_in(&list, of_list, list.page_with(id)).await?;
            page.entry(id).copied()
        } else {
            None
        };
        entry.ok_or_else(|| self.no_such_tile(id))
    }

    pub(super) fn no_such_tile(&self, id: TileId) -> ReadError {
        ReadError::NoSuchTile {
            file: Arc::clone(&self.name),
            tile: id,
            tiles: self.root.metadata.tiles as usize,
        }
    }

    /// Returns the entry of a tile, if it is in memory.
    pub(super) fn entry_in_memory(&self, id: TileId) -> Option<TileEntry> {
        let list = self.page_lists.get(self.root.list_with(id))?.get()?;
        let page = list.pages.get(list.page_with(id))?;
        let page = self.cache.peek_page(self.key(page.extent))?;
        page.entry(id).copied()
    }

    /// Returns the bytes of a list, by its place in the order of [`Lists`].
    async fn list(&self, place: usize) -> Result<Option<Bytes>, ReadError> {
        let Some(extent) = self.root.lists[place] else {
            return Ok(None);
        };
        let name = LIST_NAMES[place];
        let bytes = match &self.first_lists[place] {
            Some(bytes) => bytes.clone(),
            None => self.read(name, extent).await?,
        };
        let checked = check_crc(name, &bytes, extent.crc);
        checked.map(|()| Some(bytes)).map_err(|damage| self.damaged(damage))
    }

    /// Returns the lists of the file.
    pub(super) async fn lists(&self) -> Result<Arc<Lists>, ReadError> {
        let lists = self.lists.get_or_try_init(|| async {
            let read: OfLists<_> = future::try_join_all((0..LIST_NAMES.len()).map(|place| self.list(place)))
                .await?
                .try_into()
                .expect("an answer for each list");
            Lists::decode(read).map(Arc::new).map_err(|damage| self.damaged(damage))
        });
        Ok(Arc::clone(lists.await?))
    }

    /// Returns the sources of points, without the other lists.
    pub(super) async fn sources(&self) -> Result<Vec<Source>, ReadError> {
        match self.list(SOURCES).await? {
            Some(bytes) => decode_sources(&bytes).map_err(|damage| self.damaged(damage)),
            None => Ok(Vec::new()),
        }
    }

    /// Returns the coordinate reference system, without the other lists.
    pub(super) async fn crs(&self) -> Result<Option<String>, ReadError> {
        let crs = self.list(CRS).await?.map(|bytes| decode_crs(&bytes));
        crs.transpose().map_err(|damage| self.damaged(damage))
    }

    /// Reads the whole directory.
    pub(super) async fn whole(&self) -> Result<Directory, ReadError> {
        let mut page_lists = Vec::with_capacity(self.root.page_lists.len());
        let mut pages = Vec::new();
        for place in 0..self.root.page_lists.len() {
            let list = self.page_list(place).await?;
            self.pages_of(&list, place, &mut pages).await?;
            page_lists.push(PageList::clone(&list));
        }
        let lists = Lists::clone(&*self.lists().await?);
        let root = self.in_force.superblock.root;
        let whole = Directory::assemble((self.root.clone(), root), &page_lists, pages, lists, self.file_length());
        whole.map_err(|damage| self.damaged(damage))
    }

    /// Reads all pages of a list, many at once.
    async fn pages_of(&self, list: &PageList, of_list: usize, pages: &mut Vec<Page>) -> Result<(), ReadError> {
        let frame = self.root.frame(self.file_length());
        let mut place = 0;
        while let Some(first) = list.pages.get(place) {
            let mut range = first.extent.range();
            let mut end = place + 1;
            while let Some(next) = list.pages.get(end)
                && next.extent.offset == range.end.next_multiple_of(BLOCK)
                && next.extent.range().end - range.start <= PAGES_READ
            {
                range.end = next.extent.range().end;
                end += 1;
            }
            let start = range.start;
            let read = self.source.read_at(range).await;
            let bytes = read.map_err(|error| unreadable(&self.name, "pages of the directory", error))?;
            for place in place..end {
                let (page, next) = (&list.pages[place], list.next_tile(place, self.root.next_tile(of_list)));
                let bytes = within(&bytes, start, page.extent)
                    .ok_or_else(|| self.damaged(Damage::new("a page is shorter than it should be")))?;
                pages.push(Page::decode(&bytes, page, next, &frame).map_err(|damage| self.damaged(damage))?);
            }
            place = end;
        }
        Ok(())
    }
}

fn unreadable(name: &Arc<str>, what: &str, error: io::Error) -> ReadError {
    ReadError::Io {
        file: Arc::clone(name),
        what: what.to_owned(),
        source: Arc::new(error),
    }
}

fn invalid(name: &Arc<str>, damage: Damage) -> ReadError {
    ReadError::Invalid {
        file: Arc::clone(name),
        reason: damage.into(),
    }
}

#[cfg(test)]
mod tests;
