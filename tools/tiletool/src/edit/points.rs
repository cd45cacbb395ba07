//! `tiletool insert`, `delete`, `move` and `set-z`: changes of the points of a tile file.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use delaunay_tiles::input::{InputOptions, PointBatch, PointSource, SegmentBatch, SegmentSource};
use delaunay_tiles::{EditError, Editor, MissingZ};

use crate::common;
use crate::crs::CrsArgs;
use crate::edit::EditArgs;
use crate::input_args::InputArgs;

/// Insert points into a tile file
///
/// The resulting triangles are those of a build with the points from the start. Points may lie
/// outside the convex hull. A point at the position of another one is a duplicate, and left out. If
/// the file has z, the points need z, and if it has none, they must have none.
///
/// The changes are appended to the file and become valid in one step when they are complete. Until
/// then, and for readers that have the file open, the file is unchanged. `tiletool compact` removes
/// what is no longer used.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool insert survey.tiles new.laz
  tiletool insert survey.tiles points.csv --columns x,y,z --dry-run")]
pub struct InsertArgs {
    #[command(flatten)]
    edit: EditArgs,
    /// Files of points
    #[arg(value_name = "POINTS", required = true)]
    points: Vec<PathBuf>,
    /// How to treat points without z, if the file has z: error or zero
    #[arg(long, value_name = "error|zero", default_value = "error", hide_possible_values = true,
        value_parser = PossibleValuesParser::new(["error", "zero"]).map(|choice| match &*choice {
            "zero" => MissingZ::Zero,
            _ => MissingZ::Error,
        }))]
    missing_z: MissingZ,
    #[command(flatten)]
    crs: CrsArgs,
    #[command(flatten)]
    input: InputArgs,
}

/// Delete points from a tile file, by their positions
///
/// The resulting triangles are those of a build without the points. A vertex stays as long as a site
/// or the end of a line is there. A line that passes the point stays, without the vertex. z is not
/// compared.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool delete survey.tiles outliers.csv
  tiletool delete survey.tiles old.laz --class 2 --skip-missing")]
pub struct DeleteArgs {
    #[command(flatten)]
    known: KnownPoints,
}

/// Move points of a tile file
///
/// Each segment of the files leads from the position of a point to its new one: rows x1,y1,x2,y2 of
/// text, or lines of any format. Points keep their z. All moves happen in their order, so a point
/// may be moved to a place that another one has left. Ends of lines and sites do not move.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:
  tiletool move survey.tiles corrections.csv")]
pub struct MoveArgs {
    #[command(flatten)]
    edit: EditArgs,
    /// Files of pairs of positions
    #[arg(value_name = "PAIRS", required = true)]
    pairs: Vec<PathBuf>,
    #[command(flatten)]
    missing: MissingArgs,
    #[command(flatten)]
    crs: CrsArgs,
}

/// Give points of a tile file another z
///
/// The points are found by x and y. The triangles stay as they are.
#[derive(Args, Clone, Debug)]
#[command(
    name = "set-z",
    after_help = "Example:
  tiletool set-z survey.tiles corrected.laz"
)]
pub struct SetZArgs {
    #[command(flatten)]
    known: KnownPoints,
}

/// A file, and points that it has.
#[derive(Args, Clone, Debug)]
struct KnownPoints {
    #[command(flatten)]
    edit: EditArgs,
    /// Files of points
    #[arg(value_name = "POINTS", required = true)]
    points: Vec<PathBuf>,
    #[command(flatten)]
    missing: MissingArgs,
    #[command(flatten)]
    crs: CrsArgs,
    #[command(flatten)]
    input: InputArgs,
}

/// The treatment of points that are not there.
#[derive(Args, Clone, Copy, Debug)]
pub struct MissingArgs {
    /// Leave out points that are not in the file, and count them; without this option, the first one
    /// is an error
    #[arg(long)]
    pub skip_missing: bool,
}

