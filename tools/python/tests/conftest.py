"""Files that tests and the examples in docstrings share, made by the tool."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import signal
import subprocess
import sysconfig
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import hypothesis
import numpy as np
import pytest

import delaunay_tiles as dt

hypothesis.settings.register_profile("bounded", max_examples=40, derandomize=True, deadline=None)
hypothesis.settings.load_profile("bounded")

DATA = Path(__file__).resolve().parents[3] / "tests" / "data"

# Free points on both sides of the wall and of the obstacle.
SITES = [
    *[(1, 1), (3, 12), (2.5, 18.5), (6, 4), (7, 17), (10, 3)],
    *[(11, 18), (14, 10), (15.5, 5.5), (17, 15), (19, 2), (19, 19)],
]


@pytest.fixture(scope="session")
def tool() -> str:
    """The path of the command `tiletool`: of the environment's TILETOOL, or as it is installed."""
    folders = os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", "")])
    found = os.environ.get("TILETOOL") or shutil.which("tiletool", path=folders)
    if not found:
        pytest.fail("the command tiletool is missing: install the package, or set TILETOOL to the path of the command")
    return found


@pytest.fixture(scope="session")
def run(tool):
    """Runs the tool in a folder, and returns what it printed."""

    def run(*args: object, cwd: Path | None = None) -> str:
        done = subprocess.run([tool, *map(str, args)], cwd=cwd, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture
def worker_killed():
    """Kills a worker of a Dask client while the block works, once a condition holds."""

    @contextmanager
    def killed(client: Any, when: Callable[[], object]) -> Iterator[None]:
        first = next(iter(client.run(os.getpid).values()))
        is_over = threading.Event()

        def kill() -> None:
            while not is_over.is_set() and not when():
                time.sleep(0.001)
            os.kill(first, signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        try:
            yield
        finally:
            is_over.set()
            killer.join()

    return killed


def collection(kind: str, shapes: list) -> str:
    """Returns GeoJSON."""
    features = [
        {"type": "Feature", "properties": {}, "geometry": {"type": kind, "coordinates": shape}} for shape in shapes
    ]
    return json.dumps({"type": "FeatureCollection", "features": features})


@pytest.fixture(scope="session")
def folder(run, tmp_path_factory) -> Path:
    """A folder with town.tiles, and plain.tiles, which has the points and sites of the town but no lines.

    The points are in points.csv, and in survey.csv for the examples.
    """
    folder = tmp_path_factory.mktemp("town")
    rows = [f"{x},{y},{x + 2 * y}" for y in range(21) for x in range(21)]
    for name in ("points.csv", "survey.csv"):
        (folder / name).write_text("\n".join(["x,y,z", *rows, ""]))
    sites = [f"{x},{y},shop {number}" for number, (x, y) in enumerate(SITES)]
    (folder / "sites.csv").write_text("\n".join(["x,y,id", *sites, ""]))
    (folder / "house.geojson").write_text(
        collection("Polygon", [[[[8, 6], [12, 6], [12, 14], [8, 14], [8, 6]]]])
    )
    (folder / "fence.geojson").write_text(collection("LineString", [[[4, 2], [4, 11]]]))
    (folder / "ditch.geojson").write_text(collection("LineString", [[[14, 4], [18, 8.5]]]))
    files = ["points.csv", "--sites", "sites.csv"]
    lines = ["--obstacles", "house.geojson", "--walls", "fence.geojson", "--segments", "ditch.geojson"]
    run("build", *files, *lines, "-o", "town.tiles", "--tile-vertices", 128, "--quiet", cwd=folder)
    run("build", *files, "-o", "plain.tiles", "--quiet", cwd=folder)
    return folder


@pytest.fixture(scope="session")
def town(folder) -> dt.Tiles:
    """The town, open."""
    return dt.open(folder / "town.tiles")


@pytest.fixture(scope="session")
def survey(run, tmp_path_factory) -> dt.Tiles:
    """A hilly survey of 3,000 points with z in many tiles, with break lines, a wall, a hole and sites."""
    folder = tmp_path_factory.mktemp("survey")
    xy = np.random.default_rng(11).uniform(0, 100, (3000, 2))
    z = np.sin(xy[:, 0] / 9) * 20 + xy[:, 1] / 4
    np.column_stack([xy, z]).astype("<f8").tofile(folder / "points.f64")
    (folder / "ridge.geojson").write_text(collection("LineString", [[[10, 10], [50, 30], [90, 80]]]))
    (folder / "wall.geojson").write_text(collection("LineString", [[[60, 10], [60, 25]]]))
    (folder / "pit.geojson").write_text(collection("Polygon", [[[[20, 60], [40, 60], [30, 80], [20, 60]]]]))
    (folder / "sites.csv").write_text("x,y,id\n5,5,west\n95,50,östlich\n55,50,7\n")
    lines = ["--segments", "ridge.geojson", "--walls", "wall.geojson", "--obstacles", "pit.geojson"]
    options = ["--dims", 3, "--tile-vertices", 256, "--crs", "EPSG:25832", "--sites", "sites.csv", "--quiet"]
    run("build", "points.f64", *lines, *options, "-o", "survey.tiles", cwd=folder)
    return dt.open(folder / "survey.tiles")


@pytest.fixture(scope="session")
def small(run, tmp_path_factory) -> dict[str, dt.Tiles]:
    """Files with few points: none, one, two with z, and three on a line."""
    folder = tmp_path_factory.mktemp("small")
    rows = {"none": [], "one": [(1, 2)], "two": [(1, 1, 5.0), (2, 2, 6.0)], "line": [(0, 0), (1, 1), (2, 2)]}
    for name, points in rows.items():
        dt.build(np.array(points, dtype=np.float64).reshape(len(points), -1 if points else 2), folder / f"{name}.tiles")
    return {name: dt.open(folder / f"{name}.tiles") for name in rows}


@pytest.fixture(scope="session")
def islands(run, tmp_path_factory) -> dt.Tiles:
    """The islands of Indonesia as obstacles in the sea, with 60 ports as sites, most of them at sea."""
    folder = tmp_path_factory.mktemp("islands")
    ports = np.random.default_rng(7).uniform((95.5, -11.5), (141.5, 7.5), (60, 2))
    (folder / "ports.csv").write_text("\n".join(f"{x},{y}" for x, y in ports.tolist()) + "\n")
    land = DATA / "indonesia" / "indonesia_ne10m.geojson"
    options = ["--sites", "ports.csv", "--tile-vertices", 4096, "--crs", "EPSG:4326", "--quiet"]
    run("build", "--obstacles", land, *options, "-o", "islands.tiles", cwd=folder)
    return dt.open(folder / "islands.tiles")


@pytest.fixture(autouse=True)
def _names(doctest_namespace, folder, town, monkeypatch):
    """The names of examples, and the folder in which they run."""
    monkeypatch.chdir(folder)
    doctest_namespace.update(dt=dt, np=np, t=town, asyncio=asyncio, os=os)
