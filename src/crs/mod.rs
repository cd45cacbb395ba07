//! Coordinate reference systems: what the text that names one says.
//!
//! In: the text that a file or a user gives: WKT 1 (also ESRI's) and WKT 2, a code such as
//! `EPSG:25832`, a URN or URL of the OGC, or PROJJSON. Out: a [`Crs`] with its EPSG code, the
//! [`Unit`] of its coordinates, and whether they are angles. With the feature `epsg`, codes have
//! their definitions from the EPSG dataset. Nothing is reprojected: the library only tells whether
//! two systems [differ](Crs::conflict), and which one [several files](Agreement) have.
//!
//! ```text
//! text ──▶ code: EPSG:n, urn:…, http:… ──▶ definition (feature `epsg`) ─┐
//!     └──▶ wkt: a tree of nodes <────────────────────────────────────────┘
//!             ├──▶ system: unit, angles or lengths, parameters ──▶ conflict
//!             └──▶ projjson (feature `parquet`): the same system as PROJJSON
//! ```

mod agreement;
mod code;
#[cfg(feature = "epsg")]
pub(crate) mod epsg;
mod method;
#[cfg(feature = "parquet")]
mod projjson;
mod system;
mod unit;
mod wkt;

pub use agreement::{Agreement, CrsConflict};
pub use unit::Unit;

use std::borrow::Cow;

use crate::crs::system::System;
use crate::crs::wkt::Node;

/// A coordinate reference system of the plane, as far as its text tells.
///
/// ```
/// use delaunay_tiles::crs::{Crs, Unit};
///
/// let utm = Crs::new("urn:ogc:def:crs:EPSG::25832");
/// assert_eq!(utm.epsg(), Some(25832));
/// assert!(utm.conflict(&Crs::new("EPSG:26917")).is_some());
///
/// let geographic = Crs::new("OGC:CRS84");
/// assert_eq!((geographic.unit(), geographic.is_geographic()), (Unit::Degree, Some(true)));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Crs {
    text: String,
    epsg: Option<u32>,
    system: Option<System>,
}

impl Crs {
    /// Returns the system that a text describes. Any text is taken; of one that cannot be
    /// interpreted, nothing is [known](Self::is_known).
    #[must_use]
    pub fn new(text: &str) -> Self {
        let text = text.trim_matches(|c: char| c.is_whitespace() || c == '\0' || c == '\u{feff}');
        if let Some(root) = Node::parse(text) {
            let horizontal = system::horizontal(&root);
            return Self {
                text: text.to_owned(),
                epsg: horizontal.and_then(system::epsg),
                system: horizontal.and_then(System::of),
            };
        }
        let epsg = code::epsg(text);
        Self {
            text: text.to_owned(),
            epsg,
            system: match epsg {
                Some(epsg) => System::of_code(epsg, code::definition(epsg).as_deref()),
                None => System::of_projjson(text),
            },
        }
    }

    /// Returns the text that describes the system.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the EPSG code, if the text contains it. The code of a compound system is that of its
    /// horizontal part. OGC's CRS84 counts as EPSG:4326: the order of the axes, in which they
    /// differ, is that of the file format here.
    #[must_use]
    pub fn epsg(&self) -> Option<u32> {
        self.epsg
    }

    /// Returns the system as WKT: the text itself, or the definition of its code, which needs the
    /// feature `epsg`.
    #[must_use]
    pub fn wkt(&self) -> Option<Cow<'_, str>> {
        match Node::parse(&self.text) {
            Some(_) => Some(Cow::Borrowed(&self.text)),
            None => code::definition(self.epsg?).map(Cow::Owned),
        }
    }

    /// Returns the system as PROJJSON, if it has [WKT](Self::wkt) that can be expressed so. The text
    /// itself may be PROJJSON too; then there is no WKT.
    #[cfg(feature = "parquet")]
    pub(crate) fn projjson(&self) -> Option<serde_json::Value> {
        projjson::of(&Node::parse(&self.wkt()?)?)
    }

    /// Returns the URN of the system for the member `crs` of GeoJSON; `None` if the system is that of
    /// GeoJSON anyway, longitude and latitude in WGS 84, or if it has no code.
    ///
    /// ```
    /// # use delaunay_tiles::crs::Crs;
    /// let utm = Crs::new("EPSG:25832");
    /// assert_eq!(utm.urn().as_deref(), Some("urn:ogc:def:crs:EPSG::25832"));
    /// ```
    #[must_use]
    pub fn urn(&self) -> Option<String> {
        let epsg = self.epsg.filter(|&epsg| epsg != 4326)?;
        Some(format!("urn:ogc:def:crs:EPSG::{epsg}"))
    }

    /// Returns the name of the system, such as `WGS 84 / UTM zone 32N`.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.system.as_ref()?.name.as_deref()
    }

    /// Returns the unit of the coordinates.
    #[must_use]
    pub fn unit(&self) -> Unit {
        self.system.as_ref().map_or(Unit::Unknown, |system| system.unit)
    }

    /// Returns the unit of heights, if the text is WKT of a compound system that names one.
    ///
    /// ```
    /// # use delaunay_tiles::crs::{Crs, Unit};
    /// let wkt = r#"COMPD_CS["a",PROJCS["b",UNIT["metre",1]],VERT_CS["c",UNIT["foot",0.3048]]]"#;
    /// assert_eq!(Crs::new(wkt).height_unit(), Unit::Foot);
    /// assert_eq!(Crs::new("EPSG:25832").height_unit(), Unit::Unknown);
    /// ```
    #[must_use]
    pub fn height_unit(&self) -> Unit {
        let root = Node::parse(&self.text);
        root.as_ref().and_then(system::height_unit).unwrap_or(Unit::Unknown)
    }

    /// Returns the unit of z: that of [heights](Self::height_unit), else that of x and y if it is a length.
    #[must_use]
    pub fn z_unit(&self) -> Unit {
        let units = [self.height_unit(), self.unit()].into_iter();
        let mut lengths = units.filter(|unit| unit.metres().is_some());
        lengths.next().unwrap_or(Unit::Unknown)
    }

    /// Returns whether the coordinates are longitudes and latitudes; `None` if that is not known.
    #[must_use]
    pub fn is_geographic(&self) -> Option<bool> {
        self.system.as_ref().map(|system| system.is_geographic)
    }

    /// Returns whether the text could be interpreted at all.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.epsg.is_some() || self.system.is_some()
    }

    /// Returns how two systems differ, for a person, or `None` if nothing proves that they do.
    ///
    /// Two different EPSG codes differ. If one has no code, the systems differ if one has angles and
    /// the other has lengths, or if their units, or the methods or parameters of their projections
    /// differ. A method counts if it has one of the usual names.
    #[must_use]
    pub fn conflict(&self, other: &Self) -> Option<String> {
        if self.text == other.text {
            return None;
        }
        match (self.epsg, other.epsg) {
            (Some(this), Some(that)) => (this != that).then(|| format!("EPSG:{this} is not EPSG:{that}")),
            _ => self.system.as_ref()?.conflict(other.system.as_ref()?),
        }
    }

    /// Returns the system in a few words: its code and name, or the start of its text.
    #[must_use]
    pub fn summary(&self) -> String {
        let name = self.name().unwrap_or_default();
        match (self.epsg, name) {
            (Some(epsg), "") => format!("EPSG:{epsg}"),
            (Some(epsg), name) => format!("EPSG:{epsg}, {name}"),
            (None, "") => self.text.chars().take(60).collect(),
            (None, name) => name.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests;
