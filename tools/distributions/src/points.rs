//! Maps a kind to its points.

use std::iter::FusedIterator;

use crate::Kind;
use crate::circle::Circle;
use crate::degenerate::{FourLines, Grid, Line, NearlyCollinear, Parabola};
use crate::scattered::{Clusters, Duplicates, Kuzmin, LineSingularity, Uniform};
use crate::source::Source;
use crate::surveyed::{Contours, Lidar, Streets, Tracks};

/// Returns the first `n` points of a kind and seed: exactly `n`, each x and y finite, the same in
/// every call.
///
/// For some kinds the first points depend on `n`, which is the size of the whole set.
pub fn points(kind: Kind, n: u64, seed: u64) -> Points {
    Points {
        source: Sources::new(kind, n, seed),
        left: n,
    }
}

/// Returns the points of [`points`] with z: the terrain's height for [`Kind::Lidar`], 0 for all
/// others.
pub fn points3(kind: Kind, n: u64, seed: u64) -> Points3 {
    Points3(points(kind, n, seed))
}

/// Iterator of [`points`].
#[derive(Clone, Debug)]
pub struct Points {
    source: Sources,
    left: u64,
}

/// Iterator of [`points3`].
#[derive(Clone, Debug)]
pub struct Points3(Points);

macro_rules! sources {
    ($($kind:ident($source:ty) = $new:expr),* $(,)?) => {
        #[derive(Clone, Debug)]
        enum Sources { $($kind($source)),* }

        impl Sources {
            fn new(kind: Kind, n: u64, seed: u64) -> Self {
                match kind { $(Kind::$kind => Sources::$kind($new(n, seed))),* }
            }

            #[inline]
            fn next(&mut self) -> [f64; 2] {
                match self { $(Sources::$kind(source) => source.next()),* }
            }
        }
    };
}

sources! {
    Uniform(Uniform) = |_, seed| Uniform::new(seed),
    Kuzmin(Kuzmin) = |_, seed| Kuzmin::new(seed),
    LineSingularity(LineSingularity) = |_, seed| LineSingularity::new(seed),
    Grid(Grid) = |n, seed| Grid::new(n, seed, 0.0, 1.0),
    Lidar(Box<Lidar>) = |n, seed| Box::new(Lidar::new(n, seed)),
    Circle(Circle) = Circle::new,
    Parabola(Parabola) = Parabola::new,
    Line(Line) = Line::new,
    FourLines(FourLines) = FourLines::new,
    Clusters(Clusters) = |_, seed| Clusters::new(seed),
    Duplicates(Duplicates) = Duplicates::new,
    Contours(Contours) = Contours::new,
    Streets(Streets) = Streets::new,
    Tracks(Tracks) = |_, seed| Tracks::new(seed),
    Offset(Grid) = |n, seed| Grid::new(n, seed, 1e6, 1e-3),
    NearlyCollinear(NearlyCollinear) = |_, seed| NearlyCollinear::new(seed),
}

impl Iterator for Points {
    type Item = [f64; 2];

    #[inline]
    fn next(&mut self) -> Option<[f64; 2]> {
        self.left = self.left.checked_sub(1)?;
        Some(self.source.next())
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        hint(self.left)
    }
}

impl Iterator for Points3 {
    type Item = [f64; 3];

    #[inline]
    fn next(&mut self) -> Option<[f64; 3]> {
        let [x, y] = self.0.next()?;
        let z = match &mut self.0.source {
            Sources::Lidar(lidar) => lidar.height(x, y),
            _ => 0.0,
        };
        Some([x, y, z])
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.0.size_hint()
    }
}

impl FusedIterator for Points {}
impl FusedIterator for Points3 {}

/// Returns the size hint of an iterator with exactly `left` items left.
pub(crate) fn hint(left: u64) -> (usize, Option<usize>) {
    (usize::try_from(left).unwrap_or(usize::MAX), usize::try_from(left).ok())
}
