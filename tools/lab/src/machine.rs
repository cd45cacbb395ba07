//! Describes the machine and the command of a measurement in words.

use std::fs;
use std::thread::available_parallelism;

use limited::after_colon;

use tiletool::common;

/// Returns the processor, memory and system, as far as they are known.
pub fn describe() -> String {
    let cores = available_parallelism().map_or(1, usize::from);
    let mut parts = vec![format!(
        "{cores} {}",
        if cores == 1 { "processor" } else { "processors" }
    )];
    let [processors, memory] =
        ["/proc/cpuinfo", "/proc/meminfo"].map(|path| fs::read_to_string(path).unwrap_or_default());
    parts.extend(after_colon(&processors, "model name").map(str::to_owned));
    let memory = after_colon(&memory, "MemTotal").and_then(|text| {
        let kibibytes: u64 = text.split_whitespace().next()?.parse().ok()?;
        Some(format!("{} of memory", common::bytes(kibibytes.checked_mul(1024)?)))
    });
    parts.extend(memory);
    let kernel = fs::read_to_string("/proc/sys/kernel/osrelease");
    parts.push(match kernel {
        Ok(release) => format!("Linux {}", release.trim()),
        Err(_) => std::env::consts::OS.to_owned(),
    });
    parts.join(", ")
}

/// Returns the command that this process was started with, so that it can be repeated: words that a
/// shell would split are quoted.
pub fn command() -> String {
    let words = std::env::args().skip(1).map(|word| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+".contains(c);
        match !word.is_empty() && word.chars().all(plain) {
            true => word,
            false => format!("'{}'", word.replace('\'', "'\\''")),
        }
    });
    std::iter::once("lab".to_owned())
        .chain(words)
        .collect::<Vec<_>>()
        .join(" ")
}
