//! `tiletool serve`, in a process of its own.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::{Value, json};

use crate::support::command;
use crate::town::Town;

/// A running service; it is killed if it is dropped.
struct Service {
    child: Child,
    address: SocketAddr,
}

impl Service {
    fn start(town: &Town, args: &[&str]) -> Self {
        Self::start_with(town, args, &[])
    }

    fn start_with(town: &Town, args: &[&str], variables: &[(&str, &str)]) -> Self {
        let folder = town.path("town.tiles").parent().unwrap().to_owned();
        let mut command = command(&folder, &["serve", "town.tiles", "--listen", "127.0.0.1:0"]);
        let variables = variables.iter().copied();
        let mut child = command
            .args(args)
            .envs(variables)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap())
            .read_line(&mut line)
            .unwrap();
        assert!(line.starts_with("serving 1 file at http://127.0.0.1:"), "{line}");
        let address = line
            .split("//")
            .nth(1)
            .unwrap()
            .trim_end_matches("/\n")
            .parse()
            .unwrap();
        Self { child, address }
    }

    fn get(&self, path: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(self.address).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nhost: a\r\nconnection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        (head[9..12].parse().unwrap(), body.to_owned())
    }

    fn json(&self, path: &str) -> Value {
        let (status, body) = self.get(path);
        assert_eq!(status, 200, "{path}: {body}");
        serde_json::from_str(&body).unwrap()
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

#[test]
fn answers_are_what_query_prints() {
    let town = Town::new();
    let service = Service::start(&town, &[]);
    assert_eq!(service.json("/town")["line_kinds"], json!(["wall", "obstacle"]));
    for (path, args) in [
        ("locate?at=3.5,-3.9", "locate town.tiles --at 3.5,-3.9"),
        ("nearest?at=3,3&k=3", "nearest town.tiles --at 3,3 -k 3"),
        ("knn?at=3,3&k=3&certify=true", "knn town.tiles --at 3,3 -k 3 --certify"),
        (
            "range?at=3,3&radius=4.5&area=true",
            "range town.tiles --at 3,3 --radius 4.5 --area",
        ),
        ("path?from=-3,0&to=3.5,-3", "path town.tiles --from -3,0 --to 3.5,-3"),
        (
            "path?from=-3,0&to=3.5,-3&mode=fast",
            "path town.tiles --from -3,0 --to 3.5,-3 --mode fast",
        ),
        (
            "path?from=-3,0&to=-2.5,2.5",
            "path town.tiles --from -3,0 --to -2.5,2.5",
        ),
        (
            "along?from=-3,-3.5&to=3.5,3.5&k=2",
            "along town.tiles --from -3,-3.5 --to 3.5,3.5 -k 2",
        ),
    ] {
        let mut args: Vec<&str> = ["query"].into_iter().chain(args.split(' ')).collect();
        let answer = service.json(&format!("/town/query/{path}"));
        args.push("--json");
        let object: Value = serde_json::from_str(&town.run(0, &args)).unwrap();
        for key in ["status", "distance", "lower", "upper", "area", "element"] {
            assert_eq!(answer.get(key), object.get(key), "{path}: {key}");
        }
        args.pop();
        args.push("--geojson");
        let collection: Value = serde_json::from_str(&town.run(0, &args)).unwrap();
        assert_eq!(answer["features"], collection["features"], "{path}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_page_is_opened_in_the_browser() {
    use std::os::unix::fs::PermissionsExt;

    let town = Town::new();
    // A browser that writes down what it is to open.
    let (browser, seen) = (town.path("xdg-open"), town.path("seen"));
    fs::write(
        &browser,
        format!(
            "#!/bin/sh\nprintf %s \"$1\" > '{0}.new' && mv '{0}.new' '{0}'\n",
            seen.display()
        ),
    )
    .unwrap();
    fs::set_permissions(&browser, fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!(
        "{}:{}",
        browser.parent().unwrap().display(),
        std::env::var("PATH").unwrap()
    );
    let service = Service::start_with(&town, &["--open"], &[("PATH", &path)]);
    let began = Instant::now();
    while !seen.exists() && began.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(
        fs::read_to_string(seen).unwrap(),
        format!("http://{}/", service.address)
    );
}

#[test]
fn a_signal_ends_the_service() {
    let town = Town::new();
    // As soon as it has said its address, and when it has answered.
    for (signal, answers) in [(Signal::TERM, false), (Signal::INT, false), (Signal::TERM, true)] {
        let mut service = Service::start(&town, &["--raw"]);
        if answers {
            assert_eq!(service.get("/health").0, 200);
        }
        let began = Instant::now();
        let pid = Pid::from_raw(service.child.id().try_into().unwrap()).unwrap();
        kill_process(pid, signal).unwrap();
        let ended = service.child.wait().unwrap();
        assert!(ended.success(), "{signal:?}: {ended}");
        assert!(began.elapsed() < Duration::from_secs(10));
    }
}

#[test]
fn what_cannot_be_served_is_said() {
    let town = Town::new();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let error = town.run(1, &["serve", "town.tiles", "--listen", &address]);
    assert!(error.contains(&address) && error.contains("--listen"), "{error}");
    let error = town.run(1, &["serve", "missing.tiles", "--listen", "127.0.0.1:0"]);
    assert!(error.contains("missing.tiles"), "{error}");
    let error = town.run(1, &["serve", "town.tiles", "town.tiles", "--listen", "127.0.0.1:0"]);
    assert!(error.contains("rename"), "{error}");
    let error = town.run(1, &["serve", "http://127.0.0.1/town.tiles"]);
    assert!(error.contains("files of this machine"), "{error}");
    assert!(town.run(2, &["serve"]).contains("FILES"));
    assert!(
        town.run(2, &["serve", "town.tiles", "--cors", "maps"])
            .contains("--cors")
    );
}

#[cfg(feature = "object-store")]
#[test]
fn the_tool_reads_a_file_that_it_serves() {
    let town = Town::new();
    let service = Service::start(&town, &["--raw"]);
    let url = format!("http://{}/town/raw", service.address);
    let args = |file: &str| ["query", "path", file, "--from", "-3,0", "--to", "3.5,-3", "--json"].map(str::to_owned);
    let run = |file: &str| {
        let args = args(file);
        town.run(0, &args.iter().map(String::as_str).collect::<Vec<_>>())
    };
    assert_eq!(run(&url), run("town.tiles"));
    let of_remote = town.run(0, &["inspect", &url]);
    assert!(of_remote.contains("sites"), "{of_remote}");
}
