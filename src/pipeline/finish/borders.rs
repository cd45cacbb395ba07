//! Borders: after the root, the border log is read back group by group, and every tile gets its
//! border.
//!
//! With segments the log is read twice: each border states the regions of its triangles and of its
//! core's components, and regions are known only after the whole log was read.

use std::collections::VecDeque;
use std::ops::Range;

use parking_lot::Mutex;

use crate::io::Buffers;
pub(crate) use crate::memory::MemoryUse;
use crate::pipeline::conquer::conquest::Conquest;
use crate::pipeline::error::BuildError;
use crate::pipeline::finish::border::{Border, TileRegions, assemble};
use crate::pipeline::finish::border_mesh::BorderMesh;
use crate::pipeline::finish::regions::{RegionFinder, Regions, TileLinks};
use crate::pipeline::output::border_log::{BorderLog, GroupBorders};
use crate::pipeline::output::ordered::{Closed, Ordered};
use crate::pipeline::output::writer::{BorderToWrite, Sender, ToWrite};
use crate::pipeline::records::{GENERATION, Nexts, TileState};
use crate::pipeline::threads::on_threads;
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

/// Assembles the borders of all tiles, group by group, and sends them in order.
pub(crate) fn write_borders(
    tiles: &mut [TileState],
    conquest: &Conquest,
    threads: usize,
    sender: &Sender,
) -> Result<RegionTotals, BuildError> {
    let progress = &conquest.options.progress;
    let mut log = conquest.log.lock();
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
    let mut kept = VecDeque::new();
    let regions = match conquest.rules.has_regions && is_whole {
        true => Some(find_regions(
            &mut log, tiles, conquest, &seeded, &nexts, threads, &mut kept,
        )?),
        false => None,
    };
    let totals = Mutex::new(
        regions
            .as_ref()
            .map_or_else(RegionTotals::default, |regions| RegionTotals {
                regions: regions.count,
                spanning: regions.spanning().len() as u64,
                hole_regions: regions.spanning().iter().filter(|region| region.is_hole).count() as u64,
                ..RegionTotals::default()
            }),
    );
    let assembly = BorderAssembly {
        conquest,
        regions,
        seeded,
        is_whole,
        totals,
    };
    let borders = Ordered::new(0, 2 * threads as u32, |_, border| {
        sender.blocking_send(ToWrite::Border(border)).map_err(|_| Closed)
    });
    for number in 0..log.group_count() {
        let _span = tracing::debug_span!("borders", group = number).entered();
        if progress.is_cancelled() || sender.is_closed() {
            return Err(BuildError::Cancelled);
        }
        let cannot = |error| BuildError::io(&conquest.spill, "read the border log in", error);
        let group = match kept.pop_front() {
            Some(group) => {
                log.forget_group(number);
                group
            }
            None => GroupMeshes::of(log.take_group(number).map_err(cannot)?, tiles, &nexts, threads)?,
        };
        assembly.group(&group, tiles, threads, &borders)?;
    }
    Ok(assembly.totals.into_inner())
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
    /// Assembles the borders of a group on `threads` threads.
    fn group<F>(
        &self,
        group: &GroupMeshes,
        tiles: &mut [TileState],
        threads: usize,
        borders: &Ordered<Option<BorderToWrite>, F>,
    ) -> Result<(), BuildError>
    where
        F: FnMut(u32, Option<BorderToWrite>) -> Result<(), Closed> + Send,
    {
        let progress = &self.conquest.options.progress;
        let range = group.borders.tiles();
        let states = &mut tiles[range.start as usize..range.end as usize];
        let next = Mutex::new(range.zip(states).zip(&group.meshes));
        let buffers = Buffers::default();
        let work = || {
            loop {
                let Some(((number, state), mesh)) = next.lock().next() else {
                    return;
                };
                if progress.is_cancelled() || borders.begin(number).is_err() {
                    borders.close();
                    return;
                }
                let tile = TileId(number);
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
    fn border(&self, tile: TileId, state: &mut TileState, group: &GroupMeshes, mesh: &BorderMesh) -> Border {
        let its_regions = match &self.regions {
            Some(all) => TileRegions::Known {
                all,
                seeded: self.seeded.of_tile(tile),
            },
            None if self.is_whole => TileRegions::One,
            None => TileRegions::Unknown,
        };
        let border = assemble(tile, state, &group.borders, mesh, its_regions);
        note_border(state, &border);
        let mut totals = self.totals.lock();
        totals.hole_regions += border.closed_holes;
        totals.digest += border.digest;
        border
    }
}

/// The part of the border log that belongs to a group of tiles, and the mesh around each core.
struct GroupMeshes {
    borders: GroupBorders,
    meshes: Vec<BorderMesh>,
}

impl GroupMeshes {
    fn of(borders: GroupBorders, tiles: &[TileState], nexts: &Nexts, threads: usize) -> Result<Self, BuildError> {
        let mut meshes: Vec<_> = borders.tiles().map(|_| None).collect();
        let next = Mutex::new(borders.tiles().zip(&mut meshes));
        let work = || {
            loop {
                let Some((tile, mesh)) = next.lock().next() else {
                    return;
                };
                let next = nexts.get(&TileId(tile)).copied();
                *mesh = Some(BorderMesh::of(TileId(tile), &tiles[tile as usize], &borders, next));
            }
        };
        on_threads(threads, work, || {})?;
        let meshes = meshes.into_iter().flatten().collect();
        Ok(Self { borders, meshes })
    }

    /// Returns the size in bytes.
    fn byte_size(&self) -> u64 {
        self.borders.byte_size() + self.meshes.iter().map(BorderMesh::byte_size).sum::<u64>()
    }
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
    kept: &mut VecDeque<GroupMeshes>,
) -> Result<Regions, BuildError> {
    let late = log.next_number();
    let open: u64 = tiles.iter().map(|tile| u64::from(tile.open_components)).sum();
    let (needed, budget) = (RegionFinder::BYTES * (late + open), conquest.memory.rest());
    let finder = RegionFinder::new(late, tiles, conquest.holes).filter(|_| needed <= budget);
    let Some(mut finder) = finder else {
        return Err(conquest.memory.shortage(MemoryUse::Regions, needed).into());
    };
    // Groups at the front stay in memory for the second pass while there is room for them.
    let (mut kept_bytes, room) = (0, (budget - needed) / 2);
    for number in 0..log.group_count() {
        let _span = tracing::debug_span!("regions", group = number).entered();
        if conquest.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        let group = log.read_group(number);
        let group = group.map_err(|error| BuildError::io(&conquest.spill, "read the border log in", error))?;
        let group = GroupMeshes::of(group, tiles, nexts, threads)?;
        let links = links_of(&finder, &group, tiles, conquest, threads)?;
        for (tile, links) in group.borders.tiles().zip(&links) {
            let tile = TileId(tile);
            let taken = finder.take(tile, &tiles[tile.0 as usize], links, seeded.of_tile(tile));
            taken.map_err(|source| match source {
                Some(source) => BuildError::OpenRing {
                    obstacle: source.number(),
                },
                None => BuildError::Internal("regions are covered by different obstacles".to_owned()),
            })?;
        }
        if kept.len() == number && kept_bytes + group.byte_size() <= room {
            kept_bytes += group.byte_size();
            kept.push_back(group);
        }
    }
    Ok(finder.finish(tiles))
}

/// Returns the links of each tile of a group.
fn links_of(
    finder: &RegionFinder,
    group: &GroupMeshes,
    tiles: &[TileState],
    conquest: &Conquest,
    threads: usize,
) -> Result<Vec<TileLinks>, BuildError> {
    let mut links: Vec<_> = group.meshes.iter().map(|_| TileLinks::default()).collect();
    let next = Mutex::new(group.borders.tiles().zip(&group.meshes).zip(&mut links));
    let work = || {
        loop {
            let Some(((tile, mesh), links)) = next.lock().next() else {
                return;
            };
            let its = (TileId(tile), &tiles[tile as usize]);
            *links = finder.links_of(its, mesh, &group.borders, &conquest.rules.seeds);
        }
    };
    on_threads(threads, work, || {})?;
    Ok(links)
}
