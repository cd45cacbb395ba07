//! The state from which an interrupted build continues: the plan of its blocks and the journal of
//! finished blocks.
//!
//! ```text
//! plan      magic, CRC-32C, identity of the build, the caller's description, blocks and their runs
//! journal   for each finished block, in order: length u32, CRC-32C u32, block
//! ```
//!
//! A block is written to the journal once its cores and its part of the border log are synced. An
//! entry is either complete or ignored: reading stops at the first invalid entry.

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::{fs, io};

use crate::geometry::{Point, VertexIndex};
use crate::pipeline::error::BuildError;
use crate::pipeline::plan::{Block, BlockPlan, Run};
use crate::pipeline::records::{BlockState, Description, GroupChunks, Pending, Seam, SeamVertex, TileState};
use crate::pipeline::resume::codec::{Decoder, Encoder};
use crate::pipeline::summary::LevelSummary;
use crate::pipeline::work_folder::WorkFolder;
use crate::store::{Codec, Digest, DigestSum, Extent, KdNode, KdTree, Source, TileId, VertexId};

/// The results of a finished block.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct FinishedBlock {
    pub(crate) number: u32,
    pub(crate) state: BlockState,
    /// Extents of the cores of its tiles.
    pub(crate) cores: Vec<Extent>,
    /// Extents of its part of the border log.
    pub(crate) chunks: Vec<GroupChunks>,
}

/// A plan and the build that it belongs to.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SavedPlan {
    /// Inputs, and options that determine the output.
    pub(crate) identity: String,
    pub(crate) description: Description,
    /// One more than the largest record number of the points.
    pub(crate) next_record: u64,
    pub(crate) plan: BlockPlan,
}

const MAGIC: &[u8; 8] = b"dtplan05";

impl SavedPlan {
    /// Writes the plan to `path` atomically: the file is renamed to `path` once it is complete and
    /// synced.
    pub(crate) fn save(&self, path: &Path) -> io::Result<()> {
        let mut out = Encoder::default();
        out.text(&self.identity);
        // Builds with lines are not saved.
        let Description { sources, crs, memo, .. } = &self.description;
        out.list(sources, |out, source| {
            out.text(&source.name);
            out.u64(source.records);
            out.u64(source.first);
        });
        out.list(crs.as_slice(), |out, crs| out.text(crs));
        out.text(memo);
        out.u64(self.next_record);
        put_tree(&mut out, &self.plan.tree);
        out.list(&self.plan.blocks, |out, block| {
            out.u64(block.points);
            out.list(&block.runs, |out, run| {
                out.u32(run.number);
                out.u64(run.points);
                out.u64(run.length);
            });
        });
        out.u64(self.plan.points);
        out.u64(self.plan.merged);
        out.u32(self.plan.has_z.into());
        let crc = crc32c::crc32c(&out.0);
        let unfinished = path.with_extension("new");
        let mut file = File::create(&unfinished)?;
        file.write_all(MAGIC)?;
        file.write_all(&crc.to_le_bytes())?;
        file.write_all(&out.0)?;
        file.sync_all()?;
        fs::rename(unfinished, path)
    }

    /// Reads a plan. Returns `None` if `path` does not exist or holds no valid plan.
    pub(crate) fn load(path: &Path) -> io::Result<Option<Self>> {
        let bytes = match fs::read(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            read => read?,
        };
        let Some((header, body)) = bytes.split_at_checked(12) else {
            return Ok(None);
        };
        if header[..8] != MAGIC[..] || header[8..] != crc32c::crc32c(body).to_le_bytes() {
            return Ok(None);
        }
        Ok(Self::decode(body))
    }

    fn decode(body: &[u8]) -> Option<Self> {
        let mut from = Decoder(body);
        let identity = from.text()?;
        let source = |from: &mut Decoder<'_>| {
            Some(Source {
                name: from.text()?,
                records: from.u64()?,
                first: from.u64()?,
            })
        };
        let description = Description {
            sources: from.list(source)?,
            crs: from.list(Decoder::text)?.pop(),
            memo: from.text()?,
            // Builds with lines are not saved.
            lines: Vec::new(),
        };
        let next_record = from.u64()?;
        let run = |from: &mut Decoder<'_>| {
            Some(Run {
                number: from.u32()?,
                points: from.u64()?,
                length: from.u64()?,
            })
        };
        let block = |from: &mut Decoder<'_>| {
            Some(Block {
                points: from.u64()?,
                runs: from.list(run)?,
            })
        };
        let plan = BlockPlan {
            tree: take_tree(&mut from)?,
            blocks: from.list(block)?,
            points: from.u64()?,
            merged: from.u64()?,
            has_z: from.u32()? != 0,
            ..BlockPlan::default()
        };
        from.end(Self {
            identity,
            description,
            next_record,
            plan,
        })
    }
}

