use axum::http::StatusCode;
use delaunay_tiles::crs::Crs;
use delaunay_tiles::query::{Mode, QueryOptions, Search};
use delaunay_tiles::store::TileReader;
use delaunay_tiles::{Point, terrain::Surface};
use delaunay_tiles_answers::ask::Ask;
use delaunay_tiles_answers::asked::Asked;
use delaunay_tiles_answers::height::{Counted, Height};
use delaunay_tiles_answers::matrix::{Matrix, NamedPoints};
use delaunay_tiles_answers::objects::{features, object};
use delaunay_tiles_answers::question::Question;
use delaunay_tiles_answers::{profile, values};
use delaunay_tiles_service::Options;
use futures::TryStreamExt;
use serde_json::{Value, json};

use crate::support::{Files, get, post};

/// Returns what the tool prints with `--geojson`, and the object that it prints with `--json`.
async fn printed(reader: &TileReader, ask: Ask, question: Question, options: QueryOptions) -> (Vec<Value>, Value) {
    let crs = reader.crs().await.unwrap().map(|text| Crs::new(&text));
    let answer = ask.answer(reader, question, options).await.unwrap();
    let asked = Asked::new(ask, reader, crs.as_ref());
    (features(asked, &answer), object(asked, &answer))
}

#[tokio::test]
async fn answers_are_those_of_the_tool_to_the_last_bit() {
    let files = Files::new().await;
    let (router, reader) = (files.router(Options::default()).await, files.reader("town.tiles").await);
    let at = |x, y| Question::At(Point::new(x, y));
    let way = |a, b, c, d| Question::Way(Point::new(a, b), Point::new(c, d));
    let paths = QueryOptions::default().paths();
    let knn = |k, search| Ask::Knn { k, search };
    let within = Mode::Within(0.05);
    for (path, ask, question, options) in [
        ("locate?at=0.3,0.1", Ask::Locate, at(0.3, 0.1), paths.clone()),
        ("locate?at=1.5,1.5", Ask::Locate, at(1.5, 1.5), paths.clone()),
        ("locate?at=-99,1", Ask::Locate, at(-99.0, 1.0), paths.clone()),
        (
            "nearest?at=0.1,7",
            Ask::Nearest { k: 1, vertices: false },
            at(0.1, 7.0),
            paths.clone(),
        ),
        (
            "nearest?at=0.1,7&k=5&vertices=true",
            Ask::Nearest { k: 5, vertices: true },
            at(0.1, 7.0),
            paths.clone(),
        ),
        ("knn?at=0.1,7", knn(10, Search::Auto), at(0.1, 7.0), paths.clone()),
        (
            "knn?at=0.1,7&k=3&search=aimed",
            knn(3, Search::Aimed),
            at(0.1, 7.0),
            paths.clone(),
        ),
        (
            "knn?at=0.1,7&k=3&mode=fast",
            knn(3, Search::Auto),
            at(0.1, 7.0),
            paths.clone().mode(Mode::Fast),
        ),
        (
            "knn?at=0.1,7&k=3&certify=true",
            knn(3, Search::Auto),
            at(0.1, 7.0),
            QueryOptions::default().certified(),
        ),
        (
            "knn?at=-1.5,-1.5&k=3",
            knn(3, Search::Auto),
            at(-1.5, -1.5),
            paths.clone(),
        ),
        (
            "range?at=0.1,7&radius=5",
            Ask::Range {
                radius: 5.0,
                area: false,
            },
            at(0.1, 7.0),
            paths.clone(),
        ),
        (
            "range?at=0.1,7&radius=5&area=true",
            Ask::Range {
                radius: 5.0,
                area: true,
            },
            at(0.1, 7.0),
            paths.clone(),
        ),
        (
            "path?from=0,0&to=17,18.9",
            Ask::Path,
            way(0.0, 0.0, 17.0, 18.9),
            paths.clone(),
        ),
        (
            "path?from=0,0&to=17,18.9&mode=within:0.05",
            Ask::Path,
            way(0.0, 0.0, 17.0, 18.9),
            paths.clone().mode(within),
        ),
        (
            "path?from=0,0&to=-1.5,-1.5",
            Ask::Path,
            way(0.0, 0.0, -1.5, -1.5),
            paths.clone(),
        ),
        (
            "path?from=0,0&to=1.5,1.5",
            Ask::Path,
            way(0.0, 0.0, 1.5, 1.5),
            paths.clone(),
        ),
        (
            "path?from=0,0&to=17,18.9&max-tiles=1",
            Ask::Path,
            way(0.0, 0.0, 17.0, 18.9),
            paths.clone().max_tiles(1),
        ),
        (
            "along?from=0,0&to=17,0&k=2",
            Ask::Along { k: 2 },
            way(0.0, 0.0, 17.0, 0.0),
            paths.clone(),
        ),
    ] {
        let (features, object) = printed(&reader, ask, question, options).await;
        let answer = get(&router, &format!("/town/query/{path}")).await;
        assert_eq!(answer.status, StatusCode::OK, "{path}: {:?}", answer.bytes);
        assert_eq!(answer.header("content-type"), "application/geo+json");
        let collection = answer.json();
        assert_eq!(collection["features"], json!(features), "{path}");
        // What is no list is a member of the collection.
        for (key, value) in object.as_object().unwrap() {
            if !["path", "sites", "nearest", "intervals"].contains(&&**key) {
                assert_eq!(&collection[key], value, "{path}: {key}");
            }
        }
    }
}

