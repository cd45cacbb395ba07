//! Stars: hundreds of lines that share a vertex, with so little memory that most of them are
//! deferred, or added to a file later.
//!
//! Each result is compared with that of a build that has all lines in memory, and `verify` proves
//! it.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::ensure;
use rand_chacha::ChaCha8Rng;

use crate::campaign::{Context, Counts, below};

type P = [i64; 2];

/// Points, and lines that do not cross each other.
struct Stars {
    points: Vec<P>,
    lines: Vec<[P; 2]>,
}

/// Builds stars in three ways.
pub fn round(context: &Context, mut random: ChaCha8Rng) -> anyhow::Result<Counts> {
    let random = &mut random;
    let stars = Stars::random(random);
    let folder = tempfile::tempdir()?;
    let path = folder.path();
    let bytes = stars.points.iter().flatten().flat_map(|&c| (c as f64).to_le_bytes());
    fs::write(path.join("p.f64"), bytes.collect::<Vec<u8>>())?;
    let first = below(random, stars.lines.len() as u64 + 1) as usize;
    let (built, later) = stars.lines.split_at(first);
    for (name, lines) in [("all.csv", &*stars.lines), ("built.csv", built), ("later.csv", later)] {
        fs::write(path.join(name), rows(lines))?;
    }
    context.run(
        path,
        "build p.f64 --segments all.csv -o enough.tiles --memory 256MiB --quiet",
    )?;
    let expected = context.run(path, "digest --recompute enough.tiles")?;
    let options = format!(
        "--tile-vertices {} --memory {}MiB --threads {}",
        16 + below(random, 241),
        // With 1 MiB some sets are refused, since their seams take more.
        2 + below(random, 3),
        1 + below(random, 2),
    );
    let summary = context.run(
        path,
        &format!("build p.f64 --segments all.csv -o little.tiles {options} --json"),
    )?;
    check(context, path, "little.tiles", "--segments all.csv", &expected)?;
    let mut inputs = String::new();
    for (name, lines) in [("built.csv", built), ("later.csv", later)] {
        if !lines.is_empty() {
            write!(inputs, "--segments {name} ")?;
        }
    }
    let of_build = if built.is_empty() { "" } else { " --segments built.csv" };
    context.run(
        path,
        &format!("build p.f64{of_build} -o edited.tiles {options} --quiet"),
    )?;
    if !later.is_empty() {
        let memory = 1 + below(random, 4);
        context.run(
            path,
            &format!("constrain edited.tiles --segments later.csv --memory {memory}MiB --quiet"),
        )?;
    }
    check(context, path, "edited.tiles", inputs.trim_end(), &expected)?;
    Ok(vec![
        ("lines", stars.lines.len() as u64),
        ("lines put off", number(&summary, "deferred_segments")),
        ("lines added later", later.len() as u64),
    ])
}

/// Verifies a file, and compares its digest.
fn check(context: &Context, path: &Path, file: &str, inputs: &str, expected: &str) -> anyhow::Result<()> {
    context.run(path, &format!("verify --deep {file} --against p.f64 {inputs}"))?;
    let digest = context.run(path, &format!("digest --recompute {file}"))?;
    ensure!(digest == expected, "{file} is\n{digest}instead of\n{expected}");
    Ok(())
}

/// Returns the number after a name in JSON, or 0.
fn number(json: &str, name: &str) -> u64 {
    let value = json.split(&format!("\"{name}\":")).nth(1).unwrap_or_default();
    let digits = value.trim_start().chars().take_while(char::is_ascii_digit);
    digits.collect::<String>().parse().unwrap_or(0)
}

fn rows(lines: &[[P; 2]]) -> String {
    let row = |&[[ax, ay], [bx, by]]: &[P; 2]| format!("{ax},{ay},{bx},{by}\n");
    lines.iter().map(row).collect()
}

impl Stars {
    fn random(random: &mut ChaCha8Rng) -> Self {
        let mut stars = Self {
            points: Vec::new(),
            lines: Vec::new(),
        };
        let most = [20, 150, 600][below(random, 3) as usize];
        let degree = 3 + below(random, most);
        match below(random, 3) {
            // Two stars, one on each side of x = 0.
            0 => {
                for hub in [[-3000, 0], [3000, 17]] {
                    stars.add(random, hub, degree / 2 + 1, 0.0);
                }
                stars.lines.push([[-3000, 0], [3000, 17]]);
            }
            // A corner with all lines on one side of it.
            1 => stars.add(random, [0, 0], degree, 0.5),
            _ => stars.add(random, [0, 0], degree, 0.0),
        }
        // Other points between the lines, and on them.
        for _ in 0..below(random, 3) * degree {
            stars
                .points
                .push([below(random, 12_000) as i64 - 6000, below(random, 8000) as i64 - 4000]);
        }
        // A hull around everything; without it an edit could not add all ends.
        for x in [-9000, 9000] {
            stars.points.extend([[x, -9000], [x, 9000]]);
        }
        for index in (1..stars.lines.len()).rev() {
            stars.lines.swap(index, below(random, index as u64 + 1) as usize);
        }
        // In half of the sets the ends are points too.
        if below(random, 2) == 0 {
            stars.points.extend(stars.lines.as_flattened());
        }
        stars
    }

    /// Adds a star around a hub, in all directions or without the share `without` of them.
    fn add(&mut self, random: &mut ChaCha8Rng, hub: P, degree: u64, without: f64) {
        let unit = |random: &mut ChaCha8Rng| below(random, 1 << 30) as f64 / f64::from(1 << 30);
        let jitter = [0.0, 0.01, 0.5][below(random, 3) as usize];
        let is_regular = below(random, 2) == 0;
        let collinear = below(random, 3);
        for spoke in 0..degree {
            let share = if is_regular {
                spoke as f64 / degree as f64
            } else {
                unit(random)
            };
            let angle = std::f64::consts::TAU * share * (1.0 - without);
            let radius = 600.0 * (1.0 + jitter * unit(random));
            let step = [
                (radius * angle.cos()).round() as i64,
                (radius * angle.sin()).round() as i64,
            ];
            let at = |steps: u64| [0, 1].map(|axis| hub[axis] + steps as i64 * step[axis]);
            let steps = 1 + below(random, 1 + collinear);
            let far = at(steps);
            if step == [0, 0] {
                continue;
            }
            // Vertices on the line, and lines that overlap.
            for between in 1..steps {
                if below(random, 2) == 0 {
                    self.points.push(at(between));
                } else {
                    self.lines.push([hub, at(between)]);
                }
            }
            let is_turned = below(random, 2) == 0;
            self.lines.push(if is_turned { [far, hub] } else { [hub, far] });
        }
    }
}
