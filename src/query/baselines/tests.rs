//! Tests the effect of the stretch factor, with points that need a factor above π/2.

use std::f64::consts::FRAC_PI_2;

use crate::geometry::Point;
use crate::input::{PointBatch, SiteBatch, SiteId};
use crate::pipeline::{BuildOptions, Builder};
use crate::query::QueryOptions;
use crate::query::baselines::answers::*;
use crate::query::baselines::context::Wanted;
use crate::query::baselines::stretch::Stretch;
use crate::store::{OpenOptions, TileReader};

/// Returns 74 points. In their Delaunay triangulation, the path along edges from the first point to
/// point 37 is 1.5754 times as long as the straight line.
fn points() -> Vec<Point> {
    let text = include_str!("../../../tests/data/stretch/pi2_points_6dp.csv");
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    let point = |row: &str| {
        let mut numbers = row.split(',').map(|cell| cell.parse().unwrap());
        Point::new(numbers.next().unwrap(), numbers.next().unwrap())
    };
    rows.map(point).collect()
}

#[test]
fn half_of_pi_loses_a_site_and_the_proved_factor_does_not() {
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    runtime.block_on(async {
        let folder = tempfile::tempdir().unwrap();
        let (path, points) = (folder.path().join("points.tiles"), points());
        assert_eq!(points.len(), 74);
        let mut builder = Builder::new(&path, BuildOptions::default()).unwrap();
        let sites = SiteBatch {
            points: points.clone(),
            ids: (0..74).map(SiteId::Number).collect(),
            ..SiteBatch::default()
        };
        builder.push_sites(&sites).unwrap();
        let batch = PointBatch {
            records: (0..74).collect(),
            points: points.clone(),
            z: Vec::new(),
        };
        builder.push(&batch).await.unwrap();
        builder.finish().await.unwrap();
        let reader = TileReader::open(&path, OpenOptions::default()).await.unwrap();

        let lost = async |from: usize, to: usize, stretch: Stretch| {
            let [a, b] = [points[from], points[to]];
            let radius = (a.x - b.x).hypot(a.y - b.y) * (1.0 + 1e-12);
            let method = Method::Visibility { stretch };
            let wanted = Wanted::Within(radius);
            let found = reader
                .sites_by(method, a, wanted, QueryOptions::default())
                .await
                .unwrap();
            !found.answer.iter().any(|site| site.number == to as u64)
        };
        assert!(lost(0, 37, Stretch(FRAC_PI_2)).await, "π/2 loses no site");
        for from in 0..points.len() {
            for to in 0..points.len() {
                assert!(!lost(from, to, Stretch::PROVED).await, "{to} is lost from {from}");
            }
        }
        assert!(Stretch::new(FRAC_PI_2).is_err());
    });
}
