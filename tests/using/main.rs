//! What the library promises of finished files: queries, surfaces, map tiles, exports and edits. Each module names a promise.

#![allow(clippy::too_many_lines)]

#[path = "../support/mod.rs"]
mod support;

mod edits;
mod export;
mod heights;
mod map_tiles;
mod overviews;
mod proximity;
mod queries;
mod terrain;
