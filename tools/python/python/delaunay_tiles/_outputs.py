"""Exports, maps, and objects of other packages."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from ._arguments import path_text
from ._elements import Bounds, TileByTile
from ._surface import Ground, surface_arguments


class Map:
    """A map as a picture, which notebooks show."""

    def __init__(self, png: bytes) -> None:
        self.png = png

    def _repr_png_(self) -> bytes:
        return self.png

    def __repr__(self) -> str:
        return f"<Map: {len(self.png)} bytes of PNG>"


class Outputs(Ground):
    """Exports, maps, and objects of other packages."""

    __slots__ = ()

    _path: str
    crs: str | None

    def export(
        self,
        out: str | os.PathLike[str],
        *,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
        **options: Any,
    ) -> Any:
        """Writes the triangulation, its surface, contours or map tiles for other programs, as `tiletool export` does.

        Parameters
        ----------
        out : str or path
            `.ply`, `.node`, `.obj`, `.glb`, `.geojson`, `.fgb`, `.parquet`, `.tif`, `.asc` or
            `.pmtiles`. It appears when it is complete.
        **options
            The options of the tool, such as ``what="edges"``, ``resolution=1``, ``contours=5``, ``cog=True``,
            ``memory="1GiB"``.

        Returns
        -------
        dict
            The summary: files, bytes, counts.

        Examples
        --------
        >>> t.export("town.ply")["files"]
        ['town.ply']
        """
        surface = surface_arguments(holes, max_edge, from_hull, clip, self.crs)
        target = path_text(out, "out")
        if target == "-":
            raise ValueError("out must be a file, not standard output")
        if refused := options.keys() & {"help", "version", "output", "verbose"}:
            raise ValueError(f"{min(refused)} is no option of an export in Python")
        arguments = [self._path, f"--output={target}"]
        given = {"all": holes, "max_edge": max_edge, "from_hull": from_hull} | options
        for name, value in given.items():
            option = "--" + name.replace("_", "-")
            if value is True:
                arguments.append(option)
            elif value is not None and value is not False:
                arguments.append(f"{option}={_text(value)}")
        return self._ask(lambda awaited: self._reader.export(arguments, surface, awaited), json.loads)


def _text(value: Any) -> str:
    if isinstance(value, (tuple, list)):
        return ",".join(_text(item) for item in value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return repr(float(value)) if isinstance(value, (float, np.floating)) else str(value)


class Pictures(Outputs, TileByTile):
    """Maps and objects of other packages; they read tile by tile, and so are not for asyncio."""

    __slots__ = ()

    def plot(
        self, out: str | os.PathLike[str] | None = None, *, ax: Any = None, bounds: Bounds | None = None, **style: Any
    ) -> Any:
        """Draws a map.

        Parameters
        ----------
        out : str or path, optional
            An `.svg` or `.png` to write. Files of any size are drawn within the cache.
        ax : matplotlib axes, optional
            Draws the triangles in `bounds` on it instead; `style` goes to matplotlib's `LineCollection`.

        Returns
        -------
        Map, the axes, or None
            Without `out` and `ax`, a picture that notebooks show.

        Examples
        --------
        >>> t.plot()._repr_png_()[1:4]
        b'PNG'
        """
        if ax is not None:
            return self._plot_on(ax, bounds, style)
        if bounds is not None or style:
            raise ValueError("bounds and style are for ax, axes of matplotlib")
        if out is not None:
            self._ask(lambda awaited: self._reader.plot(path_text(out, "out"), awaited))
            return None
        # Only here, because its import takes a while.
        import tempfile

        with tempfile.TemporaryDirectory() as folder:
            picture = os.path.join(folder, "map.png")
            self._ask(lambda awaited: self._reader.plot(picture, awaited))
            with open(picture, "rb") as file:
                return Map(file.read())

    def _plot_on(self, ax: Any, bounds: Bounds | None, style: dict[str, Any]) -> Any:
        from matplotlib.collections import LineCollection

        drawn: dict[str, Any] = {"colors": "0.4", "linewidths": 0.4} | style
        for tile in self.tiles(bounds):
            rings = tile.corners[tile.triangles[:, [0, 1, 2, 0]]]
            ax.add_collection(LineCollection(rings, **drawn))
            fixed = tile.corners[
                np.stack([tile.triangles, np.roll(tile.triangles, -1, axis=1)], axis=-1)[tile.constraints]
            ]
            ax.add_collection(LineCollection(fixed, colors="C3", linewidths=1.0))
        ax.set_aspect("equal")
        ax.autoscale_view()
        if bounds is not None:
            ax.set_xlim(bounds[0], bounds[2])
            ax.set_ylim(bounds[1], bounds[3])
        return ax

    def _mesh(self, bounds: Bounds | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Returns distinct points with z if there is one, triangles, and whether they are holes."""
        corners, holes = [], []
        for tile in self.tiles(bounds):
            met = slice(None) if bounds is None else tile._meets(bounds)
            at = tile.corners if tile.z is None else np.column_stack([tile.corners, tile._corner_z])
            corners.append(at[tile.triangles[met]])
            holes.append(tile.holes[met])
        if not corners:
            return np.empty((0, 2)), np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=bool)
        rows = np.concatenate(corners)
        points, index = np.unique(rows.reshape(-1, rows.shape[-1]), axis=0, return_inverse=True)
        return points, index.reshape(-1, 3), np.concatenate(holes)

    def to_geopandas(self, bounds: Bounds | None = None, kind: str = "triangles") -> Any:
        """Returns triangles, vertices or edges as a GeoDataFrame. Needs geopandas and pyarrow.

        Examples
        --------
        >>> len(t.to_geopandas(kind="edges")) > 0
        True
        """
        import geopandas
        import pyarrow
        import shapely

        frame = pyarrow.table(self.arrow(kind, bounds)).to_pandas()
        has_z = self._reader.metadata()["has_z"]
        axes = "xyz" if has_z else "xy"

        def corner(number: str) -> np.ndarray:
            return np.column_stack([frame[f"{axis}{number}"] for axis in axes])

        if kind == "vertices":
            geometry = shapely.points(corner(""))
        elif kind == "edges":
            geometry = shapely.linestrings(np.stack([corner("0"), corner("1")], axis=1))
        else:
            geometry = shapely.polygons(np.stack([corner(str(i % 3)) for i in range(4)], axis=1))
        dropped = [column for column in frame.columns if column.rstrip("012") in axes]
        return geopandas.GeoDataFrame(frame.drop(columns=dropped), geometry=geometry, crs=self.crs)

    def to_meshio(self, bounds: Bounds | None = None) -> Any:
        """Returns the triangles as a `meshio.Mesh`, with `hole` as cell data. Needs meshio.

        Examples
        --------
        >>> len(t.to_meshio().cells[0].data) == t.metadata.triangles
        True
        """
        import meshio

        points, triangles, holes = self._mesh(bounds)
        return meshio.Mesh(points, [("triangle", triangles)], cell_data={"hole": [holes.astype(np.uint8)]})
