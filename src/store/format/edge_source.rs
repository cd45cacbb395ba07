//! The source of a constraint edge: the input line, and its kind.

use std::fmt;

/// The kind of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LineKind {
    /// Paths may cross it.
    #[default]
    BreakLine,
    /// Paths must not cross it.
    Wall,
    /// A ring of a polygon whose interior is not free. Paths must not cross it.
    Obstacle,
}

impl LineKind {
    /// Returns the number that stands for this value in a file.
    pub(crate) const fn to_code(self) -> u8 {
        match self {
            Self::BreakLine => 0,
            Self::Wall => 1,
            Self::Obstacle => 2,
        }
    }

    /// Returns the kind that a number in a file stands for, or `None` if the number is unknown.
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

/// One reason why an edge is a constraint: an input line along the edge, as seen in one direction
/// of the edge.
///
/// Lines are numbered from 0 across all inputs: segments, then walls, then obstacles.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct EdgeSource(u64);

const BREAK_LINE: u64 = 0;
const WALL: u64 = 1;
const OBSTACLE_LEFT: u64 = 2;
const OBSTACLE_RIGHT: u64 = 3;

impl EdgeSource {
    /// The largest line number. It leaves two bits for the ends in
    /// [`LinePart`](crate::store::LinePart), which takes eight bytes too.
    pub const MAX_NUMBER: u64 = u64::MAX >> 4;

    /// Creates the source for line `number`. The interior of an obstacle is on the left of the
    /// edge's direction.
    ///
    /// `number` is at most [`MAX_NUMBER`](Self::MAX_NUMBER).
    #[must_use]
    pub const fn new(kind: LineKind, number: u64) -> Self {
        let code = match kind {
            LineKind::BreakLine => BREAK_LINE,
            LineKind::Wall => WALL,
            LineKind::Obstacle => OBSTACLE_LEFT,
        };
        Self(number << 2 | code)
    }

    /// Returns the line's number.
    #[must_use]
    pub const fn number(self) -> u64 {
        self.0 >> 2
    }

    /// Returns the line's kind.
    #[must_use]
    pub const fn kind(self) -> LineKind {
        match self.0 & 3 {
            BREAK_LINE => LineKind::BreakLine,
            WALL => LineKind::Wall,
            _ => LineKind::Obstacle,
        }
    }

    /// Returns whether paths must not cross the line.
    #[must_use]
    pub const fn is_wall(self) -> bool {
        self.0 & 3 != BREAK_LINE
    }

    /// Returns by how many more obstacles the left side of the edge is covered than the right side:
    /// 1, 0 or −1.
    #[must_use]
    pub const fn depth_change(self) -> i32 {
        match self.0 & 3 {
            OBSTACLE_LEFT => 1,
            OBSTACLE_RIGHT => -1,
            _ => 0,
        }
    }

    /// Returns the same line, as seen in the other direction of the edge.
    #[must_use]
    pub const fn reversed(self) -> Self {
        // The lowest bit is the side of the interior, and applies to obstacles only.
        Self(self.0 ^ (self.0 >> 1 & 1))
    }

    /// Returns the source of the line 0 of the same kind, on the same side.
    pub(crate) const fn without_number(self) -> Self {
        Self(self.0 & 3)
    }

    /// Returns the number that stands for the kind, and for the side of the interior, in a file.
    pub(crate) const fn code(self) -> u64 {
        self.0 & 3
    }

    /// Returns the number that stands for this value in a file.
    pub(crate) const fn to_bits(self) -> u64 {
        self.0
    }

    /// The largest number that stands for a source.
    pub(crate) const MAX_BITS: u64 = Self::MAX_NUMBER << 2 | 3;

    /// Returns the source that a number in a file stands for.
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
    fn reversing_an_edge_source_swaps_the_sides_of_obstacles_only() {
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
