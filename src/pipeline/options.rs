//! Options and progress of a build.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};

use crate::input::MissingZ;
use crate::memory::{MemoryPlan, default_memory};
use crate::mesh::EngineKind;
use crate::pipeline::error::BuildError;
use crate::pipeline::task_store::TaskStore;
use crate::store;
use crate::store::Codec;

/// Options of a build. They do not change once they are given to a [`Builder`](crate::Builder).
///
/// # Example
///
/// ```
/// use delaunay_tiles::{BuildOptions, Crossings};
///
/// let options = BuildOptions::default().memory(256 << 20).crossings(Crossings::Split);
/// assert_eq!(options.memory, 256 << 20);
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct BuildOptions {
    /// The most vertices of a tile, from [`MIN_TILE_VERTICES`](Self::MIN_TILE_VERTICES) to
    /// [`MAX_TILE_VERTICES`](Self::MAX_TILE_VERTICES).
    pub tile_vertices: usize,
    /// The most seam vertices that one merge takes. A merge of two seams may take more.
    pub merge_vertices: usize,
    /// Number of threads that compute, from 1 to 1024.
    pub threads: usize,
    /// Bytes of memory that the build may request from the allocator. An allocator may keep more
    /// after memory is freed. With glibc this is little if there is one arena (`M_ARENA_MAX`) and
    /// large allocations are mapped (`M_MMAP_THRESHOLD`).
    pub memory: u64,
    /// The in-core engine.
    pub engine: EngineKind,
    /// Which of several points at the same position is kept.
    pub duplicates: Duplicates,
    /// What to do with segments that cross.
    pub crossings: Crossings,
    /// Whether segments are split where they cross the borders of cells.
    pub steiner: Steiner,
    /// What to do with vertices that have no z when others have z. By default lines and sites
    /// take it from the triangulation of the points, which is then built first, alone.
    pub missing_z: MissingZ,
    /// Whether regions that reach the hull without passing a constraint are holes, as the outside
    /// of a PSLG is for Triangle.
    pub exterior_is_hole: bool,
    /// Whether tiles are compressed. Needs the feature `compression`, here and where the file is
    /// read.
    pub compress: bool,
    /// Whether an existing output is replaced, and work of an interrupted build discarded.
    pub force: bool,
    /// The folder that work is spilled to. Default: the folder beside the output in which the file
    /// is completed.
    pub work_folder: Option<PathBuf>,
    /// Text that identifies the points, lines and sites of this build: a line for each input and
    /// for each setting that determines how they are read. If it is set, an interrupted build that
    /// outgrew the memory keeps its work and can be resumed.
    pub resumable: Option<String>,
    /// Whether to resume an interrupted build, if there is one. That build must have had the same
    /// `resumable` text, tile size, work folder, and rules for duplicates, missing z and lines.
    pub resume: bool,
    /// The object store in which tasks find their points and leave their tiles, and into which the
    /// file goes, in parts. The output has the same file name.
    pub store: Option<TaskStore>,
    /// Whether the file is a draft that nobody relies on, so that it need not be on the medium when it
    /// gets its name.
    pub(crate) is_draft: bool,
    /// Progress of the build for observers, and the way to cancel it.
    pub progress: Arc<Progress>,
}

impl BuildOptions {
    /// The smallest value of `tile_vertices`.
    pub const MIN_TILE_VERTICES: usize = 4;
    /// The largest value of `tile_vertices`.
    pub const MAX_TILE_VERTICES: usize = store::MAX_TILE_VERTICES;

    /// Checks that all options are valid.
    ///
    /// Returns [`BuildError::Option`] for a value out of range, and [`BuildError::NotResumable`] if
    /// `resume` is set without `resumable`.
    pub(crate) fn check(&self) -> Result<(), BuildError> {
        let tile_vertices = Self::MIN_TILE_VERTICES..=Self::MAX_TILE_VERTICES;
        for (option, found, range) in [
            ("tile vertices", self.tile_vertices, tile_vertices),
            ("threads", self.threads, 1..=1024),
        ] {
            if !range.contains(&found) {
                return Err(BuildError::Option {
                    option,
                    min: *range.start(),
                    max: *range.end(),
                    found,
                });
            }
        }
        if self.compress && !Codec::HAS_ZSTANDARD {
            return Err(BuildError::NoCompression);
        }
        if self.resume && self.resumable.is_none() {
            return Err(BuildError::NotResumable);
        }
        Ok(())
    }

    /// Returns the codec of tiles.
    pub(crate) fn codec(&self) -> Codec {
        match self.compress {
            true => Codec::Zstandard,
            false => Codec::Raw,
        }
    }

    /// Returns the division of the memory.
    pub(crate) fn memory_plan(&self) -> MemoryPlan {
        let plan = MemoryPlan::new(self.memory, self.threads, self.tile_vertices, self.merge_vertices);
        plan.with_compression(self.compress)
    }

