//! The triangles along a way over edges, as the edges that one crosses in them.
//!
//! ```text
//!        d ─── e          the way a v b turns left at v; round v it may be passed on either side if nothing blocks. On its left
//!       ╱ ╲   ╱ ╲         the sleeve has the triangles of v between the edges v a and v b, that is, the portals v d and v e
//!      a ─── v ─── b      (v is on their right); on its right it has those below
//!       ╲   ╱ ╲   ╱
//! ```

use std::sync::Arc;

use super::pull::Portal;
use crate::geometry::Orientation::{Clockwise, Collinear, CounterClockwise};
use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex, orient2d};
use crate::query::answer::WayPoint;
use crate::query::edges::{Node, Within, sector, wedge};
use crate::query::free_space::{Beyond, Ground, Wedge};
use crate::query::request::{Contradiction, QueryError, Tiles};
use crate::store::{Tile, VertexId};

/// A part of a way that runs through triangles, and so can be pulled taut; without portals it is straight.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) from: WayPoint,
    pub(crate) portals: Vec<Portal>,
    pub(crate) to: WayPoint,
}

/// A vertex, with the wedges in which a way comes and goes; what lies outside sees the hull from these points.
struct Pass {
    vertex: VertexId,
    wedges: [Wedge; 2],
    outside: [Option<Point>; 2],
}

/// A way over edges, in pieces: it goes from one to the next where it leaves the triangles, to walk along the hull.
pub(crate) async fn pieces(tiles: &mut Tiles, way: &[Node]) -> Result<Vec<Piece>, QueryError> {
    let point = |node: &Node| (node.point, node.vertex.vertex());
    let [first, .., last] = way else {
        return Ok(Vec::new());
    };
    let mut piece = Piece {
        from: point(first),
        portals: Vec::new(),
        to: point(last),
    };
    let mut pieces = Vec::new();
    for nodes in way.windows(3) {
        let Passing { mut entry, fan, exit } = passing(tiles, [&nodes[0], &nodes[1], &nodes[2]]).await?;
        entry.reverse();
        let turned = |portal: Portal| Portal {
            right: portal.left,
            left: portal.right,
        };
        piece.portals.extend(entry.into_iter().map(turned));
        match fan {
            Some(portals) => piece.portals.extend(portals),
            None => {
                let here = point(&nodes[1]);
                let next = Piece {
                    from: here,
                    portals: Vec::new(),
                    to: piece.to,
                };
                piece.to = here;
                pieces.push(std::mem::replace(&mut piece, next));
            }
        }
        piece.portals.extend(exit);
    }
    pieces.push(piece);
    Ok(pieces)
}

/// How a way passes a node.
struct Passing {
    /// The portals from the node back to where it comes from, if that was put in.
    entry: Vec<Portal>,
    /// Those round the node, unless it leaves the triangles there.
    fan: Option<Vec<Portal>>,
    /// Those to where it goes, if that was put in.
    exit: Vec<Portal>,
}

/// How a way passes a node between two others: through the fewest triangles.
async fn passing(tiles: &mut Tiles, [before, node, after]: [&Node; 3]) -> Result<Passing, QueryError> {
    let Some(vertex) = node.vertex.vertex() else {
        // Only ends are put in.
        let reason = "a way goes through a point that is no vertex".to_owned();
        return Err(QueryError::Uncertified { reason });
    };
    let comes = reach(tiles, vertex, node, before).await?;
    let goes = match after.vertex.vertex() {
        None => reach(tiles, vertex, node, after).await?,
        Some(end) => leaving(tiles, vertex, end, after).await?,
    };
    // The side to which it turns is the shorter one.
    let turns_left = orient2d(before.point, node.point, after.point) == CounterClockwise;
    let outside = [before, after].map(|other| other.vertex.is_put_in().then_some(other.point));
    let mut best: Option<(usize, Passing)> = None;
    for (come, entry) in &comes {
        for (go, exit) in &goes {
            let pass = Pass {
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
                    Passing {
                        entry,
                        fan: Some(fan),
                        exit,
                    },
                ));
            }
        }
    }
    let first = |ways: Vec<(Wedge, Vec<Portal>)>| ways.into_iter().next().map(|way| way.1).unwrap_or_default();
    Ok(best.map(|best| best.1).unwrap_or_else(|| Passing {
        entry: first(comes),
        fan: None,
        exit: first(goes),
    }))
}

/// The wedges of a node in which another one beside it on the way may lie; if that was put in, with the portals on the way to it.
async fn reach(
    tiles: &mut Tiles,
    vertex: VertexId,
    node: &Node,
    other: &Node,
) -> Result<Vec<(Wedge, Vec<Portal>)>, QueryError> {
    let tile = tiles.get(vertex.tile).await?;
    let ground = Ground::of(tiles, &tile);
    let (index, damaged) = (vertex.index, |reason| tiles.damaged(tile.id(), reason));
    let Some(within) = node.within else {
        return Ok(Vec::new());
    };
    let here = wedge(ground, index, within).map_err(damaged)?;
    if !other.vertex.is_put_in() {
        return Ok(vec![(here, Vec::new())]);
    }
    let (_, wedges) = sector(ground, index, here).map_err(damaged)?;
    let mut towards = Vec::new();
    for &wedge in &wedges {
        let ends = ground.neighbours(index, wedge).map_err(damaged)?;
        let [right, left] = ends.map(|end| orient2d(node.point, ground.point(end), other.point));
        if let (Wedge::Triangle(side), true) = (wedge, right != Clockwise && left != CounterClockwise) {
            towards.push((wedge, side));
        }
    }
    let mut ways = Vec::new();
    for (wedge, side) in towards {
        let portals = straight(tiles, Arc::clone(&tile), side, other.point).await?;
        ways.extend(portals.map(|portals| (wedge, portals)));
    }
    if ways.is_empty() && wedges.contains(&Wedge::Outside) {
        ways.push((Wedge::Outside, Vec::new()));
    }
    Ok(ways)
}

