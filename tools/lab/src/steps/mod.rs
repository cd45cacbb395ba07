//! `lab steps`: pictures of divide, conquer, merge, constrain and of a query, for
//! docs/how_it_works.md.
//!
//! The input is islands, as GeoJSON. The library builds tile files from their coast lines and from
//! points between them; the pictures show what stands in these files, and what the in-core engine
//! and the certificate say of each cell. The same input gives the same bytes.
//!
//! ```text
//!   ground ──▶ stages, walk ──▶ pictures ──▶ sheet
//!   points     tile files       layers       SVG
//! ```

mod ground;
mod pictures;
mod sheet;
mod stages;
#[cfg(test)]
mod tests;
mod triangles;
mod walk;

use std::path::PathBuf;

use clap::Args;

use crate::folder::Folder;
use crate::work;
use ground::Ground;
use stages::Stages;
use walk::Walk;

/// Draw how a triangulation is built, step by step: the pictures of docs/how_it_works.md.
///
/// Builds the islands from Bali to Sumbawa and random points around them in small tiles, and draws
/// the cells, the triangulation of each cell alone, the merged triangulation, the constraints, and
/// a shortest path with the tiles that it uses. Writes five pictures. The same file gives the same
/// bytes.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example, in the root of the repository:
  lab steps -o docs/pictures")]
pub struct StepsArgs {
    /// The coast lines, as GeoJSON
    #[arg(default_value = "tests/data/indonesia/indonesia_ne10m.geojson")]
    file: PathBuf,
    /// The folder for the pictures
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Draws the pictures, and writes them.
pub fn run(args: &StepsArgs) -> anyhow::Result<()> {
    let ground = Ground::read(&args.file)?;
    let mut folder = Folder::create(&args.output)?;
    let scratch = folder.scratch().to_owned();
    let drawn = work::block_on(async {
        let stages = Stages::build(&ground, &scratch).await?;
        let walk = Walk::take(&ground, &scratch).await?;
        Ok(pictures::draw(&stages, &walk))
    })?;
    for (name, svg) in drawn {
        folder.keep_picture(name, svg)?;
    }
    folder.publish()
}
