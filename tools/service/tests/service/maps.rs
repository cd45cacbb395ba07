use std::time::Duration;

use axum::Router;
use axum::http::StatusCode;
use delaunay_tiles::map_tiles::{DrawLimits, GridKind, Layer, MapSource, TerrainCoord, TileCoord};
use delaunay_tiles_service::Options;

use crate::support::{Files, get, get_with, metric};

#[tokio::test]
async fn map_tiles_are_those_of_the_library() {
    let files = Files::new().await;
    let router = files.router(Options::default()).await;
    for (name, grid, layer, z, x, y) in [
        ("town", GridKind::Native, Layer::Shade, 0, 0, 0),
        ("town", GridKind::Native, Layer::Mesh, 1, 0, 1),
        ("hill", GridKind::Native, Layer::Terrarium, 1, 1, 0),
        ("hill", GridKind::WebMercatorQuad, Layer::Shade, 0, 0, 0),
        ("hill", GridKind::WebMercatorQuad, Layer::Mesh, 4, 8, 5),
    ] {
        let maps = MapSource::open(files.reader(&format!("{name}.tiles")).await)
            .await
            .unwrap();
        let at = TileCoord::new(z, x, y).unwrap();
        let drawn = maps.draw(grid, layer, at, DrawLimits::default()).await.unwrap();
        let answer = get(&router, &format!("/{name}/{grid}/{layer}/{at}.{}", layer.ending())).await;
        assert_eq!(
            answer.status,
            if drawn.is_empty() {
                StatusCode::NO_CONTENT
            } else {
                StatusCode::OK
            }
        );
        assert_eq!(answer.bytes, drawn.bytes, "{name} {grid} {layer} {at}");
        assert!(drawn.is_empty() || answer.header("content-type") == layer.media_type());
    }
    let maps = MapSource::open(files.reader("hill.tiles").await).await.unwrap();
    let drawn = maps
        .terrain(TerrainCoord::new(0, 1, 0).unwrap(), DrawLimits::default())
        .await
        .unwrap();
    let answer = get(&router, "/hill/terrain/0/1/0.terrain").await;
    assert_eq!((answer.status, &answer.bytes), (StatusCode::OK, &drawn.bytes));
    assert_eq!(answer.header("content-type"), "application/vnd.quantized-mesh");
}

#[tokio::test]
async fn a_map_tile_is_drawn_once() {
    let router = Files::new().await.router(Options::default()).await;
    let path = "/town/native/shade/0/0/0.png";
    let all: Vec<_> = (0..8).map(|_| get(&router, path)).collect();
    let all = futures::future::join_all(all).await;
    assert!(
        all.iter()
            .all(|answer| answer.bytes == all[0].bytes && answer.status == StatusCode::OK)
    );
    assert_eq!(metric(&router, "map_tile_cache_misses_total").await, 1);
    assert_eq!(metric(&router, "map_tile_cache_hits_total").await, 7);
}

#[tokio::test]
async fn where_nothing_is_there_is_no_content() {
    let router = Files::new().await.router(Options::default()).await;
    let answer = get(&router, "/hill/WebMercatorQuad/shade/4/0/0.png").await;
    assert_eq!((answer.status, answer.bytes.len()), (StatusCode::NO_CONTENT, 0));
    assert!(!answer.header("etag").is_empty());
}

#[tokio::test]
async fn a_picture_that_needs_too_much_says_so() {
    let files = Files::new().await;
    let mut options = Options::default();
    options.max_picture_tiles = 2;
    let router = files.router(options).await;
    let answer = get(&router, "/hill/native/terrarium/0/0/0.png").await;
    assert_eq!(answer.status, StatusCode::NOT_FOUND, "{:?}", answer.bytes);
    assert!(answer.json()["what"].as_str().unwrap().contains("tiles"));
    let minimum = get(&router, "/hill/native/terrarium.json").await.json()["minzoom"]
        .as_u64()
        .unwrap();
    assert!(minimum > 0);
    let answer = get(&router, &format!("/hill/native/terrarium/{minimum}/0/0.png")).await;
    assert!(answer.status.is_success(), "{minimum}: {:?}", answer.bytes);
    // A request can lower the limit, and not raise it.
    let router = files.router(Options::default()).await;
    assert_eq!(
        get(&router, "/hill/native/terrarium/0/0/0.png?max-tiles=1")
            .await
            .status,
        StatusCode::NOT_FOUND
    );
    assert_eq!(
        get(&router, "/hill/native/terrarium/0/0/0.png").await.status,
        StatusCode::OK
    );
}

