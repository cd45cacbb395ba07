"""The wheel's command `tiletool` is the tool alone."""

from __future__ import annotations

import subprocess
import sys

import delaunay_tiles as dt


def test_the_command_is_a_module_too(run):
    done = subprocess.run([sys.executable, "-m", "tiletool", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == run("--version") and dt.__version__ in done.stdout


def test_mistakes_end_with_their_exit_codes():
    for args, code, part in [(["biuld"], 2, "build"), (["inspect", "missing.tiles"], 1, "missing.tiles")]:
        done = subprocess.run([sys.executable, "-m", "tiletool", *args], capture_output=True, text=True)
        assert done.returncode == code and part in done.stderr


def test_the_command_imports_neither_the_package_nor_numpy():
    command = [sys.executable, "-X", "importtime", "-m", "tiletool", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "tiletool" in imported and not {"numpy", "delaunay_tiles"} & imported
