//! Limits.

use std::time::Instant;

use delaunay_tiles::map_tiles::{DrawError, DrawLimits, GridKind, Layer};

use super::{Plan, hills, tile, tiles_of};
use crate::support::runtime;

#[test]
fn a_tile_that_needs_too_many_tiles_of_the_file_says_how_many() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(4000, 11).with_z(hills).tile_vertices(100).build().await;
        let limits = DrawLimits {
            max_tiles: 8,
            deadline: None,
        };
        for layer in [Layer::Shade, Layer::Terrarium] {
            let error = source
                .draw(GridKind::Native, layer, tile(0, 0, 0), limits)
                .await
                .unwrap_err();
            let DrawError::OutOfBudget { needed, allowed } = error else {
                panic!("{error}")
            };
            assert!(needed > 8 && allowed == 8);
        }
        // Vectors leave out what is too much.
        let drawn = source
            .draw(GridKind::Native, Layer::Mesh, tile(0, 0, 0), limits)
            .await
            .unwrap();
        assert_eq!(drawn.tiles, 0);
    });
}

#[test]
fn from_the_first_zoom_on_no_tile_is_out_of_budget_and_before_it_one_is() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(2000, 12).with_z(hills).tile_vertices(50).build().await;
        for max_tiles in [8, 20, 100] {
            let limits = DrawLimits {
                max_tiles,
                deadline: None,
            };
            let facts = source.facts(GridKind::Native, Layer::Shade, limits).await.unwrap();
            assert!(facts.min_zoom <= facts.max_zoom);
            let tiles = source.grid(GridKind::Native).unwrap();
            let mut is_out = [false; 2];
            for (zoom, is_out) in [facts.min_zoom.checked_sub(2), Some(facts.min_zoom)]
                .into_iter()
                .zip(&mut is_out)
            {
                let Some(zoom) = zoom else { continue };
                for at in tiles_of(tiles, zoom) {
                    match source.draw(GridKind::Native, Layer::Shade, at, limits).await {
                        Ok(drawn) => assert!(drawn.tiles <= max_tiles),
                        Err(DrawError::OutOfBudget { .. }) => *is_out = true,
                        Err(error) => panic!("{error}"),
                    }
                }
            }
            assert_eq!(is_out, [facts.min_zoom >= 2, false], "{max_tiles} {}", facts.min_zoom);
        }
    });
}

#[test]
fn a_deadline_that_has_passed_ends_a_drawing() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(100, 13).with_z(hills).build().await;
        let limits = DrawLimits {
            max_tiles: 8,
            deadline: Some(Instant::now()),
        };
        for layer in Layer::ALL {
            let drawn = source.draw(GridKind::Native, layer, tile(0, 0, 0), limits).await;
            assert!(matches!(drawn, Err(DrawError::TimedOut)));
        }
    });
}
