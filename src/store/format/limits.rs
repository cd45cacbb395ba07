//! Sizes and limits of the format.

/// Bytes of a superblock, and the alignment of cores and pages.
pub(crate) const BLOCK: u64 = 4096;
/// The offset of the first extent.
pub(crate) const FIRST_EXTENT: u64 = 2 * BLOCK;
/// The maximum size of a FlatBuffer in a file, in bytes.
pub(crate) const MAX_FLATBUFFER: u64 = 64 << 20;
/// The maximum size of the root, of a list of pages and of a page, in bytes.
pub(crate) const MAX_PAGE: u64 = 16 << 10;
/// The maximum number of tiles in a page.
pub(crate) const PAGE_TILES: u32 = 96;
/// The maximum number of pages in a list of pages.
pub(crate) const LIST_PAGES: u32 = 440;
/// The maximum number of overviews.
pub(crate) const MAX_OVERVIEWS: usize = 32;
/// The maximum number of tiles.
pub(crate) const MAX_TILES: u32 = 2_000_000;
