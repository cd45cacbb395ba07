//! What a method has gathered: candidates and obstacle edges, as a local visibility graph.

use foldhash::{HashMap, HashMapExt, HashSet, HashSetExt};

use super::asked::Asked;
use super::graph::{LocalGraph, Search};
use super::obstacles::ObstacleEdge;
use crate::geometry::Point;
use crate::query::answer::WayPoint;
use crate::query::free_space::{Place, Spot};
use crate::query::request::QueryError;
use crate::store::{Vertex, VertexId};

/// A vertex with sites.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) vertex: Vertex,
    /// Number and id of each.
    pub(super) sites: Vec<(u64, Option<String>)>,
    node: u32,
}

/// A candidate, or the target of a path, that was reached.
#[derive(Clone, Debug)]
pub(super) struct Reached {
    pub(super) candidate: usize,
    pub(super) length: f64,
    pub(super) way: Vec<WayPoint>,
}

/// Sweeps after which others have their turn.
const PAUSE: u64 = 64;

/// Candidates and obstacle edges round a source.
pub(super) struct Local {
    graph: LocalGraph,
    known: HashSet<[VertexId; 2]>,
    /// Points that lie within an edge.
    on_edges: Vec<([VertexId; 2], Point)>,
    source: u32,
    pub(super) candidates: Vec<Candidate>,
    at: HashMap<u32, usize>,
    /// The node of the target of a path.
    target: Option<u32>,
    /// Vertices all of whose edges are known.
    complete: HashSet<VertexId>,
}

fn sorted([a, b]: [VertexId; 2]) -> [VertexId; 2] {
    if a < b { [a, b] } else { [b, a] }
}

impl Local {
    /// With a source, and a target if a path is asked for.
    pub(super) fn new(source: &Place, target: Option<&Place>) -> Self {
        let mut this = Self {
            graph: LocalGraph::default(),
            known: HashSet::new(),
            on_edges: Vec::new(),
            source: 0,
            candidates: Vec::new(),
            at: HashMap::new(),
            target: None,
            complete: HashSet::new(),
        };
        this.source = this.place(source);
        this.target = target.map(|target| this.place(target));
        this
    }

    fn place(&mut self, place: &Place) -> u32 {
        if let Spot::Edge { ends } = place.spot {
            self.on_edges.push((sorted(ends.map(|end| end.id)), place.point));
        }
        self.graph.node((place.point, place.vertex()))
    }

    /// Adds an edge, unless it is known.
    pub(super) fn add_edge(&mut self, edge: &ObstacleEdge) -> bool {
        let [from, to] = edge.ends;
        let key = edge.key();
        if !self.known.insert(key) {
            return false;
        }
        let mut points = vec![(from.point, Some(from.id)), (to.point, Some(to.id))];
        let on_edge = self.on_edges.iter().filter(|on_edge| on_edge.0 == key);
        points.splice(1..1, on_edge.map(|&(_, point)| (point, None)));
        points.sort_by(|a, b| a.0.lex_cmp(b.0));
        points.dedup_by_key(|point| point.0);
        if to.point.lex_cmp(from.point).is_lt() {
            points.reverse();
        }
        for piece in points.windows(2) {
            self.graph.add_edge([piece[0], piece[1]], edge.free);
        }
        true
    }

    /// Adds a vertex with sites, unless it is known.
    pub(super) fn add_candidate(&mut self, vertex: Vertex, sites: Vec<(u64, Option<String>)>) {
        let node = self.graph.node((vertex.point, Some(vertex.id)));
        if !sites.is_empty() && !self.at.contains_key(&node) {
            self.at.insert(node, self.candidates.len());
            self.candidates.push(Candidate { vertex, sites, node });
        }
    }

    /// Notes that all edges of a vertex are known.
    pub(super) fn complete(&mut self, vertex: VertexId) {
        self.complete.insert(vertex);
    }

    /// Whether all edges of a vertex are known to be known.
    pub(super) fn is_complete(&self, vertex: VertexId) -> bool {
        self.complete.contains(&vertex)
    }

    /// How many sites there are at all candidates.
    pub(super) fn site_count(&self) -> usize {
        self.candidates.iter().map(|candidate| candidate.sites.len()).sum()
    }

    /// The nearest candidates with so many sites, within a limit; all of those that are as far away as the last one.
    pub(super) async fn nearest(
        &self,
        wanted: usize,
        limit: f64,
        asked: &mut Asked,
    ) -> Result<Vec<Reached>, QueryError> {
        let targets = self
            .candidates
            .iter()
            .map(|candidate| (candidate.node, candidate.sites.len()));
        self.search(targets.collect(), wanted, limit, asked).await
    }

    /// The target of a path, if it can be reached within a limit.
    pub(super) async fn target(&self, limit: f64, asked: &mut Asked) -> Result<Option<Reached>, QueryError> {
        let target = self.target.map(|target| (target, 1));
        let found = self.search(target.into_iter().collect(), 1, limit, asked).await;
        found.map(|mut found| found.pop())
    }

    async fn search(
        &self,
        targets: Vec<(u32, usize)>,
        wanted: usize,
        limit: f64,
        asked: &mut Asked,
    ) -> Result<Vec<Reached>, QueryError> {
        asked.clock.lap("collect");
        if wanted == 0 {
            return Ok(Vec::new());
        }
        let mut search = Search::new(&self.graph, self.source, targets, wanted, limit);
        while !search.go(PAUSE) {
            asked.pause().await?;
        }
        let statistics = &mut asked.statistics;
        statistics.candidates = self.candidates.len() as u64;
        statistics.edges_kept = self.known.len() as u64;
        statistics.graph_nodes = self.graph.node_count() as u64;
        statistics.rounds += 1;
        statistics.nodes_swept += search.swept;
        statistics.graph_edges += search.links;
        let reached = search.found().iter().map(|found| Reached {
            candidate: self.at.get(&found.node).copied().unwrap_or(usize::MAX),
            length: found.length,
            way: search.way(found),
        });
        let reached = reached.collect();
        asked.clock.lap("graph");
        Ok(reached)
    }
}

/// What a method found.
pub(super) struct Gathered {
    pub(super) local: Local,
    pub(super) reached: Vec<Reached>,
    /// If a budget was used up: the sites that are not there are at least as far away.
    pub(super) at_least: Option<f64>,
}

impl Gathered {
    pub(super) fn all((local, reached): (Local, Vec<Reached>)) -> Self {
        Self {
            local,
            reached,
            at_least: None,
        }
    }

    /// No sites, before a budget was used up.
    pub(super) fn nothing(source: &Place, at_least: f64) -> Self {
        Self {
            local: Local::new(source, None),
            reached: Vec::new(),
            at_least: Some(at_least),
        }
    }
}
