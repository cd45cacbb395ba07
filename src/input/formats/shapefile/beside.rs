//! The files beside a `.shp` file.

use crate::input::about::Field;
use crate::input::caught::catch;
use crate::input::error::{InputError, Location};
use crate::input::flaw::Flaw;
use crate::input::formats::shapes::FoundId;
use crate::input::sites::SiteId;
use crate::input::watch::{Watch, Watched};
use ::shapefile::dbase;
use ::shapefile::dbase::encoding::UnicodeLossy;
use std::error::Error;
use std::fs;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The limit on the length in bytes of a coordinate reference system.
const LONGEST_WKT: u64 = 1 << 20;

/// The fields of the features.
type Table = dbase::File<BufReader<Watched<Arc<File>>>>;

/// Opens the file with the suffix `suffix` beside the `.shp` file, in either case; `None` if there
/// is none.
fn open_beside(watch: &Watch, suffix: &str) -> Option<(PathBuf, Watched<Arc<File>>)> {
    let path = &*watch.path;
    let is_gzip = path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("gz"));
    let stem = if is_gzip {
        path.with_extension("")
    } else {
        path.to_owned()
    };
    // A stream has no suffix, and nothing beside it.
    stem.extension()?;
    [suffix.to_owned(), suffix.to_ascii_uppercase()]
        .into_iter()
        .find_map(|suffix| {
            let beside = stem.with_extension(suffix);
            // To open a pipe would wait for a writer.
            fs::metadata(&beside).ok().filter(fs::Metadata::is_file)?;
            watch.open_beside(&beside).ok().map(|file| (beside, file))
        })
}

/// Returns the WKT in the `.prj` file. Errors are ignored, since this is only metadata.
pub fn crs_beside(watch: &Watch) -> Option<String> {
    let (_, file) = open_beside(watch, "prj")?;
    let mut text = Vec::new();
    file.take(LONGEST_WKT).read_to_end(&mut text).ok()?;
    let text = String::from_utf8_lossy(&text).trim().to_owned();
    (!text.is_empty()).then_some(text)
}

/// Returns the fields of the `.dbf` file. Errors are ignored, since this is only metadata.
pub fn fields_beside(watch: &Watch) -> Vec<Field> {
    let table = open_beside(watch, "dbf").and_then(|(_, file)| open_table(file)?.ok());
    let field =
        |field: &dbase::FieldInfo| Field::new(field.name(), format!("{:?}({})", field.field_type(), field.length()));
    table.map_or_else(Vec::new, |table| table.fields().iter().map(field).collect())
}

/// Opens a table; `None` if the crate panics.
fn open_table(file: Watched<Arc<File>>) -> Option<Result<Table, dbase::Error>> {
    catch(|| Table::open_with_encoding(BufReader::new(file), UnicodeLossy))
}

/// The ids of the features, from a field of the `.dbf` file.
pub struct Ids {
    watch: Arc<Watch>,
    /// The path of the table once it is open; before, that of the `.shp` file.
    path: PathBuf,
    field: Box<str>,
    /// The table, or `None` before it is opened.
    table: Option<(Table, usize)>,
}

impl Ids {
    pub fn new(watch: &Arc<Watch>, field: &str) -> Self {
        Self {
            watch: Arc::clone(watch),
            path: watch.path.to_path_buf(),
            field: field.into(),
            table: None,
        }
    }

    /// Returns the id of a feature; `None` if it has none.
    pub fn id(&mut self, number: u64) -> Result<Option<FoundId>, InputError> {
        let (table, column) = match &mut self.table {
            Some(table) => table,
            None => {
                let table = self.open()?;
                self.table.insert(table)
            }
        };
        let read = catch(|| {
            let mut record = table.record(usize::try_from(number).ok()?)?;
            Some(record.read_field(dbase::FieldIndex(*column)))
        });
        match read {
            Some(Some(Ok(value))) => Ok(id_of(value)),
            Some(None) => Ok(None),
            Some(Some(Err(error))) => Err(damaged(&self.path, Location::Feature(number), Some(Box::new(error)))),
            None => Err(damaged(&self.path, Location::Feature(number), None)),
        }
    }

    /// Opens the table and finds the field.
    fn open(&mut self) -> Result<(Table, usize), InputError> {
        let Some((path, file)) = open_beside(&self.watch, "dbf") else {
            let problem = format!(
                "there is no .dbf file beside it, which would have the field `{}`",
                self.field
            );
            let hint = "put it there, or select no field for the ids";
            return Err(InputError::malformed(&self.path, Location::File, problem, hint));
        };
        self.path = path;
        let table = match open_table(file) {
            Some(Ok(table)) => table,
            Some(Err(error)) => return Err(damaged(&self.path, Location::File, Some(Box::new(error)))),
            None => return Err(damaged(&self.path, Location::File, None)),
        };
        let names: Vec<&str> = table.fields().iter().map(dbase::FieldInfo::name).collect();
        match names.iter().position(|name| name.eq_ignore_ascii_case(&self.field)) {
            Some(column) => Ok((table, column)),
            None => {
                let problem = format!("there is no field `{}`; there are {}", self.field, names.join(", "));
                let hint = "select one of these for the ids, or none";
                Err(InputError::malformed(&self.path, Location::File, problem, hint))
            }
        }
    }
}

fn damaged(path: &Path, location: Location, source: Option<Box<dyn Error + Send + Sync>>) -> InputError {
    InputError::Malformed {
        path: path.to_owned(),
        location,
        problem: "the fields cannot be read".to_owned(),
        hint: "the file is damaged or cut short",
        source,
    }
}

/// Returns the id that a value is, as GeoJSON with the same value would give it; `None` if it is
/// null.
fn id_of(value: dbase::FieldValue) -> Option<FoundId> {
    use dbase::FieldValue;
    let number = match value {
        FieldValue::Character(text) => return text.map(|text| SiteId::from_text(&text)),
        FieldValue::Memo(text) => return Some(SiteId::from_text(&text)),
        FieldValue::Numeric(number) => number?.to_string(),
        FieldValue::Float(number) => number?.to_string(),
        FieldValue::Double(number) | FieldValue::Currency(number) => number.to_string(),
        FieldValue::Integer(number) => number.to_string(),
        _ => return Some(Err(Flaw::IdOfWrongType)),
    };
    Some(SiteId::from_field(number.as_bytes()))
}
