//! The question and the answer that a picture shows.

use delaunay_tiles::geometry::{Point, Rect};

/// A point that is marked.
pub struct Mark {
    pub at: Point,
    /// The text beside it; it may be empty.
    pub text: String,
    /// The number of the key whose colour the mark has.
    pub key: Option<usize>,
}

/// A path that was found.
pub struct Way {
    pub points: Vec<Point>,
    /// The text on it; it may be empty.
    pub text: String,
}

/// What was found on a piece of a line.
#[derive(Clone, Copy)]
pub enum Piece {
    /// The nearest sites, as the number of a key.
    Sites(usize),
    /// No site can be reached.
    NoSite,
    /// The piece is inside an obstacle.
    Obstacle,
}

/// The question and the answer, which are drawn over the base map.
#[derive(Default)]
pub struct Overlay {
    /// The question and a summary of the answer, in one line.
    pub title: String,
    /// Start points of the queries.
    pub starts: Vec<Point>,
    /// Whether the start points are the end points too.
    pub starts_are_ends: bool,
    /// End points of paths.
    pub ends: Vec<Mark>,
    /// The sites or vertices found, the nearest first.
    pub sites: Vec<Mark>,
    /// What the sites of the file that were not found are; `None` if they are not drawn.
    pub other_sites: Option<&'static str>,
    /// Whether the whole file is shown, if it is small, with the sites that were not found.
    pub shows_all: bool,
    /// The paths found.
    pub paths: Vec<Way>,
    /// The starts and ends between which no path was found.
    pub missing: Vec<[Point; 2]>,
    /// The rings of areas.
    pub areas: Vec<Vec<Point>>,
    /// Pieces of lines.
    pub pieces: Vec<([Point; 2], Piece)>,
    /// The nearest sites of pieces, each list once.
    pub keys: Vec<String>,
    /// What the keys are.
    pub heading: &'static str,
    /// The triangles that were searched.
    pub explored: Vec<[Point; 3]>,
}

impl Overlay {
    /// Returns the bounds of all that must be seen, with a margin. `whole` are the bounds of the
    /// file, and `besides` other bounds that must be seen.
    pub fn window(&self, whole: Rect, besides: Option<Rect>) -> Rect {
        let lines = self.pieces.iter().flat_map(|(ends, _)| ends);
        let rings = self.areas.iter().flatten();
        let marks = self.sites.iter().chain(&self.ends).map(|mark| &mark.at);
        let all = self.starts.iter().chain(marks).chain(lines).chain(rings);
        let all = all.chain(self.paths.iter().flat_map(|way| &way.points)).copied();
        let corners = |b: Rect| [Point::new(b.min_x, b.min_y), Point::new(b.max_x, b.max_y)];
        let seen = Rect::around(all.chain(besides.into_iter().flat_map(corners)));
        let (width, height) = whole.size();
        if seen.is_empty() {
            return whole;
        }
        let (seen_width, seen_height) = seen.size();
        let room = (0.12 * seen_width.max(seen_height)).max(0.01 * width.max(height));
        Rect::new(
            seen.min_x - room,
            seen.min_y - room,
            seen.max_x + room,
            seen.max_y + room,
        )
    }
}
