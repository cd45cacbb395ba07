//! Triangulators, and how each is run.

use std::collections::HashSet;
use std::fmt;

use clap::ValueEnum;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::mesh::{Engine, EngineKind, Triangulation};
use distributions::Kind;
use spade::Triangulation as _;

use super::incremental::{Incremental, Order};

/// The distributions that are measured.
pub const KINDS: [Kind; 5] = [
    Kind::Uniform,
    Kind::Kuzmin,
    Kind::LineSingularity,
    Kind::Grid,
    Kind::Lidar,
];

/// One set of distinct points, in the types of all triangulators.
pub struct Input {
    /// The points for the engines of this library.
    pub points: Vec<Point>,
    /// The points for spade.
    pub spade: Vec<spade::Point2<f64>>,
    /// The points for delaunator.
    pub delaunator: Vec<delaunator::Point>,
}

impl Input {
    /// Creates an input of the first `n` points of a distribution, without duplicates.
    #[must_use]
    pub fn new(kind: Kind, n: u64) -> Self {
        let mut seen = HashSet::new();
        let points: Vec<_> = distributions::points(kind, n, 1)
            .map(|[x, y]| Point::new(x, y).normalized())
            .filter(|p| seen.insert([p.x.to_bits(), p.y.to_bits()]))
            .collect();
        Self {
            spade: points.iter().map(|p| spade::Point2::new(p.x, p.y)).collect(),
            delaunator: points.iter().map(|p| delaunator::Point { x: p.x, y: p.y }).collect(),
            points,
        }
    }
}

/// A triangulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Peer {
    /// The library's own kernel, divide and conquer.
    Native,
    /// Crate spade, its bulk load unchanged: without the flips that make the library's engine
    /// `spade` canonical.
    Spade,
    /// Crate delaunator.
    Delaunator,
    /// Incremental insertion in random rounds.
    Brio,
    /// Incremental insertion along one Hilbert curve.
    Hilbert,
}

impl Peer {
    /// All triangulators.
    pub const ALL: [Self; 5] = [Self::Native, Self::Spade, Self::Delaunator, Self::Brio, Self::Hilbert];
}

impl fmt::Display for Peer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Native => "native",
            Self::Spade => "spade",
            Self::Delaunator => "delaunator",
            Self::Brio => "brio",
            Self::Hilbert => "hilbert",
        })
    }
}

/// A triangulator with the memory that it keeps between runs. Only engines of the library's kind
/// keep any.
pub enum Contender {
    /// An engine, and its result.
    Engine(Box<dyn Engine>, Triangulation),
    /// Crate spade.
    Spade,
    /// Crate delaunator.
    Delaunator,
}

/// The result of a run, which the caller drops outside the measurement.
pub enum Outcome {
    /// The number of triangles; the contender keeps the arrays.
    Kept(usize),
    /// The result of spade.
    Spade(spade::DelaunayTriangulation<spade::Point2<f64>>),
    /// The result of delaunator.
    Delaunator(delaunator::Triangulation),
}

impl Contender {
    /// Creates a triangulator without memory from earlier runs.
    #[must_use]
    pub fn new(peer: Peer) -> Self {
        let engine: Box<dyn Engine> = match peer {
            Peer::Native => EngineKind::Native.create(),
            Peer::Brio => Box::new(Incremental::new(Order::Brio)),
            Peer::Hilbert => Box::new(Incremental::new(Order::Hilbert)),
            Peer::Spade => return Self::Spade,
            Peer::Delaunator => return Self::Delaunator,
        };
        Self::Engine(engine, Triangulation::default())
    }

    /// Triangulates; `owned` is a copy of the input's points for spade, which consumes them.
    pub fn run(&mut self, input: &Input, owned: Vec<spade::Point2<f64>>) -> Outcome {
        match self {
            Self::Engine(engine, mesh) => {
                engine.triangulate(&input.points, mesh);
                Outcome::Kept(mesh.triangles.len())
            }
            Self::Spade => Outcome::Spade(
                spade::DelaunayTriangulation::bulk_load(owned).expect("the points are within the limits of spade"),
            ),
            Self::Delaunator => Outcome::Delaunator(delaunator::triangulate(&input.delaunator)),
        }
    }

    /// Returns the copy that [`run`](Self::run) needs.
    #[must_use]
    pub fn owned(&self, input: &Input) -> Vec<spade::Point2<f64>> {
        match self {
            Self::Spade => input.spade.clone(),
            _ => Vec::new(),
        }
    }
}

impl Outcome {
    /// Returns the number of triangles.
    #[must_use]
    pub fn triangles(&self) -> usize {
        match self {
            Self::Kept(triangles) => *triangles,
            Self::Spade(spade) => spade.num_inner_faces(),
            Self::Delaunator(delaunator) => delaunator.len(),
        }
    }
}
