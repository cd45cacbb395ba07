"""The triangulation as a surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ._arguments import coordinates, finite, is_single, point, word
from ._base import Questions
from ._elements import Bounds, box
from ._geometry import wkb


def surface_arguments(
    holes: bool = False,
    max_edge: float | None = None,
    from_hull: bool = False,
    clip: Any = None,
    crs: str | None = None,
) -> dict[str, Any]:
    """Returns which triangles count, as the compiled part takes it; `crs` is that of the file."""
    if clip is not None:
        _check_crs(clip, crs)
    if max_edge is not None and not 0 < float(max_edge) < float("inf"):
        raise ValueError(f"max_edge must be a number above 0, not {max_edge!r}")
    if from_hull and max_edge is None:
        raise ValueError("from_hull needs max_edge")
    return {
        "holes": bool(holes),
        "max_edge": None if max_edge is None else float(max_edge),
        "from_hull": bool(from_hull),
        "clip": None if clip is None else wkb(clip, True, "clip"),
    }


def _check_crs(clip: Any, crs: str | None) -> None:
    """Checks that polygons have the coordinate reference system of the file, as far as both have a code."""
    given = getattr(clip, "crs", None)
    if crs is None or given is None or not hasattr(given, "to_epsg"):
        return
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    try:
        expected = CRS.from_user_input(crs).to_epsg()
    except CRSError:
        return
    code = given.to_epsg()
    if None not in (code, expected) and code != expected:
        raise ValueError(
            f"clip is in EPSG:{code}, and the file in EPSG:{expected}; convert it: clip.to_crs({expected})"
        )


@dataclass(frozen=True, slots=True)
class Raster:
    """A raster of a surface.

    Attributes
    ----------
    values : array of shape (rows, columns)
        The northern row first; NaN where there is no surface.
    bounds : (min_x, min_y, max_x, max_y)
        The outer corners of the grid.
    resolution : float
        The size of a cell.
    crs : str or None
        The coordinate reference system of the file.
    """

    values: np.ndarray
    bounds: Bounds
    resolution: float
    crs: str | None

    @property
    def transform(self) -> tuple[float, float, float, float, float, float]:
        """From column and row to x and y, as `affine.Affine` and rasterio take it."""
        return (self.resolution, 0.0, self.bounds[0], 0.0, -self.resolution, self.bounds[3])

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top), as matplotlib's `imshow` takes it."""
        min_x, min_y, max_x, max_y = self.bounds
        return (min_x, max_x, min_y, max_y)


@dataclass(frozen=True, slots=True)
class Contours:
    """Lines of equal height; higher ground is on their left.

    Attributes
    ----------
    z : array of shape (n,)
        The height of each line.
    closed : array of shape (n,)
        Whether it ends where it begins.
    points : array of shape (m, 2)
        The points of all lines.
    offsets : array of shape (n + 1,)
        Line i has the points from ``offsets[i]`` to ``offsets[i + 1]``.
    crs : str or None
        The coordinate reference system of the file.
    """

    z: np.ndarray
    closed: np.ndarray
    offsets: np.ndarray
    points: np.ndarray
    crs: str | None

    def __len__(self) -> int:
        return len(self.z)

    def __getitem__(self, number: int) -> np.ndarray:
        """The points of one line, shape (k, 2)."""
        count = len(self)
        if not -count <= number < count:
            raise IndexError(f"there are {count} contours")
        number %= count
        return self.points[self.offsets[number] : self.offsets[number + 1]]

    def to_geopandas(self) -> Any:
        """Returns a GeoDataFrame with the columns z and closed. Needs geopandas."""
        import geopandas
        import shapely

        lines = shapely.from_ragged_array(shapely.GeometryType.LINESTRING, self.points, (self.offsets,))
        return geopandas.GeoDataFrame({"z": self.z, "closed": self.closed}, geometry=lines, crs=self.crs)


@dataclass(frozen=True, slots=True)
class Profile:
    """The heights of a surface along a line.

    Attributes
    ----------
    length : float
        The length of the line.
    distance, z : arrays of shape (m,)
        The distance from the beginning, and the height, of the points where the line bends or crosses an edge.
    points : array of shape (m, 2)
        Their positions.
    offsets : array of shape (p + 1,)
        Part i of the line is on the surface, from point ``offsets[i]`` to before ``offsets[i + 1]``.
    """

    length: float
    offsets: np.ndarray
    distance: np.ndarray
    points: np.ndarray
    z: np.ndarray


@dataclass(frozen=True, slots=True)
class Volume:
    """Volumes between a surface and a horizontal plane, and areas as seen from above."""

    cut: float
    fill: float
    area: float
    area_above: float
    area_below: float


