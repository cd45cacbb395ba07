//! The kinds of point sets, by name.

use std::fmt;
use std::str::FromStr;

/// A kind of point set. Its name on the command line is in kebab case: `line-singularity`.
///
/// Lengths are in units of the coordinates. n is the requested number of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Uniform in the unit square [0, 1)².
    Uniform,
    /// Kuzmin's distribution (Wu's thesis), dense at the origin and sparse far away: the mass
    /// within radius r is M(r) = 1 - 1/√(1 + r²), the angle is uniform.
    Kuzmin,
    /// Line singularity (Wu's thesis) with b = 0.01: uniform (u, v) is mapped to (b/(u - b·u + b),
    /// v). Half of the points are within 0.01 of the line x = b.
    LineSingularity,
    /// The first n cells of an integer grid of ⌈√n⌉ columns, row by row, each once, in
    /// pseudo-random order. Every four neighbours are cocircular.
    Grid,
    /// An airborne lidar survey in the order of its acquisition: zigzag scan lines 0.7 apart with a
    /// point every 0.5, jitter, overlapping strips up to 720 wide. Coordinates are i·0.01 + 600000
    /// and i·0.01 + 4900000 with integers i, as in LAS files. Has z: smooth terrain and noise,
    /// multiples of 0.01.
    Lidar,
    /// Points on a circle in pseudo-random order. Up to n = 393660 they are distinct, have integer
    /// coordinates below 2^53 and are *exactly* on the circle, whose radius grows with n (see
    /// `circle.rs`). Beyond that they are uniform on the unit circle, rounded, so they are nearly
    /// cocircular.
    Circle,
    /// The points (i, i²) for i = 0 … n-1 in pseudo-random order. They are exact up to i =
    /// 94906265; i² is rounded beyond that.
    Parabola,
    /// The points (3i, i) for i = 0 … n-1 in pseudo-random order. All are collinear, so there is no
    /// triangle.
    Line,
    /// Points on four lines through the origin, (s, 0), (0, s), (s, s) and (s, -s) with odd
    /// integers s, in pseudo-random order: long collinear runs, and cocircular sets of four.
    FourLines,
    /// Nested clusters, five levels deep, each an eighth as large as the one around it, of uneven
    /// mass.
    Clusters,
    /// n points at about n/8 uniform positions; every 16th point is at one of only four positions.
    Duplicates,
    /// Points every unit along wavy contour lines 40 apart, line after line, multiples of 0.01.
    Contours,
    /// A city: streets that cross every 100 units, as polylines with a vertex at every crossing and
    /// 4 to 14 between, rotated by 36.87° and rounded to multiples of 0.01. Crossings occur once
    /// for each of their two streets.
    Streets,
    /// GPS tracks in degrees around (8.5, 47.5), multiples of 1e-6: a fix every second at 0 to 20
    /// m/s with pauses.
    Tracks,
    /// Like [`Kind::Grid`], with coordinates 1e6 + i·1e-3: points that are collinear or cocircular
    /// in the grid are so up to rounding.
    Offset,
    /// Runs of 1000 points on straight lines of all directions, rounded; every fourth point is then
    /// moved up by one ulp.
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

    /// Returns the name in kebab case, which [`FromStr`] reads and [`Display`](fmt::Display)
    /// writes.
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

    /// Returns a short description for a list of kinds.
    pub fn about(self) -> &'static str {
        match self {
            Kind::Uniform => "uniform in the unit square",
            Kind::Kuzmin => "dense at the origin, sparse far away",
            Kind::LineSingularity => "dense near the line x = 0.01",
            Kind::Grid => "integer grid, shuffled",
            Kind::Lidar => "airborne scan lines, with z",
            Kind::Circle => "on a circle, exactly up to 393660 points",
            Kind::Parabola => "(i, i²), shuffled",
            Kind::Line => "collinear",
            Kind::FourLines => "on four lines through the origin",
            Kind::Clusters => "nested clusters",
            Kind::Duplicates => "each position about eight times, four positions far more often",
            Kind::Contours => "every unit along contour lines 40 apart",
            Kind::Streets => "polylines of a street grid",
            Kind::Tracks => "GPS tracks in degrees",
            Kind::Offset => "grid in steps of 1e-3 at 1e6",
            Kind::NearlyCollinear => "runs that miss a straight line by an ulp",
        }
    }

    /// Returns whether points of this kind have a third coordinate; it is 0 for other kinds.
    pub fn has_z(self) -> bool {
        self == Kind::Lidar
    }

    /// Returns whether there is a [`Pslg`](crate::Pslg) of this kind.
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

/// Error of parsing a [`Kind`]: no kind has this name.
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
