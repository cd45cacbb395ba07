//! Archives of map tiles, read by the reader of crate `pmtiles`.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::PathBuf;

use delaunay_tiles::map_archive::{ArchiveError, ArchiveOptions, plan, write};
use delaunay_tiles::map_tiles::{DrawError, GridKind, Layer, MapSource, NoGrid, TileCoord};
use pmtiles::{AsyncPmTilesReader, Compression, MmapBackend, TileType};
use serde_json::Value;

use super::{Plan, draw, hills, tiles_of};
use crate::support::{Scratch, runtime};

type Reader = AsyncPmTilesReader<MmapBackend>;

/// Writes an archive. Returns its path, and the number of its map tiles.
async fn archive(scratch: &Scratch, source: &MapSource, options: ArchiveOptions) -> (PathBuf, u64) {
    let path = scratch.path.with_extension("pmtiles");
    let planned = plan(source, options).await.unwrap();
    let mut seen = Vec::new();
    let progress = |done, total| seen.push((done, total));
    let output = File::create(&path).unwrap();
    let summary = write(source, &planned, output, progress).await.unwrap();
    assert_eq!(summary.bytes, path.metadata().unwrap().len());
    let total = planned.tiles();
    assert_eq!(seen, (1..=total).map(|done| (done, total)).collect::<Vec<_>>());
    (path, summary.tiles)
}

fn options(grid: GridKind, layer: Layer, zooms: &str) -> ArchiveOptions {
    ArchiveOptions::new(grid, layer).zooms(Some(zooms.parse().unwrap()))
}

async fn tile(reader: &Reader, at: TileCoord) -> Option<Vec<u8>> {
    let at = pmtiles::TileCoord::new(at.z(), at.x(), at.y()).unwrap();
    reader.get_tile_decompressed(at).await.unwrap().map(Into::into)
}

/// Checks that an archive has what is drawn of these tiles, and nothing else.
async fn has_what_is_drawn(source: &MapSource, grid: GridKind, layer: Layer, first: u8, last: u8) -> u64 {
    let scratch = Scratch::new();
    let (path, count) = archive(&scratch, source, options(grid, layer, &format!("{first}..{last}"))).await;
    let reader = Reader::new_with_path(&path).await.unwrap();
    let mut found = 0;
    for zoom in first..=last {
        for at in tiles_of(source.grid(grid).unwrap(), zoom) {
            let drawn = draw(source, grid, layer, at).await;
            let expected = (!drawn.is_empty()).then(|| drawn.bytes.to_vec());
            assert!(tile(&reader, at).await == expected, "{grid} {layer} {at}");
            found += u64::from(expected.is_some());
        }
    }
    assert_eq!(found, count, "{grid} {layer}");
    found
}

#[test]
fn an_archive_has_the_tiles_that_are_drawn_and_no_others() {
    runtime().block_on(async {
        let plan = Plan::square(200, 31).with_z(hills).with_town().crs("EPSG:3857");
        let (_scratch, source) = plan.build().await;
        for layer in Layer::ALL {
            assert!(has_what_is_drawn(&source, GridKind::Native, layer, 0, 2).await > 10);
            assert!(has_what_is_drawn(&source, GridKind::WebMercatorQuad, layer, 17, 19).await > 3);
        }
    });
}

#[test]
fn regions_without_data_are_left_out_before_they_are_drawn() {
    runtime().block_on(async {
        // Of a disc, the corners of the rectangle around it have no data.
        let mut disc = Plan::square(4000, 32).tile_vertices(50);
        disc.points.retain(|p| (p.x - 50.0).hypot(p.y - 50.0) < 50.0);
        let (_scratch, source) = disc.with_z(hills).build().await;
        has_what_is_drawn(&source, GridKind::Native, Layer::Terrarium, 2, 2).await;
        let planned = plan(&source, options(GridKind::Native, Layer::Terrarium, "7"))
            .await
            .unwrap();
        let all = tiles_of(source.grid(GridKind::Native).unwrap(), 7).len() as u64;
        let share = planned.tiles() as f64 / all as f64;
        assert!((0.785..0.93).contains(&share), "{share}");
    });
}

