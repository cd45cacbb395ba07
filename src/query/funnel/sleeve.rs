//! The triangles along a path over edges, represented by the edges that are crossed between them.
//!
//! ```text
//!        d ─── e        The path a v b turns left at v. It may pass v on either side if nothing
//!       ╱ ╲   ╱ ╲       blocks. On the left of v, the sleeve has the triangles of v between the
//!      a ─── v ─── b    edges v a and v b, that is, the portals v d and v e (v is on their right).
//!       ╲   ╱ ╲   ╱     On the right of v, it has the triangles below.
//! ```

use std::sync::Arc;

use super::portals::Portal;
use crate::geometry::Orientation::{Clockwise, Collinear, CounterClockwise};
use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex, orient2d};
use crate::query::answer::WayPoint;
use crate::query::edges::{Node, Within, sector, wedge};
use crate::query::free_space::{FreeSpace, FreeTwin, Wedge};
use crate::query::request::{Contradiction, QueryError, Tiles};
use crate::store::{Tile, VertexId};

/// A part of a path that runs through triangles, and so can be shortened. Without portals it is
/// straight.
#[derive(Clone, Debug)]
pub(crate) struct Sleeve {
    pub(crate) from: WayPoint,
    pub(crate) portals: Vec<Portal>,
    pub(crate) to: WayPoint,
}

/// A vertex, with the wedges by which a path arrives and leaves. If the path comes from or goes to
/// the outside, `outside` has the points from which the hull is seen.
struct VertexPass {
    vertex: VertexId,
    wedges: [Wedge; 2],
    outside: [Option<Point>; 2],
}

/// Returns the sleeves of a path over edges. A sleeve ends where the path leaves the triangles, to
/// walk along the hull.
pub(crate) async fn sleeves(tiles: &mut Tiles, way: &[Node]) -> Result<Vec<Sleeve>, QueryError> {
    let point = |node: &Node| (node.point, node.vertex.vertex());
    let [first, .., last] = way else {
        return Ok(Vec::new());
    };
    let mut sleeve = Sleeve {
        from: point(first),
        portals: Vec::new(),
        to: point(last),
    };
    let mut sleeves = Vec::new();
    for nodes in way.windows(3) {
        let NodePassage { mut entry, fan, exit } = passing(tiles, [&nodes[0], &nodes[1], &nodes[2]]).await?;
        entry.reverse();
        let turned = |portal: Portal| Portal {
            right: portal.left,
            left: portal.right,
        };
        sleeve.portals.extend(entry.into_iter().map(turned));
        match fan {
            Some(portals) => sleeve.portals.extend(portals),
            None => {
                let here = point(&nodes[1]);
                let next = Sleeve {
                    from: here,
                    portals: Vec::new(),
                    to: sleeve.to,
                };
                sleeve.to = here;
                sleeves.push(std::mem::replace(&mut sleeve, next));
            }
        }
        sleeve.portals.extend(exit);
    }
    sleeves.push(sleeve);
    Ok(sleeves)
}

/// How a path passes a node.
struct NodePassage {
    /// The portals from the node back to the previous one, if that is an inserted point.
    entry: Vec<Portal>,
    /// The portals round the node; `None` if the path leaves the triangles there.
    fan: Option<Vec<Portal>>,
    /// The portals to the next node, if that is an inserted point.
    exit: Vec<Portal>,
}

/// Determines how a path passes a node between two others: through as few triangles as possible.
async fn passing(tiles: &mut Tiles, [before, node, after]: [&Node; 3]) -> Result<NodePassage, QueryError> {
    let Some(vertex) = node.vertex.vertex() else {
        // Only the ends of a path are inserted points.
        let reason = "a path passes through a point that is not a vertex".to_owned();
        return Err(QueryError::Uncertified { reason });
    };
    let comes = reach(tiles, vertex, node, before).await?;
    let goes = match after.vertex.vertex() {
        None => reach(tiles, vertex, node, after).await?,
        Some(end) => leaving(tiles, vertex, end, after).await?,
    };
    // The side to which the path turns is the shorter one.
    let turns_left = orient2d(before.point, node.point, after.point) == CounterClockwise;
    let outside = [before, after].map(|other| other.vertex.is_inserted().then_some(other.point));
    let mut best: Option<(usize, NodePassage)> = None;
    for (come, entry) in &comes {
        for (go, exit) in &goes {
            let pass = VertexPass {
                vertex,
                wedges: [*come, *go],
                outside,
            };
            let mut fan = pass.round(tiles, !turns_left).await?;
            if fan.is_none() {
                fan = pass.round(tiles, turns_left).await?;
            }
            // A point on a wall may be on either side of it.
            if let Some(fan) = fan
                && best.as_ref().is_none_or(|best| fan.len() < best.0)
            {
                let (entry, exit) = (entry.clone(), exit.clone());
                best = Some((
                    fan.len(),
                    NodePassage {
                        entry,
                        fan: Some(fan),
                        exit,
                    },
                ));
            }
        }
    }
    let first = |ways: Vec<(Wedge, Vec<Portal>)>| ways.into_iter().next().map(|way| way.1).unwrap_or_default();
    Ok(best.map(|best| best.1).unwrap_or_else(|| NodePassage {
        entry: first(comes),
        fan: None,
        exit: first(goes),
    }))
}

