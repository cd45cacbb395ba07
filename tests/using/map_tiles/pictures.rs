//! Pictures and heights.

use delaunay_tiles::map_tiles::{DrawLimits, GridKind, Layer, MapSource};
use delaunay_tiles::query::Location;
use delaunay_tiles::terrain::Surface;
use delaunay_tiles::{Cache, OpenOptions, TileReader};

use super::{Plan, draw, hills, pixels, point_in, tile, tiles_of};
use crate::support::{Random, runtime, runtime_for};

const FREE: [u8; 4] = [242, 240, 234, 255];
const HOLE: [u8; 4] = [193, 201, 207, 255];

fn height_of([r, g, b, _]: [u8; 4]) -> f64 {
    f64::from(r) * 256.0 + f64::from(g) + f64::from(b) / 256.0 - 32768.0
}

#[test]
fn terrarium_pixels_have_the_heights_of_the_surface() {
    runtime().block_on(async {
        let plan = Plan::square(3000, 1).with_z(hills);
        for (grid, plan) in [
            (GridKind::Native, plan.clone()),
            (GridKind::WebMercatorQuad, plan.crs("EPSG:3857")),
        ] {
            let (_scratch, source) = plan.build().await;
            let tiles = source.grid(grid).unwrap();
            let mut random = Random(2);
            let zoom = tiles.max_zoom().saturating_sub(2);
            let (mut above, mut outside) = (0, 0);
            for at in tiles_of(tiles, zoom) {
                let drawn = draw(&source, grid, Layer::Terrarium, at).await;
                if drawn.is_empty() {
                    continue;
                }
                let pixels = pixels(&drawn.bytes);
                for _ in 0..150 {
                    let pixel = random.below(256 * 256);
                    let p = point_in(tiles, at, pixel, [0.5, 0.5]);
                    match source.reader().surface_z(p.x, p.y, Surface::default()).await.unwrap() {
                        Some(z) => {
                            assert_eq!(pixels[pixel][3], 255);
                            assert!(
                                (height_of(pixels[pixel]) - z).abs() <= 1.0 / 512.0 + 1e-6,
                                "{at} {pixel} {z}"
                            );
                            above += 1;
                        }
                        None => {
                            assert_eq!(pixels[pixel][3], 0);
                            outside += 1;
                        }
                    }
                }
            }
            assert!(above > 100 && outside > 10, "{above} {outside}");
        }
    });
}

#[test]
fn a_slope_has_one_light_also_where_tiles_meet() {
    runtime().block_on(async {
        // The colours go from west to east in steps of less than one.
        let (_scratch, source) = Plan::square(2000, 3).with_z(|p| p.x / 5.0 + p.y / 3.0).build().await;
        let zoom = 2;
        let mut seen = 0;
        for at in tiles_of(source.grid(GridKind::Native).unwrap(), zoom) {
            if at.x() == 3 {
                continue;
            }
            let east = tile(zoom, at.x() + 1, at.y());
            let west = draw(&source, GridKind::Native, Layer::Shade, at).await;
            let east = draw(&source, GridKind::Native, Layer::Shade, east).await;
            if west.is_empty() || east.is_empty() {
                continue;
            }
            let (west, east) = (pixels(&west.bytes), pixels(&east.bytes));
            let pair = |row: usize| [west[row * 256 + 255], east[row * 256]];
            let is_opaque = |row: usize| pair(row).iter().all(|pixel| pixel[3] == 255);
            // At the hull, a slope has no neighbour on one side.
            for row in (1..255).filter(|&row| (row - 1..=row + 1).all(is_opaque)) {
                let [a, b] = pair(row);
                let far = (0..3).map(|i| a[i].abs_diff(b[i])).max().unwrap();
                assert!(far <= 2, "{at} {row} {a:?} {b:?}");
                seen += 1;
            }
        }
        assert!(seen > 200, "{seen}");
    });
}

#[test]
fn the_same_tiles_come_of_all_tile_sizes_threads_and_caches() {
    let plan = Plan::square(2500, 4).with_z(hills).with_town().crs("EPSG:32632");
    let draw_all = |tile_vertices: usize, threads: usize, cache: usize| {
        runtime_for(threads).block_on(async {
            let mut plan = plan.clone().tile_vertices(tile_vertices);
            plan.points
                .iter_mut()
                .for_each(|p| *p = delaunay_tiles::Point::new(p.x + 5e5, p.y + 5e6));
            for (_, ends) in &mut plan.lines {
                ends.as_flattened_mut()
                    .iter_mut()
                    .for_each(|p| *p = delaunay_tiles::Point::new(p.x + 5e5, p.y + 5e6));
            }
            plan.sites
                .iter_mut()
                .for_each(|p| *p = delaunay_tiles::Point::new(p.x + 5e5, p.y + 5e6));
            let (scratch, _) = plan.build().await;
            let options = OpenOptions::default().cache(&Cache::new(cache));
            let source = MapSource::open(TileReader::open(&scratch.path, options).await.unwrap())
                .await
                .unwrap();
            let limits = DrawLimits {
                max_tiles: 1000,
                deadline: None,
            };
            let mut all = Vec::new();
            for grid in GridKind::ALL {
                let tiles = source.grid(grid).unwrap();
                let zoom = tiles.max_zoom().saturating_sub(1);
                for at in tiles_of(tiles, zoom).into_iter().take(12) {
                    for layer in [Layer::Shade, Layer::Terrarium] {
                        all.push(source.draw(grid, layer, at, limits).await.unwrap().bytes);
                    }
                }
            }
            all
        })
    };
    let first = draw_all(100, 1, 1 << 20);
    assert!(first.iter().filter(|bytes| bytes.len() > 500).count() >= 8);
    assert!(first == draw_all(700, 2, 64 << 20));
    assert!(first == draw_all(5000, 2, 0));
}

