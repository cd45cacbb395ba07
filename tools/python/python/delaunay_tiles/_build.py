"""Builds of tile files."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from . import _core, _points, _sites
from ._arguments import byte_count, coordinates, path_text, positive, word
from ._geometry import crs_of, wkb
from ._progress import Observer, observer


@dataclass(frozen=True, slots=True)
class BuildSummary:
    """What a build made: counts of the input and of the file."""

    points: int
    duplicates: int
    vertices: int
    triangles: int
    hull_edges: int
    added_vertices: int
    constraint_edges: int
    crossings: int
    sites: int
    sites_in_holes: int
    regions: int
    hole_regions: int
    hole_triangles: int
    draped: int
    draped_outside: int
    without_z: int
    ponds: int
    flattened: int
    tiles: int
    file_bytes: int
    blocks: int
    resumed_blocks: int
    peak_memory: int | None
    notes: tuple[str, ...]

    @classmethod
    def _of(cls, text: str, notes: list[str]) -> BuildSummary:
        found = json.loads(text)
        names = [field.name for field in fields(cls) if field.name != "notes"]
        return cls(**{name: found[name] for name in names}, notes=tuple(notes))


class Builder:
    """Builds a tile file from parts that are added one after another: lines and sites first, then points.

    Used as a context manager, it finishes the build at the end of the block, and discards it if the block raises an
    exception. Nothing appears under the output's name before the file is complete.

    Parameters
    ----------
    out : str or path
        The tile file to write.
    **options
        `crs`, `memory`, `threads`, `tile_vertices`, `duplicates`, `crossings`, `exterior`, `missing_z`, `compress`,
        `work_folder`, `overwrite` and `progress` of `build`.

    Examples
    --------
    >>> with dt.Builder("grid.tiles", overwrite=True) as builder:
    ...     builder.add_lines([[(0, 4), (9, 4)]])
    ...     for x in range(10):
    ...         builder.add_points([(x, y) for y in range(10)])
    >>> builder.summary.triangles
    162
    """

    def __init__(
        self,
        out: str | os.PathLike[str],
        *,
        crs: str | None = None,
        memory: int | str | None = None,
        threads: int | None = None,
        tile_vertices: int = 32768,
        duplicates: str = "first",
        crossings: str = "error",
        exterior: str = "keep",
        missing_z: str = "drape",
        compress: bool = False,
        work_folder: str | os.PathLike[str] | None = None,
        overwrite: bool = False,
        progress: bool | Observer | None = None,
        _resume: bool = False,
        _identity: str | None = None,
    ) -> None:
        self._observer = observer(progress)
        self._summary: BuildSummary | None = None
        self._identity = _identity
        arguments = {
            "memory": byte_count(memory, "memory"),
            "threads": None if threads is None else positive(threads, "threads"),
            "tile_vertices": positive(tile_vertices, "tile_vertices"),
            "duplicates": word(duplicates, "duplicates"),
            "crossings": word(crossings, "crossings"),
            "exterior": word(exterior, "exterior"),
            "missing_z": word(missing_z, "missing_z"),
            "compress": bool(compress),
            "work_folder": None if work_folder is None else path_text(work_folder, "work_folder"),
            "overwrite": bool(overwrite),
            "resume": _resume,
            "identity": _identity,
        }
        crs = crs_text(crs)
        self._core = _core.Builder(path_text(out, "out"), arguments, crs, self._observer)

    def add_points(self, points: Any, name: str = "points") -> None:
        """Adds points; see `build` for what they may be. `name` stands for them in the metadata.

        Raises
        ------
        ValueError
            An array has another shape, a coordinate is NaN, infinite or out of range, or values are masked or null.
        TypeError
            The numbers are not real.
        """
        _points.push(self._core, points, name=name)

    def add_lines(self, lines: Any, kind: str = "lines") -> None:
        """Adds lines: break lines, ``"walls"``, ``"obstacles"`` or ``"ponds"``; see `build`.

        They must come before points. Add ponds before all other lines.
        """
        if isinstance(lines, (str, bytes, os.PathLike)):
            self._core.add_line_file(kind, path_text(lines, kind))
            return
        if isinstance(lines, (list, tuple)) and any(isinstance(item, (str, os.PathLike)) for item in lines):
            for item in lines:
                self.add_lines(item, kind)
            return
        crs = crs_of(lines)
        if crs is not None:
            self._core.take_crs(kind, crs)
        self._core.add_wkb(kind, wkb(lines, kind in ("obstacles", "ponds"), kind))

    def add_sites(self, sites: Any, ids: Iterable[Any] | None = None, site_id: str | None = None) -> None:
        """Adds sites: an array (n, 2) or (n, 3), a GeoDataFrame of points, or files.

        Parameters
        ----------
        sites : array, table, GeoSeries, GeoDataFrame, path or list of paths
            Their positions. They must come before points. A table has columns x, y and perhaps z.
        ids : iterable, optional
            An id for each site; its number without it.
        site_id : str, optional
            The column or property that holds the ids, in a file, a table or a GeoDataFrame.
        """
        if isinstance(sites, (str, bytes, os.PathLike)):
            self._core.add_site_file(path_text(sites, "sites"), site_id)
            return
        if isinstance(sites, (list, tuple)) and any(isinstance(item, (str, os.PathLike)) for item in sites):
            for item in sites:
                self.add_sites(item, site_id=site_id)
            return
        xy, texts, crs = _sites.arrays(sites, ids, site_id)
        if crs is not None:
            self._core.take_crs("sites", crs)
        self._core.add_sites(xy, texts)

    def add_holes(self, xy: Any) -> None:
        """Adds hole points: what can be reached from one without passing a line becomes a hole."""
        self._core.add_holes(coordinates(xy, "holes"))

    def finish(self) -> BuildSummary:
        """Builds the file and gives it its name.

        Raises
        ------
        BuildError
            The input has no constrained Delaunay triangulation as asked for.
        MemoryLimitError, OSError
            The memory or the disk does not suffice.
        """
        try:
            self._summary = BuildSummary._of(*self._core.finish())
        finally:
            self.close()
        return self._summary

    def _plan(self) -> list[int]:
        """Leaves the blocks to tasks. Returns the number of points of each; none if the file is built already."""
        try:
            blocks, built = self._core.plan()
            if built is not None:
                self._summary = BuildSummary._of(*built)
        finally:
            self.close()
        return blocks

    def _plan_inputs(self, files: list[_points.PointFile]) -> list[int] | None:
        """Leaves reading files, all in the same way, to tasks. Returns the number of records of each; none if all fit
        into memory."""
        try:
            paths = [path_text(file.path, "points") for file in files]
            return self._core.plan_inputs(paths, files[0]._arguments())
        finally:
            self.close()

    @property
    def summary(self) -> BuildSummary | None:
        """The summary of the finished build, or None before."""
        return self._summary

    def close(self) -> None:
        """Discards a build that has not finished."""
        self._core.close()
        if self._observer is not None:
            self._observer.close()

    def __enter__(self) -> Builder:
        return self

    def __exit__(self, exception: object, *_: object) -> None:
        if exception is None and self._summary is None:
            self.finish()
        else:
            self.close()


def crs_text(crs: Any) -> str | None:
    """Returns a coordinate reference system as text: given as text, or as an object of pyproj."""
    if crs is None or isinstance(crs, str):
        return crs
    if hasattr(crs, "to_wkt"):

        class _Holder:
            pass

        holder = _Holder()
        holder.crs = crs  # type: ignore[attr-defined]
        return crs_of(holder)
    raise TypeError(f"crs must be text such as 'EPSG:25832', or a pyproj.CRS, not {type(crs).__name__}")


def _files(given: Any) -> list[Any]:
    """Returns the files of an argument of `build`, if it names any."""
    if given is None:
        return []
    return list(given) if isinstance(given, (list, tuple)) else [given]


def _is_files(given: Any) -> bool:
    """Returns whether an argument of `build` has nothing but files."""
    return all(isinstance(item, (str, bytes, os.PathLike)) for item in _files(given))


def build(
    points: Any,
    out: str | os.PathLike[str],
    *,
    lines: Any = None,
    walls: Any = None,
    obstacles: Any = None,
    ponds: Any = None,
    sites: Any = None,
    site_id: str | None = None,
    holes: Any = None,
    crs: str | None = None,
    memory: int | str | None = None,
    threads: int | None = None,
    tile_vertices: int = 32768,
    duplicates: str = "first",
    crossings: str = "error",
    exterior: str = "keep",
    missing_z: str = "drape",
    compress: bool = False,
    work_folder: str | os.PathLike[str] | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: bool | Observer | None = None,
) -> BuildSummary:
    """Builds a tile file from points, and optionally lines, polygons and sites.

    The file has *the* (constrained) Delaunay triangulation of the input, the same to the last triangle whatever the
    memory, the threads and the order.

    Parameters
    ----------
    points : array, path, PointFile, table, or an iterable of these
        An array of shape (n, 2) or (n, 3) of x, y and perhaps z, which is read in place; a file (see `PointFile`);
        points of laspy; a GeoSeries or GeoDataFrame of points; anything with ``__arrow_c_stream__`` that has columns
        x, y and perhaps z, or GeoArrow points; or None, if there are lines.
    out : str or path
        The tile file to write. It appears when it is complete.
    lines, walls, obstacles, ponds : optional
        Break lines, which paths may cross; walls, which block paths; polygons whose interiors are holes; polygons in
        which all vertices get the lowest z of the shore. Each is a file or a list of files (GeoJSON, FlatGeobuf,
        shapefile, GeoPackage, text), a GeoSeries, or a list of arrays (n, 2|3), shapely geometries, or WKB.
    sites : optional
        Points to search for: an array, a GeoDataFrame or files.
    site_id : str, optional
        The column or property that holds a site's id.
    holes : array of shape (n, 2), optional
        Points in regions that are to be holes.
    crs : str or pyproj.CRS, optional
        The coordinate reference system, which overrides those of the inputs.
    memory : int or str, optional
        The memory that the build may use, besides the input; a quarter of what is available without it.
    threads : int, optional
        Threads that compute, and that decode LAZ and text; one per processor without it.
    tile_vertices : int
        Most vertices of a tile.
    duplicates : {"first", "lowest", "highest", "error"}
        Which of several points at one position is kept.
    crossings : {"error", "split"}
        What to do with lines that cross.
    exterior : {"keep", "hole"}
        Whether what lies outside of all lines is a hole.
    missing_z : {"drape", "zero", "error"}
        Where vertices without z take it from: the triangulation of the points, or 0.
    compress : bool
        Compress the tiles.
    work_folder : str or path, optional
        The folder for spilled data; one beside the output without it.
    resume : bool
        Continue a build of the same files that was interrupted. Not possible with arrays and tables, and with more
        than one file of points.
    overwrite : bool
        Replace the output if it exists.
    progress : bool or callable, optional
        True shows a bar (of tqdm, if it is installed); a function is called with (phase, done, total).

    Returns
    -------
    BuildSummary

    Raises
    ------
    FileExistsError
        `out` exists, and `overwrite` is not set.
    BuildError
        Lines cross, two points coincide and `duplicates` is "error", or more disk is needed than is free.
    InputError, ValueError, TypeError
        An input cannot be read, or has a value that is no coordinate.
    MemoryLimitError, OSError
        The memory or the disk does not suffice.
    KeyboardInterrupt
        Ctrl-C ends a build within half a second. It leaves no half file; only the work of a build that can be
        resumed stays.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> summary = dt.build(rng.random((1000, 2)), "random.tiles", overwrite=True)
    >>> summary.vertices, summary.tiles
    (1000, 1)
    """
    builder = begun(
        points, out, lines=lines, walls=walls, obstacles=obstacles, ponds=ponds, sites=sites, site_id=site_id,
        holes=holes, crs=crs, memory=memory, threads=threads, tile_vertices=tile_vertices, duplicates=duplicates,
        crossings=crossings, exterior=exterior, missing_z=missing_z, compress=compress, work_folder=work_folder,
        resume=resume, overwrite=overwrite, progress=progress,
    )  # fmt: skip
    return builder.finish()


def begun(
    points: Any,
    out: str | os.PathLike[str],
    *,
    lines: Any = None,
    walls: Any = None,
    obstacles: Any = None,
    ponds: Any = None,
    sites: Any = None,
    site_id: str | None = None,
    holes: Any = None,
    resume: bool = False,
    unnamed: str | None = None,
    has_inputs: bool = False,
    **options: Any,
) -> Builder:
    """Returns a builder that has all of the input; see `build`. `unnamed` identifies inputs that are no files, or whose
    points tasks have distributed, if `has_inputs` is set."""
    if all(given is None for given in (points, lines, walls, obstacles, ponds, sites)):
        raise ValueError("points must be given, or lines, walls, obstacles, ponds or sites")
    identity = None
    if isinstance(points, (str, os.PathLike)):
        points = _points.PointFile(points)
    beside = (("ponds", ponds), ("lines", lines), ("walls", walls), ("obstacles", obstacles), ("sites", sites))
    from_file = isinstance(points, _points.PointFile) and not points.keep_edges
    if not has_inputs and from_file and holes is None and all(_is_files(given) for _, given in beside):
        files = [(kind, path_text(path, kind)) for kind, given in beside for path in _files(given)]
        identity = _core.identity(path_text(points.path, "points"), points._arguments(), files, site_id)
    if resume and identity is None:
        raise ValueError("only a build of one file of points, with lines and sites of files, can be resumed")
    builder = Builder(out, _resume=resume or has_inputs, _identity=identity or unnamed, **options)
    try:
        if builder._core.needs_points():
            for kind, given in beside:
                if kind != "sites" and given is not None:
                    builder.add_lines(given, kind)
            if sites is not None:
                builder.add_sites(sites, site_id=site_id)
            if holes is not None:
                builder.add_holes(holes)
            if builder._core.has_inputs():
                builder._core.take_inputs()
            elif points is not None:
                _points.push(builder._core, points, are_all=True)
    except BaseException:
        builder.close()
        raise
    return builder
