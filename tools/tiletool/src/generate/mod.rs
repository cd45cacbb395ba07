//! `tiletool generate`: seeded test data, as raw coordinates and segments.
//!
//! The input is a kind, a number of points and a seed. The output is `FILE.f64`, little-endian f64
//! pairs or triples, and `FILE.u32`, little-endian u32 pairs of record numbers, if there are
//! segments. Maps are obstacles in GeoJSON and sites in text. Records are written as they are
//! computed, so memory does not grow with their number. A file appears under its name only when it
//! is complete and on the disk.

mod args;
mod count;
mod map;
mod what;

use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use clap::{Args as _, Command};
use distributions::{Kind, LongSegments, MapKind, Pslg, points, points3};

use crate::common;
use crate::output::{StandardOutput, StreamOutput};
use crate::progress::OwnBar;
pub use args::GenerateArgs;
pub use count::parse_count;
use what::What;

/// Writes the data that the arguments ask for. Ends the process with exit code 2 if the arguments
/// contradict each other.
pub fn run(args: GenerateArgs) -> anyhow::Result<()> {
    let kind = match args.kind {
        What::Points(kind) => kind,
        What::Map(kind) => return write_map(&args, kind),
    };
    let data = TestData::new(&args, kind).unwrap_or_else(|error| error.exit());
    if args.output == Path::new("-") {
        return data
            .write_stream(&mut StandardOutput::of("the points"))
            .map_err(Into::into);
    }
    let segment_path = args.output.with_extension("u32");
    let segments = data.write_files(&args.output, &segment_path, &common::interruption())?;
    let segments = segments.map(|count| (count, segment_path.as_path()));
    report(&args, data.records(), segments)
}

/// Writes the files of a map. Ends the process with exit code 2 if the arguments contradict each
/// other.
fn write_map(args: &GenerateArgs, kind: MapKind) -> anyhow::Result<()> {
    let unfit = [
        (args.pslg.is_some(), "--pslg"),
        (args.long_segments.is_some(), "--long-segments"),
        (args.dims != 2, "--dims 3"),
        (args.output == Path::new("-"), "-o -"),
        (args.output.file_name().is_none(), "an output without a name"),
    ];
    if let Some((_, option)) = unfit.into_iter().find(|unfit| unfit.0) {
        usage(format!(
            "{option} does not work with {kind:?}",
            kind = args.kind.to_string()
        ))
        .exit();
    }
    let order = map::Order {
        kind,
        obstacles: args.n,
        sites: args.sites.unwrap_or(args.n),
        seed: args.seed,
    };
    order.run(&args.output, args.json)
}

/// The points and segments to write.
struct TestData {
    source: Generator,
    dims: u8,
}

enum Generator {
    Points { kind: Kind, n: u64, seed: u64 },
    Pslg(Pslg),
    Long(LongSegments),
}

impl TestData {
    fn new(args: &GenerateArgs, kind: Kind) -> Result<Self, clap::Error> {
        let &GenerateArgs { n, seed, dims, .. } = args;
        if args.sites.is_some() {
            return Err(usage(format!(
                "--sites works only with city and parks, not with {kind}"
            )));
        }
        let source = match (args.pslg, args.long_segments) {
            (Some(alpha), _) => Generator::Pslg(Pslg::new(kind, n, alpha, seed).map_err(usage)?),
            (_, Some(_)) if kind != Kind::Uniform => {
                let why = format!("--long-segments works only with kind uniform, not with {kind}");
                return Err(usage(why));
            }
            (_, Some(m)) => Generator::Long(LongSegments::new(n, m, seed).map_err(usage)?),
            (None, None) => Generator::Points { kind, n, seed },
        };
        let segments = !matches!(source, Generator::Points { .. });
        if args.output == Path::new("-") {
            if segments || args.json {
                let option = if segments { "the segments" } else { "--json" };
                let why = format!("-o - cannot be combined with {option}: name a file");
                return Err(usage(why));
            }
            if io::stdout().is_terminal() {
                return Err(usage(
                    "binary data is not written to a terminal: name a file or use a pipe",
                ));
            }
        } else if args.output.file_name().is_none() {
            let why = format!("'{}' is not the name of a file", common::shown(&args.output));
            return Err(usage(why));
        } else if segments && args.output.extension().is_some_and(|e| e == "u32") {
            return Err(usage(
                "the segments are written to FILE.u32: the name of the points' file must not end in .u32",
            ));
        }
        Ok(TestData { source, dims })
    }

