//! One client.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{sleep, timeout};

use crate::results::Results;

/// A client waits this long for an answer.
const PATIENCE: Duration = Duration::from_secs(30);

/// How a client behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Reads its answers.
    Good,
    /// Leaves before its answers come.
    Leaves,
    /// Reads a few bytes, now and then.
    Slow,
    /// Asks for what is not there, and sends too much.
    Wrong,
    /// Connects and does nothing.
    Idle,
}

impl Kind {
    /// Returns the kind of a client.
    pub const fn of(number: u64) -> Self {
        match number % 10 {
            0..=4 => Self::Good,
            5 => Self::Leaves,
            6 => Self::Slow,
            7 => Self::Wrong,
            _ => Self::Idle,
        }
    }
}

/// An answer.
pub struct Answer {
    /// The status code.
    pub status: u16,
    /// The headers, in lower case.
    pub head: String,
    /// The body.
    pub body: Vec<u8>,
}

/// Choices from a seed (Steele, Lea and Flood 2014, SplitMix).
struct Choices(u64);

impl Choices {
    fn below(&mut self, most: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % most
    }

    fn share(&mut self) -> f64 {
        self.below(1 << 20) as f64 / f64::from(1 << 20)
    }

    /// Returns a path that has an answer.
    fn good(&mut self) -> String {
        let [a, b, c, d] = std::array::from_fn(|_| self.share());
        let zoom = self.below(5);
        let [x, y] = [self.below(1 << zoom), self.below(1 << zoom)];
        match self.below(12) {
            // The same few, again and again.
            10 | 11 => format!("/town/query/path?from=0.0{},0.1&to=0.9,0.8", self.below(4)),
            0 => format!("/town/query/path?from={a},{b}&to={c},{d}"),
            1 => format!("/town/query/locate?at={a},{b}"),
            2 => format!("/town/query/nearest?at={a},{b}&k=5&vertices=true"),
            3 => format!("/town/query/range?at={a},{b}&radius=0.05&area=true"),
            4 => "/town".to_owned(),
            5 => format!("/town/native/mesh/{zoom}/{x}/{y}.mvt"),
            6 => format!("/survey/native/terrarium/{zoom}/{x}/{y}.png"),
            7 => format!("/survey/native/mesh/{zoom}/{x}/{y}.mvt?max-tiles={}", self.below(100)),
            8 => format!(
                "/town/query/path?from={a},{b}&to={c},{d}&mode=fast&max-time={}",
                self.below(50)
            ),
            _ => format!("/town/native/shade/{zoom}/{x}/{y}.png"),
        }
    }

    /// Returns a request that is wrong.
    fn wrong(&mut self) -> String {
        let get =
            |path: &str, headers: &str| format!("GET {path} HTTP/1.1\r\nhost: a\r\n{headers}connection: close\r\n\r\n");
        match self.below(9) {
            0 => get("/survey/raw", "range: bytes=99999999999-\r\n"),
            1 => get("/town/native/shade/30/1073741824/5.png", ""),
            2 => get("/town/native/shade/99999999999999999999/0/0.png", ""),
            3 => get("/../../etc/passwd", ""),
            4 => get(&format!("/town/query/locate?at={}", "9".repeat(6000)), ""),
            5 => "POST /town/query/matrix HTTP/1.1\r\nhost: a\r\nconnection: close\r\ncontent-length: 9999999999\r\n\r\n{".to_owned(),
            6 => get("/town", &format!("x: {}\r\n", "y".repeat(100_000))),
            7 => "\u{0}\u{1}garbage\r\n\r\n".to_owned(),
            _ => get("/town/query/path?from=1e999,0&to=NaN,0", ""),
        }
    }
}

/// Sends a request on a connection of its own.
///
/// # Errors
/// Fails if the connection does.
pub async fn get(address: SocketAddr, path: &str) -> anyhow::Result<Answer> {
    let request = format!("GET {path} HTTP/1.1\r\nhost: a\r\nconnection: close\r\n\r\n");
    ask(address, &request).await
}

