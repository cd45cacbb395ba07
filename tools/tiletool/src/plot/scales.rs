//! The scales below a map: a bar of a round length, and the heights that colours mean.

use delaunay_tiles::crs::{Crs, Unit};
use delaunay_tiles::store::TileReader;
use delaunay_tiles::terrain::shading::RAMP;
use delaunay_tiles_answers::units::{Measure, number, unit};

use super::axis::{label, round_above, text_width};
use super::page::Page;
use super::relief::Heights;
use super::style::{GREY, INK, fill};
use super::svg::{Anchor, Svg};

const TEXT: f64 = 15.0;
/// Minimum length of the bar in pixels. It is less than 2.5 times as long.
const SHORTEST: f64 = 110.0;
/// Width of the colours in pixels.
const COLOURS: f64 = 220.0;
/// Pixels between the bar and the heights.
const GAP: f64 = 56.0;

/// Returns the unit of the coordinates of a file.
pub async fn unit_of(reader: &TileReader) -> anyhow::Result<Unit> {
    let crs = reader.crs().await?;
    Ok(unit(crs.as_deref().map(Crs::new).as_ref()))
}

/// Draws the scales of a page whose coordinates are in a unit, `lower` pixels below their place.
pub fn draw(svg: &mut Svg, page: &Page, lower: f64, unit: Unit, heights: Option<Heights>) {
    if page.x_axis.ticks.is_empty() && page.y_axis.ticks.is_empty() {
        return;
    }
    let [_, y, _] = page.footer();
    let y = y + lower;
    let end = draw_length(svg, page, unit, (page.frame.min_x, y));
    if let Some(heights) = heights {
        draw_heights(svg, heights, (end + GAP, y));
    }
}

/// Draws the bar. Returns the pixel at its right end.
fn draw_length(svg: &mut Svg, page: &Page, unit: Unit, (x, y): (f64, f64)) -> f64 {
    let length = round_above(SHORTEST / page.length(1.0));
    let pixels = page.length(length);
    svg.raw(&format!(
        "<path d=\"M{x:.1} {:.1}v10m0-5h{pixels:.1}m0-5v10\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"1.4\"/>",
        y - 10.0
    ));
    let text = unit.distance(length);
    let start = x + pixels + 10.0;
    svg.text((start, y), TEXT, Anchor::Start, &fill(INK), &text);
    start + text_width(&text, TEXT)
}

fn draw_heights(svg: &mut Svg, heights: Heights, (x, y): (f64, f64)) {
    let (low, high) = labels(heights);
    let mut x = x;
    let text = |svg: &mut Svg, x: &mut f64, colour: &str, text: &str| {
        svg.text((*x, y), TEXT, Anchor::Start, &fill(colour), text);
        *x += text_width(text, TEXT) + 9.0;
    };
    text(svg, &mut x, GREY, "z");
    text(svg, &mut x, INK, &low);
    let Some(high) = high else { return };
    let steps = RAMP.len() - 1;
    let stop = |(index, [r, g, b]): (usize, &[u8; 3])| {
        let offset = 100.0 * index as f64 / steps as f64;
        format!("<stop offset=\"{offset:.2}%\" stop-color=\"#{r:02x}{g:02x}{b:02x}\"/>")
    };
    let stops: String = RAMP.iter().enumerate().map(stop).collect();
    svg.raw(&format!("<linearGradient id=\"heights\">{stops}</linearGradient>"));
    svg.raw(&format!(
        "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{COLOURS}\" height=\"14\" fill=\"url(#heights)\" stroke=\"{GREY}\" \
         stroke-width=\"0.6\"/>",
        y - 12.0
    ));
    x += COLOURS + 9.0;
    text(svg, &mut x, INK, &high);
}

/// Returns the heights of the first and the last colour, with as many digits as their difference
/// needs; only one if all heights are the same.
fn labels(heights: Heights) -> (String, Option<String>) {
    let Heights { min, max, .. } = heights;
    let step = (max - min) / 200.0;
    // Also for numbers so far apart that their difference is infinite, or none.
    if !(step > f64::MIN_POSITIVE && step < f64::MAX) {
        let shown = |z: f64| number(z).replace('-', "\u{2212}");
        return (shown(min), (min < max).then(|| shown(max)));
    }
    let of = |z: f64| label(z, round_above(step), min.abs().max(max.abs()));
    let beyond = |is_cut: bool, sign: &str, z: f64| if is_cut { format!("{sign} {}", of(z)) } else { of(z) };
    (
        beyond(heights.has_lower, "<", min),
        Some(beyond(heights.has_higher, ">", max)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_have_the_digits_that_tell_them_apart() {
        for (min, max, low, high) in [
            (406.137, 615.262, "406", Some("615")),
            (-0.123, 0.456, "\u{2212}0.123", Some("0.456")),
            (0.0, 12_345.6, "0", Some("12\u{a0}346")),
            (7.25, 7.25, "7.25", None),
            (-1e308, 1e308, "\u{2212}1e308", Some("1e308")),
            (0.0, 1e-310, "0", Some("1e\u{2212}310")),
        ] {
            let heights = Heights {
                min,
                max,
                has_lower: false,
                has_higher: false,
            };
            assert_eq!(labels(heights), (low.to_owned(), high.map(str::to_owned)));
        }
        let cut = Heights {
            min: 1.0,
            max: 9.0,
            has_lower: false,
            has_higher: true,
        };
        assert_eq!(labels(cut), ("1.00".to_owned(), Some("> 9.00".to_owned())));
    }
}
