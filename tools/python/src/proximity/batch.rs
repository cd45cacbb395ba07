//! Many questions at once: their points, their options, and their answers in order.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::thread::available_parallelism;
use std::time::Duration;

use delaunay_tiles::Point;
use delaunay_tiles::query::{Mode, QueryOptions};
use futures::{StreamExt, TryStreamExt, stream};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::FromPyObject;
use pyo3::exceptions::PyMemoryError;
use tokio::sync::Semaphore;
use tokio::task::{JoinHandle, yield_now};

use crate::error::{Failure, Outcome};

/// The most questions of one task.
const LONGEST: usize = 32;

/// Number of tasks that are started for each processor. Answers are collected in order, so a slow
/// one must not keep the processors from the next.
const STARTED: usize = 16;

/// Points as rows of an array.
pub type Rows<'py> = PyReadonlyArray2<'py, f64>;

/// Mode, most tiles, longest time in seconds, whether paths are requested, and whether they are
/// proved.
#[derive(FromPyObject)]
pub struct Options(String, Option<u64>, Option<f64>, bool, bool);

impl Options {
    /// Returns whether paths are requested.
    pub const fn wants_paths(&self) -> bool {
        self.3 || self.4
    }

    /// Returns the mode.
    ///
    /// # Errors
    /// Fails if the text is none.
    pub fn mode(&self) -> Outcome<Mode> {
        let mode = self.0.parse();
        mode.map_err(|error| Failure::value(format!("{error}; not {:?}", self.0)))
    }

    /// Returns the library's options.
    ///
    /// # Errors
    /// Fails if the mode is unknown, or the time is none.
    pub fn into_query(self) -> Outcome<QueryOptions> {
        let mode = self.mode()?;
        let Self(_, tiles, seconds, paths, certified) = self;
        let mut options = QueryOptions::default().mode(mode);
        if let Some(tiles) = tiles {
            options = options.max_tiles(tiles);
        }
        if let Some(seconds) = seconds {
            let time = Duration::try_from_secs_f64(seconds);
            options = options.max_time(time.map_err(|error| Failure::value(format!("max_time: {error}")))?);
        }
        Ok(match (paths, certified) {
            (_, true) => options.certified(),
            (true, false) => options.paths(),
            (false, false) => options,
        })
    }
}

/// Returns the points of an array.
///
/// # Errors
/// Fails if the array is not one of pairs, row by row.
pub fn points(rows: &Rows<'_>) -> Outcome<Vec<Point>> {
    let coordinates = match (rows.shape(), rows.as_slice()) {
        (&[_, 2], Ok(coordinates)) => coordinates,
        _ => return Err(Failure::value("points must be contiguous rows of two")),
    };
    let (pairs, _) = coordinates.as_chunks();
    Ok(pairs.iter().map(|&[x, y]| Point::new(x, y)).collect())
}

/// Returns a list with space for `count` values.
///
/// # Errors
/// Fails if there is not enough memory.
pub fn space<T>(count: usize) -> Outcome<Vec<T>> {
    let mut list = Vec::new();
    list.try_reserve_exact(count).map_err(|_| {
        Failure::from(PyMemoryError::new_err(format!(
            "an answer of {count} cells needs too much memory"
        )))
    })?;
    Ok(list)
}

/// Answers questions, and passes the answers to `take`, in order. As many questions run at once as
/// there are processors.
///
/// # Errors
/// Returns the first error of an answer; the other questions are dropped.
pub async fn in_order<Q, A, F>(
    mut questions: impl ExactSizeIterator<Item = Q> + Send + 'static,
    ask: impl Fn(Q) -> F + Clone + Send + 'static,
    mut take: impl FnMut(A),
) -> Outcome<()>
where
    Q: Send + 'static,
    A: Send + 'static,
    F: Future<Output = Outcome<A>> + Send + 'static,
{
    // One question needs no task of its own.
    if questions.len() == 1
        && let Some(question) = questions.next()
    {
        take(ask(question).await?);
        return Ok(());
    }
    let at_once = available_parallelism().map_or(1, usize::from);
    let length = (questions.len() / (STARTED * at_once)).clamp(1, LONGEST);
    let slots = Arc::new(Semaphore::new(at_once));
    let parts = std::iter::from_fn(move || {
        let part: Vec<Q> = questions.by_ref().take(length).collect();
        (!part.is_empty()).then_some(part)
    });
    let tasks = stream::iter(parts).map(move |part| {
        let (ask, slots) = (ask.clone(), Arc::clone(&slots));
        Owned(tokio::spawn(async move {
            let _slot = slots.acquire().await;
            let mut answers = Vec::with_capacity(part.len());
            for question in part {
                answers.push(ask(question).await?);
                // A task can be stopped here, too, when all tiles are in the cache.
                yield_now().await;
            }
            Ok(answers)
        }))
    });
    let mut tasks = tasks.buffered(STARTED * at_once);
    while let Some(part) = tasks.try_next().await? {
        part.into_iter().for_each(&mut take);
    }
    Ok(())
}

/// A task that is stopped on drop.
struct Owned<T>(JoinHandle<Outcome<T>>);

impl<T> Future for Owned<T> {
    type Output = Outcome<T>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let joined = ready!(Pin::new(&mut self.0).poll(context));
        Poll::Ready(joined.unwrap_or_else(|error| Err(Failure::other(format!("internal error: {error}")))))
    }
}

impl<T> Drop for Owned<T> {
    fn drop(&mut self) {
        self.0.abort();
    }
}
