"""Tiles, tables of elements, and where points lie."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, overload

import numpy as np

from . import _core
from ._arguments import coordinates
from ._base import Questions

Bounds = tuple[float, float, float, float]


@overload
def box(bounds: Bounds) -> Bounds: ...


@overload
def box(bounds: None) -> None: ...


def box(bounds: Any) -> Bounds | None:
    """Returns a box as four numbers, checked."""
    if bounds is None:
        return None
    try:
        min_x, min_y, max_x, max_y = (float(value) for value in bounds)
    except (TypeError, ValueError):
        raise ValueError(f"bounds must be (min_x, min_y, max_x, max_y), not {bounds!r}") from None
    if not (min_x <= max_x and min_y <= max_y):
        raise ValueError(f"bounds must have the lower ends first, and no NaN, not {bounds!r}")
    return min_x, min_y, max_x, max_y


@dataclass(frozen=True, slots=True)
class Places:
    """Where points lie; arrays of shape (n,).

    Attributes
    ----------
    kind : uint8
        0 outside, 1 inside a triangle, 2 on an edge, 3 on a vertex.
    tile : int64
        The tile that has the triangle or the vertex, −1 outside.
    triangle : int64
        The number of the triangle in the tile, −1 outside. Of several at an edge or a vertex, always the same one.
        If another tile owns the triangle, `Tile.triangle_ids` does not list it.
    corner : int64
        On an edge: the corner (0, 1, 2) at which it starts, counter-clockwise. On a vertex: its number in the tile.
        Otherwise −1.
    """

    kind: np.ndarray
    tile: np.ndarray
    triangle: np.ndarray
    corner: np.ndarray

    @property
    def inside(self) -> np.ndarray:
        """Whether each point is in the triangulation, its boundary included."""
        return self.kind > 0

    def __len__(self) -> int:
        return len(self.kind)


class Tile:
    """A tile in memory. Its arrays are read-only.

    `points` and `z` are views of the tile's memory, which they keep alive; the other arrays are decoded when they are
    asked for.
    """

    def __init__(self, core: _core.Tile) -> None:
        self._core = core

    @property
    def id(self) -> int:
        """The number of the tile."""
        return self._core.id

    @cached_property
    def points(self) -> np.ndarray:
        """x and y of the vertices that the tile owns, shape (n, 2)."""
        return np.frombuffer(self._core.coordinates(), dtype="<f8").reshape(-1, 2)

    @cached_property
    def z(self) -> np.ndarray | None:
        """z of these vertices, shape (n,), or None."""
        view = self._core.z()
        return None if view is None else np.frombuffer(view, dtype="<f8")

    @cached_property
    def records(self) -> np.ndarray:
        """The number of the input record of each vertex, shape (n,)."""
        return _frozen(self._core.records()[0])

    @cached_property
    def _decoded(self) -> tuple[np.ndarray, ...]:
        return tuple(_frozen(array) for array in self._core.triangles())

    @property
    def triangle_ids(self) -> np.ndarray:
        """The numbers in the tile of the triangles that it owns, shape (m,)."""
        return self._decoded[0]

    @property
    def triangles(self) -> np.ndarray:
        """The corners of these triangles, counter-clockwise, as rows of `corners`, shape (m, 3)."""
        return self._decoded[1]

    @property
    def regions(self) -> np.ndarray:
        """The region of each triangle, shape (m,)."""
        return self._decoded[2]

    @property
    def holes(self) -> np.ndarray:
        """Whether each triangle is in a hole, shape (m,)."""
        return self._decoded[3]

    @property
    def constraints(self) -> np.ndarray:
        """Whether the edge from each corner to the next one is a constraint, shape (m, 3)."""
        return self._decoded[4]

    @cached_property
    def corners(self) -> np.ndarray:
        """x and y of the vertices of the tile, then of corners that other tiles own, shape (n + k, 2)."""
        return _frozen(np.concatenate([self.points, self._decoded[5]]))

    @property
    def others(self) -> tuple[np.ndarray, np.ndarray]:
        """The tiles, and the numbers there, of the corners that other tiles own; two arrays of shape (k,)."""
        return self._decoded[6], self._decoded[7]

    @cached_property
    def _corner_z(self) -> np.ndarray:
        """z of `corners`, if the file has z."""
        return np.concatenate([self.z, self._decoded[8]])

    def _meets(self, bounds: Bounds) -> np.ndarray:
        """Whether each triangle intersects a box, shape (m,)."""
        return self._core.meets(box(bounds))[0]

    @cached_property
    def sites(self) -> tuple[np.ndarray, np.ndarray, list[str | None]]:
        """The sites: their vertices, their numbers, and their ids."""
        return self._core.sites()

    def __repr__(self) -> str:
        return f"<Tile {self.id}: {len(self.points)} vertices>"


def _frozen(array: np.ndarray) -> np.ndarray:
    array.flags.writeable = False
    return array


class Table:
    """Rows that are read tile by tile when something asks for them.

    pyarrow, polars, DuckDB and pandas read it through ``__arrow_c_stream__``, each time from the beginning.
    """

    def __init__(self, reader: _core.Reader, kind: str, bounds: Bounds | None) -> None:
        reader.arrow(kind, bounds)
        self._arguments = (reader, kind, bounds)

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        reader, kind, bounds = self._arguments
        return reader.arrow(kind, bounds).__arrow_c_stream__(requested_schema)


class Elements(Questions):
    """Tiles, tables of elements, and where points lie."""

    __slots__ = ()

    def tile(self, number: int) -> Any:
        """Reads a tile.

        Raises
        ------
        IndexError
            There is no tile with this number, from 0 on.

        Examples
        --------
        >>> tile = t.tile(0)
        >>> tile.triangles.shape[1], tile.points.flags.owndata
        (3, False)
        """
        index = _tile_number(number)
        return self._ask(lambda awaited: self._reader.tile(index, awaited), Tile)

    def tile_ids(self, bounds: Bounds | None = None) -> Any:
        """Returns the numbers of the tiles whose boxes meet `bounds`, or of all tiles.

        Examples
        --------
        >>> t.tile_ids((0, 0, 3, 3))
        [0]
        """
        rect = box(bounds)
        return self._ask(lambda awaited: self._reader.tile_ids(rect, awaited))

    def locate(self, xy: Any) -> Any:
        """Locates points in the triangulation, exactly.

        Parameters
        ----------
        xy : array of shape (n, 2), or one point

        Returns
        -------
        Places
            A point that is not finite is outside.

        Raises
        ------
        ValueError, TypeError
            `xy` has another shape or is not real.

        Examples
        --------
        >>> t.locate([(1.5, 1.25), (30, 1), (2, 3)]).kind
        array([1, 0, 3], dtype=uint8)
        """
        points = coordinates(xy)
        return self._ask(lambda awaited: self._reader.locate(points, awaited), lambda found: Places(*found))

    def arrow(self, kind: str = "triangles", bounds: Bounds | None = None) -> Table:
        """Returns the triangles, vertices or constraint edges as a table for Arrow.

        Parameters
        ----------
        kind : {"triangles", "vertices", "edges"}
            Triangles have the columns tile, triangle, x0, y0, (z0,) … region, hole; vertices tile, vertex, x, y, (z,)
            record, input; edges tile, x0, y0, (z0,) x1, y1, (z1,) kind, line, a row for each line along an edge.
        bounds : (min_x, min_y, max_x, max_y), optional
            Only triangles that intersect it, vertices in it, edges whose boxes meet it.

        Examples
        --------
        >>> import pyarrow
        >>> pyarrow.table(t.arrow("vertices")).num_rows == t.metadata.vertices
        True
        """
        return Table(self._reader, kind, box(bounds))


class TileByTile(Elements):
    """What needs one tile after another, and so is not for asyncio."""

    __slots__ = ()

    def tiles(self, bounds: Bounds | None = None) -> Iterator[Tile]:
        """Reads the tiles whose boxes meet `bounds`, or all, one after another.

        Examples
        --------
        >>> sum(len(tile.triangles) for tile in t.tiles()) == t.metadata.triangles
        True
        """
        for number in self.tile_ids(bounds):
            yield self.tile(number)


def _tile_number(number: Any) -> int:
    try:
        index = number.__index__()
    except AttributeError:
        raise TypeError(f"the number of a tile must be a whole number, not {type(number).__name__}") from None
    if not 0 <= index < 2**32:
        raise IndexError(f"there is no tile {index}; tiles are numbered from 0")
    return index
