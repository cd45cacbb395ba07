"""Delaunay triangulations larger than memory, kept as tiles in one file."""

import os

from . import _core
from ._answers import Along, Distances, Footing, Nearest, Neighbours, Reached
from ._errors import BuildError, Error, FileError, InputError, MemoryLimitError, QueryError, VerifyError
from ._open import AsyncTiles, Tiles, aopen, open
from ._paths import Bend, Path, Paths
from ._reach import Reach
from ._tiles import Cache, Metadata, Verified

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_core.in_child_of_fork)

__version__ = _core.__version__

__all__ = [
    "Along",
    "AsyncTiles",
    "Bend",
    "BuildError",
    "Cache",
    "Distances",
    "Error",
    "FileError",
    "Footing",
    "InputError",
    "MemoryLimitError",
    "Metadata",
    "Nearest",
    "Neighbours",
    "Path",
    "Paths",
    "QueryError",
    "Reach",
    "Reached",
    "Tiles",
    "Verified",
    "VerifyError",
    "aopen",
    "open",
]
