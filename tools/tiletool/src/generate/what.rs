//! The kinds of data that `tiletool generate` writes.

use std::fmt;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use distributions::{Kind, MapKind};

/// What to write: a set of points, or a map of obstacles and sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum What {
    Points(Kind),
    Map(MapKind),
}

impl fmt::Display for What {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Points(kind) => kind.name(),
            Self::Map(kind) => kind.name(),
        })
    }
}

/// Returns the parser of names.
pub(super) fn kinds() -> impl TypedValueParser<Value = What> {
    let points = Kind::ALL.map(|kind| PossibleValue::new(kind.name()).help(kind.about()));
    let maps = MapKind::ALL.map(|kind| PossibleValue::new(kind.name()).help(kind.about()));
    PossibleValuesParser::new(points.into_iter().chain(maps)).try_map(|name| {
        let map = MapKind::ALL.into_iter().find(|kind| kind.name() == name);
        map.map_or_else(|| Kind::from_str(&name).map(What::Points), |kind| Ok(What::Map(kind)))
    })
}
