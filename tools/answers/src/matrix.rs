//! Walking distances between the points of two lists, as JSON and GeoJSON.

use anyhow::ensure;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{DistanceOutcome, PairDistance};
use delaunay_tiles::store::TileReader;
use futures::TryStreamExt;
use serde_json::{Value, json};

use crate::answer::{Status, name};
use crate::asked::NO_SITES;
use crate::values::{line_string, position, with_distance};

/// Points and their names.
#[derive(Clone, Debug)]
pub struct NamedPoints {
    /// The points.
    pub points: Vec<Point>,
    /// The names of sites; `None` if the points are named by their indices.
    pub names: Option<Vec<String>>,
}

/// The start points and the end points.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// The start points.
    pub from: NamedPoints,
    /// The end points.
    pub to: NamedPoints,
}

impl NamedPoints {
    /// Creates a list of points that are named by their indices.
    pub const fn unnamed(points: Vec<Point>) -> Self {
        Self { points, names: None }
    }

    /// Returns all sites, in the order of their numbers.
    ///
    /// # Errors
    /// Fails if the file has no sites, or if a tile cannot be read.
    pub async fn sites(reader: &TileReader) -> anyhow::Result<Self> {
        let mut sites = Vec::new();
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            sites.extend(tile.sites().map(|site| {
                let name = name(Some(site.number), site.id);
                (site.number, tile.point(site.vertex), name)
            }));
        }
        ensure!(!sites.is_empty(), "{}: {NO_SITES}", reader.name());
        sites.sort_by_key(|&(number, ..)| number);
        let (points, names) = sites.into_iter().map(|(_, point, name)| (point, name)).unzip();
        Ok(Self {
            points,
            names: Some(names),
        })
    }

    /// Returns the name of a site; `None` if the points are no sites.
    pub fn name_of(&self, index: usize) -> Option<&str> {
        self.names.as_ref().map(|names| &*names[index])
    }
}

impl Matrix {
    /// Returns the start and the end of a pair.
    pub fn points(&self, found: &PairDistance) -> [Point; 2] {
        [self.from.points[found.from_index], self.to.points[found.to_index]]
    }

    /// Returns the JSON object of a pair.
    pub fn object(&self, found: &PairDistance) -> Value {
        let [from, to] = self.points(found).map(position);
        let [from_index, to_index] = [found.from_index, found.to_index];
        let mut value = json!({"from_index": from_index, "to_index": to_index, "from": from, "to": to});
        if let Some(name) = self.to.name_of(to_index) {
            value["site"] = name.into();
        }
        status(found.outcome).add_to(&mut value);
        match found.outcome {
            DistanceOutcome::Found(distance) => with_distance(value, &distance),
            _ => value,
        }
    }

    /// Returns the GeoJSON feature of a pair: its path, if the query asked for paths.
    pub fn feature(&self, found: &PairDistance) -> Value {
        let [from, to] = self.points(found);
        let geometry = match &found.path {
            // A line needs two positions that differ.
            Some(_) if from == to => json!({"type": "Point", "coordinates": position(from)}),
            Some(path) => line_string(path),
            None => Value::Null,
        };
        json!({"type": "Feature", "properties": self.object(found), "geometry": geometry})
    }
}

/// Converts the outcome of a pair to the status of a query.
pub fn status(outcome: DistanceOutcome) -> Status {
    match outcome {
        DistanceOutcome::Found(_) => Status::Ok,
        DistanceOutcome::Unreachable => Status::Unreachable,
        DistanceOutcome::InsideObstacle { point, nearest_free } => Status::Inside(point, nearest_free),
        DistanceOutcome::OutOfBudget { lower_bound } => Status::Budget(lower_bound),
    }
}
