//! Builds a grid of points, and then adds a wall to the file on disk.
//!
//! `cargo run --release --example edit`

use delaunay_tiles::input::{PointBatch, SegmentBatch};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{
    BuildOptions, Builder, EditOptions, Editor, OpenOptions, PathOutcome, Point, QueryOptions, TileReader,
};

type Error = Box<dyn std::error::Error>;

async fn walk(field: &TileReader) -> Result<f64, Error> {
    let (from, to) = (Point::new(40.0, 50.5), Point::new(60.0, 50.5));
    match field.shortest_path(from, to, QueryOptions::default()).await? {
        PathOutcome::Found(path) => Ok(path.distance.value),
        other => Err(format!("no path: {other:?}").into()),
    }
}

#[tokio::main]
async fn main() -> Result<(), Error> {
    let output = std::env::temp_dir().join("field.tiles");
    let points: Vec<Point> = (0..10_000)
        .map(|i| Point::new(f64::from(i % 100), f64::from(i / 100)))
        .collect();
    let options = BuildOptions::default().tile_vertices(1000).force(true);
    let mut builder = Builder::new(&output, options)?;
    builder
        .push(&PointBatch {
            records: (0..10_000).collect(),
            points,
            z: Vec::new(),
        })
        .await?;
    builder.finish().await?;
    let before = TileReader::open(&output, OpenOptions::default()).await?;
    println!("without a wall: {:.3}", walk(&before).await?);

    // An edit writes behind the end of the file, and one superblock makes it valid at once.
    let wall = [Point::new(50.0, 20.0), Point::new(50.0, 80.0)];
    let mut transaction = Editor::open(&output, EditOptions::default().memory(256 << 20))
        .await?
        .begin()
        .await?;
    let batch = SegmentBatch {
        ends: vec![wall],
        lines: vec![0],
        ..SegmentBatch::default()
    };
    transaction.constrain(LineKind::Wall, transaction.first_line(), &batch)?;
    let summary = transaction.commit().await?;
    println!("{} constraint edges", summary.constraint_edges);

    // Readers that were open keep what they opened; new ones have the wall.
    println!("in the reader of before: {:.3}", walk(&before).await?);
    let after = TileReader::open(&output, OpenOptions::default()).await?;
    println!("round the wall: {:.3}", walk(&after).await?);
    Ok(())
}
