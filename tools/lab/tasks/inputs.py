#!/usr/bin/env python3
"""Measures a build whose inputs and blocks are tasks, two at a time, beside one process, in turns.

    tools/lab/tasks/inputs.py target/release/tiletool a.f64 b.f64 … [--memory 128MiB] [--rounds 3] [--folder FOLDER]

The inputs say how many records they have, such as LAZ or raw numbers. The digests of both files are computed anew, and
compared, in each round. The table has medians.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# Tasks at once, of one thread each; the process beside them has as many threads.
AT_ONCE = 2


def main():
    arguments = parsed()
    with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
        rounds = [measured(arguments, Path(folder)) for _ in range(arguments.rounds)]
    medians = {what: statistics.median(one[what] for one in rounds) for what in rounds[0]}
    blocks = medians.pop("number of blocks")
    print(f"{len(arguments.inputs)} inputs, {arguments.memory}, {blocks} blocks; the digests are equal\n")
    print("| " + " | ".join(medians) + " |\n|" + "--:|" * len(medians))
    print("| " + " | ".join(f"{value:.1f} s" for value in medians.values()) + " |")


def parsed():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiletool", type=Path)
    parser.add_argument("inputs", type=Path, nargs="+")
    parser.add_argument("--memory", default="128MiB", help="of a process")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--folder", type=Path, help="for the files, about 200 bytes a point")
    return parser.parse_args()


def measured(arguments, folder):
    """Builds both files. Returns the seconds of each step, and the number of blocks."""
    tool, whole, shared = arguments.tiletool.resolve(), folder / "whole.tiles", folder / "shared.tiles"

    def build(output, *options):
        inputs = [path.resolve() for path in arguments.inputs]
        limits = ["--memory", arguments.memory, "--threads", AT_ONCE, "--quiet", "--force"]
        return seconds([tool, "build", *inputs, "-o", output, *limits, *options])

    def tasks(kind):
        listed = json.loads(subprocess.check_output([tool, "task", shared, "--json"]))[kind + "s"]
        one = [tool, "task", shared, "--threads", 1, "--quiet", "--" + kind]
        began = time.perf_counter()
        with ThreadPoolExecutor(AT_ONCE) as workers:
            list(workers.map(lambda number: seconds([*one, number]), range(len(listed))))
        return time.perf_counter() - began, len(listed)

    one_process = build(whole)
    plan_of_inputs = build(shared, "--tasks=inputs")
    of_inputs, _ = tasks("input")
    plan_of_blocks = build(shared, "--resume", "--tasks")
    of_blocks, blocks = tasks("block")
    finish = build(shared, "--resume")
    digests = {subprocess.check_output([tool, "digest", "--recompute", file]) for file in (whole, shared)}
    if len(digests) > 1:
        sys.exit("the digests differ")
    steps = (plan_of_inputs, of_inputs, plan_of_blocks, of_blocks, finish)
    names = ("plan of inputs", "inputs", "plan of blocks", "blocks", "finish")
    return {"one process": one_process, **dict(zip(names, steps)), "sum": sum(steps), "number of blocks": blocks}


def seconds(command):
    began = time.perf_counter()
    subprocess.run([str(part) for part in command], check=True)
    return time.perf_counter() - began


if __name__ == "__main__":
    main()
