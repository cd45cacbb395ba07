//! Answers many questions: near ones one after the other, so that they share the tiles in the cache,
//! and passes on the answers in the order of the questions.

use std::collections::BTreeMap;
use std::future::Future;
use std::time::{Duration, Instant};

use delaunay_tiles::geometry::{Point, curve_order};
use futures::StreamExt;
use futures::stream::FuturesUnordered;

/// The most questions that are sorted together.
const MOST: usize = 1 << 14;
/// The largest weight of all answers that wait for their turn. An answer weighs about as much as it
/// has points.
const HEAVIEST: usize = 1 << 17;
/// If no answer was passed on for so long, the next one is asked for first.
const PATIENCE: Duration = Duration::from_secs(1);

/// The questions of a batch that were not asked yet.
struct Turns {
    /// Their numbers, in the order in which they are asked.
    along: std::vec::IntoIter<usize>,
    is_asked: Vec<bool>,
    /// All questions before this one were asked.
    first: usize,
}

impl Turns {
    fn new(places: &[Point]) -> Self {
        Self {
            along: curve_order(places).into_iter(),
            is_asked: vec![false; places.len()],
            first: 0,
        }
    }

    /// Returns the question to ask next: the first one if it is urgent, else the nearest to the one
    /// before.
    fn next(&mut self, is_urgent: bool) -> Option<usize> {
        let next = if is_urgent {
            while *self.is_asked.get(self.first)? {
                self.first += 1;
            }
            self.first
        } else {
            self.along.find(|&number| !self.is_asked[number])?
        };
        self.is_asked[next] = true;
        Some(next)
    }

    /// Skips all questions after this one.
    fn end_after(&mut self, number: usize) {
        self.is_asked[number + 1..].fill(true);
    }
}

/// Answers questions, up to `at_once` at the same time, and passes the answers to `take` in the order
/// of the questions. `place` returns where a question is asked, and `weight` about how many points
/// an answer has.
///
/// # Errors
/// Returns the error of the first question that has one, after the answers before it were passed
/// on, or the error of `take`.
pub async fn in_order<Q, A, E, F>(
    questions: &[Q],
    at_once: usize,
    place: impl Fn(&Q) -> Point,
    weight: impl Fn(&A) -> usize,
    ask: impl Fn(&Q) -> F,
    mut take: impl FnMut(A) -> Result<(), E>,
) -> Result<(), E>
where
    F: Future<Output = Result<A, E>>,
{
    for part in questions.chunks(MOST) {
        let places: Vec<Point> = part.iter().map(&place).collect();
        let mut turns = Turns::new(&places);
        let mut running = FuturesUnordered::new();
        let mut waiting: BTreeMap<usize, (usize, Result<A, E>)> = BTreeMap::new();
        let (mut taken, mut waiting_weight, mut last) = (0, 0, Instant::now());
        loop {
            while running.len() < at_once {
                let is_urgent = waiting_weight > HEAVIEST || last.elapsed() > PATIENCE;
                let Some(number) = turns.next(is_urgent) else { break };
                let answer = ask(&part[number]);
                running.push(async move { (number, answer.await) });
            }
            let Some((number, answer)) = running.next().await else {
                break;
            };
            if answer.is_err() {
                turns.end_after(number);
            }
            let its_weight = answer.as_ref().map_or(0, &weight);
            waiting_weight += its_weight;
            waiting.insert(number, (its_weight, answer));
            while let Some((its_weight, answer)) = waiting.remove(&taken) {
                take(answer?)?;
                waiting_weight -= its_weight;
                (taken, last) = (taken + 1, Instant::now());
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers each question with itself. Questions without a place have no answer.
    async fn run(xs: &[f64], heaviest: usize, asked: &std::cell::RefCell<Vec<f64>>) -> (Vec<f64>, Result<(), String>) {
        let mut taken = Vec::new();
        let ask = |&x: &f64| {
            asked.borrow_mut().push(x);
            async move { if x < 0.0 { Err(format!("{x}")) } else { Ok(x) } }
        };
        let ended = in_order(
            xs,
            1,
            |&x| Point::new(x, 0.0),
            |_| heaviest,
            ask,
            |x| {
                taken.push(x);
                Ok(())
            },
        );
        let ended = ended.await;
        (taken, ended)
    }

    #[tokio::test]
    async fn questions_are_asked_along_the_plane_and_answered_in_order() {
        let xs = [7.0, 1.0, 5.0, 3.0, 2.0, 6.0, 0.0, 4.0];
        let asked = std::cell::RefCell::default();
        assert_eq!(run(&xs, 1, &asked).await, (xs.to_vec(), Ok(())));
        assert!(asked.borrow().is_sorted());
    }

    #[tokio::test]
    async fn heavy_answers_are_not_collected() {
        let xs: Vec<f64> = (0..100).rev().map(f64::from).collect();
        let asked = std::cell::RefCell::default();
        assert_eq!(run(&xs, HEAVIEST, &asked).await, (xs.clone(), Ok(())));
        // Two are asked along the plane, then the others in their order.
        assert_eq!(asked.borrow()[2..], xs[..98]);
    }

    #[tokio::test]
    async fn the_first_error_ends_the_answers() {
        let xs = [3.0, 2.0, -1.0, 1.0, -2.0, 5.0];
        let asked = std::cell::RefCell::default();
        let (taken, ended) = run(&xs, 1, &asked).await;
        assert_eq!((taken, ended), (vec![3.0, 2.0], Err("-1".to_owned())));
    }

    #[tokio::test]
    async fn all_parts_of_a_large_batch_are_answered() {
        let xs: Vec<f64> = (0..2 * MOST + 5).map(|i| (i * 7919 % 10_007) as f64).collect();
        let asked = std::cell::RefCell::default();
        assert_eq!(run(&xs, 1, &asked).await, (xs, Ok(())));
    }
}
