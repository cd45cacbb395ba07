//! The formats of vector data: features with geometries and fields.

use crate::input::bytes::ByteInput;
use crate::input::content;
use crate::input::error::InputError;
use crate::input::format::Format;
#[cfg(feature = "flatgeobuf")]
use crate::input::formats::flatgeobuf;
#[cfg(feature = "geojson")]
use crate::input::formats::geojson::GeoJson;
#[cfg(feature = "geopackage")]
use crate::input::formats::geopackage;
#[cfg(feature = "shapefile")]
use crate::input::formats::shapefile;
use crate::input::formats::shapes::Shapes;
use crate::input::watch::Watched;
use std::fs::File;
use std::sync::Arc;

/// A format of vector data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Vector {
    GeoJson,
    FlatGeobuf,
    Shapefile,
    GeoPackage,
}

impl Vector {
    /// Returns the format of vector data that `format` is.
    pub fn of(format: Format) -> Option<Self> {
        match format {
            Format::GeoJson => Some(Self::GeoJson),
            Format::FlatGeobuf => Some(Self::FlatGeobuf),
            Format::Shapefile => Some(Self::Shapefile),
            Format::GeoPackage => Some(Self::GeoPackage),
            _ => None,
        }
    }

    pub fn format(self) -> Format {
        match self {
            Self::GeoJson => Format::GeoJson,
            Self::FlatGeobuf => Format::FlatGeobuf,
            Self::Shapefile => Format::Shapefile,
            Self::GeoPackage => Format::GeoPackage,
        }
    }

    /// Starts to read a stream.
    pub fn start(self, input: ByteInput) -> Result<Box<dyn Shapes>, InputError> {
        match self {
            #[cfg(feature = "geojson")]
            Self::GeoJson => Ok(Box::new(GeoJson::new(input)?)),
            #[cfg(feature = "flatgeobuf")]
            Self::FlatGeobuf => flatgeobuf::open(input),
            #[cfg(feature = "shapefile")]
            Self::Shapefile => shapefile::open(input),
            #[cfg(feature = "geopackage")]
            Self::GeoPackage => Err(geopackage::no_stream(&input.path)),
            #[cfg(not(all(
                feature = "geojson",
                feature = "flatgeobuf",
                feature = "shapefile",
                feature = "geopackage"
            )))]
            absent => Err(absent.format().missing(&input.path)),
        }
    }

    /// Starts to read a file. `field` is the field of the ids, if one is selected.
    pub fn start_file(self, file: Watched<Arc<File>>) -> Result<Box<dyn Shapes>, InputError> {
        #[cfg(feature = "geopackage")]
        if self == Self::GeoPackage && file.watch.size().is_some() {
            return geopackage::open(file);
        }
        let input = ByteInput::new(file, true)?;
        if input.was_gzip {
            content::check_unzipped(&input, self.format())?;
        }
        self.start(input)
    }
}
