//! Tile files on web servers: the answers are those from disk, or an error says what is wrong.

#[path = "../support/errors.rs"]
mod errors;
mod server;

use std::fs;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::io::{ObjectFile, ReadAt};
use delaunay_tiles::store::{Digest, OpenOptions, ReadError, TileId, TileReader};
use delaunay_tiles::{BuildOptions, Builder};
use errors::whole;
use server::{Fault, Lie, Server};

fn wait<T>(future: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_multi_thread().build().unwrap();
    runtime.block_on(future)
}

/// Builds a tile file of several tiles.
fn town() -> Vec<u8> {
    grid(30, 64)
}

/// Builds a tile file of `width` times `width` points.
fn grid(width: u32, tile_vertices: usize) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("town.tiles");
    let count = width * width;
    let points: Vec<Point> = (0..count)
        .map(|i| Point::new(f64::from(i % width), f64::from(i / width)))
        .collect();
    let (records, z) = ((0..count.into()).collect(), Vec::new());
    wait(async {
        let options = BuildOptions::default().tile_vertices(tile_vertices);
        let mut builder = Builder::new(&path, options).unwrap();
        builder.push(&PointBatch { records, points, z }).await.unwrap();
        builder.finish().await.unwrap();
    });
    fs::read(path).unwrap()
}

fn open(server: &Server) -> Result<TileReader, ReadError> {
    wait(TileReader::open_url(&server.url, OpenOptions::default()))
}

fn digest(server: &Server) -> Result<Digest, ReadError> {
    wait(async {
        let reader = TileReader::open_url(&server.url, OpenOptions::default()).await?;
        reader.recompute_digest().await
    })
}

/// Asserts that a digest fails with a message that contains `words`.
fn fails(fault: Fault, words: &str) {
    let server = Server::start(town(), fault);
    let error = whole(&digest(&server).unwrap_err());
    assert!(
        error.contains(words) && error.contains("town.tiles"),
        "{fault:?}: {error}"
    );
}

#[test]
fn the_digest_from_a_server_is_that_of_the_file() {
    let bytes = town();
    let file = delaunay_tiles::io::MemoryFile::new(bytes.clone());
    let expected = wait(async {
        let reader = TileReader::open_source(file, "town", OpenOptions::default())
            .await
            .unwrap();
        reader.recompute_digest().await.unwrap()
    });
    // Including faults that the reader recovers from.
    for fault in [
        Fault::None,
        Fault::NoTags,
        Fault::Fails(0, 2),
        Fault::Fails(5, 2),
        Fault::Truncates(3, 1),
        Fault::ChangedAfter(1000),
    ] {
        let server = Server::start(bytes.clone(), fault);
        assert_eq!(digest(&server).unwrap(), expected, "{fault:?}");
    }
}

#[test]
fn opening_and_reading_one_tile_take_at_most_four_requests() {
    let server = Server::start(town(), Fault::None);
    let reader = open(&server).unwrap();
    assert_eq!(
        server.requests(),
        1,
        "the beginning, with the root and the list of pages"
    );
    assert_eq!((reader.backend(), reader.backend_note()), ("object", None));
    wait(reader.tile(TileId(3))).unwrap();
    assert!(server.requests() <= 4);
    let none = Server::start(town(), Fault::NoTags);
    assert!(open(&none).unwrap().backend_note().unwrap().contains("no version tags"));
}

#[test]
fn a_tile_of_thousands_takes_at_most_four_requests_at_any_place() {
    let server = Server::start(grid(200, 8), Fault::None);
    assert!(open(&server).unwrap().metadata().tiles >= 5000);
    for place in 0..20 {
        let before = server.requests();
        let reader = open(&server).unwrap();
        let at = Point::new(f64::from(place * 73 % 199) + 0.5, f64::from(place * 31 % 199) + 0.25);
        wait(async {
            let id = reader.tile_at(at).await.unwrap().unwrap();
            reader.tile(id).await.unwrap();
        });
        let requests = server.requests() - before;
        assert!(requests <= 4, "{requests} requests for the tile at {at:?}");
    }
}

