//! Answers to queries, in the form in which they are printed.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{AlongInterval, AreaPolygon, Location, Near, Path, QueryError, SiteFound, TriangleRef};
use delaunay_tiles::shown;
use delaunay_tiles::store::{TileReader, Vertex};
use delaunay_tiles::terrain::Surface;
use serde_json::Value;

use crate::question::Question;

/// How a query ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// The query ended as it should.
    Ok,
    /// No path connects the two points.
    Unreachable,
    /// A point of the query is inside an obstacle: the point, and the nearest free point.
    Inside(Point, Option<Point>),
    /// The query reached a limit: the lower bound of the distance of everything that was not found.
    Budget(f64),
}

impl Status {
    /// Returns the name for tables and objects.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Unreachable => "unreachable",
            Self::Inside(..) => "inside_obstacle",
            Self::Budget(_) => "out_of_budget",
        }
    }

    /// Converts an error that is an answer.
    ///
    /// # Errors
    /// Returns all other errors unchanged.
    pub fn of(error: QueryError) -> anyhow::Result<Self> {
        match error {
            QueryError::InsideObstacle { point, nearest_free } => Ok(Self::Inside(point, nearest_free)),
            QueryError::OutOfBudget { lower_bound } => Ok(Self::Budget(lower_bound)),
            other => Err(other.into()),
        }
    }
}

/// The area within a walking distance.
#[derive(Clone, Debug)]
pub struct Area {
    /// Polygons inside the true area.
    pub polygons: Vec<AreaPolygon>,
    /// The size of the polygons.
    pub size: f64,
}

/// The measured cost of an answer.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The cost as a JSON object.
    pub object: Value,
    /// The cost as a line of text.
    pub line: String,
}

/// An answer and its question.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The question.
    pub question: Question,
    /// How the query ended.
    pub status: Status,
    /// What was found.
    pub found: QueryResult,
    /// The cost, if it was measured.
    pub cost: Option<Measured>,
    /// The area within the radius, if it was requested.
    pub area: Option<Area>,
}

impl Answer {
    /// Returns about how many points the answer has.
    pub fn weight(&self) -> usize {
        let of_path = |path: &Option<Path>| path.as_ref().map_or(0, |path| path.points.len());
        let found = match &self.found {
            QueryResult::Location(_) => 1,
            QueryResult::Near(near) => near.len(),
            QueryResult::Sites(sites) => sites.iter().map(|site| 1 + of_path(&site.path)).sum(),
            QueryResult::Path(path) => of_path(path),
            QueryResult::Along(intervals) => intervals.len(),
        };
        let polygons = self.area.iter().flat_map(|area| &area.polygons);
        let rings = polygons.flat_map(AreaPolygon::rings);
        1 + found + rings.map(<[Point]>::len).sum::<usize>()
    }
}

/// The location of a point, with heights.
#[derive(Clone, Debug)]
pub struct Located {
    /// Where the point is.
    pub location: Location,
    /// The height of the surface at the point, if it is on it.
    pub z: Option<f64>,
    /// The vertices there. Each has a height if the file has z.
    pub vertices: Vec<(Vertex, Option<f64>)>,
    /// The number of the region, if the point is within a triangle.
    pub region: Option<u64>,
}

/// What a query found.
#[derive(Clone, Debug)]
pub enum QueryResult {
    /// The location of a point.
    Location(Located),
    /// The nearest sites or vertices by Euclidean distance.
    Near(Vec<Near>),
    /// Sites by walking distance.
    Sites(Vec<SiteFound>),
    /// A path, if there is one.
    Path(Option<Path>),
    /// The nearest sites along a line.
    Along(Vec<AlongInterval>),
}

impl QueryResult {
    /// Returns the empty result of a question: no sites, or no path.
    pub fn nothing(question: Question) -> Self {
        match question {
            Question::At(_) => Self::Sites(Vec::new()),
            Question::Way(..) => Self::Path(None),
        }
    }
}

impl Located {
    /// Locates a point.
    ///
    /// # Errors
    /// Fails if a tile cannot be read.
    pub async fn find(reader: &TileReader, at: Point) -> anyhow::Result<Self> {
        let (location, z) = reader.locate_with_z(at.x, at.y, Surface::default()).await?;
        let vertices = match &location {
            Location::Outside => Vec::new(),
            // A vertex in a hole has a z too.
            Location::OnVertex(vertex) if reader.metadata().has_z && z.is_none() => {
                vec![(*vertex, reader.z_of(vertex.id).await?)]
            }
            Location::OnVertex(vertex) => vec![(*vertex, z)],
            Location::InTriangle(triangle) => corners(reader, triangle).await?,
            Location::OnEdge { ends, triangle } => {
                let mut found = corners(reader, triangle).await?;
                found.retain(|(vertex, _)| ends.iter().any(|end| end.id == vertex.id));
                found.sort_by_key(|(vertex, _)| vertex.id != ends[0].id);
                found
            }
        };
        let region = match &location {
            Location::InTriangle(triangle) => Some(reader.tile(triangle.tile).await?.region(triangle.triangle)),
            _ => None,
        };
        Ok(Self {
            z,
            vertices,
            region,
            location,
        })
    }

    /// Returns the kind of element at the location: vertex, edge, triangle or outside.
    pub fn element(&self) -> &'static str {
        match self.location {
            Location::OnVertex(_) => "vertex",
            Location::OnEdge { .. } => "edge",
            Location::InTriangle(_) => "triangle",
            Location::Outside => "outside",
        }
    }

    /// Returns the ids of the vertices.
    pub fn ids(&self) -> Vec<String> {
        self.vertices.iter().map(|(vertex, _)| vertex.id.to_string()).collect()
    }
}

/// Returns the corners of a triangle, each with its height if the file has z.
async fn corners(reader: &TileReader, triangle: &TriangleRef) -> anyhow::Result<Vec<(Vertex, Option<f64>)>> {
    let heights = match reader.metadata().has_z {
        true => reader.z_of_corners(triangle).await?,
        false => None,
    };
    let height = |i: usize| heights.map(|heights| heights[i]);
    Ok((0..3).map(|i| (triangle.vertices[i], height(i))).collect())
}

/// Returns the name of a site for people, on one line, with control characters escaped.
pub fn displayed_name(number: Option<u64>, id: Option<&str>) -> String {
    shown::text(&name(number, id)).into_owned()
}

/// Returns the id of a site, or its number if it has no id.
pub fn name(number: Option<u64>, id: Option<&str>) -> String {
    match (id, number) {
        (Some(id), _) => id.to_owned(),
        (None, Some(number)) => number.to_string(),
        (None, None) => String::new(),
    }
}
