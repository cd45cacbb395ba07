//! Shared code of the fuzz targets: a file, changes to it that the fuzzer chooses, right checksums,
//! and everything that a service would ask of it. Any answer and any error is accepted; a panic, a
//! hang or unbounded memory is not.

#[path = "../../../tests/support/flat.rs"]
#[allow(dead_code, reason = "tests have more uses for it")]
pub mod flat;
#[path = "../../../tests/building/hostile/surgery.rs"]
mod surgery;

/// The module path under which `surgery` finds it.
mod support {
    pub use super::flat;
}

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::io::MemoryFile;
use delaunay_tiles::query::baselines::{Method, Stretch};
use delaunay_tiles::query::{BulkOptions, Mode, QueryOptions};
use delaunay_tiles::store::{LineKind, OpenOptions, TileReader};
use delaunay_tiles::terrain::{Clip, Surface};
use delaunay_tiles::{BuildOptions, Builder, EditOptions, Editor, MissingZ};
use futures::{StreamExt, TryStreamExt};
use surgery::Patient;

/// The part of a file that is changed.
#[derive(Clone, Copy, Debug)]
pub enum ChangedPart {
    /// The superblocks.
    Superblock,
    /// Root and pages.
    Directory,
    /// Cores, borders and component tables that lie apart.
    Tile,
    /// Component tables, their lengths, and the extents of those that lie apart.
    Tables,
    /// The plans of compressed cores and borders.
    Compressed,
}

fn runtime() -> tokio::runtime::Runtime {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .expect("a runtime")
}

