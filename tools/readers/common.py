"""Runs the tool, and compares what it wrote with what was expected."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy
import pyproj

TOOL = Path(sys.argv[1]).resolve()
DATA = Path(__file__).resolve().parents[2] / "tests/data"


def tool(*args):
    """Runs the tool, and returns the JSON that it prints."""
    done = subprocess.run([TOOL, *map(str, args), "--json"], capture_output=True, text=True)
    assert done.returncode == 0, f"tiletool {' '.join(map(str, args))}:\n{done.stderr}"
    return json.loads(done.stdout)


def same(what, found, expected):
    assert found == expected, f"{what}: {found}, not {expected}"


def near(what, found, expected, within):
    found, expected = numpy.asarray(found, float), numpy.asarray(expected, float)
    assert found.shape == expected.shape, f"{what}: {found.shape}, not {expected.shape}"
    assert numpy.abs(found - expected).max(initial=0) <= within, what


def rows(array):
    """The rows of an array as a set."""
    return set(map(tuple, numpy.asarray(array, float).tolist()))


def same_system(what, found, expected):
    """Compares reference systems, each in any form, or an EPSG code. In files, x is before y anyway."""
    assert found is not None, f"{what}: no reference system"
    found, expected = pyproj.CRS.from_user_input(found), pyproj.CRS.from_user_input(expected)
    assert found.equals(expected, ignore_axis_order=True), f"{what}: {found!r}, not {expected!r}"


def has_ogrinfo():
    """Whether GDAL's own programs are there, as they must be in CI."""
    found = shutil.which("ogrinfo") is not None
    assert found or not os.environ.get("CI"), "ogrinfo is missing; install gdal-bin"
    return found


def ogrinfo(path):
    """What GDAL's own program prints about a file."""
    return subprocess.run(["ogrinfo", "-so", "-al", path], check=True, capture_output=True, text=True).stdout
