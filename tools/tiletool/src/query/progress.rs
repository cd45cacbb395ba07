//! Prints fast answers first, then the exact ones.

use delaunay_tiles::query::{Progress, QueryError, QueryOptions};
use delaunay_tiles::store::TileReader;
use delaunay_tiles_answers::answer::{Answer, QueryResult, Status};
use delaunay_tiles_answers::ask::{Ask, path_found};
use delaunay_tiles_answers::question::Question;
use futures::{Stream, TryStreamExt};

use super::print::Printer;
use super::stage::Stage;

/// Answers a question twice, and prints each answer as soon as it is known.
pub async fn answer(
    ask: Ask,
    reader: &TileReader,
    question: Question,
    options: QueryOptions,
    printer: &mut Printer,
) -> anyhow::Result<()> {
    match (ask, question) {
        (Ask::Knn { k, .. }, Question::At(at)) => {
            let progress = reader.nearest_sites_progressive(at, k as usize, options);
            print_all(
                question,
                progress,
                |sites| (Status::Ok, QueryResult::Sites(sites)),
                printer,
            )
            .await
        }
        (_, Question::Way(from, to)) => {
            let progress = reader.shortest_path_progressive(from, to, options);
            print_all(question, progress, path_found, printer).await
        }
        _ => unreachable!("only sites and paths have two stages"),
    }
}

async fn print_all<T>(
    question: Question,
    mut progress: impl Stream<Item = Result<Progress<T>, QueryError>> + Unpin,
    found: impl Fn(T) -> (Status, QueryResult),
    printer: &mut Printer,
) -> anyhow::Result<()> {
    let mut next_is_exact = false;
    loop {
        let (stage, (status, found)) = match progress.try_next().await {
            Ok(None) => return Ok(()),
            Ok(Some(Progress::Fast { answer, exact })) => (Some(Stage::Fast(exact)), found(answer)),
            Ok(Some(Progress::Exact(answer))) => (Some(Stage::Exact), found(answer)),
            Err(error) => {
                let stage = next_is_exact.then_some(Stage::Exact);
                // Nothing was found, but a lower bound of the distance may be known.
                (stage, (Status::of(error)?, QueryResult::nothing(question)))
            }
        };
        next_is_exact = true;
        let answer = Answer {
            question,
            status,
            area: None,
            cost: None,
            found,
        };
        printer.print_stage(&answer, stage)?;
    }
}