#[test]
fn holes_and_free_ground_are_where_the_triangulation_has_them() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(1500, 5).with_town().build().await;
        let tiles = source.grid(GridKind::Native).unwrap();
        let mut random = Random(6);
        let mut counts = [0; 3];
        for at in tiles_of(tiles, 2) {
            let drawn = draw(&source, GridKind::Native, Layer::Shade, at).await;
            let pixels = if drawn.is_empty() {
                vec![[0; 4]; 65536]
            } else {
                pixels(&drawn.bytes)
            };
            for _ in 0..150 {
                let pixel = random.below(256 * 256);
                // Lines are drawn over places where something else begins.
                let mut around = Vec::new();
                for x in [-2.5, 0.5, 3.5] {
                    for y in [-2.5, 0.5, 3.5] {
                        let p = point_in(tiles, at, pixel, [x, y]);
                        around.push(match source.reader().locate(p.x, p.y).await.unwrap() {
                            Location::InTriangle(triangle) => {
                                let tile = source.reader().tile(triangle.tile).await.unwrap();
                                Some(tile.is_hole(triangle.triangle))
                            }
                            Location::Outside => None,
                            _ => continue,
                        });
                    }
                }
                let expected = match around[0] {
                    _ if around.iter().any(|other| *other != around[0]) => continue,
                    Some(true) => HOLE,
                    Some(false) => FREE,
                    None => [0; 4],
                };
                let found = pixels[pixel];
                let is_line = expected == FREE && found != FREE && found != HOLE;
                if found[3] > 0 && is_line {
                    // A break line, a wall or a site, of which there are few.
                    counts[2] += 1;
                    continue;
                }
                assert!(
                    found == expected || found[3] == 0 && expected[3] == 0,
                    "{at} {pixel} {found:?} {expected:?}"
                );
                counts[usize::from(expected == HOLE)] += 1;
            }
        }
        assert!(counts[0] > 300 && counts[1] > 100 && counts[2] < 100, "{counts:?}");
    });
}

#[test]
fn a_pixel_on_the_outline_of_a_hole_is_mixed_by_exact_samples() {
    runtime().block_on(async {
        // A hole with sides along the axes, without lines over its inside.
        let mut plan = Plan::square(300, 8);
        let corners =
            [(20.0, 20.0), (80.0, 20.0), (80.0, 80.0), (20.0, 80.0)].map(|(x, y)| delaunay_tiles::Point::new(x, y));
        let ring = (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect();
        plan.lines.push((delaunay_tiles::store::LineKind::Obstacle, ring));
        let (_scratch, source) = plan.build().await;
        let tiles = source.grid(GridKind::Native).unwrap();
        let drawn = draw(&source, GridKind::Native, Layer::Shade, tile(0, 0, 0)).await;
        let pixels = pixels(&drawn.bytes);
        let row_of = |y: f64| ((tiles.square().max_y - y) / tiles.square().size().1 * 256.0) as usize;
        let column_of = |x: f64| ((x - tiles.square().min_x) / tiles.square().size().0 * 256.0) as usize;
        // No seam of triangles is seen inside.
        for row in row_of(80.0) + 3..row_of(20.0) - 3 {
            for column in column_of(20.0) + 3..column_of(80.0) - 3 {
                assert_eq!(pixels[row * 256 + column], HOLE, "{row} {column}");
            }
        }
    });
}

#[test]
fn a_coarse_zoom_is_drawn_from_a_coarse_level() {
    runtime().block_on(async {
        let plan = Plan::square(20_000, 9).with_z(hills);
        let (scratch, fine) = plan.build().await;
        let mut some = plan.clone();
        some.points = plan.points.iter().copied().skip(19_000).collect();
        some.z = plan.z.iter().copied().skip(19_000).collect();
        let (_other, coarse) = some.tile_vertices(5000).build().await;
        let levels = vec![coarse.reader().clone()];
        let source = MapSource::with_levels(scratch.open().await, levels).await.unwrap();
        let at = tile(0, 0, 0);
        // A pixel is half a unit long, and a typical edge of the coarse level 3: too coarse.
        assert_eq!(
            draw(&source, GridKind::Native, Layer::Terrarium, at).await.tiles,
            fine.reader().metadata().tiles
        );
        // Vectors are drawn from it.
        let drawn = draw(&source, GridKind::Native, Layer::Mesh, at).await;
        assert_eq!(drawn.tiles, 1);
    });
}
