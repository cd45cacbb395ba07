//! Draws a vector tile: cells, triangles, lines, holes and sites.
//!
//! Vector tiles are never out of budget. What would take too many tiles of the file, or too many
//! bytes, is left out, and the layer `info` says so.

use crate::geometry::{Point, Rect};
use crate::map_tiles::budget::Budget;
use crate::map_tiles::coord::TileCoord;
use crate::map_tiles::drawn::{DrawError, DrawLimits, Drawn};
use crate::map_tiles::facets::{Facets, Wanted};
use crate::map_tiles::grid::TileGrid;
use crate::map_tiles::source::{FILE, MapSource};
use crate::map_tiles::vector::{CellShape, VectorTile};
use crate::map_tiles::window::{PER_PIXEL, Window, doubled_area};
use crate::store::{CellContent, ReadError, Tile, spawn};

/// How far shapes reach over the sides of a tile, in units.
pub(super) const BUFFER: i32 = 4 * PER_PIXEL;
/// The typical length of edges in pixels up to which a level is fine enough, and below which
/// triangles are left out.
const EDGE: [f64; 2] = [12.0, 2.0];
/// The maximum number of triangles in a tile.
const TRIANGLES: usize = 20_000;
/// The maximum number of parts of holes in a tile, of segments of lines, and of sites.
const PARTS: usize = 40_000;
/// The maximum number of cells in a tile.
const CELLS: usize = 1000;

impl MapSource {
    /// Draws the layer [`Mesh`](crate::map_tiles::layer::Layer::Mesh).
    pub(super) async fn draw_mesh(
        &self,
        grid: &TileGrid,
        at: TileCoord,
        limits: DrawLimits,
    ) -> Result<Drawn, DrawError> {
        let mut budget = Budget::new(limits);
        let window = Window::new(grid, at, BUFFER);
        let mut tile = VectorTile {
            level: self.level_for(grid.pixel_size(at.z()) * EDGE[0]),
            ..VectorTile::default()
        };
        match self.cells(&window).await? {
            Some(cells) => tile.cells = cells,
            None => tile.omitted.push("cells"),
        }
        limits.check()?;
        self.add_triangles(grid, at, &window, &mut tile, &mut budget, limits)
            .await?;
        self.add_shapes(&window, &mut tile, &mut budget, limits).await?;
        let bytes = spawn(move || {
            tile.facets.sort();
            tile.encode()
        });
        Ok(Drawn {
            bytes: bytes.await?,
            tiles: budget.used(),
        })
    }

    /// Adds the triangles of the tile's level.
    async fn add_triangles(
        &self,
        grid: &TileGrid,
        at: TileCoord,
        window: &Window,
        tile: &mut VectorTile,
        budget: &mut Budget,
        limits: DrawLimits,
    ) -> Result<(), DrawError> {
        let level = tile.level;
        let is_dense = self.spacing_of(level) < grid.pixel_size(at.z()) * EDGE[1];
        let tiles = match is_dense {
            true => None,
            false => budget.try_claim(self.level(level), window.rect()).await?.ok(),
        };
        let Some(tiles) = tiles else {
            tile.omitted.push("triangles");
            return Ok(());
        };
        let wanted = Wanted {
            triangles: Some(TRIANGLES),
            holes: false,
            regions: level == FILE,
        };
        let of = {
            let window = window.clone();
            move |tile: &Tile| Facets::of(tile, &window, wanted)
        };
        let facets = &mut tile.facets;
        self.of_tiles(level, tiles, limits, of, |part| facets.append(part, TRIANGLES))
            .await?;
        if tile.facets.too_many {
            tile.omitted.push("triangles");
        }
        Ok(())
    }

    /// Adds lines, holes and sites, which are those of the file at all levels.
    async fn add_shapes(
        &self,
        window: &Window,
        tile: &mut VectorTile,
        budget: &mut Budget,
        limits: DrawLimits,
    ) -> Result<(), DrawError> {
        let metadata = self.reader().metadata();
        let (has_lines, has_holes) = (metadata.constraint_edges > 0, metadata.hole_triangles > 0);
        let has = [
            ("lines", has_lines),
            ("holes", has_holes),
            ("sites", metadata.sites > 0),
        ];
        if !has.iter().any(|(_, has)| *has) {
            return Ok(());
        }
        let is_counted = tile.level == FILE && !tile.omitted.contains(&"triangles");
        let claimed = match is_counted {
            true => Ok(self.reader().tiles_in(window.rect(), usize::MAX).await?),
            false => budget.try_claim(self.reader(), window.rect()).await?,
        };
        let Ok(tiles) = claimed else {
            tile.omitted
                .extend(has.iter().filter(|(_, has)| *has).map(|(name, _)| *name));
            return Ok(());
        };
        tile.shapes = self.shapes(tiles.clone(), window, false, limits).await?;
        if has_holes {
            let wanted = Wanted {
                triangles: None,
                holes: true,
                regions: true,
            };
            let of = {
                let window = window.clone();
                move |tile: &Tile| Facets::of(tile, &window, wanted)
            };
            let mut holes = Facets::default();
            self.of_tiles(FILE, tiles, limits, of, |part| holes.append(part, TRIANGLES))
                .await?;
            tile.facets.holes = holes.holes;
        }
        tile.leave_out(PARTS);
        Ok(())
    }

    /// Returns the cells of the tiles of the file that meet a map tile. `None` if there are too
    /// many.
    async fn cells(&self, window: &Window) -> Result<Option<Vec<CellShape>>, ReadError> {
        let reader = self.reader();
        let (mut found, mut open) = (Vec::new(), Vec::from_iter(reader.root_cell()));
        while let Some(cell) = open.pop() {
            if !cell.rect.intersects(window.rect()) {
                continue;
            }
            match reader.content_of(cell).await? {
                CellContent::Cut([low, high]) => open.extend([high, low]),
                CellContent::Tile(tile) => {
                    let Some(corners) = corners(window, cell.rect) else {
                        continue;
                    };
                    let vertices = reader.entry(tile).await?.vertices;
                    found.push(CellShape {
                        tile,
                        vertices,
                        corners,
                    });
                    if found.len() > CELLS {
                        return Ok(None);
                    }
                }
            }
        }
        Ok(Some(found))
    }
}

/// Returns the part of a rectangle in a map tile, clockwise on a screen.
fn corners(window: &Window, rect: Rect) -> Option<Vec<[i32; 2]>> {
    let [west, east] = [rect.min_x, rect.max_x];
    let corners = [
        (west, rect.max_y),
        (east, rect.max_y),
        (east, rect.min_y),
        (west, rect.min_y),
    ];
    let corners: Option<Vec<_>> = corners.iter().map(|&(x, y)| window.units(Point::new(x, y))).collect();
    let part = window.clip_polygon(&corners?);
    (part.len() > 2 && doubled_area(&part) > 0).then_some(part)
}
