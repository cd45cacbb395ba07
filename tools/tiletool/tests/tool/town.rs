//! A small town, for tests of queries.

use std::fs;
use std::path::PathBuf;

use crate::support::{command, complaint, printed};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder with a town: a square of 8 by 8 with an obstacle in the middle, a closed wall, and
/// sites.
pub struct Town(TempDir);

impl Town {
    pub fn new() -> Self {
        let this = Self(tempfile::tempdir().unwrap());
        let ring = |[x, y, u, v]: [i32; 4]| json!([[x, y], [u, y], [u, v], [x, v], [x, y]]);
        let features = [ring([-1, -1, 1, 1]), ring([2, -4, 3, 2])];
        let features = features.map(|ring| json!({"type": "Polygon", "coordinates": [ring]}));
        this.write(
            "houses.geojson",
            json!({"type": "GeometryCollection", "geometries": features}).to_string(),
        );
        this.write("fences.csv", "-3,2,-2,2\n-2,2,-2,3\n-2,3,-3,3\n-3,3,-3,2\n");
        this.write("points.csv", "-4,-4\n4,-4\n4,4\n-4,4\n");
        this.write(
            "shops.csv",
            "0,3,baker\n\"-2.5\",2.5,inner\n3.5,0,\"far, far\"\n0,-3,pump\n",
        );
        let build = [
            "build",
            "points.csv",
            "--obstacles",
            "houses.geojson",
            "--walls",
            "fences.csv",
        ];
        this.run(0, &[&build[..], &["--sites", "shops.csv", "-o", "town.tiles"]].concat());
        this
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs a command that must end with this exit code. Returns its standard output, or its
    /// standard error if the code is not 0.
    #[track_caller]
    pub fn run(&self, code: i32, args: &[&str]) -> String {
        let command = command(self.0.path(), args);
        match code {
            0 => printed(command),
            _ => complaint(command, code),
        }
    }

    pub fn query(&self, what: &str, args: &[&str]) -> String {
        self.run(0, &[&["query", what, "town.tiles"], args].concat())
    }

    pub fn json(&self, what: &str, args: &[&str]) -> Value {
        serde_json::from_str(&self.query(what, &[args, &["--json"]].concat())).unwrap()
    }
}
