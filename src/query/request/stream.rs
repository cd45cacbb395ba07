//! Streams of answers.

use std::pin::Pin;

use futures::stream;
use futures::stream::{Stream, StreamExt};

use super::error::QueryError;

/// Returns a stream whose items `next` produces one after the other, until it returns `None` or
/// fails.
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
    enum StreamState<F, S> {
        New(F),
        Going(S),
        Over,
    }
    let step = move |state: StreamState<Pin<Box<F>>, S>| {
        let next = next.clone();
        async move {
            let going = match state {
                StreamState::New(start) => start.await,
                StreamState::Going(going) => Ok(going),
                StreamState::Over => return None,
            };
            let made = match going {
                Ok(going) => next(going).await,
                Err(error) => Err(error),
            };
            match made {
                Ok(Some((item, going))) => Some((Ok(item), StreamState::Going(going))),
                Ok(None) => None,
                Err(error) => Some((Err(error), StreamState::Over)),
            }
        }
    };
    stream::unfold(StreamState::New(Box::pin(start)), step).boxed()
}
