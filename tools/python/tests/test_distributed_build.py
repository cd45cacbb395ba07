"""Builds over workers: the triangles are those of one process, whatever does the tasks, and if a worker is killed."""

from __future__ import annotations

import json
import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import delaunay_tiles as dt

# 60,000 points take more than this, so there are several blocks.
LITTLE = {"memory": "2MB", "threads": 2, "tile_vertices": 500}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory) -> dict[str, Path]:
    """Files of points, walls, obstacles and sites across all blocks."""
    folder = tmp_path_factory.mktemp("inputs")
    xy = np.random.default_rng(3).random((60_000, 2)) * 100
    np.savetxt(folder / "points.csv", np.column_stack([xy, xy.sum(axis=1)]), "%.17g", ",", header="x,y,z", comments="")
    rows = [f"{x + 0.5},{y + 0.25},{x + 9.5},{y + 1.25}" for x in range(0, 90, 10) for y in range(0, 100, 5)]
    (folder / "walls.csv").write_text("\n".join(rows))
    rings = [[[x, y], [x + 2, y], [x + 2, y + 1], [x, y + 1], [x, y]] for x in range(1, 99, 7) for y in range(3, 99, 5)]
    shapes = ",".join(str([ring]) for ring in rings)
    (folder / "houses.geojson").write_text(f'{{"type": "MultiPolygon", "coordinates": [{shapes}]}}')
    sites = [f"{x}.5,{y}.75,shop {x}/{y}" for x in range(0, 100, 9) for y in range(0, 100, 10)]
    (folder / "sites.csv").write_text("\n".join(["x,y,id", *sites]))
    names = {"points": "points.csv", "walls": "walls.csv", "obstacles": "houses.geojson", "sites": "sites.csv"}
    return {what: folder / name for what, name in names.items()}


@pytest.fixture(scope="module")
def whole(inputs, run, tmp_path_factory) -> str:
    """The digest of a file that one process built in memory."""
    out = tmp_path_factory.mktemp("whole") / "whole.tiles"
    summary = dt.build(**inputs, out=out, crossings="split", memory="1GB")
    assert summary.blocks == 1 and summary.sites == 120 and summary.hole_triangles > 0
    return run("digest", "--recompute", out)


def assert_is(whole: str, out: Path, summary: dt.BuildSummary, run) -> None:
    assert summary.blocks > 3 and summary.resumed_blocks == summary.blocks
    run("verify", "--deep", out)
    assert run("digest", "--recompute", out) == whole
    assert os.listdir(out.parent) == [out.name]


def test_processes_build_what_one_builds(inputs, whole, run, tmp_path):
    seen = []
    out = tmp_path / "shared.tiles"
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as client:
        summary = dt.distributed.build(
            **inputs, out=out, client=client, crossings="split", progress=lambda *state: seen.append(state), **LITTLE
        )
    assert_is(whole, out, summary, run)
    steps = [state[1:] for state in seen if state[0] == "tasks"]
    assert len(steps) == summary.blocks + 1 and steps[0][0] == 0 and steps[-1][0] == steps[-1][1] >= 60_000


@pytest.fixture(scope="module")
def raw(inputs, tmp_path_factory) -> list[dt.PointFile]:
    """The points in files of raw numbers."""
    xyz = np.loadtxt(inputs["points"], delimiter=",", skiprows=1)
    folder = tmp_path_factory.mktemp("raw")
    files = [folder / f"{number}.f64" for number in range(5)]
    for path, part in zip(files, np.array_split(xyz, 5), strict=True):
        part.tofile(path)
    return [dt.PointFile(path, dims=3) for path in files]


def test_processes_read_the_inputs_too(inputs, raw, whole, run, tmp_path):
    seen = []
    arguments = {**inputs, "points": raw, "crossings": "split", "read_inputs": True, **LITTLE}
    out = tmp_path / "shared.tiles"
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as client:
        summary = dt.distributed.build(
            **arguments, out=out, client=client, progress=lambda *state: seen.append(state)
        )
    assert_is(whole, out, summary, run)
    assert ("tasks", 60_000, 60_000) in seen
    names = [source["name"] for source in json.loads(run("inspect", out, "--json"))["sources"]]
    assert names == [f"{number}.f64" for number in range(5)]


