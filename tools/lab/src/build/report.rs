//! The page about builds: tables of medians, charts, and the figures that others have published.

use distributions::Kind;

use super::plan::{ALPHA, Data};
use super::record::{Engine, Measured, Record, median};
use crate::folder::Folder;
use crate::machine;
use crate::peer::Peer;
use crate::pictures::Pictures;
use crate::plot::chart::{Chart, Dimension, Line};
use crate::table::{Cell, Table};
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

/// A line of a chart: of which engine, and what of it.
type Value = fn(&Record) -> Option<f64>;

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

fn held(record: &Record) -> Option<f64> {
    Some(100.0 * record.held_share()?)
}

impl Page<'_> {
    fn introduction(&mut self) {
        let m = self.measured;
        self.text += &format!(
            "# Building: time, bytes and memory\n\n\
             `{}`\n\n\
             Measured with tiletool {} on {}. `tiletool build` had {} and {} threads; {}. Each build is a process of its own, from reading the raw points \
             to the finished file; the input was thrown out of the page cache before. spade (and `triangle`, where it is installed) read the same file and triangulate in memory: \
             they keep nothing, so they write nothing. All processes are in [builds.csv](builds.csv), with \
             `off_cpu_seconds`, the time less the processor time, which is what a program of one thread has as its I/O time.\n\n\
             *CPU* is processor time of all threads. *Waited* is how long computing threads stood still for the disk, all added up: the \
             part of the I/O that was not overlapped. Bytes are those that the program read and wrote: input, work files, tiles. *Seam* is the share of \
             the vertices that tiles hand up, *border* that of the triangles that a merge settles, *held* that of the triangles that segments hold back. \
             Blocks are what the points were cut into; with 1, all were in memory.\n",
            machine::command(),
            env!("CARGO_PKG_VERSION"),
            machine::describe(),
            common::bytes(m.memory),
            m.threads,
            match m.rounds {
                1 => "each was measured once".to_owned(),
                rounds => format!("figures are of the middle one of {rounds} by time"),
            },
        );
    }

    /// Against the number of points: Figures 3.12 and 3.15 of the thesis.
    fn by_size(&mut self, alpha: Option<f64>) -> anyhow::Result<()> {
        let what = match alpha {
            None => "Delaunay triangulation".to_owned(),
            Some(alpha) => format!("Constrained Delaunay triangulation, α = {alpha}"),
        };
        let (stem, short) = match alpha {
            None => ("dt", "DT".to_owned()),
            Some(alpha) => ("cdt", format!("CDT, α = {alpha}")),
        };
        self.text += &format!("\n## {what}, against the number of points\n\n");
        let data = self.of_each_kind(|kind| {
            let sizes = self.measured.plan.sizes.iter();
            sizes.map(|&points| Data { kind, points, alpha }).collect()
        });
        self.text += &self.table(data.iter().flatten(), false).markdown();
        for (kind, data) in self.measured.plan.kinds.iter().zip(&data) {
            let [ours, its] = [Engine::Ours, Engine::Peer(Peer::Spade)].map(|engine| self.growth(engine, data));
            let Some(ours) = ours else { continue };
            self.text += &format!("\nFrom the smallest to the largest, {kind}: time grows as N^{ours:.2}");
            self.text += &its.map_or_else(String::new, |its| format!(", spade's as N^{its:.2}"));
            self.text += ".\n";
        }
        let x = || Dimension::logarithmic("points");
        let by_points = |data: &Data| data.points as f64;
        let times = self.lines(&data, &self.engines(), seconds, by_points);
        self.picture(
            &format!("{stem}-time"),
            &format!("{short}: time"),
            x(),
            Dimension::logarithmic("seconds"),
            times,
        )?;
        let mut parts = self.lines_of_ours(&data, "CPU", 0, Record::cpu, by_points);
        parts.extend(self.lines_of_ours(&data, "waited", 1, Record::waited, by_points));
        self.picture(
            &format!("{stem}-parts"),
            &format!("{short}: processor time and waiting for the disk"),
            Dimension::from_zero("points"),
            Dimension::from_zero("seconds, all threads together"),
            parts,
        )?;
        let mut bytes = self.lines_of_ours(&data, "read", 0, read, by_points);
        bytes.extend(self.lines_of_ours(&data, "written", 1, written, by_points));
        self.picture(
            &format!("{stem}-bytes"),
            &format!("{short}: bytes read and written"),
            x(),
            Dimension::logarithmic("MiB"),
            bytes,
        )?;
        let mut shares = self.lines_of_ours(&data, "seam", 0, seam, by_points);
        if alpha.is_some() {
            shares.extend(self.lines_of_ours(&data, "held", 1, held, by_points));
        }
        self.picture(
            &format!("{stem}-shares"),
            &format!("{short}: what goes up from the tiles"),
            x(),
            Dimension::from_zero("% of vertices (seam) or triangles (held)"),
            shares,
        )?;
        let memory = self.lines(&data[..1], &self.engines(), peak, by_points);
        self.picture(
            &format!("{stem}-memory"),
            &format!("{short}: peak of resident memory"),
            x(),
            Dimension::logarithmic("MiB"),
            memory,
        )
    }

    /// Against the share of segments: Figure 3.16 of the thesis.
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
        self.text += &self.table(data.iter().flatten(), true).markdown();
        let by_alpha = |data: &Data| data.alpha.unwrap_or(0.0);
        let x = || Dimension::fitted("α: segments for each point");
        let times = self.lines(&data, &self.engines(), seconds, by_alpha);
        self.picture(
            "alpha-time",
            &format!("Time, {title}"),
            x(),
            Dimension::from_zero("seconds"),
            times,
        )?;
        let mut shares = self.lines_of_ours(&data, "seam", 0, seam, by_alpha);
        shares.extend(self.lines_of_ours(&data, "held", 1, held, by_alpha));
        let y = Dimension::from_zero("% of vertices (seam) or triangles (held)");
        self.picture("alpha-shares", &format!("What goes up, {title}"), x(), y, shares)
    }

    /// Under a hard limit, where those who work in memory are ended.
    fn limited(&mut self) -> anyhow::Result<()> {
        let limit = &self.measured.limit;
        self.text += &format!(
            "\n## Under a hard limit of memory\n\nThe same once more on points of the first distribution, {}, with {}. `tiletool build` was told to use {}.\n\n",
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
                        Ended::Failed(code) => format!("gave up (exit code {code})"),
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
            Line {
                name: engine.name().to_owned(),
                colour,
                is_dashed: false,
                points: done.iter().map(|r| (r.data.points as f64, r.took.seconds)).collect(),
                failures: ended.iter().map(|r| r.data.points as f64).collect(),
            }
        });
        let lines = lines.collect();
        let kind = plan.kinds.first().map_or("", |kind| kind.name());
        let title = format!("{kind}, within {}; a cross: ended", common::bytes(limit.bytes));
        let (x, y) = (Dimension::logarithmic("points"), Dimension::logarithmic("seconds"));
        self.picture("limit", &title, x, y, lines)
    }

    /// What others have published.
    fn published(&mut self) {
        let mut table = Table::new(["who", "points", "minutes", "points/s", "memory", "on"]);
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
        self.text += "\n## Beside published figures\n\n";
        self.text += &table.markdown();
        self.text += "\nThese are different machines, twenty years apart, and different tasks: theirs is a triangulation of points that come in the \
             order of a survey, streamed out as it is made, on one processor and hard drives; ours takes points in any order, keeps an index to read the result by, and uses \
             all processors and what storage there is now. Points per second do not compare algorithms across that; what does is the memory, \
             which is bounded in both, and that time grows as the input does. The thesis sets its times beside those of Kumar and Ramos (*I/O-efficient construction of Voronoi diagrams*, \
             2002), of Delaunay triangulations without constraints; that report was not to be had, so their figures are not repeated here: see section 3.5 of the thesis.\n";
    }

    fn notes(&mut self) {
        if self.measured.notes.is_empty() {
            self.text += "\nAll that were not ended count the same triangles and constraint edges.\n";
            return;
        }
        self.text += "\n## Notes\n\n";
        for note in &self.measured.notes {
            self.text += &format!("- {note}\n");
        }
    }

    /// Those of which there is anything, ours first.
    fn engines(&self) -> Vec<Engine> {
        let mut engines = Vec::new();
        for record in &self.measured.records {
            if !engines.contains(&record.engine) {
                engines.push(record.engine);
            }
        }
        engines
    }

    /// Sets of points, one list for each distribution.
    fn of_each_kind(&self, data: impl Fn(Kind) -> Vec<Data>) -> Vec<Vec<Data>> {
        self.measured.plan.kinds.iter().map(|&kind| data(kind)).collect()
    }

    fn median(&self, engine: Engine, data: &Data) -> Option<&Record> {
        median(&self.measured.records, engine, data, None)
    }

    fn table<'d>(&self, data: impl Iterator<Item = &'d Data>, is_by_alpha: bool) -> Table {
        let varies = if is_by_alpha { "α" } else { "points" };
        let mut table = Table::new([
            "",
            varies,
            "s",
            "CPU s",
            "waited s",
            "read MiB",
            "written MiB",
            "seam %",
            "border %",
            "held %",
            "blocks",
            "peak MiB",
            "spade s",
            "spade MiB",
            "ours/spade",
        ]);
        for one in data {
            let Some(ours) = self.median(Engine::Ours, one) else {
                continue;
            };
            let spade = self
                .median(Engine::Peer(Peer::Spade), one)
                .filter(|spade| spade.is_done());
            let percent = |share: Option<f64>| Cell::number(share.map(|share| 100.0 * share), 2);
            table.push([
                one.kind.name().into(),
                match is_by_alpha {
                    true => Cell::number(one.alpha, 1),
                    false => one.points.into(),
                },
                Cell::Number(ours.took.seconds, 2),
                Cell::number(ours.cpu(), 2),
                Cell::number(ours.waited(), 2),
                Cell::number(read(ours), 1),
                Cell::number(written(ours), 1),
                percent(ours.seam_share()),
                percent(ours.border_share()),
                percent(ours.held_share().filter(|_| one.alpha.is_some())),
                Cell::count(ours.blocks()),
                Cell::number(peak(ours), 0),
                Cell::number(spade.map(|spade| spade.took.seconds), 2),
                Cell::number(spade.and_then(peak), 0),
                Cell::number(spade.map(|spade| ours.took.seconds / spade.took.seconds), 2),
            ]);
        }
        table
    }

    /// The exponent with which time grows from the first to the last.
    fn growth(&self, engine: Engine, data: &[Data]) -> Option<f64> {
        let [first, last] = [data.first()?, data.last()?];
        let [a, b] = [self.median(engine, first)?, self.median(engine, last)?];
        let is_told = a.is_done() && b.is_done() && first.points < last.points;
        let times = b.took.seconds / a.took.seconds;
        is_told.then(|| times.ln() / (last.points as f64 / first.points as f64).ln())
    }

    /// A line for each distribution and engine; engines have colours, and but for the first of them dashes.
    fn lines(
        &self,
        data: &[Vec<Data>],
        engines: &[Engine],
        value: Value,
        x: impl Fn(&Data) -> f64 + Copy,
    ) -> Vec<Line> {
        let mut lines = Vec::new();
        for (place, &engine) in engines.iter().enumerate() {
            for (colour, data) in data.iter().enumerate() {
                let Some(first) = data.first() else { continue };
                let name = format!("{}, {}", engine.name(), first.kind);
                lines.push(self.line(name, engine, (colour + 3 * (place / 2), place % 2 > 0), data, value, x));
            }
        }
        lines
    }

    /// A line for each distribution, of our builds.
    fn lines_of_ours(
        &self,
        data: &[Vec<Data>],
        what: &str,
        place: usize,
        value: Value,
        x: impl Fn(&Data) -> f64 + Copy,
    ) -> Vec<Line> {
        let named = data.iter().enumerate().filter_map(|(colour, data)| {
            let name = format!("{what}, {}", data.first()?.kind);
            Some(self.line(name, Engine::Ours, (colour, place > 0), data, value, x))
        });
        named.collect()
    }

    fn line(
        &self,
        name: String,
        engine: Engine,
        (colour, is_dashed): (usize, bool),
        data: &[Data],
        value: Value,
        x: impl Fn(&Data) -> f64,
    ) -> Line {
        let records = data.iter().filter_map(|one| Some((x(one), self.median(engine, one)?)));
        let (done, ended): (Vec<_>, Vec<_>) = records.partition(|(_, record)| record.is_done());
        Line {
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

    /// Keeps a chart and shows it on the page.
    fn picture(&mut self, stem: &str, title: &str, x: Dimension, y: Dimension, lines: Vec<Line>) -> anyhow::Result<()> {
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
        let name = self.pictures.name(stem);
        self.folder.keep_picture(&name, chart.draw())?;
        self.text += &format!("\n![{title}]({name})\n");
        Ok(())
    }
}
