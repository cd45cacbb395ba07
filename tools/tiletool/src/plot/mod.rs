//! Maps: the cells of the tiles over the triangulation, as SVG or PNG.
//!
//! The input is an open tile file. The output is a picture that appears under its name only when it
//! is complete. All of the file is drawn: a small one line by line, and a large one, which may exceed
//! memory, tile by tile into the pixels of an image. If there is z, an image of it is the ground.

mod args;
pub mod axis;
mod base_map;
mod distances;
mod file;
mod found;
mod heading;
mod image;
mod ink;
mod labels;
mod layers;
pub mod legend;
pub mod map;
mod overlay;
pub mod page;
pub mod png;
mod query;
mod relief;
mod scales;
pub mod scene;
pub mod style;
pub mod svg;
mod widths;

use std::path::Path;

use delaunay_tiles::peak_memory;
use delaunay_tiles::store::TileReader;
use resvg::tiny_skia::Pixmap;
use serde::Serialize;

use crate::common::{bytes, counted, file_name};
pub use args::TitleArgs;
use file::PictureFormat;
pub use file::PlotFile;
use heading::Heading;
use layers::Layers;
use legend::Legend;
use map::{Ground, Map};
pub use overlay::{Mark, Overlay, Piece, Way};
use page::Page;
use relief::Relief;
use scene::Scene;
use style::{PAPER, rgb};

/// A report about a drawn map. Its field names are stable keys of `--json`.
#[derive(Serialize)]
pub struct Plotted {
    file: String,
    bytes: u64,
    width: u32,
    height: u32,
    vertices: u64,
    triangles: u64,
    peak_memory_bytes: Option<u64>,
}

impl Plotted {
    /// Returns the report for people, as one line.
    pub fn report(&self) -> String {
        let vertices = counted(self.vertices, "vertex", "vertices");
        let (width, height) = (self.width, self.height);
        format!(
            "{}: {width} x {height} pixels, {}, {vertices}\n",
            self.file,
            bytes(self.bytes)
        )
    }
}

/// Returns how much of the memory that a command may use is for the reader of a file that is drawn; the
/// rest is for pixels. Too little memory for both is all for the reader, so that its errors name it.
pub fn memory_of_reader(memory: u64) -> u64 {
    const MEBIBYTE: u64 = 1 << 20;
    match memory > 16 * MEBIBYTE {
        true => memory - (memory / 3).min(24 * MEBIBYTE),
        false => memory,
    }
}

/// Draws a map of a tile file.
///
/// # Errors
/// Fails if the file cannot be read or is damaged, if the memory does not suffice, or if the map
/// cannot be written.
pub async fn draw(reader: &TileReader, file: &PlotFile) -> anyhow::Result<Plotted> {
    let directory = reader.directory().await?;
    let page = Page::new(directory.metadata.bounds)?;
    let name = file_name(Path::new(reader.name()));
    let relief = Relief::gather(reader, &page).await?;
    let heights = relief.as_ref().and_then(Relief::heights);
    let mut ground = match (relief, heights) {
        (Some(relief), Some(heights)) => Some(relief.image(heights, rgb(PAPER))?),
        _ => None,
    };
    let mut legend = Legend::default();
    let scene = Scene::gather(reader).await?;
    let (vertices, triangles) = match &scene {
        Some(scene) => (scene.points.len() as u64, scene.triangles),
        None => {
            let layers = Layers::gather(reader, &page).await?;
            let mut image = ground.map_or_else(|| image::blank(page.pixels(), rgb(PAPER)), Ok)?;
            layers.paint(&mut image, heights.is_some(), &mut legend);
            ground = Some(image);
            layers.counts()
        }
    };
    let map = Map {
        heading: &Heading::new(&name, file.title.as_deref(), &map::subtitle(&directory)),
        directory: &directory,
        page: &page,
        unit: scales::unit_of(reader).await?,
        scene: scene.as_ref(),
        heights,
    };
    let (picture, height) = picture(&map, ground, file.format, legend)?;
    let bytes = file.save(&picture)?;
    Ok(Plotted {
        file: file.path.display().to_string(),
        bytes,
        width: page.width,
        height,
        vertices,
        triangles,
        peak_memory_bytes: peak_memory(),
    })
}

/// Draws a map, over an image of its frame if there is one. Returns the picture and its height.
fn picture(map: &Map, image: Option<Pixmap>, format: PictureFormat, legend: Legend) -> anyhow::Result<(Vec<u8>, u32)> {
    let Some(image) = image else {
        let (svg, height) = map.draw(Ground::Colour(PAPER), legend);
        return Ok((format.encode(svg)?, height));
    };
    match format {
        PictureFormat::Svg => {
            let reference = image::data_url(&image)?;
            drop(image);
            let (svg, height) = map.draw(Ground::Image(&reference), legend);
            Ok((svg.into_bytes(), height))
        }
        PictureFormat::Png => {
            let corner = (map.page.frame.min_x as i32, map.page.frame.min_y as i32);
            let (svg, height) = map.draw(Ground::Beneath, legend);
            Ok((png::render(&svg, Some((image, corner)))?, height))
        }
    }
}

/// Returns the bytes of a picture whose name ends in `.svg` or `.png`.
pub fn encode(name: &Path, svg: String) -> anyhow::Result<Vec<u8>> {
    PlotFile::new(name.to_owned())?.format.encode(svg)
}

/// Draws the answer to a query.
pub async fn draw_query(reader: &TileReader, file: &PlotFile, overlay: &Overlay) -> anyhow::Result<()> {
    let m = reader.metadata();
    let whole = (overlay.shows_all && m.vertices <= scene::MAX_DRAWN).then_some(m.bounds);
    let page = Page::new(overlay.window(m.bounds, whole))?;
    let name = file_name(Path::new(reader.name()));
    let heading = Heading::new(&name, file.title.as_deref(), &overlay.title);
    let svg = query::draw(reader, &heading, overlay, &page).await?;
    file.save(&file.format.encode(svg)?)?;
    Ok(())
}
