//! The page about builds: tables of medians, charts, and published figures of others.

use distributions::Kind;

use super::plan::{ALPHA, Data};
use super::record::{Engine, Measured, Record, median};
use crate::folder::Folder;
use crate::machine;
use crate::peer::Peer;
use crate::pictures::Pictures;
use crate::plot::chart::{Chart, ChartLine, Dimension};
use crate::table::{Cell, Column, Table};
use limited::Ended;
use tiletool::common;

/// Keeps the page and its charts.
pub fn keep(measured: &Measured, pictures: Pictures, folder: &mut Folder) -> anyhow::Result<()> {
    let mut page = Page {
        measured,
        pictures,
        folder,
        text: String::new(),
    };
    page.introduction();
    page.by_size(None)?;
    page.by_size(Some(ALPHA))?;
    page.by_alpha()?;
    page.limited()?;
    page.published();
    page.notes();
    let text = std::mem::take(&mut page.text);
    folder.keep("README.md", text);
    Ok(())
}

struct Page<'a> {
    measured: &'a Measured,
    pictures: Pictures,
    folder: &'a mut Folder,
    text: String,
}

/// The value of a process that a line of a chart shows.
type Value = fn(&Record) -> Option<f64>;

/// A quantity of our builds, with its name.
type Quantity = (&'static str, Value);

const TIMES: [Quantity; 2] = [("CPU", Record::cpu), ("waited", Record::waited)];
const BYTES: [Quantity; 2] = [("read", read), ("written", written)];
/// The quantities that go up from the tiles, and their unit.
const SHARES: [Quantity; 2] = [("seam", seam), ("held", held)];
const SHARE: &str = "% of vertices (seam) or triangles (held)";

const MEBIBYTE: f64 = (1u64 << 20) as f64;

fn seconds(record: &Record) -> Option<f64> {
    Some(record.took.seconds)
}

fn peak(record: &Record) -> Option<f64> {
    Some(record.peak()? as f64 / MEBIBYTE)
}

fn read(record: &Record) -> Option<f64> {
    Some(record.read()? as f64 / MEBIBYTE)
}

fn written(record: &Record) -> Option<f64> {
    Some(record.written()? as f64 / MEBIBYTE)
}

fn seam(record: &Record) -> Option<f64> {
    Some(100.0 * record.seam_share()?)
}

fn border(record: &Record) -> Option<f64> {
    Some(100.0 * record.border_share()?)
}

fn held(record: &Record) -> Option<f64> {
    Some(100.0 * record.held_share()?)
}

/// Our build of a set of points, and spade's if there is one.
struct Pair<'a> {
    ours: &'a Record,
    spade: Option<&'a Record>,
}

impl Pair<'_> {
    /// Returns the columns about both, by the share of segments or by the number of points.
    fn columns(is_by_alpha: bool) -> [Column<Self>; 15] {
        let varies: Column<Self> = match is_by_alpha {
            true => ("α", |p| Cell::number(p.ours.data.alpha, 1)),
            false => ("points", |p| p.ours.data.points.into()),
        };
        [
            ("", |p| p.ours.data.kind.name().into()),
            varies,
            ("s", |p| Cell::number(seconds(p.ours), 2)),
            ("CPU s", |p| Cell::number(p.ours.cpu(), 2)),
            ("waited s", |p| Cell::number(p.ours.waited(), 2)),
            ("read MiB", |p| Cell::number(read(p.ours), 1)),
            ("written MiB", |p| Cell::number(written(p.ours), 1)),
            ("seam %", |p| Cell::number(seam(p.ours), 2)),
            ("border %", |p| Cell::number(border(p.ours), 2)),
            ("held %", |p| {
                Cell::number(held(p.ours).filter(|_| p.ours.data.alpha.is_some()), 2)
            }),
            ("blocks", |p| Cell::count(p.ours.blocks())),
            ("peak MiB", |p| Cell::number(peak(p.ours), 0)),
            ("spade s", |p| Cell::number(p.spade.and_then(seconds), 2)),
            ("spade MiB", |p| Cell::number(p.spade.and_then(peak), 0)),
            ("ours/spade", |p| Cell::number(p.ratio(), 2)),
        ]
    }

    fn ratio(&self) -> Option<f64> {
        Some(self.ours.took.seconds / self.spade?.took.seconds)
    }
}

