//! Checks of a whole file: every tile, and the facts that need all tiles.

use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use std::sync::Arc;

use futures::future::FutureExt;
use futures::stream::StreamExt;

use crate::geometry::{Rect, TriangleId};
use crate::memory::FileShares;
use crate::store::error::ReadError;
use crate::store::format::digest::Digest;
use crate::store::format::directory::Directory;
use crate::store::format::entry::TileEntry;
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::tile::Tile;
use crate::store::pass::{Needs, PassPlan, PassReader, Workspaces};
use crate::store::reader::TileReader;
use crate::store::verify::components::{LinkReport, Pair};
use crate::store::verify::error::{Fault, VerifyError, VerifyReport};
use crate::store::verify::held::LineRules;
use crate::store::verify::polygons::ObstacleEdges;
use crate::store::verify::shared_vertices::SharedVertices;
use crate::store::verify::tile::{Expected, TileReport, VertexPoints};
use crate::store::verify::{components, regions, tile};

impl TileReader {
    /// Checks the file. If `deep` is true, proves the triangulation too. Must be awaited within a
    /// tokio runtime.
    ///
    /// # Errors
    ///
    /// Returns the first fault, or an error if a tile does not fit into the memory that the reader
    /// may use.
    pub fn verify(&self, deep: bool) -> impl Future<Output = Result<VerifyReport, VerifyError>> + Send {
        async move { self.for_passes().await?.verify(deep).await }.boxed()
    }
}

/// Returns the cell of each tile, by its number.
fn cells_of_tiles(directory: &Directory) -> Vec<Rect> {
    let mut cells = vec![Rect::EMPTY; directory.tiles.len()];
    for (tile, cell) in directory.tree.cells() {
        cells[tile.0 as usize] = cell;
    }
    cells
}

/// Checks a tile, and its component table if the check is deep.
fn check_tile(
    tile: &Tile,
    cell: Rect,
    expected: &Expected,
    points: &mut VertexPoints,
) -> Result<(TileReport, LinkReport), Fault> {
    let report = tile::check(tile, cell, expected, points)?;
    let links = match expected.deep {
        true => components::check(tile, expected.regions.is_some())?,
        false => LinkReport::default(),
    };
    Ok((report, links))
}

impl PassReader {
    async fn verify(&self, deep: bool) -> Result<VerifyReport, VerifyError> {
        let directory = self.directory();
        let metadata = &directory.metadata;
        let cells = cells_of_tiles(directory);
        let expected = Arc::new(Expected {
            has_triangles: metadata.triangles > 0,
            deep,
            lines: Arc::new(LineRules::of(directory)),
            regions: (metadata.regions > 0).then(|| regions::RegionClaims::of(directory)),
        });
        let mut needs = Needs {
            per_vertex: tile::BYTES_PER_VERTEX + u64::from(deep) * components::BYTES_PER_VERTEX,
            ..Needs::default()
        };
        let claims = expected.regions.as_ref().filter(|_| deep);
        if claims.is_some() {
            needs.per_vertex += regions::BYTES_PER_VERTEX;
            needs.fixed += regions::BYTES_PER_SPANNING * metadata.spanning_regions;
        }
        let points = Arc::new(Workspaces::<VertexPoints>::default());
        let shared = Arc::clone(&expected);
        let mut reports = self.for_each_tile(needs, move |tile| {
            let cell = cells[tile.id().0 as usize];
            let report = points.with(|points| check_tile(&tile, cell, &shared, points));
            (tile.id(), report)
        })?;
        let mut totals = FileTotals {
            regions: claims.map(regions::RegionTotals::new),
            ..FileTotals::default()
        };
        while let Some(report) = reports.next().await {
            let (tile, report) = report?;
            let (report, links) = report.map_err(|fault| fault.of(tile))?;
            totals.add(self, report)?;
            totals.add_links(links);
        }
        self.verify_metadata(&totals)?;
        if deep {
            self.verify_whole(&totals, &expected.lines).await?;
        }
        if let (Some(claims), Some(regions)) = (claims, &totals.regions) {
            regions
                .check(claims, metadata)
                .map_err(|damage| VerifyError::File(damage.into()))?;
            self.verify_polygons(std::mem::take(&mut totals.obstacle_edges)).await?;
        }
        let shared_vertices = std::mem::take(&mut totals.shared_vertices);
        self.verify_shared_vertices(shared_vertices, &expected.lines).await?;
        // Last, because the other checks say more about what is wrong.
        self.verify_digest(&totals.digest)?;
        Ok(VerifyReport {
            tiles: metadata.tiles.into(),
            vertices: metadata.vertices,
            triangles: metadata.triangles,
            edges: totals.edges,
            constraint_edges: totals.digest.constraint_edges.count,
            regions: claims.map_or(0, |_| metadata.regions),
            hole_regions: claims.map_or(0, |_| metadata.hole_regions),
            ..VerifyReport::default()
        })
    }

