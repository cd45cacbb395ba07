use std::fs;

use axum::body::Body;
use axum::http::{Request, StatusCode};
use delaunay_tiles_service::Options;
use futures::StreamExt;
use tower::ServiceExt;

use crate::support::{Files, get, get_with};

fn raw() -> Options {
    let mut options = Options::default();
    options.raw = true;
    options
}

#[tokio::test]
async fn bytes_are_served_only_if_that_is_wished() {
    let files = Files::new().await;
    assert_eq!(
        get(&files.router(Options::default()).await, "/town/raw").await.status,
        StatusCode::NOT_FOUND
    );
    let answer = get(&files.router(raw()).await, "/town/raw").await;
    assert_eq!(answer.status, StatusCode::OK);
    assert_eq!(answer.header("accept-ranges"), "bytes");
    assert_eq!(answer.bytes, fs::read(files.path("town.tiles")).unwrap());
}

#[tokio::test]
async fn ranges_are_parts_of_the_file() {
    let files = Files::new().await;
    let router = files.router(raw()).await;
    let whole = fs::read(files.path("hill.tiles")).unwrap();
    let length = whole.len();
    for (range, start, end) in [
        ("bytes=0-0".to_owned(), 0, 1),
        ("bytes=4000-9000".to_owned(), 4000, 9001),
        (format!("bytes={}-", length - 5), length - 5, length),
        ("bytes=-7".to_owned(), length - 7, length),
        ("bytes=10-99999999999999999999999".to_owned(), 10, length),
    ] {
        let answer = get_with(&router, "/hill/raw", &[("range", &range)]).await;
        assert_eq!(answer.status, StatusCode::PARTIAL_CONTENT, "{range}");
        assert_eq!(
            answer.header("content-range"),
            format!("bytes {start}-{}/{length}", end - 1)
        );
        assert_eq!(answer.bytes, whole[start..end]);
    }
    let answer = get_with(&router, "/hill/raw", &[("range", &format!("bytes={length}-"))]).await;
    assert_eq!(answer.status, StatusCode::RANGE_NOT_SATISFIABLE);
    assert_eq!(answer.header("content-range"), format!("bytes */{length}"));
    let several = get_with(&router, "/hill/raw", &[("range", "bytes=0-1,5-6")]).await;
    assert_eq!((several.status, several.bytes.len()), (StatusCode::OK, length));
}

#[tokio::test]
async fn a_reader_never_gets_bytes_of_two_states() {
    let files = Files::new().await;
    let router = files.router(raw()).await;
    let before = fs::read(files.path("town.tiles")).unwrap();
    let tag = get(&router, "/town/raw").await.header("etag").to_owned();
    // The head is sent before the edit, and the body is read after it.
    let request = Request::builder().uri("/town/raw").body(Body::empty()).unwrap();
    let begun = router.clone().oneshot(request).await.unwrap();
    files.edit().await;
    let parts: Vec<_> = begun.into_body().into_data_stream().collect().await;
    let read: Vec<u8> = parts.into_iter().flat_map(|part| part.unwrap().to_vec()).collect();
    assert_eq!(read, before);
    let after = fs::read(files.path("town.tiles")).unwrap();
    assert_ne!(after[..before.len()], before);
    let answer = get_with(&router, "/town/raw", &[("if-match", &tag), ("range", "bytes=0-9")]).await;
    assert_eq!(answer.status, StatusCode::PRECONDITION_FAILED);
    let answer = get_with(&router, "/town/raw", &[("if-range", &tag), ("range", "bytes=0-9")]).await;
    assert_eq!((answer.status, answer.bytes), (StatusCode::OK, after.clone().into()));
    let tag = get(&router, "/town/raw").await.header("etag").to_owned();
    let answer = get_with(&router, "/town/raw", &[("if-match", &tag), ("range", "bytes=0-9")]).await;
    assert_eq!(
        (answer.status, &answer.bytes[..]),
        (StatusCode::PARTIAL_CONTENT, &after[..10])
    );
    let known = get_with(&router, "/town/raw", &[("if-none-match", &tag)]).await;
    assert_eq!(known.status, StatusCode::NOT_MODIFIED);
}
