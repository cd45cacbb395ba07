//! The features of a layer, in the order of their numbers in the table.

use crate::input::about::Field;
use crate::input::caught::catch;
use crate::input::error::{InputError, Location};
use crate::input::flaw::Flaw;
use crate::input::formats::geopackage::database;
use crate::input::formats::geopackage::database::{damaged, quoted};
use crate::input::formats::geopackage::geometry::add_blob;
use crate::input::formats::geopackage::layers::{self, Layer, ListedLayer, columns, crs, find_column, find_layer};
use crate::input::formats::shapes::{Decoded, Decoder, Feature, FoundId, Shapes};
use crate::input::layer;
use crate::input::sites::SiteId;
use crate::input::watch::{Watch, Watched};
use crate::shown;
use rusqlite::Connection;
use rusqlite::types::ValueRef;
use std::collections::VecDeque;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// The limits on the features that are read at once: their number, and the bytes after which no
/// further one is read.
const MOST_ROWS: usize = 256;
const MOST_BYTES: usize = 1 << 20;

/// Returns the error for GeoPackage in an input that is not a file.
pub fn no_stream(path: &Path) -> InputError {
    let hint = "give the name of a file (not a pipe, and not gzip)";
    InputError::malformed(path, Location::File, "GeoPackage is not read from a stream", hint)
}

/// Returns the layers of a file, in the order of its list.
pub fn list(file: &Watched<Arc<File>>) -> Result<Vec<ListedLayer>, InputError> {
    layers::list(&connect(file)?, &file.watch.path)
}

/// Opens the file and finds the layer that its path names, or its only one.
pub fn open(file: Watched<Arc<File>>) -> Result<Box<dyn Shapes>, InputError> {
    let path = Arc::clone(&file.watch.path);
    open_layer(&file, layer::split(&path).map(|(_, name)| name))
}

fn connect(file: &Watched<Arc<File>>) -> Result<Connection, InputError> {
    database::open(&file.watch.path, &file.head(), file.watch.size().unwrap_or(0))
}

/// Opens the file and finds the layer `name`, or its only one.
pub fn open_layer(file: &Watched<Arc<File>>, name: Option<&str>) -> Result<Box<dyn Shapes>, InputError> {
    let watch = Arc::clone(&file.watch);
    let connection = connect(file)?;
    let layer = find_layer(&connection, &watch.path, name)?;
    Ok(Box::new(Decoded::new(GeoPackage {
        crs: crs(&connection, &layer),
        connection,
        layer,
        watch,
        field: None,
        rows: VecDeque::new(),
        after: None,
        is_at_end: false,
    })))
}

struct GeoPackage {
    connection: Connection,
    layer: Layer,
    watch: Arc<Watch>,
    crs: Option<String>,
    /// The column of the ids.
    field: Option<Box<str>>,
    /// The features that were read and not yet handed out.
    rows: VecDeque<Row>,
    /// The number of the last feature that was read.
    after: Option<i64>,
    is_at_end: bool,
}

/// A row of the table.
struct Row {
    /// The number of the feature in the table.
    number: i64,
    /// Its geometry, or what is wrong with it.
    geometry: Result<Option<Vec<u8>>, &'static str>,
    id: Option<FoundId>,
}

impl GeoPackage {
    /// Reads the next rows.
    fn read_rows(&mut self) -> rusqlite::Result<()> {
        let field = self.field.as_ref().map(|field| format!(", {}", quoted(field)));
        let (number, table) = (self.layer.number, quoted(&self.layer.table));
        let from = self.after.map_or(String::new(), |_| format!("WHERE {number} > ?1"));
        let sql = format!(
            "SELECT {number}, {}{} FROM {table} {from} ORDER BY {number} LIMIT {MOST_ROWS}",
            quoted(&self.layer.column),
            field.as_deref().unwrap_or_default(),
        );
        let mut statement = self.connection.prepare(&sql)?;
        let mut rows = match self.after {
            None => statement.query([])?,
            Some(after) => statement.query([after])?,
        };
        let mut bytes = 0;
        while bytes < MOST_BYTES {
            let Some(row) = rows.next()? else {
                self.is_at_end = self.rows.len() < MOST_ROWS;
                break;
            };
            let geometry = match row.get_ref(1)? {
                ValueRef::Null => Ok(None),
                ValueRef::Blob(blob) => {
                    bytes += blob.len();
                    Ok(Some(blob.to_vec()))
                }
                _ => Err("its geometry is not a blob"),
            };
            let id = match field {
                Some(_) => id_of(row.get_ref(2)?),
                None => None,
            };
            let number: i64 = row.get(0)?;
            // In a damaged file they may come in any order, and again and again.
            if self.after.is_some_and(|after| after >= number) {
                let geometry = Err("its number is not above that of the row before");
                self.rows.push_back(Row {
                    number,
                    geometry,
                    id: None,
                });
                self.is_at_end = true;
                break;
            }
            self.after = Some(number);
            self.rows.push_back(Row { number, geometry, id });
        }
        self.watch.advance(bytes as u64);
        Ok(())
    }