    /// Returns the plan of a pass, and the number of items, of `bytes` bytes each, to look up at
    /// once. The number is in `range`, or its start if `range` is empty. `needs` returns the memory
    /// that a pass needs for a number of items.
    pub(super) fn plan_lookups(
        &self,
        needs: impl Fn(u64) -> Needs,
        range: Range<u64>,
        bytes: u64,
    ) -> Result<(PassPlan, usize), ReadError> {
        let share = FileShares(self.memory()).lookups(needs(0).least(self.directory()));
        let at_once = (share / bytes).min(range.end).max(range.start);
        Ok((self.plan(needs(at_once))?, at_once as usize))
    }

    /// Checks the root of the directory against its entries, which have been checked before.
    fn verify_metadata(&self, totals: &FileTotals) -> Result<(), VerifyError> {
        let Directory { metadata, tiles, .. } = self.directory();
        let found = &totals.digest;
        for (what, found, expected) in [
            (
                "constraint edges",
                found.constraint_edges.count,
                metadata.constraint_edges,
            ),
            ("triangles in holes", found.holes.count, metadata.hole_triangles),
            ("sites", found.sites.count, metadata.sites),
            ("vertices without a point of the input", totals.ends, metadata.ends),
        ] {
            if found != expected {
                return Err(VerifyError::File(format!(
                    "there are {found} {what}, but the directory says {expected}"
                )));
            }
        }
        let bounds = tiles.iter().fold(Rect::EMPTY, |all, tile| all.union(tile.bounds));
        if bounds != metadata.bounds {
            let found = metadata.bounds;
            return Err(VerifyError::File(format!(
                "its bounds are {bounds:?}, but the directory says {found:?}"
            )));
        }
        // They are statistics of the build.
        let is_as_built = metadata.last_transaction == 0;
        let distinct = metadata.points.checked_sub(metadata.duplicates);
        let built = distinct.and_then(|distinct| distinct.checked_add(metadata.ends));
        if is_as_built && built != Some(metadata.vertices) {
            return Err(VerifyError::File(format!(
                "{} points less {} duplicates and {} ends of segments are not {} vertices",
                metadata.points, metadata.duplicates, metadata.ends, metadata.vertices
            )));
        }
        // Edits let tiles grow before they cut them.
        let is_too_large = |tile: &TileEntry| tile.vertices > metadata.tile_vertices && self.generation() == 1;
        match tiles.iter().zip(0u32..).find(|(tile, _)| is_too_large(tile)) {
            Some((tile, number)) => {
                let (found, most) = (tile.vertices, metadata.tile_vertices);
                let reason = format!("it has {found} vertices, but the directory allows {most} at most");
                Err(Fault::new(reason).of(TileId(number)))
            }
            None => Ok(()),
        }
    }

    /// Checks the directory's digest against that of the tiles.
    fn verify_digest(&self, found: &Digest) -> Result<(), VerifyError> {
        match found.first_difference(&self.metadata().digest) {
            Some([found, stored]) => Err(VerifyError::File(format!(
                "the digest of its tiles is \"{found}\", but the directory says \"{stored}\""
            ))),
            None => Ok(()),
        }
    }