#[tokio::test]
async fn headers_say_what_an_answer_took() {
    let files = Files::new().await;
    let router = files.router(Options::default()).await;
    let all = files.reader("town.tiles").await.metadata().tiles;
    let tiles = async |path: &str| {
        let answer = get(&router, path).await;
        let time = answer.header("server-timing").strip_prefix("query;dur=").unwrap();
        assert!(time.parse::<f64>().unwrap() >= 0.0, "{time}");
        answer.header("tiles-read").parse::<u32>().unwrap()
    };
    let here = tiles("/town/query/locate?at=0,0").await;
    let across = tiles("/town/query/path?from=-2.5,-2.5&to=19,19").await;
    assert!(0 < here && here < across && across <= all, "{here} {across} {all}");
    // A tile in the cache counts too, and a tile that is used twice counts once.
    assert_eq!(tiles("/town/query/path?from=-2.5,-2.5&to=19,19").await, across);
    assert_eq!(tiles("/town/query/path?from=-2.5,-2.5&to=19,19&max-tiles=2").await, 2);
}

#[tokio::test]
async fn ends_of_a_query_are_answers() {
    let router = Files::new().await.router(Options::default()).await;
    for (path, status) in [
        ("path?from=0,0&to=17,18", "ok"),
        ("path?from=0,0&to=-1.5,-1.5", "unreachable"),
        ("path?from=0,0&to=1.5,1.5", "inside_obstacle"),
        ("path?from=0,0&to=17,18&max-tiles=1", "out_of_budget"),
        ("path?from=0,0&to=17,18&max-time=0", "out_of_budget"),
    ] {
        let answer = get(&router, &format!("/town/query/{path}")).await;
        assert_eq!(
            (answer.status, &answer.json()["status"]),
            (StatusCode::OK, &json!(status)),
            "{path}"
        );
    }
    let path = get(&router, "/town/query/path?from=0,0&to=17,18").await.json();
    let [distance, lower, upper] = ["distance", "lower", "upper"].map(|key| path[key].as_f64().unwrap());
    assert!(lower <= distance && distance <= upper && lower > 24.7);
}

#[tokio::test]
async fn heights_are_those_of_the_tool() {
    let files = Files::new().await;
    let (router, reader) = (files.router(Options::default()).await, files.reader("hill.tiles").await);
    for at in [
        Point::new(500_123.4, 5_500_567.8),
        Point::new(500_000.0, 5_500_000.0),
        Point::new(0.0, 0.0),
    ] {
        let answer = get(&router, &format!("/hill/query/z?at={},{}", at.x, at.y))
            .await
            .json();
        let height = Height::find(&reader, at, Counted::default()).await.unwrap();
        assert_eq!(answer["features"], json!([height.feature()]));
        assert_eq!(answer["z"], height.object()["z"]);
    }
    let line = [Point::new(500_001.0, 5_500_002.0), Point::new(500_400.0, 5_500_300.0)];
    let answer = get(&router, "/hill/query/profile?from=500001,5500002&to=500400,5500300")
        .await
        .json();
    let found = reader.profile(&line, Surface::default()).await.unwrap();
    let parts: Vec<Value> = found
        .parts
        .iter()
        .zip(0..)
        .map(|(part, number)| profile::feature(part, number))
        .collect();
    assert_eq!(
        (&answer["features"], &answer["length"]),
        (&json!(parts), &json!(found.length))
    );
    assert_eq!(answer["crs"]["properties"]["name"], "urn:ogc:def:crs:EPSG::25832");
    let answer = get(
        &router,
        "/hill/query/profile?from=500001,5500002&to=500900,5500900&max-tiles=1",
    )
    .await
    .json();
    assert_eq!(
        (&answer["status"], &answer["features"]),
        (&json!("out_of_budget"), &json!([]))
    );
    let answer = get(&router, "/hill/query/profile?from=1,2&to=1,2").await.json();
    assert_eq!(answer["length"], 0.0);
}

