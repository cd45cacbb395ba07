"""Points of any kind, on their way to a builder."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from typing import Any

import numpy as np

from . import _core
from ._arguments import coordinates, path_text, positive, refuse_masked
from ._geometry import crs_of

# The number of points that are converted at once.
_CHUNK = 1 << 18

# The number of points of an array that show the builder in advance how they are distributed.
_SAMPLE = 1 << 16

_KINDS = "an array of shape (n, 2) or (n, 3), a path, a table or an iterable of these"


@dataclass(frozen=True)
class PointFile:
    """A file of points, and how it is read.

    Parameters
    ----------
    path : str or path
        LAS, LAZ, COPC, text, raw f64, `.node`, `.poly`, PLY, OBJ, GeoJSON, FlatGeobuf, shapefile, GeoPackage
        (`FILE.gpkg:LAYER` where there are several layers), Parquet. The segments of a `.poly` become walls, and its
        hole points holes.
    format : str, optional
        The format, such as ``"las"`` or ``"text"``; by name, otherwise by content.
    columns : str, optional
        For text: the columns of the coordinates by name or number, such as ``"lon,lat,height"``.
    dims : int
        For raw f64: 2 or 3 numbers a point.
    classes : int or sequence of int
        For LAS: keep only these classes; 2 is ground.
    returns : {"all", "first", "last"}
        For LAS: keep only these returns.
    keep_withheld : bool
        For LAS: keep points that are marked as withheld.
    bounds : (min_x, min_y, max_x, max_y), optional
        Keep only points in this rectangle; of COPC, only what meets it is read.
    every : int
        Keep only each of so many records, from the first one.
    level, resolution : int, float, optional
        For COPC: the deepest level of the octree, or the distance of points that suffices.
    skip_invalid : bool
        Skip invalid records; otherwise the first one is an `InputError`.
    keep_edges : bool
        Keep the edges of the triangulation in the file (`.node` with `.ele`, PLY, OBJ) as break lines.

    Examples
    --------
    >>> ground = dt.PointFile("points.csv", columns="x,y,z", every=2)
    >>> dt.build(ground, "half.tiles", overwrite=True).points
    221
    """

    path: str | os.PathLike[str]
    format: str | None = None
    columns: str | None = None
    dims: int = 2
    classes: int | Sequence[int] = ()
    returns: str = "all"
    keep_withheld: bool = False
    bounds: tuple[float, float, float, float] | None = None
    every: int = 1
    level: int | None = None
    resolution: float | None = None
    skip_invalid: bool = False
    keep_edges: bool = False

    def _arguments(self) -> dict[str, Any]:
        names = ("format", "columns", "returns", "keep_withheld", "bounds", "level", "resolution", "skip_invalid")
        if self.dims not in (2, 3):
            raise ValueError(f"dims must be 2 or 3, not {self.dims!r}")
        return {name: getattr(self, name) for name in names} | {
            "dims": self.dims,
            "classes": _classes(self.classes),
            "every": positive(self.every, "every"),
        }


def _classes(classes: Any) -> list[int]:
    numbers = list(classes) if isinstance(classes, Iterable) else [classes]
    for number in numbers:
        if not hasattr(number, "__index__") or not 0 <= number < 256:
            raise ValueError(f"classes must be whole numbers from 0 to 255, not {number!r}")
    return [number.__index__() for number in numbers]


def push(builder: _core.Builder, points: Any, are_all: bool = False, name: str = "points") -> None:
    """Pushes points to a builder. `are_all` tells whether no other points come."""
    if isinstance(points, (str, bytes, os.PathLike)):
        points = PointFile(path_text(points, name))
    if isinstance(points, PointFile):
        path = path_text(points.path, name)
        builder.add_point_file(path, points._arguments(), points.keep_edges, are_all)
        return
    series = getattr(points, "geometry", points)
    if hasattr(series, "to_wkb") and hasattr(series, "geom_type"):
        _note_crs(builder, series, name)
        points = _of_series(series, name)
    elif hasattr(points, "point_format") and hasattr(points, "x"):
        _push_las(builder, points, are_all, name)
        return
    elif hasattr(points, "__arrow_c_stream__") and not isinstance(points, np.ndarray):
        builder.note_source(name, _push_table(builder, points, name))
        return
    if _is_array(points):
        _push_rows(builder, points, are_all, name)
    elif isinstance(points, Iterable) and not isinstance(points, Mapping):
        _push_iterable(builder, points, name)
    else:
        raise TypeError(f"{name} must be {_KINDS}, not {type(points).__name__}")


def _is_array(points: Any) -> bool:
    if isinstance(points, memoryview) or hasattr(points, "__array__"):
        return True
    return hasattr(points, "shape") and hasattr(points, "dtype")


def _aligned(rows: Any) -> np.ndarray:
    """Returns rows as the compiled part takes them."""
    return np.require(np.asarray(rows), np.float64, ["C", "ALIGNED"])


def _push_table(builder: _core.Builder, points: Any, name: str) -> int:
    try:
        return builder.add_arrow(points)
    except ValueError as error:
        if "C data struct as a Schema" not in str(error):
            raise
        raise TypeError(
            f"{name} is one column of Arrow, {type(points).__name__}, and no table with columns x and y"
        ) from None


def _push_rows(builder: _core.Builder, points: Any, are_all: bool, name: str) -> None:
    """Pushes an array: of float64 without a copy, of other numbers piece by piece."""
    refuse_masked(points, name)
    if not hasattr(points, "shape") or not hasattr(points, "dtype"):
        points = np.asarray(points)
    if len(points.shape) != 2 or points.shape[1] not in (2, 3):
        raise ValueError(f"{name} must have the shape (n, 2) or (n, 3), not {tuple(points.shape)}")
    if np.dtype(points.dtype).kind not in "fiu":
        raise TypeError(f"{name} must hold real numbers, not {points.dtype}")
    if are_all and isinstance(points, np.ndarray):
        builder.expect(len(points), _aligned(points[:: max(len(points) // _SAMPLE, 1)]))
    if isinstance(points, np.ndarray) and points.dtype == np.float64 and points.dtype.isnative and points.flags.aligned:
        builder.add_points(points.view(np.ndarray))
    else:
        for start in range(0, points.shape[0], _CHUNK):
            builder.add_points(_aligned(points[start : start + _CHUNK]))
    builder.note_source(name, points.shape[0])


def _of_series(series: Any, name: str) -> np.ndarray:
    if not (series.geom_type == "Point").all():
        kinds = ", ".join(sorted({kind if isinstance(kind, str) else "None" for kind in series.geom_type}))
        raise ValueError(f"{name} must have points only; it has {kinds}")
    if series.has_z.any() and not series.has_z.all():
        row = int(np.argmin(np.asarray(series.has_z)))
        raise ValueError(f"{name} has points with and without z; row {row} has none")
    columns = [series.x, series.y, series.z] if series.has_z.all() and len(series) else [series.x, series.y]
    return np.column_stack([np.asarray(column, dtype=np.float64) for column in columns])


def _column(table: Any, column: str, name: str) -> Any:
    """Returns a column of a table."""
    columns = getattr(table, "column_names", getattr(table, "columns", None))
    if columns is None:
        raise TypeError(f"{name} must be a file or a table for a column {column!r}, not {type(table).__name__}")
    if column not in list(columns):
        raise ValueError(f"{name} has no column {column!r}; it has {', '.join(map(str, columns))}")
    found = table[column]
    return found.to_pylist() if hasattr(found, "to_pylist") else found


def _of_table(table: Any, name: str) -> np.ndarray:
    """Returns the columns x, y and perhaps z of a table as rows."""
    columns = getattr(table, "column_names", getattr(table, "columns", ()))
    axes = [_column(table, axis, name) for axis in "xyz" if axis != "z" or axis in list(columns)]
    return np.column_stack([np.asarray(axis) for axis in axes])


def _note_crs(builder: _core.Builder, series: Any, name: str) -> None:
    crs = crs_of(series)
    if crs is not None:
        builder.take_crs(name, crs)


def _push_las(builder: _core.Builder, las: Any, are_all: bool, name: str) -> None:
    """Pushes the points of laspy, piece by piece: each of its coordinates is computed when it is asked for."""

    def rows(piece: slice) -> np.ndarray:
        return np.column_stack([np.asarray(axis[piece], dtype=np.float64) for axis in (las.x, las.y, las.z)])

    if are_all:
        builder.expect(len(las), rows(slice(None, None, max(len(las) // _SAMPLE, 1))))
    for start in range(0, len(las), _CHUNK):
        builder.add_points(rows(slice(start, start + _CHUNK)))
    builder.note_source(name, len(las))


def _push_iterable(builder: _core.Builder, points: Iterable[Any], name: str) -> None:
    """Pushes rows of numbers as one input, and other items as inputs of their own."""
    items = iter(points)
    for first in items:
        break
    else:
        builder.note_source(name, 0)
        return
    items = chain([first], items)
    if not _is_row(first):
        for number, item in enumerate(items):
            push(builder, item, name=f"{name}[{number}]")
        return
    count = 0
    while rows := list(islice(items, _CHUNK)):
        try:
            array = np.asarray(rows)
        except ValueError:
            raise ValueError(f"{name} must have rows (x, y) or (x, y, z) of numbers, all of one length") from None
        array = coordinates(array, name, (2, 3))
        builder.add_points(array)
        count += len(array)
    builder.note_source(name, count)


def _is_row(item: Any) -> bool:
    """Returns whether an item is one point rather than several."""
    if isinstance(item, (str, bytes)):
        return False
    if isinstance(item, np.ndarray):
        return item.ndim == 1
    if not isinstance(item, (list, tuple)) or len(item) not in (2, 3):
        return False
    return all(isinstance(value, (int, float, np.number)) for value in item)
