//! The promise: a map tile shows what the triangulation has, where it has it, and is a function of
//! the file's content, the grid and the numbers of the tile.

mod archives;
mod degenerate;
mod earth;
mod limits;
mod pictures;
mod terrain;
mod vectors;

use delaunay_tiles::input::{SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::map_tiles::{DrawLimits, Drawn, GridKind, Layer, MapSource, TileCoord, TileGrid};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{BuildOptions, Builder, Description, Point};

use crate::support::{Random, Scratch, batches};

/// The side of the square of random points.
const SIDE: f64 = 100.0;

/// What a file is built from.
#[derive(Clone, Default)]
struct Plan {
    points: Vec<Point>,
    z: Vec<f64>,
    lines: Vec<(LineKind, Vec<[Point; 2]>)>,
    sites: Vec<Point>,
    crs: Option<&'static str>,
    tile_vertices: usize,
}

impl Plan {
    /// Random points in a square, without z.
    fn square(count: usize, seed: u64) -> Self {
        let mut random = Random(seed);
        let mut points: Vec<Point> = (0..count)
            .map(|_| Point::new(SIDE * random.unit(), SIDE * random.unit()))
            .collect();
        points.extend([(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)].map(|(x, y)| Point::new(x, y)));
        Self {
            points,
            tile_vertices: 500,
            ..Self::default()
        }
    }

    fn with_z(mut self, z: impl Fn(Point) -> f64) -> Self {
        self.z = self.points.iter().map(|&p| z(p)).collect();
        self
    }

    fn tile_vertices(mut self, count: usize) -> Self {
        self.tile_vertices = count;
        self
    }

    fn crs(mut self, crs: &'static str) -> Self {
        self.crs = Some(crs);
        self
    }

    /// Obstacles on a grid of squares, a break line and a wall between them, and sites.
    fn with_town(mut self) -> Self {
        for i in 0..16 {
            let (x, y) = (10.3 + 22.0 * f64::from(i % 4), 9.1 + 23.0 * f64::from(i / 4));
            let corners = [(x, y), (x + 9.7, y + 1.3), (x + 8.1, y + 9.9), (x - 1.9, y + 8.2)];
            let corners = corners.map(|(x, y)| Point::new(x, y));
            let ring = (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect();
            self.lines.push((LineKind::Obstacle, ring));
        }
        self.lines
            .push((LineKind::BreakLine, vec![[Point::new(3.0, 4.0), Point::new(97.0, 4.5)]]));
        self.lines
            .push((LineKind::Wall, vec![[Point::new(27.0, 6.0), Point::new(26.0, 95.0)]]));
        self.sites = vec![Point::new(5.0, 50.0), Point::new(95.5, 27.25)];
        self
    }

    async fn build(&self) -> (Scratch, MapSource) {
        let scratch = Scratch::new();
        let options = BuildOptions::default().tile_vertices(self.tile_vertices);
        let mut builder = Builder::new(&scratch.path, options).unwrap();
        builder.describe(Description {
            crs: self.crs.map(str::to_owned),
            ..Description::default()
        });
        for (number, (kind, ends)) in self.lines.iter().enumerate() {
            let lines = vec![number as u64; ends.len()];
            let batch = SegmentBatch {
                ends: ends.clone(),
                lines,
                ..SegmentBatch::default()
            };
            builder.push_lines(*kind, number as u64, &batch).unwrap();
        }
        let ids = (0..self.sites.len() as u64).map(SiteId::Number).collect();
        builder
            .push_sites(&SiteBatch {
                points: self.sites.clone(),
                ids,
                ..SiteBatch::default()
            })
            .unwrap();
        for batch in batches(&self.points, &self.z) {
            builder.push(&batch).await.unwrap();
        }
        builder.finish().await.unwrap();
        let source = MapSource::open(scratch.open().await).await.unwrap();
        (scratch, source)
    }
}

/// A hill, a valley, and a plateau.
fn hills(p: Point) -> f64 {
    120.0 + 30.0 * (p.x / 17.0).sin() + 25.0 * (p.y / 23.0).cos() + p.x / 10.0
}

fn tile(z: u8, x: u32, y: u32) -> TileCoord {
    TileCoord::new(z, x, y).unwrap()
}

/// All tiles of a zoom that have something of a file.
fn tiles_of(grid: &TileGrid, zoom: u8) -> Vec<TileCoord> {
    let (bounds, square) = (grid.bounds(), grid.square());
    let side = (square.max_x - square.min_x) / f64::from(1u32 << zoom);
    let last = (1u32 << zoom) - 1;
    let number = |far: f64| ((far / side) as u32).min(last);
    let columns = number(bounds.min_x - square.min_x)..=number(bounds.max_x - square.min_x);
    let rows = number(square.max_y - bounds.max_y)..=number(square.max_y - bounds.min_y);
    columns
        .flat_map(|x| rows.clone().map(move |y| tile(zoom, x, y)))
        .collect()
}

async fn draw(source: &MapSource, grid: GridKind, layer: Layer, at: TileCoord) -> Drawn {
    source.draw(grid, layer, at, DrawLimits::default()).await.unwrap()
}

/// Returns red, green, blue and opacity of each pixel.
fn pixels(png: &[u8]) -> Vec<[u8; 4]> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height), (256, 256));
    match info.color_type {
        png::ColorType::Rgb => bytes.chunks(3).map(|c| [c[0], c[1], c[2], 255]).collect(),
        png::ColorType::Rgba => bytes.chunks(4).map(|c| [c[0], c[1], c[2], c[3]]).collect(),
        other => panic!("{other:?}"),
    }
}

/// Returns the point of the file at a place in a pixel, computed in another way than the library
/// does.
fn point_in(grid: &TileGrid, at: TileCoord, pixel: usize, within: [f64; 2]) -> Point {
    let all = 256.0 * f64::from(1u32 << at.z());
    let x = (f64::from(at.x() * 256) + (pixel % 256) as f64 + within[0]) / all;
    let y = (f64::from(at.y() * 256) + (pixel / 256) as f64 + within[1]) / all;
    match grid.kind() {
        GridKind::Native => {
            let square = grid.square();
            let side = square.max_x - square.min_x;
            Point::new(square.min_x + x * side, square.max_y - y * side)
        }
        GridKind::WebMercatorQuad => grid.point_at([x, y]).unwrap(),
    }
}
