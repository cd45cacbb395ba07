//! All paths, with what they take and give.

use serde_json::{Map, Value, json};

use super::parameters as take;
use crate::options::Options;
use crate::reply::{GEOJSON, JSON};

/// A path and a method.
pub struct Operation {
    /// The path.
    pub path: String,
    /// The method.
    pub method: &'static str,
    /// The id of the operation.
    pub name: String,
    /// What it does.
    pub summary: &'static str,
    /// The parameters.
    pub parameters: Vec<Value>,
    /// The body of the request.
    pub body: Option<Value>,
    gives: Gives,
    /// Whether headers say what the answer took.
    has_cost: bool,
}

/// What an operation gives.
struct Gives {
    media: &'static str,
    schema: Value,
    /// The status codes besides 200, 400 and 503.
    others: &'static [u16],
}

const OF_SERVICE: &[u16] = &[];
const OF_FILE: &[u16] = &[304, 404];
const OF_TILE: &[u16] = &[204, 304, 404];
const OF_RAW: &[u16] = &[206, 304, 404, 412, 416];
const OF_MATRIX: &[u16] = &[404, 408, 413];

impl Operation {
    fn new(path: &str, name: &str, summary: &'static str, gives: Gives) -> Self {
        Self {
            path: path.to_owned(),
            method: "get",
            name: name.to_owned(),
            summary,
            parameters: Vec::new(),
            body: None,
            gives,
            has_cost: false,
        }
    }

    fn takes(mut self, parameters: impl IntoIterator<Item = Value>) -> Self {
        self.parameters.extend(parameters);
        self
    }

    /// Returns all answers.
    pub fn responses(&self) -> Value {
        let content = json!({ self.gives.media: {"schema": self.gives.schema} });
        let mut all = Map::new();
        all.insert(
            "200".to_owned(),
            json!({"description": "The answer", "content": content}),
        );
        if self.has_cost {
            all["200"]["headers"] = json!({
                "Tiles-Read": {
                    "description": "The number of different tiles of the file that were used, from the file or from the cache",
                    "schema": {"type": "integer", "minimum": 0},
                },
                "Server-Timing": {
                    "description": "The time that the query took, in milliseconds, as query;dur=TIME",
                    "schema": {"type": "string"},
                },
            });
        }
        for status in self.gives.others.iter().chain(&[400, 503]) {
            let problem = json!({JSON: {"schema": {"$ref": "#/components/schemas/Problem"}}});
            let of = |description: &str| json!({"description": description, "content": problem});
            let answer = match status {
                204 => json!({"description": "The file has nothing there"}),
                206 => json!({"description": "The bytes of the range", "content": content}),
                304 => json!({"description": "The client has the answer already"}),
                400 => of("The request is invalid"),
                404 => of("There is no such thing, or the file does not have it; the reason is in the answer"),
                408 => of("The body did not come in time"),
                412 => of("The file is not the one of If-Match"),
                413 => of("The body is too large"),
                416 => of("The range is not in the file"),
                _ => of(
                    "Not now: the file cannot be read, or too many requests wait; Retry-After says when to ask again",
                ),
            };
            all.insert(status.to_string(), answer);
        }
        Value::Object(all)
    }
}

fn schema(name: &str) -> Value {
    json!({"$ref": format!("#/components/schemas/{name}")})
}

fn gives(media: &'static str, schema: Value, others: &'static [u16]) -> Gives {
    Gives { media, schema, others }
}

fn binary(media: &'static str, others: &'static [u16]) -> Gives {
    gives(media, json!({}), others)
}

/// Returns all paths of a service of the files with these ids.
pub fn all(ids: &[&str], options: &Options) -> Vec<Operation> {
    let mut all = of_service();
    all.extend(of_files(ids, options));
    all.extend(of_queries(ids, options));
    all.extend(of_surfaces(ids, options));
    all
}

fn of_service() -> Vec<Operation> {
    let text = |media| gives(media, json!({"type": "string"}), OF_SERVICE);
    let metrics = "application/openmetrics-text";
    vec![
        Operation::new("/", "index", "The list of all files, as a page", text("text/html")),
        Operation::new(
            "/catalog",
            "catalog",
            "All files and layers, as the server martin lists them",
            gives(JSON, schema("Catalog"), OF_SERVICE),
        ),
        Operation::new(
            "/health",
            "health",
            "Whether the service takes requests",
            gives(JSON, schema("Health"), OF_SERVICE),
        ),
        Operation::new(
            "/metrics",
            "metrics",
            "Measurements, as Prometheus reads them",
            text(metrics),
        ),
        Operation::new(
            "/openapi.json",
            "openapi",
            "This description",
            gives(JSON, json!({"type": "object"}), OF_SERVICE),
        ),
    ]
}

