//! `tiletool serve`: tile files over HTTP.

use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, bail};
use bytesize::ByteSize;
use clap::Args;
use delaunay_tiles::store::Cache;
use delaunay_tiles_service::{Catalog, Options, Service, serve};
use tokio::net::TcpListener;

use crate::{allocator, common};

/// The share of the cache for finished map tiles: one part in four.
const FINISHED: u64 = 4;

/// Serve tile files over HTTP: a page, map tiles, terrain and answers
///
/// Each file is at a path of its name without the ending. A file that is edited or replaced is noticed
/// within a second. Ctrl-C and SIGTERM let running requests end, for up to ten seconds.
///
/// The service has no passwords and no encryption. To serve others than this machine, put a proxy
/// before it, such as nginx or Caddy.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  tiletool serve town.tiles
  tiletool serve town.tiles --open
  tiletool serve town.tiles survey.tiles --listen 127.0.0.1:8080 --cache 1GiB
  tiletool serve town.tiles --raw --cors https://maps.example.org
  curl 'http://127.0.0.1:3000/town/query/path?from=-1,2&to=8,8'")]
pub struct ServeArgs {
    /// Tile files to serve
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Address to listen on; port 0 takes a free one
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:3000")]
    listen: String,
    /// Open the page in the browser
    #[arg(long)]
    open: bool,
    /// Serve the bytes of the files too, at /NAME/raw, for readers such as `tiletool inspect`
    #[arg(long)]
    raw: bool,
    /// Origin whose pages may read the answers, such as https://maps.example.org, or * for all; may be
    /// repeated
    #[arg(long, value_name = "ORIGIN", value_parser = origin)]
    cors: Vec<String>,
    /// Memory for tiles of the files and finished map tiles
    ///
    /// The process takes up to 128 MiB more.
    #[arg(long, value_name = "BYTES", default_value = "256MiB")]
    cache: ByteSize,
    /// Maximum number of tiles that a query may read; a request can lower it
    #[arg(long, value_name = "COUNT", default_value_t = Options::default().max_tiles)]
    max_tiles: u64,
    /// Maximum number of tiles that a map tile may be drawn from
    #[arg(long, value_name = "COUNT", default_value_t = Options::default().max_picture_tiles)]
    max_picture_tiles: u32,
    /// Maximum time that a request may compute, in milliseconds; a request can lower it
    #[arg(long, value_name = "MILLISECONDS", default_value_t = 10_000)]
    max_time: u64,
    /// Number of requests that compute at once [default: two per processor]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=4096))]
    at_once: Option<u16>,
    /// Number of requests that may wait to compute; more get the status 503 at once
    #[arg(long, value_name = "COUNT", default_value_t = 64)]
    queue: u16,
    /// Maximum number of connections
    #[arg(long, value_name = "COUNT", default_value_t = 1000, value_parser = clap::value_parser!(u16).range(1..))]
    max_connections: u16,
    /// Address of the service as clients see it, if a proxy does not tell it
    #[arg(long, value_name = "URL", value_parser = url)]
    public_url: Option<String>,
}

/// Parses the origin of a page.
fn origin(text: &str) -> Result<String, String> {
    let is_origin = text.split_once("://").is_some_and(|(scheme, host)| {
        matches!(scheme, "http" | "https") && !host.is_empty() && !host.contains(['/', '?', '#', ' ', '@'])
    });
    match text == "*" || is_origin {
        true => Ok(text.to_owned()),
        false => Err("an origin is https://HOST, perhaps with a port, or *".to_owned()),
    }
}

/// Parses the address of a service.
fn url(text: &str) -> Result<String, String> {
    let is_url = text.split_once("://").is_some_and(|(scheme, rest)| {
        matches!(scheme, "http" | "https") && !rest.is_empty() && !rest.contains(['?', '#', ' ', '{', '}', '"'])
    });
    match is_url {
        true => Ok(text.to_owned()),
        false => Err("an address is https://HOST, perhaps with a path".to_owned()),
    }
}

