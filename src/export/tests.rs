//! Tests of files with damage that only an export detects, and of files that exceed PLY's limits.
//! `tests/export` exports whole files of all kinds.

use super::*;
use crate::geometry::{Point, Rect, VertexIndex};
use crate::io::{Buffers, MemoryFile};
use crate::mesh::Twin;
use crate::store::{
    BorderDraft, CoreDraft, Directory, KdNode, KdTree, Lists, Metadata, OpenOptions, Source, TablePlace, TileEntry,
    TileId, TileReader, TileWriter, VertexId, front_end_for,
};

/// Two tiles, and one triangle of both: vertices 0:0 and 0:1, and 1:0. Each test makes some field
/// wrong.
struct Draft {
    foreign: VertexId,
    owned: u32,
    z: [Vec<f64>; 2],
    records: [Vec<u64>; 2],
    sources: Vec<u64>,
}

impl Default for Draft {
    fn default() -> Self {
        Self {
            foreign: vertex(1, 0),
            owned: 1,
            z: [vec![5.0, 6.0], vec![7.0]],
            records: [vec![0, 2], vec![1]],
            sources: vec![3],
        }
    }
}

fn vertex(tile: u32, index: u32) -> VertexId {
    VertexId {
        tile: TileId(tile),
        index: VertexIndex(index),
    }
}

impl Draft {
    async fn open(self) -> TileReader {
        let (a, b, c) = (Point::new(0.0, 0.0), Point::new(1.0, 0.0), Point::new(2.0, 1.0));
        let foreign = [vec![(self.foreign, c)], vec![(vertex(0, 0), a), (vertex(0, 1), b)]];
        let own = [vec![a, b], vec![c]];
        let foreign_z = [vec![7.0], vec![5.0, 6.0]];
        let file = MemoryFile::default();
        let mut writer = TileWriter::new(file.clone(), front_end_for(2));
        let mut tiles = Vec::new();
        let foreign = foreign.into_iter().zip(foreign_z);
        let parts = own.into_iter().zip(foreign).zip(self.z).zip(self.records).zip(0u32..);
        for ((((points, (foreign, foreign_z)), z), records), tile) in parts {
            let vertices = points.len() as u32;
            let core = CoreDraft {
                points,
                z,
                records,
                ..CoreDraft::default()
            };
            let border = BorderDraft {
                vertices,
                foreign_z: (!core.z.is_empty()).then_some(foreign_z),
                foreign,
                triangles: vec![if tile == 0 { [0, 1, 2] } else { [1, 2, 0] }],
                neighbours: vec![[Twin::Hull; 3]],
                ..BorderDraft::default()
            };
            tiles.push(TileEntry {
                core: writer
                    .append_core(&core.encode(TileId(tile), 1, &Buffers::default()))
                    .await
                    .unwrap(),
                border: writer
                    .append_border(&border.encode(TileId(tile), 1, &Buffers::default()))
                    .await
                    .unwrap(),
                generation: 1,
                vertices,
                core_triangles: 0,
                border_triangles: 1,
                owned_triangles: if tile == 0 { self.owned } else { 0 },
                bounds: Rect::new(0.0, 0.0, 2.0, 1.0),
                table: TablePlace::Nowhere,
            });
        }
        let sources = self.sources.into_iter().map(|records| Source {
            name: "a.csv".to_owned(),
            records,
            first: 0,
        });
        let metadata = Metadata {
            vertices: 3,
            triangles: self.owned.into(),
            has_z: true,
            bounds: Rect::new(0.0, 0.0, 2.0, 1.0),
            ..Metadata::default()
        };
        let nodes = vec![
            KdNode::X { cut: 1.0, right: 2 },
            KdNode::Leaf(TileId(0)),
            KdNode::Leaf(TileId(1)),
        ];
        let tree = KdTree::new(nodes).unwrap();
        let lists = Lists {
            sources: sources.collect(),
            ..Lists::default()
        };
        let directory = Directory::new(metadata, lists, tree, tiles);
        writer.finish(&directory).await.unwrap();
        TileReader::open_source(file, "test", OpenOptions::default())
            .await
            .unwrap()
    }