fn of_files(ids: &[&str], options: &Options) -> Vec<Operation> {
    let (id, version) = (take::id(ids), take::version());
    let most = take::max_tiles(options.max_picture_tiles.into());
    let of_tile = || {
        [id.clone(), version.clone(), most.clone()]
            .into_iter()
            .chain(take::tile())
    };
    let document = |path: &str, name: &str, summary, of: &str| {
        Operation::new(path, name, summary, gives(JSON, schema(of), OF_FILE)).takes([id.clone(), version.clone()])
    };
    let mut all = vec![
        document("/{id}", "file", "What is known of a file", "File"),
        document(
            "/{id}/{grid}/{layer}.json",
            "tileJson",
            "The TileJSON of a layer",
            "TileJson",
        )
        .takes([take::grid(), take::layer(&["shade", "terrarium", "mesh"])]),
        document(
            "/{id}/terrain/layer.json",
            "terrainLayer",
            "The description of the terrain, for Cesium",
            "Terrain",
        ),
        Operation::new(
            "/{id}/{grid}/{layer}/{z}/{x}/{y}.png",
            "picture",
            "A picture",
            binary("image/png", OF_TILE),
        )
        .takes(of_tile().chain([take::grid(), take::layer(&["shade", "terrarium"])]))
        .takes([take::flag(
            "opaque",
            "Of the layer terrarium: leave no pixel transparent. Browsers forget the heights of such pixels",
        )]),
        Operation::new(
            "/{id}/{grid}/mesh/{z}/{x}/{y}.mvt",
            "vectors",
            "A vector tile",
            binary("application/vnd.mapbox-vector-tile", OF_TILE),
        )
        .takes(of_tile().chain([take::grid()])),
        Operation::new(
            "/{id}/terrain/{z}/{x}/{y}.terrain",
            "terrain",
            "A mesh in the format quantized-mesh",
            binary("application/vnd.quantized-mesh", OF_FILE),
        )
        .takes(of_tile()),
    ];
    if options.raw {
        all.push(of_bytes(id, version));
    }
    all
}

fn of_bytes(id: Value, version: Value) -> Operation {
    let range = json!({
        "name": "Range",
        "in": "header",
        "required": false,
        "schema": {"type": "string"},
        "description": "One range of bytes; several are answered with all bytes",
    });
    let gives = binary("application/octet-stream", OF_RAW);
    Operation::new("/{id}/raw", "raw", "The bytes of the file", gives).takes([id, version, range])
}

fn of_queries(ids: &[&str], options: &Options) -> Vec<Operation> {
    let of = |name: &str, summary: &'static str| {
        let gives = gives(
            GEOJSON,
            schema(&format!("{}{}", name[..1].to_uppercase(), &name[1..])),
            OF_FILE,
        );
        let operation = Operation::new(&format!("/{{id}}/query/{name}"), name, summary, gives);
        let operation = Operation {
            has_cost: true,
            ..operation
        };
        operation
            .takes([take::id(ids), take::version()])
            .takes(take::limits(options))
    };
    let at = || take::point("at", "The point, as X,Y");
    let way = || {
        [
            take::point("from", "The start, as X,Y"),
            take::point("to", "The end, as X,Y"),
        ]
    };
    let certify = || {
        take::flag(
            "certify",
            "Prove each path by a walk through the triangles that it passes",
        )
    };
    vec![
        of(
            "locate",
            "The vertex, edge or triangle at a point, and whether the point is free",
        )
        .takes([at()]),
        of("nearest", "The nearest sites or vertices by Euclidean distance").takes([
            at(),
            take::k(options, 1),
            take::flag("vertices", "Find vertices even if the file has sites"),
        ]),
        of("knn", "The nearest sites by walking distance").takes([
            at(),
            take::k(options, 10),
            take::mode(),
            take::search(),
            certify(),
        ]),
        of("range", "All sites, and the area, within a walking distance").takes([
            at(),
            take::radius(),
            take::flag("area", "Return the area too"),
            take::mode(),
            certify(),
        ]),
        of("path", "A shortest path")
            .takes(way())
            .takes([take::mode(), certify()]),
        of("along", "The nearest sites along a line")
            .takes(way())
            .takes([take::k(options, 1)]),
    ]
}

fn of_surfaces(ids: &[&str], options: &Options) -> Vec<Operation> {
    let counted = || [take::flag("all", "Count triangles in holes too"), take::max_edge()];
    let matrix = Operation {
        method: "post",
        body: Some(json!({"required": true, "content": {JSON: {"schema": schema("Lists")}}})),
        ..Operation::new(
            "/{id}/query/matrix",
            "matrix",
            "The walking distances between all points of two lists",
            gives(GEOJSON, schema("Matrix"), OF_MATRIX),
        )
    };
    vec![
        Operation::new(
            "/{id}/query/z",
            "z",
            "The height of the surface at a point",
            gives(GEOJSON, schema("Z"), OF_FILE),
        )
        .takes([take::id(ids), take::version(), take::point("at", "The point, as X,Y")])
        .takes(counted()),
        Operation::new(
            "/{id}/query/profile",
            "profile",
            "The heights of the surface along a line",
            gives(GEOJSON, schema("Profile"), OF_FILE),
        )
        .takes([take::id(ids), take::version()])
        .takes(take::limits(options))
        .takes([
            take::point("from", "The start, as X,Y"),
            take::point("to", "The end, as X,Y"),
        ])
        .takes(counted()),
        matrix
            .takes([take::id(ids), take::version()])
            .takes(take::limits(options)),
    ]
}
