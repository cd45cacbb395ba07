//! Builds the islands of Indonesia as obstacles, with three harbours as sites, and sails between them.
//!
//! `cargo run --release --example query --features geojson`

use delaunay_tiles::input::{SegmentBatch, SegmentSource, SiteBatch, SiteId};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{BuildOptions, Builder, OpenOptions, PathOutcome, Point, QueryOptions, TileReader};
use futures::{StreamExt, TryStreamExt};

type Error = Box<dyn std::error::Error>;

const ISLANDS: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/data/indonesia/indonesia_ne10m.geojson"
);

/// Longitude and latitude in degrees, in the water off each harbour.
const HARBOURS: [(&str, f64, f64); 3] = [
    ("Jakarta", 106.9, -6.0),
    ("Makassar", 119.3, -5.2),
    ("Ambon", 128.1, -3.75),
];

#[tokio::main]
async fn main() -> Result<(), Error> {
    let output = std::env::temp_dir().join("islands.tiles");
    let mut builder = Builder::new(&output, BuildOptions::default().force(true))?;
    let mut source = SegmentSource::open_obstacles(&[ISLANDS.into()])?;
    let mut batch = SegmentBatch::default();
    while source.next_batch(&mut batch)? {
        builder.push_lines(LineKind::Obstacle, 0, &batch)?;
    }
    builder.push_sites(&SiteBatch {
        points: HARBOURS.map(|(_, x, y)| Point::new(x, y)).to_vec(),
        ids: HARBOURS.map(|(name, ..)| SiteId::Text(name.into())).to_vec(),
        ..SiteBatch::default()
    })?;
    builder.finish().await?;

    let islands = TileReader::open(&output, OpenOptions::default()).await?;
    let singapore = Point::new(104.0, 1.0);

    // A stream: each site costs only as much search as it takes to be sure of it.
    let mut sites = islands.nearest_sites(singapore, QueryOptions::default()).take(2);
    while let Some(site) = sites.try_next().await? {
        let name = site.id.as_deref().unwrap_or("a site");
        println!("{name}: {:.4} degrees of sailing from Singapore", site.distance.value);
    }

    let ambon = Point::new(HARBOURS[2].1, HARBOURS[2].2);
    let options = QueryOptions::default().certified();
    match islands.shortest_path(singapore, ambon, options).await? {
        PathOutcome::Found(path) => println!(
            "to Ambon: between {:.9} and {:.9} degrees, by {} bends",
            path.distance.lower,
            path.distance.upper,
            path.points.len() - 2
        ),
        other => println!("no path: {other:?}"),
    }
    Ok(())
}