#[tokio::test]
async fn matrices_are_those_of_the_tool() {
    let files = Files::new().await;
    let (router, reader) = (files.router(Options::default()).await, files.reader("town.tiles").await);
    let points = [[0.0, 0.0], [9.7, 3.1], [-1.5, -1.5], [1.5, 1.5]];
    let of = |points: &[[f64; 2]]| NamedPoints::unnamed(points.iter().map(|[x, y]| Point::new(*x, *y)).collect());
    let sites = NamedPoints::sites(&reader).await.unwrap();
    for (body, from, to) in [
        (json!({"from": points}), of(&points), of(&points)),
        (
            json!({"from": points, "to": points[1..]}),
            of(&points),
            of(&points[1..]),
        ),
        (json!({"from": points, "sites": true}), of(&points), sites),
    ] {
        let answer = post(&router, "/town/query/matrix", &body).await;
        let [starts, ends] = [&from, &to].map(|list| list.points.clone());
        let pairs = reader.distance_matrix(starts, ends, QueryOptions::default().paths().max_tiles(500));
        let pairs: Vec<_> = pairs.try_collect().await.unwrap();
        let matrix = Matrix { from, to };
        let features: Vec<Value> = pairs.iter().map(|found| matrix.feature(found)).collect();
        let answer = answer.json();
        assert_eq!(
            (&answer["status"], &answer["features"]),
            (&json!("ok"), &json!(features))
        );
    }
}

#[tokio::test]
async fn a_body_is_what_the_tool_prints_to_the_byte() {
    let files = Files::new().await;
    let (router, reader) = (files.router(Options::default()).await, files.reader("hill.tiles").await);
    let answer = get(&router, "/hill/query/locate?at=500001.5,5500001").await;
    let question = Question::At(Point::new(500_001.5, 5_500_001.0));
    let (features, _) = printed(&reader, Ask::Locate, question, QueryOptions::default().paths()).await;
    let text = String::from_utf8(answer.bytes.to_vec()).unwrap();
    assert!(
        text.ends_with(&format!("\"features\":[\n{}{}\n", features[0], values::COLLECTION_END)),
        "{text}"
    );
}

#[tokio::test]
async fn what_is_wrong_with_a_query_is_said() {
    let router = Files::new().await.router(Options::default()).await;
    for (path, place) in [
        ("locate", "at"),
        ("locate?at=1", "at"),
        ("locate?at=1,2&at=3,4", "at"),
        ("locate?at=1,2&colour=red", "query"),
        ("knn?at=1,2&k=0", "k"),
        ("knn?at=1,2&k=1001", "k"),
        ("knn?at=1,2&mode=quick", "mode"),
        ("knn?at=1,2&search=no", "search"),
        ("knn?at=1,2&certify=yes", "certify"),
        ("nearest?at=1,2&mode=fast", "query"),
        ("range?at=1,2", "radius"),
        ("range?at=1,2&radius=-1", "radius"),
        ("path?from=1,2", "to"),
        ("path?from=1,2&to=3,4&max-tiles=-1", "max-tiles"),
        ("path?from=1,2&to=3,4&max-time=soon", "max-time"),
    ] {
        let answer = get(&router, &format!("/town/query/{path}")).await;
        let problem = answer.json();
        assert_eq!(
            (answer.status, problem["where"].as_str()),
            (StatusCode::BAD_REQUEST, Some(place)),
            "{path}"
        );
    }
    for body in [
        json!({}),
        json!([]),
        json!({"from": []}),
        json!({"from": [[1]]}),
        json!({"from": [[1, 2]], "to": null}),
        json!({"from": [[1, 2]], "to": [[1, 2]], "sites": true}),
        json!({"from": [[1e70, 2]]}),
        json!({"from": [[1, 2]], "x": 1}),
        json!({"from": vec![[1, 2]; 101]}),
    ] {
        let answer = post(&router, "/town/query/matrix", &body).await;
        assert_eq!(
            (answer.status, &answer.json()["where"]),
            (StatusCode::BAD_REQUEST, &json!("body")),
            "{body}"
        );
    }
    let answer = post(&router, "/hill/query/matrix", &json!({"from": [[1, 2]], "sites": true})).await;
    assert_eq!(answer.status, StatusCode::NOT_FOUND);
}
