"""Questions over workers: the answers are those of one process, whatever the batches, and if a worker is killed."""

from __future__ import annotations

import multiprocessing
import shutil
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import delaunay_tiles as dt

XY = np.random.default_rng(31).uniform(0, 20, (700, 2))


def assert_same(mine: object, other: object, names: list[str]) -> None:
    for name in names:
        left, right = getattr(mine, name), getattr(other, name)
        assert left.dtype == right.dtype, name
        same = np.array_equal(left, right, equal_nan=left.dtype.kind == "f")
        assert same, name


def assert_same_neighbours(mine: dt.Neighbours, other: dt.Neighbours) -> None:
    names = ["status", "site", "id", "distance", "lower", "upper", "xy", "bound", "nearest_free"]
    assert_same(mine, other, names)


def assert_same_distances(mine: dt.Distances, other: dt.Distances) -> None:
    assert_same(mine, other, ["status", "distance", "lower", "upper"])


@pytest.fixture(scope="module")
def processes():
    """An executor with two processes, which share nothing with this one."""
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        yield pool


@pytest.mark.parametrize("batch", [1, 7, 100, 10_000])
@pytest.mark.parametrize("mode", ["exact", "within:0.1"])
def test_answers_do_not_depend_on_the_batches(town, batch, mode):
    xy = XY[:60]
    with ThreadPoolExecutor(3) as client:
        near = dt.distributed.knn(town, xy, 3, mode, client=client, batch=batch)
        assert_same_neighbours(near, town.knn(xy, 3, mode))
        for a, b in (xy, xy[:9]), (xy[:9], xy), (xy[:8], xy[8:16]), (xy[:0], xy), (xy, xy[:0]):
            found = dt.distributed.matrix(town, a, b, mode, client=client, batch=batch)
            assert_same_distances(found, town.matrix(a, b, mode))


def test_more_neighbours_than_sites_and_points_in_obstacles_are_told_as_by_one_process(town):
    with ThreadPoolExecutor(2) as client:
        near = dt.distributed.knn(town, XY, 20, client=client, batch=50)
        assert_same_neighbours(near, town.knn(XY, 20))
        for row, other in zip(near, town.knn(XY, 20), strict=True):
            assert np.array_equal(row.distance, other.distance, equal_nan=True)
        assert len(dt.distributed.knn(town, XY[:0], 2, client=client)) == 0
        limited = dt.distributed.knn(town, XY, 3, client=client, max_tiles=1)
        assert "out_of_budget" in limited.status.tolist()


def test_processes_open_the_file_themselves(processes, folder, town, monkeypatch):
    near = dt.distributed.knn(folder / "town.tiles", XY, 2, client=processes, batch=64)
    assert_same_neighbours(near, town.knn(XY, 2))
    # Their working directory is another one.
    monkeypatch.chdir(folder)
    near = dt.distributed.knn("town.tiles", XY, 2, client=processes, batch=64)
    assert_same_neighbours(near, town.knn(XY, 2))
    found = dt.distributed.matrix(folder / "town.tiles", XY[:20], XY, client=processes, batch=5)
    assert_same_distances(found, town.matrix(XY[:20], XY))


def test_a_file_that_was_changed_meanwhile_is_told(processes, folder, run, tmp_path):
    path = tmp_path / "changed.tiles"
    shutil.copy(folder / "town.tiles", path)
    tiles = dt.open(path)
    (tmp_path / "one.csv").write_text("x,y,z\n0.5,0.25,1\n")
    run("insert", path, tmp_path / "one.csv")
    with pytest.raises(dt.FileError, match="not in the state"):
        dt.distributed.knn(tiles, XY, 2, client=processes)


def test_mistakes_are_told_before_anything_is_sent(town):
    class Unused:
        def submit(self, *_: object) -> object:
            raise AssertionError("a task was sent")

    client = Unused()
    with pytest.raises(ValueError, match="k must be above 0"):
        dt.distributed.knn(town, XY, 0, client=client)
    with pytest.raises(ValueError, match="batch must be above 0"):
        dt.distributed.knn(town, XY, 1, client=client, batch=0)
    with pytest.raises(dt.QueryError, match=r"a\[1\]"):
        dt.distributed.matrix(town, [(1, 1), (np.nan, 2)], XY, client=client)
    with pytest.raises(FileNotFoundError):
        dt.distributed.knn("nowhere.tiles", XY, 1, client=client)


def test_on_dask_workers_that_are_killed_change_nothing(folder, town, worker_killed):
    dask = pytest.importorskip("dask.distributed")
    xy = np.random.default_rng(5).uniform(0, 20, (4000, 2))
    with (
        dask.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        dask.Client(cluster) as client,
    ):
        # Some tasks are done by then, and others are not.
        with worker_killed(client, lambda: any(client.has_what().values())):
            near = dt.distributed.knn(folder / "town.tiles", xy, 2, client=client, batch=20)
        found = dt.distributed.matrix(folder / "town.tiles", xy[:30], xy, client=client, batch=3)
    assert_same_neighbours(near, town.knn(xy, 2))
    assert_same_distances(found, town.matrix(xy[:30], xy))
