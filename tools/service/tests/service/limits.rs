use axum::body::Body;
use axum::http::{Method, StatusCode};
use delaunay_tiles_service::Options;
use futures::FutureExt;
use serde_json::json;

use crate::support::{Files, get, metric, post, send};

#[tokio::test]
async fn too_many_requests_are_refused_at_once() {
    let mut options = Options::default();
    (options.at_once, options.queue) = (1, 2);
    let router = Files::new().await.router(options).await;
    // They are begun together, before any of them ends.
    let asks = (0..50).map(|i| {
        let router = router.clone();
        async move { get(&router, &format!("/town/query/range?at=0.{i},7&radius=30&area=true")).await }
    });
    let answers = futures::future::join_all(asks).await;
    let count = |status| answers.iter().filter(|answer| answer.status == status).count();
    let (good, busy) = (count(StatusCode::OK), count(StatusCode::SERVICE_UNAVAILABLE));
    assert_eq!(good + busy, 50);
    assert!(good >= 3 && busy > 0, "{good} {busy}");
    let refused = answers
        .iter()
        .find(|answer| answer.status == StatusCode::SERVICE_UNAVAILABLE)
        .unwrap();
    assert_eq!(refused.header("retry-after"), "1");
    assert_eq!(metric(&router, "rejected_total").await, busy as u64);
    assert_eq!(metric(&router, "running").await, 0);
}

#[tokio::test]
async fn one_who_leaves_frees_the_slot() {
    let mut options = Options::default();
    (options.at_once, options.queue) = (1, 0);
    let router = Files::new().await.router(options).await;
    for i in 0..20 {
        let path = format!("/town/query/range?at=0.{i},7&radius=30&area=true");
        let mut leaves = Box::pin(get(&router, &path));
        assert!(leaves.as_mut().now_or_never().is_none());
        drop(leaves);
    }
    assert_eq!(metric(&router, "running").await, 0);
    assert_eq!(metric(&router, "in_flight").await, 1);
    assert_eq!(get(&router, "/town/query/locate?at=0,0").await.status, StatusCode::OK);
}

#[tokio::test]
async fn large_bodies_and_addresses_are_refused() {
    let mut options = Options::default();
    options.max_body = 1000;
    let router = Files::new().await.router(options).await;
    let body = Body::from(" ".repeat(1001));
    let answer = send(&router, Method::POST, "/town/query/matrix", &[], body).await;
    assert_eq!(
        (answer.status, &answer.json()["where"]),
        (StatusCode::PAYLOAD_TOO_LARGE, &json!("body"))
    );
    let answer = get(&router, &format!("/town/query/locate?at={}", "1".repeat(5000))).await;
    assert_eq!(
        (answer.status, &answer.json()["where"]),
        (StatusCode::URI_TOO_LONG, &json!("URL"))
    );
}

#[tokio::test]
async fn a_request_lowers_limits_and_does_not_raise_them() {
    let mut options = Options::default();
    options.max_tiles = 2;
    let router = Files::new().await.router(options).await;
    let status = async |limit: &str| {
        let answer = get(&router, &format!("/town/query/path?from=0,0&to=17,18{limit}")).await;
        answer.json()["status"].as_str().unwrap().to_owned()
    };
    assert_eq!(status("").await, "out_of_budget");
    assert_eq!(status("&max-tiles=1000000").await, "out_of_budget");
    assert_eq!(status("&max-time=1000000").await, "out_of_budget");
}

#[tokio::test]
async fn answers_have_at_most_so_many_points() {
    let mut options = Options::default();
    options.max_points = 10;
    let router = Files::new().await.router(options).await;
    let answer = get(&router, "/town/query/range?at=0.1,7&radius=100").await.json();
    let found = answer["features"].as_array().unwrap();
    assert_eq!(answer["status"], "out_of_budget");
    assert!(!found.is_empty() && found.len() < 10);
    let farthest = found
        .iter()
        .map(|site| site["properties"]["lower"].as_f64().unwrap())
        .fold(0.0, f64::max);
    assert_eq!(answer["lower_bound"].as_f64(), Some(farthest));
    let points: Vec<[f64; 2]> = (0..8).map(|i| [f64::from(i) / 10.0, 0.0]).collect();
    let answer = post(&router, "/town/query/matrix", &json!({"from": points}))
        .await
        .json();
    assert_eq!(answer["status"], "out_of_budget");
    assert!(answer["features"].as_array().unwrap().len() <= 10);
}

#[tokio::test]
async fn answers_that_nobody_reads_do_not_add_up() {
    let mut options = Options::default();
    options.outgoing_bytes = 4 << 10;
    let router = Files::new().await.router(options).await;
    use tower::ServiceExt;
    let ask = || {
        axum::http::Request::builder()
            .uri("/town/query/knn?at=0.1,7&k=20")
            .body(Body::empty())
            .unwrap()
    };
    let unread = router.clone().oneshot(ask()).await.unwrap();
    assert_eq!(unread.status(), StatusCode::OK);
    let refused = router.clone().oneshot(ask()).await.unwrap();
    assert_eq!(refused.status(), StatusCode::SERVICE_UNAVAILABLE);
    drop(unread);
    assert_eq!(router.clone().oneshot(ask()).await.unwrap().status(), StatusCode::OK);
}