impl Page<'_> {
    fn introduction(&mut self) {
        let m = self.measured;
        self.text += &format!(
            "# Building: time, bytes and memory\n\n\
             `{}`\n\n\
             Measured with tiletool {} on {}. `tiletool build` had {} and {} threads; {}. Each build is a process of its own, from reading the raw points \
             to the finished file; the input was evicted from the page cache before. On the first distribution, \
             spade (and `triangle`, if it is installed) read the same file and triangulate in memory: \
             they keep no result, so they write nothing. All processes are in [builds.csv](builds.csv), with \
             `off_cpu_seconds`, the time less the processor time, which is the I/O time of a program of one thread.\n\n\
             *CPU* is the processor time of all threads. *Waited* is the time that computing threads waited for the disk, summed over the threads: the \
             part of the I/O that was not overlapped. Bytes are those that the program read and wrote: input, work files, tiles. *Seam* is the share of \
             the vertices that tiles hand up, *border* that of the triangles that a merge settles, *held* that of the triangles that are held for segments. \
             The points were divided into blocks; with 1 block, all were in memory. *Peak* is the largest resident size: the program's code may \
             take up to 16 MiB besides the memory that `tiletool build` had; the largest peak of its builds was {}.\n",
            machine::command(),
            env!("CARGO_PKG_VERSION"),
            machine::describe(),
            common::bytes(m.memory),
            m.threads,
            match m.rounds {
                1 => "each was measured once".to_owned(),
                rounds => format!(
                    "figures are those of the median of {rounds} by time, and of one process if a peer took over a minute"
                ),
            },
            m.records
                .iter()
                .filter(|r| r.engine == Engine::Ours)
                .filter_map(Record::peak)
                .max()
                .map_or_else(|| "not known".to_owned(), common::bytes),
        );
    }

    /// Shows results by the number of points: Figures 3.12 and 3.15 of the thesis.
    fn by_size(&mut self, alpha: Option<f64>) -> anyhow::Result<()> {
        let (stem, short, what) = match alpha {
            None => ("dt", "DT".to_owned(), "Delaunay triangulation".to_owned()),
            Some(alpha) => (
                "cdt",
                format!("CDT, α = {alpha}"),
                format!("Constrained Delaunay triangulation, α = {alpha}"),
            ),
        };
        self.text += &format!("\n## {what}, against the number of points\n\n");
        let data = self.of_each_kind(|kind| {
            let sizes = self.measured.plan.sizes.iter();
            sizes.map(|&points| Data { kind, points, alpha }).collect()
        });
        self.text += &self.table(data.iter().flatten(), false);
        self.growths(&data);
        self.charts_by_size(&data, stem, &short, alpha.is_some())
    }

    fn charts_by_size(&mut self, data: &[Vec<Data>], stem: &str, of: &str, has_segments: bool) -> anyhow::Result<()> {
        let by_points = |data: &Data| data.points as f64;
        let times = self.lines(data, seconds, by_points);
        let ours = |parts: &[Quantity]| self.lines_of_ours(data, parts, by_points);
        let memory = self.lines(&data[..1], peak, by_points);
        let shares = if has_segments { &SHARES[..] } else { &SHARES[..1] };
        let [linear, log]: [fn(&str) -> Dimension; 2] = [Dimension::from_zero, Dimension::logarithmic];
        let charts = [
            ("time", "time", log, log("seconds"), times),
            (
                "parts",
                "processor time and waiting for the disk",
                linear,
                linear("seconds, all threads together"),
                ours(&TIMES),
            ),
            ("bytes", "bytes read and written", log, log("MiB"), ours(&BYTES)),
            (
                "shares",
                "vertices and triangles that go up from the tiles",
                log,
                linear(SHARE),
                ours(shares),
            ),
            ("memory", "peak of resident memory", log, log("MiB"), memory),
        ];
        for (what, title, x, y, lines) in charts {
            let (stem, title) = (format!("{stem}-{what}"), format!("{of}: {title}"));
            self.picture(&stem, &title, x("points"), y, lines)?;
        }
        Ok(())
    }

    /// Says how time grows with the points of each distribution.
    fn growths(&mut self, data: &[Vec<Data>]) {
        for (kind, data) in self.measured.plan.kinds.iter().zip(data) {
            let [ours, spade] = [Engine::Ours, Engine::Peer(Peer::Spade)].map(|engine| self.growth(engine, data));
            let Some(ours) = ours else { continue };
            self.text += &format!("\nFrom the smallest to the largest set, {kind}: time grows as N^{ours:.2}");
            self.text += &spade.map_or_else(String::new, |exponent| format!(", spade's as N^{exponent:.2}"));
            self.text += ".\n";
        }
    }

    /// Shows results by the share of segments: Figure 3.16 of the thesis.
    fn by_alpha(&mut self) -> anyhow::Result<()> {
        let points = self.measured.plan.alpha_size;
        let title = format!("{} points, against the share of segments α", common::thousands(points));
        self.text += &format!("\n## {title}\n\n");
        let data = self.of_each_kind(|kind| {
            let alphas = self.measured.plan.alphas.iter();
            let alphas = alphas.map(|&alpha| Data {
                kind,
                points,
                alpha: Some(alpha),
            });
            alphas.collect()
        });
        self.text += &self.table(data.iter().flatten(), true);
        let by_alpha = |data: &Data| data.alpha.unwrap_or(0.0);
        let x = || Dimension::fitted("α: segments for each point");
        let times = self.lines(&data, seconds, by_alpha);
        let y = Dimension::from_zero("seconds");
        self.picture("alpha-time", &format!("Time, {title}"), x(), y, times)?;
        let shares = self.lines_of_ours(&data, &SHARES, by_alpha);
        let y = Dimension::from_zero(SHARE);
        self.picture(
            "alpha-shares",
            &format!("Vertices and triangles that go up, {title}"),
            x(),
            y,
            shares,
        )
    }

    /// Shows results under a hard limit, which ends the engines that work in memory.
    fn limited(&mut self) -> anyhow::Result<()> {
        let limit = &self.measured.limit;
        self.text += &format!(
            "\n## Under a hard limit of memory\n\nThe same processes again on points of the first distribution, {}, with {}. `tiletool build` had a budget of {}.\n\n",
            self.measured.plan.kinds.first().map_or("", |kind| kind.name()),
            limit.describe(),
            common::bytes(self.measured.memory)
        );
        let mut table = Table::new(["points", "α", "engine", "end", "seconds", "peak MiB"]);
        let plan = &self.measured.plan;
        let limited: Vec<Data> = plan
            .data()
            .iter()
            .copied()
            .filter(|data| plan.is_limited(data))
            .collect();
        for data in &limited {
            for engine in self.engines() {
                let Some(record) = median(&self.measured.records, engine, data, Some(limit.bytes)) else {
                    continue;
                };
                table.push([
                    data.points.into(),
                    data.alpha
                        .map_or_else(|| "–".into(), |alpha| Cell::Text(alpha.to_string())),
                    engine.name().into(),
                    Cell::Text(match record.took.ended {
                        Ended::Done => "done".to_owned(),
                        Ended::Failed(code) => format!("failed (exit code {code})"),
                        Ended::Killed(signal) => format!("**killed** (signal {signal})"),
                    }),
                    Cell::Number(record.took.seconds, 2),
                    Cell::number(peak(record), 0),
                ]);
            }
        }
        self.text += &table.markdown();
        let lines = self.engines().into_iter().zip(0..).map(|(engine, colour)| {
            let records = limited
                .iter()
                .filter(|data| data.alpha.is_none())
                .filter_map(|data| median(&self.measured.records, engine, data, Some(limit.bytes)));
            let (done, ended): (Vec<_>, Vec<_>) = records.partition(|record| record.is_done());
            ChartLine {
                name: engine.name().to_owned(),
                colour,
                is_dashed: false,
                points: done.iter().map(|r| (r.data.points as f64, r.took.seconds)).collect(),
                failures: ended.iter().map(|r| r.data.points as f64).collect(),
            }
        });
        let lines = lines.collect();
        let kind = plan.kinds.first().map_or("", |kind| kind.name());
        let title = format!(
            "{kind}, within {}; a cross: failed or killed",
            common::bytes(limit.bytes)
        );
        let (x, y) = (Dimension::logarithmic("points"), Dimension::logarithmic("seconds"));
        self.picture("limit", &title, x, y, lines)
    }

    /// Shows published results of others.
    fn published(&mut self) {
        let mut table = Table::new(["source", "points", "minutes", "points/s", "memory", "on"]);
        table.push([
            "Isenburg, Liu, Shewchuk and Snoeyink 2006, streaming".into(),
            500_000_000.into(),
            Cell::Number(48.0, 1),
            Cell::Number(500e6 / (48.0 * 60.0), 0),
            "70 MB".into(),
            "a laptop of 2006 with two hard drives; lidar points (11.2 GB) in the order of their survey".into(),
        ]);
        let m = self.measured;
        let largest = m.plan.kinds.iter().map(|&kind| {
            let points = m.plan.sizes.last().copied().unwrap_or(0);
            let data = Data {
                kind,
                points,
                alpha: None,
            };
            median(&m.records, Engine::Ours, &data, None)
        });
        for record in largest.flatten() {
            let points = record.data.points;
            table.push([
                Cell::Text(format!("this run, {}", record.data.kind)),
                points.into(),
                Cell::Number(record.took.seconds / 60.0, 2),
                Cell::Number(points as f64 / record.took.seconds, 0),
                Cell::Text(record.peak().map_or_else(|| "–".to_owned(), common::bytes)),
                Cell::Text(format!("{}; points in random order", machine::describe())),
            ]);
        }
        self.text += "\n## Comparison with published figures\n\n";
        self.text += &table.markdown();
        self.text += "\nThese are different machines, twenty years apart, and different tasks. Theirs triangulates points in the \
             order of a survey, and streams the result out as it is made, on one processor and hard drives. Ours takes points in any order, stores an index for reading the result, and uses \
             all processors and today's storage. So points per second do not compare the algorithms. Two things are comparable: the memory \
             is bounded in both, and in both the time grows as the input does. The thesis compares its times with those of Kumar and Ramos (*I/O-efficient construction of Voronoi diagrams*, \
             2002), for Delaunay triangulations without constraints; that report was not available, so their figures are not repeated here: see section 3.5 of the thesis.\n";
    }

    fn notes(&mut self) {
        if self.measured.notes.is_empty() {
            self.text += "\nAll processes that succeeded count the same triangles and constraint edges.\n";
            return;
        }
        self.text += "\n## Notes\n\n";
        for note in &self.measured.notes {
            self.text += &format!("- {note}\n");
        }
    }

    /// Returns the engines that have records, ours first.
    fn engines(&self) -> Vec<Engine> {
        let mut engines = Vec::new();
        for record in &self.measured.records {
            if !engines.contains(&record.engine) {
                engines.push(record.engine);
            }
        }
        engines
    }

    /// Returns sets of points, one list for each distribution.
    fn of_each_kind(&self, data: impl Fn(Kind) -> Vec<Data>) -> Vec<Vec<Data>> {
        self.measured.plan.kinds.iter().map(|&kind| data(kind)).collect()
    }

    fn median(&self, engine: Engine, data: &Data) -> Option<&Record> {
        median(&self.measured.records, engine, data, None)
    }

    /// Returns a table of the sets of points, by their number or by the share of segments.
    fn table<'d>(&self, data: impl Iterator<Item = &'d Data>, is_by_alpha: bool) -> String {
        let pairs: Vec<_> = data.filter_map(|one| self.pair(one)).collect();
        Table::of(&Pair::columns(is_by_alpha), &pairs).markdown()
    }

    /// Returns our build of a set of points, and spade's.
    fn pair(&self, data: &Data) -> Option<Pair<'_>> {
        let spade = self.median(Engine::Peer(Peer::Spade), data);
        Some(Pair {
            ours: self.median(Engine::Ours, data)?,
            spade: spade.filter(|spade| spade.is_done()),
        })
    }

    /// Returns the exponent with which time grows from the first set to the last.
    fn growth(&self, engine: Engine, data: &[Data]) -> Option<f64> {
        let [first, last] = [data.first()?, data.last()?];
        let [a, b] = [self.median(engine, first)?, self.median(engine, last)?];
        let is_known = a.is_done() && b.is_done() && first.points < last.points;
        let times = b.took.seconds / a.took.seconds;
        is_known.then(|| times.ln() / (last.points as f64 / first.points as f64).ln())
    }

    /// Returns a line for each engine and each distribution that it triangulated. Distributions have
    /// colours; every second engine has dashed lines.
    fn lines(&self, data: &[Vec<Data>], value: Value, x: impl Fn(&Data) -> f64 + Copy) -> Vec<ChartLine> {
        let mut lines = Vec::new();
        for (index, engine) in self.engines().into_iter().enumerate() {
            for (colour, data) in data.iter().enumerate() {
                let Some(first) = data.first() else { continue };
                let name = format!("{}, {}", engine.name(), first.kind);
                lines.push(self.line(name, engine, (colour + 3 * (index / 2), index % 2 > 0), data, value, x));
            }
        }
        lines.retain(|line| !line.points.is_empty() || !line.failures.is_empty());
        lines
    }

    /// Returns a line for each quantity of our builds and each distribution; for several quantities,
    /// only the first and the last distribution, since more lines are hard to tell apart. All
    /// quantities but the first have dashed lines.
    fn lines_of_ours(&self, data: &[Vec<Data>], parts: &[Quantity], x: impl Fn(&Data) -> f64 + Copy) -> Vec<ChartLine> {
        let mut lines = Vec::new();
        for (index, &(part, value)) in parts.iter().enumerate() {
            for (colour, data) in data.iter().enumerate() {
                let is_between = colour > 0 && colour + 1 < self.measured.plan.kinds.len();
                let Some(first) = data.first().filter(|_| parts.len() == 1 || !is_between) else {
                    continue;
                };
                let name = format!("{part}, {}", first.kind);
                lines.push(self.line(name, Engine::Ours, (colour, index > 0), data, value, x));
            }
        }
        lines
    }

    fn line(
        &self,
        name: String,
        engine: Engine,
        (colour, is_dashed): (usize, bool),
        data: &[Data],
        value: Value,
        x: impl Fn(&Data) -> f64,
    ) -> ChartLine {
        let records = data.iter().filter_map(|one| Some((x(one), self.median(engine, one)?)));
        let (done, ended): (Vec<_>, Vec<_>) = records.partition(|(_, record)| record.is_done());
        ChartLine {
            name,
            colour,
            is_dashed,
            points: done
                .into_iter()
                .filter_map(|(x, record)| Some((x, value(record)?)))
                .collect(),
            failures: ended.into_iter().map(|(x, _)| x).collect(),
        }
    }

    /// Keeps a chart, and shows it on the page.
    fn picture(
        &mut self,
        stem: &str,
        title: &str,
        x: Dimension,
        y: Dimension,
        lines: Vec<ChartLine>,
    ) -> anyhow::Result<()> {
        let chart = Chart {
            title: title.to_owned(),
            subtitle: format!(
                "tiletool build with {} and {} threads",
                common::bytes(self.measured.memory),
                self.measured.threads
            ),
            x,
            y,
            lines,
        };
        self.text += &self.pictures.keep(stem, title, chart.draw(), self.folder)?;
        Ok(())
    }
}
