use axum::body::Body;
use axum::http::{Method, StatusCode};
use delaunay_tiles_service::Options;

use crate::support::{Files, get, post, send};
use serde_json::json;

#[tokio::test]
async fn the_catalogue_has_all_files_and_layers() {
    let router = Files::new().await.router(Options::default()).await;
    let tiles = get(&router, "/catalog").await.json()["tiles"].clone();
    assert!(tiles["town"]["content_type"].is_string());
    assert_eq!(tiles["town/native/shade"]["content_type"], "image/png");
    assert_eq!(tiles["hill/WebMercatorQuad/terrarium"]["content_type"], "image/png");
    assert!(tiles["town/native/terrarium"].is_null() && tiles["town/WebMercatorQuad/shade"].is_null());
    // martin's clients ask for a source at its id.
    assert!(get(&router, "/town/native/shade").await.json()["tiles"][0].is_string());
}

#[tokio::test]
async fn a_file_is_described() {
    let files = Files::new().await;
    let router = files.router(Options::default()).await;
    let (answer, reader) = (get(&router, "/town").await.json(), files.reader("town.tiles").await);
    assert_eq!(answer["counts"]["triangles"], reader.metadata().triangles);
    assert_eq!(answer["counts"]["sites"], 20);
    assert_eq!(answer["bounds"], json!([-3.0, -3.0, 20.0, 20.0]));
    assert_eq!((&answer["has_z"], &answer["generation"]), (&json!(false), &json!(1)));
    assert!(
        answer["grids"]["WebMercatorQuad"]["missing"]
            .as_str()
            .unwrap()
            .contains("reference system")
    );
    assert_eq!(answer["unit"], json!({"name": "coordinate units", "metres": null}));
    // The file does not state which lines it has.
    assert_eq!(answer["line_kinds"], json!(["break line", "wall", "obstacle"]));
    assert_eq!(
        (&answer["coloured_heights"], &answer["lowest_height"]),
        (&json!(null), &json!(null))
    );
    let hill = get(&router, "/hill").await.json();
    assert_eq!(hill["unit"], json!({"name": "m", "metres": 1.0}));
    assert_eq!((&hill["z_unit"], &hill["line_kinds"]), (&hill["unit"], &json!([])));
    // Heights are y / 1000 and up to 20 more or less.
    let height = |value: &serde_json::Value| value.as_f64().unwrap();
    let [low, high] = [0, 1].map(|i| height(&hill["coloured_heights"][i]));
    assert!(
        (5_480.0..5_490.0).contains(&low) && (5_510.0..5_521.0).contains(&high),
        "{low} {high}"
    );
    assert!((5_479.0..=low).contains(&height(&hill["lowest_height"])));
    assert_eq!(hill["crs"]["epsg"], 25832);
    let bounds = &hill["grids"]["WebMercatorQuad"]["lon_lat_bounds"];
    assert!((bounds[0].as_f64().unwrap() - 9.0).abs() < 0.1, "{bounds}");
}

#[tokio::test]
async fn what_is_not_there_is_named_and_no_path_of_the_machine_is() {
    let files = Files::new().await;
    let router = files.router(Options::default()).await;
    let folder = files.0.path().to_str().unwrap().to_owned();
    for path in [
        "/nope",
        "/town.tiles",
        "/..",
        "/%2e%2e/etc",
        "/town/",
        "/town/raw",
        "/town/query",
        "/town/query/",
        "/town/query/volume",
        "/town/nowhere/shade.json",
        "/town/native/colours.json",
        "/town/native/terrarium.json",
        "/town/native/terrarium/0/0/0.png",
        "/town/native/shade/0/0/0.mvt",
        "/town/native/shade/0/0/0",
        "/town/native/shade/x/0/0.png",
        "/town/native/shade/-1/0/0.png",
        "/town/native/shade/31/0/0.png",
        "/town/native/shade/1/2/0.png",
        "/town/native/shade/0/0/99999999999.png",
        "/town/native/shade/0/+0/0.png",
        "/town/WebMercatorQuad/shade/0/0/0.png",
        "/town/WebMercatorQuad/shade.json",
        "/town/terrain/layer.json",
        "/town/terrain/0/0/0.terrain",
        "/hill/terrain/0/2/0.terrain",
        "/hill/terrain/9/0/0.terrain",
        "/town/query/z?at=1,1",
        "/town/query/profile?from=1,1&to=2,2",
        "/%ff",
        "/%ff/query/z",
    ] {
        let answer = get(&router, path).await;
        assert_eq!(answer.status, StatusCode::NOT_FOUND, "{path}");
        let problem = answer.json();
        for key in ["what", "where", "advice"] {
            assert!(!problem[key].as_str().unwrap().is_empty(), "{path}: {problem}");
        }
        assert_eq!(problem["status"], 404);
        assert!(!String::from_utf8_lossy(&answer.bytes).contains(&folder), "{problem}");
    }
}

