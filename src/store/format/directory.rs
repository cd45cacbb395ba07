//! The directory: the k-d tree, an entry for each tile, and the metadata of the whole file.

use bytes::Bytes;
use flatbuffers::FlatBufferBuilder;

use crate::store::format::damage::Damage;
use crate::store::format::entry::{TileEntry, decode_entry, encode_entry};
use crate::store::format::generated::directory as schema;
use crate::store::format::ids::TileId;
use crate::store::format::kd_tree::{KdNode, KdTree};
use crate::store::format::metadata::Metadata;
use crate::store::format::superblock::Superblock;

/// The number of entries in a page. An entry takes 88 bytes, so a page takes a few hundred
/// kilobytes.
const PAGE_ENTRIES: usize = 4096;
/// The maximum number of tiles, for which the root has room: two nodes of 16 bytes each, in 64 MiB.
pub(crate) const MAX_TILES: u32 = 2_000_000;
/// The whole directory of a tile file, in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Directory {
    /// The metadata of the whole file.
    pub metadata: Metadata,
    /// The k-d tree of the cells.
    pub tree: KdTree,
    /// The entry of each tile, in order.
    pub tiles: Vec<TileEntry>,
}

impl Directory {
    /// Encodes the root and the pages after it. Returns the bytes, and the length and CRC-32C of
    /// the root.
    pub(crate) fn encode(&self) -> (Vec<u8>, u32, u32) {
        let pages: Vec<_> = self.tiles.chunks(PAGE_ENTRIES).zip(0u32..).map(encode_page).collect();
        let extents = |first: u64| {
            pages.iter().scan(first, |offset, page| {
                let extent = schema::PageExtent::new(*offset, page.len() as u32, crc32c::crc32c(page));
                *offset += page.len() as u64;
                Some(extent)
            })
        };
        // The offsets of the pages depend on the length of the root, which does not depend on the
        // offsets.
        let length = self.encode_root(extents(0).collect()).len() as u64;
        let mut bytes = self.encode_root(extents(length).collect());
        let (length, crc) = (bytes.len() as u32, crc32c::crc32c(&bytes));
        for page in &pages {
            bytes.extend_from_slice(page);
        }
        (bytes, length, crc)
    }

    fn encode_root(&self, pages: Vec<schema::PageExtent>) -> Vec<u8> {
        let mut builder = FlatBufferBuilder::new();
        let nodes: Vec<_> = self.tree.nodes().iter().map(encode_node).collect();
        let nodes = builder.create_vector(&nodes);
        let pages = builder.create_vector(&pages);
        let root = self
            .metadata
            .encode(&mut builder, self.tiles.len() as u32, nodes, pages);
        builder.finish(root, None);
        padded(builder.finished_data())
    }

    /// Decodes the directory from its bytes, which start with the root. The error says what is
    /// wrong.
    pub(crate) fn decode(bytes: &Bytes, superblock: &Superblock) -> Result<Self, Damage> {
        let root_bytes = bytes
            .get(..superblock.root_length as usize)
            .ok_or_else(|| Damage::new("it is shorter than its root"))?;
        check_crc("the directory's root", root_bytes, superblock.root_crc)?;
        let root: schema::Directory<'_> = verified(root_bytes, "the directory's root")?;
        let nodes = root.nodes().iter().map(decode_node).collect::<Result<_, _>>()?;
        let tree = KdTree::new(nodes).map_err(|damage| damage.of("the k-d tree is broken"))?;
        let mut tiles = Vec::new();
        let mut first = root_bytes.len();
        for extent in root.pages() {
            // Pages must be back to back, so that no directory can make its reader check the same
            // bytes again and again.
            if extent.offset() != first as u64 {
                return Err(Damage::new(format!(
                    "a page starts at byte {}, not {first}",
                    extent.offset()
                )));
            }
            let end = first + extent.length() as usize;
            let page = bytes
                .get(first..end)
                .ok_or_else(|| Damage::new("a page is outside the directory"))?;
            first = end;
            check_crc("a page of the directory", page, extent.crc())?;
            let page: schema::Page<'_> = verified(page, "a page of the directory")?;
            if page.first_tile() as usize != tiles.len() {
                return Err(Damage::new(format!(
                    "a page starts at tile {}, not {}",
                    page.first_tile(),
                    tiles.len()
                )));
            }
            for entry in page.entries() {
                let tile = TileId(tiles.len() as u32);
                tiles.push(decode_entry(entry, superblock).map_err(|damage| damage.of(&format!("tile {tile}")))?);
            }
        }
        if tiles.len() != root.tiles() as usize || tree.tiles() != root.tiles() {
            return Err(Damage::new(format!(
                "it counts {} tiles, but has {} entries and {} cells",
                root.tiles(),
                tiles.len(),
                tree.tiles()
            )));
        }
        let stored: u64 = tiles
            .iter()
            .map(|t| u64::from(t.core.length) + u64::from(t.border.length))
            .sum();
        if stored > superblock.file_length {
            return Err(Damage::new(format!(
                "its tiles take {stored} bytes, more than the file has"
            )));
        }
        let metadata = Metadata::decode(root)?;
        let sum = |count: fn(&TileEntry) -> u32| tiles.iter().map(|t| u64::from(count(t))).sum::<u64>();
        if sum(|t| t.vertices) != metadata.vertices || sum(|t| t.owned_triangles) != metadata.triangles {
            return Err(Damage::new("the counts of its tiles do not add up"));
        }
        Ok(Self { metadata, tree, tiles })
    }
}