async fn ask(address: SocketAddr, request: &str) -> anyhow::Result<Answer> {
    let mut stream = TcpStream::connect(address).await?;
    // A service that refuses may close the connection before all is sent.
    _ = stream.write_all(request.as_bytes()).await;
    let mut bytes = Vec::new();
    let read = timeout(PATIENCE, stream.read_to_end(&mut bytes)).await?;
    let end = bytes.windows(4).position(|part| part == b"\r\n\r\n");
    let end = end.with_context(|| format!("no answer: {read:?}"))?;
    let head = String::from_utf8_lossy(&bytes[..end]).to_lowercase();
    let status = head
        .get(9..12)
        .and_then(|status| status.parse().ok())
        .context("no status")?;
    Ok(Answer {
        status,
        head,
        body: bytes.split_off(end + 4),
    })
}

/// Asks until `end`.
pub async fn run(address: SocketAddr, kind: Kind, seed: u64, end: Instant, results: Arc<Results>) {
    let mut choices = Choices(seed);
    while Instant::now() < end {
        match kind {
            Kind::Good => good(address, &mut choices, &results).await,
            Kind::Wrong => wrong(address, &choices.wrong(), &results).await,
            Kind::Leaves => {
                let wait = Duration::from_micros(choices.below(20_000));
                _ = timeout(wait, get(address, &choices.good())).await;
            }
            Kind::Slow => slow(address, end).await,
            Kind::Idle => {
                let connection = TcpStream::connect(address).await;
                sleep(Duration::from_millis(choices.below(3000))).await;
                drop(connection);
            }
        }
    }
}

async fn good(address: SocketAddr, choices: &mut Choices, results: &Results) {
    let path = choices.good();
    let began = Instant::now();
    match get(address, &path).await {
        Ok(answer) => {
            results.count(&path, answer.status, began.elapsed());
            if answer.status == 503 {
                sleep(Duration::from_millis(50)).await;
            }
            check(&path, &answer, results);
        }
        Err(_) => results.count(&path, 0, began.elapsed()),
    }
}

/// Checks that an answer is whole, and of one state.
fn check(path: &str, answer: &Answer, results: &Results) {
    if !matches!(answer.status, 200 | 204 | 304 | 404 | 503) {
        results.complain(format!("{path}: status {}", answer.status));
    }
    let length = answer
        .head
        .split("content-length: ")
        .nth(1)
        .and_then(|rest| rest.split('\r').next()?.parse().ok());
    if length.is_some_and(|length: usize| length != answer.body.len()) {
        results.complain(format!("{path}: {} of {length:?} bytes", answer.body.len()));
    }
    if answer.status != 200 || !answer.head.contains("json") {
        return;
    }
    let Ok(value) = serde_json::from_slice::<Value>(&answer.body) else {
        return results.complain(format!("{path}: it is no JSON"));
    };
    let tag = answer
        .head
        .split("etag: ")
        .nth(1)
        .and_then(|rest| rest.split('\r').next());
    if let (Some(tag), true) = (tag, path.ends_with("to=0.9,0.8")) {
        results.same(path, tag, &answer.body);
    }
    if path == "/town" {
        let version = value["version"].as_str().unwrap_or_default();
        results.version(version);
        // The tag, the version and the counts are of one state.
        let generation = value["generation"].as_u64().unwrap_or(0);
        if !answer.head.contains(&format!("etag: \"{version}-")) || !version.ends_with(&format!("-{generation}")) {
            results.complain(format!("{path}: two states in {value} with {}", answer.head));
        }
        if generation == 1 && value["counts"]["constraint_edges"].as_u64() > Some(900 + 4 * 225) {
            results.complain(format!("{path}: an edit in the first generation: {value}"));
        }
    }
}

async fn wrong(address: SocketAddr, request: &str, results: &Results) {
    let began = Instant::now();
    let what = &request[..request.len().min(60)];
    match ask(address, request).await {
        Ok(answer) => {
            results.count(what, answer.status, began.elapsed());
            if answer.status < 400 {
                results.complain(format!("{what}: status {}", answer.status));
            }
        }
        Err(_) => results.count(what, 0, began.elapsed()),
    }
}

/// Asks for a whole file, and reads a few bytes at a time.
async fn slow(address: SocketAddr, end: Instant) {
    let Ok(mut stream) = TcpStream::connect(address).await else {
        return sleep(Duration::from_millis(100)).await;
    };
    _ = stream.write_all(b"GET /survey/raw HTTP/1.1\r\nhost: a\r\n\r\n").await;
    let mut some = [0; 100];
    while Instant::now() < end && matches!(stream.read(&mut some).await, Ok(1..)) {
        sleep(Duration::from_millis(50)).await;
    }
}
