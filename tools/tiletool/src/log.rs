//! The library's log on standard error.

use std::fmt::{self, Debug, Display, Formatter, Write};
use std::io;

use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::{Event, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::fmt::format::FmtSpan;
use tracing_subscriber::layer::{Context, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

use crate::common;

/// The environment variable that says what is logged, by module.
const CHOICE: &str = "RUST_LOG";

/// Sends the library's log to standard error: warnings, one line each, at level 0; the plan of a build at
/// 1, each step at 2, and everything from 3 on. At level 0, the environment variable `RUST_LOG` may ask
/// for more, as `info` or `delaunay_tiles::io=trace`.
pub fn start(verbose: u8) {
    let all = |level| Some(Targets::new().with_default(level));
    let filter = match verbose {
        0 => chosen(),
        1 => all(LevelFilter::INFO),
        2 => all(LevelFilter::DEBUG),
        _ => all(LevelFilter::TRACE),
    };
    let registry = tracing_subscriber::registry();
    let started = match filter {
        None => registry.with(Warnings.with_filter(LevelFilter::WARN)).try_init(),
        Some(filter) => {
            let lines = tracing_subscriber::fmt::layer()
                .with_span_events(FmtSpan::CLOSE)
                .with_ansi(false)
                .with_writer(io::stderr);
            registry.with(lines.with_filter(filter)).try_init()
        }
    };
    // If the process has a log already, the library writes to that.
    drop(started);
}

/// Returns what the environment asks for.
fn chosen() -> Option<Targets> {
    let text = std::env::var_os(CHOICE).filter(|text| !text.is_empty())?;
    let text = text.to_string_lossy();
    match text.parse() {
        Ok(targets) => Some(targets),
        Err(error) => {
            common::say(format_args!("warning: {CHOICE}={text} is ignored: {error}"));
            None
        }
    }
}

/// Prints each event on a line for people.
struct Warnings;

impl<S: Subscriber> Layer<S> for Warnings {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let mut line = Line::default();
        event.record(&mut line);
        common::say(format_args!("warning: {line}"));
    }
}

/// The message of an event, and its other fields.
#[derive(Default)]
struct Line {
    message: String,
    fields: String,
}

impl Visit for Line {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        // Writing to a string does not fail.
        let _ = match field.name() {
            "message" => write!(self.message, "{value:?}"),
            "error" => write!(self.fields, ": {value:?}"),
            name => write!(self.fields, "; {name}: {value:?}"),
        };
    }
}

impl Display for Line {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        f.write_str(&self.fields)
    }
}
