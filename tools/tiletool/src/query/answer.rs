//! What a query comes to, as far as it is printed.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{AlongInterval, Location, Near, Path, QueryError, SiteFound};
use delaunay_tiles::shown;
use serde_json::Value;

use super::batch::Question;

/// How a query ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    Ok,
    Unreachable,
    /// With the point, and the nearest free one.
    Inside(Point, Option<Point>),
    /// The rest is at least as far away.
    Budget(f64),
}

impl Status {
    /// The name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Unreachable => "unreachable",
            Self::Inside(..) => "inside_obstacle",
            Self::Budget(_) => "out_of_budget",
        }
    }

    /// Of an error that is an answer.
    pub fn of(error: QueryError) -> anyhow::Result<Self> {
        match error {
            QueryError::InsideObstacle { point, nearest_free } => Ok(Self::Inside(point, nearest_free)),
            QueryError::OutOfBudget { at_least } => Ok(Self::Budget(at_least)),
            other => Err(other.into()),
        }
    }
}

/// Rings, the outer one first, counter-clockwise, the others clockwise; first points are not repeated.
pub type Polygon = Vec<Vec<Point>>;

/// What an answer cost.
#[derive(Clone, Debug)]
pub struct Measured {
    /// For programs.
    pub object: Value,
    /// For people.
    pub line: String,
}

/// An answer and its question.
#[derive(Clone, Debug)]
pub struct Answer {
    pub question: Question,
    pub status: Status,
    pub found: Found,
    /// What it cost, if that was measured.
    pub cost: Option<Measured>,
    /// The area within reach, if it was asked for.
    pub area: Option<Vec<Polygon>>,
}

/// What was found.
#[derive(Clone, Debug)]
pub enum Found {
    Location(Location),
    Near(Vec<Near>),
    Sites(Vec<SiteFound>),
    Path(Option<Path>),
    Along(Vec<AlongInterval>),
}

impl Found {
    /// No sites, or no path.
    pub fn nothing(question: Question) -> Self {
        match question {
            Question::At(_) => Self::Sites(Vec::new()),
            Question::Way(..) => Self::Path(None),
        }
    }
}

/// What a point lies on or in, and the numbers of the vertices there.
pub fn spot(location: &Location) -> (&'static str, Vec<String>) {
    let (what, vertices) = match location {
        Location::OnVertex(vertex) => ("vertex", std::slice::from_ref(vertex)),
        Location::OnEdge { ends, .. } => ("edge", &ends[..]),
        Location::InTriangle(triangle) => ("triangle", &triangle.vertices[..]),
        Location::Outside => ("outside", &[][..]),
    };
    (what, vertices.iter().map(|vertex| vertex.id.to_string()).collect())
}

/// The same for people, on one line.
pub fn shown_name(number: Option<u64>, id: Option<&str>) -> String {
    shown::text(&name(number, id)).into_owned()
}

/// The id of a site, or its number if it has none.
pub fn name(number: Option<u64>, id: Option<&str>) -> String {
    match (id, number) {
        (Some(id), _) => id.to_owned(),
        (None, Some(number)) => number.to_string(),
        (None, None) => String::new(),
    }
}
