//! Lengths that others computed.

use std::fs::{self, File};
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use delaunay_tiles::build::{BuildOptions, Builder};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{InputOptions, PointBatch, PointSource, PolySource, SegmentBatch};
use delaunay_tiles::query::QueryOptions;
use delaunay_tiles::store::{LineKind, TileReader};
use flate2::read::GzDecoder;
use futures::TryStreamExt;

use crate::support::oracle::Walk;
use crate::support::places::{data, shared};
use crate::support::{Scratch, runtime};
use crate::{is_near, walk};

/// Builds from a PSLG of walls with hole points.
pub async fn build(file: &Path, options: BuildOptions) -> (Scratch, TileReader) {
    let scratch = Scratch::new();
    let mut builder = Builder::new(&scratch.path, options).unwrap();
    let mut batch = SegmentBatch::default();
    let mut source = PolySource::open(file).unwrap();
    while source.next_batch(&mut batch).unwrap() {
        builder.push_lines(LineKind::Wall, 0, &batch).unwrap();
    }
    builder.push_seeds(&source.holes().unwrap()).unwrap();
    let mut points = PointSource::open(&[file.to_owned()], &InputOptions::default()).unwrap();
    let mut batch = PointBatch::default();
    while points.next_batch(&mut batch).unwrap() {
        builder.push(&batch).await.unwrap();
    }
    builder.finish().await.unwrap();
    let reader = scratch.open().await;
    (scratch, reader)
}

/// The numbers of a table with a header.
pub fn rows(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().skip(1);
    rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect()
}

fn unzipped(path: PathBuf) -> io::Result<String> {
    let mut text = String::new();
    GzDecoder::new(BufReader::new(File::open(path)?)).read_to_string(&mut text)?;
    Ok(text)
}

/// Whether a length is the one that was printed with six digits.
fn is_printed(length: f64, printed: f64) -> bool {
    let digits = 5 - printed.log10().floor() as i32;
    let scale = 10f64.powi(digits);
    (length * scale).round() == (printed * scale).round()
}

#[test]
fn paths_on_the_map_of_a_game() {
    let lengths = rows(&fs::read_to_string(data("arena/arena_lengths.csv")).unwrap());
    assert_eq!(lengths.len(), 160);
    for tile_vertices in [8, 1 << 16] {
        runtime().block_on(async {
            let options = BuildOptions {
                tile_vertices,
                exterior_is_hole: true,
                ..BuildOptions::default()
            };
            let (_scratch, reader) = build(&data("arena/arena.poly"), options).await;
            for row in &lengths {
                let &[x, y, to_x, to_y, expected] = &row[..] else {
                    panic!("{row:?}")
                };
                for [from, to] in
                    [[x, y, to_x, to_y], [to_x, to_y, x, y]].map(|[x, y, u, v]| [Point::new(x, y), Point::new(u, v)])
                {
                    let Walk::Length(length) = walk(&reader, from, to).await else {
                        panic!("{row:?}: there is no path")
                    };
                    assert!(is_printed(length, expected), "{row:?}: {length}");
                }
            }
        });
    }
}

/// 40 places and 150 targets each, of which three in four are hidden.
#[test]
fn distances_among_islands() {
    let (Some(islands), Some(truth)) = (
        shared("indonesia/group1_dense_small.poly"),
        shared("indonesia/group1_truth.csv.gz"),
    ) else {
        return;
    };
    let truth = rows(&unzipped(truth).unwrap());
    assert_eq!(truth.len(), 6000);
    for tile_vertices in [64, 1 << 16] {
        runtime().block_on(async {
            let options = BuildOptions {
                tile_vertices,
                ..BuildOptions::default()
            };
            let (_scratch, reader) = build(&islands, options).await;
            for of_query in truth.chunk_by(|a, b| a[0] == b[0]) {
                let from = Point::new(of_query[0][1], of_query[0][2]);
                let to: Vec<Point> = of_query.iter().map(|row| Point::new(row[4], row[5])).collect();
                let found = reader.shortest_paths(from, to.clone(), QueryOptions::default());
                let found: Vec<_> = found.try_collect().await.unwrap();
                assert_eq!(found.len(), to.len());
                for (place, path) in found {
                    let expected = of_query[place][7];
                    assert!(
                        is_near(path.distance.value, expected),
                        "{:?}: {path:?}",
                        of_query[place]
                    );
                }
                for row in of_query.iter().step_by(7) {
                    let found = walk(&reader, from, Point::new(row[4], row[5])).await;
                    assert!(
                        matches!(found, Walk::Length(length) if is_near(length, row[7])),
                        "{row:?}: {found:?}"
                    );
                }
            }
        });
    }
}