/// Returns the wedges of a node that may contain its neighbour `other` on the path. If `other` is
/// an inserted point, each wedge comes with the portals on the way to it.
async fn reach(
    tiles: &mut Tiles,
    vertex: VertexId,
    node: &Node,
    other: &Node,
) -> Result<Vec<(Wedge, Vec<Portal>)>, QueryError> {
    let tile = tiles.get(vertex.tile).await?;
    let space = FreeSpace::of(tiles, &tile);
    let (index, damaged) = (vertex.index, |reason| tiles.damaged(tile.id(), reason));
    let Some(within) = node.within else {
        return Ok(Vec::new());
    };
    let here = wedge(space, index, within).map_err(damaged)?;
    if !other.vertex.is_inserted() {
        return Ok(vec![(here, Vec::new())]);
    }
    let (_, wedges) = sector(space, index, here).map_err(damaged)?;
    let mut towards = Vec::new();
    for &wedge in &wedges {
        let ends = space.neighbours(index, wedge).map_err(damaged)?;
        let [right, left] = ends.map(|end| orient2d(node.point, space.point(end), other.point));
        if let (Wedge::Triangle(half_edge), true) = (wedge, right != Clockwise && left != CounterClockwise) {
            towards.push((wedge, half_edge));
        }
    }
    let mut ways = Vec::new();
    for (wedge, half_edge) in towards {
        let portals = straight(tiles, Arc::clone(&tile), half_edge, other.point).await?;
        ways.extend(portals.map(|portals| (wedge, portals)));
    }
    if ways.is_empty() && wedges.contains(&Wedge::Outside) {
        ways.push((Wedge::Outside, Vec::new()));
    }
    Ok(ways)
}

/// Returns the portals of the straight line from the origin of a half-edge, through the half-edge's
/// triangle, to `to`. Returns `None` if the line is blocked.
///
/// The loop ends even in damaged tiles: see [`FreeSpace::check_crossing`].
async fn straight(
    tiles: &mut Tiles,
    tile: Arc<Tile>,
    half_edge: HalfEdge,
    to: Point,
) -> Result<Option<Vec<Portal>>, QueryError> {
    let from = tile.point(tile.origin(half_edge));
    let (mut tile, mut exit) = (tile, half_edge.next());
    let mut portals = Vec::new();
    let is_in = |tile: &Tile, triangle: TriangleId| {
        let corners = tile.triangle_points(triangle);
        (0..3).all(|s| orient2d(corners[s], corners[(s + 1) % 3], to) != Clockwise)
    };
    while !is_in(&tile, exit.triangle()) {
        let [right, left] = tile.ends(exit);
        portals.push(Portal {
            right: (right.point, Some(right.id)),
            left: (left.point, Some(left.id)),
        });
        let entered = match FreeSpace::of(tiles, &tile).twin(exit) {
            FreeTwin::HalfEdge(half_edge) => half_edge,
            FreeTwin::Outside => return Ok(Some(portals)),
            FreeTwin::Blocked => return Ok(None),
            FreeTwin::Elsewhere => match tiles.half_edge_between(left.id, right.id).await? {
                Some((there, half_edge)) if !there.is_hole(half_edge.triangle()) => {
                    tile = there;
                    half_edge
                }
                None if tiles.outside_is_free() => return Ok(Some(portals)),
                _ => return Ok(None),
            },
        };
        let crossed = FreeSpace::of(tiles, &tile).check_crossing(entered, [left.point, right.point]);
        tiles.checked(tile.id(), crossed)?;
        if is_in(&tile, entered.triangle()) {
            break;
        }
        let apex = tile.point(tile.origin(entered.prev()));
        exit = match orient2d(from, to, apex) {
            CounterClockwise => entered.next(),
            Clockwise => entered.prev(),
            Collinear => return Ok(None),
        };
    }
    Ok(Some(portals))
}

/// Returns the wedge of a node through whose triangle the path continues to a vertex of the file.
async fn leaving(
    tiles: &mut Tiles,
    vertex: VertexId,
    end: VertexId,
    after: &Node,
) -> Result<Vec<(Wedge, Vec<Portal>)>, QueryError> {
    let tile = tiles.get(vertex.tile).await?;
    let (space, index) = (FreeSpace::of(tiles, &tile), vertex.index);
    let found = match after.within {
        // The triangle is on the left of the path if the wedge at its end starts there.
        Some(Within::RightOf(third)) if third == vertex => right_at(space, index, end),
        Some(Within::RightOf(_)) => wedge(space, index, Within::RightOf(end)).map(Some),
        Some(Within::Outside) => Ok(Some(Wedge::Outside)),
        Some(Within::Sector(_)) | None => Ok(None),
    };
    let found = tiles.checked(tile.id(), found)?;
    Ok(found.into_iter().map(|wedge| (wedge, Vec::new())).collect())
}

