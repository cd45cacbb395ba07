//! Rewrites tiles with other regions, for tests.

use futures::stream::TryStreamExt;

use crate::geometry::{HalfEdge, PackedHalfEdge, TriangleId, VertexIndex};
use crate::io::{Buffers, MemoryFile};
use crate::mesh::{Topology, Twin};
use crate::store::directory_writer::front_end_for;
use crate::store::format::component_table::{Component, ComponentRecord, encode};
use crate::store::format::directory::Directory;
use crate::store::format::encode::{BorderDraft, CoreDraft};
use crate::store::format::entry::TileEntry;
use crate::store::format::metadata::Metadata;
use crate::store::format::tile::Tile;
use crate::store::open_options::OpenOptions;
use crate::store::reader::TileReader;
use crate::store::writer::TileWriter;

/// Returns the drafts of a tile, without constraints, regions and sites.
fn drafts(tile: &Tile) -> (CoreDraft, BorderDraft) {
    let core_end = 3 * tile.core_triangle_count();
    let vertices = tile.vertex_indices();
    let triangles: Vec<[u32; 3]> = tile
        .triangle_ids()
        .map(|t| tile.corners(t).map(|corner| corner.0))
        .collect();
    let (of_core, of_border) = triangles.split_at(tile.core_triangle_count() as usize);
    let twin_in_core = |half_edge: HalfEdge| {
        let twin = tile.twin(half_edge).half_edge();
        PackedHalfEdge::from(twin.filter(|twin| twin.0 < core_end))
    };
    let corners = of_border.as_flattened().iter().copied();
    let foreign = corners
        .max()
        .map_or(0, |last| (last + 1).saturating_sub(tile.vertex_count()));
    let core_half_edges = tile.half_edges().take_while(|half_edge| half_edge.0 < core_end);
    let links = core_half_edges.filter_map(|half_edge| match tile.twin(half_edge) {
        Twin::HalfEdge(twin) if twin.0 >= core_end => Some((half_edge.0, twin.0)),
        _ => None,
    });
    let leaving = vertices.clone().filter_map(|v| Some((v.0, tile.leaving(v)?.0)));
    let core = CoreDraft {
        points: tile.points().collect(),
        z: vertices.clone().filter_map(|v| tile.z(v)).collect(),
        records: vertices.clone().map(|v| tile.record(v)).collect(),
        input_points: vertices.map(|v| tile.is_input_point(v)).collect(),
        triangles: of_core.to_vec(),
        neighbours: tile
            .triangle_ids()
            .take(of_core.len())
            .map(|t| HalfEdge::of_triangle(t).map(twin_in_core))
            .collect(),
        constraints: Vec::new(),
        components: Vec::new(),
        edge_sources: Vec::new(),
        sites: Vec::new(),
        site_ids: Vec::new(),
    };
    let border = BorderDraft {
        vertices: tile.vertex_count(),
        core_triangles: tile.core_triangle_count(),
        foreign: (0..foreign)
            .map(|corner| tile.vertex(VertexIndex(tile.vertex_count() + corner)))
            .map(|v| (v.id, v.point))
            .collect(),
        foreign_z: tile.has_z().then(|| {
            let corners = (0..foreign).map(|corner| VertexIndex(tile.vertex_count() + corner));
            corners.filter_map(|corner| tile.z(corner)).collect()
        }),
        triangles: of_border.to_vec(),
        neighbours: tile
            .border_triangle_ids()
            .map(|t| HalfEdge::of_triangle(t).map(|half_edge| tile.twin(half_edge)))
            .collect(),
        core_links: links.collect(),
        vertex_sides: leaving.filter(|&(_, half_edge)| half_edge >= core_end).collect(),
        constraints: Vec::new(),
        components: Vec::new(),
        edge_sources: Vec::new(),
        edges: Vec::new(),
    };
    (core, border)
}

/// Writes a copy of a file in which triangles have the regions, depths and kinds that `label`
/// returns. `change` may change the drafts of each tile, and `metadata` the metadata of the file.
pub(crate) async fn relabelled(
    reader: &TileReader,
    label: impl Fn(&Tile, TriangleId) -> Component,
    change: impl Fn(&Tile, &mut CoreDraft, &mut BorderDraft),
    metadata: impl FnOnce(&mut Metadata),
) -> MemoryFile {
    let file = MemoryFile::default();
    let mut writer = TileWriter::new(file.clone(), front_end_for(2));
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    let (mut cores, mut borders, mut tables) = (Vec::new(), Vec::new(), Vec::new());
    for tile in tiles {
        let (mut core, mut border) = drafts(&tile);
        let mut components: Vec<u32> = Vec::new();
        let mut records: Vec<ComponentRecord> = Vec::new();
        for triangle in tile.triangle_ids() {
            let component = label(&tile, triangle);
            let index = records.iter().position(|other| other.component == component);
            components.push(index.unwrap_or(records.len()) as u32);
            if index.is_none() {
                records.push(ComponentRecord {
                    component,
                    ..ComponentRecord::default()
                });
            }
        }
        tables.push(encode(tile.id(), &records));
        border.components = components.split_off(core.triangles.len());
        core.components = components;
        change(&tile, &mut core, &mut border);
        let buffers = Buffers::default();
        let bytes = core.encode(tile.id(), 1, &buffers);
        cores.push(writer.append_core(&bytes).await.unwrap());
        borders.push(border.encode(tile.id(), 1, &buffers));
    }
    let Directory {
        metadata: mut changed,
        lists,
        tree,
        mut tiles,
        ..
    } = Directory::clone(&*reader.directory().await.unwrap());
    for (((entry, core), border), table) in tiles.iter_mut().zip(cores).zip(borders).zip(tables) {
        let border = writer.append_border(&border).await.unwrap();
        let table = writer.place_table(table).await.unwrap();
        *entry = TileEntry {
            core,
            border,
            table,
            ..*entry
        };
    }
    metadata(&mut changed);
    writer
        .finish(&Directory::new(changed, lists, tree, tiles))
        .await
        .unwrap();
    file
}

/// Opens a file that [`relabelled`] returned.
pub(crate) async fn opened(file: MemoryFile) -> TileReader {
    TileReader::open_source(file, "relabelled", OpenOptions::default())
        .await
        .unwrap()
}