    /// Checks the facts that need all tiles.
    async fn verify_whole(&self, totals: &FileTotals, lines: &LineRules) -> Result<(), VerifyError> {
        let metadata = self.metadata();
        let mut pairs: Vec<_> = totals
            .shared
            .iter()
            .filter(|(_, sum)| **sum != 0)
            .map(|(p, _)| *p)
            .collect();
        pairs.sort_unstable();
        if let Some(&(owner, other)) = pairs.first() {
            return Err(self.find_difference(owner, other).await?);
        }
        self.verify_links(totals).await?;
        if totals.hull_edges != metadata.hull_edges {
            let expected = metadata.hull_edges;
            return Err(VerifyError::File(format!(
                "there are {} hull edges, but by Euler's formula there should be {expected}",
                totals.hull_edges
            )));
        }
        let hulls = u64::from(metadata.triangles > 0);
        if totals.hull_minima != hulls {
            return Err(VerifyError::File(format!(
                "the hull goes round {} times, not {hulls}",
                totals.hull_minima
            )));
        }
        if metadata.triangles == 0 {
            self.verify_on_line(lines).await?;
        }
        Ok(())
    }

    /// Checks the links between components of different tiles.
    async fn verify_links(&self, totals: &FileTotals) -> Result<(), VerifyError> {
        let wrong = totals.links.iter().filter(|(_, sum)| **sum != 0);
        let wrong = wrong
            .map(|(pair, _)| pair)
            .filter(|pair| !totals.ambiguous.contains(pair));
        if let Some((owner, other)) = wrong.min() {
            let reason = format!("its links to components of tile {owner} do not fit the triangles that they share");
            return Err(Fault::new(reason).of(*other));
        }
        for &(owner, other) in &totals.ambiguous {
            let (owning, sharing) = (self.tile(owner).await?, self.tile(other).await?);
            components::check_pair(&owning, &sharing).map_err(|fault| fault.of(other))?;
        }
        Ok(())
    }

    /// Returns an error that names the triangle that one of the two tiles owns or shares and the
    /// other lacks.
    async fn find_difference(&self, owner: TileId, other: TileId) -> Result<VerifyError, ReadError> {
        let (owning, sharing) = (self.tile(owner).await?, self.tile(other).await?);
        let keys = |tile: &Tile| -> HashMap<u128, TriangleId> {
            let shared = tile
                .border_triangle_ids()
                .filter(|&t| tile::owner(tile, t) == owner && tile.vertices(t).iter().any(|v| v.id.tile == other));
            shared.map(|t| (tile::hash(tile, t), t)).collect()
        };
        let (of_owner, of_other) = (keys(&owning), keys(&sharing));
        let lacking = |from: &HashMap<u128, TriangleId>, to: &HashMap<u128, TriangleId>| {
            from.iter()
                .filter(|(key, _)| !to.contains_key(key))
                .map(|(_, &t)| t)
                .min()
        };
        if let Some(difference) = other_z([&owning, &sharing], [&of_owner, &of_other])
            && let Some(error) = self.of_other_z([owner, other], &difference).await?
        {
            return Ok(error);
        }
        let fault = if let Some(triangle) = lacking(&of_owner, &of_other) {
            Fault::at(
                triangle,
                format!("tile {other} must have the triangle too, but does not"),
            )
            .of(owner)
        } else if let Some(triangle) = lacking(&of_other, &of_owner) {
            Fault::at(
                triangle,
                format!("tile {owner} owns the triangle, but does not have it"),
            )
            .of(other)
        } else {
            Fault::new(format!(
                "it and tile {other} disagree on the number of triangles that they share"
            ))
            .of(owner)
        };
        Ok(fault)
    }

    /// Returns the error for the one of two tiles whose z of a vertex is not that of the tile that
    /// owns the vertex, if that tile has it.
    async fn of_other_z(&self, tiles: [TileId; 2], difference: &OtherZ) -> Result<Option<VerifyError>, ReadError> {
        let vertex = difference.vertex;
        let owner = match self.directory().entry(vertex.tile) {
            Some(entry) if vertex.index.0 < entry.vertices => self.tile(vertex.tile).await?,
            _ => return Ok(None),
        };
        let right = owner.z(vertex.index);
        let mut stored = tiles.into_iter().zip(difference.stored);
        let wrong = stored.find(|(_, (_, z))| z.map(f64::to_bits) != right.map(f64::to_bits));
        let error = wrong.and_then(|(tile, (triangle, z))| {
            let (z, right) = (z?, right?);
            let reason = format!("it says that vertex {vertex} has z {z:?}, but the tile that owns it says {right:?}");
            Some(Fault::at(triangle, reason).of(tile))
        });
        Ok(error)
    }
}

