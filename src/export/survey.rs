//! What an export will write, found in a pass before it where the directory does not say it: how many
//! elements, and their bounds.

use futures::stream::StreamExt;

use super::error::ExportError;
use super::numbering::Numbering;
use super::output::ExportJob;
use super::what::CutBy;
use crate::geometry::{Point, VertexIndex};
use crate::store::{Needs, Tile};

/// The least and greatest x, y and z of some vertices; z is 0 where a file has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) min: [f64; 3],
    pub(super) max: [f64; 3],
}

impl Bounds {
    pub(super) const EMPTY: Self = Self {
        min: [f64::INFINITY; 3],
        max: [f64::NEG_INFINITY; 3],
    };

    #[cfg(any(feature = "flatgeobuf", feature = "parquet"))]
    pub(super) fn is_empty(&self) -> bool {
        self.min[0] > self.max[0]
    }

    pub(super) fn include(&mut self, position: [f64; 3]) {
        for ((min, max), at) in self.min.iter_mut().zip(&mut self.max).zip(position) {
            *min = min.min(at);
            *max = max.max(at);
        }
    }

    pub(super) fn union(&mut self, other: &Self) {
        self.min = [0, 1, 2].map(|axis| self.min[axis].min(other.min[axis]));
        self.max = [0, 1, 2].map(|axis| self.max[axis].max(other.max[axis]));
    }
}

/// The elements that an export writes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Survey {
    pub(super) count: u64,
    pub(super) bounds: Bounds,
}

impl Survey {
    fn of(numbering: &Numbering, tile: &Tile, by: CutBy) -> Self {
        let mut survey = Self {
            count: 0,
            bounds: Bounds::EMPTY,
        };
        let mut add = |corners: &[VertexIndex]| {
            survey.count += 1;
            for &corner in corners {
                let Point { x, y } = tile.point(corner);
                survey.bounds.include([x, y, tile.z(corner).unwrap_or(0.0)]);
            }
        };
        match by {
            CutBy::Triangles => {
                let surface = numbering.surface().in_tile(tile);
                let written = tile.triangle_ids().filter(|&t| numbering.is_written(tile, &surface, t));
                written.for_each(|triangle| add(&tile.corners(triangle)));
            }
            CutBy::Vertices => tile.vertex_indices().for_each(|vertex| add(&[vertex])),
            CutBy::Points => {
                let written = tile.vertex_indices().filter(|&v| numbering.writes_point(tile, v));
                written.for_each(|vertex| add(&[vertex]));
            }
            CutBy::Edges => {
                let written = tile.owned_constraints().filter(|&e| numbering.writes_edge(tile, e));
                written.for_each(|edge| add(&tile.corners_of_edge(edge)));
            }
        }
        survey
    }
}

impl ExportJob<'_> {
    /// Returns the number of elements that will be written, by a survey if the directory does not say
    /// it. `passes` more passes follow.
    pub(super) async fn counted(&mut self, by: CutBy, passes: u64) -> Result<u64, ExportError> {
        let known = self.count(by);
        self.passes(passes + u64::from(known.is_none()));
        match known {
            Some(count) => Ok(count),
            None => Ok(self.survey(by).await?.count),
        }
    }

    /// Counts, in a pass, the elements that will be written, and finds their bounds.
    pub(super) async fn survey(&mut self, by: CutBy) -> Result<Survey, ExportError> {
        let numbering = self.numbering.clone();
        let needs = match by {
            CutBy::Triangles => numbering.surface().needs(),
            CutBy::Vertices | CutBy::Points | CutBy::Edges => Needs::default(),
        };
        let work = move |tile: crate::store::TileInPass| Survey::of(&numbering, &tile, by);
        let mut surveys = self.reader().for_each_tile(needs, work)?;
        let mut all = Survey {
            count: 0,
            bounds: Bounds::EMPTY,
        };
        while let Some(survey) = surveys.next().await {
            let survey = survey?;
            all.count += survey.count;
            all.bounds.union(&survey.bounds);
            self.advance();
        }
        self.expect(by, all.count)?;
        Ok(all)
    }
}
