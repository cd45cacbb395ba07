//! The export formats and their names.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// A format to which triangulations are exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// PLY, binary, with x, y, z and the record number of each vertex. z is 0 if the file has none.
    Ply,
    /// Triangle's `.node` and `.ele`, numbered from 0. If the file has z, it is an attribute of the
    /// vertices.
    Node,
    /// Wavefront OBJ. z is 0 if the file has none.
    Obj,
    /// GeoJSON: a polygon for each triangle, whose property `vertices` has the numbers of its
    /// vertices. A file without triangles becomes its vertices, as points with the properties
    /// `vertex` and `record`.
    GeoJson,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Ply, Self::Node, Self::Obj, Self::GeoJson];

    /// Returns the suffixes of the files that the format consists of, without the dot.
    #[must_use]
    pub fn suffixes(self) -> &'static [&'static str] {
        match self {
            Self::Ply => &["ply"],
            Self::Node => &["node", "ele"],
            Self::Obj => &["obj"],
            Self::GeoJson => &["geojson"],
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
#[error("formats are ply, node (with ele), obj and geojson, not '{0}'")]
pub struct UnknownFormat(String);

impl FromStr for Format {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "ply" => Ok(Self::Ply),
            "node" | "ele" => Ok(Self::Node),
            "obj" => Ok(Self::Obj),
            "geojson" | "json" => Ok(Self::GeoJson),
            _ => Err(UnknownFormat(name.to_owned())),
        }
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
            assert!(error.to_string().contains("ply, node (with ele), obj and geojson"));
        }
    }
}