/// Returns the free wedge of a vertex whose right neighbour is `right`.
fn right_at(space: FreeSpace<'_>, vertex: VertexIndex, right: VertexId) -> Result<Option<Wedge>, Contradiction> {
    for wedge in space.free_wedges(vertex)? {
        if space.tile.vertex(space.neighbours(vertex, wedge)?[0]).id == right {
            return Ok(Some(wedge));
        }
    }
    Ok(None)
}

impl VertexPass {
    /// Returns the portals round the vertex from one wedge to the other: leftwards, with the vertex
    /// on the left, or rightwards. Returns `None` if something blocks.
    async fn round(&self, tiles: &mut Tiles, leftwards: bool) -> Result<Option<Vec<Portal>>, QueryError> {
        let tile = tiles.get(self.vertex.tile).await?;
        tiles.checked(tile.id(), self.round_in(FreeSpace::of(tiles, &tile), leftwards))
    }

    fn round_in(&self, space: FreeSpace<'_>, leftwards: bool) -> Result<Option<Vec<Portal>>, Contradiction> {
        let vertex = self.vertex.index;
        let here = (space.point(vertex), Some(self.vertex));
        let [start, goal] = self.wedges;
        let mut portals = Vec::new();
        let mut wedge = start;
        for _ in 0..=space.tile.triangle_count() {
            // A path from the outside to the outside crosses the whole hull.
            if wedge == goal && (goal != Wedge::Outside || !portals.is_empty()) {
                return Ok(Some(portals));
            }
            let end = space.neighbours(vertex, wedge)?[usize::from(leftwards)];
            let Some(there) = space.beside(vertex, wedge, leftwards)? else {
                return Ok(None);
            };
            let end = (space.point(end), Some(space.tile.vertex(end).id));
            // A path crosses the hull only to or from a point that sees the hull edge.
            let seen_from = match (wedge, there) {
                (Wedge::Outside, _) => Some(self.outside[0]),
                (_, Wedge::Outside) if goal == Wedge::Outside => Some(self.outside[1]),
                (_, Wedge::Outside) => return Ok(None),
                _ => None,
            };
            if let Some(from) = seen_from {
                let inside_is_left = (wedge == Wedge::Outside) == leftwards;
                let [a, b] = if inside_is_left { [here, end] } else { [end, here] };
                if from.is_none_or(|from| orient2d(a.0, b.0, from) != Clockwise) {
                    return Ok(None);
                }
            }
            let [right, left] = if leftwards { [end, here] } else { [here, end] };
            portals.push(Portal { right, left });
            wedge = there;
        }
        Err(Contradiction::EndlessStar(vertex))
    }
}

impl Sleeve {
    /// Moves the sleeve to the other side of a vertex, from portal `from` on, if nothing blocks
    /// there. Returns the index of the portal after the vertex.
    pub(crate) async fn flip(
        &mut self,
        tiles: &mut Tiles,
        vertex: VertexId,
        is_left: bool,
        from: usize,
    ) -> Result<Option<usize>, QueryError> {
        let ends = |portal: &Portal| {
            let (own, other) = if is_left {
                (portal.left, portal.right)
            } else {
                (portal.right, portal.left)
            };
            (own.1 == Some(vertex)).then_some(other.1).flatten()
        };
        let Some(first) = (from..self.portals.len()).find(|&i| ends(&self.portals[i]).is_some()) else {
            return Ok(None);
        };
        let run: Vec<VertexId> = self.portals[first..].iter().map_while(ends).collect();
        let (Some(&enter), Some(&leave)) = (run.first(), run.last()) else {
            return Ok(None);
        };
        let tile = tiles.get(vertex.tile).await?;
        if !tile.has_vertex(vertex.index) {
            return Err(tiles.damaged(vertex.tile, Contradiction::NoVertex(vertex.index)));
        }
        let space = FreeSpace::of(tiles, &tile);
        let wedges =
            [(enter, is_left), (leave, !is_left)].map(|(end, on_right)| beside(space, vertex.index, end, on_right));
        let [come, go] = wedges.map(|wedge| tiles.checked(tile.id(), wedge));
        let (Some(come), Some(go)) = (come?, go?) else {
            return Ok(None);
        };
        let pass = VertexPass {
            vertex,
            wedges: [come, go],
            outside: [Some(self.from.0), Some(self.to.0)],
        };
        let Some(other) = pass.round(tiles, !is_left).await? else {
            return Ok(None);
        };
        let behind = first + other.len();
        self.portals.splice(first..first + run.len(), other);
        Ok(Some(behind))
    }
}

/// Returns the free wedge of a vertex on the right or on the left of the edge to `end`.
fn beside(
    space: FreeSpace<'_>,
    vertex: VertexIndex,
    end: VertexId,
    on_right: bool,
) -> Result<Option<Wedge>, Contradiction> {
    if !on_right {
        return right_at(space, vertex, end);
    }
    let wedge = space.right_of_edge(vertex, end)?;
    Ok(wedge.or(space.outside_is_free.then_some(Wedge::Outside)))
}
