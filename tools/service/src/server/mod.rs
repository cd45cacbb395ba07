//! Listens, with limits that keep slow or many clients from taking the service down.

mod connection;
mod patient;

use std::io;
use std::sync::Arc;
use std::time::Duration;

use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, watch};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use crate::state::Service;
use connection::Connection;

/// How long the service waits if the system refuses a connection, such as for lack of file descriptors.
const PAUSE: Duration = Duration::from_millis(50);

/// The whole answer to a connection that is too many.
const REFUSAL: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\nRetry-After: 1\r\nConnection: close\r\n\
Content-Type: application/json\r\nContent-Length: 101\r\n\r\n\
{\"status\":503,\"what\":\"there are too many connections\",\"where\":\"service\",\"advice\":\"try again later\"}\r\n";

/// Serves on a socket until `ended` is ready. Then running requests may end, for as long as
/// [`Options::drain`](crate::Options::drain); new ones get 503, `/health` too. Must be awaited within a
/// tokio runtime with time and I/O.
///
/// # Errors
/// Fails if the socket has no address.
pub async fn serve(service: Service, listener: TcpListener, ended: impl Future<Output = ()>) -> io::Result<()> {
    tracing::info!(address = %listener.local_addr()?, "listening");
    let options = service.options().clone();
    let (router, free) = (service.router(), Arc::new(Semaphore::new(options.max_connections)));
    let (leave, leaving) = watch::channel(false);
    let mut connections = JoinSet::new();
    let ended = async {
        ended.await;
        service.drain();
        // Running requests end, and idle connections are closed.
        leave.send_replace(true);
        tracing::info!("draining");
    };
    let serving = async {
        loop {
            while connections.try_join_next().is_some() {}
            let stream = match listener.accept().await {
                Ok((stream, _)) => stream,
                Err(error) => {
                    tracing::warn!(%error, "cannot accept a connection");
                    sleep(PAUSE).await;
                    continue;
                }
            };
            let Ok(permit) = Arc::clone(&free).try_acquire_owned() else {
                service.metrics().refused.inc();
                refuse(stream);
                continue;
            };
            let connection = Connection::new(service.clone(), router.clone(), leaving.clone());
            connections.spawn(async move {
                connection.run(stream).await;
                drop(permit);
            });
        }
    };
    tokio::pin!(serving);
    tokio::select! {
        () = &mut serving => {}
        () = ended => {}
    }
    // `/health` says that the service ends, as long as requests run.
    let idle = async {
        while free.available_permits() < options.max_connections {
            sleep(PAUSE).await;
        }
    };
    tokio::select! {
        () = &mut serving => {}
        ended = timeout(options.drain, idle) => tracing::info!(in_time = ended.is_ok(), "ended"),
    }
    Ok(())
}

/// Answers a connection that is too many, without waiting for its client.
fn refuse(stream: TcpStream) {
    _ = stream.try_write(REFUSAL);
}
