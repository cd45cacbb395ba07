//! Distribution of the segments of a bucket to the cells of a grid.

use crate::constraints::crossings::boxes::{bounds, common};
use crate::constraints::crossings::ends::Ends;
use crate::constraints::crossings::grid::{CellRange, Extents, Grid};
use crate::constraints::crossings::segment_view::SegmentView;
use crate::geometry::{Point, Rect};

/// Largest fraction of all pairs that may remain within cells. Above it, a grid is not worthwhile.
const FEW_PAIRS: f64 = 0.25;

/// Largest average number of cells per segment. Above it, a grid is not worthwhile.
const MOST_COPIES: usize = 8;

/// Number of segments that are sampled to find where most segments are.
const SAMPLE: usize = 128;

/// Smallest number of segments from which a sample is taken.
const SAMPLED_FROM: usize = 1024;

/// Number of levels of nested grids that use samples. It is limited, since a sample may be
/// misleading.
const SAMPLED_LEVELS: usize = 8;

/// The result of choosing a grid that separates the segments of a bucket.
pub(crate) enum GridChoice {
    /// A grid separates them; these are its cells.
    Cells(Cells),
    /// Most segments are too long to be separated. This coarse grid may separate some from others.
    Coarse(Grid),
    /// The segments are too close together for any grid.
    None,
}

/// The members of a bucket, grouped by the cells of a grid.
pub(crate) struct Cells {
    pub(crate) grid: Grid,
    /// The start of each cell's members in `members`, and the end of the last cell's members.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl GridChoice {
    /// Distributes segments to the cells of a grid if that is worthwhile.
    pub(crate) fn of<S: Ends>(view: SegmentView<S>, members: &[u32], rect: Rect, level: usize) -> Self {
        if members.len() >= SAMPLED_FROM && level < SAMPLED_LEVELS {
            let sample = || sample(members, level).map(|member| view.ends(member));
            let extents = Extents::measure(sample(), rect, core(sample(), rect));
            let extents = Extents {
                contents: rect,
                ..extents
            };
            if let Some(cells) = Cells::with_few_pairs(&extents, view, members) {
                return Self::Cells(cells);
            }
        }
        let extents = Extents::measure(members.iter().map(|&member| view.ends(member)), rect, rect);
        if let Some(cells) = Cells::with_few_pairs(&extents, view, members) {
            Self::Cells(cells)
        } else {
            Grid::coarse(&extents).map_or(Self::None, Self::Coarse)
        }
    }
}

impl Cells {
    fn with_few_pairs<S: Ends>(extents: &Extents, view: SegmentView<S>, members: &[u32]) -> Option<Self> {
        let (grid, pairs) = Grid::new(extents, members.len())?;
        if pairs > FEW_PAIRS {
            return None;
        }
        Self::distribute(grid, view, members)
    }

    /// Distributes segments to the cells of a grid. Returns `None` if they are in too many cells.
    pub(crate) fn distribute<S: Ends>(grid: Grid, view: SegmentView<S>, members: &[u32]) -> Option<Self> {
        // Holds counts first, then the end of each cell (prefix sums). Filling the cells backwards
        // turns each end into a start.
        let mut starts = vec![0u32; grid.cells() as usize + 1];
        let mut ranges: Vec<CellRange> = Vec::with_capacity(members.len());
        let most = MOST_COPIES.saturating_mul(members.len()).min(u32::MAX as usize);
        let mut total = 0;
        for &member in members {
            let ends = view.ends(member);
            let range = grid.range(ends);
            grid.visit(
                range,
                || ends,
                |cell| {
                    starts[cell as usize] += 1;
                    total += 1;
                },
            );
            if total > most {
                return None;
            }
            ranges.push(range);
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut sorted = vec![0; sum as usize];
        for (&member, range) in members.iter().zip(ranges).rev() {
            grid.visit(
                range,
                || view.ends(member),
                |cell| {
                    let slot = &mut starts[cell as usize];
                    *slot -= 1;
                    sorted[*slot as usize] = member;
                },
            );
        }
        Some(Self {
            grid,
            starts,
            members: sorted,
        })
    }

    /// Returns the members of each cell.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let ranges = self.starts.windows(2);
        ranges.map(|range| &self.members[range[0] as usize..range[1] as usize])
    }
}

/// Returns a pseudo-random sample of the members, a different one at each level.
fn sample(members: &[u32], level: usize) -> impl Iterator<Item = u32> {
    // Multiples of the golden ratio are spread evenly.
    const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
    (0..SAMPLE as u64).map(move |number| {
        let hash = (number + (level * SAMPLE) as u64).wrapping_mul(STEP);
        members[((u128::from(hash) * members.len() as u128) >> 64) as usize]
    })
}

/// Returns a rectangle around most of the segments of a sample, and not much larger. Outliers and
/// the empty space around clusters must not make the cells so large that nearly all segments are in
/// one.
fn core(sample: impl Iterator<Item = [Point; 2]>, rect: Rect) -> Rect {
    let parts = sample
        .map(|ends| common(bounds(ends), rect))
        .filter(|part| !part.is_empty());
    let centre = |part: Rect| ((part.min_x + part.max_x) / 2.0, (part.min_y + part.max_y) / 2.0);
    let (mut x, mut y): (Vec<f64>, Vec<f64>) = parts.map(centre).unzip();
    if x.is_empty() {
        return rect;
    }
    let range = |values: &mut Vec<f64>| {
        values.sort_unstable_by(f64::total_cmp);
        let (low, high) = (values[values.len() / 10], values[values.len() * 9 / 10]);
        [low - (high - low), high + (high - low)]
    };
    let ([min_x, max_x], [min_y, max_y]) = (range(&mut x), range(&mut y));
    Rect::new(min_x, min_y, max_x, max_y)
}
