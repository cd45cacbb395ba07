//! The page, and its scripts and styles.

use std::io::Read;

use axum::Router;
use axum::http::StatusCode;
use delaunay_tiles_service::Options;
use flate2::read::GzDecoder;

use crate::support::{Answer, Files, get, get_with};

/// The most bytes that the page may be, as sent, without map tiles.
const MOST: usize = 700_000;

fn text(answer: &Answer) -> String {
    String::from_utf8(answer.bytes.to_vec()).unwrap()
}

/// Returns the addresses that attributes of a page name, relative to it.
fn named(page: &str) -> Vec<String> {
    let attributes = ["href=\"", "src=\""];
    let all = attributes.iter().flat_map(|attribute| page.split(attribute).skip(1));
    all.filter_map(|rest| rest.split('"').next())
        .map(str::to_owned)
        .collect()
}

/// Returns the folder of the page's files.
fn assets(page: &str) -> String {
    let script = named(page).into_iter().find(|name| name.ends_with("/main.js"));
    script.unwrap().trim_end_matches("/main.js").to_owned()
}

#[tokio::test]
async fn the_page_names_all_files_and_loads_nothing_from_elsewhere() {
    let router = Files::new().await.router(Options::default()).await;
    let page = get(&router, "/").await;
    assert_eq!(page.status, StatusCode::OK);
    assert!(page.header("content-type").starts_with("text/html"));
    let policy = page.header("content-security-policy").to_owned();
    assert!(policy.contains("default-src 'none'") && !policy.contains("unsafe") && !policy.contains("http"));
    let page = text(&page);
    assert!(page.contains(r#"["town","hill"]"#) && !page.contains("{{"), "{page}");
    assert!(page.contains("<noscript>") && page.contains("href=\"catalog\""));
    for name in named(&page) {
        assert!(!name.contains("//") && !name.starts_with('/'), "{name}");
        let path = format!("/{}", name.trim_start_matches("./"));
        assert_eq!(get(&router, &path).await.status, StatusCode::OK, "{name}");
    }
}

#[tokio::test]
async fn the_page_works_within_another_router() {
    let inner = Files::new().await.router(Options::default()).await;
    let outer = Router::new().nest("/maps", inner);
    let page = text(&get(&outer, "/maps").await);
    assert!(page.contains(r#"<base href="./maps/">"#), "{page}");
    let script = format!("/maps/{}/main.js", assets(&page));
    assert_eq!(get(&outer, &script).await.status, StatusCode::OK);
}

#[tokio::test]
async fn files_of_the_page_are_kept_for_ever_under_their_version_only() {
    let router = Files::new().await.router(Options::default()).await;
    let folder = assets(&text(&get(&router, "/").await));
    let script = get(&router, &format!("/{folder}/main.js")).await;
    assert!(script.header("content-type").starts_with("text/javascript"));
    assert!(script.header("cache-control").contains("immutable"));
    let tag = script.header("etag").to_owned();
    assert!(tag.starts_with('"'), "{tag}");
    let other = get_with(&router, "/page/other/main.js", &[("if-none-match", &tag)]).await;
    assert_eq!(
        (other.status, other.header("cache-control")),
        (StatusCode::NOT_MODIFIED, "no-cache")
    );
    for path in [
        "index.html",
        "nope.js",
        "",
        "../Cargo.toml",
        "%2e%2e/Cargo.toml",
        "vendor",
    ] {
        let answer = get(&router, &format!("/{folder}/{path}")).await;
        assert_eq!(answer.status, StatusCode::NOT_FOUND, "{path}");
    }
}

#[tokio::test]
async fn the_map_library_is_sent_compressed_and_is_what_it_was() {
    let router = Files::new().await.router(Options::default()).await;
    let folder = assets(&text(&get(&router, "/").await));
    let mut sum = 0;
    for name in ["maplibre-gl.mjs", "maplibre-gl-worker.mjs", "maplibre-gl.css"] {
        let path = format!("/{folder}/vendor/maplibre-gl/{name}");
        let sent = get_with(&router, &path, &[("accept-encoding", "gzip")]).await;
        assert_eq!(sent.header("content-encoding"), "gzip");
        let mut unpacked = Vec::new();
        GzDecoder::new(&*sent.bytes).read_to_end(&mut unpacked).unwrap();
        assert!(unpacked == get(&router, &path).await.bytes, "{name}");
        sum += sent.bytes.len();
    }
    assert!(sum < MOST, "{sum} bytes");
}
