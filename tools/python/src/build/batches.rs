//! Rows of arrays and of Arrow record batches, as the library's batches of points and sites.

use arrow_array::cast::AsArray;
use arrow_array::types::{
    Decimal128Type, Decimal256Type, DecimalType, Float16Type, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type,
    Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrayRef, Float64Array, PrimitiveArray, RecordBatch};
use arrow_schema::DataType;
use delaunay_tiles::Point;
use delaunay_tiles::input::{PointBatch, SiteBatch, SiteId};
use numpy::ndarray::ArrayView2;

use crate::error::{Failure, Outcome};

/// The number of points of a batch.
pub const ROWS: usize = 8192;

/// Fills a batch with rows of x, y and perhaps z. Their records are numbered from `first` on.
pub fn fill(batch: &mut PointBatch, rows: ArrayView2<'_, f64>, first: u64) {
    batch.clear();
    let has_z = rows.ncols() > 2;
    match rows.as_slice() {
        // The same as below, twice as fast.
        Some(values) if has_z => {
            let (rows, _) = values.as_chunks::<3>();
            batch
                .points
                .extend(rows.iter().map(|&[x, y, _]| Point::new(x, y).normalized()));
            batch.z.extend(rows.iter().map(|&[.., z]| z + 0.0));
        }
        Some(values) => {
            let (rows, _) = values.as_chunks::<2>();
            batch
                .points
                .extend(rows.iter().map(|&[x, y]| Point::new(x, y).normalized()));
        }
        None => {
            batch
                .points
                .extend(rows.outer_iter().map(|row| Point::new(row[0], row[1]).normalized()));
            if has_z {
                batch.z.extend(rows.column(2).iter().map(|z| z + 0.0));
            }
        }
    }
    batch.records.extend((first..).take(rows.nrows()));
}

/// Returns rows as sites with these ids, or with their numbers from `first` on.
pub fn sites(rows: ArrayView2<'_, f64>, ids: Option<Vec<String>>, first: u64) -> Outcome<SiteBatch> {
    let mut points = PointBatch::default();
    fill(&mut points, rows, 0);
    let ids: Vec<SiteId> = match ids {
        None => (first..).take(points.len()).map(SiteId::Number).collect(),
        Some(ids) if ids.len() == points.len() => {
            // A number that is an id is the number of its site too. Among texts, it could be that of another site.
            let are_numbers = ids.iter().all(|id| number(id).is_some());
            ids.into_iter()
                .map(|text| id(text, are_numbers))
                .collect::<Outcome<_>>()?
        }
        Some(ids) => {
            return Err(Failure::value(format!(
                "there are {} ids for {} sites; give one for each",
                ids.len(),
                points.len()
            )));
        }
    };
    let PointBatch { points, z, .. } = points;
    Ok(SiteBatch { points, z, ids })
}

/// Returns the number that a text is, written without sign, fraction and leading zeros.
fn number(text: &str) -> Option<u64> {
    text.parse::<u64>().ok().filter(|number| number.to_string() == text)
}

/// Returns a text as an id: a number if `is_number`.
fn id(text: String, is_number: bool) -> Outcome<SiteId> {
    match number(&text).filter(|_| is_number) {
        Some(number) => Ok(SiteId::Number(number)),
        None if text.is_empty() || text.len() > SiteId::LONGEST => Err(Failure::value(format!(
            "an id of a site must have from 1 to {} bytes, not {}",
            SiteId::LONGEST,
            text.len()
        ))),
        None => Ok(SiteId::Text(text)),
    }
}

/// Fills a batch with the points of a record batch: of the columns `x`, `y` and perhaps `z`, or of a
/// column of GeoArrow points.
pub fn fill_from_arrow(batch: &mut PointBatch, records: &RecordBatch, first: u64) -> Outcome<()> {
    let (x, y, z) = coordinates(records)?;
    batch.clear();
    let points = x.values().iter().zip(y.values());
    batch
        .points
        .extend(points.map(|(&x, &y)| Point::new(x, y).normalized()));
    if let Some(z) = z {
        batch.z.extend(z.values().iter().map(|z| z + 0.0));
    }
    batch.records.extend((first..).take(records.num_rows()));
    Ok(())
}

