"""Measures builds on the workers of Dask beside the same builds in one process, in turns.

Needs requirements-test.txt, and the command tiletool; for a picture of Dask's dashboard, also bokeh,
playwright and chromium:

    python bench/cluster.py --points 20000000 --memory 128MiB
    python bench/cluster.py --points 10000000 --alpha 0.5 --memory 128MiB --parts
    python bench/cluster.py --kill 3 --rounds 1 --dashboard dashboard.png

The table has medians. The digests of both files are computed anew and compared in each round. With --kill, workers are
killed at random moments while tasks run, and Dask starts others in their place: the lines on standard error say when.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import delaunay_tiles as dt


def main() -> None:
    import dask.distributed

    options = arguments()
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        folder = Path(name)
        inputs = generate(options, folder)
        settings = {"memory": options.memory, "overwrite": True, **inputs}
        workers = {"n_workers": options.workers, "threads_per_worker": 1}
        with dask.distributed.LocalCluster(**workers) as cluster, cluster.get_client() as client:
            rounds = [measure(options, folder, settings, client) for _ in range(options.rounds)]
    report(options, {what: statistics.median(one[what] for one in rounds) for what in rounds[0]})


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=20_000_000)
    parser.add_argument("--alpha", type=float, default=0.0, help="about as many segments per point")
    parser.add_argument("--memory", default="128MiB", help="of a process, for both kinds of build")
    parser.add_argument("--workers", type=int, default=2, help="of Dask, of one thread each")
    parser.add_argument("--parts", action="store_true", help="the workers' file is in parts")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--kill", type=int, default=0, help="workers to kill in each round")
    parser.add_argument("--dashboard", type=Path, help="where to put a picture of the dashboard while tasks run")
    parser.add_argument("--tool", default=os.environ.get("TILETOOL") or shutil.which("tiletool"), help="tiletool")
    parser.add_argument("--folder", type=Path, help="for files, a disk that is large and fast enough")
    options = parser.parse_args()
    if not options.tool:
        parser.error("the command tiletool is missing: give its path with --tool")
    return options


def generate(options: argparse.Namespace, folder: Path) -> dict[str, Path]:
    points = folder / "points.f64"
    command = [options.tool, "generate", "uniform", "-n", str(options.points), "--seed", "5", "-o", points]
    if options.alpha:
        command += ["--pslg", str(options.alpha)]
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
    return {"points": points, "lines": points.with_suffix(".u32")} if options.alpha else {"points": points}


def measure(options: argparse.Namespace, folder: Path, settings: dict, client: Any) -> dict[str, float]:
    """Builds both files. Returns the seconds, and the bytes per point, of each kind of work."""
    whole, shared = folder / "whole.tiles", folder / ("shared.tiles.parts" if options.parts else "shared.tiles")
    begun = time.perf_counter()
    dt.build(out=whole, threads=options.workers, **settings)
    found = {"one process": time.perf_counter() - begun}

    recording = Recording(client)
    with killing(client, recording, options.kill), photographed(client, recording, options.dashboard):
        begun = time.perf_counter()
        dt.distributed.build(out=shared, client=recording, threads=options.workers, **settings)
        ended = time.perf_counter()
    digests = [subprocess.check_output([options.tool, "digest", "--recompute", file]) for file in (whole, shared)]
    if digests[0] != digests[1]:
        sys.exit("the digests differ")
    tasks = [future.result() for future in recording.futures]
    read, written = (sum(task[column] for task in tasks) / options.points for column in (1, 2))
    return found | {
        "plan": recording.begun - begun,
        "tasks": recording.ended - recording.begun,
        "finish": ended - recording.ended,
        "sum": ended - begun,
        "blocks": len(tasks),
        "read by tasks": read,
        "written by tasks": written,
        "the file": os.path.getsize(whole) / options.points,
    }


class Recording:
    """A client that keeps what it was asked for, and notes when the first task was sent and the last one was done."""

    def __init__(self, client: Any) -> None:
        self._client, self.futures = client, []
        self.begun = self.ended = 0.0

    def submit(self, function: Callable[..., Any], /, *values: Any) -> Any:
        self.begun = self.begun or time.perf_counter()
        future = self._client.submit(function, *values)
        future.add_done_callback(self._note)
        self.futures.append(future)
        return future

    def _note(self, _future: Any) -> None:
        self.ended = time.perf_counter()

    def done(self) -> int:
        return sum(future.done() for future in self.futures)


@contextmanager
def beside(work: Callable[[threading.Event], None]) -> Iterator[None]:
    """Runs other work meanwhile, on a thread."""
    is_over = threading.Event()
    thread = threading.Thread(target=work, args=(is_over,))
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


def killing(client: Any, recording: Recording, count: int) -> Any:
    """Kills workers, each once some more tasks are done."""
    rng = random.Random(7)

    def kill(is_over: threading.Event) -> None:
        for number in range(count):
            wanted = recording.done() + rng.randint(1, 5)
            while not recording.futures or recording.done() < wanted:
                if is_over.wait(0.005):
                    return
            process = rng.choice(list(client.run(os.getpid).values()))
            os.kill(process, signal.SIGKILL)
            after = time.perf_counter() - recording.begun
            of = f"{recording.done()} of {len(recording.futures)} tasks were done"
            print(f"{after:.2f} s after the first task: killed worker {number + 1}, when {of}", file=sys.stderr)

    return beside(kill)


def photographed(client: Any, recording: Recording, picture: Path | None) -> Any:
    """Takes a picture of the dashboard in a browser, once a third of the tasks is done."""

    def photograph(is_over: threading.Event) -> None:
        while picture and (not recording.futures or recording.done() * 3 < len(recording.futures)):
            if is_over.wait(0.05):
                return
        if picture:
            from playwright.sync_api import sync_playwright

            with sync_playwright() as browsers:
                browser = browsers.chromium.launch(executable_path=shutil.which("chromium"))
                page = browser.new_page(viewport={"width": 1280, "height": 720})
                page.goto(client.dashboard_link)
                # It is drawn by what the server sends.
                page.wait_for_timeout(2000)
                page.screenshot(path=picture)

    return beside(photograph)


def report(options: argparse.Namespace, found: dict[str, float]) -> None:
    seconds = ["one process", "plan", "tasks", "finish", "sum"]
    lines = f" with segments, α = {options.alpha}" if options.alpha else ""
    kind = "in parts" if options.parts else "one file"
    print(f"{options.points:,} points{lines}, {options.memory}, {found['blocks']:.0f} blocks, {kind}\n")
    print("| " + " | ".join([*seconds, "speed"]) + " |\n|" + "--:|" * 6)
    cells = [f"{found[what]:.1f} s" for what in seconds]
    print("| " + " | ".join([*cells, f"{found['one process'] / found['sum']:.2f}"]) + " |\n")
    print("| bytes per point | |\n|---|--:|")
    for what in ("read by tasks", "written by tasks", "the file"):
        print(f"| {what} | {found[what]:.1f} |")
    print("\nThe digests are equal.")


if __name__ == "__main__":
    main()
