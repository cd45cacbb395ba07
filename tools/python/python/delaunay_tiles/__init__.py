"""Delaunay triangulations larger than memory, kept as tiles in one file."""

import os

from . import _core, distributed
from ._answers import Along, Distances, Footing, Nearest, Neighbours, Reached
from ._build import Builder, BuildSummary, build
from ._edit import Editor, EditSummary, edit
from ._elements import Places, Table, Tile
from ._errors import BuildError, EditError, Error, FileError, InputError, MemoryLimitError, QueryError, VerifyError
from ._mesh import Triangulation, triangulate
from ._open import AsyncTiles, Tiles, aopen, open
from ._outputs import Map
from ._paths import Bend, Path, Paths
from ._points import PointFile
from ._reach import Reach
from ._surface import Contours, Profile, Raster, Volume
from ._tiles import Cache, Metadata, Verified

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_core.in_child_of_fork)

__version__ = _core.__version__

__all__ = [
    "Along",
    "AsyncTiles",
    "Bend",
    "BuildError",
    "BuildSummary",
    "Builder",
    "Cache",
    "Contours",
    "Distances",
    "EditError",
    "EditSummary",
    "Editor",
    "Error",
    "FileError",
    "Footing",
    "InputError",
    "Map",
    "MemoryLimitError",
    "Metadata",
    "Nearest",
    "Neighbours",
    "Path",
    "Paths",
    "Places",
    "PointFile",
    "Profile",
    "QueryError",
    "Raster",
    "Reach",
    "Reached",
    "Table",
    "Tile",
    "Tiles",
    "Triangulation",
    "Verified",
    "VerifyError",
    "Volume",
    "aopen",
    "build",
    "distributed",
    "edit",
    "open",
    "triangulate",
]