    /// Returns the number of points.
    fn records(&self) -> u64 {
        match &self.source {
            &Generator::Points { n, .. } => n,
            Generator::Pslg(pslg) => pslg.records(),
            Generator::Long(long) => long.records(),
        }
    }

    /// Writes the points. Returns how many.
    fn write_points(&self, out: &mut dyn Write, progress: Progress<'_>) -> io::Result<u64> {
        match (&self.source, self.dims) {
            (&Generator::Points { kind, n, seed }, 2) => write_records(out, points(kind, n, seed).map(bytes), progress),
            (&Generator::Points { kind, n, seed }, _) => {
                write_records(out, points3(kind, n, seed).map(bytes), progress)
            }
            (Generator::Pslg(pslg), 2) => write_records(out, pslg.points().map(bytes), progress),
            (Generator::Pslg(pslg), _) => write_records(out, pslg.points().map(flat_bytes), progress),
            (Generator::Long(long), 2) => write_records(out, long.points().map(bytes), progress),
            (Generator::Long(long), _) => write_records(out, long.points().map(flat_bytes), progress),
        }
    }

    /// Writes the segments, if this kind of data has any. Returns how many.
    fn write_segments(&self, out: &mut dyn Write, progress: Progress<'_>) -> io::Result<u64> {
        match &self.source {
            Generator::Points { .. } => Ok(0),
            Generator::Pslg(pslg) => write_records(out, pslg.segments().map(end_bytes), progress),
            Generator::Long(long) => write_records(out, long.segments().map(end_bytes), progress),
        }
    }

    fn write_stream(&self, out: &mut dyn Write) -> io::Result<()> {
        ignore_broken_pipe(self.write_points(out, &mut |_| Ok(())).and_then(|_| out.flush()))
    }

    /// Writes both files, and then renames them to their final names. Returns the number of
    /// segments if there is a file of them.
    fn write_files(&self, path: &Path, segment_path: &Path, stop: &AtomicBool) -> anyhow::Result<Option<u64>> {
        let bar = OwnBar::new(self.records(), "{wide_bar} {human_pos}/{human_len} points {msg} {eta}");
        let mut progress = |done| {
            bar.set_position(done);
            if stop.load(Ordering::Relaxed) {
                Err(io::Error::other("interrupted; no file was written"))
            } else {
                Ok(())
            }
        };
        let failed = |path: &Path| format!("cannot write {}", common::shown(path));

        let mut point_file = StreamOutput::create(path).with_context(|| failed(path))?;
        let mut segment_file = None;
        if !matches!(self.source, Generator::Points { .. }) {
            segment_file = Some(StreamOutput::create(segment_path).with_context(|| failed(segment_path))?);
        }
        self.write_points(point_file.file(), &mut progress)
            .with_context(|| failed(path))?;
        point_file.sync().with_context(|| failed(path))?;
        let mut segments = None;
        if let Some(mut file) = segment_file {
            bar.set_message("segments");
            let count = self.write_segments(file.file(), &mut |_| progress(self.records()));
            segments = Some(count.with_context(|| failed(segment_path))?);
            file.sync().with_context(|| failed(segment_path))?;
            file.publish().with_context(|| failed(segment_path))?;
        }
        // The points get their name last, so a process that sees new points also sees new segments.
        point_file.publish().with_context(|| failed(path))?;
        Ok(segments)
    }
}

/// A function that is called with the number of records written so far, after each block. An error
/// stops the writing.
type Progress<'a> = &'a mut dyn FnMut(u64) -> io::Result<()>;

/// Number of bytes that are collected for one write.
const BLOCK: usize = 1 << 20;

/// Writes records of `D` numbers of `W` bytes each, in blocks. Returns how many.
fn write_records<const W: usize, const D: usize>(
    out: &mut dyn Write,
    records: impl Iterator<Item = [[u8; W]; D]>,
    progress: Progress<'_>,
) -> io::Result<u64> {
    let mut block = Vec::with_capacity(BLOCK);
    let mut done = 0;
    for record in records {
        block.extend_from_slice(record.as_flattened());
        done += 1;
        if block.len() > BLOCK - W * D {
            out.write_all(&block)?;
            block.clear();
            progress(done)?;
        }
    }
    out.write_all(&block)?;
    progress(done)?;
    Ok(done)
}

