//! The sites that may be the nearest, and their walking distances.

use std::collections::HashMap;

use crate::geometry::Point;
use crate::query::aimed::{AimedRun, Expectation, Targets};
use crate::query::answer::{Distance, Path, SiteFound, distance};
use crate::query::euclidean::Near;
use crate::query::free_space::QueryPoint;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::store::VertexId;

/// Sites that may be the nearest, by vertex.
pub(super) struct Candidates {
    source: QueryPoint,
    options: QueryOptions,
    expectation: Expectation,
    vertices: Vec<QueryPoint>,
    found: Vec<Found>,
    /// The index of each vertex.
    indices: HashMap<VertexId, usize>,
    /// The free sites, each with the index of its vertex.
    sites: Vec<(usize, Near)>,
    /// The number of triangles that searches have passed.
    passed: u64,
}

/// What is known of the distance of a vertex.
enum Found {
    /// Nothing yet.
    No,
    At(Distance, Option<Path>),
    /// It is too far away, or cannot be reached.
    Never,
}

impl Candidates {
    pub(super) fn new(source: QueryPoint, expectation: Expectation, options: QueryOptions) -> Self {
        Self {
            source,
            options,
            expectation,
            vertices: Vec::new(),
            found: Vec::new(),
            indices: HashMap::new(),
            sites: Vec::new(),
            passed: 0,
        }
    }

    /// Adds a site, unless it is in an obstacle.
    pub(super) async fn add(&mut self, tiles: &mut Tiles, near: Near) -> Result<(), QueryError> {
        let id = near.vertex.id;
        if let Some(&index) = self.indices.get(&id) {
            self.sites.push((index, near));
            return Ok(());
        }
        let vertex = QueryPoint::at_vertex(tiles, near.vertex).await?;
        if vertex.is_free {
            let index = self.vertices.len();
            self.indices.insert(id, index);
            self.vertices.push(vertex);
            self.found.push(Found::No);
            self.sites.push((index, near));
        }
        Ok(())
    }

    /// Returns the number of sites.
    pub(super) fn len(&self) -> usize {
        self.sites.len()
    }

    /// Returns the number of sites whose distance is known.
    pub(super) fn found(&self) -> usize {
        let is_found = |site: &&(usize, Near)| matches!(self.found[site.0], Found::At(..));
        self.sites.iter().filter(is_found).count()
    }

    /// Returns the distance of the `count`-th nearest site, of those whose distance is known;
    /// infinite if there are fewer.
    pub(super) fn length(&self, count: usize) -> f64 {
        let mut lengths: Vec<f64> = self.lengths().collect();
        lengths.sort_by(f64::total_cmp);
        match count.checked_sub(1) {
            None => 0.0,
            Some(last) => lengths.get(last).copied().unwrap_or(f64::INFINITY),
        }
    }

    fn lengths(&self) -> impl Iterator<Item = f64> {
        self.sites.iter().filter_map(|&(index, _)| match &self.found[index] {
            Found::At(distance, _) => Some(distance.value),
            Found::No | Found::Never => None,
        })
    }

    /// Returns a lower bound of the distances of all sites that are not known.
    pub(super) fn bound(&self) -> f64 {
        let unknown = self.vertices.iter().zip(&self.found);
        let unknown = unknown.filter(|(_, found)| matches!(found, Found::No));
        let straight = unknown.map(|(vertex, _)| distance(self.source.point, vertex.point));
        straight.fold(f64::INFINITY, f64::min)
    }

    /// Finds the distances that are not known, as far as they are not more than `limit`. Returns
    /// the tiles, and whether no distance is missing because searches have passed more than `most`
    /// triangles.
    pub(super) async fn reach(
        &mut self,
        tiles: Tiles,
        limit: f64,
        most: u64,
    ) -> Result<(Option<Tiles>, bool), QueryError> {
        let is_wanted: Vec<bool> = self.found.iter().map(|found| matches!(found, Found::No)).collect();
        let wanted = (0..).zip(&is_wanted).filter(|(_, is_wanted)| **is_wanted);
        let points: Vec<Point> = self.vertices.iter().map(|vertex| vertex.point).collect();
        let targets = Targets::new(points, wanted.map(|(index, _)| index));
        let (source, options) = (self.source.clone(), self.options.clone());
        let run = AimedRun::new(
            tiles,
            source,
            &targets,
            &self.vertices,
            is_wanted.clone(),
            self.expectation,
            options,
        );
        let mut run = run.within(limit, most.saturating_sub(self.passed));
        while let Some(reached) = run.next().await? {
            let path = match self.options.paths {
                true => run.path(&reached).await?,
                false => None,
            };
            self.found[reached.0 as usize] = Found::At(run.distance(&reached.1), path);
        }
        self.expectation = run.expectation();
        self.passed = self.passed.saturating_add(run.passed());
        if self.passed > most {
            return Ok((run.into_tiles(), false));
        }
        for (found, _) in self
            .found
            .iter_mut()
            .zip(&is_wanted)
            .filter(|(_, is_wanted)| **is_wanted)
        {
            if matches!(found, Found::No) {
                *found = Found::Never;
            }
        }
        Ok((run.into_tiles(), true))
    }

    /// Returns the sites whose distance is known and at most `limit`, in no order.
    pub(super) fn sites(mut self, limit: f64) -> Vec<SiteFound> {
        let mut sites = Vec::new();
        for (index, near) in self.sites {
            let Found::At(distance, path) = &mut self.found[index] else {
                continue;
            };
            if distance.value > limit {
                continue;
            }
            sites.push(SiteFound {
                number: near.site.unwrap_or_default(),
                id: near.id,
                vertex: near.vertex,
                distance: *distance,
                path: path.clone(),
            });
        }
        sites
    }
}
