//! Borders: after the root, the border log is read back in batches, and every tile gets its border.
//!
//! With segments the log is read twice: each border states the regions of its triangles and of its
//! core's components, and regions are known only after the whole log was read.
//!
//! The next batch is read while threads compute with the one before.

use std::io;
use std::ops::Range;

use parking_lot::Mutex;

use crate::io::Buffers;
pub(crate) use crate::memory::MemoryUse;
use crate::pipeline::conquer::conquest::Conquest;
use crate::pipeline::error::BuildError;
use crate::pipeline::finish::border::{Border, TileRegions, assemble};
use crate::pipeline::finish::border_mesh::BorderMesh;
use crate::pipeline::finish::regions::{RegionFinder, Regions};
use crate::pipeline::output::border_log::{BorderLog, GroupBorders};
use crate::pipeline::output::ordered::{Closed, Ordered};
use crate::pipeline::output::writer::{BorderToWrite, Sender, ToWrite};
use crate::pipeline::records::{GENERATION, Nexts, TileState};
use crate::pipeline::threads::{for_each_ahead, on_threads};
use crate::store::{Digest, Part, TileId, by_tile, component_table};

/// Totals of the borders of a file and of its regions.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct RegionTotals {
    /// Number of all regions; 0 if regions are not distinguished.
    pub(crate) regions: u64,
    /// Number of regions that may extend over several tiles.
    pub(crate) spanning: u64,
    pub(crate) hole_regions: u64,
    /// The digest of all borders, and of the triangles in holes.
    pub(crate) digest: Digest,
}

impl RegionTotals {
    /// Counts the regions that may extend over several tiles.
    fn of(regions: &Regions) -> Self {
        let spanning = regions.spanning();
        Self {
            regions: regions.count,
            spanning: spanning.len() as u64,
            hole_regions: spanning.iter().filter(|region| region.is_hole).count() as u64,
            ..Self::default()
        }
    }
}

/// Assembles the borders of all tiles, batch by batch, and sends them in order.
pub(crate) fn write_borders(
    tiles: &mut [TileState],
    conquest: &Conquest,
    threads: usize,
    sender: &Sender,
) -> Result<RegionTotals, BuildError> {
    let mut log = conquest.log.lock();
    let log = &mut *log;
    let (seeded, nexts, is_whole) = {
        let mut state = conquest.state.lock();
        let of_blocks = state.blocks.iter().flat_map(|block| &block.seeded);
        let mut seeded: Vec<(u32, u32)> = of_blocks.copied().collect();
        seeded.sort_unstable();
        (
            Seeded::of(&seeded),
            std::mem::take(&mut state.next_on_line),
            state.deferred.is_empty(),
        )
    };
    let mut kept = Vec::new();
    let regions = match conquest.rules.has_regions && is_whole {
        true => Some(find_regions(log, tiles, conquest, &seeded, &nexts, threads, &mut kept)?),
        false => None,
    };
    let assembly = BorderAssembly {
        conquest,
        totals: Mutex::new(regions.as_ref().map(RegionTotals::of).unwrap_or_default()),
        regions,
        seeded,
        is_whole,
    };
    let borders = Ordered::new(0, 2 * threads as u32, |_, border| {
        sender.blocking_send(ToWrite::Border(border)).map_err(|_| Closed)
    });
    let write = |batch: &Batch, tiles: &mut [TileState]| {
        let _span = tracing::debug_span!("borders", tile = batch.tiles().start).entered();
        if conquest.options.progress.is_cancelled() || sender.is_closed() {
            return Err(BuildError::Cancelled);
        }
        assembly.batch(batch, tiles, threads, &borders)
    };
    let mut numbers = log.batches(batch_tiles(threads));
    let later = numbers.split_off(kept.len());
    for (batch, numbers) in kept.into_iter().zip(numbers) {
        log.forget_groups(numbers);
        write(&batch, tiles)?;
    }
    for_each_batch(
        conquest,
        threads,
        later,
        |numbers| {
            let groups = log.read_groups(numbers.clone());
            log.forget_groups(numbers);
            groups
        },
        |groups| {
            let (batch, _) = Batch::of(groups, tiles, &nexts, threads, |_, _, _| ())?;
            write(&batch, tiles)
        },
    )?;
    Ok(assembly.totals.into_inner())
}

