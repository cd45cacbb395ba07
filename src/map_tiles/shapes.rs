//! Lines and sites of the tiles of a file, in units of a map tile.
//!
//! What is found depends on the triangulation alone, and not on its tiles: each edge is seen from
//! the triangles on both of its sides, which two tiles may own, and what they know is joined.

use crate::geometry::{HalfEdge, Point};
use crate::map_tiles::window::{Unit, Window};
use crate::mesh::Topology;
use crate::store::{Tile, TileEdge};

/// What a line of a map is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// A constraint that paths may cross.
    Break,
    /// A wall at a hole: the outline of an obstacle.
    Obstacle,
    /// A wall that is not at a hole.
    Wall,
}

impl Kind {
    pub(super) const ALL: [Self; 3] = [Self::Break, Self::Obstacle, Self::Wall];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Break => "break",
            Self::Obstacle => "obstacle",
            Self::Wall => "wall",
        }
    }
}

/// A part of a constraint, as seen from one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Sighting {
    /// In order.
    ends: [Unit; 2],
    is_wall: bool,
    is_at_hole: bool,
}

/// A site in a map tile.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SiteShape {
    pub(super) at: Unit,
    pub(super) number: u64,
    pub(super) id: Option<String>,
    pub(super) z: Option<f64>,
}

/// Lines and sites in a map tile.
#[derive(Clone, Debug, Default)]
pub(super) struct Shapes {
    seen: Vec<Sighting>,
    sites: Vec<SiteShape>,
    /// The vertices of a file without triangles.
    vertices: Vec<Unit>,
}

impl Shapes {
    /// Returns the shapes of a tile of the file. If segments of the file are curves in the grid,
    /// the lines are too, if `curved` says so.
    pub(super) fn of(tile: &Tile, window: &Window, curved: bool) -> Self {
        let mut this = Self::default();
        this.add_sites(tile, window);
        if tile.triangle_count() == 0 {
            for number in 0..tile.edge_count() {
                let edge = TileEdge::OnLine(number);
                let ends = tile.corners_of_edge(edge).map(|corner| tile.point(corner));
                this.add_line(ends, [tile.is_wall(edge), false], window, curved);
            }
            this.vertices.extend(tile.points().filter_map(|p| window.inside(p)));
            return this;
        }
        for half_edge in tile.constraint_half_edges() {
            let ends = [tile.origin(half_edge), tile.destination(half_edge)].map(|corner| tile.point(corner));
            if tile.owns(half_edge.triangle()) {
                this.add_line(ends, facts(tile, half_edge), window, curved);
            }
        }
        this.join();
        this
    }

    fn add_sites(&mut self, tile: &Tile, window: &Window) {
        let sites = tile.sites().filter_map(|site| {
            Some(SiteShape {
                at: window.inside(tile.point(site.vertex))?,
                number: site.number,
                id: site.id.map(str::to_owned),
                z: tile.z(site.vertex),
            })
        });
        self.sites.extend(sites);
    }

    fn add_line(&mut self, mut ends: [Point; 2], [is_wall, is_at_hole]: [bool; 2], window: &Window, curved: bool) {
        // Both triangles at the edge divide it alike.
        ends.sort_unstable_by(|a, b| a.lex_cmp(*b));
        let mut take = |mut ends: [Unit; 2]| {
            ends.sort_unstable();
            self.seen.push(Sighting {
                ends,
                is_wall,
                is_at_hole,
            });
        };
        match curved {
            true => window.curve(ends, &mut take),
            false => window.line(ends, &mut take),
        }
    }

    /// Adds the shapes of another tile.
    pub(super) fn append(&mut self, mut other: Self) {
        self.seen.append(&mut other.seen);
        self.sites.append(&mut other.sites);
        self.vertices.append(&mut other.vertices);
    }

    /// Joins what is known of the same line, and sorts all shapes.
    pub(super) fn join(&mut self) {
        self.seen.sort_unstable();
        self.seen.dedup_by(|next, kept| {
            let is_same = next.ends == kept.ends;
            if is_same {
                kept.is_wall |= next.is_wall;
                kept.is_at_hole |= next.is_at_hole;
            }
            is_same
        });
        self.sites.sort_unstable_by_key(|site| site.number);
        self.vertices.sort_unstable();
        self.vertices.dedup();
    }

    /// Returns the lines of a kind, each in order. All shapes must have been [joined](Self::join).
    pub(super) fn lines(&self, kind: Kind) -> Vec<[Unit; 2]> {
        let is_it = |seen: &&Sighting| {
            kind == match (seen.is_wall, seen.is_at_hole) {
                (false, _) => Kind::Break,
                (true, true) => Kind::Obstacle,
                (true, false) => Kind::Wall,
            }
        };
        self.seen.iter().filter(is_it).map(|seen| seen.ends).collect()
    }

    /// Returns the lines at holes.
    pub(super) fn at_holes(&self) -> impl Iterator<Item = [Unit; 2]> {
        self.seen.iter().filter(|seen| seen.is_at_hole).map(|seen| seen.ends)
    }

    /// Returns the number of segments of all lines.
    pub(super) fn line_count(&self) -> usize {
        self.seen.len()
    }

    pub(super) fn clear_lines(&mut self) {
        self.seen.clear();
    }

    pub(super) fn clear_sites(&mut self) {
        self.sites.clear();
    }

    pub(super) fn sites(&self) -> &[SiteShape] {
        &self.sites
    }

    pub(super) fn vertices(&self) -> &[Unit] {
        &self.vertices
    }
}

/// Returns whether the edge of a half-edge is a wall, and whether the triangle on its left is in a
/// hole.
fn facts(tile: &Tile, half_edge: HalfEdge) -> [bool; 2] {
    [tile.is_wall(half_edge), tile.is_hole(half_edge.triangle())]
}
