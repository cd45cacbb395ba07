//! Tests dead ends against a search for other exits.

use std::collections::HashSet;

use proptest::prelude::*;

use crate::geometry::{HalfEdge, Point};
use crate::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
use crate::pipeline::{BuildOptions, Builder};
use crate::query::free_space::passages::*;
use crate::store::{LineKind, OpenOptions, Tile, TileReader};

/// Points of a square grid, walls between neighbours, and sites.
#[derive(Clone, Debug)]
struct Scene {
    width: u32,
    walls: Vec<(u32, bool)>,
    sites: Vec<u32>,
    tile_vertices: usize,
    exterior_is_hole: bool,
}

impl Scene {
    fn point(&self, number: u32) -> Point {
        let number = number % (self.width * self.width);
        Point::new(f64::from(number % self.width), f64::from(number / self.width))
    }

    async fn tiles(&self) -> Vec<Tile> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.tiles");
        let options = BuildOptions::default()
            .tile_vertices(self.tile_vertices)
            .exterior_is_hole(self.exterior_is_hole);
        let mut builder = Builder::new(&path, options).unwrap();
        let points: Vec<Point> = (0..self.width * self.width).map(|i| self.point(i)).collect();
        for &(number, is_upright) in &self.walls {
            let from = self.point(number);
            let to = if is_upright {
                Point::new(from.x, from.y + 1.0)
            } else {
                Point::new(from.x + 1.0, from.y)
            };
            if points.contains(&to) {
                let batch = SegmentBatch {
                    ends: vec![[from, to]],
                    lines: vec![0],
                    ..SegmentBatch::default()
                };
                builder.push_lines(LineKind::Wall, 0, &batch).unwrap();
            }
        }
        let sites = SiteBatch {
            points: self.sites.iter().map(|&site| self.point(site)).collect(),
            ids: (0..self.sites.len() as u64).map(SiteId::Number).collect(),
            ..SiteBatch::default()
        };
        builder.push_sites(&sites).unwrap();
        let batch = PointBatch {
            records: (0..points.len() as u64).collect(),
            points,
            z: Vec::new(),
        };
        builder.push(&batch).await.unwrap();
        builder.finish().await.unwrap();
        let reader = TileReader::open(&path, OpenOptions::default()).await.unwrap();
        let mut tiles = Vec::new();
        for id in 0..reader.directory().await.unwrap().tiles.len() as u32 {
            tiles.push(Tile::clone(&*reader.tile(crate::store::TileId(id)).await.unwrap()));
        }
        tiles
    }
}

fn scenes() -> impl Strategy<Value = Scene> {
    let walls = prop::collection::vec((0..49u32, any::<bool>()), 0..90);
    let sites = prop::collection::vec(0..49u32, 0..3);
    (
        3..8u32,
        walls,
        sites,
        prop::sample::select(vec![8usize, 1 << 16]),
        any::<bool>(),
    )
        .prop_map(|(width, walls, sites, tile_vertices, exterior_is_hole)| Scene {
            width,
            walls,
            sites,
            tile_vertices,
            exterior_is_hole,
        })
}

/// Returns the number of triangles beyond a half-edge if all of them are core triangles without
/// sites, and each can be reached in one way only.
fn leads_nowhere(space: FreeSpace<'_>, half_edge: HalfEdge) -> Option<usize> {
    let tile = space.tile;
    let FreeTwin::HalfEdge(entered) = space.twin(half_edge) else {
        return None;
    };
    let mut seen = HashSet::from([half_edge.triangle()]);
    let mut open = vec![entered];
    while let Some(entered) = open.pop() {
        let triangle = entered.triangle();
        let has_site = tile
            .corners(triangle)
            .into_iter()
            .any(|corner| tile.has_vertex(corner) && tile.is_site(corner));
        if triangle.0 >= tile.core_triangle_count() || has_site || !seen.insert(triangle) {
            return None;
        }
        let half_edges = HalfEdge::of_triangle(triangle).into_iter();
        for half_edge in half_edges.filter(|&half_edge| half_edge != entered) {
            match space.twin(half_edge) {
                FreeTwin::HalfEdge(next) => open.push(next),
                FreeTwin::Blocked => {}
                FreeTwin::Elsewhere | FreeTwin::Outside => return None,
            }
        }
    }
    Some(seen.len() - 1)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn dead_ends_are_the_regions_without_another_exit(scene in scenes()) {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        for tile in runtime.block_on(scene.tiles()) {
            let space = FreeSpace { tile: &tile, outside_is_free: !scene.exterior_is_hole };
            let passages = space.passages();
            for half_edge in (0..3 * tile.triangle_count()).map(HalfEdge) {
                prop_assert!(!matches!(passages.twin(half_edge), Passage::DeadEnd(_)));
            }
            for _ in 0..tile.triangle_count() {
                prop_assert!(!passages.knows_dead_ends());
                passages.count_passed(1);
            }
            prop_assert!(passages.knows_dead_ends() && passages.knows_dead_ends());
            for half_edge in (0..3 * tile.triangle_count()).map(HalfEdge).filter(|half_edge| space.is_free(half_edge.triangle())) {
                let expected = leads_nowhere(space, half_edge);
                match passages.twin(half_edge) {
                    Passage::DeadEnd(entered) => {
                        prop_assert!(expected.is_some());
                        prop_assert_eq!(space.twin(half_edge), FreeTwin::HalfEdge(entered));
                        // The half-edge leads to each triangle in the dead end.
                        let way = passages.way_in(entered.triangle());
                        prop_assert!(way.starts_with(&[entered.triangle(), half_edge.triangle()]));
                    }
                    Passage::HalfEdge(entered) => {
                        prop_assert_eq!(space.twin(half_edge), FreeTwin::HalfEdge(entered));
                        // If an edge is a dead end from both sides, one of its half-edges is
                        // marked.
                        let is_marked = matches!(passages.twin(entered), Passage::DeadEnd(_));
                        prop_assert!(expected.is_none() || is_marked);
                    }
                    Passage::Elsewhere => prop_assert_eq!(space.twin(half_edge), FreeTwin::Elsewhere),
                    Passage::Outside => prop_assert_eq!(space.twin(half_edge), FreeTwin::Outside),
                    Passage::Blocked => prop_assert_eq!(space.twin(half_edge), FreeTwin::Blocked),
                    Passage::Contradictory => prop_assert!(false, "half-edge {} is contradictory", half_edge.0),
                }
            }
        }
    }
}
