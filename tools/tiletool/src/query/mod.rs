//! `tiletool query`: what is where, what is near, and how to get there.

mod along;
mod answer;
mod area;
mod args;
mod ask;
mod batch;
mod matrix;
mod method;
mod picture;
mod print;
mod progress;

use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, bail};
use clap::Args;
use delaunay_tiles::query::{Explored, Mode};
use delaunay_tiles::store::TileReader;
use futures::{StreamExt, TryStreamExt, stream};
use tokio::sync::Semaphore;

use crate::common::{self, thousands};
use crate::plot;
use args::{CommonArgs, QueryCommand};
use ask::Ask;
use batch::Question;
use method::Measure;
use picture::Picture;
use print::{Format, Printer};

/// Ask a tile file what is where, what is near, and how to get there among obstacles.
///
/// Walls and the rings of obstacles block the way; one may walk along them, and round the outside of all, unless the file was
/// built with --exterior hole. Break lines do not block.
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct QueryArgs {
    #[command(subcommand)]
    command: QueryCommand,
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
    if let QueryCommand::Matrix(args) = &args.command {
        return matrix::run(args);
    }
    let measure = args.command.measure();
    let (ask, mut questions, common) = args.command.parts();
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
    let (mode, is_progressive) = args.command.mode();
    if measure.is_some_and(|measure| !measure.is_wave()) {
        if matches!(ask, Ask::Range { area: true, .. }) {
            bail!("only --method wave gives an --area");
        } else if mode != Mode::Exact || is_progressive {
            bail!("only --method wave has a --mode, or is --progressive; the others are exact");
        }
    }
    if is_progressive && common.plot.is_some() {
        bail!("--plot draws one answer, and --progressive gives two; leave out one of them");
    }
    // What a mode other than exact costs is not measured.
    let measure = measure.filter(|_| mode == Mode::Exact && !is_progressive);
    common::block_on(answer_all(ask, measure, questions, (mode, is_progressive), common))
}

/// Answers in parallel, and prints in order.
async fn answer_all(
    ask: Ask,
    measure: Option<Measure>,
    questions: Vec<Question>,
    (mode, is_progressive): (Mode, bool),
    args: &CommonArgs,
) -> anyhow::Result<()> {
    let reader = args.reading.open().await?;
    let format = args.format.format();
    let mut options = args.options(format).mode(mode);
    let explored = Explored::default();
    // For several queries a picture of what was searched would show little.
    if args.plot.is_some() && questions.len() == 1 {
        options = options.explored(&explored);
    }
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    let at_once = args.threads.map_or(available, usize::from);
    let began = Instant::now();
    let count = questions.len();
    let (staged, questions) = if is_progressive {
        (questions, Vec::new())
    } else {
        (Vec::new(), questions)
    };
    // Answers are printed in order. So that a slow one does not hold up others, more are begun than may be worked on at once.
    let slots = Arc::new(Semaphore::new(at_once));
    let answers = stream::iter(questions).map(|question| {
        let (reader, options, slots) = (reader.clone(), options.clone(), Arc::clone(&slots));
        let task = tokio::spawn(async move {
            let _slot = slots.acquire().await;
            match measure {
                Some(measure) => measure.answer(ask, &reader, question, options).await,
                None => ask.answer(&reader, question, options).await,
            }
        });
        async move { task.await.context("a query broke down")? }
    });
    let mut answers = answers.buffered(BEGUN * at_once);
    let mut printer = Printer::new(format, ask, is_progressive)?;
    for question in staged {
        progress::answer(ask, &reader, question, options.clone(), &mut printer).await?;
    }
    let mut picture = args.plot.as_ref().map(|_| Picture::new());
    while let Some(answer) = answers.try_next().await? {
        printer.print(&answer)?;
        if let (Some(statistics), true) = (&answer.statistics, format != Format::Json) {
            common::say(method::line(statistics));
        }
        if let Some(picture) = &mut picture {
            picture.take(ask, &answer);
        }
    }
    printer.finish()?;
    if let (Some(picture), Some(file)) = (picture, &args.plot) {
        plot::draw_query(&reader, file, &picture.finish(&explored)).await?;
    }
    if args.reading.stats {
        report("queries", count as u64, began, &reader);
    }
    Ok(())
}

/// Tells on standard error how long it took and what was read.
fn report(what: &str, count: u64, began: Instant, reader: &TileReader) {
    let statistics = reader.cache().statistics();
    common::say(format_args!(
        "{} {what} in {:.3} s; tiles: {} read, {} found in the cache, {} dropped from it",
        thousands(count),
        began.elapsed().as_secs_f64(),
        thousands(statistics.misses),
        thousands(statistics.hits),
        thousands(statistics.evictions),
    ));
}
