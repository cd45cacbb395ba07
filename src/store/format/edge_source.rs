//! What an input line makes of the edges along it, and which line it was.

use std::fmt;

/// What lines are for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LineKind {
    /// Does not block the way.
    #[default]
    BreakLine,
    /// Blocks the way.
    Wall,
    /// A ring of a polygon whose interior is not free; blocks the way too.
    Obstacle,
}

impl LineKind {
    /// As a number that fits a file.
    pub(crate) const fn to_code(self) -> u8 {
        match self {
            Self::BreakLine => 0,
            Self::Wall => 1,
            Self::Obstacle => 2,
        }
    }

    /// From such a number, if it is one.
    pub(crate) const fn from_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::BreakLine),
            1 => Some(Self::Wall),
            2 => Some(Self::Obstacle),
            _ => None,
        }
    }
}

impl fmt::Display for LineKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BreakLine => "break line",
            Self::Wall => "wall",
            Self::Obstacle => "obstacle",
        })
    }
}

/// One reason why an edge is a constraint: the input line along it, seen in one direction of the edge.
///
/// Lines are numbered from 0 over all inputs: segments, then walls, then obstacles.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct EdgeSource(u64);

const BREAK_LINE: u64 = 0;
const WALL: u64 = 1;
const OBSTACLE_LEFT: u64 = 2;
const OBSTACLE_RIGHT: u64 = 3;

impl EdgeSource {
    /// The largest number of a line.
    pub const MAX_NUMBER: u64 = u64::MAX >> 2;

    /// A line. An obstacle's interior is on the left of the edge's direction.
    ///
    /// The number is at most [`MAX_NUMBER`](Self::MAX_NUMBER).
    #[must_use]
    pub const fn new(kind: LineKind, number: u64) -> Self {
        let code = match kind {
            LineKind::BreakLine => BREAK_LINE,
            LineKind::Wall => WALL,
            LineKind::Obstacle => OBSTACLE_LEFT,
        };
        Self(number << 2 | code)
    }

    /// The line's number.
    #[must_use]
    pub const fn number(self) -> u64 {
        self.0 >> 2
    }

    /// What the line is for.
    #[must_use]
    pub const fn kind(self) -> LineKind {
        match self.0 & 3 {
            BREAK_LINE => LineKind::BreakLine,
            WALL => LineKind::Wall,
            _ => LineKind::Obstacle,
        }
    }

    /// Whether the line blocks the way.
    #[must_use]
    pub const fn is_wall(self) -> bool {
        self.0 & 3 != BREAK_LINE
    }

    /// By how much more the left of the edge is covered by obstacles than the right.
    #[must_use]
    pub const fn depth_change(self) -> i32 {
        match self.0 & 3 {
            OBSTACLE_LEFT => 1,
            OBSTACLE_RIGHT => -1,
            _ => 0,
        }
    }

    /// The same line, seen in the other direction of the edge.
    #[must_use]
    pub const fn reversed(self) -> Self {
        // Only of obstacles the lowest bit tells the side.
        Self(self.0 ^ (self.0 >> 1 & 1))
    }

    /// As a number that fits a file.
    pub(crate) const fn to_bits(self) -> u64 {
        self.0
    }

    /// From such a number.
    pub(crate) const fn from_bits(bits: u64) -> Self {
        Self(bits)
    }
}

impl fmt::Debug for EdgeSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = match self.0 & 3 {
            OBSTACLE_LEFT => " on the left",
            OBSTACLE_RIGHT => " on the right",
            _ => "",
        };
        write!(f, "{} {}{side}", self.kind(), self.number())
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for EdgeSource {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let mut source = serializer.serialize_struct("EdgeSource", 3)?;
        source.serialize_field("kind", &self.kind().to_string())?;
        source.serialize_field("number", &self.number())?;
        source.serialize_field("depth_change", &self.depth_change())?;
        source.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_obstacle_changes_sides_with_the_direction() {
        for number in [0, 1, 77, EdgeSource::MAX_NUMBER] {
            let obstacle = EdgeSource::new(LineKind::Obstacle, number);
            assert_eq!([obstacle.depth_change(), obstacle.reversed().depth_change()], [1, -1]);
            for kind in [LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle] {
                let source = EdgeSource::new(kind, number);
                assert_eq!((source.kind(), source.number()), (kind, number));
                assert_eq!((source.reversed().kind(), source.reversed().number()), (kind, number));
                assert_eq!(source.reversed().reversed(), source);
                assert_eq!(source.is_wall(), kind != LineKind::BreakLine);
                assert_eq!(EdgeSource::from_bits(source.to_bits()), source);
            }
        }
    }
}
