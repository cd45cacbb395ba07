//! `tiletool insert`, `delete`, `move` and `set-z`: changes of the points and sites of a tile file.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use delaunay_tiles::input::{
    InputOptions, PointBatch, PointSource, SegmentBatch, SegmentSource, SiteBatch, SiteSource,
};
use delaunay_tiles::{EditError, MissingZ, Transaction};

use crate::common;
use crate::crs::CrsArgs;
use crate::edit::EditArgs;
use crate::input_args::InputArgs;

/// Insert points and sites into a tile file
///
/// The resulting triangles are those of a build with the points from the start. Points may lie
/// outside the convex hull. A point at the position of another one is a duplicate, and left out. If
/// the file has z, the points need z, and if it has none, they must have none. A site where no vertex
/// is makes one.
///
/// The changes are appended to the file and become valid in one step when they are complete. Until
/// then, and for readers that have the file open, the file is unchanged. `tiletool compact` removes
/// what is no longer used.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool insert survey.tiles new.laz
  tiletool insert survey.tiles points.csv --columns x,y,z --dry-run
  tiletool insert town.tiles --sites shops.geojson --site-id name")]
pub struct InsertArgs {
    #[command(flatten)]
    edit: EditArgs,
    /// Files of points
    #[arg(value_name = "POINTS", required_unless_present = "sites")]
    points: Vec<PathBuf>,
    #[command(flatten)]
    sites: SiteFiles,
    /// Column or property that holds a site's id [default: third column of text, otherwise the
    /// number of the record]
    #[arg(long, value_name = "FIELD", requires = "sites")]
    site_id: Option<String>,
    /// How to treat sites without z, if the file has z, where no vertex is: drape, error or zero.
    /// Points without z are an error, or get 0
    #[arg(long, value_name = "drape|error|zero", default_value = "drape", hide_possible_values = true,
        value_parser = PossibleValuesParser::new(["drape", "error", "zero"]).map(|choice| match &*choice {
            "drape" => MissingZ::Drape,
            "zero" => MissingZ::Zero,
            _ => MissingZ::Error,
        }))]
    missing_z: MissingZ,
    #[command(flatten)]
    crs: CrsArgs,
    #[command(flatten)]
    input: InputArgs,
}

/// Delete points and sites from a tile file, by their positions
///
/// The resulting triangles are those of a build without the points. A vertex stays as long as a point,
/// a site or the end of a line is there. A line that passes the point stays, without the vertex. z and
/// ids are not compared.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool delete survey.tiles outliers.csv
  tiletool delete survey.tiles old.laz --class 2 --skip-missing
  tiletool delete town.tiles --sites closed.geojson")]
pub struct DeleteArgs {
    #[command(flatten)]
    edit: EditArgs,
    /// Files of points
    #[arg(value_name = "POINTS", required_unless_present = "sites")]
    points: Vec<PathBuf>,
    #[command(flatten)]
    sites: SiteFiles,
    #[command(flatten)]
    missing: MissingArgs,
    #[command(flatten)]
    crs: CrsArgs,
    #[command(flatten)]
    input: InputArgs,
}