/// Reads batches of groups of the border log, and passes each to `take`. With more than one thread,
/// the next batch is read on another one meanwhile.
fn for_each_batch(
    conquest: &Conquest,
    threads: usize,
    batches: Vec<Range<usize>>,
    read: impl FnMut(Range<usize>) -> io::Result<Vec<GroupBorders>> + Send,
    mut take: impl FnMut(Vec<GroupBorders>) -> Result<(), BuildError>,
) -> Result<(), BuildError> {
    // Without room, one batch at most waits.
    for_each_ahead(threads, "tile-borders", 0, batches.into_iter().map(read), |groups| {
        if conquest.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        take(groups.map_err(|error| BuildError::io(&conquest.spill, "read the border log in", error))?)
    })
}

/// The state shared by the threads that assemble borders.
struct BorderAssembly<'a> {
    conquest: &'a Conquest,
    regions: Option<Regions>,
    seeded: Seeded,
    /// Whether all segments are inserted, that is, none was deferred.
    is_whole: bool,
    totals: Mutex<RegionTotals>,
}

impl BorderAssembly<'_> {
    /// Assembles the borders of a batch on `threads` threads.
    fn batch<F>(
        &self,
        batch: &Batch,
        tiles: &mut [TileState],
        threads: usize,
        borders: &Ordered<Option<BorderToWrite>, F>,
    ) -> Result<(), BuildError>
    where
        F: FnMut(u32, Option<BorderToWrite>) -> Result<(), Closed> + Send,
    {
        let progress = &self.conquest.options.progress;
        let range = batch.tiles();
        let states = &mut tiles[range.start as usize..range.end as usize];
        let next = Mutex::new(batch.each().zip(states));
        let buffers = Buffers::default();
        let work = || {
            loop {
                let Some(((tile, mesh, group), state)) = next.lock().next() else {
                    return;
                };
                let number = tile.0;
                if progress.is_cancelled() || borders.begin(number).is_err() {
                    borders.close();
                    return;
                }
                let to_write = (state.vertices > 0).then(|| {
                    let border = self.border(tile, state, group, mesh);
                    let encoded = border.draft.encode(tile, GENERATION, &buffers);
                    BorderToWrite {
                        border: self.conquest.options.codec().store(encoded, Part::Border),
                        table: component_table::encode(tile, &border.records),
                    }
                });
                if borders.put(number, to_write).is_err() {
                    return;
                }
                progress.advance(1, u64::from(state.vertices));
            }
        };
        on_threads(threads, work, || borders.close())
    }

    /// Assembles the border of a tile and adds it to the totals.
    fn border(&self, tile: TileId, state: &mut TileState, group: &GroupBorders, mesh: &BorderMesh) -> Border {
        let its_regions = match &self.regions {
            Some(all) => TileRegions::Known {
                all,
                seeded: self.seeded.of_tile(tile),
            },
            None if self.is_whole => TileRegions::One,
            None => TileRegions::Unknown,
        };
        let border = assemble(tile, state, group, mesh, its_regions);
        note_border(state, &border);
        let mut totals = self.totals.lock();
        totals.hole_regions += border.closed_holes;
        totals.digest += border.digest;
        border
    }
}

/// Consecutive groups of the border log, and the mesh around each core.
struct Batch {
    groups: Vec<GroupBorders>,
    meshes: Vec<BorderMesh>,
}

impl Batch {
    /// Makes the mesh around each core, on `threads` threads. Returns what `and_then` returns for
    /// each tile, too.
    fn of<T: Send>(
        groups: Vec<GroupBorders>,
        tiles: &[TileState],
        nexts: &Nexts,
        threads: usize,
        and_then: impl Fn(TileId, &BorderMesh, &GroupBorders) -> T + Sync,
    ) -> Result<(Self, Vec<T>), BuildError> {
        let mut made: Vec<_> = each_tile(&groups).map(|_| None).collect();
        let next = Mutex::new(each_tile(&groups).zip(&mut made));
        let work = || {
            loop {
                let Some(((tile, group), made)) = next.lock().next() else {
                    return;
                };
                let next = nexts.get(&tile).copied();
                let mesh = BorderMesh::of(tile, &tiles[tile.0 as usize], group, next);
                let its = and_then(tile, &mesh, group);
                *made = Some((mesh, its));
            }
        };
        on_threads(threads, work, || {})?;
        drop(next);
        let (meshes, all) = made.into_iter().flatten().unzip();
        Ok((Self { groups, meshes }, all))
    }

