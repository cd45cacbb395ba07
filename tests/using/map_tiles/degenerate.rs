//! Files with little in them, and tiles where nothing is.

use delaunay_tiles::map_tiles::{DrawError, DrawLimits, GridKind, Layer, NoGrid, TerrainCoord};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{Point, Rect};

use super::{Plan, draw, hills, pixels, tile};
use crate::support::runtime;

#[test]
fn a_file_without_z_has_no_heights() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(50, 21).crs("EPSG:3857").build().await;
        assert_eq!(source.layers(), [Layer::Shade, Layer::Mesh]);
        let limits = DrawLimits::default();
        let drawn = source
            .draw(GridKind::Native, Layer::Terrarium, tile(0, 0, 0), limits)
            .await;
        assert!(matches!(drawn, Err(DrawError::NoLayer(Layer::Terrarium))));
        assert_eq!(source.terrain_facts().unwrap_err(), NoGrid::NoHeights);
        let terrain = source.terrain(TerrainCoord::new(0, 0, 0).unwrap(), limits).await;
        assert!(matches!(terrain, Err(DrawError::NoGrid(NoGrid::NoHeights))));
    });
}

#[test]
fn outside_of_the_bounds_tiles_are_empty_at_all_zooms() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(200, 22)
            .with_z(hills)
            .with_town()
            .crs("EPSG:3857")
            .build()
            .await;
        for zoom in [3, 17, 30] {
            let last = (1u32 << zoom) - 1;
            for (x, y) in [(last, 0), (0, 0), (last, last)] {
                for layer in Layer::ALL {
                    for grid in GridKind::ALL {
                        let drawn = draw(&source, grid, layer, tile(zoom, x, y)).await;
                        assert!(drawn.is_empty() && drawn.tiles == 0, "{grid} {layer} {zoom}/{x}/{y}");
                    }
                }
            }
        }
    });
}

#[test]
fn the_deepest_tiles_are_drawn_too() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(500, 23)
            .with_z(hills)
            .with_town()
            .crs("EPSG:3857")
            .build()
            .await;
        for grid in GridKind::ALL {
            let tiles = source.grid(grid).unwrap();
            let number = |share: f64| (share * f64::from(1u32 << 30)) as u32;
            let [x, y] = tiles.fraction(Point::new(51.0, 49.0)).unwrap();
            for layer in Layer::ALL {
                let drawn = draw(&source, grid, layer, tile(30, number(x), number(y))).await;
                assert!(!drawn.is_empty() && drawn.bytes.len() < 20_000, "{grid} {layer}");
            }
        }
    });
}

#[test]
fn an_empty_file_has_no_grids() {
    runtime().block_on(async {
        let (_scratch, source) = Plan {
            tile_vertices: 100,
            ..Plan::default()
        }
        .build()
        .await;
        assert_eq!(source.grid(GridKind::Native).err(), Some(NoGrid::Empty));
        let drawn = source
            .draw(GridKind::Native, Layer::Shade, tile(0, 0, 0), DrawLimits::default())
            .await;
        assert!(matches!(drawn, Err(DrawError::NoGrid(NoGrid::Empty))));
    });
}

#[test]
fn one_vertex_and_vertices_on_a_line_are_drawn_as_dots() {
    runtime().block_on(async {
        for count in [1, 2, 40] {
            let points: Vec<Point> = (0..count)
                .map(|i| Point::new(f64::from(i), 2.0 * f64::from(i)))
                .collect();
            let mut plan = Plan {
                points,
                tile_vertices: 10,
                ..Plan::default()
            };
            if count == 40 {
                plan.lines
                    .push((LineKind::Wall, vec![[Point::new(3.0, 6.0), Point::new(9.0, 18.0)]]));
            }
            for plan in [plan.clone(), plan.with_z(hills)] {
                let (_scratch, source) = plan.build().await;
                assert_eq!(source.reader().metadata().triangles, 0);
                let drawn = draw(&source, GridKind::Native, Layer::Shade, tile(0, 0, 0)).await;
                let inked = pixels(&drawn.bytes).iter().filter(|pixel| pixel[3] > 0).count();
                assert!(inked >= count as usize, "{count}: {inked}");
                draw(&source, GridKind::Native, Layer::Mesh, tile(0, 0, 0)).await;
                if source.layers().contains(&Layer::Terrarium) {
                    draw(&source, GridKind::Native, Layer::Terrarium, tile(0, 0, 0)).await;
                }
            }
        }
    });
}

#[test]
fn very_large_and_very_small_coordinates_are_drawn() {
    runtime().block_on(async {
        for scale in [1e-30, 1e-3, 1e30, 1e55] {
            let mut plan = Plan::square(200, 24);
            plan.points
                .iter_mut()
                .for_each(|p| *p = Point::new(scale * p.x, scale * p.y));
            let (_scratch, source) = plan.with_z(hills).crs("EPSG:32632").build().await;
            let square: Rect = source.grid(GridKind::Native).unwrap().square();
            assert!(square.size().0 >= 100.0 * scale && square.size().0 <= 260.0 * scale);
            for layer in Layer::ALL {
                assert!(
                    !draw(&source, GridKind::Native, layer, tile(0, 0, 0)).await.is_empty(),
                    "{scale} {layer}"
                );
            }
            if scale > 1e9 {
                assert!(
                    matches!(source.grid(GridKind::WebMercatorQuad), Err(NoGrid::Outside { .. })),
                    "{scale}"
                );
            }
        }
    });
}
