//! Schemas of answers and of bodies.

use serde_json::{Map, Value, json};

use crate::options::Options;
use crate::parameters::number::{LEAST, MOST};

/// Returns all schemas by their names.
pub fn all(options: &Options) -> Value {
    let mut all = Map::new();
    let mut add = |name: &str, schema: Value| _ = all.insert(name.to_owned(), schema);
    add("Problem", problem());
    add("Health", object(json!({"status": {"const": "ok"}})));
    add("Catalog", catalog());
    add("File", file());
    add("TileJson", tile_json());
    add("Terrain", terrain());
    add("Lists", lists(options));
    add("Position", position());
    add(
        "Status",
        json!({"enum": ["ok", "unreachable", "inside_obstacle", "out_of_budget"]}),
    );
    for (name, members) in collections() {
        add(name, collection(members));
    }
    Value::Object(all)
}

/// Returns the schema of an object with these members, all of which are required, and perhaps others.
fn object(members: Value) -> Value {
    let names: Vec<&String> = members.as_object().into_iter().flat_map(Map::keys).collect();
    json!({"type": "object", "required": names, "properties": members})
}

/// Returns a schema for the members of an object that need not be there.
fn with_optional(mut object: Value, members: Value) -> Value {
    if let (Some(into), Value::Object(members)) = (object["properties"].as_object_mut(), members) {
        into.extend(members);
    }
    object
}

fn problem() -> Value {
    object(json!({
        "status": {"type": "integer", "minimum": 400, "maximum": 599},
        "what": {"type": "string", "description": "What is wrong"},
        "where": {"type": "string", "description": "Which part of the request, or which file"},
        "advice": {"type": "string", "description": "What to do about it"},
    }))
}

fn catalog() -> Value {
    let source = object(json!({"content_type": {"type": "string"}, "description": {"type": "string"}}));
    object(json!({"tiles": {"type": "object", "additionalProperties": source}}))
}

fn bounds() -> Value {
    json!({"type": ["array", "null"], "items": {"type": "number"}, "minItems": 4, "maxItems": 4})
}

fn file() -> Value {
    let grid = json!({"type": "object", "properties": {
        "bounds": bounds(),
        "lon_lat_bounds": bounds(),
        "tile_0": bounds(),
        "max_zoom": {"type": "integer"},
        "layers": {"type": "object", "additionalProperties": {"type": "string"}},
        "missing": {"type": "string", "description": "Why the file has no tiles in this grid"},
    }});
    let texts = json!({"type": "array", "items": {"type": "string"}});
    let unit = object(json!({"name": {"type": "string"}, "metres": {"type": ["number", "null"]}}));
    object(json!({
        "id": {"type": "string"},
        "version": {"type": "string"},
        "generation": {"type": "integer", "minimum": 1},
        "bytes": {"type": "integer", "minimum": 0},
        "bounds": bounds(),
        "crs": {"type": ["object", "null"]},
        "unit": unit,
        "z_unit": unit,
        "has_z": {"type": "boolean"},
        "line_kinds": {"type": "array", "items": {"enum": ["break line", "wall", "obstacle"]}},
        "coloured_heights": {
            "type": ["array", "null"],
            "items": {"type": "number"},
            "minItems": 2,
            "maxItems": 2,
            "description": "The heights of the first and the last colour of pictures, in metres",
        },
        "counts": {"type": "object", "additionalProperties": {"type": "integer", "minimum": 0}},
        "lowest_height": {
            "type": ["number", "null"],
            "description": "The height that the layer terrarium has where there is no surface, in metres",
        },
        "layers": texts,
        "grids": {"type": "object", "additionalProperties": grid},
        "terrain": {"type": "object", "properties": {"layer": {"type": "string"}, "missing": {"type": "string"}}},
        "queries": texts,
        "matrix": {"type": "string"},
        "raw": {"type": ["string", "null"]},
    }))
}

