//! The kinds of point sets, by name.

use std::fmt;
use std::str::FromStr;

/// A kind of point set. Its name on the command line is in kebab case: `line-singularity`.
///
/// Lengths are in units of the coordinates. Where n matters, it is the number of points asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Uniform in the unit square [0, 1)².
    Uniform,
    /// Kuzmin's distribution (Wu's thesis), dense at the origin and thin up to far away: the mass within radius r is
    /// M(r) = 1 - 1/√(1 + r²), the angle is uniform.
    Kuzmin,
    /// Line singularity (Wu's thesis) with b = 0.01: uniform (u, v) goes to (b/(u - b·u + b), v); half of the points lie
    /// within 0.01 of the line x = b.
    LineSingularity,
    /// The integer grid of ⌈√n⌉ columns, its first n cells row by row, each once, in pseudo-random order: every four
    /// neighbours are cocircular.
    Grid,
    /// An airborne lidar survey in the order of its acquisition: zigzag scan lines 0.7 apart with a point every 0.5,
    /// jitter, strips of up to 720 width that overlap; coordinates are i·0.01 + 600000 and i·0.01 + 4900000 with
    /// integers i, as in LAS files. Has z: smooth terrain and noise, multiples of 0.01.
    Lidar,
    /// Points on a circle in pseudo-random order. Up to n = 393660 they have integer coordinates below 2^53 and lie on
    /// the circle *exactly* (points are distinct; the radius grows with n, see `circle.rs`); beyond that they are
    /// uniform on the unit circle, rounded, so that they are nearly cocircular.
    Circle,
    /// The points (i, i²) for i = 0 … n-1 in pseudo-random order; exact up to i = 94906265, i² is rounded beyond that.
    Parabola,
    /// The points (3i, i) for i = 0 … n-1 in pseudo-random order: all on one line, there is no triangle.
    Line,
    /// Points on four lines through the origin, (s, 0), (0, s), (s, s) and (s, -s) with odd integers s, in pseudo-random
    /// order: long collinear runs, and fours that are cocircular.
    FourLines,
    /// Clusters within clusters, five levels deep, each an eighth as large as the one around it, of uneven mass.
    Clusters,
    /// n points on about n/8 uniform places, every 16th point on one of only four.
    Duplicates,
    /// Points every unit along wavy contour lines 40 apart, line after line, multiples of 0.01.
    Contours,
    /// A city: streets that cross every 100, as polylines with a vertex at every crossing and 4 to 14 between, turned by
    /// 36.87° and rounded to multiples of 0.01; crossings occur once for each of their two streets.
    Streets,
    /// GPS tracks in degrees around (8.5, 47.5), multiples of 1e-6: a fix every second at 0 to 20 m/s with pauses.
    Tracks,
    /// Like [`Kind::Grid`], with coordinates 1e6 + i·1e-3: what is collinear and cocircular in there is so but for the
    /// rounding.
    Offset,
    /// Runs of 1000 points on straight lines of all directions, rounded; every fourth is then one ulp higher.
    NearlyCollinear,
}

impl Kind {
    /// All kinds, in the order of their declaration.
    pub const ALL: [Kind; 16] = [
        Kind::Uniform,
        Kind::Kuzmin,
        Kind::LineSingularity,
        Kind::Grid,
        Kind::Lidar,
        Kind::Circle,
        Kind::Parabola,
        Kind::Line,
        Kind::FourLines,
        Kind::Clusters,
        Kind::Duplicates,
        Kind::Contours,
        Kind::Streets,
        Kind::Tracks,
        Kind::Offset,
        Kind::NearlyCollinear,
    ];

    /// The name in kebab case: what [`FromStr`] reads and [`Display`](fmt::Display) writes.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Uniform => "uniform",
            Kind::Kuzmin => "kuzmin",
            Kind::LineSingularity => "line-singularity",
            Kind::Grid => "grid",
            Kind::Lidar => "lidar",
            Kind::Circle => "circle",
            Kind::Parabola => "parabola",
            Kind::Line => "line",
            Kind::FourLines => "four-lines",
            Kind::Clusters => "clusters",
            Kind::Duplicates => "duplicates",
            Kind::Contours => "contours",
            Kind::Streets => "streets",
            Kind::Tracks => "tracks",
            Kind::Offset => "offset",
            Kind::NearlyCollinear => "nearly-collinear",
        }
    }

    /// A few words for a list of kinds.
    pub fn about(self) -> &'static str {
        match self {
            Kind::Uniform => "uniform in the unit square",
            Kind::Kuzmin => "dense at the origin, thin far away",
            Kind::LineSingularity => "crowded towards the line x = 0.01",
            Kind::Grid => "integer grid, shuffled",
            Kind::Lidar => "airborne scan lines, with z",
            Kind::Circle => "on a circle, exactly so up to 393660 points",
            Kind::Parabola => "(i, i²), shuffled",
            Kind::Line => "all on one line",
            Kind::FourLines => "on four lines through the origin",
            Kind::Clusters => "clusters within clusters",
            Kind::Duplicates => "each place about eight times, four places far more often",
            Kind::Contours => "every unit along contour lines 40 apart",
            Kind::Streets => "polylines of a street grid",
            Kind::Tracks => "GPS tracks in degrees",
            Kind::Offset => "grid in steps of 1e-3 at 1e6",
            Kind::NearlyCollinear => "runs that miss a straight line by an ulp",
        }
    }

    /// Whether points of this kind have a third coordinate; it is 0 for the others.
    pub fn has_z(self) -> bool {
        self == Kind::Lidar
    }

    /// Whether there is a [`Pslg`](crate::Pslg) of this kind.
    pub fn has_pslg(self) -> bool {
        matches!(self, Kind::Uniform | Kind::Kuzmin | Kind::LineSingularity)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Kind {
    type Err = UnknownKind;

    fn from_str(name: &str) -> Result<Self, UnknownKind> {
        Kind::ALL
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or_else(|| UnknownKind(name.to_owned()))
    }
}

/// Error of reading a [`Kind`]: no kind has this name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownKind(pub String);

impl fmt::Display for UnknownKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "unknown kind '{}'; there are {}",
            self.0,
            Kind::ALL.map(Kind::name).join(", ")
        )
    }
}

impl std::error::Error for UnknownKind {}