    /// Returns the text that a resumed build must have in common with the interrupted one.
    pub(crate) fn identity(&self) -> String {
        let inputs = self.resumable.as_deref().unwrap_or_default();
        let Self {
            tile_vertices,
            duplicates,
            work_folder,
            compress,
            missing_z,
            crossings,
            steiner,
            exterior_is_hole,
            ..
        } = self;
        let spill = work_folder
            .as_deref()
            .map(|folder| std::path::absolute(folder).unwrap_or_default());
        format!(
            "tile vertices: {tile_vertices}\nduplicates: {duplicates}\ncompress: {compress}\nmissing z: {missing_z:?}\n\
             crossings: {crossings:?}\nSteiner points: {steiner:?}\nexterior is a hole: {exterior_is_hole}\n\
             spilled to: {spill:?}\n{inputs}"
        )
    }
}

/// One setter for each field.
impl BuildOptions {
    /// Sets [`tile_vertices`](field@Self::tile_vertices).
    #[must_use]
    pub fn tile_vertices(self, tile_vertices: usize) -> Self {
        Self { tile_vertices, ..self }
    }

    /// Sets [`merge_vertices`](field@Self::merge_vertices).
    #[must_use]
    pub fn merge_vertices(self, merge_vertices: usize) -> Self {
        Self { merge_vertices, ..self }
    }

    /// Sets [`threads`](field@Self::threads).
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// Sets [`memory`](field@Self::memory).
    #[must_use]
    pub fn memory(self, memory: u64) -> Self {
        Self { memory, ..self }
    }

    /// Sets [`engine`](field@Self::engine).
    #[must_use]
    pub fn engine(self, engine: EngineKind) -> Self {
        Self { engine, ..self }
    }

    /// Sets [`duplicates`](field@Self::duplicates).
    #[must_use]
    pub fn duplicates(self, duplicates: Duplicates) -> Self {
        Self { duplicates, ..self }
    }

    /// Sets [`crossings`](field@Self::crossings).
    #[must_use]
    pub fn crossings(self, crossings: Crossings) -> Self {
        Self { crossings, ..self }
    }

    /// Sets [`steiner`](field@Self::steiner).
    #[must_use]
    pub fn steiner(self, steiner: Steiner) -> Self {
        Self { steiner, ..self }
    }

    /// Sets [`missing_z`](field@Self::missing_z).
    #[must_use]
    pub fn missing_z(self, missing_z: MissingZ) -> Self {
        Self { missing_z, ..self }
    }

    /// Sets [`exterior_is_hole`](field@Self::exterior_is_hole).
    #[must_use]
    pub fn exterior_is_hole(self, exterior_is_hole: bool) -> Self {
        Self {
            exterior_is_hole,
            ..self
        }
    }

    /// Sets [`compress`](field@Self::compress).
    #[must_use]
    pub fn compress(self, compress: bool) -> Self {
        Self { compress, ..self }
    }

    /// Sets [`force`](field@Self::force).
    #[must_use]
    pub fn force(self, force: bool) -> Self {
        Self { force, ..self }
    }

    /// Sets [`work_folder`](field@Self::work_folder).
    #[must_use]
    pub fn work_folder(self, work_folder: impl Into<Option<PathBuf>>) -> Self {
        Self {
            work_folder: work_folder.into(),
            ..self
        }
    }

    /// Sets [`resumable`](field@Self::resumable).
    #[must_use]
    pub fn resumable(self, resumable: impl Into<Option<String>>) -> Self {
        Self {
            resumable: resumable.into(),
            ..self
        }
    }

    /// Sets [`resume`](field@Self::resume).
    #[must_use]
    pub fn resume(self, resume: bool) -> Self {
        Self { resume, ..self }
    }

    /// Sets [`store`](field@Self::store).
    #[must_use]
    pub fn store(self, store: impl Into<Option<TaskStore>>) -> Self {
        let store = store.into();
        Self { store, ..self }
    }

    /// Sets [`progress`](field@Self::progress).
    #[must_use]
    pub fn progress(self, progress: Arc<Progress>) -> Self {
        Self { progress, ..self }
    }
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            tile_vertices: 1 << 15,
            merge_vertices: 1 << 16,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            memory: default_memory(),
            engine: EngineKind::default(),
            duplicates: Duplicates::default(),
            crossings: Crossings::default(),
            steiner: Steiner::default(),
            missing_z: MissingZ::default(),
            exterior_is_hole: false,
            compress: false,
            force: false,
            work_folder: None,
            resumable: None,
            resume: false,
            store: None,
            is_draft: false,
            progress: Arc::default(),
        }
    }
}

/// Whether vertices are added where none is needed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Steiner {
    /// No vertices are added.
    #[default]
    Never,
    /// Vertices are added where segments cross the borders of the cells that points are spilled to,
    /// as in Wu's thesis. Points that fit in memory are in one cell. The crossing points of a
    /// border are computed exactly and rounded once, and the segments are bent through them, as
    /// with segments that are [split](Crossings::Split). All segments must fit in memory. With this
    /// option the triangles depend on the cells, and so on the amount of memory; with all other
    /// options they do not.
    Borders,
}

