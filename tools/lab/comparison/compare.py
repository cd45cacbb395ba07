#!/usr/bin/env python3
"""The same work by tiletool and by other programs: steps, seconds, memory, and whether the result is correct.

    python3 -m pip install -r tools/lab/comparison/requirements.txt
    cargo build --release -p tiletool && cargo build --release -p lab --bin spade-corners
    tools/lab/comparison/compare.py target/release/tiletool -o docs/comparison.md
    tools/lab/comparison/compare.py target/release/tiletool --points 10000 --segments-of 10000 --survey 10000 --rounds 1

It prints the tables, or, with -o, replaces those between the markers of a page. g++ and Debian's libcgal-dev and gdal-bin must
be installed, and the machine must be quiet. Programs that are missing are named below the tables. README.md says what
is measured.
"""

import argparse
import os
import statistics
import sys
import tempfile
from pathlib import Path

import numpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import dem
import measured
import sets
from checker import check
from programs import Case, programs
from results import NoTriangles


class Measurement:
    """A program with its runs of one task, and why it has none."""

    def __init__(self, program, constrained=False, slow=()):
        self.program, self.runs, self.why, self.slow = program, [], None, False
        if constrained and not program.constrains:
            self.why = "has no constraints"
        elif not program.why and program in slow:
            self.why = "not tried, too slow with fewer points"

    def measure(self, case, limit):
        if self.why:
            return
        try:
            self.runs.append(self.program.triangulate(case, limit))
        except measured.Skipped as why:
            self.why, self.slow = str(why), isinstance(why, measured.TooSlow)


def table(titles, rows):
    """Returns a Markdown table whose numbers are at the right."""
    lines = ["| " + " | ".join(titles) + " |", "|" + "|".join("--:" if ">" in t else "---" for t in titles) + "|"]
    lines[0] = lines[0].replace(">", "")
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def amount(runs):
    """Returns the medians of seconds, of seconds of processors and of peak memory as text."""
    seconds = statistics.median(run.seconds for run in runs)
    processors = statistics.median(run.processors for run in runs)
    peak = statistics.median(run.peak for run in runs) / 2**20
    return [f"{seconds:.2f}", f"{processors:.2f}", f"{peak:,.0f}"]


def missing(measurements):
    """Returns a line that names programs without a result."""
    said = [f"{name}: {why}" for name, why in measurements if why]
    return "\n\nNo result: " + "; ".join(said) + "." if said else ""


def timed(case, all_programs, arguments, constrained=False, slow=()):
    """Returns the table of a case, and which programs were too slow. The programs take turns."""
    measurements = [Measurement(program, constrained, slow) for program in all_programs]
    for turn in range(arguments.rounds):
        for measurement in measurements:
            note(f"round {turn + 1}: {measurement.program.name}")
            measurement.measure(case, arguments.limit)
    rows = []
    for one in measurements:
        if one.runs and not one.why:
            rows.append([one.program.name, one.program.steps(constrained), *amount(one.runs), one.program.stores])
    head = ["program", "steps", ">seconds", ">of processors", ">peak, MiB", "stores"]
    text = table(head, rows) + missing((one.program.name, one.why) for one in measurements)
    return text, {one.program for one in measurements if one.slow or one.program in slow}


def generate(tiletool, folder, points, *options):
    """Returns uniform points, and segments or None, of the tool's generator."""
    path = Path(folder) / "generated.f64"
    measured.run([tiletool, "generate", "uniform", "-n", points, "--seed", 1, "-o", path, *options])
    segments = path.with_suffix(".u32")
    found = numpy.fromfile(segments, "<u4").reshape(-1, 2) if segments.exists() else None
    return numpy.fromfile(path, "<f8").reshape(-1, 2), found


def delaunay(arguments, all_programs):
    said, slow = [], set()
    for points in sorted(arguments.points):
        with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
            case = Case(folder, generate(arguments.tiletool, folder, points)[0])
            text, slow = timed(case, all_programs, arguments, slow=slow)
            said.append(f"{len(case.points):,} uniform points:\n\n{text}")
    return "\n\n".join(said)


def constrained(arguments, all_programs):
    with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
        case = Case(folder, *generate(arguments.tiletool, folder, arguments.segments_of, "--pslg", 0.5))
        head = f"{len(case.points):,} uniform points, {len(case.segments):,} segments:\n\n"
        return head + timed(case, all_programs, arguments, constrained=True)[0]


def survey(arguments, _):
    with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
        case = dem.Survey(folder, arguments.tiletool, arguments.survey, arguments.cells)
        makers = dem.makers()
        for turn in range(arguments.rounds):
            for maker in makers:
                note(f"round {turn + 1}: {maker.name}")
                maker.measure(case, arguments.limit)
        own = case.values(makers[0].path) if makers[0].path else None
        rows = []
        for maker in makers:
            if maker.runs and not maker.why:
                differs = ["", ""] if maker is makers[0] or own is None else list(maker.difference(case, own))
                rows.append([maker.name, maker.steps, *amount(maker.runs), *differs])
        head = ["program", "steps", ">seconds", ">of processors", ">peak, MiB", ">largest", ">median"]
        size = f"{len(case.xyz):,} points in a LAZ file, {case.columns:,} by {case.rows:,} cells:\n\n"
        return size + table(head, rows) + missing((maker.name, maker.why) for maker in makers)