    /// Fails if there is no column of the ids in the table.
    fn check_field(&self) -> Result<(), InputError> {
        let Some(field) = &self.field else { return Ok(()) };
        let path = &self.watch.path;
        let columns = columns(&self.connection, &self.layer.table);
        let columns = columns.map_err(|error| damaged(path, "its tables cannot be read", error))?;
        if find_column(&columns, field).is_some_and(|column| !column.is_computed) {
            return Ok(());
        }
        let names = columns.iter().filter(|column| !column.is_computed);
        let names: Vec<&str> = names.map(|column| &*column.name).collect();
        let names = shown::beginning(&names.join(", "), 200);
        let problem = format!("there is no field `{}`; there are {names}", shown::beginning(field, 60));
        let hint = "select one of these for the ids, or none";
        Err(InputError::malformed(path, Location::File, problem, hint))
    }

    /// Returns the next row; `None` at the end.
    fn next_row(&mut self) -> Result<Option<Row>, InputError> {
        if self.rows.is_empty() && !self.is_at_end {
            self.watch.reading.check()?;
            if self.after.is_none() {
                self.check_field()?;
            }
            if let Err(error) = self.read_rows() {
                let problem = match self.after {
                    Some(after) => format!("the features after number {after} cannot be read"),
                    None => "the features cannot be read".to_owned(),
                };
                return Err(damaged(&self.watch.path, problem, error));
            }
        }
        Ok(self.rows.pop_front())
    }
}

impl Decoder for GeoPackage {
    fn decode(&mut self, number: u64, feature: &mut Feature) -> Result<bool, InputError> {
        let Some(row) = self.next_row()? else {
            return Ok(false);
        };
        feature.id = row.id;
        let added = match row.geometry {
            Ok(None) => return Ok(true),
            Ok(Some(blob)) => catch(|| add_blob(&blob, feature)),
            Err(problem) => Some(Err(problem.to_owned())),
        };
        let problem = match added {
            Some(Ok(())) => return Ok(true),
            Some(Err(problem)) => problem,
            None => "its geometry cannot be decoded".to_owned(),
        };
        let problem = format!("row {} is invalid: {problem}", row.number);
        let location = Location::Feature(number);
        Err(InputError::malformed(
            &self.watch.path,
            location,
            problem,
            "the file is damaged",
        ))
    }

    fn keep_ids(&mut self, field: &str) {
        self.field = Some(field.into());
    }

    fn fields(&self) -> Vec<Field> {
        layers::fields(&self.connection, &self.layer)
    }

    fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }
}

/// Returns the id that a value is, as GeoJSON with the same value would give it; `None` if it is
/// null.
fn id_of(value: ValueRef) -> Option<FoundId> {
    Some(match value {
        ValueRef::Null => return None,
        ValueRef::Integer(number) => SiteId::from_field(number.to_string().as_bytes()),
        ValueRef::Real(number) => SiteId::from_field(format!("{number:?}").as_bytes()),
        ValueRef::Text(text) => match std::str::from_utf8(text) {
            Ok(text) => SiteId::from_text(text),
            Err(_) => Err(Flaw::IdNotUtf8),
        },
        ValueRef::Blob(_) => Err(Flaw::IdOfWrongType),
    })
}