impl ServeArgs {
    fn options(&self) -> Options {
        let mut options = Options::default();
        options.raw = self.raw;
        options.cors.clone_from(&self.cors);
        options.public_url.clone_from(&self.public_url);
        options.finished_bytes = usize::try_from(self.cache.as_u64() / FINISHED).unwrap_or(usize::MAX);
        options.max_tiles = self.max_tiles;
        options.max_picture_tiles = self.max_picture_tiles;
        options.max_time = Duration::from_millis(self.max_time);
        options.queue = self.queue.into();
        options.max_connections = self.max_connections.into();
        if let Some(count) = self.at_once {
            options.at_once = count.into();
        }
        options
    }

    /// Returns the cache of tiles of files.
    fn tiles(&self) -> Cache {
        let bytes = self.cache.as_u64() - self.cache.as_u64() / FINISHED;
        Cache::new(usize::try_from(bytes).unwrap_or(usize::MAX))
    }
}

/// Serves until a signal ends it.
pub fn run(args: &ServeArgs) -> anyhow::Result<()> {
    allocator::keep_to(args.cache.as_u64());
    if let Some(path) = args.files.iter().find(|path| path.to_string_lossy().contains("://")) {
        bail!("{}: only files of this machine are served", common::shown(path));
    }
    common::block_on(async {
        let catalog = Catalog::open(&args.files, &args.tiles()).await?;
        let listener = listen(&args.listen).await?;
        let address = listener.local_addr().context("cannot learn the address")?;
        // Before anyone knows the address: a client may send a signal at once.
        let interrupted = common::interrupted();
        let count = common::counted(args.files.len() as u64, "file", "files");
        common::print("the address", &format!("serving {count} at http://{address}/\n"))?;
        if !address.ip().is_loopback() {
            common::note("others can reach this address, and the service has no passwords; put a proxy before it");
        }
        if args.open {
            show(address);
        }
        let service = Service::new(catalog, args.options());
        serve(service, listener, interrupted).await.context("cannot serve")
    })
}

/// Opens the page in the browser. The service runs also if there is none.
fn show(address: SocketAddr) {
    let url = format!("http://{}/", reachable(address));
    if let Err(error) = open::that_detached(&url) {
        common::note(format!("cannot open a browser: {error}; open {url} in one"));
    }
}

/// Returns the address at which this machine reaches a service that listens at `address`.
fn reachable(mut address: SocketAddr) -> SocketAddr {
    match address {
        SocketAddr::V4(all) if all.ip().is_unspecified() => address.set_ip(Ipv4Addr::LOCALHOST.into()),
        SocketAddr::V6(all) if all.ip().is_unspecified() => address.set_ip(Ipv6Addr::LOCALHOST.into()),
        _ => {}
    }
    address
}

async fn listen(address: &str) -> anyhow::Result<TcpListener> {
    let error = match TcpListener::bind(address).await {
        Ok(listener) => return Ok(listener),
        Err(error) => error,
    };
    let hint = match error.kind() {
        io::ErrorKind::AddrInUse => "another program listens there; choose another port with --listen HOST:PORT",
        io::ErrorKind::PermissionDenied => "the system does not allow it; choose a port from 1024 up",
        io::ErrorKind::AddrNotAvailable => "this machine does not have this address",
        _ => "give --listen HOST:PORT, such as 127.0.0.1:3000",
    };
    Err(error).with_context(|| format!("cannot listen on {}: {hint}", delaunay_tiles::shown::text(address)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_browser_asks_this_machine_if_all_addresses_are_listened_at() {
        for (listened, asked) in [
            ("0.0.0.0:80", "127.0.0.1:80"),
            ("[::]:80", "[::1]:80"),
            ("10.0.0.1:80", "10.0.0.1:80"),
        ] {
            assert_eq!(reachable(listened.parse().unwrap()), asked.parse().unwrap());
        }
    }

    #[test]
    fn origins_have_a_scheme_and_a_host_and_no_path() {
        for text in ["*", "https://maps.example.org", "http://localhost:8080"] {
            assert!(origin(text).is_ok(), "{text}");
        }
        for text in [
            "",
            "maps.example.org",
            "ftp://a",
            "https://",
            "https://a/",
            "https://a?b",
            "null",
        ] {
            assert!(origin(text).is_err(), "{text}");
        }
        assert!(url("https://example.org/maps").is_ok() && url("example.org").is_err());
    }
}