/// Files of sites.
#[derive(Args, Clone, Debug)]
struct SiteFiles {
    /// File of sites, as for `build`; may be repeated
    #[arg(long, value_name = "FILE")]
    sites: Vec<PathBuf>,
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

/// The treatment of what is not there.
#[derive(Args, Clone, Copy, Debug)]
pub struct MissingArgs {
    /// Leave out what is not in the file, and count it; without this option, the first such position,
    /// segment or number is an error
    #[arg(long)]
    pub skip_missing: bool,
}

/// Inserts the points.
pub fn insert(args: InsertArgs) -> anyhow::Result<()> {
    let InsertArgs {
        edit,
        points,
        sites,
        site_id,
        missing_z,
        crs,
        input,
    } = args;
    // Without this, points without z would get z = 0 as they are read.
    let of_points = match missing_z {
        MissingZ::Drape => MissingZ::Error,
        missing_z => missing_z,
    };
    let sites = SiteSource::open(&sites.sites, site_id.as_deref())?;
    let source = PointsAndSites::open(&points, &input.options().missing_z(of_points), sites)?;
    change(&edit, &crs, source, move |transaction, source| {
        transaction.missing_z(missing_z);
        source.each_batch(|batch| transaction.insert(batch))?;
        if let Some(points) = &source.points {
            transaction.add_point_sources(points.sources());
        }
        source.each_batch_of_sites(|batch| transaction.insert_sites(batch))
    })
}

/// Deletes the points and the sites.
pub fn delete(args: DeleteArgs) -> anyhow::Result<()> {
    let sites = SiteSource::open(&args.sites.sites, None)?;
    let source = PointsAndSites::open(&args.points, &args.input.options(), sites)?;
    change(&args.edit, &args.crs, source, move |transaction, source| {
        transaction.skip_missing(args.missing.skip_missing);
        source.each_batch(|batch| transaction.delete(&batch.points))?;
        source.each_batch_of_sites(|batch| transaction.delete_sites(&batch.points))
    })
}

/// Gives the points their z.
pub fn set_z(args: SetZArgs) -> anyhow::Result<()> {
    let options = args.input.options().missing_z(MissingZ::Error);
    let source = PointsAndSites::open(&args.points, &options, SiteSource::open(&[], None)?)?;
    change(&args.edit, &args.crs, source, move |transaction, source| {
        transaction.skip_missing(args.missing.skip_missing);
        source.each_batch(|batch| transaction.set_z(batch))
    })
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
    change(&edit, &crs, source, move |transaction, source| {
        transaction.skip_missing(missing.skip_missing);
        let mut batch = SegmentBatch::default();
        while source.next_batch(&mut batch)? {
            transaction.move_points(&batch.ends)?;
        }
        Ok(())
    })
}

/// Files of changes.
trait Changes: Send + 'static {
    /// Returns the files that name a coordinate reference system, with that name.
    fn crs_of_files(&self) -> Vec<(PathBuf, String)>;

    /// Returns notes for the user about the input.
    fn notes(&self) -> Vec<String>;
}

impl Changes for PointsAndSites {
    fn crs_of_files(&self) -> Vec<(PathBuf, String)> {
        let of_points = self.points.iter().flat_map(PointSource::crs_of_files);
        of_points.chain(self.sites.crs_of_files()).cloned().collect()
    }

    fn notes(&self) -> Vec<String> {
        let of_points = self.points.iter().flat_map(PointSource::notes);
        of_points.chain(self.sites.notes()).cloned().collect()
    }
}

impl Changes for SegmentSource {
    fn crs_of_files(&self) -> Vec<(PathBuf, String)> {
        self.crs_of_files().to_vec()
    }

    fn notes(&self) -> Vec<String> {
        self.notes().to_vec()
    }
}

/// Files of points and sites.
struct PointsAndSites {
    /// `None` if there are none: a source of no files is an error.
    points: Option<PointSource>,
    sites: SiteSource,
}

impl PointsAndSites {
    fn open(points: &[PathBuf], options: &InputOptions, sites: SiteSource) -> anyhow::Result<Self> {
        let points = match points {
            [] => None,
            points => Some(PointSource::open(points, options)?),
        };
        Ok(Self { points, sites })
    }

    /// Calls `take` with each batch of points.
    fn each_batch(&mut self, mut take: impl FnMut(&PointBatch) -> Result<(), EditError>) -> anyhow::Result<()> {
        let Some(points) = &mut self.points else { return Ok(()) };
        let mut batch = PointBatch::default();
        while points.next_batch(&mut batch)? {
            take(&batch)?;
        }
        Ok(())
    }

    /// Calls `take` with each batch of sites.
    fn each_batch_of_sites(&mut self, mut take: impl FnMut(&SiteBatch) -> Result<(), EditError>) -> anyhow::Result<()> {
        let mut batch = SiteBatch::default();
        while self.sites.next_batch(&mut batch)? {
            take(&batch)?;
        }
        Ok(())
    }
}

/// Makes the changes that `feed` reads from a source.
fn change<S: Changes>(
    edit: &EditArgs,
    crs: &CrsArgs,
    mut source: S,
    feed: impl FnOnce(&mut Transaction, &mut S) -> anyhow::Result<()> + Send + 'static,
) -> anyhow::Result<()> {
    let (summary, notes) = common::wait_for("editing", async {
        let mut transaction = edit.open().await?;
        let of_file = transaction.crs().map(|crs| (edit.file.clone(), crs.to_owned()));
        let of_input = source.crs_of_files();
        crs.agree(of_file.iter().chain(&of_input))?;
        let (transaction, source) = common::on_thread("input", move || {
            feed(&mut transaction, &mut source)?;
            Ok((transaction, source))
        })
        .await?;
        let summary = edit.finish(transaction, anyhow::Error::new).await?;
        Ok((summary, source.notes()))
    })?;
    edit.report(&summary, notes)
}
