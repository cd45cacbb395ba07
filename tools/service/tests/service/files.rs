use std::fs;
use std::time::Duration;

use axum::http::StatusCode;
use delaunay_tiles::Cache;
use delaunay_tiles_service::{Catalog, Options};
use tokio::time::sleep;

use crate::support::{Files, get, town};

/// Longer than a state is served without a look at the file.
const LOOK: Duration = Duration::from_millis(700);

#[tokio::test]
async fn an_edit_is_noticed() {
    let files = Files::new().await;
    let router = files.router(Options::default()).await;
    let path = "/town/query/path?from=-2.9,5&to=-0.1,5";
    let before = get(&router, path).await.json();
    files.edit().await;
    let after = get(&router, path).await.json();
    assert!(
        after["distance"].as_f64() > before["distance"].as_f64(),
        "{before} {after}"
    );
    assert_eq!(get(&router, "/town").await.json()["generation"], 2);
}

#[tokio::test]
async fn a_file_of_another_town_in_its_place_is_noticed() {
    let files = Files::new().await;
    let router = files.router(Options::default()).await;
    let before = get(&router, "/town").await.json();
    town(&files.path("other.tiles"), 100.0).await;
    fs::rename(files.path("other.tiles"), files.path("town.tiles")).unwrap();
    sleep(LOOK).await;
    let after = get(&router, "/town").await.json();
    assert_ne!(before["version"], after["version"]);
    assert_eq!(after["bounds"][0], 97.0);
}

#[tokio::test]
async fn a_file_that_is_gone_or_damaged_is_503_until_it_is_back() {
    let files = Files::new().await;
    let router = files.router(Options::default()).await;
    let folder = files.0.path().to_str().unwrap().to_owned();
    let whole = fs::read(files.path("town.tiles")).unwrap();
    for damage in [None, Some(&b"no tile file"[..]), Some(&whole[..9000])] {
        match damage {
            None => fs::remove_file(files.path("town.tiles")).unwrap(),
            Some(bytes) => fs::write(files.path("town.tiles"), bytes).unwrap(),
        }
        sleep(LOOK).await;
        let answer = get(&router, "/town/query/locate?at=0,0").await;
        assert_eq!(answer.status, StatusCode::SERVICE_UNAVAILABLE, "{:?}", answer.bytes);
        assert!(!answer.header("retry-after").is_empty());
        let problem = answer.json();
        assert_eq!(problem["where"], "town");
        assert!(!problem["what"].as_str().unwrap().is_empty());
        assert!(!String::from_utf8_lossy(&answer.bytes).contains(&folder), "{problem}");
        // Others are served.
        assert_eq!(get(&router, "/hill").await.status, StatusCode::OK);
        assert!(get(&router, "/catalog").await.json()["tiles"]["town"].is_null());
        assert_eq!(get(&router, "/").await.status, StatusCode::OK);
        fs::write(files.path("town.tiles"), &whole).unwrap();
        sleep(LOOK).await;
        assert_eq!(get(&router, "/town/query/locate?at=0,0").await.status, StatusCode::OK);
    }
}

#[tokio::test]
async fn a_catalogue_refuses_what_it_cannot_serve() {
    let files = Files::new().await;
    let cache = Cache::new(1 << 20);
    let refused = async |names: &[&str]| {
        let paths = names.iter().map(|name| files.path(name));
        Catalog::open(paths, &cache)
            .await
            .err()
            .expect("it is refused")
            .to_string()
    };
    assert!(refused(&["missing.tiles"]).await.contains("missing.tiles"));
    fs::copy(files.path("town.tiles"), files.path("town.copy")).unwrap();
    let clash = refused(&["town.tiles", "town.copy"]).await;
    assert!(clash.contains("town.tiles") && clash.contains("town.copy"), "{clash}");
    fs::copy(files.path("town.tiles"), files.path("my town.tiles")).unwrap();
    assert!(refused(&["my town.tiles"]).await.contains("rename"));
    fs::write(files.path("text.tiles"), "text").unwrap();
    assert!(refused(&["text.tiles"]).await.contains("text.tiles"));
}