/// Builds a town of 400 points with z, with a house around a court, a fence and two shops, in tiles of at most 40.
pub fn town(compress: bool) -> Patient {
    let path = std::env::temp_dir().join(format!("fuzz-{}-{compress}.tiles", std::process::id()));
    let ring = |x: f64, y: f64, r: f64| {
        let corners = [(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)].map(|(x, y)| Point::new(x, y));
        let ends = (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect();
        SegmentBatch {
            ends,
            lines: vec![0; 4],
            ..SegmentBatch::default()
        }
    };
    let points: Vec<Point> = (0..400)
        .map(|i| Point::new(f64::from(i % 20), f64::from(i / 20) + f64::from(i % 7) / 16.0))
        .collect();
    let built = runtime().block_on(async {
        let options = BuildOptions::default()
            .tile_vertices(40)
            .compress(compress)
            .force(true)
            .missing_z(MissingZ::Zero);
        let mut builder = Builder::new(&path, options)?;
        builder.push_lines(LineKind::Wall, 0, &ring(14.25, 13.125, 2.0))?;
        // A house with a court, whose ring is a line of its own.
        let (mut house, court) = (ring(5.5, 6.25, 3.0), ring(5.5, 6.25, 1.0));
        house.ends.extend(court.ends.iter().map(|&[a, b]| [b, a]));
        house.lines.extend([1; 4]);
        house.polygons = vec![1; 8];
        builder.push_lines(LineKind::Obstacle, 1, &house)?;
        builder.push_sites(&SiteBatch {
            points: vec![Point::new(1.5, 1.5), Point::new(17.5, 17.25)],
            ids: vec![SiteId::Number(7), SiteId::Text("baker".to_owned())],
            ..SiteBatch::default()
        })?;
        builder
            .push(&PointBatch {
                records: (0..400).collect(),
                points,
                z: (0..400).map(f64::from).collect(),
            })
            .await?;
        builder.finish().await
    });
    built.expect("a good file");
    let bytes = std::fs::read(&path).expect("the file that was just written");
    let _ = std::fs::remove_file(&path);
    Patient::new(bytes)
}

/// Changes the file as the data says, makes its checksums right, and asks it everything.
pub fn run(data: &[u8], changed: ChangedPart) {
    static TOWN: OnceLock<Patient> = OnceLock::new();
    static COMPRESSED: OnceLock<Patient> = OnceLock::new();
    let town = match changed {
        ChangedPart::Compressed => COMPRESSED.get_or_init(|| town(true).unpacked()),
        _ => TOWN.get_or_init(|| town(false)),
    };
    let mut town = town.clone();
    let part = |part: &surgery::FilePart| part.at..part.at + part.length;
    let parts: Vec<Range<usize>> = match changed {
        ChangedPart::Superblock => std::iter::once(0..4092).collect(),
        ChangedPart::Directory => town.directory().map(part).collect(),
        ChangedPart::Tile | ChangedPart::Compressed => town.of_tiles().map(part).collect(),
        ChangedPart::Tables => {
            let in_pages = [&town.tables_in_pages, &town.table_lengths, &town.tables_apart];
            let in_pages = in_pages.into_iter().flatten().cloned();
            in_pages.chain(town.tables.iter().map(part)).collect()
        }
    };
    // Each change has a part, an offset in it, an operation and a value.
    for change in data.chunks_exact(5) {
        let part = &parts[usize::from(change[0]) % parts.len()];
        let at = part.start + usize::from(u16::from_le_bytes([change[1], change[2]])) % part.len();
        let byte = &mut town.bytes[at];
        match change[3] % 4 {
            0 => *byte = change[4],
            1 => *byte ^= 1 << (change[4] % 8),
            2 => *byte = byte.wrapping_add(change[4]),
            _ => {
                let end = part.end.min(at + 8);
                town.bytes[at..end].fill(change[4]);
            }
        }
    }
    match changed {
        ChangedPart::Superblock => town.sew_superblocks(),
        _ => town.sew(),
    }
    runtime().block_on(async {
        if let ChangedPart::Tables = changed {
            // Edits rely on tables of tiles that they do not read.
            edit(&town.bytes).await;
        }
        ask(town.bytes).await;
    });
}

/// Adds a fence to a file. Any outcome will do, but for a panic.
async fn edit(bytes: &[u8]) {
    // Several threads may run at a time.
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let path = std::env::temp_dir().join(format!("fuzz-{}-edit-{number}.tiles", std::process::id()));
    std::fs::write(&path, bytes).expect("room for a file");
    let fence = SegmentBatch {
        ends: vec![[Point::new(1.5, 1.5), Point::new(12.0, 3.0)]],
        lines: vec![0],
        ..SegmentBatch::default()
    };
    let edited = async {
        let mut transaction = Editor::open(&path, EditOptions::default().memory(64 << 20))
            .await?
            .begin()
            .await?;
        transaction.missing_z(MissingZ::Zero);
        let first_line = transaction.first_line();
        transaction.constrain(LineKind::Wall, first_line, &fence)?;
        transaction.commit().await
    };
    let edited = edited.await;
    let _ = std::fs::remove_file(&path);
    if let Err(error) = edited {
        assert!(!error.to_string().contains("gone"), "a thread panicked: {error}");
    }
}

/// Asks a file everything; the answers do not matter.
async fn ask(bytes: Vec<u8>) {
    let opened = TileReader::open_source(MemoryFile::new(bytes), "file", OpenOptions::default().memory(64 << 20)).await;
    let Ok(reader) = opened else { return };
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.next().await {
        let Ok(tile) = tile else { continue };
        let _ = tile
            .vertex_indices()
            .filter(|&vertex| tile.is_input_point(vertex))
            .count();
        let parts = tile.owned_constraints().flat_map(|edge| tile.edge_parts(edge));
        let _ = parts.filter(|part| part.begins() || part.ends()).count();
    }
    let line = [Point::new(-1.0, 1.5), Point::new(14.0, 13.0), Point::new(5.5, 6.0)];
    let _ = reader.profile(&line, Surface::default()).await;
    let ring = [Point::new(1.0, 1.0), Point::new(15.5, 2.0), Point::new(3.0, 14.5)];
    let clip = Clip::new((0..3).map(|i| [ring[i], ring[(i + 1) % 3]]).collect());
    let _ = reader.volume(2.0, Surface::default(), Some(Arc::new(clip))).await;
    let peeled = Surface::default().max_edge(Some(2.0)).from_hull(true);
    let _ = reader.volume(2.0, peeled, None).await;
    let grid = (0..400).map(|i| Point::new(f64::from(i % 20), f64::from(i / 20)));
    let (grid, bulk): (Vec<Point>, _) = (grid.collect(), BulkOptions::default().threads(1));
    let _ = reader.locate_many(&grid[..], bulk).await;
    let _ = reader.surface_z_many(&grid[..], Surface::default(), bulk).await;
    let options = || QueryOptions::default().certified();
    for (x, y) in [(1.25, 1.5), (5.5, 6.0), (14.0, 13.0), (19.0, 3.0), (-3.0, 40.0)] {
        let _ = reader.locate(x, y).await;
        let _ = reader.z_at(x, y).await;
        let _ = reader
            .nearest_sites(Point::new(x, y), options())
            .take(3)
            .try_collect::<Vec<_>>()
            .await;
        let (from, to) = (Point::new(x, y), Point::new(18.5, 18.5));
        for mode in [Mode::Exact, Mode::Within(0.01), Mode::Fast] {
            let _ = reader.shortest_path(from, to, options().mode(mode)).await;
        }
        let _ = reader.cdt_distance(from, to, options()).await;
        for method in [
            Method::Visibility {
                stretch: Stretch::PROVED,
            },
            Method::EuclidZhang,
            Method::EuclidXia,
        ] {
            let _ = reader.nearest_sites_by(method, from, 2, options()).await;
        }
        let _ = reader.area_within(from, 7.5, options()).try_collect::<Vec<_>>().await;
        let _ = reader
            .nearest_along(from, to, 1, options())
            .try_collect::<Vec<_>>()
            .await;
    }
    let _ = reader
        .triangles_in(Rect::new(2.0, 2.0, 9.0, 9.0))
        .try_collect::<Vec<_>>()
        .await;
    let _ = reader.recompute_digest().await;
    let _ = reader.verify(true).await;
}
