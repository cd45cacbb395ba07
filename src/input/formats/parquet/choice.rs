//! The choice of the columns that have the points.

use crate::input::formats::names::{X, Y, Z};
use crate::input::formats::parquet::geo::Geo;
use crate::input::formats::parquet::metadata::Problem;
use crate::input::options::{Column, Columns};
use crate::shown;
use ::parquet::basic::{ConvertedType, LogicalType, Type};
use ::parquet::file::metadata::ParquetMetaData;
use ::parquet::schema::types::ColumnDescriptor;

/// How the points are in the columns.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Numbers: a point in each row.
    Columns,
    /// Numbers that are the parts of a geometry, which may be null.
    Struct,
    /// A geometry in WKB.
    Wkb,
}

/// The columns that have the points.
pub struct Choice {
    pub layout: Layout,
    /// The numbers of the leaves: x, y and, if there is one, z; or the geometry.
    pub leaves: Vec<usize>,
    pub crs: Option<String>,
    /// Whether each row is expected to have one point.
    pub one_per_row: bool,
}

const HINT: &str = "name the columns with the option `columns` (x,y or x,y,z)";

impl Choice {
    pub fn new(metadata: &ParquetMetaData, columns: Option<&Columns>) -> Result<Self, Problem> {
        let leaves = Leaves(metadata);
        if let Some(columns) = columns {
            return leaves.named(columns);
        }
        let keys = metadata.file_metadata().key_value_metadata();
        let geo = keys.into_iter().flatten().find(|key| key.key == "geo");
        if let Some(key) = geo {
            let geo = Geo::parse(key.value.as_deref().unwrap_or_default()).map_err(|what| {
                let problem = format!(
                    "the key `geo` of GeoParquet is broken: {}",
                    shown::beginning(&what, 200)
                );
                Problem::new(problem, HINT)
            })?;
            return leaves.geometry(geo);
        }
        match leaves.of_geometry_type() {
            Some(choice) => Ok(choice),
            None => leaves.usual(),
        }
    }
}

/// The leaves of the schema.
struct Leaves<'a>(&'a ParquetMetaData);

impl Leaves<'_> {
    fn all(&self) -> impl Iterator<Item = &ColumnDescriptor> {
        let schema = self.0.file_metadata().schema_descr();
        schema.columns().iter().map(|leaf| &**leaf)
    }

    fn find(&self, path: &str) -> Option<usize> {
        let is_it = |leaf: &ColumnDescriptor| leaf.path().string().to_lowercase() == path.to_lowercase();
        self.all().position(is_it)
    }

    /// Returns the error of a column that is missing.
    fn missing(&self, what: &str) -> Problem {
        let names: Vec<String> = self.all().take(20).map(|leaf| leaf.path().string()).collect();
        let names = shown::beginning(&names.join(", "), 200);
        Problem::new(
            format!("no column {} among `{names}`", shown::beginning(what, 60)),
            HINT,
        )
    }

    fn named(&self, columns: &Columns) -> Result<Choice, Problem> {
        let count = self.all().count();
        let find = |column: &Column| match column {
            Column::Number(n) => n.checked_sub(1).filter(|n| *n < count),
            Column::Name(name) => self.find(name),
        };
        let need = |column: &Column| find(column).ok_or_else(|| self.missing(&format!("`{column}`")));
        let z = columns.z.as_ref().map(need).transpose()?;
        self.numbers(Layout::Columns, need(&columns.x)?, need(&columns.y)?, z)
    }

    fn usual(&self) -> Result<Choice, Problem> {
        let any = |names: &[&str]| names.iter().find_map(|name| self.find(name));
        let need = |names: &[&str], what: &str| any(names).ok_or_else(|| self.missing(what));
        let x = need(X, "for x (such as x, lon, easting)")?;
        let y = need(Y, "for y (such as y, lat, northing)")?;
        self.numbers(Layout::Columns, x, y, any(Z))
    }

    fn numbers(&self, layout: Layout, x: usize, y: usize, z: Option<usize>) -> Result<Choice, Problem> {
        let leaves: Vec<usize> = [x, y].into_iter().chain(z).collect();
        for leaf in leaves.iter().filter_map(|&leaf| self.all().nth(leaf)) {
            if leaf.max_rep_level() > 0 || !is_number(leaf) {
                let problem = format!(
                    "the column `{}` is not a number in each row",
                    shown::beginning(&leaf.path().string(), 60)
                );
                return Err(Problem::new(problem, HINT));
            }
        }
        Ok(Choice {
            layout,
            leaves,
            crs: None,
            one_per_row: true,
        })
    }

    /// Returns the choice that the key `geo` makes.
    fn geometry(&self, geo: Geo) -> Result<Choice, Problem> {
        let column = &geo.column;
        let one_per_row = geo.has_points_only();
        let choice = match &*geo.encoding {
            "WKB" => {
                let leaf = self.find(column).ok_or_else(|| self.missing(&format!("`{column}`")))?;
                self.wkb(leaf)?
            }
            "point" => {
                let find = |axis: &str| self.find(&format!("{column}.{axis}"));
                let need = |axis: &str| find(axis).ok_or_else(|| self.missing(&format!("`{column}.{axis}`")));
                self.numbers(Layout::Struct, need("x")?, need("y")?, find("z"))?
            }
            other => {
                let problem = format!("geometries in the encoding `{}`", shown::beginning(other, 60));
                return Err(Problem::new(
                    problem,
                    "points are read from WKB and from the encoding `point`",
                ));
            }
        };
        Ok(Choice {
            crs: geo.crs,
            one_per_row,
            ..choice
        })
    }

    /// Returns the first column whose type is Parquet's own for geometries.
    fn of_geometry_type(&self) -> Option<Choice> {
        self.all().enumerate().find_map(|(leaf, about)| {
            let crs = match about.logical_type_ref()? {
                LogicalType::Geometry(geometry) => geometry.crs.as_ref(),
                LogicalType::Geography(geography) => geography.crs.as_ref(),
                _ => return None,
            };
            let crs = crs.map_or("OGC:CRS84", |crs| &**crs).to_owned();
            let choice = self.wkb(leaf).ok()?;
            Some(Choice {
                crs: Some(crs),
                ..choice
            })
        })
    }

    fn wkb(&self, leaf: usize) -> Result<Choice, Problem> {
        let is_bytes =
            |about: &ColumnDescriptor| about.physical_type() == Type::BYTE_ARRAY && about.max_rep_level() == 0;
        if !self.all().nth(leaf).is_some_and(is_bytes) {
            let problem = "the geometry column does not have bytes in each row";
            return Err(Problem::new(problem, "WKB is bytes; was the column changed?"));
        }
        Ok(Choice {
            layout: Layout::Wkb,
            leaves: vec![leaf],
            crs: None,
            one_per_row: false,
        })
    }
}

fn is_number(leaf: &ColumnDescriptor) -> bool {
    let kind = leaf.converted_type();
    match leaf.physical_type() {
        Type::FLOAT | Type::DOUBLE => true,
        Type::INT32 | Type::INT64 => match leaf.logical_type_ref() {
            Some(LogicalType::Integer(_) | LogicalType::Decimal(_)) => kind != ConvertedType::UINT_64,
            None => matches!(kind, ConvertedType::NONE | ConvertedType::DECIMAL),
            Some(_) => false,
        },
        _ => false,
    }
}