/// Inserts the points.
pub fn insert(args: InsertArgs) -> anyhow::Result<()> {
    let InsertArgs {
        edit,
        points,
        missing_z,
        crs,
        input,
    } = args;
    // Without this, points without z would get z = 0 as they are read.
    let source = PointSource::open(&points, &input.options().missing_z(missing_z))?;
    change(&edit, &crs, source, move |editor, source| {
        editor.missing_z(missing_z);
        each_batch(source, |batch| editor.insert(batch))?;
        editor.add_point_sources(source.sources());
        Ok(())
    })
}

/// Deletes the points.
pub fn delete(args: DeleteArgs) -> anyhow::Result<()> {
    let options = args.known.input.options();
    args.known
        .change(&options, |editor, batch| editor.delete(&batch.points))
}

/// Gives the points their z.
pub fn set_z(args: SetZArgs) -> anyhow::Result<()> {
    let options = args.known.input.options().missing_z(MissingZ::Error);
    args.known.change(&options, Editor::set_z)
}

impl KnownPoints {
    /// Makes a change with each batch of the points.
    fn change(
        self,
        options: &InputOptions,
        mut take: impl FnMut(&mut Editor, &PointBatch) -> Result<(), EditError> + Send + 'static,
    ) -> anyhow::Result<()> {
        let source = PointSource::open(&self.points, options)?;
        change(&self.edit, &self.crs, source, move |editor, source| {
            editor.skip_missing(self.missing.skip_missing);
            each_batch(source, |batch| take(editor, batch))
        })
    }
}

/// Moves the points.
pub fn move_points(args: MoveArgs) -> anyhow::Result<()> {
    let MoveArgs {
        edit,
        pairs,
        missing,
        crs,
    } = args;
    let source = SegmentSource::open(&pairs)?;
    change(&edit, &crs, source, move |editor, source| {
        editor.skip_missing(missing.skip_missing);
        let mut batch = SegmentBatch::default();
        while source.next_batch(&mut batch)? {
            editor.move_points(&batch.ends)?;
        }
        Ok(())
    })
}

/// Files of changes.
trait Changes: Send + 'static {
    /// Returns the files that name a coordinate reference system, with that name.
    fn crs_of_files(&self) -> &[(PathBuf, String)];

    /// Returns notes for the user about the input.
    fn notes(&self) -> &[String];
}

impl Changes for PointSource {
    fn crs_of_files(&self) -> &[(PathBuf, String)] {
        self.crs_of_files()
    }

    fn notes(&self) -> &[String] {
        self.notes()
    }
}

impl Changes for SegmentSource {
    fn crs_of_files(&self) -> &[(PathBuf, String)] {
        self.crs_of_files()
    }

    fn notes(&self) -> &[String] {
        self.notes()
    }
}

/// Makes the changes that `feed` reads from a source.
fn change<S: Changes>(
    edit: &EditArgs,
    crs: &CrsArgs,
    mut source: S,
    feed: impl FnOnce(&mut Editor, &mut S) -> anyhow::Result<()> + Send + 'static,
) -> anyhow::Result<()> {
    let (summary, notes) = common::block_on(async {
        let mut editor = edit.open().await?;
        let of_file = editor.crs().map(|crs| (edit.file.clone(), crs.to_owned()));
        crs.agree(of_file.iter().chain(source.crs_of_files()))?;
        let (editor, source) = common::on_thread("input", move || {
            feed(&mut editor, &mut source)?;
            Ok((editor, source))
        })
        .await?;
        let summary = edit.finish(editor, anyhow::Error::new).await?;
        Ok((summary, source.notes().to_vec()))
    })?;
    edit.report(&summary, notes)
}

/// Calls `take` with each batch of a source.
fn each_batch(
    source: &mut PointSource,
    mut take: impl FnMut(&PointBatch) -> Result<(), EditError>,
) -> anyhow::Result<()> {
    let mut batch = PointBatch::default();
    while source.next_batch(&mut batch)? {
        take(&batch)?;
    }
    Ok(())
}
