//! Shapes of a map tile as Mapbox Vector Tile, version 2.
//!
//! Exterior rings are clockwise on a screen. Positions are whole units, rounded before.

use bytes::Bytes;
use mvt::{Error, Feature, GeomData, GeomEncoder, GeomType, Layer, Tile};

use crate::map_tiles::chains::chains;
use crate::map_tiles::facets::Facets;
use crate::map_tiles::shapes::{Kind, Shapes, SiteShape};
use crate::map_tiles::window::{EXTENT, Unit};
use crate::store::TileId;

/// The cell of a tile of the file in a map tile.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CellShape {
    pub(super) tile: TileId,
    pub(super) vertices: u32,
    /// Clockwise on a screen.
    pub(super) corners: Vec<Unit>,
}

/// The shapes of a map tile.
#[derive(Clone, Debug, Default)]
pub(super) struct VectorTile {
    pub(super) cells: Vec<CellShape>,
    pub(super) facets: Facets,
    pub(super) shapes: Shapes,
    /// The level of the triangles.
    pub(super) level: usize,
    /// The layers that are left out.
    pub(super) omitted: Vec<&'static str>,
}

impl VectorTile {
    /// Returns the tile in its format; empty if there is no shape in it.
    pub(super) fn encode(&self) -> Bytes {
        // The encoder fails if a name is used twice or a number is too large, which cannot be here.
        let bytes = self.layers().expect("whole numbers can be encoded");
        bytes.into()
    }

    /// Leaves out lines, holes and sites of which there are more than `most`.
    pub(super) fn leave_out(&mut self, most: usize) {
        if self.shapes.line_count() > most {
            self.shapes.clear_lines();
            self.omitted.push("lines");
        }
        if self.facets.holes.values().map(Vec::len).sum::<usize>() > most {
            self.facets.holes.clear();
            self.omitted.push("holes");
        }
        if self.shapes.sites().len() > most {
            self.shapes.clear_sites();
            self.omitted.push("sites");
        }
    }

    fn layers(&self) -> Result<Vec<u8>, Error> {
        let mut tile = Tile::new(EXTENT);
        let layers = [
            self.cells(tile.create_layer("cells"))?,
            self.triangles(tile.create_layer("triangles"))?,
            self.lines(tile.create_layer("lines"))?,
            self.holes(tile.create_layer("holes"))?,
            self.sites(tile.create_layer("sites"))?,
        ];
        if layers.iter().all(|layer| layer.num_features() == 0) && self.omitted.is_empty() {
            return Ok(Vec::new());
        }
        let info = self.info(tile.create_layer("info"))?;
        for layer in layers.into_iter().chain([info]) {
            if layer.num_features() > 0 {
                tile.add_layer(layer)?;
            }
        }
        tile.to_bytes()
    }

    fn cells(&self, mut layer: Layer) -> Result<Layer, Error> {
        for cell in &self.cells {
            layer = feature(layer, polygons([&cell.corners])?, |feature| {
                feature.add_tag_uint("id", cell.tile.0.into());
                feature.add_tag_uint("vertices", cell.vertices.into());
            });
        }
        Ok(layer)
    }

    fn triangles(&self, mut layer: Layer) -> Result<Layer, Error> {
        for facet in &self.facets.triangles {
            layer = feature(layer, polygons([&facet.corners])?, |feature| {
                if let Some([low, high]) = facet.z {
                    feature.add_tag_float("zmin", low);
                    feature.add_tag_float("zmax", high);
                }
                if let Some((region, is_hole)) = facet.region {
                    feature.add_tag_uint("region", region);
                    feature.add_tag_bool("hole", is_hole);
                }
            });
        }
        Ok(layer)
    }

    fn lines(&self, mut layer: Layer) -> Result<Layer, Error> {
        for kind in Kind::ALL {
            for line in chains(self.shapes.lines(kind)) {
                let mut geometry = GeomEncoder::new(GeomType::Linestring);
                line.iter().try_for_each(|&[x, y]| geometry.add_point(x, y))?;
                layer = feature(layer, geometry.encode()?, |feature| {
                    feature.add_tag_string("kind", kind.name())
                });
            }
        }
        Ok(layer)
    }

    fn holes(&self, mut layer: Layer) -> Result<Layer, Error> {
        for (&region, parts) in &self.facets.holes {
            let geometry = polygons(parts)?;
            layer = feature(layer, geometry, |feature| feature.add_tag_uint("region", region));
        }
        Ok(layer)
    }

    fn sites(&self, mut layer: Layer) -> Result<Layer, Error> {
        for SiteShape {
            at: [x, y],
            number,
            id,
            z,
        } in self.shapes.sites()
        {
            let geometry = GeomEncoder::new(GeomType::Point).point(*x, *y)?.encode()?;
            layer = feature(layer, geometry, |feature| {
                feature.add_tag_uint("number", *number);
                if let Some(id) = id {
                    feature.add_tag_string("id", id);
                }
                if let Some(z) = z {
                    feature.add_tag_double("z", *z);
                }
            });
        }
        Ok(layer)
    }

    fn info(&self, layer: Layer) -> Result<Layer, Error> {
        let middle = (EXTENT / 2) as i32;
        let geometry = GeomEncoder::new(GeomType::Point).point(middle, middle)?.encode()?;
        Ok(feature(layer, geometry, |feature| {
            feature.add_tag_uint("level", self.level as u64);
            feature.add_tag_string("omitted", &self.omitted.join(","));
        }))
    }
}

/// Adds a feature to a layer.
fn feature(layer: Layer, geometry: GeomData, tags: impl FnOnce(&mut Feature)) -> Layer {
    let mut feature = layer.into_feature(geometry);
    tags(&mut feature);
    feature.into_layer()
}

/// Returns the geometry of polygons without holes.
fn polygons<'a>(rings: impl IntoIterator<Item = &'a Vec<Unit>>) -> Result<GeomData, Error> {
    let mut geometry = GeomEncoder::new(GeomType::Polygon);
    let mut last = None;
    for ring in rings {
        // The encoder joins a ring to the one before if it begins where that ended.
        let first = usize::from(ring.first() == last.as_ref());
        let (before, from) = ring.split_at(first);
        for &[x, y] in from.iter().chain(before) {
            geometry.add_point(x, y)?;
        }
        geometry.complete_geom()?;
        last = before.last().or(from.last()).copied();
    }
    geometry.encode()
}