#[tokio::test]
async fn heights_without_transparent_pixels_are_another_tile() {
    let router = Files::new().await.router(Options::default()).await;
    // The colour type of a PNG: 2 without opacity, 6 with it.
    let colours = |bytes: &[u8]| bytes[25];
    let path = "/hill/native/terrarium/0/0/0.png";
    let (plain, opaque) = (
        get(&router, path).await,
        get(&router, &format!("{path}?opaque=true")).await,
    );
    assert_eq!((colours(&plain.bytes), colours(&opaque.bytes)), (6, 2));
    assert_ne!(plain.header("etag"), opaque.header("etag"));
    let picture = "/hill/native/shade/0/0/0.png";
    let pictures = [
        get(&router, picture).await,
        get(&router, &format!("{picture}?opaque=true")).await,
    ];
    assert_eq!(pictures[0].bytes, pictures[1].bytes);
    assert_eq!(
        get(&router, &format!("{path}?opaque=perhaps")).await.status,
        StatusCode::BAD_REQUEST
    );
}

#[tokio::test]
async fn a_drawing_that_takes_too_long_is_given_up() {
    let mut options = Options::default();
    options.max_time = Duration::ZERO;
    let router = Files::new().await.router(options).await;
    let answer = get(&router, "/town/native/shade/0/0/0.png").await;
    assert_eq!(answer.status, StatusCode::SERVICE_UNAVAILABLE);
}

#[tokio::test]
async fn addresses_are_right_under_a_prefix_and_behind_a_proxy() {
    let files = Files::new().await;
    let inner = files.router(Options::default()).await;
    let url = async |router: &Router, path: &str, headers: &[(&str, &str)]| {
        let tiles = get_with(router, path, headers).await.json()["tiles"][0]
            .as_str()
            .unwrap()
            .to_owned();
        tiles.split("{z}").next().unwrap().to_owned()
    };
    let host = ("host", "maps.example.org:8080");
    let path = "/town/native/mesh.json";
    assert_eq!(
        url(&inner, path, &[host]).await,
        "http://maps.example.org:8080/town/native/mesh/"
    );
    let outer = Router::new().nest("/a/b", inner.clone());
    let nested = format!("/a/b{path}");
    assert_eq!(
        url(&outer, &nested, &[host]).await,
        "http://maps.example.org:8080/a/b/town/native/mesh/"
    );
    let proxy = [
        host,
        ("x-forwarded-proto", "https"),
        ("x-forwarded-host", "example.org"),
        ("x-forwarded-prefix", "/maps/"),
    ];
    assert_eq!(
        url(&inner, path, &proxy).await,
        "https://example.org/maps/town/native/mesh/"
    );
    let evil = [
        host,
        ("x-forwarded-proto", "javascript"),
        ("x-forwarded-host", "a/\"><b"),
        ("x-forwarded-prefix", "//c"),
    ];
    assert_eq!(
        url(&inner, path, &evil).await,
        "http://maps.example.org:8080/town/native/mesh/"
    );
    let mut options = Options::default();
    options.public_url = Some("https://example.org/x/".to_owned());
    assert_eq!(
        url(&files.router(options).await, path, &[host]).await,
        "https://example.org/x/town/native/mesh/"
    );
}

#[tokio::test]
async fn tile_json_describes_the_layers() {
    let router = Files::new().await.router(Options::default()).await;
    let mesh = get(&router, "/hill/WebMercatorQuad/mesh.json").await.json();
    let layers: Vec<&str> = mesh["vector_layers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|layer| layer["id"].as_str().unwrap())
        .collect();
    assert!(layers.contains(&"triangles") && layers.contains(&"sites"), "{layers:?}");
    assert_eq!(mesh["bounds"].as_array().unwrap().len(), 4);
    assert!(
        mesh["tiles"][0]
            .as_str()
            .unwrap()
            .contains("/hill/WebMercatorQuad/mesh/{z}/{x}/{y}.mvt?v=")
    );
    let heights = get(&router, "/hill/native/terrarium.json").await.json();
    assert_eq!(
        (heights["encoding"].as_str(), heights["tilejson"].as_str()),
        (Some("terrarium"), Some("3.0.0"))
    );
    let terrain = get(&router, "/hill/terrain/layer.json").await.json();
    assert_eq!(
        (terrain["format"].as_str(), terrain["scheme"].as_str()),
        (Some("quantized-mesh-1.0"), Some("tms"))
    );
}