/// A corner of a triangle that two tiles share, for which they store different z.
struct OtherZ {
    vertex: VertexId,
    /// For each of the tiles its number of the triangle, and its z.
    stored: [(TriangleId, Option<f64>); 2],
}

/// Returns the first corner of the triangles that two tiles share for which they store different z.
fn other_z(tiles: [&Tile; 2], shared: [&HashMap<u128, TriangleId>; 2]) -> Option<OtherZ> {
    let corners = |which: usize| {
        let triangles = shared[which].values();
        triangles.map(move |&triangle| {
            let heights = tile::heights(tiles[which], triangle);
            (heights.map(|(id, _)| id), (triangle, heights.map(|(_, z)| z)))
        })
    };
    let of_other: HashMap<_, _> = corners(1).collect();
    let differences = corners(0).filter_map(|(ids, (triangle, z))| {
        let (there, other) = of_other.get(&ids)?;
        let corner = (0..3).find(|&corner| z[corner].map(f64::to_bits) != other[corner].map(f64::to_bits))?;
        Some(OtherZ {
            vertex: ids[corner],
            stored: [(triangle, z[corner]), (*there, other[corner])],
        })
    });
    differences.min_by_key(|difference| difference.stored[0].0)
}

/// The sums over all tiles.
#[derive(Default)]
struct FileTotals {
    edges: u64,
    hull_edges: u64,
    /// The number of hull vertices that are lexicographically smaller than both their neighbours on
    /// the hull.
    hull_minima: u64,
    /// For each pair of an owner and another tile, the sum of the hashes of the triangles owned
    /// less those shared.
    shared: HashMap<(TileId, TileId), u128>,
    ends: u64,
    digest: Digest,
    /// The links between components of different tiles.
    links: HashMap<Pair, u128>,
    /// Pairs of tiles whose links these sums do not check.
    ambiguous: BTreeSet<Pair>,
    /// The sums of regions, if these are checked.
    regions: Option<regions::RegionTotals>,
    obstacle_edges: ObstacleEdges,
    shared_vertices: SharedVertices,
}

impl FileTotals {
    fn add_links(&mut self, report: LinkReport) {
        for (pair, sum) in report.sums {
            let total = self.links.entry(pair).or_default();
            *total = total.wrapping_add(sum);
            if *total == 0 {
                self.links.remove(&pair);
            }
        }
        self.ambiguous.extend(report.ambiguous);
    }

    fn add(&mut self, reader: &PassReader, report: TileReport) -> Result<(), VerifyError> {
        let directory = reader.directory();
        let entry = &directory.tiles[report.tile.0 as usize];
        let wrong = |reason: String| Err(Fault::new(reason).of(report.tile));
        if report.owned != entry.owned_triangles {
            return wrong(format!(
                "{} triangles belong to it, but its entry says {}",
                report.owned, entry.owned_triangles
            ));
        }
        if report.bounds != entry.bounds {
            return wrong(format!(
                "its bounds are {:?}, but its entry says {:?}",
                report.bounds, entry.bounds
            ));
        }
        if report.has_z != directory.metadata.has_z {
            return wrong("it and the directory disagree on whether there is z".to_owned());
        }
        self.edges += report.edges;
        self.hull_edges += report.hull_edges;
        self.hull_minima += report.hull_minima;
        self.ends += report.ends;
        self.digest += report.digest;
        self.shared_vertices.add(report.tile, report.shared_vertices);
        if let (Some(totals), Some(regions)) = (&mut self.regions, &report.regions) {
            self.obstacle_edges.add(report.tile, regions.obstacles);
            totals.add(regions).map_err(|fault| fault.of(report.tile))?;
        }
        for (pair, sum) in report.shared {
            let total = self.shared.entry(pair).or_default();
            *total = total.wrapping_add(sum);
            if *total == 0 {
                self.shared.remove(&pair);
            }
        }
        Ok(())
    }
}
