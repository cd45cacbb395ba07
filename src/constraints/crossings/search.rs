//! The search for pairs of segments that meet.
//!
//! In: segments, and a test of whether and where two of them meet. Out: the pairs that meet, each
//! once.
//!
//! Segments are distributed to the cells of a grid, the segments of each cell to the cells of a
//! grid over that cell, and so on. When few are left, all their pairs are tested. Two segments may
//! share many cells; the pair is found in the cell that contains the point where they meet. Cells
//! do not separate segments most of which pass through all of the contents: the rays at the centre
//! of a star, long parallels, many copies of the same segment. These are swept instead.

use std::ops::ControlFlow;

use crate::constraints::crossings::boxes::bounds;
use crate::constraints::crossings::cells::{Cells, GridChoice};
use crate::constraints::crossings::ends::Ends;
use crate::constraints::crossings::grid::Grid;
use crate::constraints::crossings::pairs::Pairs;
use crate::constraints::crossings::segment_view::SegmentView;
use crate::constraints::crossings::sweep::Sweep;
use crate::geometry::{Point, Rect};

/// Largest number of segments of which all pairs are tested.
const FEW: usize = 40;

/// Largest number of segments of which all pairs are tested if cells do not separate them.
const MANY: usize = 128;

/// Largest number of segments that are copied to be contiguous: they fit in a processor's cache.
const LOCAL: usize = 1 << 13;

/// Largest depth of nested grids. Only nested clusters, each far smaller than the one around it,
/// come near this bound.
const MOST_LEVELS: usize = 64;

/// Finds the pairs of segments that meet in the rectangle `within`.
///
/// `meet` receives the ends of two segments that share no end and whose bounding boxes meet. Its
/// result must not depend on the order or direction of the two. The point that it returns is at
/// most rounded: it is in both bounding boxes and in the rectangle. `meet` also receives the
/// rectangle that matters: if the segments meet elsewhere, it may return `None`.
pub(crate) fn search<S: Ends>(
    segments: &[S],
    within: Rect,
    meet: &impl Fn([Point; 2], [Point; 2], Rect) -> Option<Point>,
    found: &mut impl FnMut(u32, u32, Point) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let numbered = (0..=u32::MAX).zip(segments);
    let near = numbered.filter(|(_, segment)| bounds(segment.ends()).intersects(within));
    let members: Vec<u32> = near.map(|(number, _)| number).collect();
    let view = SegmentView {
        segments,
        originals: None,
    };
    let mut search = PairSearch {
        meet,
        found,
        path: Vec::new(),
        pairs: Pairs::default(),
    };
    search.bucket(view, &members, within)
}

struct PairSearch<'a, M, F> {
    meet: &'a M,
    found: &'a mut F,
    /// The cells around the current bucket, from the outermost.
    path: Vec<(Grid, u32)>,
    pairs: Pairs,
}

impl<M, F> PairSearch<'_, M, F>
where
    M: Fn([Point; 2], [Point; 2], Rect) -> Option<Point>,
    F: FnMut(u32, u32, Point) -> ControlFlow<()>,
{
    /// Finds the pairs that meet in `rect` and in the cells of `path`. Other pairs are not searched
    /// for, but may be tested.
    fn bucket<S: Ends>(&mut self, view: SegmentView<S>, members: &[u32], rect: Rect) -> ControlFlow<()> {
        if members.len() <= FEW {
            return self.all_pairs(view, members, rect);
        }
        if members.len() <= LOCAL && view.originals.is_none() && view.segments.len() > 2 * LOCAL {
            let copies: Vec<[Point; 2]> = members.iter().map(|&member| view.ends(member)).collect();
            let copies = SegmentView {
                segments: &copies,
                originals: Some(members),
            };
            let all: Vec<u32> = (0..members.len() as u32).collect();
            return self.bucket(copies, &all, rect);
        }
        let choice = if self.path.len() < MOST_LEVELS {
            GridChoice::of(view, members, rect, self.path.len())
        } else {
            GridChoice::None
        };
        let cells = match choice {
            GridChoice::Cells(cells) => cells,
            _ if members.len() <= MANY => return self.all_pairs(view, members, rect),
            choice => {
                let sweep = Sweep::new(members.iter().map(|&member| (view.ends(member), member)));
                let cells = match choice {
                    GridChoice::Coarse(grid) if !sweep.is_cheap() => Cells::distribute(grid, view, members),
                    _ => None,
                };
                match cells {
                    Some(cells) if sweep.is_worse_than(cells.iter()) => cells,
                    _ => return self.swept(view, &sweep, rect),
                }
            }
        };
        for (cell, members) in (0..).zip(cells.iter()) {
            if members.len() > 1 {
                self.path.push((cells.grid, cell));
                self.bucket(view, members, cells.grid.rect(cell))?;
                self.path.pop();
            }
        }
        ControlFlow::Continue(())
    }

    fn all_pairs<S: Ends>(&mut self, view: SegmentView<S>, members: &[u32], rect: Rect) -> ControlFlow<()> {
        let mut pairs = std::mem::take(&mut self.pairs);
        let ends = members.iter().map(|&member| view.ends(member));
        let done = pairs.visit(ends, |(one, index), (other, other_index)| {
            let Some(point) = self.meeting(one, other, rect) else {
                return ControlFlow::Continue(());
            };
            let number = |index: u32| view.number(members[index as usize]);
            (self.found)(number(index), number(other_index), point)
        });
        self.pairs = pairs;
        done
    }

    fn swept<S: Ends>(&mut self, view: SegmentView<S>, sweep: &Sweep, rect: Rect) -> ControlFlow<()> {
        sweep.visit(|(one, its), (other, those)| {
            if let Some(point) = self.meeting(one, other, rect) {
                for &member in its {
                    for &other in those {
                        (self.found)(view.number(member), view.number(other), point)?;
                    }
                }
            }
            ControlFlow::Continue(())
        })
    }

    /// Returns the point where two segments meet, if it is in this bucket.
    #[inline]
    fn meeting(&self, one: [Point; 2], other: [Point; 2], rect: Rect) -> Option<Point> {
        let point = (self.meet)(one, other, rect)?;
        let is_here = self.path.iter().all(|(grid, cell)| grid.cell_of(point) == *cell);
        is_here.then_some(point)
    }
}