#[test]
fn ranges_close_together_are_one_request_and_their_bytes_are_aligned() {
    let bytes: Vec<u8> = (0..5_000_000u32).map(|i| (i % 251) as u8).collect();
    let server = Server::start(bytes.clone(), Fault::None);
    let file = wait(ObjectFile::open(&server.url)).unwrap();
    let ranges = [
        4_000_008..4_000_100,
        10_000..10_008,
        20_008..60_000,
        3_000_000..3_000_000,
        60_000..60_008,
        100..108,
    ];
    let before = server.requests();
    let read = wait(file.read_many(&ranges)).unwrap();
    assert_eq!(server.requests() - before, 2);
    for (read, range) in read.iter().zip(&ranges) {
        assert!(read == &bytes[range.start as usize..range.end as usize], "{range:?}");
        assert!(
            read.is_empty() || (read.as_ptr().addr() as u64 - range.start).is_multiple_of(8),
            "{range:?}"
        );
    }
}

#[test]
fn a_file_that_changed_on_the_server_is_reported() {
    for count in [1, 2, 3, 7] {
        fails(
            Fault::ChangedAfter(count),
            "has changed since it was opened; open it again",
        );
        fails(
            Fault::ChangedAfterUnnoticed(count),
            "has changed since it was opened; open it again",
        );
    }
}

/// The body of an error was once gathered in memory for as long as it came, for 30 seconds.
#[test]
fn an_endless_error_takes_no_memory_and_control_characters_are_escaped() {
    let before = delaunay_tiles::peak_memory().unwrap_or(0);
    fails(Fault::Lies(Lie::EndlessError, 0, usize::MAX), "xxxxxxxx");
    fails(Fault::Lies(Lie::EndlessError, 3, usize::MAX), "xxxxxxxx");
    let after = delaunay_tiles::peak_memory().unwrap_or(0);
    assert!(after - before < 64 << 20, "{} bytes", after - before);
    let server = Server::start(town(), Fault::Lies(Lie::Commands, 0, usize::MAX));
    let error = whole(&digest(&server).unwrap_err());
    assert!(
        error.contains(r"\u{1b}]0;owned") && !error.contains('\u{1b}'),
        "{error}"
    );
}

#[test]
fn the_web_page_of_an_error_is_not_printed() {
    for first in [0, 3] {
        let server = Server::start(town(), Fault::Lies(Lie::Page, first, usize::MAX));
        let error = whole(&digest(&server).unwrap_err());
        assert!(
            error.contains("503 Service Unavailable; the server sent a web page") && error.contains("try again later"),
            "{error}"
        );
        assert!(!error.contains('<') && !error.contains("Busy"), "{error}");
    }
}

#[test]
fn errors_name_what_is_wrong_with_a_server() {
    fails(Fault::NoRanges, "does not answer by byte range");
    fails(Fault::Missing, "there is no such object");
    fails(Fault::Missing, "; check the address");
    for lie in [Lie::Loop, Lie::LongWay, Lie::Nowhere] {
        fails(Fault::Lies(lie, 0, usize::MAX), "the request failed");
    }
    fails(Fault::Fails(0, usize::MAX), "500");
    fails(Fault::Fails(4, usize::MAX), "500");
    fails(Fault::Shortens(0), "Requested");
    fails(Fault::Shortens(2), "Requested");
    fails(Fault::Truncates(2, usize::MAX), "the request failed");
    let nobody = whole(
        &wait(TileReader::open_url(
            "http://127.0.0.1:1/town.tiles",
            OpenOptions::default(),
        ))
        .err()
        .unwrap(),
    );
    assert!(nobody.contains("town.tiles: the request failed"), "{nobody}");
}
