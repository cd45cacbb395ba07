"""Paths as answers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, overload

import numpy as np

from ._columns import status

_KINDS = ("break line", "wall", "obstacle")


@dataclass(frozen=True, slots=True)
class Bend:
    """A bend of a path.

    Attributes
    ----------
    xy : tuple of float
        The point.
    turns : str
        The direction in which the path turns: ``"left"``, with an obstacle on its left, or ``"right"``.
    vertex : tuple of int
        Tile and index of the vertex.
    edge_to : tuple of int or None
        Tile and index of the other end of the edge that the path bends around. None if nothing is in the way, because
        the path is not a shortest one.
    lines : tuple
        Kind (``"wall"``, ``"obstacle"`` or ``"break line"``) and number of each input line along that edge.
    """

    xy: tuple[float, float]
    turns: str
    vertex: tuple[int, int]
    edge_to: tuple[int, int] | None
    lines: tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A path, or why there is none. It is true if a path was found.

    Attributes
    ----------
    status : str
        ``"ok"``, ``"unreachable"``, ``"inside_obstacle"`` (an end is not free) or ``"out_of_budget"``.
    distance, lower, upper : float
        The length, and bounds of the true shortest length: infinite if no path connects the ends, and NaN if an end is
        inside an obstacle. At a limit, `distance` is NaN, and the bounds hold.
    points : array of shape (m, 2)
        The start, the bends and the end; no points if no path was found.
    bends : list of Bend
        What the path bends around, at each point between start and end.
    certified : bool
        Whether the path was proved by a walk through the triangles that it passes.
    inside_point, nearest_free : array of shape (2,) or None
        The end that is inside an obstacle, and the free point that is nearest to it.
    """

    status: str
    distance: float
    lower: float
    upper: float
    points: np.ndarray
    bends: list[Bend]
    certified: bool
    inside_point: np.ndarray | None
    nearest_free: np.ndarray | None

    def __bool__(self) -> bool:
        return self.status == "ok"

    def to_wkt(self) -> str:
        """Returns the path as well-known text: ``LINESTRING (x y, …)``, or ``LINESTRING EMPTY``."""
        if not self:
            return "LINESTRING EMPTY"
        return f"LINESTRING ({', '.join(f'{x} {y}' for x, y in self.points.tolist())})"

    @property
    def __geo_interface__(self) -> dict[str, Any]:
        return {"type": "LineString", "coordinates": tuple(map(tuple, self.points.tolist()))}


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Paths:
    """Paths, one for each pair of points. ``paths[i]`` is a `Path`, ``paths[i:j]`` are `Paths`.

    ``geopandas.GeoDataFrame.from_features(paths)`` has a row for each path, without a line if there is none.

    Attributes
    ----------
    status : array of shape (n,)
        The words of `Path.status`.
    distance, lower, upper : array of shape (n,)
        The lengths and bounds of `Path`.
    points : array of shape (m, 2)
        The points of all paths, one path after the other.
    offsets : array of shape (n + 1,)
        Path i has the points from ``offsets[i]`` to ``offsets[i + 1]``.
    certified : array of shape (n,)
        Whether each path was proved.
    inside_point, nearest_free : array of shape (n, 2)
        Of the end that is inside an obstacle, as in `Path`; otherwise NaN.
    """

    _codes: np.ndarray
    distance: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    inside_point: np.ndarray
    nearest_free: np.ndarray
    offsets: np.ndarray
    points: np.ndarray
    certified: np.ndarray
    _bends: tuple[np.ndarray, ...]

    @classmethod
    def _of(cls, columns: tuple[Any, ...]) -> Paths:
        codes, _, inside, free, distance, lower, upper, offsets, points, certified, *bends = columns
        return cls(codes, distance, lower, upper, inside, free, offsets, points, certified, tuple(bends))

    @property
    def status(self) -> Any:
        return status(self._codes)

    def __len__(self) -> int:
        return len(self._codes)

    def __iter__(self) -> Iterator[Path]:
        return map(self._path, range(len(self)))

    @overload
    def __getitem__(self, index: int) -> Path: ...

    @overload
    def __getitem__(self, index: slice) -> Paths: ...

    def __getitem__(self, index: int | slice) -> Path | Paths:
        if not isinstance(index, slice):
            return self._path(range(len(self))[index])
        first, end, step = index.indices(len(self))
        if step != 1:
            raise ValueError("a slice of paths has the step 1")
        end = max(first, end)
        some = slice(first, end)
        offsets = self.offsets[first : end + 1]
        bend_offsets, *bends = self._bends
        # The bends stay whole: their offsets are of the whole list.
        return Paths(
            self._codes[some],
            self.distance[some],
            self.lower[some],
            self.upper[some],
            self.inside_point[some],
            self.nearest_free[some],
            offsets - offsets[0],
            self.points[offsets[0] : offsets[-1]],
            self.certified[some],
            (bend_offsets[first : end + 1], *bends),
        )

    @property
    def __geo_interface__(self) -> dict[str, Any]:
        features = []
        for path in self:
            numbers = {"distance": path.distance, "lower": path.lower, "upper": path.upper}
            line = path.__geo_interface__ if path else None
            properties = {"status": path.status, **numbers}
            features.append({"type": "Feature", "properties": properties, "geometry": line})
        return {"type": "FeatureCollection", "features": features}

    def _path(self, i: int) -> Path:
        word = str(status(self._codes[i]))
        is_inside = word == "inside_obstacle"
        points = self.points[self.offsets[i] : self.offsets[i + 1]]
        has_free = is_inside and not np.isnan(self.nearest_free[i, 0])
        return Path(
            word,
            float(self.distance[i]),
            float(self.lower[i]),
            float(self.upper[i]),
            points,
            self._bends_of(i, points),
            bool(self.certified[i]),
            self.inside_point[i] if is_inside else None,
            self.nearest_free[i] if has_free else None,
        )

    def _bends_of(self, i: int, points: np.ndarray) -> list[Bend]:
        offsets, vertices, edges_to, turns_left, line_offsets, kinds, lines = self._bends
        bends = []
        for place, b in enumerate(range(int(offsets[i]), int(offsets[i + 1])), 1):
            along = slice(line_offsets[b], line_offsets[b + 1])
            named = zip((_KINDS[kind] for kind in kinds[along]), lines[along].tolist(), strict=True)
            tile, index = edges_to[b].tolist()
            turns = "left" if turns_left[b] else "right"
            edge_to = None if tile < 0 else (tile, index)
            bends.append(Bend(tuple(points[place].tolist()), turns, tuple(vertices[b].tolist()), edge_to, tuple(named)))
        return bends

    def __repr__(self) -> str:
        return f"<Paths: {len(self)}>"
