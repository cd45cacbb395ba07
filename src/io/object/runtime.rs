//! The runtime of the connections.

use std::io;
use std::sync::OnceLock;

use futures::future::{BoxFuture, FutureExt, ready};
use tokio::runtime::{Builder, Handle};

use crate::io::start::start_thread;

/// Runs a request on the runtime of the connections, from any runtime or none.
pub(super) fn on_runtime<T: Send + 'static>(
    request: impl Future<Output = io::Result<T>> + Send + 'static,
) -> BoxFuture<'static, io::Result<T>> {
    static RUNTIME: OnceLock<Result<Handle, io::ErrorKind>> = OnceLock::new();
    let start = || -> io::Result<Handle> {
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let handle = runtime.handle().clone();
        start_thread("tile-net", move || runtime.block_on(std::future::pending::<()>()))?;
        Ok(handle)
    };
    match RUNTIME.get_or_init(|| start().map_err(|error| error.kind())) {
        Err(kind) => ready(Err((*kind).into())).boxed(),
        Ok(runtime) => {
            let answer = runtime.spawn(request);
            async move { answer.await.unwrap_or_else(|error| Err(io::Error::other(error))) }.boxed()
        }
    }
}
