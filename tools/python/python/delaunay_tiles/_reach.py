"""The area within a walking distance, as an answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _core
from ._arguments import is_single
from ._columns import status
from ._places import places


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Reach:
    """The area within a walking distance of a point.

    Attributes
    ----------
    status : str
        ``"ok"``, ``"inside_obstacle"`` (the point is not free, and the area empty) or ``"out_of_budget"`` (a limit was
        reached, and the area is a part of the true one).
    area : float
        The size of the polygons, in squared units of the coordinates.
    nearest_free : array of shape (2,) or None
        The free point nearest to one that is inside an obstacle.
    """

    _code: int
    area: float
    nearest_free: np.ndarray | None
    _corners: np.ndarray
    _rings: np.ndarray
    _polygons: np.ndarray

    @classmethod
    def _of(cls, columns: tuple[Any, ...]) -> Reach:
        codes, _, _, free, size, corners, rings, polygons = columns
        return cls(codes[0], float(size[0]), None if np.isnan(free).any() else free[0], corners, rings, polygons)

    @property
    def status(self) -> str:
        return str(status(self._code))

    @property
    def polygons(self) -> list[list[np.ndarray]]:
        """The polygons, each as rings: the outer one first, counter-clockwise, then the holes, clockwise.

        A ring is an array of shape (m, 2). Its first point is not repeated at the end. The polygons are inside the true
        area: arcs are chords that leave the arc by at most 0.0001 of its radius.
        """
        rings = [self._corners[a:b] for a, b in zip(self._rings, self._rings[1:], strict=False)]
        return [rings[a:b] for a, b in zip(self._polygons, self._polygons[1:], strict=False)]

    def contains(self, xy: Any) -> Any:
        """Returns whether points are in the polygons or on their rings.

        Parameters
        ----------
        xy : array_like of shape (n, 2) or (2,)
            The points.

        Returns
        -------
        array of bool of shape (n,), or bool
            One for each point.

        Examples
        --------
        >>> t.reach((6, 10), 3).contains([(4.5, 10), (3.5, 10), (9, 10)])
        array([ True, False, False])
        """
        inside = _core.in_polygons(self._corners, self._rings, places(xy, "xy"))
        return bool(inside[0]) if is_single(xy) else inside

    def to_wkt(self) -> str:
        """Returns the polygons as well-known text: ``MULTIPOLYGON (((x y, …)))``."""
        if not len(self._corners):
            return "MULTIPOLYGON EMPTY"

        def ring(points: Any) -> str:
            return f"({', '.join(f'{x} {y}' for x, y in points)})"

        def polygon(rings: Any) -> str:
            return f"({', '.join(map(ring, rings))})"

        return f"MULTIPOLYGON ({', '.join(map(polygon, self.__geo_interface__['coordinates']))})"

    @property
    def __geo_interface__(self) -> dict[str, Any]:
        def closed(ring: np.ndarray) -> tuple[Any, ...]:
            return tuple(map(tuple, [*ring.tolist(), ring[0].tolist()]))

        return {
            "type": "MultiPolygon",
            "coordinates": tuple(tuple(map(closed, rings)) for rings in self.polygons),
        }

    def __repr__(self) -> str:
        return f"<Reach: {self.status}, {len(self.polygons)} polygons, area {self.area:g}>"
