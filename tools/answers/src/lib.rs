//! Answers to queries of `delaunay-tiles`, and their JSON and GeoJSON.
//!
//! The command `tiletool query` prints them, and the service sends them, so both have the same
//! numbers to the last bit.
//!
//! # Examples
//!
//! ```
//! use delaunay_tiles_answers::ask::Ask;
//! use delaunay_tiles_answers::asked::Asked;
//! use delaunay_tiles_answers::objects;
//! use delaunay_tiles_answers::question::Question;
//!
//! # use delaunay_tiles::input::PointBatch;
//! # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, QueryOptions, TileReader};
//! # fn main() -> anyhow::Result<()> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("town.tiles");
//! # tokio::runtime::Runtime::new()?.block_on(async {
//! # let mut builder = Builder::new(&path, BuildOptions::default())?;
//! # let points = (0..100).map(|i| Point::new(f64::from(i % 10), f64::from(i / 10)));
//! # builder.push(&PointBatch { records: (0..100).collect(), points: points.collect(), z: vec![] }).await?;
//! # builder.finish().await?;
//! let town = TileReader::open(&path, OpenOptions::default()).await?;
//! let question = Question::At(Point::new(3.0, 4.0));
//! let answer = Ask::Locate.answer(&town, question, QueryOptions::default()).await?;
//! let object = objects::object(Asked::new(Ask::Locate, &town, None), &answer);
//! assert_eq!(object["element"], "vertex");
//! # anyhow::Ok(())
//! # })
//! # }
//! ```

pub mod along;
pub mod answer;
pub mod area;
pub mod ask;
pub mod asked;
pub mod height;
pub mod matrix;
pub mod objects;
pub mod profile;
pub mod question;
pub mod units;
pub mod values;
