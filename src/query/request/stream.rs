//! Streams of answers.

use std::pin::Pin;

use futures::stream;
use futures::stream::Stream;

use super::error::QueryError;

/// A stream that a function makes, one item after the other, until it says that there is no more or fails.
pub(crate) fn unfold<S, T, F, G, H>(
    start: F,
    next: G,
) -> impl Stream<Item = Result<T, QueryError>> + Send + Unpin + 'static + use<S, T, F, G, H>
where
    S: Send + 'static,
    T: Send + 'static,
    F: Future<Output = Result<S, QueryError>> + Send + 'static,
    G: Fn(S) -> H + Clone + Send + 'static,
    H: Future<Output = Result<Option<(T, S)>, QueryError>> + Send + 'static,
{
    enum State<F, S> {
        New(F),
        Going(S),
        Over,
    }
    let step = move |state: State<Pin<Box<F>>, S>| {
        let next = next.clone();
        async move {
            let going = match state {
                State::New(start) => start.await,
                State::Going(going) => Ok(going),
                State::Over => return None,
            };
            let made = match going {
                Ok(going) => next(going).await,
                Err(error) => Err(error),
            };
            match made {
                Ok(Some((item, going))) => Some((Ok(item), State::Going(going))),
                Ok(None) => None,
                Err(error) => Some((Err(error), State::Over)),
            }
        }
    };
    Box::pin(stream::unfold(State::New(Box::pin(start)), step))
}
