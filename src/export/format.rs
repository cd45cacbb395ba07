//! The export formats and their names.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

#[cfg(doc)]
use super::what::What;

/// A format to which triangulations are exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// PLY, binary, with x, y, z and the record number of each vertex. z is 0 if the file has none.
    /// Constraint edges are written only if they are [requested](super::ExportOptions::edges).
    Ply,
    /// Triangle's `.node` and `.ele`, numbered from 0. If the file has z, it is an attribute of the
    /// vertices.
    Node,
    /// Wavefront OBJ. z is 0 if the file has none.
    Obj,
    /// glTF, binary (`.glb`): a mesh with coordinates of 32 bits relative to the centre of the file,
    /// which is the translation of the mesh's node. The y axis is up: x, z, -y.
    Glb,
    /// GeoJSON: a polygon for each triangle, whose property `vertices` has the numbers of its
    /// vertices; or, by [`What`], a point for each vertex or a line for each constraint edge.
    GeoJson,
    /// FlatGeobuf, without a spatial index: the features of GeoJSON, with the reference system. Needs
    /// feature `flatgeobuf`.
    FlatGeobuf,
    /// GeoParquet 1.1: the features of GeoJSON as a table, with the reference system. Vertices also
    /// have columns `x`, `y` and `z`. Needs feature `parquet`.
    GeoParquet,
}

const COUNT: usize = 5 + cfg!(feature = "flatgeobuf") as usize + cfg!(feature = "parquet") as usize;

impl Format {
    /// All formats that the library was compiled with.
    pub const ALL: [Self; COUNT] = [
        Self::Ply,
        Self::Node,
        Self::Obj,
        Self::Glb,
        Self::GeoJson,
        #[cfg(feature = "flatgeobuf")]
        Self::FlatGeobuf,
        #[cfg(feature = "parquet")]
        Self::GeoParquet,
    ];

    /// Returns whether the format consists of features of one kind, [`What`], instead of a mesh.
    #[must_use]
    pub fn has_features(self) -> bool {
        matches!(self, Self::GeoJson | Self::FlatGeobuf | Self::GeoParquet)
    }

    /// Returns the suffixes of the files that the format consists of, without the dot.
    #[must_use]
    pub fn suffixes(self) -> &'static [&'static str] {
        match self {
            Self::Ply => &["ply"],
            Self::Node => &["node", "ele"],
            Self::Obj => &["obj"],
            Self::Glb => &["glb"],
            Self::GeoJson => &["geojson"],
            Self::FlatGeobuf => &["fgb"],
            Self::GeoParquet => &["parquet"],
        }
    }

    /// Returns the format that a file's suffix indicates.
    ///
    /// # Errors
    /// Fails if the file name has no suffix, or one of no format.
    pub fn from_path(path: &Path) -> Result<Self, UnknownFormat> {
        let suffix = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_ascii_lowercase();
        suffix.parse()
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.suffixes()[0])
    }
}

/// The error of a name that no format has.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UnknownFormat {
    /// No format has the name.
    #[error("formats are {formats}, not '{name}'", formats = all())]
    Name {
        /// The name.
        name: String,
    },
    /// The library was compiled without the format.
    #[error("'{suffix}' needs a program that was compiled with feature '{feature}'; formats are {formats}", formats = all())]
    Feature {
        /// The suffix of the format.
        suffix: &'static str,
        /// The feature that the library needs.
        feature: &'static str,
    },
}

/// Returns the names of all formats, for messages.
fn all() -> String {
    let names: Vec<_> = Format::ALL
        .iter()
        .map(|format| match format {
            Format::Node => "node (with ele)".to_owned(),
            format => format.to_string(),
        })
        .collect();
    names.join(", ")
}

impl FromStr for Format {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let format = match name {
            "ply" => Self::Ply,
            "node" | "ele" => Self::Node,
            "obj" => Self::Obj,
            "glb" => Self::Glb,
            "geojson" | "json" => Self::GeoJson,
            "fgb" => Self::FlatGeobuf,
            "parquet" | "geoparquet" => Self::GeoParquet,
            _ => return Err(UnknownFormat::Name { name: name.to_owned() }),
        };
        if Self::ALL.contains(&format) {
            return Ok(format);
        }
        Err(UnknownFormat::Feature {
            suffix: format.suffixes()[0],
            feature: if format == Self::FlatGeobuf {
                "flatgeobuf"
            } else {
                "parquet"
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_suffixes_parse_to_their_format() {
        for format in Format::ALL {
            assert_eq!(format.to_string().parse::<Format>().unwrap(), format);
            for suffix in format.suffixes() {
                assert_eq!(Format::from_path(Path::new(&format!("a.b.{suffix}"))).unwrap(), format);
            }
        }
        assert_eq!(Format::from_path(Path::new("A.PLY")).unwrap(), Format::Ply);
        for name in ["a.stl", "ply", "a.", ""] {
            let error = Format::from_path(Path::new(name)).unwrap_err();
            assert!(error.to_string().contains("ply, node (with ele), obj, glb, geojson"));
        }
    }
}
