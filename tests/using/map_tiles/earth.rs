//! Coordinates on Earth: reference systems, units, longitudes.

use delaunay_tiles::map_tiles::{GridKind, Layer, MapSource, NoGrid, TileCoord};
use delaunay_tiles::{Point, Rect};

use super::{Plan, draw, hills, pixels};
use crate::support::{Scratch, runtime};

fn height_of([r, g, b, _]: [u8; 4]) -> f64 {
    f64::from(r) * 256.0 + f64::from(g) + f64::from(b) / 256.0 - 32768.0
}

/// Moves and scales the points of a plan, and its z.
fn placed(mut plan: Plan, scale: f64, corner: (f64, f64), z: f64) -> Plan {
    plan.points
        .iter_mut()
        .for_each(|p| *p = Point::new(scale * p.x + corner.0, scale * p.y + corner.1));
    plan.z.iter_mut().for_each(|height| *height *= z);
    plan
}

/// The tile of a zoom at the middle of a file.
fn middle(source: &MapSource, zoom: u8) -> TileCoord {
    let grid = source.grid(GridKind::WebMercatorQuad).unwrap();
    let bounds = source.reader().metadata().bounds;
    let p = Point::new((bounds.min_x + bounds.max_x) / 2.0, (bounds.min_y + bounds.max_y) / 2.0);
    let [x, y] = grid
        .fraction(p)
        .unwrap()
        .map(|share| (share * f64::from(1u32 << zoom)) as u32);
    TileCoord::new(zoom, x, y).unwrap()
}

#[test]
fn feet_and_metres_give_the_same_heights_at_the_same_places() {
    runtime().block_on(async {
        // EPSG:2992 is EPSG:2991 in international feet.
        const METRES: &str = "EPSG:2991";
        const FEET: &str = "EPSG:2992";
        let plan = Plan::square(2000, 31).with_z(hills);
        let foot = 1.0 / 0.3048;
        let metres = placed(plan.clone(), 10.0, (194_000.0, 259_000.0), 1.0).crs(METRES);
        let feet = placed(plan, 10.0 * foot, (194_000.0 * foot, 259_000.0 * foot), foot).crs(FEET);
        let (_one, metres): (Scratch, _) = metres.build().await;
        let (_other, feet) = feet.build().await;
        let at = middle(&metres, 16);
        assert_eq!(at, middle(&feet, 16));
        let a = draw(&metres, GridKind::WebMercatorQuad, Layer::Terrarium, at).await;
        let b = draw(&feet, GridKind::WebMercatorQuad, Layer::Terrarium, at).await;
        let (a, b) = (pixels(&a.bytes), pixels(&b.bytes));
        let both: Vec<_> = a.iter().zip(&b).filter(|(a, b)| a[3] == 255 && b[3] == 255).collect();
        assert!(both.len() > 30_000, "{}", both.len());
        let far = both
            .iter()
            .map(|(a, b)| (height_of(**a) - height_of(**b)).abs())
            .fold(0.0, f64::max);
        // Coordinates in feet are rounded elsewhere.
        assert!(far < 0.01, "{far}");
        assert!(height_of(*both[0].0) > 50.0 && height_of(*both[0].0) < 200.0);
    });
}

#[test]
fn a_file_is_where_its_reference_system_says() {
    runtime().block_on(async {
        for (crs, bounds, expected) in [
            // UTM zone 32: the central meridian is 9° east.
            (
                "EPSG:32632",
                Rect::new(499_000.0, 5_538_000.0, 501_000.0, 5_539_000.0),
                [9.0, 50.0],
            ),
            ("EPSG:4326", Rect::new(106.0, -7.0, 107.0, -6.0), [106.5, -6.5]),
            ("OGC:CRS84", Rect::new(-1.0, 10.0, 1.0, 12.0), [0.0, 11.0]),
            ("EPSG:4326", Rect::new(234.0, 47.0, 238.0, 49.0), [-124.0, 48.0]),
            ("EPSG:3857", Rect::new(-1000.0, -1000.0, 1000.0, 1000.0), [0.0, 0.0]),
        ] {
            let (width, height) = bounds.size();
            let mut plan = Plan::square(100, 32);
            plan.points.iter_mut().for_each(|p| {
                *p = Point::new(bounds.min_x + width * p.x / 100.0, bounds.min_y + height * p.y / 100.0);
            });
            let (_scratch, source) = plan.crs(crs).build().await;
            let grid = source.grid(GridKind::WebMercatorQuad).unwrap();
            let there = grid.lon_lat_bounds().unwrap();
            let [lon, lat] = [(there.min_x + there.max_x) / 2.0, (there.min_y + there.max_y) / 2.0];
            assert!(
                (lon - expected[0]).abs() < 0.01 && (lat - expected[1]).abs() < 0.01,
                "{crs} {lon} {lat}"
            );
            // The tile there has something.
            let at = middle(&source, grid.max_zoom().saturating_sub(2));
            assert!(
                !draw(&source, GridKind::WebMercatorQuad, Layer::Shade, at)
                    .await
                    .is_empty(),
                "{crs}"
            );
        }
    });
}

#[test]
fn a_file_without_a_known_reference_system_says_why_it_is_on_no_web_map() {
    runtime().block_on(async {
        let reason = |plan: Plan| async move {
            let (_scratch, source) = plan.build().await;
            assert!(source.grid(GridKind::Native).is_ok());
            source.grid(GridKind::WebMercatorQuad).err().unwrap()
        };
        assert_eq!(reason(Plan::square(50, 33)).await, NoGrid::NoCrs);
        let unsupported = reason(Plan::square(50, 33).crs(r#"LOCAL_CS["site",UNIT["metre",1]]"#)).await;
        assert!(matches!(unsupported, NoGrid::Unsupported { .. }), "{unsupported}");
        let outside = reason(placed(Plan::square(50, 33), 1.0, (400.0, 400.0), 1.0).crs("EPSG:4326")).await;
        assert!(matches!(outside, NoGrid::Outside { .. }), "{outside}");
    });
}
