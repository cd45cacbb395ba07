//! Runs all queries, and prints the answers in order.

use std::future::Future;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, bail};
use clap::{Args, Subcommand};
use delaunay_tiles::query::{Explored, QueryOptions};
use delaunay_tiles::store::TileReader;
use delaunay_tiles_answers::answer::Answer;
use delaunay_tiles_answers::ask::Ask;
use delaunay_tiles_answers::asked::Asked;
use delaunay_tiles_answers::question::Question;
use tokio::sync::Semaphore;

use super::args::Format;
use super::batch;
use super::command::QueryCommand;
use super::picture::Picture;
use super::print::Printer;
use super::terrain::{profile, volume, z};
use super::{matrix, progress, turns};
use crate::common;
use crate::plot;

/// Answer questions: locations, nearest sites, shortest paths, heights
///
/// Walls and the rings of obstacles block paths. Paths may run along them, and around the outside
/// of the convex hull unless the file was built with --exterior hole. Break lines do not block
/// paths.
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct QueryArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Clone, Debug)]
enum Command {
    #[command(flatten)]
    Questions(QueryCommand),
    Matrix(matrix::MatrixArgs),
    Z(z::ZArgs),
    Profile(profile::ProfileArgs),
    Volume(volume::VolumeArgs),
}

const EXAMPLES: &str = "\
Examples:
  tiletool query knn town.tiles --at 3.5,-4 -k 3
  tiletool query path town.tiles --from -1,2 --to 8,8 --geojson
  tiletool query path town.tiles --from -1,2 --to 8,8 --mode within:0.05
  tiletool query range town.tiles --batch places.csv --radius 500 --csv
  tiletool query range town.tiles --at 7,7 --radius 500 --area --plot reach.png
  tiletool query along town.tiles --from -1,2 --to 8,8 -k 3
  tiletool query z survey.tiles --at 637000.5,849000.25
  tiletool query profile survey.tiles --line road.geojson --csv
  tiletool query volume survey.tiles --level 420 --polygon pit.geojson";

/// Number of queries that are started for each one that may run, so that the next one need not wait
/// until an answer is printed.
const STARTED_PER_SLOT: usize = 4;

/// Runs a query command.
pub fn run(args: QueryArgs) -> anyhow::Result<()> {
    match args.command {
        Command::Matrix(args) => matrix::run(&args),
        Command::Z(args) => z::run(&args),
        Command::Profile(args) => profile::run(&args),
        Command::Volume(args) => volume::run(&args),
        Command::Questions(command) => answer(&command, |ask, reader, question, options| async move {
            ask.answer(&reader, question, options).await
        }),
    }
}

/// Answers queries with `by`, and prints the answers.
pub fn answer<F>(
    command: &QueryCommand,
    by: impl Fn(Ask, TileReader, Question, QueryOptions) -> F,
) -> anyhow::Result<()>
where
    F: Future<Output = anyhow::Result<Answer>> + Send + 'static,
{
    let questions = questions(command)?;
    common::answer(answer_all(command, questions, by))
}

/// Returns the queries of a command.
///
/// # Errors
/// Fails if no query is given, or options contradict each other.
fn questions(command: &QueryCommand) -> anyhow::Result<Vec<Question>> {
    let (ask, mut questions, common) = command.parts();
    if let Some(path) = &common.batch {
        questions.extend(batch::read(path, matches!(ask, Ask::Path | Ask::Along { .. }))?);
    } else if questions.is_empty() {
        match ask {
            Ask::Along { .. } => bail!("no line is given; give --from X,Y --to X,Y, or --batch FILE"),
            Ask::Path => bail!("no points are given; give --from X,Y --to X,Y, or --batch FILE"),
            _ => bail!("no point is given; give --at X,Y, or --batch FILE"),
        }
    }
    if command.mode().1 && common.plot.is_some() {
        bail!("--plot draws one answer, and --progressive gives two; leave out one of them");
    }
    Ok(questions)
}

/// Answers queries in parallel, and prints the answers in order.
async fn answer_all<F>(
    command: &QueryCommand,
    questions: Vec<Question>,
    by: impl Fn(Ask, TileReader, Question, QueryOptions) -> F,
) -> anyhow::Result<()>
where
    F: Future<Output = anyhow::Result<Answer>> + Send + 'static,
{
    let ((mode, is_progressive), (ask, _, args)) = (command.mode(), command.parts());
    let reader = args.reading.open().await?;
    let format = args.format.format();
    let mut options = args.options(format).mode(mode);
    let explored = Explored::default();
    // The searched triangles are drawn only for a single query, because a picture of several
    // searches would show little.
    if args.plot.is_some() && questions.len() == 1 {
        options = options.explored(&explored);
    }
    let began = Instant::now();
    let count = common::counted(questions.len() as u64, "query", "queries");
    let crs = args.reading.crs(&reader, ask != Ask::Locate).await?;
    let asked = Asked::new(ask, &reader, crs.as_ref());
    let mut printer = Printer::new(format, asked, crs.as_ref(), is_progressive)?;
    if is_progressive {
        for question in questions {
            progress::answer(ask, &reader, question, options.clone(), &mut printer).await?;
        }
        printer.finish()?;
        args.reading.report(&count, began, &reader);
        return Ok(());
    }
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    let at_once = args.threads.map_or(available, usize::from);
    let slots = Arc::new(Semaphore::new(at_once));
    let mut picture = args.plot.as_ref().map(|_| Picture::new(questions.len()));
    let started = |&question: &Question| {
        let (answer, slots) = (by(ask, reader.clone(), question, options.clone()), Arc::clone(&slots));
        let task = tokio::spawn(async move {
            let _slot = slots.acquire().await;
            answer.await
        });
        async move { task.await.context("a query task failed")? }
    };
    let print = |answer: Answer| {
        printer.print(&answer)?;
        if let (Some(cost), true) = (&answer.cost, format != Format::Json) {
            common::say(&cost.line);
        }
        if let Some(picture) = &mut picture {
            picture.take(ask, asked.unit, &answer);
        }
        Ok(())
    };
    let most = STARTED_PER_SLOT * at_once;
    turns::in_order(&questions, most, Question::place, Answer::weight, started, print).await?;
    printer.finish()?;
    if let (Some(picture), Some(file)) = (picture, &args.plot) {
        plot::draw_query(&reader, &args.title.of(file), &picture.finish(&explored)).await?;
    }
    args.reading.report(&count, began, &reader);
    Ok(())
}