/// Returns the bytes of a point.
fn bytes<const D: usize>(point: [f64; D]) -> [[u8; 8]; D] {
    point.map(f64::to_le_bytes)
}

/// Returns the bytes of a point with height 0.
fn flat_bytes([x, y]: [f64; 2]) -> [[u8; 8]; 3] {
    bytes([x, y, 0.0])
}

/// Returns the bytes of a segment.
fn end_bytes(ends: [u32; 2]) -> [[u8; 4]; 2] {
    ends.map(u32::to_le_bytes)
}

/// Ignores a broken pipe: the reader has read enough.
fn ignore_broken_pipe(written: io::Result<()>) -> io::Result<()> {
    written.or_else(|error| {
        if error.kind() == ErrorKind::BrokenPipe {
            Ok(())
        } else {
            Err(error)
        }
    })
}

/// Prints a summary: text for people on standard error, or JSON for programs on standard output.
fn report(args: &GenerateArgs, records: u64, segments: Option<(u64, &Path)>) -> anyhow::Result<()> {
    if args.json {
        let json = serde_json::json!({
            "kind": args.kind.to_string(),
            "seed": args.seed,
            "dims": args.dims,
            "points": records,
            "output": args.output.to_string_lossy(),
            "segments": segments.map_or(0, |(count, _)| count),
            "segments_output": segments.map(|(_, path)| path.to_string_lossy()),
        });
        return common::print_json("the summary", &json);
    }
    let points = common::counted(records, "point", "points");
    common::tell(format_args!("{points} in {}", common::shown(&args.output)));
    if let Some((count, path)) = segments {
        let segments = common::counted(count, "segment", "segments");
        common::tell(format_args!("{segments} in {}", common::shown(path)));
    }
    Ok(())
}