    /// Returns the tiles of all groups.
    fn tiles(&self) -> Range<u32> {
        let ends = self.groups.first().zip(self.groups.last());
        ends.map_or(0..0, |(first, last)| first.tiles().start..last.tiles().end)
    }

    /// Returns each tile with its mesh and its group.
    fn each(&self) -> impl Iterator<Item = (TileId, &BorderMesh, &GroupBorders)> {
        let all = each_tile(&self.groups).zip(&self.meshes);
        all.map(|((tile, group), mesh)| (tile, mesh, group))
    }

    /// Returns the size in bytes.
    fn byte_size(&self) -> u64 {
        self.groups.iter().map(GroupBorders::byte_size).sum::<u64>()
            + self.meshes.iter().map(BorderMesh::byte_size).sum::<u64>()
    }
}

/// Returns each tile of groups with its group.
fn each_tile(groups: &[GroupBorders]) -> impl Iterator<Item = (TileId, &GroupBorders)> {
    groups
        .iter()
        .flat_map(|group| group.tiles().map(move |tile| (TileId(tile), group)))
}

/// Returns the least number of tiles of a batch: enough to keep all threads busy.
fn batch_tiles(threads: usize) -> u32 {
    4 * threads as u32
}

/// Adds a border's counts and bounds to its tile's state.
fn note_border(state: &mut TileState, border: &Border) {
    state.border_triangles = border.draft.triangles.len() as u32;
    state.owned_triangles = state.core_triangles + border.digest.triangles.count as u32;
    state.constraint_edges += border.digest.constraint_edges.count;
    state.bounds = state.bounds.union(border.bounds);
}

/// The components of tiles that contain seeds.
struct Seeded {
    components: Vec<u32>,
    /// Tiles with such components, and the range of each in `components`.
    of_tiles: Vec<(TileId, Range<usize>)>,
}

impl Seeded {
    /// Creates the lists from pairs of tile and component, which are sorted.
    fn of(all: &[(u32, u32)]) -> Self {
        Self {
            of_tiles: by_tile(all, |&(tile, _)| tile),
            components: all.iter().map(|&(_, component)| component).collect(),
        }
    }

    /// Returns the components of `tile`, sorted.
    fn of_tile(&self, tile: TileId) -> &[u32] {
        match self.of_tiles.binary_search_by_key(&tile, |(tile, _)| *tile) {
            Ok(index) => &self.components[self.of_tiles[index].1.clone()],
            Err(_) => &[],
        }
    }
}

/// Finds the regions of all triangles.
fn find_regions(
    log: &mut BorderLog,
    tiles: &[TileState],
    conquest: &Conquest,
    seeded: &Seeded,
    nexts: &Nexts,
    threads: usize,
    kept: &mut Vec<Batch>,
) -> Result<Regions, BuildError> {
    let late = log.next_number();
    let open: u64 = tiles.iter().map(|tile| u64::from(tile.open_components)).sum();
    let (needed, budget) = (RegionFinder::BYTES * (late + open), conquest.memory.rest());
    let finder = RegionFinder::new(late, tiles, conquest.holes).filter(|_| needed <= budget);
    let Some(mut finder) = finder else {
        return Err(conquest.memory.shortage(MemoryUse::Regions, needed).into());
    };
    // Batches at the front stay in memory for the second pass while there is room for them.
    let (mut kept_bytes, room, mut is_keeping) = (0, (budget - needed) / 2, true);
    let batches = log.batches(batch_tiles(threads));
    for_each_batch(
        conquest,
        threads,
        batches,
        |numbers| log.read_groups(numbers),
        |groups| {
            let links_of = |tile: TileId, mesh: &BorderMesh, group: &GroupBorders| {
                finder.links_of((tile, &tiles[tile.0 as usize]), mesh, group, &conquest.rules.seeds)
            };
            let (batch, links) = Batch::of(groups, tiles, nexts, threads, links_of)?;
            for ((tile, ..), links) in batch.each().zip(&links) {
                let taken = finder.take(tile, &tiles[tile.0 as usize], links, seeded.of_tile(tile));
                taken.map_err(|source| match source {
                    Some(source) => BuildError::OpenRing {
                        obstacle: source.number(),
                    },
                    None => BuildError::Internal("regions are covered by different obstacles".to_owned()),
                })?;
            }
            kept_bytes += batch.byte_size();
            is_keeping &= kept_bytes <= room;
            if is_keeping {
                kept.push(batch);
            }
            Ok(())
        },
    )?;
    Ok(finder.finish(tiles))
}
