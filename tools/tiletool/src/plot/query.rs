//! The picture of an answer: obstacles, searched triangles, and results.

use delaunay_tiles::store::TileReader;

use super::base_map::BaseMap;
use super::found;
use super::heading::Heading;
use super::legend::Legend;
use super::map::{Ground, draw_axes, draw_frame};
use super::overlay::Overlay;
use super::page::Page;
use super::scales;
use super::style::LINES;
use super::svg::Svg;

/// Draws the page of an answer.
pub async fn draw(reader: &TileReader, heading: &Heading, overlay: &Overlay, page: &Page) -> anyhow::Result<String> {
    let (base_map, unit) = (BaseMap::gather(reader, page).await?, scales::unit_of(reader).await?);
    let mut svg = Svg::new(page.width, page.height, &heading.title);
    let (mut legend, mut below) = (Legend::default(), Legend::default());
    draw_frame(
        &mut svg,
        page,
        Ground::Colour(base_map.ground()),
        heading.lines(),
        |svg| {
            svg.in_units(&format!("{LINES} stroke-linecap=\"round\""), |svg| {
                base_map.draw(svg, &mut below, &overlay.explored, page);
                found::draw(svg, &mut legend, overlay, &base_map.sites, page);
            });
            found::write(svg, overlay, page);
        },
    );
    draw_axes(&mut svg, page);
    legend.append(below);
    found::add_keys(&mut legend, overlay);
    let [legend_y, ..] = page.footer();
    let lower = legend.draw_within(&mut svg, (page.frame.min_x, legend_y), page.frame.max_x);
    scales::draw(&mut svg, page, lower, unit, None);
    svg.grow(lower as u32);
    Ok(svg.finish())
}