fn usage(why: impl ToString) -> clap::Error {
    let mut command = GenerateArgs::augment_args(Command::new("generate").bin_name("tiletool generate"));
    command.error(clap::error::ErrorKind::ValueValidation, why.to_string())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use clap::{CommandFactory, Parser};

    use super::*;

    /// Returns the sorted names of the entries of a folder.
    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort_unstable();
        names
    }

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        args: GenerateArgs,
    }

    /// Parses arguments of `tiletool generate`, separated by spaces.
    fn parse(line: &str) -> Result<GenerateArgs, clap::Error> {
        let words = std::iter::once("generate").chain(line.split_whitespace());
        Cli::try_parse_from(words).map(|cli| cli.args)
    }

    fn test_data(args: &GenerateArgs) -> Result<TestData, clap::Error> {
        let What::Points(kind) = args.kind else {
            panic!("{}", args.kind)
        };
        TestData::new(args, kind)
    }

    fn data(line: &str) -> TestData {
        let args = parse(line).unwrap_or_else(|error| panic!("{line}: {error}"));
        test_data(&args).unwrap_or_else(|error| panic!("{line}: {error}"))
    }

    fn floats(bytes: &[u8]) -> Vec<f64> {
        assert_eq!(bytes.len() % 8, 0);
        bytes
            .chunks(8)
            .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
            .collect()
    }

    /// A writer that accepts this many bytes and then fails with this kind of error.
    struct Failing(usize, ErrorKind);

    impl Write for Failing {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 = self.0.checked_sub(bytes.len()).ok_or(self.1)?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    static GO: AtomicBool = AtomicBool::new(false);

    #[test]
    fn arguments_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn contradictory_arguments_are_usage_errors() {
        for line in [
            "uniform -n 10 --pslg 0.5 -o -",
            "uniform -n 10 --long-segments 5 -o -",
            "uniform -n 10 --json -o -",
            "uniform -n 10 --pslg 0.5 -o pts.u32",
            "uniform -n 5G --pslg 0.5 -o pts.f64",
            "uniform -n 4G --long-segments 1G -o pts.f64",
            "grid -n 10 --pslg 0.5 -o pts.f64",
            "lidar -n 10 --pslg 0.5 -o pts.f64",
            "kuzmin -n 10 --long-segments 5 -o pts.f64",
            "uniform -n 10 --pslg 1.5 -o pts.f64",
            "uniform -n 10 --pslg nan -o pts.f64",
            "uniform -n 10 -o ..",
            "uniform -n 10 --sites 3 -o pts.f64",
        ] {
            let error = test_data(&parse(line).unwrap()).err();
            assert_eq!(error.map(|error| error.exit_code()), Some(2), "{line}");
        }
        for line in [
            "gird -n 10 -o pts.f64",
            "grid -o pts.f64",
            "grid -n 10",
            "lidar -n 10 --dims 4 -o pts.f64",
            "uniform -n 10 --pslg 0.5 --long-segments 5 -o pts.f64",
        ] {
            assert_eq!(parse(line).unwrap_err().exit_code(), 2, "{line}");
        }
    }

    #[test]
    fn a_stream_has_the_coordinates_of_every_kind() {
        for kind in Kind::ALL {
            for dims in [2, 3] {
                let mut bytes = Vec::new();
                let data = data(&format!("{kind} -n 100 --seed 3 --dims {dims} -o pts.f64"));
                data.write_stream(&mut bytes).unwrap();
                let expected = points3(kind, 100, 3).flat_map(|p| p.into_iter().take(dims));
                assert_eq!(floats(&bytes), expected.collect::<Vec<f64>>(), "{kind}");
            }
        }
    }

    #[test]
    fn points_of_several_blocks_are_written_in_order() {
        let mut bytes = Vec::new();
        data("uniform -n 300k -o pts.f64").write_stream(&mut bytes).unwrap();
        assert!(
            floats(&bytes)
                .into_iter()
                .eq(points(Kind::Uniform, 300_000, 0).flatten())
        );
    }

    #[test]
    fn points_and_segments_are_written_to_two_files() {
        let folder = tempfile::tempdir().unwrap();
        let [path, segment_path] = ["pts.f64", "pts.u32"].map(|name| folder.path().join(name));
        for (line, records, segments) in [
            ("kuzmin -n 1k --pslg 1 -o pts.f64", 1000, 999),
            ("uniform -n 1k --long-segments 7 -o pts.f64", 1014, 7),
        ] {
            let count = data(line).write_files(&path, &segment_path, &GO).unwrap();
            assert_eq!(count, Some(segments));
            assert_eq!(fs::read(&path).unwrap().len() as u64, records * 16);
            let ends = fs::read(&segment_path).unwrap();
            assert_eq!(ends.len() as u64, segments * 8);
            assert!(
                ends.chunks(4)
                    .all(|b| u64::from(u32::from_le_bytes(b.try_into().unwrap())) < records)
            );
            assert_eq!(names(folder.path()), ["pts.f64", "pts.u32"]);
        }
    }

    #[test]
    fn a_file_is_replaced_only_by_a_complete_one() {
        let folder = tempfile::tempdir().unwrap();
        let [path, segment_path] = ["pts.f64", "pts.u32"].map(|name| folder.path().join(name));
        fs::write(&path, "old").unwrap();
        let stop = AtomicBool::new(true);
        let pslg = data("uniform -n 300k --pslg 0.5 -o pts.f64");
        let error = pslg.write_files(&path, &segment_path, &stop).unwrap_err();
        assert!(format!("{error:#}").contains("pts.f64: interrupted"), "{error:#}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["pts.f64"]);

        // If the file of segments cannot be created, the file of points is not written either.
        fs::create_dir(&segment_path).unwrap();
        assert!(pslg.write_files(&path, &segment_path, &GO).is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["pts.f64", "pts.u32"]);

        let points = data("uniform -n 10 -o pts.f64");
        points.write_files(&path, &segment_path, &GO).unwrap();
        assert_eq!(fs::read(&path).unwrap().len(), 160);
        assert_eq!(names(folder.path()), ["pts.f64", "pts.u32"]);
    }

    #[test]
    fn a_full_disk_is_an_error_and_a_broken_pipe_is_not() {
        let data = data("uniform -n 300k -o pts.f64");
        data.write_stream(&mut Failing(2_000_000, ErrorKind::BrokenPipe))
            .unwrap();
        let error = data
            .write_stream(&mut Failing(2_000_000, ErrorKind::StorageFull))
            .unwrap_err();
        assert_eq!(error.kind(), ErrorKind::StorageFull);
    }
}
