//! The measurements of one process, from outside and as it reports them.

use anyhow::Context;
use serde::Deserialize;

use super::plan::{BuildPlan, Data};
use crate::peer::Peer;
use crate::table::{Cell, Column};
use limited::{Ended, Limit, Took};
use tiletool::common::share;

/// A triangulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// `tiletool build`.
    Ours,
    Peer(Peer),
}

impl Engine {
    /// Returns its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ours => "tiletool",
            Self::Peer(peer) => peer.name(),
        }
    }
}

/// The measurements of one process.
#[derive(Clone, Debug)]
pub struct Record {
    pub engine: Engine,
    pub data: Data,
    pub round: u32,
    /// The hard limit of its memory, in bytes.
    pub limit: Option<u64>,
    pub took: Took,
    input_bytes: u64,
    /// Its own report; `None` if it did not succeed, or reports nothing.
    summary: Option<Summary>,
}

/// The keys of `tiletool build --json` that are used; `lab peer` has some of them.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct Summary {
    triangles: u64,
    constraint_edges: u64,
    vertices: u64,
    segments: u64,
    border_triangles: u64,
    held_triangles: u64,
    deferred_segments: u64,
    tiles: u64,
    blocks: u64,
    file_bytes: u64,
    peak_memory_bytes: Option<u64>,
    phases: Vec<Phase>,
    levels: Vec<Level>,
    waits: Waits,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct Phase {
    bytes_read: u64,
    bytes_written: u64,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct Level {
    seam_share: f64,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct Waits {
    computing_for_blocks: f64,
    computing_for_writing: f64,
}

impl Record {
    /// Creates a record, and parses the process's own report, if it gives one.
    pub fn new(
        engine: Engine,
        data: Data,
        round: u32,
        limit: Option<u64>,
        input_bytes: u64,
        took: Took,
    ) -> anyhow::Result<Self> {
        let has_report = took.ended == Ended::Done && engine != Engine::Peer(Peer::Triangle);
        let parsed = has_report.then(|| serde_json::from_str(&took.output)).transpose();
        let summary = parsed.with_context(|| format!("{data}: {} printed no valid report", engine.name()))?;
        Ok(Self {
            engine,
            data,
            round,
            limit,
            took,
            input_bytes,
            summary,
        })
    }

    /// Returns whether it succeeded.
    pub fn is_done(&self) -> bool {
        self.took.ended == Ended::Done
    }

    /// Returns the seconds of processor time.
    pub fn cpu(&self) -> Option<f64> {
        Some(self.took.user_seconds? + self.took.system_seconds?)
    }

    /// Returns the seconds that all computing threads together waited for the disk.
    pub fn waited(&self) -> Option<f64> {
        let waits = &self.ours()?.waits;
        Some(waits.computing_for_blocks + waits.computing_for_writing)
    }

    /// Returns the bytes that it reports to have read.
    pub fn read(&self) -> Option<u64> {
        match self.engine {
            Engine::Ours => Some(self.ours()?.phases.iter().map(|phase| phase.bytes_read).sum()),
            Engine::Peer(Peer::Spade) => self.summary.as_ref().map(|_| self.input_bytes),
            Engine::Peer(Peer::Triangle) => None,
        }
    }

    /// Returns the bytes that it reports to have written.
    pub fn written(&self) -> Option<u64> {
        Some(self.ours()?.phases.iter().map(|phase| phase.bytes_written).sum())
    }

    /// Returns the vertices that tiles handed up, as a share of all vertices.
    pub fn seam_share(&self) -> Option<f64> {
        let ours = self.ours()?;
        Some(ours.levels.first().map_or(0.0, |level| level.seam_share))
    }

    /// Returns the triangles that only a merge settled, as a share of all triangles.
    pub fn border_share(&self) -> Option<f64> {
        self.ours().map(|ours| share(ours.border_triangles, ours.triangles))
    }

    /// Returns the triangles that were held for segments, as a share of all triangles.
    pub fn held_share(&self) -> Option<f64> {
        self.ours().map(|ours| share(ours.held_triangles, ours.triangles))
    }

    /// Returns the number of blocks that the points were divided into; 1 if all were in memory.
    pub fn blocks(&self) -> Option<u64> {
        self.ours().map(|ours| ours.blocks)
    }

    /// Returns the peak of its resident memory, in bytes.
    pub fn peak(&self) -> Option<u64> {
        let own = self.summary.as_ref().and_then(|summary| summary.peak_memory_bytes);
        own.max(self.took.peak)
    }

    fn ours(&self) -> Option<&Summary> {
        self.summary.as_ref().filter(|_| self.engine == Engine::Ours)
    }

    /// Returns a count of its own report, as a cell.
    fn reported(&self, count: fn(&Summary) -> u64) -> Cell {
        Cell::count(self.summary.as_ref().map(count))
    }

    /// Returns a count of its own report, as a cell; missing for peers.
    fn ours_reported(&self, count: fn(&Summary) -> u64) -> Cell {
        Cell::count(self.ours().map(count))
    }
}

/// Returns the median by time of the processes with the same engine, data and limit; a process that
/// was ended precedes all others.
pub fn median<'a>(records: &'a [Record], engine: Engine, data: &Data, limit: Option<u64>) -> Option<&'a Record> {
    let is_one = |record: &&Record| record.engine == engine && record.data == *data && record.limit == limit;
    let mut same: Vec<_> = records.iter().filter(is_one).collect();
    same.sort_by(|a, b| {
        let key = |record: &Record| (record.is_done(), record.took.seconds);
        key(a).0.cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1))
    });
    match same.first() {
        Some(first) if first.is_done() => same.get((same.len() - 1) / 2).copied(),
        first => first.copied(),
    }
}

