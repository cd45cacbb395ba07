//! The layers of a file, which are its feature tables, and their coordinate reference systems.

use crate::input::about::{Field, MOST_FIELDS};
use crate::input::error::{InputError, Location};
use crate::input::formats::geopackage::database::damaged;
use crate::shown;
use rusqlite::{Connection, OptionalExtension};
use std::path::Path;

/// The limit on the number of layers that are read, and of those that a message lists.
const MOST: u32 = 1000;
const MOST_SHOWN: usize = 20;

/// The names of the number of a row, each of which a column of the same name hides.
const ROW_NUMBERS: [&str; 3] = ["rowid", "_rowid_", "oid"];

/// A feature table.
pub struct Layer {
    pub table: String,
    /// The column of the geometries.
    pub column: String,
    geometry_type: String,
    /// The name of the number of a row.
    pub number: &'static str,
    srs: Option<i64>,
}

/// A column of a table.
pub struct Column {
    pub name: String,
    /// The type, as the file declares it.
    pub kind: String,
    /// Whether SQLite computes its values when they are read.
    pub is_computed: bool,
}

/// A layer in the list of a file.
pub struct ListedLayer {
    pub name: String,
    /// The type of its geometries, as the file declares it.
    pub geometry_type: String,
}

/// Returns all layers.
pub fn list(connection: &Connection, path: &Path) -> Result<Vec<ListedLayer>, InputError> {
    let layers = layers(connection).map_err(|error| damaged(path, "its layers cannot be read", error))?;
    let listed = layers.into_iter().map(|layer| ListedLayer {
        name: layer.table,
        geometry_type: layer.geometry_type,
    });
    Ok(listed.collect())
}

/// Returns the columns of a layer other than that of the geometries. Errors are ignored, since this
/// is only metadata.
pub fn fields(connection: &Connection, layer: &Layer) -> Vec<Field> {
    let columns = columns(connection, &layer.table).unwrap_or_default();
    let others = columns.into_iter().filter(|column| column.name != layer.column);
    let fields = others.map(|column| Field::new(column.name, column.kind));
    fields.take(MOST_FIELDS).collect()
}

/// Returns the layer `name`, or the only one.
pub fn find_layer(connection: &Connection, path: &Path, name: Option<&str>) -> Result<Layer, InputError> {
    let mut layers = layers(connection).map_err(|error| damaged(path, "its layers cannot be read", error))?;
    let (problem, hint) = match name {
        Some(name) => match layers.iter().position(|layer| layer.table == name) {
            Some(at) => return check_table(connection, path, layers.swap_remove(at)),
            None => (
                format!("there is no layer `{}`", shown::text(name)),
                "give one of these",
            ),
        },
        None if layers.len() == 1 => return check_table(connection, path, layers.swap_remove(0)),
        None if layers.is_empty() => (
            "there are no layers with features".to_owned(),
            "add one, or give another file",
        ),
        None => (
            format!("there are {} layers", layers.len()),
            "give the one to read as FILE.gpkg:LAYER",
        ),
    };
    let names = layers
        .iter()
        .take(MOST_SHOWN)
        .map(|layer| shown::text(&layer.table).to_string());
    let mut names: Vec<String> = names.collect();
    if layers.len() > MOST_SHOWN {
        names.push("…".to_owned());
    }
    let problem = match names.is_empty() {
        true => problem,
        false => format!("{problem}: {}", names.join(", ")),
    };
    Err(InputError::malformed(path, Location::File, problem, hint))
}

/// Returns all feature tables, in the order of the list in the file.
fn layers(connection: &Connection) -> rusqlite::Result<Vec<Layer>> {
    let mut statement = connection.prepare(
        "SELECT c.table_name, g.column_name, g.srs_id, g.geometry_type_name FROM gpkg_contents AS c JOIN gpkg_geometry_columns AS g \
         ON g.table_name = c.table_name WHERE c.data_type = 'features' ORDER BY c.rowid LIMIT ?1",
    )?;
    let rows = statement.query_map([MOST], |row| {
        Ok(Layer {
            table: row.get(0)?,
            column: row.get(1)?,
            number: ROW_NUMBERS[0],
            srs: row.get(2)?,
            // It is only shown.
            geometry_type: row.get(3).unwrap_or_default(),
        })
    })?;
    rows.collect()
}

/// Fails if a layer is not a table that is in the file as it is. Finds the name of the numbers of
/// its rows.
fn check_table(connection: &Connection, path: &Path, mut layer: Layer) -> Result<Layer, InputError> {
    let refused = |what: &str| {
        let problem = format!("the layer `{}` {what}", shown::text(&layer.table));
        InputError::malformed(path, Location::File, problem, "copy it to a plain table, and give that")
    };
    let unreadable = |error| damaged(path, "its tables cannot be read", error);
    // A virtual table has no page of its own.
    let sql = "SELECT type = 'table' AND rootpage > 0 FROM sqlite_schema WHERE name = ?1 COLLATE NOCASE";
    let is_table = connection.query_row(sql, [&layer.table], |row| row.get::<_, bool>(0));
    match is_table.optional().map_err(unreadable)? {
        Some(true) => {}
        Some(false) => return Err(refused("is a view or a virtual table")),
        None => return Err(refused("is not in the file")),
    }
    let columns = columns(connection, &layer.table).map_err(unreadable)?;
    match find_column(&columns, &layer.column) {
        Some(column) if !column.is_computed => {}
        Some(_) => return Err(refused("computes its geometries")),
        None => return Err(refused("has no column of geometries")),
    }
    let Some(number) = ROW_NUMBERS
        .into_iter()
        .find(|name| find_column(&columns, name).is_none())
    else {
        return Err(refused("has columns that hide the numbers of its rows"));
    };
    layer.number = number;
    Ok(layer)
}

/// Returns the columns of a table.
pub fn columns(connection: &Connection, table: &str) -> rusqlite::Result<Vec<Column>> {
    let mut statement = connection.prepare("SELECT name, hidden = 2, type FROM pragma_table_xinfo(?1)")?;
    let rows = statement.query_map([table], |row| {
        Ok(Column {
            name: row.get(0)?,
            is_computed: row.get(1)?,
            kind: row.get(2).unwrap_or_default(),
        })
    })?;
    rows.collect()
}

/// Returns the column with this name, as SQLite would.
pub fn find_column<'a>(columns: &'a [Column], name: &str) -> Option<&'a Column> {
    columns.iter().find(|column| column.name.eq_ignore_ascii_case(name))
}

/// Returns the coordinate reference system of a layer: `EPSG:…`, or else WKT. Errors are ignored,
/// since this is only metadata.
pub fn crs(connection: &Connection, layer: &Layer) -> Option<String> {
    // 0 and -1 mean that it is not known.
    let srs = layer.srs.filter(|srs| *srs > 0)?;
    let sql = "SELECT organization, organization_coordsys_id, definition FROM gpkg_spatial_ref_sys WHERE srs_id = ?1";
    let (organization, code, definition) = connection
        .query_row(sql, [srs], |row| {
            Ok((
                row.get::<_, String>(0)?,
                row.get::<_, i64>(1)?,
                row.get::<_, Option<String>>(2)?,
            ))
        })
        .ok()?;
    if organization.eq_ignore_ascii_case("EPSG") && code > 0 {
        return Some(format!("EPSG:{code}"));
    }
    let definition = definition?.trim().to_owned();
    (!definition.is_empty() && definition != "undefined").then_some(definition)
}
