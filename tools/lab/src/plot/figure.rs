//! Figures: lines, patches and dots in the plane, over coordinates, with a legend.
//!
//! The input is layers, the lowest first. The output is an SVG.

use std::collections::HashMap;

use delaunay_tiles::geometry::{Point, Rect};

use tiletool::plot::legend::{Legend, Sign};
use tiletool::plot::map::{Ground, draw_axes, draw_frame};
use tiletool::plot::page::Page;
use tiletool::plot::style::{LINES, PAPER, fill, stroke};
use tiletool::plot::svg::{Path, Svg};

/// A layer of shapes of one kind, in one style.
pub struct Layer {
    /// The name in the legend; a layer without a name is not in the legend.
    pub name: &'static str,
    pub colour: &'static str,
    pub shape: Shape,
}

/// Shapes in the plane.
pub enum Shape {
    /// Lines between two points, with their width in pixels.
    Edges(Vec<[Point; 2]>, f64),
    /// Filled triangles.
    Triangles(Vec<[Point; 3]>),
    /// Discs, with their radius in pixels.
    Dots(Vec<Point>, f64),
}

/// Layers on a page.
pub struct Figure {
    pub title: String,
    pub caption: String,
    /// The rectangle that the figure shows.
    pub bounds: Rect,
    pub layers: Vec<Layer>,
}

impl Figure {
    /// Draws the figure as an SVG.
    ///
    /// # Errors
    /// If the bounds are not coordinates.
    pub fn draw(&self) -> anyhow::Result<String> {
        let page = Page::new(self.bounds)?;
        let mut svg = Svg::new(page.width, page.height, &self.title);
        let mut legend = Legend::default();
        draw_frame(
            &mut svg,
            &page,
            Ground::Colour(PAPER),
            [&self.title, &self.caption],
            |svg| {
                svg.in_units(LINES, |svg| {
                    for layer in &self.layers {
                        let sign = layer.draw(svg, &page);
                        if !layer.name.is_empty() {
                            legend.add(sign, layer.name);
                        }
                    }
                });
            },
        );
        draw_axes(&mut svg, &page);
        legend.draw(&mut svg, (page.frame.min_x, page.frame.max_y + 58.0));
        Ok(svg.finish())
    }
}

impl Layer {
    /// Creates a layer of lines that are `width` pixels wide.
    pub fn edges(name: &'static str, colour: &'static str, edges: Vec<[Point; 2]>, width: f64) -> Self {
        let shape = Shape::Edges(edges, width);
        Self { name, colour, shape }
    }

    fn draw(&self, svg: &mut Svg, page: &Page) -> Sign {
        match &self.shape {
            Shape::Edges(edges, width) => {
                let mut numbers = HashMap::new();
                let mut pixels = Vec::new();
                let mut number = |p: Point| {
                    *numbers.entry([p.x.to_bits(), p.y.to_bits()]).or_insert_with(|| {
                        pixels.push(page.pixel(p));
                        pixels.len() as u32 - 1
                    })
                };
                let edges: Vec<_> = edges.iter().map(|edge| edge.map(&mut number)).collect();
                let mut path = Path::default();
                path.trails(&pixels, &edges);
                svg.path(&path, &stroke(self.colour, *width));
                Sign::Line(self.colour, width.max(0.9))
            }
            Shape::Triangles(triangles) => {
                let triangles = triangles.iter().map(|t| t.map(|corner| page.pixel(corner)));
                svg.path(&Path::polygons(triangles), &fill(self.colour));
                Sign::Patch(self.colour)
            }
            Shape::Dots(dots, radius) => {
                let dots = dots.iter().map(|&dot| page.pixel(dot));
                svg.path(&Path::discs(dots, *radius), &fill(self.colour));
                Sign::Dot(self.colour)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_layer_is_drawn_and_named_in_the_legend() {
        let at = |x: f64, y: f64| Point::new(x, y);
        let figure = Figure {
            title: "a & b".to_owned(),
            caption: "below".to_owned(),
            bounds: Rect::new(0.0, 0.0, 4.0, 3.0),
            layers: vec![
                Layer {
                    name: "patches",
                    colour: "#abcdef",
                    shape: Shape::Triangles(vec![[at(0.0, 0.0), at(4.0, 0.0), at(0.0, 3.0)]]),
                },
                Layer {
                    name: "lines",
                    colour: "#123456",
                    shape: Shape::Edges(vec![[at(0.0, 0.0), at(4.0, 3.0)], [at(4.0, 3.0), at(4.0, 0.0)]], 1.0),
                },
                Layer {
                    name: "",
                    colour: "#654321",
                    shape: Shape::Dots(vec![at(1.0, 1.0)], 3.0),
                },
            ],
        };
        let svg = figure.draw().unwrap();
        for part in [
            "a &amp; b",
            "below",
            "patches",
            "lines",
            "#abcdef",
            "#123456",
            "#654321",
        ] {
            assert!(svg.contains(part), "{part}");
        }
        // The two lines are one path.
        let lines = svg.lines().find(|line| line.contains("stroke=\"#123456\"")).unwrap();
        assert_eq!(lines.matches('m').count(), 1, "{lines}");
        assert!(tiletool::plot::png::render(&svg, None).is_ok());
        assert!(
            Figure {
                bounds: Rect::PLANE,
                ..figure
            }
            .draw()
            .is_err()
        );
    }
}