#[test]
fn the_bytes_do_not_depend_on_how_many_tiles_are_drawn_at_once() {
    runtime().block_on(async {
        let (scratch, source) = Plan::square(300, 33).with_z(hills).with_town().build().await;
        for layer in [Layer::Shade, Layer::Mesh] {
            let mut archives = HashSet::new();
            for at_once in [1, 2, 7] {
                let options = options(GridKind::Native, layer, "0..2").at_once(at_once);
                let (path, _) = archive(&scratch, &source, options).await;
                archives.insert(std::fs::read(path).unwrap());
            }
            assert_eq!(archives.len(), 1, "{layer}");
        }
    });
}

#[test]
fn the_header_and_the_metadata_describe_the_layer() {
    runtime().block_on(async {
        let plan = Plan::square(200, 34).with_z(hills).with_town().crs("EPSG:3857");
        let (scratch, source) = plan.build().await;
        for layer in Layer::ALL {
            for (grid, zooms) in [(GridKind::Native, "0..1"), (GridKind::WebMercatorQuad, "17..18")] {
                let options = options(grid, layer, zooms).name("a \"town\"");
                let options = options.attribution(Some("© us".to_owned()));
                let (path, _) = archive(&scratch, &source, options).await;
                let reader = Reader::new_with_path(&path).await.unwrap();
                let metadata: Value = serde_json::from_str(&reader.get_metadata().await.unwrap()).unwrap();
                let header = reader.get_header();
                let is_mesh = layer == Layer::Mesh;
                assert_eq!(header.tile_type == TileType::Mvt, is_mesh);
                assert_eq!(header.tile_compression == Compression::Gzip, is_mesh);
                assert_eq!(format!("{}..{}", header.min_zoom, header.max_zoom), zooms);
                assert!((header.min_zoom..=header.max_zoom).contains(&header.center_zoom));
                let shown = source.grid(grid).unwrap().shown_bounds();
                assert!(header.min_longitude <= shown.min_x && shown.max_x <= header.max_longitude);
                assert!(header.min_latitude <= shown.min_y && shown.max_y <= header.max_latitude);
                assert!((header.center_longitude - (shown.min_x + shown.max_x) / 2.0).abs() < 1e-6);
                assert_eq!(metadata["bounds"][0], header.min_longitude);
                assert_eq!(metadata["name"], "a \"town\"");
                assert_eq!(metadata["attribution"], "© us");
                assert_eq!(metadata["grid"], grid.name());
                assert_eq!(metadata.get("grid_square").is_some(), grid == GridKind::Native);
                assert_eq!(metadata.get("encoding").is_some(), layer == Layer::Terrarium);
                let layers = metadata
                    .get("vector_layers")
                    .map(|layers| layers.as_array().unwrap().len());
                assert_eq!(layers, is_mesh.then(|| layer.vector_layers().len()));
            }
        }
    });
}

#[test]
fn tiles_with_the_same_bytes_are_stored_once() {
    runtime().block_on(async {
        let (scratch, source) = Plan::square(0, 35).with_z(|_| 7.0).build().await;
        let (path, count) = archive(&scratch, &source, options(GridKind::Native, Layer::Terrarium, "0..3")).await;
        let reader = Reader::new_with_path(&path).await.unwrap();
        let (mut distinct, mut all) = (HashSet::new(), 0);
        for zoom in 0..=3 {
            for at in tiles_of(source.grid(GridKind::Native).unwrap(), zoom) {
                if let Some(bytes) = tile(&reader, at).await {
                    all += bytes.len() as u64;
                    distinct.insert(bytes);
                }
            }
        }
        assert!(distinct.len() as u64 * 3 < count, "{} of {count}", distinct.len());
        let stored: usize = distinct.iter().map(Vec::len).sum();
        let length = path.metadata().unwrap().len();
        // Header and directories have 16 KiB.
        assert!(
            length < stored as u64 + (20 << 10) && length < all,
            "{length}, {stored}, {all}"
        );
    });
}

