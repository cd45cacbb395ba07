use std::net::SocketAddr;
use std::time::{Duration, Instant};

use delaunay_tiles_service::{Options, Service, serve};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

use crate::support::Files;

/// A service that listens.
struct Running {
    address: SocketAddr,
    end: oneshot::Sender<()>,
    task: JoinHandle<std::io::Result<()>>,
}

async fn start(files: &Files, options: Options) -> Running {
    let (service, _): (Service, _) = files.service(options).await;
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let (end, ended) = oneshot::channel();
    let task = tokio::spawn(serve(service, listener, async { _ = ended.await }));
    Running { address, end, task }
}

/// Sends a request on a connection of its own. Returns the whole answer.
async fn ask(address: SocketAddr, path: &str) -> String {
    let mut stream = TcpStream::connect(address).await.unwrap();
    let request = format!("GET {path} HTTP/1.1\r\nhost: a\r\nconnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    // A connection that was refused may be reset after its answer.
    _ = stream.read_to_end(&mut answer).await;
    String::from_utf8_lossy(&answer).into_owned()
}

async fn metric(address: SocketAddr, name: &str) -> u64 {
    let text = ask(address, "/metrics").await;
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix(&format!("delaunay_tiles_{name} ")));
    line.unwrap_or_else(|| panic!("no {name} in {text}")).parse().unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn requests_are_answered_over_connections() {
    let files = Files::new().await;
    let running = start(&files, Options::default()).await;
    assert!(ask(running.address, "/health").await.starts_with("HTTP/1.1 200 OK"));
    let path = ask(running.address, "/town/query/path?from=0,0&to=17,18").await;
    assert!(path.contains("\"distance\""), "{path}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_does_not_read_is_left() {
    let files = Files::new().await;
    let mut options = Options::default();
    options.raw = true;
    options.write_timeout = Duration::from_millis(300);
    let running = start(&files, options).await;
    let mut slow = TcpStream::connect(running.address).await.unwrap();
    // Far more than the buffers of a connection hold.
    let request = "GET /hill/raw HTTP/1.1\r\nhost: a\r\n\r\n".repeat(100);
    slow.write_all(request.as_bytes()).await.unwrap();
    let began = Instant::now();
    while metric(running.address, "connections").await > 1 {
        assert!(began.elapsed() < Duration::from_secs(20), "the connection stays");
        sleep(Duration::from_millis(50)).await;
    }
    assert_eq!(metric(running.address, "outgoing_bytes").await, 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_does_not_send_is_left() {
    let files = Files::new().await;
    let mut options = Options::default();
    options.read_timeout = Duration::from_millis(200);
    let running = start(&files, options).await;
    let mut slow = TcpStream::connect(running.address).await.unwrap();
    slow.write_all(b"GET /health HT").await.unwrap();
    let mut answer = Vec::new();
    let read = timeout(Duration::from_secs(10), slow.read_to_end(&mut answer)).await;
    assert!(read.is_ok(), "the connection stays");
    let mut slow = TcpStream::connect(running.address).await.unwrap();
    let head = b"POST /town/query/matrix HTTP/1.1\r\nhost: a\r\ncontent-length: 100\r\n\r\n{";
    slow.write_all(head).await.unwrap();
    let mut answer = [0; 12];
    timeout(Duration::from_secs(10), slow.read_exact(&mut answer))
        .await
        .unwrap()
        .unwrap();
    assert_eq!(&answer, b"HTTP/1.1 408");
}

#[tokio::test(flavor = "multi_thread")]
async fn connections_beyond_the_limit_are_answered_503() {
    let files = Files::new().await;
    let mut options = Options::default();
    options.max_connections = 3;
    let running = start(&files, options).await;
    let mut held = Vec::new();
    for _ in 0..3 {
        let mut stream = TcpStream::connect(running.address).await.unwrap();
        stream
            .write_all(b"GET /health HTTP/1.1\r\nhost: a\r\n\r\n")
            .await
            .unwrap();
        let mut answer = [0; 15];
        stream.read_exact(&mut answer).await.unwrap();
        assert_eq!(&answer, b"HTTP/1.1 200 OK");
        held.push(stream);
    }
    let mut refused = TcpStream::connect(running.address).await.unwrap();
    let mut answer = Vec::new();
    refused.read_to_end(&mut answer).await.unwrap();
    let answer = String::from_utf8(answer).unwrap();
    assert!(
        answer.starts_with("HTTP/1.1 503") && answer.to_lowercase().contains("retry-after: 1"),
        "{answer}"
    );
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    assert!(head.contains(&format!("Content-Length: {}", body.len())), "{answer}");
    assert_eq!(serde_json::from_str::<serde_json::Value>(body).unwrap()["status"], 503);
    held.pop();
    sleep(Duration::from_millis(100)).await;
    assert!(ask(running.address, "/health").await.starts_with("HTTP/1.1 200 OK"));
}

#[tokio::test(flavor = "multi_thread")]
async fn one_who_leaves_ends_the_work() {
    let files = Files::new().await;
    let mut options = Options::default();
    (options.at_once, options.queue) = (1, 0);
    let running = start(&files, options).await;
    for _ in 0..5 {
        let mut leaves = TcpStream::connect(running.address).await.unwrap();
        let points: Vec<String> = (0..100).map(|i| format!("[0.{i},7]")).collect();
        let body = format!("{{\"from\":[{}]}}", points.join(","));
        let request = format!(
            "POST /town/query/matrix HTTP/1.1\r\nhost: a\r\ncontent-length: {}\r\n\r\n{body}",
            body.len()
        );
        leaves.write_all(request.as_bytes()).await.unwrap();
        sleep(Duration::from_millis(5)).await;
        drop(leaves);
        let began = Instant::now();
        while metric(running.address, "running").await > 0 {
            assert!(began.elapsed() < Duration::from_secs(5), "the work goes on");
            sleep(Duration::from_millis(10)).await;
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_end_lets_running_requests_end_and_refuses_others() {
    let files = Files::new().await;
    let mut options = Options::default();
    options.drain = Duration::from_secs(5);
    let running = start(&files, options).await;
    let mut slow = TcpStream::connect(running.address).await.unwrap();
    let head = b"POST /town/query/matrix HTTP/1.1\r\nhost: a\r\ncontent-length: 18\r\n\r\n{";
    slow.write_all(head).await.unwrap();
    let mut idle = TcpStream::connect(running.address).await.unwrap();
    sleep(Duration::from_millis(100)).await;
    running.end.send(()).unwrap();
    // Idle connections are closed, and the service says that it ends.
    let mut rest = Vec::new();
    timeout(Duration::from_secs(3), idle.read_to_end(&mut rest))
        .await
        .unwrap()
        .unwrap();
    let health = ask(running.address, "/health").await;
    assert!(
        health.starts_with("HTTP/1.1 503") && health.contains("draining"),
        "{health}"
    );
    assert!(
        ask(running.address, "/town/query/locate?at=0,0")
            .await
            .starts_with("HTTP/1.1 503")
    );
    slow.write_all(b"\"from\":[[0,0.1]]}").await.unwrap();
    let mut answer = Vec::new();
    timeout(Duration::from_secs(3), slow.read_to_end(&mut answer))
        .await
        .unwrap()
        .unwrap();
    let answer = String::from_utf8(answer).unwrap();
    assert!(
        answer.starts_with("HTTP/1.1 200") && answer.contains("from_index"),
        "{answer}"
    );
    timeout(Duration::from_secs(3), running.task)
        .await
        .unwrap()
        .unwrap()
        .unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn the_end_comes_in_time_even_if_clients_stay() {
    let files = Files::new().await;
    let mut options = Options::default();
    options.drain = Duration::from_millis(500);
    let running = start(&files, options).await;
    let mut slow = TcpStream::connect(running.address).await.unwrap();
    slow.write_all(b"POST /town/query/matrix HTTP/1.1\r\nhost: a\r\ncontent-length: 17\r\n\r\n{")
        .await
        .unwrap();
    sleep(Duration::from_millis(100)).await;
    running.end.send(()).unwrap();
    timeout(Duration::from_secs(3), running.task)
        .await
        .unwrap()
        .unwrap()
        .unwrap();
}
