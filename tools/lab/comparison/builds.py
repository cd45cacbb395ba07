#!/usr/bin/env python3
"""Measures builds of ten million points beside programs in memory, and two threads beside one, in turns.

    tools/lab/comparison/builds.py target/release/tiletool [--before TILETOOL] [--points 10000000] [--rounds 5]

It needs what compare.py needs. Seconds are those of whole processes, medians of the rounds. The other programs take one
processor. With --before, an older tiletool takes its turn too.
"""

import argparse
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import dem
import measured
from programs import Cgal, Spade

MEMORY = "256MiB"


class Input:
    """Files of uniform points, and perhaps of segments, in a folder."""

    def __init__(self, folder, tiletool, points, *options):
        self.folder, self.segments = Path(folder), None
        self.folder.mkdir()
        output = ["-o", self.path("points.f64"), "--quiet"]
        subprocess.run([tiletool, "generate", "uniform", "-n", str(points), *output, *options], check=True)
        segments = self.path("points.u32")
        if segments.exists():
            self.segments = segments.rename(self.path("segments.u32"))

    def path(self, name):
        return self.folder / name

    def points(self):
        return numpy.fromfile(self.path("points.f64")).reshape(-1, 2)


def build(tiletool, case, name, threads):
    """Returns the command that builds tiles from a file of points."""
    lines = [] if case.segments is None else ["--segments", case.segments]
    limits = ["--memory", MEMORY, "--threads", threads]
    return [tiletool, "build", case.path(name), *lines, "-o", case.path("out.tiles"), "--force", "--quiet", *limits]


def in_turns(rounds, commands):
    """Returns the median of the seconds of each command."""
    runs = {what: [] for what in commands}
    for _ in range(rounds):
        for what, command in commands.items():
            runs[what].append(measured.run(command).seconds)
    return {what: statistics.median(seconds) for what, seconds in runs.items()}


def beside(tools, case, rounds, name, program, threads):
    """Prints a row for each tool and number of threads, beside a program."""
    commands = {(label, n): build(tool, case, "points.f64", n) for label, tool in tools.items() for n in threads}
    commands[program.name] = program.command(case)
    seconds = in_turns(rounds, commands)
    other = seconds.pop(program.name)
    for (label, n), own in seconds.items():
        print(f"| {name}, threads: {n}; {label} | {own:.2f} | {program.name} {other:.2f} | {own / other:.2f} |", flush=True)


def threads(tool, case, rounds, name):
    """Prints a row for two threads beside one."""
    seconds = in_turns(rounds, {n: build(tool, case, name, n) for n in (2, 1)})
    ratio = f"{seconds[1] / seconds[2]:.2f} times as fast"
    print(f"| {name}, threads: 2 | {seconds[2]:.2f} | one thread {seconds[1]:.2f} | {ratio} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiletool", type=Path)
    parser.add_argument("--before", type=Path, help="an older tiletool")
    parser.add_argument("--points", type=int, default=10_000_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--folder", type=Path, help="for the files, about 200 bytes a point")
    arguments = parser.parse_args()
    tool, rounds = arguments.tiletool.resolve(), arguments.rounds
    tools = {"before": arguments.before.resolve()} if arguments.before else {}
    tools["this"] = tool
    with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
        plain = Input(Path(folder) / "plain", tool, arguments.points)
        print("| work | s | beside, s | ratio |\n|---|--:|--:|--:|")
        beside(tools, plain, rounds, "raw numbers to tiles", Cgal(folder), (2, 1))
        dem.write_laz(plain.path("points.laz"), numpy.pad(plain.points() * 1e5, ((0, 0), (0, 1))))
        numpy.savetxt(plain.path("points.csv"), plain.points(), fmt="%.17g", delimiter=",")
        for name in ("points.laz", "points.csv"):
            threads(tool, plain, rounds, name)
        segments = Input(Path(folder) / "segments", tool, arguments.points, "--pslg", "0.5")
        spade = Spade(tool.parent / "spade-corners")
        beside(tools, segments, rounds, "α = 0.5", spade, (2,))


if __name__ == "__main__":
    main()
