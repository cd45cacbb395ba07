//! Shapefile: the geometries in the `.shp` file. Source: ESRI Shapefile Technical Description, 1998.
//!
//! In: the `.shp` file, and where they are beside it, `.prj` for the coordinate reference system and
//! `.dbf` for ids. `.shx` is not needed, since records are read in their order in the file.
//!
//! The crate `shapefile` decodes the records. Its `ShapeReader` is not used, because it allocates
//! according to counts in the file; here each record is read as a whole and checked before. Its
//! polygons are not used either: it takes the directions of rings by rounded areas.

mod beside;
mod reader;
mod record;
mod rings;

pub use reader::open;
