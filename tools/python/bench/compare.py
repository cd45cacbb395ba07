"""Measures the package beside the tool, scipy, matplotlib and numpy.

Needs requirements-test.txt, and the command tiletool of the same version, built with optimisation. What is compared
runs in turns, in processes of its own, and the medians of the rounds are printed:

    python bench/compare.py --tool ../../target/release/tiletool --wheel target/wheels/*.whl

- build: the call ``build(array)``, and its whole process, which reads the array first, beside the whole process
  ``tiletool build`` on the same file.
- memory: the highest resident size during ``build(array)``, less the array. It includes the interpreter and numpy,
  whose size is printed, too.
- locate: random points in the same triangulation. Cold is the first call, with the opening of the file or the making
  of the trifinder; warm is the second call, with other points.
- import: within new processes; the import of numpy is a part of that of delaunay_tiles.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

# Name, the largest or smallest ratio that is good, and whether more is better.
BARS = {
    "build(array) / tiletool": (1.05, False),
    "resident, less the array / budget": (1.0, False),
    "locate, warm: fastest other / ours": (5.0, True),
    "locate, cold: fastest other / ours": (5.0, True),
    "wheel, MB": (15.0, False),
    "import / numpy's": (1.5, False),
}

CHUNK = 1 << 20


def main() -> None:
    options = arguments()
    seconds: dict[str, list[float]] = defaultdict(list)
    ratios: dict[str, float] = {}
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        if options.points:
            measure_builds(options, Path(folder), seconds, ratios)
        if options.vertices:
            measure_locate(options, seconds, ratios)
    measure_imports(options.imports, seconds, ratios)
    if options.wheel:
        ratios["wheel, MB"] = options.wheel.stat().st_size / 1e6
    report(options, seconds, ratios)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=10_000_000, help="of the build; 0 to leave it out")
    parser.add_argument("--memory", type=int, default=1024, help="the budget of the build in MiB")
    parser.add_argument("--vertices", type=int, default=1_000_000, help="of the triangulation; 0 to leave it out")
    parser.add_argument("--queries", type=int, default=1_000_000, help="points to locate")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--imports", type=int, default=15, help="rounds of the imports")
    parser.add_argument("--tool", default=os.environ.get("TILETOOL") or shutil.which("tiletool"), help="tiletool")
    parser.add_argument("--wheel", type=Path, help="whose size is measured")
    parser.add_argument("--folder", type=Path, help="for files, a disk that is large and fast enough")
    options = parser.parse_args()
    if options.points and not options.tool:
        parser.error("the command tiletool is missing: give its path with --tool")
    return options


def child(function: Callable[..., object], *values: object) -> tuple[dict[str, float], float]:
    """Calls a function of this file in a new process. Returns its answer, and the time of the process."""
    begun = time.perf_counter()
    command = [sys.executable, __file__, "--child", function.__name__, *map(str, values)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return json.loads(done.stdout), time.perf_counter() - begun


# Builds.


def measure_builds(options: argparse.Namespace, folder: Path, seconds: dict, ratios: dict) -> None:
    import numpy as np

    rng = np.random.default_rng(1)
    file, out = folder / "points.f64", folder / "out.tiles"
    with file.open("wb") as written:
        for first in range(0, options.points, CHUNK):
            written.write(rng.random((min(CHUNK, options.points - first), 2)).tobytes())
    memory = options.memory << 20
    residents, before = [], []
    for _ in range(options.rounds):
        found, whole = child(build_array, file, out, memory)
        seconds["build(array): the call"].append(found["seconds"])
        seconds["build(array): the process"].append(whole)
        residents.append(found["resident"] - found["array"])
        before.append(found["before"] - found["array"])
        out.unlink()
        begun = time.perf_counter()
        command = [options.tool, "build", file, "-o", out, "--memory", f"{options.memory}MiB", "--quiet"]
        subprocess.run(command, check=True)
        seconds["tiletool build: the process"].append(time.perf_counter() - begun)
        out.unlink()
    resident = statistics.median(residents)
    print(f"resident at most, less the array: {resident / 2**20:.0f} MiB; the budget is {options.memory} MiB")
    print(f"resident before the build, less the array: {statistics.median(before) / 2**20:.0f} MiB")
    call, tool = median(seconds, "build(array): the call"), median(seconds, "tiletool build: the process")
    ratios["build(array) / tiletool"] = call / tool
    ratios["resident, less the array / budget"] = resident / memory


def build_array(file: str, out: str, memory: str) -> dict[str, float]:
    import numpy as np

    import delaunay_tiles as dt

    points = np.fromfile(file).reshape(-1, 2)
    # The highest resident size begins anew, if the system permits that.
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        pass
    before = status("VmRSS")
    begun = time.perf_counter()
    dt.build(points, out, memory=int(memory))
    taken = time.perf_counter() - begun
    return {"seconds": taken, "before": before, "resident": status("VmHWM"), "array": points.nbytes}


def status(name: str) -> int:
    """Returns a size of this process in bytes."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith(f"{name}:"))


