//! The promise: what is asked of the surface is exact, and the same whatever the tiles, the threads
//! and the memory.

mod contours;
mod contours_cut;
mod peeling;
mod profiles;
mod rasters;
mod volumes;
mod z;
