use axum::http::StatusCode;
use delaunay_tiles_service::Options;

use crate::support::{Files, get, get_with, metric};

const PATHS: [&str; 8] = [
    "/town",
    "/town/query/knn?at=0.1,7&k=3",
    "/hill/query/z?at=500001,5500001",
    "/town/native/shade.json",
    "/town/native/shade/0/0/0.png",
    "/town/native/mesh/0/0/0.mvt",
    "/hill/terrain/layer.json",
    "/hill/query/profile?from=500001,5500002&to=500400,5500300",
];

#[tokio::test]
async fn a_known_answer_is_304_and_reads_no_tile() {
    let files = Files::new().await;
    let (_, first) = files.service(Options::default()).await;
    let mut tags = Vec::new();
    for path in PATHS {
        let answer = get(&first, path).await;
        assert_eq!(answer.status, StatusCode::OK, "{path}: {:?}", answer.bytes);
        assert_eq!(answer.header("cache-control"), "no-cache");
        tags.push(answer.header("etag").to_owned());
    }
    assert_eq!(
        tags.iter().collect::<std::collections::BTreeSet<_>>().len(),
        PATHS.len()
    );
    // A new service has nothing in its caches, and the same tags.
    let (service, router) = files.service(Options::default()).await;
    let before = service.catalog().cache().statistics();
    for (path, tag) in PATHS.iter().zip(&tags) {
        let answer = get_with(&router, path, &[("if-none-match", tag)]).await;
        assert_eq!(
            (answer.status, answer.bytes.len()),
            (StatusCode::NOT_MODIFIED, 0),
            "{path}"
        );
        assert_eq!(answer.header("etag"), tag);
    }
    let after = service.catalog().cache().statistics();
    assert_eq!((before.misses, before.hits), (after.misses, after.hits));
    assert_eq!(metric(&router, "map_tile_cache_misses_total").await, 0);
    let answer = get_with(&router, PATHS[1], &[("if-none-match", "\"another\"")]).await;
    assert_eq!(answer.status, StatusCode::OK);
    assert!(service.catalog().cache().statistics().misses > after.misses);
}

#[tokio::test]
async fn an_address_with_the_present_version_is_kept_for_ever_and_another_is_not() {
    let router = Files::new().await.router(Options::default()).await;
    let version = get(&router, "/town").await.json()["version"]
        .as_str()
        .unwrap()
        .to_owned();
    for path in ["/town/native/shade/0/0/0.png", "/town/query/locate"] {
        let control = async |version: &str| {
            let answer = get(&router, &format!("{path}?at=1,2&v={version}")).await;
            answer.header("cache-control").to_owned()
        };
        assert!(control(&version).await.contains("immutable"));
        assert_eq!(control("0-9").await, "no-cache");
    }
}

#[tokio::test]
async fn what_a_limit_ended_has_no_tag() {
    let router = Files::new().await.router(Options::default()).await;
    let answer = get(&router, "/town/query/path?from=0,0&to=17,18&max-time=0").await;
    assert_eq!(
        (answer.header("etag"), answer.header("cache-control")),
        ("", "no-store")
    );
}

#[tokio::test]
async fn an_edit_changes_the_tags() {
    let files = Files::new().await;
    let router = files.router(Options::default()).await;
    let before = get(&router, PATHS[1]).await.header("etag").to_owned();
    files.edit().await;
    let answer = get_with(&router, PATHS[1], &[("if-none-match", &before)]).await;
    assert_eq!(answer.status, StatusCode::OK);
    assert_ne!(answer.header("etag"), before);
}

#[tokio::test]
async fn compressed_answers_are_the_same_and_have_tags_of_their_own() {
    use std::io::Read;
    let router = Files::new().await.router(Options::default()).await;
    for path in [
        "/town/query/knn?at=0.1,7&k=20",
        "/town/native/mesh/0/0/0.mvt",
        "/openapi.json",
    ] {
        let (plain, packed) = (
            get(&router, path).await,
            get_with(&router, path, &[("accept-encoding", "gzip")]).await,
        );
        assert_eq!(
            (packed.header("content-encoding"), plain.header("content-encoding")),
            ("gzip", "")
        );
        assert!(packed.header("vary").contains("accept-encoding") && plain.header("vary").contains("accept-encoding"));
        let mut bytes = Vec::new();
        flate2::read::GzDecoder::new(&*packed.bytes)
            .read_to_end(&mut bytes)
            .unwrap();
        assert_eq!(bytes, plain.bytes);
        assert!(packed.bytes.len() < plain.bytes.len());
        if !plain.header("etag").is_empty() {
            assert_ne!(packed.header("etag"), plain.header("etag"));
            let known = get_with(&router, path, &[("if-none-match", packed.header("etag"))]).await;
            assert_eq!(known.status, StatusCode::NOT_MODIFIED);
        }
    }
    let png = get_with(&router, "/town/native/shade/0/0/0.png", &[("accept-encoding", "gzip")]).await;
    assert_eq!(png.header("content-encoding"), "");
}