/// Says where a peer counts other triangles or constraint edges than we do: one of the two is
/// wrong.
pub fn contradictions(records: &[Record]) -> Vec<String> {
    let mut notes = Vec::new();
    for peer in records.iter().filter(|record| record.engine != Engine::Ours) {
        let ours = median(records, Engine::Ours, &peer.data, None).and_then(Record::ours);
        let (Some(ours), Some(its)) = (ours, &peer.summary) else {
            continue;
        };
        let counts = |summary: &Summary| (summary.triangles, summary.constraint_edges);
        if counts(ours) != counts(its) {
            let (name, data) = (peer.engine.name(), peer.data);
            let note = format!(
                "{data}: {name} counts {} triangles and {} constraint edges, tiletool {} and {}.",
                its.triangles, its.constraint_edges, ours.triangles, ours.constraint_edges
            );
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
    }
    notes
}

/// All columns about a process.
pub const COLUMNS: &[Column<Record>] = &[
    ("engine", |r| r.engine.name().into()),
    ("distribution", |r| r.data.kind.name().into()),
    ("points", |r| r.data.points.into()),
    ("alpha", |r| Cell::number(r.data.alpha, 2)),
    ("round", |r| u64::from(r.round).into()),
    ("limit_bytes", |r| Cell::count(r.limit)),
    ("ended", |r| {
        Cell::Text(match r.took.ended {
            Ended::Done => "done".to_owned(),
            Ended::Failed(code) => format!("failed {code}"),
            Ended::Killed(signal) => format!("killed {signal}"),
        })
    }),
    ("seconds", |r| Cell::Number(r.took.seconds, 3)),
    ("user_seconds", |r| Cell::number(r.took.user_seconds, 3)),
    ("system_seconds", |r| Cell::number(r.took.system_seconds, 3)),
    ("off_cpu_seconds", |r| {
        Cell::number(r.cpu().map(|cpu| (r.took.seconds - cpu).max(0.0)), 3)
    }),
    ("waited_thread_seconds", |r| Cell::number(r.waited(), 3)),
    ("bytes_read", |r| Cell::count(r.read())),
    ("bytes_written", |r| Cell::count(r.written())),
    ("storage_bytes_read", |r| Cell::count(r.took.storage_read)),
    ("storage_bytes_written", |r| Cell::count(r.took.storage_written)),
    ("peak_memory_bytes", |r| Cell::count(r.peak())),
    ("vertices", |r| r.reported(|its| its.vertices)),
    ("triangles", |r| r.reported(|its| its.triangles)),
    ("segments", |r| r.ours_reported(|ours| ours.segments)),
    ("constraint_edges", |r| r.reported(|its| its.constraint_edges)),
    ("seam_share", |r| Cell::number(r.seam_share(), 4)),
    ("border_share", |r| Cell::number(r.border_share(), 4)),
    ("held_share", |r| Cell::number(r.held_share(), 4)),
    ("deferred_segments", |r| r.ours_reported(|ours| ours.deferred_segments)),
    ("blocks", |r| Cell::count(r.blocks())),
    ("tiles", |r| r.ours_reported(|ours| ours.tiles)),
    ("file_bytes", |r| r.ours_reported(|ours| ours.file_bytes)),
];

/// All measurements, and their conditions.
pub struct Measured {
    pub records: Vec<Record>,
    pub notes: Vec<String>,
    pub plan: BuildPlan,
    pub threads: u32,
    pub memory: u64,
    pub limit: Limit,
    pub rounds: u32,
}
