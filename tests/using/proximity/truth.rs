//! Lengths that others computed.

use std::fs::{self, File};
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{InputOptions, PointBatch, PointSource, PolySource, SegmentBatch};
use delaunay_tiles::query::QueryOptions;
use delaunay_tiles::store::{LineKind, TileReader};
use delaunay_tiles::{BuildOptions, Builder};
use flate2::read::GzDecoder;
use futures::TryStreamExt;

use crate::proximity::{is_near, same, walk};
use crate::support::oracle::Walk;
use crate::support::test_data::{data, shared};
use crate::support::{Scratch, runtime};

/// Builds from a PSLG of walls with hole points.
async fn build(file: &Path, options: BuildOptions) -> (Scratch, TileReader) {
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

/// Builds the map of a game with `tile_vertices`, and returns the lengths of shortest paths on it,
/// to six digits.
pub async fn game(tile_vertices: usize) -> (Scratch, TileReader, Vec<([Point; 2], f64)>) {
    let options = BuildOptions::default()
        .tile_vertices(tile_vertices)
        .exterior_is_hole(true);
    let (scratch, reader) = build(&data("arena/arena.poly"), options).await;
    let lengths = rows(&fs::read_to_string(data("arena/arena_lengths.csv")).unwrap());
    let length = |row: Vec<f64>| match row[..] {
        [x, y, to_x, to_y, length] => ([Point::new(x, y), Point::new(to_x, to_y)], length),
        _ => panic!("{row:?}"),
    };
    let lengths: Vec<_> = lengths.into_iter().map(length).collect();
    assert_eq!(lengths.len(), 160);
    (scratch, reader, lengths)
}

/// A point among islands, and a target with its distance.
#[derive(Debug)]
pub struct KnownDistance {
    pub query: f64,
    pub from: Point,
    pub to: Point,
    pub distance: f64,
}

/// Builds islands with `tile_vertices`, and returns distances between 40 points and 150 targets
/// each, three in four of which are hidden; `None` if the data is not there.
pub async fn islands(tile_vertices: usize) -> Option<(Scratch, TileReader, Vec<KnownDistance>)> {
    let (islands, truth) = (
        shared("indonesia/group1_dense_small.poly")?,
        shared("indonesia/group1_truth.csv.gz")?,
    );
    let options = BuildOptions::default().tile_vertices(tile_vertices);
    let (scratch, reader) = build(&islands, options).await;
    let known = |row: Vec<f64>| KnownDistance {
        query: row[0],
        from: Point::new(row[1], row[2]),
        to: Point::new(row[4], row[5]),
        distance: row[7],
    };
    let distances: Vec<KnownDistance> = rows(&unzipped(truth).unwrap()).into_iter().map(known).collect();
    assert_eq!(distances.len(), 6000);
    Some((scratch, reader, distances))
}

/// Returns the numbers of a table with a header.
fn rows(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().skip(1);
    rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect()
}

fn unzipped(path: PathBuf) -> io::Result<String> {
    let mut text = String::new();
    GzDecoder::new(BufReader::new(File::open(path)?)).read_to_string(&mut text)?;
    Ok(text)
}

/// Returns whether a length, rounded to six digits, is the printed one.
pub fn is_printed(length: f64, printed: f64) -> bool {
    let digits = 5 - printed.log10().floor() as i32;
    let scale = 10f64.powi(digits);
    (length * scale).round() == (printed * scale).round()
}

#[test]
fn shortest_paths_have_the_known_lengths_on_the_map_of_a_game() {
    for tile_vertices in [8, 1 << 16] {
        runtime().block_on(async {
            let (_scratch, reader, lengths) = game(tile_vertices).await;
            for ([a, b], expected) in lengths {
                for [from, to] in [[a, b], [b, a]] {
                    let Walk::Length(length) = walk(&reader, from, to).await else {
                        panic!("there is no path from {from:?} to {to:?}")
                    };
                    assert!(
                        is_printed(length, expected),
                        "{from:?} to {to:?}: {length}, not {expected}"
                    );
                }
            }
        });
    }
}

#[test]
fn shortest_paths_have_the_known_lengths_among_islands() {
    for tile_vertices in [64, 1 << 16] {
        runtime().block_on(async {
            let Some((_scratch, reader, distances)) = islands(tile_vertices).await else {
                return;
            };
            for of_query in distances.chunk_by(|a, b| a.query == b.query) {
                let from = of_query[0].from;
                let to: Vec<Point> = of_query.iter().map(|known| known.to).collect();
                let found = reader.shortest_paths(from, to, QueryOptions::default());
                let found: Vec<_> = found.try_collect().await.unwrap();
                assert_eq!(found.len(), of_query.len());
                for (target, path) in found {
                    let expected = &of_query[target];
                    assert!(
                        is_near(path.distance.value, expected.distance),
                        "{expected:?}: {path:?}"
                    );
                }
                for known in of_query.iter().step_by(7) {
                    let found = walk(&reader, from, known.to).await;
                    assert!(same(found, Walk::Length(known.distance)), "{known:?}: {found:?}");
                }
            }
        });
    }
}
