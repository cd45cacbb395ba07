//! Heights at points, as JSON and GeoJSON.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::Location;
use delaunay_tiles::store::TileReader;
use delaunay_tiles::terrain::{Surface, TerrainError};
use serde_json::{Value, json};

use crate::values::position;

/// A point, and its height or why it has none.
#[derive(Clone, Copy, Debug)]
pub struct Height {
    /// The point.
    pub at: Point,
    /// The height of the surface at the point.
    pub z: Result<f64, &'static str>,
}

/// The triangles that count.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counted {
    /// Whether triangles in holes count too.
    pub all: bool,
    /// The length of the longest edge that a triangle may have.
    pub max_edge: Option<f64>,
}

impl Counted {
    /// Returns the surface of these triangles.
    pub fn surface(self) -> Surface {
        Surface::default().holes(self.all).max_edge(self.max_edge)
    }

    /// Returns why a point within the hull is not on the surface.
    pub const fn why_not(self) -> &'static str {
        match (self.all, self.max_edge) {
            (false, None) => "in a hole",
            (false, Some(_)) => "in a hole, or in a triangle that --max-edge leaves out",
            (true, _) => "in a triangle that --max-edge leaves out",
        }
    }
}

impl Height {
    /// Finds the height of the surface at a point.
    ///
    /// # Errors
    /// Fails if the file has no z, or if a tile cannot be read.
    pub async fn find(reader: &TileReader, at: Point, counted: Counted) -> Result<Self, TerrainError> {
        if !reader.metadata().has_z {
            let file = reader.name().to_owned();
            return Err(TerrainError::NoZ { file });
        }
        let z = match reader.locate_with_z(at.x, at.y, counted.surface()).await? {
            (_, Some(z)) => Ok(z),
            (Location::Outside, None) => Err("outside the triangulation"),
            (_, None) => Err(counted.why_not()),
        };
        Ok(Self { at, z })
    }

    /// Returns the JSON object.
    pub fn object(&self) -> Value {
        let mut object = json!({"at": position(self.at), "z": self.z.ok()});
        if let Err(why) = self.z {
            object["note"] = why.into();
        }
        object
    }

    /// Returns a feature whose position has the height, if there is one.
    pub fn feature(&self) -> Value {
        let Point { x, y } = self.at;
        let coordinates = self.z.map_or_else(|_| json!([x, y]), |z| json!([x, y, z]));
        let geometry = json!({"type": "Point", "coordinates": coordinates});
        json!({"type": "Feature", "properties": self.object(), "geometry": geometry})
    }
}
