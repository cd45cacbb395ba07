"""Questions by walking distance and by Euclidean distance."""

from __future__ import annotations

from datetime import timedelta
from typing import Any, Literal

import numpy as np

from . import _core
from ._answers import Along, Distances, Footing, Nearest, Neighbours, Reached
from ._arguments import is_single
from ._base import Questions
from ._paths import Path, Paths
from ._places import distance, distances, options, pairs, place, places, rank
from ._reach import Reach

_Time = float | timedelta | None


class Proximity(Questions):
    """Questions by walking distance and by Euclidean distance.

    Walls and the rings of obstacles block paths. Paths may run along them, and around the outside of the convex hull
    unless the file was built with ``exterior="hole"``. Break lines block nothing. Distances are in the unit of the
    coordinates.

    The annotated answers are those of `Tiles`; the methods of `AsyncTiles` return an awaitable of them. The questions
    of one call run in parallel.

    What several methods have in common:

    mode : str
        ``"exact"``: exact except for rounding. ``"within:0.05"``: the upper bound is at most 1.05 times the lower one.
        ``"fast"``: a short path along edges of the triangulation, shortened, with bounds.
    max_tiles : int, optional
        The most different tiles that one question may read. A question that needs more is ``"out_of_budget"``.
    max_time : float or timedelta, optional
        The longest time of one question, in seconds, with the same effect.

    All raise `TypeError` and `ValueError` for arguments of the wrong type, shape or value, `QueryError` for a point
    that is not finite and for a file without triangles, and `FileError` for a damaged tile. A point inside an obstacle
    and a limit are no errors: the `status` of an answer tells of them.
    """

    __slots__ = ()

    def knn(
        self,
        xy: Any,
        k: int,
        mode: str = "exact",
        *,
        paths: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Neighbours:
        """Finds the k nearest sites by walking distance.

        Parameters
        ----------
        xy : array_like of shape (n, 2) or (2,)
            The points. For one point, the arrays of the answer have no first axis.
        k : int
            How many sites, at least 1.
        mode, max_tiles, max_time
            See `Proximity`. In mode "fast" the sites are near, but perhaps not the nearest.
        paths : bool
            Whether to return the paths, too.

        Returns
        -------
        Neighbours
            Arrays with n rows and k columns, nearest first. A file without sites has no neighbours.

        Raises
        ------
        ValueError
            `k` is so much larger than the number of sites that the answer would only fill the memory.

        Examples
        --------
        >>> near = t.knn((3.5, 8), k=2)
        >>> near.id.tolist(), near.distance.round(2).tolist()
        (['shop 1', 'shop 0'], [4.03, 7.43])
        >>> t.knn([(3.5, 8), (10, 10)], k=1).status
        array(['ok', 'inside_obstacle'], dtype=object)
        """
        at = places(xy, "xy")
        k = rank(k, len(at), lambda: self._reader.metadata()["sites"])
        asked = options(mode, max_tiles, max_time, paths=paths)
        return self._ask(
            lambda awaited: _core.nearest_sites(self._reader, at, k, asked, awaited),
            lambda columns: Neighbours._of(columns, k, is_single(xy)),
        )

    def within(
        self,
        xy: Any,
        r: Any,
        mode: str = "exact",
        *,
        paths: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Reached:
        """Finds all sites within a walking distance.

        Parameters
        ----------
        xy : array_like of shape (n, 2) or (2,)
            The points. For one point, the arrays of the answer have no first axis.
        r : float or array_like of shape (n,)
            The distance, at least 0.
        mode, max_tiles, max_time
            See `Proximity`. The sites are exact in every mode.
        paths : bool
            Whether to return the paths, too.

        Returns
        -------
        Reached
            The sites of all points in flat arrays, nearest first for each point; ``reached[i]`` has those of point i.

        Examples
        --------
        >>> reached = t.within([(3.5, 8), (16, 3)], 6)
        >>> reached.site.tolist(), reached.offsets.tolist()
        ([1, 8, 10, 5], [0, 1, 4])
        >>> reached[1].id.tolist()
        ['shop 8', 'shop 10', 'shop 5']
        """
        at = places(xy, "xy")
        radii = distances(r, len(at))
        asked = options(mode, max_tiles, max_time, paths=paths)
        return self._ask(
            lambda awaited: _core.sites_within(self._reader, at, radii, asked, awaited),
            lambda columns: Reached._of(columns, is_single(xy)),
        )

    def path(
        self,
        a: Any,
        b: Any,
        mode: str = "exact",
        *,
        certified: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Path:
        """Finds a shortest path between two points.

        Parameters
        ----------
        a, b : array_like of shape (2,)
            The ends.
        mode, max_tiles, max_time
            See `Proximity`.
        certified : bool
            Whether to prove the path by a walk through the triangles that it passes, with exact predicates.

        Returns
        -------
        Path
            The path, which is true if it was found. Shapely and geopandas take it as a line.

        Examples
        --------
        >>> way = t.path((3, 8), (5, 8))
        >>> round(way.distance, 3), way.points.tolist()
        (6.325, [[3.0, 8.0], [4.0, 11.0], [5.0, 8.0]])
        >>> way.bends[0].turns, way.bends[0].lines
        ('right', (('wall', 1),))
        >>> t.path((3, 8), (9, 9)).nearest_free
        array([8., 9.])
        """
        start, end = place(a, "a").reshape(1, 2), place(b, "b").reshape(1, 2)
        asked = options(mode, max_tiles, max_time, certified=certified)
        return self._ask(
            lambda awaited: _core.paths(self._reader, start, end, asked, awaited),
            lambda columns: Paths._of(columns)[0],
        )

    def paths(
        self,
        a: Any,
        b: Any,
        mode: str = "exact",
        *,
        certified: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Paths:
        """Finds a shortest path for each of n pairs of points.

        Parameters
        ----------
        a, b : array_like of shape (n, 2)
            The starts and the ends. One point, of shape (2,), belongs to all pairs.
        mode, max_tiles, max_time
            See `Proximity`.
        certified : bool
            Whether to prove each path, as in `path`.

        Returns
        -------
        Paths
            The paths in flat arrays; ``paths[i]`` is a `Path`.

        Examples
        --------
        >>> ways = t.paths((3, 8), [(5, 8), (3, 9), (9, 9)])
        >>> ways.distance.round(3), ways.offsets
        (array([6.325, 1.   ,   nan]), array([0, 3, 5, 5]))
        >>> [way.status for way in ways]
        ['ok', 'ok', 'inside_obstacle']
        """
        starts, ends = pairs(a, b)
        asked = options(mode, max_tiles, max_time, certified=certified)
        return self._ask(lambda awaited: _core.paths(self._reader, starts, ends, asked, awaited), Paths._of)

    def matrix(
        self,
        a: Any,
        b: Any,
        mode: str = "exact",
        *,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Distances:
        """Finds the walking distances between all points of two lists.

        One search serves a whole row or column, so this is much quicker than `paths`. In modes other than "exact", each
        pair is a search.

        Parameters
        ----------
        a : array_like of shape (n, 2)
            The starts.
        b : array_like of shape (m, 2)
            The ends.
        mode, max_tiles, max_time
            See `Proximity`. The limits hold for each search.

        Returns
        -------
        Distances
            Arrays of shape (n, m).

        Raises
        ------
        MemoryError
            There is not enough memory for n × m cells.

        Examples
        --------
        >>> t.matrix([(3, 8), (1, 1)], [(5, 8), (3, 8), (9, 9)]).distance.round(2)
        array([[6.32, 0.  ,  nan],
               [9.25, 7.28,  nan]])
        """
        starts, ends = places(a, "a"), places(b, "b")
        asked = options(mode, max_tiles, max_time)
        return self._ask(
            lambda awaited: _core.matrix(self._reader, starts, ends, asked, awaited),
            lambda columns: Distances._of_pairs(columns, len(starts), len(ends), mode == "exact"),
        )

    def along(
        self, a: Any, b: Any, k: int = 1, *, max_tiles: int | None = None, max_time: _Time = None
    ) -> Along:
        """Finds the k nearest sites by walking distance from each point of a straight line.

        Parameters
        ----------
        a, b : array_like of shape (2,)
            The ends of the line, which may cross obstacles.
        k : int
            How many sites, at least 1.
        max_tiles, max_time
            See `Proximity`. The limits hold for the line as a whole.

        Returns
        -------
        Along
            The intervals on which the sites and their order stay the same, in order.

        Raises
        ------
        ValueError
            `k` is so much larger than the number of sites that the answer would only fill the memory.

        Examples
        --------
        >>> street = t.along((6, 10), (14, 10))
        >>> street.from_t, street.to_t, street.free
        (array([0.  , 0.25, 0.75]), array([0.25, 0.75, 1.  ]), array([ True, False,  True]))
        >>> street.id[:, 0].tolist()
        ['shop 1', None, 'shop 7']
        """
        start, end = place(a, "a"), place(b, "b")
        # A line has some thousand intervals at most, unless it is very long.
        k = rank(k, 1 << 10, lambda: self._reader.metadata()["sites"])
        asked = options("exact", max_tiles, max_time)
        line = [*start.tolist(), *end.tolist()]
        return self._ask(
            lambda awaited: _core.along(self._reader, line, k, asked, awaited),
            lambda columns: Along._of(columns, k),
        )

    def reach(self, p: Any, r: float, *, max_tiles: int | None = None, max_time: _Time = None) -> Reach:
        """Finds the area within a walking distance of a point.

        Parameters
        ----------
        p : array_like of shape (2,)
            The point.
        r : float
            The distance, at least 0 and finite.
        max_tiles, max_time
            See `Proximity`.

        Returns
        -------
        Reach
            Polygons inside the true area, and their size. Shapely and geopandas take it as a multipolygon.

        Examples
        --------
        >>> reach = t.reach((6, 10), 3)
        >>> round(reach.area, 2), len(reach.polygons)
        (23.13, 1)
        >>> reach.contains((5, 10))
        True
        """
        at, radius = place(p, "p").tolist(), distance(r)
        asked = options("exact", max_tiles, max_time)
        return self._ask(lambda awaited: _core.reach(self._reader, at, radius, asked, awaited), Reach._of)

    def nearest(
        self,
        xy: Any,
        k: int = 1,
        of: Literal["vertices", "sites"] = "vertices",
        *,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Nearest:
        """Finds the k nearest vertices or sites by Euclidean distance, regardless of obstacles.

        Parameters
        ----------
        xy : array_like of shape (n, 2) or (2,)
            The points. For one point, the arrays of the answer have no first axis.
        k : int
            How many, at least 1.
        of : str
            ``"vertices"`` or ``"sites"``.
        max_tiles, max_time
            See `Proximity`.

        Returns
        -------
        Nearest
            Arrays with n rows and k columns, nearest first.

        Raises
        ------
        ValueError
            `k` is so much larger than the number of vertices or sites that the answer would only fill the memory.

        Examples
        --------
        >>> t.nearest((3.2, 8.1)).xy
        array([[3., 8.]])
        >>> t.nearest([(3.2, 8.1), (10, 10)], k=2, of="sites").id
        array([['shop 1', 'shop 3'],
               ['shop 7', 'shop 5']], dtype=object)
        """
        if of not in ("vertices", "sites"):
            raise ValueError(f"of must be 'vertices' or 'sites', not {of!r}")
        at = places(xy, "xy")
        k = rank(k, len(at), lambda: self._reader.metadata()[of])
        asked = options("exact", max_tiles, max_time)
        return self._ask(
            lambda awaited: _core.nearest(self._reader, at, k, of == "sites", asked, awaited),
            lambda columns: Nearest._of(columns, k, is_single(xy)),
        )

    def footing(self, xy: Any, *, max_tiles: int | None = None, max_time: _Time = None) -> Footing:
        """Finds whether points are free or inside an obstacle, and the nearest free points.

        Parameters
        ----------
        xy : array_like of shape (n, 2) or (2,)
            The points. For one point, the arrays of the answer have no first axis.
        max_tiles, max_time
            See `Proximity`.

        Returns
        -------
        Footing
            Arrays with n rows.

        Examples
        --------
        >>> footing = t.footing([(3, 8), (9, 9)])
        >>> footing.free, footing.nearest_free
        (array([ True, False]), array([[3., 8.],
               [8., 9.]]))
        """
        at = places(xy, "xy")
        asked = options("exact", max_tiles, max_time)
        return self._ask(
            lambda awaited: _core.footing(self._reader, at, asked, awaited),
            lambda columns: Footing._of(columns, at, is_single(xy)),
        )

    def edge_distances(
        self, a: Any, b: Any, *, max_tiles: int | None = None, max_time: _Time = None
    ) -> Distances:
        """Finds the distances along edges of the triangulation (CDT distances) for n pairs of points.

        They are at least the walking distances, and less than 2.42 times them. Points that are no vertices are
        inserted for the question.

        Parameters
        ----------
        a, b : array_like of shape (n, 2)
            The starts and the ends. One point, of shape (2,), belongs to all pairs.
        max_tiles, max_time
            See `Proximity`.

        Returns
        -------
        Distances
            Arrays of shape (n,).

        Raises
        ------
        QueryError
            The file has break lines, with which the bound does not hold.

        Examples
        --------
        >>> plain = dt.open("plain.tiles")
        >>> plain.edge_distances((0, 0), [(3, 0), (3, 1)]).distance.round(3)
        array([3., 4.])
        """
        starts, ends = pairs(a, b)
        asked = options("exact", max_tiles, max_time)
        return self._ask(
            lambda awaited: _core.edge_distances(self._reader, starts, ends, asked, awaited),
            lambda columns: Distances(*columns),
        )
