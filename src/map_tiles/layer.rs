//! What map tiles show.

use std::fmt;
use std::str::FromStr;

/// What a map tile shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Layer {
    /// A picture: shaded relief, or the plane without heights; with holes, lines and sites.
    Shade,
    /// Heights in metres as colours, for files with z.
    Terrarium,
    /// Vectors: cells, triangles, lines, holes and sites.
    Mesh,
}

/// The text names no layer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no layer of this name; use shade, terrarium or mesh")]
pub struct UnknownLayer;

impl Layer {
    /// All layers.
    pub const ALL: [Self; 3] = [Self::Shade, Self::Terrarium, Self::Mesh];

    /// Returns the name: `shade`, `terrarium` or `mesh`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Shade => "shade",
            Self::Terrarium => "terrarium",
            Self::Mesh => "mesh",
        }
    }

    /// Returns the media type of tiles.
    #[must_use]
    pub const fn media_type(self) -> &'static str {
        match self {
            Self::Shade | Self::Terrarium => "image/png",
            Self::Mesh => "application/vnd.mapbox-vector-tile",
        }
    }

    /// Returns the ending of names of tiles, without the dot.
    #[must_use]
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Shade | Self::Terrarium => "png",
            Self::Mesh => "mvt",
        }
    }

    /// Returns what it shows, in a few words.
    #[must_use]
    pub const fn description(self) -> &'static str {
        match self {
            Self::Shade => "Shaded relief, or the plane without heights, with holes, lines and sites",
            Self::Terrarium => "Heights in metres as colours",
            Self::Mesh => "Cells, triangles, lines, holes and sites",
        }
    }

    /// Returns the layers of vector tiles, which only [`Mesh`](Self::Mesh) has, with the fields of
    /// their features.
    #[must_use]
    pub const fn vector_layers(self) -> &'static [VectorLayer] {
        match self {
            Self::Mesh => VECTOR_LAYERS,
            Self::Shade | Self::Terrarium => &[],
        }
    }
}

impl fmt::Display for Layer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Layer {
    type Err = UnknownLayer;

    fn from_str(name: &str) -> Result<Self, UnknownLayer> {
        Self::ALL
            .into_iter()
            .find(|layer| layer.name() == name)
            .ok_or(UnknownLayer)
    }
}

/// A layer of vector tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct VectorLayer {
    /// The name of the layer.
    pub id: &'static str,
    /// What it contains.
    pub description: &'static str,
    /// The names of the fields, and their types as TileJSON names them: `Number`, `String` or
    /// `Boolean`.
    pub fields: &'static [(&'static str, &'static str)],
}

const VECTOR_LAYERS: &[VectorLayer] = &[
    VectorLayer {
        id: "cells",
        description: "The cells of the tiles of the file",
        fields: &[("id", "Number"), ("vertices", "Number")],
    },
    VectorLayer {
        id: "triangles",
        description: "The triangles of the file, or of an overview",
        fields: &[
            ("zmin", "Number"),
            ("zmax", "Number"),
            ("region", "Number"),
            ("hole", "Boolean"),
        ],
    },
    VectorLayer {
        id: "lines",
        description: "Break lines, walls and the outlines of obstacles",
        fields: &[("kind", "String")],
    },
    VectorLayer {
        id: "holes",
        description: "Holes, by region",
        fields: &[("region", "Number")],
    },
    VectorLayer {
        id: "sites",
        description: "Sites",
        fields: &[("id", "String"), ("number", "Number"), ("z", "Number")],
    },
    VectorLayer {
        id: "info",
        description: "One point: the level of detail, 0 for the file, and which layers are left out",
        fields: &[("level", "Number"), ("omitted", "String")],
    },
];