fn tile_json() -> Value {
    let zoom = json!({"type": "integer", "minimum": 0, "maximum": 30});
    let tile_json = object(json!({
        "tilejson": {"type": "string"},
        "tiles": {"type": "array", "items": {"type": "string"}, "minItems": 1},
        "name": {"type": "string"},
        "minzoom": zoom,
        "maxzoom": zoom,
        "scheme": {"const": "xyz"},
    }));
    let layer = object(json!({"id": {"type": "string"}, "fields": {"type": "object"}}));
    let others = json!({"bounds": bounds(), "vector_layers": {"type": "array", "items": layer}});
    with_optional(tile_json, others)
}

fn terrain() -> Value {
    object(json!({
        "tilejson": {"type": "string"},
        "format": {"const": "quantized-mesh-1.0"},
        "scheme": {"const": "tms"},
        "projection": {"const": "EPSG:4326"},
        "tiles": {"type": "array", "items": {"type": "string"}},
        "available": {"type": "array"},
        "bounds": bounds(),
    }))
}

fn position() -> Value {
    json!({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 3})
}

/// Returns the schema of the body of a matrix.
fn lists(options: &Options) -> Value {
    let coordinate = json!({"type": "number", "anyOf": [
        {"const": 0},
        {"minimum": LEAST, "maximum": MOST},
        {"minimum": -MOST, "maximum": -LEAST},
    ]});
    let point = json!({"type": "array", "items": coordinate, "minItems": 2, "maxItems": 2});
    let most = options.max_pairs;
    let points = json!({"type": "array", "items": point, "minItems": 1, "maxItems": most});
    json!({
        "type": "object",
        "required": ["from"],
        "properties": {
            "from": points,
            "to": points,
            "sites": {"type": "boolean", "default": false},
        },
        "additionalProperties": false,
        "not": {"required": ["to", "sites"], "properties": {"sites": {"const": true}}},
        "description": format!("Start points, and end points: those of `to`, all sites, or the start points. At most {most} pairs."),
    })
}

/// Returns the collections, with their members besides `type` and `features`.
fn collections() -> [(&'static str, Value); 9] {
    let text = json!({"type": "string"});
    let (at, status) = (
        json!({"$ref": "#/components/schemas/Position"}),
        json!({"$ref": "#/components/schemas/Status"}),
    );
    let of_point = || json!({"at": at, "status": status});
    let of_way = || json!({"from": at, "to": at, "status": status});
    let nullable = json!({"type": ["number", "null"]});
    let mut locate = of_point();
    locate["element"] = json!({"enum": ["vertex", "edge", "triangle", "outside"]});
    locate["vertices"] = json!({"type": "array", "items": text, "maxItems": 3});
    locate["points"] = json!({"type": "array", "items": at, "maxItems": 3});
    locate["region"] = json!({"type": ["integer", "null"], "minimum": 0});
    locate["z"] = nullable.clone();
    [
        ("Locate", locate),
        ("Nearest", of_point()),
        ("Knn", of_point()),
        ("Range", of_point()),
        ("Path", of_way()),
        ("Along", of_way()),
        ("Z", json!({"at": at, "z": nullable})),
        ("Profile", of_way()),
        ("Matrix", json!({"status": status})),
    ]
}

fn collection(mut members: Value) -> Value {
    members["type"] = json!({"const": "FeatureCollection"});
    members["features"] = json!({"type": "array", "items": feature()});
    let number = json!({"type": "number"});
    let others = json!({
        "crs": {"type": "object"},
        "note": {"type": "string"},
        "distance": number,
        "lower": number,
        "upper": number,
        "lower_bound": number,
        "area": number,
        "length": number,
        "bends": {"type": "array", "items": {"type": "object"}, "description": "Where the path bends, and round which lines"},
        "inside_point": {"$ref": "#/components/schemas/Position"},
        "nearest_free": {"type": ["array", "null"], "items": number},
        "gaps": {"type": "array", "items": {"type": "array", "items": number}},
    });
    with_optional(object(members), others)
}

fn feature() -> Value {
    let kinds = json!(["Point", "LineString", "MultiPolygon"]);
    let geometry = json!({
        "type": ["object", "null"],
        "required": ["type", "coordinates"],
        "properties": {"type": {"enum": kinds}, "coordinates": {"type": "array"}},
    });
    object(json!({"type": {"const": "Feature"}, "properties": {"type": "object"}, "geometry": geometry}))
}