/// Returns the bytes of a journal entry.
pub(crate) fn encode(block: &FinishedBlock, seam: &Seam) -> Vec<u8> {
    let mut out = Encoder(vec![0; 8]);
    out.u32(block.number);
    let state = &block.state;
    out.u32(state.first_tile);
    put_tree(&mut out, &state.tree);
    out.list(&state.tiles, |out, tile| {
        out.u32(tile.vertices);
        out.u32(tile.core_triangles);
        out.rect(tile.bounds);
        for word in tile.core_sum.to_words() {
            out.u64(word);
        }
    });
    for number in [state.duplicates, state.ends, state.late_triangles, state.held_triangles] {
        out.u64(number);
    }
    out.list(&state.levels, |out, level| {
        for number in [level.nodes, level.vertices, level.settled, level.seam_vertices] {
            out.u64(number);
        }
    });
    for word in state.digest.to_words().as_flattened() {
        out.u64(*word);
    }
    out.list(&block.cores, put_extent);
    out.list(&block.chunks, |out, group| {
        for chunks in group {
            out.list(chunks, put_extent);
        }
    });
    out.u64(seam.level as u64);
    out.u64(seam.below);
    out.list(&seam.vertices, |out, vertex| {
        out.u32(vertex.id.tile.0);
        out.u32(vertex.id.index.0);
        out.f64(vertex.point.x);
        out.f64(vertex.point.y);
        out.f64(vertex.z);
    });
    out.list(seam.unsettled.as_flattened(), |out, &corner| out.u32(corner));
    let (length, crc) = (out.0.len() as u32 - 8, crc32c::crc32c(&out.0[8..]));
    out.0[..4].copy_from_slice(&length.to_le_bytes());
    out.0[4..8].copy_from_slice(&crc.to_le_bytes());
    out.0
}

fn take_digest(from: &mut Decoder<'_>) -> Option<Digest> {
    let mut words = [[0; 3]; 7];
    for word in words.as_flattened_mut() {
        *word = from.u64()?;
    }
    Some(Digest::from_words(words))
}

fn take_tile_state(from: &mut Decoder<'_>) -> Option<TileState> {
    Some(TileState {
        vertices: from.u32()?,
        core_triangles: from.u32()?,
        bounds: from.rect()?,
        core_sum: DigestSum::from_words([from.u64()?, from.u64()?, from.u64()?]),
        // Borders come after the journal, and builds with lines have no journal.
        border_triangles: 0,
        owned_triangles: 0,
        constraint_edges: 0,
        components: 0,
        open_components: 0,
    })
}

fn decode(bytes: &[u8]) -> Option<(FinishedBlock, Seam)> {
    let mut from = Decoder(bytes);
    let level = |from: &mut Decoder<'_>| {
        Some(LevelSummary {
            nodes: from.u64()?,
            vertices: from.u64()?,
            settled: from.u64()?,
            seam_vertices: from.u64()?,
        })
    };
    let vertex = |from: &mut Decoder<'_>| {
        let tile = TileId(from.u32()?);
        let index = VertexIndex(from.u32()?);
        Some(SeamVertex {
            id: VertexId { tile, index },
            point: Point::new(from.f64()?, from.f64()?),
            z: from.f64()?,
        })
    };
    let block = FinishedBlock {
        number: from.u32()?,
        state: BlockState {
            first_tile: from.u32()?,
            tree: take_tree(&mut from)?,
            tiles: from.list(take_tile_state)?,
            duplicates: from.u64()?,
            ends: from.u64()?,
            late_triangles: from.u64()?,
            held_triangles: from.u64()?,
            levels: from.list(level)?,
            digest: take_digest(&mut from)?,
        },
        cores: from.list(take_extent)?,
        chunks: from.list(|from| {
            let mut group = GroupChunks::default();
            for chunks in &mut group {
                *chunks = from.list(take_extent)?;
            }
            Some(group)
        })?,
    };
    let seam = Seam {
        level: usize::try_from(from.u64()?).ok()?,
        below: from.u64()?,
        vertices: from.list(vertex)?,
        unsettled: from.list(Decoder::u32)?.as_chunks().0.to_vec(),
        // Builds with segments have no journal.
        pending: Pending::default(),
    };
    from.end((block, seam))
}

