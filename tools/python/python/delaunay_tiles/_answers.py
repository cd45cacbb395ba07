"""Answers about sites, vertices and distances, as arrays.

An answer to a list of n points has arrays with n rows, and ``answer[i]`` is the answer for point i. An answer to one
point has arrays without that first axis.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from ._columns import ids, missing_distances, names, spread, status
from ._paths import Paths


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class _Ends:
    """How the questions of an answer ended."""

    _codes: Any
    bound: Any
    nearest_free: np.ndarray

    @property
    def status(self) -> Any:
        """How each question ended, in words: a text for one point, an array of texts for several."""
        return status(self._codes)

    @property
    def _is_single(self) -> bool:
        return np.ndim(self._codes) == 0

    def __len__(self) -> int:
        if self._is_single:
            raise TypeError("the answer for one point has no length; its arrays have")
        return len(self._codes)

    def _row(self, i: int) -> Self:
        """Returns the answer for one point."""
        raise NotImplementedError

    def __getitem__(self, index: int) -> Self:
        return self._row(range(len(self))[index])

    def __iter__(self) -> Iterator[Self]:
        return map(self._row, range(len(self)))

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.status if self._is_single else f'{len(self)} points'}>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Neighbours(_Ends):
    """The nearest sites by walking distance, from each of n points.

    Attributes
    ----------
    status : array of shape (n,)
        ``"ok"``, ``"inside_obstacle"`` (the point is not free) or ``"out_of_budget"`` (a limit was reached).
    site : int64 array of shape (n, k)
        The numbers of the sites, counted from 0 over all inputs, nearest first; -1 where there are fewer.
    id : array of shape (n, k)
        The ids of the sites as text; None for a site without an id, and where there are fewer.
    distance, lower, upper : array of shape (n, k)
        The walking distances, and bounds of the true ones. Where there are fewer sites, infinite; NaN if the point is
        inside an obstacle. At a limit, the lower bound holds for all sites that were not found, whose `distance` is
        NaN.
    xy : array of shape (n, k, 2)
        The points of the sites; NaN where there are fewer.
    bound : array of shape (n,)
        The lower bound of the distances of the sites that were not found, at a limit; otherwise NaN.
    nearest_free : array of shape (n, 2)
        The free point nearest to one that is inside an obstacle; otherwise NaN.
    paths : Paths or None
        The paths to the sites that were found, one point after the other, if they were requested.
    """

    site: np.ndarray
    distance: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    xy: np.ndarray
    paths: Paths | None
    _offsets: np.ndarray
    _names: tuple[np.ndarray, np.ndarray]

    @classmethod
    def _of(cls, columns: tuple[Any, ...], k: int, is_single: bool) -> Neighbours:
        found = Reached._of(columns, False)
        offsets = found.offsets
        value, lower, upper = missing_distances(found._codes, found.bound)
        answer = cls(
            found._codes,
            found.bound,
            found.nearest_free,
            spread(offsets, k, found.site, -1),
            spread(offsets, k, found.distance, value),
            spread(offsets, k, found.lower, lower),
            spread(offsets, k, found.upper, upper),
            spread(offsets, k, found.xy, np.nan),
            found.paths,
            offsets,
            found._names,
        )
        return answer[0] if is_single else answer

    @property
    def id(self) -> Any:
        return ids(self.site, self._names)

    def _row(self, i: int) -> Neighbours:
        first, end = self._offsets[i : i + 2].tolist()
        return Neighbours(
            self._codes[i],
            self.bound[i],
            self.nearest_free[i],
            self.site[i],
            self.distance[i],
            self.lower[i],
            self.upper[i],
            self.xy[i],
            None if self.paths is None else self.paths[first:end],
            np.array([0, end - first]),
            self._names,
        )


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Reached(_Ends):
    """The sites within a walking distance of each of n points, one point after the other.

    ``reached[i]`` has the sites of point i: those from ``offsets[i]`` to ``offsets[i + 1]``.

    Attributes
    ----------
    status : array of shape (n,)
        The words of `Neighbours.status`.
    offsets : int64 array of shape (n + 1,)
        Where the sites of each point begin.
    site : int64 array of shape (m,)
        The numbers of the sites, nearest first for each point.
    id : array of shape (m,)
        The ids of the sites as text; None for a site without an id.
    distance, lower, upper : array of shape (m,)
        The walking distances, and bounds of the true ones.
    xy : array of shape (m, 2)
        The points of the sites.
    bound : array of shape (n,)
        The lower bound of the distances of the sites that were not found, at a limit; otherwise NaN.
    nearest_free : array of shape (n, 2)
        The free point nearest to one that is inside an obstacle; otherwise NaN.
    paths : Paths or None
        The m paths, if they were requested.
    """

    offsets: np.ndarray
    site: np.ndarray
    distance: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    xy: np.ndarray
    paths: Paths | None
    _names: tuple[np.ndarray, np.ndarray]

    @classmethod
    def _of(cls, columns: tuple[Any, ...], is_single: bool) -> Reached:
        codes, bounds, _, free, offsets, site, value, lower, upper, xy, numbers, texts, *ways = columns
        paths = None
        if ways:
            nowhere = np.broadcast_to(np.nan, (len(site), 2))
            paths = Paths._of((np.zeros_like(site, np.uint8), None, nowhere, nowhere, value, lower, upper, *ways))
        table = names(numbers, texts)
        answer = cls(codes, bounds, free, offsets, site, value, lower, upper, xy, paths, table)
        return answer[0] if is_single else answer

    @property
    def id(self) -> Any:
        return ids(self.site, self._names)

    def _row(self, i: int) -> Reached:
        first, end = self.offsets[i : i + 2].tolist()
        return Reached(
            self._codes[i],
            self.bound[i],
            self.nearest_free[i],
            np.array([0, end - first]),
            self.site[first:end],
            self.distance[first:end],
            self.lower[first:end],
            self.upper[first:end],
            self.xy[first:end],
            None if self.paths is None else self.paths[first:end],
            self._names,
        )


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Nearest(_Ends):
    """The nearest vertices or sites by Euclidean distance, from each of n points.

    Attributes
    ----------
    status : array of shape (n,)
        ``"ok"``, or ``"out_of_budget"`` if a limit was reached.
    distance : array of shape (n, k)
        The Euclidean distances, nearest first. Where there are fewer, infinite; NaN if a limit was reached before.
    xy : array of shape (n, k, 2)
        The points; NaN where there are fewer.
    tile, index : int64 array of shape (n, k)
        The tile of each vertex, and its index in the tile; -1 where there are fewer.
    site : int64 array of shape (n, k)
        The numbers of the sites; -1 where there are fewer, and for vertices.
    id : array of shape (n, k)
        The ids of the sites as text, or None.
    bound : array of shape (n,)
        The lower bound of the distances of what was not found, at a limit; otherwise NaN.
    """

    distance: np.ndarray
    xy: np.ndarray
    tile: np.ndarray
    index: np.ndarray
    site: np.ndarray
    _names: tuple[np.ndarray, np.ndarray]

    @classmethod
    def _of(cls, columns: tuple[Any, ...], k: int, is_single: bool) -> Nearest:
        codes, bounds, _, free, offsets, distance, xy, vertices, site, numbers, texts = columns
        vertices = spread(offsets, k, vertices, -1)
        answer = cls(
            codes,
            bounds,
            free,
            spread(offsets, k, distance, missing_distances(codes, bounds)[0]),
            spread(offsets, k, xy, np.nan),
            vertices[..., 0],
            vertices[..., 1],
            spread(offsets, k, site, -1),
            names(numbers, texts),
        )
        return answer[0] if is_single else answer

    @property
    def id(self) -> Any:
        return ids(self.site, self._names)

    def _row(self, i: int) -> Nearest:
        return Nearest(
            self._codes[i],
            self.bound[i],
            self.nearest_free[i],
            self.distance[i],
            self.xy[i],
            self.tile[i],
            self.index[i],
            self.site[i],
            self._names,
        )


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Footing(_Ends):
    """Whether each of n points is free.

    Attributes
    ----------
    free : array of bool of shape (n,)
        Whether the point is free; at a limit, False.
    nearest_free : array of shape (n, 2)
        The nearest free point, rounded: the point itself if it is free, NaN if no point is.
    status : array of shape (n,)
        ``"ok"`` (free), ``"inside_obstacle"``, or ``"out_of_budget"`` if a limit was reached.
    """

    free: Any

    @classmethod
    def _of(cls, columns: tuple[Any, ...], xy: np.ndarray, is_single: bool) -> Footing:
        codes, bounds, _, nearest = columns
        free = codes == 0
        answer = cls(codes, bounds, np.where(free[:, None], xy, nearest), free)
        return answer[0] if is_single else answer

    def _row(self, i: int) -> Footing:
        return Footing(self._codes[i], self.bound[i], self.nearest_free[i], self.free[i])


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Distances:
    """Distances without paths: (n, m) of all pairs of two lists, or (n,) of n pairs.

    Attributes
    ----------
    distance, lower, upper : array
        The distances, and bounds of the true ones: infinite if no path connects the points, and NaN if one of them is
        inside an obstacle. At a limit, `distance` is NaN, and the bounds hold.
    status : array
        ``"ok"``, ``"unreachable"``, ``"inside_obstacle"`` or ``"out_of_budget"``.
    """

    _codes: np.ndarray
    distance: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    @classmethod
    def _of_pairs(cls, columns: tuple[Any, ...], rows: int, width: int, is_exact: bool) -> Distances:
        if is_exact and width < rows:
            # The cells come in the order of the shorter list.
            return cls(*(column.reshape(width, rows).T for column in columns))
        return cls(*(column.reshape(rows, width) for column in columns))

    @property
    def status(self) -> Any:
        return status(self._codes)

    def __repr__(self) -> str:
        return f"<Distances: shape {np.shape(self.distance)}>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Along:
    """The nearest sites along a line, in m intervals on which they and their order stay the same.

    Attributes
    ----------
    status : str
        ``"ok"``, or ``"out_of_budget"`` if a limit was reached: then the intervals end early.
    from_t, to_t : array of shape (m,)
        Where each interval starts and ends, from 0 (the start of the line) to 1 (its end).
    start, end : array of shape (m, 2)
        The points there, rounded.
    free : array of bool of shape (m,)
        Whether the interval is outside all obstacles.
    site : int64 array of shape (m, k)
        The numbers of the sites, nearest first; -1 where fewer can be reached, and in obstacles.
    id : array of shape (m, k)
        The ids of the sites as text; None for a site without an id, and where there is none.
    xy : array of shape (m, k, 2)
        The points of the sites; NaN where there is none.
    from_distance, to_distance : array of shape (m, k)
        The walking distances from the start and from the end of the interval; infinite where fewer sites can be
        reached, and NaN in obstacles.
    """

    status: str
    from_t: np.ndarray
    to_t: np.ndarray
    start: np.ndarray
    end: np.ndarray
    free: np.ndarray
    site: np.ndarray
    xy: np.ndarray
    from_distance: np.ndarray
    to_distance: np.ndarray
    _names: tuple[np.ndarray, np.ndarray]

    @classmethod
    def _of(cls, columns: tuple[Any, ...], k: int) -> Along:
        codes, _, _, _, positions, corners, free, offsets, site, xy, distances, numbers, texts = columns
        distances = spread(offsets, k, distances, np.where(free, np.inf, np.nan))
        return cls(
            str(status(codes[0])),
            positions[:, 0],
            positions[:, 1],
            corners[:, :2],
            corners[:, 2:],
            free,
            spread(offsets, k, site, -1),
            spread(offsets, k, xy, np.nan),
            distances[..., 0],
            distances[..., 1],
            names(numbers, texts),
        )

    @property
    def id(self) -> Any:
        return ids(self.site, self._names)

    def __len__(self) -> int:
        return len(self.from_t)

    def __repr__(self) -> str:
        return f"<Along: {self.status}, {len(self)} intervals>"