class Ground(Questions):
    """The triangulation as a surface: heights between the vertices, on the planes of the triangles.

    Triangles in holes do not count, unless `holes` is set; nor do those with an edge above `max_edge`, or with
    `from_hull` only those of them that are peeled off from the hull inwards. `clip` limits a result to polygons: a
    GeoSeries, shapely geometries, WKB, or arrays of positions.
    """

    __slots__ = ()

    crs: str | None

    def interpolate(
        self, xy: Any, *, holes: bool = False, max_edge: float | None = None, from_hull: bool = False
    ) -> Any:
        """Returns the heights of the surface at points.

        Returns
        -------
        float64 array of shape (n,), or a float for one point
            NaN where there is no surface.

        Raises
        ------
        QueryError
            The file has no z.

        Examples
        --------
        >>> t.interpolate([(1.5, 1.25), (30, 1)])
        array([ 4., nan])
        """
        points, surface = coordinates(xy), surface_arguments(holes, max_edge, from_hull)
        single = is_single(xy)
        self._needs_z()
        return self._ask(
            lambda awaited: self._reader.interpolate(points, surface, awaited),
            lambda found: float(found[0][0]) if single else found[0],
        )

    def raster(
        self,
        resolution: float,
        *,
        bounds: Bounds | None = None,
        align: tuple[float, float] | None = None,
        what: str = "z",
        z_factor: float = 1.0,
        azimuth: float = 315.0,
        altitude: float = 45.0,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
    ) -> Any:
        """Returns a raster of the surface: the value at the centre of each cell.

        Parameters
        ----------
        resolution : float
            The size of a cell, in units of the coordinates.
        bounds : (min_x, min_y, max_x, max_y), optional
            What to cover; the whole file without it.
        align : (x, y), optional
            Corners of cells are whole multiples of the resolution away from it.
        what : {"z", "slope", "aspect", "hillshade"}
            Heights; angles in degrees; or light from 1 to 255, from `azimuth` and `altitude`.
        z_factor : float
            Heights are multiplied by it first.

        Returns
        -------
        Raster

        Raises
        ------
        ValueError
            An argument is out of range.
        MemoryLimitError
            The raster would not fit in memory. `export` writes any size as GeoTIFF.

        Examples
        --------
        >>> t.raster(2).values.shape
        (10, 10)
        """
        surface = surface_arguments(holes, max_edge, from_hull, clip, self.crs)
        arguments = {
            "resolution": float(resolution),
            "bounds": box(bounds),
            "align": None if align is None else tuple(point(align, "align").tolist()),
            "what": word(what, "what"),
            "z_factor": finite(z_factor, "z_factor"),
            "azimuth": finite(azimuth, "azimuth"),
            "altitude": finite(altitude, "altitude"),
        }
        crs = self.crs
        return self._ask(
            lambda awaited: self._reader.raster(arguments, surface, awaited),
            lambda found: Raster(found[0], tuple(found[1].tolist()), float(resolution), crs),
        )

    def contours(
        self,
        step: float,
        *,
        base: float = 0.0,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
    ) -> Any:
        """Returns the contours at the heights ``base + i * step``, exact but for the rounding of their points.

        Returns
        -------
        Contours

        Raises
        ------
        QueryError
            The file has no z, or there would be too many levels.

        Examples
        --------
        >>> np.unique(t.contours(20).z).tolist()
        [20.0, 40.0]
        """
        surface = surface_arguments(holes, max_edge, from_hull, clip, self.crs)
        crs = self.crs
        return self._ask(
            lambda awaited: self._reader.contours(float(step), float(base), surface, awaited),
            lambda found: Contours(found[0], found[1], found[2], found[3], crs),
        )

    def profile(self, line: Any, *, holes: bool = False, max_edge: float | None = None, from_hull: bool = False) -> Any:
        """Returns the heights along a line of shape (n, 2).

        Returns
        -------
        Profile

        Examples
        --------
        >>> t.profile([(1, 1), (1, 5)]).z[[0, -1]]
        array([ 3., 11.])
        """
        corners, surface = coordinates(line, "line"), surface_arguments(holes, max_edge, from_hull)
        return self._ask(
            lambda awaited: self._reader.profile(corners, surface, awaited),
            lambda found: Profile(float(found[0][0]), *found[1:]),
        )

    def volume(
        self,
        level: float,
        *,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
    ) -> Any:
        """Returns the volumes between the surface and the plane at `level`.

        Returns
        -------
        Volume
            `cut` above the plane, `fill` below it, and the areas.

        Examples
        --------
        >>> round(t.volume(0, holes=True).area)
        400
        """
        surface = surface_arguments(holes, max_edge, from_hull, clip, self.crs)
        height = finite(level, "level")
        return self._ask(
            lambda awaited: self._reader.volume(height, surface, awaited), lambda found: Volume(*found)
        )

    def _needs_z(self) -> None:
        about = self._reader.metadata()
        if not about["has_z"]:
            from ._errors import QueryError

            raise QueryError(f"{self._reader.name} has no z; build it from points that have z")
