//! A web server of one file, with faults. The attack `web` of `tools/attacks` uses it too.

#![allow(clippy::too_many_lines)]
#![allow(dead_code, reason = "each user uses its part")]

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::thread;
use std::time::Duration;

/// A fault of the server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The server has no fault.
    None,
    /// The server sends the whole file for any request.
    NoRanges,
    /// The server sends no entity tags.
    NoTags,
    /// After this number of requests the file is another one.
    ChangedAfter(usize),
    /// After this number of requests the file is another one, and the server ignores `If-Match`.
    ChangedAfterUnnoticed(usize),
    /// From the request with the first number on, as many requests as the second number says fail
    /// with status 500.
    Fails(usize, usize),
    /// From the request with the first number on, as many answers as the second number says end
    /// halfway, with the connection.
    Truncates(usize, usize),
    /// From this request on, answers are shorter than requested, and say so.
    Shortens(usize),
    /// There is no file.
    Missing,
    /// From the request with the first number on, the server lies as many times as the second
    /// number says.
    Lies(Lie, usize, usize),
}

/// A false answer of a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lie {
    /// The whole file, with status 200, though a range was requested.
    Whole,
    /// Another range, with its true header.
    OtherRange,
    /// The bytes of another range, with the header of the requested one.
    OtherBytes,
    /// The right bytes, with the header of another range.
    OtherHeader,
    /// Some bytes differ from those of the file.
    WrongBytes,
    /// A body longer than its header says.
    TooLong,
    /// A body half as long as its header says; then the connection stays open and silent.
    Silent,
    /// A body that never ends.
    Endless,
    /// An error whose text never ends.
    EndlessError,
    /// A header that never ends.
    EndlessHeader,
    /// One byte at a time, with long pauses.
    Drip,
    /// A file of another length.
    OtherLength,
    /// A file of 2^63 bytes.
    HugeLength,
    /// A new version for each request.
    NewTag,
    /// A redirection to itself.
    Loop,
    /// A redirection to the first of very many redirections.
    LongWay,
    /// A redirection to another server, which has another file.
    Elsewhere,
    /// A redirection without an address.
    Nowhere,
    /// No HTTP at all.
    Garbage,
    /// The status 304, which answers no request that was made, as a cache sends it.
    NotModified,
    /// An error with commands for a terminal.
    Commands,
    /// An error with a web page for people.
    Page,
}

impl Lie {
    /// All lies.
    pub const ALL: [Self; 22] = [
        Self::Whole,
        Self::OtherRange,
        Self::OtherBytes,
        Self::OtherHeader,
        Self::WrongBytes,
        Self::TooLong,
        Self::Silent,
        Self::Endless,
        Self::EndlessError,
        Self::EndlessHeader,
        Self::Drip,
        Self::OtherLength,
        Self::HugeLength,
        Self::NewTag,
        Self::Loop,
        Self::LongWay,
        Self::Elsewhere,
        Self::Nowhere,
        Self::Garbage,
        Self::NotModified,
        Self::Commands,
        Self::Page,
    ];
}

/// A server on a port of its own, which runs until the process ends.
pub struct Server {
    pub url: String,
    shared: Arc<Shared>,
}

struct Shared {
    bytes: Vec<u8>,
    fault: Fault,
    /// The address of the redirection [`Lie::Elsewhere`].
    elsewhere: String,
    /// The number of requests so far.
    requests: AtomicUsize,
}

impl Server {
    pub fn start(bytes: Vec<u8>, fault: Fault) -> Self {
        Self::start_before(bytes, fault, String::new())
    }

    /// Starts a server that redirects to `elsewhere` for [`Lie::Elsewhere`].
    pub fn start_before(bytes: Vec<u8>, fault: Fault, elsewhere: String) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}/maps/town.tiles", listener.local_addr().unwrap());
        let requests = AtomicUsize::new(0);
        let shared = Arc::new(Shared {
            bytes,
            fault,
            elsewhere,
            requests,
        });
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

/// The relevant parts of a request.
#[derive(Default)]
struct Request {
    is_head: bool,
    path: String,
    range: Option<Range<usize>>,
    if_match: Option<String>,
}

impl Request {
    /// Reads a request; returns `None` at the end of the connection.
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

