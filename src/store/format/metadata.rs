//! The metadata of the whole file, and its encoding in the root of the directory.

use flatbuffers::FlatBufferBuilder;

use crate::geometry::Rect;
use crate::store::format::damage::Damage;
use crate::store::format::digest::Digest;
use crate::store::format::edge_source::LineKind;
use crate::store::format::generated::directory as schema;

/// Returns the name and version of this program, as they are stored in files that it writes.
pub(crate) fn this_program() -> String {
    concat!("delaunay-tiles ", env!("CARGO_PKG_VERSION")).to_owned()
}

/// The metadata of the whole file.
#[derive(Clone, Debug, PartialEq)]
pub struct Metadata {
    /// The number of tiles.
    pub tiles: u32,
    /// The maximum number of vertices per tile for which the file was built.
    pub tile_vertices: u32,
    /// The number of vertices.
    pub vertices: u64,
    /// The number of triangles.
    pub triangles: u64,
    /// The number of edges with a triangle on one side only.
    pub hull_edges: u64,
    /// The number of points in the input of the build. Edits do not change it.
    pub points: u64,
    /// The number of points in the input of the build that coincide with another one. Edits do not
    /// change it.
    pub duplicates: u64,
    /// The number of vertices that are an end of a segment or a site, but no point of the input.
    pub ends: u64,
    /// The number of constraint edges.
    pub constraint_edges: u64,
    /// Whether the vertices have a z.
    pub has_z: bool,
    /// The bounding rectangle of all vertices.
    pub bounds: Rect,
    /// The program that wrote the file.
    pub producer: String,
    /// The number of regions: parts of the triangulation that no constraint crosses. 0 in files
    /// without regions.
    pub regions: u64,
    /// The number of regions that may extend over several tiles. These have the numbers from 0 up
    /// to this one; each of the others is within one tile.
    pub spanning_regions: u64,
    /// The number of regions that are holes.
    pub hole_regions: u64,
    /// The number of triangles in holes.
    pub hole_triangles: u64,
    /// The number of sites.
    pub sites: u64,
    /// The number of pairs of lines that crossed and were split.
    pub crossings: u64,
    /// The kinds of lines from which the file has any: 1 for break lines, 2 for walls and 4 for
    /// obstacles, added. 0 if the file does not state which lines it has.
    pub line_kinds: u32,
    /// Whether regions that reach the hull without a constraint are holes.
    pub exterior_is_hole: bool,
    /// One more than the largest record number ever assigned to a point, to the end of a segment,
    /// to a crossing point or to a site. Edits number the ends of their segments from here on.
    pub next_record: u64,
    /// One more than the largest number ever assigned to a line.
    pub next_line: u64,
    /// One more than the largest number ever assigned to a site that has no number of its own.
    pub next_site: u64,
    /// The number of edits that changed points or sites, or removed lines; 0 if none did.
    pub last_transaction: u64,
    /// The number of edits that removed lines. Since then, the lines of the file may have other
    /// numbers than those of a build.
    pub line_removals: u64,
    /// The digest of the triangulation, as the file says. Builds and edits compute it as they
    /// write; [`TileReader::recompute_digest`](crate::store::TileReader::recompute_digest) computes
    /// it from the tiles.
    pub digest: Digest,
}

impl Default for Metadata {
    fn default() -> Self {
        Self {
            tiles: 0,
            tile_vertices: 0,
            vertices: 0,
            triangles: 0,
            hull_edges: 0,
            points: 0,
            duplicates: 0,
            ends: 0,
            constraint_edges: 0,
            has_z: false,
            bounds: Rect::EMPTY,
            producer: this_program(),
            regions: 0,
            spanning_regions: 0,
            hole_regions: 0,
            hole_triangles: 0,
            sites: 0,
            crossings: 0,
            line_kinds: 0,
            exterior_is_hole: false,
            next_record: 0,
            next_line: 0,
            next_site: 0,
            last_transaction: 0,
            line_removals: 0,
            digest: Digest::default(),
        }
    }
}

impl Metadata {
    /// Returns whether the file has lines of a kind; `None` if it does not state which lines it has.
    #[must_use]
    pub fn has_lines(&self, kind: LineKind) -> Option<bool> {
        match self.line_kinds {
            0 if self.constraint_edges > 0 => None,
            kinds => Some(kinds >> kind.to_code() & 1 == 1),
        }
    }

