//! The candidates and obstacle edges that a method has collected, as a local visibility graph.

use foldhash::{HashMap, HashMapExt, HashSet, HashSetExt};

use super::context::QueryContext;
use super::graph::{LocalGraph, VisibilitySearch};
use super::obstacles::ObstacleEdge;
use crate::geometry::Point;
use crate::query::answer::WayPoint;
use crate::query::free_space::{Position, QueryPoint};
use crate::query::request::QueryError;
use crate::store::{Vertex, VertexId};

/// A vertex with sites.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) vertex: Vertex,
    /// The number and id of each site.
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

/// The number of sweeps after which the search yields to other tasks.
const PAUSE: u64 = 64;

/// Candidates and obstacle edges round a source.
pub(super) struct Local {
    graph: LocalGraph,
    known: HashSet<[VertexId; 2]>,
    /// Points inside an edge.
    on_edges: Vec<([VertexId; 2], Point)>,
    source: u32,
    pub(super) candidates: Vec<Candidate>,
    at: HashMap<u32, usize>,
    /// The node of the target of a path.
    target: Option<u32>,
    /// Vertices whose edges are all known.
    complete: HashSet<VertexId>,
}

fn sorted([a, b]: [VertexId; 2]) -> [VertexId; 2] {
    if a < b { [a, b] } else { [b, a] }
}

impl Local {
    /// Creates a graph with a source, and with a target if a path is wanted.
    pub(super) fn new(source: &QueryPoint, target: Option<&QueryPoint>) -> Self {
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
        this.source = this.add_node(source);
        this.target = target.map(|target| this.add_node(target));
        this
    }

    fn add_node(&mut self, point: &QueryPoint) -> u32 {
        if let Position::Edge { ends } = point.position {
            self.on_edges.push((sorted(ends.map(|end| end.id)), point.point));
        }
        self.graph.node((point.point, point.vertex()))
    }

    /// Adds an edge. Returns `false` if it is known already.
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
        for subsegment in points.windows(2) {
            self.graph.add_edge([subsegment[0], subsegment[1]], edge.free);
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

    /// Returns whether all edges of a vertex are noted as known.
    pub(super) fn is_complete(&self, vertex: VertexId) -> bool {
        self.complete.contains(&vertex)
    }

    /// Returns the number of sites at all candidates.
    pub(super) fn site_count(&self) -> usize {
        self.candidates.iter().map(|candidate| candidate.sites.len()).sum()
    }

    /// Returns the nearest candidates with `wanted` sites in total, within a limit, and all
    /// candidates that are as far away as the last one.
    pub(super) async fn nearest(
        &self,
        wanted: usize,
        limit: f64,
        context: &mut QueryContext,
    ) -> Result<Vec<Reached>, QueryError> {
        let targets = self
            .candidates
            .iter()
            .map(|candidate| (candidate.node, candidate.sites.len()));
        self.search(targets.collect(), wanted, limit, context).await
    }

    /// Returns the target of a path, if it can be reached within a limit.
    pub(super) async fn target(&self, limit: f64, context: &mut QueryContext) -> Result<Option<Reached>, QueryError> {
        let target = self.target.map(|target| (target, 1));
        let found = self.search(target.into_iter().collect(), 1, limit, context).await;
        found.map(|mut found| found.pop())
    }

    async fn search(
        &self,
        targets: Vec<(u32, usize)>,
        wanted: usize,
        limit: f64,
        context: &mut QueryContext,
    ) -> Result<Vec<Reached>, QueryError> {
        context.clock.lap("collect");
        if wanted == 0 {
            return Ok(Vec::new());
        }
        let mut search = VisibilitySearch::new(&self.graph, self.source, targets, wanted, limit);
        while !search.go(PAUSE) {
            context.pause().await?;
        }
        let statistics = &mut context.statistics;
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
        context.clock.lap("graph");
        Ok(reached)
    }
}

/// What a method found.
pub(super) struct Gathered {
    pub(super) local: Local,
    pub(super) reached: Vec<Reached>,
    /// If a limit was reached: a lower bound of the distances of the missing sites.
    pub(super) lower_bound: Option<f64>,
}

impl Gathered {
    pub(super) fn all((local, reached): (Local, Vec<Reached>)) -> Self {
        Self {
            local,
            reached,
            lower_bound: None,
        }
    }

    /// Returns a result without sites, for a limit that was reached before any was found.
    pub(super) fn nothing(source: &QueryPoint, lower_bound: f64) -> Self {
        Self {
            local: Local::new(source, None),
            reached: Vec::new(),
            lower_bound: Some(lower_bound),
        }
    }
}
