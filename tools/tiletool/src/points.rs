//! Points of files on their way to a builder.

use std::path::PathBuf;

use delaunay_tiles::Builder;
use delaunay_tiles::input::{InputError, PointBatch, PointSource};
use serde::{Deserialize, Serialize};
use tokio::sync::{Notify, mpsc};

use crate::common;
use crate::crs::Extents;

/// Number of sampled points that show a build in advance how the points are distributed.
pub const SAMPLE: usize = 1 << 16;

/// Maximum number of batches that wait between the reader and the builder.
const BATCHES_AHEAD: usize = 8;

/// What was read of inputs of points.
#[derive(Debug, Default, Deserialize, Serialize)]
pub struct PointsRead {
    pub records: u64,
    pub withheld: u64,
    pub filtered: u64,
    pub invalid: u64,
    pub bytes: u64,
    pub notes: Vec<String>,
    /// The name and the number of records of each input.
    pub sources: Vec<(String, u64)>,
    /// The coordinate reference systems that inputs name.
    pub crs: Vec<(PathBuf, String)>,
}

impl PointsRead {
    /// Returns what was read of a source that has ended.
    pub fn of(source: &PointSource) -> Self {
        let counts = source.counts();
        Self {
            records: counts.records,
            withheld: counts.withheld,
            filtered: counts.filtered,
            invalid: counts.invalid,
            bytes: counts.bytes_read,
            notes: source.notes().to_vec(),
            sources: source.sources().to_vec(),
            crs: source.crs_of_files().to_vec(),
        }
    }

    /// Adds what was read of the inputs behind these.
    pub fn add(&mut self, other: Self) {
        self.records += other.records;
        self.withheld += other.withheld;
        self.filtered += other.filtered;
        self.invalid += other.invalid;
        self.bytes += other.bytes;
        self.notes.extend(other.notes);
        self.sources.extend(other.sources);
        self.crs.extend(other.crs);
    }
}

/// Returns whether the error says that reading was stopped.
pub fn is_stopped(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(InputError::Stopped))
}

/// Reads all points of files and passes them to a builder. Their records are numbered from
/// `first_record` on. `are_all` tells whether the builder gets all points that the files announce, and
/// no others.
pub async fn push_points(
    mut source: PointSource,
    builder: &mut Builder,
    first_record: u64,
    are_all: bool,
    extents: &mut Extents,
    cancelled: &Notify,
) -> anyhow::Result<PointSource> {
    let (sender, mut batches) = mpsc::channel::<PointBatch>(BATCHES_AHEAD);
    // With a filter, the number of points that a file announces says little, so it is not used.
    if let Some(points) = source.expected_points().filter(|_| are_all) {
        let sample;
        (sample, source) = common::on_thread("sample", move || Ok((source.sample(SAMPLE)?, source))).await?;
        builder.expect(points, sample)?;
    }
    let reading = common::begin("reading", move || {
        let mut batch = PointBatch::default();
        while source.next_batch(&mut batch)? {
            if sender.blocking_send(std::mem::take(&mut batch)).is_err() {
                break;
            }
        }
        Ok(source)
    })?;
    loop {
        let batch = tokio::select! {
            batch = batches.recv() => batch,
            // A build that waits for a pipe must notice the cancellation too. The builder then
            // returns the error.
            () = cancelled.notified() => Some(PointBatch::default()),
        };
        let Some(mut batch) = batch else { break };
        batch
            .records
            .iter_mut()
            .for_each(|record| *record = record.saturating_add(first_record));
        extents.add_points(&batch.points);
        builder.push(&batch).await?;
    }
    match reading.await {
        // The builder decides whether its work is kept, so its error comes first.
        Err(error) if is_stopped(&error) => {
            let pushed = builder.push(&PointBatch::default()).await;
            Err(pushed.err().map_or(error, Into::into))
        }
        source => source,
    }
}
