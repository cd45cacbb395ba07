//! The sources, which open files and produce batches of their records.

mod edges;
mod lines;
mod points;
mod poly;
mod row_file;
mod sites;
mod stream;

pub use lines::{LineOrigin, SegmentSource};
pub use points::PointSource;
pub use poly::PolySource;
pub use row_file::RowFile;
pub use sites::SiteSource;
pub use stream::Source;