#[tokio::test]
async fn other_methods_are_refused_with_those_that_are_taken() {
    let router = Files::new().await.router(Options::default()).await;
    for (path, allowed) in [
        ("/health", "GET,HEAD"),
        ("/town", "GET,HEAD"),
        ("/town/query/matrix", "POST"),
    ] {
        let answer = send(&router, Method::DELETE, path, &[], Body::empty()).await;
        assert_eq!(answer.status, StatusCode::METHOD_NOT_ALLOWED);
        assert_eq!(answer.header("allow"), allowed);
        assert_eq!(answer.json()["status"], 405);
    }
    assert_eq!(
        get(&router, "/town/query/matrix").await.status,
        StatusCode::METHOD_NOT_ALLOWED
    );
    assert_eq!(
        post(&router, "/health", &json!({})).await.status,
        StatusCode::METHOD_NOT_ALLOWED
    );
}

#[tokio::test]
async fn head_has_the_headers_of_get_and_no_body() {
    let mut options = Options::default();
    options.raw = true;
    let router = Files::new().await.router(options).await;
    for path in [
        "/",
        "/catalog",
        "/health",
        "/town",
        "/town/query/path?from=0,0&to=9,9",
        "/town/native/shade.json",
        "/town/native/shade/0/0/0.png",
        "/hill/terrain/layer.json",
        "/town/raw",
        "/nope",
    ] {
        let (whole, head) = (
            get(&router, path).await,
            send(&router, Method::HEAD, path, &[], Body::empty()).await,
        );
        assert_eq!(head.status, whole.status, "{path}");
        assert!(head.bytes.is_empty() && !whole.bytes.is_empty(), "{path}");
        for name in ["etag", "content-type", "cache-control", "content-length"] {
            assert_eq!(head.header(name), whole.header(name), "{path}: {name}");
        }
    }
}

#[tokio::test]
async fn requests_are_counted_by_template_and_status() {
    let router = Files::new().await.router(Options::default()).await;
    get(&router, "/town").await;
    get(&router, "/hill").await;
    get(&router, "/nope").await;
    get(&router, "/no/such/path/at/all/there/is").await;
    let text = String::from_utf8(get(&router, "/metrics").await.bytes.to_vec()).unwrap();
    for line in [
        "delaunay_tiles_requests_total{route=\"/{id}\",status=\"200\"} 2",
        "delaunay_tiles_requests_total{route=\"/{id}\",status=\"404\"} 1",
        "delaunay_tiles_requests_total{route=\"none\",status=\"404\"} 1",
        "delaunay_tiles_panics_total 0",
    ] {
        assert!(text.lines().any(|found| found == line), "{line} in {text}");
    }
    assert!(text.contains("resident_bytes") && text.ends_with("# EOF\n"));
}

#[tokio::test]
async fn pages_of_named_origins_only_may_read_answers() {
    let files = Files::new().await;
    let mut options = Options::default();
    options.cors = vec!["https://maps.example.org".to_owned()];
    let router = files.router(options.clone()).await;
    let ask = async |router: &axum::Router, origin: &str| {
        let answer = send(router, Method::GET, "/town", &[("origin", origin)], Body::empty()).await;
        answer.header("access-control-allow-origin").to_owned()
    };
    assert_eq!(
        ask(&router, "https://maps.example.org").await,
        "https://maps.example.org"
    );
    assert_eq!(ask(&router, "https://other.example.org").await, "");
    let headers = [
        ("origin", "https://maps.example.org"),
        ("access-control-request-method", "POST"),
    ];
    let preflight = send(&router, Method::OPTIONS, "/town/query/matrix", &headers, Body::empty()).await;
    assert!(preflight.status.is_success() && preflight.header("access-control-allow-methods").contains("POST"));
    options.cors = vec!["*".to_owned()];
    assert_eq!(
        ask(&files.router(options).await, "https://other.example.org").await,
        "*"
    );
    assert_eq!(
        ask(&files.router(Options::default()).await, "https://maps.example.org").await,
        ""
    );
}