/// Reads the entries of a journal, one at a time.
#[derive(Debug)]
pub(crate) struct JournalReader {
    file: File,
    left: u64,
    /// Bytes of the valid entries read so far.
    pub(crate) good: u64,
}

impl JournalReader {
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        Ok(Self {
            left: file.metadata()?.len(),
            file,
            good: 0,
        })
    }

    /// Reads the next entry. Returns `None` at the end or at an invalid entry.
    pub(crate) fn next(&mut self) -> io::Result<Option<(FinishedBlock, Seam)>> {
        let mut header = [0; 8];
        let Some(left) = self.left.checked_sub(8) else {
            return Ok(None);
        };
        self.file.read_exact(&mut header)?;
        let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
        let (length, crc) = (word(0), word(4));
        let Some(left) = left.checked_sub(length.into()) else {
            return Ok(None);
        };
        let mut bytes = vec![0; length as usize];
        self.file.read_exact(&mut bytes)?;
        if crc32c::crc32c(&bytes) != crc {
            return Ok(None);
        }
        self.left = left;
        let entry = decode(&bytes);
        if entry.is_some() {
            self.good += 8 + u64::from(length);
        }
        Ok(entry)
    }
}

/// The blocks that an earlier build finished.
#[derive(Debug, Default)]
pub(crate) struct FinishedBlocks {
    pub(crate) blocks: u32,
    pub(crate) points: u64,
    pub(crate) cores: Vec<Extent>,
    pub(crate) journal_length: u64,
    /// Lengths, in bytes, of the valid parts of the tile file and the border log.
    pub(crate) file_length: u64,
    pub(crate) log_length: u64,
}

impl FinishedBlocks {
    /// Reads the journal. Stops at the first entry that is out of sequence or whose extents reach
    /// beyond the tile file or the border log.
    pub(crate) fn read(folder: &WorkFolder) -> Result<Self, BuildError> {
        let path = folder.journal();
        let cannot = |error| BuildError::io(&path, "read", error);
        let mut this = Self::default();
        let mut reader = match JournalReader::open(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(this),
            opened => opened.map_err(cannot)?,
        };
        let length = |path: &Path| path.metadata().map_or(0, |metadata| metadata.len());
        let (file_length, log_length) = (length(&folder.file()), length(&folder.borders()));
        while let Some((block, seam)) = reader.next().map_err(cannot)? {
            let end_of_cores = block.cores.last().map_or(0, |core| core.range().end);
            let chunks = block.chunks.iter().flatten().flatten();
            let end_of_log = chunks.map(|chunk| chunk.range().end).max().unwrap_or(0);
            if block.number != this.blocks || end_of_cores > file_length || end_of_log > log_length {
                break;
            }
            this.blocks += 1;
            this.points += seam.below + block.state.duplicates;
            this.cores.extend(block.cores);
            this.file_length = end_of_cores;
            this.log_length = this.log_length.max(end_of_log);
            this.journal_length = reader.good;
        }
        Ok(this)
    }
}

fn put_extent(out: &mut Encoder, extent: &Extent) {
    out.u64(extent.offset);
    out.u32(extent.length);
    out.u32(extent.crc);
    out.u32(extent.codec.number().into());
    out.u32(extent.decoded);
}

fn take_extent(from: &mut Decoder<'_>) -> Option<Extent> {
    Some(Extent {
        offset: from.u64()?,
        length: from.u32()?,
        crc: from.u32()?,
        codec: Codec::of_number(u8::try_from(from.u32()?).ok()?)?,
        decoded: from.u32()?,
    })
}

fn put_tree(out: &mut Encoder, tree: &KdTree) {
    out.list(tree.nodes(), |out, node| match *node {
        KdNode::X { cut, right } => {
            out.u32(0);
            out.f64(cut);
            out.u32(right);
        }
        KdNode::Y { cut, right } => {
            out.u32(1);
            out.f64(cut);
            out.u32(right);
        }
        KdNode::Leaf(tile) => {
            out.u32(2);
            out.u32(tile.0);
        }
    });
}

fn take_tree(from: &mut Decoder<'_>) -> Option<KdTree> {
    let node = |from: &mut Decoder<'_>| match from.u32()? {
        0 => Some(KdNode::X {
            cut: from.f64()?,
            right: from.u32()?,
        }),
        1 => Some(KdNode::Y {
            cut: from.f64()?,
            right: from.u32()?,
        }),
        2 => Some(KdNode::Leaf(TileId(from.u32()?))),
        _ => None,
    };
    KdTree::new(from.list(node)?).ok()
}