    async fn export(self, format: Format) -> Result<Exported<Vec<u8>>, ExportError> {
        let outputs = format.suffixes().iter().map(|_| Vec::new()).collect();
        export(&self.open().await, format, ExportOptions::default(), outputs, |_, _| ()).await
    }

    async fn says(self, format: Format, expected: &str) {
        let error = self.export(format).await.unwrap_err();
        assert!(error.to_string().contains(expected), "{format}: {error}");
    }
}

#[tokio::test]
async fn a_sound_file_is_exported_to_all_formats() {
    let obj = Draft::default().export(Format::Obj).await.unwrap();
    let obj = String::from_utf8(obj.outputs.into_iter().next().unwrap()).unwrap();
    assert!(
        obj.ends_with("v 0.0 0.0 5.0\nv 1.0 0.0 6.0\nv 2.0 1.0 7.0\nf 1 2 3\n"),
        "{obj}"
    );
    for format in Format::ALL {
        let exported = Draft::default().export(format).await.unwrap();
        let bytes = exported.outputs.iter().map(Vec::len).sum::<usize>();
        assert_eq!(
            (exported.vertices, exported.triangles, exported.bytes),
            (3, 1, bytes as u64)
        );
    }
}

#[tokio::test]
async fn foreign_vertices_that_no_tile_has_are_damage() {
    for format in Format::ALL {
        for (foreign, says) in [
            (vertex(2, 0), "vertex 2:0, but the file has 2 tiles"),
            (
                vertex(u32::MAX, u32::MAX),
                "vertex 4294967295:4294967295, but the file has 2 tiles",
            ),
            (vertex(1, 1), "vertex 1:1, but tile 1 has 1 vertices"),
        ] {
            let draft = Draft {
                foreign,
                ..Draft::default()
            };
            let says = format!("is damaged: it has a triangle with {says}");
            draft.says(format, &says).await;
        }
    }
}

#[tokio::test]
async fn a_wrong_count_of_triangles_is_damage() {
    for format in Format::ALL {
        // A count larger than the tile's is refused when the file is opened.
        let draft = Draft {
            owned: 0,
            ..Draft::default()
        };
        draft
            .says(format, "it owns 1 triangles, but the directory says 0")
            .await;
    }
}

#[tokio::test]
async fn missing_or_non_finite_z_is_damage() {
    for format in Format::ALL {
        let nan = || Draft {
            z: [vec![5.0, 6.0], vec![f64::NAN]],
            ..Draft::default()
        };
        nan().says(format, "tile 1 at byte").await;
        nan().says(format, "vertex 0 has no finite z").await;
        let missing = Draft {
            z: [vec![5.0, 6.0], vec![]],
            ..Draft::default()
        };
        missing.says(format, "disagree on whether there is a z").await;
    }
}

#[tokio::test]
async fn ply_record_numbers_get_the_smallest_type_that_holds_them() {
    let large = u64::from(u32::MAX) + 1;
    for (record, sources, expected) in [
        (1, vec![3], "uint"),
        (1, vec![], "uint"),
        (1, vec![large, 7], "uint"),
        (1, vec![u64::MAX, u64::MAX], "uint"),
        (large - 1, vec![1, large - 1], "uint"),
        (large, vec![large, 1], "double"),
        (large, vec![], "double"),
        (1 << 53, vec![], "double"),
    ] {
        let draft = Draft {
            records: [vec![0, 2], vec![record]],
            sources,
            ..Draft::default()
        };
        let exported = draft.export(Format::Ply).await.unwrap();
        let header = String::from_utf8_lossy(&exported.outputs[0]);
        assert!(header.contains(&format!("property {expected} record\n")), "{record}");
    }
    let draft = |record, sources| Draft {
        records: [vec![0, 2], vec![record]],
        sources,
        ..Draft::default()
    };
    let contradiction = "vertex 0 is of record 4294967296, but the directory has no source";
    draft(large, vec![3]).says(Format::Ply, contradiction).await;
    draft((1 << 53) + 1, vec![]).says(Format::Ply, "9007199254740993").await;
    draft((1 << 53) + 1, vec![]).export(Format::Obj).await.unwrap();
}