#[test]
fn what_cannot_be_written_is_said_before_anything_is() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(3000, 36).tile_vertices(100).build().await;
        let error = plan(&source, options(GridKind::Native, Layer::Terrarium, "0"))
            .await
            .unwrap_err();
        assert!(matches!(
            error,
            ArchiveError::Source(DrawError::NoLayer(Layer::Terrarium))
        ));
        let error = plan(&source, options(GridKind::WebMercatorQuad, Layer::Shade, "0"))
            .await
            .unwrap_err();
        assert!(matches!(error, ArchiveError::Source(DrawError::NoGrid(NoGrid::NoCrs))));
        let small = options(GridKind::Native, Layer::Mesh, "0..4").directory_memory(10_000);
        let error = plan(&source, small).await.unwrap_err();
        assert!(matches!(error, ArchiveError::Memory { allowed: 10_000, .. }), "{error}");
        let whole = options(GridKind::Native, Layer::Shade, "0").max_picture_tiles(8);
        let planned = plan(&source, whole).await.unwrap();
        let error = write(&source, &planned, io::Cursor::new(Vec::new()), |_, _| ())
            .await
            .unwrap_err();
        let ArchiveError::OutOfBudget {
            needed, allowed, first, ..
        } = error
        else {
            panic!("{error}");
        };
        assert!(needed > 8 && allowed == 8 && first > 0);
    });
}

#[test]
fn too_many_map_tiles_are_an_error_with_their_number_and_bytes() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(100, 37).build().await;
        // The square of the grid is 128 wide, the file 100: its tiles are counted here by arithmetic.
        let of_zoom = |zoom: i32| (100.0 / 128.0 * 2f64.powi(zoom)).ceil().powi(2) as u64;
        let all: u64 = (0..=4).map(of_zoom).sum();
        let fits = plan(&source, options(GridKind::Native, Layer::Mesh, "0..4"))
            .await
            .unwrap();
        assert!(
            fits.tiles() >= all && fits.tiles() <= all + all / 4,
            "{} {all}",
            fits.tiles()
        );
        for (zooms, last, allowed, fitting) in [("0..4", 4, fits.tiles() - 1, Some(3)), ("0..20", 20, 10_000, Some(6))]
        {
            let error = plan(
                &source,
                options(GridKind::Native, Layer::Mesh, zooms).max_tiles(allowed),
            )
            .await;
            let ArchiveError::TooMany(error) = error.unwrap_err() else {
                panic!()
            };
            let all: u64 = (0..=last).map(of_zoom).sum();
            assert!(error.tiles > all / 2 && error.tiles < all * 2, "{} {all}", error.tiles);
            assert_eq!((error.allowed, error.fitting), (allowed, fitting));
            // A tile has at least the layers `cells` and `info`.
            assert!(error.bytes > 100 * error.tiles);
        }
    });
}

/// An output that fails after so many bytes.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = bytes.len().min(self.0);
        self.0 -= written;
        match written {
            0 => Err(io::ErrorKind::StorageFull.into()),
            _ => Ok(written),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Full {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Ok(0)
    }
}

#[test]
fn a_full_disk_is_an_error_wherever_it_shows() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(50, 38).build().await;
        let planned = plan(&source, options(GridKind::Native, Layer::Mesh, "0..2"))
            .await
            .unwrap();
        for most in [0, 100, 20_000] {
            let error = write(&source, &planned, Full(most), |_, _| ()).await.unwrap_err();
            let ArchiveError::Write(error) = error else {
                panic!("{most}: {error}");
            };
            assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        }
    });
}
