//! Many questions at once: their points, their options, and their answers in order.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::task::{Context, Poll, ready};
use std::thread::available_parallelism;
use std::time::Duration;

use delaunay_tiles::Point;
use delaunay_tiles::geometry::curve_order;
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

/// Number of tasks that are started for each processor.
const STARTED: usize = 16;

/// The most questions that are sorted together. Their answers wait for each other.
const SORTED: usize = 1 << 13;

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
/// there are processors. Near ones are asked one after the other, so that they share the tiles in
/// the cache; `place` returns where a question is asked.
///
/// # Errors
/// Returns the error of the first question that has one; those after it are dropped.
pub async fn in_order<Q, A, F>(
    mut questions: impl ExactSizeIterator<Item = Q> + Send + 'static,
    place: impl Fn(&Q) -> Point,
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
    loop {
        let sorted: Vec<Q> = questions.by_ref().take(SORTED).collect();
        if sorted.is_empty() {
            return Ok(());
        }
        let failed = Arc::new(AtomicUsize::new(usize::MAX));
        let mut answers: Vec<Option<Outcome<A>>> = sorted.iter().map(|_| None).collect();
        let parts = stream::iter(parts(sorted, &place, length));
        let tasks = parts.map(|part| {
            let (ask, slots, failed) = (ask.clone(), Arc::clone(&slots), Arc::clone(&failed));
            Owned(tokio::spawn(async move {
                let _slot = slots.acquire().await;
                answered(part, ask, &failed).await
            }))
        });
        let mut tasks = tasks.buffer_unordered(STARTED * at_once);
        while let Some(part) = tasks.try_next().await? {
            for (number, answer) in part {
                answers[number] = Some(answer);
            }
        }
        for answer in answers.into_iter().flatten() {
            take(answer?);
        }
    }
}

/// Divides questions into parts of `length`, each of questions near each other, with their numbers.
fn parts<Q>(questions: Vec<Q>, place: impl Fn(&Q) -> Point, length: usize) -> Vec<Vec<(usize, Q)>> {
    let places: Vec<Point> = questions.iter().map(place).collect();
    let mut questions: Vec<Option<Q>> = questions.into_iter().map(Some).collect();
    let order = curve_order(&places);
    let part = |numbers: &[usize]| {
        let taken = numbers.iter().map(|&number| Some((number, questions[number].take()?)));
        taken.flatten().collect()
    };
    order.chunks(length).map(part).collect()
}

/// Answers the questions of a part, but none after a question that `failed`.
async fn answered<Q, A, F>(
    part: Vec<(usize, Q)>,
    ask: impl Fn(Q) -> F,
    failed: &AtomicUsize,
) -> Vec<(usize, Outcome<A>)>
where
    F: Future<Output = Outcome<A>>,
{
    let mut answers = Vec::with_capacity(part.len());
    for (number, question) in part {
        if number > failed.load(Ordering::Relaxed) {
            continue;
        }
        let answer = ask(question).await;
        if answer.is_err() {
            failed.fetch_min(number, Ordering::Relaxed);
        }
        answers.push((number, answer));
        // A task can be stopped here, too, when all tiles are in the cache.
        yield_now().await;
    }
    answers
}

/// A task that is stopped on drop.
struct Owned<T>(JoinHandle<T>);

impl<T> Future for Owned<T> {
    type Output = Outcome<T>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let joined = ready!(Pin::new(&mut self.0).poll(context));
        Poll::Ready(joined.map_err(|error| Failure::other(format!("internal error: {error}"))))
    }
}

impl<T> Drop for Owned<T> {
    fn drop(&mut self) {
        self.0.abort();
    }
}
