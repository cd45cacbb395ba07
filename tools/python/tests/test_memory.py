"""Memory, views, signals and forks. What a process measures or is told is done in one of its own."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import delaunay_tiles as dt

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")

RESIDENT = """
import sys, threading, time
import numpy as np
import delaunay_tiles as dt

def resident():
    fields = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return int(fields["VmRSS"].split()[0]) >> 10
"""


def child(text: str, folder: Path) -> subprocess.Popen:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", RESIDENT + text]
    return subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def result_of(text: str, folder: Path) -> list[int]:
    """Runs Python in a process of its own, and returns the whole numbers that it printed."""
    process = child(text, folder)
    printed, errors = process.communicate(timeout=100)
    assert process.returncode == 0, errors
    return [int(word) for word in printed.split()]


def test_a_build_holds_no_copy_of_an_array(tmp_path):
    # The build is stopped after its points were read, all of which a copy would have.
    text = """
points = np.random.default_rng(0).random((25_000_000, 2))
dt.build(points[:1000], "warm.tiles", memory="64MiB")
before, most = resident(), 0
def look(phase, done, total):
    global most
    most = max(most, resident())
    if phase != "read":
        raise SystemError("read")
try:
    dt.build(points, "t.tiles", memory="64MiB", progress=look)
except SystemError:
    pass
print(points.nbytes >> 20, before, most)
"""
    array, before, most = result_of(text, tmp_path)
    print(f"an array of {array} MiB: {before} MiB resident before the build, at most {most} MiB in it")
    assert array == 381 and before > array
    assert most <= before + 64 + 48
    assert [path.name for path in tmp_path.iterdir()] == ["warm.tiles"]


def test_float32_is_converted_piece_by_piece(tmp_path):
    text = """
points = np.random.default_rng(0).random((12_000_000, 2), dtype=np.float32)
dt.build(points[:1000], "warm.tiles", memory="64MiB")
before, most = resident(), 0
def look(phase, done, total):
    global most
    most = max(most, resident())
    if phase != "read" or done > 6_000_000:
        raise SystemError("read")
try:
    dt.build(points, "t.tiles", memory="64MiB", progress=look)
except SystemError:
    pass
print(points.nbytes >> 20, before, most)
"""
    array, before, most = result_of(text, tmp_path)
    print(f"an array of {array} MiB: {before} MiB resident before the build, at most {most} MiB in it")
    assert most <= before + 64 + 48


def test_arrays_of_a_tile_outlive_its_reader_and_its_cache(survey):
    def arrays(tile: dt.Tile) -> list[np.ndarray]:
        return [tile.points, tile.z, tile.triangles, tile.corners, tile.records]

    t = dt.open(survey.name, cache=1)
    tile = t.tile(3)
    views, copies = arrays(tile), [array.copy() for array in arrays(tile)]
    assert not views[0].flags.owndata and views[0] is tile.points
    for _ in t.tiles():
        pass
    assert t.cache.statistics["bytes"] < 100_000
    del t, tile
    gc.collect()
    # Other tiles would take the memory, if it were free.
    others = [tile.points for tile in dt.open(survey.name).tiles()]
    for view, copy in zip(views, copies, strict=True):
        assert np.array_equal(view, copy)
    assert len(others) > 8


def test_arrays_of_a_tile_cannot_be_written(survey):
    tile = survey.tile(0)
    arrays = [tile.points, tile.z, tile.triangles, tile.triangle_ids, tile.corners, tile.regions, tile.holes]
    for array in [*arrays, tile.constraints, tile.records]:
        assert not array.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            array[:1] = 0
    with pytest.raises(ValueError, match="WRITEABLE"):
        tile.points.flags.writeable = True


LONG_BUILD = """
points = np.random.default_rng(0).random((6_000_000, 2))
print("begins", flush=True)
try:
    dt.build({points}, "t.tiles", memory="64MiB")
except KeyboardInterrupt:
    print("interrupted", flush=True)
    raise SystemExit(7)
"""


@pytest.mark.parametrize("points", ["points", "map(tuple, points)", "points.astype('f4')"])
def test_ctrl_c_ends_a_build_and_leaves_no_file(points, tmp_path):
    process = child(LONG_BUILD.format(points=points), tmp_path)
    assert process.stdout.readline() == "begins\n"
    time.sleep(0.8)
    assert process.poll() is None
    sent = time.monotonic()
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "interrupted\n", process.stderr.read()
    print(f"KeyboardInterrupt after {time.monotonic() - sent:.2f} s")
    process.communicate(timeout=60)
    assert process.returncode == 7 and not list(tmp_path.iterdir())


def test_a_killed_build_leaves_no_file_under_its_name(tmp_path):
    process = child(LONG_BUILD.format(points="points"), tmp_path)
    assert process.stdout.readline() == "begins\n"
    time.sleep(0.5)
    process.kill()
    process.communicate(timeout=60)
    assert not (tmp_path / "t.tiles").exists()
    dt.build([(0, 0), (1, 0), (0, 1)], tmp_path / "t.tiles", overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["t.tiles"]


FORK = """
import os
builder = dt.Builder("t.tiles")
builder.add_points([(0, 0), (1, 0), (0, 1)])
{before}
child = os.fork()
if child == 0:
    try:
        {act}
    except RuntimeError as error:
        os._exit(7 if "forked" in str(error) else 1)
    os._exit(2)
_, status = os.waitpid(child, 0)
assert os.waitstatus_to_exitcode(status) == 7, status
print(builder.finish().triangles)
assert dt.open("t.tiles").verify(True).triangles == 1
"""


@pytest.mark.parametrize("act", ["builder.add_points([(5, 5)])", "builder.finish()", "dt.build([(0, 0)], 'u.tiles')"])
def test_a_fork_amid_a_build_is_an_error_in_the_child_only(act, tmp_path):
    assert result_of(FORK.format(act=act, before=""), tmp_path) == [1]
    assert [path.name for path in tmp_path.iterdir()] == ["t.tiles"]


def test_a_child_of_a_fork_that_ends_does_not_harm_a_build(tmp_path):
    act = "del builder; import gc; gc.collect(); raise RuntimeError('forked')"
    assert result_of(FORK.format(act=act, before=""), tmp_path) == [1]
