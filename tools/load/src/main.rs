//! Puts load on `tiletool serve`, while its files are edited and replaced.
//!
//! ```text
//! service-load --tiletool target/debug/tiletool --seconds 15 --clients 200
//! ```
//!
//! Clients ask for map tiles and queries, some of them wrong; some leave, some read slowly, some send too
//! much. The program fails if the service panics, answers with a status of 500 or above other than 503,
//! takes more memory than it may, or mixes two states of a file in one answer. It prints how many answers
//! there were a second, and how long they took.

mod client;
mod files;
mod results;
mod server;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{bail, ensure};
use clap::Parser;

use client::Kind;
use files::Files;
use results::Results;
use server::Server;

/// Puts load on `tiletool serve`
#[derive(Parser, Debug)]
struct Args {
    /// The program
    #[arg(long, value_name = "FILE")]
    tiletool: PathBuf,
    /// For how long
    #[arg(long, value_name = "SECONDS", default_value_t = 300)]
    seconds: u64,
    /// Number of clients at once
    #[arg(long, value_name = "COUNT", default_value_t = 1000)]
    clients: u64,
    /// The cache of the service, in MiB
    #[arg(long, value_name = "MIB", default_value_t = 64)]
    cache: u64,
    /// Seed of all choices
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// The bytes that the service may take besides its cache.
const BESIDES: u64 = 128 << 20;
/// How often the memory is measured.
const MEASURED: Duration = Duration::from_millis(100);

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    raise_files();
    let files = Files::new(&args.tiletool).await?;
    let mut server = Server::start(&args.tiletool, &files, args.cache).await?;
    let results = Arc::new(Results::default());
    let end = Instant::now() + Duration::from_secs(args.seconds);
    let clients: Vec<_> = (0..args.clients)
        .map(|number| {
            let (address, results) = (server.address, Arc::clone(&results));
            let seed = args.seed.wrapping_mul(1_000_003).wrapping_add(number);
            tokio::spawn(client::run(address, Kind::of(number), seed, end, results))
        })
        .collect();
    let change = files.change(end);
    let watch = async {
        let mut most = 0;
        while Instant::now() < end {
            most = server.resident().max(most);
            tokio::time::sleep(MEASURED).await;
        }
        most
    };
    let (changes, most) = tokio::join!(change, watch);
    let changes = changes?;
    for client in clients {
        client.await?;
    }
    let panics = server.metric("panics_total").await?;
    println!("{}", results.report(args.seconds));
    println!("{changes} changes of files; {} MiB resident at most", most >> 20);
    server.stop().await?;
    ensure!(panics == 0, "{panics} requests failed by a defect");
    let bound = (args.cache << 20) + BESIDES;
    ensure!(most <= bound, "{most} bytes are resident, and {bound} may be");
    ensure!(changes > 1, "the files did not change");
    match results.complaint() {
        Some(complaint) => bail!("{complaint}"),
        None => Ok(()),
    }
}

/// Allows as many connections as the system does.
fn raise_files() {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Nofile);
    let raised = Rlimit {
        current: limit.maximum,
        maximum: limit.maximum,
    };
    // If the system refuses, some clients cannot connect, which they count.
    _ = setrlimit(Resource::Nofile, raised);
}