    /// Returns the arguments of a root with this metadata and nothing else.
    pub(super) fn encode<'b>(&self, builder: &mut FlatBufferBuilder<'b>) -> schema::DirectoryArgs<'b> {
        // The arguments of a root refer to the sums, so these are set by the root.
        schema::DirectoryArgs {
            tiles: self.tiles,
            tile_vertices: self.tile_vertices,
            vertices: self.vertices,
            triangles: self.triangles,
            hull_edges: self.hull_edges,
            points: self.points,
            duplicates: self.duplicates,
            has_z: self.has_z,
            min_x: self.bounds.min_x,
            min_y: self.bounds.min_y,
            max_x: self.bounds.max_x,
            max_y: self.bounds.max_y,
            producer: Some(builder.create_string(&self.producer)),
            ends: self.ends,
            constraint_edges: self.constraint_edges,
            regions: self.regions,
            spanning_regions: self.spanning_regions,
            hole_regions: self.hole_regions,
            hole_triangles: self.hole_triangles,
            sites: self.sites,
            crossings: self.crossings,
            line_kinds: self.line_kinds,
            exterior_is_hole: self.exterior_is_hole,
            next_record: self.next_record,
            next_line: self.next_line,
            next_site: self.next_site,
            last_transaction: self.last_transaction,
            line_removals: self.line_removals,
            ..schema::DirectoryArgs::default()
        }
    }

    /// Decodes the metadata from a verified root. The error says what is wrong with it.
    pub(super) fn decode(root: schema::Directory<'_>) -> Result<Self, Damage> {
        let this = Self {
            tiles: root.tiles(),
            tile_vertices: root.tile_vertices(),
            vertices: root.vertices(),
            triangles: root.triangles(),
            hull_edges: root.hull_edges(),
            points: root.points(),
            duplicates: root.duplicates(),
            ends: root.ends(),
            constraint_edges: root.constraint_edges(),
            has_z: root.has_z(),
            bounds: Rect::new(root.min_x(), root.min_y(), root.max_x(), root.max_y()),
            producer: root.producer().unwrap_or_default().to_owned(),
            regions: root.regions(),
            spanning_regions: root.spanning_regions(),
            hole_regions: root.hole_regions(),
            hole_triangles: root.hole_triangles(),
            sites: root.sites(),
            crossings: root.crossings(),
            line_kinds: root.line_kinds(),
            exterior_is_hole: root.exterior_is_hole(),
            next_record: root.next_record(),
            next_line: root.next_line(),
            next_site: root.next_site(),
            last_transaction: root.last_transaction(),
            line_removals: root.line_removals(),
            digest: Digest::from_schema([
                root.triangle_sum(),
                root.vertex_sum(),
                root.constraint_edge_sum(),
                root.hole_sum(),
                root.vertex_z_sum(),
                root.edge_source_sum(),
                root.site_sum(),
            ]),
        };
        // Callers allocate memory according to the number of regions. The number of triangles
        // bounds it, and is compared with the tiles.
        let counts = [this.spanning_regions, this.regions, this.triangles];
        if !counts.is_sorted() || this.hole_regions > this.regions || this.hole_triangles > this.triangles {
            return Err(Damage::new("its counts of regions and holes are inconsistent"));
        }
        Ok(this)
    }
}

/// Returns the number of hull edges for `vertices` vertices and `triangles` triangles, by Euler's
/// formula for a triangulated disc; 0 without triangles.
pub(crate) fn hull_edges(vertices: u64, triangles: u64) -> u64 {
    match triangles {
        0 => 0,
        triangles => (2 * vertices - 2).saturating_sub(triangles),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::format::digest::DigestSum;
    use crate::store::format::root::Root;

    fn decoded(metadata: &Metadata) -> Result<Metadata, Damage> {
        let root = Root {
            metadata: metadata.clone(),
            ..Root::default()
        };
        Ok(Root::decode(&root.encode().into(), u64::MAX)?.metadata)
    }

    fn full() -> Metadata {
        Metadata {
            triangles: 100,
            regions: 9,
            spanning_regions: 3,
            hole_regions: 2,
            hole_triangles: 40,
            sites: 5,
            crossings: 6,
            line_kinds: 6,
            exterior_is_hole: true,
            next_record: 1 << 40,
            next_line: 1 << 41,
            next_site: 1 << 42,
            last_transaction: 1 << 43,
            line_removals: 1 << 44,
            digest: Digest {
                triangles: DigestSum {
                    count: 100,
                    sum: u128::MAX - 5,
                },
                sites: DigestSum {
                    count: 1 << 63,
                    sum: 1 << 64,
                },
                ..Digest::default()
            },
            ..Metadata::default()
        }
    }

    #[test]
    fn metadata_is_read_as_it_was_written() {
        assert_eq!(decoded(&full()), Ok(full()));
        assert_eq!(decoded(&Metadata::default()), Ok(Metadata::default()));
    }

    #[test]
    fn inconsistent_counts_are_rejected() {
        let faults: [fn(&mut Metadata); 4] = [
            |m| m.spanning_regions = 10,
            |m| m.regions = 101,
            |m| m.hole_regions = 10,
            |m| m.hole_triangles = 101,
        ];
        for (fault, number) in faults.iter().zip(0..) {
            let mut wrong = full();
            fault(&mut wrong);
            assert!(decoded(&wrong).is_err(), "{number}");
        }
    }
}
