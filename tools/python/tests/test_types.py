"""Checks the annotations: within the package, beside the compiled part, and as a user's editor sees them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import delaunay_tiles as dt

pytest.importorskip("mypy")

PROJECT = Path(__file__).resolve().parents[1]

USE = """
from typing import Any, assert_type

import numpy as np
from numpy.typing import NDArray

import delaunay_tiles as dt

town = dt.open("town.tiles")
assert_type(town.knn([(1, 1)], 2), dt.Neighbours)
assert_type(town.path((1, 1), (2, 2)).distance, float)
assert_type(town.paths((1, 1), [(2, 2)])[0], dt.Path)
assert_type(town.paths((1, 1), [(2, 2)])[:1], dt.Paths)
assert_type(town.interpolate((1.0, 1.0)), float)
assert_type(town.interpolate([(1.0, 1.0)]), NDArray[np.float64])
assert_type(town.raster(1).values, np.ndarray)
assert_type(town.locate(np.zeros((2, 2))), dt.Places)
assert_type([tile.id for tile in town.tiles()], list[int])
assert_type(town.plot(), dt.Map)
assert_type(dt.build(np.zeros((2, 2)), "a.tiles").triangles, int)
assert_type(dt.triangulate([(0, 0)]).triangles, np.ndarray)


async def ask() -> None:
    town = await dt.aopen("town.tiles")
    assert_type(await town.knn([(1, 1)], 2), dt.Neighbours)
    assert_type(await town.interpolate((1.0, 1.0)), float)
    assert_type(await town.digest(), str)
    town.knn([(1, 1)], 2).distance  # type: ignore[attr-defined]
    town.plot()  # type: ignore[attr-defined]


town.path((1, 1))  # type: ignore[call-arg]
town.nearest((1, 1), of="shops")  # type: ignore[arg-type]
town.raster(1, what="colour")  # type: ignore[arg-type]
"""


def check(*arguments: object) -> None:
    """Runs a Python module, which must find nothing."""
    package = Path(dt.__file__).parents[1]
    # An installed package is found without a path.
    path = {} if package.name == "site-packages" else {"MYPYPATH": str(package)}
    command = [sys.executable, "-m", *map(str, arguments)]
    done = subprocess.run(
        command, cwd=PROJECT, env=os.environ | path, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_passes_mypy():
    check("mypy", "--config-file", "pyproject.toml")


def test_the_stubs_say_what_is_there():
    allowed = ["--allowlist", "tests/stubtest-allowlist.txt"]
    check("mypy.stubtest", "delaunay_tiles", "--mypy-config-file", "pyproject.toml", *allowed)


def test_an_editor_knows_the_types_of_answers(tmp_path):
    (tmp_path / "use.py").write_text(USE)
    check("mypy", "--strict", "--config-file", os.devnull, "--cache-dir", tmp_path / "cache", tmp_path / "use.py")