def test_what_workers_cannot_read_is_an_error(inputs, raw, tmp_path):
    out = tmp_path / "shared.tiles"
    with ThreadPoolExecutor(2) as client:

        def build(points: object, **options: object) -> dt.BuildSummary:
            return dt.distributed.build(points, out, client=client, read_inputs=True, **{**LITTLE, **options})

        with pytest.raises(ValueError, match="all read in the same way"):
            build([raw[0], dt.PointFile(raw[1].path, dims=2)])
        with pytest.raises(ValueError, match="must be files"):
            build([])
        with pytest.raises(dt.BuildError, match="does not say how many records it has"):
            build(inputs["points"])
        with pytest.raises(ValueError, match="read_inputs or resume"):
            build(raw, resume=True)
        # All fit into memory.
        assert build(raw, memory="1GB").blocks == 1
    assert os.listdir(tmp_path) == [out.name]


def test_inputs_of_different_systems_are_refused_before_workers_read_them(tmp_path):
    geopandas = pytest.importorskip("geopandas")
    pytest.importorskip("pyarrow")
    files = []
    for crs in "EPSG:25832", "EPSG:32633":
        x, y = np.random.default_rng(2).random((2, 30_000))
        files.append(tmp_path / f"{len(files)}.parquet")
        geopandas.GeoDataFrame(geometry=geopandas.points_from_xy(x, y), crs=crs).to_parquet(files[-1])
    with pytest.raises(dt.InputError, match="32633"):
        dt.distributed.build(files, tmp_path / "shared.tiles", client=None, read_inputs=True, **LITTLE)
    assert sorted(os.listdir(tmp_path)) == [file.name for file in files]


def test_arrays_become_tasks_too(run, tmp_path):
    xyz = np.random.default_rng(4).random((60_000, 3))
    lines = [np.array([[0.1, y], [0.9, y + 0.01]]) for y in np.linspace(0.1, 0.9, 20)]
    dt.build(xyz, tmp_path / "whole.tiles", lines=lines, memory="1GB")
    digest = run("digest", "--recompute", tmp_path / "whole.tiles")
    with ThreadPoolExecutor(2) as client:
        for task_threads in 1, 3:
            (tmp_path / "shared").mkdir(exist_ok=True)
            out = tmp_path / "shared" / "shared.tiles"
            summary = dt.distributed.build(
                xyz, out, lines=lines, client=client, task_threads=task_threads, overwrite=True, **LITTLE
            )
            assert_is(digest, out, summary, run)
    assert dt.open(out).metadata.has_z


def test_a_build_in_memory_asks_no_worker(tmp_path):
    class Unused:
        def submit(self, *_: object) -> object:
            raise AssertionError("a task was sent")

    summary = dt.distributed.build([(0, 0), (1, 0), (0, 1)], tmp_path / "few.tiles", client=Unused())
    assert (summary.vertices, summary.blocks) == (3, 1)
    with pytest.raises(FileExistsError, match="overwrite=True"):
        dt.distributed.build([(0, 0)], tmp_path / "few.tiles", client=Unused())
    with pytest.raises(ValueError, match="task_threads must be above 0"):
        dt.distributed.build([(0, 0)], tmp_path / "few.tiles", client=Unused(), task_threads=0)


def test_a_worker_with_too_little_memory_says_so_and_the_build_goes_on_elsewhere(
    inputs, whole, run, tmp_path, monkeypatch
):
    out = tmp_path / "shared.tiles"
    arguments = {**inputs, "out": out, "crossings": "split", **LITTLE}
    with ThreadPoolExecutor(2) as client:
        with monkeypatch.context() as patch:
            patch.setattr(dt.distributed, "_memory_of_worker", lambda: 1_900_000)
            with pytest.raises(dt.BuildError, match="needs 2 MiB of memory, and may take 1; do it where there is more"):
                dt.distributed.build(**arguments, client=client)
        with pytest.raises(FileExistsError, match="resume=True or overwrite=True"):
            dt.distributed.build(**arguments, client=client)
        summary = dt.distributed.build(**arguments, client=client, resume=True)
    assert_is(whole, out, summary, run)


def test_on_dask_workers_that_are_killed_change_nothing(inputs, whole, run, tmp_path, worker_killed):
    dask = pytest.importorskip("dask.distributed")
    out = tmp_path / "shared.tiles"
    with (
        dask.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        dask.Client(cluster) as client,
    ):
        work = tmp_path / "shared.tiles.partial"
        # Some tasks are done by then, and others are not.
        with worker_killed(client, lambda: list(work.glob("block-*[0-9]"))):
            summary = dt.distributed.build(**inputs, out=out, client=client, crossings="split", **LITTLE)
    assert_is(whole, out, summary, run)