def verdict(program, case, limit):
    """Returns what the exact check says of a program's triangles."""
    try:
        corners, own = program.triangles(case, limit)
    except measured.TooSlow:
        return f"not finished within {limit:g} s"
    except measured.Crashed as signal:
        return f"crashed ({signal})"
    except measured.Refused:
        return "refuses"
    except (measured.Skipped, NoTriangles) as why:
        return str(why)
    vertices = case.points if own is None else own
    # Some have further vertices, such as one at infinity.
    used, corners = numpy.unique(corners, return_inverse=True)
    if (used >= len(vertices)).any() or not numpy.isfinite(vertices[used]).all():
        return "corners that are no points"
    corners, vertices = corners.reshape(-1, 3).tolist(), vertices[used].tolist()
    segments = [] if case.segments is None else case.segments.tolist()
    return str(check(case.points.tolist(), corners, segments, vertices, program.polygons))


def checked(arguments, all_programs, cases):
    """Returns a table of what the check says, a row for each set."""
    rows = []
    for name, (points, segments) in cases.items():
        row = [name, f"{len(points):,}"]
        for program in all_programs:
            note(f"{name}: {program.name}")
            with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
                row.append(verdict(program, Case(folder, points, segments), arguments.limit))
        rows.append(row)
    return table(["set", ">points", *(program.name for program in all_programs)], rows)


def degenerate(arguments, all_programs):
    # With one thread the triangles are the same, which other tests show; PDAL's files are not read.
    shown = [p for p in all_programs if not p.why and p.name != "PDAL" and not p.name.startswith("tiletool,")]
    alone = checked(arguments, shown, {name: (points, None) for name, points in sets.sets().items()})
    shown = [program for program in shown if program.constrains]
    return alone + "\n\nWith segments:\n\n" + checked(arguments, shown, sets.constrained_sets())


def machine(arguments, all_programs):
    """Returns the processor, and versions."""
    with open("/proc/cpuinfo") as about:
        names = [line.split(":")[1].strip() for line in about if line.startswith("model name")]
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    versions = [(p.name, p.version() if not p.why else p.why) for p in all_programs if "," not in p.name]
    versions += [("laspy", dem.laspy.__version__), ("NumPy", numpy.__version__), ("Python", sys.version.split()[0])]
    head = f"{names[0] if names else 'unknown processor'}, {os.cpu_count()} cores, {memory:.0f} GiB of memory.\n\n"
    return head + table(["program", "version"], versions)


TABLES = {
    "machine": machine,
    "delaunay": delaunay,
    "constrained": constrained,
    "survey": survey,
    "degenerate": degenerate,
}


def note(text):
    print(text, file=sys.stderr, flush=True)


def put(page, name, text):
    """Replaces what is between the markers of a table."""
    first, last = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    whole = page.read_text()
    before, found, rest = whole.partition(first)
    _, ended, after = rest.partition(last)
    if not (found and ended):
        raise SystemExit(f"{page}: has no lines {first.strip()} and {last}")
    page.write_text(f"{before}{first}\n{text}\n\n{last}{after}")


def parsed():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiletool", type=Path)
    output = "put the tables between the markers of a page"
    parser.add_argument("-o", "--output", type=Path, metavar="PAGE", help=output)
    parser.add_argument("--only", choices=list(TABLES), nargs="+", default=list(TABLES), help="make these tables only")
    sizes = "numbers of uniform points; default: 100000 1000000"
    parser.add_argument("--points", type=int, nargs="+", default=[100_000, 1_000_000], help=sizes)
    parser.add_argument("--segments-of", type=int, default=1_000_000, metavar="POINTS", help="points with segments")
    parser.add_argument("--survey", type=int, default=100_000, metavar="POINTS", help="points of the LAZ file")
    parser.add_argument("--cells", type=int, default=1_000_000, help="cells of the raster, about")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--limit", type=float, default=20, help="seconds for one process; slower programs are skipped")
    spade = "the program spade-corners; default: beside tiletool"
    parser.add_argument("--spade", type=Path, help=spade)
    parser.add_argument("--folder", type=Path, help="for temporary files")
    arguments = parser.parse_args()
    arguments.tiletool = arguments.tiletool.resolve()
    arguments.spade = (arguments.spade or arguments.tiletool.parent / "spade-corners").resolve()
    return arguments


def main():
    arguments = parsed()
    with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
        all_programs = programs(arguments.tiletool, arguments.spade, folder)
        for name in arguments.only:
            text = TABLES[name](arguments, all_programs)
            if arguments.output:
                put(arguments.output, name, text)
            else:
                print(f"\n{text}")


if __name__ == "__main__":
    main()
