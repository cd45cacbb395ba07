use axum::http::StatusCode;
use delaunay_tiles_service::Options;

use crate::support::{Files, get};

#[tokio::test]
async fn each_described_path_is_there() {
    let mut options = Options::default();
    options.raw = true;
    let router = Files::new().await.router(options).await;
    let document = get(&router, "/openapi.json").await.json();
    let paths = document["paths"].as_object().unwrap();
    for (path, methods) in paths {
        let concrete = path
            .replace("{id}", "hill")
            .replace("{grid}", "native")
            .replace("{layer}", "shade")
            .replace("{z}", "0")
            .replace("{x}", "1")
            .replace("{y}", "0")
            .replace("shade/0/1", "shade/0/0")
            .replace("mesh/0/1", "mesh/0/0");
        let query = "?at=500001,5500001&from=500001,5500001&to=500100,5500100&radius=1";
        let concrete = match path.contains("/query/") {
            true => format!("{concrete}{}", query),
            false => concrete,
        };
        let answer = get(&router, &concrete).await;
        // Strict paths refuse parameters of others; what matters is that they are there.
        let is_there = matches!(answer.status, StatusCode::OK | StatusCode::BAD_REQUEST) || methods["post"].is_object();
        assert!(is_there, "{concrete}: {} {:?}", answer.status, answer.bytes);
    }
    assert_eq!(paths.len(), 21);
    let ids = &document["paths"]["/{id}"]["get"]["parameters"][0]["schema"]["enum"];
    assert_eq!(ids, &serde_json::json!(["town", "hill"]));
}
