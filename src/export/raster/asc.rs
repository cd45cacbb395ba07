//! Esri's ASCII grid: a header, then rows of numbers, the northern one first.
//!
//! Numbers are written in full: they parse to the same bits.

use std::io::Write;

use super::job::{RasterJob, Unit};
use super::samples::Samples;
use crate::export::error::ExportError;
use crate::export::output::Output;
use crate::export::text::{put, put_number};
use crate::terrain::{Block, Grid};

/// The number of cells that are formatted at once.
const PART: usize = 1 << 15;

/// Writes a raster.
pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut RasterJob<'_>,
    samples: Samples,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    output.push(header(job.grid(), samples)).await?;
    let unit = Unit {
        rows: 1,
        may_split: false,
    };
    job.for_each_block(unit, async |job, block| {
        let rows_each = PART.div_ceil(block.columns());
        let parts = (0..block.rows()).step_by(rows_each);
        let parts = parts.map(|start| start..block.rows().min(start + rows_each));
        let format = move |block: &Block, rows| text(block, rows, samples);
        job.encode(&block, parts.collect(), format, output).await
    })
    .await
}

fn header(grid: &Grid, samples: Samples) -> Vec<u8> {
    let (columns, rows, bounds) = (grid.columns(), grid.rows(), grid.bounds());
    let mut out = Vec::new();
    put(&mut out, format_args!("ncols {columns}\nnrows {rows}\n"));
    let size = grid.resolution();
    for (name, number) in [
        ("xllcorner", bounds.min_x),
        ("yllcorner", bounds.min_y),
        ("cellsize", size),
    ] {
        put(&mut out, format_args!("{name} "));
        put_number(&mut out, number);
        out.push(b'\n');
    }
    put(&mut out, format_args!("NODATA_value {}\n", samples.no_data()));
    out
}

fn text(block: &Block, rows: std::ops::Range<usize>, samples: Samples) -> Vec<u8> {
    let mut out = Vec::new();
    for row in rows {
        let mut separator = None;
        for value in block.row(row, 0..block.columns()) {
            out.extend(separator);
            separator = Some(b' ');
            let stored = samples.stored(value);
            match samples {
                Samples::Float64 if stored != samples.no_data() => put_number(&mut out, stored),
                Samples::Float32 if stored != samples.no_data() => put(&mut out, format_args!("{:?}", stored as f32)),
                _ => put(&mut out, format_args!("{stored}")),
            }
        }
        out.push(b'\n');
    }
    out
}
