//! Asks all questions, and prints the answers in order.

use std::future::Future;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, bail};
use clap::{Args, Subcommand};
use delaunay_tiles::query::{Explored, QueryOptions};
use delaunay_tiles::store::TileReader;
use futures::{StreamExt, TryStreamExt, stream};
use tokio::sync::Semaphore;

use super::answer::Answer;
use super::args::Format;
use super::ask::Ask;
use super::batch::{self, Question};
use super::command::QueryCommand;
use super::picture::Picture;
use super::print::Printer;
use super::{matrix, progress};
use crate::common;
use crate::plot;

/// Ask a tile file what is where, what is near, and how to get there among obstacles.
///
/// Walls and the rings of obstacles block the way; one may walk along them, and round the outside of all, unless the file was
/// built with --exterior hole. Break lines do not block.
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
}

const EXAMPLES: &str = "\
Example:
  tiletool query knn town.tiles --at 3.5,-4 -k 3
  tiletool query path town.tiles --from -1,2 --to 8,8 --geojson
  tiletool query path town.tiles --from -1,2 --to 8,8 --mode within:0.05
  tiletool query range town.tiles --batch places.csv --radius 500 --csv
  tiletool query range town.tiles --at 7,7 --radius 500 --area --plot reach.png
  tiletool query along town.tiles --from -1,2 --to 8,8 -k 3";

/// Queries that are begun for each that is worked on.
const BEGUN: usize = 16;

/// Answers queries.
pub fn run(args: QueryArgs) -> anyhow::Result<()> {
    match args.command {
        Command::Matrix(args) => matrix::run(&args),
        Command::Questions(command) => answer(&command, |ask, reader, question, options| async move {
            ask.answer(&reader, question, options).await
        }),
    }
}

/// Answers queries in some way, and prints the answers.
pub fn answer<F>(
    command: &QueryCommand,
    by: impl Fn(Ask, TileReader, Question, QueryOptions) -> F,
) -> anyhow::Result<()>
where
    F: Future<Output = anyhow::Result<Answer>> + Send + 'static,
{
    let questions = questions(command)?;
    common::block_on(answer_all(command, questions, by))
}

/// What is asked, if it can be answered.
fn questions(command: &QueryCommand) -> anyhow::Result<Vec<Question>> {
    let (ask, mut questions, common) = command.parts();
    if let Some(path) = &common.batch {
        questions.extend(batch::read(path, matches!(ask, Ask::Path | Ask::Along { .. }))?);
    } else if questions.is_empty() {
        match ask {
            Ask::Along { .. } => bail!("no line is given; give --from X,Y --to X,Y, or --batch FILE.csv"),
            Ask::Path => bail!("no path is asked for; give --from X,Y --to X,Y, or --batch FILE.csv"),
            _ => bail!("no point is asked for; give --at X,Y, or --batch FILE.csv"),
        }
    }
    if matches!(ask, Ask::Range { area: true, .. }) && common.plot.is_none() && !common.format.geojson {
        bail!("--area is given as GeoJSON or drawn: add --geojson or --plot MAP.svg");
    }
    if command.mode().1 && common.plot.is_some() {
        bail!("--plot draws one answer, and --progressive gives two; leave out one of them");
    }
    Ok(questions)
}

/// Answers in parallel, and prints in order.
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
    // For several queries a picture of what was searched would show little.
    if args.plot.is_some() && questions.len() == 1 {
        options = options.explored(&explored);
    }
    let began = Instant::now();
    let count = questions.len();
    let mut printer = Printer::new(format, ask, is_progressive)?;
    if is_progressive {
        for question in questions {
            progress::answer(ask, &reader, question, options.clone(), &mut printer).await?;
        }
        printer.finish()?;
        args.reading.report("queries", count as u64, began, &reader);
        return Ok(());
    }
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    let at_once = args.threads.map_or(available, usize::from);
    // Answers are printed in order. So that a slow one does not hold up others, more are begun than may be worked on at once.
    let slots = Arc::new(Semaphore::new(at_once));
    let answers = stream::iter(questions).map(|question| {
        let (answer, slots) = (by(ask, reader.clone(), question, options.clone()), Arc::clone(&slots));
        let task = tokio::spawn(async move {
            let _slot = slots.acquire().await;
            answer.await
        });
        async move { task.await.context("a query broke down")? }
    });
    let mut answers = answers.buffered(BEGUN * at_once);
    let mut picture = args.plot.as_ref().map(|_| Picture::new());
    while let Some(answer) = answers.try_next().await? {
        printer.print(&answer)?;
        if let (Some(cost), true) = (&answer.cost, format != Format::Json) {
            common::say(&cost.line);
        }
        if let Some(picture) = &mut picture {
            picture.take(ask, &answer);
        }
    }
    printer.finish()?;
    if let (Some(picture), Some(file)) = (picture, &args.plot) {
        plot::draw_query(&reader, file, &picture.finish(&explored)).await?;
    }
    args.reading.report("queries", count as u64, began, &reader);
    Ok(())
}
