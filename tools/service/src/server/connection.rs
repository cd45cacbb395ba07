//! One connection.

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpStream;
use tokio::sync::watch;

use super::patient::Patient;
use crate::state::Service;

/// The bytes that a connection reads or writes at once, at most.
const BUFFER: usize = 32 << 10;
/// The number of headers of a request.
const HEADERS: usize = 64;

/// What a connection needs.
pub struct Connection {
    service: Service,
    router: Router,
    leaving: watch::Receiver<bool>,
    _counted: Counted,
}

/// A connection that counts until it is dropped.
struct Counted(Service);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.metrics().connections.dec();
    }
}

impl Connection {
    /// Creates a connection, which counts from now on. It ends after its request once `leaving` is true.
    pub fn new(service: Service, router: Router, leaving: watch::Receiver<bool>) -> Self {
        service.metrics().connections.inc();
        Self {
            _counted: Counted(service.clone()),
            service,
            router,
            leaving,
        }
    }

    /// Answers all requests of a connection. If the client leaves, its request is dropped.
    pub async fn run(mut self, stream: TcpStream) {
        // Answers are written at once; to wait for more would delay them.
        _ = stream.set_nodelay(true);
        let options = self.service.options();
        let stream = TokioIo::new(Patient::new(stream, options.write_timeout));
        let mut builder = http1::Builder::new();
        builder
            .timer(TokioTimer::new())
            .header_read_timeout(options.read_timeout)
            .max_buf_size(BUFFER)
            .max_headers(HEADERS);
        // One that comes after the end began has one request, such as for `/health`.
        let is_last = *self.leaving.borrow();
        builder.keep_alive(!is_last);
        let connection = builder.serve_connection(stream, TowerToHyperService::new(self.router));
        tokio::pin!(connection);
        let leaves = async { _ = self.leaving.wait_for(|leaves| *leaves).await };
        let ended = tokio::select! {
            ended = &mut connection => ended,
            () = leaves, if !is_last => {
                connection.as_mut().graceful_shutdown();
                connection.await
            }
        };
        if let Err(error) = ended {
            tracing::debug!(%error, "a connection ended");
        }
    }
}