/// What a straight way from the vertex that a side leaves crosses, through the triangle of the side, to a point. None if it cannot go there.
/// It ends, whatever the tiles say: see [`Ground::check_crossing`].
async fn straight(
    tiles: &mut Tiles,
    tile: Arc<Tile>,
    side: HalfEdge,
    to: Point,
) -> Result<Option<Vec<Portal>>, QueryError> {
    let from = tile.point(tile.origin(side));
    let (mut tile, mut exit) = (tile, side.next());
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
        let entered = match Ground::of(tiles, &tile).beyond(exit) {
            Beyond::Side(side) => side,
            Beyond::Outside => return Ok(Some(portals)),
            Beyond::Blocked => return Ok(None),
            Beyond::Elsewhere => match tiles.side_between(left.id, right.id).await? {
                Some((there, side)) if !there.is_hole(side.triangle()) => {
                    tile = there;
                    side
                }
                None if tiles.outside_is_free() => return Ok(Some(portals)),
                _ => return Ok(None),
            },
        };
        let crossed = Ground::of(tiles, &tile).check_crossing(entered, [left.point, right.point]);
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

/// The wedge of a node by whose triangle the way goes on to a vertex of the file.
async fn leaving(
    tiles: &mut Tiles,
    vertex: VertexId,
    end: VertexId,
    after: &Node,
) -> Result<Vec<(Wedge, Vec<Portal>)>, QueryError> {
    let tile = tiles.get(vertex.tile).await?;
    let (ground, index) = (Ground::of(tiles, &tile), vertex.index);
    let found = match after.within {
        // The triangle is on the left of the way if the wedge at its end begins there.
        Some(Within::RightOf(third)) if third == vertex => right_at(ground, index, end),
        Some(Within::RightOf(_)) => wedge(ground, index, Within::RightOf(end)).map(Some),
        Some(Within::Outside) => Ok(Some(Wedge::Outside)),
        Some(Within::Sector(_)) | None => Ok(None),
    };
    let found = tiles.checked(tile.id(), found)?;
    Ok(found.into_iter().map(|wedge| (wedge, Vec::new())).collect())
}

/// The wedge of a vertex that has another one on its right.
fn right_at(ground: Ground<'_>, vertex: VertexIndex, right: VertexId) -> Result<Option<Wedge>, Contradiction> {
    for wedge in ground.free_wedges(vertex)? {
        if ground.tile.vertex(ground.neighbours(vertex, wedge)?[0]).id == right {
            return Ok(Some(wedge));
        }
    }
    Ok(None)
}

impl Pass {
    /// What is crossed round the vertex from one wedge to the other, leftwards, with the vertex on the left, or rightwards. None if
    /// something blocks.
    async fn round(&self, tiles: &mut Tiles, leftwards: bool) -> Result<Option<Vec<Portal>>, QueryError> {
        let tile = tiles.get(self.vertex.tile).await?;
        tiles.checked(tile.id(), self.round_in(Ground::of(tiles, &tile), leftwards))
    }

    fn round_in(&self, ground: Ground<'_>, leftwards: bool) -> Result<Option<Vec<Portal>>, Contradiction> {
        let vertex = self.vertex.index;
        let here = (ground.point(vertex), Some(self.vertex));
        let [start, goal] = self.wedges;
        let mut portals = Vec::new();
        let mut wedge = start;
        for _ in 0..=ground.tile.triangle_count() {
            // From outside to outside the way goes all through the hull.
            if wedge == goal && (goal != Wedge::Outside || !portals.is_empty()) {
                return Ok(Some(portals));
            }
            let end = ground.neighbours(vertex, wedge)?[usize::from(leftwards)];
            let Some(there) = ground.beside(vertex, wedge, leftwards)? else {
                return Ok(None);
            };
            let end = (ground.point(end), Some(ground.tile.vertex(end).id));
            // Over the hull one goes only to or from a point that sees the edge.
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

impl Piece {
    /// Leads the sleeve round a vertex on its other side, from this portal on, if nothing blocks there. Returns the portal behind.
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
        let ground = Ground::of(tiles, &tile);
        let wedges =
            [(enter, is_left), (leave, !is_left)].map(|(end, on_right)| beside(ground, vertex.index, end, on_right));
        let [come, go] = wedges.map(|wedge| tiles.checked(tile.id(), wedge));
        let (Some(come), Some(go)) = (come?, go?) else {
            return Ok(None);
        };
        let pass = Pass {
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

/// The free wedge of a vertex on the right or on the left of the edge to another one.
fn beside(
    ground: Ground<'_>,
    vertex: VertexIndex,
    end: VertexId,
    on_right: bool,
) -> Result<Option<Wedge>, Contradiction> {
    if !on_right {
        return right_at(ground, vertex, end);
    }
    let wedge = ground.right_of_edge(vertex, end)?;
    Ok(wedge.or(ground.outside_is_free.then_some(Wedge::Outside)))
}