fn encode_page((entries, number): (&[TileEntry], u32)) -> Vec<u8> {
    let mut builder = FlatBufferBuilder::new();
    let entries: Vec<_> = entries.iter().map(encode_entry).collect();
    let entries = Some(builder.create_vector(&entries));
    let first_tile = number * PAGE_ENTRIES as u32;
    let root = schema::Page::create(&mut builder, &schema::PageArgs { first_tile, entries });
    builder.finish(root, None);
    padded(builder.finished_data())
}

fn encode_node(node: &KdNode) -> schema::KdNode {
    match *node {
        KdNode::X { cut, right } => schema::KdNode::new(cut, right, 0),
        KdNode::Y { cut, right } => schema::KdNode::new(cut, right, 1),
        KdNode::Leaf(tile) => schema::KdNode::new(0.0, tile.0, 2),
    }
}

fn decode_node(node: &schema::KdNode) -> Result<KdNode, Damage> {
    let (cut, right) = (node.cut(), node.right());
    match node.axis() {
        0 => Ok(KdNode::X { cut, right }),
        1 => Ok(KdNode::Y { cut, right }),
        2 => Ok(KdNode::Leaf(TileId(right))),
        axis => Err(Damage::new(format!("the k-d tree has a node of axis {axis}"))),
    }
}

/// Verifies the structure of a FlatBuffer and returns its root table.
pub(crate) fn verified<'b, T>(bytes: &'b [u8], what: &str) -> Result<T, Damage>
where
    T: flatbuffers::Follow<'b, Inner = T> + flatbuffers::Verifiable + 'b,
{
    // Parts of a buffer may be shared, but unpacking them must not take many times its size.
    let options = flatbuffers::VerifierOptions {
        max_apparent_size: 4 * bytes.len() + 4096,
        ..flatbuffers::VerifierOptions::default()
    };
    flatbuffers::root_with_opts::<T>(&options, bytes)
        .map_err(|error| Damage::new(format!("{what} is no valid FlatBuffer: {error}")))
}

/// Checks a CRC-32C. `what` names the bytes in the error.
pub(crate) fn check_crc(what: &str, bytes: &[u8], expected: u32) -> Result<(), Damage> {
    let found = crc32c::crc32c(bytes);
    if found == expected {
        Ok(())
    } else {
        Err(Damage::new(format!(
            "the checksum of {what} is {found:08x}, not {expected:08x}"
        )))
    }
}

/// Pads a buffer to a multiple of 8 bytes. FlatBuffers align to at most 8 bytes, so a buffer after
/// another one stays aligned.
fn padded(buffer: &[u8]) -> Vec<u8> {
    let mut bytes = buffer.to_vec();
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::format::superblock::FIRST_EXTENT;

    /// A root of 100 KB whose thousand sources share one name would unpack to 100 MB.
    #[test]
    fn a_directory_cannot_unpack_to_many_times_its_size() {
        let mut builder = FlatBufferBuilder::new();
        let name = Some(builder.create_string(&"x".repeat(100_000)));
        let source = schema::SourceArgs {
            name,
            records: 0,
            first: 0,
        };
        let sources: Vec<_> = (0..1000)
            .map(|_| schema::Source::create(&mut builder, &source))
            .collect();
        let sources = Some(builder.create_vector(&sources));
        let nodes = Some(builder.create_vector::<schema::KdNode>(&[]));
        let pages = Some(builder.create_vector::<schema::PageExtent>(&[]));
        let args = schema::DirectoryArgs {
            nodes,
            pages,
            sources,
            ..schema::DirectoryArgs::default()
        };
        let root = schema::Directory::create(&mut builder, &args);
        builder.finish(root, None);
        let bytes = builder.finished_data();
        assert!(flatbuffers::root::<schema::Directory<'_>>(bytes).is_ok());
        assert!(verified::<schema::Directory<'_>>(bytes, "it").is_err());
    }

    #[test]
    fn a_directory_with_many_short_source_names_is_read() {
        let source = |i: u64| crate::store::format::metadata::Source {
            name: "a".repeat(i as usize % 2),
            records: i,
            first: i * 7,
        };
        let directory = Directory {
            metadata: Metadata {
                sources: (0..10_000).map(source).collect(),
                ..Metadata::default()
            },
            ..Directory::default()
        };
        let (bytes, root_length, root_crc) = directory.encode();
        let superblock = Superblock {
            file_id: crate::store::format::superblock::FileId(0),
            generation: 1,
            file_length: FIRST_EXTENT + bytes.len() as u64,
            directory_offset: FIRST_EXTENT,
            directory_length: bytes.len() as u64,
            root_length,
            root_crc,
        };
        assert_eq!(Directory::decode(&bytes.into(), &superblock), Ok(directory));
    }
}
