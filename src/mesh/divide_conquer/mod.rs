//! The library's own kernel: divide and conquer over triangles.
//!
//! Input: distinct points in any order. Output: the canonical Delaunay triangulation with adjacency
//! and hull.
//!
//! Sources: Guibas and Stolfi, "Primitives for the manipulation of general subdivisions and the
//! computation of Voronoi diagrams" (1985) for the merge; Dwyer, "A faster divide-and-conquer
//! algorithm for constructing Delaunay triangulations" (1987) for cuts along both axes; Shewchuk,
//! "Triangle" (1996) for triangles with ghosts in place of quad-edges. Departures: cells are halved
//! in space, not by count, so one sort by Morton keys finds all the cuts and no medians are
//! selected; two to four points come from a table of the signs of their tests, and a merge tests
//! with error bounds that hold for all its points; and the circle test is the perturbed one, so the
//! result is canonical without flips afterwards.
//!
//! Every hull edge u → v has a ghost triangle (v, u, ∞) on its outer side. So a set of two
//! points, or a chain of collinear points, is a ring of ghosts like any other hull, and n points
//! always have 2n − 2 triangles, ghosts included. The merge turns ghosts into triangles and back,
//! and makes two new ghosts, one below and one above.

mod arrays;
mod conquer;
mod few;
mod half_edges;
mod hull;
mod merge;

pub(super) use conquer::DivideConquer;
