//! A web server of one file, with faults.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::thread;

/// What is wrong with the server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    None,
    /// It sends whole files, whatever is asked for.
    NoRanges,
    /// It names no versions.
    NoTags,
    /// After so many requests the file is another one.
    ChangedAfter(usize),
    /// The same, and it does not look at `If-Match`.
    ChangedAfterUnnoticed(usize),
    /// Requests fail from this one on, so many of them, with status 500.
    Fails(usize, usize),
    /// Answers end halfway, with the connection, from this one on, so many of them.
    Truncates(usize, usize),
    /// Answers are shorter than what was asked for from this one on, and say so.
    Shortens(usize),
    /// There is no file.
    Missing,
}

/// A server on a port of its own, until the process ends.
pub struct Server {
    pub url: String,
    shared: Arc<Shared>,
}

struct Shared {
    bytes: Vec<u8>,
    fault: Fault,
    /// Requests so far.
    requests: AtomicUsize,
}

impl Server {
    pub fn start(bytes: Vec<u8>, fault: Fault) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}/maps/town.tiles", listener.local_addr().unwrap());
        let requests = AtomicUsize::new(0);
        let shared = Arc::new(Shared { bytes, fault, requests });
        let server = Self {
            url,
            shared: Arc::clone(&shared),
        };
        thread::spawn(move || {
            for connection in listener.incoming() {
                let shared = Arc::clone(&shared);
                thread::spawn(move || shared.serve(&connection.unwrap()));
            }
        });
        server
    }

    pub fn requests(&self) -> usize {
        self.shared.requests.load(SeqCst)
    }
}

/// What of a request matters.
#[derive(Default)]
struct Request {
    is_head: bool,
    path: String,
    range: Option<Range<usize>>,
    if_match: Option<String>,
}

impl Request {
    /// None at the end of the connection.
    fn read(lines: &mut impl BufRead) -> Option<Self> {
        let mut line = String::new();
        lines.read_line(&mut line).ok().filter(|&length| length > 0)?;
        let mut words = line.split_whitespace();
        let mut request = Self {
            is_head: words.next()? == "HEAD",
            path: words.next()?.to_owned(),
            ..Self::default()
        };
        loop {
            let mut line = String::new();
            lines.read_line(&mut line).ok()?;
            let Some((name, value)) = line.trim().split_once(": ") else {
                return Some(request);
            };
            match name.to_lowercase().as_str() {
                "range" => {
                    let (from, to) = value.strip_prefix("bytes=")?.split_once('-')?;
                    request.range = Some(from.parse().ok()?..to.parse::<usize>().ok()? + 1);
                }
                "if-match" => request.if_match = Some(value.to_owned()),
                _ => (),
            }
        }
    }
}

impl Shared {
    fn serve(&self, connection: &TcpStream) {
        let mut lines = BufReader::new(connection);
        while let Some(request) = Request::read(&mut lines) {
            if self.answer(&request, connection).is_none() {
                return;
            }
        }
    }

    /// None if the connection ends with it.
    fn answer(&self, request: &Request, mut connection: &TcpStream) -> Option<()> {
        let number = self.requests.fetch_add(1, SeqCst);
        let mut send = |status: &str, headers: &str, body: &[u8], length: usize| {
            let head = format!("HTTP/1.1 {status}\r\nContent-Length: {length}\r\n{headers}\r\n");
            connection.write_all(head.as_bytes()).ok()?;
            let body = if request.is_head { &[] } else { body };
            connection.write_all(body).ok()
        };
        let within = |(from, count): (usize, usize)| (from..from.saturating_add(count)).contains(&number);
        if self.fault == Fault::Missing || request.path != "/maps/town.tiles" {
            return send("404 Not Found", "", b"", 0);
        }
        if let Fault::Fails(from, count) = self.fault
            && within((from, count))
        {
            return send("500 Internal Server Error", "", b"out of order", 12);
        }
        let changed = match self.fault {
            Fault::ChangedAfter(count) | Fault::ChangedAfterUnnoticed(count) => number >= count,
            _ => false,
        };
        let tag = if changed { "\"two\"" } else { "\"one\"" };
        let unnoticed = matches!(self.fault, Fault::ChangedAfterUnnoticed(_));
        if request.if_match.as_deref().is_some_and(|wanted| wanted != tag) && !unnoticed {
            return send("412 Precondition Failed", "", b"", 0);
        }
        let tag = match self.fault {
            Fault::NoTags => String::new(),
            _ => format!("ETag: {tag}\r\n"),
        };
        let whole = self.bytes.len();
        let Some(range) = request.range.clone().filter(|_| self.fault != Fault::NoRanges) else {
            return send("200 OK", &tag, &self.bytes, whole);
        };
        let mut range = range.start..range.end.min(whole);
        if range.is_empty() {
            return send(
                "416 Range Not Satisfiable",
                &format!("Content-Range: bytes */{whole}\r\n"),
                b"",
                0,
            );
        }
        if matches!(self.fault, Fault::Shortens(from) if number >= from) {
            range.end -= 1;
        }
        let headers = format!(
            "{tag}Content-Range: bytes {}-{}/{whole}\r\n",
            range.start,
            range.end - 1
        );
        let body = &self.bytes[range];
        if let Fault::Truncates(from, count) = self.fault
            && within((from, count))
        {
            send("206 Partial Content", &headers, &body[..body.len() / 2], body.len());
            return None;
        }
        send("206 Partial Content", &headers, body, body.len())
    }
}
