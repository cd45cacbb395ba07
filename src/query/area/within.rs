//! Queries for areas.

use std::collections::VecDeque;

use futures::stream::Stream;

use super::cover::AreaCover;
use super::piece::AreaPiece;
use crate::geometry::Point;
use crate::query::request::{QueryError, QueryOptions, unfold};
use crate::query::wavefront::{Goal, QueryPoints, WavefrontRun};
use crate::store::TileReader;

/// Returns the radius that counts: none if it is negative or not a number.
fn valid(radius: f64) -> f64 {
    if radius > 0.0 {
        radius.min(Point::MAX_MAGNITUDE)
    } else {
        0.0
    }
}

/// The area within a walking distance.
impl TileReader {
    /// Returns the area within a walking distance of `at`, in pieces, roughly nearest first. A
    /// point is in the area if and only if it is in a piece. The pieces of one root do not overlap;
    /// those of different roots may. There are pieces outside the hull, too, if the outside is
    /// free.
    ///
    /// If `radius` is negative or not a number, there are no pieces. A radius above
    /// [`Point::MAX_MAGNITUDE`] counts as that. The stream ends, and its limits apply, as for
    /// [`nearest_sites`](Self::nearest_sites). The pieces that come before a limit is reached are a
    /// part of the area.
    ///
    /// [Examples](crate::query#examples).
    pub fn area_within(
        &self,
        at: Point,
        radius: f64,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<AreaPiece, QueryError>> + Send + Unpin + 'static + use<> {
        let (reader, radius) = (self.clone(), valid(radius));
        let start = async move {
            let goal = Goal::Points(QueryPoints::new([]));
            let mut run = WavefrontRun::from_point(&reader, at, goal, radius, options).await?;
            run.keep_regions();
            Ok((run, VecDeque::new()))
        };
        unfold(
            start,
            move |(mut run, mut pieces): (WavefrontRun, VecDeque<AreaPiece>)| async move {
                loop {
                    if let Some(piece) = pieces.pop_front() {
                        return Ok(Some((piece, (run, pieces))));
                    }
                    let Some(regions) = run.next_regions().await? else {
                        return Ok(None);
                    };
                    pieces.extend(regions.into_iter().filter_map(|region| {
                        let (root, walked) = run.root_at(region.root);
                        AreaPiece::of(region, root, walked, radius)
                    }));
                }
            },
        )
    }

    /// Adds the area within a walking distance of `at` to an empty cover, which gives it as
    /// [polygons](AreaCover::polygons). Triangles that lie in the area as a whole have no pieces, so
    /// this is faster than uniting those of [`area_within`](Self::area_within).
    ///
    /// # Errors
    /// As for [`area_within`](Self::area_within). If a limit is reached, the cover has what was
    /// found until then, which is a part of the area.
    ///
    /// [Examples](crate::query#examples).
    pub async fn cover_area(
        &self,
        at: Point,
        radius: f64,
        options: QueryOptions,
        cover: &mut AreaCover,
    ) -> Result<(), QueryError> {
        let radius = valid(radius);
        let goal = Goal::Points(QueryPoints::new([]));
        let mut run = WavefrontRun::from_point(self, at, goal, radius, options).await?;
        run.keep_regions();
        run.wavefront.keep_whole();
        cover.set_radius(radius);
        loop {
            let goes_on = run.go_further().await;
            for triangle in run.wavefront.take_whole() {
                cover.add_whole(triangle);
            }
            for region in run.wavefront.take_regions() {
                let (root, walked) = run.root_at(region.root);
                let triangle = region.triangle();
                if let Some(piece) = AreaPiece::of(region, root, walked, radius) {
                    cover.add_piece(triangle, piece);
                }
            }
            if !goes_on? {
                cover.complete();
                return Ok(());
            }
        }
    }
}