# Locating points.


def measure_locate(options: argparse.Namespace, seconds: dict, ratios: dict) -> None:
    functions = {"delaunay_tiles": locate_tiles, "scipy": locate_scipy, "matplotlib": locate_matplotlib}
    for _ in range(options.rounds):
        inside = set()
        for name, function in functions.items():
            found, _ = child(function, options.vertices, options.queries)
            for how in ("cold", "warm"):
                seconds[f"locate, {how}: {name}"].append(found[how])
            inside.add(found["inside"])
        if max(inside) - min(inside) > 1e-5 * options.queries:
            raise SystemExit(f"the numbers of points inside differ: {sorted(inside)}")
    for how in ("cold", "warm"):
        ours, *others = (median(seconds, f"locate, {how}: {name}") for name in functions)
        ratios[f"locate, {how}: fastest other / ours"] = min(others) / ours


def located(vertices: str, queries: str, prepare: Callable, make: Callable, locate: Callable) -> dict[str, float]:
    """Measures one package: `prepare` is not measured, `make` is a part of the first call."""
    import numpy as np

    rng = np.random.default_rng(2)
    prepared = prepare(rng.random((int(vertices), 2)))
    first, second = rng.random((2, int(queries), 2))
    begun = time.perf_counter()
    made = make(prepared)
    locate(made, first)
    cold = time.perf_counter() - begun
    begun = time.perf_counter()
    is_inside = locate(made, second)
    return {"cold": cold, "warm": time.perf_counter() - begun, "inside": int(is_inside.sum())}


def locate_tiles(vertices: str, queries: str) -> dict[str, float]:
    import delaunay_tiles as dt

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "random.tiles"
        return located(
            vertices,
            queries,
            lambda points: dt.build(points, file),
            lambda _: dt.open(file),
            lambda tiles, xy: tiles.locate(xy).triangle >= 0,
        )


def locate_scipy(vertices: str, queries: str) -> dict[str, float]:
    from scipy.spatial import Delaunay

    return located(vertices, queries, Delaunay, lambda mesh: mesh, lambda mesh, xy: mesh.find_simplex(xy) >= 0)


def locate_matplotlib(vertices: str, queries: str) -> dict[str, float]:
    from matplotlib.tri import Triangulation

    import delaunay_tiles as dt

    return located(
        vertices,
        queries,
        lambda points: Triangulation(*points.T, dt.triangulate(points).triangles),
        lambda mesh: mesh.get_trifinder(),
        lambda find, xy: find(*xy.T) >= 0,
    )


# Imports.


def measure_imports(rounds: int, seconds: dict, ratios: dict) -> None:
    for _ in range(rounds):
        for name in ("numpy", "delaunay_tiles"):
            found, _ = child(import_once, name)
            seconds[f"import {name}"].append(found["seconds"])
    ratios["import / numpy's"] = median(seconds, "import delaunay_tiles") / median(seconds, "import numpy")


def import_once(name: str) -> dict[str, float]:
    begun = time.perf_counter()
    __import__(name)
    return {"seconds": time.perf_counter() - begun}


# The report.


def median(seconds: dict[str, list[float]], name: str) -> float:
    return statistics.median(seconds[name])


def report(options: argparse.Namespace, seconds: dict[str, list[float]], ratios: dict[str, float]) -> None:
    print("\n| what | median, s | from | to |\n|---|--:|--:|--:|")
    for name, found in seconds.items():
        print(f"| {name} | {statistics.median(found):.3f} | {min(found):.3f} | {max(found):.3f} |")
    print("\n| bar | found | wanted | |\n|---|--:|--:|---|")
    for name, found in ratios.items():
        limit, is_more_better = BARS[name]
        is_good = found >= limit if is_more_better else found <= limit
        wanted = f"{'≥' if is_more_better else '≤'} {limit:g}"
        print(f"| {name} | {found:.2f} | {wanted} | {'yes' if is_good else 'NO'} |")
    packages = ", ".join(f"{name} {installed(name)}" for name in ("numpy", "scipy", "matplotlib"))
    command = [options.tool, "--version"]
    tool = subprocess.run(command, capture_output=True, text=True).stdout.strip() if options.tool else "no tiletool"
    print(f"\n{options.points:,} points, {options.vertices:,} vertices, {options.queries:,} queries,", end=" ")
    print(f"{options.rounds} rounds")
    print(f"delaunay_tiles {own_version()}, {tool}, {packages}")
    print(f"Python {platform.python_version()}, {platform.system()} {platform.release()}, {os.cpu_count()} processors")


def installed(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "missing"


def own_version() -> str:
    import delaunay_tiles as dt

    return dt.__version__


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        print(json.dumps(globals()[sys.argv[2]](*sys.argv[3:])))
    else:
        main()
