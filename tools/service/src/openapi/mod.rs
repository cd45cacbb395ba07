//! The description of all paths, as OpenAPI 3.1.

mod operations;
mod parameters;
mod schemas;

use serde_json::{Map, Value, json};

use crate::options::Options;

/// Returns the description of a service of the files with these ids.
pub fn document(ids: &[&str], options: &Options) -> Value {
    let mut paths = Map::new();
    for operation in operations::all(ids, options) {
        let responses = operation.responses();
        let mut described = json!({
            "operationId": operation.name,
            "summary": operation.summary,
            "parameters": operation.parameters,
            "responses": responses,
        });
        if let Some(body) = operation.body {
            described["requestBody"] = body;
        }
        paths.insert(operation.path, json!({ operation.method: described }));
    }
    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "delaunay-tiles",
            "description": "Delaunay triangulations as map tiles, terrain and answers to queries. GET answers HEAD too. \
                Answers have an ETag unless they may differ the next time; If-None-Match is answered 304 before \
                anything is read.",
            "version": env!("CARGO_PKG_VERSION"),
            "license": {"name": "MIT OR Apache-2.0", "identifier": "MIT OR Apache-2.0"},
        },
        "servers": [{"url": "."}],
        "paths": paths,
        "components": {"schemas": schemas::all(options)},
    })
}
