//! Parameters of paths and queries.

use serde_json::{Value, json};

use crate::options::Options;
use crate::parameters::MAX_COUNT;
use crate::parameters::number::NUMBER;

fn query(name: &str, required: bool, schema: &Value, description: &str) -> Value {
    json!({"name": name, "in": "query", "required": required, "schema": schema, "description": description})
}

fn path(name: &str, schema: &Value, description: &str) -> Value {
    json!({"name": name, "in": "path", "required": true, "schema": schema, "description": description})
}

/// Returns the name of a file.
pub fn id(ids: &[&str]) -> Value {
    path(
        "id",
        &json!({"type": "string", "enum": ids}),
        "The name of a file, without its ending",
    )
}

/// Returns the name of a grid.
pub fn grid() -> Value {
    let grids = json!({"type": "string", "enum": ["native", "WebMercatorQuad"]});
    path(
        "grid",
        &grids,
        "A quadtree over the coordinates of the file, or that of web maps",
    )
}

/// Returns the name of a layer, which is one of these.
pub fn layer(names: &[&str]) -> Value {
    path("layer", &json!({"type": "string", "enum": names}), "What tiles show")
}

/// Returns the numbers of a tile.
pub fn tile() -> [Value; 3] {
    let number = |name: &str, most: u32, description: &str| {
        let schema = json!({"type": "integer", "minimum": 0, "maximum": most});
        path(name, &schema, description)
    };
    [
        number("z", 30, "The zoom"),
        number("x", (1 << 30) - 1, "The column, from the west"),
        number("y", (1 << 30) - 1, "The row: from the north, of terrain from the south"),
    ]
}

/// Returns the version that the client knows.
pub fn version() -> Value {
    let description = "The version of the file, from /{id}. If it is the present one, the answer may be kept for ever";
    query("v", false, &json!({"type": "string"}), description)
}

/// Returns a limit of tiles.
pub fn max_tiles(most: u64) -> Value {
    count(
        "max-tiles",
        &format!("Maximum number of tiles that are read; at most {most}, even if more is given"),
    )
}

/// Returns the limits of a query.
pub fn limits(options: &Options) -> [Value; 2] {
    let most = options.max_time.as_millis();
    [
        max_tiles(options.max_tiles),
        count(
            "max-time",
            &format!("Maximum time in milliseconds; at most {most}, even if more is given"),
        ),
    ]
}

fn count(name: &str, description: &str) -> Value {
    query(
        name,
        false,
        &json!({"type": "integer", "minimum": 0, "maximum": MAX_COUNT}),
        description,
    )
}

/// Returns a point.
pub fn point(name: &str, description: &str) -> Value {
    let pattern = format!("^{NUMBER},{NUMBER}$");
    query(
        name,
        true,
        &json!({"type": "string", "pattern": pattern, "examples": ["3.5,-4"]}),
        description,
    )
}

/// Returns the number of items to find.
pub fn k(options: &Options, default: u32) -> Value {
    let schema = json!({"type": "integer", "minimum": 1, "maximum": options.max_k, "default": default});
    query("k", false, &schema, "The number of sites or vertices to find")
}

/// Returns whether something is so.
pub fn flag(name: &str, description: &str) -> Value {
    query(name, false, &json!({"type": "boolean", "default": false}), description)
}

/// Returns the accuracy of distances.
pub fn mode() -> Value {
    // No tolerance is negative.
    let tolerance = NUMBER.trim_start_matches("-?");
    let pattern = format!("^(exact|fast|within:{tolerance})$");
    let schema = json!({"type": "string", "pattern": pattern, "default": "exact"});
    query(
        "mode",
        false,
        &schema,
        "Accuracy of distances: exact, fast, or within:TOLERANCE",
    )
}

/// Returns how sites are searched for.
pub fn search() -> Value {
    let schema = json!({"type": "string", "enum": ["auto", "wavefront", "aimed"], "default": "auto"});
    query(
        "search",
        false,
        &schema,
        "How sites are searched for, with the same answers",
    )
}

/// Returns the largest distance.
pub fn radius() -> Value {
    let schema = json!({"type": "number", "minimum": 0, "maximum": 1e50});
    query("radius", true, &schema, "The largest walking distance")
}

/// Returns the length of the longest edge.
pub fn max_edge() -> Value {
    let schema = json!({"type": "number", "exclusiveMinimum": 0, "maximum": 1e50});
    query(
        "max-edge",
        false,
        &schema,
        "Leave out triangles with an edge longer than this",
    )
}
