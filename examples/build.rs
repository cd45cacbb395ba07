//! Builds a tile file from a lidar survey, and reads heights from it.
//!
//! `cargo run --release --example build --features las -- [FILE.laz] [OUT.tiles]`

use std::path::PathBuf;

use delaunay_tiles::input::{InputOptions, PointBatch, PointSource};
use delaunay_tiles::{BuildOptions, Builder, OpenOptions, TileReader};

type Error = Box<dyn std::error::Error>;

#[tokio::main]
async fn main() -> Result<(), Error> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let shipped = || concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/las/autzen.laz").into();
    let input = arguments.next().unwrap_or_else(shipped);
    let output = arguments
        .next()
        .unwrap_or_else(|| std::env::temp_dir().join("survey.tiles"));

    // A builder spills to disk what does not fit into `memory`.
    let options = BuildOptions::default().memory(256 << 20).force(true);
    let mut builder = Builder::new(&output, options)?;
    let mut source = PointSource::open(&[input], &InputOptions::default())?;
    let mut batch = PointBatch::default();
    while source.next_batch(&mut batch)? {
        builder.push(&batch).await?;
    }
    let summary = builder.finish().await?;
    println!(
        "{} vertices, {} triangles, {} tiles",
        summary.vertices, summary.triangles, summary.tiles
    );

    // The file has its name only when it is complete; any number of readers may open it.
    let survey = TileReader::open(&output, OpenOptions::default()).await?;
    let bounds = survey.metadata().bounds;
    for i in 1..5 {
        let along = f64::from(i) / 5.0;
        let (width, height) = bounds.size();
        let (x, y) = (bounds.min_x + along * width, bounds.min_y + along * height);
        match survey.z_at(x, y).await? {
            Some(z) => println!("z at ({x:.1}, {y:.1}): {z:.2}"),
            None => println!("({x:.1}, {y:.1}) is outside of the triangulation"),
        }
    }
    Ok(())
}