/// Returns the columns of the coordinates.
fn coordinates(records: &RecordBatch) -> Outcome<(Float64Array, Float64Array, Option<Float64Array>)> {
    let named = |names: [&str; 3]| {
        let schema = records.schema_ref();
        let found = |name: &&str| {
            schema
                .fields()
                .iter()
                .position(|field| field.name().eq_ignore_ascii_case(name))
        };
        names
            .iter()
            .find_map(|name| found(name).map(|at| (records.column(at), schema.field(at).name().clone())))
    };
    let x = named(["x", "lon", "longitude"]);
    let y = named(["y", "lat", "latitude"]);
    if let (Some((x, x_name)), Some((y, y_name))) = (x, y) {
        let z = named(["z", "height", "elevation"]);
        let z = z.map(|(z, name)| numbers(z, &name)).transpose()?;
        return Ok((numbers(x, &x_name)?, numbers(y, &y_name)?, z));
    }
    for (field, column) in records.schema_ref().fields().iter().zip(records.columns()) {
        let extension = field.metadata().get("ARROW:extension:name").map(String::as_str);
        if extension == Some("geoarrow.point") {
            return of_points(column, field.name());
        }
    }
    let names: Vec<&str> = records
        .schema_ref()
        .fields()
        .iter()
        .map(|field| field.name().as_str())
        .collect();
    Err(Failure::value(format!(
        "the table has no columns x and y, nor one of GeoArrow points; it has {}",
        names.join(", ")
    )))
}

/// Returns the coordinates of a column of GeoArrow points, separated or interleaved.
fn of_points(column: &ArrayRef, name: &str) -> Outcome<(Float64Array, Float64Array, Option<Float64Array>)> {
    let unknown = || {
        Failure::value(format!(
            "the points of column {name} have no layout that GeoArrow defines"
        ))
    };
    if column.null_count() > 0 {
        return Err(Failure::value(format!("column {name} has nulls; leave these rows out")));
    }
    if let Some(parts) = column.as_struct_opt() {
        let part = |name| parts.column_by_name(name).map(|part| numbers(part, name)).transpose();
        return Ok((
            part("x")?.ok_or_else(unknown)?,
            part("y")?.ok_or_else(unknown)?,
            part("z")?,
        ));
    }
    let lists = column.as_fixed_size_list_opt().ok_or_else(unknown)?;
    let width = usize::try_from(lists.value_length()).unwrap_or(0);
    let values = numbers(lists.values(), name)?;
    let from = lists.offset() * width;
    let every = |start: usize| -> Float64Array {
        let values = values.values().iter().skip(from + start).step_by(width.max(1));
        values.take(lists.len()).copied().collect::<Vec<_>>().into()
    };
    match width {
        2 => Ok((every(0), every(1), None)),
        3 => Ok((every(0), every(1), Some(every(2)))),
        _ => Err(unknown()),
    }
}

/// Returns a column as numbers. Casting by crate `arrow-cast` would make the wheel a tenth larger.
fn numbers(column: &ArrayRef, name: &str) -> Outcome<Float64Array> {
    if column.null_count() > 0 {
        return Err(Failure::value(format!("column {name} has nulls; leave these rows out")));
    }
    macro_rules! converted {
        ($($kind:ident => $type:ty),*) => {
            match column.data_type() {
                DataType::Float64 => Some(column.as_primitive::<Float64Type>().clone()),
                $(DataType::$kind => Some(column.as_primitive::<$type>().unary(|value| value as f64)),)*
                DataType::Float16 => Some(column.as_primitive::<Float16Type>().unary(f64::from)),
                DataType::Decimal128(..) => decimals(column.as_primitive::<Decimal128Type>()),
                DataType::Decimal256(..) => decimals(column.as_primitive::<Decimal256Type>()),
                _ => None,
            }
        };
    }
    let values = converted!(
        Float32 => Float32Type, Int8 => Int8Type, Int16 => Int16Type, Int32 => Int32Type, Int64 => Int64Type,
        UInt8 => UInt8Type, UInt16 => UInt16Type, UInt32 => UInt32Type, UInt64 => UInt64Type
    );
    values.ok_or_else(|| {
        let kind = column.data_type();
        Failure::of_type(format!("column {name} must hold numbers, not {kind}"))
    })
}

/// Returns decimals as the numbers that are nearest to them.
fn decimals<T: DecimalType>(column: &PrimitiveArray<T>) -> Option<Float64Array> {
    let numbers = (0..column.len()).map(|row| column.value_as_string(row).parse());
    Some(Float64Array::from(numbers.collect::<Result<Vec<f64>, _>>().ok()?))
}
