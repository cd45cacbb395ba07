"""Questions by distance from threads, asyncio and other processes; Ctrl-C and cancellation."""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import pickle
import shutil
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import delaunay_tiles as dt

XY = np.random.default_rng(12).uniform(0, 20, (300, 2))


def answers(t: dt.Tiles, xy: np.ndarray = XY) -> list[np.ndarray]:
    """Returns arrays of several questions."""
    near, paths = t.knn(xy, 3), t.paths(xy, (1, 1))
    return [near.site, near.distance, paths.points, t.matrix(xy[:5], xy).distance, t.nearest(xy, 4).distance]


def assert_same(left: list[np.ndarray], right: list[np.ndarray]) -> None:
    for mine, other in zip(left, right, strict=True):
        assert np.array_equal(mine, other, equal_nan=True)


def test_threads_share_one_file(folder):
    t = dt.open(folder / "town.tiles", cache="64KiB")
    expected = answers(t)
    with ThreadPoolExecutor(8) as pool:
        for found in pool.map(lambda _: answers(t), range(16)):
            assert_same(found, expected)


def test_awaited_answers_are_those_of_a_question_in_turn(folder, town):
    async def ask() -> list:
        t = await dt.aopen(folder / "town.tiles")
        return await asyncio.gather(
            t.knn(XY, 3),
            t.within(XY, 4),
            t.path((3, 8), (5, 8)),
            t.paths(XY, (1, 1)),
            t.matrix(XY[:5], XY),
            t.along((6, 10), (14, 10)),
            t.reach((6, 10), 3),
            t.nearest(XY, 4),
            t.footing(XY),
            *(t.knn(one, 3) for one in XY[:50]),
        )

    near, reached, path, paths, matrix, along, reach, nearest, footing, *each = asyncio.run(ask())
    assert_same([near.site, near.distance, paths.points, matrix.distance, nearest.distance], answers(town))
    assert reached.site.tolist() == town.within(XY, 4).site.tolist()
    assert path.points.tolist() == town.path((3, 8), (5, 8)).points.tolist()
    assert along.id.tolist() == town.along((6, 10), (14, 10)).id.tolist()
    assert reach.area == town.reach((6, 10), 3).area
    assert footing.free.tolist() == town.footing(XY).free.tolist()
    assert [one.site.tolist() for one in each] == near.site[:50].tolist()


def test_errors_of_awaited_questions_are_raised(folder):
    async def ask() -> None:
        t = await dt.aopen(folder / "town.tiles")
        with pytest.raises(dt.QueryError, match="break lines"):
            await t.edge_distances((1, 1), (2, 2))
        with pytest.raises(ValueError, match="k must be"):
            t.knn(XY, 0)

    asyncio.run(ask())


def test_a_cancelled_question_stops(islands):
    many = np.random.default_rng(1).uniform((96, -11), (141, 7), (50_000, 2))

    async def ask() -> dt.AsyncTiles:
        t = await dt.aopen(islands.name)
        task = asyncio.ensure_future(t.knn(many, 60))
        await asyncio.sleep(0.2)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(t.paths(many, many[::-1]), 0.2)
        return t

    assert comes_to_rest(asyncio.run(ask()).cache)


def comes_to_rest(cache: dt.Cache) -> bool:
    """Waits until no tile is asked for any more; returns whether that happened within a minute."""
    before = None
    for _ in range(120):
        now = cache.statistics
        if now == before:
            return True
        before = now
        time.sleep(0.5)
    return False


INTERRUPTED = """
import signal, sys, threading, time
import numpy as np
import delaunay_tiles as dt

t = dt.open(sys.argv[1])
many = np.random.default_rng(1).uniform((96, -11), (141, 7), (1_000_000, 2))
pressed = []

def press():
    pressed.append(time.monotonic())
    signal.raise_signal(signal.SIGINT)

asks = [lambda: t.knn(many, 50), lambda: t.matrix(many[:500], many[:20_000]), lambda: t.paths(many, many[::-1], "fast")]
for ask in asks:
    threading.Timer(0.5, press).start()
    try:
        ask()
    except KeyboardInterrupt:
        print(time.monotonic() - pressed[-1])
    else:
        sys.exit("not interrupted")
print(t.knn(many[:10], 1).site.shape)
"""


def test_ctrl_c_ends_a_long_batch(islands):
    command = [sys.executable, "-c", INTERRUPTED, islands.name]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, env=os.environ)
    assert done.returncode == 0, done.stderr
    *delays, last = done.stdout.splitlines()
    # Half a second is promised; a busy machine may take longer, but the questions would take hours.
    assert len(delays) == 3 and max(map(float, delays)) < 20
    assert last == "(10, 1)"


def test_files_travel_to_processes_that_are_spawned(town):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        for found in pool.map(answers, [town] * 3):
            assert_same(found, answers(town))


def test_a_pickle_is_of_one_state_of_the_file(folder, run, tmp_path):
    name = tmp_path / "moved.tiles"
    shutil.copy(folder / "town.tiles", name)
    pickled = pickle.dumps(dt.open(name))
    assert_same(answers(pickle.loads(pickled)), answers(dt.open(name)))
    run("build", folder / "points.csv", "-o", name, "--force", "--quiet")
    with pytest.raises(dt.FileError, match="not in the state in which it was pickled"):
        pickle.loads(pickled)
    name.unlink()
    with pytest.raises(FileNotFoundError):
        pickle.loads(pickled)


def test_answers_are_pickled(town):
    near = town.knn(XY, 3, paths=True)
    copy = pickle.loads(pickle.dumps(near))
    assert copy.site.tolist() == near.site.tolist() and copy.id.tolist() == near.id.tolist()
    assert copy.paths[5] and copy.paths[5].bends == near.paths[5].bends
    reach = town.reach((6, 10), 3)
    assert pickle.loads(pickle.dumps(reach)).to_wkt() == reach.to_wkt()
    along = pickle.loads(pickle.dumps(town.along((6, 10), (14, 10))))
    assert along.id.tolist() == town.along((6, 10), (14, 10)).id.tolist()


FORKED = """
import os, sys
import delaunay_tiles as dt

t = dt.open(sys.argv[1])
if os.fork() == 0:
    asks = [lambda: t.knn((1, 1), 1), lambda: t.path((1, 1), (2, 2)), lambda: dt.open(sys.argv[1])]
    caught = 0
    for ask in asks:
        try:
            ask()
        except RuntimeError as error:
            caught += "forked" in str(error) and "spawn" in str(error)
    os._exit(caught)
print(os.waitstatus_to_exitcode(os.wait()[1]), t.knn((1, 1), 1).site)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_child_of_a_fork_is_told_so(town):
    command = [sys.executable, "-c", FORKED, town.name]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=os.environ)
    assert done.stdout == "3 [0]\n", done.stderr