    /// Answers a request; returns `None` if the connection ends with the answer.
    fn answer(&self, request: &Request, mut connection: &TcpStream) -> Option<()> {
        let number = self.requests.fetch_add(1, SeqCst);
        let mut send = |status: &str, headers: &str, body: &[u8], length: usize| {
            let head = format!("HTTP/1.1 {status}\r\nContent-Length: {length}\r\n{headers}\r\n");
            connection.write_all(head.as_bytes()).ok()?;
            let body = if request.is_head { &[] } else { body };
            connection.write_all(body).ok()
        };
        let within = |(from, count): (usize, usize)| (from..from.saturating_add(count)).contains(&number);
        if let Fault::Lies(lie, from, count) = self.fault
            && within((from, count))
        {
            return self.lie(lie, request, number, connection);
        }
        if self.fault == Fault::Missing || !request.path.starts_with("/maps/town.tiles") {
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

impl Shared {
    /// Answers a request with a lie; returns `None` if the connection ends with the answer.
    fn lie(&self, lie: Lie, request: &Request, number: usize, mut connection: &TcpStream) -> Option<()> {
        let whole = self.bytes.len();
        let asked = request.range.clone().unwrap_or(0..whole);
        let range = asked.start.min(whole)..asked.end.min(whole);
        let length = range.len();
        let other = match range.start {
            0 => whole - length..whole,
            _ => 0..length,
        };
        let mut send = |status: &str, headers: &str, body: &[u8]| {
            let head = format!("HTTP/1.1 {status}\r\n{headers}\r\n");
            connection.write_all(head.as_bytes()).ok()?;
            if request.is_head {
                return Some(());
            }
            connection.write_all(body).ok()
        };
        let partial = "206 Partial Content";
        let headers = |tag: &str, range: &Range<usize>, length: usize, whole: u64| {
            let (from, to) = (range.start, range.end.max(1) - 1);
            format!("ETag: \"{tag}\"\r\nContent-Length: {length}\r\nContent-Range: bytes {from}-{to}/{whole}\r\n")
        };
        let truth = headers("one", &range, length, whole as u64);
        let redirect = |to: &str| format!("Location: {to}\r\nContent-Length: 0\r\n");
        let bytes = &self.bytes;
        match lie {
            Lie::Whole => send(
                "200 OK",
                &format!("ETag: \"one\"\r\nContent-Length: {whole}\r\n"),
                bytes,
            ),
            Lie::OtherRange => send(
                partial,
                &headers("one", &other, length, whole as u64),
                &bytes[other.clone()],
            ),
            Lie::OtherBytes => send(partial, &truth, &bytes[other]),
            Lie::OtherHeader => send(partial, &headers("one", &other, length, whole as u64), &bytes[range]),
            Lie::WrongBytes => {
                let mut body = bytes[range].to_vec();
                body.iter_mut()
                    .step_by(97)
                    .for_each(|byte| *byte = byte.wrapping_add(number as u8 | 1));
                send(partial, &truth, &body)
            }
            Lie::TooLong => send(partial, &truth, &[&bytes[range], &bytes[other]].concat()).and(None),
            Lie::Silent => {
                send(partial, &truth, &bytes[range][..length / 2])?;
                thread::sleep(Duration::from_secs(3));
                None
            }
            Lie::Endless => {
                let endless = format!(
                    "ETag: \"one\"\r\nTransfer-Encoding: chunked\r\nContent-Range: bytes {}-{}/{whole}\r\n",
                    range.start,
                    range.end.max(1) - 1
                );
                send(partial, &endless, b"")?;
                endless_chunks(connection)
            }
            Lie::EndlessError => {
                send("403 Forbidden", "Transfer-Encoding: chunked\r\n", b"")?;
                endless_chunks(connection)
            }
            Lie::EndlessHeader => loop {
                connection.write_all(b"X-Much: more and more and more\r\n").ok()?;
            },
            Lie::Drip => {
                send(partial, &truth, b"")?;
                for byte in &bytes[range] {
                    connection.write_all(&[*byte]).ok()?;
                    thread::sleep(Duration::from_millis(100));
                }
                Some(())
            }
            Lie::OtherLength => send(
                partial,
                &headers("one", &range, length, whole as u64 + 4096),
                &bytes[range],
            ),
            Lie::HugeLength => send(partial, &headers("one", &range, length, 1 << 63), &bytes[range]),
            Lie::NewTag => send(
                partial,
                &headers(&number.to_string(), &range, length, whole as u64),
                &bytes[range],
            ),
            Lie::Loop => send("302 Found", &redirect(&request.path), b""),
            Lie::LongWay => send("307 Temporary Redirect", &redirect(&format!("{}x", request.path)), b""),
            Lie::Elsewhere => send("301 Moved Permanently", &redirect(&self.elsewhere), b""),
            Lie::Nowhere => send("302 Found", "Content-Length: 0\r\n", b""),
            Lie::Garbage => send("\0\u{1b}[2J", "\r\n\r\n", &bytes[range]).and(None),
            Lie::NotModified => send("304 Not Modified", "ETag: \"one\"\r\n", b""),
            Lie::Commands => send(
                "403 Forbidden",
                "Content-Length: 22\r\n",
                b"\x1b]0;owned\x07\x1b[2Jerror: \n",
            ),
            Lie::Page => {
                let page = b"\n<!DOCTYPE html>\n<html><head><title>Busy</title></head><body>Come back</body></html>\n";
                let length = format!("Content-Length: {}\r\n", page.len());
                send("503 Service Unavailable", &length, page)
            }
        }
    }
}

/// Sends chunks of bytes until the client closes the connection.
fn endless_chunks(mut connection: &TcpStream) -> Option<()> {
    let mut chunk = b"10000\r\n".to_vec();
    chunk.resize(chunk.len() + 0x10000, b'x');
    chunk.extend(b"\r\n");
    loop {
        connection.write_all(&chunk).ok()?;
    }
}