/// What to do with segments that cross where there is no vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Crossings {
    /// The build fails and reports the first crossings.
    #[default]
    Error,
    /// The crossing points, computed exactly and rounded once, become vertices, and the segments
    /// are bent through them. This is repeated until nothing crosses. All segments must fit in
    /// memory. Where the rings of an obstacle are inside out, as in one lobe of a ring that crosses
    /// itself, the obstacle covers that part too; without splitting that is an error.
    Split,
}

/// Which of several points at the same position is kept. Does not depend on the order of arrival.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Duplicates {
    /// The point with the smallest record number.
    #[default]
    First,
    /// The point with the lowest z; of several, the one with the smallest record number.
    Lowest,
    /// The point with the highest z; of several, the one with the smallest record number.
    Highest,
    /// None: the build fails.
    Error,
}

/// Which of several points at the same position is kept.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DuplicateRule {
    pub(crate) duplicates: Duplicates,
    /// First record number of segment ends and sites, which are replaced by points at their
    /// position.
    pub(crate) first_end: u64,
}

impl DuplicateRule {
    /// Returns whether point `a` is kept rather than `b`. Each is given by its z and record number.
    /// Among segment ends and sites, one with z is kept rather than one without.
    pub(crate) fn prefers(self, a: (f64, u64), b: (f64, u64)) -> bool {
        match (a.1 >= self.first_end, b.1 >= self.first_end) {
            (false, false) => self.duplicates.prefers(a, b),
            (true, true) => (a.0.is_nan(), a.1) < (b.0.is_nan(), b.1),
            _ => a.1 < b.1,
        }
    }
}

impl Duplicates {
    const NAMES: [(Self, &'static str); 4] = [
        (Self::First, "first"),
        (Self::Lowest, "lowest"),
        (Self::Highest, "highest"),
        (Self::Error, "error"),
    ];
}

impl Duplicates {
    /// Returns whether a record is kept rather than another, each given by its z and number.
    pub(crate) fn prefers(self, (z, record): (f64, u64), (other_z, other): (f64, u64)) -> bool {
        let by_z = match self {
            Self::First | Self::Error => std::cmp::Ordering::Equal,
            Self::Lowest => z.total_cmp(&other_z),
            Self::Highest => other_z.total_cmp(&z),
        };
        // A record without z is neither lower nor higher than another.
        let by_z = match (self, z.is_nan() || other_z.is_nan()) {
            (Self::Lowest | Self::Highest, true) => z.is_nan().cmp(&other_z.is_nan()),
            _ => by_z,
        };
        by_z.then(record.cmp(&other)).is_lt()
    }
}

impl fmt::Display for Duplicates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.iter().find(|(value, _)| value == self).map_or("", |n| n.1);
        f.write_str(name)
    }
}

/// Error: no rule for duplicates has this name.
#[derive(Clone, Debug, thiserror::Error)]
#[error("duplicates are kept first, lowest or highest, or are an error, not '{0}'")]
pub struct UnknownDuplicates(String);

impl FromStr for Duplicates {
    type Err = UnknownDuplicates;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let found = Self::NAMES.iter().find(|n| n.1 == name);
        found.map(|n| n.0).ok_or_else(|| UnknownDuplicates(name.to_owned()))
    }
}

/// The phases of a build, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub enum Phase {
    /// Points arrive.
    Read,
    /// The plane is cut into cells.
    Divide,
    /// Tiles are triangulated and their seams merged.
    Conquer,
    /// Borders are assembled.
    Borders,
    /// The directory is written and the file gets its name.
    Finish,
}

impl Phase {
    /// All phases, in order.
    pub const ALL: [Self; 5] = [Self::Read, Self::Divide, Self::Conquer, Self::Borders, Self::Finish];

    /// Returns the name of the phase in summaries.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Divide => "divide",
            Self::Conquer => "conquer",
            Self::Borders => "borders",
            Self::Finish => "finish",
        }
    }
}

/// Progress of a build, shared between the build and its observers.
#[derive(Debug, Default)]
pub struct Progress {
    phase: AtomicU8,
    done: AtomicU64,
    total: AtomicU64,
    points: AtomicU64,
    cancelled: AtomicBool,
}

impl Progress {
    /// Returns the phase, the number of its steps that are done, and their total number. Steps are
    /// points while points are read and conquered, and tiles while borders are assembled. While
    /// points are read, the total is not known and is 0.
    #[must_use]
    pub fn state(&self) -> (Phase, u64, u64) {
        let phase = Phase::ALL[usize::from(self.phase.load(Ordering::Relaxed))];
        (
            phase,
            self.done.load(Ordering::Relaxed),
            self.total.load(Ordering::Relaxed),
        )
    }

    /// Returns the number of points that the phase has processed so far.
    #[must_use]
    pub fn points(&self) -> u64 {
        self.points.load(Ordering::Relaxed)
    }

    /// Asks the build to stop. It then returns [`BuildError::Cancelled`].
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns whether the build was asked to stop.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    pub(crate) fn start(&self, phase: Phase, total: u64) {
        self.points.store(0, Ordering::Relaxed);
        self.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
        self.phase.store(phase as u8, Ordering::Relaxed);
    }

    pub(crate) fn advance(&self, steps: u64, points: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
        self.points.fetch_add(points, Ordering::Relaxed);
    }
}
