//! The twin of a half-edge as a tile stores it.

use crate::geometry::HalfEdge;
use crate::mesh::Twin;

/// A [`Twin`] in four bytes instead of eight: the cache is full of tiles, which have three twins
/// for each triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PackedTwin(u32);

impl PackedTwin {
    const HULL: Self = Self(u32::MAX);
    const ELSEWHERE: Self = Self(u32::MAX - 1);

    #[inline]
    pub(crate) const fn get(self) -> Twin {
        match self {
            Self::HULL => Twin::Hull,
            Self::ELSEWHERE => Twin::Elsewhere,
            Self(half_edge) => Twin::HalfEdge(HalfEdge(half_edge)),
        }
    }
}

impl From<Twin> for PackedTwin {
    #[inline]
    fn from(twin: Twin) -> Self {
        match twin {
            Twin::HalfEdge(half_edge) => Self(half_edge.0),
            Twin::Hull => Self::HULL,
            Twin::Elsewhere => Self::ELSEWHERE,
        }
    }
}
