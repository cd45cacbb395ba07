//! Files to serve, and requests.

use std::path::{Path, PathBuf};

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{HeaderMap, HeaderName, Method, Request, StatusCode};
use bytes::Bytes;
use delaunay_tiles::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::pipeline::Description;
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{BuildOptions, Builder, Cache, EditOptions, Editor, OpenOptions, Point, TileReader};
use delaunay_tiles_service::{Catalog, Options, Service, router};
use serde_json::Value;
use tempfile::TempDir;
use tower::ServiceExt;

/// An answer.
pub struct Answer {
    pub status: StatusCode,
    pub headers: HeaderMap,
    pub bytes: Bytes,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.bytes).unwrap_or_else(|error| panic!("{error}: {:?}", self.bytes))
    }

    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }
}

/// A folder with files to serve.
pub struct Files(pub TempDir);

impl Files {
    pub async fn new() -> Self {
        let this = Self(tempfile::tempdir().unwrap());
        town(&this.path("town.tiles"), 0.0).await;
        hill(&this.path("hill.tiles")).await;
        this
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Returns a service of the files, and its router.
    pub async fn service(&self, options: Options) -> (Service, Router) {
        let cache = Cache::new(8 << 20);
        let catalog = Catalog::open([self.path("town.tiles"), self.path("hill.tiles")], &cache);
        let service = Service::new(catalog.await.unwrap(), options.clone());
        let routed = service.router();
        (service, routed)
    }

    pub async fn router(&self, options: Options) -> Router {
        let cache = Cache::new(8 << 20);
        let catalog = Catalog::open([self.path("town.tiles"), self.path("hill.tiles")], &cache);
        router(catalog.await.unwrap(), options)
    }

    /// Adds a wall to the town, and waits until that is noticed.
    pub async fn edit(&self) {
        let mut transaction = Editor::open(self.path("town.tiles"), EditOptions::default().memory(64 << 20))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        let wall = [Point::new(-1.5, 3.0), Point::new(-1.5, 8.0)];
        let batch = SegmentBatch {
            ends: vec![wall],
            lines: vec![0],
            ..SegmentBatch::default()
        };
        let first = transaction.first_line();
        transaction.constrain(LineKind::Wall, first, &batch).unwrap();
        transaction.commit().await.unwrap();
        tokio::time::sleep(std::time::Duration::from_millis(700)).await;
    }

    pub async fn reader(&self, name: &str) -> TileReader {
        TileReader::open(self.path(name), OpenOptions::default()).await.unwrap()
    }
}

fn ring([x, y, u, v]: [f64; 4]) -> Vec<[Point; 2]> {
    let corners = [[x, y], [u, y], [u, v], [x, v]].map(|[x, y]| Point::new(x, y));
    (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect()
}

/// Builds a town: a grid of houses, a closed wall, and sites. Everything is `shift` to the east.
pub async fn town(path: &Path, shift: f64) {
    let mut builder = Builder::new(path, BuildOptions::default().tile_vertices(50).force(true)).unwrap();
    for house in 0..36u32 {
        let [x, y] = [house % 6, house / 6].map(f64::from);
        let ends = ring([
            x * 3.0 + 1.0 + shift,
            y * 3.0 + 1.0,
            x * 3.0 + 2.5 + shift,
            y * 3.0 + 2.5,
        ]);
        let lines = vec![house.into(); 4];
        let batch = SegmentBatch {
            ends,
            lines,
            ..SegmentBatch::default()
        };
        builder.push_lines(LineKind::Obstacle, 0, &batch).unwrap();
    }
    let wall = SegmentBatch {
        ends: ring([-2.0 + shift, -2.0, -1.0 + shift, -1.0]),
        lines: vec![0; 4],
        ..SegmentBatch::default()
    };
    builder.push_lines(LineKind::Wall, 1, &wall).unwrap();
    let sites: Vec<Point> = (0..20)
        .map(|i| Point::new(f64::from(i % 5) * 3.0 + 0.5 + shift, f64::from(i / 5) * 3.0 + 0.25))
        .collect();
    let ids = (0..20).map(|number| SiteId::Text(format!("shop {number}")));
    let ids: Vec<SiteId> = ids.collect();
    builder
        .push_sites(&SiteBatch {
            points: sites,
            ids,
            ..SiteBatch::default()
        })
        .unwrap();
    let corners = [[-3.0, -3.0], [20.0, -3.0], [20.0, 20.0], [-3.0, 20.0]];
    let points: Vec<Point> = corners.iter().map(|[x, y]| Point::new(x + shift, *y)).collect();
    let batch = PointBatch {
        records: (0..4).collect(),
        points,
        z: vec![],
    };
    builder.push(&batch).await.unwrap();
    builder.finish().await.unwrap();
}

/// Builds a surface with heights, in a known reference system.
pub async fn hill(path: &Path) {
    let options = BuildOptions::default().tile_vertices(500).force(true);
    let mut builder = Builder::new(path, options).unwrap();
    let crs = Some("EPSG:25832".to_owned());
    builder.describe(Description {
        crs,
        ..Description::default()
    });
    let points: Vec<Point> = (0..10_000)
        .map(|i| {
            Point::new(
                500_000.0 + f64::from(i % 100) * 10.0,
                5_500_000.0 + f64::from(i / 100) * 10.0,
            )
        })
        .collect();
    let z = points
        .iter()
        .map(|p| (p.x / 100.0).sin() * 20.0 + p.y / 1000.0)
        .collect();
    builder
        .push(&PointBatch {
            records: (0..10_000).collect(),
            points,
            z,
        })
        .await
        .unwrap();
    builder.finish().await.unwrap();
}

/// Sends a request.
pub async fn send(router: &Router, method: Method, path: &str, headers: &[(&str, &str)], body: Body) -> Answer {
    let mut request = Request::builder().method(method).uri(path);
    for (name, value) in headers {
        request = request.header(HeaderName::from_bytes(name.as_bytes()).unwrap(), *value);
    }
    let response = router.clone().oneshot(request.body(body).unwrap()).await.unwrap();
    let (parts, body) = response.into_parts();
    Answer {
        status: parts.status,
        headers: parts.headers,
        bytes: to_bytes(body, usize::MAX).await.unwrap(),
    }
}

pub async fn get(router: &Router, path: &str) -> Answer {
    send(router, Method::GET, path, &[], Body::empty()).await
}

pub async fn get_with(router: &Router, path: &str, headers: &[(&str, &str)]) -> Answer {
    send(router, Method::GET, path, headers, Body::empty()).await
}

pub async fn post(router: &Router, path: &str, body: &Value) -> Answer {
    send(
        router,
        Method::POST,
        path,
        &[("content-type", "application/json")],
        Body::from(body.to_string()),
    )
    .await
}

/// Returns a measurement.
pub async fn metric(router: &Router, name: &str) -> u64 {
    let text = get(router, "/metrics").await.bytes;
    let text = String::from_utf8(text.to_vec()).unwrap();
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix(&format!("delaunay_tiles_{name} ")));
    line.unwrap_or_else(|| panic!("no {name} in {text}")).parse().unwrap()
}
